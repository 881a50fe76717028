"""Compiled kernels that a wheel carries: for all processors of one level, looked for before those of the user.

They are entries of the cache like others, in a folder of their stamp, compiled for `CPU` and `FEATURES` in place of the
processor that builds the wheel. `docs/decisions/0020-wheels-with-kernels.md` says more.
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
    """Return the folder of the packaged kernels for *stamp*, and their processor: (triple, name, features).

    None if there are none, if the *host* lacks something of that level, or if the user has named a processor.
    """
    if not _has_any(stamp) or missing(host):
        return None
    return HOME / stamp, (host[0], CPU, FEATURES)


def _has_any(stamp: str) -> bool:
    return config.CPU_NAME is None and config.CPU_FEATURES is None and (HOME / stamp).is_dir()


def missing(host: tuple[Any, ...]) -> list[str]:
    """Return the processor features of the level that the *host* lacks."""
    level, own = ({each[1:] for each in listed.split(",") if each[:1] == "+"} for listed in (FEATURES, host[2]))
    return sorted(level - own)


def tell_unused(stamp: str, host: tuple[Any, ...]) -> None:
    """Say, once, that kernels are compiled in spite of those that are carried, where the *host* lacks something."""
    global _has_told
    lacking = missing(host)
    if lacking and not _has_told and _has_any(stamp):
        _has_told = True
        words = "the kernels that come with this package are for processors with %s: they are compiled for this one"
        log.warning(words, ", ".join(lacking))
