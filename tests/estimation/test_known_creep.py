"""Creep that a robot file describes, by the estimators of a point platform with lidars: that of Merlet 2023 and the
filter."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from cablewright.estimation import slackness, started_filter
from cablewright.estimation.kalman import filter as error_state
from cablewright.estimation.kalman.filter import FirstState
from cablewright.estimation.known_creep import KnownCreep, known_creep
from cablewright.foundation.arrays import Array
from cablewright.foundation.saved_state import load as restore
from cablewright.foundation.saved_state import save
from cablewright.foundation.signals import Command, Scan, SensorFrame
from cablewright.live.estimator_settings import OBSERVERS, started_settings
from cablewright.live.estimators import CreepingEstimator, estimator
from cablewright.machine.simulated.settings import load_twin
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.models.creep import log_response, memory_of, usual_creep, voigt_response
from cablewright.models.statics import Model
from cablewright.robot import Robot, load
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import linearise

ROBOT, TWIN = load("merlet2023"), load_twin("merlet2023")
PLACE = np.array([0.3, -0.4, 1.2])
HOUR_STRAIN = 3e-3  # under the mean of the lines' tensions
SEEN, BLIND = 12.0, 90.0  # s with lidars, and all


def creeping(compliance: float) -> Robot:
    law = usual_creep(compliance)
    lines = (line.model_copy(update={"cable": line.cable.model_copy(update={"creep": law})}) for line in ROBOT.lines)
    return ROBOT.model_copy(update={"lines": tuple(lines)})


def test_a_filter_of_creeping_cables_receives_the_mass_of_the_drum() -> None:
    one = estimator("filter", creeping(1e-12), load_twin("merlet2023").owner, np.zeros(3))
    assert isinstance(one, CreepingEstimator)
    one.weigh(41.0)
    assert one._observed._filtered._state.filter.motion.mass == 41.0
    estimator("paper", creeping(1e-12), load_twin("merlet2023").owner, np.zeros(3)).weigh(41.0)  # it does not use that


def creep_of(compliances: Array) -> KnownCreep:
    memory = memory_of([usual_creep(each) for each in compliances])
    assert memory is not None
    return KnownCreep(memory, len(compliances))


@pytest.mark.parametrize("step", [0.01, 0.3, 1.0, 20.0])
def test_rates_under_a_constant_load_add_up_to_the_closed_form(step: float) -> None:
    compliances, loads = np.array([1e-6, 3e-7]), np.array([200.0, 500.0])
    creep, strain, end = creep_of(compliances), np.zeros(2), 600.0
    for k in range(round(end / step)):
        creep.follow(loads, k * step)
        strain = strain + step * creep.rates
    times = np.array([end])
    response = 0.2 * (voigt_response(times, 60.0) + voigt_response(times, 1200.0)) + 0.6 * log_response(times)
    np.testing.assert_allclose(strain, compliances * loads * response, rtol=2e-3)


def test_loads_that_change_leave_no_drift() -> None:
    """Rates are those of the loads of a second ago; what they missed is made good."""
    laws = [usual_creep(1e-6), usual_creep(3e-7)]
    memory, creep, strain = memory_of(laws), creep_of(np.array([1e-6, 3e-7])), np.zeros(2)
    assert memory is not None
    before = np.zeros(2)
    for k in range(3000):
        loads = np.array([200.0 + 150.0 * np.sin(0.05 * k), 500.0 - 0.1 * k])
        memory.advance(before if k else loads, loads, 0.1 if k else 1e-9)
        creep.follow(loads, 0.1 * k)
        strain = strain + 0.1 * creep.rates
        before = loads
    np.testing.assert_allclose(strain, memory.strain, rtol=0.03)


def test_a_gap_and_a_clock_that_is_set_back_count_nothing_twice() -> None:
    creep, loads = creep_of(np.array([1e-6])), np.array([300.0])
    for now in (0.0, 1.0, 600.0):  # where a rate of a second would be far too large
        creep.follow(loads, now)
    after = creep.rates.copy()
    assert 0.0 < float(after[0]) < 1e-6 * 300.0 / 600.0
    creep.follow(loads, 10.0)
    np.testing.assert_allclose(creep.rates, creep._memory.gain(loads, 1.0))


def test_without_a_law_there_is_none() -> None:
    assert known_creep(ROBOT) is None


@cache
def standing(name: str, described: bool) -> tuple[float, float]:
    """Sinking of an exact machine that creeps, without lidars: the true one, and that of an estimator, m."""
    mean = 200.0
    robot = creeping(HOUR_STRAIN / mean)
    twin = TWIN.with_simulation(quasi_static_period=0.5)
    machine = SimulatedMachine(robot, twin, PLACE, seed=5, plant="quasi-static")
    observer = OBSERVERS[name]
    settings = observer.settings(robot if described else ROBOT, twin.owner, ())
    state, start = observer.start(settings), (np.nan, np.nan)
    while machine.time < BLIND:
        frame = machine.step(Command(machine.time, np.zeros(4)))
        if machine.time > SEEN:
            frame = SensorFrame(frame.time, tuple(each for each in frame.readings if not isinstance(each, Scan)))
        estimate = observer.step(settings, state, frame)
        if machine.time <= SEEN:
            start = machine.truth.position[2], estimate.position[2]
    return float(start[0] - machine.truth.position[2]), float(start[1] - estimate.position[2])


@pytest.mark.parametrize("name", ["paper", "filter"])
def test_without_lidars_a_platform_sinks_as_described(name: str) -> None:
    true, known = standing(name, True)
    _, unknown = standing(name, False)
    assert true > 0.02
    assert known == pytest.approx(true, rel=0.05)
    assert abs(unknown - true) > 0.1 * true  # line angles let the filter see much of it, nothing the other estimator


@pytest.mark.parametrize("name", ["paper", "filter"])
def test_what_crept_is_saved_with_a_print(name: str) -> None:
    robot = creeping(HOUR_STRAIN / 200.0)
    twin = TWIN.with_simulation(quasi_static_period=0.5)
    machine = SimulatedMachine(robot, twin, PLACE, seed=5, plant="quasi-static")
    began = estimator(name, robot, TWIN.owner, PLACE)
    assert isinstance(began, CreepingEstimator)
    while machine.time < 30.0:
        began.step(machine.step(Command(machine.time, np.zeros(4))))
    snapshot = save(began)
    resumed, loads = estimator(name, robot, TWIN.owner, PLACE), np.full(4, 200.0)
    assert isinstance(resumed, CreepingEstimator)
    rested = resumed._creep._memory.gain(loads, 10.0)
    restore(resumed, snapshot)
    again = resumed._creep._memory.gain(loads, 10.0)
    np.testing.assert_allclose(again, began._creep._memory.gain(loads, 10.0))
    assert (again < 0.5 * rested).all()
    resumed._creep.follow(loads, 0.0)
    np.testing.assert_allclose(resumed._creep.rates, resumed._creep._memory.gain(loads, 1.0))
    assert not isinstance(estimator(name, ROBOT, TWIN.owner, PLACE), CreepingEstimator)


def test_the_filter_moves_by_lengths_as_a_robot_whose_mounts_give() -> None:
    """Its J = (u'Ku)^-1 u'K against the statics' own; without mounts in K it would be farther off."""
    soft = (2e-5, 0.0, 1e-5, 0.0)  # of each mount, m/N: not equal, or J would hardly change
    lines = tuple(
        line.model_copy(update={"exit_compliance": each}) for line, each in zip(ROBOT.lines, soft, strict=True)
    )
    robot, off = ROBOT.model_copy(update={"lines": lines}), []
    held = solve_inverse(Model(robot), PLACE).checked()
    exact = linearise(held).per_length
    for described in (robot, ROBOT):
        settings = started_settings(described, TWIN.owner)
        state = started_filter.start(settings).filter
        own = held if described is robot else solve_inverse(Model(ROBOT), PLACE).checked()
        begun = FirstState(
            0.0, PLACE, np.zeros(3), 0.0, own.lengths, np.full(4, 0.05), slackness.start(settings.chain.slackness)
        )
        assert error_state.begin(settings.filter, state, begun)
        off.append(float(np.abs(state.hung.jacobian - exact).max()))
    assert off[0] < 0.1 * float(np.abs(exact).max())
    assert off[0] < 0.3 * off[1]
