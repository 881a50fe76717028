"""Input that says a thing twice, or of different parts: rejected by one line that names the place."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.measurements import Measured, read_measured, write_measured
from cablewright.calibration.plan import Bound, CalibrationPlan, Group, Known, load_plan
from cablewright.calibration.poses.problem import StraightProblem
from cablewright.calibration.poses.simulation import SensorNoise, measure, simulate_calibration
from cablewright.foundation.errors import InputError
from cablewright.models.rotation import matrices
from cablewright.robot import Eyelet, Line, Robot, load

WANG = load("wang2021")


@cache
def made() -> Measured:
    """Lengths and angles at 20 poses."""
    return simulate_calibration(WANG, 20, 1e-4, seed=1, sensors=SensorNoise(swivel=1e-3)).measured


def with_first(robot: Robot, **own: object) -> Robot:
    return robot.model_copy(update={"lines": (robot.lines[0].model_copy(update=own), *robot.lines[1:])})


def drummed(line: Line, radius: float) -> Line:
    return line.model_copy(update={"winch": line.winch.model_copy(update={"drum_radius": radius})})


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (
            "deviation = 0\n\n[[known]]\nname = 'build_up'\ndeviation = 1e-3",
            r"known\[1\].name': build_up is in known\[0\] too",
        ),
        (
            "lines = ['a', 'b']\ndeviation = 0\n\n[[known]]\nname = 'build_up'\ndeviation = 1e-3",
            "build_up of a, b is in",
        ),
        ("lines = ['a']\ndeviation = 0\n\n[[known]]\nname = 'build_up'\nlines = ['b']\ndeviation = 1e-3", ""),
    ],
)
def test_a_known_number_is_given_once(tmp_path: Path, text: str, fault: str) -> None:
    file = tmp_path / "plan.toml"
    file.write_text(f"schema = 1\n\n[[known]]\nname = 'build_up'\n{text}\n")
    if not fault:
        assert len(load_plan(file).known) == 2
        return
    with pytest.raises(InputError, match=fault):
        load_plan(file)


def test_a_range_is_given_once() -> None:
    bounds = (Bound(name="build_up", min=0.0, max=0.1), Bound(name="build_up", min=0.0, max=0.2))
    with pytest.raises(ValueError, match=r"build_up is in bounds\[0\] too"):
        CalibrationPlan(bounds=bounds)


def test_of_several_lines_the_widest_deviation_counts_for_a_shared_number() -> None:
    names = [line.name for line in WANG.lines]
    known = (
        Known(name="build_up", lines=tuple(names[:2]), deviation=0.0),
        Known(name="build_up", lines=tuple(names[2:]), deviation=1e-3),
    )
    found = calibrate(WANG, made(), CalibrationPlan(known=known), rough=0.05, outliers=False)
    assert "build_up" in {each.name for each in found.doubt.considered}


def test_a_copied_row_is_rejected(tmp_path: Path) -> None:
    file = tmp_path / "data.csv"
    text = write_measured(made(), WANG).splitlines()
    file.write_text("\n".join([*text, text[7]]) + "\n")
    with pytest.raises(
        InputError, match="line 22: repeats all measurements of line 8; a copied row is no new measurement"
    ):
        calibrate(WANG, file)
    file.write_text("\n".join([*text, text[7].rpartition(",")[0] + ",0.5"]) + "\n")
    assert len(read_measured(file, WANG).counted) == 21


def test_home_may_be_measured_again() -> None:
    counted = made().counted - made().counted[0]
    counted[9] = 0.0
    assert made().guess is not None
    data = replace(
        made(), counted=counted, swivel=None, guess=np.vstack([made().guess[:9], made().guess[:1], made().guess[10:]])
    )
    assert calibrate(WANG, data, rough=0.05, outliers=False).status == "ok"


def test_a_group_is_of_lines_with_the_same_parts() -> None:
    first, second, *_ = (line.name for line in WANG.lines)

    def plan(name: str) -> CalibrationPlan:
        return CalibrationPlan(
            unknowns=("exit_point", "length_offset", name), groups=(Group(name=name, lines=(first, second)),)
        )

    with pytest.raises(
        InputError,
        match=f"groups: sheave_radius: line '{first}' does not have this number; leave the line out of the group",
    ):
        StraightProblem.of(with_first(WANG, sheave=Eyelet()), replace(made(), swivel=None), plan("sheave_radius"))
    spools = load("hangprinter-v4")
    lines = (drummed(spools.lines[0], 0.09), *(drummed(line, 0.05) for line in spools.lines[1:]))
    other = spools.model_copy(update={"lines": lines})
    names = tuple(line.name for line in spools.lines[:2])
    counted = simulate_calibration(other, 20, 1e-4, seed=1).measured
    both = CalibrationPlan(
        unknowns=("exit_point", "length_offset", "build_up"), groups=(Group(name="build_up", lines=names),)
    )
    with pytest.raises(InputError, match=r"groups: build_up of .*: of different drums or cables"):
        StraightProblem.of(other, counted, both)


def positioned(seed: int = 1) -> Measured:
    return simulate_calibration(WANG, 40, 1e-4, seed=seed, sensors=SensorNoise(pose=1e-3)).measured


@pytest.mark.parametrize(("rows", "shift", "turn"), [(20, (0.5, 0.2, 0.0), 0.0), (12, (0.05, 0.0, 0.02), 0.02)])
def test_positions_in_two_frames_are_named(rows: int, shift: tuple[float, ...], turn: float) -> None:
    """The last rows are measured in a frame that is moved and turned."""
    data = positioned()
    assert data.guess is not None
    guess = data.guess.copy()
    guess[-rows:] = guess[-rows:] @ matrices([0.0, 0.0, turn]).T + shift
    found = calibrate(WANG, replace(data, guess=guess), rough=0.05)
    assert found.verdict == "bad"
    first, *_ = found.reasons
    assert first.startswith("measured positions are in two frames: that of pose ")
    assert f"and {rows - 3} more is " in first
    assert "measure all from one set-up" in first
    if rows < 20:
        assert "that of pose 29, pose 30, pose 31 and 9 more" in first
        assert f"turned by {np.degrees(turn):.2g} deg" in first


def test_a_scale_that_lengths_do_not_know_makes_no_frames() -> None:
    """Two clusters of positions, drums of a radius that is 1.5 % off, and one wrong position."""
    rng = np.random.default_rng(4)
    places = np.concatenate([rng.uniform([-1.2, -0.8, 1.0], [-0.6, 0.8, 1.8], (16, 3)),
                             rng.uniform([0.6, -0.8, 1.0], [1.2, 0.8, 1.8], (16, 3))])  # fmt: skip
    made = measure(WANG, places, 1e-4, rng, sensors=SensorNoise(pose=1e-3)).measured
    assert made.guess is not None
    guess = made.guess.copy()
    guess[7] += 0.05
    plan = CalibrationPlan(unknowns=("exit_point", "length_offset", "length_scale"), shared=("length_scale",))
    found = calibrate(WANG, replace(made, counted=made.counted / 1.015, guess=guess), plan, rough=0.05)
    assert not any("frames" in reason for reason in found.reasons)


def test_positions_in_one_frame_are_not() -> None:
    """Neither where a few positions are wrong, nor where lengths are."""
    data, rng = positioned(), np.random.default_rng(3)
    assert data.guess is not None
    guess = data.guess.copy()
    guess[::8] += rng.normal(0.0, 0.05, (5, 3))
    wrong = replace(data, guess=guess)
    for each in (data, wrong, replace(data, counted=data.counted[:, [1, 0, 2, 3]])):
        assert not any("frames" in reason for reason in calibrate(WANG, each, rough=0.05).reasons)


def test_counts_that_come_again_at_another_position_are_rejected() -> None:
    data = positioned()
    counted = data.counted.copy()
    counted[31] = counted[32] = counted[30]
    with pytest.raises(InputError, match=r"pose 33: repeats the counts of pose 31, but its position is .* m away"):
        calibrate(WANG, replace(data, counted=counted))
    assert data.guess is not None
    counted[32] = data.counted[32]  # one alone is left to the search for wrong rows, which names it
    alone = calibrate(WANG, replace(data, counted=counted), rough=0.05)
    assert [each.pose for each in alone.rejected] == [31] or any("pose 32" in each for each in alone.notes)
    guess = data.guess.copy()
    guess[31] = guess[30] + 1e-3  # the same pose, measured again
    assert calibrate(WANG, replace(data, counted=counted, guess=guess), rough=0.05).status == "ok"
