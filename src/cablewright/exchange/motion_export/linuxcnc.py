"""A job as motion of winches for LinuxCNC: an INI's axes and joints, and a G-code file in winch coordinates.

LinuxCNC has nine axes; X Y Z are the nozzle's place, virtual, and winches take A B C U V W. What is laid is an analog
output that is set in time with the motion (M67), mm of strand per mm of way.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from cablewright.exchange.motion_export.gcode_lines import extent_notes, motion_lines
from cablewright.exchange.motion_export.klipper import rates_of
from cablewright.exchange.motion_export.non_motion_gcode import Beside
from cablewright.foundation.errors import printable
from cablewright.printing.job import Job
from cablewright.robot import Robot
from cablewright.studies.checks.winch_angles import WinchPath

LETTERS: Final = "ABCUVW"
BLENDING: Final = 0.01
"""Distance, mm, within which LinuxCNC may round corners so that it does not stop at each point (G64 P)."""


PERIOD: Final = 1_000_000  # ns, of the servo thread


def linuxcnc_ini(robot: Robot, job: Job, path: WinchPath) -> str:
    """Return the sections of an INI file for kinematics, axes and joints; HAL pins are the machine's own.

    Joints are homed where they are, which is then the first point: the nozzle is there by hand or by the machine.
    """
    letters = LETTERS[: robot.winches]
    speed = 1e3 * max(job.motion.print_speed, job.motion.travel_speed)
    acceleration = 1e3 * job.motion.acceleration
    rates = np.abs(rates_of(path)).max(axis=0)
    axes = "XYZ" + letters
    text = f"[KINS]\nKINEMATICS = trivkins coordinates={axes} kinstype=BOTH\nJOINTS = {len(axes)}\n\n"
    text += f"[TRAJ]\nCOORDINATES = {axes}\nLINEAR_UNITS = mm\nANGULAR_UNITS = degree\n"
    text += f"MAX_LINEAR_VELOCITY = {speed:g}\nMAX_LINEAR_ACCELERATION = {acceleration:g}\n"
    turning = 1.1 * speed * max(float(rates.max(initial=0.0)), 1e-3)
    text += f"MAX_ANGULAR_VELOCITY = {turning:.4f}\nDEFAULT_LINEAR_VELOCITY = {speed:g}\n"
    starts = [*(1e3 * path.samples.positions[0]), *([0.0] * robot.m)]
    low, high = 1e3 * path.samples.positions.min(axis=0), 1e3 * path.samples.positions.max(axis=0)
    ends = np.degrees(path.turns)
    lows, highs = [*low, *ends.min(axis=0)], [*high, *ends.max(axis=0)]
    for k, letter in enumerate(axes):
        rate = 1.0 if k < 3 else max(float(rates[k - 3]), 1e-3)
        kind = "ANGULAR" if letter in "ABC" else "LINEAR"
        body = (
            f"MIN_LIMIT = {lows[k] - 1.0:.3f}\nMAX_LIMIT = {highs[k] + 1.0:.3f}\n"
            f"MAX_VELOCITY = {1.1 * rate * speed:.4f}\nMAX_ACCELERATION = {2.0 * rate * acceleration:.4f}\n"
        )
        home = (
            f"HOME = {starts[k]:.4f}\nHOME_OFFSET = {starts[k]:.4f}\nHOME_SEARCH_VEL = 0\nHOME_LATCH_VEL = 0\n"
            "HOME_SEQUENCE = 0\n"
        )
        what = "nozzle, virtual" if k < 3 else f"line {robot.winch_names[k - 3]!r}, degrees of the drum"
        text += (
            f"\n# {what}\n[AXIS_{letter}]\n{body}\n[JOINT_{k}]\nTYPE = {kind}\n{home}FERROR = 1\nMIN_FERROR = 1\n{body}"
        )
    return text


def linuxcnc_config(robot: Robot) -> tuple[str, dict[str, str]]:
    """Return the lines before `linuxcnc_ini` in a complete INI file, and the files that it names.

    The HAL file moves simulated joints: each follows its command. A machine's own puts its drives between the two.
    """
    sections = {
        "EMC": {"VERSION": "1.1", "MACHINE": printable(robot.name), "DEBUG": "0"},
        "DISPLAY": {"DISPLAY": "axis", "CYCLE_TIME": "0.1", "PROGRAM_PREFIX": ".", "GEOMETRY": "XYZ"},
        "TASK": {"TASK": "milltask", "CYCLE_TIME": "0.001"},
        "RS274NGC": {"PARAMETER_FILE": "machine.var"},
        "EMCMOT": {"EMCMOT": "motmod", "COMM_TIMEOUT": "1.0", "BASE_PERIOD": "0", "SERVO_PERIOD": str(PERIOD)},
        "EMCIO": {"EMCIO": "io", "CYCLE_TIME": "0.1", "TOOL_TABLE": "tool.tbl"},
        "HAL": {"HALFILE": "machine.hal", "HALUI": "halui"},
    }
    text = "".join(
        f"[{name}]\n" + "".join(f"{key} = {value}\n" for key, value in keys.items()) + "\n"
        for name, keys in sections.items()
    )
    joints = 3 + robot.winches
    hal = "# Simulated joints. Of a machine, drives take motor-pos-cmd, and their encoders give motor-pos-fb.\n"
    hal += "loadrt [KINS]KINEMATICS\n"
    hal += "loadrt [EMCMOT]EMCMOT servo_period_nsec=[EMCMOT]SERVO_PERIOD num_joints=[KINS]JOINTS num_aio=4 num_dio=4\n"
    hal += "addf motion-command-handler servo-thread\naddf motion-controller servo-thread\n"
    for k in range(joints):
        hal += f"net joint-{k} joint.{k}.motor-pos-cmd => joint.{k}.motor-pos-fb\n"
    hal += "net laying <= motion.analog-out-00  # 1 while a strand is laid\n"
    hal += "net estop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in\n"
    hal += "net tool-prepare iocontrol.0.tool-prepare => iocontrol.0.tool-prepared\n"
    hal += "net tool-change iocontrol.0.tool-change => iocontrol.0.tool-changed\n"
    return text, {"machine.hal": hal, "tool.tbl": "T1 P1 D0 ; the nozzle\n", "machine.var": ""}


def linuxcnc_job(robot: Robot, job: Job, path: WinchPath, besides: Beside) -> str:
    """Return the G-code of a job: its motion, and the commands *besides* motion of its own file, as of heaters."""
    letters = LETTERS[: robot.winches]
    x, y, z = (f"{1e3 * each:.4f}" for each in path.samples.positions[0])
    text = f"; {printable(job.name)} on {printable(robot.name)}, for LinuxCNC\n"
    text += extent_notes(path, letters, robot, "M67 E0: 1 while a strand is laid")
    zero = " ".join(f"{letter}0" for letter in letters)
    text += f"G21 G90 G94 G64 P{BLENDING:g}\nG10 L20 P1 X{x} Y{y} Z{z} {zero}\nM67 E0 Q0\n"
    return f"{text}{''.join(_with_output(path, letters, besides))}M67 E0 Q0\nM2\n"


def _with_output(path: WinchPath, letters: str, besides: Beside) -> Iterator[str]:
    """Yield the lines of motion, and the output where laying begins and ends."""
    laying = False
    for line in motion_lines(path, letters, besides, extruder=False):
        if line.startswith(("G0 ", "G1 ")) and line.startswith("G1 ") != laying:
            laying = not laying
            yield f"M67 E0 Q{int(laying)}\n"
        yield line.replace("G0 ", "G1 ", 1) if line.startswith("G0 ") else line  # a rapid has no feed
