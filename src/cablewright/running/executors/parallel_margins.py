"""Workspace margins computed by an executor: blocks of positions are items, with results on disk."""

from __future__ import annotations

import base64
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np

from cablewright.analyses.workspace.criterion import Criterion, RetractionLaw
from cablewright.analyses.workspace.refinement import SearchBox
from cablewright.foundation.arrays import Array
from cablewright.foundation.progress import Progress, silent
from cablewright.models.statics import Model
from cablewright.running.executors.executor import Executor
from cablewright.running.executors.stored_results import KeptResults
from cablewright.running.executors.study import shared_blocks

_PLACES: Final = 4096  # of a block, at most

_Numbers = tuple[float, ...]


class _Question(NamedTuple):
    """A `Criterion` in numbers and texts."""

    model: Model
    name: str
    box: tuple[_Numbers, _Numbers]
    point: str
    orientations: tuple[_Numbers, ...]
    retraction: float | RetractionLaw | None
    wrench_box: tuple[_Numbers, _Numbers] | None
    arm: float

    @classmethod
    def of(cls, asked: Criterion) -> _Question:
        """Return the data of a criterion that workers need."""
        box, wrenches = (_numbers(asked.box.low), _numbers(asked.box.high)), asked.wrench_box
        return cls(
            asked.model,
            asked.name,
            box,
            asked.point,
            tuple(map(_numbers, asked.orientations)),
            asked.retraction,
            None if wrenches is None else (_numbers(wrenches[0]), _numbers(wrenches[1])),
            asked.arm,
        )

    @property
    def criterion(self) -> Criterion:
        """Return the criterion from these data."""
        low, high = map(np.array, self.box)
        wrenches = None if self.wrench_box is None else (np.array(self.wrench_box[0]), np.array(self.wrench_box[1]))
        turns = np.array(self.orientations).reshape(-1, 3)
        box = SearchBox(low, high)
        return Criterion(self.model, self.name, box, self.point, turns, self.retraction, wrenches, self.arm)


@dataclass(frozen=True, eq=False)
class SharedMargin:
    """Margins of a `Criterion`, computed by an *executor*; *kept*: results of earlier calls."""

    executor: Executor
    kept: KeptResults = field(default_factory=KeptResults)

    def __call__(self, criterion: Criterion, places: Array, progress: Progress | None, stage: str) -> Array:
        """Return the margins (N,) at *places* (N, 3), m, equal to the criterion's own to the bit.

        Raises `AnswerError` for a block that fails, `EnvironmentFault` where no worker is available.
        """
        count, report = len(places), progress or silent

        def show(_stage: str, done: int, total: int) -> None:
            report(stage, count if done == total else done * _PLACES, count)

        blocks = {first: _text(places[first : first + _PLACES]) for first in range(0, count, _PLACES)}
        found = shared_blocks(margins_of, _Question.of(criterion), blocks, self.executor, self.kept, show)
        return np.concatenate([np.zeros(0), *map(_array, found)])


def margins_of(question: _Question, item: str) -> str:
    """Return the workspace margins at the positions of an *item*; both are arrays as text."""
    return _text(question.criterion.margin(_array(item).reshape(-1, 3)))


def _numbers(values: Array) -> _Numbers:
    return tuple(values.tolist())


def _text(values: Array) -> str:
    return base64.b64encode(np.ascontiguousarray(values, dtype="<f8").tobytes()).decode()


def _array(text: str) -> Array:
    return np.frombuffer(base64.b64decode(text), dtype="<f8").astype(np.float64)
