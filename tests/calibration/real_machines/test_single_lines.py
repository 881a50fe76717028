"""A number of one line that is not that of the file: tested by residuals, named, and found where the drum is wrong."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from benchmarks.campaigns.twins import errors, outside_spools

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.judgement.model_doubt import with_more
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.judgement.score_tests import LEVEL
from cablewright.calibration.plan import CalibrationPlan, Known, Sigmas
from cablewright.calibration.poses.simulation import SensorNoise, measure, random_poses
from cablewright.robot import Robot, load
from cases import often

WANG = load("wang2021")
FILE = CalibrationPlan(sigma=Sigmas(encoder=1e-4))


def larger(radius: float) -> Robot:
    """The robot with another radius of its first sheave, m."""
    first = WANG.lines[0]
    assert first.sheave.kind == "swivel"
    sheave = first.sheave.model_copy(update={"radius": radius})
    return WANG.model_copy(update={"lines": (first.model_copy(update={"sheave": sheave}), *WANG.lines[1:])})


def calibrated(robot: Robot, seed: int, drum: float = 1.0, models: Literal["file", "auto"] = "file") -> Calibration:
    """40 poses, measured to 1 mm; the drum of the second line has *drum* times the radius in the file."""
    rng = np.random.default_rng(seed)
    made = measure(robot, random_poses(robot, 40, rng), 1e-4, rng, sensors=SensorNoise(pose=1e-3)).measured
    data = replace(made, counted=made.counted / [1.0, drum, 1.0, 1.0])
    return calibrate(WANG, data, FILE, rough=0.05, outliers=False, need=5e-3, models=models)


def test_a_score_is_that_of_least_squares_with_one_more_unknown() -> None:
    """Against a dense solution with all poses, of rows that are written out."""
    found = calibrated(WANG, 1)
    problem, fit = found.problem, found.fit
    _, rows, more = with_more(problem, fit, ["sheave_radius", "length_scale"], ())
    count, e, p = rows.by_pose.shape
    k = len(fit.theta)
    for score in found.scores:
        column = k + next(at for at, each in enumerate(more) if each.label == score.words)
        dense = np.zeros((count * e + len(rows.others), k + 1 + count * p))
        dense[: count * e, : k + 1] = rows.by_unknown[..., [*range(k), column]].reshape(-1, k + 1)
        dense[count * e :, :k] = rows.others_by_unknown[:, :k]
        for j in range(count):
            dense[j * e : (j + 1) * e, k + 1 + j * p : k + 1 + (j + 1) * p] = rows.by_pose[j]
        rest = np.append(rows.residual.ravel(), rows.others)
        change = np.linalg.lstsq(dense, -rest, rcond=1e-12)[0]
        spread = np.linalg.pinv(dense.T @ dense, rcond=1e-14, hermitian=True)
        assert score.value == pytest.approx(change[k], rel=1e-4, abs=1e-3 * score.sigma)
        assert score.sigma == pytest.approx(found.scale * np.sqrt(spread[k, k]), rel=1e-4)
        assert score.shift == pytest.approx(change[:k], abs=1e-3 * np.abs(change[:k]).max() + 1e-3 * score.sigma)
    assert len(found.scores) == 8


def test_scores_of_a_right_file_are_standard_normal() -> None:
    scores = [each for seed in range(often(8, 20)) for each in calibrated(WANG, 100 + seed).scores]
    normal = np.array([each.value / each.sigma for each in scores])
    assert np.sqrt(np.mean(normal**2)) == pytest.approx(1.0, abs=0.15)
    assert sum(each.probability < LEVEL for each in scores) <= often(0, 1)


def test_a_sheave_that_is_plainly_larger_is_named() -> None:
    found = calibrated(larger(0.1), 3)
    (best, *_), name = found.scores, WANG.lines[0].name
    assert best.words == f"sheave radius of {name}"
    assert best.value == pytest.approx(0.025, abs=4.0 * best.sigma)
    assert found.verdict != "good"
    assert any(f"another sheave radius of {name}" in each and "measure it" in each for each in found.reasons)
    known = FILE.model_copy(update={"known": (Known(name="sheave_radius", deviation=0.0),)})
    assert all(
        each.name == "length_scale" for each in calibrate(WANG, found.problem.measured, known, rough=0.05).scores
    )


def test_errors_that_no_data_show_are_reported() -> None:
    found = calibrated(WANG, 4)
    worst = max((each for each in found.scores if each.name == "sheave_radius"), key=lambda each: each.sigma)
    radius, scale = found.unseen
    if "radius" not in radius:
        radius, scale = scale, radius
    assert radius == f"an error of the {worst.words} shows only from {worst.shows:.2g} m, in four of five cases"
    assert "length scale of" in scale
    assert found.to_dict()["unseen"] == list(found.unseen)


def test_the_drum_of_one_line_is_found() -> None:
    plain, found = calibrated(WANG, 5, 1.03), calibrated(WANG, 5, 1.03, "auto")
    name = WANG.lines[1].name
    (effect,) = [each for each in found.effects if each.chosen]
    assert effect.name == f"length_scale.{name}"
    assert effect.value == pytest.approx(0.03, abs=1e-4)
    assert found.verdict == "doubtful"
    assert any(f"the drum of {name} pays out 3 % more" in each for each in found.reasons)
    assert plain.verdict != "good"
    exits = np.array([line.exit_point for line in WANG.lines]).ravel()
    assert np.abs(found.values[:12] - exits).max() < 4.0 * found.sigma[:12].max() < 0.02
    assert not any("length_scale." in each.name for each in calibrated(WANG, 5, 1.0, "auto").effects)


def test_a_printer_with_a_drum_of_another_size_finds_held_out_positions() -> None:
    twin = outside_spools(8000)
    found = calibrate(twin.file, twin.measured, twin.plan, rough=0.05, need=5e-3, models="auto")
    assert found.verdict != "good"
    assert float(np.sqrt(np.mean(errors(twin, found, twin.counts) ** 2))) < 3e-3
