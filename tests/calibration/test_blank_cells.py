"""Rows that lack a sensor: blank cells of load cells, swivels and tilts, and tensions without start values."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.measurements import Measured, read_measured, write_measured
from cablewright.calibration.plan import CalibrationPlan, Prior, Sigmas
from cablewright.calibration.poses.problem import StraightProblem
from cablewright.calibration.poses.simulation import SensorNoise, measure, random_poses
from cablewright.foundation.errors import InputError
from cablewright.robot import Robot, load

WANG, COGIRO, PATY = load("wang2021"), load("cogiro"), load("paty2021")


def made_of(robot: Robot, seed: int, noise: float, sensors: SensorNoise, cable: str = "rigid") -> Measured:
    rng = np.random.default_rng(seed)
    return measure(robot, random_poses(robot, 24, rng, cable), noise, rng, 0.01, cable, sensors).measured


def with_blanks(values: np.ndarray | None, seed: int, share: float = 0.3) -> np.ndarray:
    assert values is not None
    return np.where(np.random.default_rng(seed).random(values.shape) < share, np.nan, values)


def exits_off(robot: Robot, values: np.ndarray) -> float:
    exits = np.array([line.exit_point for line in robot.lines]).ravel()
    return float(np.abs(values[: len(exits)] - exits).max())


def test_blank_tensions_of_straight_lines_say_nothing_and_harm_nothing() -> None:
    """Without noise the answer is right to 0.1 mm, with whole rows, single cells and a whole column blank."""
    measured = made_of(WANG, 1, 0.0, SensorNoise(tension=0.0))
    tensions = with_blanks(measured.tensions, 1)
    tensions[3], tensions[:, 1] = np.nan, np.nan
    plan = CalibrationPlan(sigma=Sigmas(encoder=1e-4, tension=1.0))
    found = calibrate(WANG, replace(measured, tensions=tensions), plan, rough=0.05, outliers=False)
    assert found.status == "ok"
    assert exits_off(WANG, found.values) < 1e-4


def test_a_blank_cell_weighs_as_a_cell_of_no_accuracy() -> None:
    """Rows of a pose with a blank cell are those after elimination of its tension."""
    measured = made_of(COGIRO, 2, 0.0, SensorNoise(tension=0.0))
    assert measured.tensions is not None
    blank = measured.tensions.copy()
    blank[:, [2, 5]] = np.nan
    plan = CalibrationPlan(unknowns=("length_offset", "tension_offset"), sigma=Sigmas(tension=1.0))
    priors = (Prior(name="tension_offset", deviation=100.0),)
    problem = StraightProblem.of(COGIRO, replace(measured, tensions=blank), plan.model_copy(update={"priors": priors}))
    assert (problem.row_counts == 8 + 4).all()
    whole = StraightProblem.of(COGIRO, measured, plan)
    assert (whole.row_counts == 8 + 6).all()
    assert measured.guess is not None
    rows = problem.derivatives(problem.free, measured.guess)
    columns = [at for at, each in enumerate(problem.unknowns) if each.name == "tension_offset"]
    by_cell = np.abs(rows.by_unknown[:, 8:, columns]).max(axis=(0, 1))
    assert by_cell[[2, 5]].max() < 0.02 * by_cell.min(initial=np.inf, where=~np.isin(range(8), [2, 5]))


def test_tensions_need_no_start_values_where_lengths_determine_the_poses() -> None:
    measured = replace(made_of(WANG, 3, 0.0, SensorNoise(tension=0.0)), guess=None)
    plan = CalibrationPlan(sigma=Sigmas(encoder=1e-4, tension=1.0))
    found = calibrate(WANG, measured, plan, rough=0.02, outliers=False)
    assert found.status == "ok"
    assert found.gauge == ("translation along x", "translation along y", "translation along z", "yaw")
    assert found.rms < 1e-8
    assert measured.tensions is not None
    three = Measured(measured.counted[:, :3], tensions=measured.tensions[:, :3])
    with pytest.raises(InputError, match="columns x,y,z, start values"):
        calibrate(WANG.model_copy(update={"lines": WANG.lines[:3]}), three, plan)


def test_blank_tensions_of_lines_that_stretch_count_for_nothing() -> None:
    measured = made_of(PATY, 4, 0.0, SensorNoise(tension=0.0), "elastic")
    plan = CalibrationPlan(sigma=Sigmas(encoder=1e-4, tension=1.0))
    measured = replace(measured, tensions=with_blanks(measured.tensions, 4, 0.1))
    found = calibrate(PATY, measured, plan, cable="elastic", rough=0.02, outliers=False)
    assert found.status == "ok"
    assert exits_off(PATY, found.values) < 1e-6


def test_blank_angles_count_for_nothing() -> None:
    measured = made_of(WANG, 5, 0.0, SensorNoise(swivel=0.0))
    turned = replace(measured, swivel=with_blanks(measured.swivel, 5) - 0.7)
    plan = CalibrationPlan(unknowns=("exit_point", "length_offset", "swivel_offset"), sigma=Sigmas(encoder=1e-4))
    found = calibrate(WANG, turned, plan, rough=0.02, outliers=False)
    assert found.values[-4:] == pytest.approx(0.7, abs=1e-6)
    body = made_of(COGIRO, 6, 0.0, SensorNoise(tilt=0.0, yaw=0.0))
    body = replace(body, tilt=with_blanks(body.tilt, 6), yaw=with_blanks(body.yaw, 7))
    again = calibrate(COGIRO, body, CalibrationPlan(sigma=Sigmas(encoder=1e-4)), rough=0.02, outliers=False)
    assert exits_off(COGIRO, again.values) < 1e-6
    assert again.rms < 1e-8


def test_friction_before_a_cell_is_a_share_of_its_tension() -> None:
    """Tensions with errors of 3 % of either sign: with this sigma, their residuals are as large as their sigma says."""
    ratios = []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        measured = made_of(WANG, seed, 1e-4, SensorNoise(tension=0.5))
        assert measured.tensions is not None
        off = measured.tensions * (1.0 + 0.03 * rng.choice([-1.0, 1.0], measured.tensions.shape))
        plan = CalibrationPlan(sigma=Sigmas(encoder=1e-4, tension=0.5, friction=0.03))
        found = calibrate(WANG, replace(measured, tensions=off), plan, rough=0.02, outliers=False)
        ratios.append(found.problem.factors.get("tensions", 1.0))
    assert np.mean(ratios) < 1.2


@pytest.mark.parametrize(
    ("sensor", "column"), [("tensions", "f_1"), ("swivel", "swivel_1"), ("tilt", "tilt_x"), ("yaw", "yaw")]
)
def test_a_sensor_without_any_reading_is_rejected(sensor: str, column: str, tmp_path: Path) -> None:
    count = {"tensions": 8, "swivel": 8, "tilt": 2, "yaw": 1}[sensor]
    data = Measured(np.zeros((3, 8)), **{sensor: np.full((3, count), np.nan)})
    file = tmp_path / "d.csv"
    file.write_text(write_measured(data, COGIRO))
    with pytest.raises(InputError, match=f"line 2: {column} and all others of it are blank; leave the columns out"):
        read_measured(file, COGIRO)


def test_an_offset_without_any_reading_is_named() -> None:
    measured = made_of(WANG, 8, 1e-4, SensorNoise(tension=1.0))
    assert measured.tensions is not None
    tensions = np.where(np.arange(4) == 2, np.nan, measured.tensions)
    plan = CalibrationPlan(unknowns=("exit_point", "length_offset", "tension_offset"))
    with pytest.raises(InputError, match=f"tension offset of {WANG.lines[2].name}: .* has no reading of it"):
        calibrate(WANG, replace(measured, tensions=tensions), plan)
