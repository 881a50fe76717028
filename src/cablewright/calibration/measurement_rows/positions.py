"""Calibration equations of measured poses, and a check that they lie in the platform's plane, if it has one.

The unknowns of a pose are those that the plane leaves: 2 of a point, 3 of a body. Of a measured position these
components count; its distance from the plane tests the plane alone, before any fit.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from cablewright.calibration.measurement_rows.measurement_kinds import SensorRows
from cablewright.calibration.measurements import Measured
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.kernels.fitting import calibration_residuals
from cablewright.models.plane import basis
from cablewright.models.rotation import rotations, turn_between
from cablewright.robot import Robot
from cablewright.robot.plane import OFF_PLANE

SIGMAS_OFF: Final = 5.0
"""How far a measured pose may be off the plane, over its standard deviation there."""

START_OFF: Final = 0.1
"""How far a start value may be off the plane, m, or rotated out of it, rad: it is moved into it."""


def check_plane(robot: Robot, measured: Measured) -> None:
    """Raise `InputError` for a position off the platform's plane, or a rotation out of it, that noise cannot explain.

    Start values, which are no measurements, may have errors up to `START_OFF`.
    """
    plane = robot.platform.plane
    if plane is None or measured.guess is None:
        return
    known = np.asarray(np.isfinite(measured.guess).all(axis=1))
    guess = np.where(known[:, None], measured.guess, 0.0)
    sigmas = np.full(guess.shape, np.nan) if measured.pose_sigma is None else measured.pose_sigma
    normal = np.array(plane.across)
    off = np.where(known, guess[:, :3] @ normal - plane.distance, 0.0)
    words = f"x, y, z are {{off:.3g}} m off the platform's plane {plane}"
    _refuse_far(measured, off, _deviation(sigmas[:, :3], normal), words, "m")
    if robot.n == 6:
        aside = turn_between(guess[:, 3:] @ np.outer(normal, normal), guess[:, 3:])
        words = f"rx, ry, rz turn {{off:.3g}} rad out of the platform's plane {plane}"
        for way in basis(plane, 3).T:
            _refuse_far(measured, aside @ way, _deviation(sigmas[:, 3:], way), words, "rad")


def _deviation(sigmas: Array, way: Array) -> Array:
    """Return the standard deviation (N,) along the unit vector *way* (3,), from *sigmas* (N, 3) along the axes."""
    return np.asarray(np.sqrt(sigmas**2 @ way**2))


def _refuse_far(measured: Measured, off: Array, sigma: Array, words: str, unit: str) -> None:
    """Raise `InputError` for the first pose that is too far *off* (N,), by its *sigma* (N,), NaN of a start value."""
    start = np.isnan(sigma)
    limit = np.where(start, START_OFF, SIGMAS_OFF * np.nan_to_num(sigma)) + OFF_PLANE
    far = np.flatnonzero(np.abs(off) > limit)
    if len(far):
        row = int(far[0])
        allowed = f"{START_OFF:g} {unit} of a start value"
        if not start[row]:
            allowed = f"{SIGMAS_OFF:g} times their sigma of {sigma[row]:.3g} {unit}"
        raise InputError(
            f"{measured.origin}, {measured.place(row)}: {words.format(off=abs(off[row]))}; at most {allowed} is allowed"
        )


def position_rows(robot: Robot, measured: Measured) -> Iterator[SensorRows]:
    """Yield the equations of measured poses, if any, with weight 0 where they are blank.

    In a plane they combine three coordinates of different sigmas to the two in the plane: directions of independent
    errors, and the estimate along each (Gauss, Markov). The rotation is that about the normal, in its sigma.
    """
    plane, n = robot.platform.plane, robot.n
    if measured.pose_sigma is None or measured.guess is None:
        return
    if plane is None:
        places = np.nan_to_num(measured.guess)
        extra = np.zeros((*places.shape, 6))
        extra[:, 3:, :3] = rotations(places)[:, None]
        weights = np.nan_to_num(1.0 / measured.pose_sigma)
        yield SensorRows(calibration_residuals.COORDINATE, places, weights, other=np.arange(n), extra=extra)
        return
    known = np.asarray(np.isfinite(measured.pose_sigma).all(axis=1))
    guess = np.where(known[:, None], measured.guess, 0.0)
    sigmas = np.where(known[:, None], measured.pose_sigma, 1.0)
    inside, normal = basis(plane, 3), np.array(plane.across)
    by_place = inside.T / (sigmas[:, None, :3] ** 2)  # (N, 2, 3)
    sizes, turned = np.linalg.eigh(by_place @ inside)
    place = np.linalg.solve(by_place @ inside, by_place @ (guess[:, :3] - plane.distance * normal)[..., None])
    across = np.swapaxes(turned, 1, 2)
    extra = np.zeros((len(guess), robot.freedoms, 6))
    values, weights = np.zeros(extra.shape[:2]), np.zeros(extra.shape[:2])
    extra[:, :2, :3], values[:, :2], weights[:, :2] = across @ inside.T, (across @ place)[..., 0], np.sqrt(sizes)
    if n == 6:
        extra[:, 2, :3], extra[:, 2, 3:] = normal, (guess[:, 3:] @ normal)[:, None] * normal
        weights[:, 2] = 1.0 / _deviation(sigmas[:, 3:], normal)
    other = np.array([0, 0, 3])[: robot.freedoms]
    yield SensorRows(calibration_residuals.ALONG, values, weights * known[:, None], other=other, extra=extra)
