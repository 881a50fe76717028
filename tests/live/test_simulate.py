"""The verb `simulate`: its arguments, its errors, and its result."""

from __future__ import annotations

import json
from typing import Any

import pytest

import cablewright as cw
import shared_winch_robots

ROBOT = cw.load("merlet2023")
SHORT: dict[str, Any] = {"hold": [0.0, 0.0, 1.2], "duration": 4.0, "plant": "quasi-static"}


def told(found: cw.Simulation) -> dict[str, Any]:
    """All figures but the one that the computer decides."""
    return {key: value for key, value in found.to_dict().items() if key != "real_time_ratio"}


def test_a_robot_and_a_model_settings_and_their_name_give_the_same(tmp_path) -> None:
    log = tmp_path / "run.mcap"
    found = cw.simulate(ROBOT, log=log, **SHORT)
    assert told(found) == told(cw.simulate(cw.Model(ROBOT), cw.load_twin("merlet2023"), **SHORT))
    assert told(found) == told(cw.simulate(ROBOT, "merlet2023", **SHORT))
    with cw.read_log(log) as read:
        assert len(list(read.entries())) == found.drive.steps == 20


def test_a_simulation_is_a_result() -> None:
    found = cw.simulate(ROBOT, **SHORT)
    assert json.dumps(found.to_dict(), allow_nan=False)
    assert len(repr(found)) < 160
    assert "\n" not in repr(found)
    assert len(found.plot().axes) == 4


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({}, "give one of loop"),
        ({"loop": 28.0, "hold": [0.0, 0.0, 1.2]}, "give one of loop"),
        ({"hold": [0.0, 0.0, 1.2]}, "hold needs a duration"),
        ({**SHORT, "hold": [0.0, 0.0]}, "3 finite numbers"),
        ({**SHORT, "plant": "static"}, "unknown plant 'static'; did you mean 'quasi-static'"),
        ({**SHORT, "machine": "merlet"}, "no machine 'merlet'"),
        ({**SHORT, "log": "log.bag"}, r"a name that ends in \.mcap"),
    ],
)
def test_what_cannot_be_simulated_is_rejected(options: dict[str, Any], says: str) -> None:
    with pytest.raises(cw.InputError, match=says):
        cw.simulate(ROBOT, **options)


def test_a_platform_on_few_winches_holds_as_it_hangs() -> None:
    found = cw.simulate(shared_winch_robots.pairs(), **{**SHORT, "hold": [0.1, 0.0, 0.6]})
    assert not found.drive.notices
    assert found.drive.path[-1][1:4] == pytest.approx([0.1, 0.0, 0.6], abs=5e-3)
