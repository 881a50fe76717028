"""Rows of load cells: the tension of each line that stretches, or the balance of forces of straight lines."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cablewright.calibration.measurements import Measured
from cablewright.calibration.sensors.measurement_kinds import SensorRows
from cablewright.calibration.unknowns import free_directions
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.kernels.fitting import calibration_residuals
from cablewright.models.plane import within
from cablewright.models.rotation import placed
from cablewright.robot import Robot


def require_tensions(robot: Robot, measured: Measured) -> None:
    """Raise `InputError` for straight lines whose ends give, where nothing measured by which forces.

    Lines that stretch count mounts and springs in their equilibria, straight ones to first order by measured tensions.
    """
    for line in robot.lines if measured.tensions is None else ():
        if line.gives_by:
            raise InputError(
                f"{measured.origin}: no column f_1: line {line.name!r} has {line.gives_by}, and straight lines "
                "need measured tensions for its compliance; measure them, or calibrate with --cable "
                "elastic"
            )


def tension_rows(robot: Robot, measured: Measured, sigma: float) -> Iterator[SensorRows]:
    """Yield the rows of the tensions of lines that stretch, one a line."""
    if measured.tensions is not None:
        yield SensorRows(calibration_residuals.TENSION, measured.tensions, 1.0 / sigma, np.arange(robot.m))


def balance_rows(robot: Robot, measured: Measured, sigma: float) -> Iterator[SensorRows]:
    """Yield the rows of measured tensions: the wrench they leave unbalanced, along directions of independent errors.

    A tension's error acts along its line, so the wrench has the covariance sigma^2 sum w w^T, w = pull (u, r x u). The
    directions u are those from the file's exit points to the platform points at the start values of the poses.
    """
    guess, n, plane = measured.guess, robot.n, robot.platform.plane
    if measured.tensions is None:
        return
    if guess is None:
        raise InputError(f"{measured.origin}: tensions f_1.. require columns x,y,z, start values of the poses")
    if np.isnan(guess).any():
        row = measured.place(int(np.argmax(np.isnan(guess).any(axis=1))))
        raise InputError(f"{measured.origin}, {row}: x, y, z are blank; with tensions f_1.. a start value is required")
    guess, free = within(plane, guess), free_directions(robot)
    points = placed(guess, [line.platform_point for line in robot.lines])
    away = points - np.array([line.exit_point for line in robot.lines])
    u = away / np.linalg.norm(away, axis=2)[..., None]
    pull = np.array([line.advantage * line.cables for line in robot.lines])[:, None]
    w = pull * np.concatenate([u, np.cross(points - guess[:, None, :3], u)], axis=2)[..., :n]
    w = w @ free  # a plane carries the rest
    spread = np.einsum("nmi,nmj->nij", w, w)
    size = np.einsum("nii->ni", spread)[:, None] * np.eye(robot.freedoms)  # m and N: small is relative to the same row
    along = np.linalg.inv(np.linalg.cholesky(spread + 1e-6 * size)) / sigma
    extra = np.zeros((len(guess), robot.freedoms, 6))
    extra[..., :n] = along @ free.T
    yield SensorRows(calibration_residuals.BALANCE, np.zeros(extra.shape[:2]), 1.0, extra=extra)


def load_on(robot: Robot) -> Array:
    """Return the load (10,) on the platform: external force (N) and moment (N m), weight (N) and its centre (m)."""
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
