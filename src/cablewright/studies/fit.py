"""Whether a part fits a robot: where, turned how, up to which scale, and what limits it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.foundation.progress import Progress, silent
from cablewright.foundation.results import Figure, Pictured
from cablewright.models.statics import Model
from cablewright.printing.job import Job
from cablewright.printing.stl import read_stl
from cablewright.robot import Robot
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
    """A part in the reach of a robot, at its largest scale among the places and rotations that were tried."""

    FIGURES: ClassVar = (
        Figure("fits", "", "Whether the part fits at its own scale."),
        Figure("scale", "1", "Largest scale at which it fits at this rotation.", name="largest scale"),
        Figure("origin", "m", "Where the part's zero is at its own scale, or else at the largest: a job's origin."),
        Figure(
            "rotation", "rad", "By how much it is turned about the vertical; only where it fits only so.", shown="deg"
        ),
        Figure("size", "m", "Sides of the part at its own scale."),
        Figure("limit", "", "What limits a larger part."),
        Figure("reach_volume", "m^3", "Volume that the nozzle reaches; in a plane m^2.", "reach.volume"),
        Figure("not_checked", "", "What is not counted.", sentences=True, detail=True),
    )
    HEADLINES: ClassVar = ("fits", "scale", "limit")

    robot: Robot
    points: Array  # (k, 3) m, at its own scale
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
        """Whether the part fits as it is."""
        return self.scale >= 1.0

    @property
    def size(self) -> Array:
        """Sides (3,), m."""
        return np.asarray(np.ptp(self.points, axis=0))

    @property
    def placed(self) -> Array:
        """The points (k, 3), m, where they are at the largest scale, or at their own if that is less."""
        return _turned(self.points, self.rotation) * min(self.scale, 1.0) + self.origin

    @property
    def refusal(self) -> str:
        """Why it does not fit."""
        if self.fits:
            return ""
        return f"the part fits {self.robot.name!r} up to a scale of {self.scale:.3g}: {self.limit}"


def fit(
    robot: Robot, part: Job | str | Path, *, max_error: float | None = None, turns: int = TURNS,
    progress: Progress = silent,
) -> Fit:  # fmt: skip
    """Return where a *part* fits, a job or an STL file in mm, standing on the height at which its file has it.

    *max_error*: m, as of `reach`; *turns*: rotations that are tried. Where it fits it is verified at its points, with
    all physics. Raises `InputError` as `reach`, and `AnswerError` where the robot reaches nothing.
    """
    if turns < 1:
        raise InputError(f"turns = {turns}: must be at least 1")
    points = _points(part)
    found = reach(robot, max_error=max_error, progress=progress)
    if not found.cells.any():
        raise AnswerError(f"robot {robot.name!r} holds its nozzle nowhere in its frame within its limits")
    flat = robot.platform.plane is not None
    angles = np.zeros(1) if flat else np.arange(turns) * math.pi / turns
    best = (0.0, 0.0, np.zeros(3))
    for number, angle in enumerate(angles):
        progress("placing", number, len(angles))
        if best[0] >= 1.0 and best[1] == 0.0:
            break  # a part is turned where it does not fit else
        best = max(best, _largest(found, points, float(angle), best[0], flat), key=lambda each: each[0])
    progress("placing", len(angles), len(angles))
    scale, angle, centre = best
    model = Model.full(robot)
    turned = _turned(points, angle)
    while scale > 0.0 and not held_at(model, _at(turned, scale, centre)).ok.all():
        scale = scale * _SHRUNK if scale > _CLOSER else 0.0
    origin = _origin(turned, min(scale, 1.0) if scale else 1.0, centre)
    return Fit(robot, points, found, scale, angle, origin, _limit(robot, model, turned, scale, centre))


def _points(part: Job | str | Path) -> Array:
    """Return points (k, 3), m, of a part: of its surface, or of what its path lays. Raises `InputError`."""
    if isinstance(part, Job):
        toolpath = part.toolpath()
        laid = toolpath.extruding
        ends = np.concatenate([toolpath.start[laid], toolpath.end[laid]])
        points = ends * part.scale + np.array([0.0, 0.0, part.origin[2]])
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


def _middle(turned: Array) -> Array:
    """Return the middle of the box around points (k, 3), m, at the height z = 0, from which a part is scaled."""
    middle = 0.5 * (turned.min(axis=0) + turned.max(axis=0))
    return np.array([middle[0], middle[1], 0.0])


def _at(turned: Array, scale: float, centre: Array) -> Array:
    return np.asarray((turned - _middle(turned)) * scale + centre)


def _origin(turned: Array, scale: float, centre: Array) -> Array:
    """Return where the part's own zero is, (3,) m."""
    return np.asarray(centre - _middle(turned) * scale)


def _largest(found: Reach, points: Array, angle: float, least: float, flat: bool) -> tuple[float, float, Array]:
    """Return the largest scale at an *angle*, rad, that exceeds *least*, and the middle of the part, (3,) m."""
    turned = _turned(points, angle)
    best = (least, angle, np.zeros(3))
    x, y, _ = found.axes
    for px in np.linspace(x[0], x[-1], _PLACES):
        for py in y[:1] if flat and len(y) == 1 else np.linspace(y[0], y[-1], _PLACES):
            centre = np.array([px, py, 0.0])
            low, high = best[0], 2.0 * max(best[0], 0.05)
            if low > 0.0 and not found.within(_at(turned, low * (1.0 + _CLOSER), centre)).all():
                continue
            while high < _LARGEST and found.within(_at(turned, high, centre)).all():
                low, high = high, 2.0 * high
            while high - low > 0.5 * _CLOSER * high:
                between = 0.5 * (low + high)
                if found.within(_at(turned, between, centre)).all():
                    low = between
                else:
                    high = between
                if high < _CLOSER:
                    break
            if low > best[0]:
                best = (low, angle, centre)
    return best


def _limit(robot: Robot, model: Model, turned: Array, scale: float, centre: Array) -> str:
    """Return what keeps the part from being larger: the frame, or the line whose tension is out of bounds."""
    for more in (1.02, 1.05, 1.1, 1.2, 1.5, 2.0):
        placed = _at(turned, max(scale, 0.01) * more, centre)
        for k, name in enumerate("xyz"):
            if placed[:, k].min() < robot.scene.frame_min[k] or placed[:, k].max() > robot.scene.frame_max[k]:
                return f"the frame's box along {name}"
        held = held_at(model, placed)
        if not held.ok.all():
            bad = int(np.flatnonzero(~held.ok)[0])
            place = ", ".join(f"{each:.3g}" for each in placed[bad])
            return f"nozzle at {place} m: {held[bad].sentence()}"
    return "an error over the largest that is allowed, or the grid of places"
