"""Sigmas that hold where the model is wrong: every kind's noise, wrong known numbers, scatter, friction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.judgement.model_doubt import Considered, _found_off
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.plan import CalibrationPlan, Point, Sigmas
from cablewright.calibration.poses.problem import SURVEY, StraightProblem
from cablewright.calibration.poses.simulation import SensorNoise, SimulatedCalibration, aligned, measure, random_poses
from cablewright.robot import Robot, load
from cases import often, some

WANG, PATY = load("wang2021"), load("paty2021")
ALL = ("exit_point", "length_offset", "modulus")


def exits_of(robot: Robot) -> np.ndarray:
    return np.array([line.exit_point for line in robot.lines])


def surveyed(rng: np.random.Generator, off: float = 0.0) -> CalibrationPlan:
    points = []
    for at, line in enumerate(WANG.lines):
        place = np.array(line.exit_point) + rng.normal(0.0, 5e-4, 3) + np.array([off * (at == 2), 0.0, 0.0])
        points.append(Point(line=line.name, at=tuple(place.tolist()), deviation=5e-4))
    return CalibrationPlan(points=tuple(points))


def softer(robot: Robot) -> Robot:
    """Lines of which the platform's weight stretches a metre by a millimetre."""
    changed = {"axial_stiffness": 1e5, "young_modulus": None, "section": None}
    lines = [line.model_copy(update={"cable": line.cable.model_copy(update=changed)}) for line in robot.lines]
    return robot.model_copy(update={"lines": tuple(lines)})


def made_with(effect: str, rng: np.random.Generator) -> tuple[Robot, SimulatedCalibration]:
    """The file, and data of a machine with an effect that straight lines by the file do not have."""
    robot = softer(WANG) if effect == "flex" else WANG
    made = measure(robot, random_poses(robot, 40, rng), 1e-4, rng, cable="elastic" if effect == "flex" else "rigid")
    if effect == "build-up":
        counted = -np.log1p(-1e-3 * made.measured.counted) / 1e-3
        made = replace(made, measured=replace(made.measured, counted=counted))
    if effect == "radius":
        lines = []
        for line in robot.lines:
            assert line.sheave.kind == "swivel"
            radius = line.sheave.radius * (1.0 + 0.03 * rng.choice([-1.0, 1.0]))
            lines.append(line.model_copy(update={"sheave": line.sheave.model_copy(update={"radius": radius})}))
        robot = robot.model_copy(update={"lines": tuple(lines)})
    return robot, made


@pytest.mark.parametrize("effect", some(["flex", "none", "build-up", "radius"]))
def test_sigmas_cover_errors_of_a_wrong_model(effect: str) -> None:
    """By noise alone a third to a half of them would be outside."""
    told, noise = [], []
    for seed in range(often(3, 8)):
        rng = np.random.default_rng(seed)
        file, made = made_with(effect, rng)
        found = calibrate(file, made.measured, surveyed(rng))
        off = np.abs(found.values[:12] - exits_of(WANG).ravel())
        told.append(off < 1.96 * found.sigma[:12])
        noise.append(off < 1.96 * found.noise_sigma[:12])
        assert (found.sigma >= found.noise_sigma * (1.0 - 1e-9)).all()
        assert np.linalg.eigvalsh(found.covariance).min() > -1e-12
    assert np.mean(told) > 0.9
    assert effect == "none" or np.mean(told) >= np.mean(noise)


def test_a_stretch_that_the_data_show_is_found() -> None:
    """Once the stretch by the file's stiffness, and its shift is in the sigmas."""
    rng = np.random.default_rng(3)
    file, made = made_with("flex", rng)
    found = calibrate(file, made.measured, surveyed(rng))
    stretch = found.doubt.considered[-1]
    assert stretch.words.startswith("stretch of all lines")
    assert abs(abs(stretch.value) - 1.0) < 4.0 * max(stretch.sigma, 0.05)
    assert found.to_dict()["considered"][-1]["words"] == stretch.words


def test_numbers_that_are_unknown_are_not_considered_too() -> None:
    rng = np.random.default_rng(4)
    _, made = made_with("none", rng)
    plan = CalibrationPlan(unknowns=("exit_point", "length_offset", "sheave_radius"), shared=("sheave_radius",))
    words = [each.words for each in calibrate(WANG, made.measured, plan).doubt.considered]
    assert not any("radius" in each for each in words)
    assert len(words) == 2
    names = [each.words for each in calibrate(WANG, made.measured).doubt.considered]
    assert sum("sheave radius" in each for each in names) == 4


@pytest.mark.parametrize("seed", some(range(3)))
@pytest.mark.parametrize("told", some([True, False]))
def test_friction_in_the_sheaves_is_reported(seed: int, told: bool) -> None:
    """With tension errors of 3 % a modulus error of 20 % had a sigma of 2.3 %, one of 63 mm of an exit point 5.3 mm."""
    rng = np.random.default_rng(seed)
    made = measure(PATY, random_poses(PATY, 40, rng, "catenary"), 1e-4, rng, 0.02, "catenary", SensorNoise(tension=5.0))
    assert made.measured.tensions is not None
    tensions = made.measured.tensions * (1.0 + 0.03 * rng.choice([-1.0, 1.0], made.measured.tensions.shape))
    sigma = Sigmas(encoder=1e-4, tension=5.0) if told else Sigmas()
    plan = CalibrationPlan(unknowns=ALL, shared=("modulus",), sigma=sigma)
    found = calibrate(PATY, replace(made.measured, tensions=tensions), plan, cable="catenary", rough=0.02)
    exits, _ = aligned(found.values[:12].reshape(-1, 3), exits_of(PATY))
    assert found.verdict != "good"
    assert 5.0 < found.problem.factors["tensions"] < 15.0
    assert np.abs(exits - exits_of(PATY)).max() < 3.0 * found.exit_sigma
    assert abs(found.values[-1] - 1.0) < 3.0 * found.sigma[-1]


def positioned(seed: int, truth: float, told: float) -> Calibration:
    rng = np.random.default_rng(seed)
    made = measure(WANG, random_poses(WANG, 30, rng), 1e-4, rng)
    guess = made.poses + rng.normal(0.0, truth, (30, 3))
    measured = replace(made.measured, guess=guess, pose_sigma=np.full((30, 3), told))
    return calibrate(WANG, measured, CalibrationPlan(sigma=Sigmas(encoder=1e-4)), need=1.0)


def test_a_given_sigma_grows_where_residuals_deny_it_and_never_falls() -> None:
    seeds = range(often(1, 4))
    grown = [positioned(seed, 4e-3, 1e-3).problem.factors["positions"] for seed in seeds]
    assert np.mean(grown) == pytest.approx(4.0, rel=0.15)
    kept = [positioned(seed, 1e-3, 1e-2).problem.factors.get("positions", 1.0) for seed in seeds]
    assert kept == [1.0] * len(seeds)


def test_a_surveyed_point_that_has_an_error_widens_the_others() -> None:
    rng = np.random.default_rng(5)
    made = measure(WANG, random_poses(WANG, 40, rng), 1e-4, rng)
    found = calibrate(WANG, made.measured, surveyed(rng, 0.01))
    assert found.problem.factors[SURVEY] > 3.0
    assert any("residuals of the surveyed points" in each for each in found.reasons)
    again = StraightProblem.of(WANG, made.measured, found.problem.plan).weighed_as(found.problem)
    assert again.rows.linear == pytest.approx(found.problem.rows.linear)
    assert again.weighed_as(again).rows.linear == pytest.approx(again.rows.linear)


def test_the_average_over_kinds_is_that_of_their_models() -> None:
    rng = np.random.default_rng(5)
    rows, off, sizes = rng.normal(size=(30, 4)), rng.normal(size=30), np.array([0.3, 0.3, 0.1, 0.5])
    names = ("build_up", "build_up", "sag", "hysteresis")
    fitted = (False, False, False, True)
    numbers = [
        Considered(name, None, "", "1", 0.0, size, 0.0, fitted=fit)
        for name, size, fit in zip(names, sizes.tolist(), fitted, strict=True)
    ]
    found = _found_off(rows, rows.T @ off, numbers)
    moment, weights, within = np.zeros((4, 4)), [], []
    for chosen in ([1, 1, 1, 1], [1, 1, 0, 1], [0, 0, 1, 1], [0, 0, 0, 1]):
        prior = np.diag((sizes * chosen) ** 2)
        of_data = np.eye(30) + rows @ prior @ rows.T
        gain = prior @ rows.T @ np.linalg.inv(of_data)
        weights.append(np.exp(-0.5 * (off @ np.linalg.solve(of_data, off) + np.linalg.slogdet(of_data)[1])))
        moment += weights[-1] * (prior - gain @ rows @ prior + np.outer(gain @ off, gain @ off))
        within.append(chosen)
    assert found.averaged == pytest.approx(moment / sum(weights), abs=1e-12)
    assert found.probability == pytest.approx(np.array(weights) @ within / sum(weights))
    assert np.linalg.eigvalsh(found.averaged)[0] >= 0.0
