"""What a copy of the package with a tilt meter does with it: a program of its own, which prints JSON."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np

import cablewright
from cablewright.exchange.ros.messages import LEFT_OUT
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import READINGS, Command, Encoders, Inertial
from cablewright.live.body_estimator import BodyEstimator, body_settings
from cablewright.live.rest_pose import rest_pose
from cablewright.machine.log.head import LogHead
from cablewright.machine.log.log import read_log, write_log
from cablewright.machine.simulated.settings import load_twin
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.robot import load

TABLES = """
[tilt_meter]
rate = 20.0
deviation = "0.02 deg"
bias = "0.05 deg"

[simulation.tilt_meter]
dropout = 0.1

[[simulation.faults]]
source = "tilt_meter"
kind = "silent"
begin = 1.5
"""


def refused(text: str, folder: Path) -> str:
    file = folder / "wrong.toml"
    file.write_text(text)
    try:
        load_twin(file)
    except InputError as error:
        return str(error).removeprefix(f"{file}: ")
    return ""


def main(folder: Path) -> None:
    (kind,) = (kind for kind in READINGS if kind.__name__ == "TiltMeter")
    text = (Path(cablewright.__file__).parent / "machine" / "library" / "cogiro.toml").read_text()
    file = folder / "machine.toml"
    file.write_text(text + TABLES)
    robot, twin, plain = load("cogiro"), load_twin(file), load_twin("cogiro")
    pose = rest_pose(robot).equilibrium.pose
    machines = [SimulatedMachine(robot, each, pose, seed=3) for each in (twin, plain)]
    owners = [each.with_owner(inertial=None).owner for each in (twin, plain)]
    estimators = [BodyEstimator(body_settings(robot, owner, sensors=True), pose) for owner in owners]
    times, same = [], True
    head = LogHead(robot, twin.owner, machines[0].period, simulation=twin.simulation, plant="dynamic", seed=3)
    with write_log(folder / "log.mcap", head) as log:
        for _ in range(250):
            frames = [each.step(Command(each.time, np.zeros(robot.m))) for each in machines]
            times += [reading.time for reading in frames[0].of(kind)]
            for one, other in zip(frames[0].of(Encoders), frames[1].of(Encoders), strict=True):
                same = same and np.array_equal(one.counts, other.counts)
            for one, other in zip(frames[0].of(Inertial), frames[1].of(Inertial), strict=True):
                same = same and np.array_equal(one.acceleration, other.acceleration)
            log.write(frames[0])
            estimates = [each.step(frame) for each, frame in zip(estimators, frames, strict=True)]
    with read_log(folder / "log.mcap") as read:
        logged = [reading for entry in read.entries() for reading in entry.frame.of(kind)]
    told = {
        "times": times,
        "logged": [reading.time for reading in logged],
        "numbers": sum(len(reading.tilt) for reading in logged),
        "same": bool(same),
        "sigmas": [np.sqrt(np.diag(each.covariance)[6:8]).tolist() for each in estimates],
        "faults": [fault.sentence for fault in estimates[0].faults if fault.source == kind.source],
        "left_out": LEFT_OUT[0],
        "unknown": refused(text + TABLES.replace("dropout", "bias"), folder),
        "none": refused(text + TABLES.partition("[simulation.tilt_meter]")[1] + "\ndropout = 0.1", folder),
    }
    print(json.dumps(told))


main(Path(sys.argv[1]))
