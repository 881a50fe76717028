"""A picture as PNG for a light and for a dark page: drawn once, each colour then becomes that of the dark page.

White becomes the dark paper of the page, black its light ink, and a tint keeps its hue over the paper. Colours of a
scale (`style.error_colours`, `style.signed_colours`) become those that the 3-D view has on a dark page.
"""

from __future__ import annotations

import io
from functools import cache
from typing import Any, Final

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from PIL import Image

from cablewright.apps import style
from cablewright.apps.report.page import Themed
from cablewright.apps.web.colours import RAMPS
from cablewright.foundation.arrays import Array

PAPER, INK = np.array([[0x14, 0x18, 0x1F], [0xE6, 0xEA, 0xF0]]) / 255.0  # as in page.css
_BYTES: Final = np.array([65536, 256, 1])  # of red, green and blue in a code
_LIFT, _FULLER = 0.35, 0.7  # white added to a full colour; exponent on the share of a tint, which is faint when dark


def themed(drawn: Figure) -> Themed:
    """Return a figure as PNG for a light and for a dark page; the dark one has at most 256 colours, to be small."""
    light, out = style.png(drawn), io.BytesIO()
    with Image.open(io.BytesIO(light)) as image:
        codes = np.asarray(image.convert("RGB"), np.int32) @ _BYTES
    known = np.zeros(1 << 24, np.bool_)
    known[codes] = True
    shades, on_dark = np.flatnonzero(known), np.zeros((1 << 24, 3), np.uint8)
    on_dark[shades] = np.rint(255.0 * dark(shades[:, None] // _BYTES % 256 / 255.0))
    Image.fromarray(on_dark[codes]).quantize(dither=Image.Dither.NONE).save(out, "PNG", optimize=True)
    return light, out.getvalue()


def dark(colours: Any) -> Array:
    """Return *colours* (..., 3 or 4), from 0 to 1, as they are on a dark page; opacity stays.

    A colour is a full colour s over white by the share a: a s + (1 - a). On a dark page s, lifted towards white, or
    towards the ink where it is nearly black, is over the dark paper by the share a^`_FULLER`.
    """
    given, (codes, on_dark) = np.asarray(colours, dtype=np.float64), _scales()
    share = 1.0 - given[..., :3].min(axis=-1, keepdims=True)
    full = np.clip((given[..., :3] - 1.0 + share) / np.maximum(share, 1e-9), 0.0, 1.0)
    black, cover = (1.0 - np.ptp(full, axis=-1, keepdims=True)) ** 2, share**_FULLER
    found = cover * (black * INK + (1.0 - black) * (full + (1.0 - full) * _LIFT)) + (1.0 - cover) * PAPER
    at = np.minimum(np.searchsorted(codes, _code(given)), len(codes) - 1)
    rgb = np.where((codes[at] == _code(given))[..., None], on_dark[at], found)
    return np.concatenate([rgb, given[..., 3:]], axis=-1)


def _code(colours: Array) -> Array:
    return np.asarray(np.rint(255.0 * colours[..., :3]) @ _BYTES)


@cache
def _scales() -> tuple[Array, Array]:
    """Return codes (k,) of the colours of all scales, rising, and their colours (k, 3) on a dark page."""
    light, shades = {"error": style.error_colours(), "signed": style.signed_colours()}, np.arange(256)
    codes, first = np.unique(_code(np.concatenate([each(shades) for each in light.values()])), return_index=True)
    maps = [LinearSegmentedColormap.from_list(name, RAMPS[name]["dark"], len(shades)) for name in light]
    return codes, np.concatenate([each(shades)[:, :3] for each in maps])[first]
