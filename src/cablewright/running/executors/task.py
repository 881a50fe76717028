"""Work of executors: a function of this package on many items, by programs of the same version."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import Any, Final

import numpy as np
from pydantic import ValidationError
from pydantic_core import to_jsonable_python

from cablewright.foundation.errors import CablewrightError, EnvironmentFault, InputError, one_line
from cablewright.solvers.row_threads import use_threads

PROGRAMS: Final = ("cablewright", "numba", "numpy", "scipy")
"""Distributions on whose version results may depend."""

_NUMERIC: Final = (CablewrightError, ValidationError, ArithmeticError, np.linalg.LinAlgError, MemoryError)
"""What an item may raise that is no error of the program: the others are computed nevertheless."""


def digest(value: Any) -> str:
    """Return the SHA-256 hash of a value made of frozen descriptions, dataclasses, numbers and texts."""
    plain = to_jsonable_python(value, inf_nan_mode="constants")
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()


@dataclass(frozen=True)
class Task:
    """One function of a module of this package, and the common arguments of its calls.

    ``function(shared, item)`` returns a value that JSON can hold. ``shared`` and the items are frozen values that can
    be pickled and hashed by `digest`; ``noun`` is what one item is called.
    """

    function: Callable[[Any, Any], Any]
    shared: Any
    noun: str

    def key(self) -> str:
        """Return the hash of the function, of ``shared`` and of the programs' versions, as they are here."""
        name = f"{self.function.__module__}:{self.function.__qualname__}"
        return digest([name, self.shared, list(programs().values())])


@dataclass(frozen=True)
class Outcome:
    """Outcome of one item: the result as JSON text, or the reason why there is none.

    ``refused``: whether that is an `InputError`.
    """

    text: str = ""
    fault: str = ""
    refused: bool = False

    @property
    def value(self) -> Any:
        """The result of the task. Raises `ValueError` where there is none."""
        return json.loads(self.text)


@dataclass(frozen=True)
class Chunk:
    """Items that one worker computes in a row; ``numbers``: their indices among all items."""

    task: Task
    key: str  # of the task as the client knows it
    programs: dict[str, str]  # of the client
    items: tuple[Any, ...]
    numbers: tuple[int, ...]

    def failed(self, why: str) -> Computed:
        """Return the chunk of work with one fault for all of its items."""
        return Computed(self.numbers, tuple(Outcome(fault=why) for _ in self.items), 0.0)

    def parts(self) -> tuple[Chunk, ...]:
        """Return the items of the chunk one by one, to find the one that no worker survives."""
        return tuple(
            replace(self, items=(item,), numbers=(number,))
            for item, number in zip(self.items, self.numbers, strict=True)
        )


@dataclass(frozen=True)
class Computed:
    """Outcomes of a chunk, and how long it took, s."""

    numbers: tuple[int, ...]
    outcomes: tuple[Outcome, ...]
    seconds: float


@cache
def programs() -> dict[str, str]:
    """Return the versions of the programs on which results depend, and a hash of this package's sources."""
    return {name: version(name) for name in PROGRAMS} | {"sources": _sources()}


def _sources() -> str:
    home = Path(str(files("cablewright")))
    found = hashlib.sha256()
    for file in sorted(home.rglob("*.py")):
        found.update(file.relative_to(home).as_posix().encode() + b"\0" + hashlib.sha256(file.read_bytes()).digest())
    return found.hexdigest()[:16]


def unlike(here: dict[str, str], there: dict[str, str]) -> str:
    """Return how a worker's program versions differ from those of this process; empty if they are equal."""
    for name, own in here.items():
        if there.get(name) != own:
            what = "other sources of cablewright" if name == "sources" else f"{name} {there.get(name)}"
            return f"has {what}; here it is {own}"
    return ""


def run_chunk(chunk: Chunk, threads: int | None = 1) -> Computed:
    """Compute the items of a *chunk* on *threads* threads; None: as many as the program may use.

    Raises `EnvironmentFault` where this program is not the client's: its results would differ.
    """
    difference = unlike(chunk.programs, programs())
    if not difference and chunk.task.key() != chunk.key:
        difference = "reads the inputs (robot, job, settings) as other values"
    if difference:
        raise EnvironmentFault(f"a worker {difference}")
    begin = time.monotonic()
    with use_threads(threads):
        outcomes = tuple(_computed(chunk.task, item) for item in chunk.items)
    return Computed(chunk.numbers, outcomes, time.monotonic() - begin)


def _computed(task: Task, item: Any) -> Outcome:
    try:
        return Outcome(json.dumps(task.function(task.shared, item)))
    except _NUMERIC as reason:
        words = str(reason) if isinstance(reason, CablewrightError) else f"{type(reason).__name__}: {reason}"
        return Outcome(fault=one_line(words), refused=isinstance(reason, InputError))


def faults(outcomes: Iterable[Outcome]) -> list[str]:
    """Return the reasons why items have no result, as a sentence."""
    return [each.fault for each in outcomes if each.fault]
