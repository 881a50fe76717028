"""Pictures of a calibration: residuals, sigmas of exit points, correlations of unknowns; the room of a guided one."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from cablewright.apps import style
from cablewright.apps.quantities import enlargement
from cablewright.calibration.guidance.guided_calibration import Guidance
from cablewright.calibration.judgement.result import Calibration
from cablewright.foundation.arrays import Array

_COLOURS: Final = (style.BLUE, style.ORANGE, style.GREEN, style.INK)
_MARKS: Final = "osD^vP"
_MAX_NAMED: Final = 12
_SHARE: Final = 0.08  # of the longest side: about the size of the largest ellipse
_CLOSE: Final = 0.08  # of the same: points nearer to each other share a label
_MAX_CELLS: Final = 60
_VIEWS: Final = ((0, 1, "from above"), (0, 2, "from the side"))


def residuals_picture(found: Calibration) -> Figure:
    """Draw the residual of each length over the poses."""
    drawn, axes = style.axes(9.0, 3.6)
    size, unit = (1e6, "µm") if found.rms < 2e-5 else (1e3, "mm")
    pose = np.arange(1, found.problem.poses + 1)
    for i, line in enumerate(found.problem.robot.lines):
        marker, colour = _MARKS[i // len(_COLOURS) % len(_MARKS)], _COLOURS[i % len(_COLOURS)]
        name = style.label(line.name) if i < _MAX_NAMED else None
        used = found.used[:, i]
        axes.plot(pose[used], found.residuals[used, i] * size, marker, color=colour, ms=3.5, label=name)
    if np.isfinite(found.encoder_sigma):
        band = found.encoder_sigma * size
        axes.axhspan(-band, band, color=style.GREY, alpha=0.15, linewidth=0, label="sigma of the encoders")
    out = sorted({each.pose + 1 for each in found.rejected})
    if out:
        axes.plot(out, np.zeros(len(out)), "x", color=style.RED, ms=7, mew=1.6, label="left out", clip_on=False)
    axes.set(
        xlabel="pose", ylabel=f"residual in {unit}", xlim=(0, found.problem.poses + 1), title="residuals of the lengths"
    )
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    style.legend_below(drawn, axes, columns=6)
    return drawn


def exits_picture(found: Calibration) -> Figure | None:
    """Draw the exit points from above and from the side with their sigma ellipses; None where they are not fitted."""
    blocks = _blocks(found)
    if not blocks:
        return None
    drawn = style.figure(9.0, 4.6)
    largest = max(float(np.sqrt(np.linalg.eigvalsh(block).max())) for _, _, block in blocks)
    points = np.array([point for _, point, _ in blocks])
    span = float(np.ptp(points, axis=0).max())
    times = enlargement(_SHARE * span, largest)
    scene = found.problem.robot.scene
    for at, (across, up, title) in enumerate(_VIEWS):
        axes, plane = drawn.add_subplot(1, 2, at + 1), [across, up]
        label = "frame of the robot file"
        style.rectangle(axes, scene.frame_min, scene.frame_max, (across, up), linewidth=0.8, label=label)
        for _, point, block in blocks:
            style.ellipse(axes, point[plane], block[np.ix_(plane, plane)], times, style.BLUE)
        axes.plot(*points[:, plane].T, "o", color=style.BLUE, ms=3)
        for place, names in _together(points[:, (across, up)], [name for name, _, _ in blocks], _CLOSE * span):
            axes.annotate(style.label(", ".join(names), 18), place, xytext=(4, 4), textcoords="offset points")
        axes.plot([], [], color=style.BLUE, label=f"ellipse of one sigma, enlarged {times:g} times")
        axes.set(
            xlabel=f"{'xyz'[across]} in m",
            ylabel=f"{'xyz'[up]} in m",
            title=title,
            aspect="equal",
        )
        axes.margins(0.14)
    style.legend_below(drawn, axes, columns=3)
    return drawn


def _blocks(found: Calibration) -> list[tuple[str, Array, Array]]:
    """Return name, place (3,), m, and covariance (3, 3), m², of each line's exit point that is fitted."""
    made = []
    for i, line in enumerate(found.problem.robot.lines):
        at = [k for k, each in enumerate(found.unknowns) if each.name == "exit_point" and each.line == line.name]
        if len(at) == 3 and np.isfinite(found.covariance[np.ix_(at, at)]).all():
            made.append((line.name, found.problem.points(found.fit.theta)[i], found.covariance[np.ix_(at, at)]))
    return made


def _together(points: Array, names: list[str], apart: float) -> list[tuple[tuple[float, float], list[str]]]:
    """Group points (k, 2) nearer than *apart* to the first of their group: its place, and the names of all."""
    groups: list[tuple[tuple[float, float], list[str]]] = []
    for point, name in zip(points, names, strict=True):
        near = next((group for group in groups if np.hypot(*(point - group[0])) < apart), None)
        if near is None:
            groups.append(((float(point[0]), float(point[1])), [name]))
        else:
            near[1].append(name)
    return groups


def correlation_picture(found: Calibration) -> Figure | None:
    """Draw the correlations of the unknowns; None where there are fewer than two, or too many to show."""
    known = np.flatnonzero(np.isfinite(found.sigma) & (found.sigma > 0.0))
    if not 2 <= len(known) <= _MAX_CELLS:
        return None
    sigma = found.sigma[known]
    correlation = found.covariance[np.ix_(known, known)] / np.outer(sigma, sigma)
    side = 2.6 + 0.17 * len(known)
    drawn, axes = style.axes(side + 1.6, side)
    image = axes.imshow(correlation, cmap="PuOr", vmin=-1.0, vmax=1.0)
    names = [f"{style.label(found.unknowns[at].label, 34)}  {i}" for i, at in enumerate(known, 1)]
    axes.set_yticks(range(len(names)), names, fontsize=7)
    axes.set_xticks(range(len(names)), [str(i + 1) for i in range(len(names))], fontsize=6)
    axes.grid(visible=False)
    style.colour_bar(drawn, axes, image, "correlation", shrink=0.8)
    axes.set_title("correlations of the unknowns")
    return drawn


def guidance_picture(found: Guidance) -> Figure:
    """Draw frame, exit points with their standard deviations, measured and next poses, and the camera."""
    drawn, both = style.subplots(9.6, 5.2, 1, 2)
    for axes, (across, up, title) in zip(both, _VIEWS, strict=True):
        _draw_room(axes, found, [across, up])
        axes.set(xlabel="x in m", ylabel=f"{'xyz'[up]} in m", title=title)
    style.legend_below(drawn, *both, columns=4)
    return drawn


def _draw_room(axes: Axes, found: Guidance, plane: list[int]) -> None:
    """Draw the room in the *plane* of two axes of the world."""
    scene, exits = found.robot.scene, np.array([line.exit_point for line in found.robot.lines])[:, plane]
    (left, low), (right, high) = (np.array(corner)[plane] for corner in (scene.frame_min, scene.frame_max))
    axes.plot([left, right, right, left, left], [low, low, high, high, low], color=style.GREY, label="frame")
    axes.plot(*exits.T, "o", color=style.BLUE, markersize=4, label="exit point")
    labels = [f"{style.label(known.line, 16)}: {1e3 * known.now:.2g} mm" for known in found.exits]
    for point, words in _together(exits[: len(labels)], labels, _CLOSE * float(np.ptp(exits))):
        axes.annotate("\n".join(words), point, xytext=(5, 5), textcoords="offset points", fontsize=7)
    if found.found is not None:
        axes.plot(*found.found.poses[:, plane].T, ".", color=style.GREY, label="measured")
    places = np.array([each.pose[:3] for each in found.next_poses]).reshape(-1, 3)[:, plane]
    if len(places):
        axes.plot(*places.T, "s-", color=style.ORANGE, linewidth=0.6, markersize=4, label="next, in this order")
    for at, place in enumerate(places.tolist(), 1):
        axes.annotate(f"{at}", place, xytext=(4, -9), textcoords="offset points", color=style.ORANGE, fontsize=8)
    if found.view is not None and found.view.seen.layout.camera == "room":
        place, rotation = found.view.seen.place, found.view.seen.rotation
        camera = found.view.seen.camera
        half = 0.5 * camera.width / camera.focal[0]
        reach = float(np.linalg.norm(np.subtract(scene.frame_max, scene.frame_min)))
        for side in (-half, half) if plane[1] == 1 else (0.0,):
            ray = np.array([place, place + reach * rotation @ np.array([side, 0.0, 1.0])])[:, plane]
            axes.plot(*ray.T, ":", color=style.RED, linewidth=0.8)
        axes.plot(*place[plane], "^", color=style.RED, markersize=9, label="camera")
    axes.set_aspect("equal", adjustable="datalim")
