"""Areas of slices by height and retraction length, the largest of each, and the fitted law (Jung 2020, Fig. 10)."""

from __future__ import annotations

from matplotlib.figure import Figure

from cablewright.analyses.workspace.retraction import RetractionStudy
from cablewright.apps import style


def retraction_picture(found: RetractionStudy) -> Figure:
    """Draw the table of areas with the law, and the areas by height."""
    drawn = style.figure(10.4, 4.6)
    left, right = drawn.subplots(1, 2, width_ratios=(1.15, 1.0))
    half, step = 0.5 * found.slice_height, 0.5 * (found.lengths[1] - found.lengths[0])
    extent = (found.heights[0] - half, found.heights[-1] + half, found.lengths[0] - step, found.lengths[-1] + step)
    look = {"origin": "lower", "aspect": "auto", "cmap": "cividis", "interpolation": "nearest"}
    shown = left.imshow(found.areas.T, extent=extent, **look)
    style.colour_bar(drawn, left, shown, "area of the slice in m²", shrink=1.0)
    for rows, colour, name in (
        (~found.fitted, "white", "largest area, not fitted"),
        (found.fitted, style.ORANGE, "largest area, fitted"),
    ):
        edge = {"markeredgecolor": style.INK, "markeredgewidth": 0.5, "markersize": 4}
        left.plot(found.heights[rows], found.best[rows], "o", color=colour, label=name, **edge)
    left.plot(found.heights, found.law.at(found.heights), color=style.RED, linewidth=1.6, label="law, clamped")
    height = f"height of the {found.law.of} in m"
    left.set(xlabel=height, ylabel="retraction length in m", xlim=extent[:2], ylim=extent[2:])
    left.grid(visible=False)
    left.set_title("area by height and retraction length")
    left.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=3)
    for k, name in ((0, "shortest"), (len(found.lengths) - 1, "longest")):
        colour = (style.GREEN, style.BLUE)[k > 0]
        right.plot(found.areas[:, k], found.heights, color=colour, label=f"{name}, {found.lengths[k]:.3g} m")
    right.plot(found.best_areas, found.heights, color=style.INK, linewidth=2.4, alpha=0.35, label="largest area")
    right.plot(found.held.slices(found.heights), found.heights, "--", color=style.RED, label="with the law")
    right.set(xlabel="area of the slice in m²", ylabel=height, ylim=extent[:2])
    right.set_xlim(left=0.0)
    right.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2)
    right.set_title(f"volume {found.held.volume:.3g} m³ with the law, {100 * found.share:.1f} % of max")
    return drawn
