"""An exhaustive search for equilibria that can be interrupted at any time and resumed from a file."""

from __future__ import annotations

import hashlib
import zipfile
from importlib.metadata import version
from pathlib import Path

import numpy as np

from cablewright.errors import InputError
from cablewright.file_output import whole_file
from cablewright.kernels.layout import Packed
from cablewright.progress import Progress
from cablewright.solvers.equilibria import Equilibria
from cablewright.solvers.exhaustive import ExhaustiveSearch, begin, exhaust

FIELDS = ("box", "open", "undecided", "reasons", "poses", "level", "judged")
MAX_BYTES = 1 << 30


def search_all(
    found: Equilibria,
    box: list[float] | None,
    file: Path,
    *,
    time_limit: float,
    progress: Progress | None = None,
) -> Equilibria:
    """Search for equilibria that *found* lacks; resume the search in *file* if it has the same inputs.

    Returns the equilibria, which know whether the search is finished. *file* has the state of the search, also after an
    interruption.
    *box*, *time_limit* (s): see `exhaust`. Raises `InputError` where *file* is something else,
    `EnvironmentFault` where it cannot be written.
    """
    initial = begin(found.solutions.model, None if box is None else np.array(box))
    question = _question(found, initial)
    search = _read(file, question) or initial
    every, _ = exhaust(
        found, search, time_limit=time_limit, save=lambda now: _write(file, question, now), progress=progress
    )
    return every


def _question(found: Equilibria, initial: ExhaustiveSearch) -> str:
    """Hash of the inputs: the machine's packed parameters, its lengths, the box and the version."""
    packed: Packed = found.solutions.model.packed
    digest = hashlib.sha256(version("cablewright").encode())
    for part in (packed.lines, packed.platform, found.solutions.lengths[0], initial.box):
        digest.update(np.ascontiguousarray(part).tobytes())
    return digest.hexdigest()


def _read(file: Path, question: str) -> ExhaustiveSearch | None:
    """Return the search in *file*; None if there is no such file or its inputs were others."""
    if not file.exists():
        return None
    if file.stat().st_size > MAX_BYTES:
        raise InputError(f"{file}: more than {MAX_BYTES} bytes; no search has as many")
    try:
        with file.open("rb") as stream, np.load(stream, allow_pickle=False) as stored:
            if str(stored["question"]) != question:
                return None
            values = {name: stored[name] for name in FIELDS}
    except (OSError, ValueError, KeyError, zipfile.BadZipFile) as reason:
        raise InputError(
            f"{file}: not a search of this program ({reason}); remove it or choose another --out"
        ) from None
    return ExhaustiveSearch(**values | {name: int(values[name]) for name in ("level", "judged")})


def _write(file: Path, question: str, search: ExhaustiveSearch) -> None:
    with whole_file(file, parents=True) as stream:
        np.savez(stream, question=np.array(question), **{name: getattr(search, name) for name in FIELDS})
