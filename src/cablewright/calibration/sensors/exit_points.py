"""The parts of a plan that belong to no pose: surveyed points, level, priors, and the datum."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import Final

import numpy as np

from cablewright.arrays import Array, Mask
from cablewright.calibration.measured import Measured
from cablewright.calibration.plan import INNER, CalibrationPlan
from cablewright.calibration.unknowns import Unknown, coordinates_of
from cablewright.errors import InputError, UnknownName
from cablewright.robot import Robot
from cablewright.robot.parameter_values import AXES

_YAW: Final = 1e-5  # rad: how well the frame's own yaw is known, where only mounts would tell it


def line_index(robot: Robot, name: str, where: str) -> int:
    """Return the index of a line. Raises `InputError`, which says *where* the plan names it, for an unknown one."""
    names = [line.name for line in robot.lines]
    if name not in names:
        raise InputError(f"{where}: {UnknownName('line', name, names)}")
    return names.index(name)


def tilt_rows(robot: Robot, unknowns: Sequence[Unknown]) -> Array:
    """Return rows (2, k): the slopes of the plane through all height changes of exit points, about x and about y, rad.

    Neither a translation nor a yaw of all points changes them.
    """
    points = np.array([line.exit_point for line in robot.lines])
    arms = (points - points.mean(axis=0))[:, :2]
    slopes = np.linalg.pinv(arms, rcond=1e-6)  # (2, m): d height / dx, d height / dy
    which, coordinates = coordinates_of(robot, unknowns)
    heights = coordinates % 3 == 2
    rows = np.zeros((2, len(unknowns)))
    rows[:, which[heights]] = np.stack([slopes[1], -slopes[0]])[:, coordinates[heights] // 3]
    return rows


def across_rows(robot: Robot, unknowns: Sequence[Unknown]) -> Array:
    """Return rows (m, k): how far each exit point is off the platform's plane, by the unknowns among its coordinates.

    Raises `InputError` for a robot without a plane, and where none is among the unknowns.
    """
    plane = robot.platform.plane
    if plane is None:
        raise InputError(f"across: robot {robot.name!r} has no platform.plane")
    which, coordinates = coordinates_of(robot, unknowns)
    if not len(which):
        raise InputError("across: exit_point is not among the unknowns")
    rows = np.zeros((robot.m, len(unknowns)))
    rows[coordinates // 3, which] = np.array(plane.across)[coordinates % 3]
    return rows


def yaw_row(robot: Robot, unknowns: Sequence[Unknown]) -> Array:
    """Return the row (k,) of how far all exit points together turn about the vertical, rad."""
    points = np.array([line.exit_point for line in robot.lines])
    arms = (points - points.mean(axis=0))[:, :2]
    which, coordinates = coordinates_of(robot, unknowns)
    around = np.column_stack([-arms[:, 1], arms[:, 0], np.zeros(robot.m)]) / np.sum(arms**2)
    row = np.zeros(len(unknowns))
    row[which] = around.ravel()[coordinates]
    return row


def mounts_tell_yaw(robot: Robot, unknowns: Sequence[Unknown], plan: CalibrationPlan, measured: Measured) -> bool:
    """Whether nothing but matrices of mounts tells the yaw: badly, and these are in the frame of the file."""
    if not any(line.mount_gives and not isinstance(line.exit_compliance, float) for line in robot.lines):
        return False
    if plan.points or measured.positioned or robot.platform.plane is not None:
        return False
    told = any(measured.has(each) and f"{each}_offset" not in plan.unknowns for each in ("swivel", "yaw"))
    return not told and sum(each.name == "exit_point" for each in unknowns) == 3 * robot.m


def linear_rows(
    robot: Robot, unknowns: Sequence[Unknown], plan: CalibrationPlan, start: Array, keep_yaw: bool = False
) -> tuple[Array, Array, Mask]:
    """Return weighted rows (q, k) that are linear in the unknowns, their values (q,), and which are prior knowledge.

    *keep_yaw*: whether the exit points together keep the yaw of the file.
    """
    rows: list[Array] = []
    values: list[float] = []
    for at, point in enumerate(plan.points):
        line_index(robot, point.line, f"points[{at}]")
        for axis, value in enumerate(point.at):
            row = _is_exit(unknowns, point.line, axis)
            if not row.any():
                raise InputError(f"points[{at}]: exit_point is not among the unknowns")
            rows.append(row / point.deviation)
            values.append(value / point.deviation)
    if plan.level is not None:
        rows += list(tilt_rows(robot, unknowns) / plan.level)
        values += [float(row @ start) for row in rows[-2:]]
    measured = len(rows)
    for row in [] if plan.across is None else across_rows(robot, unknowns):
        rows.append(row / plan.across)
        values.append(float(rows[-1] @ start))
    if keep_yaw:
        rows.append(yaw_row(robot, unknowns) / _YAW)
        values.append(float(rows[-1] @ start))
    for at, prior in enumerate(plan.priors):
        if prior.name.partition(".")[0] not in plan.unknowns:
            raise InputError(f"priors[{at}]: {prior.name} is not among the unknowns")
        for name in prior.lines or ():
            line_index(robot, name, f"priors[{at}]")
        for place, unknown in enumerate(unknowns):
            if prior.is_of(unknown):
                weight = unknown.size / prior.deviation
                rows.append(weight * np.eye(len(unknowns))[place])
                values.append(float(weight * start[place]))
    return np.array(rows).reshape(len(rows), len(unknowns)), np.array(values), np.arange(len(rows)) >= measured


def _is_exit(unknowns: Sequence[Unknown], line: str, axis: int) -> Mask:
    """Return which of the unknowns is a coordinate of the exit point of a line."""
    return np.array([(each.name, each.line, each.axis) == ("exit_point", line, axis) for each in unknowns], dtype=bool)


def held_by_datum(robot: Robot, unknowns: Sequence[Unknown], plan: CalibrationPlan) -> Mask:
    """Return which unknowns (k,) the datum holds. Raises `InputError` for a contradictory or unknown datum."""
    parts = [part for part in plan.datum if part != INNER]
    if len(parts) < len(plan.datum) and parts:
        raise InputError(f"datum: inner and {parts[0]} contradict each other: inner holds no single point")
    held, names = np.zeros(len(unknowns), dtype=bool), [each.name for each in robot.lines]
    for part in parts:
        line, dot, axis = part.rpartition(".")
        if part in names:
            line, axes = part, list(AXES)
        elif dot and line in names and axis in AXES:
            axes = [axis]
        else:
            allowed = chain([INNER], names, (f"{name}.{AXES[0]}" for name in names))
            raise UnknownName("datum", part, list(allowed))
        for each in axes:
            picked = _is_exit(unknowns, line, AXES.index(each))
            if not picked.any():
                raise InputError(f"datum {part}: exit_point is not among the unknowns")
            if (held & picked).any():
                raise InputError(f"datum: the {each} coordinate of {line} is held twice")
            held |= picked
    return held
