"""Pictures of a calibration: what is left of each length, how well exit points are known, what goes together."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from cablewright.apps import style
from cablewright.arrays import Array
from cablewright.calibration.result import Calibration

_COLOURS: Final = (style.BLUE, style.ORANGE, style.GREEN, style.INK)
_MARKS: Final = "osD^vP"
_MAX_NAMED: Final = 12
_SHARE: Final = 0.08  # of the frame's longest side: how large the largest ellipse is drawn, at least
_CLOSE: Final = 0.08  # of the same: points nearer to each other share a label
_MAX_CELLS: Final = 60


def residuals_picture(found: Calibration) -> Figure:
    """Draw what is left of each length over the poses. Call within `style.drawing`."""
    drawn = style.figure(9.0, 3.6)
    axes = drawn.add_subplot()
    size, unit = (1e6, "µm") if found.rms < 2e-5 else (1e3, "mm")
    pose = np.arange(1, found.problem.poses + 1)
    used = found.used
    for i, line in enumerate(found.problem.robot.lines):
        marker, colour = _MARKS[i // len(_COLOURS) % len(_MARKS)], _COLOURS[i % len(_COLOURS)]
        name = style.label(line.name) if i < _MAX_NAMED else None
        count = used[:, i]
        axes.plot(pose[count], found.residuals[count, i] * size, marker, color=colour, ms=3.5, label=name)
    if np.isfinite(found.encoder_sigma):
        band = found.encoder_sigma * size
        axes.axhspan(-band, band, color=style.GREY, alpha=0.15, linewidth=0, label="sigma of the encoders")
    out = sorted({each.pose + 1 for each in found.rejected})
    if out:
        axes.plot(out, np.zeros(len(out)), "x", color=style.RED, ms=7, mew=1.6, label="left out", clip_on=False)
    axes.set(xlabel="pose", ylabel=f"length left over in {unit}", xlim=(0, found.problem.poses + 1))
    axes.set_title("what is left of each length")
    drawn.legend(loc="outside lower center", ncols=6)
    return drawn


def exits_picture(found: Calibration) -> Figure | None:
    """Draw the exit points from above and from the side with their sigma ellipses; None where they are not unknown."""
    blocks = _blocks(found)
    if not blocks:
        return None
    drawn = style.figure(9.0, 4.6)
    largest = max(float(np.sqrt(np.linalg.eigvalsh(block).max())) for _, _, block in blocks)
    points = np.array([point for _, point, _ in blocks])
    span = float(np.ptp(points, axis=0).max())
    times = _round(_SHARE * span / largest) if largest > 0.0 else 1.0
    scene = found.problem.robot.scene
    for at, (across, up) in enumerate(((0, 1), (0, 2))):
        axes = drawn.add_subplot(1, 2, at + 1)
        low, high = scene.frame_min, scene.frame_max
        corners = [(low[across], low[up]), (high[across], low[up]), (high[across], high[up]), (low[across], high[up])]
        axes.plot(*np.array([*corners, corners[0]]).T, color=style.GREY, linewidth=0.8, label="frame of the file")
        for _, point, block in blocks:
            _ellipse(axes, point, block, (across, up), times)
        for place, names in _together(points[:, (across, up)], [name for name, _, _ in blocks], _CLOSE * span):
            told = style.label(", ".join(names), 18)
            axes.annotate(told, place, xytext=(4, 4), textcoords="offset points")
        axes.plot([], [], color=style.BLUE, label=f"sigma, {times:g} times its size")
        axes.set(xlabel=f"{'xyz'[across]} in m", ylabel=f"{'xyz'[up]} in m")
        axes.set_title("from above" if up == 1 else "from the side")
        axes.set_aspect("equal")
        axes.margins(0.14)
    handles, names = drawn.axes[0].get_legend_handles_labels()
    drawn.legend(handles, names, loc="outside lower center", ncols=3)
    return drawn


def _blocks(found: Calibration) -> list[tuple[str, Array, Array]]:
    """Name, place (3,) and covariance (3, 3) of each line's exit point that is unknown."""
    made = []
    for i, line in enumerate(found.problem.robot.lines):
        at = [k for k, each in enumerate(found.unknowns) if each.name == "exit_point" and each.line == line.name]
        if len(at) == 3 and np.isfinite(found.covariance[np.ix_(at, at)]).all():
            made.append((line.name, found.problem.exit_points(found.fit.theta)[i], found.covariance[np.ix_(at, at)]))
    return made


def _together(points: Array, names: list[str], apart: float) -> list[tuple[tuple[float, float], list[str]]]:
    """Names of points (k, 2) that lie no further than *apart* from the first of them, with its place."""
    groups: list[tuple[tuple[float, float], list[str]]] = []
    for point, name in zip(points, names, strict=True):
        near = next((group for group in groups if np.hypot(*(point - group[0])) < apart), None)
        if near is None:
            groups.append(((float(point[0]), float(point[1])), [name]))
        else:
            near[1].append(name)
    return groups


def _ellipse(axes: Axes, point: Array, block: Array, plane: tuple[int, int], times: float) -> None:
    values, vectors = np.linalg.eigh(block[np.ix_(plane, plane)])
    width, height = 2.0 * times * np.sqrt(values.clip(min=0.0))
    angle = float(np.degrees(np.arctan2(vectors[1, 0], vectors[0, 0])))
    place = (float(point[plane[0]]), float(point[plane[1]]))
    axes.add_patch(Ellipse(place, width, height, angle=angle, facecolor="none", edgecolor=style.BLUE, linewidth=1.4))
    axes.plot(*place, "o", color=style.BLUE, ms=3)


def _round(value: float) -> float:
    """The next lower of 1, 2, 5 times a power of ten; at least 1."""
    power = 10.0 ** np.floor(np.log10(max(value, 1.0)))
    return float(max(power * step for step in (1, 2, 5) if power * step <= max(value, 1.0)))


def correlation_picture(found: Calibration) -> Figure | None:
    """Draw the correlations of the unknowns; None where there are none, or too many to see."""
    known = np.flatnonzero(np.isfinite(found.sigma) & (found.sigma > 0.0))
    if not 2 <= len(known) <= _MAX_CELLS:
        return None
    sigma = found.sigma[known]
    correlation = found.covariance[np.ix_(known, known)] / np.outer(sigma, sigma)
    side = 2.6 + 0.17 * len(known)
    drawn = style.figure(side + 1.6, side)
    axes = drawn.add_subplot()
    image = axes.imshow(correlation, cmap="PuOr", vmin=-1.0, vmax=1.0)
    names = [style.label(found.unknowns[at].label, 34) for at in known]
    axes.set_yticks(range(len(names)), names, fontsize=7)
    axes.set_xticks(range(len(names)), [str(at + 1) for at in range(len(names))], fontsize=6)
    axes.grid(visible=False)
    drawn.colorbar(image, ax=axes, label="correlation", shrink=0.8)
    axes.set_title("which values are known together only")
    return drawn
