"""What no model has, each part by itself: against closed forms, oracles and laws."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest

from cablewright.kernels.layout import COLUMNS, PLATFORM, STATE, Packed
from cablewright.machine.simulated.unmodelled.cable_creep import CableCreep, step_response
from cablewright.machine.simulated.unmodelled.cable_hysteresis import CableHysteresis
from cablewright.machine.simulated.unmodelled.exit_mounts import ExitMountState
from cablewright.machine.simulated.unmodelled.gear_backlash import GearBacklash
from cablewright.machine.simulated.unmodelled.gusts import Gusts
from cablewright.machine.simulated.unmodelled.sheave_slip import STICKS, SheaveSlip
from cablewright.models.creep import HOUR, LOG_BEGIN, LOG_SHARE, RETARDATIONS, VOIGT_SHARES
from cablewright.models.packed_views import LineNumbers, LineStates

COMPLIANCES = np.array([1e-6, 2e-6, 0.5e-6])  # 1/N after an hour
Array = np.ndarray


def crept(loads: Array, times: Array) -> CableCreep:
    """Lines under *loads* (k, 3) at *times* (k,), linear in between."""
    creep = CableCreep(COMPLIANCES)
    for i in range(1, len(times)):
        creep.advance(loads[i - 1], loads[i], times[i] - times[i - 1])
    return creep


@pytest.mark.parametrize("time", [1.0, 30.0, HOUR, 86400.0, 1e6])
def test_creep_answers_a_step_by_its_closed_form(time: float) -> None:
    load, (begin, share) = np.array([100.0, 100.0, 300.0]), (LOG_BEGIN, LOG_SHARE)
    creep = CableCreep(COMPLIANCES)
    creep.advance(load, load, time)
    with mpmath.workdps(30):
        parts = zip(RETARDATIONS, VOIGT_SHARES, strict=True)
        voigt = sum(s * mpmath.expm1(-time / t) / mpmath.expm1(-HOUR / t) for t, s in parts)
        exact = float(voigt + share * mpmath.log(1 + time / begin) / mpmath.log(1 + HOUR / begin))
    assert step_response(np.array([time]))[0] == pytest.approx(exact, rel=1e-12)
    assert creep.strain == pytest.approx(load * COMPLIANCES * exact, rel=1e-3)


def test_shares_of_creep_after_an_hour_are_all() -> None:
    assert sum(VOIGT_SHARES) + LOG_SHARE == pytest.approx(1.0)
    assert step_response(np.array([0.0, HOUR])) == pytest.approx([0.0, 1.0])


def test_creep_does_not_depend_on_the_steps() -> None:
    ends = np.array([[0.0, 50.0, 400.0], [300.0, 50.0, 20.0]])
    for whole in (0.2, 60.0, 2e4):
        once = crept(ends, np.array([0.0, whole]))
        for count in (2, 7, 100):
            shares = np.linspace(0.0, 1.0, count + 1) ** 2
            parts = crept(ends[0] + shares[:, None] * (ends[1] - ends[0]), whole * shares)
            assert parts.stretched == pytest.approx(once.stretched, rel=1e-9, abs=1e-18)


def test_creep_adds_up_and_remembers() -> None:
    random = np.random.default_rng(1)
    times = np.cumsum(random.uniform(0.1, 500.0, 40))
    one, two = random.uniform(0.0, 400.0, (2, 40, 3))
    assert crept(one + 3.0 * two, times).strain == pytest.approx(
        crept(one, times).strain + 3.0 * crept(two, times).strain
    )
    # a load taken off again is a step up and one down (Boltzmann), and is not forgotten immediately
    load, none = np.full(3, 100.0), np.zeros(3)
    creep = CableCreep(COMPLIANCES)
    creep.advance(load, load, HOUR)
    creep.advance(none, none, 600.0)
    up, down = step_response(np.array([HOUR + 600.0, 600.0]))
    assert creep.strain == pytest.approx(100.0 * COMPLIANCES * (up - down), rel=1e-3)
    assert (creep.strain > 0.1 * 100.0 * COMPLIANCES).all()


def test_creep_gains_no_energy_over_a_cycle() -> None:
    times = np.linspace(0.0, 4000.0, 4001)
    loads = np.repeat(200.0 + 150.0 * np.sin(2.0 * np.pi * times / 1000.0)[:, None], 3, axis=1)
    creep, strains = CableCreep(COMPLIANCES), [np.zeros(3)]
    for i in range(1, len(times)):
        creep.advance(loads[i - 1], loads[i], 1.0)
        strains.append(creep.strain)
    work = (0.5 * (loads[1:] + loads[:-1]) * np.diff(strains, axis=0))[-1000:].sum(axis=0)
    assert (work > 0.0).all()


def hysteresis() -> CableHysteresis:
    return CableHysteresis(5e-4, 100.0, np.array([100.0]), np.array([1e-5]))


def cycled(loads: Array) -> Array:
    """Strains (k,) after which the cable has come to rest at each of *loads* (k,)."""
    cable, strains = hysteresis(), []
    for load in loads:
        cable.follow(np.array([load]))
        strains.append(cable.settled[0])
    return np.array(strains)


def test_a_large_cycle_of_load_has_a_loop_of_the_given_width() -> None:
    up, down = np.linspace(0.0, 300.0, 301), np.linspace(300.0, 0.0, 301)
    strains = cycled(np.concatenate([up, down, up, down]))[602:]
    width = strains[301:][::-1] - strains[:301]
    assert width.max() == pytest.approx(5e-4, rel=1e-9)
    assert (width >= -1e-15).all()
    assert width[[0, -1]] == pytest.approx([0.0, 0.0], abs=1e-15)


def test_hysteresis_takes_energy_over_any_closed_cycle() -> None:
    random = np.random.default_rng(2)
    for _ in range(50):
        turns = random.uniform(0.0, 300.0, 6)
        cycle = np.concatenate([np.linspace(a, b, 200) for a, b in zip(turns, np.roll(turns, -1), strict=True)])
        loads, strains = np.tile(cycle, 3), cycled(np.tile(cycle, 3))
        work = (0.5 * (loads[1:] + loads[:-1]) * np.diff(strains))[-len(cycle) :].sum()
        assert work >= -1e-12
        assert strains[-1] == pytest.approx(strains[-1 - len(cycle)], abs=1e-15)  # the loop is closed


def test_hysteresis_does_not_depend_on_the_steps_between_turns() -> None:
    fine = cycled(np.concatenate([np.linspace(100.0, 180.0, 999), np.linspace(180.0, 60.0, 999)]))
    assert cycled(np.array([180.0, 60.0])) == pytest.approx(fine[[998, -1]], abs=1e-18)


def test_strain_arrives_where_the_load_leads_it() -> None:
    cable = hysteresis()
    for _ in range(60):
        cable.follow(np.array([190.0]))
    assert cable.strain == pytest.approx(cable.settled)


STRAIGHT, PLANES = np.zeros(1), np.array([[1.0, 0.0, 4.0, 0.0]])


def packed_of(lines: Array) -> Packed:
    """The packed *lines* of a plain robot."""
    return Packed(3, lines, np.zeros(PLATFORM), None)


def one_line(radius: float, free: float, angle: float = -0.5, dead: float = -0.5 * math.pi) -> tuple[Array, Array]:
    """A packed line with dead span, that leaves downwards at *angle*, and its state with *free* m after the sheave."""
    lines, states = np.zeros((1, COLUMNS)), np.zeros((1, STATE))
    numbers, state = LineNumbers(lines), LineStates(states)
    numbers.radius, numbers.side, numbers.unknowns, numbers.spans = radius, 1.0, 5.0, 1.0
    numbers.pulls = 1.0
    numbers.free_compliance = numbers.dead_compliance = 1e-5
    state.free_length, state.dead_length, state.free_angle, state.dead_angle = free, 3.0, angle, dead
    state.log_tension = math.log(200.0)
    return lines, states


@pytest.mark.parametrize("radius", [0.0, 0.05])
@pytest.mark.parametrize("angle", [-1.4, -0.3, 0.9])
def test_a_sheave_divides_tensions_by_the_capstan_formula(radius: float, angle: float) -> None:
    lines, states = one_line(radius, 5.0, angle)
    sheaves = SheaveSlip(0.03, states, STRAIGHT)
    mu = -math.log(0.97) / (0.5 * math.pi)
    for way, sign in ((0.5, -1.0), (-0.5, 1.0)):  # paid out: the platform's side pulls the cable through
        states[0, 2] += way
        turned = 0.5 * math.pi - angle  # from straight up to *angle*
        assert sheaves.slide(packed_of(lines), states, PLANES)[0] == pytest.approx(
            math.exp(sign * mu * turned), rel=1e-12
        )
    assert SheaveSlip(0.03, one_line(0.0, 5.0, 0.0)[1], STRAIGHT)._rate * 0.5 * math.pi == pytest.approx(
        -math.log(0.97)
    )


def test_where_the_motion_turns_round_tension_does_not_jump() -> None:
    lines, states = one_line(0.05, 5.0)
    sheaves, ratios = SheaveSlip(0.03, states, STRAIGHT), []
    for way in 1e-5 * np.concatenate([np.ones(300), -np.ones(600), np.ones(600)]):
        states[0, 2] += way
        ratios.append(sheaves.slide(packed_of(lines), states, PLANES)[0])
    steps = np.abs(np.diff(ratios))
    full = max(ratios) - min(ratios)
    assert full > 0.03
    assert steps.max() < 0.03 * full
    assert ratios[299] == min(ratios)
    # after the way back over twice what the stiffest element sticks, it is the same again: no drift
    assert ratios[-1] == pytest.approx(ratios[299], rel=1e-12)
    assert 2.0 * STICKS.max() < 3e-3


def test_friction_takes_energy_over_any_closed_way() -> None:
    random = np.random.default_rng(3)
    lines, states = one_line(0.05, 5.0)
    for _ in range(30):
        turns = random.uniform(-3e-3, 3e-3, 5)
        way = np.concatenate([np.linspace(a, b, 100) for a, b in zip(turns, np.roll(turns, -1), strict=True)])
        sheaves, ratios = SheaveSlip(0.1, states, STRAIGHT), []
        for off in np.tile(way, 3):
            states[0, 2] = 5.0 + off
            ratios.append(sheaves.slide(packed_of(lines), states, PLANES)[0])
        paid = np.tile(way, 3)
        force = 1.0 - 0.5 * (np.array(ratios)[1:] + np.array(ratios)[:-1])  # on the cable, against its motion out
        assert (force * np.diff(paid))[-len(way) :].sum() >= -1e-12


def test_friction_does_not_depend_on_the_steps_between_turns() -> None:
    lines, states = one_line(0.05, 5.0)
    coarse, fine = SheaveSlip(0.03, states, STRAIGHT), SheaveSlip(0.03, states, STRAIGHT)
    for way in (0.7e-3, -0.4e-3, 0.3e-3):
        for part in range(1, 101):
            between = states.copy()
            between[0, 2] += way * part / 100.0
            last = fine.slide(packed_of(lines), between, PLANES)
        states = between
        assert coarse.slide(packed_of(lines), states, PLANES) == pytest.approx(last, rel=1e-12)


@pytest.mark.parametrize("compliance", [1e-5, [[3e-5, 1e-5, 0.0], [1e-5, 2e-5, 0.0], [0.0, 0.0, 1e-6]]])
def test_an_exit_is_displaced_by_its_forces(compliance: object) -> None:
    lines, states = one_line(0.0, 5.0, angle=-0.5, dead=-1.5)
    before, planes = lines.copy(), np.array([[0.6, 0.8, 4.0, -2.0]])
    matrix = np.eye(3) * compliance if isinstance(compliance, float) else np.array(compliance)
    exits = ExitMountState(matrix[None])
    for _ in range(80):  # without a platform that answers the tension stays as it is
        moved = exits.give(packed_of(lines), states, planes, np.array([1.03]))
    assert moved < 1e-12
    flat = np.array([0.6, 0.8])
    free = np.array([*(math.cos(-0.5) * flat), math.sin(-0.5)])
    dead = np.array([*(math.cos(-1.5) * flat), math.sin(-1.5)])
    expected = matrix @ (200.0 * (free + 1.03 * dead))
    assert exits.displaced[0] == pytest.approx(expected, abs=1e-11)
    numbers, were = LineNumbers(lines), LineNumbers(before)
    assert (numbers.exit_point - were.exit_point)[0] == pytest.approx(expected, abs=1e-11)
    # the winch, relative to the exit point, has stayed
    assert (numbers.winch_height - were.winch_height)[0] == pytest.approx(-expected[2], abs=1e-11)
    assert (numbers.winch_distance - were.winch_distance)[0] == pytest.approx(-expected[:2] @ flat, abs=1e-11)


def test_a_cantilever_gives_by_beam_theory() -> None:
    # a post of steel 3 m high, box 100 x 100 x 4 mm: C = h^3 / 3 EI across it; along it h / EA
    bending = 3.0**3 / (3.0 * 210e9 * (0.1**4 - 0.092**4) / 12.0)
    along = 3.0 / (210e9 * (0.1**2 - 0.092**2))
    lines, states = one_line(0.0, 5.0, angle=0.0)
    exits = ExitMountState(np.diag([bending, bending, along])[None])
    LineNumbers(lines).unknowns = 3.0  # the winch is on the post: only the free span bends it
    for _ in range(80):
        exits.give(packed_of(lines), states, np.array([[1.0, 0.0, 4.0, 0.0]]), np.ones(1))
    assert exits.displaced[0] == pytest.approx([200.0 * bending, 0.0, 0.0], abs=1e-12)
    assert 1e-5 < bending < 2e-5  # m/N: of the size of the rough severity


def test_a_gear_loses_its_backlash_only_where_no_line_pulls() -> None:
    gears = GearBacklash(0.01, 10.0, np.zeros(2))
    pulls = np.array([50.0, 1.0])
    wound = np.cumsum([-0.004, -0.004, -0.004, 0.005, 0.005, 0.005])  # pays out, then reels in
    lags = []
    for angle in wound:
        gears.turn(np.full(2, angle), pulls)
        lags.append(gears.lag.copy())
    assert np.array(lags) == pytest.approx(np.array([[0.0] * 6, [0.004, 0.008, 0.01, 0.005, 0.0, 0.0]]).T)
    gears.turn(np.full(2, wound[-1] - 0.004), np.full(2, 1.0))
    assert gears.lag == pytest.approx([0.004, 0.004])
    gears.turn(np.full(2, wound[-1] - 0.004), np.full(2, 11.0))  # a line that pulls again takes its drum along
    assert gears.lag == pytest.approx([0.0, 0.0])


@pytest.mark.parametrize("period", [0.01, 0.2])
def test_gusts_have_the_given_force_and_correlation_time(period: float) -> None:
    gusts = Gusts(3.0, 2.0, np.random.default_rng(4))
    forces = np.array([gusts.blow(period) for _ in range(round(4000.0 / period))])
    assert math.sqrt((forces**2).sum(axis=1).mean()) == pytest.approx(3.0, rel=0.06)
    lag = round(2.0 / period)
    memory = (forces[lag:] * forces[:-lag]).sum(axis=1).mean() / (forces**2).sum(axis=1).mean()
    assert memory == pytest.approx(math.exp(-1.0), abs=0.06)
