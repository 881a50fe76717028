"""Laws of the time law."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cablewright.foundation import memory_mapped
from cablewright.printing.layers import layer_table
from cablewright.printing.path import Samples, sample
from cablewright.printing.timing import corner_speeds, time_law

LEG = st.tuples(st.integers(-40, 40), st.integers(-40, 40), st.integers(-3, 3), st.booleans(), st.integers(1, 900))
PATHS = st.lists(LEG, min_size=1, max_size=15)
STEPS = st.sampled_from([0.011, 0.05, 0.4, 100.0])
ACCELERATIONS = st.sampled_from([0.02, 0.5, 30.0])


def samples_of(read, legs, step: float) -> Samples:
    """A path at 1:20, some moves printing, some travelling, a dwell here and there."""
    text = "M83\nG1 X0.5 E1 F300\n"
    for x, y, z, laying, feed in legs:
        text += f"G1 X{x} Y{y} Z{z} F{feed}{' E1' if laying else ''}\n" + "G4 P300\n" * (feed % 7 == 0)
    return sample(read(text), 20, (0, 0, 0), step, 0.3, 0.5)


def backwards(samples: Samples) -> Samples:
    """The same path from its end to its start."""
    shifted = {
        name: np.concatenate([column[:1], column[1:][::-1]])
        for name in ("speed_limit", "move", "extruding", "layer", "line")
        for column in [getattr(samples, name)]
    }
    shifted["move"][0] = shifted["move"][1]
    return dataclasses.replace(
        samples,
        positions=samples.positions[::-1],
        distance=samples.distance[-1] - samples.distance[::-1],
        dwell=samples.dwell[::-1],
        **shifted,
    )


@given(PATHS, STEPS, ACCELERATIONS)
def test_bounds(read, legs, step, acceleration):
    samples = samples_of(read, legs, step)
    law = time_law(samples, acceleration)
    length, limit = np.diff(samples.distance), samples.speed_limit[1:]
    spent = np.diff(law.time) - samples.dwell[:-1]
    squared = law.speed**2
    assert law.speed[0] == law.speed[-1] == law.time[0] == 0
    assert (law.speed[samples.dwell > 0] == 0).all()
    assert (law.speed[1:] <= limit * (1 + 1e-12)).all()
    assert (law.speed[:-1] <= limit * (1 + 1e-12)).all()
    assert (np.abs(np.diff(squared)) <= 2 * acceleration * length * (1 + 1e-9) + 1e-9).all()
    assert (spent > 0).all()
    assert (spent >= length / limit * (1 - 1e-9)).all()
    assert (spent >= np.abs(np.diff(law.speed)) / acceleration * (1 - 1e-6) - 1e-9).all()
    assert law.duration == pytest.approx(spent.sum() + samples.dwell.sum())


@given(PATHS, STEPS, ACCELERATIONS)
def test_nothing_can_be_faster(read, legs, step, acceleration):
    """At each sample the speed is held by a limit, by the corner, or by the acceleration from or to a neighbour."""
    samples = samples_of(read, legs, step)
    squared = time_law(samples, acceleration).speed ** 2
    limit = samples.speed_limit[1:]
    held = np.minimum(np.minimum(limit[:-1], limit[1:]), corner_speeds(samples, acceleration, 5e-3)[1:-1]) ** 2
    held[samples.dwell[1:-1] > 0] = 0
    gain = 2 * acceleration * np.diff(samples.distance)
    reachable = np.minimum(squared[:-2] + gain[:-1], squared[2:] + gain[1:])
    assert squared[1:-1] == pytest.approx(np.minimum(held, reachable), rel=1e-6, abs=1e-9)


@given(PATHS, STEPS, ACCELERATIONS)
def test_backwards_takes_as_long(read, legs, step, acceleration):
    samples = samples_of(read, legs, step)
    there, back = time_law(samples, acceleration), time_law(backwards(samples), acceleration)
    assert back.duration == pytest.approx(there.duration, rel=1e-9)
    assert back.speed[::-1] == pytest.approx(there.speed, abs=1e-5)


@given(PATHS, ACCELERATIONS)
def test_finer_samples_change_no_time(read, legs, acceleration):
    coarse = time_law(samples_of(read, legs, 100.0), acceleration)
    fine = time_law(samples_of(read, legs, 0.05), acceleration)
    assert fine.duration == pytest.approx(coarse.duration, rel=1e-6)


@pytest.mark.parametrize("step", [0.05, 100.0])
@pytest.mark.parametrize(
    ("length", "duration"),
    [(4.0, 4 / 0.5 + 0.5 / 0.25), (0.64, 2 * math.sqrt(0.64 / 0.25))],  # cruising, or never reaching the limit
)
def test_one_straight_move(length, duration, step, read):
    samples = sample(read(f"G1 X{length * 1000} E1"), step=step, print_speed=0.5)
    assert time_law(samples, 0.25).duration == pytest.approx(duration)


def test_without_any_limit_of_speed(read):
    law = time_law(sample(read("G1 X1000 E1")), 0.25)
    assert law.duration == pytest.approx(2 * math.sqrt(1 / 0.25))


class TestCorners:
    def speed(self, read, x, y, deviation=5e-3) -> float:
        samples = sample(read(f"M83\nG1 X1000 E1\nG1 X{x} Y{y} E1\n"), step=100)
        return float(corner_speeds(samples, 0.5, deviation)[1])

    def test_right_angle_by_junction_deviation(self, read):
        # An arc of radius r that touches both legs passes the corner at r (sqrt 2 - 1).
        assert self.speed(read, 1000, 1000) == pytest.approx(math.sqrt(0.5 * 5e-3 / (math.sqrt(2) - 1)))

    def test_short_moves_bound_the_arc(self, read):
        # Touching at half of the shorter leg, 0.5 m, an arc through a right angle has just that radius.
        assert self.speed(read, 1000, 1000, deviation=10) == pytest.approx(math.sqrt(0.5 * 0.5))

    def test_straight_on_and_straight_back(self, read):
        assert self.speed(read, 2000, 0) == math.inf
        assert self.speed(read, 500, 0) == 0

    def test_sharper_is_slower(self, read):
        around = [self.speed(read, 1000 + 1000 * math.cos(a), 1000 * math.sin(a)) for a in np.linspace(0.1, 3.1, 20)]
        assert (np.diff(around) < 0).all()

    @pytest.mark.parametrize("arc_step", [2e-3, 1e-4])
    def test_a_circle_is_passed_at_its_own_speed_however_it_is_cut(self, read, arc_step):
        samples = sample(read("M83\nG1 X1 E1\n" + "G3 I100 E1\n" * 3, arc_step), step=1)
        law = time_law(samples, 0.5)
        assert law.speed.max() == pytest.approx(math.sqrt(0.5 * 0.1), rel=1e-3)


def test_a_dwell_stops_and_adds(read):
    plain = time_law(sample(read("M83\nG1 X100 E1\nG1 X200 E1\n"), print_speed=0.1), 0.5)
    waiting = time_law(sample(read("M83\nG4 S7\nG1 X100 E1\nG4 S10\nG1 X200 E1\nG4 S5\n"), print_speed=0.1), 0.5)
    assert waiting.speed[2] == 0
    assert waiting.time[1] > 7
    assert waiting.time[3] - waiting.time[2] > 10
    assert waiting.duration == pytest.approx(plain.duration + 22 + 0.1 / 0.5)


def test_arrays_cannot_be_written(read):
    law = time_law(sample(read("G1 X100 E1")), 0.5)
    with pytest.raises(ValueError, match="read-only"):
        law.speed[0] = 1


@pytest.mark.parametrize("jerk", [None, 2.0])
@pytest.mark.parametrize("size", [1, 2, 7])
@settings(max_examples=30)
@given(legs=PATHS, step=STEPS, acceleration=ACCELERATIONS)
def test_a_path_in_blocks_is_the_same_path(read, size: int, jerk: float | None, legs, step, acceleration) -> None:
    def all_of() -> list[np.ndarray]:
        samples = samples_of(read, legs, step)
        law = time_law(samples, acceleration, jerk=jerk)
        layers = layer_table(samples, law)
        own = [*vars(samples).values(), *vars(law).values(), corner_speeds(samples, acceleration, 5e-3)]
        lengths = [layers.extruded_length, layers.travel_length, layers.duration]
        exact = [layers.number, layers.z, layers.first, layers.stop]
        return [*map(np.asarray, own), *exact, np.round(np.stack(lengths), 9)]

    whole = all_of()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(memory_mapped, "BLOCK", size)
        for one, other in zip(whole, all_of(), strict=True):
            np.testing.assert_array_equal(one, other)
