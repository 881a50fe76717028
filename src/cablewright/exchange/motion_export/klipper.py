"""A job as motion of winches for Klipper: ``kinematics: none``, a manual stepper for each winch, and a G-code file.

Each line moves the winches, in degrees of their drums, and a virtual X Y Z, the nozzle's place. Klipper plans by X Y Z,
so that it does not stop between the pieces of a straight line, as it does where extra axes move alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.exchange.motion_export.gcode_lines import extent_notes, extruder_words, motion_lines
from cablewright.exchange.motion_export.non_motion_gcode import Beside
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import printable
from cablewright.printing.job import Job
from cablewright.robot import Robot
from cablewright.studies.checks.winch_angles import WinchPath

LETTERS: Final = "ABCDHIJKLOPQRSUVW"
"""Axes of G-code that winches take; X Y Z E F N, G, M and T have a meaning of their own."""

SQUARE_CORNER: Final = 5.0  # mm/s, Klipper's default


@dataclass(frozen=True)
class Stepper:
    """The motor of a winch, as far as Klipper needs it. ``ratio``: turns of the motor for one of the drum."""

    full_steps: int = 200
    microsteps: int = 16
    ratio: float = 1.0

    @property
    def microstep(self) -> float:
        """Angle of a microstep at the drum, rad."""
        return math.tau / (self.full_steps * self.microsteps * self.ratio)


def printer_config(robot: Robot, job: Job, stepper: Stepper) -> str:
    """Return the sections of a ``printer.cfg``; pins are the machine's own. Raises `InputError` for too many lines."""
    letters = LETTERS[: robot.winches]
    text = (
        "# Winches as manual steppers, in degrees of the drum. Add [mcu], pins, and the extruder of the machine.\n"
        "[printer]\nkinematics: none\n"
        f"max_velocity: {1e3 * max(job.motion.print_speed, job.motion.travel_speed):g}\n"
        f"max_accel: {1e3 * job.motion.acceleration:g}\nsquare_corner_velocity: {SQUARE_CORNER:g}\n"
    )
    for letter, line in zip(letters, robot.winch_lines, strict=True):
        text += (
            f"\n# line {line.name!r}, axis {letter}\n[manual_stepper winch_{letter.lower()}]\n"
            "#step_pin:\n#dir_pin:\n#enable_pin:\n"
            f"microsteps: {stepper.microsteps}\nfull_steps_per_rotation: {stepper.full_steps}\n"
            f"gear_ratio: {stepper.ratio!r}:1\nrotation_distance: 360\n"
        )
    return text


def klipper_job(robot: Robot, job: Job, path: WinchPath, besides: Beside) -> str:
    """Return the G-code of a job: its motion, and the commands *besides* motion of its own file, as of heaters."""
    letters = LETTERS[: robot.winches]
    start = path.samples.positions[0]
    x, y, z = (f"{1e3 * each:.4f}" for each in start)
    corner = _corner_velocity(path, job)
    mode, zero, extruded = extruder_words(besides)
    text = f"; {printable(job.name)} on {printable(robot.name)}, for Klipper\n"
    text += extent_notes(path, letters, robot, extruded)
    text += "; the nozzle is at the first point, by hand or by homing; drums count from there\n"
    for letter in letters:
        name = f"winch_{letter.lower()}"
        text += f"MANUAL_STEPPER STEPPER={name} SET_POSITION=0\n"
        text += f"MANUAL_STEPPER STEPPER={name} GCODE_AXIS={letter} INSTANTANEOUS_CORNER_VELOCITY={corner:.4f}\n"
    text += f"G90\n{mode}\nG92 X{x} Y{y} Z{z}{zero}\n"
    text += "".join(motion_lines(path, letters, besides, extruder=True))
    return text + "".join(f"MANUAL_STEPPER STEPPER=winch_{letter.lower()} GCODE_AXIS=\n" for letter in letters)


def _corner_velocity(path: WinchPath, job: Job) -> float:
    """Return the instantaneous change of a winch's speed, deg/s, at which no winch slows down a straight line.

    It is the most that the ratio of winch to nozzle changes between two pieces of one move, times the largest speed.
    """
    rates = rates_of(path)
    move = path.samples.move[1:]
    same = (move[1:] == move[:-1])[:, None]
    change = float(np.max(np.abs(np.diff(rates, axis=0)) * same, initial=0.0))
    speed = 1e3 * max(job.motion.print_speed, job.motion.travel_speed)
    corner = float(np.abs(rates).max(initial=0.0)) * SQUARE_CORNER
    return max(1.01 * change * speed, corner, 1e-3)


def rates_of(path: WinchPath) -> Array:
    """Return how far each winch turns per distance of the nozzle (k - 1, m), deg/mm."""
    way = 1e3 * np.diff(path.samples.distance)
    return np.asarray(np.degrees(np.diff(path.turns, axis=0)) / way[:, None])
