from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from benchmarks.campaigns.camera_rooms import Room, Setup, exit_errors, later, room

import cablewright as cw
from cablewright.calibration.drift.drift import _of_record
from cablewright.calibration.drift.record import record_of
from cablewright.calibration.poses.problem import StraightProblem
from cablewright.calibration.sightings.placing import started

SMALL = Setup(poses=12, width=960, height=720, focal=800.0, floor=2, print_scale=0.98, moved=1)
PLAN = cw.CalibrationPlan(sigma={"encoder": 5e-4})


@pytest.fixture(scope="module")
def machine() -> cw.Robot:
    return cw.load("ipanema")


@pytest.fixture(scope="module")
def measured(machine: cw.Robot) -> Room:
    return room(machine, SMALL, 2)


@pytest.fixture(scope="module")
def found(machine: cw.Robot, measured: Room) -> cw.Calibration:
    return cw.calibrate(machine, measured.data, PLAN, rough=0.05)


def _value(found: cw.Calibration, label: str) -> tuple[float, float]:
    at = [each.label for each in found.unknowns].index(label)
    return float(found.values[at]), float(found.sigma[at])


def test_exit_points_are_within_their_joint_ellipsoid(found: cw.Calibration, measured: Room) -> None:
    assert found.status == "ok"
    assert found.gauge == ()  # the tags on the floor hold the world
    which = [at for at, each in enumerate(found.unknowns) if each.name == "exit_point"]
    off = exit_errors(measured.robot, found.robot, own_frame=False).ravel()
    spread = found.covariance[np.ix_(which, which)]
    assert off @ np.linalg.solve(spread, off) < 2.0 * len(which)
    assert np.abs(exit_errors(measured.robot, found.robot, own_frame=True)).max() < 0.01


def test_a_print_of_98_percent_is_found(found: cw.Calibration) -> None:
    value, sigma = _value(found, "print scale")
    assert sigma < 1e-3
    assert value == pytest.approx(0.98, abs=3.5 * sigma)


def test_a_tag_that_moved_is_named(found: cw.Calibration, measured: Room) -> None:
    sentences = found.to_dict()["pictures"]
    assert [each for each in sentences if "is not where" in each] == [
        "tag 1 is not where the layout has it: its place is taken from the pictures"
    ]
    shift = [_value(found, f"tag place {axis} of tag 1")[0] for axis in "xyz"]
    assert np.linalg.norm(shift - measured.tags[1][0]) < 4e-3


def test_the_place_of_the_camera_is_found(found: cw.Calibration, measured: Room) -> None:
    for at, axis in enumerate("xyz"):
        value, sigma = _value(found, f"camera place {axis}")
        assert value == pytest.approx(measured.camera[0][at], abs=4.0 * sigma)


def test_a_bump_of_an_exit_point_is_found_by_three_pictures(
    machine: cw.Robot, found: cw.Calibration, measured: Room, tmp_path: Path
) -> None:
    (tmp_path / "data.csv").write_text("dl_1\n")
    record = record_of(found, tmp_path / "data.csv", datetime.now(UTC))
    same, _ = later(measured, SMALL, 7)
    assert cw.check_drift(found.robot, same.data, record).verdict == "unchanged"
    bumped, line = later(measured, SMALL, 7, bump=0.03)
    drift = cw.check_drift(found.robot, bumped.data, record)
    assert drift.verdict == "moved"
    assert drift.changes[0].line == line


def test_a_tag_that_the_record_lacks_is_known_as_its_layout_says(
    found: cw.Calibration, measured: Room, tmp_path: Path
) -> None:
    (tmp_path / "data.csv").write_text("dl_1\n")
    record = record_of(found, tmp_path / "data.csv", datetime.now(UTC))
    kept = [at for at, each in enumerate((*record.values, *record.considered)) if each.line != "tag 0"]
    rows = record.spread[np.ix_(kept, kept)].tolist()
    without = record.model_copy(
        update={
            "values": tuple(each for each in record.values if each.line != "tag 0"),
            "covariance": tuple(tuple(row[: at + 1]) for at, row in enumerate(rows)),
        }
    )
    same, _ = later(measured, SMALL, 7)
    seen = same.data.sightings
    assert seen is not None
    tag = next(tag for tag in seen.layout.tags if tag.number == 0)
    problem = StraightProblem.of(found.robot, replace(same.data, guess=same.poses), without.plan, hold=False)
    _, spread = _of_record(problem, without)
    own = [at for at, each in enumerate(problem.unknowns) if each.line == "tag 0"]
    assert np.sqrt(np.diag(spread)[own]) == pytest.approx([tag.sigma] * 3 + [tag.turn_sigma] * 3)
    assert cw.check_drift(found.robot, same.data, without).verdict == "unchanged"
    values = tuple(each for each in record.values if each.line != "camera")
    with pytest.raises(cw.InputError, match="the record is of a calibration without pictures"):
        _of_record(problem, record.model_copy(update={"values": values}))


def test_a_point_platform_is_calibrated_as_the_body_that_pictures_show() -> None:
    machine = cw.load("wang2021")
    made = room(machine, replace(SMALL, poses=10, floor=0, moved=-1, print_scale=1.0), 4)
    found = cw.calibrate(machine, made.data, PLAN.model_copy(update={"level": 1e-3}), rough=0.05)
    assert found.status == "ok"
    assert found.robot.platform == machine.platform
    assert found.poses.shape == (10, 6)
    assert np.abs(exit_errors(made.robot, found.robot, own_frame=True)).max() < 0.05


def test_a_file_of_another_camera_is_an_error(machine: cw.Robot, measured: Room) -> None:
    seen = measured.data.sightings
    assert seen is not None
    focal = (1.15 * seen.camera.focal[0], 1.15 * seen.camera.focal[1])
    other = replace(seen, camera=seen.camera.model_copy(update={"focal": focal}))
    with pytest.raises(cw.InputError, match="the lens or the size of the print that fits them is far") as error:
        started(other, machine, measured.data.counted, None, "data.csv")
    assert "\n" not in str(error.value)


def test_a_layout_that_is_not_of_the_pictures_is_an_error(machine: cw.Robot, measured: Room) -> None:
    seen = measured.data.sightings
    assert seen is not None
    off = np.random.default_rng(0).normal(0.0, 0.1, (len(seen.layout.tags), 3))
    tags = tuple(
        tag.model_copy(update={"at": tuple(at)}) for tag, at in zip(seen.layout.tags, off.tolist(), strict=True)
    )
    other = replace(seen, layout=seen.layout.model_copy(update={"tags": tags}))
    with pytest.raises(cw.InputError, match=r"of 5 tags do not fit the others") as error:
        started(other, machine, measured.data.counted, None, "data.csv")
    assert "\n" not in str(error.value)


def test_a_pose_without_a_picture_of_few_lines_is_an_error() -> None:
    machine = cw.load("wang2021")
    made = room(machine, replace(SMALL, poses=8, floor=0, moved=-1), 4)
    seen = made.data.sightings
    assert seen is not None
    without = replace(made.data, sightings=replace(seen, pictures=(*seen.pictures[:7], None)))
    with pytest.raises(cw.InputError, match=r"pose 8: no picture shows a tag at this pose"):
        cw.calibrate(machine, without, PLAN)


def test_pictures_without_a_tag_of_the_layout_are_an_error(machine: cw.Robot, measured: Room) -> None:
    seen = measured.data.sightings
    assert seen is not None
    nothing = replace(measured.data, sightings=replace(seen, pictures=(None,) * len(seen.pictures)))
    with pytest.raises(cw.InputError, match="no picture shows a tag of the layout that can be used"):
        cw.calibrate(machine, nothing)
