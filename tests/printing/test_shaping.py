"""Shaped motion: residual swing, rounding of corners, stops, and its time."""

import dataclasses
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cablewright.foundation.memory_mapped import Room
from cablewright.printing.job import Job, Motion
from cablewright.printing.numeric_path import Helix
from cablewright.printing.path import Samples, sample
from cablewright.printing.running_mean import IntegratedLaw, Kernel
from cablewright.printing.shaping import Shaper
from cablewright.printing.timing import TimeLaw, time_law
from cablewright.robot import load
from cablewright.solvers.swing_free_motion import JobMotion

FREQUENCY = 1.7  # Hz
ACCELERATION, DEVIATION = 0.5, 5e-3
CORNER = [(0, 0), (2000, 0), (2000, 2000)]  # mm
TURNS = {"blunt": (3700, 1000), "right": (2000, 2000), "sharp": (300, 700), "back": (0, 0)}
WRONG = ((1.0, 0.05), (0.9, 0.1), (1.1, 0.1), (0.75, 0.3), (1.25, 0.3), (2.0, 0.1), (3.7, 0.1))
LEGS = st.lists(st.tuples(st.integers(-60, 60), st.integers(-60, 60), st.integers(0, 9)), min_size=2, max_size=14)


def shaper(frequency: float = FREQUENCY, jerk: float | None = None) -> Shaper:
    return Shaper(lambda places: np.full(len(places), 1.0 / frequency), ACCELERATION, DEVIATION, jerk)


def through(read, corners, dwell: dict[int, float] | None = None, step: float = 0.05) -> Samples:
    """A path through corners, mm, at 0.3 m/s, which waits *dwell* s at some of them."""
    text = f"G0 X{corners[0][0]} Y{corners[0][1]} F18000\n"
    for number, (x, y) in enumerate(corners[1:], 1):
        text += f"G1 X{x} Y{y} E1\n" + (f"G4 P{1e3 * dwell[number]:g}\n" if number in (dwell or {}) else "")
    return sample(read("M83\n" + text), 1.0, (0, 0, 0), step, 0.3, 0.3)


def commanded(samples: Samples, law: TimeLaw, times: np.ndarray) -> np.ndarray:
    """Where winches have the nozzle: along the samples, a cubic in time between two."""
    left = law.time + samples.dwell
    row = np.clip(np.searchsorted(law.time, times, side="right") - 1, 0, len(samples) - 2)
    whole = law.time[row + 1] - left[row]
    u = np.clip((times - left[row]) / whole, 0.0, 1.0)
    way = np.diff(samples.distance)[row]
    a, b = law.speed[row] * whole, law.speed[row + 1] * whole
    along = u * (a + u * (3.0 * way - 2.0 * a - b + u * (a + b - 2.0 * way)))
    share = np.clip(along / way, 0.0, 1.0)[:, None]
    return samples.positions[row] + share * (samples.positions[row + 1] - samples.positions[row])


def swing(samples: Samples, law: TimeLaw, frequency: float, begin: float, end: float) -> float:
    """The largest amplitude, m, of an undamped mode, from *begin* to *end*, s, where the command is steady.

    The mode is solved exactly for a command that is straight between times 2 ms apart.
    """
    step = 2e-3
    times = np.arange(0.0, end, step)
    speed = np.diff(commanded(samples, law, times), axis=0) / step
    jumps = np.diff(speed, axis=0, prepend=np.zeros((1, 3)))
    rate = 2.0 * np.pi * frequency
    phasors = np.cumsum(jumps * np.exp(1j * rate * times[:-1, None]), axis=0) / rate  # of the mode about the command
    return float(np.linalg.norm(np.abs(phasors[times[:-1] > begin]), axis=1).max())


def steady(law: TimeLaw, samples: Samples, corner: tuple[float, float], after: float) -> tuple[float, float]:
    """A second at constant speed, *after* s after the corner."""
    nearest = int(np.linalg.norm(samples.positions[:, :2] - np.array(corner) / 1e3, axis=1).argmin())
    begin = float(law.time[nearest] + samples.dwell[nearest]) + after
    return begin, begin + 1.0


@pytest.mark.parametrize("turn", TURNS)
def test_swing_after_a_corner_is_a_tenth_though_frequencies_are_wrong_by_a_tenth(read, turn):
    path = through(read, [(0, 0), (2000, 0), TURNS[turn]])
    plain, (shaped, law) = time_law(path, ACCELERATION, DEVIATION), shaper().shaped(path)
    for factor, most in WRONG:
        around = [factor * FREQUENCY * share for share in (0.9, 0.95, 1.0, 1.05, 1.1)]  # the plain law may be lucky
        before = max(swing(path, plain, each, *steady(plain, path, (2000, 0), 1.5)) for each in around)
        left = swing(shaped, law, factor * FREQUENCY, *steady(law, shaped, (2000, 0), 1.5))
        assert left <= most * before + 1e-4, (factor, left, before)


def test_swing_in_a_planned_stop_is_a_tenth_though_frequencies_are_wrong_by_a_tenth(read):
    path = through(read, [(0, 0), (1000, 0), (2000, 0)], {1: 3.0})
    plain, (shaped, law) = time_law(path, ACCELERATION, DEVIATION), shaper().shaped(path)
    for factor, most in WRONG:
        ends = [float(each.time[at.dwell > 0][0]) for at, each in ((path, plain), (shaped, law))]
        before = swing(path, plain, factor * FREQUENCY, ends[0] + 0.1, ends[0] + 2.9)
        left = swing(shaped, law, factor * FREQUENCY, ends[1] + 0.1, ends[1] + 2.9)
        worst = (
            2.0 * ACCELERATION / (2.0 * np.pi * factor * FREQUENCY) ** 2
        )  # begin and end of the deceleration in step
        assert left <= most * worst, (factor, left, before)


def test_a_planned_stop_is_where_the_path_has_it_and_as_long(read):
    path = through(read, CORNER, {1: 0.7})
    shaped, law = shaper().shaped(path)
    stop = np.flatnonzero(shaped.dwell > 0.0)
    assert len(stop) == 1
    np.testing.assert_allclose(shaped.positions[stop[0]], (2.0, 0.0, 0.0), atol=1e-12)
    assert shaped.dwell[stop[0]] == pytest.approx(0.7)
    assert law.speed[stop[0]] < 1e-9
    np.testing.assert_allclose(law.vector[stop[0]], 0.0, atol=1e-9)


def distances(points: np.ndarray, path: np.ndarray) -> np.ndarray:
    """Distance of each point from the nearest of all segments of a path."""
    begin, way = path[:-1], np.diff(path, axis=0)
    share = ((points[:, None] - begin) * way).sum(axis=2) / (way**2).sum(axis=1)
    near = begin + np.clip(share, 0.0, 1.0)[..., None] * way
    return np.linalg.norm(points[:, None] - near, axis=2).min(axis=1)


@given(LEGS, st.sampled_from([0.6, 1.7, 6.0]))
def test_no_point_is_further_from_the_path_than_the_corner_deviation(read, legs, frequency):
    corners = np.cumsum([(0, 0), *((10 * x, 10 * y) for x, y, _ in legs)], axis=0)
    corners = corners[np.append(True, np.abs(np.diff(corners, axis=0)).sum(axis=1) > 0)]
    if len(corners) < 2:
        return
    waits = {number: 0.1 * wait for number, (_, _, wait) in enumerate(legs, 1) if wait > 7 and number < len(corners)}
    path = through(read, corners.tolist(), waits)
    shaped, law = shaper(frequency).shaped(path)
    between = np.linspace(shaped.positions[:-1], shaped.positions[1:], 4).reshape(-1, 3)
    assert distances(between, path.positions).max() <= DEVIATION * 1.001
    assert (np.diff(law.time) > shaped.dwell[:-1]).all()
    assert (np.diff(shaped.distance) > 0.0).all()
    np.testing.assert_allclose(shaped.positions[[0, -1]], path.positions[[0, -1]], atol=1e-9)
    assert np.linalg.norm(law.vector, axis=1).max() <= 2.0 * ACCELERATION
    assert law.speed.max() <= 0.3 + 1e-9
    assert shaped.dwell.sum() == pytest.approx(path.dwell.sum(), abs=1e-12)


@settings(max_examples=10)
@given(LEGS)
def test_speed_and_acceleration_are_the_derivatives_of_the_place(read, legs):
    corners = np.cumsum([(0, 0), *((10 * abs(x) + 10, 10 * y) for x, y, _ in legs)], axis=0)
    path = through(read, corners.tolist())
    law = time_law(dataclasses.replace(path, dwell=path.dwell + 0.0), ACCELERATION, DEVIATION)
    pieces = IntegratedLaw.of(path, law, ACCELERATION, slice(0, len(path)))
    times = np.linspace(0.6, law.duration - 0.6, 200) if law.duration > 2.0 else np.array([0.7])
    kernel, small = Kernel(np.full(len(times), 0.6), np.full(len(times), 0.27)), 1e-3
    early, late = (pieces.mean(times + shift, kernel) for shift in (-small, small))
    place, velocity, acceleration = pieces.mean(times, kernel)
    np.testing.assert_allclose((late[0] - early[0]) / (2 * small), velocity, atol=2e-5)
    np.testing.assert_allclose((late[1] - early[1]) / (2 * small), acceleration, atol=5e-3)
    ends = np.linspace(-0.5, 0.5, 201)
    sums = np.zeros_like(place)
    for share in (ends[:-1] + ends[1:]) / 2:  # the longer mean, by the midpoint rule, of the shorter
        sums += pieces.mean(times + 0.6 * share, Kernel(np.full(len(times), 0.27), np.full(len(times), 1e-3)))[0]
    np.testing.assert_allclose(sums / 200, place, atol=1e-5)


def test_a_straight_line_costs_its_start_and_end_alone(read):
    path = through(read, [(0, 0), (5000, 0)])
    plain, (shaped, law) = time_law(path, ACCELERATION, DEVIATION), shaper().shaped(path)
    assert law.duration - plain.duration == pytest.approx(1.6 / FREQUENCY, rel=1e-6)
    assert np.abs(shaped.positions[:, 1:]).max() == 0.0


def test_jerk_is_within_its_limit(read):
    path = through(read, [(0, 0), (3000, 0)])
    _, law = shaper(jerk=0.8).shaped(path)
    jerk = np.diff(law.vector[:, 0]) / np.diff(law.time)
    assert 0.3 < np.abs(jerk).max() <= 0.8 + 1e-9


def test_files_and_memory_have_the_same_motion(read, tmp_path):
    path = through(read, [(10 * (i % 7), 10 * (i % 5)) for i in range(3000)], {9: 0.5})
    (one, law), (other, same) = shaper().shaped(path), shaper().shaped(path, Room(tmp_path))
    np.testing.assert_array_equal(one.positions, other.positions)
    np.testing.assert_array_equal(law.time, same.time)


@pytest.mark.parametrize("step", [0.05, 0.005])
def test_a_ring_is_as_fast_as_its_rounding_allows(step):
    """At 9 m/s^2 the mean of a ring of 1 m is 5 mm off at 0.497 m/s: v^2 / r times half the kernel's variance."""
    motion = Motion(print_speed=3.0, travel_speed=3.0, acceleration=9.0)
    job = Job(name="r", helix=Helix(radius=1.0, layers=1, layer_height=0.001, first_height=1.0), motion=motion)
    path = job.samples(job.toolpath(), step)
    shaped, law = dataclasses.replace(shaper(), acceleration=9.0).shaped(path)
    variance = (1.05**2 + 0.55**2) / 12.0 / FREQUENCY**2
    speed = np.sqrt(2.0 * DEVIATION / variance)
    assert law.duration <= 1.1 * 2.0 * np.pi / speed + 2.0 * 1.6 / FREQUENCY
    away = np.abs(np.linalg.norm(shaped.positions[:, :2], axis=1) - 1.0)
    assert away.max() <= DEVIATION * 1.01


def test_many_tiny_corners_cost_no_more_than_they_are(read):
    """Moves of 0.1 mm in a zigzag: the shaper meets hundreds at a time."""
    count = 30_000
    path = through(read, [(0.1 * i, 0.1 * (i % 2)) for i in range(count)])
    begin = time.thread_time()
    shaped, law = shaper().shaped(path)
    assert time.thread_time() - begin < 20.0
    assert len(shaped) < 1.5 * len(path)
    assert law.duration < 1.2 * time_law(path, ACCELERATION, DEVIATION).duration


def test_a_path_in_a_tilted_plane_is_shaped_by_the_modes_in_it(tmp_path: Path) -> None:
    robot = load("maslow4")
    rise = -robot.platform.plane.across[1] / robot.platform.plane.across[2]
    ends = [(0, 0), (100, 0), (100, 30), (0, 30)]
    moves = [f"G1 X{x} Y{y} Z{rise * y:.6f} E{9 * i} F600" for i, (x, y) in enumerate(ends)]
    (tmp_path / "flat.gcode").write_text("\n".join(["G21 G90", ";LAYER:0", *moves]) + "\n")
    job = Job(name="flat", gcode=tmp_path / "flat.gcode")
    found = JobMotion.of(robot, job, job.samples(job.toolpath()))
    assert found.shaper is not None
    assert found.slowest > 1.0
