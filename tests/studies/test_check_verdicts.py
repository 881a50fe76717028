"""Verdicts of a check: each no is named, each yes was shown, and open questions are listed."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest

from cablewright.apps.figures import sheets
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.models.statics import Model
from cablewright.printing.job import Job, load_job
from cablewright.robot import Robot, Uncertainty, library_text, load, loads
from cablewright.solvers.forward import solve_forward
from cablewright.studies.checks.check import check
from cablewright.studies.checks.result import Check
from cablewright.studies.checks.verdict import verdict
from cablewright.studies.interference import interference
from cases import some

TOWER = """
schema = 1
name = "three lines"
scene = { frame_min = [-3, -3, 0], frame_max = [3, 3, 3] }
platform = { mass = "10 kg" }
cable = { axial_stiffness = "1000 kN", linear_density = 0, breaking_load = "9 kN" }
sheave = { kind = "eyelet" }
line = { tension_limits = [1, "2 kN"] }
lines = [
    { name = "west", exit_point = [-2, 0, 2] },
    { name = "north", exit_point = [2, 2, 2] },
    { name = "south", exit_point = [2, -2, 2] },
]
"""


def finding(found: Check, name: str):
    return next(each for each in found.findings if each.limit == name)


def house(**changes: object) -> Robot:
    """The house-printer with other numbers of its winches."""
    robot = load("house-printer")
    lines = tuple(line.model_copy(update={"winch": line.winch.model_copy(update=changes)}) for line in robot.lines)
    return robot.model_copy(update={"lines": lines})


def job_with(job_file: Path, **changes: object) -> Job:
    job = load_job(job_file)
    motion = job.motion.model_copy(update=changes.pop("motion", {}))
    return job.model_copy(update={"motion": motion, **changes})


class TestNo:
    def test_lines_that_collide(self, tmp_path: Path) -> None:
        rows = ["G21 G90 M83", "G0 X0 Y-100 Z20 F200"]
        for layer in range(20):
            z = 40 * (layer + 1)
            rows += [f";LAYER:{layer}", f"G0 X0 Y-100 Z{z}", "G1 Y100 E5", f"G0 X1000 Y-50 Z{z + 60}", "G0 Z20"]
            rows += ["G1 Y0 E5", f"G0 Z{z + 60}"]
        (tmp_path / "tower.gcode").write_text("\n".join(rows) + "\n")
        job = job_with(tmp_path / "tower.gcode", motion={"shaping": "none"})
        found, alone = check(loads(TOWER), job), interference(loads(TOWER), job)
        assert not found.feasible
        assert alone.worst is not None
        assert finding(found, "clearance of lines").value == pytest.approx(alone.worst.margin)
        assert finding(found, "clearance of lines").violations == (alone.margins.min(axis=1) <= 0.0).sum()
        touching = f"line {alone.worst.line} touches {alone.worst.other}"
        assert "three lines cannot print tower: " in found.verdict
        assert touching in found.verdict
        assert found.nearest_place is not None
        assert f"in layer {found.nearest_place.layer}, G-code line" in found.verdict
        assert check(loads(TOWER), job, skip=("interference",)).feasible

    def test_lines_nearer_than_is_requested(self, found: Check, job_file: Path) -> None:
        assert found.nearest is not None
        no = check(found.robot, job_file, clearance=found.nearest.margin + 0.01)
        assert "comes too near to bead" in no.verdict
        assert "(required: at least" in no.verdict

    def test_a_nozzle_error_above_the_tolerance(self, found: Check, job_file: Path) -> None:
        assert found.expected is not None
        allowed = 0.9 * found.expected.value
        no = check(found.robot, job_with(job_file, max_error=allowed))
        assert not no.feasible
        assert no.findings[0].limit == "expected error"
        assert "the expected position error is" in no.verdict
        assert f"(allowed: at most {allowed * 1e3:.3g} mm)" in no.verdict

    def test_a_nozzle_error_of_ten_millimetres_by_its_own_file(self, job_file: Path) -> None:
        table = '\n[[uncertainty.parameters]]\nname = "exit_point"\nplus_minus = "6 mm"\n'
        robot = loads(library_text("house-printer") + table)
        no = check(robot, job_with(job_file, max_error=0.01))
        assert no.uncertainty == "robot file"
        assert "(95th percentile, given tolerances)" in no.verdict
        assert finding(no, "expected error").value > 0.01

    def test_a_swing_that_a_winch_cannot_hold(self, job_file: Path) -> None:
        slow = {"print_speed": 0.01, "travel_speed": 0.01}
        calm = check(house(), job_with(job_file, motion=slow))
        rest = 0.1 * float(np.nanmax(calm.statics.tensions))  # the drum's radius times the tension at the sheave
        limit = rest + 0.5 * (finding(check(house(), job_with(job_file)), "winch torque").value - rest)
        assert check(house(max_torque=limit), job_with(job_file, motion=slow)).feasible
        no = check(house(max_torque=limit), job_with(job_file))
        assert not no.codes.any()
        assert no.findings[0].limit == "winch torque"
        assert "winch torque of line" in no.verdict

    def test_every_other_limit_is_named_too(self, job_file: Path) -> None:
        no = check(house(max_torque=10.0, max_speed=0.05, capacity=20.0), job_with(job_file))
        assert "Also out of bounds: " in no.verdict
        for name in ("winch torque", "winch speed", "cable length"):
            assert name in no.verdict

    def test_a_path_that_the_model_does_not_meet_is_no_yes(self, found: Check) -> None:
        no = dataclasses.replace(
            found, errors=dataclasses.replace(found.errors, compensated=found.errors.compensated + 1e-3)
        )
        assert not no.feasible
        says = "house-printer cannot be shown to print square: the compensated path is not met at"
        assert verdict(no, 0).startswith(f"{says} {len(found.samples)} samples, first in layer 1, G-code line ")

    def test_a_robot_that_holds_nothing_anywhere(self, job_file: Path) -> None:
        no = check(load("house-printer"), job_file, tension_limits=(3000.0, 3001.0))
        assert (no.codes != 0).all()
        assert "The lines cannot hold the platform at any of 343 positions tried in the frame" in no.verdict

    def test_a_place_out_of_reach_is_not_a_robot_that_holds_nothing(self, write_job) -> None:
        no = check(load("house-printer"), write_job(origin=(0.0, 0.0, 14.99)))
        assert no.codes.any()
        assert "at any of" not in no.verdict


class TestSizes:
    def test_a_job_ten_times_the_frame_asks_for_its_scale(self, write_job) -> None:
        with pytest.raises(InputError, match=r"the path is 10 times as large as the frame of house-printer: is scale"):
            check(load("house-printer"), write_job(scale=150.0))

    def test_a_job_a_thousand_times_the_frame_asks_for_units(self, write_job) -> None:
        with pytest.raises(InputError, match="or is a unit wrong, mm taken for m"):
            check(loads(library_text("house-printer")), write_job(scale=9999.0))

    def test_a_part_that_is_lost_in_the_frame_is_noted(self, write_job) -> None:
        found = check(load("house-printer"), write_job(scale=0.015))
        assert any("the path is 15 mm large, the frame 15 m" in note for note in found.notes)

    def test_parts_of_a_usual_size_are_not(self, found: Check) -> None:
        assert not any("the frame" in note for note in found.notes)


class TestYes:
    def test_it_says_what_was_shown(self, found: Check) -> None:
        assert found.feasible
        assert "All samples are within the limits. Smallest distance between a line and an obstacle" in found.verdict
        assert "mm (95th percentile, assumed tolerances)." in found.verdict
        assert " Motion of the platform adds at most " in found.verdict
        assert "um" not in found.verdict.split()

    def test_what_was_switched_off_is_in_no_verdict_and_in_the_list(self, found: Check, job_file: Path) -> None:
        part = check(found.robot, job_file, skip=("interference", "expected-error"))
        assert part.feasible
        motion = r" Motion of the platform adds at most 12\.\d mm at 1\.\d+ Hz with a damping ratio of 1 % .assumed.\."
        start = r"house-printer can print square\. All samples are within the limits\."
        assert re.fullmatch(start + motion, part.verdict)
        assert part.not_checked[:2] == ("interference of lines: switched off", "expected error: switched off")
        assert (part.to_dict()["expected_error"], part.to_dict()["clearance"]) == (None, None)
        np.testing.assert_array_equal(part.lengths, found.lengths)

    def test_data_missing_in_the_files_are_in_the_list(self, job_file: Path) -> None:
        bare = check(house(max_torque=None, max_speed=None, capacity=None), job_file)
        for key in ("max_torque", "max_speed", "capacity"):
            assert any(f"gives no winch.{key}" in item for item in bare.not_checked), key
        assert any("gives no scene.beams" in item for item in bare.not_checked)
        assert "wind" in bare.not_checked
        whole = check(load("house-printer"), job_file)
        assert not any("winch" in item for item in whole.not_checked)

    def test_a_line_without_a_limit_is_named(self, job_file: Path) -> None:
        robot = load("house-printer")
        first, *rest = robot.lines
        bare = first.model_copy(update={"winch": first.winch.model_copy(update={"max_speed": None})})
        found = check(robot.model_copy(update={"lines": (bare, *rest)}), job_file)
        assert "winch speed of line south-west: the robot file gives no winch.max_speed" in found.not_checked

    def test_an_unknown_part_of_the_check_is_rejected(self, job_file: Path) -> None:
        with pytest.raises(UnknownName, match="interference"):
            check(load("house-printer"), job_file, skip=("interferense",))

    @pytest.mark.parametrize("clearance", [-1.0, float("nan"), float("inf")])
    def test_a_clearance_that_is_none(self, job_file: Path, clearance: float) -> None:
        with pytest.raises(InputError, match="clearance"):
            check(load("house-printer"), job_file, clearance=clearance)


class TestUncertainty:
    def test_a_given_one_counts_before_the_robot_files(self, job_file: Path) -> None:
        table = '\n[[uncertainty.parameters]]\nname = "exit_point"\nplus_minus = "6 mm"\n'
        robot = loads(library_text("house-printer") + table)
        entry = {"name": "mass", "factor": (0.9, 1.1)}
        given = Uncertainty.model_validate({"name": "weighed", "parameters": [entry]})
        own, other = check(robot, job_file), check(robot, job_file, uncertainty=given)
        assert (own.uncertainty, other.uncertainty) == ("robot file", "weighed")
        assert [cause.name for cause in other.expected.causes] == ["mass", "interpolation"]
        assert {cause.name for cause in own.expected.causes} == {"exit_point", "interpolation"}

    def test_what_would_reduce_it_is_a_note(self, found: Check) -> None:
        assert any("of the expected error is by exit point: survey or calibrate" in note for note in found.notes)


class TestAcceleration:
    def test_a_redundant_robot_keeps_a_reserve_at_rest(self) -> None:
        """Least tensions touch the limit at rest; acceleration would take them below it."""
        robot = load("wang2021")
        limits = robot.lines[0].tension_limits
        helix = {"radius": 0.3, "layers": 1, "layer_height": 0.02, "first_height": 1.0}
        job = Job.model_validate({"name": "ring", "helix": helix, "motion": {"acceleration": 1.0}})
        found = check(robot, job)
        assert found.reserved
        assert any("tensions at rest keep" in note for note in found.notes)
        assert np.nanmin(found.statics.lines.lowest_tension) >= limits[0] * (1 - 1e-9)
        assert found.statics.tensions.min() > limits[0]

    def test_without_haste_the_margin_of_a_print_is_kept(self) -> None:
        robot = load("wang2021")
        helix = {"radius": 0.3, "layers": 1, "layer_height": 0.02, "first_height": 1.0}
        motion = {"acceleration": 1e-6, "print_speed": 1e-5, "travel_speed": 1e-5}
        motion |= {"shaping": "none"}  # which would sample a day's motion at the period of a swing
        found = check(robot, Job.model_validate({"name": "ring", "helix": helix, "motion": motion}))
        least = robot.lines[0].tension_limits[0]
        assert found.chosen.robot.lines[0].tension_limits[0] == 2.0 * least  # the widest of those that are tried
        assert found.statics.tensions.min() == pytest.approx(2.0 * least, rel=1e-4)

    def test_figures_with_acceleration_contain_those_at_rest(self, found: Check) -> None:
        statics = found.statics
        assert (statics.lines.highest_tension >= statics.tensions - 1e-9).all()
        assert (statics.displacement >= 0.0).all()
        assert found.to_dict()["acceleration_displacement"] == found.to_dict()["motion_error"]
        laid = found.samples.extruding
        assert found.to_dict()["motion_error"] == statics.displacement[laid].max()


def test_the_step_follows_the_robot() -> None:
    """Lengths midway between samples have no larger errors than the step is chosen for."""
    small = loads(TOWER.replace("[-2, 0, 2]", "[-0.4, 0, 0.5]").replace("[2, 2, 2]", "[0.3, 0.3, 0.5]")
                  .replace("[2, -2, 2]", "[0.3, -0.3, 0.5]"))  # fmt: skip
    helix = {"radius": 0.05, "layers": 1, "layer_height": 0.002, "first_height": 0.05}
    job = Job.model_validate({"name": "ring", "helix": helix, "bead": {"width": 0.002, "height": 0.001}})
    coarse, fine = check(load("house-printer"), job), check(small, job)
    assert fine.step < 0.01 < coarse.step <= 0.05
    mean = 0.5 * (fine.lengths[1:] + fine.lengths[:-1])
    middle = 0.5 * (fine.samples.positions[1:] + fine.samples.positions[:-1])
    reached = solve_forward(Model.full(small), mean, guess=middle)
    assert np.linalg.norm(reached.pose - middle, axis=1).max() < 1e-4


class TestUnits:
    def test_a_job_in_inches_or_feet_asks_for_its_unit(self, write_job) -> None:
        with pytest.raises(InputError, match="or is a unit wrong, cm or inch taken for m"):
            check(load("house-printer"), write_job(scale=300.0))

    @pytest.mark.parametrize(
        ("origin", "unit"),
        some([((190.0, -80.0, 0.0), "inch"), ((1500.0, -800.0, 0.0), "mm"), ((20.0, 13.0, 2.0), "ft")]),
    )
    def test_an_origin_outside_of_the_robot_is_noted(self, origin: tuple[float, ...], unit: str, write_job) -> None:
        found = check(load("house-printer"), write_job(origin=origin), skip=("interference", "expected-error"))
        (note,) = (each for each in found.notes if "is not in the robot" in each)
        assert unit in note

    def test_a_path_within_the_robot_is_not(self, found: Check) -> None:
        assert not any("is not in the robot" in note for note in found.notes)


def test_a_job_that_no_sample_holds_is_shown() -> None:
    """Without an expected error there are no expected tensions, of any line."""
    helix = {"radius": 0.5, "layers": 1, "layer_height": 0.02}
    found = check(load("house-printer"), Job.model_validate({"name": "far", "helix": helix, "origin": [0, 0, 14.6]}))
    assert not found.feasible
    assert found.to_dict()["expected_error"] is None
    assert found.to_dict()["line_expected_tensions"] == [[None, None]] * 4
    assert "expected by lengths alone" in "".join(str(head) for sheet in sheets(found) for head in sheet.head)
