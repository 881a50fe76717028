"""A robot and a job as the files of a firmware: configuration, and motion."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from types import MappingProxyType
from typing import Final

import numpy as np

from cablewright.errors import InputError, UnknownName, printable
from cablewright.exchange import linuxcnc
from cablewright.exchange.klipper_config import klipper_anchors
from cablewright.exchange.klipper_motion import Stepper, klipper_job, letters_of, printer_config
from cablewright.exchange.motion_lines import motion_lines
from cablewright.exchange.rrf_config import rrf_config
from cablewright.exchange.translation import Notes
from cablewright.machine.drums import drums_of
from cablewright.machine.settings import MachineSettings
from cablewright.models.drum import Drum
from cablewright.models.statics import Model
from cablewright.printing.job import Job
from cablewright.progress import Progress, silent
from cablewright.robot import Robot
from cablewright.studies.checks.winch_path import WinchPath, winch_path


@dataclass(frozen=True, eq=False)
class Firmware:
    """Files by name, what they lose and assume, and the path that they hold."""

    files: Mapping[str, str]
    lost: tuple[str, ...]
    assumed: tuple[str, ...]
    path: WinchPath


FIRMWARE: Final = ("klipper", "reprapfirmware", "linuxcnc")
"""Names of the firmwares."""


def firmware(
    name: str,
    robot: Robot,
    job: Job,
    *,
    machine: MachineSettings | None = None,
    stepper: Stepper | None = None,
    layers: tuple[int, int] | None = None,
    tolerance: float | None = None,
    progress: Progress = silent,
) -> Firmware:
    """Return the files for a firmware. Without a *machine* drums have one layer and no gear, and that is noted.

    *tolerance*: of lengths between points, m; by default half a microstep, or none where the firmware computes the
    lengths itself.

    Raises `InputError` for a robot or job that it cannot do, by name, and `AnswerError` where the robot cannot.
    """
    if name not in FIRMWARE:
        raise UnknownName("firmware", name, FIRMWARE)
    robot.require_own_winches(f"firmware {name}")
    assumed, lost = Notes(), Notes()
    motor = stepper or Stepper(ratio=1.0 if machine is None else machine.winch.ratio)
    if machine is None:
        assumed.add("drums: one layer of cable, turned without a gear; --machine gives layers and gear")
    if stepper is None:
        assumed.add(f"motors: {motor.full_steps} full steps a turn, {motor.microsteps} microsteps each")
    drums = drums_of(robot, machine)
    _require_lines(name, robot)
    config = rrf_config(robot, drums, machine, motor.full_steps) if name == "reprapfirmware" else None
    close = _tolerance(name, motor, robot, drums) if tolerance is None else tolerance
    path = winch_path(Model.full(robot), job, drums, layers=layers, tolerance=close, progress=progress)
    lost.add("job: retractions of the filament; E is mm of strand that is laid")
    if config is not None:
        for each in config.lost:
            lost.add(each)
        for each in config.assumed:
            assumed.add(each)
        files = {"config.g": config.text, "job.g": _cartesian(robot, job, path)}
    elif name == "klipper":
        files = {"printer.cfg": printer_config(robot, job, motor), "job.gcode": klipper_job(robot, job, path)}
        files |= _anchors(robot, lost)
    else:
        files = {
            "machine.ini": linuxcnc.linuxcnc_ini(robot, job, path),
            "job.ngc": linuxcnc.linuxcnc_job(robot, job, path),
        }
    return Firmware(MappingProxyType(files), lost.all, assumed.all, path)


def _require_lines(name: str, robot: Robot) -> None:
    """Raise `InputError` for too many lines, and for one without a winch, before the path is solved."""
    robot.require_winches(name)
    if name == "klipper":
        letters_of(robot)
    elif name == "linuxcnc":
        linuxcnc.letters_of(robot)


def _tolerance(name: str, motor: Stepper, robot: Robot, drums: Sequence[Drum]) -> float:
    """Return the error that lengths between points may have, m, with a little left for the rounding of angles."""
    if name == "reprapfirmware":
        return math.inf
    corners = list(product(*zip(robot.scene.frame_min, robot.scene.frame_max, strict=True)))
    radii = []
    for line, drum in zip(robot.lines, drums, strict=True):
        longest = line.advantage * max(math.dist(corner, line.exit_point) for corner in corners)
        radii.append(drum.radius if drum.build_up == 0.0 else float(drum.radii(np.asarray(longest))))
    return 0.99 * 0.5 * motor.microstep * min(radii)


def _anchors(robot: Robot, lost: Notes) -> dict[str, str]:
    """Return Klipper's own winch kinematics as a file, where it can describe the robot."""
    try:
        return {"printer-winch.cfg": klipper_anchors(robot).text}
    except InputError as reason:
        lost.add(f"printer-winch.cfg, for Klipper's own kinematics, is not written: {reason}")
        return {}


def _cartesian(robot: Robot, job: Job, path: WinchPath) -> str:
    """Return the G-code of a job in X Y Z, for a firmware that computes the lengths itself."""
    x, y, z = (f"{1e3 * each:.4f}" for each in path.samples.positions[0])
    text = f"; {printable(job.name)} on {printable(robot.name)}, for RepRapFirmware\n"
    text += f"; X Y Z: the nozzle, mm; E: mm of strand laid\nG21\nG90\nM82\nG92 E0\nG0 X{x} Y{y} Z{z}\n"
    return text + "".join(motion_lines(path, "", extruder=True))
