"""Lines in a plan: numbers that some share, priors of a coordinate, lengths that are absolute."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.plan import CalibrationPlan, Group, Point, Prior, load_plan
from cablewright.calibration.poses.problem import StraightProblem
from cablewright.calibration.poses.simulation import SensorNoise, measure, random_poses
from cablewright.foundation.errors import InputError
from cablewright.kernels.fitting import line_over_sheave
from cablewright.robot import load

WANG = load("wang2021")
NAMES = [line.name for line in WANG.lines]
SCALED = ("exit_point", "length_offset", "length_scale")
PAIRS = (Group(name="length_scale", lines=tuple(NAMES[:2])), Group(name="length_scale", lines=tuple(NAMES[2:])))


def measured(scales: np.ndarray, seed: int = 1, known: int = 9):
    """44 poses, of which the first ones are measured to a millimetre, of lines that are longer than counted."""
    rng = np.random.default_rng(seed)
    made = measure(WANG, random_poses(WANG, 44, rng), 1e-4, rng, sensors=SensorNoise(pose=1e-3))
    some = np.where(np.arange(44)[:, None] < known, made.measured.pose_sigma, np.nan)
    guess = np.where(np.arange(44)[:, None] < known, made.measured.guess, np.nan)
    return replace(made.measured, counted=made.measured.counted / scales, guess=guess, pose_sigma=some)


def test_lines_of_a_group_share_their_number() -> None:
    scales = np.array([1.01, 1.01, 0.995, 0.995])
    plan = CalibrationPlan(unknowns=SCALED, groups=PAIRS)
    found = calibrate(WANG, measured(scales), plan, need=0.02)
    told = dict(zip([each.label for each in found.unknowns], found.values, strict=True))
    sigma = dict(zip([each.label for each in found.unknowns], found.sigma, strict=True))
    for pair, scale in ((NAMES[:2], 1.01), (NAMES[2:], 0.995)):
        label = f"length scale of {', '.join(pair)}"
        assert told[label] == pytest.approx(scale, abs=4.0 * sigma[label])
        assert sigma[label] < 2e-3
    alone = calibrate(WANG, measured(scales), CalibrationPlan(unknowns=SCALED), need=0.02)
    assert len(alone.unknowns) == len(found.unknowns) + 2
    grouped, own = (each.noise_sigma[:12].max() / each.encoder_sigma for each in (found, alone))
    assert grouped < own  # knowledge of the machine helps


def test_a_line_beside_a_group_has_its_own_number() -> None:
    plan = CalibrationPlan(unknowns=SCALED, groups=PAIRS[:1])
    problem = StraightProblem.of(WANG, measured(np.ones(4)), plan)
    scales = [each.label for each in problem.unknowns if each.name == "length_scale"]
    assert scales == [f"length scale of {NAMES[0]}, {NAMES[1]}", *(f"length scale of {name}" for name in NAMES[2:])]
    columns = problem.rows.target[:, line_over_sheave.SCALE]
    assert columns[0] == columns[1] != columns[2] != columns[3]


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"groups": (Group(name="length_scale", lines=(NAMES[0], "nowhere")),)}, "unknown line 'nowhere'"),
        ({"groups": (PAIRS[0], PAIRS[0])}, "is in it twice"),
        ({"groups": (Group(name="sheave_radius", lines=tuple(NAMES[:2])),)}, "is not among the unknowns"),
        ({"groups": (Group(name="length_offset", lines=tuple(NAMES[:2])),)}, "cannot be one number"),
        ({"groups": (Group(name="exit_point", lines=tuple(NAMES[:2])),)}, "cannot be one number"),
        ({"groups": PAIRS, "shared": ("length_scale",)}, "is shared by all lines"),
    ],
)
def test_groups_that_make_no_sense_are_rejected(changes: dict[str, object], told: str) -> None:
    plan = CalibrationPlan(unknowns=SCALED).model_copy(update=changes)
    with pytest.raises(InputError, match=told):
        StraightProblem.of(WANG, measured(np.ones(4)), plan)


def test_a_prior_of_a_coordinate_holds_that_one() -> None:
    """Heights that are known to 0.1 mm stay, and x and y do not count as known."""
    made = measure(WANG, random_poses(WANG, 40, np.random.default_rng(2)), 1e-4, np.random.default_rng(3)).measured
    free = calibrate(WANG, made, need=0.1)
    held = calibrate(WANG, made, CalibrationPlan(priors=(Prior(name="exit_point.z", deviation=1e-4),)), need=0.1)
    heights = np.array([each.kind == "exit_point.z" for each in held.unknowns])
    assert held.sigma[heights].max() <= 1.01e-4
    assert free.sigma[heights].max() > 1e-3
    assert np.abs(held.changes[heights]).max() < 5e-4
    assert int(held.problem.is_prior.sum()) == 4


def test_absolute_lengths_have_no_home(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    made = measure(WANG, random_poses(WANG, 40, rng), 1e-4, rng)
    lengths = replace(made.measured, counted=made.measured.counted + made.home_lengths)
    file = tmp_path / "plan.toml"
    file.write_text('schema = 1\nlengths = "absolute"\n')
    plan = load_plan(file)
    assert plan.unknowns == ("exit_point",)
    points = tuple(Point(line=line.name, at=line.exit_point) for line in WANG.lines[:3])
    found = calibrate(WANG, lengths, plan.model_copy(update={"points": points}), need=5e-3)
    assert len(found.unknowns) == 12
    truth = np.array([line.exit_point for line in WANG.lines]).ravel()
    assert np.abs(found.values - truth).max() < 4.0 * found.exit_sigma


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('lengths = "absolute"\nunknowns = ["exit_point", "length_offset"]', "leave length_offset out"),
        ('lengths = "relative"\nunknowns = ["exit_point"]', "add length_offset"),
        ('lengths = "long"', "absolute"),
        ('[[groups]]\nname = "nothing"\nlines = ["a", "b"]', "unknown number"),
        ('[[groups]]\nname = "build_up"\nlines = ["a"]', "lines"),
        ('[[priors]]\nname = "exit_point.w"\ndeviation = 0.1', "unknown number"),
    ],
)
def test_plans_that_say_otherwise_are_rejected_in_a_line(text: str, told: str, tmp_path: Path) -> None:
    file = tmp_path / "plan.toml"
    file.write_text(f"schema = 1\n{text}\n")
    with pytest.raises(InputError, match=told) as error:
        load_plan(file)
    assert "\n" not in str(error.value)
