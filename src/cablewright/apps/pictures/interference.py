"""Picture of interference: lines and their nearest obstacles; along a job also distance by layer, and free heights."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec

from cablewright.analyses.interference import Contact, Interference
from cablewright.apps import style
from cablewright.apps.quantities import quantity
from cablewright.apps.space_axes import add_faces, add_lines, add_point, machine
from cablewright.foundation.arrays import Array
from cablewright.kernels.collision.clearance import BEADS
from cablewright.models.obstacles import Obstacle
from cablewright.models.rotation import placed
from cablewright.studies.interference import JobInterference

_MAX_PIECES: Final = 6000
_SIDES: Final = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))


def interference_picture(found: Interference | JobInterference) -> Figure:
    """Draw the result of `interference` at one pose, or along a job."""
    if isinstance(found, Interference):
        drawn = style.figure(7.4, 6.4)
        _scene(drawn, drawn.add_gridspec(1, 1)[0], found, found.part, found.nearest())
        return drawn
    drawn = style.figure(11.0, 6.0)
    grid = drawn.add_gridspec(2, 2, width_ratios=(1.25, 1.0))
    if found.closest is not None:
        _scene(drawn, grid[:, 0], found.closest, found.part, found.worst)
    _layers(drawn.add_subplot(grid[0, 1]), found)
    _floor(drawn, grid[1, 1], found)
    return drawn


def _scene(drawn: Figure, where: SubplotSpec, shown: Interference, part: Obstacle, worst: Contact | None) -> None:
    """Draw frame, part and lines at one pose."""
    robot = shown.equilibrium.model.robot
    curves = shown.curves()
    boxes = part.solid.boxes[: min(1, len(part.order))]  # the first is around the whole part
    axes = machine(drawn, where, robot, *curves, boxes[:, :3] - boxes[:, 3:], boxes[:, :3] + boxes[:, 3:])
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
        text = f"nearest: line {worst.line} to {other}, {quantity(worst.margin, 'm')}"
        add_point(axes, np.array(worst.place), "N", above=True, label=style.label(text, 70))
    axes.set_title(style.label(robot.name))
    style.legend_below(drawn, axes, columns=3, side="left")


def _add_part(axes: Any, part: Obstacle) -> None:
    """Draw a thinned part: strands as lines along them, a mesh as faces."""
    count = len(part.order)
    if not count:
        return
    pieces = part.solid.pieces[np.linspace(0, count - 1, min(count, _MAX_PIECES)).astype(int)]
    if part.solid.kind == BEADS:
        reach = pieces[:, 3:6] * pieces[:, 9:10]
        add_lines(axes, np.stack([pieces[:, :3] - reach, pieces[:, :3] + reach], axis=1), 3, 0.5, style.ORANGE)
    else:
        add_faces(axes, pieces[:, :9].reshape(-1, 3, 3), style.ORANGE, 3, alpha=0.5)


def _box(lowest: Any, highest: Any, pose: Array) -> Array:
    """Return the six sides (6, 4, 3) of a box of the platform, m, world."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    return np.asarray(placed(pose, np.where(corners, highest, lowest))[np.array(_SIDES)])


def _layers(axes: Any, found: JobInterference) -> None:
    """Draw the min distance of the lines from the part in each layer, and the clearance that is required."""
    numbers, nearest = found.layers()
    shown = np.isfinite(nearest) & (numbers > 0)
    axes.plot(numbers[shown], nearest[shown] * 1e3, color=style.ORANGE, label="min distance")
    axes.axhline(
        found.clearance * 1e3, color=style.RED, linewidth=1.0, linestyle=style.DASHED, label="required clearance"
    )
    if found.first_layer is not None:
        axes.axvline(
            found.first_layer, color=style.INK, linestyle=":", label=f"first too near: layer {found.first_layer}"
        )
    axes.set(xlabel="layer", ylabel="distance in mm", title="distance of the lines from the part")
    axes.legend(loc="best")


def _floor(drawn: Figure, where: SubplotSpec, found: JobInterference) -> None:
    """Draw the height from which on no line touches the whole part."""
    axes = drawn.add_subplot(where, aspect="equal")
    x, y, _ = found.region.axes
    floor = found.region.floor
    known = floor[np.isfinite(floor)]
    scale = style.ErrorScale(known.min(), known.max(), "neither") if len(known) else style.scale_of(known)
    style.cells(axes, x, y, floor.T, style.error_bar(drawn, axes, scale, "height of the nozzle in m", shrink=0.9))
    share = 100.0 * found.region.fraction
    title = "min height without contact" + (f"\n{share:.0f} % of all positions are free" if np.isfinite(share) else "")
    axes.set(xlabel="x in m", ylabel="y in m", title=title)
