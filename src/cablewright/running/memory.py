"""Free memory of the system, so that work that needs more is rejected before it begins."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from cablewright.foundation.errors import EnvironmentFault

_GROUP = Path("/sys/fs/cgroup")


def require_memory(needed: float, what: str, advice: str) -> None:
    """Raise `EnvironmentFault` where *what* needs more memory (bytes) than is free, as far as the system reports it."""
    free = free_memory()
    if free is not None and needed > free:
        sizes = f"about {needed / 1e9:.1f} GB, and {free / 1e9:.1f} GB are free"
        raise EnvironmentFault(f"not enough memory: {what} takes {sizes}; {advice}")


def require_for_samples(samples: int, each: float, what: str) -> None:
    """Require memory for a study of a job's *samples*, *each* of so many bytes; see `require_memory`."""
    require_memory(samples * each, f"{what} of {samples} samples", "a longer step in [sampling] takes less")


def free_memory() -> float | None:
    """Return the free memory, bytes, of a Linux system or, if that is less, of its control group; None if not known.

    Groups of version 2, that of this process. The cache of files can be freed immediately, and counts as free.
    """
    known = []
    with suppress(OSError, ValueError, StopIteration):
        known.append(1024.0 * _entry(Path("/proc/meminfo"), "MemAvailable:"))
    with suppress(OSError, ValueError, StopIteration):  # "max" is no number: the group has no limit
        lines = Path("/proc/self/cgroup").read_text("ascii").splitlines()
        own = next(line for line in lines if line.startswith("0::/")).removeprefix("0::/")
        most, used = (float((_GROUP / own / name).read_text("ascii")) for name in ("memory.max", "memory.current"))
        known.append(most - used + _entry(_GROUP / own / "memory.stat", "inactive_file"))
    return min(known, default=None)


def _entry(file: Path, key: str) -> float:
    """The number after *key* in a file of the system. Raises `StopIteration` where there is none."""
    return float(next(line for line in file.read_text("ascii").splitlines() if line.startswith(f"{key} ")).split()[1])
