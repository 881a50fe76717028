"""Rigid platforms whose cables creep and whose mounts give: as described, and how far the covariance expects it off."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np
import pytest
from scipy import stats
from scipy.stats import multivariate_normal
from tests.bodies import BodyPlant, told

from cablewright.estimation.body import filter as of_body
from cablewright.estimation.body.creep import ASSUMED, LoadPath
from cablewright.estimation.body.estimated_constants import load
from cablewright.estimation.body.law_sizes import LawSize, averaged, law_sizes
from cablewright.estimation.body.measurement import pose_covariance, slopes_of
from cablewright.estimation.body.settings import BodySettings, Deviations
from cablewright.estimation.body.state import BodyState, set_load, start
from cablewright.foundation.arrays import Array
from cablewright.foundation.saved_state import load as restore
from cablewright.foundation.saved_state import save
from cablewright.foundation.signals import Command, Encoders, Estimate, SensorFrame
from cablewright.live.estimators import estimator
from cablewright.machine.settings import MachineSettings
from cablewright.machine.simulated.settings import load_twin
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.models.creep import HOUR, log_response, scaled_creep, usual_creep, voigt_response
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.robot import load as load_robot
from cablewright.robot.cable import Creep
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cases import often

ROBOT = load_robot("cogiro")
HOME = np.array([0.3, -0.4, 1.0, 0.0, 0.0, 0.0])
STILL = np.zeros(ROBOT.m, dtype=np.int64)
SURE = Deviations(creep=1e-9, hysteresis=1e-9, exit_compliance=1e-12)


@cache
def mean_tension() -> float:
    return float(solve_inverse(Model(ROBOT), HOME).checked().tensions.mean())


def creeping(law: Creep) -> Robot:
    lines = (line.model_copy(update={"cable": line.cable.model_copy(update={"creep": law})}) for line in ROBOT.lines)
    return ROBOT.model_copy(update={"lines": tuple(lines)})


def stood(settings: BodySettings, seconds: float, period: float = 1.0) -> tuple[BodyState, Estimate]:
    """Stand at home by encoders alone."""
    state = start(settings, HOME)
    for k in range(round(seconds / period) + 1):
        estimate = of_body.step(settings, state, SensorFrame(k * period, (Encoders(k * period, STILL),)))
    return state, estimate


@pytest.mark.parametrize("seconds", [60.0, 900.0])
def test_a_platform_that_stands_sinks_by_the_closed_form(seconds: float) -> None:
    """Loads are constant but for what little the sinking changes: strain is load times response, motion J dl."""
    law = usual_creep(2e-4 / mean_tension())
    settings = told(creeping(law), cells=False, tilt=False)
    state, estimate = stood(settings, seconds)
    held = solve_inverse(settings.model, HOME).checked()
    times = np.array([seconds])
    voigt = [c * voigt_response(times, t)[0] for c, t in zip(law.compliances, law.retardations, strict=True)]
    strain = held.tensions * (sum(voigt) + law.logarithmic * log_response(times)[0])
    assert state.creep.described is not None
    assert state.creep.described.strain == pytest.approx(strain, rel=0.02)
    found = slopes_of(start(settings, HOME))
    assert found is not None
    moved = (found.pose @ (held.lengths * strain))[:3]
    assert estimate.position - HOME[:3] == pytest.approx(moved, rel=0.03, abs=2e-5)
    assert moved[2] < -1e-4


def machine_stands(robot: Robot, creep: float, seconds: float) -> tuple[Array, Array, Array]:
    """True, and estimated by encoders alone with *robot* and without its creep, place of an exact machine that stands.

    *creep*: without a description.
    """
    twin = load_twin("cogiro")
    zero = dict.fromkeys(("anchor", "sheave_radius", "modulus", "home_length", "drum_radius", "mass"), 0.0)
    tolerances = twin.simulation.tolerances.model_copy(update=zero)
    cable = twin.simulation.cable.model_copy(update={"creep": creep})
    walk = twin.simulation.winch.model_copy(update={"radius_walk": 0.0, "sideways_walk": 0.0})
    twin = twin.with_simulation(tolerances=tolerances, cable=cable, winch=walk, quasi_static_period=1.0)
    machine = SimulatedMachine(robot, twin, HOME, seed=1, plant="quasi-static")
    owner = twin.owner
    assert isinstance(owner, MachineSettings)
    known, unknown = (estimator("encoders", each, owner, HOME) for each in (robot, ROBOT))
    while machine.time < seconds:
        frame = machine.step(Command(machine.time, np.zeros(ROBOT.m)))
        there, guessed = known.step(frame).position, unknown.step(frame).position
    return machine.truth.position, there, guessed


def test_described_creep_of_the_plant_leaves_no_error() -> None:
    law = usual_creep(1e-3 / mean_tension())
    true, known, unknown = machine_stands(creeping(law), 0.0, 900.0)
    still, without, _ = machine_stands(ROBOT, 0.0, 60.0)
    assert np.linalg.norm(true - unknown) > 5e-3
    assert np.linalg.norm((true - known) - (still - without)) < 1e-4


def test_given_doubts_move_no_position_by_encoders() -> None:
    """To the bit: without sensors of forces, doubts are in the covariance alone."""
    settings = told(ROBOT, cells=False, tilt=False)
    plant = BodyPlant(ROBOT, HOME, 3)
    frames = [plant.step(np.full(8, 0.02 * (k % 7)), 0.1) for k in range(40)]
    found = []
    for deviations in (SURE, Deviations(creep=1e-2, hysteresis=1e-2, exit_compliance=1e-4)):
        state = start(replace(settings, deviations=deviations), HOME)
        found.append([of_body.step(replace(settings, deviations=deviations), state, frame) for frame in frames])
    for one, other in zip(*found, strict=True):
        assert (one.position == other.position).all()
        assert (one.lengths == other.lengths).all()
    assert np.trace(found[1][-1].covariance[:3, :3]) > 10.0 * np.trace(found[0][-1].covariance[:3, :3])


def test_the_covariance_of_creep_is_that_of_its_law() -> None:
    """Covariance with the doubt less that without: J diag(l s) C (..)', s the strain of one standard deviation."""
    settings = told(ROBOT, cells=False, tilt=False)
    covariances, strains = [], np.zeros(8)
    for share in (1e-3, 1e-12):
        own = replace(settings, deviations=replace(SURE, creep=share))
        state, estimate = stood(own, 600.0, 2.0)
        covariances.append(estimate.covariance[:3, :3])
        if share == 1e-3:
            held = solve_inverse(own.model, HOME).checked()
            voigt = voigt_response(np.array([[600.0]]), np.array([60.0, 1200.0]))[0]
            response = 0.2 * voigt.sum() + 0.6 * log_response(np.array([600.0]))[0]
            strains = share / held.tensions.mean() * held.tensions * response
            found = slopes_of(state)
    assert found is not None
    by_line = found.pose[:3] * (held.lengths * strains)
    expected = by_line @ (0.9 + 0.1 * np.eye(8)) @ by_line.T
    assert covariances[0] - covariances[1] == pytest.approx(expected, rel=0.02, abs=1e-3 * np.trace(expected))


@pytest.mark.parametrize("part", ["mount", "softness"])
def test_softer_lines_move_the_platform_as_the_statics_say(part: str) -> None:
    """The filter's gradient against the forward solution of a robot whose mounts, or cables, give more."""
    settings, softer = told(ROBOT), 1e-7
    state = start(settings, HOME)
    of_body.step(settings, state, SensorFrame(0.0, (Encoders(0.0, STILL),)))
    found, home = slopes_of(state), state.load_path.home
    assert found is not None
    own, away = getattr(state.layout, part), HOME + np.array([0.4, 0.3, 0.5, 0.0, 0.0, 0.0])
    held = solve_inverse(settings.model, away).checked()
    if part == "mount":
        lines = tuple(line.model_copy(update={"exit_compliance": softer}) for line in ROBOT.lines)
        other = Model(ROBOT.model_copy(update={"lines": lines}))
        lengths, change = state.home.lengths, np.full(8, softer)
        moved = solve_forward(other, lengths, guess=HOME).checked().pose - HOME
    else:  # as an elastic strain that grows with the load from that at home, of which the length there has none
        state.lengths, share = held.lengths.copy(), 1e-6
        change = np.full(8, share)
        springs = share * held.lengths / state.load_path.mean
        lines = tuple(
            line.model_copy(update={"spring": 1.0 / spring}) for line, spring in zip(ROBOT.lines, springs, strict=True)
        )
        other = Model(ROBOT.model_copy(update={"lines": lines}))
        lengths = held.lengths * (1.0 - share * home / state.load_path.mean)
        moved = solve_forward(other, lengths, guess=away).checked().pose - held.pose
        state = start(settings, away)
        state.load_path.home = home
        state.load_path.mean = float(home.mean())
        of_body.step(settings, state, SensorFrame(0.0, (Encoders(0.0, STILL),)))
        found = slopes_of(state)
        assert found is not None
    expected = found.pose @ state.belief.gradients[:, own] @ change
    assert moved == pytest.approx(expected, rel=0.02, abs=2e-8)
    state.belief.unknowns[own] = change
    set_load(state, settings.model)
    assert state.tracker.step(lengths).word == "ok"
    assert state.pose == pytest.approx(solve_forward(other, lengths, guess=state.pose).checked().pose, abs=1e-7)


def test_a_line_never_gets_stiffer_than_twice_its_description() -> None:
    settings = told(ROBOT)
    state = start(settings, HOME)
    state.belief.unknowns[state.layout.mount] = -1.0
    set_load(state, settings.model)
    assert state.tracker.step(state.lengths).word == "ok"


def test_hysteresis_is_forgotten_by_the_way_of_the_loads() -> None:
    settings = told(ROBOT, cells=False)
    settings = replace(settings, deviations=replace(SURE, hysteresis=1e-3))
    layout = start(settings, HOME).layout
    path, loads = LoadPath(np.full(8, 100.0)), np.full(8, 100.0)
    unknowns, covariance = np.zeros(layout.size), np.zeros((layout.size, layout.size))
    load(settings, layout, unknowns, covariance, path.follow(loads + 4.0))  # to and fro within the play
    load(settings, layout, unknowns, covariance, path.follow(loads - 4.0))
    assert not covariance.any()
    ways = path.follow(loads + np.array([45.0, -45.0, *np.zeros(6)]))
    load(settings, layout, unknowns, covariance, ways)
    own = covariance[layout.hysteresis, layout.hysteresis]
    expected = (1.0 - math.exp(-2.0)) * (0.5e-3) ** 2  # 40 N beyond the play: one whole way
    assert own[0, 0] == pytest.approx(expected)
    assert own[0, 1] == pytest.approx(-0.5 * expected)
    assert not own[2:].any()
    for _ in range(40):
        for load_now in (400.0, 50.0):
            load(settings, layout, unknowns, covariance, path.follow(np.full(8, load_now)))
    assert np.diag(covariance[layout.hysteresis, layout.hysteresis]) == pytest.approx((0.5e-3) ** 2)


def test_what_is_learnt_of_a_law_is_not_all_believed() -> None:
    """Where all is learnt, 30 % of the first standard deviation are left; by encoders alone nothing is added."""
    state = start(told(ROBOT), HOME)
    of_body.step(told(ROBOT), state, SensorFrame(0.0, (Encoders(0.0, STILL),)))
    slopes, laws = slopes_of(state), state.layout.laws
    assert slopes is not None
    state.belief.sizes, state.belief.averaged = (LawSize((1.0,), (1.0,)),) * 3, None
    state.belief.gradients[:, laws] = np.hstack([np.eye(8), np.eye(8), np.eye(8)])
    by = slopes.pose @ state.belief.gradients[:, laws]
    state.belief.covariance = np.zeros_like(state.belief.covariance)
    state.belief.covariance[laws, laws] = state.belief.untold
    whole = by @ state.belief.untold @ by.T
    np.testing.assert_allclose(pose_covariance(state, slopes), whole, rtol=1e-9, atol=1e-15)
    state.belief.covariance[laws, laws] = 0.0
    np.testing.assert_allclose(pose_covariance(state, slopes), 0.09 * whole, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("cells", [True, False])
def test_the_covariance_is_honest_about_undescribed_creep(cells: bool) -> None:
    """Creep is of the size that the estimator assumes, and cables never shorten: normalised errors over machines."""
    share, found = ASSUMED, []
    for seed in range(960, 960 + often(6, 16)):
        plant, random = BodyPlant(ROBOT, HOME, seed), np.random.default_rng(seed)
        factor = share * (math.sqrt(0.9) * abs(random.standard_normal()) + math.sqrt(0.1) * random.standard_normal(8))
        settings = told(ROBOT, cells=cells, tilt=cells)
        settings = replace(settings, deviations=replace(settings.deviations, creep=share))
        state = start(settings, HOME)
        response = usual_creep(1.0)
        for k in range(150):
            plant.slipped = plant.home * factor * plant.truth[1] / mean_tension() * at(response, 4.0 * k)
            estimate = of_body.step(settings, state, plant.step(np.zeros(8), 4.0))
        error = estimate.position - plant.truth[0][:3]
        found.append(error @ np.linalg.solve(estimate.covariance[:3, :3], error))
    low, high = stats.chi2(3 * len(found)).ppf([5e-4, 1.0 - 5e-4])
    assert low < sum(found) < high


def at(law: Creep, time: float) -> float:
    """Strain of a load of 1 at a time."""
    times = np.array([time])
    voigt = [c * voigt_response(times, t)[0] for c, t in zip(law.compliances, law.retardations, strict=True)]
    return float(sum(voigt) + law.logarithmic * log_response(times)[0])


def test_a_law_is_scaled() -> None:
    law = usual_creep(3e-7)
    assert at(law, HOUR) == pytest.approx(3e-7)
    assert at(scaled_creep(law, 0.3), 100.0) == pytest.approx(0.3 * at(law, 100.0))


def test_what_crept_is_saved_with_a_print() -> None:
    owner = load_twin("cogiro").owner
    robot = creeping(usual_creep(1e-3 / mean_tension()))
    began = estimator("encoders", robot, owner, HOME)
    for k in range(300):
        began.step(SensorFrame(1.0 * k, (Encoders(1.0 * k, STILL),)))
    snapshot = save(began)
    resumed = estimator("encoders", robot, owner, HOME + np.array([0.0, 0.0, 0.2, 0.0, 0.0, 0.0]))
    restore(resumed, snapshot)
    for k in range(300, 600):
        frame = SensorFrame(1.0 * k, (Encoders(1.0 * k, STILL),))
        one, other = began.step(frame), resumed.step(frame)
    assert other.position == pytest.approx(one.position, abs=2e-5)
    assert other.covariance == pytest.approx(one.covariance, rel=0.02, abs=1e-9)


def told_by(data: Array, noise: float, prior: Array) -> tuple[Array, Array]:
    """Estimate and covariance of unknowns with a *prior* covariance, each measured once, with a *noise*."""
    covariance = np.linalg.inv(np.linalg.inv(prior) + np.eye(len(prior)) / noise**2)
    return np.asarray(covariance @ data / noise**2), np.asarray(covariance)


def test_sizes_are_averaged_by_bayes() -> None:
    """Against the sum over all sizes of posteriors that are computed from the data."""
    random = np.random.default_rng(5)
    sizes = LawSize((1.0, 3.0), (0.3, 0.7)), LawSize((1.0, 2.0), (0.5, 0.5)), LawSize((1.0,), (1.0,))
    blocks = [scale**2 * (0.4 + 0.6 * np.eye(3)) for scale in (1e-4, 1e-6, 1.0)]
    untold = np.block([[blocks[at] if at == to else np.zeros((3, 3)) for to in range(3)] for at in range(3)])
    unit = np.sqrt(np.diag(untold))
    data, noise = 2.0 * random.standard_normal(9), 0.8
    estimate, covariance = told_by(data, noise, untold / np.outer(unit, unit))
    found = averaged(unit * estimate, covariance * np.outer(unit, unit), untold, sizes)
    total, moment, squares, shown = 0.0, np.zeros((9, 9)), np.zeros(3), np.zeros((9, 9))
    for (one, p), (other, q) in product(
        zip(*vars(sizes[0]).values(), strict=True), zip(*vars(sizes[1]).values(), strict=True)
    ):
        factor = np.repeat([one, other, 1.0], 3)
        prior = untold / np.outer(unit, unit) * np.outer(factor, factor)
        value, spread = told_by(data, noise, prior)
        weight = p * q * multivariate_normal(cov=prior + noise**2 * np.eye(9)).pdf(data)
        total += weight
        moment += weight * (spread + np.outer(value - estimate, value - estimate))
        squares += weight * factor[::3] ** 2
        shown += weight * (prior - spread)
    scale, inverse = np.outer(unit, unit), np.linalg.inv(covariance)
    assert found.squares == pytest.approx(squares / total)
    assert found.shown / scale == pytest.approx(shown / total, rel=1e-7, abs=1e-9)
    expected = inverse @ (moment / total - covariance) @ inverse
    assert found.wider * scale == pytest.approx(expected, rel=1e-7, abs=1e-8)


def test_the_covariance_follows_the_size_that_data_show() -> None:
    """Mounts of the assumed size leave it as with that size; ten times as large ones widen it to theirs."""
    state = start(replace(told(ROBOT), deviations=Deviations()), HOME)
    layout, belief, slopes = state.layout, state.belief, slopes_of(state)
    assert slopes is not None
    belief.gradients[np.arange(8), layout.mount.start + np.arange(8)] = 1.0
    untold, unmeasured = belief.covariance[layout.mount, layout.mount].copy(), pose_covariance(state, slopes)
    belief.sizes, belief.averaged = (*belief.sizes[:2], LawSize((1.0,), (1.0,))), None
    assert np.trace(unmeasured) > np.trace(pose_covariance(state, slopes))
    belief.sizes, belief.averaged = law_sizes(replace(told(ROBOT), deviations=Deviations())), None
    random, noise = np.random.default_rng(1), 0.1 * math.sqrt(untold[0, 0])
    for factor in (1.0, 10.0):
        found = []
        for _ in range(60):
            data = factor * np.linalg.cholesky(untold) @ random.standard_normal(8) + noise * random.standard_normal(8)
            belief.unknowns[layout.mount], belief.covariance[layout.mount, layout.mount] = told_by(data, noise, untold)
            laws = layout.laws
            own = averaged(belief.unknowns[laws], belief.covariance[laws, laws], belief.untold, belief.sizes)
            assert np.linalg.eigvalsh(pose_covariance(state, slopes))[0] > 0.0
            found.append(own.squares[2])
        assert np.median(found) == pytest.approx(factor**2, rel=0.1)


def test_an_average_is_taken_again_where_much_has_changed() -> None:
    """Meanwhile sigmas are within a tenth of those by an average of its own time."""
    state = start(replace(told(ROBOT), deviations=Deviations()), HOME)
    layout, belief, slopes = state.layout, state.belief, slopes_of(state)
    assert slopes is not None
    belief.gradients[np.arange(8), layout.mount.start + np.arange(8)] = 1.0
    untold, random, count = belief.covariance[layout.mount, layout.mount].copy(), np.random.default_rng(3), 0
    true = 5.0 * np.linalg.cholesky(untold) @ random.standard_normal(8)
    noise, sums = 3.0 * math.sqrt(untold[0, 0]), np.zeros(8)
    for measured in range(1, 800):
        sums += true + noise * random.standard_normal(8)
        told_now = told_by(sums / measured, noise / math.sqrt(measured), untold)
        belief.unknowns[layout.mount], belief.covariance[layout.mount, layout.mount] = told_now
        before, found = belief.averaged, pose_covariance(state, slopes)
        count += belief.averaged is not before
        if measured % 20 == 0:
            kept, belief.averaged = belief.averaged, None
            own, belief.averaged = pose_covariance(state, slopes), kept
            assert np.sqrt(np.diag(found) / np.diag(own)) == pytest.approx(np.ones(6), abs=0.1)
    assert 100 < count < 500


def test_sizes_that_an_owner_states_are_believed() -> None:
    stated = replace(told(ROBOT), deviations=Deviations(creep=1e-3, hysteresis=1e-3, exit_compliance=1e-5))
    untold = replace(told(ROBOT), deviations=Deviations())
    assert all(size.chances[0] > 0.9 for size in law_sizes(stated))
    assert all(size.chances[0] < 0.5 for size in law_sizes(untold))
    described = replace(untold, model=Model(creeping(usual_creep(1e-6))))
    assert [size.chances[0] > 0.9 for size in law_sizes(described)] == [True, False, False]
