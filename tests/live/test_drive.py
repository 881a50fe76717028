"""A pilot keeps a simulated machine on its path, and what it sums up is what happened."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.foundation.errors import AnswerError, InputError
from cablewright.live.drive_along_path import DriveSettings, drive, path_length, random_loop
from cablewright.live.error_statistics import SLACK
from cablewright.machine.log.log import LogWriter, read_log
from cablewright.machine.powder_load import PowderLoad
from cablewright.robot import load
from twins import SETTINGS, head, machine

LOOP = random_loop(load("merlet2023"), 28.0, seed=2)
START = (*LOOP[0], 1.2)


def test_the_machine_goes_along_the_loop_at_its_speed() -> None:
    settings = DriveSettings()
    twin = machine(plant="quasi-static", start=START)
    drive(twin, LOOP, 20.0, seed=2)
    gone = settings.speed * (20.0 - 0.5 * settings.ramp) / path_length(LOOP) * (len(LOOP) - 1)
    expected = LOOP[round(gone)]
    assert np.linalg.norm(twin.truth.position[:2] - expected) < 0.03
    assert abs(twin.truth.position[2] - 1.2) < 0.03


@pytest.mark.slow  # rounds are driven in the next test
def test_a_drive_comes_to_the_end_of_its_round() -> None:
    twin = machine(plant="quasi-static", start=START)
    found = drive(twin, LOOP, 933.0, seed=2)
    assert found.distance == pytest.approx(28.0, rel=0.02)
    assert np.linalg.norm(twin.truth.position[:2] - LOOP[0]) < 0.05
    assert found.powder == pytest.approx(SETTINGS.drum.powder - 933.0 * SETTINGS.drum.flow, abs=1e-6)
    assert found.notices.total() == 0
    assert found.slack_share.sum() > 0.1
    assert found.slack_share.max() < 1.0


def test_the_drum_is_filled_up_after_each_round(tmp_path) -> None:
    twin = machine(plant="quasi-static", start=START)
    with (tmp_path / "a.mcap").open("wb") as file, LogWriter(file, head()) as log:
        found = drive(twin, LOOP, 120.0, settings=DriveSettings(speed=0.5), log=log)
    load_of_log, before = PowderLoad.of(SETTINGS.drum), 0.0
    with read_log(tmp_path / "a.mcap") as log:
        for entry in log.entries():
            load_of_log.follow(entry.orders, entry.command, entry.frame.time - before)
            before = entry.frame.time
            assert load_of_log.left == pytest.approx(entry.truth.powder, abs=1e-6)
    assert found.refills == 2
    assert found.powder > SETTINGS.drum.powder - 30.0 * SETTINGS.drum.flow
    laid = twin.rig.ground.mass + twin.rig.falling_mass
    assert laid == pytest.approx(120.0 * SETTINGS.drum.flow, rel=1e-9)
    with pytest.raises(InputError, match="the drum takes 0 to 50 kg"):
        twin.refill(60.0)


def test_the_log_and_the_summary_agree(tmp_path) -> None:
    twin = machine(plant="dynamic", start=START)
    with (tmp_path / "a.mcap").open("wb") as file, LogWriter(file, head()) as log:
        found = drive(twin, LOOP, 8.0, seed=1, log=log)
    with read_log(tmp_path / "a.mcap") as log:
        entries = list(log.entries())
    excess = np.array([entry.truth.excess for entry in entries])
    np.testing.assert_array_equal((excess > SLACK).mean(axis=0), found.slack_share)
    assert found.max_tension == max(entry.truth.tensions.max() for entry in entries)
    assert sum(len(entry.frame.readings) for entry in entries) == found.readings.total()
    assert len(found.path) == 8
    assert entries[100].command.valve == 1.0


def test_a_machine_is_held_in_its_place() -> None:
    twin = machine(plant="quasi-static")
    found = drive(twin, None, 60.0, settings=DriveSettings(slack=0.0, error=0.0, valve=0.0))
    np.testing.assert_allclose(twin.truth.position, (0.3, -1.0, 1.2), atol=1e-4)
    assert found.distance < 1e-2


def test_what_cannot_be_driven_is_rejected() -> None:
    twin = machine(plant="quasi-static")
    with pytest.raises(InputError, match="duration = 0 s"):
        drive(twin, None, 0.0)
    with pytest.raises(AnswerError, match="the path cannot be held at"):
        drive(twin, 4.0 * LOOP, 1.0)
    for wrong, says in (
        ({"speed": 0.0}, "speed = 0"),
        ({"slack": 2.0}, "slack = 2 m"),
        ({"valve": -1.0}, "valve = -1"),
    ):
        with pytest.raises(InputError, match=says):
            DriveSettings(**wrong)
