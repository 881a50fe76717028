"""What measured places teach of lengths: against plants of which all is known, and against other ways to compute it."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cablewright.estimation import encoders_only
from cablewright.estimation.length_corrections import (
    CREEP,
    KEPT,
    MOUNT,
    SHARE,
    LearntLengths,
    LengthPriors,
    MeasuredPlace,
    winding,
)
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Encoders, SensorFrame
from cablewright.kernels import layout
from cablewright.live.estimators import reckoning_of
from cablewright.machine.simulated.settings import load_twin
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot, load
from cablewright.robot.cable import Creep
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import inverse
from cablewright.solvers.parameter_effects import mount_lengths

PLACES = np.array([[4.0, 3.0, 1.0], [-4.0, 2.0, 1.0], [-3.0, -4.0, 1.1], [4.5, -3.0, 1.1]])
FILE_MOUNT, FILE_CREEP = 3e-5, 6e-6  # m/N, 1/N: so large that drawn values are hardly negative


def printer(mounts: tuple[float, ...] = (FILE_MOUNT,) * 4) -> Robot:
    """The house printer with compliant mounts, m/N, and cables that creep."""
    robot = load("house-printer")
    pairs = zip(robot.lines, mounts, strict=True)
    creep = Creep(logarithmic=FILE_CREEP)
    lines = tuple(
        line.model_copy(update={"exit_compliance": mount, "cable": line.cable.model_copy(update={"creep": creep})})
        for line, mount in pairs
    )
    return robot.model_copy(update={"lines": lines})


ROBOT = printer()
MODEL = Model(ROBOT)
EXACT = LengthPriors(1e-3, share=5e-4, creep=1e-3, mount=1e-5, drift=0.0, scatter=0.0)
USUAL = replace(EXACT, scatter=LengthPriors(1e-3).scatter)
DRAWS = 60


@cache
def at_places() -> Equilibrium:
    """The robot of the file at the places."""
    return inverse(ROBOT, PLACES).checked()


@cache
def mean_tension() -> float:
    return float(np.mean(at_places().tensions))


def visited(learnt: LearntLengths, true: np.ndarray, random: np.random.Generator | None = None) -> None:
    """Let the machine with the *true* unknowns (4, 3) rest for 300 s at each of the places, and measure them.

    Its mounts are those of its statics, and it creeps by the tensions that it has there by its file: what that knows
    was counted.
    """
    plant, time = Model(printer(tuple((FILE_MOUNT + true[:, MOUNT]).tolist()))), 0.0
    for place, counted, tensions in zip(PLACES, at_places().lengths, at_places().tensions, strict=True):
        learnt.memory.advance(tensions, tensions, 300.0)
        time += 300.0
        crept = true[:, CREEP] * learnt.remembered
        scattered = 0.0 if random is None else random.normal(0.0, learnt.priors.scatter, 4)
        longer = counted * (1.0 + true[:, SHARE] + crept + scattered)
        there = solve_forward(plant, longer, guess=place).checked().pose
        noise = np.zeros(3) if random is None else random.normal(0.0, learnt.priors.place, 3)
        learnt.told(MODEL, measured(learnt, counted, there + noise, time))


def measured(learnt: LearntLengths, counted: np.ndarray, place: np.ndarray, time: float = 0.0) -> MeasuredPlace:
    return MeasuredPlace(counted, place, learnt.remembered, np.zeros(4), time)


def begun(priors: LengthPriors = EXACT) -> LearntLengths:
    return LearntLengths.of(priors, MODEL, np.full(4, mean_tension()))


@pytest.mark.parametrize("size", [1e-3, 1.0], ids=["linear", "nonlinear"])
def test_errors_are_as_large_as_their_covariance(size: float) -> None:
    """Of machines drawn by the priors, on which all is linear, or is not, the mean of chi-square is that of 12."""
    sigmas = ("place", "share", "creep", "mount", "scatter")
    priors = replace(USUAL, **{key: size * getattr(USUAL, key) for key in sigmas})
    random, squares = np.random.default_rng(5), []
    for _ in range(DRAWS):
        learnt = begun(priors)
        true = random.normal(0.0, learnt.known.sigmas)
        true = np.maximum(true, [-np.inf, -FILE_CREEP, -FILE_MOUNT])
        visited(learnt, true, random)
        off = (learnt.known.values - true).ravel()
        squares.append(off @ np.linalg.solve(learnt.known.covariance, off))
    assert abs(np.mean(squares) - 12.0) < 3.5 * np.sqrt(2.0 * 12.0 / DRAWS)


def test_errors_of_lines_are_found() -> None:
    """By places without noise: sums that move the platform are right to a tenth of their earlier errors."""
    learnt = begun(replace(EXACT, place=1e-5))
    true = np.column_stack([[4e-4, -3e-4, 2e-4, -5e-4], np.array([1.0, 0.2, 0.6, 0.4]) / mean_tension() * 1e-3,
                            [8e-6, -5e-6, 3e-6, 1e-5]])  # fmt: skip
    elsewhere, plant = np.array([1.0, 0.5, 1.2]), Model(printer(tuple((FILE_MOUNT + true[:, MOUNT]).tolist())))
    visited(learnt, true)
    counted = inverse(ROBOT, elsewhere).checked()
    crept = true[:, CREEP] * learnt.remembered
    there = solve_forward(plant, counted.lengths * (1.0 + true[:, SHARE] + crept), guess=elsewhere).checked().pose
    mounts = FILE_MOUNT + learnt.used[:, MOUNT]
    lengths = counted.lengths + learnt.longer(counted.lengths)
    found = solve_forward(Model(printer(tuple(mounts.tolist()))), lengths, guess=elsewhere).checked().pose
    assert np.linalg.norm(there - elsewhere) > 0.01
    assert np.linalg.norm(there - found) < 0.05 * np.linalg.norm(there - elsewhere)


@pytest.mark.parametrize("rounds", [1, 5], ids=["kept", "more"])
def test_places_are_one_weighted_least_squares(rounds: int) -> None:
    """Derivatives by differences of the whole statics, and all places together: the same, also of those not kept."""
    priors = replace(EXACT, scatter=1e-4)
    learnt = begun(priors)
    small = 1e-3 * np.random.default_rng(2).normal(0.0, learnt.known.sigmas)
    information, left = np.diag(1.0 / learnt.known.sigmas.ravel() ** 2), np.zeros(12)
    for place, counted, tensions in rounds * list(zip(PLACES, at_places().lengths, at_places().tensions, strict=True)):
        learnt.memory.advance(tensions, tensions, 300.0)
        per_unknown, inverse_noise = weighted_rows(learnt, counted, place)
        told = place + per_unknown @ small.ravel()
        learnt.told(MODEL, measured(learnt, counted, told))
        information += per_unknown.T @ inverse_noise @ per_unknown
        left += per_unknown.T @ inverse_noise @ (told - place)
    assert len(learnt.places) == min(4 * rounds, KEPT)
    expected, covariance = np.linalg.solve(information, left).reshape(4, 3), np.linalg.inv(information)
    np.testing.assert_allclose(learnt.known.values / learnt.known.sigmas, expected / learnt.known.sigmas, atol=2e-4)
    scale = 1.0 / np.sqrt(np.diag(covariance))
    assert np.abs((learnt.known.covariance - covariance) * scale[:, None] * scale).max() < 0.01


def weighted_rows(learnt: LearntLengths, counted: np.ndarray, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The motion (3, 12) per unknown, by differences, and the inverse (3, 3) of the covariance of a place."""

    def moved(lengths: np.ndarray, model: Model = MODEL) -> np.ndarray:
        return np.asarray(solve_forward(model, lengths, guess=place).checked().pose)

    at, columns, lines = moved(counted), [], []
    remembered = learnt.remembered
    for i in range(4):
        one, mounts = np.zeros(4), [FILE_MOUNT] * 4
        one[i], mounts[i] = 1e-4, FILE_MOUNT + 1e-8
        lines.append((moved(counted + one) - at) / 1e-4)
        columns += [lines[i] * counted[i], lines[i] * counted[i] * remembered[i]]
        columns.append((moved(counted, Model(printer(tuple(mounts)))) - at) / 1e-8)
    scattered = np.column_stack(lines) * learnt.priors.scatter * counted
    noise = learnt.priors.place**2 * np.eye(3) + scattered @ scattered.T
    return np.column_stack(columns), np.linalg.inv(noise)


def test_undetermined_combinations_keep_their_prior() -> None:
    """One place determines three numbers of twelve: in the other nine directions nothing is known better than
    before."""
    learnt = begun()
    known = learnt.known.covariance.copy()
    learnt.told(MODEL, measured(learnt, at_places().lengths[0], PLACES[0] + 0.01, 0.0))
    scale = 1.0 / np.sqrt(np.diag(known))
    kept = np.linalg.eigvalsh(learnt.known.covariance * scale[:, None] * scale)
    np.testing.assert_allclose(kept[3:], 1.0, atol=1e-9)
    assert kept[:3].max() < 0.1


def test_one_exact_place_without_gives_is_the_smallest_change() -> None:
    """As `placed`, to first order: that takes the least change in each of its steps, this the least of all."""
    robot, owner, counts = load("house-printer"), load_twin("house-printer").owner, np.zeros(4, dtype=np.int64)
    none = LengthPriors(0.0, creep=0.0, mount=0.0, drift=0.0, scatter=0.0)
    settings = replace(reckoning_of(robot, owner), priors=none)
    told = PLACES[0] + np.array([0.002, -0.001, -0.003])
    taught = encoders_only.start(settings, PLACES[0])
    encoders_only.step(settings, taught, SensorFrame(0.0, (Encoders(0.0, counts),)))
    plain = encoders_only.placed(settings, taught, told)
    encoders_only.taught(settings, taught, told)
    there = encoders_only.step(settings, taught, SensorFrame(1.0, (Encoders(1.0, counts),)))
    np.testing.assert_allclose(there.position, told, atol=1e-7)
    counted_plain = inverse(load("house-printer"), PLACES[0]).checked().lengths
    change = plain.start_lengths - counted_plain
    np.testing.assert_allclose(there.lengths - counted_plain, change, atol=0.02 * np.abs(change).max())


def test_a_compliant_mount_acts_as_additional_length() -> None:
    """Platform held: solved again with another mount, tensions are those of a line longer by its deflection."""
    held = inverse(ROBOT, PLACES[0]).checked()
    more = mount_lengths(held[None])[0]
    softer = Model(printer((FILE_MOUNT + 1e-7,) * 4))
    moved = solve_forward(softer, held.lengths, guess=PLACES[0]).checked().pose - PLACES[0]
    longer = solve_forward(MODEL, held.lengths + 1e-7 * more, guess=PLACES[0]).checked().pose - PLACES[0]
    assert np.linalg.norm(moved) > 1e-5
    np.testing.assert_allclose(longer, moved, atol=0.01 * np.linalg.norm(moved))


def test_cable_wound_is_as_uncertain_as_the_radius() -> None:
    """Against the double integral of the covariance of a Gauss-Markov process."""
    priors = LengthPriors(0.0, radius=1e-3, turns=2.0)
    middles = (np.arange(2000) + 0.5) / 2000
    for turns in (1e-4, 0.3, 7.0):
        apart = np.abs(np.subtract.outer(middles, middles)) * turns / priors.turns
        expected = 2.0 * np.pi * turns * priors.radius * np.sqrt(np.exp(-apart).mean())
        np.testing.assert_allclose(winding(priors, np.array([turns])), expected, rtol=1e-3)


def test_no_compliance_and_no_creep_is_negative() -> None:
    """The used values are the nearest by the covariance: no other of which all give and creep is nearer."""
    robot = load("house-printer")
    learnt = LearntLengths.of(EXACT, Model(robot), np.full(4, mean_tension()))
    random = np.random.default_rng(3)
    root = random.normal(0.0, 1.0, (12, 12)) * learnt.known.sigmas.ravel()
    learnt.known.covariance, learnt.known.values = root @ root.T, np.zeros((4, 3))
    learnt.known.values[:, MOUNT] = [-1e-5, 3e-6, -2e-6, 1e-5]
    learnt.known.values[:, CREEP] = np.array([1e-3, 2e-4, -3e-4, 1e-3]) / mean_tension()
    inverted = np.linalg.inv(learnt.known.covariance)

    def far(values: np.ndarray) -> float:
        off = (values - learnt.known.values).ravel()
        return float(off @ inverted @ off)

    used = learnt.used
    assert used[:, MOUNT].min() >= 0.0
    assert used[:, CREEP].min() >= 0.0
    assert (learnt.packed(Model(robot)).lines[:, layout.MOUNT] >= 0.0).all()
    for _ in range(300):
        other = used + 0.1 * random.normal(0.0, learnt.known.sigmas)
        other[:, [CREEP, MOUNT]] = np.maximum(other[:, [CREEP, MOUNT]], 0.0)
        assert far(other) >= far(used) * (1.0 - 1e-9)


def test_what_drifts_is_less_known() -> None:
    learnt = begun(replace(EXACT, drift=2e-4))
    learnt.told(MODEL, measured(learnt, at_places().lengths[0], PLACES[0], 0.0))
    again, later = deepcopy(learnt), learnt
    again.told(MODEL, measured(again, at_places().lengths[0], PLACES[0], 0.0))
    later.told(MODEL, measured(later, at_places().lengths[0], PLACES[0], 36000.0))
    assert (later.known.sigmas[:, SHARE] > again.known.sigmas[:, SHARE]).all()


@pytest.mark.parametrize(
    ("change", "message"),
    [({"share": -1.0}, "share = -1: must be a finite number from 0 on"), ({"turns": 0.0}, "turns = 0: must be")],
)
def test_priors_that_cannot_be(change: dict[str, float], message: str) -> None:
    make: Callable[..., LengthPriors] = LengthPriors
    with pytest.raises(InputError, match=message):
        make(1e-3, **change)
