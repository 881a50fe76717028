"""On the nonlinear plant a tenth of the swing is left after corners, stops, pauses and jogs, with wrong frequencies."""

from __future__ import annotations

from pathlib import Path

import pytest
from tools.motion.shaped_stops import printed

pytestmark = pytest.mark.slow


def test_a_tenth_of_the_swing_is_left_though_frequencies_are_wrong_by_a_tenth(tmp_path: Path) -> None:
    wild = printed(0.3, "none", 1.0, tmp_path).found()
    for factor, most in ((0.9, 0.1), (1.1, 0.1), (0.75, 0.3), (1.25, 0.3)):
        calm = printed(0.3, "auto", factor, tmp_path).found()
        for name, left, before in zip(("corner", "stop", "pause", "jog"), calm, wild, strict=True):
            assert left <= most * before, (name, factor)
