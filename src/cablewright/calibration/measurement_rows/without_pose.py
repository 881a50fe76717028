"""Equations of a calibration plan apart from poses: surveyed exit points, distances, level, priors, and the datum."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import Final

import numpy as np

from cablewright.calibration.measurement_rows.measurement_kinds import SensorRows
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import INNER, CalibrationPlan
from cablewright.calibration.unknowns import Unknown, by_exits, line_index
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.kernels.fitting import calibration_residuals
from cablewright.robot import Robot
from cablewright.robot.parameter_values import AXES

_YAW: Final = 1e-5  # rad: how well the frame's own yaw is known, where only mounts would determine it


def distance_rows(robot: Robot, plan: CalibrationPlan) -> SensorRows:
    """Return the rows (1, d) of measured distances between exit points, which belong to no pose."""
    ends = [
        line_index(robot, name, f"distances[{at}]") for at, each in enumerate(plan.distances) for name in each.between
    ]
    values, sigmas = (np.array([[getattr(each, name) for each in plan.distances]]) for name in ("value", "deviation"))
    return SensorRows(calibration_residuals.BETWEEN, values, 1.0 / sigmas, ends[::2], ends[1::2])


def tilt_rows(robot: Robot, unknowns: Sequence[Unknown]) -> Array:
    """Return rows (2, k): the slopes of the plane through all height changes of exit points, about x and about y, rad.

    Neither a translation nor a yaw of all points changes them.
    """
    slopes = np.linalg.pinv(_arms(robot), rcond=1e-6)  # (2, m): d height / dx, d height / dy
    return by_exits(robot, unknowns, np.kron([slopes[1], -slopes[0]], np.eye(3)[2]))


def across_rows(robot: Robot, unknowns: Sequence[Unknown]) -> Array:
    """Return rows (m, k): the distance of each exit point from the platform's plane, by its unknown coordinates.

    Raises `InputError` for a robot without a plane, and where none is among the unknowns.
    """
    plane = robot.platform.plane
    if plane is None:
        raise InputError(f"across: robot {robot.name!r} has no platform.plane")
    if all(each.name != "exit_point" for each in unknowns):
        raise InputError(
            "across: is for exit points beside the plane; add exit_point to the unknowns, or leave out across"
        )
    return by_exits(robot, unknowns, np.kron(np.eye(robot.m), plane.across))


def _yaw_row(robot: Robot, unknowns: Sequence[Unknown]) -> Array:
    """Return the row (1, k) of how far all exit points together turn about the vertical, rad."""
    arms = _arms(robot)
    around = np.column_stack([-arms[:, 1], arms[:, 0], np.zeros(robot.m)]) / np.sum(arms**2)
    return by_exits(robot, unknowns, around.reshape(1, -1))


def _arms(robot: Robot) -> Array:
    """Return x and y (m, 2) of the file's exit points from their mean, m."""
    points = np.array([line.exit_point for line in robot.lines])
    return np.asarray((points - points.mean(axis=0))[:, :2])


def mounts_tell_yaw(robot: Robot, unknowns: Sequence[Unknown], plan: CalibrationPlan, measured: Measured) -> bool:
    """Return whether the yaw is determined by nothing but the matrices of compliant mounts, and so badly."""
    if not any(line.mount_gives and not isinstance(line.exit_compliance, float) for line in robot.lines):
        return False
    if plan.points or measured.positioned or robot.platform.plane is not None:
        return False
    told = any(measured.has(each) and f"{each}_offset" not in plan.unknowns for each in ("swivel", "yaw"))
    return not told and sum(each.name == "exit_point" for each in unknowns) == 3 * robot.m


def linear_rows(
    robot: Robot,
    unknowns: Sequence[Unknown],
    plan: CalibrationPlan,
    start: Array,
    keep_yaw: bool,
    more: tuple[Array, Array],
) -> tuple[Array, Array, Mask]:
    """Return weighted equations (q, k) linear in the unknowns, their values (q,), and which are prior knowledge.

    *keep_yaw*: whether the exit points together keep the yaw of the file. *more*: further such rows and values.
    """
    surveyed, values = [np.zeros((0, len(unknowns)))], list[float]()
    for at, point in enumerate(plan.points):
        line_index(robot, point.line, f"points[{at}]")
        row = np.array([_is_exit(unknowns, point.line, axis) for axis in range(3)])
        if not row.any(axis=1).all():
            raise InputError(f"points[{at}]: exit_point is not among the unknowns")
        surveyed.append(row / point.deviation)
        values += [value / point.deviation for value in point.at]
    level = [] if plan.level is None else [tilt_rows(robot, unknowns) / plan.level]
    prior = [] if plan.across is None else [across_rows(robot, unknowns) / plan.across]
    if keep_yaw:
        prior.append(_yaw_row(robot, unknowns) / _YAW)
    given: list[Array] = []
    for at, each in enumerate(plan.priors):
        if each.name.partition(".")[0] not in plan.unknowns:
            raise InputError(f"priors[{at}]: {each.name} is not among the unknowns")
        for name in each.lines or ():
            line_index(robot, name, f"priors[{at}]")
        weights = np.array([each.is_of(unknown) * unknown.size / each.deviation for unknown in unknowns])
        own = np.diag(weights)[np.flatnonzero(weights)]
        axes = [unknown.axis for unknown in unknowns if each.is_of(unknown)]
        if len(axes) <= each.alike * len(set(axes)):
            why = "`alike` requires at least two numbers" if axes else "none of the unknowns is of these lines"
            raise InputError(f"priors[{at}]: {each.name}: {why}")
        for axis in set(axes) if each.alike else ():
            same = [one == axis for one in axes]
            own[same] -= own[same].mean(axis=0)
        if each.tilted:
            own -= own @ _tilts(robot, unknowns)
        prior.append(own)
        given.append(own @ start if each.value is None else np.full(len(own), each.value / each.deviation))
    rows, measured = np.concatenate([*surveyed, *level, *prior]), 3 * len(plan.points) + 2 * len(level)
    before = rows[len(values) : len(rows) - sum(map(len, given))] @ start
    rows = np.concatenate([rows, more[0]])
    return rows, np.concatenate([values, before, *given, more[1]]), np.arange(len(rows)) >= measured


def _tilts(robot: Robot, unknowns: Sequence[Unknown]) -> Array:
    """Return the projection (k, k) of changes of the unknowns on tilts of all exit points as one body."""
    points = np.array([line.exit_point for line in robot.lines])
    turns = [np.cross(axis, points - points.mean(axis=0)).ravel() for axis in np.eye(3)[:2]]
    span, sizes, _ = np.linalg.svd(by_exits(robot, unknowns, turns).T, full_matrices=False)
    span = span[:, sizes > 1e-9 * max(sizes.max(), 1e-300)]  # exit points on a line do not turn about it
    return np.asarray(span @ span.T)


def _is_exit(unknowns: Sequence[Unknown], line: str, axis: int) -> Mask:
    """Return which of the unknowns is a coordinate of the exit point of a line."""
    return np.array([(each.name, each.line, each.axis) == ("exit_point", line, axis) for each in unknowns], dtype=bool)


def held_by_datum(robot: Robot, unknowns: Sequence[Unknown], plan: CalibrationPlan) -> Mask:
    """Return which unknowns (k,) the datum of the plan fixes.

    Raises `InputError` for a contradictory or unknown datum.
    """
    parts = [part for part in plan.datum if part != INNER]
    if len(parts) < len(plan.datum) and parts:
        raise InputError(f"datum: inner and {parts[0]} contradict each other: inner holds no single point")
    held, names = np.zeros(len(unknowns), dtype=bool), [each.name for each in robot.lines]
    for part in parts:
        line, axes = part, list(AXES)
        if part not in names:
            line, _, axis = part.rpartition(".")
            axes = [axis]
        if line not in names or axes[0] not in AXES:
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
