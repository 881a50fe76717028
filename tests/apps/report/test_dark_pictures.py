"""Pictures for dark pages: paper, ink, contrast, and the colours of the 3-D view."""

from __future__ import annotations

import io
import re

import matplotlib.image
import numpy as np
import pytest
from matplotlib.colors import to_rgb

from cablewright.apps import style
from cablewright.apps.dark_pictures import INK, PAPER, dark, themed
from cablewright.apps.report.page import bundled, picture
from cablewright.apps.web.colours import RAMPS


def luminance(colour) -> float:
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in colour]
    return float(np.dot([0.2126, 0.7152, 0.0722], linear))  # WCAG 2.1


def contrast(one, other) -> float:
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


@pytest.fixture(scope="module")
def drawn():
    with style.drawing():
        figure, axes = style.axes(4.0, 3.0)
        axes.plot([0.0, 1.0], [0.0, 1.0], color=style.RED, linewidth=12.0)
        mesh = axes.pcolormesh([0.0, 0.4], [0.6, 1.0], [[0.0]], cmap=style.error_colours(), vmin=0.0, vmax=1.0)
        figure.colorbar(mesh, ax=axes)
        return themed(figure)


def pixels(png: bytes):
    return matplotlib.image.imread(io.BytesIO(png))[..., :3]


def test_white_is_paper_and_black_is_ink_and_opacity_stays():
    np.testing.assert_allclose(dark([[1.0, 1.0, 1.0, 0.3], [0.0, 0.0, 0.0, 0.7]]), [[*PAPER, 0.3], [*INK, 0.7]])


def test_paper_is_that_of_the_page(drawn):
    paper = re.findall(r"--paper: (#[0-9a-f]{6})", bundled("page.css"))[1]
    np.testing.assert_allclose(PAPER, to_rgb(paper))
    np.testing.assert_allclose(pixels(drawn[0])[0, 0], 1.0)
    np.testing.assert_allclose(pixels(drawn[1])[0, 0], PAPER, atol=0.01)


def test_curves_and_text_are_seen_on_both_papers():
    for colour in (*style.COLOURS, style.SKY, style.PINK, style.YELLOW):
        assert contrast(dark(to_rgb(colour)), PAPER) >= 2.5, colour
    assert contrast(dark(to_rgb(style.INK)), PAPER) >= 7.0


def test_scales_have_the_colours_of_the_view_in_three_dimensions(drawn):
    for name, scale in (("error", style.error_colours()), ("signed", style.signed_colours())):
        for end, at in ((0, 0), (-1, 255)):
            np.testing.assert_allclose(dark(scale(at)[:3]), to_rgb(RAMPS[name]["dark"][end]), atol=0.01)
    found = np.abs(pixels(drawn[1]) - to_rgb(RAMPS["error"]["dark"][0])).max(axis=-1) < 0.02
    assert found.mean() > 0.02, "the cell with the smallest value"


def test_a_page_shows_the_picture_of_its_scheme_without_a_filter(drawn):
    html = picture(drawn, "a line", "caption")
    assert re.search(r'<picture><source srcset="data:image/png[^"]+" media="[^"]*dark[^"]*"><img src="data:', html)
    assert "filter" not in bundled("page.css")
    assert len(drawn[1]) < len(drawn[0])


def test_the_same_picture_has_the_same_bytes(drawn):
    with style.drawing():
        figures = [style.axes(2.0, 2.0)[0] for _ in range(2)]
        assert themed(figures[0]) == themed(figures[1])
