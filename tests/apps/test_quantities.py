"""Numbers as a builder reads them."""

import math

import pytest

from cablewright.apps.quantities import allowed_range, count, duration, quantity


def plain(text: str) -> str:
    return text.replace("\N{NO-BREAK SPACE}", " ").replace("\N{MINUS SIGN}", "-")


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.0, "m", "0 m"),
        (1e-9, "m", "< 0.001 mm"),
        (-1e-9, "m", "> -0.001 mm"),
        (0.02663, "m", "26.6 mm"),
        (0.000301, "m", "0.301 mm"),
        (3.5312, "m", "3.53 m"),
        (1234.5, "m", "1234 m"),
        (16710.2, "m", "16.7 km"),
        (172.3, "N", "172 N"),
        (-2580.0, "N", "-2.58 kN"),
        (5150.0, "N", "5.15 kN"),
        (math.pi / 4, "rad", "45°"),
        (0.18234, "m/s", "0.182 m/s"),
        (110.42, "N m", "110 N m"),
        (3.0, "", "3"),
        (1e-7, "N m", "1.00e-07 N m"),
        (math.nan, "N", "not known"),
        (math.inf, "N", "no limit"),
    ],
)
def test_quantity(value, unit, text):
    assert plain(quantity(value, unit)) == text


@pytest.mark.parametrize(
    ("low", "high", "text"),
    [
        (20.0, 5150.0, "20 N to 5.15 kN"),
        (20.0, math.inf, "at least 20 N"),
        (-math.inf, 600.0, "at most 600 N"),
        (-math.inf, math.inf, "no limit"),
    ],
)
def test_allowed_range(low, high, text):
    assert plain(allowed_range(low, high, "N")) == text


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.0, "0 s"),
        (2.34, "2.3 s"),
        (119.0, "119 s"),
        (1085.0, "18 min"),
        (3599.9, "1 h 0 min"),
        (192890.6, "53 h 35 min"),
        (math.nan, "not known"),
    ],
)
def test_duration(seconds, text):
    assert plain(duration(seconds)) == text


def test_count():
    assert plain(count(392000)) == "392 000"
