"""A yes of `check` is no further than its own figures: lengths, speeds, jumps, sums of errors, contact with a plane."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tools.drawn_machines import share
from tools.random_checks import Tally, straight_lengths

from cablewright.analyses.feasibility import INTERPOLATION, LENGTH_JUMP, MOVED_ERROR, PACE, PLANE_FORCE, SLACK
from cablewright.printing.job import Job
from cablewright.robot import Robot, load, loads
from cablewright.robot.plausibility import overstretched
from cablewright.solvers import inverse as inverse_module
from cablewright.studies.checks.check import check
from cablewright.studies.checks.result import Check
from cablewright.studies.one_pose import SolvedPose
from cases import some

LOW_LINES = """
schema = 1
name = "low lines"
scene = { frame_min = [-2, -2, 0], frame_max = [2, 2, 2.5] }
platform = { mass = "0.5 kg" }
cable = { axial_stiffness = "20 kN", linear_density = "0.9 g/m", breaking_load = "1 kN" }
sheave = { kind = "eyelet" }
line = { tension_limits = [0, 35] }
lines = [
    { name = "a", advantage = 2, exit_point = [0, -2, 0] },
    { name = "b", advantage = 2, exit_point = [2, 1.5, 0] },
    { name = "c", advantage = 2, exit_point = [-2, 1.5, 0] },
    { name = "d", advantage = 4, exit_point = [0, 0, 2.5] },
]
"""
BOARD = """
schema = 1
name = "board"
scene = { frame_min = [-1, -1, -0.01], frame_max = [1, 1, 0.4] }
platform = { mass = "5 kg", plane = { normal = [0, 0, 1] SIDED } }
cable = { axial_stiffness = "140 kN", linear_density = "30 g/m", breaking_load = "2 kN" }
sheave = { kind = "eyelet" }
line = { tension_limits = ["80 N", "400 N"] }
lines = [
    { name = "a", exit_point = [-1, -1, 0.4] },
    { name = "b", exit_point = [1, -1, 0.4] },
    { name = "c", exit_point = [1, 1, 0.4] },
    { name = "d", exit_point = [-1, 1, 0.4] },
]
"""
CORNERS = "G21\nG90\nM83\n;LAYER:0\nG0 X-300 Y-300 Z{z} F6000\nG1 X300 Y-300 E9 F3000\nG1 X300 Y300 E9\n"
ALONE = ("interference",)
SLOW = {"print_speed": 0.001, "travel_speed": 0.001}


def board(sided: str = "") -> Robot:
    return loads(BOARD.replace("SIDED", sided))


@pytest.fixture
def corners(tmp_path: Path):
    """A job of two sides of a square at a height, mm."""

    def written(z: float, **more: Any) -> Job:
        file = tmp_path / "part.gcode"
        file.write_text(CORNERS.format(z=z))
        motion = {"shaping": "none"} | more.pop("motion", {})  # corners and lengths are those of the path
        return Job.model_validate({"name": "part", "gcode": str(file), "motion": motion, **more})

    return written


def broken(found: Check) -> set[str]:
    return {each.limit for each in found.findings if each.violations}


class TestSlackLines:
    def test_lines_that_may_hang_slack_are_taut_and_the_preferred_tension_is_reported(self, corners) -> None:
        found = check(loads(LOW_LINES), corners(400.0), skip=ALONE)
        assert found.feasible
        ratio = found.lengths / straight_lengths(found.robot, found.poses)
        assert np.abs(ratio - 1.0).max() < 0.01
        assert (found.statics.lines.winch_speed.max(axis=0) <= 0.1 * np.array([2, 2, 2, 4])).all()
        assert any("nearest to 17.5 N, the preferred tension" in note for note in found.notes)
        assert found.to_dict()["line_preferred_tension"] == [17.5] * 4

    def test_a_solution_that_jumps_between_taut_and_slack_is_a_no(self, corners, monkeypatch) -> None:
        monkeypatch.setattr(inverse_module, "preferred_tensions", lambda _model: None)
        found = check(loads(LOW_LINES), corners(400.0), skip=ALONE)
        assert not found.feasible
        assert {SLACK, PACE, INTERPOLATION, LENGTH_JUMP} <= broken(found)
        assert any(f"{name} of line" in found.verdict for name in (SLACK, PACE, INTERPOLATION, LENGTH_JUMP))

    def test_one_pose_reports_it_too(self) -> None:
        found = SolvedPose.judged(inverse_module.inverse(loads(LOW_LINES), [0.0, 0.0, 0.4]))
        assert found.to_dict()["preferred_tensions"] == [17.5] * 4
        assert "17.5 N, the preferred tension" in found.notes[0]


class TestErrors:
    def test_expected_error_and_displacement_add_up(self, corners) -> None:
        robot = loads(LOW_LINES)
        calm = check(robot, corners(400.0, motion=SLOW), skip=ALONE)
        assert calm.expected is not None
        moved = check(robot, corners(400.0), skip=ALONE).to_dict()["motion_error"]
        allowed = calm.expected.value + 0.5 * moved
        assert check(robot, corners(400.0, motion=SLOW, max_error=allowed), skip=ALONE).feasible
        no = check(robot, corners(400.0, max_error=allowed), skip=ALONE)
        assert broken(no) == {MOVED_ERROR}
        assert "the sum of expected error and error by motion is" in no.verdict

    def test_without_the_expected_error_the_displacement_is_judged_alone(self, corners) -> None:
        found = check(loads(LOW_LINES), corners(400.0, max_error=1e-6), skip=(*ALONE, "expected-error"))
        assert broken(found) == {MOVED_ERROR}

    def test_a_yes_says_what_the_motion_adds_with_which_damping(self, corners) -> None:
        found = check(loads(LOW_LINES), corners(400.0), skip=ALONE)
        assert "Hz with a damping ratio of 1 % (assumed)" in found.verdict
        assert not any("swinging" in each for each in found.not_checked)

    def test_a_swing_of_travel_counts_where_it_lasts_into_what_is_laid(self, tmp_path: Path) -> None:
        """After a long stand nothing of it is left; without one it is."""
        rows = "G21\nG90\nM83\n;LAYER:0\nG0 X-300 Y-300 Z400 F6000\nG0 X300\nG0 Y300\n{stand}G1 X-300 E9 F60\n"
        errors = {}
        for stand in ("", "G4 P60000\n"):
            (tmp_path / "part.gcode").write_text(rows.format(stand=stand))
            motion = {"acceleration": 20.0}
            job = Job.model_validate({"name": "part", "gcode": str(tmp_path / "part.gcode"), "motion": motion})
            found = check(loads(LOW_LINES), job, skip=(*ALONE, "expected-error"))
            assert found.motion is not None
            travel = found.statics.displacement[~found.samples.extruding].max()
            errors[stand] = found.motion.largest / travel
            bound = job.model_copy(update={"max_error": 1.01 * found.motion.largest})
            assert MOVED_ERROR not in broken(check(loads(LOW_LINES), bound, skip=(*ALONE, "expected-error")))
        assert errors["G4 P60000\n"] < 0.2 < errors[""]


class TestPlane:
    def force(self) -> float:
        """Force along the normal at the centre, of straight belts without weight, N."""
        return 4 * 80.0 * 0.4 / np.sqrt(1.0 + 1.0 + 0.16) - 5.0 * 9.81

    @pytest.mark.parametrize("side", ["", ", one_sided = true"])
    def test_a_plane_that_is_not_said_to_hold_both_ways_does_not_hold_a_lifted_sled(self, side: str, corners) -> None:
        found = check(board(side), corners(0.0), skip=ALONE)
        assert broken(found) == {PLANE_FORCE}
        assert "one_sided = false to a plane that holds both ways" in found.verdict
        assert found.to_dict()["max_plane_force"] > self.force()
        pose = SolvedPose.judged(inverse_module.inverse(found.robot, [0.0, 0.0, 0.0]))
        assert pose.equilibrium.plane_force == pytest.approx(self.force(), abs=1.0)
        assert pose.status.word == "out-of-limits"
        assert "plane force" in pose.refusal
        assert "one_sided = false" in pose.refusal

    def test_a_heavy_sled_stays_on_its_board(self, corners) -> None:
        heavy = loads(BOARD.replace("SIDED", ", one_sided = true").replace("5 kg", "60 kg"))
        found = check(heavy, corners(0.0, motion=SLOW), skip=ALONE)
        assert found.feasible
        assert found.statics.plane_force.max() < 0.0

    def test_guides_hold_both_ways(self, corners) -> None:
        found = check(board(", one_sided = false"), corners(0.0), skip=ALONE)
        assert found.feasible
        assert not any("plane" in each for each in found.not_checked)
        pose = SolvedPose.judged(inverse_module.inverse(found.robot, [0.0, 0.0, 0.0]))
        assert pose.refusal == ""

    def test_belts_in_the_plane_do_not_lift(self, corners) -> None:
        flat = loads(BOARD.replace("SIDED", "").replace("0.4]", "0.0]").replace('"9.81 m/s^2"', "0.0"))
        found = check(flat, corners(0.0), skip=ALONE)
        assert PLANE_FORCE not in broken(found)


@pytest.mark.parametrize(("robots", "least"), some([(4, 1), (12, 3)]))
def test_no_yes_of_random_robots_has_an_absurd_figure(robots: int, least: int, tmp_path: Path) -> None:
    tally = Tally()
    for number in range(robots):
        tally.run(3, number, tmp_path)
    assert tally.faults == []
    assert tally.answers["yes"] >= least


def test_machines_that_go_slack_are_within_the_expected_error(tmp_path: Path) -> None:
    helix = {"radius": 0.25, "layers": 1, "layer_height": 0.005, "first_height": 0.3}
    found = check(load("hangprinter-v4"), Job.model_validate({"name": "ring", "helix": helix}), skip=ALONE)
    drawn = share("hangprinter-v4", found, machines=60, samples=40, seed=5)
    assert drawn.within >= 0.87 * drawn.machines
    assert drawn.level == pytest.approx(drawn.expected, rel=0.25)


class TestStrain:
    """A cable that strains by over 5 % at the largest tension of a job, and not at that of its limits, is named."""

    def soft(self, strain: float, corners) -> Check:
        """The board with guides, whose cables strain by *strain* at the largest tension of the job."""
        text = BOARD.replace("SIDED", ", one_sided = false").replace('"2 kN"', "1e4").replace('"400 N"', "1e4")
        stiff = check(loads(text), corners(0.0, motion=SLOW), skip=ALONE)
        newtons = stiff.statics.lines.highest_tension.max() / strain
        return check(loads(text.replace('"140 kN"', repr(float(newtons)))), corners(0.0, motion=SLOW), skip=ALONE)

    def test_it_is_named_with_its_line_value_and_unit(self, corners) -> None:
        notes = [note for note in self.soft(0.08, corners).notes if "strains" in note]
        assert len(notes) == 1
        assert "cable.axial_stiffness = " in notes[0]
        assert "the largest tension of the job" in notes[0]
        assert notes[0].startswith("line '")
        assert notes[0].endswith(" kgf?")

    def test_a_little_less_is_not(self, corners) -> None:
        assert not any("strains" in note for note in self.soft(0.03, corners).notes)

    def test_a_spring_may_stretch(self) -> None:
        robot = board()
        limp = [line.model_copy(update={"spring": 1e4}) for line in robot.lines]
        said = overstretched(robot, [8e3, 0.0, 9e3, 0.0])
        assert len(said) == 1
        assert said[0].startswith(
            "line 'c': cable.axial_stiffness = 140000: it strains by 6.43 % at 9000 N, the largest"
        )
        assert said[0].endswith(": 140000 kgf?")
        assert overstretched(robot.model_copy(update={"lines": tuple(limp)}), [9e3] * 4) == ()
