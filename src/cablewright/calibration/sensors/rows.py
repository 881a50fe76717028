"""The rows of each sensor of a calibration: encoders, load cells, measured poses, angles, planes and ranges."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cablewright.arrays import Array
from cablewright.calibration.measured import Measured
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.sensors.exit_points import line_index
from cablewright.calibration.sensors.positions import free_directions, position_rows
from cablewright.errors import InputError
from cablewright.kernels.fitting import calibration_residuals
from cablewright.models.plane import within
from cablewright.models.rotation import placed
from cablewright.robot import RigidPlatform, Robot, Swivel
from cablewright.robot.direction import unit_vector

ENCODER_SIGMA: Final = 1e-4
"""Default standard deviation of the encoders, m, which weighs them against other sensors."""

_OF_A_BODY: Final = (
    ("tilt", "tilt_x, tilt_y", calibration_residuals.TILT),
    ("yaw", "yaw", calibration_residuals.YAW),
)
"""Sensors of a rigid platform: the field of what they measured, the columns, and the kind of their rows."""


class SensorRows(NamedTuple):
    """Rows of one sensor, r at each of N poses; what is not an array is the same in all rows, see `MeasurementRows`."""

    kind: int
    values: Array  # (N, r)
    weights: Array | float
    line: ArrayLike = 0
    other: ArrayLike = 0
    extra: ArrayLike = 0


def distance_rows(robot: Robot, plan: CalibrationPlan) -> SensorRows:
    """Return the rows (1, d) of measured distances between exit points, which belong to no pose."""
    ends = [
        line_index(robot, name, f"distances[{at}]") for at, each in enumerate(plan.distances) for name in each.between
    ]
    values, sigmas = (np.array([[getattr(each, name) for each in plan.distances]]) for name in ("value", "deviation"))
    return SensorRows(calibration_residuals.BETWEEN, values, 1.0 / sigmas, ends[::2], ends[1::2])


def sensor_rows(robot: Robot, measured: Measured, plan: CalibrationPlan, elastic: bool) -> Iterator[SensorRows]:
    """Yield the rows of each sensor that the data have: encoders first, then tensions if each is a row of its own."""
    sigma, lines = plan.sigma, np.arange(robot.m)
    encoder = calibration_residuals.PAID_OUT if elastic else calibration_residuals.ENCODER
    yield SensorRows(encoder, measured.counted, 1.0 / (sigma.encoder or ENCODER_SIGMA), lines)
    if elastic and measured.tensions is not None:
        yield SensorRows(calibration_residuals.TENSION, measured.tensions, 1.0 / sigma.tension, lines)
    if measured.pose_sigma is not None:
        yield _positions(robot, measured)
    if measured.swivel is not None:
        _require_azimuths(robot, measured)
        yield SensorRows(calibration_residuals.SWIVEL, measured.swivel, 1.0 / sigma.swivel, lines)
    for name, columns, kind in _OF_A_BODY:
        values = getattr(measured, name)
        if values is None:
            continue
        if robot.n == 3:
            raise InputError(f"{measured.origin}: {columns}: {robot.name!r} is a point platform, which has no {name}")
        yield SensorRows(kind, values, 1.0 / getattr(sigma, name), other=np.arange(values.shape[1]))
    if not elastic and measured.tensions is not None:
        yield _balance(robot, measured, sigma.tension)
    nozzle = robot.platform.nozzle if isinstance(robot.platform, RigidPlatform) else robot.lines[0].platform_point
    for index, plane in enumerate(plan.planes):
        at = _at_poses(measured, plane.poses, f"planes[{index}]")
        normal = np.asarray(plane.normal) / math.hypot(*plane.normal)
        weights = at[:, None] / plane.deviation
        values = np.full(weights.shape, float(normal @ plane.point))
        yield SensorRows(calibration_residuals.PLANE, values, weights, extra=np.append(normal, nozzle))
    for index, reach in enumerate(plan.ranges):
        at = _at_poses(measured, reach.poses, f"ranges[{index}]")
        values = np.zeros((len(at), 1))
        values[np.asarray(reach.poses) - 1, 0] = reach.values
        yield SensorRows(
            calibration_residuals.REACH, values, at[:, None] / reach.deviation, extra=np.append(reach.point, nozzle)
        )


def _positions(robot: Robot, measured: Measured) -> SensorRows:
    """Return the rows of measured poses, with weight 0 where they are blank."""
    assert measured.guess is not None
    assert measured.pose_sigma is not None
    if robot.platform.plane is not None:
        values, weights, along, other = position_rows(robot, measured)
        return SensorRows(calibration_residuals.ALONG, values, weights, other=other, extra=along)
    places = np.nan_to_num(measured.guess)
    extra = np.zeros((*places.shape, 6))
    if robot.n == 6:
        extra[:, 3:, :3] = places[:, None, 3:]
    weights = np.nan_to_num(1.0 / measured.pose_sigma)
    return SensorRows(calibration_residuals.COORDINATE, places, weights, other=np.arange(robot.n), extra=extra)


def _require_azimuths(robot: Robot, measured: Measured) -> None:
    """Raise `InputError` for a swivel whose angle is no azimuth, or not that from where its exit is without load."""
    for index, line in enumerate(robot.lines):
        if isinstance(line.sheave, Swivel) and abs(unit_vector(line.sheave.axis)[2]) < 1.0:
            raise InputError(
                f"{measured.origin}: swivel_{index + 1}: line {line.name!r} has an axis that is not vertical, so the "
                "angle is no azimuth; leave these columns out"
            )
        if line.mount_out_of_plane_by:
            raise InputError(
                f"{measured.origin}: swivel_{index + 1}: line {line.name!r} has {line.mount_out_of_plane_by}, which "
                "turns its azimuth by as much as it goes aside; leave these columns out"
            )


def _at_poses(measured: Measured, poses: Sequence[int], where: str) -> Array:
    """Return 1 at each of the poses (counted from 1), 0 at the others, (N,)."""
    if max(poses) > len(measured.counted):
        raise InputError(f"{where}.poses: there is no pose {max(poses)}; the data have {len(measured.counted)}")
    at = np.zeros(len(measured.counted))
    at[np.asarray(poses) - 1] = 1.0
    return at


def _balance(robot: Robot, measured: Measured, sigma: float) -> SensorRows:
    """Return the rows of measured tensions: the wrench they leave unbalanced, along directions of independent errors.

    A tension's error acts along its line, so the wrench has the covariance sigma^2 sum w w^T, w = pull (u, r x u). The
    directions u are those from the file's exit points to the platform points at the start values of the poses.
    """
    guess, count, n = measured.guess, len(measured.counted), robot.n
    free = free_directions(robot)
    if guess is None:
        raise InputError(f"{measured.origin}: tensions f_1.. require columns x,y,z, start values of the poses")
    if np.isnan(guess).any():
        row = measured.place(int(np.argmax(np.isnan(guess).any(axis=1))))
        raise InputError(f"{measured.origin}, {row}: x, y, z are blank; with tensions f_1.. a start value is required")
    guess = within(robot.platform.plane, guess)
    points = placed(guess, [line.platform_point for line in robot.lines])
    away = points - np.array([line.exit_point for line in robot.lines])
    u = away / np.linalg.norm(away, axis=2)[..., None]
    pull = np.array([line.advantage * line.cables for line in robot.lines])[:, None]
    w = pull * np.concatenate([u, np.cross(points - guess[:, None, :3], u)], axis=2)[..., :n]
    w = w if robot.platform.plane is None else w @ free  # the plane carries the rest
    spread = np.einsum("nmi,nmj->nij", w, w)
    size = np.einsum("nii->ni", spread)[:, None] * np.eye(robot.freedoms)  # m and N: small is relative to the same row
    along = np.linalg.inv(np.linalg.cholesky(spread + 1e-6 * size)) / sigma
    extra = np.zeros((count, robot.freedoms, 6))
    extra[..., :n] = along if robot.platform.plane is None else along @ free.T
    return SensorRows(calibration_residuals.BALANCE, np.zeros(extra.shape[:2]), 1.0, extra=extra)


def load_on(robot: Robot) -> Array:
    """Return the load (10,) on the platform: external force (N) and moment (N m), weight (N) and its centre (m)."""
    platform, load = robot.platform, np.zeros(10)
    load[:3], load[6] = platform.force, platform.mass * robot.scene.gravity
    if isinstance(platform, RigidPlatform):
        load[3:6], load[7:] = platform.moment, platform.centre_of_mass
    return load
