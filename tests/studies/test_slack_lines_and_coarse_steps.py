"""A yes of `check` with minimum tensions just above 0, long sampling steps and guides, and of many random robots."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tools.random_checks import Tally, straight_lengths

from cablewright.printing.job import Job
from cablewright.robot import Robot, loads
from cablewright.studies.checks.check import check
from cablewright.studies.checks.result import Check

HEAVY_LINES = """
schema = 1
name = "heavy lines"
scene = { frame_min = [-2, -2, 0], frame_max = [2, 2, 2.5] }
platform = { mass = "0.5 kg" }
cable = { axial_stiffness = "20 kN", linear_density = "9 g/m", breaking_load = "1 kN" }
sheave = { kind = "eyelet" }
line = { tension_limits = [0.02, 35] }
lines = [
    { name = "a", advantage = 2, exit_point = [0, -2, 0] },
    { name = "b", advantage = 2, exit_point = [2, 1.5, 0] },
    { name = "c", advantage = 2, exit_point = [-2, 1.5, 0] },
    { name = "d", advantage = 4, exit_point = [0, 0, 2.5] },
]
"""
"""A minimum tension just large enough for least tensions, in which lines hang in loops."""

GUIDES = """
schema = 1
name = "guides"
scene = { frame_min = [-1, -1, -0.01], frame_max = [1, 1, 0.4] }
platform = { mass = "5 kg", plane = { normal = [0, 0, 1], one_sided = false } }
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


def checked(folder: Path, robot: Robot, half: float, height: float, **job: object) -> Check:
    """The check of two sides of a square, of this *half* side and *height*, m; *job*: further keys."""
    a, z = 1e3 * half, 1e3 * height
    moves = f"G0 X{-a} Y{-a} Z{z} F6000\nG1 X{a} Y{-a} E9 F3000\nG1 X{a} Y{a} E9\n"
    (folder / "sides.gcode").write_text(f"G21\nG90\nM83\n;LAYER:0\n{moves}")
    table = {"name": "sides", "gcode": str(folder / "sides.gcode")} | job
    return check(robot, Job.model_validate(table), skip=("interference",))


def broken(found: Check) -> set[str]:
    return {each.limit for each in found.findings if each.violations}


def test_lines_in_loops_and_changes_between_branches_are_a_no(tmp_path: Path) -> None:
    found = checked(tmp_path, loads(HEAVY_LINES), 0.3, 0.4, motion={"acceleration": 0.1})
    assert (found.lengths / straight_lengths(found.robot, found.poses)).max() > 1.3
    assert broken(found) == {
        "length against straight line",
        "winch speed against nozzle speed",
        "interpolation of lengths",
        "jump of a length",
        "jump of a tension",
    }
    assert "above it the line" in found.verdict or "above it the solution changes" in found.verdict


def test_a_long_sampling_step_is_in_the_expected_error(tmp_path: Path) -> None:
    unshaped = {"shaping": "none"}  # shaped motion is sampled by the modes
    found = checked(tmp_path, loads(GUIDES), 0.6, 0.0, sampling={"step": 0.6}, motion=unshaped, max_error=0.015)
    middle = 0.5 * (found.poses[1:] + found.poses[:-1])
    between = 0.5 * (found.lengths[1:] + found.lengths[:-1])
    off = np.abs(straight_lengths(found.robot, middle) - between).max()
    assert found.interpolation_error == pytest.approx(off, rel=0.1)
    assert found.interpolation_error > 0.015
    assert found.to_dict()["expected_error"] > 0.015
    assert not found.feasible


def test_guides_hold_both_ways_without_a_word(tmp_path: Path) -> None:
    found = checked(tmp_path, loads(GUIDES), 0.2, 0.0)
    assert found.feasible
    assert found.to_dict()["max_plane_force"] > 0.0
    assert "plane" not in found.verdict


@pytest.mark.slow
def test_a_yes_of_many_random_robots_holds(tmp_path: Path) -> None:
    tally = Tally()
    for number in range(80):
        tally.run(1, number, tmp_path)
    assert tally.answers["yes"] > 10
    assert tally.faults == []
