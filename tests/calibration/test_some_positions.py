"""Positions measured at some rows only: blank cells, from the file to the answer."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.measurements import Measured, read_measured, write_measured
from cablewright.calibration.plan import CalibrationPlan, Sigmas
from cablewright.calibration.poses.simulation import measure, random_poses
from cablewright.foundation.errors import InputError
from cablewright.robot import load
from cases import some

WANG = load("wang2021")
TRUE = np.array([line.exit_point for line in WANG.lines])


def partly(seed: int, known: int, guessed: int, count: int = 30) -> tuple[Measured, np.ndarray]:
    """Data with measured positions at the first *known* poses, guesses at *guessed* more, nothing at the others."""
    rng = np.random.default_rng(seed)
    made = measure(WANG, random_poses(WANG, count, rng), 1e-4, rng)
    sigma = np.full((count, 3), np.nan)
    sigma[:known] = 1e-3
    guess = made.poses + rng.normal(0.0, 1e-3, (count, 3))
    guess[known + guessed :] = np.nan
    return replace(made.measured, guess=guess, pose_sigma=sigma), made.poses


@pytest.mark.parametrize("known", [4, 12])
def test_a_file_with_blanks_is_read_as_it_was_written(tmp_path: Path, known: int) -> None:
    measured, _ = partly(1, known, 5)
    file = tmp_path / "d.csv"
    file.write_text(write_measured(measured, WANG))
    assert ",," in file.read_text()
    again = read_measured(file, WANG)
    for name in ("counted", "guess", "pose_sigma"):
        assert np.array_equal(getattr(again, name), getattr(measured, name), equal_nan=True)
    assert again.positioned == known


@pytest.mark.parametrize("guessed", [0, 8])
@pytest.mark.parametrize("seed", some(range(3)))
def test_a_few_positions_fix_the_frame(seed: int, guessed: int) -> None:
    """What the blank rows leave is what a vague sigma says, and all is found from nothing but nine positions."""
    measured, poses = partly(seed, 9, guessed)
    plan = CalibrationPlan(sigma=Sigmas(encoder=1e-4))
    found = calibrate(WANG, measured, plan)
    assert (found.status, found.gauge, found.rejected) == ("ok", (), ())
    assert np.abs(found.values[:12] - TRUE.ravel()).max() < 4.0 * found.sigma[:12].max() < 0.03
    assert np.abs(found.poses - poses).max() < 0.02
    sigma = np.where(np.isnan(measured.pose_sigma), 100.0, measured.pose_sigma)
    near = poses + np.random.default_rng(seed).normal(0.0, 1e-3, poses.shape)
    guess = np.where(np.isnan(measured.guess), near, measured.guess)
    vague = calibrate(WANG, replace(measured, guess=guess, pose_sigma=sigma), plan)
    assert (np.abs(found.values - vague.values) < 0.1 * found.sigma).all()  # vague rows that fit speak for the sigma
    assert found.sigma == pytest.approx(vague.sigma, rel=0.1)


def test_two_positions_leave_a_turn_open() -> None:
    measured, _ = partly(2, 2, 28)
    found = calibrate(WANG, measured, CalibrationPlan(sigma=Sigmas(encoder=1e-4)))
    assert found.status == "ok"
    assert found.alone.rank == found.alone.total  # two points and a tilt that the sheaves show
    one, _ = partly(2, 1, 29)
    assert len(calibrate(WANG, one, CalibrationPlan(sigma=Sigmas(encoder=1e-4))).gauge) == 1


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        (["0,0,0,0,1,,1,,,"], "line 2: a part of the position is blank"),
        (["0,0,0,0,1,1,1,1,,1"], "line 2: a part of the sigma of the position is blank"),
        (["0,0,0,0,,,,1,1,1", "0,0,0,0,1,1,1,1,1,1"], "line 2: sigma_x without x"),
        (["0,0,0,0,,,,,,"], "x, y, z are blank in all rows"),
        (["0,0,0,0,1,1,1,,,"], "sigma_x is blank in all rows"),
        (["0,0,0,,1,1,1,1,1,1"], "line 2: dl_4 = '': must be a finite number"),
        (["0,0,0,0,1,1,1,0,1,1"], "line 2: sigma_x: must be at least 1e-09"),
    ],
)
def test_blanks_that_say_nothing_are_rejected(tmp_path: Path, rows: list[str], told: str) -> None:
    file = tmp_path / "d.csv"
    file.write_text("\n".join(["dl_1,dl_2,dl_3,dl_4,x,y,z,sigma_x,sigma_y,sigma_z", *rows]) + "\n")
    with pytest.raises(InputError, match=told):
        read_measured(file, WANG)


def test_positions_in_two_frames_are_no_good_calibration() -> None:
    """Half of the positions are from an origin 20 mm aside."""
    measured, _ = partly(7, 24, 0, 24)
    assert measured.guess is not None
    moved = measured.guess + np.where(np.arange(24) < 12, 0.0, 0.02)[:, None] * np.array([1.0, 0.0, 0.0])
    found = calibrate(WANG, replace(measured, guess=moved), rough=0.05)
    assert found.verdict == "bad"
    assert any("contradict each other" in each for each in found.reasons)
