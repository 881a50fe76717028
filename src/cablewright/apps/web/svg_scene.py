"""SVG picture of a scene, seen from a corner: for paper, and for browsers without WebGL."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from itertools import product
from typing import TYPE_CHECKING, Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.models.rotation import placed

if TYPE_CHECKING:
    from cablewright.apps.web.scene import SceneDescription

_WIDTH: Final = 860.0
_MARGIN: Final = 46.0
_MOST: Final = 6000  # vertices of a path
_MOST_NAMES: Final = 12
_AZIMUTH, _ELEVATION = np.radians(-62.0), np.radians(22.0)


def svg(scene: SceneDescription) -> str:
    """Return the scene as an SVG element. Its colours are the variables of viewer.css."""
    project = _Projection(*scene.bounds)
    parts = [*_frame(scene, project), *_path(scene, project), *_lines(scene, project), *_platform(scene, project)]
    told = escape(f"{scene.title}, seen from a corner")
    size = f"0 0 {_WIDTH:.0f} {project.height:.0f}"
    return f'<svg class="still" viewBox="{size}" role="img" aria-label="{told}">{"".join(parts)}</svg>'


class _Projection:
    """Points in space to points of the picture."""

    def __init__(self, low: Array, high: Array) -> None:
        self._right = np.array([-np.sin(_AZIMUTH), np.cos(_AZIMUTH), 0.0])
        back = np.array(
            [np.cos(_ELEVATION) * np.cos(_AZIMUTH), np.cos(_ELEVATION) * np.sin(_AZIMUTH), np.sin(_ELEVATION)]
        )
        self._up = np.cross(back, self._right)
        corners = self._flat(np.array(list(product(*zip(low, high, strict=True)))))
        self._low, high_ = corners.min(axis=0), corners.max(axis=0)
        size = np.maximum(high_ - self._low, 1e-9)
        self._scale = min((_WIDTH - 2 * _MARGIN) / size[0], 620.0 / size[1])
        self._left = (_WIDTH - self._scale * size[0]) / 2
        self.height = float(self._scale * size[1] + 2 * _MARGIN)

    def _flat(self, points: Array) -> Array:
        return np.stack([points @ self._right, points @ self._up], axis=-1)

    def __call__(self, points: Array) -> Array:
        """Return (k, 2), from the upper left corner."""
        at = self._scale * (self._flat(np.asarray(points, dtype=float)) - self._low)
        return np.stack([self._left + at[..., 0], self.height - _MARGIN - at[..., 1]], axis=-1)


def _polyline(points: Array, look: str, width: float) -> str:
    known = points[np.isfinite(points).all(axis=1)]
    text = " ".join(f"{x:.1f},{y:.1f}" for x, y in known)
    return f'<polyline class="{look}" points="{text}" fill="none" stroke-width="{width}"/>'


def _frame(scene: SceneDescription, project: _Projection) -> Iterator[str]:
    low, high = np.array(scene.robot.scene.frame_min), np.array(scene.robot.scene.frame_max)
    corners = np.array(list(product(*zip(low, high, strict=True))))
    for one, other in ((a, b) for a in range(8) for b in range(a + 1, 8) if (a ^ b) in (1, 2, 4)):
        yield _polyline(project(corners[[one, other]]), "edge", 1.0)
    for beam in scene.robot.scene.beams:
        yield _polyline(project(np.array([beam.start, beam.end])), "beam", 3.0)


def _path(scene: SceneDescription, project: _Projection) -> Iterator[str]:
    if scene.path is None:
        return
    coarse = scene.path.overview
    coarse = coarse[:: -(-len(coarse) // _MOST)] if len(coarse) else coarse
    flat, laid = project(scene.path.positions[coarse]), scene.path.kind[coarse] == 1
    for run in np.split(np.arange(len(coarse)), np.flatnonzero(~laid)):
        if len(run) > 1:
            yield _polyline(flat[run], "path", 1.2)


def _lines(scene: SceneDescription, project: _Projection) -> Iterator[str]:
    states = scene.states
    for line, curve in zip(scene.robot.lines, states.curves[states.shown], strict=True):
        yield _polyline(project(curve), "line", 1.8)
        x, y = project(np.array(line.exit_point))
        yield f'<rect class="exit" x="{x - 3:.1f}" y="{y - 3:.1f}" width="6" height="6"/>'
        if scene.robot.m <= _MOST_NAMES:
            yield f'<text class="name" x="{x:.1f}" y="{y - 8:.1f}" text-anchor="middle">{escape(line.name[:28])}</text>'


def _platform(scene: SceneDescription, project: _Projection) -> Iterator[str]:
    from cablewright.apps.web.scene import platform_of

    given, pose = platform_of(scene.robot, scene.drum), scene.states.poses[scene.states.shown]
    if not np.isfinite(pose).all():
        return
    for low, high in given["boxes"]:
        corners = project(placed(pose, np.array(list(product(*zip(low, high, strict=True))))))
        for one, other in ((a, b) for a in range(8) for b in range(a + 1, 8) if (a ^ b) in (1, 2, 4)):
            yield _polyline(corners[[one, other]], "platform", 1.4)
    if given["hull"] and not given["boxes"]:
        flat = project(placed(pose, np.array(given["hull"]["vertices"])))
        for face in given["hull"]["faces"]:
            yield _polyline(flat[[*face, face[0]]], "platform", 1.0)
    x, y = project(placed(pose, [given["nozzle"]]))[0]
    yield f'<circle class="nozzle" cx="{x:.1f}" cy="{y:.1f}" r="4"/>'
