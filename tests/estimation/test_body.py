"""Pose of a rigid platform, on a plant whose errors are known as sigmas only, with seeds that were not used for
tuning."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from tests.bodies import COIL, HELD, BodyPlant, Errors, told

from cablewright.estimation.body import filter as of_body
from cablewright.estimation.body.broken_line import hanging_without
from cablewright.estimation.body.settings import BodySettings
from cablewright.estimation.body.state import BodyState, start
from cablewright.estimation.clock_offset import ClockLeadSettings
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Encoders, Estimate, Inertial, Tensions
from cablewright.models.rotation import angle_between
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.inverse import solve_inverse
from cases import some

ROBOT = load("cogiro")
HOME = np.array([0.3, -0.4, 1.0, 0.0, 0.0, 0.0])
DT = 0.1
NAMES = [line.name for line in ROBOT.lines]


def driven(plant: BodyPlant, settings: BodySettings, steps: int, then: int = 0) -> tuple[BodyState, list[Estimate]]:
    """Drive along a loop by uncorrected lengths, then rest for some steps."""
    state, estimates, model = start(settings, HOME), [], Model(ROBOT)
    turns = 2.0 * math.pi * np.arange(steps + 1) / max(steps, 1)
    places = HOME + np.stack(
        [0.3 * np.sin(turns), 0.3 - 0.3 * np.cos(turns), 0.1 * np.sin(turns), *np.zeros((3, steps + 1))], axis=1
    )
    lengths = solve_inverse(model, places, path=True).checked().lengths
    angles = np.array(
        [[w - COIL.angle(HELD - out) for w, out in zip(plant.wound, row, strict=True)] for row in lengths]
    )
    estimates.append(of_body.step(settings, state, plant.step(np.zeros(ROBOT.m), DT)))
    rates = [*np.diff(angles, axis=0) / DT, *np.zeros((then, ROBOT.m))]
    estimates += [of_body.step(settings, state, plant.step(rate, DT)) for rate in rates]
    return state, estimates


def stands(plant: BodyPlant, settings: BodySettings, state: BodyState) -> Estimate:
    """Stand: the machine is to stop by the third measurement, and by the twelfth it is to know the line."""
    for k in range(12):
        estimate = of_body.step(settings, state, plant.step(np.zeros(ROBOT.m), DT))
        assert bool(state.judged.danger) == (k >= 2)
    assert state.judged.search is None
    return estimate


def off(plant: BodyPlant, estimate: Estimate) -> Array:
    pose, _ = plant.truth
    return np.asarray(estimate.position - pose[:3])


def test_without_errors_the_pose_is_that_of_the_plant() -> None:
    plant = BodyPlant(ROBOT, HOME, 0, Errors(0.0, 0.0, 0.0, 0.0))
    state, estimates = driven(plant, told(ROBOT, cells=False, tilt=False), 40)
    pose, tensions = plant.truth
    assert estimates[-1].position == pytest.approx(pose[:3], abs=2e-5)  # an encoder's count
    assert angle_between(estimates[-1].rotation, pose[3:]) < 1e-4
    assert state.tensions == pytest.approx(tensions, abs=2.0)


@pytest.mark.parametrize("seed", some([901, 902, 903]))
def test_load_cells_find_the_tensions_that_lengths_alone_miss(seed: int) -> None:
    errors = []
    for cells in (True, False):
        plant = BodyPlant(ROBOT, HOME, seed)
        state, _ = driven(plant, told(ROBOT, cells=cells, tilt=cells), 100)
        errors.append(np.abs(state.tensions - plant.truth[1]).max())
    assert errors[0] < 15.0 < 3.0 * errors[0] + 30.0
    assert errors[0] < 0.5 * errors[1]


def test_the_covariance_is_honest() -> None:
    """Mean squares of normalised errors over seeds are between quantiles of a chi-squared distribution."""
    for cells in (True, False):
        found = []
        for seed in range(910, 922):
            plant = BodyPlant(ROBOT, HOME, seed)
            _, estimates = driven(plant, told(ROBOT, cells=cells, tilt=cells), 60)
            covariance = estimates[-1].covariance
            assert covariance is not None
            error = off(plant, estimates[-1])
            found.append(error @ np.linalg.solve(covariance[:3, :3], error))
        assert 3.0 * 12 * 0.25 < sum(found) < 3.0 * 12 * 2.2  # independent seeds: chi-squared of 36


@pytest.mark.parametrize("line", [1, 6])
def test_a_cell_that_has_an_error_is_named_and_left_out(line: int) -> None:
    plant, settings = BodyPlant(ROBOT, HOME, 931), told(ROBOT)
    state, _ = driven(plant, settings, 60)
    plant.cell_offset[line] = 150.0
    estimates = [of_body.step(settings, state, plant.step(np.zeros(8), DT)) for _ in range(10)]
    assert [fault.sentence.split(" contradicts")[0] for fault in estimates[-1].faults] == [
        f"the load cell of line {NAMES[line]}"
    ]
    assert not state.judged.danger
    assert np.linalg.norm(off(plant, estimates[-1])) < 8e-3


@pytest.mark.parametrize(("line", "slip"), [(2, 0.02), (5, -0.02)])
def test_a_line_that_is_longer_than_its_encoder_says_is_named(line: int, slip: float) -> None:
    plant, settings = BodyPlant(ROBOT, HOME, 932), told(ROBOT)
    state, _ = driven(plant, settings, 60)
    plant.slipped[line] = slip
    stands(plant, settings, state)
    named, *alike = state.judged.danger.split("; ")  # of two lines that would show the same, both
    assert NAMES[line] in state.judged.danger.replace(";", "").split()
    assert abs(abs(float(named.split(" mm")[0].split()[-1])) - 1e3 * abs(slip)) < 4.0
    assert len(alike) <= 1


def test_counts_that_jump_have_slipped_and_are_left_out() -> None:
    plant, settings = BodyPlant(ROBOT, HOME, 933), told(ROBOT)
    state, _ = driven(plant, settings, 60)
    before = state.wound.paid.copy()
    plant.counted[3] += 6.0  # rad: no winch turns so far in a step
    for _ in range(3):
        of_body.step(settings, state, plant.step(np.zeros(8), DT))
    assert state.judged.danger.startswith(f"the encoder of line {NAMES[3]} slipped by")
    assert state.wound.paid == pytest.approx(before, abs=1e-3)


def test_a_broken_line_is_named_with_where_the_platform_hangs() -> None:
    plant, settings = BodyPlant(ROBOT, HOME, 934), told(ROBOT)
    state, _ = driven(plant, settings, 60)
    plant.cut = 4
    estimate = stands(plant, settings, state)
    assert state.judged.danger.startswith(f"line {NAMES[4]} pulls nothing: it broke, or left its sheave; the platform")
    assert np.linalg.norm(off(plant, estimate)) < 0.02


def test_without_further_readings_the_wait_for_a_name_ends() -> None:
    plant, settings = BodyPlant(ROBOT, HOME, 935), told(ROBOT)
    state, _ = driven(plant, settings, 60)
    plant.cut = 4
    for _ in range(3):
        of_body.step(settings, state, plant.step(np.zeros(8), DT))
    assert state.judged.search is not None
    for _ in range(60):
        frame = plant.step(np.zeros(8), DT)
        kept = tuple(each for each in frame.readings if isinstance(each, Encoders))
        of_body.step(settings, state, replace(frame, readings=kept))
    assert state.judged.search is None
    assert state.judged.danger.endswith(
        "a line slipped, left its sheave or broke; there are too few readings to say which"
    )


def test_the_equilibria_without_a_line_balance() -> None:
    lengths = solve_inverse(Model(ROBOT), HOME).checked().lengths
    found = hanging_without(ROBOT, lengths, 4, HOME, math.nan)
    assert found
    for each in found:
        assert each.tensions[4] == 0.0
        assert (np.delete(each.tensions, 4) >= 0.0).all()


@pytest.mark.parametrize("lead", [0.03, -0.03])
def test_readings_by_the_clock_of_the_platform_are_used_however_far_it_is_ahead(lead: float) -> None:
    plant = BodyPlant(ROBOT, HOME, 933)
    settings = replace(told(ROBOT), clock=ClockLeadSettings(offset=0.02, drift=1e-5, latency=0.005))
    state = start(settings, HOME)
    for _ in range(20):
        frame = plant.step(np.zeros(ROBOT.m), DT)
        own = [
            each.stamped(each.time - 0.005 + lead) if isinstance(each, Inertial) else each for each in frame.readings
        ]
        estimate = of_body.step(settings, state, replace(frame, readings=tuple(own)))
    assert estimate.faults == ()
    assert state.motion.shaking > 0.0  # the swing of the platform is known
    tilt = state.layout.tilt
    assert (
        np.diag(state.belief.covariance)[tilt].max()
        < 0.9 * np.diag(start(settings, HOME).belief.covariance)[tilt].max()
    )


def test_bad_readings_raise_nothing() -> None:
    plant, settings = BodyPlant(ROBOT, HOME, 935), told(ROBOT)
    state = start(settings, HOME)
    for k in range(30):
        frame = plant.step(np.zeros(8), DT)
        if k % 3 == 1:
            readings = tuple(
                type(each)(each.source, each.time, np.full(8, np.nan)) if isinstance(each, Tensions) else each
                for each in frame.readings
            )
            frame = type(frame)(frame.time, readings)
        estimate = of_body.step(settings, state, frame)
    assert estimate.valid
    assert np.isfinite(estimate.position).all()
