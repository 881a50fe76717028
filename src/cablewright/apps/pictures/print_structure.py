"""Pictures of a printed structure: height maps, true and from scans, their difference, and cuts across the path."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, Normalize
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from cablewright.apps import style
from cablewright.foundation.arrays import Array
from cablewright.live.prints.result import PrintRecord
from cablewright.live.prints.structure import CrossSection
from cablewright.printing.heightfield import HeightField

_MARGIN: Final = 0.5  # m that are drawn around the path


def maps_picture(found: PrintRecord) -> Figure | None:
    """Draw heights from above: true, rebuilt from scans, and their difference."""
    structure = found.structure
    if structure is None:
        return None
    fields = [("true", structure.true), ("rebuilt from scans", structure.estimated)]
    known = [(title, field) for title, field in fields if field is not None]
    low = found.track.positions[:, :2].min(axis=0) - _MARGIN
    high = found.track.positions[:, :2].max(axis=0) + _MARGIN
    wide, deep = high - low
    columns = len(known) + (len(known) == 2)
    drawn, axes = style.subplots(
        3.2 * columns + 0.4, float(np.clip(2.7 * deep / wide, 2.0, 7.0)) + 1.3, 1, columns, sharex=True, sharey=True
    )
    top = 1e3 * max(structure.highest, 1e-3)
    for axis, (title, field) in zip(axes, known, strict=False):
        shown = _map(axis, field, 1e3 * field.heights, (0.0, top), style.stress_colours())
        axis.set_title(title)
    style.colour_bar(drawn, list(axes[: len(known)]), shown, "height in mm", location="bottom", shrink=0.7)
    if structure.estimated is not None and structure.true is not None:
        _difference(drawn, axes[-1], structure.true, structure.estimated)
    for axis in axes:
        axis.set(xlabel="x in m", aspect="equal", xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        axis.grid(visible=False)
    axes[0].set_ylabel("y in m")
    return drawn


def _map(axes: Axes, field: HeightField, values: Array, ends: tuple[float, float], colours: Colormap) -> AxesImage:
    (left, right), (bottom, top) = ((field.low[k], field.low[k] + field.cell * field.shape[k]) for k in (0, 1))
    norm, extent = Normalize(*ends), (left, right, bottom, top)
    return axes.imshow(values.T, origin="lower", extent=extent, cmap=colours, norm=norm, interpolation="nearest")


def _difference(drawn: Figure, axes: Axes, true: HeightField, seen: HeightField) -> None:
    x, y = np.meshgrid(seen.centres(0), seen.centres(1), indexing="ij")
    off = 1e3 * (seen.heights - true.at(np.stack([x.ravel(), y.ravel()], axis=1)).reshape(seen.shape))
    known = np.abs(off[np.isfinite(off)])
    limit = max(float(np.quantile(known, 0.995)) if len(known) else 1.0, 1.0)
    shown = _map(axes, seen, off, (-limit, limit), style.signed_colours())
    axes.set_title("rebuilt minus true")
    style.colour_bar(drawn, axes, shown, "difference in mm", location="bottom", shrink=0.95, aspect=20, extend="both")


def cuts_picture(found: PrintRecord) -> Figure | None:
    """Draw heights across the path where it passes once, and where the structure is highest."""
    if found.structure is None or not found.structure.sections:
        return None
    cuts = found.structure.sections
    drawn, axes = style.subplots(9.6, 3.2, 1, len(cuts), sharey=True, sharex=True)
    for axis, cut in zip(axes, cuts, strict=True):
        _draw_cut(axis, cut)
    axes[0].set_ylabel("height in mm")
    style.legend_below(drawn, *axes, columns=2)
    return drawn


def _draw_cut(axes: Axes, cut: CrossSection) -> None:
    across, true, rebuilt = 1e3 * cut.offsets, 1e3 * cut.true, 1e3 * cut.estimated
    if np.isfinite(true).any():
        axes.fill_between(across, 0.0, true, color=style.GREY, alpha=0.35, linewidth=0, label="true")
    if np.isfinite(rebuilt).any():
        axes.plot(across, rebuilt, drawstyle="steps-mid", color=style.BLUE, label="rebuilt from scans")
    title = style.minus(f"{cut.title}: x {cut.place[0]:.2f} m, y {cut.place[1]:.2f} m")
    axes.set(xlabel="offset from the path in mm, positive to the left", title=title)
