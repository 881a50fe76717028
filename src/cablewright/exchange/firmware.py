"""A robot and a job as the files of a firmware: configuration, and motion."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from types import MappingProxyType
from typing import Final

import numpy as np

from cablewright.analyses.safe_travel import driven_job
from cablewright.exchange import linuxcnc
from cablewright.exchange.klipper_config import klipper_anchors
from cablewright.exchange.klipper_motion import SQUARE_CORNER, Stepper, klipper_job, printer_config
from cablewright.exchange.motion_lines import motion_lines
from cablewright.exchange.rrf_config import rrf_config
from cablewright.exchange.translation import Notes
from cablewright.foundation.errors import InputError, UnknownName, printable
from cablewright.foundation.progress import Progress, silent
from cablewright.machine.drums import drums_of
from cablewright.machine.settings import MachineSettings
from cablewright.models.drum import WinchDrum
from cablewright.models.statics import Model
from cablewright.models.support import Capability, require
from cablewright.printing.job import Job
from cablewright.robot import Robot
from cablewright.studies.checks.winch_path import TOLERANCE, WinchPath, winch_path


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
    lengths itself. By default a jump of a length, as of a line that goes slack, may be `TOLERANCE` and is noted.

    Raises `InputError` for a robot or job that it cannot do, by name, and `AnswerError` where the robot cannot.
    """
    if name not in FIRMWARE:
        raise UnknownName("firmware", name, FIRMWARE)
    assumed, lost = Notes(), Notes()
    motor = stepper or Stepper(ratio=1.0 if machine is None else machine.winch.ratio)
    if machine is None:
        assumed.add("drums: one layer of cable, turned without a gear; --machine gives layers and gear")
    if stepper is None:
        assumed.add(f"motors: {motor.full_steps} full steps a turn, {motor.microsteps} microsteps each")
    require(robot, Capability(f"export {name}"))
    job, _ = driven_job(robot, job)
    drums = drums_of(robot, machine)
    close = _tolerance(name, motor, robot, drums) if tolerance is None else tolerance
    jump = TOLERANCE if tolerance is None else 0.0
    path = winch_path(Model.full(robot), job, drums, layers=layers, tolerance=close, jump=jump, progress=progress)
    if path.error > close:
        lost.add(f"job: where a line goes slack its length jumps, by {1e6 * path.error:.2g} um between two points")
    _note_job(name, job, path, lost)
    if name == "reprapfirmware":
        config = rrf_config(robot, drums, machine, motor.full_steps, path.samples.positions)
        lost.add_all(config.lost)
        assumed.add_all(config.assumed)
        files = {"config.g": config.text, "job.g": _cartesian(robot, job, path)}
    elif name == "klipper":
        assumed.add(f"square_corner_velocity: {SQUARE_CORNER:g} mm/s, Klipper's default")
        files = {"printer.cfg": printer_config(robot, job, motor), "job.gcode": klipper_job(robot, job, path)}
        files |= _anchors(robot, lost)
    else:
        assumed.add(f"G64 P{linuxcnc.BLENDING:g}: corners are rounded by up to {linuxcnc.BLENDING:g} mm")
        files = {
            "machine.ini": linuxcnc.linuxcnc_ini(robot, job, path),
            "job.ngc": linuxcnc.linuxcnc_job(robot, job, path),
        }
    told = [*(f"lost: {each}" for each in lost.all), *(f"assumed: {each}" for each in assumed.all)]
    for file, text in files.items():
        mark = "#" if file.endswith((".cfg", ".ini")) else ";"
        files[file] = "".join(f"{mark} {printable(each)}\n" for each in told) + text
    return Firmware(MappingProxyType(files), lost.all, assumed.all, path)


def _note_job(name: str, job: Job, path: WinchPath, lost: Notes) -> None:
    """Note what of a job the motion does not have."""
    if job.motion.shaping != "none":
        lost.add(
            "job: shaping: the firmware's planner makes its own motion along the path, which may swing the platform"
        )
    lost.add("job: retractions of the filament")
    if name == "linuxcnc":
        lost.add("job: amounts of material; M67 E0 is 1 while a strand is laid and else 0")
    else:
        lost.add(
            "job: E is mm of strand that is laid, not of filament: calibrate the extruder in steps for mm of strand"
        )
    if codes := [f"{word} ({count})" for word, count in path.ignored.items() if word[0] in "MT"]:
        lost.add(f"job: temperatures, fans and the like: {', '.join(codes)}; put those that it needs before the motion")


def _tolerance(name: str, motor: Stepper, robot: Robot, drums: Sequence[WinchDrum]) -> float:
    """Return the error that lengths between points may have, m, with a little left for the rounding of angles."""
    if name == "reprapfirmware":
        return math.inf
    corners = list(product(*zip(robot.scene.frame_min, robot.scene.frame_max, strict=True)))
    radii = []
    for line, drum in zip(robot.winch_lines, drums, strict=True):
        longest = line.advantage * max(math.dist(corner, line.exit_point) for corner in corners)
        radii.append(drum.radius if drum.build_up == 0.0 else float(drum.radii(np.asarray(longest))))
    return 0.99 * 0.5 * motor.microstep * min(radii)


def _anchors(robot: Robot, lost: Notes) -> dict[str, str]:
    """Return Klipper's own winch kinematics as a file, where it can describe the robot."""
    try:
        found = klipper_anchors(robot)
        lost.add_all(f"printer-winch.cfg: {each}" for each in found.lost)
        return {"printer-winch.cfg": found.text}
    except InputError as reason:
        lost.add(f"printer-winch.cfg, for Klipper's own kinematics, is not written: {reason}")
        return {}


def _cartesian(robot: Robot, job: Job, path: WinchPath) -> str:
    """Return the G-code of a job in X Y Z, for a firmware that computes the lengths itself."""
    x, y, z = (f"{1e3 * each:.4f}" for each in path.samples.positions[0])
    text = f"; {printable(job.name)} on {printable(robot.name)}, for RepRapFirmware\n"
    text += f"; X Y Z: the nozzle, mm; E: mm of strand laid\nG21\nG90\nM82\nG92 E0\nG0 X{x} Y{y} Z{z}\n"
    return text + "".join(motion_lines(path, "", extruder=True))
