"""What a plan says of the unknowns apart from poses: distances, surveyed points, priors, and what the datum holds."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

import numpy as np

from cablewright.arrays import Array, Mask
from cablewright.calibration.plan import INNER, CalibrationPlan
from cablewright.calibration.unknowns import Unknown
from cablewright.errors import InputError, UnknownName
from cablewright.robot import Robot
from cablewright.robot.parameter_values import AXES


def _index(robot: Robot, name: str, where: str) -> int:
    names = [line.name for line in robot.lines]
    if name not in names:
        raise InputError(f"{where}: {UnknownName('line', name, names)}")
    return names.index(name)


def distances_of(robot: Robot, plan: CalibrationPlan) -> list[tuple[int, int, float, float]]:
    """Of each measured distance the two lines, its value and its standard deviation, m."""
    return [
        (
            _index(robot, each.between[0], f"distances[{at}]"),
            _index(robot, each.between[1], f"distances[{at}]"),
            each.value,
            each.deviation,
        )
        for at, each in enumerate(plan.distances)
    ]


def tilt_rows(robot: Robot, unknowns: Sequence[Unknown]) -> Array:
    """Rows (2, k): the slopes of the plane through all changes of the exit points' heights, about x and about y, rad.

    Heights alone: neither a translation nor a yaw of all points changes them.
    """
    points = np.array([line.exit_point for line in robot.lines])
    arms = (points - points.mean(axis=0))[:, :2]
    slopes = np.linalg.pinv(arms, rcond=1e-6)  # (2, m): d height / dx, d height / dy
    names = [line.name for line in robot.lines]
    rows = np.zeros((2, len(unknowns)))
    for at, unknown in enumerate(unknowns):
        if unknown.name == "exit_point" and unknown.axis == 2:
            i = names.index(unknown.line or names[0])
            rows[:, at] = slopes[1, i], -slopes[0, i]
    return rows


def linear_rows(
    robot: Robot, unknowns: Sequence[Unknown], plan: CalibrationPlan, start: Array
) -> tuple[Array, Array, Mask]:
    """Rows that are linear in the unknowns, weighted, what they should give, and whether they were known before."""
    rows: list[tuple[Array, float, bool]] = []
    for at, point in enumerate(plan.points):
        _index(robot, point.line, f"points[{at}]")
        for axis, value in enumerate(point.at):
            row = _picks(unknowns, "exit_point", point.line, axis)
            if not row.any():
                raise InputError(f"points[{at}]: exit_point is not among the unknowns")
            rows.append((row / point.deviation, value / point.deviation, False))
    if plan.level is not None:
        turns = tilt_rows(robot, unknowns) / plan.level
        rows += [(row, float(row @ start), False) for row in turns]
    for at, prior in enumerate(plan.priors):
        if prior.name not in plan.unknowns:
            raise InputError(f"priors[{at}]: {prior.name} is not among the unknowns")
        for name in prior.lines or ():
            _index(robot, name, f"priors[{at}]")
        for place, unknown in enumerate(unknowns):
            if unknown.name == prior.name and (prior.lines is None or unknown.line in prior.lines):
                weight = unknown.size / prior.deviation
                rows.append((weight * np.eye(len(unknowns))[place], float(weight * start[place]), True))
    if not rows:
        return np.zeros((0, len(unknowns))), np.zeros(0), np.zeros(0, dtype=bool)
    return np.array([row[0] for row in rows]), np.array([row[1] for row in rows]), np.array([row[2] for row in rows])


def _picks(unknowns: Sequence[Unknown], name: str, line: str, axis: int | None) -> Array:
    return np.array([float((each.name, each.line, each.axis) == (name, line, axis)) for each in unknowns])


def held_by_datum(robot: Robot, unknowns: Sequence[Unknown], plan: CalibrationPlan) -> Mask:
    """Which unknowns the datum holds."""
    asked = [part for part in plan.datum if part != INNER]
    if len(asked) < len(plan.datum) and asked:
        raise InputError(f"datum: inner and {asked[0]} contradict each other: inner holds no single point")
    held = np.zeros(len(unknowns), dtype=bool)
    for part in asked:
        line, dot, axis = part.rpartition(".")
        names = [each.name for each in robot.lines]
        if part in names:
            line, axes = part, list(AXES)
        elif dot and line in names and axis in AXES:
            axes = [axis]
        else:
            allowed = chain([INNER], names, (f"{name}.{AXES[0]}" for name in names))
            raise UnknownName("datum", part, list(allowed))
        for each in axes:
            picked = _picks(unknowns, "exit_point", line, AXES.index(each)) > 0.0
            if not picked.any():
                raise InputError(f"datum {part}: exit_point is not among the unknowns")
            if (held & picked).any():
                raise InputError(f"datum: the {each} coordinate of {line} is held twice")
            held |= picked
    return held
