"""Lines that vibrate about as slowly as the platform are named: from there on its modes are others than the model's."""

from __future__ import annotations

import numpy as np
import pytest
from tools.motion.line_vibration import compared, square

from cablewright.studies.checks.line_vibration import FACTOR, slow_lines


@pytest.mark.parametrize(("side", "mass"), [(16.0, 1600.0), (8.0, 400.0), (8.0, 240.0)])
def test_from_the_factor_on_the_slowest_mode_is_that_of_a_fine_mesh(side: float, mass: float) -> None:
    own, slowest, found, share = compared(side, mass)
    assert own > 0.75 * FACTOR * slowest
    assert slowest == pytest.approx(found, rel=3e-3)
    assert share > 0.99


def test_below_it_the_mesh_has_another() -> None:
    own, slowest, found, _ = compared(16.0, 100.0)
    assert own < FACTOR * slowest
    assert slowest < 0.95 * found


def test_lines_are_named_within_the_factor_alone() -> None:
    places = np.linspace((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), 300)
    assert list(slow_lines(square(8.0, 1600.0), places, None)) == []
    (found,) = slow_lines(square(16.0, 100.0), places, None)
    assert found.startswith("own vibration of line 0, 1, 2, 3: 2.68 Hz is less than 2 times")
    aside = np.array([[2.5, 0.0, 0.0]] * 3)
    (found,) = slow_lines(square(8.0, 400.0), aside, None)  # the longer ones alone
    assert found.startswith("own vibration of line 0, 3: ")
