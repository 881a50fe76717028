"""A camera on the platform that looks at tags on the floor, from pixels to the calibrated robot, and a later check."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from benchmarks.campaigns.camera_rooms import Room, Setup, exit_errors, later, room

import cablewright as cw
from cablewright.calibration.drift.record import record_of

SETUP = Setup(camera="platform", poses=14, width=800, height=600, focal=400.0, size=0.4, encoder=1e-4)
PLAN = cw.CalibrationPlan(sigma={"encoder": 1e-4})


@pytest.fixture(scope="module")
def measured() -> Room:
    return room(cw.load("ipanema"), SETUP, 3)


@pytest.fixture(scope="module")
def found(measured: Room) -> cw.Calibration:
    return cw.calibrate(cw.load("ipanema"), measured.data, PLAN, rough=0.05)


def test_exit_points_are_found_in_the_world_of_the_floor(measured: Room, found: cw.Calibration) -> None:
    assert measured.data.sightings is not None
    assert np.count_nonzero(measured.data.sightings.counts) >= 8  # near the floor none fits into a picture
    assert (found.status, found.gauge) == ("ok", ())
    which = [at for at, each in enumerate(found.unknowns) if each.name == "exit_point"]
    off = exit_errors(measured.robot, found.robot, own_frame=False).ravel()
    assert off @ np.linalg.solve(found.covariance[np.ix_(which, which)], off) < 2.0 * len(which)
    assert np.abs(exit_errors(measured.robot, found.robot, own_frame=True)).max() < 6e-3


def test_the_mount_is_found_from_a_rough_one(measured: Room, found: cw.Calibration) -> None:
    """The layout has the camera 55 mm from where it is on the platform."""
    at = {each.label: index for index, each in enumerate(found.unknowns)}
    for axis, true in zip("xyz", measured.camera[0], strict=True):
        index = at[f"camera place {axis}"]
        assert found.values[index] == pytest.approx(true, abs=4.0 * found.sigma[index])
        assert found.sigma[index] < 0.02


def test_a_bump_is_found_by_three_pictures_from_the_platform(
    measured: Room, found: cw.Calibration, tmp_path: Path
) -> None:
    (tmp_path / "data.csv").write_text("dl_1\n")
    record = record_of(found, tmp_path / "data.csv", datetime.now(UTC))
    same, _ = later(measured, SETUP, 7)
    bumped, line = later(measured, SETUP, 7, bump=0.03)
    assert cw.check_drift(found.robot, same.data, record).verdict == "unchanged"
    drift = cw.check_drift(found.robot, bumped.data, record)
    assert drift.verdict == "moved"
    assert drift.changes[0].line == line


def test_all_tags_on_the_platform_are_an_error(measured: Room) -> None:
    seen = measured.data.sightings
    assert seen is not None
    tags = [tag.model_dump() | {"on": "platform"} for tag in seen.layout.tags]
    with pytest.raises(ValueError, match="are all on the platform, as the camera is: put some into the room"):
        cw.TagLayout(camera="platform", tags=tags)
    nothing = replace(measured.data, sightings=replace(seen, pictures=(None,) * len(seen.pictures)))
    with pytest.raises(cw.InputError, match="no picture shows a tag of the layout that can be used"):
        cw.calibrate(cw.load("ipanema"), nothing)
