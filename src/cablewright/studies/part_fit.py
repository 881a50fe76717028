"""Whether a part fits in a robot's reach: position, rotation, largest scale, and the limit that stops it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import ClassVar, Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.foundation.progress import Progress, silent
from cablewright.foundation.results import Figure, Pictured
from cablewright.models.job_poses import on_plane
from cablewright.models.statics import Model
from cablewright.printing.job import Job
from cablewright.printing.stl import read_stl
from cablewright.robot import Robot
from cablewright.robot.plane import OFF_PLANE
from cablewright.studies.reach import Reach, held_at, reach

POINTS: Final = 1500
"""Points of a part, spread over it and with its extremes, that are placed."""

TURNS: Final = 12
"""Rotations about the vertical that are tried, over half a turn."""

_PLACES: Final = 15  # along the longer side of the frame
_CLOSER: Final = 0.01  # of the scale
_SHRUNK: Final = 0.98
_LARGEST: Final = 1e3


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Pictured):
    """A part in a robot's reach, at its largest scale among the positions and rotations that were tried."""

    FIGURES: ClassVar = (
        Figure("fits", "", "Whether the part fits at its own scale."),
        Figure("scale", "1", "Largest scale at which it fits at this rotation.", name="largest scale"),
        Figure("origin", "m", "Where the part's zero is at its own scale, or else at the largest: a job's origin."),
        Figure(
            "rotation", "rad", "By how much it is turned about the vertical; only where it fits only so.", shown="deg"
        ),
        Figure("size", "m", "Sides of the part at its own scale."),
        Figure("limit", "", "What limits a larger part."),
        Figure(
            "reach_volume",
            "m^3",
            "Volume that the nozzle reaches.",
            "reach.volume",
            only=lambda of: not of.reach.is_flat,
        ),
        Figure(
            "reach_volume",
            "m^2",
            "In a plane: area that the nozzle reaches.",
            "reach.volume",
            name="reach area",
            only=lambda of: of.reach.is_flat,
        ),
        Figure("not_checked", "", "What is not counted.", sentences=True, detail=True),
    )
    HEADLINES: ClassVar = ("fits", "scale", "limit")

    robot: Robot
    points: Array  # (k, 3) m, at its own scale, from its zero along the directions of ``reach``
    reach: Reach
    scale: float
    rotation: float
    origin: Array  # (3,) m
    limit: str
    not_checked: tuple[str, ...] = (
        "lines against the part and each other, motion, winches and expected error: check counts them",
    )

    @property
    def fits(self) -> bool:
        """Whether the part fits the robot at its present size."""
        return self.scale >= 1.0

    @property
    def size(self) -> Array:
        """Sides (3,) of the part, m."""
        return np.asarray(np.ptp(self.points, axis=0))

    @property
    def placed(self) -> Array:
        """The points (k, 3), m, of the part at the largest scale, or at their own if that is less."""
        at_scale = _turned(self.points, self.rotation) * min(self.scale, 1.0)
        return np.asarray(at_scale @ self.reach.directions + self.origin)

    @property
    def refusal(self) -> str:
        """Reason why the part does not fit."""
        if self.fits:
            return ""
        return f"the part fits {self.robot.name!r} up to a scale of {self.scale:.3g}: {self.limit}"


def fit(
    robot: Robot, part: Job | str | Path, *, max_error: float | None = None, turns: int = TURNS,
    progress: Progress = silent,
) -> Fit:  # fmt: skip
    """Find a position where a *part* fits, a job or an STL file in mm, standing on the height in its file.

    Where the frame begins above that, it stands on the frame's floor; in a plane that is not level it is anywhere.
    *max_error*: m, as of `reach`; *turns*: rotations that are tried. Where it fits it is verified at its points, with
    all physics. Raises `InputError` as `reach`, and for a solid where the nozzle moves in a plane; `AnswerError` where
    the robot reaches nothing.
    """
    if turns < 1:
        raise InputError(f"turns = {turns}: the number of rotations to try must be at least 1")
    job = on_plane(robot, part) if isinstance(part, Job) else None
    lift = job.origin[2] if job else 0.0
    found = reach(robot, max_error=max_error, progress=progress)
    if not found.cells.any():
        raise AnswerError(f"robot {robot.name!r} holds its nozzle nowhere in its frame within its limits")
    points = _points(job or part) @ found.directions.T
    on_wall = len(found.axes[1]) == 1
    if found.is_flat and not job and np.ptp(points[:, 1 if on_wall else 2]) > OFF_PLANE:
        raise InputError(f"{part}: is not flat, and the nozzle of {robot.name!r} moves in a plane: give a job")
    angles = np.zeros(1) if found.is_flat else np.arange(turns) * math.pi / turns
    floor = float(found.axes[2][0])
    place = _Placing(found, on_wall, lift, floor if floor > points[:, 2].min() + lift and not on_wall else None)
    best = (0.0, 0.0, np.zeros(3))
    for number, angle in enumerate(angles):
        progress("placing", number, len(angles))
        if best[0] >= 1.0 and best[1] == 0.0:
            break  # a part is turned where it does not fit else
        best = max(best, place.largest(points, float(angle), best[0]), key=lambda each: each[0])
    progress("placing", len(angles), len(angles))
    scale, angle, centre = best
    model = Model.full(robot)
    turned = _turned(points, angle)
    while scale > 0.0 and not held_at(model, place.at(turned, scale, centre) @ found.directions).holds.all():
        scale = scale * _SHRUNK if scale > _CLOSER else 0.0
    origin = (centre - place.middle(turned) * (min(scale, 1.0) if scale else 1.0)) @ found.directions
    limit = _limit(robot, model, lambda larger: place.at(turned, max(scale, 0.01) * larger, centre) @ found.directions)
    return Fit(robot, points, found, scale, angle, origin, limit)


def _points(part: Job | str | Path) -> Array:
    """Return points (k, 3), m, from a part's zero: of its surface, or of its laid material. Raises `InputError`."""
    if isinstance(part, Job):
        toolpath = part.toolpath()
        laid = toolpath.extruding
        start, end = toolpath.start[laid], toolpath.end[laid]
        shares = np.linspace(0.0, 1.0, 2 + POINTS // max(len(start), 1))[:, None, None]
        points = (start + shares * (end - start)).reshape(-1, 3) * part.scale
    else:
        if Path(part).suffix.lower() != ".stl":
            raise InputError(f"{part}: must be a job's TOML or G-code, or an STL file in mm")
        points = read_stl(part, 1e-3).vertices.copy()
        points[:, 2] -= points[:, 2].min()
    some = points[:: max(1, len(points) // POINTS)]
    extremes = [int(pick) for k in range(3) for pick in (points[:, k].argmin(), points[:, k].argmax())]
    return np.concatenate([some, points[extremes]])


def _turned(points: Array, angle: float) -> Array:
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.asarray(points @ np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]]))


@dataclass(frozen=True, eq=False)
class _Placing:
    """Places of a part in a reach: at the height of its file, or with its foot on a ``floor`` above that, m.

    ``on_wall``: whether the part is printed in a plane that is not level, where it may be at any height. ``lift``:
    height, m, of the file's zero over the world's. Points are along the directions of the reach.
    """

    reach: Reach
    on_wall: bool
    lift: float
    floor: float | None

    def middle(self, turned: Array) -> Array:
        """Return the point of a part, (3,) m, about which it is scaled: the middle of its plan, or of the part."""
        low, high = turned.min(axis=0), turned.max(axis=0)
        middle = 0.5 * (low + high)
        if not self.on_wall:
            middle[2] = -self.lift if self.floor is None else low[2]
        return np.asarray(middle)

    def at(self, turned: Array, scale: float, centre: Array) -> Array:
        """Return the points (k, 3), m, of a part whose middle is at *centre*."""
        return np.asarray((turned - self.middle(turned)) * scale + centre)

    def largest(self, points: Array, angle: float, least: float) -> tuple[float, float, Array]:
        """Return the largest scale at an *angle*, rad, above *least*, and the position of the part's middle, (3,) m."""
        turned = _turned(points, angle)
        best = (least, angle, np.zeros(3))
        heights = self.reach.axes[2] if self.on_wall else np.array([self.floor or 0.0])
        tried = [axis if len(axis) == 1 else np.linspace(axis[0], axis[-1], _PLACES)
                 for axis in (*self.reach.axes[:2], heights)]  # fmt: skip
        for place in product(*tried):
            centre = np.array(place)
            scale = self._largest_at(turned, centre, best[0])
            if scale > best[0]:
                best = (scale, angle, centre)
        return best

    def _largest_at(self, turned: Array, centre: Array, least: float) -> float:
        """Return the largest scale, or one that is not over *least* where there is none."""

        def fits(scale: float) -> bool:
            return bool(self.reach.within(self.at(turned, scale, centre)).all())

        low, high = least, 2.0 * max(least, 0.05)
        if low > 0.0 and not fits(low * (1.0 + _CLOSER)):
            return 0.0
        while high < _LARGEST and fits(high):
            low, high = high, 2.0 * high
        while high - low > 0.5 * _CLOSER * high and high >= _CLOSER:
            between = 0.5 * (low + high)
            low, high = (between, high) if fits(between) else (low, between)
        return low


def _limit(robot: Robot, model: Model, placed_at: Callable[[float], Array]) -> str:
    """Return what keeps the part from being larger: the frame, or the line whose tension is out of bounds.

    *placed_at*: points (k, 3), m, of a part so many times as large.
    """
    for more in (1.02, 1.05, 1.1, 1.2, 1.5, 2.0):
        placed = placed_at(more)
        for k, name in enumerate("xyz"):
            if placed[:, k].min() < robot.scene.frame_min[k] or placed[:, k].max() > robot.scene.frame_max[k]:
                return f"the frame's box along {name}"
        held = held_at(model, placed)
        if not (good := held.holds).all():
            bad = int(np.argmin(good))
            place = ", ".join(f"{each:.3g}" for each in placed[bad])
            return f"nozzle at {place} m: {held[bad].sentence()}"
    return "an error over the largest that is allowed, or the grid of places"
