"""Picture file (PNG) of a scene, drawn without a browser."""

from __future__ import annotations

from itertools import product
from typing import Final

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure

from cablewright.apps import style
from cablewright.apps.space_axes import add_faces, add_lines, machine
from cablewright.apps.web.colours import RAMPS
from cablewright.apps.web.path_scene import LAID, Quantity
from cablewright.apps.web.scene import SceneDescription, platform_of, route
from cablewright.foundation.arrays import Array
from cablewright.models.rotation import placed

_MOST: Final = 20_000  # pieces of a path
_SHADES: Final = 60.0  # pieces of one colour are at most this part of the scene's extent long
_MOST_NAMES: Final = 12
_SIDES: Final = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))
_UNITS: Final = {"m": (1e3, "mm")}  # of errors; heights stay in m


def scene_png(scene: SceneDescription) -> bytes:
    """Return a PNG of the scene in the state that is shown first."""
    with style.drawing():
        return style.png(_drawn(scene))


def _drawn(scene: SceneDescription) -> Figure:
    sides = np.subtract(scene.robot.scene.frame_max, scene.robot.scene.frame_min)
    drawn = style.figure(7.4, 3.6 + 2.4 * min(1.0, float(sides[2] / max(sides[:2]))))
    states, robot = scene.states, scene.robot
    curves, pose = states.curves[states.shown], states.poses[states.shown]
    low, high = scene.bounds
    axes = machine(drawn, drawn.add_gridspec(1, 1)[0], robot, low, high)
    beams = np.array([(beam.start, beam.end) for beam in robot.scene.beams]).reshape(-1, 2, 3)
    add_lines(axes, beams, 2, 3.0, style.GREY)
    dead = [pair for line in robot.lines for pair in zip(route(line)[:-1], route(line)[1:], strict=True)]
    add_lines(axes, np.array(dead).reshape(-1, 2, 3), 2, 1.0, style.GREY)
    _add_path(drawn, axes, scene)
    _add_platform(axes, scene, pose)
    scale = states.scale(robot)
    colours = None
    if scale is not None:
        colours = ScalarMappable(Normalize(scale["low"], scale["high"]), _map("tension"))
        style.colour_bar(drawn, axes, colours, f"tension in N; limits {scale['limits']}", shrink=0.6)
    for tension, curve in zip(states.tensions[states.shown], curves, strict=True):
        known = colours is not None and np.isfinite(tension)
        colour = colours.to_rgba(tension) if known and colours is not None else style.INK
        axes.plot(*curve.T, color=colour, linewidth=1.8, zorder=6)
    if robot.m <= _MOST_NAMES:
        for line in robot.lines:
            axes.text(*line.exit_point, f" {style.label(line.name)}", fontsize=8.0, zorder=9)
    axes.set_title(style.label(scene.title, 60))
    return drawn


def _map(name: str) -> Colormap:
    return LinearSegmentedColormap.from_list(name, list(RAMPS[name]["light"]))


def _add_path(drawn: Figure, axes: object, scene: SceneDescription) -> None:
    """The path as far as it lays material, in the colours of its first quantity."""
    path = scene.path
    if path is None:
        return
    kept = path.overview
    ends = np.stack([kept[:-1], kept[1:]], axis=1)[path.kind[kept[1:]] == LAID]
    ends = ends[:: max(1, len(ends) // _MOST)]
    if not len(ends):
        return
    if not path.quantities:
        add_lines(axes, path.positions[ends], 4, 1.0, style.BLUE)
        return
    first: Quantity = path.quantities[0]
    size, unit = _UNITS.get(first.unit, (1.0, first.unit)) if first.high < 1.0 else (1.0, first.unit)
    colours = ScalarMappable(Normalize(size * first.low, size * first.high), _map(first.colours))
    pieces, values = _shaded(path.positions[ends], first.values[ends], path.extent / _SHADES)
    add_lines(axes, pieces, 4, 1.0, colours.to_rgba(size * values))
    style.colour_bar(drawn, axes, colours, f"{first.label} in {unit}", shrink=0.6)  # type: ignore[arg-type]


def _shaded(pieces: Array, values: Array, longest: float) -> tuple[Array, Array]:
    """Pieces (p, 2, 3) and values (p, 2) at their ends, cut to at most *longest*, m; values of the middles."""
    length = np.linalg.norm(pieces[:, 1] - pieces[:, 0], axis=1)
    count = np.clip(np.ceil(length / longest), 1, _SHADES).astype(int)
    of = np.repeat(np.arange(len(pieces)), count)
    place = (np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count)) / count[of]
    share = np.stack([place, place + 1.0 / count[of]], axis=1)
    cut = pieces[of, :1] + share[..., None] * (pieces[of, 1:] - pieces[of, :1])
    return cut, values[of, 0] + share.mean(axis=1) * (values[of, 1] - values[of, 0])


def _add_platform(axes: object, scene: SceneDescription, pose: Array) -> None:
    given = platform_of(scene.robot, scene.drum)
    for low, high in given["boxes"]:
        corners = placed(pose, np.array(list(product(*zip(low, high, strict=True)))))
        add_faces(axes, corners[np.array(_SIDES)], style.GREY, 5, alpha=0.6, edge=style.INK)
    if given["hull"]:
        corners = placed(pose, np.array(given["hull"]["vertices"]))[np.array(given["hull"]["faces"])]
        add_faces(axes, corners, style.GREY, 5, alpha=0.5, edge=style.INK)
    nozzle = placed(pose, [given["nozzle"]])[0]
    axes.plot(*nozzle[:, None], "o", color=style.RED, markersize=5, zorder=8)  # type: ignore[attr-defined]
