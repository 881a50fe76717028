"""Compiled kernels that a wheel contains, searched before those in the user's cache.

They are compiled for all processors of one level (`CPU` and `FEATURES`) in place of the processor that builds the
wheel, and have the format and the stamp of the cache. See `docs/decisions/0020-wheels-with-kernels.md`.
"""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

from numba.core import config

CPU = "x86-64-v3"
FEATURES = (
    "+64bit,+avx,+avx2,+bmi,+bmi2,+cmov,+crc32,+cx16,+cx8,+f16c,+fma,+fxsr,+lzcnt,+mmx,+movbe,+popcnt,+sahf,+sse,+sse2,"
    "+sse3,+sse4.1,+sse4.2,+ssse3,+xsave"
)
"""All that the level has, by LLVM's names; as a setting, it keeps out what else the building processor has."""
HOME = Path(__file__).parent / "compiled"
"""Folders by stamp. Only wheels have one: it is as trustworthy as the sources beside it."""
log = logging.getLogger(__name__)

_has_told = False


def carried(stamp: str, host: tuple[Any, ...]) -> tuple[Path, tuple[Any, ...]] | None:
    """Return the folder of the kernels in the wheel for *stamp*, and their processor: (triple, name, features).

    None if there are none, if the *host* lacks a feature of that level, or if the user has named a processor.
    """
    if not _has_any(stamp) or missing(host):
        return None
    return HOME / stamp, (host[0], CPU, FEATURES)


def _has_any(stamp: str) -> bool:
    return config.CPU_NAME is None and config.CPU_FEATURES is None and (HOME / stamp).is_dir()


def missing(host: tuple[Any, ...]) -> list[str]:
    """Return the processor features that the wheel's kernels need and the *host* lacks."""
    level, own = ({each[1:] for each in listed.split(",") if each[:1] == "+"} for listed in (FEATURES, host[2]))
    return sorted(level - own)


def tell_unused(stamp: str, host: tuple[Any, ...]) -> None:
    """Log, once, that the wheel's kernels are not used and kernels are compiled, since the *host* lacks a feature."""
    global _has_told
    lacking = missing(host)
    if lacking and not _has_told and _has_any(stamp):
        _has_told = True
        words = "the kernels that come with this package are for processors with %s: they are compiled for this one"
        log.warning(words, ", ".join(lacking))
