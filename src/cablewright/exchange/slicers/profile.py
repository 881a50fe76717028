"""A robot's data for slicers: the outline of its bed, its height, speeds, accelerations, and G-codes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.analyses.modes import modes
from cablewright.exchange.translation_result import Notes
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.foundation.progress import Progress, silent
from cablewright.models.statics import Model
from cablewright.printing.job import Bead, Motion
from cablewright.robot import Robot
from cablewright.studies.reach import Reach, held_at, reach

CORNERS: Final = 48
"""Corners of the outline of a bed."""

SWING: Final = 0.25
"""By which share of a strand's width the platform may swing when it accelerates."""

MOST: Final = 10.0
"""Largest acceleration of a profile, m/s^2."""

_SHRUNK: Final = 0.98
_TRIES: Final = 40


@dataclass(frozen=True, eq=False)
class Profile:
    """A robot for a slicer, in m and m/s. ``outline``: (k, 2), around ``centre`` (2,); ``bed``: its height.

    ``scale``: ratio of the slicer's lengths to those of the machine, at most 1; ``width`` and ``height``: size of a
    strand.
    """

    name: str
    outline: Array
    centre: Array
    bed: float
    tall: float
    print_speed: float
    travel_speed: float
    acceleration: float
    width: float
    height: float
    scale: float = 1.0

    def mm(self, length: float) -> float:
        """Return a length, speed or acceleration in mm, mm/s or mm/s^2, reduced to the slicer's scale."""
        return float(f"{1e3 * self.scale * length:.6g}")

    @property
    def corners(self) -> list[str]:
        """The outline in mm, as slicers spell points."""
        return [f"{round(self.mm(x), 3) + 0.0:g}x{round(self.mm(y), 3) + 0.0:g}" for x, y in self.outline.tolist()]

    @property
    def rectangle(self) -> tuple[float, float]:
        """Sides, m, of the largest rectangle about the centre, of the ratios that were tried, within the outline."""
        away = self.outline - self.centre
        angles = np.arctan2(away[:, 1], away[:, 0])
        order = np.argsort(angles)
        best = (0.0, 0.0)
        for ratio in np.linspace(0.15, 1.42, 40):  # angle of the corner
            corner = math.inf
            for sign in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
                at = math.atan2(sign[1] * math.sin(ratio), sign[0] * math.cos(ratio))
                far = np.interp(at, angles[order], np.linalg.norm(away, axis=1)[order], period=math.tau)
                corner = min(corner, float(far))
            sides = (2.0 * corner * math.cos(ratio) * _SHRUNK, 2.0 * corner * math.sin(ratio) * _SHRUNK)
            best = max(best, sides, key=lambda each: each[0] * each[1])
        return best

    @property
    def begin(self) -> str:
        """Code before a print: units only, since the job itself moves the platform."""
        return "G21 ; mm\nG90\nM83 ; each E by itself"

    @property
    def end(self) -> str:
        """Code after a print: heaters and fan off, a little up. Motors stay on: without them lines go slack."""
        up, speed = max(self.mm(2.0 * self.height), 0.01), 60.0 * self.mm(self.travel_speed)
        return f"M104 S0\nM140 S0\nM107\nG91\nG1 Z{up:g} F{speed:g}\nG90\n; motors stay on: no M84"


def profile_of(robot: Robot, bead: Bead, largest: float, assumed: Notes, progress: Progress = silent) -> Profile:
    """Return the profile of a robot for strands of *bead*, and note assumed values.

    *largest*: m, the longest side of a bed that the slicer has; a larger one is scaled down. Raises `InputError` for a
    robot in a plane, and `AnswerError` for one that reaches nothing.
    """
    if robot.platform.plane is not None:
        raise InputError(f"robot {robot.name!r} moves in a plane: a slicer needs a bed; give its G-code by hand")
    found = reach(robot, progress=progress)
    bed = 0.0 if robot.scene.frame_min[2] <= 0.0 < robot.scene.frame_max[2] else robot.scene.frame_min[2]
    free, tall = _column(found, bed)
    if not free.any():
        raise AnswerError(f"robot {robot.name!r} reaches no place at the height of a bed, {bed:g} m, in its frame")
    centre, outline = _outline(robot, found, free, bed, tall)
    motion = Motion()
    speeds = [line.winch.max_speed / line.advantage for line in robot.lines if line.winch.max_speed is not None]
    slowest = min(speeds, default=math.inf)
    if not speeds:
        assumed.add(f"speeds: {1e3 * motion.print_speed:g} mm/s, a job's default: no line gives winch.max_speed")
    acceleration = _acceleration(robot, bead, centre, bed, tall, assumed)
    side = float(np.ptp(outline, axis=0).max())
    scale = 1.0
    while side * scale > largest:
        scale *= 0.5
    if scale < 1.0:
        assumed.add(
            f"scale: the slicer's bed is at most {1e3 * largest:g} mm wide: parts are sliced at 1 to {1.0 / scale:g}, "
            f"strands too; print with scale = {1.0 / scale:g} in the job file"
        )
    return Profile(
        robot.name, outline, centre, bed, tall, min(motion.print_speed, slowest), min(motion.travel_speed, slowest),
        acceleration, bead.width, bead.height, scale,
    )  # fmt: skip


def _column(found: Reach, bed: float) -> tuple[Mask, float]:
    """Return which cells (nx - 1, ny - 1) are reached from the bed up to a height, m, of the largest such volume."""
    largest, best, tall = 0.0, np.zeros(found.cells.shape[:2], np.bool_), 0.0
    for top in found.axes[2][found.axes[2] > bed + 1e-9]:
        free = found.up_to(bed, float(top))
        volume = int(free.sum()) * float(top - bed)
        if volume > largest:
            largest, best, tall = volume, free, float(top) - bed
    return best, tall


def _outline(robot: Robot, found: Reach, free: Mask, bed: float, tall: float) -> tuple[Array, Array]:
    """Return a centre (2,) and the outline (k, 2), m, of places all held from the bed to its height."""
    x, y, _ = found.axes
    step = min(x[1] - x[0], y[1] - y[0])
    rows, columns = np.nonzero(free)
    middles = np.column_stack([0.5 * (x[rows] + x[rows + 1]), 0.5 * (y[columns] + y[columns + 1])])
    centre = middles[np.argmin(np.linalg.norm(middles - middles.mean(axis=0), axis=1))]
    if found.within(np.array([0.0, 0.0, bed])) and np.linalg.norm(centre) < 2.0 * step:
        centre = np.zeros(2)
    radii = np.zeros(CORNERS)
    angles = np.arange(CORNERS) * math.tau / CORNERS
    for k, angle in enumerate(angles):
        along = np.array([math.cos(angle), math.sin(angle)])
        at = centre + np.arange(0.25 * step, float(np.hypot(np.ptp(x), np.ptp(y))), 0.25 * step)[:, None] * along
        i, j = (np.searchsorted(axis, at[:, n]) - 1 for n, axis in enumerate((x, y)))
        inside = (i >= 0) & (i < free.shape[0]) & (j >= 0) & (j < free.shape[1])
        inside[inside] = free[i[inside], j[inside]]
        radii[k] = 0.25 * step * (len(at) if inside.all() else int(np.argmin(inside)))
    model, directions = Model.full(robot), np.stack([np.cos(angles), np.sin(angles)], axis=1)
    for _ in range(_TRIES):  # where corners are cut across cells
        places = centre + radii[:, None] * directions
        levels = [np.column_stack([places, np.full(CORNERS, bed + tall * share)]) for share in (0.0, 0.5, 1.0)]
        lost = ~np.all([held_at(model, level).holds for level in levels], axis=0)
        if not lost.any():
            break
        radii[lost] *= _SHRUNK
    else:
        raise AnswerError(f"robot {robot.name!r}: its reach at the height of a bed, {bed:g} m, has no outline")
    return centre, centre + radii[:, None] * directions


def _acceleration(robot: Robot, bead: Bead, centre: Array, bed: float, tall: float, assumed: Notes) -> float:
    """Return an acceleration, m/s^2, at which the platform swings by `SWING` of a strand's width at most.

    A mass on a spring of natural frequency f is deflected by a / (2 pi f)^2 under the acceleration a.
    """
    if not robot.platform.has_inertia:
        assumed.add(f"acceleration: {Motion().acceleration:g} m/s^2, a job's default: the platform gives no inertia")
        return Motion().acceleration
    model = Model.full(robot)
    places = np.array([[*centre, bed + share * tall] for share in (0.0, 0.5, 1.0)])
    held = held_at(model, places)
    balanced = [held[k] for k in np.flatnonzero(held.holds).tolist()]
    if not balanced:
        raise AnswerError(f"robot {robot.name!r}: no tensions within the limits hold it over the middle of its bed")
    lowest = min(float(np.nanmin(modes(each).frequencies)) for each in balanced)
    found = min(SWING * bead.width * (math.tau * lowest) ** 2, MOST)
    assumed.add(
        f"acceleration: {found:.3g} m/s^2, at which a platform of {lowest:.3g} Hz swings by at most {SWING:g} of a "
        "strand's width"
    )
    return found
