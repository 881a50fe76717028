"""Tags on exit points: a measurement of these, from pixels to the calibrated robot; and they move with them."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from benchmarks.campaigns.camera_rooms import Room, Setup, exit_errors, later, room

import cablewright as cw
from cablewright.calibration.drift.record import record_of
from cablewright.calibration.sightings.layout import load_layout

SETUP = Setup(poses=10, width=1000, height=750, focal=562.0, size=0.35, at=(3.6, -2.9, 1.2), exits=8, encoder=1e-4)
PLAN = cw.CalibrationPlan(sigma={"encoder": 1e-4})


@pytest.fixture(scope="module")
def machine() -> cw.Robot:
    return cw.load("ipanema")


@pytest.fixture(scope="module")
def measured(machine: cw.Robot) -> Room:
    return room(machine, SETUP, 2)


@pytest.fixture(scope="module")
def found(machine: cw.Robot, measured: Room) -> cw.Calibration:
    return cw.calibrate(machine, measured.data, PLAN, rough=0.05)


def _seen(measured: Room) -> cw.Sightings:
    seen = measured.data.sightings
    assert seen is not None
    return seen


def _without_exits(measured: Room) -> cw.Measured:
    seen = _seen(measured)
    tags = tuple(tag for tag in seen.layout.tags if tag.line is None)
    pictures = tuple(
        None if each is None else replace(each, sightings=tuple(one for one in each.sightings if one.number < 40))
        for each in seen.pictures
    )
    layout = seen.layout.model_copy(update={"tags": tags})
    return replace(measured.data, sightings=replace(seen, layout=layout, pictures=pictures))


def _own_sigma(found: cw.Calibration) -> float:
    """The largest standard deviation of a coordinate of an exit point in the frame of all, m."""
    which = [at for at, each in enumerate(found.unknowns) if each.name == "exit_point"]
    points = np.array([line.exit_point for line in found.robot.lines])
    turns = [np.cross(axis, points - points.mean(axis=0)).ravel() for axis in np.eye(3)]
    motions = np.column_stack([np.tile(np.eye(3), (len(points), 1)), *turns])
    basis, _ = np.linalg.qr(motions)
    inside = np.eye(len(basis)) - basis @ basis.T
    return float(np.sqrt(np.diag(inside @ found.covariance[np.ix_(which, which)] @ inside).max()))


def test_exit_points_are_measured(machine: cw.Robot, measured: Room, found: cw.Calibration) -> None:
    """Their places to each other are known better than without these tags, and errors agree with the stated ones."""
    assert found.status == "ok"
    without = cw.calibrate(machine, _without_exits(measured), PLAN, rough=0.05)
    sigma = _own_sigma(found)
    assert sigma < 0.6 * _own_sigma(without)
    assert np.abs(exit_errors(measured.robot, found.robot, own_frame=True)).max() < 4.0 * sigma
    assert "translation along x" in found.gauge  # no tag has a place in the world that is known beyond the file


def test_a_bump_of_an_exit_point_with_its_tag_is_found(found: cw.Calibration, measured: Room, tmp_path: Path) -> None:
    (tmp_path / "data.csv").write_text("dl_1\n")
    record = record_of(found, tmp_path / "data.csv", datetime.now(UTC))
    same, _ = later(measured, SETUP, 7)
    assert cw.check_drift(found.robot, same.data, record).verdict == "unchanged"
    bumped, line = later(measured, SETUP, 7, bump=0.03)
    drift = cw.check_drift(found.robot, bumped.data, record)
    assert drift.verdict == "moved"
    assert drift.changes[0].line == line


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"on": "exit"}, "is missing: name the line whose exit point it is at"),
        ({"line": "1"}, "is for on = 'exit' alone"),
        ({"on": "exit", "line": "1", "sigma": 0.0}, "sigma = 0.0: must be over 0 m"),
        ({"on": "ceiling"}, "'platform', 'room' or 'exit'"),
    ],
)
def test_a_layout_says_what_is_allowed(tmp_path: Path, change: dict[str, object], words: str) -> None:
    tag = {"number": 1, "size": 0.2, "on": "platform", "at": [0, 0, 0]} | change
    lines = "\n".join(f"{key} = {value!r}" for key, value in tag.items())
    file = tmp_path / "tags.toml"
    file.write_text(f"schema = 1\n[[tags]]\nnumber = 0\nsize = 0.2\nat = [0, 0, 0]\n[[tags]]\n{lines}\n")
    with pytest.raises(cw.InputError) as error:
        load_layout(file)
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_a_line_that_the_robot_lacks_is_an_error(machine: cw.Robot, measured: Room) -> None:
    seen = _seen(measured)
    tags = [tag.model_copy(update={"line": "attic"}) if tag.number == 40 else tag for tag in seen.layout.tags]
    layout = seen.layout.model_copy(update={"tags": tuple(tags)})
    with pytest.raises(cw.InputError, match="tags: tag 40: unknown line 'attic'"):
        cw.calibrate(machine, replace(measured.data, sightings=replace(seen, layout=layout)), PLAN)
