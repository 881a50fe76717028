"""A point platform on virtual CANopen drives holds the tensions that the control chooses, by the drives' torques."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cablewright.live.drives import actions
from cablewright.live.drives.printing import print_on_drives
from cablewright.machine.log.log import read_log
from cablewright.printing.job import Job, Motion
from cablewright.printing.numeric_path import Helix
from terminal_user import WORDS, Typist
from virtual_drives import bench

JOB = Job(
    name="small ring",
    origin=(0.7, -0.5, 0.0),
    helix=Helix(radius=0.1, layers=1, layer_height=0.001, first_height=1.0),
    motion=Motion(print_speed=0.1, travel_speed=0.1, acceleration=0.1),
)


def test_torques_hold_the_chosen_tensions_of_a_point(tmp_path: Path) -> None:
    times = dict.fromkeys(("heartbeat_timeout", "command_timeout", "answer_timeout", "following_time"), 0.1)
    found = bench("house-printer", tension=60.0, deceleration=3.0, **times)
    place = found.rig.plant.truth.position
    homed = actions.home(found.robot, found.twin.owner, tmp_path / "machine", place, lambda: found.port)
    assert homed.status == "done", homed.reason
    found.rig.turn_by_hand(found.robot.lines[0].name, 0.002)  # m that no counter shows
    typist = Typist({state: list(words) for state, words in WORDS.items()})
    answer = print_on_drives(
        found.robot, JOB, tmp_path / "run", found.twin.owner, tmp_path / "machine", typist,
        inputs={}, say=typist.said.append, port=lambda: found.port,
    )  # fmt: skip
    assert answer.finished, typist.said
    told = answer.to_dict()
    assert told["tension_error_rms"] < 12.0  # N of 500 to 700 N, as measured; 20 N by lengths alone
    assert abs(told["estimated_max_path_error"]) < 2e-3
    with read_log(tmp_path / "run") as log:
        given = [each.progress.tensions for each in log.entries() if each.progress is not None]
    chosen = [each for each in given if each is not None]
    assert np.abs(found.rig.plant.truth.tensions - chosen[-1]).max() < 5.0  # true ones, friction and all
