"""An exhaustive search for equilibria that can be interrupted at any time and resumed from a file.

A finished search is a proof, and its file states what is proved already. So the file is signed with the user's key,
over its content and all inputs of the proof; a file of another user is rejected.
"""

from __future__ import annotations

import hashlib
import json
import logging
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

import numpy as np

from cablewright.foundation.errors import InputError
from cablewright.foundation.progress import Progress
from cablewright.foundation.saved_state import Snapshot, read_snapshots, write_snapshots
from cablewright.kernels.cache import STAMP
from cablewright.kernels.layout import Packed
from cablewright.running.signing_key import is_signed, signature
from cablewright.solvers.equilibria import Equilibria
from cablewright.solvers.exhaustive import ExhaustiveSearch, begin, exhaust

log = logging.getLogger(__name__)

_PART: Final = "search"
_ARRAYS: Final = ("box", "open", "undecided", "reasons", "poses")
_COUNTS: Final = ("level", "judged")


def search_all(
    found: Equilibria,
    box: list[float] | None,
    file: Path,
    *,
    time_limit: float,
    progress: Progress | None = None,
) -> Equilibria:
    """Search exhaustively for equilibria that *found* lacks; resume the search in *file* if it has the same inputs.

    Returns the equilibria, which know whether the search is finished. *file* has the state of the search, also after an
    interruption. *box*, *time_limit* (s): see `exhaust`. Raises `InputError` where *file* is something else,
    `EnvironmentFault` where it cannot be written.
    """
    signature(b"")  # a key that cannot be had is said before the work
    initial = begin(found.solutions.model, None if box is None else np.array(box))
    question = _question(found, initial)
    search = _read(file, question) or initial
    every, _ = exhaust(
        found, search, time_limit=time_limit, save=lambda now: _write(file, question, now), progress=progress
    )
    return every


def _question(found: Equilibria, initial: ExhaustiveSearch) -> str:
    """Hash of the inputs: the machine's packed parameters, its lengths, the box, the version and the kernels."""
    packed: Packed = found.solutions.model.packed
    digest = hashlib.sha256(f"{version('cablewright')} {STAMP}".encode())
    for part in (packed.lines, packed.platform, found.solutions.lengths[0], initial.box):
        digest.update(np.ascontiguousarray(part).tobytes())
    return digest.hexdigest()


def _read(file: Path, question: str) -> ExhaustiveSearch | None:
    """Return the search in *file*; None where there is none, and, with a warning, if its inputs or kernels differ."""
    if not file.exists():
        return None
    found = read_snapshots(file).get(_PART)
    if found is None or {"question", "signature", *_COUNTS} - found.values.keys() or {*_ARRAYS} - found.arrays.keys():
        raise InputError(f"{file}: this file is no saved state of a search; remove it or choose another --out")
    if found.values["question"] != question:
        log.warning("%s: a search of other inputs or by other kernels; it starts again", file)
        return None
    given = str(found.values["signature"])
    if not is_signed(_content(found), bytes.fromhex(given) if _is_hex(given) else b""):
        why = "not signed by this user, so that no proof is taken from it"
        raise InputError(f"{file}: {why}; remove it or choose another --out")
    values: dict[str, Any] = {name: found.values[name] for name in _COUNTS}
    return ExhaustiveSearch(**values | {name: found.arrays[name].copy() for name in _ARRAYS})


def _write(file: Path, question: str, search: ExhaustiveSearch) -> None:
    values = {"question": question} | {name: getattr(search, name) for name in _COUNTS}
    state = Snapshot(values, {name: getattr(search, name) for name in _ARRAYS})
    state.values["signature"] = signature(_content(state)).hex()
    write_snapshots(file, {_PART: state}, parents=True)


def _content(state: Snapshot) -> bytes:
    """All of a state but its signature, as bytes that differ where it differs."""
    shapes = {name: [state.arrays[name].dtype.str, *state.arrays[name].shape] for name in _ARRAYS}
    head = {"shapes": shapes} | {name: state.values[name] for name in ("question", *_COUNTS)}
    data = (np.ascontiguousarray(state.arrays[name]).tobytes() for name in _ARRAYS)
    return b"".join([json.dumps(head, sort_keys=True).encode(), b"\n", *data])


def _is_hex(text: str) -> bool:
    return len(text) % 2 == 0 and all(each in "0123456789abcdef" for each in text)
