"""What the tests of printing share: G-code from a text."""

import io
from collections.abc import Callable

import pytest

from cablewright.printing.gcode import parse
from cablewright.printing.toolpath import Toolpath


def read_text(text: str | bytes, arc_step: float = 1e-3) -> Toolpath:
    return parse(io.BytesIO(text.encode() if isinstance(text, str) else text), arc_step)


@pytest.fixture(scope="session")
def read() -> Callable[..., Toolpath]:
    """Parse a text; a line that extrudes is for the test to give."""
    return read_text


@pytest.fixture(scope="session")
def points() -> Callable[..., list[tuple[float, ...]]]:
    """End points, in mm, of the moves a text makes before a last extruding move that only makes the file valid."""

    def end_points(text: str, arc_step: float = 1e-3) -> list[tuple[float, ...]]:
        end = read_text(text + "\nG21\nG90\nM83\nG1 X999 Y999 Z999 E1\n", arc_step).end[:-1]
        return [tuple(float(v) for v in row) for row in (end * 1e3).round(9)]

    return end_points
