"""A yes of a check holds for the figures that it reports: lengths, speeds, jumps, sums of errors, the plane's force."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from tools.random_checks import Tally, straight_lengths

from cablewright.printing.job import Job
from cablewright.robot import Robot, loads
from cablewright.solvers.inverse import inverse
from cablewright.solvers.tension import tension_distribution
from cablewright.studies.checks.check import check
from cablewright.studies.checks.result import Check
from cablewright.studies.one_pose import SolvedPose

BRANCHES = """
schema = 1
name = "branches"
scene = {{ frame_min = [-2, -2, 0], frame_max = [2, 2, 2.5] }}
platform = {{ mass = "0.5 kg" }}
cable = {{ axial_stiffness = "20 kN", linear_density = "0.9 g/m", breaking_load = "1 kN" }}
sheave = {{ kind = "eyelet" }}
line = {{ tension_limits = [{least}, 35] }}
lines = [
    {{ name = "a", advantage = 2, exit_point = [0, -2, 0] }},
    {{ name = "b", advantage = 2, exit_point = [2, 1.5, 0] }},
    {{ name = "c", advantage = 2, exit_point = [-2, 1.5, 0] }},
    {{ name = "d", advantage = 4, exit_point = [0, 0, 2.5] }},
]
"""
"""Lines that pull against each other, and hang slack where the minimum tension lets them."""

SLED = """
schema = 1
name = "table"
scene = {{ frame_min = [-1, -1, -0.01], frame_max = [1, 1, 0.4] }}
platform = {{ mass = "5 kg", plane = {{ normal = [0, 0, 1]{sided} }} }}
cable = {{ axial_stiffness = "140 kN", linear_density = "30 g/m", breaking_load = "2 kN" }}
sheave = {{ kind = "eyelet" }}
line = {{ tension_limits = ["{least} N", "400 N"] }}
lines = [
    {{ name = "a", exit_point = [-1, -1, 0.4] }},
    {{ name = "b", exit_point = [1, -1, 0.4] }},
    {{ name = "c", exit_point = [1, 1, 0.4] }},
    {{ name = "d", exit_point = [-1, 1, 0.4] }},
]
"""
"""Belts that pull a sled off its board with more than its weight where their minimum tension is large."""

Asked = Callable[..., Check]


@pytest.fixture(scope="module")
def asked(tmp_path_factory: pytest.TempPathFactory) -> Asked:
    """The check of an angle of two strands at a height, m, on a robot; *job*: further keys of the job."""
    folder = tmp_path_factory.mktemp("angle")

    def of(robot: Robot, half: float, height: float, **job: object) -> Check:
        a, z = 1e3 * half, 1e3 * height
        moves = f"G0 X{-a} Y{-a} Z{z} F6000\nG1 X{a} Y{-a} E9 F3000\nG1 X{a} Y{a} E9\n"
        (folder / "angle.gcode").write_text(f"G21\nG90\nM83\n;LAYER:0\n{moves}")
        table = {"name": "angle", "gcode": str(folder / "angle.gcode")} | job
        return check(robot, Job.model_validate(table), skip=("interference",))

    return of


def broken(found: Check) -> set[str]:
    return {each.limit for each in found.findings if each.violations}


def branches(least: float) -> Robot:
    return loads(BRANCHES.format(least=least))


def sled(one_sided: str, least: float) -> Robot:
    sided = f", one_sided = {one_sided}" if one_sided else ""
    return loads(SLED.format(sided=sided, least=least))


@pytest.fixture(scope="module")
def taut(asked: Asked) -> Check:
    return asked(branches(0.0), 0.3, 0.4)


@pytest.fixture(scope="module")
def slack(asked: Asked) -> Check:
    """Of a minimum tension just large enough for the least tensions, in which lines hang slack."""
    robot = loads(BRANCHES.format(least=0.02).replace("0.9 g/m", "9 g/m"))
    return asked(robot, 0.3, 0.4, motion={"acceleration": 0.1})


class TestSlackLines:
    def test_no_minimum_tension_keeps_lengths_near_the_straight_ones(self, taut: Check) -> None:
        assert taut.feasible
        np.testing.assert_allclose(taut.lengths, straight_lengths(taut.robot, taut.poses), rtol=0.01)

    def test_winches_are_no_faster_than_the_nozzle_times_the_spans(self, taut: Check) -> None:
        spans = np.array([line.advantage for line in taut.robot.lines])
        assert (taut.statics.lines.winch_speed <= 1.02 * spans * taut.law.speed.max()).all()

    def test_the_preferred_tension_is_said(self, taut: Check) -> None:
        assert taut.to_dict()["line_preferred_tension"] == [17.5] * 4
        assert any("17.5 N, the preferred tension" in note for note in taut.notes)

    def test_lines_in_loops_and_changes_between_branches_are_a_no(self, slack: Check) -> None:
        assert broken(slack) == {
            "length against straight line",
            "winch speed against nozzle speed",
            "interpolation of lengths",
            "jump of a length",
            "jump of a tension",
        }
        assert "above it the line" in slack.verdict or "above it the solution changes" in slack.verdict

    def test_every_verb_has_the_same_default_tension(self) -> None:
        pose = [0.3, 0.2, 0.4]
        for robot in (branches(0.0), branches(2.0)):
            held = inverse(robot, pose)
            at_platform = tension_distribution(robot, pose).tensions
            np.testing.assert_allclose(held.tensions, at_platform, rtol=0.05, atol=0.01 * at_platform.max())
        assert any("preferred tension" in note for note in SolvedPose(inverse(branches(0.0), pose)).notes)


def test_a_long_sampling_step_is_in_the_expected_error(asked: Asked) -> None:
    coarse = asked(sled("false", 10), 0.6, 0.0, sampling={"step": 0.6}, max_error=0.015)
    middle = 0.5 * (coarse.poses[1:] + coarse.poses[:-1])
    between = 0.5 * (coarse.lengths[1:] + coarse.lengths[:-1])
    off = np.abs(straight_lengths(coarse.robot, middle) - between).max()
    assert coarse.interpolation_error == pytest.approx(off, rel=0.1)
    assert coarse.interpolation_error > 0.015
    assert coarse.to_dict()["expected_error"] > 0.015
    assert not coarse.feasible


def test_expected_error_and_displacement_together_are_judged(asked: Asked) -> None:
    def of(**job: object) -> Check:
        motion = {"print_speed": 2.0, "travel_speed": 2.0, "acceleration": 3.0}
        return asked(sled("false", 20), 0.2, 0.0, motion=motion, **job)

    figures = of().to_dict()
    expected, displacement = figures["expected_error"], figures["acceleration_displacement"]
    no = of(max_error=expected + 0.5 * displacement)
    assert broken(no) == {"expected error with acceleration"}
    assert "expected error and displacement by acceleration are" in no.verdict
    assert of(max_error=1.01 * (expected + displacement)).feasible


class TestPlane:
    def test_a_plane_that_only_pushes_does_not_hold_what_belts_lift(self, asked: Asked) -> None:
        found = asked(sled("true", 80), 0.2, 0.0)
        assert not found.feasible
        assert "plane force" in broken(found)
        lift = 80.0 * 0.4 * sum(1.0 / np.hypot(np.hypot(x, y), 0.4) for x in (0.8, 1.2) for y in (0.8, 1.2))
        assert found.to_dict()["max_plane_force"] > 0.95 * (lift - 5.0 * 9.81) > 0.0

    def test_it_holds_a_sled_that_is_heavy_enough(self, asked: Asked) -> None:
        found = asked(sled("true", 10), 0.2, 0.0)
        assert found.feasible
        assert found.to_dict()["max_plane_force"] < 0.0

    def test_an_unknown_plane_is_named(self, asked: Asked) -> None:
        found = asked(sled("", 80), 0.2, 0.0)
        assert "its plane has to pull at it, with up to" in found.verdict
        assert any("platform.plane.one_sided" in each for each in found.not_checked)
        alone = SolvedPose(inverse(found.robot, [0.0, 0.0, 0.0]))
        assert any("platform.plane.one_sided" in note for note in alone.notes)

    def test_guides_hold_both_ways_without_a_word(self, asked: Asked) -> None:
        found = asked(sled("false", 80), 0.2, 0.0)
        assert found.feasible
        assert "plane" not in found.verdict
        assert not any("plane" in each for each in found.not_checked)


def tallied(first: int, count: int, folder: Path) -> Tally:
    tally = Tally()
    for number in range(first, first + count):
        tally.run(1, number, folder)
    return tally


def test_a_yes_of_random_robots_holds(tmp_path: Path) -> None:
    assert tallied(0, 5, tmp_path).faults == []


@pytest.mark.slow
def test_a_yes_of_many_random_robots_holds(tmp_path: Path) -> None:
    tally = tallied(5, 75, tmp_path)
    assert tally.answers["yes"] > 10
    assert tally.faults == []
