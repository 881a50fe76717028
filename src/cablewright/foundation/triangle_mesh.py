"""A surface of triangles: its volume, area and sections, whether it is closed, and its STL and glTF files."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from functools import cached_property
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array

STL_FACET: Final = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("unused", "<u2")])
"""A triangle of a binary STL file."""

FLOAT, UINT = 5126, 5125  # glTF's numbers of component types
UPRIGHT = (-(0.5**0.5), 0.0, 0.0, 0.5**0.5)  # glTF's y is up: a quarter turn about x


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """Triangles in space, m; those of a closed surface are anticlockwise as seen from outside."""

    vertices: Array  # (V, 3)
    triangles: NDArray[np.int64]  # (F, 3) indices of vertices

    @classmethod
    def of_corners(cls, corners: Array) -> Self:
        """Return the mesh of triangles (F, 3, 3), m; equal corners become one vertex. Read-only arrays."""
        points = corners.reshape(-1, 3)
        order = np.lexsort(points.T)
        ordered = points[order]
        new = np.append(True, (ordered[1:] != ordered[:-1]).any(axis=1))[: len(points)]
        number = np.empty(len(points), dtype=np.int64)
        number[order] = np.cumsum(new) - 1
        vertices, triangles = ordered[new], number.reshape(-1, 3)
        for each in (vertices, triangles):
            each.setflags(write=False)
        return cls(vertices, triangles)

    @property
    def corners(self) -> Array:
        """Positions of the triangles' corners (F, 3, 3), m."""
        return self.vertices[self.triangles]

    @property
    def normals(self) -> Array:
        """Unit normal of each triangle (F, 3); 0 for one without area."""
        corners = self.corners
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300))

    @property
    def volume(self) -> float:
        """Enclosed volume, m^3, by the divergence theorem."""
        if not len(self.triangles):
            return 0.0
        a, b, c = (self.vertices - self.vertices.mean(axis=0))[self.triangles].transpose(1, 0, 2)
        return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0

    @property
    def area(self) -> float:
        """Area of the surface, m^2."""
        a, b, c = self.corners.transpose(1, 0, 2)
        return 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())

    @cached_property
    def is_closed(self) -> bool:
        """Whether the triangles bound a volume: each edge belongs to exactly one other triangle, in reverse direction.

        Triangles with a repeated vertex are ignored.
        """
        first = self.triangles[(self.triangles != np.roll(self.triangles, 1, axis=1)).all(axis=1)]
        second, size = np.roll(first, -1, axis=1), len(self.vertices)
        ahead, back = np.unique(first * size + second), np.sort((second * size + first).ravel())
        return bool(len(first)) and np.array_equal(ahead, back)

    def section(self, axis: int, at: float) -> list[Array]:
        """Return closed outlines (P, 2), m, in the plane where coordinate *axis* is *at*, m.

        The first of the other two coordinates is the one that follows *axis* in the cycle x, y, z: in that order
        outlines are anticlockwise, and those of holes clockwise.
        """
        begins, ends, places = self._cut(axis, at)
        follows = dict(zip(begins.tolist(), ends.tolist(), strict=True))
        where = dict(zip(begins.tolist(), places, strict=True))
        outlines = []
        while follows:
            start, edge = follows.popitem()
            outline = [where[start]]
            while edge != start:
                outline.append(where[edge])
                edge = follows.pop(edge)
            outlines.append(np.array(outline))
        return outlines

    def section_area(self, axis: int, at: float) -> float:
        """Return the area, m^2, of the section where coordinate *axis* is *at*, m."""
        begins, ends, places = self._cut(axis, at)
        order = np.argsort(begins)
        after = places[order[np.searchsorted(begins[order], ends)]] if len(begins) else places
        return 0.5 * float(np.sum(places[:, 0] * after[:, 1] - places[:, 1] * after[:, 0]))

    def _cut(self, axis: int, at: float) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
        """Return the segment of each cut triangle in the plane: edges of its begin and end (C,), and its begin (C, 2).

        A vertex in the plane counts as above it, so that all outlines are closed.
        """
        above = self.vertices[:, axis] >= at
        count = above[self.triangles].sum(axis=1)
        rows = self.triangles[(count == 1) | (count == 2)]
        sides = above[rows]
        lone = np.argmax(sides == (sides.sum(axis=1) == 1)[:, None], axis=1)  # the corner alone on its side
        turned = np.take_along_axis(rows, (lone[:, None] + np.arange(3)) % 3, axis=1)
        first, second = turned[:, [0, 1]], turned[:, [0, 2]]
        up = above[turned[:, 0]][:, None]
        begin, end = np.where(up, first, second), np.where(up, second, first)
        size = len(self.vertices)
        names = [np.min(edge, axis=1) * size + np.max(edge, axis=1) for edge in (begin, end)]
        low, high = self.vertices[np.min(begin, axis=1)], self.vertices[np.max(begin, axis=1)]
        share = (at - low[:, axis]) / (high[:, axis] - low[:, axis])
        place = low + share[:, None] * (high - low)
        return names[0], names[1], place[:, [(axis + 1) % 3, (axis + 2) % 3]]

    def stl(self) -> bytes:
        """Return the mesh as a binary STL file, in metres."""
        facets = np.zeros(len(self.triangles), STL_FACET)
        facets["normal"], facets["corners"] = self.normals, self.corners
        return b"cablewright, metres".ljust(80) + struct.pack("<I", len(facets)) + facets.tobytes()

    def glb(self) -> bytes:
        """Return a glTF 2.0 binary file, in metres, z up. Raises `ValueError` for a mesh without triangles."""
        if not len(self.triangles):
            raise ValueError("a glTF file cannot hold a mesh without triangles")
        points, indices = self.vertices.astype("<f4"), self.triangles.astype("<u4").ravel()
        views, at = [], 0
        for block, target in ((points.nbytes, 34962), (indices.nbytes, 34963)):
            views.append({"buffer": 0, "byteOffset": at, "byteLength": block, "target": target})
            at += block
        extent = {"min": points.min(axis=0).tolist(), "max": points.max(axis=0).tolist()}
        document = {
            "asset": {"version": "2.0", "generator": "cablewright"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "rotation": UPRIGHT}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
            "materials": [{"doubleSided": True, "pbrMetallicRoughness": {"metallicFactor": 0.0}}],
            "accessors": [
                {"bufferView": 0, "componentType": FLOAT, "count": len(points), "type": "VEC3"} | extent,
                {"bufferView": 1, "componentType": UINT, "count": len(indices), "type": "SCALAR"},
            ],
            "bufferViews": views,
            "buffers": [{"byteLength": at}],
        }
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 4)
        whole = 12 + 8 + len(text) + 8 + at
        return b"".join(
            [
                struct.pack("<4sII", b"glTF", 2, whole),
                struct.pack("<I4s", len(text), b"JSON") + text,
                struct.pack("<I4s", at, b"BIN\0") + points.tobytes() + indices.tobytes(),
            ]
        )
