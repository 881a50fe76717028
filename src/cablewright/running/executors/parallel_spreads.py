"""Spread of nozzle errors at many positions, computed by an executor: blocks of positions are items."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any, Final, NamedTuple

import numpy as np

from cablewright.analyses.accuracy.corners import vertex_count
from cablewright.analyses.accuracy.spread import SOLVES, Method, MonteCarlo, Spread, SpreadProblem
from cablewright.foundation.arrays import Array
from cablewright.foundation.progress import Progress, silent
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot.uncertainty import Range
from cablewright.running.executors.executor import Executor
from cablewright.running.executors.stored_results import KeptResults
from cablewright.running.executors.study import shared_blocks

_PLACES: Final = 64  # of a block, at most


class _Question(NamedTuple):
    """What all blocks have in common; the name, as two methods without options have equal settings."""

    model: Model
    ranges: tuple[Range, ...]
    method: Method
    name: str


@dataclass(frozen=True, eq=False)
class SharedMethod:
    """A `Method` whose places are computed by an *executor*; *kept*: results of earlier calls."""

    method: Method
    executor: Executor
    kept: KeptResults = field(default_factory=KeptResults)
    progress: Progress = silent

    @property
    def name(self) -> str:
        """Name of the method."""
        return self.method.name

    def __call__(self, problem: SpreadProblem) -> Spread:
        """Return the spread at each pose, equal to the method's own to the bit.

        Raises `AnswerError` for a block that fails, `EnvironmentFault` where no worker is available.
        """
        question = _Question(problem.nominal.model, problem.ranges, self.method, self.method.name)
        size = min(_PLACES, max(1, SOLVES // _solves(self.method, len(problem.ranges))))
        firsts = range(0, len(problem.commanded), size)
        blocks = {first: _item(problem.rows(slice(first, first + size))) for first in firsts}
        values = shared_blocks(spread_of, question, blocks, self.executor, self.kept, self.progress)
        joined: dict[str, Any] = {each.name: _joined(each.name, values) for each in fields(Spread)}
        return Spread(**joined)


def spread_of(question: _Question, item: tuple[Any, ...]) -> dict[str, Any]:
    """Return the spread of errors at the positions of an *item*, as lists by name."""
    model, ranges, method, _ = question
    commanded, wanted, pose, states, lines, platform = (np.array(each, dtype=np.float64) for each in item)
    none = np.zeros(len(pose), dtype=np.int64)
    packed = model.packed._replace(lines=lines, platform=platform)
    nominal = Equilibrium(model, packed, pose, commanded, states, none, np.zeros(len(pose)), none)
    found = method(SpreadProblem(nominal, commanded, wanted, ranges))
    return {each.name: getattr(found, each.name).tolist() for each in fields(Spread)}


def _solves(method: Method, ranges: int) -> int:
    """How many forward problems a place takes."""
    return method.samples if isinstance(method, MonteCarlo) else vertex_count(ranges)


def _item(problem: SpreadProblem) -> tuple[Any, ...]:
    """Return the places of a problem as nested lists: what `spread_of` takes."""
    nominal = problem.nominal
    arrays = (problem.commanded, problem.wanted, nominal.pose, nominal.states, *nominal.packed[1:3])
    return tuple(each.tolist() for each in arrays)


def _joined(name: str, values: list[dict[str, Any]]) -> Array:
    kind = np.int64 if name == "unsolved" else np.float64
    return np.concatenate([np.array(each[name], dtype=kind) for each in values])
