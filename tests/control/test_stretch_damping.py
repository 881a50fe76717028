"""Swings in which lines stretch are damped by measured tensions, also late; modes too fast for that are left alone."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np
import pytest

import cablewright as cw
from cablewright.control import velocity
from cablewright.control.path_follower import Target
from cablewright.control.stretch_damping import (
    MOST_RATE,
    UNKNOWN_DELAY,
    DampingLoop,
    StretchDamping,
    StretchState,
    follow,
    listen,
    swings_at,
)
from cablewright.control.velocity import VelocitySettings
from cablewright.foundation.signals import Estimate, SensorFrame, Tensions
from cablewright.live.prints.plan import plan_print, twin_of
from cablewright.machine.sensors.tensions import TensionSensor
from cablewright.models.inertia import mass_matrix
from cablewright.models.statics import Equilibrium, Model
from cablewright.models.stiffness import stiffness
from cablewright.printing.job import Job, Motion
from cablewright.printing.numeric_path import Helix
from cablewright.robot import load
from cablewright.solvers.inverse import solve_inverse

PERIOD = 0.01  # s
LAG = 0.02  # s, of winches
OWN = 0.01  # share of critical damping of each mode
LOOP = DampingLoop(late=0.02, lag=LAG, gain=0.5)
CELLS = StretchDamping("load_cells", LOOP)
HOUSE = Model(load("house-printer"))
STILL = np.zeros(3)


@dataclass(frozen=True)
class Louder(StretchDamping):
    """Damping with a gain that is wrong by a *factor*."""

    factor: float = 2.0

    def added(self, rates: np.ndarray) -> np.ndarray:
        return self.factor * super().added(rates)


def held_at(*place: float) -> Equilibrium:
    return solve_inverse(HOUSE, np.array(place)).checked()


def frame_of(tensions: np.ndarray, now: float) -> SensorFrame:
    return SensorFrame(now, (Tensions("load_cells", now, tensions),))


def swing(
    settings: StretchDamping, held: Equilibrium, *, delay: float = 0.0, softer: float = 1.0, time: float = 5.0
) -> np.ndarray:
    """The largest displacements (k,), m, in each second of a swing that begins with 1 mm along each axis.

    An own integration of the linear platform, whose stiffness is *softer* than the control believes: speeds come late
    by *delay*, s, and winches have a lag; lengths are brought back as a print does it. A reading is 15 ms old when its
    speed acts.
    """
    parts, mass = stiffness(held), mass_matrix(HOUSE.robot, held.pose)
    own = softer * parts.total
    rates, shapes = np.linalg.eig(np.linalg.solve(mass, own))
    drag = mass @ shapes @ np.diag(2.0 * OWN * np.sqrt(rates)) @ np.linalg.inv(shapes)
    axial, along = softer * parts.axial, parts.chords
    late = deque([np.zeros(4)] * (1 + round(delay / PERIOD)))
    place, moving = np.full(3, 1e-3), np.zeros(3)
    lengths, speed = np.zeros(4), np.zeros(4)
    state, found, steps = StretchState(), [], 5
    for k in range(round(time / PERIOD)):
        now = k * PERIOD
        listen(settings, state, frame_of(held.tensions + axial * (along @ place - lengths), now))
        late.append(follow(settings, state, held, STILL, now, PERIOD) - LOOP.gain * lengths)
        asked = late.popleft()
        for _ in range(steps):
            dt = PERIOD / steps
            pull = (axial * lengths) @ along
            moving = moving + dt * np.linalg.solve(mass, pull - own @ place - drag @ moving)
            place = place + dt * moving
            speed = speed + dt * (asked - speed) / LAG
            lengths = lengths + dt * speed
        found.append(np.linalg.norm(place))
    return np.array(found).reshape(-1, round(1.0 / PERIOD)).max(axis=1)


def settling(amplitudes: np.ndarray) -> int:
    """Seconds until a tenth of the first amplitude remains."""
    return int(np.argmax(amplitudes < 0.1 * amplitudes[0]))


@pytest.mark.parametrize("place", [(0.0, 0.0, 1.5), (-4.0, 3.0, 2.0)])
@pytest.mark.parametrize("delay", [0.0, 0.02, UNKNOWN_DELAY])
def test_it_settles_in_less_than_half_of_the_time(place: tuple[float, float, float], delay: float) -> None:
    held = held_at(*place)
    without = math.log(10.0) / (OWN * swings_at(held).rates[0])
    assert 0 < settling(swing(CELLS, held, delay=delay)) <= 0.25 * without


@pytest.mark.parametrize("softer", [0.8, 1.2])  # frequencies by 10 %
def test_it_is_stable_with_wrong_frequencies_and_twice_the_gain_at_40_ms(softer: float) -> None:
    amplitudes = swing(Louder("load_cells", LOOP), held_at(0.0, 0.0, 1.5), delay=UNKNOWN_DELAY, softer=softer)
    assert amplitudes[-1] < 0.02 * amplitudes[0]


def test_a_delay_breaks_it_where_the_margin_says_so() -> None:
    held = held_at(0.0, 0.0, 1.5)
    rates = swings_at(held).rates
    added = CELLS.added(rates)
    assert (added > 0.0).all()
    assert LOOP.holds(rates, added, UNKNOWN_DELAY).all()
    assert LOOP.holds(rates, added, 0.06, margin=0.0).all()
    assert not LOOP.holds(rates, added, 0.2, margin=0.0).all()
    assert swing(CELLS, held, delay=0.06)[-1] < 1e-4
    assert swing(CELLS, held, delay=0.2)[-1] > 1e-3


def test_the_share_is_what_a_mode_gains() -> None:
    held = held_at(0.0, 0.0, 1.5)
    rate = swings_at(held).rates[0]
    amplitudes = swing(CELLS, held, delay=0.02, time=4.0)
    gained = -math.log(amplitudes[2] / amplitudes[0]) / 2.0 / rate - OWN
    assert gained == pytest.approx(CELLS.added(np.array([rate]))[0], rel=0.5)


def test_fast_modes_are_left_undamped_and_reported() -> None:
    rates = 2.0 * np.pi * np.array([0.5, 1.77, 4.0, 8.0, 15.0])
    added = CELLS.added(rates)
    assert (added[:2] >= 0.05).all()
    assert added[2] >= 0.01
    assert (added[3:] == 0.0).all()
    damped, told = CELLS.note(rates)
    assert damped
    assert told == (
        "swings of 0.5 to 4 Hz in which lines stretch are damped by load_cells; "
        "swings of 8 to 15 Hz are too fast to be damped at 40 ms of delay"
    )
    assert not CELLS.note(rates[3:])[0]


def test_the_margin_is_6_db_and_30_degrees() -> None:
    rates = 2.0 * np.pi * np.geomspace(0.2, 5.0, 30)
    for gain in (0.5, 4.0):
        loop = DampingLoop(0.02, LAG, gain)
        added = StretchDamping("load_cells", loop).added(rates)
        assert loop.holds(rates, added).all()
        assert loop.holds(rates, 2.0 * added, margin=0.01).all()


def test_a_steady_pull_and_a_wrong_zero_move_nothing() -> None:
    held, state = held_at(0.0, 0.0, 1.5), StretchState()
    moved = np.zeros(4)
    for k in range(600):
        zeros = np.array([300.0, -50.0, 20.0, 0.0]) * (k > 100)
        listen(CELLS, state, frame_of(held.tensions + zeros, k * PERIOD))
        rates = follow(CELLS, state, held, STILL, k * PERIOD, PERIOD)
        assert np.abs(rates).max() <= MOST_RATE * (1.0 + 1e-12)
        moved = moved + rates * PERIOD
    assert np.abs(moved).max() < 2e-5
    assert np.abs(rates).max() < 1e-8


def test_tensions_that_balance_each_other_move_nothing() -> None:
    held, state = held_at(0.0, 0.0, 1.5), StretchState()
    inner = np.linalg.svd(stiffness(held).chords.T)[2][3] * 200.0
    for k in range(50):
        listen(CELLS, state, frame_of(held.tensions + inner * math.sin(12.0 * k * PERIOD), k * PERIOD))
        assert np.abs(follow(CELLS, state, held, STILL, k * PERIOD, PERIOD)).max() < 1e-9


def test_without_readings_the_swing_is_not_known() -> None:
    held, state = held_at(0.0, 0.0, 1.5), StretchState()
    for k in range(60):
        if k < 30:
            pulled = held.tensions + np.array([20.0, 0.0, -20.0, 0.0]) * math.sin(12.0 * k * PERIOD)
            listen(CELLS, state, frame_of(pulled, k * PERIOD))
        else:
            listen(CELLS, state, frame_of(np.full(4, np.nan), k * PERIOD))
        rates = follow(CELLS, state, held, STILL, k * PERIOD, PERIOD)
        if 10 < k < 30:
            assert rates.any()
    assert not rates.any()
    assert state.filtered is None


def test_a_reading_that_is_repeated_or_of_another_number_of_lines_is_not_the_swing_of_now() -> None:
    held, frozen, short = held_at(0.0, 0.0, 1.5), StretchState(), StretchState()
    pulled = held.tensions + np.array([20.0, 0.0, -20.0, 0.0])
    for k in range(60):
        (reading,) = frame_of(pulled, 0.0).readings
        listen(CELLS, frozen, SensorFrame(k * PERIOD, (reading,)))
        listen(CELLS, short, frame_of(pulled[:3], k * PERIOD))
        rates = [follow(CELLS, state, held, STILL, k * PERIOD, PERIOD) for state in (frozen, short)]
        assert not rates[1].any()
    assert not rates[0].any()
    assert frozen.filtered is None


def test_ramps_that_are_to_stay_are_those_without_damping_to_the_bit() -> None:
    still = VelocitySettings(HOUSE, 10.0, "model", manage_slack=False)
    damped = replace(still, stretch=CELLS)
    place, held = np.array([0.1, 0.0, 1.5]), held_at(0.1, 0.0, 1.5)
    target = Target(place, np.array([0.2, 0.0, 0.0]), 0.0, 1, 0.2, False, False, False)
    estimate = Estimate(0.0, place, STILL, STILL, held.lengths, np.zeros(4), np.zeros(4, dtype=bool), np.full(4, 0.1))
    found = []
    for settings, calms in ((still, True), (damped, False), (damped, True)):
        state = velocity.start(settings)
        pulled = held.tensions + np.array([30.0, 0.0, -30.0, 0.0])
        for k in range(3):
            listen(CELLS, state.stretch, frame_of(held.tensions if k == 0 else pulled, k * PERIOD))
            now = replace(estimate, time=k * PERIOD)
            speeds = velocity.step(settings, state, now, target, PERIOD, calms=calms)
        found.append(speeds)
    np.testing.assert_array_equal(found[0], found[1])
    assert np.abs(found[2] - found[0]).max() > 1e-4


def test_a_print_damps_by_load_cells_where_the_machine_has_them_and_it_is_wanted() -> None:
    ring = Job(
        name="ring",
        helix=Helix(radius=0.3, layers=1, layer_height=0.001, first_height=1.0),
        motion=Motion(print_speed=0.03),
    )
    machine = cw.load_twin("house-printer")
    celled = machine.with_owner(load_cells=TensionSensor(rate=100.0, deviation=5.0, most=6000.0))
    for given, damping, damps in ((machine, True, False), (celled, False, False), (celled, True, True)):
        plan = plan_print(twin_of(HOUSE.robot, ring, given, cw.PrintOptions(damping=damping)))
        assert plan.velocity.damps is damps
        assert any("are damped by load_cells" in note for note in plan.notes) is damps
