"""The description of a 3-D scene for the viewer, as one JSON object. Shared by `show` and all reports.

Lengths are in m, forces in N, times in s, rotation vectors in rad, in the world's axes if nothing else is said. An
array (`Packed`) is ``{"type", "shape", "delta", "data"}``: u8, u16, u32 or f32, little-endian, deflated, in base64.
With ``delta`` each row is the difference from the row before, modulo its size. Keys:

* ``schema``, ``title``, ``notes``: 1; texts.
* ``bounds``: ``low`` and ``high`` of all that is drawn. Points of lines are whole steps of their largest side / 65535.
* ``colours``: by name of a scale, ``light`` and ``dark``: colours from small to large.
* ``frame``, ``beams``, ``walls``: the box of the robot file; bars; rectangles with names.
* ``lines``: of each ``name``, ``dead`` (points from winch to exit point), ``exit``, ``limits`` (N), ``sheave`` (radius,
  or null).
* ``platform``: ``kind``, ``nozzle``, ``boxes`` and ``hull`` (``vertices``, ``faces``), platform frame.
* ``frames``: the states: ``poses`` (F, n), ``tensions`` (F, m), ``curves`` (F, m, k, 3), ``sheaves`` (F, m, 6: centre
  and axis), ``times``, ``samples``, ``layers``, ``fileLines``, ``estimates``, ``ellipsoids`` (half axes),
  ``ellipsoid_times``, ``ellipsoid_label``, ``names``, ``notes``, ``shown``; ``lattice`` (x, y and z of the nozzle, of
  which the states are all, x fastest; or null); ``scans`` (k, 3) of all states and ``scan_ends`` (F,).
* ``tension_scale``: ``low``, ``high``, and the limits in words.
* ``path``: ``origin``, ``step``, ``places``, ``layer``, ``layers``, ``kind`` (0 nothing, 1 laid, 2 travel), ``level``,
  ``tolerances`` (m, by level), ``sample``, ``time`` (ms), ``line``, ``line_name``, ``quantities`` (``key``, ``label``,
  ``unit``, ``low``, ``high``, ``colours``, ``note``, ``values`` in 250 steps), ``bead``.
* ``meshes``, ``points``, ``tracks``: ``name``, ``token`` (its colour), ``shown``, and ``vertices`` with ``faces``, or
  ``places``.
* ``worst``: a ``label`` and its ``place``, or null.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from itertools import combinations, product
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from cablewright.apps.web.colours import RAMPS
from cablewright.apps.web.detail_levels import Packed, packed
from cablewright.apps.web.path_scene import PathScene
from cablewright.apps.web.viewer_states import States
from cablewright.foundation.arrays import Array
from cablewright.foundation.triangle_mesh import TriangleMesh
from cablewright.robot import Robot

SCHEMA: Final = 1
"""Version of the description."""

STEPS: Final = 65_535  # of the grid of points, across the largest side


@dataclass(frozen=True)
class SceneBody:
    """A mesh in the scene, a set of points, or a polyline. ``token``: the colour, a variable of viewer.css."""

    name: str
    token: str
    mesh: TriangleMesh | None = None
    points: Array | None = None  # (k, 3) m, drawn as crosses
    track: Array | None = None  # (k, 3) m, drawn joined; NaN interrupts
    opacity: float = 1.0
    shown: bool = True


@dataclass(frozen=True)
class Mark:
    """A named position in the 3-D view."""

    label: str
    place: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class SceneDescription:
    """A robot in one or more states, and other objects, for the 3-D view."""

    title: str
    robot: Robot
    states: States
    path: PathScene | None = None
    walls: tuple[tuple[str, Array], ...] = ()  # name and corners (4, 3), m
    bodies: tuple[SceneBody, ...] = ()
    worst: Mark | None = None
    drum: tuple[float, float] | None = None  # m: radius and depth of a drum that hangs from a point platform
    notes: tuple[str, ...] = field(default=())

    def with_bodies(self, *bodies: SceneBody) -> SceneDescription:
        """Return the 3-D scene with more bodies."""
        return replace(self, bodies=(*self.bodies, *bodies))

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest corner (3,), m, of all that is drawn."""
        points: list[ArrayLike] = [self.robot.scene.frame_min, self.robot.scene.frame_max]
        points += [point for line in self.robot.lines for point in route(line)]
        points += [corners for _, corners in self.walls]
        points += [each for curves in self.states.curves for each in curves if len(each)]
        points += [] if self.path is None else [self.path.bounds]
        for body in self.bodies:
            points += [each for each in (body.points, body.track) if each is not None and len(each)]
            points += [] if body.mesh is None else [body.mesh.vertices]
        stacked = np.vstack([np.atleast_2d(np.asarray(each, dtype=float)) for each in points])
        return np.nanmin(stacked, axis=0), np.nanmax(stacked, axis=0)

    def as_dict(self) -> dict[str, Any]:
        """The 3-D scene as a JSON object."""
        low, high = self.bounds
        step = max(float((high - low).max()), 1e-9) / STEPS
        scene = self.robot.scene
        return {
            "schema": SCHEMA,
            "title": self.title,
            "notes": list(self.notes),
            "bounds": {"low": _numbers(low), "high": _numbers(high)},
            "colours": RAMPS,
            "frame": {"low": scene.frame_min, "high": scene.frame_max},
            "beams": [{"start": beam.start, "end": beam.end, "radius": beam.radius} for beam in scene.beams],
            "walls": [{"name": name, "corners": [_numbers(each) for each in corners]} for name, corners in self.walls],
            "lines": lines_of(self.robot),
            "platform": platform_of(self.robot, self.drum),
            "frames": self.states.as_dict(low, step) | self._places_in_file(),
            "tension_scale": self.states.scale(self.robot),
            "path": None if self.path is None else self.path.as_dict(),
            "meshes": [_mesh(body, body.mesh) for body in (*_plane(self.robot), *self.bodies) if body.mesh is not None],
            "points": [_places(body, body.points) for body in self.bodies if body.points is not None],
            "tracks": [_places(body, body.track) for body in self.bodies if body.track is not None],
            "worst": None if self.worst is None else {"label": self.worst.label, "place": self.worst.place},
        }

    def _places_in_file(self) -> dict[str, Any]:
        """The layer and the line of the file of each state."""
        path, samples = self.path, self.states.samples
        if path is None or samples is None:
            return {}
        lines = None if path.line is None else packed(path.line[samples], "u32")
        return {"layers": packed(path.layer[samples], "u32"), "fileLines": lines}

    def as_json(self) -> str:
        """The scene as JSON text that may stand in a page: nothing in a name ends an element."""
        text = json.dumps(self.as_dict(), separators=(",", ":"), allow_nan=False)
        for mark in "<>&\u2028\u2029":
            text = text.replace(mark, f"\\u{ord(mark):04x}")
        return text


def route(line: Any) -> list[tuple[float, float, float]]:
    """Return the points (m, world) of a line from its winch over its guides to its exit point, or to a pulley there."""
    return [line.exit_point] if line.winch_exit is None else line.dead_span().drawn()


def lines_of(robot: Robot) -> list[dict[str, Any]]:
    """Return the constant data of each line: its guides up to the exit point, the sheave's size, its limits."""
    return [
        {
            "name": line.name,
            "dead": route(line),
            "exit": line.exit_point,
            "limits": line.tension_limits,
            "sheave": None if line.sheave.kind == "eyelet" else {"radius": line.sheave.radius},
        }
        for line in robot.lines
    ]


def platform_of(robot: Robot, drum: tuple[float, float] | None = None) -> dict[str, Any]:
    """Return the platform in its own frame: nozzle, boxes, or the hull of its platform points without boxes."""
    platform = robot.platform
    boxes = [[box.lowest, box.highest] for box in platform.boxes]
    nozzle = getattr(platform, "nozzle", (0.0, 0.0, 0.0))
    if drum is not None:
        radius, depth = drum
        boxes, nozzle = [*boxes, [(-radius, -radius, -depth), (radius, radius, 0.0)]], (0.0, 0.0, -depth)
    points = np.unique([line.platform_point for line in robot.lines], axis=0)
    return {"kind": platform.kind, "nozzle": nozzle, "boxes": boxes, "hull": _hull(points)}


def _hull(points: Array) -> dict[str, Any] | None:
    """The convex hull of points (k, 3) as vertices and faces; of points in a plane, the polygon; None of a point."""
    away = points - points.mean(axis=0)
    _, sizes, axes = np.linalg.svd(away, full_matrices=True)
    rank = int((sizes > 1e-6 * max(float(np.abs(away).max()), 1e-12)).sum()) if len(points) > 1 else 0
    if rank < 2:
        return None
    if rank == 2:
        flat = away @ axes[:2].T
        order = np.argsort(np.arctan2(flat[:, 1], flat[:, 0]))
        faces = [[int(order[0]), int(order[k]), int(order[k + 1])] for k in range(1, len(order) - 1)]
    else:
        from scipy.spatial import ConvexHull  # takes a third of a second to load

        faces = ConvexHull(points).simplices.tolist()
    return {"vertices": points.tolist(), "faces": faces}


def _plane(robot: Robot) -> tuple[SceneBody, ...]:
    """The plane in which the platform moves, as far as the frame goes; none where it moves in no plane."""
    plane = robot.platform.plane
    if plane is None:
        return ()
    corners = np.array(list(product(*zip(robot.scene.frame_min, robot.scene.frame_max, strict=True))))
    heights = np.array([plane.height(corner) for corner in corners])
    cut = [corners[heights == 0.0]]
    for i, j in combinations(range(8), 2):
        if (corners[i] == corners[j]).sum() == 2 and heights[i] * heights[j] < 0.0:  # an edge from side to side
            share = heights[i] / (heights[i] - heights[j])
            cut.append((corners[i] + share * (corners[j] - corners[i]))[None])
    hull = _hull(np.concatenate(cut))
    if hull is None:
        return ()
    mesh = TriangleMesh(np.array(hull["vertices"]), np.array(hull["faces"]))
    return (SceneBody("plane of the platform", "--wall", mesh=mesh, opacity=0.25),)


def _mesh(body: SceneBody, mesh: TriangleMesh) -> dict[str, Any]:
    vertices: Packed = packed(mesh.vertices, "f32")
    return _named(body) | {"opacity": body.opacity, "vertices": vertices, "faces": packed(mesh.triangles, "u32")}


def _places(body: SceneBody, places: Array) -> dict[str, Any]:
    return _named(body) | {"places": packed(places, "f32")}


def _named(body: SceneBody) -> dict[str, Any]:
    return {"name": body.name, "token": body.token, "shown": body.shown}


def _numbers(values: ArrayLike) -> list[float]:
    return [float(each) for each in np.asarray(values)]
