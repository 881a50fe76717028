"""Platforms in a plane: what measurements say of a pose in it, and exit points on the file's side of it.

The unknowns of a pose are those that the plane leaves: 2 of a point, 3 of a body. Of a measured position counts what it
says of them; how far it is off the plane tests the plane alone, and is looked at before any fit.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from cablewright.arrays import Array, Indices
from cablewright.calibration.measured import Measured
from cablewright.calibration.unknowns import Unknown, coordinates_of
from cablewright.errors import InputError
from cablewright.models.plane import basis
from cablewright.models.rotation import turn_between
from cablewright.robot import Robot
from cablewright.robot.plane import OFF_PLANE

SIGMAS_OFF: Final = 5.0
"""How far a measured pose may be off the plane, over its standard deviation there."""

START_OFF: Final = 0.1
"""How far a start value may be off the plane, m, or rotated out of it, rad: it is moved into it."""

_RISING: Final = 0.01  # sine of the slope under which a plane lies
_ON: Final = 1e-6  # m: a line whose ends are as near across the plane runs in it, on no side


def free_directions(robot: Robot) -> Array:
    """Return a basis (n, p) of the directions in which a pose is free, its columns orthonormal."""
    plane = robot.platform.plane
    return np.eye(robot.n) if plane is None else np.ascontiguousarray(basis(plane, robot.n))


def check_plane(robot: Robot, measured: Measured) -> None:
    """Raise `InputError` for a position off the platform's plane, or a rotation out of it, that noise cannot explain.

    Start values, which are no measurements, may be off by `START_OFF`.
    """
    plane = robot.platform.plane
    if plane is None or measured.guess is None:
        return
    known, sigmas = np.asarray(np.isfinite(measured.guess).all(axis=1)), measured.pose_sigma
    guess = np.where(known[:, None], measured.guess, 0.0)
    sigmas = np.full(guess.shape, np.nan) if sigmas is None else sigmas
    normal, (u, v) = np.array(plane.across), basis(plane, 3).T
    off = np.where(known, guess[:, :3] @ normal - plane.distance, 0.0)
    words = f"x, y, z are {{off:.3g}} m off the platform's plane {plane}"
    _refuse_far(measured, off, _deviation(sigmas[:, :3], normal), words, "m")
    if robot.n == 6:
        aside = turn_between(guess[:, 3:] @ np.outer(normal, normal), guess[:, 3:])
        words = f"rx, ry, rz turn {{off:.3g}} rad out of the platform's plane {plane}"
        for way in (u, v):
            _refuse_far(measured, aside @ way, _deviation(sigmas[:, 3:], way), words, "rad")


def _deviation(sigmas: Array, way: Array) -> Array:
    """Return the standard deviation (N,) along a unit vector of three numbers of known *sigmas* (N, 3)."""
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
        where = f"{measured.origin}, {measured.place(row)}"
        raise InputError(f"{where}: {words.format(off=abs(off[row]))}; at most {allowed} is allowed")


def position_rows(robot: Robot, measured: Measured) -> tuple[Array, Array, Array, Array]:
    """Return the rows of measured poses in a plane: values and weights (N, p), vectors (N, p, 6) and others (p,).

    For `kernels.fitting.calibration_residuals.ALONG`. They hold all that three coordinates of different sigmas say of
    the two in the plane: directions of independent errors, and the estimate along each (Gauss, Markov). The rotation is
    that about the normal, in its sigma.
    """
    plane, n = robot.platform.plane, robot.n
    assert plane is not None
    assert measured.guess is not None
    assert measured.pose_sigma is not None
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
    return values, weights * known[:, None], extra, np.array([0, 0, 3])[: robot.freedoms]


def exit_rows(robot: Robot, unknowns: Sequence[Unknown]) -> tuple[Array, Indices]:
    """Return rows (a, k), coordinates of exit points by the unknowns among them, and the line (a,) of each.

    Of a platform in a plane they are those along its axes: what is across hardly matters there.
    """
    which, coordinates = coordinates_of(robot, unknowns)
    plane, own = robot.platform.plane, coordinates // 3
    if plane is None:
        return np.eye(len(unknowns))[which], own
    rows = np.zeros((robot.m, 2, len(unknowns)))
    rows[own, :, which] = basis(plane, 3)[coordinates % 3]
    flat = rows.reshape(-1, len(unknowns))
    kept = np.flatnonzero(flat.any(axis=1))
    return flat[kept], kept // 2


def upwards(robot: Robot) -> Array:
    """Return the unit vector (3,) upwards in the platform's plane, along an axis of one that lies; without one: up."""
    up, plane = np.array([0.0, 0.0, 1.0]), robot.platform.plane
    if plane is None:
        return up
    inside = basis(plane, 3)
    rising = inside @ (inside.T @ up)
    size = float(np.linalg.norm(rising))
    return np.asarray(rising / size if size > _RISING else inside[:, 0])


def on_file_side(robot: Robot, exits: Array, points: Array) -> Array:
    """Return *exits* (m, 3), m, each on the side of the plane through the line's platform point where the file's is.

    Straight lines to a platform in a plane are as long from the mirror image of their exit point. *points*: platform
    points (m, 3), m. Exit points of a robot without a plane stay as they are.
    """
    plane = robot.platform.plane
    if plane is None:
        return exits
    normal = np.array(plane.across)
    file = np.array([np.subtract(line.exit_point, line.platform_point) for line in robot.lines]) @ normal
    now = (exits - points) @ normal
    wanted, found = file - plane.distance, now - plane.distance
    other = (np.abs(wanted) > _ON) & (np.sign(found) == -np.sign(wanted))
    return np.asarray(np.where(other[:, None], exits - 2.0 * found[:, None] * normal, exits))
