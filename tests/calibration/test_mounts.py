"""Mounts of exit points that give: their compliance is found, by the plant's own law as the oracle."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.drift.drift import check_drift
from cablewright.calibration.drift.record import CalibrationRecord, load_record, record_of, record_text
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.judgement.sigmas import leverages
from cablewright.calibration.measurements import Measured, write_measured
from cablewright.calibration.plan import Bound, CalibrationPlan, Prior, Sigmas
from cablewright.calibration.poses.elastic import ElasticProblem
from cablewright.calibration.poses.problem import CalibrationProblem, StraightProblem
from cablewright.calibration.poses.simulation import random_poses, simulate_calibration
from cablewright.foundation.errors import InputError
from cablewright.kernels.plant import dynamics
from cablewright.kernels.statics.equilibrium import evaluate
from cablewright.machine.simulated.unmodelled.exit_mounts import ExitMountState
from cablewright.models.fidelity import Fidelity
from cablewright.models.packed_views import LineStates
from cablewright.models.statics import Model
from cablewright.robot import Robot, load
from cablewright.solvers.inverse import solve_inverse
from cases import some

PLAIN = ("exit_point", "length_offset")
SOFT = CalibrationPlan(unknowns=(*PLAIN, "exit_compliance"), sigma=Sigmas(encoder=1e-4, tension=2.0))
WANG = load("wang2021")


def plant(robot: Robot, cable: str, poses: np.ndarray, soft: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lengths, and poses and tensions in equilibrium with exit points that give as those of the simulated machine
    do."""
    model = Model(robot, Fidelity.of(cable))
    held = solve_inverse(model, poses).checked()
    work, _ = dynamics.moving_workspace(model.packed)
    places, tensions = held.pose.copy(), held.tensions.copy()
    for k in range(len(poses)):
        packed = model.packed._replace(lines=model.packed.lines.copy(), platform=model.packed.platform.copy())
        states, lengths = held.states[k].copy(), held.lengths[k].copy()
        evaluate(packed, lengths, places[k], states, work)  # for the lines' planes
        exits = ExitMountState(soft[:, None, None] * np.eye(3))
        code = exits.close(packed, np.arange(robot.m), lengths, places[k], states, np.ones(robot.m), work)
        assert code == 0
        tensions[k] = LineStates(states).tension
    return held.lengths, places, tensions


def soft_of(robot: Robot, rng: np.random.Generator) -> np.ndarray:
    return rng.uniform(1e-6, 5e-6, robot.m)


def found_of(found: Calibration) -> tuple[np.ndarray, np.ndarray]:
    which = [each.name == "exit_compliance" for each in found.unknowns]
    return found.values[which], found.sigma[which]


@pytest.mark.parametrize(
    ("name", "cable", "exact"),
    some([("merlet2023", "catenary", 1e-4), ("cogiro", "elastic", 1e-4), ("paty2021", "catenary", 0.005)], fast=2),
)
def test_mounts_of_the_plant_are_found(name: str, cable: str, exact: float) -> None:
    """With noise within 4 sigmas; without any but for how dead spans go aside, of second order in some mm."""
    robot, rng = load(name), np.random.default_rng(1)
    soft = soft_of(robot, rng)
    lengths, poses, tensions = plant(robot, cable, random_poses(robot, 30, rng, cable), soft)
    clean = Measured(lengths - lengths[0], poses, tensions=tensions)
    values, _ = found_of(calibrate(robot, clean, SOFT, cable=cable, rough=0.05, outliers=False))
    assert values == pytest.approx(soft, abs=exact * soft.max())
    noisy = Measured(
        clean.counted + rng.normal(0.0, 1e-4, lengths.shape),
        poses + rng.uniform(-0.02, 0.02, poses.shape),
        tensions=tensions + rng.normal(0.0, 2.0, tensions.shape),
    )
    found = calibrate(robot, noisy, SOFT, cable=cable, rough=0.05, need=0.1)
    values, sigma = found_of(found)
    assert found.verdict == "good"
    assert np.abs((values - soft) / sigma).max() < 4.0
    assert found.unknowns[-1].unit == "m/N"


def straight(rng: np.random.Generator, soft: np.ndarray) -> Measured:
    """What a robot with rigid lines measures whose exit points are displaced by its tensions, each along its line."""
    poses = random_poses(WANG, 60, rng)
    held = solve_inverse(Model(WANG, Fidelity.of("rigid")), poses).checked()
    points, lengths = held.platform_points, held.lengths.copy()
    exits = np.broadcast_to([line.exit_point for line in WANG.lines], points.shape)
    for _ in range(20):  # the mount is pulled towards the platform, along the line as it is then
        away = points - exits
        away /= np.linalg.norm(away, axis=2)[..., None]
        exits = np.array([line.exit_point for line in WANG.lines]) + (soft * held.tensions)[..., None] * away
        moved = solve_inverse(Model(WANG, Fidelity.of("rigid")), poses, exit_points=np.ascontiguousarray(exits))
        lengths = moved.lengths
    noise = rng.normal(0.0, 1e-4, lengths.shape)
    start = poses + rng.uniform(-0.02, 0.02, poses.shape)
    return Measured(lengths - lengths[0] + noise, start, tensions=held.tensions + rng.normal(0.0, 2.0, lengths.shape))


def test_mounts_under_straight_lines_are_found_by_their_tensions() -> None:
    """The line leaves its sheave near the direction from the exit point; a tenth of the deflection is left for that."""
    rng = np.random.default_rng(2)
    soft = 3.0 * soft_of(WANG, rng)
    measured = straight(rng, soft)
    found = calibrate(WANG, measured, SOFT, rough=0.05, need=0.1)
    values, sigma = found_of(found)
    assert found.verdict == "good"
    assert np.abs(values - soft).max() < 4.0 * sigma.max() + 0.1 * soft.max()
    assert sigma.max() < 0.5 * soft.max()
    assert found.rms < 1.3e-4
    assert calibrate(WANG, measured, SOFT.model_copy(update={"unknowns": PLAIN}), rough=0.05).rms > 2e-4


def test_stiff_mounts_are_found_stiff() -> None:
    """At the edge of their range, where the file has them, and that is an answer."""
    rng = np.random.default_rng(3)
    measured = straight(rng, np.zeros(4))
    found = calibrate(WANG, measured, SOFT.model_copy(update={"shared": ("exit_compliance",)}), rough=0.05, need=0.1)
    value, sigma = found_of(found)
    assert found.verdict == "good"
    assert 0.0 <= value[0] < 4.0 * sigma[0]
    assert found.unknowns[-1].label == "exit compliance of all lines"


def test_a_prior_and_bounds_are_in_metres_per_newton() -> None:
    rng = np.random.default_rng(2)
    soft = 3.0 * soft_of(WANG, rng)
    measured = straight(rng, soft)
    tight = SOFT.model_copy(update={"priors": (Prior(name="exit_compliance", deviation=1e-8),)})
    assert found_of(calibrate(WANG, measured, tight, rough=0.05))[0].max() < 1e-6
    narrow = SOFT.model_copy(update={"bounds": (Bound(name="exit_compliance", min=0.0, max=2e-6),)})
    found = calibrate(WANG, measured, narrow, rough=0.05)
    assert found.status == "degenerate"
    assert "the edge of its range from 0 to 2e-06 m/N" in found.reason


def test_without_tensions_nothing_determines_them() -> None:
    made = simulate_calibration(WANG, 40, 1e-4, seed=1)
    with pytest.raises(InputError, match="unknowns: exit_compliance: the data has no column f_1, so no data"):
        calibrate(WANG, made.measured, SOFT)


@pytest.mark.parametrize(("robot", "cable"), [(WANG, "rigid"), (load("merlet2023"), "catenary")])
def test_counts_are_those_that_leave_no_residual(robot: Robot, cable: str) -> None:
    """With a drum that builds up, compliant mounts, and load cells with offsets where lines are straight."""
    rng = np.random.default_rng(4)
    model = Model(robot, Fidelity.of(cable))
    held = solve_inverse(model, random_poses(robot, 5, rng, cable)).checked()
    plan = CalibrationPlan(unknowns=("length_offset", "length_scale", "build_up", "exit_compliance", "tension_offset"))

    def problem(counted: np.ndarray) -> CalibrationProblem:
        measured = Measured(counted, held.pose, tensions=held.tensions)
        if cable == "rigid":
            return StraightProblem.of(robot, measured, plan)
        return ElasticProblem.of(model, measured, plan)

    first = problem(np.zeros(held.lengths.shape))
    sizes = {
        "length_offset": 4.0,
        "length_scale": 1.02,
        "build_up": 0.01,
        "exit_compliance": 5e-3,
        "tension_offset": 3.0,
    }
    theta = np.array([sizes[each.name] for each in first.free_unknowns])
    states = held.pose if cable == "rigid" else first.states_of(held)
    counted = first.counts_at(theta, states, first.given(theta, states))
    left = problem(counted).derivatives(theta, states).residual[:, : robot.m] * first.encoder_sigma
    assert left == pytest.approx(np.zeros_like(left), abs=1e-9)
    if cable == "rigid":  # else equilibria count mounts
        assert np.abs(counted - first.counts_at(theta, states)).min() > 1e-5


@pytest.mark.parametrize("cable", ["rigid", "catenary"])
def test_a_machine_with_soft_mounts_passes_its_check(cable: str, tmp_path: Path) -> None:
    """With the tensions that straight lines need, and a line that slipped is named."""
    rng, robot = np.random.default_rng(5), WANG if cable == "rigid" else load("merlet2023")
    if cable == "rigid":
        measured = straight(rng, 3.0 * soft_of(WANG, rng))
    else:
        lengths, poses, tensions = plant(robot, cable, random_poses(robot, 30, rng, cable), soft_of(robot, rng))
        noise = rng.normal(0.0, 1e-4, lengths.shape)
        measured = Measured(
            lengths - lengths[0] + noise, poses, tensions=tensions + rng.normal(0.0, 2.0, lengths.shape)
        )
    file = tmp_path / "d.csv"
    file.write_text(write_measured(measured, robot), encoding="utf-8")
    found = calibrate(robot, file, SOFT, cable=cable, rough=0.05, need=0.1)
    record = load_record_text(record_text(record_of(found, file, datetime(2026, 3, 1, tzinfo=UTC))), tmp_path)
    later = part(measured, 8)
    assert check_drift(found.robot, later, record).verdict == "unchanged"
    slipped = replace(later, counted=later.counted + 0.1 * np.eye(4)[1])
    assert check_drift(found.robot, slipped, record).verdict == "moved"
    if cable == "rigid":
        with pytest.raises(InputError, match="no column f_1: line 'south-west' has exit_compliance"):
            check_drift(found.robot, replace(later, tensions=None), record)


def part(measured: Measured, count: int) -> Measured:
    assert measured.guess is not None
    assert measured.tensions is not None
    return Measured(measured.counted[:count], measured.guess[:count], tensions=measured.tensions[:count])


def load_record_text(text: str, folder: Path) -> CalibrationRecord:
    file = folder / "r.toml"
    file.write_text(text, encoding="utf-8")
    return load_record(file)


def test_a_pose_without_a_value_has_no_leverage() -> None:
    measured = simulate_calibration(WANG, 20, 1e-4, seed=1).measured
    found = calibrate(WANG, measured, rough=0.05, outliers=False)
    inside = found.fit.poses.copy()
    inside[3] = WANG.lines[0].exit_point
    inside[3, 0] += 0.07  # within the sheave
    lost = leverages(found.problem, type(found.fit)(found.fit.theta, inside, found.fit.weights, np.inf, 0, 0))
    assert (lost[3] == 0.0).all()
    assert np.isfinite(lost).all()
