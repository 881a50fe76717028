"""Equations of a calibration by load cells: tensions of lines that stretch, or the balance of straight lines."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.calibration.measurement_rows.measurement_kinds import SensorRows, present
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan, Sigmas
from cablewright.calibration.unknowns import Unknown, free_directions, numbers_of_lines
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.kernels.fitting import calibration_lengths, calibration_residuals, line_over_sheave
from cablewright.kernels.fitting.calibration_residuals import MeasurementRows
from cablewright.models.fidelity import CableLaw
from cablewright.models.pack import guided_lines
from cablewright.models.parameters import lines_of
from cablewright.models.plane import within
from cablewright.models.rotation import placed
from cablewright.models.statics import Model
from cablewright.robot import Robot

_UNKNOWN: Final = 1e6  # N: sigma of a blank cell where directions are chosen
_HUNG: Final = 1e-3  # share of a counterweight's tension that is its sigma, beside the friction of the guides


def require_tensions(robot: Robot, measured: Measured) -> None:
    """Raise `InputError` if straight lines have compliant ends and no tensions were measured.

    The equilibria of lines that stretch include mounts and springs. Those of straight lines need measured tensions, by
    which the compliance acts to first order.
    """
    for line in robot.lines if measured.tensions is None else ():
        if line.gives_by:
            raise InputError(
                f"{measured.origin}: no column f_1: line {line.name!r} has {line.gives_by}, and straight lines "
                "need measured tensions for its compliance; measure them, or calibrate with --cable "
                "elastic"
            )


def check_counterweights(model: Model, measured: Measured) -> None:
    """Raise `InputError` for tensions measured in rigid lines with a counterweight, which has that tension."""
    hung = model.robot.hung if model.fidelity.cable is CableLaw.RIGID else ()
    for name, read in (("f", measured.tensions), ("hz", measured.frequencies)):
        for at in hung:
            if read is not None and np.isfinite(read[:, at]).any():
                line = model.robot.lines[at].name
                raise InputError(
                    f"{measured.origin}: {name}_{at + 1}: line {line!r} has a counterweight, whose weight is its "
                    "tension while lines are rigid: leave the cells blank, or use --cable elastic"
                )


def with_counterweights(robot: Robot, measured: Measured, sigma: Sigmas) -> Measured:
    """Return the data whose tensions, if any, are those of the counterweights where a line has one."""
    if measured.tensions is None or not robot.hung:
        return measured
    hung, tensions = list(robot.hung), measured.tensions.copy()
    own = np.full(tensions.shape, np.nan) if measured.tension_sigma is None else measured.tension_sigma.copy()
    for at in hung:
        line = robot.lines[at]
        tensions[:, at] = (line.counterweight or 0.0) * robot.scene.gravity / line.cables
    own[:, hung] = np.hypot(_HUNG, sigma.friction) * tensions[:, hung]
    return replace(measured, tensions=tensions, tension_sigma=own)


def exact_counterweights(robot: Robot, lines: Array, target: NDArray[np.int64], elastic: bool) -> None:
    """Write into *lines* (m, COLUMNS) and *target* that a counterweight's tension in a rigid line has no load cell."""
    hung = [] if elastic else list(robot.hung)
    lines[hung, line_over_sheave.TENSION_SCALE], lines[hung, line_over_sheave.TENSION_OFFSET] = 1.0, 0.0
    target[hung, line_over_sheave.TENSION_SCALE] = target[hung, line_over_sheave.TENSION_OFFSET] = -1


def unseen_lines(robot: Robot, measured: Measured, elastic: bool) -> list[str]:
    """Return the names of the lines that no measurement depends on: rigid ones with a counterweight, without tensions.

    Nothing counts their length. With tensions they act in the balance, by the counterweight instead of a load cell.
    """
    blind = not elastic and measured.tensions is None
    return [robot.lines[at].name for at in robot.hung] if blind else []


def is_unseen(robot: Robot, unknown: Unknown, measured: Measured, plan: CalibrationPlan, elastic: bool) -> bool:
    """Return whether nothing depends on an unknown of lines with a counterweight, or of their load cells."""
    if elastic or unknown.line is None or not (measured.tensions is None or unknown.name.startswith("tension_")):
        return False
    return all(at in robot.hung for at in lines_of(robot, unknown)) and not _is_told(unknown, plan)


def _is_told(unknown: Unknown, plan: CalibrationPlan) -> bool:
    """Return whether the plan itself says something of an exit point: a surveyed point, a distance, or a prior."""
    named = [point.line for point in plan.points] + [line for each in plan.distances for line in each.between]
    told = unknown.line in named or any(each.is_of(unknown) for each in plan.priors)
    return unknown.name == "exit_point" and told


def balanced_readings(robot: Robot, rows: MeasurementRows, lines: Array, tensions: Array, poses: Array) -> Array:
    """Return the load cell readings (N, m), N, that balance the load and differ least from *tensions* (N, m), N.

    *lines* (m, ..): numbers of the lines; *poses* (N, n).
    """
    w, free = np.zeros((len(poses), robot.m, 6)), free_directions(robot)
    calibration_lengths.wrenches_at(rows.guided, lines, np.ascontiguousarray(poses), w)
    u = np.swapaxes(w[..., : robot.n] * lines[:, line_over_sheave.PULL, None] @ free, 1, 2)  # (N, p, m)
    left = wrench_of_load(rows.load, poses) @ free - np.einsum("nam,nm->na", u, tensions)
    scale = lines[:, line_over_sheave.TENSION_SCALE]
    return np.asarray(rows.tensions + np.einsum("nma,na->nm", np.linalg.pinv(u), left) / scale)


def tension_rows(robot: Robot, measured: Measured, sigma: Sigmas) -> Iterator[SensorRows]:
    """Yield the rows of the tensions of lines that stretch, one a line."""
    if measured.tensions is not None:
        spread = _deviations(measured, sigma)
        yield SensorRows(calibration_residuals.TENSION, *present(measured.tensions, spread), np.arange(robot.m))


def _deviations(measured: Measured, sigma: Sigmas) -> Array:
    """Return the standard deviation (N, m) of tensions, N: of the load cell and the friction before it, or its own."""
    assert measured.tensions is not None
    of_cell = np.hypot(sigma.tension, sigma.friction * np.nan_to_num(measured.tensions))
    own = np.nan if measured.tension_sigma is None else measured.tension_sigma
    return np.where(np.isnan(own), of_cell, own)


def balance_rows(robot: Robot, measured: Measured, sigma: Sigmas) -> Iterator[SensorRows]:
    """Yield the rows of measured tensions: the wrench they leave unbalanced, along directions of independent errors.

    A tension's error acts along its line, so the wrench has the covariance sum sigma^2 w w^T, w = pull (u, r x u). The
    directions u are those of the file's lines at the start values of the poses. Along
    the w of a blank cell nothing is known: rows are across those, and as many do not count.
    """
    if measured.tensions is None:
        return
    poses, free = _start_poses(robot, measured), free_directions(robot)
    w = _wrenches(robot, poses)
    blank = np.isnan(measured.tensions)
    spread = np.einsum("nm,nmi,nmj->nij", np.where(blank, 0.0, _deviations(measured, sigma) ** 2), w, w)
    size = np.einsum("nii->ni", spread)[:, None] * np.eye(robot.freedoms)  # m and N: small is relative to the same row
    spread += 1e-6 * size + np.einsum("nm,nmi,nmj->nij", blank * _UNKNOWN**2, w, w)
    along = np.linalg.inv(np.linalg.cholesky(spread))
    extra = np.zeros((len(poses), robot.freedoms, 6))
    extra[..., : robot.n] = along @ free.T
    weights = np.ones(extra.shape[:2])
    if blank.any():
        sizes, ways = np.linalg.eigh(spread)
        known = np.arange(robot.freedoms) < robot.freedoms - blank.sum(axis=1, keepdims=True)  # the least uncertain
        extra[..., : robot.n] = np.swapaxes(ways / np.sqrt(sizes)[:, None], 1, 2) @ free.T
        weights = known.astype(float)
    yield SensorRows(calibration_residuals.BALANCE, np.zeros(extra.shape[:2]), weights, extra=extra)


def _start_poses(robot: Robot, measured: Measured) -> Array:
    """Return poses (N, n) near those of the data. Raises `InputError` for a row without a start value."""
    near = measured.guess if measured.near is None else measured.near
    if near is None:
        raise InputError(f"{measured.origin}: tensions f_1.. require columns x,y,z, start values of the poses")
    if np.isnan(near).any():
        row = measured.place(int(np.argmax(np.isnan(near).any(axis=1))))
        raise InputError(f"{measured.origin}, {row}: x, y, z are blank; with tensions f_1.. a start value is required")
    return within(robot.platform.plane, near)


def _wrenches(robot: Robot, poses: Array) -> Array:
    """Return the wrench (N, m, p) of a tension of 1 N in each line at *poses* (N, n), along the free directions.

    Where no straight cable runs, the line goes from its exit point to its platform point.
    """
    lines, w = numbers_of_lines(robot), np.zeros((len(poses), robot.m, 6))
    calibration_lengths.wrenches_at(guided_lines(robot), lines, np.ascontiguousarray(poses), w)
    points = placed(poses, [line.platform_point for line in robot.lines])
    away = points - np.array([line.exit_point for line in robot.lines])
    u = away / np.linalg.norm(away, axis=2)[..., None]
    direct = np.concatenate([u, np.cross(points - poses[:, None, :3], u)], axis=2)
    w = lines[:, line_over_sheave.PULL, None] * np.where(np.isnan(w), direct, w)
    return np.asarray(w[..., : robot.n] @ free_directions(robot))  # a plane carries the rest


def filled_tensions(robot: Robot, measured: Measured, elastic: bool) -> Array:
    """Return the tensions (N, m), N, with blank cells filled: by the balance of forces, or *elastic*, by the mean."""
    if measured.tensions is None:
        return np.zeros((len(measured.counted), robot.m))
    blank, tensions = np.isnan(measured.tensions), np.nan_to_num(measured.tensions)
    if not blank.any():
        return tensions
    if elastic:
        means = tensions.sum(axis=0) / np.maximum((~blank).sum(axis=0), 1)
        return np.where(blank, np.where(blank.all(axis=0), means.mean(), means), tensions)
    poses = _start_poses(robot, measured)
    w = _wrenches(robot, poses)
    left = wrench_of_load(load_on(robot), poses) @ free_directions(robot) + np.einsum("nmi,nm->ni", w, tensions)
    found = np.einsum("nim,ni->nm", np.linalg.pinv(np.swapaxes(w * blank[..., None], 1, 2)).swapaxes(1, 2), -left)
    return np.where(blank, found, tensions)


def load_on(robot: Robot) -> Array:
    """Return the load on the platform (10,): external force (N) and moment (N m), weight (N) and its centre (m)."""
    platform, load = robot.platform, np.zeros(10)
    load[:3], load[6] = platform.force, platform.mass * robot.scene.gravity
    load[3:6], load[7:] = platform.moment, platform.centre_of_mass
    return load


def wrench_of_load(load: Array, poses: Array) -> Array:
    """Return the wrench (N, n) of a load at *poses* (N, n) about the platform's origin, N and N m."""
    weight = np.array([0.0, 0.0, -load[6]])
    found = np.tile(load[:6], (len(poses), 1))
    found[:, :3] += weight
    found[:, 3:] += np.cross(placed(poses, [load[7:]])[:, 0] - poses[:, :3], weight)
    return found[:, : poses.shape[1]]
