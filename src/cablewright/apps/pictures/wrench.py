"""Pictures of the available wrenches at a pose, and of tensions by several methods side by side."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.spatial import ConvexHull

from cablewright.analyses.tension_comparison import TensionComparison
from cablewright.analyses.wrench_polytope import WrenchPolytope
from cablewright.apps import style
from cablewright.apps.space_axes import add_faces, add_lines, space
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError

_FACE = (0.0, 0.447, 0.698)  # `style.BLUE`
_SAME_PLANE = 1e-6  # difference of unit normals under which triangles are of one face


def polytope_picture(found: WrenchPolytope) -> Figure:
    """Draw the forces that lines can apply together with the moment that balances the loads; in a plane a polygon."""
    corners = found.vertices()
    forces = found.basis[:3, np.abs(found.basis[:3]).any(axis=0)]
    unit, name = (1e3, "kN") if np.abs(corners).max() >= 2e4 else (1.0, "N")
    required, moment = found.required[:3] / unit, found.required[3:]
    beside = f", with moments {', '.join(f'{x:.3g}' for x in moment + 0.0)} N m" if len(moment) else ""
    drawn = style.figure(6.4, 5.6)
    if forces.shape[1] == 2:
        flat = corners @ forces / unit
        axes = drawn.add_subplot()
        around = flat[ConvexHull(flat).vertices]
        axes.fill(*around.T, facecolor=(*_FACE, 0.2), edgecolor=style.BLUE, label="available forces")
        axes.plot(*(forces.T @ required)[:, None], "o", color=style.RED, label="balances weight and loads")
        axes.set(
            xlabel=f"force along {_axis(forces[:, 0])} in {name}", ylabel=f"force along {_axis(forces[:, 1])} in {name}"
        )
        axes.set_aspect("equal", adjustable="datalim")
    else:
        corners = corners / unit
        low, high = (end(np.vstack([corners, required]), axis=0) for end in (np.min, np.max))
        axes, _ = space(drawn, drawn.add_gridspec(1, 1)[0], low, high, name)
        for side, text in zip("xyz", ("xlabel", "ylabel", "zlabel"), strict=True):
            axes.set(**{text: f"force along {side} in {name}"})
        hull = ConvexHull(corners)
        add_faces(axes, corners[hull.simplices], [(*_FACE, 0.12)] * len(hull.simplices), 2, 0.12, edge="none")
        add_lines(axes, _edges(corners, hull), 3, 1.0, style.BLUE)
        axes.plot([], [], color=style.BLUE, label="available forces")
        axes.plot(*required[:, None], "o", color=style.RED, zorder=5, label="balances weight and loads")
    style.headline(drawn, f"{style.label(found.robot_name)}: forces on the platform{beside}")
    style.legend_below(drawn, axes, columns=2)
    return drawn


def _axis(direction: Array) -> str:
    """The name of a direction: an axis of the world, or its numbers."""
    near = int(np.abs(direction).argmax())
    return "xyz"[near] if abs(direction[near]) > 1.0 - 1e-9 else f"({', '.join(f'{x:.3g}' for x in direction + 0.0)})"


def _edges(corners: Array, hull: Any) -> Array:
    """Return the edges (e, 2, 3) of a hull between faces that are not in one plane."""
    kept = []
    for own, (face, beside) in enumerate(zip(hull.simplices, hull.neighbors, strict=True)):
        for k, other in enumerate(beside):
            if other > own and not np.allclose(hull.equations[own], hull.equations[other], atol=_SAME_PLANE, rtol=1e-6):
                kept.append(corners[np.delete(face, k)])
    return np.array(kept).reshape(-1, 2, 3)


def tensions_picture(found: TensionComparison) -> Figure:
    """Draw the tensions at one pose as bars, a colour for each method; at a path of poses as curves, a row each."""
    m, k = len(found.lines), len(found.methods)
    if found.tensions.ndim == 2:
        drawn, axes = style.axes(max(6.4, 0.7 * m + 2.0), 4.2)
        for i, name in enumerate(found.methods):
            at = np.arange(m) + (i + 0.5 - 0.5 * k) * 0.8 / k
            axes.bar(at, found.tensions[i], 0.8 / k, color=style.curve(i)["color"], label=style.label(name))
        axes.hlines(found.limits.T.ravel(), *np.tile([np.arange(m) - 0.45, np.arange(m) + 0.45], 2),
                    color=style.INK, linewidth=1.0, linestyle=style.DASHED, label="limits")  # fmt: skip
        axes.set_xticks(np.arange(m), [style.label(each) for each in found.lines])
        axes.set(xlabel="line", ylabel="tension in N")
        axes.grid(visible=False, axis="x")
        style.legend_below(drawn, axes, columns=min(k + 1, 3))
        return drawn
    if found.tensions.shape[1] < 2:
        raise InputError("plot: the batch has only one pose; take its row, found[0], or compute more poses")
    drawn, panels, columns = style.panels(k, 2.6, spare=0.6, sharex=True, sharey=True)
    for axes, name, tensions in zip(panels, found.methods, found.tensions, strict=True):
        for i, line in enumerate(found.lines):
            axes.plot(
                np.arange(len(tensions)), tensions[:, i], linewidth=1.1, label=style.label(line), **style.curve(i)
            )
        axes.set_title(style.label(name))
    style.outer_labels(panels, columns, "pose", "tension in N")
    style.legend_below(drawn, panels[0], columns=min(m, 8))
    return drawn
