"""Bounds of each unknown of a calibration: physical limits, and near the robot file unless the plan says otherwise."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.sightings.sighted import SightedUnknown
from cablewright.calibration.unknowns import Unknown, line_index
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError
from cablewright.models.parameters import lines_of
from cablewright.robot import Robot
from cablewright.robot.mount import MOST
from cablewright.robot.winch import MAX_BUILD_UP

SHARES: Final = {
    "length_scale": (0.9, 1.1),
    "drum_radius": (0.9, 1.1),
    "sheave_radius": (0.5, 2.0),
    "modulus": (0.1, 10.0),
    "tension_scale": (0.5, 2.0),
}
"""Min and max of each of these unknowns, over its value in the robot file, or over 1."""

OF_NOTHING: Final = {
    "build_up": (0.0, 0.2),  # 1/m: cable wound on a spool makes it thicker, never thinner
    "exit_compliance": (0.0, 1e-3),  # m/N: a softer mount bends in the hand
}
"""Min and max of unknowns that most robot files leave out. If a file has more compliance, the max is twice that."""

AWAY: Final = 3.0  # frame diagonals: max distance of a coordinate from the file's, and a third of the longest line
AZIMUTH: Final = 2.0 * math.pi  # rad: the zero of a sensor of azimuths may be anywhere
TILT: Final = 0.3  # rad: a tilt error as large is of a sensor mounted the wrong way
_AT: Final = 1e-9  # of the range: nearer than this is at the bound


def ranges(robot: Robot, unknowns: Sequence[Unknown], plan: CalibrationPlan, start: Array, measured: Measured) -> Array:
    """Return the min and max (2, k) of each unknown, over its scale.

    The offset of a load cell is at most its largest reading, or the line's max tension where that is more: one that was
    set to zero under a load reads the rest. The length paid out, offset plus count, is positive at every pose. Raises
    `InputError` for bounds in the plan that are not of an unknown, or that exclude the file's value or that of a prior.
    """
    diagonal = math.dist(robot.scene.frame_min, robot.scene.frame_max)
    found = np.zeros((2, len(unknowns)))
    for at, each in enumerate(unknowns):
        if isinstance(each, SightedUnknown):
            found[:, at] = each.low, each.high
        elif each.name in SHARES:
            found[:, at] = np.array(SHARES[each.name]) * start[at]
        elif each.name in OF_NOTHING:
            low, high = OF_NOTHING[each.name]
            most = MAX_BUILD_UP if each.name == "build_up" else MOST
            found[:, at] = low / each.size, max(high / each.size, min(2.0 * start[at], most / each.size))
        elif each.name == "length_offset":
            most = max(robot.lines[i].advantage for i in lines_of(robot, each))  # cable beyond the exit point
            found[:, at] = -measured.counted[:, lines_of(robot, each)].min(), 3.0 * AWAY * diagonal * most
        elif each.entry.role == "sensor":
            found[:, at] = np.array([-1.0, 1.0]) * _largest(robot, each, measured)
        else:
            found[:, at] = start[at] - AWAY * diagonal, start[at] + AWAY * diagonal
    _bound(found, robot, unknowns, plan, start)
    for index, prior in enumerate(plan.priors):
        for at, each in enumerate(unknowns):
            value = None if prior.value is None or not prior.is_of(each) else prior.value / each.size
            if value is not None and not found[0, at] <= value <= found[1, at]:
                low, high = found[:, at] * each.size
                unit = "" if each.unit == "1" else f" {each.unit}"
                raise InputError(
                    f"priors[{index}]: value = {prior.value:g} of {each.label} is out of its range, {low:.4g} to "
                    f"{high:.4g}{unit}; change it or give bounds"
                )
    return found


def _bound(found: Array, robot: Robot, unknowns: Sequence[Unknown], plan: CalibrationPlan, start: Array) -> None:
    """Write the bounds of the plan to the *found* ones, (2, k). Raises `InputError` as `ranges`."""
    for index, bound in enumerate(plan.bounds):
        where = f"bounds[{index}]"
        if bound.name not in plan.unknowns:
            raise InputError(f"{where}: {bound.name} is not among the unknowns")
        for name in bound.lines or ():
            line_index(robot, name, where)
        for at, each in enumerate(unknowns):
            if each.name == bound.name and (bound.lines is None or any(each.of_line(line) for line in bound.lines)):
                found[:, at] = bound.min / each.size, bound.max / each.size
                told = any(prior.is_of(each) and prior.value is not None for prior in plan.priors)
                if each.in_file and not told and not found[0, at] <= start[at] <= found[1, at]:
                    raise InputError(
                        f"{where}: {each.label} is {start[at] * each.size:g} in the file, out of the bounds"
                    )


def _largest(robot: Robot, unknown: Unknown, measured: Measured) -> float:
    """Return how large the offset of a sensor may be, SI."""
    if unknown.name != "tension_offset":
        return TILT if unknown.name == "tilt_offset" else AZIMUTH
    if measured.tensions is None:
        return 0.0
    of = lines_of(robot, unknown)
    return max(
        float(np.abs(np.nan_to_num(measured.tensions[:, of])).max()), *(robot.lines[i].tension_limits[1] for i in of)
    )


def at_bound(values: Array, limits: Array, start: Array) -> tuple[Mask, Mask]:
    """Return which *values* (k,) are at the min, and which at the max, of *limits* (2, k).

    A value at a limit does not count if the robot file has it there too, in *start* (k,), as a build-up of 0. NaN in
    *start*: the file has no value.
    """
    room = _AT * np.maximum(limits[1] - limits[0], 1e-300)
    at_start = np.abs(start - limits) <= room
    return (values <= limits[0] + room) & ~at_start[0], (values >= limits[1] - room) & ~at_start[1]
