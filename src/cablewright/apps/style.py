"""Style of all pictures, elements that several draw, and export as PNG, SVG or PDF.

Colour-blind readers can distinguish the colours. Matplotlib's object interface with Agg is used: no window, and no
figure that outlives its function.
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from importlib.resources import files
from pathlib import Path
from textwrap import fill
from types import MappingProxyType
from typing import Any, Final, Literal, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Colormap, LinearSegmentedColormap, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.gridspec import SubplotSpec
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse, Rectangle
from matplotlib.text import Text
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter
from numpy.typing import ArrayLike
from pydantic_core import PydanticCustomError

from cablewright.apps.style_sheets import settings_of
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import EnvironmentFault, InputError, UnknownName
from cablewright.foundation.units import LENGTH

# The palette of Okabe and Ito.
BLUE: Final = "#0072b2"
ORANGE: Final = "#e69f00"
GREEN: Final = "#009e73"
RED: Final = "#d55e00"
INK: Final = "#1c2430"
GREY: Final = "#8a93a0"
SKY: Final = "#56b4e9"
PINK: Final = "#cc79a7"
YELLOW: Final = "#f0e442"

COLOURS: Final = (BLUE, ORANGE, GREEN, RED, INK, GREY)
"""Colours of curves in one pair of axes."""
DASHED: Final = (0, (4, 2))
RING: Final[Any] = {"marker": "o", "linestyle": "none", "markersize": 11, "fillstyle": "none", "color": INK}
"""How a picture marks the place with the largest value."""

_DASHES: Final[Any] = ("-", (0, (5, 1.5)), "-.", (0, (1, 1.2)))
_RAISED: Final = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_OUTLIERS: Final = 0.002  # of the values at each end, left out where they would take much of a colour scale
_DPI: Final = 150
_BELOW: Final[Any] = {side: f"outside lower {side}" for side in ("left", "center", "right")}
_LONGEST_LABEL: Final = 28
_MISSING: Final = "\N{WHITE SQUARE}"

STYLE_SHEET: Final = files("cablewright.apps") / "pictures.mplstyle"
"""The style sheet of all pictures, which comes with the package: copy and change it for one's own."""

FORMATS: Final = (".png", ".svg", ".pdf")
"""Endings of the files of pictures."""

WIDTHS: Final = MappingProxyType({"one-column": 3.5, "two-column": 7.16})
"""Widths of pictures in papers of two columns, inches: 89 and 182 mm (IEEE)."""

NARROW: Final = 5.0
"""Width of a page below which pictures have half as many panels beside one another, inches."""

_TITLE: Final = 11.0  # points, of a title over a figure
_HANDLE: Final = 7  # letters that an entry's line and its gaps take
_NARROW_LETTER: Final = 0.52  # mean width of a letter over its size
_LETTER: Final = 0.72  # mean width of a bold letter over its size
_SIZE: Final = 9.0  # of texts of a picture of its own, points
_PRINTED: Final = 7.0  # of texts in a paper
_HIGHEST: Final = 9.0  # inches of a page that a picture may take
_TALLEST: Final = 1.6  # by which a picture in a paper is taller than in proportion, so that texts have room
_METADATA: Final[Any] = {
    ".svg": {"Date": None, "Creator": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}


class _Page:
    """The width of pictures, inches; None: each has its own. And the factor by which texts are smaller there."""

    width: float | None = None
    shrink: float = 1.0


class ShownFigure(Figure):
    """A figure that a notebook shows without a window or a backend of its own."""

    def _repr_png_(self) -> bytes:
        return png(self)


@contextmanager
def drawing(width: float | str | None = None, style: str | Path | Mapping[str, Any] | None = None) -> Iterator[None]:
    """Return a context with this style of matplotlib instead of the user's settings, which return afterwards.

    The settings are the process's: draw in one thread at a time. *width*: a name in `WIDTHS`, or a length in m; None:
    each picture has its own. *style*: a style sheet, or settings by name, over those of `STYLE_SHEET`; with a width its
    ``font.size`` is that on the page, and other sizes are in proportion. Raises `InputError`.
    """
    before, inches = (_Page.width, _Page.shrink), page_width(width)
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(mpl.rc_params_from_file(str(STYLE_SHEET), use_default_template=False))
        own: Any = {} if style is None else settings_of(style)
        try:
            size = _PRINTED if inches is None else float(own.pop("font.size", _PRINTED))
            mpl.rcParams.update(own)
        except (ValueError, TypeError) as reason:
            raise InputError(f"style: {reason}") from None
        _Page.width, _Page.shrink = inches, 1.0 if inches is None else size / _SIZE
        try:
            yield
        finally:
            _Page.width, _Page.shrink = before


def page_width(width: float | str | None) -> float | None:
    """Return the width of a printed picture in inches. Raises `InputError`."""
    if width is None:
        return None
    if isinstance(width, str) and width in WIDTHS:
        return WIDTHS[width]
    try:
        size = LENGTH.read(width)
    except PydanticCustomError:
        raise UnknownName("width", str(width), [*WIDTHS, "a length such as 120 mm"]) from None
    if not 0.02 <= size <= 2.0:
        raise InputError(f"width = {size:g} m: must be from 0.02 to 2 m, or one of {', '.join(WIDTHS)}")
    return size / 0.0254


def picture_file(file: str | Path) -> Path:
    """Return the path of a picture that is to be written. Raises `InputError` for another ending than `FORMATS`.

    Raises `EnvironmentFault` where its folder is not there.
    """
    path = Path(file)
    if path.suffix.lower() not in FORMATS:
        raise InputError(
            f"plot = {str(file)!r}: expected a name that ends in {', '.join(FORMATS[:-1])} or {FORMATS[-1]}"
        )
    if not path.absolute().parent.is_dir():
        raise EnvironmentFault(f"plot = {str(file)!r}: cannot be written: there is no folder {path.parent}")
    return path


def figure(width: float, height: float) -> Figure:
    """Return an empty figure of that size in inches, or for the page that is set. Call within `drawing`."""
    if _Page.width is not None:
        scale = _Page.width / width
        width, height = _Page.width, height * scale * min(max(_Page.shrink / scale, 1.0), _TALLEST)
        height = min(height, max(_HIGHEST, 1.2 * width))
    made = ShownFigure(figsize=(width, height), dpi=_DPI, layout="constrained", facecolor="white")
    FigureCanvasAgg(made)
    return made


def is_narrow() -> bool:
    """Return whether panels are drawn one below the other, for a narrow column."""
    return _Page.width is not None and _Page.width < NARROW


def beside(most: int) -> int:
    """Return how many of *most* panels fit into a row: half as many in a narrow column."""
    return (most + 1) // 2 if is_narrow() else most


def finish(drawn: Figure) -> None:
    """Scale texts and markers of a figure down to their size on the page that is set, if one is."""
    if _Page.width is None:
        return
    by = _Page.shrink
    sides = [side for each in drawn.axes for side in (each.xaxis, each.yaxis, getattr(each, "zaxis", each.xaxis))]
    sizes: list[Any] = [side.get_tick_params().get("labelsize") for side in sides]
    for text in drawn.findobj(Text):
        text.set_fontsize(float(text.get_fontsize()) * by)
    for line in drawn.findobj(Line2D):
        line.set_linewidth(line.get_linewidth() * by)
        line.set_markersize(line.get_markersize() * by)
    for pieces in drawn.findobj(LineCollection):
        pieces.set_linewidth([width * by for width in np.ravel(pieces.get_linewidth()).tolist()])
    for each in drawn.axes:
        titles = {each.get_title(place) for place in ("left", "center")} - {""}
        letters = max(int(each.get_position().width * _Page.width * 72.0 / (_LETTER * _SIZE * by)), 8)
        for found in each.findobj(Text):
            if found.get_text() in titles:
                found.set_text(fill(found.get_text(), letters))
    for side, size in zip(sides, sizes, strict=True):
        side.set_tick_params(labelsize=by * (size if isinstance(size, float | int) else _SIZE))


def axes(width: float, height: float, **look: Any) -> tuple[Figure, Axes]:
    """Return a figure of that size in inches, and its one pair of axes. Call within `drawing`."""
    made = figure(width, height)
    return made, made.add_subplot(**look)


def subplots(width: float, height: float, rows: int, columns: int, **options: Any) -> tuple[Figure, Any]:
    """Return a figure of that size in inches, and a list of its axes, row by row. Call within `drawing`.

    One row of axes becomes one column of them on a narrow page.
    """
    if is_narrow() and rows == 1:
        width, height, rows, columns = width / columns, height * columns, columns, 1
        options.pop("width_ratios", None)
    made = figure(width, height)
    return made, list(made.subplots(rows, columns, squeeze=False, **options).ravel())


def grid(
    width: float, height: float, shape: tuple[int, int], *places: tuple[int | slice, int | slice], **ratios: Any
) -> tuple[Figure, list[SubplotSpec]]:
    """Return a figure of that size in inches, and its axes at *places* in a grid of rows and columns.

    Call within `drawing`. On a narrow page the places are one below the other.
    """
    rows, columns = shape
    if not is_narrow():
        made = figure(width, height)
        cells = made.add_gridspec(rows, columns, **ratios)
        return made, [cells[place] for place in places]
    spans = [len(range(rows)[row]) if isinstance(row, slice) else 1 for row, _ in places]
    ends = np.cumsum(spans).tolist()
    made = figure(width / columns, height * ends[-1] / rows)
    cells = made.add_gridspec(ends[-1], 1)
    return made, [cells[end - span : end, 0] for end, span in zip(ends, spans, strict=True)]


def png(drawn: Figure) -> bytes:
    """Return the figure as a PNG: the same bytes for the same picture, with neither date nor program in it."""
    return written(drawn, ".png")


def written(drawn: Figure, ending: str) -> bytes:
    """Return the figure in a format of `FORMATS`, its fonts embedded: the same bytes for the same picture."""
    out = io.BytesIO()
    if ending == ".png":
        FigureCanvasAgg(drawn).print_png(out, metadata={"Software": None}, pil_kwargs={"compress_level": 6})  # type: ignore[no-untyped-call]
    else:
        drawn.savefig(out, format=ending[1:], metadata=_METADATA[ending])
    return out.getvalue()


@cache
def error_colours() -> Colormap:
    """Return colours of an error, from dark blue (small) to orange (large): all are dark enough on white."""
    return ListedColormap(mpl.colormaps["plasma"](np.linspace(0.0, 0.82, 256)), name="error")


@cache
def stress_colours() -> Colormap:
    """Return colours of a stress, from pale blue (none) over green to red: a part without load is seen too."""
    return ListedColormap(mpl.colormaps["turbo"](np.linspace(0.06, 0.92, 256)), name="stress")


@cache
def signed_colours() -> Colormap:
    """Return colours of a signed value: blue below zero, at zero a grey that is seen on white, red above."""
    return LinearSegmentedColormap.from_list("signed", [BLUE, "#c3cad2", RED])


class ErrorScale(NamedTuple):
    """Ends of a colour scale for errors, in their unit, and whether errors exceed them."""

    low: float
    high: float
    extend: str  # neither, min, max or both


def scale_of(values: Array) -> ErrorScale:
    """Return a colour scale for finite *values* (k,); a few outliers do not stretch it."""
    if len(values) == 0:
        return ErrorScale(0.0, 1.0, "neither")
    low, high = float(values.min()), float(values.max())
    core = np.quantile(values, [_OUTLIERS, 1.0 - _OUTLIERS])
    if high - low > 1.5 * np.ptp(core) > 0.0:
        extend = {(True, True): "both", (True, False): "min", (False, True): "max"}
        beyond = extend.get((low < core[0], high > core[1]), "neither")
        return ErrorScale(float(core[0]), float(core[1]), beyond)
    margin = 0.0 if high - low > 1e-9 else max(1e-6, 0.05 * abs(high))
    return ErrorScale(low - margin, high + margin, "neither")


def colour_bar(drawn: Figure, axes: Axes | Sequence[Axes], colours: ScalarMappable, text: str, **options: Any) -> None:
    """Draw the colour scale of *colours* beside *axes*; *text* names its quantity and unit."""
    bar = drawn.colorbar(colours, ax=axes, **({"shrink": 0.75, "aspect": 28, "pad": 0.02} | options))
    bar.set_label(text)
    bar.outline.set_visible(False)


def error_bar(
    drawn: Figure, axes: Axes | Sequence[Axes], scale: ErrorScale, text: str, **options: Any
) -> ScalarMappable:
    """Draw the colour scale of an error beside *axes*; return the function from values to colours."""
    colours = ScalarMappable(Normalize(scale.low, scale.high), error_colours())
    colour_bar(drawn, axes, colours, text, extend=scale.extend, ticks=MaxNLocator(7), **options)
    return colours


def cells(axes: Axes, across: Array, up: Array, values: Array, colours: ScalarMappable, **options: Any) -> Any:
    """Draw a map of *values* (U, A) around the nodes *across* (A,) and *up* (U,); unknown cells stay white."""
    norm = Normalize(*colours.get_clim())
    shown = np.ma.masked_invalid(values)
    return axes.pcolormesh(across, up, shown, shading="nearest", cmap=colours.get_cmap(), norm=norm, **options)


def pieces(axes: Axes, begin: Array, end: Array, values: Array, **look: Any) -> LineCollection:
    """Draw straight pieces from points *begin* (p, 2) to points *end* (p, 2), coloured by *values* (p,)."""
    ends = np.stack([begin, end], axis=1)
    bundle = LineCollection(ends, array=values, capstyle="round", **look)  # type: ignore[arg-type]  # (p, 2, 2) is one
    axes.add_collection(bundle)
    return bundle


def panels(
    count: int, height: float, *, spare: float = 0.0, sharex: bool = False, sharey: bool = False
) -> tuple[Figure, list[Axes], int]:
    """Return a figure with *count* axes of *height* inches in up to two columns, those axes, and the columns.

    *spare* is the height in inches of the texts around them.
    """
    columns = min(beside(2), count)
    rows = -(-count // columns)
    drawn, grid = subplots(9.6, spare + height * rows, rows, columns, sharex=sharex, sharey=sharey)
    for each in grid[count:]:
        each.set_visible(False)
    return drawn, grid[:count], columns


def outer_labels(panels: Sequence[Axes], columns: int, below: str, beside: str) -> None:
    """Label the lowest of the *panels* in each column below, and those in the first column at their left."""
    for i, axes in enumerate(panels):
        if i % columns == 0:
            axes.set_ylabel(beside)
        if i + columns >= len(panels):
            axes.set_xlabel(below)
            axes.tick_params(labelbottom=True)


def legend_below(drawn: Figure, *axes: Axes, columns: int, side: Literal["left", "center", "right"] = "center") -> None:
    """Draw one legend of all labels in *axes* below the figure, without labels of earlier axes."""
    handles: list[Artist] = []
    names: list[str] = []
    for each in axes:
        own = [pair for pair in zip(*each.get_legend_handles_labels(), strict=True) if pair[1] not in names]
        handles += [handle for handle, _ in own]
        names += [name for _, name in own]
    if names:
        drawn.legend(handles, names, loc=_BELOW[side], ncols=legend_columns(names, columns))


def legend_columns(names: Sequence[str], most: int) -> int:
    """Return the number of columns, at most *most*, in which a legend of *names* fits the width of the page."""
    if _Page.width is None or not is_narrow():
        return most
    wide = (max(map(len, names), default=0) + _HANDLE) * _NARROW_LETTER * _SIZE * _Page.shrink
    return max(1, min(most, int(_Page.width * 72.0 / wide)))


def headline(drawn: Figure, text: str) -> None:
    """Write a title over the whole figure, in several lines where it is too long for the page that is set."""
    if _Page.width is not None:
        text = fill(text, int(_Page.width * 72.0 / (_LETTER * _TITLE * _Page.shrink)))
    drawn.suptitle(text, x=0.01, ha="left", fontsize=_TITLE, fontweight="bold")


def rectangle(axes: Axes, low: ArrayLike, high: ArrayLike, plane: tuple[int, int] = (0, 1), **look: Any) -> Rectangle:
    """Draw the outline of a box from *low* to *high* (3,) in the plane of two of its axes."""
    (left, bottom), (right, top) = (np.asarray(corner, dtype=float)[list(plane)] for corner in (low, high))
    made = Rectangle((left, bottom), right - left, top - bottom, fill=False, edgecolor=GREY, **look)
    axes.add_patch(made)
    return made


def ellipse(axes: Axes, place: ArrayLike, covariance: Array, times: float, colour: str) -> None:
    """Draw the ellipse of one sigma, *times* its size, around *place* (2,) for its *covariance* (2, 2)."""
    values, vectors = np.linalg.eigh(covariance)
    width, height = 2.0 * times * np.sqrt(values.clip(min=0.0))
    angle = math.degrees(math.atan2(vectors[1, 0], vectors[0, 0]))
    x, y = np.asarray(place).tolist()
    axes.add_patch(Ellipse((x, y), width, height, angle=angle, fill=False, edgecolor=colour, linewidth=1.2))


def curve(number: int) -> dict[str, Any]:
    """Return the colour and dash pattern of the curve with a number; curves differ in one of the two."""
    colours = mpl.rcParams["axes.prop_cycle"].by_key().get("color", COLOURS)
    return {"color": colours[number % len(colours)], "linestyle": _DASHES[number % len(_DASHES)]}


def round_ticks(axes: Axes, count: int = 6) -> None:
    """Put ticks on both axes, at most *count* intervals of 1, 2 or 5 times a power of ten."""
    for side in (axes.xaxis, axes.yaxis):
        side.set_major_locator(MaxNLocator(count, steps=[1, 2, 5, 10]))


def log_ticks(axis: Axis, low: float, high: float) -> None:
    """Label a logarithmic *axis* that shows values from *low* to *high* in plain text.

    Matplotlib's own labels are formulas, which pictures do not typeset since a name may have a dollar in it.
    """
    decades = math.log10(high / low)
    steps = (1.0,) if decades > 3.0 else (1.0, 2.0, 5.0)
    axis.set_major_locator(LogLocator(subs=steps, numticks=12) if decades > 1.0 else MaxNLocator(6))
    axis.set_major_formatter(lambda value, _: power(value) if value > 0.0 else "")  # 0 may be a tick out of sight
    axis.set_minor_formatter(NullFormatter())


def power(value: float) -> str:
    """Return a tick label of a logarithmic axis: plain from a thousandth to a million, as a power of ten beyond."""
    if 0.999e-3 <= value < 1e6:
        return f"{value:g}"
    exponent = math.floor(math.log10(value) + 1e-9)
    factor = f"{value / 10.0**exponent:.3g}"
    return ("" if factor == "1" else f"{factor}·") + "10" + str(exponent).translate(_RAISED)


def time_unit(duration: float) -> tuple[float, str]:
    """Return the unit of an axis that shows *duration*, s: its size in seconds, and its name."""
    return next(((size, name) for size, name in ((3600.0, "h"), (60.0, "min")) if duration >= 3.0 * size), (1.0, "s"))


def minus(text: str) -> str:
    """Return *text* with its hyphens as minus signs."""
    return text.replace("-", "\N{MINUS SIGN}")


def label(text: str, longest: int = _LONGEST_LABEL) -> str:
    """Return a text from a file in a form that a picture can show.

    At most *longest* characters, one line, no missing glyphs.
    """
    known = _glyphs()
    shown = "".join(c if ord(c) in known else _MISSING for c in " ".join(text.split()))
    return shown if len(shown) <= longest else shown[: longest - 1] + "\N{HORIZONTAL ELLIPSIS}"


@cache
def _glyphs() -> frozenset[int]:
    """Return the code points that the font of `STYLE_SHEET` can draw."""
    return frozenset(get_font(findfont(FontProperties(family="DejaVu Sans"))).get_charmap())
