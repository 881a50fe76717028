"""A job on a robot: errors in their order, limits with their places, one verdict, whatever the blocks and threads."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest

from cablewright.foundation import memory_mapped
from cablewright.foundation.errors import InputError, Status
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Model
from cablewright.printing.job import load_job
from cablewright.robot import Robot, library_text, load, loads
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.checks.check import check
from cablewright.studies.checks.path_statics import PathStatics
from cablewright.studies.checks.result import Check

ROUNDING = 1e-9  # N
POSES = ("uncompensated", "compensated", "elastic_only")
LENGTHS = ("rigid_lengths", "lengths", "cable_length")


def arrays(found: Check) -> dict[str, np.ndarray]:
    """All that the statics say, by name."""
    statics = {field.name: getattr(found.statics, field.name) for field in dataclasses.fields(PathStatics)}
    return statics | vars(statics.pop("lines"))


def limit(found: Check, name: str):
    return next(finding for finding in found.findings if finding.limit == name)


def wide(name: str = "merlet2023") -> Robot:
    """The robot of that name in a frame far wider than its exit points."""
    text = library_text(name).replace("frame_min = [-2.5, -5.0, 0.0]", "frame_min = [-9, -9, 0]")
    return loads(text.replace("frame_max = [2.5, 5.0, 4.03]", "frame_max = [9, 9, 4.03]"))


def test_compensation_meets_the_path_and_half_of_it_comes_between(found: Check) -> None:
    assert found.error_compensated.max() < 1e-6
    assert found.error_uncompensated.min() > 1e-3
    assert (found.error_compensated < found.error_elastic_only).all()
    assert (found.error_elastic_only < found.error_uncompensated).all()
    assert found.error_elastic_only.max() > 1e-5


def test_uncompensated_is_the_full_model_with_the_lengths_of_rigid_cables(found: Check) -> None:
    robot, positions = found.robot, found.samples.positions[::40]
    rigid = solve_inverse(Model(robot, Fidelity(CableLaw.RIGID)), positions)
    np.testing.assert_allclose(found.statics.rigid_lengths[::40], rigid.lengths, atol=1e-9)
    hung = solve_forward(Model(robot), rigid.lengths)
    np.testing.assert_allclose(found.statics.uncompensated[::40], hung.pose, atol=1e-9)
    lower = found.statics.uncompensated[:, 2] < found.samples.positions[:, 2]
    assert lower.all()  # heavy and elastic


def test_lengths_and_tensions_are_those_of_the_inverse_problem(found: Check) -> None:
    solved = solve_inverse(Model(found.robot), found.samples.positions)
    np.testing.assert_allclose(found.lengths, solved.lengths, atol=1e-9)
    np.testing.assert_allclose(found.statics.tensions, solved.tensions, atol=1e-6)
    assert (found.statics.lines.lowest_tension <= found.statics.tensions + ROUNDING).all()
    assert (found.statics.lines.highest_tension >= found.statics.tensions - ROUNDING).all()


def test_what_lies_in_files_is_the_same(found: Check, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(memory_mapped, "SMALL", 1)
    again = check(found.robot, found.job, room=tmp_path)
    for name, values in arrays(found).items():
        assert np.array_equal(values, arrays(again)[name], equal_nan=True), name
    for ours, theirs in ((found.samples, again.samples), (found.law, again.law), (found.errors, again.errors)):
        for name, values in vars(ours).items():
            assert values is None or np.array_equal(values, getattr(theirs, name), equal_nan=True), name
    assert np.array_equal(found.poses, again.poses)
    assert again.findings == found.findings
    assert again.to_dict() == found.to_dict()
    assert not list(tmp_path.iterdir())


def test_shapes_and_summary(found: Check) -> None:
    k = len(found.samples)
    shapes = {name: values.shape for name, values in arrays(found).items()}
    assert {shapes.pop(name) for name in POSES} == {(k, 3)}
    assert {shapes.pop(name) for name in ("codes", "violations", "displacement", "frequency", "plane_force")} == {(k,)}
    assert set(shapes.values()) == {(k, 4)}
    assert len(shapes) == 12
    summary = found.to_dict()
    assert (summary["layers"], summary["samples"]) == (3, k)
    assert summary["extruded_length"] == pytest.approx(12.0)
    assert summary["travel_length"] == pytest.approx(0.04)
    assert summary["duration"] == found.law.time[-1]
    assert summary["min_tension"] == found.statics.lines.lowest_tension.min()
    assert summary["max_tension"] == found.statics.lines.highest_tension.max()
    assert summary["max_error_uncompensated"] == found.error_uncompensated.max()


def test_cable_speed_is_at_least_the_mean_over_each_step(found: Check) -> None:
    mean = np.abs(np.diff(found.lengths, axis=0)) / np.diff(found.law.time)[:, None]
    assert (found.statics.lines.winch_speed[1:] >= mean - 1e-12).all()
    assert found.statics.lines.winch_speed.max() <= found.samples.speed_limit.max()


def test_a_yes_has_findings_without_violations(found: Check) -> None:
    assert found.feasible
    assert found.verdict.startswith("house-printer can print square. All samples are within the limits")
    assert {finding.limit for finding in found.findings} == {
        "frame, z",
        "lowest tension",
        "highest tension",
        "cable length",
        "swing",
        "lever",
        "winch speed",
        "winch torque",
        "sheave clearance",
        "clearance of lines",
        "length against straight line",
        "winch speed against nozzle speed",
        "interpolation of lengths",
        "jump of a length",
        "jump of a tension",
        "expected error with acceleration",
        "expected error",
    }
    for finding in found.findings:
        assert finding.violations == 0
        low, high = finding.allowed
        assert finding.margin == pytest.approx(min(finding.value - low, high - finding.value))
        assert finding.margin >= 0.0
        assert 0 <= finding.sample < len(found.samples)


def test_a_finding_points_to_the_worst_sample_and_line(found: Check) -> None:
    lowest = limit(found, "lowest tension")
    column = [line.name for line in found.robot.lines].index(lowest.line or "")
    tensions = found.statics.lines.lowest_tension
    assert lowest.value == tensions[lowest.sample, column]
    assert lowest.value == pytest.approx(tensions.min(), rel=1e-12)  # equal corners tie to rounding


def test_tension_limits_that_no_tensions_meet(job_file) -> None:
    no = check(load("house-printer"), load_job(job_file), tension_limits=(20.0, 500.0))
    assert not no.feasible
    worst = no.findings[0]
    assert worst.limit == "highest tension"
    assert worst.allowed[1] == 500.0
    assert worst.violations == len(no.samples)
    assert worst.margin == pytest.approx(500.0 - no.statics.lines.highest_tension.max())
    assert "house-printer cannot print square: highest tension of line" in no.verdict
    assert f"at {worst.violations} of {len(no.samples)} samples" in no.verdict
    assert f"G-code line {no.samples.line[worst.sample]} (allowed:" in no.verdict


def test_tension_limits_that_do_not_rise_are_rejected(job_file) -> None:
    with pytest.raises(InputError, match="0 <= lowest < highest"):
        check(load("house-printer"), load_job(job_file), tension_limits=(500.0, 20.0))


def test_a_job_outside_the_frame(write_job) -> None:
    no = check(load("house-printer"), load_job(write_job(origin=(-0.5, -0.5, -0.01))))
    assert not no.feasible
    frame = limit(no, "frame, z")
    assert frame.margin == pytest.approx(-0.01)
    assert frame.violations == (no.samples.positions[:, 2] < 0).sum()
    assert "frame, z is out of bounds" in no.verdict


def test_a_winch_too_slow(job_file) -> None:
    robot = load("house-printer")
    slow = tuple(
        line.model_copy(update={"winch": line.winch.model_copy(update={"max_speed": 0.05})}) for line in robot.lines
    )
    no = check(robot.model_copy(update={"lines": slow}), load_job(job_file))
    assert not no.feasible
    assert no.findings[0].limit == "winch speed"
    assert no.findings[0].margin == pytest.approx(0.05 - no.statics.lines.winch_speed.max())


@pytest.mark.parametrize("origin", [(0.0, 5.5, 1.0), (3.2, 0.0, 1.0)])
def test_a_job_that_no_tensions_hold_is_never_a_yes(write_job, origin: tuple[float, float, float]) -> None:
    """Beyond the outermost exit points a suspended robot cannot reach, whatever its frame says."""
    no = check(wide(), load_job(write_job(origin=origin, scale=0.1)))
    assert (no.codes != 0).all()
    assert not no.feasible
    assert "cannot" in no.verdict


@pytest.fixture(scope="module")
def inside_sheave(write_job) -> Check:
    """A path that passes through a sheave of the house-printer, and is held before and after it."""
    gcode = "G21\nG90\nM83\nG1 X500 Y500 Z400 E1 F6000\nG1 X0 Y0 Z0 E1\n"
    return check(load("house-printer"), load_job(write_job(origin=(6.99, 6.99, 14.55), gcode=gcode)))


def test_a_sample_inside_a_sheave_is_an_answer(inside_sheave: Check) -> None:
    codes = {Status.of(code) for code in np.unique(inside_sheave.codes)}
    assert Status.INSIDE_SHEAVE in codes
    assert Status.OK in codes
    assert not inside_sheave.feasible
    assert any(finding.limit == "the platform point is inside a sheave" for finding in inside_sheave.findings)


def test_a_sample_without_a_solution_has_no_numbers(inside_sheave: Check) -> None:
    bad = inside_sheave.codes == list(Status).index(Status.INSIDE_SHEAVE)
    assert np.isnan(inside_sheave.statics.compensated[bad]).all()
    for name in ("lengths", "tensions", "lowest_tension", "highest_tension", "winch_torque"):
        assert np.isnan(arrays(inside_sheave)[name][bad]).all(), name
    assert np.isfinite(inside_sheave.lengths[inside_sheave.codes == 0]).all()


def test_made_up_numbers_are_in_no_summary(inside_sheave: Check) -> None:
    good = inside_sheave.codes == 0
    summary = inside_sheave.to_dict()
    assert summary["max_winch_speed"] < 5.0
    assert summary["min_tension"] == pytest.approx(inside_sheave.statics.lines.lowest_tension[good].min(), rel=0.5)


@pytest.mark.parametrize("block", [64, 100, 40])
def test_blocks_do_not_matter(found: Check, job_file, monkeypatch, block: int) -> None:
    monkeypatch.setattr("cablewright.studies.checks.job_samples.BLOCK", block)
    assert_same(check(found.robot, found.job), found, 1e-9)


@pytest.mark.parametrize("threads", [1, 3])
def test_threads_do_not_matter(found: Check, monkeypatch, threads: int) -> None:
    monkeypatch.setattr("cablewright.solvers.row_threads.thread_count", lambda: threads)
    assert_same(check(found.robot, found.job), found, 0.0)


def assert_same(one: Check, other: Check, tolerance: float) -> None:
    """Lengths and places to *tolerance* (m), all else to a relative one."""
    theirs = arrays(other)
    for name, ours in arrays(one).items():
        absolute = tolerance if name in (*POSES, *LENGTHS) else tolerance * 1e3
        np.testing.assert_allclose(ours, theirs[name], rtol=tolerance, atol=absolute, err_msg=name)
    assert one.verdict == other.verdict


def test_progress_ends_where_all_is_done(job_file) -> None:
    told: dict[str, tuple[int, int]] = {}
    done = check(load("merlet2023"), load_job(job_file), progress=lambda stage, at, of: told.update({stage: (at, of)}))
    assert told["solving"] == (len(done.samples), len(done.samples))
    assert told["reading G-code"][0] == told["reading G-code"][1] > 0


def test_the_robot_keeps_its_own_limits(job_file) -> None:
    robot = load("house-printer")
    check(robot, load_job(job_file), tension_limits=(30.0, 4000.0))
    assert robot == load("house-printer")


def test_a_model_and_a_file_are_the_robot_and_the_job(found: Check, job_file) -> None:
    again = check(Model(found.robot), job_file)
    assert again.to_dict() == found.to_dict() == json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert len(repr(again)) < 160
    with pytest.raises(InputError, match="the model is elastic, the machine itself is catenary"):
        check(Model(found.robot, Fidelity(CableLaw.ELASTIC)), job_file)
