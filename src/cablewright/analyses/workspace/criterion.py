"""Workspace criterion: the condition for a position to be in the workspace, and the pose of the platform there."""

from __future__ import annotations

import math
from collections.abc import Sized
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol, TypedDict, Unpack, get_args

import numpy as np
from numpy.typing import ArrayLike

from cablewright.analyses.feasibility import broken_limits
from cablewright.analyses.workspace.refinement import SearchBox
from cablewright.analyses.workspace.search_plane import SearchPlane
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.choices import CriterionName, PointName
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.progress import Progress
from cablewright.foundation.results import Figure
from cablewright.models.fidelity import CableLaw, SheaveLaw
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.solvers.arguments import as_rows, require_a_load
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.tension import Capacity, Distribution, capacity, tension_distribution, wrench_closure
from cablewright.solvers.winched_tensions import require_both_ways

CRITERIA: tuple[str, ...] = get_args(CriterionName)
POINTS: tuple[str, ...] = get_args(PointName)
CONTINUOUS = ("closed-form", "exact", "capacity", "wrench-closure")
"""Criteria whose margin is continuous at the boundary. That of ``improved-closed-form`` is zero far inside."""

BLOCK = 16384  # poses evaluated between two progress reports; bounds memory
IN_PLANE = 1e-9  # m: largest distance of an exit point of a planar robot from the plane
HALF_TURN = math.pi * (1.0 + 1e-9)  # rad, with room for rounding


class Margins(Protocol):
    """Interface of an object that computes the margins of a criterion, such as an executor."""

    def __call__(self, criterion: Criterion, places: Array, progress: Progress | None, stage: str) -> Array:
        """Return what `Criterion.margin` of the criterion alone would."""
        ...


class Options(TypedDict, total=False):
    """Options (keyword arguments) of `Criterion.of`, which `workspace`, `count_nodes` and `boundary_modes` pass on."""

    cable: CableLaw | str | None
    sheave: SheaveLaw | str | None
    tension_limits: tuple[float, float] | None
    box: ArrayLike | None
    point: str
    wrench: ArrayLike | None
    wrench_box: tuple[ArrayLike, ArrayLike] | None
    arm: float
    orientations: ArrayLike | None
    retraction: float | RetractionLaw | None
    margins: Margins | None


@dataclass(frozen=True)
class RetractionLaw:
    """Retraction length slope * z + intercept, m, at the height z (m) of the point `of`: ``nozzle`` or ``origin``.

    The length is clamped to `least` and `most`, m; None: not clamped.
    """

    slope: float
    intercept: float
    least: float | None = None
    most: float | None = None
    of: str = "nozzle"

    def at(self, heights: ArrayLike) -> Array:
        """Return the platform's retraction lengths, m, with the nozzle at *heights*, m."""
        lengths = self.slope * np.asarray(heights, dtype=np.float64) + self.intercept
        return np.clip(lengths, self.least, self.most)


@dataclass(frozen=True, eq=False)
class Criterion:
    """The condition for a position to be in the workspace. `Criterion.of` makes one and checks its arguments."""

    model: Model
    name: str  # one of CRITERIA
    box: SearchBox  # the region that is searched
    point: str  # whose position it is: the platform's "nozzle" or "origin"
    orientations: Array  # (K, 3) rotation vectors, rad; the criterion has to hold under each
    retraction: float | RetractionLaw | None  # m
    wrench_box: tuple[Array, Array] | None  # lowest and highest (n,), N and N m, for `capacity`
    arm: float  # m; `capacity` divides moments by it to compare them with forces
    margins: Margins | None = None  # who computes them; None: this program

    @classmethod
    def of(
        cls,
        robot: Robot | Model,
        name: str = "exact",
        *,
        flat: bool = False,
        **options: Unpack[Options],
    ) -> Criterion:
        """Return the criterion *name*; arguments as for `workspace`. Raises `InputError`.

        *flat*: whether the box may be flat; a planar robot's then is, unless one is given.
        """
        point, wrench, wrench_box = options.get("point", "nozzle"), options.get("wrench"), options.get("wrench_box")
        if name not in CRITERIA:
            raise UnknownName("criterion", name, CRITERIA)
        if point not in POINTS:
            raise UnknownName("point", point, POINTS)
        default = CableLaw.CATENARY if name == "static" else CableLaw.RIGID
        cable, sheave, limits = options.get("cable"), options.get("sheave"), options.get("tension_limits")
        model = Model.of(robot, cable=cable, sheave=sheave, tension_limits=limits, default=default)
        if name != "static" and model.fidelity.cable is CableLaw.CATENARY:
            raise InputError(f"cable = catenary: {name} requires straight lines; use rigid or elastic, or static")
        if wrench is not None:
            whole = np.zeros(6)
            whole[: model.n] = as_rows(wrench, model.n, "wrench", "N and N m")[0][0]
            model = replace(model, robot=model.robot.under_wrench(whole[:3].tolist(), whole[3:].tolist()))
        wrenches = None
        if wrench_box is not None:
            if name != "capacity":
                raise InputError(f"a box of wrenches is for the criterion capacity, not for {name}; leave it out")
            low, high = (as_rows(side, model.n, "wrench box", "N and N m")[0][0] for side in wrench_box)
            wrenches = low, high
        turns = _turns(model, options.get("orientations"))
        box, tilted = options.get("box"), model.robot.platform.in_tilted_plane
        plane = plane_of(model.robot, point) if flat and box is None and not tilted else None
        where = plane or box_of(model.robot, box, flat=flat and not tilted)
        arm = float(options.get("arm", 1.0))
        retraction, margins = options.get("retraction"), options.get("margins")
        made = cls(model, name, where, point, turns, retraction, wrenches, arm, margins)
        made._check_retraction()
        made._check_plane(flat)
        if name in ("exact", "closed-form", "improved-closed-form"):
            require_a_load(model)
        return made

    @property
    def length(self) -> float | None:
        """The constant retraction length, m; None if there is none or it follows a law."""
        return None if isinstance(self.retraction, RetractionLaw) else self.retraction

    @property
    def law(self) -> RetractionLaw | None:
        """Law of the platform's retraction by the nozzle's height; None if there is none."""
        return self.retraction if isinstance(self.retraction, RetractionLaw) else None

    @property
    def turns(self) -> Array | None:
        """The rotations (K, 3) of a rigid platform under which the criterion must hold; None for a point platform."""
        return self.orientations if self.model.n == 6 else None

    @property
    def continuous(self) -> bool:
        """Whether the margin changes continuously at the workspace's boundary, so that it can be interpolated."""
        return self.name in CONTINUOUS

    def margin(self, places: Array, progress: Progress | None = None, stage: str = "places") -> Array:
        """Return signed margins (N,) at *places* (N, 3), m: inside where at least 0; the minimum over the orientations.

        In N of tension; of wrench for `capacity`; as a share of the mean tension for `wrench-closure`; 1 or -1 for
        `static`. -inf where no tensions balance the load, and everywhere if there are no orientations.
        """
        if self.margins is not None:
            return self.margins(self, places, progress, stage)
        found = np.full(len(places), np.inf if len(self.orientations) else -np.inf)
        for first in range(0, len(places), BLOCK):
            block = slice(first, first + BLOCK)
            for turn in self.orientations:
                found[block] = np.minimum(found[block], self._margins(self.poses(places[block], turn)))
            if progress:
                progress(stage, min(first + BLOCK, len(places)), len(places))
        return found

    def continuous_margin(self, places: Array, progress: Progress | None, stage: str) -> Array:
        """Return the `margin` of the criterion, or only its sign if it is not continuous."""
        margins = self.margin(places, progress, stage)
        return margins if self.continuous else np.where(margins >= 0.0, 1.0, -1.0)

    def poses(self, places: Array, turn: Array) -> Array:
        """Return poses (N, n) that bring the point to *places* (N, 3), m, rotated by the vector *turn* (3,), rad."""
        poses = np.concatenate([places, np.broadcast_to(turn, places.shape)], axis=1)[:, : self.model.n]
        return self.model.at_nozzle(poses) if self.point == "nozzle" else poses

    def all_poses(self, places: Array) -> Array:
        """Return poses (K * N, n) at *places* (N, 3), m, orientation by orientation."""
        rows = [self.poses(places, turn) for turn in self.orientations]
        return np.concatenate([np.empty((0, self.model.n)), *rows])

    def lengths(self, poses: Array) -> Array | float | None:
        """Return the retraction lengths at *poses* (N, n), m."""
        law = self.retraction
        if not isinstance(law, RetractionLaw):
            return law
        return law.at(poses[:, 2] if law.of == "origin" else self.model.nozzle(poses)[:, 2])

    def broken_limits(self, poses: Array) -> tuple[tuple[str, ...], Mask]:
        """Return, for `static`, the names of all L limits and which of them *poses* (N, n) violate, (N, L)."""
        given = poses
        if self.across is not None and self.model.winches < self.model.n:  # gravity keeps them in their plane
            given = poses.copy()
            given[:, self.across] = np.nan
        if self.turned_by_gravity:
            given = poses.copy()
            given[:, 3:] = np.nan
        return broken_limits(solve_inverse(self.model, given, retraction=self.lengths(poses)))

    @property
    def turned_by_gravity(self) -> bool:
        """Whether a body's lines share winches such that its position is given, and gravity decides its rotation."""
        model = self.model
        free = bool(model.robot.sharing) and model.n == 6 and model.robot.platform.plane is None
        return free and 3 <= model.winches < model.freedoms

    @cached_property
    def across(self) -> int | None:
        """The axis across the plane of a planar robot in whose plane the box is; None for others and for `Plane`."""
        guided = self.model.robot.platform.plane is not None
        plane = plane_of(self.model.robot) if self.box.is_flat and not guided else None
        if plane is None:
            return None
        axis = plane.flat_axis
        return axis if axis == self.box.flat_axis and plane.low[axis] == self.box.low[axis] else None

    @cached_property
    def search_plane(self) -> SearchPlane:
        """The plane that is searched: the platform's plane, or that of a flat box."""
        plane = self.model.robot.platform.plane
        if plane is None:
            axis = self.box.flat_axis
            return SearchPlane(np.eye(3)[axis], float(self.box.low[axis]))
        return SearchPlane.of(self.model.robot, plane, self.point)

    def _margins(self, poses: Array) -> Array:
        """Signed margins (N,) of *poses* (N, n)."""
        if self.name == "static":
            return np.where(self.broken_limits(poses)[1].any(axis=1), -1.0, 1.0)
        lengths = self.lengths(poses)
        found: Distribution | Capacity
        if self.name == "capacity":
            found = capacity(self.model, poses, box=self.wrench_box, length=self.arm, retraction=lengths)
        elif self.name == "wrench-closure":
            found = wrench_closure(self.model, poses, retraction=lengths)
        else:
            found = tension_distribution(self.model, poses, self.name, retraction=lengths)
        no = np.where(found.margin < 0.0, found.margin, np.where(np.isfinite(found.margin), -1e-300, -np.inf))
        return np.where(found.feasible, np.maximum(found.margin, 0.0), no)

    def _check_plane(self, flat: bool) -> None:
        """Reject what no planar robot can do: to pull across its plane, or to leave it. Raises `InputError`."""
        if self.model.robot.platform.plane is not None:
            self._check_box(flat)
        if self.name in ("capacity", "wrench-closure"):
            require_both_ways(self.model, self.name)
        if self.name == "static" and self.turned_by_gravity:
            if self.orientations.any():
                raise InputError(
                    "static: lines share winches, and gravity decides the rotation: leave out orientations"
                )
            return
        if self.name == "static" and self.model.winches < self.model.freedoms and self.across is None:
            count, what = self.model.winches, "winches" if self.model.winches < self.model.m else "lines"
            why = f"{count} {what} hold {count} of the {self.model.freedoms} degrees of freedom"
            raise InputError(f"static: {why}; only two lines in a plane can be searched, in that plane")
        if self.across is None:
            return
        if self.name == "wrench-closure":
            raise InputError(
                "wrench-closure: lines of a planar robot cannot pull across its plane; use another criterion"
            )
        if self.wrench_box is not None and any(side[self.across] for side in self.wrench_box):
            axis = "xyz"[self.across]
            raise InputError(f"wrench box: no lines pull across the plane; give 0 to 0 along {axis}")

    def _check_box(self, flat: bool) -> None:
        """Reject a box out of the plane that carries the platform. Raises `InputError`."""
        if not flat or not self.search_plane.crosses(self.box):
            why = f"the {self.point} of {self.model.robot.name!r} moves in the plane {self.search_plane}"
            raise InputError(f"box: {why}: only an area in that plane can be searched")

    def _check_retraction(self) -> None:
        """Reject retraction lengths outside the platform's range. Raises `InputError`."""
        law, robot = self.retraction, self.model.robot
        if law is None:
            return
        if not isinstance(law, RetractionLaw):
            robot.retraction_to(law)
            return
        if law.of not in POINTS:
            raise UnknownName("point", law.of, POINTS)
        if not (math.isfinite(law.slope) and math.isfinite(law.intercept)):
            raise InputError(f"retraction law {law.slope:g} z + {law.intercept:g} m: finite numbers are expected")
        if (law.least is None) != (law.most is None):
            raise InputError("retraction law: give both clamps, MIN and MAX, or none")
        if law.least is not None and law.most is not None:
            if not law.least < law.most:
                raise InputError(f"retraction law: clamps {law.least:g} to {law.most:g} m: least < most is expected")
            robot.retraction_to(law.least)
            robot.retraction_to(law.most)
            return
        if robot.retraction is None:
            raise InputError(f"robot {robot.name!r} has no retraction: it cannot follow a retraction law")
        self._check_unclamped(law)

    def _check_unclamped(self, law: RetractionLaw) -> None:
        """Reject a law without clamps that leaves the platform's range within the box. Raises `InputError`."""
        heights = [float(self.box.low[2]), float(self.box.high[2])]
        poses = self.all_poses(np.column_stack([np.zeros((2, 2)), heights]))
        for height, length in zip(heights * len(self.orientations), np.asarray(self.lengths(poses)), strict=True):
            try:
                self.model.robot.retraction_to(float(length))
            except InputError as reason:
                law_text = f"retraction law {law.slope:g} z + {law.intercept:g} m leaves its range"
                raise InputError(
                    f"{law_text} at height {height:g} m: {reason}; give the law clamps, C,D,MIN,MAX"
                ) from None


def is_planar(robot: Robot, box: ArrayLike | None) -> bool:
    """Return whether a *box* (6,), m, is flat, or without one the robot: a point in the plane of its exit points."""
    if robot.platform.in_tilted_plane:
        return True
    return plane_of(robot) is not None if box is None else box_of(robot, box, flat=True).is_flat


def plane_of(robot: Robot, point: str = "origin") -> SearchBox | None:
    """Return the part of the frame in the plane of a planar robot, None for others.

    A planar robot has `platform.plane`, not tilted, in which its *point* moves in parallel; or it is a point whose
    lines have one coordinate in common, along which nothing pulls.
    """
    if robot.platform.plane is not None:
        search_plane = SearchPlane.of(robot, robot.platform.plane, point)
        low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
        low[search_plane.axis] = high[search_plane.axis] = (
            search_plane.distance * search_plane.normal[search_plane.axis]
        )
        return SearchBox(low, high)
    exits = np.array([np.subtract(line.exit_point, line.platform_point) for line in robot.lines])
    pulls = robot.platform.force - np.array([0.0, 0.0, robot.platform.mass * robot.scene.gravity])
    low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    within = (low <= exits[0]) & (exits[0] <= high)
    across = np.flatnonzero((np.ptp(exits, axis=0) <= IN_PLANE) & (pulls == 0.0) & within)
    in_plane = all(line.in_plane for line in robot.lines)
    if robot.n != 3 or len(across) != 1 or not in_plane:  # exit points in a line span no plane without a load
        return None
    low[across] = high[across] = exits[0, across]
    return SearchBox(low, high)


def box_of(robot: Robot, ends: ArrayLike | None, *, flat: bool = False) -> SearchBox:
    """Return the box with *ends* (6,) x0, x1, y0, y1, z0, z1, m; None: the robot's frame.

    *flat*: whether two equal ends, for a plane, are allowed. Raises `InputError`.
    """
    if ends is None:
        return SearchBox(np.array(robot.scene.frame_min), np.array(robot.scene.frame_max))
    numbers = np.asarray(ends, dtype=np.float64)
    if numbers.shape != (6,) or not np.isfinite(numbers).all():
        raise InputError(f"box: 6 finite numbers are expected, x0,x1,y0,y1,z0,z1 in m; got {numbers.tolist()}")
    low, high = numbers[::2], numbers[1::2]
    if flat and (low == high).sum() == 1 and (low <= high).all():
        return SearchBox(low, high)
    if (low >= high).any():
        axis = int(np.argmax(low >= high))
        raise InputError(f"box: {'xyz'[axis]} from {low[axis]:g} to {high[axis]:g} m: lowest < highest is expected")
    return SearchBox(low, high)


def _turns(model: Model, orientations: ArrayLike | None) -> Array:
    """The rotation vectors (K, 3), rad, checked. Raises `InputError`."""
    if orientations is None:
        return np.zeros((1, 3))
    none = isinstance(orientations, Sized) and not len(orientations)
    turns, _ = as_rows(np.empty((0, 3)) if none else orientations, 3, "orientations", "rad")
    if model.n == 3:
        raise InputError(f"orientations: {model.robot.name!r} has a point platform, which cannot rotate")
    far = float(np.linalg.norm(turns, axis=1).max(initial=0.0))
    if far > HALF_TURN:
        raise InputError(
            f"orientations: a rotation of {far:g} rad ({math.degrees(far):.4g} degrees); "
            "at most pi (180 degrees) either way is allowed"
        )
    return turns


def criterion_figures(path: str) -> tuple[Figure, ...]:
    """Return the figures of the criterion at the attribute *path* of a result."""
    return (
        Figure("robot", "", "Name of the robot.", f"{path}.model.robot.name"),
        Figure("criterion", "", "What must hold at a place.", f"{path}.name"),
        Figure("cable", "", "Cable law.", f"{path}.model.fidelity.cable"),
        Figure("sheave", "", "Sheave law; null where each is as built.", f"{path}.model.fidelity.sheave", detail=True),
        Figure("point", "", "Point of the platform at a place: nozzle or origin.", f"{path}.point"),
        Figure("orientations", "rad", "Rotation vectors under each of which it holds.", f"{path}.turns", detail=True),
        Figure("retraction", "m", "Retraction length.", f"{path}.length", detail=True),
        Figure("retraction_law", "", "Law of the retraction length by height.", f"{path}.law", detail=True),
        Figure("wrench_box", "N, N m", "Min and max wrench that is balanced.", f"{path}.wrench_box", detail=True),
    )
