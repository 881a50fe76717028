"""Closed surfaces: volume, sections, and the files that others read."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from cablewright.foundation.triangle_mesh import TriangleMesh

Hull = tuple[TriangleMesh, ConvexHull]


def hull_mesh(points: np.ndarray) -> Hull:
    """The hull of points, its triangles turned outwards."""
    hull = ConvexHull(points)
    middle = points.mean(axis=0)
    triangles = []
    for a, b, c in hull.simplices:
        normal = np.cross(points[b] - points[a], points[c] - points[a])
        triangles.append((a, b, c) if normal @ (points[a] - middle) > 0 else (a, c, b))
    return TriangleMesh(points, np.array(triangles)), hull


@pytest.fixture(params=range(3))
def hull(request: pytest.FixtureRequest) -> Hull:
    return hull_mesh(np.random.default_rng(request.param).normal(3.0, 1.0, (30, 3)))


def test_volume_and_area_are_those_of_the_hull(hull: Hull) -> None:
    mesh, known = hull
    assert mesh.is_closed
    assert mesh.volume == pytest.approx(known.volume, rel=1e-12)
    assert mesh.area == pytest.approx(known.area, rel=1e-12)


def test_a_mesh_with_a_hole_or_a_turned_triangle_is_not_closed(hull: Hull) -> None:
    mesh, _ = hull
    assert not TriangleMesh(mesh.vertices, mesh.triangles[1:]).is_closed
    turned = mesh.triangles.copy()
    turned[0] = turned[0, ::-1]
    assert not TriangleMesh(mesh.vertices, turned).is_closed


def test_corners_in_one_place_are_one_vertex(hull: Hull) -> None:
    mesh, _ = hull
    again = TriangleMesh.of_corners(mesh.corners)
    assert len(again.vertices) == len(np.unique(mesh.triangles))
    np.testing.assert_array_equal(again.corners, mesh.corners)
    assert again.is_closed
    for none in (np.zeros((0, 3, 3)), mesh.corners[:, [0, 1, 1]]):
        assert not TriangleMesh.of_corners(none).is_closed


@pytest.mark.parametrize("axis", range(3))
def test_sections_have_the_area_of_the_cut_and_make_up_the_volume(hull: Hull, axis: int) -> None:
    mesh, known = hull
    low, high = mesh.vertices[:, axis].min(), mesh.vertices[:, axis].max()
    at = 0.6 * low + 0.4 * high
    (outline,) = mesh.section(axis, at)
    assert mesh.section_area(axis, at) == pytest.approx(ConvexHull(outline).volume, rel=1e-9)  # of a polygon: its area
    heights = low + (high - low) * (np.arange(4000) + 0.5) / 4000
    total = sum(mesh.section_area(axis, z) for z in heights) * (high - low) / 4000
    assert total == pytest.approx(known.volume, rel=1e-5)
    assert mesh.section_area(axis, high + 1.0) == 0.0
    assert mesh.section(axis, low - 1.0) == []


def test_a_hole_counts_against_a_section() -> None:
    outer, _ = hull_mesh(np.array([[x, y, z] for x in (0.0, 3.0) for y in (0.0, 3.0) for z in (0.0, 3.0)]))
    inner, _ = hull_mesh(np.array([[x, y, z] for x in (1.0, 2.0) for y in (1.0, 2.0) for z in (1.0, 2.0)]))
    both = TriangleMesh(
        np.concatenate([outer.vertices, inner.vertices]),
        np.concatenate([outer.triangles, inner.triangles[:, ::-1] + 8]),
    )
    assert both.volume == pytest.approx(26.0)
    assert both.section_area(2, 1.5) == pytest.approx(8.0)
    assert len(both.section(2, 1.5)) == 2


def test_stl_says_the_same_triangles(hull: Hull) -> None:
    mesh, _ = hull
    raw = mesh.stl()
    (count,) = struct.unpack_from("<I", raw, 80)
    assert (count, len(raw)) == (len(mesh.triangles), 84 + 50 * count)
    assert not raw.startswith(b"solid")  # or readers take it for text
    facets = np.frombuffer(raw, np.dtype([("f", "<f4", (4, 3)), ("u", "<u2")]), offset=84)["f"]
    np.testing.assert_allclose(facets[:, 1:], mesh.vertices[mesh.triangles], rtol=1e-6)
    ways = np.cross(facets[:, 2] - facets[:, 1], facets[:, 3] - facets[:, 1])
    np.testing.assert_allclose(facets[:, 0], ways / np.linalg.norm(ways, axis=1, keepdims=True), atol=1e-4)


def read_glb(raw: bytes) -> tuple[dict, TriangleMesh]:
    """The document and the only mesh of a glTF binary file, read by the letter of its specification."""
    magic, version, length = struct.unpack_from("<4sII", raw)
    assert (magic, version, length) == (b"glTF", 2, len(raw))
    size, kind = struct.unpack_from("<I4s", raw, 12)
    assert kind == b"JSON"
    assert size % 4 == 0
    document = json.loads(raw[20 : 20 + size])
    block, kind = struct.unpack_from("<I4s", raw, 20 + size)
    assert kind == b"BIN\0"
    binary = raw[28 + size :]
    assert block == len(binary) == document["buffers"][0]["byteLength"]
    (primitive,) = document["meshes"][0]["primitives"]
    arrays = []
    for accessor, dtype in ((primitive["attributes"]["POSITION"], "<f4"), (primitive["indices"], "<u4")):
        told = document["accessors"][accessor]
        view = document["bufferViews"][told["bufferView"]]
        assert told["componentType"] == {"<f4": 5126, "<u4": 5125}[dtype]
        piece = binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
        arrays.append(np.frombuffer(piece, dtype).reshape(-1, 3))
        assert told["count"] == (len(arrays[-1]) if told["type"] == "VEC3" else arrays[-1].size)
    return document, TriangleMesh(arrays[0].astype(float), arrays[1].astype(int))


def test_glb_says_the_same_mesh_and_turns_z_up(hull: Hull) -> None:
    mesh, _ = hull
    document, back = read_glb(mesh.glb())
    np.testing.assert_allclose(back.vertices, mesh.vertices, rtol=1e-6)
    np.testing.assert_array_equal(back.triangles, mesh.triangles)
    told = document["accessors"][0]
    np.testing.assert_allclose([told["min"], told["max"]], [back.vertices.min(axis=0), back.vertices.max(axis=0)])
    x, y, z, w = document["nodes"][0]["rotation"]
    up = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]  # where the quaternion takes z
    np.testing.assert_allclose(up, [0, 1, 0], atol=1e-12)  # glTF's up
    with pytest.raises(ValueError, match="without triangles"):
        TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int)).glb()
