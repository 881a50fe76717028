"""What a workspace is asked for: which places count, by which criterion, how the platform is held there."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.analyses.feasibility import broken_limits
from cablewright.errors import InputError, UnknownName
from cablewright.models.fidelity import CableLaw
from cablewright.models.statics import Model
from cablewright.progress import Progress
from cablewright.solvers.arguments import as_rows
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.tension import Capacity, Distribution, capacity, distribute, wrench_closure

__all__ = ["CRITERIA", "POINTS", "Law", "Question", "ask"]

Array = NDArray[np.float64]

CRITERIA = ("closed-form", "improved-closed-form", "exact", "capacity", "wrench-closure", "static")
POINTS = ("nozzle", "origin")
TENDING = ("closed-form", "exact", "capacity", "wrench-closure")
"""Criteria whose margin goes evenly to zero at the boundary. The improved closed form's is zero far inside."""

BLOCK = 16384  # poses between two reports, and robots that differ by row in memory at once
HALF_TURN = math.pi * (1.0 + 1e-9)


@dataclass(frozen=True)
class Law:
    """Retraction length slope * z + intercept, m, by the height z of the nozzle or of the platform's origin, m.

    Below `least` and above `most`, its clamps, the length stays there; None: it has none.
    """

    slope: float
    intercept: float
    least: float | None = None
    most: float | None = None
    of: str = "nozzle"

    def at(self, heights: ArrayLike) -> Array:
        """Lengths at *heights*, m."""
        lengths = self.slope * np.asarray(heights, dtype=np.float64) + self.intercept
        return np.clip(lengths, self.least, self.most)


@dataclass(frozen=True, eq=False)
class Question:
    """A criterion for a place: made by `ask`, which checks it."""

    model: Model
    criterion: str
    point: str  # what is at the place: the platform's nozzle or its origin
    orientations: Array  # (K, 3) rotation vectors, rad: a place counts if it does under each
    retraction: float | Law | None
    wrench_box: tuple[Array, Array] | None  # lowest and highest (n,), N and N m, of `capacity`
    arm: float  # m, on which a moment counts as a force for `capacity`

    def margin(self, places: Array, progress: Progress | None = None, stage: str = "places") -> Array:
        """Signed margins (N,) of *places* (N, 3), m, the least over the orientations: inside where at least 0.

        N of tension; of a wrench for `capacity`, a share of the mean tension for `wrench-closure`. `static` has no
        margin: it is 1 or -1. A place where nothing balances has -inf.
        """
        found = np.full(len(places), np.inf)
        for first in range(0, len(places), BLOCK):
            block = slice(first, first + BLOCK)
            for turn in self.orientations:
                found[block] = np.minimum(found[block], self._of(self.poses(places[block], turn)))
            if progress:
                progress(stage, min(first + BLOCK, len(places)), len(places))
        return found

    def tending(self, places: Array, stage: str, progress: Progress | None = None) -> Array:
        """What `refine` can interpolate: the margin where it tends to zero at the boundary, else 1 or -1."""
        margins = self.margin(places, progress, stage)
        return margins if self.criterion in TENDING else np.where(margins >= 0.0, 1.0, -1.0)

    def poses(self, places: Array, turn: Array) -> Array:
        """Poses (N, n) that bring the point to *places* (N, 3), turned by a rotation vector (3,), rad."""
        if self.model.n == 3:
            return places
        poses = np.concatenate([places, np.broadcast_to(turn, places.shape)], axis=1)
        return self.model.at_nozzle(poses) if self.point == "nozzle" else poses

    def lengths(self, poses: Array) -> Array | float | None:
        """Retraction lengths at *poses* (N, n), m."""
        law = self.retraction
        if not isinstance(law, Law):
            return law
        return law.at(poses[:, 2] if law.of == "origin" else self.model.nozzle(poses)[:, 2])

    def _of(self, poses: Array) -> Array:
        lengths = self.lengths(poses)
        found: Distribution | Capacity
        if self.criterion == "static":
            held = solve_inverse(self.model, poses, retraction=lengths)
            return np.where(broken_limits(held)[1].any(axis=1), -1.0, 1.0)
        if self.criterion == "capacity":
            found = capacity(self.model, poses, box=self.wrench_box, length=self.arm, retraction=lengths)
        elif self.criterion == "wrench-closure":
            found = wrench_closure(self.model, poses, retraction=lengths)
        else:
            found = distribute(self.model, poses, self.criterion, retraction=lengths)
        no = np.where(found.margin < 0.0, found.margin, np.where(np.isfinite(found.margin), -1e-300, -np.inf))
        return np.where(found.feasible, np.maximum(found.margin, 0.0), no)


def ask(
    model: Model,
    criterion: str,
    heights: tuple[float, float],
    *,
    point: str = "nozzle",
    wrench: ArrayLike | None = None,
    wrench_box: tuple[ArrayLike, ArrayLike] | None = None,
    arm: float = 1.0,
    orientations: ArrayLike | None = None,
    retraction: float | Law | None = None,
) -> Question:
    """Check what is asked for between two *heights* of the point, m. Raises `InputError`; see `workspace`."""
    if criterion not in CRITERIA:
        raise UnknownName("criterion", criterion, CRITERIA)
    if point not in POINTS:
        raise UnknownName("point", point, POINTS)
    if criterion != "static" and model.fidelity.cable is CableLaw.CATENARY:
        raise InputError(f"cable = catenary: {criterion} is of straight lines; use rigid or elastic, or static")
    if wrench is not None:
        values = as_rows(wrench, model.n, "wrench", "N and N m")[0][0]
        model = replace(model, robot=model.robot.under_wrench(values[:3], values[3:] if model.n == 6 else (0, 0, 0)))
    box = None
    if wrench_box is not None:
        if criterion != "capacity":
            raise InputError(f"a box of wrenches goes with criterion capacity, not with {criterion}")
        low, high = (as_rows(side, model.n, "wrench box", "N and N m")[0][0] for side in wrench_box)
        box = low, high
    asked = Question(model, criterion, point, _turns(model, orientations), retraction, box, float(arm))
    _check_retraction(asked, heights)
    return asked


def _turns(model: Model, orientations: ArrayLike | None) -> Array:
    """Rotation vectors (K, 3), rad. Raises `InputError`."""
    if orientations is None:
        return np.zeros((1, 3))
    turns, _ = as_rows(orientations, 3, "orientations", "rad")
    if model.n == 3:
        raise InputError(f"orientations: {model.robot.name!r} has a point platform, which has none")
    if not len(turns):
        raise InputError("orientations: at least one is wanted")
    angles = np.linalg.norm(turns, axis=1)
    if angles.max() > HALF_TURN:
        far = float(angles.max())
        raise InputError(
            f"orientations: a rotation of {far:g} rad ({math.degrees(far):.4g} degrees); "
            "at most pi (180 degrees) either way is allowed"
        )
    return turns


def _check_retraction(asked: Question, heights: tuple[float, float]) -> None:
    """Refuse lengths that the platform does not have. Raises `InputError`."""
    law, robot = asked.retraction, asked.model.robot
    if law is None:
        return
    if not isinstance(law, Law):
        robot.retraction_to(law)
        return
    if law.of not in POINTS:
        raise UnknownName("point", law.of, POINTS)
    if not (math.isfinite(law.slope) and math.isfinite(law.intercept)):
        raise InputError(f"retraction law {law.slope:g} z + {law.intercept:g} m: finite numbers are wanted")
    if (law.least is None) != (law.most is None):
        raise InputError("retraction law: both clamps are wanted, or none")
    if law.least is not None and law.most is not None:
        if not law.least < law.most:
            raise InputError(f"retraction law: clamps {law.least:g} to {law.most:g} m: least < most is wanted")
        robot.retraction_to(law.least)
        robot.retraction_to(law.most)
        return
    if robot.retraction is None:
        raise InputError(f"robot {robot.name!r} has no retraction: a law of it has no meaning")
    ends = np.column_stack([np.zeros((2, 2)), heights])
    for turn in asked.orientations:
        lengths = asked.lengths(asked.poses(ends, turn))
        for height, length in zip(heights, np.broadcast_to(np.asarray(lengths), 2), strict=True):
            try:
                robot.retraction_to(float(length))
            except InputError as reason:
                told = f"retraction law {law.slope:g} z + {law.intercept:g} m leaves its range at height {height:g} m"
                raise InputError(f"{told}: {reason}; give it clamps") from None
