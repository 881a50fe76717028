"""Surfaces of frame, exit points and platform, for pictures in STL and glTF files.

The frame is its bars, or where it has none thin bars along the edges of its box; an exit point is a small octahedron;
the platform its boxes, or the hull of its platform points. Lines are left out.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, product
from typing import Final

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from cablewright.foundation.arrays import Array
from cablewright.foundation.triangle_mesh import TriangleMesh
from cablewright.models.rotation import placed
from cablewright.robot import Robot

SIDES: Final = 16
"""Sides of the prism that represents a round bar."""

_THIN: Final = 0.003  # radius of a bar along an edge of the box, over its largest side
_EXIT: Final = 0.008  # of an exit

Triangles = Array  # (k, 3, 3) m


def shapes(robot: Robot, pose: Array) -> TriangleMesh:
    """Return the surfaces of a robot with its platform at a *pose* (n,), m and rad; they may cross each other."""
    return TriangleMesh.of_corners(np.concatenate(list(solids(robot, pose))))


def solids(robot: Robot, pose: Array) -> Iterator[Triangles]:
    """Yield the closed surfaces of a robot, with triangles counter-clockwise from outside."""
    low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    size = float((high - low).max())
    if robot.scene.beams:
        for beam in robot.scene.beams:
            yield _bar(np.array(beam.start), np.array(beam.end), beam.radius)
    else:
        for start, end in _edges(low, high):
            yield _bar(start, end, _THIN * size)
    for line in robot.lines:
        yield _octahedron(np.array(line.exit_point), _EXIT * size)
    boxes = robot.platform.boxes
    for box in boxes:
        yield _hull(placed(pose, list(product(*zip(box.lowest, box.highest, strict=True)))))
    if not boxes:
        yield _body(placed(pose, [line.platform_point for line in robot.lines]), _EXIT * size)


def _edges(low: Array, high: Array) -> Iterator[tuple[Array, Array]]:
    corners = np.array(list(product(*zip(low, high, strict=True))))
    for start, end in combinations(corners, 2):
        if (start != end).sum() == 1:
            yield start, end


def _body(points: Array, size: float) -> Triangles:
    """Return the hull of platform points; where they lie in a plane, with thickness, and a small ball for a point."""
    try:
        return _hull(points)
    except QhullError:
        return _hull(np.concatenate([points + each for each in size * np.vstack([np.eye(3), -np.eye(3)])]))


def _octahedron(centre: Array, radius: float) -> Triangles:
    return _hull(centre + radius * np.vstack([np.eye(3), -np.eye(3)]))


def _bar(start: Array, end: Array, radius: float) -> Triangles:
    along = (end - start) / (np.linalg.norm(end - start) or 1.0)
    across = np.cross(along, np.eye(3)[int(np.abs(along).argmin())])
    across /= np.linalg.norm(across)
    turns = 2.0 * np.pi * np.arange(SIDES) / SIDES
    ring = radius * (np.cos(turns)[:, None] * across + np.sin(turns)[:, None] * np.cross(along, across))
    if np.array_equal(start, end):
        return _octahedron(start, radius)
    return _hull(np.concatenate([start + ring, end + ring]))


def _hull(points: Array) -> Triangles:
    """Return the convex hull of points (k, 3), its triangles turned outwards."""
    triangles = points[ConvexHull(points).simplices]
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    inwards = np.einsum("ij,ij->i", normals, triangles[:, 0] - points.mean(axis=0)) < 0.0
    triangles[inwards] = triangles[inwards][:, ::-1]
    return np.asarray(triangles)
