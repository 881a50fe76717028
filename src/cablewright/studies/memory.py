"""How much memory is free, so that work that needs more is refused before it begins."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from cablewright.errors import EnvironmentFault

_GROUP = Path("/sys/fs/cgroup")


def require_memory(needed: float, what: str, advice: str) -> None:
    """Raise `EnvironmentFault` where *what* needs more memory (bytes) than is free, as far as the system says."""
    free = free_memory()
    if free is not None and needed > free:
        sizes = f"about {needed / 1e9:.1f} GB, and {free / 1e9:.1f} GB are free"
        raise EnvironmentFault(f"not enough memory: {what} takes {sizes}; {advice}")


def free_memory() -> float | None:
    """Return the free memory, bytes, of the system or of the control group if that is less; None if not known."""
    known = []
    with suppress(OSError, ValueError, StopIteration):  # Linux alone has it
        lines = Path("/proc/meminfo").read_text("ascii").splitlines()
        known.append(1024.0 * float(next(line for line in lines if line.startswith("MemAvailable:")).split()[1]))
    with suppress(OSError, ValueError):  # "max" is no number: the group has no limit
        most, used = (float((_GROUP / name).read_text("ascii")) for name in ("memory.max", "memory.current"))
        known.append(most - used)
    return min(known, default=None)
