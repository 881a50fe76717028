"""Batches of rotation vectors (rad): matrices, rotated points, shortest equivalents, rotations between two; and angles.

`matrix_of` and `motion_between` are of one alone, for loops of control: they take a tenth of the time.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from cablewright.foundation.arrays import Array
from cablewright.kernels import Direct
from cablewright.kernels.rotation import compose, matrix
from cablewright.kernels.statics.platform import between

_MATRIX: Final = Direct(matrix)
_COMPOSE: Final = Direct(compose)
_BETWEEN: Final = Direct(between)


def matrices(vectors: ArrayLike) -> Array:
    """Return matrices (..., 3, 3) of rotation *vectors* (..., 3), rad (Rodrigues)."""
    vectors = np.asarray(vectors, dtype=np.float64)
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(*x.shape, 3, 3)
    half = 0.5 * np.sinc(0.5 * angle / np.pi)
    return np.asarray(np.eye(3) + np.sinc(angle / np.pi) * cross + 2.0 * half * half * (cross @ cross))


def matrix_of(vector: Array) -> Array:
    """Return the matrix (3, 3) of one rotation *vector* (3,), rad."""
    found = np.empty((3, 3))
    _MATRIX.call(np.array(vector, dtype=np.float64), found)  # a copy, as the kernel's one signature wants it
    return found


def motion_between(start: Array, end: Array) -> Array:
    """Return the translation, m, and the rotation in space, rad, (6,), that move pose *start* (6,) to *end*."""
    found = np.empty(6)
    own = np.array(start, dtype=np.float64), np.array(end, dtype=np.float64)  # copies, as its one signature wants them
    _BETWEEN.call(*own, found)
    return found


def moved(pose: Array, motion: Array) -> Array:
    """Return the pose (n,) to which a translation, m, and a rotation in space, rad, (n,), move *pose* (n,)."""
    found = np.asarray(pose + motion, dtype=np.float64)
    if len(found) == 3:
        return np.asarray(found)
    found[3:] = pose[3:]
    _COMPOSE.call(*map(float, motion[3:]), found[3:])
    return found


def rotations(poses: Array) -> Array:
    """Return the rotation vectors (..., 3), rad, of *poses* (..., n): 0 of a point."""
    return poses[..., 3:] if poses.shape[-1] == 6 else np.zeros_like(poses)


def placed(poses: Array, points: ArrayLike) -> Array:
    """Return *points* (..., m, 3), m, of the platform frame in world coordinates, at *poses* (..., n)."""
    arms = np.asarray(points, dtype=np.float64)
    if poses.shape[-1] == 6:
        arms = arms @ np.swapaxes(matrices(poses[..., 3:]), -1, -2)
    return np.asarray(poses[..., None, :3] + arms)


def yawed(poses: Array, angle: float, about: Array, axis: ArrayLike = (0.0, 0.0, 1.0)) -> Array:
    """Return the *poses* (N, n) turned by *angle*, rad, about the point *about* (3,), m, and *axis*: the vertical."""
    found, turn = poses.copy(), angle * np.asarray(axis, dtype=np.float64)
    found[:, :3] = (poses[:, :3] - about) @ matrices(turn).T + about
    if poses.shape[1] == 6:
        found[:, 3:] = turn_between(-poses[:, 3:], np.tile(turn, (len(poses), 1)))
    return found


def shortest(vectors: Array) -> Array:
    """Return the rotation vectors (..., 3) of length at most pi with the same rotations as *vectors*."""
    angle = np.linalg.norm(vectors, axis=-1, keepdims=True)
    turns = np.round(angle / (2.0 * np.pi))
    return np.where(angle > np.pi, vectors * (1.0 - 2.0 * np.pi * turns / np.where(angle > 0.0, angle, 1.0)), vectors)


def wrap_angle(angle: float) -> float:
    """Return an *angle*, rad, within half a turn of 0."""
    return math.remainder(angle, math.tau)


def wrap_angles(angles: Array) -> Array:
    """Return *angles*, rad, within half a turn of 0."""
    return np.asarray(np.remainder(angles + math.pi, math.tau) - math.pi)


def angle_between(first: ArrayLike, second: ArrayLike) -> Array:
    """Return the angle (...), rad, of the rotation from *first* to *second*, rotation vectors (..., 3)."""
    return _sine_and_angle(np.swapaxes(matrices(first), -1, -2) @ matrices(second))[1][..., 0]


def turn_between(first: ArrayLike, second: ArrayLike) -> Array:
    """Return the rotation vector (..., 3), rad, world, from *first* to *second*, rotation vectors (..., 3)."""
    axis, angle = _sine_and_angle(matrices(second) @ np.swapaxes(matrices(first), -1, -2))
    sine = np.linalg.norm(axis, axis=-1, keepdims=True)
    return np.asarray(axis * np.where(sine > 0.0, angle / np.where(sine > 0.0, sine, 1.0), 1.0))


def rotation_onto(points: Array, others: Array) -> Array:
    """Return the rotation (3, 3), about the means, that best moves *points* (k, 3) onto *others* (k, 3) (Kabsch)."""
    left, _, right = np.linalg.svd((points - points.mean(axis=0)).T @ (others - others.mean(axis=0)))
    return np.asarray(right.T @ np.diag([1.0, 1.0, np.sign(np.linalg.det(right.T @ left.T))]) @ left.T)


def _sine_and_angle(rotation: Array) -> tuple[Array, Array]:
    """Return the axis times the sine of the angle (..., 3), and the angle (..., 1), rad, of *rotation* (..., 3, 3)."""
    skew = 0.5 * (rotation - np.swapaxes(rotation, -1, -2))
    axis = np.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], axis=-1)
    cosine = 0.5 * (np.trace(rotation, axis1=-2, axis2=-1)[..., None] - 1.0)
    return axis, np.arctan2(np.linalg.norm(axis, axis=-1, keepdims=True), cosine)
