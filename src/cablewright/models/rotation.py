"""Rotation vectors (rad) in batches: matrices, points that turn with them, the shortest that means the same."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cablewright.arrays import Array


def matrices(vectors: ArrayLike) -> Array:
    """Matrices (..., 3, 3) of rotation *vectors* (..., 3), rad (Rodrigues)."""
    vectors = np.asarray(vectors, dtype=np.float64)
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(*x.shape, 3, 3)
    half = 0.5 * np.sinc(0.5 * angle / np.pi)
    return np.asarray(np.eye(3) + np.sinc(angle / np.pi) * cross + 2.0 * half * half * (cross @ cross))


def placed(poses: Array, points: ArrayLike) -> Array:
    """Points (..., m, 3) of the platform, its frame, in the world at *poses* (..., n), m."""
    arms = np.asarray(points, dtype=np.float64)
    if poses.shape[-1] == 6:
        arms = arms @ np.swapaxes(matrices(poses[..., 3:]), -1, -2)
    return np.asarray(poses[..., None, :3] + arms)


def shortest(vectors: Array) -> Array:
    """The rotation vectors (..., 3) of length at most pi that mean the same rotations as *vectors*."""
    angle = np.linalg.norm(vectors, axis=-1, keepdims=True)
    turns = np.round(angle / (2.0 * np.pi))
    return np.where(angle > np.pi, vectors * (1.0 - 2.0 * np.pi * turns / np.where(angle > 0.0, angle, 1.0)), vectors)


def angle_between(first: ArrayLike, second: ArrayLike) -> Array:
    """Angle (...) in rad of the rotation that takes *first* to *second*, rotation vectors (..., 3)."""
    between = np.swapaxes(matrices(first), -1, -2) @ matrices(second)
    skew = between - np.swapaxes(between, -1, -2)
    sine = 0.5 * np.linalg.norm(np.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], axis=-1), axis=-1)
    return np.asarray(np.arctan2(sine, 0.5 * (np.trace(between, axis1=-2, axis2=-1) - 1.0)))


def turn_between(first: ArrayLike, second: ArrayLike) -> Array:
    """Rotation vector (..., 3) in space, rad, that takes *first* to *second*, rotation vectors (..., 3)."""
    between = matrices(second) @ np.swapaxes(matrices(first), -1, -2)
    skew = 0.5 * (between - np.swapaxes(between, -1, -2))
    axis = np.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], axis=-1)
    sine = np.linalg.norm(axis, axis=-1, keepdims=True)
    angle = np.arctan2(sine, 0.5 * (np.trace(between, axis1=-2, axis2=-1)[..., None] - 1.0))
    return np.asarray(axis * np.where(sine > 0.0, angle / np.where(sine > 0.0, sine, 1.0), 1.0))
