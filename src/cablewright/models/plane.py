"""Directions in which a platform can move that a plane carries."""

from __future__ import annotations

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.robot import Plane


def basis(plane: Plane, n: int) -> Array:
    """Return orthonormal free directions: (3, 2) of a point, n = 3; (6, 3) of a body, rotation about the normal last.

    Those in the plane are along the world's axes where the plane is.
    """
    normal = np.array(plane.across)
    first = np.eye(3)[int(np.abs(normal).argmin())]
    first = first - (first @ normal) * normal
    first /= np.linalg.norm(first)
    inside = np.column_stack([first, np.cross(normal, first)])
    if n == 3:
        return inside
    free = np.zeros((6, 3))
    free[:3, :2], free[3:, 2] = inside, normal
    return free


def directions(plane: Plane | None, n: int) -> Array:
    """Return orthonormal columns (n, p): the directions that *plane* leaves free, or where it is None all."""
    return np.eye(n) if plane is None else np.ascontiguousarray(basis(plane, n))


def turning_axis(plane: Plane | None) -> Array:
    """Return the unit vector (3,) about which platforms turn without tilting: across *plane*, else upwards."""
    return np.array([0.0, 0.0, 1.0] if plane is None else plane.across)


def turning_axes(plane: Plane | None) -> Array:
    """Return the axes (k, 3) about which a body can turn: that of its plane, or z, x and y without one."""
    return np.eye(3)[[2, 0, 1]] if plane is None else np.array([turning_axis(plane)])


def within(plane: Plane | None, poses: Array) -> Array:
    """Return *poses* (..., n), m and rad, moved across *plane* into it and turned about its normal alone.

    They are as they are where it is None; a pose in the plane stays to rounding, and NaN stays NaN.
    """
    if plane is None:
        return poses
    normal = np.array(plane.across)
    found = poses.copy()
    found[..., :3] -= (poses[..., :3] @ normal - plane.distance)[..., None] * normal
    if poses.shape[-1] == 6:
        found[..., 3:] = (poses[..., 3:] @ normal)[..., None] * normal
    return found


def leaving(plane: Plane | None, vectors: Array) -> Array:
    """Return the components of *vectors* (..., 3) along the plane's normal; zeros where *plane* is None."""
    if plane is None:
        return np.zeros_like(vectors)
    normal = np.array(plane.across)
    return np.asarray((vectors @ normal)[..., None] * normal)


def projected(free: Array | None, wrenches: Array) -> Array:
    """Return *wrenches* (..., n) without the reactions of the plane; unchanged where *free* is None."""
    return wrenches if free is None else np.asarray(wrenches @ free @ free.T)
