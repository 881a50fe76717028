"""Surfaces between the nodes of a grid: closed, where distances say, and on the grid's sides where it is full."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.analyses.workspace import boundary_limits as module
from cablewright.analyses.workspace.boundary_limits import boundary_limits
from cablewright.analyses.workspace.marching import surface_between
from cablewright.analyses.workspace.workspace import count_nodes
from cablewright.foundation.triangle_mesh import TriangleMesh
from cablewright.robot import load

AXES = (np.linspace(-1.0, 1.0, 25), np.linspace(-1.0, 1.0, 23), np.linspace(-1.0, 1.0, 21))
X, Y, Z = np.meshgrid(*AXES, indexing="ij")


def surface(heights: np.ndarray) -> TriangleMesh:
    """Of where *heights* (X, Y, Z) are above 0, which change by 1 per m there."""
    mesh = surface_between(AXES, heights > 0.0, np.abs(heights))
    assert mesh.is_closed
    return mesh


def test_a_ball() -> None:
    mesh = surface(0.8 - np.sqrt(X**2 + Y**2 + Z**2))
    assert mesh.volume == pytest.approx(4.0 / 3.0 * np.pi * 0.8**3, rel=0.01)
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices, axis=1), 0.8, atol=5e-3)


def test_a_ball_that_the_side_of_the_grid_cuts() -> None:
    mesh = surface(0.8 - np.sqrt(X**2 + Y**2 + (Z + 1.0) ** 2))
    assert mesh.volume == pytest.approx(2.0 / 3.0 * np.pi * 0.8**3, rel=0.01)
    assert mesh.vertices[:, 2].min() == -1.0


def test_a_plane_is_met_to_rounding() -> None:
    normal = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
    mesh = surface(0.07 - normal[0] * X - normal[1] * Y - normal[2] * Z)
    inner = (np.abs(mesh.vertices) < 1.0).all(axis=1)
    assert inner.sum() > 1000
    np.testing.assert_allclose(mesh.vertices[inner] @ normal, 0.07, atol=1e-12)


def test_a_full_grid_is_its_box_and_an_empty_one_nothing() -> None:
    assert surface(np.ones(X.shape)).volume == pytest.approx(8.0, rel=1e-12)
    assert len(surface_between(AXES, np.zeros(X.shape, dtype=bool), np.ones(X.shape)).triangles) == 0


def test_the_surface_of_a_static_workspace_meets_its_boundary(monkeypatch: pytest.MonkeyPatch) -> None:
    found = boundary_limits(count_nodes(load("paty2021"), "static", step=1.0))
    mesh = found.surface()
    assert mesh.is_closed
    assert mesh.volume == pytest.approx(found.nodes.trapezoid_volume, rel=0.02)
    known = found.points[found.ended_by < len(found.limits) - 1]  # the last limit is the frame
    away = np.linalg.norm(mesh.vertices[:, None] - known, axis=2).min(axis=0)
    assert away.max() < 1.0  # a cell
    assert np.quantile(away, 0.8) < 0.1
    monkeypatch.setattr(module, "MAX_NODES", 8)
    coarse = found.surface()
    assert coarse.is_closed
    assert len(coarse.triangles) < 0.4 * len(mesh.triangles)
    assert coarse.volume == pytest.approx(mesh.volume, rel=0.1)
