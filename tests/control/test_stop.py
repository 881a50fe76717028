"""A stop goes on by commands, never back: together to rest, held for its time, then brakes."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.control.stop import StopKind, StopSettings, StopState, advance
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import WinchMode

SETTINGS = StopSettings(ramp_time=0.3, hold_time=0.5)
DT = 0.05
SPEEDS = np.array([1.0, -2.0, 0.5])


def commands(stop: StopState, steps: int = 30) -> tuple[np.ndarray, list[WinchMode]]:
    told = [advance(SETTINGS, stop, DT) for _ in range(steps)]
    return np.array([speeds for speeds, _ in told]), [mode for _, mode in told]


def test_winches_come_to_rest_together_are_held_and_then_braked() -> None:
    """One factor for all: the ratios of the speeds stay, so that no line is wound in against the others."""
    stop = StopState(SPEEDS)
    speeds, modes = commands(stop)
    factors = speeds / SPEEDS
    assert np.ptp(factors, axis=1).max() < 1e-12
    assert (np.diff(factors[:, 0]) <= 0.0).all()
    assert modes[:5] == [WinchMode.VELOCITY] * 5
    assert modes.count(WinchMode.HOLD) in (10, 11)  # by rounding
    assert modes[16:] == [WinchMode.OFF] * 14
    assert stop.at_rest(SETTINGS)


@pytest.mark.parametrize(
    ("kind", "ends"), [(StopKind.HOLD, WinchMode.OFF), (StopKind.KEEP, WinchMode.HOLD), (StopKind.BRAKE, WinchMode.OFF)]
)
def test_a_more_urgent_stop_has_no_ramp(kind: StopKind, ends: WinchMode) -> None:
    speeds, modes = commands(StopState(SPEEDS, kind))
    assert not speeds.any()
    assert modes[-1] is ends
    held = {StopKind.HOLD: (10, 11), StopKind.KEEP: (30,), StopKind.BRAKE: (0,)}
    assert modes.count(WinchMode.HOLD) in held[kind]


def test_it_never_goes_back() -> None:
    stop = StopState(SPEEDS)
    commands(stop, 3)
    stop.worsen(StopKind.HOLD)
    stop.worsen(StopKind.RAMP)
    speeds, _ = commands(stop)
    assert not speeds.any()
    for kind in StopKind:
        stop.worsen(kind)
        assert advance(SETTINGS, stop, DT)[1] is WinchMode.OFF  # brakes that are closed stay closed
    assert advance(SETTINGS, StopState.closed(3), DT)[1] is WinchMode.OFF


def test_without_brakes_it_ends_held() -> None:
    stop = StopState(SPEEDS, brakes=False)
    _, modes = commands(stop, 60)
    assert modes[-1] is WinchMode.HOLD
    assert stop.at_rest(SETTINGS)


def test_times_that_are_none_are_rejected() -> None:
    with pytest.raises(InputError, match="ramp_time = 0"):
        StopSettings(ramp_time=0.0)
