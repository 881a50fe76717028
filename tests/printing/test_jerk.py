"""The time law with bounded jerk: bounds, limits, and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cablewright.printing.path import Samples, sample
from cablewright.printing.timing import corner_speeds, time_law

LEG = st.tuples(st.integers(-40, 40), st.integers(-40, 40), st.booleans(), st.integers(1, 900))
PATHS = st.lists(LEG, min_size=1, max_size=12)
JERKS = st.sampled_from([0.4, 5.0, 300.0])


def samples_of(read, legs, step: float) -> Samples:
    """A path at 1:20, some moves printing, some travelling, a dwell here and there."""
    text = "M83\nG1 X0.5 E1 F300\n"
    for x, y, laying, feed in legs:
        text += f"G1 X{x} Y{y} F{feed}{' E1' if laying else ''}\n" + "G4 P300\n" * (feed % 7 == 0)
    return sample(read(text), 20, (0, 0, 0), step, 0.3, 0.5)


@given(PATHS, JERKS, st.sampled_from([0.011, 0.05, 0.4]))
@settings(max_examples=60, deadline=None)
def test_speed_acceleration_and_jerk_keep_their_bounds(read, legs, jerk, step):
    samples, acceleration = samples_of(read, legs, step), 0.5
    law = time_law(samples, acceleration, 5e-3, jerk)
    plain = time_law(samples, acceleration, 5e-3)
    corner = corner_speeds(samples, acceleration, 5e-3)
    assert law.speed[0] == law.speed[-1] == law.time[0] == 0.0
    assert (law.speed[samples.dwell > 0] == 0.0).all()
    assert (law.speed[1:] <= samples.speed_limit[1:] * (1 + 1e-6)).all()
    assert (law.speed[:-1] <= samples.speed_limit[1:] * (1 + 1e-6)).all()
    assert (law.speed <= corner * (1 + 1e-6) + 1e-9).all()
    assert law.duration >= plain.duration * (1 - 1e-9)
    left, reached = law.time + samples.dwell, law.time
    spent = reached[1:] - left[:-1]
    assert (spent >= np.diff(samples.distance) / samples.speed_limit[1:] * (1 - 1e-6)).all()
    assert (np.abs(np.diff(law.speed)) <= acceleration * spent * (1 + 1e-6) + 1e-8).all()

    # Means of the acceleration over two intervals, one after the other, differ by at most jerk times half of both.
    means = np.diff(law.speed) / spent
    going = samples.dwell[1:-1] == 0.0
    bound = 0.5 * jerk * (spent[:-1] + spent[1:])
    noise = 1e-8 / np.minimum(spent[:-1], spent[1:])
    assert (np.abs(np.diff(means)) <= bound * (1 + 1e-6) + noise)[going].all()


@pytest.mark.parametrize(("jerk", "length"), [(2.0, 20.0), (40.0, 5.0)])
def test_a_straight_way_takes_as_long_as_its_closed_form(read, jerk: float, length: float) -> None:
    samples = sample(read(f"M83\nG1 X{50 * length} E1 F60000\n"), 20, (0, 0, 0), 0.05, 0.3, 0.5)
    law = time_law(samples, 0.5, 5e-3, jerk)
    assert law.duration == pytest.approx(length / 0.3 + 0.3 / 0.5 + 2 * 0.5 / jerk, rel=1e-9)
    middle = law.time.searchsorted(0.5 * law.duration)
    assert law.speed[middle] == pytest.approx(0.3, rel=1e-9)


def test_a_jerk_without_end_is_the_law_without_bound(read) -> None:
    samples = samples_of(read, [(20, 0, True, 300), (20, 20, True, 300), (0, 3, False, 900)], 0.05)
    plain, law = time_law(samples, 0.5, 5e-3), time_law(samples, 0.5, 5e-3, 1e4)
    np.testing.assert_allclose(law.time, plain.time, atol=2e-3)


def test_backwards_takes_as_long_on_a_straight_way_with_two_feeds(read) -> None:
    there = sample(read("M83\nG1 X20 E1 F900\nG1 X30 E1 F200\n"), 20, (0, 0, 0), 0.05, 0.3, 0.5)
    back = sample(read("M83\nG1 X10 E1 F200\nG1 X30 E1 F900\n"), 20, (0, 0, 0), 0.05, 0.3, 0.5)
    one, other = (time_law(each, 0.5, 5e-3, 3.0).duration for each in (there, back))
    assert one == pytest.approx(other, rel=1e-9)
