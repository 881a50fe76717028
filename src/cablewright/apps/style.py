"""How every picture looks: colours told apart by all eyes, one font, units on every axis; and how it becomes PNG.

Matplotlib's object interface with Agg: no window, no figure that outlives its function.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Colormap, ListedColormap
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font

# Okabe and Ito's palette, the colours a picture means something by.
BLUE: Final = "#0072b2"
ORANGE: Final = "#e69f00"
GREEN: Final = "#009e73"
RED: Final = "#d55e00"
INK: Final = "#1c2430"
GREY: Final = "#8a93a0"

_DPI: Final = 150
_LONGEST_LABEL: Final = 28
_MISSING: Final = "\N{WHITE SQUARE}"

_STYLE: Final[Any] = {
    "font.family": ["DejaVu Sans"],  # comes with matplotlib: the same picture everywhere
    "font.size": 9.0,
    "text.parse_math": False,  # a name with dollars is a name
    "axes.formatter.useoffset": False,
    "axes.titlesize": 10.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.edgecolor": GREY,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e4e8ed",
    "grid.linewidth": 0.7,
    "xtick.color": GREY,
    "ytick.color": GREY,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "text.color": INK,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.6,
    "lines.solid_capstyle": "round",
}


@contextmanager
def drawing() -> Iterator[None]:
    """Give matplotlib this style, whatever the user's own settings are, and give those back afterwards.

    The settings are the process's: draw in one thread at a time.
    """
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_STYLE)
        yield


def figure(width: float, height: float) -> Figure:
    """Return an empty figure of that size in inches. Call within `drawing`."""
    made = Figure(figsize=(width, height), dpi=_DPI, layout="constrained", facecolor="white")
    FigureCanvasAgg(made)
    return made


def png(drawn: Figure) -> bytes:
    """Return the figure as a PNG: the same bytes for the same picture, with neither date nor program in it."""
    out = io.BytesIO()
    drawn.savefig(out, format="png", metadata={"Software": None}, pil_kwargs={"compress_level": 9})
    return out.getvalue()


@cache
def error_colours() -> Colormap:
    """Colours of an error, from dark blue (small) to orange (large): all of them dark enough to be seen on white."""
    plasma = mpl.colormaps["plasma"]
    return ListedColormap(plasma(np.linspace(0.0, 0.82, 256)), name="error")


@cache
def stress_colours() -> Colormap:
    """Colours of a stress, from pale blue (none) over green to red: a part that bears nothing is seen too."""
    turbo = mpl.colormaps["turbo"]
    return ListedColormap(turbo(np.linspace(0.06, 0.92, 256)), name="stress")


def label(text: str, longest: int = _LONGEST_LABEL) -> str:
    """Return a foreign text as a picture can show it: short, one line, no missing glyphs."""
    known = _glyphs()
    shown = "".join(c if ord(c) in known else _MISSING for c in " ".join(text.split()))
    return shown if len(shown) <= longest else shown[: longest - 1] + "\N{HORIZONTAL ELLIPSIS}"


@cache
def _glyphs() -> frozenset[int]:
    """Code points that the font of `_STYLE` can draw."""
    return frozenset(get_font(findfont(FontProperties(family="DejaVu Sans"))).get_charmap())
