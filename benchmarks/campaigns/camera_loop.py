"""Errors and coverage of the estimators with a camera in the room, beside encoders alone and other sensors.

    python -m benchmarks.campaigns.camera_loop exhibition 12 30 90001        # machine, machines, seconds, first seed
    python -m benchmarks.campaigns.camera_loop house 12 30 90001 typical
    python -m benchmarks.campaigns.camera_loop body 8 60 90001

`merlet2023` (exhibition) and `house-printer` are driven along a random closed path, `cogiro` prints in steps of 0.2 s
from equilibrium to equilibrium (`body_stretch`); all estimators read the same frames. The camera takes 2 pictures a
second (2.5 of the body), 4K with a focal length of 2400 px, and sees four tags. Its place is known to 1 mm, its
direction to 0.2 mrad, the focal length to 0.02 %, times to 5 ms: about what a calibration of 20 poses leaves
(`camera_setups`). Unknown to the estimators: delays of 30 to 200 ms, a tenth of the time hidden, 5 % lost, 1 % random,
a readout of 10 ms and an exposure of 5 ms. Positions count ten times a second, of the body once, from 5 s on. The nees
is ideally 3; positions of one machine are not independent.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Final

import numpy as np

from benchmarks.campaigns.body_stretch import JOB, PERIOD, Found, machine_of
from cablewright.foundation.signals import Estimate
from cablewright.live.drive_along_path import DriveSettings, Pilot, random_loop
from cablewright.live.estimators import Estimator, estimator
from cablewright.live.prints.plan import PrintOptions, plan_print, twin_of
from cablewright.live.prints.run import begin_print
from cablewright.live.prints.simulated_operator import attendant_of
from cablewright.machine.sensors.camera import CameraSensor, PlatformTag
from cablewright.machine.settings import MachineSettings
from cablewright.machine.simulated.sensors.camera import CameraFlaws
from cablewright.machine.simulated.settings import TwinSettings, load_twin
from cablewright.machine.simulated.severities import with_severity
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.robot import Robot, load

NAMES: Final = {"exhibition": "merlet2023", "house": "house-printer", "body": "cogiro"}
SEVERITIES: Final = ("typical", "rough")
LENGTHS: Final = {"exhibition": 28.0, "house": 60.0}  # m, of a path
HEIGHTS: Final = {"exhibition": 1.2, "house": 3.0}  # m
AWAY: Final = {"exhibition": 1.0, "house": 4.0, "body": 3.0}  # m, of the camera before the frame
SIZES: Final = {"exhibition": 0.25, "house": 0.5, "body": 0.3}  # m, of a tag
COUNTS_FROM: Final = 5.0  # s
TAGS: Final = (
    ((-0.6, -0.8, -1.2), (-0.5, -1.0, 0.2)),
    ((0.6, -0.8, -1.2), (0.5, -1.0, 0.2)),
    ((-0.4, -0.8, -2.4), (0.0, -1.0, 0.3)),
    ((0.4, -0.8, -3.0), (0.2, -1.0, 0.0)),
)
"""Places of tags over their size, and normals."""

FLAWS: Final = CameraFlaws(
    occlusion=0.1, dropout=0.05, outliers=0.01, exposure=5e-3, readout=10e-3, latency=(0.03, 0.2)
)


def camera_of(which: str, robot: Robot) -> CameraSensor:
    """Return the camera of a machine."""
    low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    middle, size = 0.5 * (low + high), SIZES[which]
    tags = tuple(PlatformTag(size=size, at=tuple(size * x for x in at), normal=normal) for at, normal in TAGS)
    return CameraSensor(
        rate=2.5 if which == "body" else 2.0,
        at=(float(middle[0]), float(low[1]) - AWAY[which], float(middle[2])),
        looks=(0.0, 1.0, -0.15),
        width=3840,
        height=2160,
        focal_length=2400.0,
        corner_deviation=0.15,
        place_deviation=1e-3,
        turn_deviation=2e-4,
        focal_deviation=2e-4,
        time_deviation=5e-3,
        tags=tags,
    )


def beside(which: str, owner: MachineSettings) -> dict[str, tuple[str, MachineSettings]]:
    """Return the estimators by name: which one, and of what machine."""
    found = {"encoders": ("encoders", owner)}
    if which == "body":
        no_cells = dict.fromkeys(("load_cells", "motor_torques", "inertial", "swivels"))
        found["camera"] = "filter", owner.model_copy(update=no_cells)
        found["cells and inertial unit"] = "filter", owner.model_copy(update={"camera": None})
        found["all"] = "filter", owner
        return found
    found["camera"] = "filter", owner.model_copy(update={"lidars": {}})
    if owner.lidars:
        found["lidars"] = "filter", owner.model_copy(update={"camera": None})
        found["both"] = "filter", owner
    return found


def watched(item: tuple[str, str, int, float]) -> dict[str, Found]:
    """Drive the machine of a severity and a seed with all estimators beside it."""
    which, severity, seed, seconds = item
    found: dict[str, Found] = {}
    for name, estimate, position, time in _body(severity, seed, seconds) if which == "body" else _point(*item):
        own = found.setdefault(name, Found())
        if estimate.valid and time >= COUNTS_FROM:
            if estimate.covariance is None:
                own.errors.append(float(np.linalg.norm(estimate.position - position)))
            else:
                own.add(estimate, position)
    return found


_Row = tuple[str, Estimate, np.ndarray, float]


def _point(which: str, severity: str, seed: int, seconds: float) -> Iterator[_Row]:
    robot = load(NAMES[which])
    twin = _seen(which, robot, with_severity(load_twin(NAMES[which]), severity))
    way = random_loop(robot, LENGTHS[which], seed)
    start = np.array([*way[0], HEIGHTS[which]])
    machine = SimulatedMachine(robot, twin, start, seed=seed)
    pilot = Pilot(machine, way, DriveSettings(), seed)
    run = _started(which, robot, twin.owner, start)
    for step in range(round(seconds / machine.period)):
        frame = machine.step(pilot.command())
        for name, each in run.items():
            estimate = each.step(frame)
            if step % 10 == 0:
                yield name, estimate, machine.truth.position, frame.time


def _body(severity: str, seed: int, seconds: float) -> Iterator[_Row]:
    robot, settings = machine_of(severity)
    options = PrintOptions("filter", layers=2, plant="quasi-static", period=PERIOD, seed=seed)
    twin = twin_of(robot, JOB, _seen("body", robot, settings), options)
    machine, printer = begin_print(twin, plan_print(twin))
    run = _started("body", robot, machine.settings, twin.path.start_pose)
    attendant = attendant_of(machine, printer, options)
    for number in range(round(seconds / PERIOD)):
        step = printer.step(attendant.orders(printer, printer.time))
        for name, each in run.items():
            estimate = each.step(step.frame)
            if number % 5 == 0:
                yield name, estimate, machine.truth.position, step.frame.time
        if attendant.is_over(printer):
            break


def _seen(which: str, robot: Robot, twin: TwinSettings) -> TwinSettings:
    return twin.with_owner(camera=camera_of(which, robot)).with_simulation(camera=FLAWS)


def _started(which: str, robot: Robot, owner: MachineSettings, start: np.ndarray) -> dict[str, Estimator]:
    return {name: estimator(kind, robot, own, start) for name, (kind, own) in beside(which, owner).items()}


def main() -> None:
    """Print the table."""
    which, machines, seconds, first = sys.argv[1], int(sys.argv[2]), float(sys.argv[3]), int(sys.argv[4])
    severities = tuple(sys.argv[5].split(",")) if len(sys.argv) > 5 else SEVERITIES
    jobs = [(which, severity, first + k, seconds) for severity in severities for k in range(machines)]
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        found = dict(zip(jobs, pool.map(watched, jobs), strict=True))
    print(f"| {which}, {machines} machines | estimator | rms, most | sigma | in the 95 % ellipsoid | nees |")
    print("| --- | --- | --- | --- | --- | --- |")
    for severity in severities:
        pooled: dict[str, Found] = {}
        for job in jobs:
            for name, each in found[job].items() if job[1] == severity else ():
                own = pooled.setdefault(name, Found())
                for key, values in vars(each).items():
                    getattr(own, key).extend(values)
        for name, each in pooled.items():
            print(f"| {severity} | {name} | {_row(each)} |", flush=True)


def _row(found: Found) -> str:
    if found.nees:
        return found.row()
    size = 1e3 * np.array(found.errors)
    return f"{np.sqrt((size**2).mean()):.2f}, {size.max():.1f} mm | - | - | -"


if __name__ == "__main__":
    main()
