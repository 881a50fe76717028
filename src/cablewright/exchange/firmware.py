"""Export of a robot and a job to the files of a firmware: configuration, and motion."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from types import MappingProxyType
from typing import Final

import numpy as np

from cablewright.analyses.travel_moves import driven_job
from cablewright.exchange.klipper_config import LETTERS as ALPHABET
from cablewright.exchange.klipper_config import klipper_anchors, winch_sections
from cablewright.exchange.motion_export import linuxcnc
from cablewright.exchange.motion_export.cartesian import (
    OwnModelPath,
    as_anchors,
    klipper_turns,
    own_model_path,
    rrf_turns,
)
from cablewright.exchange.motion_export.gcode_lines import extruder_words, motion_lines
from cablewright.exchange.motion_export.klipper import SQUARE_CORNER, Stepper, klipper_job, printer_config
from cablewright.exchange.motion_export.non_motion_gcode import Beside, beside
from cablewright.exchange.rrf_config import FEW, LETTERS, RrfTarget, geometry_words, law_of, rrf_config
from cablewright.exchange.translation_result import Notes
from cablewright.foundation.choices import DialectName, RrfVersionName
from cablewright.foundation.errors import InputError, UnknownName, printable
from cablewright.foundation.progress import Progress, silent
from cablewright.machine.drums import drums_of
from cablewright.machine.settings import MachineSettings
from cablewright.models.drum import WinchDrum
from cablewright.models.statics import Model
from cablewright.models.support_table import Capability, require
from cablewright.printing.job import Job
from cablewright.robot import Robot
from cablewright.studies.checks.winch_angles import TOLERANCE, WinchPath, winch_path


@dataclass(frozen=True, eq=False)
class Firmware:
    """Exported files of a firmware by name, lists of lost and assumed values, and the path that they contain."""

    files: Mapping[str, str]
    lost: tuple[str, ...]
    assumed: tuple[str, ...]
    path: WinchPath


FEWEST: Final = 3
"""Lines that a firmware's own kinematics needs."""

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
    version: RrfVersionName | None = None,
    gear: tuple[int, int] | None = None,
    complete: bool = False,
    progress: Progress = silent,
) -> Firmware:
    """Return the files for a firmware. Without a *machine* drums have one layer and no gear, and that is noted.

    *tolerance*: largest error of the lengths between two points, m; by default half a microstep, or none where the
    firmware computes the lengths itself. By default a jump of a length, as of a line that goes slack, may be
    `TOLERANCE` and is noted. *version*: version of RepRapFirmware; *gear*: teeth of motors and spools; *complete*: for
    LinuxCNC, whether to write all files that it needs to move simulated joints.

    Raises `InputError` for a robot or job that it cannot do, by name, and `AnswerError` where the robot cannot.
    """
    if name not in FIRMWARE:
        raise UnknownName("firmware", name, FIRMWARE)
    assumed, lost = Notes(), Notes()
    motor = _motor(stepper, machine, gear)
    if machine is None:
        without = "" if gear else ", turned without a gear"
        assumed.add(f"drums: one layer of cable{without}; --machine gives layers and gear")
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
    besides = beside(job, path, name)
    _note_job(name, job, besides, lost)
    if name == "reprapfirmware":
        target = rrf_target(robot, version, gear, assumed)
        config = rrf_config(robot, drums, machine, motor.full_steps, path.samples.positions, target)
        lost.add_all(config.lost)
        assumed.add_all(config.assumed)
        files = {"config.g": config.text, "job.g": _cartesian(robot, job, path, besides)}
    elif name == "klipper":
        assumed.add(f"square_corner_velocity: {SQUARE_CORNER:g} mm/s, Klipper's default")
        files = {"printer.cfg": printer_config(robot, job, motor), "job.gcode": klipper_job(robot, job, path, besides)}
        files |= _anchors(robot, lost)
    else:
        assumed.add(f"G64 P{linuxcnc.BLENDING:g}: corners are rounded by up to {linuxcnc.BLENDING:g} mm")
        before, more = linuxcnc.linuxcnc_config(robot) if complete else ("", {})
        files = more | {
            "machine.ini": before + linuxcnc.linuxcnc_ini(robot, job, path),
            "job.ngc": linuxcnc.linuxcnc_job(robot, job, path, besides),
        }
    lost.add_all(besides.notes())
    return _told(files, lost, assumed, path)


def plain_gcode(
    dialect: DialectName,
    robot: Robot,
    job: Job,
    *,
    machine: MachineSettings | None = None,
    stepper: Stepper | None = None,
    layers: tuple[int, int] | None = None,
    version: RrfVersionName | None = None,
    gear: tuple[int, int] | None = None,
    progress: Progress = silent,
) -> tuple[Firmware, OwnModelPath]:
    """Return the files of a job in X Y Z for a firmware's own kinematics, and the accuracy that they reach.

    The difference between its model and this one is in the path. Parameters as of `firmware`. Raises `InputError` for
    a robot whose lines such a kinematics cannot drive, and as `own_model_path`.
    """
    require(robot, Capability.KLIPPER)
    assumed, lost = Notes(), Notes()
    most = len(LETTERS) if dialect == "rrf" else len(ALPHABET)
    if not FEWEST <= robot.m <= most:
        raise InputError(
            f"robot {robot.name!r} has {robot.m} lines; the own kinematics of {dialect} has {FEWEST} to {most}: export "
            "klipper, which moves winches by their angle"
        )
    if robot.winches < robot.m:
        why = f"the own kinematics of {dialect} has one on each: export klipper, which moves winches by their angle"
        raise InputError(f"robot {robot.name!r} has {robot.m} lines on {robot.winches} winches; {why}")
    motor = _motor(stepper, machine, gear)
    job, _ = driven_job(robot, job)
    drums, model = drums_of(robot, machine), Model.full(robot)
    path = winch_path(model, job, drums, layers=layers, tolerance=math.inf, progress=progress)
    anchored = as_anchors(robot, job)
    target = "reprapfirmware" if dialect == "rrf" else "klipper"
    besides = beside(job, path, target)
    _note_job(target, job, besides, lost)
    if dialect == "rrf":
        wanted = rrf_target(robot, version, gear, assumed)
        wanted.require(robot)
        law = law_of(anchored, drums, machine, path.samples.positions, wanted)
        found = own_model_path(model, job, drums, rrf_turns(anchored, law), path, progress)
        config, told = geometry_words(anchored, machine, motor.full_steps, law, wanted)
        assumed.add_all(told)
        files = {"config.g": config, "job.g": _cartesian(robot, job, found.path, besides)}
    else:
        turns = np.array([math.tau * float(drum.radii(path.lengths[:1, i])[0]) / line.advantage
                          for i, (drum, line) in enumerate(zip(drums, robot.lines, strict=True))])  # fmt: skip
        found = own_model_path(model, job, drums, klipper_turns(anchored, turns), path, progress)
        files = {
            "printer.cfg": winch_sections(anchored, turns, motor.ratio),
            "job.gcode": _cartesian(robot, job, found.path, besides),
        }
    _note_own_model(robot, found, lost, assumed)
    lost.add_all(besides.notes())
    return _told(files, lost, assumed, found.path), found


def _note_own_model(robot: Robot, found: OwnModelPath, lost: Notes, assumed: Notes) -> None:
    """Note how near the nozzle comes, and how taut lines are."""
    lost.add(
        f"job: the nozzle's error by the firmware's own model is up to {1e3 * found.error:.2g} mm; X Y Z differ from "
        f"the path by up to {1e3 * found.difference:.2g} mm, without which it would be {1e3 * found.without:.2g} mm"
    )
    taut = ", ".join(
        f"{line.name} {first:.3g} N ({low:.3g} to {high:.3g} N along the path)"
        for line, first, low, high in zip(robot.lines, found.first, *found.tensions, strict=True)
    )
    assumed.add(f"tensions with the nozzle at the first point, where drums count from: {taut}")
    assumed.add(
        "the firmware compensates no stretch: M666 without W, and without F from 3.7 on; Klipper's fork M666 F0"
    )


def _told(files: dict[str, str], lost: Notes, assumed: Notes, path: WinchPath) -> Firmware:
    """Return *files* with comments at the top of each: what was lost, and what was assumed."""
    told = [*(f"lost: {each}" for each in lost.all), *(f"assumed: {each}" for each in assumed.all)]
    for file, text in files.items():
        mark = "#" if file.endswith((".cfg", ".ini", ".hal")) else ";"
        if file.endswith((".var", ".tbl")):
            continue
        files[file] = "".join(f"{mark} {printable(each)}\n" for each in told) + text
    return Firmware(MappingProxyType(files), lost.all, assumed.all, path)


def _motor(stepper: Stepper | None, machine: MachineSettings | None, gear: tuple[int, int] | None) -> Stepper:
    """Return the motor, with the ratio of *gear*, teeth of motor and spool, or of the *machine*."""
    ratio = gear[1] / gear[0] if gear else 1.0 if machine is None else machine.winch.ratio
    return replace(stepper or Stepper(), ratio=ratio)


def rrf_target(robot: Robot, version: RrfVersionName | None, gear: tuple[int, int] | None, assumed: Notes) -> RrfTarget:
    """Return the RepRapFirmware to write for; by default 3.6, or the first that has as many anchors as lines."""
    if version is None:
        version = "3.6" if robot.m <= FEW else "3.7"
        assumed.add(f"RepRapFirmware {version}; --firmware-version takes another")
    return RrfTarget(version, gear)


def _note_job(name: str, job: Job, besides: Beside, lost: Notes) -> None:
    """Note what of a job the motion does not have."""
    if job.motion.shaping != "none":
        lost.add(
            "job: shaping: the firmware's planner makes its own motion along the path, which may swing the platform"
        )
    if name == "linuxcnc":
        lost.add("job: amounts of material; M67 E0 is 1 while a strand is laid and else 0")
    elif besides.feeds is None:
        lost.add(
            "job: E is mm of strand that is laid, not of filament: calibrate the extruder in steps for mm of strand"
        )
        lost.add("job: retractions of the filament")


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


def _cartesian(robot: Robot, job: Job, path: WinchPath, besides: Beside) -> str:
    """Return the G-code of a job in X Y Z, for a firmware that computes the lengths itself."""
    title = {"klipper": "Klipper", "reprapfirmware": "RepRapFirmware"}[besides.target]
    x, y, z = (f"{1e3 * each:.4f}" for each in path.samples.positions[0])
    mode, zero, extruded = extruder_words(besides)
    text = f"; {printable(job.name)} on {printable(robot.name)}, for {title}\n"
    text += f"; X Y Z: the nozzle, mm; {extruded}\nG21\nG90\n{mode}\n"
    if zero:
        text += f"G92{zero}\n"
    text += f"G0 X{x} Y{y} Z{z}\n"
    return text + "".join(motion_lines(path, "", besides, extruder=True))
