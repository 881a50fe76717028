"""Planes and circles fitted to measured markers, with the Jacobian of each fit by the markers for its covariance.

A fit is a small least-squares problem in which every residual is weighted by the covariance of its marker
(Gauss-Markov with conditions).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from cablewright.foundation.arrays import Array

_ROUNDS: Final = 30
_SETTLED: Final = 1e-13  # relative


@dataclass(frozen=True, eq=False)
class Linear:
    """A vector computed from N surveyed markers, with its Jacobian by the markers' coordinates."""

    value: Array  # (k,)
    jacobian: Array  # (k, 3 N)

    def covariance(self, of_markers: Array) -> Array:
        """Return the covariance (k, k) of the fit from that of the markers (3 N, 3 N)."""
        return np.asarray(self.jacobian @ of_markers @ self.jacobian.T)

    def sigma(self, of_markers: Array) -> Array:
        """Standard deviations (k,) of the vector."""
        return np.sqrt(np.maximum(np.diag(self.covariance(of_markers)), 0.0))

    def __getitem__(self, part: slice | list[int]) -> Linear:
        return Linear(self.value[part], self.jacobian[part])


class ShapeFit(NamedTuple):
    """A plane or circle fitted to k markers: unknowns, their Jacobian, residuals and the sigmas of these."""

    value: Array  # (p,)
    jacobian: Array  # (p, 3 k) by the coordinates of its own markers
    residuals: Array  # (k, r) m, by marker
    allowed: Array  # (k, r) m, sigma of each residual; 0 where nothing checks it
    chi_squared: float
    surplus: int  # conditions less unknowns
    converged: bool


Model = Callable[[Array, Array], tuple[Array, Array, Array]]
"""From unknowns (p,) and markers (k, 3): residuals (k, r), Jacobians by unknowns (k, r, p) and by markers (k, r, 3)."""


def _fit(model: Model, start: Array, points: Array, covariances: Array) -> ShapeFit:
    """Solve by Gauss-Newton; where the equations are singular, the fit has not converged."""
    try:
        return _solved(model, start, points, covariances)
    except np.linalg.LinAlgError:
        r = model(start, points)[0]
        return ShapeFit(start, np.zeros((len(start), points.size)), r, np.zeros_like(r), math.nan, 0, converged=False)


def _solved(model: Model, start: Array, points: Array, covariances: Array) -> ShapeFit:
    q, converged = start, False
    for _ in range(_ROUNDS):
        r, A, B = model(q, points)
        weight = np.linalg.inv(np.einsum("kri,kij,ksj->krs", B, covariances, B))
        normal = np.einsum("krp,krs,ksq->pq", A, weight, A)
        scale = 1.0 / np.sqrt(np.diag(normal))  # an angle and a length differ by orders of magnitude
        inverse = scale[:, None] * np.linalg.inv(scale[:, None] * normal * scale) * scale
        step = -inverse @ np.einsum("krp,krs,ks->p", A, weight, r)
        if converged:
            break
        q = q + step
        converged = bool(np.all(np.abs(step) <= _SETTLED * (1.0 + np.abs(q))))
    pull = np.einsum("pq,kqr->kpr", inverse, np.einsum("krp,krs->kps", A, weight))
    jacobian = -np.einsum("kpr,krj->pkj", pull, B).reshape(len(q), -1)
    spread = np.einsum("krr->kr", np.linalg.inv(weight)) - np.einsum("krp,pq,krq->kr", A, inverse, A)
    surplus = r.size - len(q)
    allowed = np.sqrt(np.maximum(spread, 0.0)) if surplus > 0 else np.zeros_like(r)
    return ShapeFit(q, jacobian, r, allowed, float(np.einsum("kr,krs,ks->", r, weight, r)), surplus, converged)


def _wall(azimuth: float, lean: float, distance: float, p: Array) -> tuple[Array, Array, Array]:
    """Return distances of markers from a wall and Jacobians as a `Model`, by azimuth, elevation of normal, distance."""
    level, t = directions(azimuth)
    up = np.array([0.0, 0.0, 1.0])
    n = np.cos(lean) * level + np.sin(lean) * up
    per_lean = np.cos(lean) * up - np.sin(lean) * level
    A = np.stack([np.cos(lean) * (p @ t), p @ per_lean, -np.ones(len(p))], axis=-1)
    return (p @ n - distance)[:, None], A[:, None, :], np.broadcast_to(n, (len(p), 1, 3))


def upright_plane(points: Array, covariances: Array) -> ShapeFit:
    """Fit a vertical wall, n(a) p = d, to two markers or more: azimuth a of its normal (rad) and distance d (m)."""
    centre = points.mean(axis=0)
    along = np.linalg.svd((points - centre)[:, :2])[2][0]
    azimuth = np.arctan2(along[0], -along[1])

    def model(q: Array, p: Array) -> tuple[Array, Array, Array]:
        r, A, B = _wall(q[0], 0.0, q[1], p)
        return r, A[..., [0, 2]], B

    return _fit(model, np.array([azimuth, directions(azimuth)[0] @ centre]), points, covariances)


def plane(points: Array, covariances: Array, azimuth: float) -> ShapeFit:
    """Fit a wall that may lean to three markers or more: azimuth and elevation of its normal (rad), distance (m).

    *azimuth*: the start value, rad.
    """
    start = np.array([azimuth, 0.0, directions(azimuth)[0] @ points.mean(axis=0)])
    return _fit(lambda q, p: _wall(q[0], q[1], q[2], p), start, points, covariances)


def level_plane(points: Array, covariances: Array) -> ShapeFit:
    """Fit a level floor or ceiling to one marker or more: its height, m."""

    def model(q: Array, p: Array) -> tuple[Array, Array, Array]:
        up = np.broadcast_to(np.array([[0.0, 0.0, 1.0]]), (len(p), 1, 3))
        return p[:, 2:] - q[0], -np.ones((len(p), 1, 1)), up

    return _fit(model, points[:, 2].mean(keepdims=True), points, covariances)


def level_circle(points: Array, covariances: Array) -> ShapeFit:
    """Fit a circle about a vertical axis to three markers or more: x, y of the axis, radius, height, m."""
    x, y, radius = _algebraic(points[:, :2])

    def model(q: Array, p: Array) -> tuple[Array, Array, Array]:
        away = p[:, :2] - q[:2]
        far = np.maximum(np.hypot(*away.T), 1e-300)
        u = away / far[:, None]
        zero, one = np.zeros(len(p)), np.ones(len(p))
        A = np.stack([np.stack([-u[:, 0], -u[:, 1], -one, zero], -1), np.stack([zero, zero, zero, -one], -1)], 1)
        B = np.stack([np.stack([u[:, 0], u[:, 1], zero], -1), np.stack([zero, zero, one], -1)], 1)
        return np.stack([far - q[2], p[:, 2] - q[3]], -1), A, B

    return _fit(model, np.array([x, y, radius, points[:, 2].mean()]), points, covariances)


def circle(points: Array, covariances: Array) -> tuple[ShapeFit, Array]:
    """Fit a circle to three markers or more: centre (3,) and radius, m, two tilts of its axis, and a basis (3, 3).

    The rows of the basis are two directions in the plane of the markers and its normal. The axis is the normal plus the
    tilts, unknowns 4 and 5, times these two directions.
    """
    middle = points.mean(axis=0)
    basis = np.linalg.svd(points - middle)[2]
    x, y, radius = _algebraic((points - middle) @ basis[:2].T)
    centre = middle + x * basis[0] + y * basis[1]

    def model(q: Array, p: Array) -> tuple[Array, Array, Array]:
        n = q[4:] @ basis[:2] + basis[2]
        size = np.linalg.norm(n)
        n = n / size
        tilts = [(basis[i] - (basis[i] @ n) * n) / size for i in (0, 1)]
        away = p - q[:3]
        out = away @ n
        flat = away - out[:, None] * n
        far = np.maximum(np.linalg.norm(flat, axis=1), 1e-300)
        u = flat / far[:, None]
        radial = np.concatenate([-u, -np.ones((len(p), 1)), *(-(out * (u @ t))[:, None] for t in tilts)], axis=1)
        level = np.zeros((len(p), 1))
        off = np.concatenate([np.broadcast_to(-n, p.shape), level, *((away @ t)[:, None] for t in tilts)], axis=1)
        B = np.stack([u, np.broadcast_to(n, p.shape)], axis=1)
        return np.stack([far - q[3], out], -1), np.stack([radial, off], axis=1), B

    return _fit(model, np.array([*centre, radius, 0.0, 0.0]), points, covariances), basis


def directions(azimuth: float) -> tuple[Array, Array]:
    """Return the horizontal unit vector (3,) of an azimuth (rad, from x towards y), and its derivative (3,) per rad."""
    c, s = np.cos(azimuth), np.sin(azimuth)
    return np.array([c, s, 0.0]), np.array([-s, c, 0.0])


def _algebraic(points: Array) -> tuple[float, float, float]:
    """Return centre and radius of the algebraic circle fit (Kasa) to points (k, 2) of a plane: a start value."""
    middle = points.mean(axis=0)
    p = points - middle
    A = np.column_stack([2.0 * p, np.ones(len(p))])
    x, y, c = np.linalg.lstsq(A, (p**2).sum(axis=1), rcond=None)[0]
    return float(x + middle[0]), float(y + middle[1]), float(np.sqrt(max(c + x**2 + y**2, 1e-12)))
