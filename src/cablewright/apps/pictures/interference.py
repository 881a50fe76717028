"""Interference: the lines in the frame with what they come nearest to; along a job also by layer, and what is free."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec

from cablewright.analyses.interference import Contact, Interference
from cablewright.apps import style
from cablewright.apps.report.quantities import quantity
from cablewright.apps.space_axes import add_faces, add_lines, draw_frame, point, space
from cablewright.arrays import Array
from cablewright.kernels.collision.clearance import BEADS
from cablewright.models.rotation import placed
from cablewright.models.solids import Obstacle
from cablewright.robot import Robot
from cablewright.studies.interference import JobInterference

_MAX_PIECES: Final = 6000
_SIDES: Final = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))


def interference_picture(found: Interference | JobInterference) -> Figure:
    """Draw what `interference` found at one pose, or along a job. Call within `style.drawing`."""
    if isinstance(found, Interference):
        drawn = style.figure(7.4, 6.4)
        _machine(drawn, drawn.add_gridspec(1, 1)[0], found, found.part, found.nearest())
        return drawn
    drawn = style.figure(11.0, 6.0)
    grid = drawn.add_gridspec(2, 2, width_ratios=(1.25, 1.0))
    if found.closest is not None:
        _machine(drawn, grid[:, 0], found.closest, found.part, found.worst)
    _layers(drawn.add_subplot(grid[0, 1]), found)
    _floor(drawn, grid[1, 1], found)
    return drawn


def _machine(drawn: Figure, where: SubplotSpec, shown: Interference, part: Obstacle, worst: Contact | None) -> None:
    """Draw frame, part and lines at one pose."""
    robot = shown.equilibrium.model.robot
    curves = shown.curves()
    low, high = _room(robot, part, curves)
    axes, _ = space(drawn, where, low, high, "m")
    draw_frame(axes, robot)
    _add_part(axes, part)
    beams = np.array([(beam.start, beam.end) for beam in robot.scene.beams]).reshape(-1, 2, 3)
    add_lines(axes, beams, 2, 2.5, style.GREY)
    pose = np.atleast_2d(shown.equilibrium.pose)[0]
    for box in robot.platform.boxes:
        add_faces(axes, _box(box.lowest, box.highest, pose), style.GREEN, 4, alpha=0.35)
    for curve in curves:
        axes.plot(*curve.T, color=style.BLUE, linewidth=1.2, zorder=5)
    axes.plot([], [], color=style.BLUE, linewidth=1.2, label="lines")
    if len(part.order):
        axes.plot([], [], color=style.ORANGE, label="part")
    if worst is not None:
        other = f"line {worst.other}" if worst.kind == "line" else worst.other
        told = f"nearest: line {worst.line} from {other}, {quantity(worst.margin, 'm')}"
        point(axes, np.array(worst.place), "N", above=True, label=style.label(told, 70))
    axes.set_title(style.label(robot.name))
    handles, names = axes.get_legend_handles_labels()
    drawn.legend(handles, names, loc="outside lower left", ncols=3)


def _room(robot: Robot, part: Obstacle, curves: list[Array]) -> tuple[Array, Array]:
    """Lowest and highest corner (3,) of all that is shown."""
    ends = [robot.scene.frame_min, robot.scene.frame_max, *(line.exit_point for line in robot.lines)]
    if len(part.order):
        box = part.solid.boxes[0]
        ends += [tuple(box[:3] - box[3:]), tuple(box[:3] + box[3:])]
    corners = np.vstack([np.array(ends), *curves])
    return corners.min(axis=0), corners.max(axis=0)


def _add_part(axes: Any, part: Obstacle) -> None:
    """Draw a thinned part: strands as lines along them, a mesh as faces."""
    count = len(part.order)
    kept = part.solid.pieces[np.linspace(0, count - 1, min(count, _MAX_PIECES)).astype(int)] if count else []
    if not len(kept):
        return
    pieces = np.array(kept)
    if part.solid.kind == BEADS:
        reach = pieces[:, 3:6] * pieces[:, 9:10]
        add_lines(axes, np.stack([pieces[:, :3] - reach, pieces[:, :3] + reach], axis=1), 3, 0.5, style.ORANGE)
    else:
        add_faces(axes, pieces[:, :9].reshape(-1, 3, 3), style.ORANGE, 3, alpha=0.5)


def _box(lowest: Any, highest: Any, pose: Array) -> Array:
    """The six sides (6, 4, 3) of a box of the platform, world."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    points = placed(pose, np.where(corners, highest, lowest))
    return np.asarray(points[np.array(_SIDES)])


def _layers(axes: Any, found: JobInterference) -> None:
    """Draw the smallest distance from the part in each layer, and over the whole job from the other things."""
    numbers, nearest = found.layers()
    shown = np.isfinite(nearest) & (numbers >= 0)
    axes.plot(numbers[shown], nearest[shown] * 1e3, color=style.ORANGE, label="from the part")
    axes.axhline(found.clearance * 1e3, color=style.RED, linewidth=1.0, label="too near below")
    if found.first_layer is not None:
        axes.axvline(found.first_layer, color=style.INK, linestyle=":", label=f"first: layer {found.first_layer}")
    axes.set(xlabel="layer", ylabel="distance in mm", title="smallest distance of a line from the part")
    axes.legend(loc="best")


def _floor(drawn: Figure, where: SubplotSpec, found: JobInterference) -> None:
    """Draw from which height on the nozzle is free of the whole part."""
    axes = drawn.add_subplot(where, aspect="equal")
    x, y, _ = found.region.axes
    floor = np.ma.masked_invalid(found.region.floor.T)
    cells = axes.pcolormesh(x, y, floor, shading="nearest", cmap=style.error_colours())
    scale = drawn.colorbar(cells, ax=axes, shrink=0.9)
    scale.set_label("height in m")
    scale.outline.set_visible(False)
    share = 100.0 * found.region.fraction
    title = "lowest height free of the whole part" + (f": {share:.0f} %" if np.isfinite(share) else "")
    axes.set(xlabel="x in m", ylabel="y in m", title=title)
