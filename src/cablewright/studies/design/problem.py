"""A design problem: variables with their bounds, objectives, constraints, and the positions of the part."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.models.job_poses import poses_at
from cablewright.printing.job import Job
from cablewright.printing.path import Samples
from cablewright.robot import Robot
from cablewright.robot.design_variables import Change, require_different, with_box_inertia
from cablewright.robot.symmetry import SymmetricChange
from cablewright.studies.design.measures import MEASURES, DesignCandidate, Measure, Prices
from cablewright.studies.trade import TradeSettings

CELLS: Final = 6
"""Cells along each side of the part's box, each represented by one position."""

GRID: Final = 9
"""Nodes along each side of the box, for workspaces and their boundaries."""

_CONSTRAINT: Final = re.compile(r"([a-z_]+)\s*(>=|<=)([^<>=]+)")


@dataclass(frozen=True)
class Variable:
    """A design variable between two values, SI. Raises `InputError` for bounds that do not rise."""

    change: SymmetricChange
    low: float
    high: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high):
            raise InputError(f"vary {self.name} from {self.low:g} to {self.high:g}: needs two finite numbers that rise")

    @property
    def name(self) -> str:
        """Name of the design variable."""
        return self.change.name

    @property
    def unit(self) -> str:
        """SI unit of the design variable."""
        return self.change.unit

    @classmethod
    def read(cls, text: str, mirrors: tuple[str, ...] = ()) -> Variable:
        """Return the design variable of ``NAME=LOW:HIGH``.

        Raises `InputError`, with the nearest names for an unknown one.
        """
        name, equals, bounds = text.partition("=")
        low, colon, high = bounds.partition(":")
        try:
            ends = (float(low), float(high)) if equals and colon else None
        except ValueError:
            ends = None
        if ends is None:
            raise InputError(f"vary = {text!r}: expected NAME=LOW:HIGH, two numbers in SI units")
        return cls(SymmetricChange(Change(name), mirrors), *ends)


@dataclass(frozen=True)
class DesignConstraint:
    """A bound of a figure, SI: a minimum ``bound`` where it is ``lower``, else a maximum."""

    key: str
    lower: bool
    bound: float

    def __str__(self) -> str:
        return f"{self.key} {'>=' if self.lower else '<='} {self.bound:g}"

    def missed_by(self, value: float) -> float:
        """Return by how much a value violates the constraint, SI; 0 if it satisfies it, infinite for NaN."""
        if math.isnan(value):
            return math.inf
        return max(0.0, self.bound - value if self.lower else value - self.bound)

    @classmethod
    def read(cls, text: str) -> DesignConstraint:
        """Return the constraint of ``FIGURE>=VALUE`` or ``FIGURE<=VALUE``. Raises `InputError`."""
        match = _CONSTRAINT.fullmatch(text.strip())
        try:
            bound = math.nan if match is None else float(match[3])
        except ValueError:
            bound = math.nan
        if match is None or not math.isfinite(bound):
            raise InputError(f"constraint = {text!r}: expected FIGURE>=VALUE or FIGURE<=VALUE, in SI units")
        return cls(measure(match[1]).key, match[2] == ">=", bound)


def measure(key: str) -> Measure:
    """Return the figure that rates designs, by its name. Raises `UnknownName`."""
    if key not in MEASURES:
        raise UnknownName("figure of a candidate", key, MEASURES)
    return MEASURES[key]


@dataclass(frozen=True)
class DesignProblem:
    """A design task: the robot to change, its variables, objectives and constraints.

    ``job``: without its G-code, of which ``places`` (k, 3), m, are the part's. Raises `InputError` for contradictions.
    """

    robot: Robot
    variables: tuple[Variable, ...]
    objectives: tuple[str, ...]
    constraints: tuple[DesignConstraint, ...] = ()
    job: Job | None = None
    places: tuple[tuple[float, float, float], ...] = ()
    workspace: TradeSettings = field(default_factory=lambda: default_workspace())
    seed: int = 0
    prices: Prices | None = None

    def __post_init__(self) -> None:
        if not self.variables:
            raise InputError("vary: give at least one design variable")
        if not self.objectives:
            raise InputError("objectives: give at least one quantity to optimise")
        require_different(each.change.change for each in self.variables)
        for key in self.keys:
            if measure(key).of_part and self.job is None:
                raise InputError(f"{key}: can only be computed for a printed part; give a JOB")
        if "cost" in self.keys and self.prices is None:
            raise InputError("cost: needs at least one price: of cable, winch or torque")
        if len(set(self.objectives)) < len(self.objectives):
            raise InputError("objectives: one is given twice; give each once")
        self._require_room()

    def _require_room(self) -> None:
        """Reject two bounds of one figure that leave nothing between them."""
        for one, other in product(self.constraints, repeat=2):
            if one.key == other.key and one.lower and not other.lower and one.bound > other.bound:
                raise InputError(f"constraints: {one} and {other} contradict each other")

    @property
    def keys(self) -> tuple[str, ...]:
        """Names of the figures that objectives and constraints need."""
        return tuple(dict.fromkeys((*self.objectives, *(each.key for each in self.constraints))))

    def made(self, values: Sequence[float]) -> Robot:
        """Return the robot with given values of the design variables; without values the original.

        Raises `InputError`.
        """
        robot = self.robot
        for variable, value in zip(self.variables, values, strict=True) if values else ():
            robot = variable.change.on(robot, value)
        return with_box_inertia(robot) if self.workspace.inertia == "box" else robot

    def worth(self, figures: Mapping[str, float]) -> Array:
        """Return the objectives (n,), to be minimised, of a candidate from its *figures*; NaN for a missing figure."""
        signs = [-1.0 if measure(key).higher else 1.0 for key in self.objectives]
        return np.array([figures.get(key, math.nan) for key in self.objectives]) * signs

    def candidate(self, values: Sequence[float]) -> DesignCandidate:
        """Return the candidate robot with these values, at the positions of the part. Raises `InputError`."""
        robot, poses, retraction = self.made(values), None, None
        if self.job is not None:
            poses, retraction = poses_at(robot, self.job, np.array(self.places))
        return DesignCandidate(robot, poses, retraction, self.workspace, self.seed, self.prices or Prices())


def default_workspace() -> TradeSettings:
    """Return the default settings of the candidates' workspaces."""
    return TradeSettings(count="nodes", grid=GRID, boundary_grid=GRID)


def places_of(samples: Samples) -> tuple[tuple[float, float, float], ...]:
    """Return positions that represent a path: one of each cell of its box, and the outermost ones.

    Moves that lay no material do not count, unless none does.
    """
    at = samples.positions[samples.extruding] if samples.extruding.any() else samples.positions
    pitch = np.maximum(np.ptp(at, axis=0), 1e-9) / CELLS
    cell = ((at - at.min(axis=0)) / pitch).astype(np.intp).clip(0, CELLS - 1) @ np.array([CELLS * CELLS, CELLS, 1])
    first = np.unique(cell, return_index=True)[1]
    ways = np.array([way for way in product((-1.0, 0.0, 1.0), repeat=3) if any(way)])
    farthest = np.argmax((at / np.maximum(np.ptp(at, axis=0), 1e-9)) @ ways.T, axis=0)
    chosen: Array = at[np.unique(np.concatenate([first, farthest]))]
    return tuple((float(x), float(y), float(z)) for x, y, z in chosen)
