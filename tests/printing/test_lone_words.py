"""Words of G-code on lines of their own: a feed holds from its line on, whatever stands beside it."""

from __future__ import annotations

import io

import numpy as np
import pytest

from cablewright.foundation.errors import InputError
from cablewright.printing.gcode import parse

PART = "G1 X0 Y0 Z10\nG1 X100 E5\nG1 Y50 E8\n"


def feeds(head: str, part: str = PART) -> np.ndarray:
    """The feeds of a part after the lines *head*, mm/min."""
    return parse(io.BytesIO(f"G21 G90\n{head}\n{part}".encode())).feed * 6e4


@pytest.mark.parametrize(
    "head",
    [
        "F1200",
        "f1200 ; the feed",
        "N10 F1200",
        "N10 (nothing else)\nN20F1200",
        "S5000 F1200",
        "S5000\nT1\nF1200",
        "M3 S5000 F1200",
        "F1200 M106 S255",
        "T1 M6 F1200",
        "G17 G40 G49 G80 G94 F1200",
    ],
)
def test_feed_before_the_first_motion_holds_as_that_of_the_first_move(head: str) -> None:
    np.testing.assert_allclose(feeds(head), feeds("", PART.replace("Z10", "Z10 F1200")))


def test_feed_alone_after_an_arc_is_no_arc() -> None:
    arc = "G1 X0 Y0\nG2 X10 I5 E1 F600\nF900\nG1 X20 E2\n"
    assert feeds("", arc)[-1] == pytest.approx(900.0)


def test_feed_alone_is_of_the_units_that_hold_there() -> None:
    assert feeds("G20\nF10\nG21")[0] == pytest.approx(254.0)


@pytest.mark.parametrize("head", ["M207 S1 F1200", "M900 F1200", "G29 F1200"])
def test_parameter_of_a_code_that_owns_its_words_is_no_feed(head: str) -> None:
    assert np.isinf(feeds(head)).all()


@pytest.mark.parametrize(
    ("head", "why"),
    [
        ("E5", "axes without a G code"),
        ("X5 F100", "axes without a G code"),
        ("F100 F200", "F is given twice"),
        ("F0", "F must be above 0"),
        ("F", "F has no number"),
    ],
)
def test_words_without_a_meaning_are_rejected(head: str, why: str) -> None:
    with pytest.raises(InputError, match=why):
        feeds(head)
