"""Corners of the box of uncertain parameters: all of them, or those that can be extreme."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from cablewright.foundation.arrays import Array

ALL_VERTICES = 12  # largest number of parameters for which all corners are evaluated
JITTER = 1e-9  # relative perturbation that makes parallel generators distinct


def vertex_count(k: int) -> int:
    """Return the number of corners of the box that are evaluated for *k* parameters."""
    return 2**k if k <= ALL_VERTICES else 4 * k * (k - 1)


def signs_of_box(k: int) -> Array:
    """Return the signs (2^k, k) of all corners of the box of parameters; the last parameter changes first."""
    return np.asarray(1.0 - 2.0 * ((np.arange(2**k)[:, None] >> np.arange(k)[::-1]) & 1))


def extreme_signs(effects: Array) -> Array:
    """Return the signs (4 k (k - 1), k) of the corners that can be extreme for a convex function.

    They map to vertices of a zonotope, the image of the box under *effects* (3, k): displacement per parameter. A
    convex function, such as a distance, is largest at such a corner. Each vertex belongs to a face spanned by two of
    the generators; the signs of the others are those of their products with the normal of that face.
    """
    k = effects.shape[1]
    size = np.maximum(np.linalg.norm(effects, axis=0), 1e-300)
    generators = effects / size + JITTER * np.random.default_rng(0).standard_normal((3, k))
    pairs = np.array(list(combinations(range(k), 2)))
    normals = np.cross(generators[:, pairs[:, 0]].T, generators[:, pairs[:, 1]].T)
    signs = np.where(normals @ generators >= 0.0, 1.0, -1.0)
    faces = np.concatenate([signs, -signs])
    corners = []
    both = np.concatenate([pairs, pairs])
    at = np.arange(len(both))
    for first, second in ((1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)):
        corner = faces.copy()
        corner[at, both[:, 0]], corner[at, both[:, 1]] = first, second
        corners.append(corner)
    return np.concatenate(corners)
