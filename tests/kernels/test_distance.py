"""Closed forms of distances against minimisation that knows nothing of them; symmetric, touching, degenerate cases."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from cablewright.kernels.collision.distance import (
    clipped,
    depth_in_box,
    segment_box,
    segment_disc,
    segment_polygon,
    segment_segment,
)
from cases import often

SEED = 20200612
EXACT = 1e-12


def segments(kind: str, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Two random segments (2, 3), related as *kind* says."""
    a, b = rng.normal(size=(2, 2, 3))
    way = np.array([[0.0], [1.0]])
    if kind == "parallel":
        b = b[0] + way * (a[1] - a[0]) * rng.normal()
    elif kind == "nearly parallel":
        b = b[0] + way * ((a[1] - a[0]) * rng.normal() + 1e-8 * rng.normal(size=3))
    elif kind == "one line":
        b = a[0] + (a[1] - a[0]) * rng.normal(size=(2, 1))
    elif kind == "a point":
        b[1] = b[0]
    elif kind == "two points":
        a[1], b[1] = a[0], b[0]
    elif kind == "a shared end":
        b[0] = a[1]
    elif kind == "crossing":
        b += a[0] + rng.uniform() * (a[1] - a[0]) - (b[0] + rng.uniform() * (b[1] - b[0]))
    return a, b


def nearest(a: np.ndarray, b: np.ndarray) -> float:
    """Distance of two segments as a bounded least squares problem."""
    found = lsq_linear(np.stack([a[1] - a[0], b[0] - b[1]], axis=1), b[0] - a[0], (0.0, 1.0), tol=1e-15)
    return float(np.linalg.norm(a[0] + found.x[0] * (a[1] - a[0]) - b[0] - found.x[1] * (b[1] - b[0])))


@pytest.mark.parametrize(
    "kind",
    ["skew", "parallel", "nearly parallel", "one line", "a point", "two points", "a shared end", "crossing"],
)
def test_segments(kind: str) -> None:
    rng = np.random.default_rng(SEED)
    for _ in range(often(60, 200)):
        a, b = segments(kind, rng)
        square, s, t = segment_segment(a, 0, b, 0)
        assert 0.0 <= s <= 1.0
        assert 0.0 <= t <= 1.0
        reached = np.linalg.norm(a[0] + s * (a[1] - a[0]) - b[0] - t * (b[1] - b[0]))
        assert np.sqrt(square) == pytest.approx(reached, abs=EXACT)
        assert np.sqrt(square) <= nearest(a, b) + 1e-7  # the oracle's own
        assert np.sqrt(square) == pytest.approx(np.sqrt(segment_segment(b, 0, a, 0)[0]), abs=EXACT)
        ends = [np.linalg.norm(p - q) for p in a for q in b]
        assert np.sqrt(square) <= min(ends) + EXACT
        if kind in ("a shared end", "crossing"):
            assert np.sqrt(square) < 1e-7


def test_segments_do_not_undercut() -> None:
    """No pair of points on a fine grid is nearer; with the points reached, the distance is so the least."""
    rng = np.random.default_rng(SEED + 1)
    share = np.linspace(0.0, 1.0, 60)[:, None]
    for _ in range(200):
        a, b = segments("skew", rng)
        p, q = a[0] + share * (a[1] - a[0]), b[0] + share * (b[1] - b[0])
        grid = np.linalg.norm(p[:, None] - q[None], axis=2).min()
        assert -EXACT <= grid - np.sqrt(segment_segment(a, 0, b, 0)[0]) < 0.1


@pytest.mark.parametrize("kind", ["any", "along a face", "a point", "small and near"])
def test_boxes(kind: str) -> None:
    rng = np.random.default_rng(SEED + 2)
    share = np.linspace(0.0, 1.0, 2001)[:, None]
    inside = 0
    for _ in range(often(100, 300)):
        p, q, h = 2.0 * rng.normal(size=3), 2.0 * rng.normal(size=3), rng.uniform(0.1, 1.5, 3)
        if kind == "along a face":
            q[0] = p[0]
        elif kind == "a point":
            q = p.copy()
        elif kind == "small and near":
            p, q = 0.3 * p, 0.3 * q
        beyond = np.abs(p + share * (q - p)) - h
        square, s = segment_box(*p, *(q - p), *h)
        step = np.linalg.norm(q - p) / 2000 + EXACT
        grid = np.linalg.norm(np.maximum(beyond, 0.0), axis=1).min()
        assert -EXACT <= grid - np.sqrt(square) <= step
        assert np.linalg.norm(np.maximum(np.abs(p + s * (q - p)) - h, 0.0)) == pytest.approx(np.sqrt(square), abs=1e-7)
        if square == 0.0:
            inside += 1
            depth, at = depth_in_box(*p, *(q - p), *h, s)
            assert -EXACT <= beyond.max(axis=1).min() - depth <= step
            assert (np.abs(p + at * (q - p)) - h).max() == pytest.approx(depth, abs=EXACT)
    assert inside


def test_a_box_in_symmetric_places() -> None:
    for axis in range(3):
        for sign in (-1.0, 1.0):
            p, u = np.zeros(3), np.zeros(3)
            p[axis], p[axis - 1], u[axis - 1] = 3.0 * sign, -5.0, 10.0
            square, _ = segment_box(*p, *u, 1.0, 1.0, 1.0)
            assert square == pytest.approx(4.0, abs=EXACT)
    assert segment_box(-2.0, 1.0, 0.0, 4.0, 0.0, 0.0, 1.0, 1.0, 1.0)[0] == 0.0  # along a face: touching
    assert depth_in_box(-2.0, 0.0, 0.0, 4.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.5)[0] == pytest.approx(-1.0, abs=EXACT)
    assert depth_in_box(-2.0, 0.75, 0.0, 4.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.5)[0] == pytest.approx(-0.25, abs=EXACT)


def brute(a: np.ndarray, corners: np.ndarray) -> float:
    """Distance of a segment from a triangle as a bounded least squares problem in its barycentric coordinates."""
    p, e, f = corners[0], corners[1] - corners[0], corners[2] - corners[0]
    least = np.inf
    for u in np.linspace(0.0, 1.0, 41):  # rays of the triangle from its first corner: each is a segment
        ray = np.stack([p, p + (1.0 - u) * e + u * f])
        least = min(least, nearest(a, ray))
    return least


@pytest.mark.parametrize("kind", ["any", "no area", "in the plane", "a point", "through it"])
def test_triangles(kind: str) -> None:
    rng = np.random.default_rng(SEED + 3)
    polygon = np.zeros((5, 3))
    for _ in range(often(8, 25)):
        corners, a = rng.normal(size=(3, 3)), 1.5 * rng.normal(size=(2, 3))
        if kind == "no area":
            corners[2] = corners[0]
        elif kind == "in the plane":
            corners[:, 2], a[:, 2] = 0.5, 0.5
        elif kind == "a point":
            a[1] = a[0]
        elif kind == "through it":
            a += rng.dirichlet(np.ones(3)) @ corners - a[0] - rng.uniform() * (a[1] - a[0])
        count = clipped(np.r_[corners.ravel(), 0.0, 0.0, 0.0], 1e9, polygon)
        assert count == 3
        square, s = segment_polygon(a, 0, polygon, count)
        assert 0.0 <= s <= 1.0
        found = np.sqrt(square)
        assert -1e-7 <= brute(a, corners) - found < 0.06
        if kind == "through it":
            assert found < 1e-12


def test_a_triangle_is_cut_at_a_height() -> None:
    rng = np.random.default_rng(SEED + 4)
    polygon = np.zeros((5, 3))
    for _ in range(200):
        corners, height = rng.normal(size=(3, 3)), rng.normal()
        count = clipped(np.r_[corners.ravel(), 0.0, 0.0, 0.0], height, polygon)
        below = (corners[:, 2] <= height).sum()
        assert count == {0: 0, 1: 3, 2: 4, 3: 3}[below]
        if count:
            assert (polygon[: count + 1, 2] <= height + EXACT).all()
            np.testing.assert_array_equal(polygon[count], polygon[0])
            whole = np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0]))
            parts = [np.cross(polygon[k] - polygon[0], polygon[k + 1] - polygon[0]) for k in range(1, count - 1)]
            share = np.linalg.norm(np.sum(parts, axis=0)) / whole
            if below == 1:  # similar triangles
                z = np.sort(corners[:, 2])
                assert share == pytest.approx((height - z[0]) ** 2 / ((z[1] - z[0]) * (z[2] - z[0])), rel=1e-9)
            elif below == 2:
                z = np.sort(corners[:, 2])
                assert 1.0 - share == pytest.approx((z[2] - height) ** 2 / ((z[2] - z[1]) * (z[2] - z[0])), rel=1e-6)


def test_a_disc_is_as_far_as_its_nearest_point() -> None:
    """Against minimisation over fractions and discs' points; crossing segments have distance zero."""
    rng = np.random.default_rng(SEED)
    for k in range(100):
        a = rng.normal(size=(2, 3))
        normal = rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        centre, radius = rng.normal(size=3), rng.uniform(0.05, 1.5)
        if k % 4 == 0:  # through the disc
            one = np.cross(normal, rng.normal(size=3))
            a += centre + 0.9 * radius * one / np.linalg.norm(one) - (0.3 * a[0] + 0.7 * a[1])
        if k % 10 == 1:
            a[1] = a[0]
        square, s = segment_disc(a, 0, np.concatenate([centre, normal, [radius]]))

        def square_at(t: float, a=a, normal=normal, centre=centre, radius=radius) -> float:
            from_centre = a[0] + t * (a[1] - a[0]) - centre
            height = from_centre @ normal
            beyond = max(np.linalg.norm(from_centre - height * normal) - radius, 0.0)
            return height**2 + beyond**2

        assert square == pytest.approx(square_at(s), abs=EXACT)
        assert square <= min(square_at(t) for t in np.linspace(0.0, 1.0, 301)) + EXACT
        if k % 4 == 0 and k % 10 != 1:
            assert square < EXACT
