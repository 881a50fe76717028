"""Jog and take-up where drums wind one line up as they pay another out, so that their torque has any sign."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from cablewright.control.take_up import TakeUp, TakeUpSettings
from cablewright.control.winch_jog import WinchJog, WinchJogSettings
from cablewright.foundation.signals import Encoders, Estimate, SensorFrame, Tensions, frozen

ARMS = np.array([0.04, 0.04])
UNKNOWN = frozen(np.full(3, math.nan))
ESTIMATE = Estimate(0.0, *(UNKNOWN,) * 5, np.zeros(3, np.bool_), UNKNOWN, valid=False)


def frame(now: float, *torques: float) -> SensorFrame:
    """A frame of two drums with three lines or more, of which only torques are known."""
    counts = Encoders(now, np.zeros(2, np.int64))
    return SensorFrame(now, (counts, Tensions("motor_torques", now, UNKNOWN, frozen(np.array(torques)))))


@pytest.mark.parametrize("opposed", [[True, True], [True, False], [False, False]])
def test_a_torque_inwards_is_a_wrong_sign_of_drums_alone_that_are_not_opposed(opposed: list[bool]) -> None:
    settings = TakeUpSettings(("a", "b"), 10.0, 650.0, 0.04, arms=ARMS, opposed=np.array(opposed))
    taken = TakeUp(settings)
    done = taken.step(frame(0.01, -4.0, 0.8), ESTIMATE, 0.01)
    if opposed[0]:
        assert (done.failure, done.finished) == ("", True)
    else:
        assert "line a pulls with -100 N" in done.failure


def test_by_hand_too_a_wrong_sign_is_found_beside_an_opposed_drum() -> None:
    settings = WinchJogSettings(0, 2, 0.02, 15.0, 0.04, np.array([-math.inf, -5.0]), arms=ARMS, opposed=True)
    for line, torques, fails in ((0, (-0.4, 0.8), False), (0, (-0.4, -0.8), True), (1, (-0.4, -0.8), True)):
        jog = WinchJog(replace(settings, line=line, opposed=line == 0))
        jog.lease()
        assert ("pulls with -20 N" in jog.step(frame(0.01, *torques), ESTIMATE, 0.01).failure) == fails


@pytest.mark.parametrize(("speed", "tight"), [(0.02, -0.7), (-0.02, 0.7)])
def test_an_opposed_drum_stops_by_the_line_that_it_reels_in(speed: float, tight: float) -> None:
    for torque in (tight, -tight):
        jog = WinchJog(WinchJogSettings(0, 2, speed, 15.0, 0.04, arms=ARMS, opposed=True))
        jog.lease()
        turned = [jog.step(frame(now, torque, 0.0), ESTIMATE, 0.01).winch_speeds[0] for now in (0.01, 0.02, 0.03)]
        assert (turned[-1] == 0.0) == (torque == tight)
        assert turned[-1] * speed >= 0.0
