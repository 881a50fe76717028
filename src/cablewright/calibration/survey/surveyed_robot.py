"""A robot with the exit points and winch exits of a survey."""

from __future__ import annotations

import math
from typing import Any, Final

from cablewright.arrays import Array
from cablewright.calibration.survey.result import Exit, Survey
from cablewright.errors import InputError
from cablewright.models.support import Capability, require
from cablewright.robot.line import Line
from cablewright.robot.robot import Robot
from cablewright.robot.sheave import Eyelet
from cablewright.units import Vec3
from cablewright.validation import validated

_DIGITS: Final = 5  # of a metre: 0.01 mm is far below the accuracy of a survey
_OFF_AXIS: Final = 5e-3  # m: horizontal distance of a winch from its swivel's axis that needs a note
_MOVED: Final = 0.3  # m: an exit point that moves by more is in another frame, or of another line


def surveyed(robot: Robot, found: Survey) -> tuple[Robot, tuple[str, ...]]:
    """Return the robot with the surveyed exits of its lines, and sentences on what could not be taken over.

    A robot file has the winch exit of a swivelling sheave straight below or above the exit point. Where the winch is
    beside that axis, only its height is taken, with a note. Dead spans that are given as lengths get the surveyed
    lengths. Raises `InputError` if the survey has no exits, for lines out of the plane, or if the resulting robot is
    not valid.
    """
    require(robot, Capability.SURVEY)
    by_line = {exit_.line: exit_ for exit_ in found.exits}
    if not by_line:
        raise InputError(
            "the survey has no exit point and no winch of any line: there is nothing to write into a robot"
        )
    notes: list[str] = []
    missing = [line.name for line in robot.lines if line.name not in by_line]
    if missing:
        notes.append(f"not surveyed, so kept as they are: {', '.join(missing[:8])}")
    lines = [_line(line, by_line[line.name], notes) if line.name in by_line else line for line in robot.lines]
    surveyed = robot.model_dump() | {"lines": [line.model_dump() for line in lines]}
    return validated(Robot, surveyed, "the robot cannot be as surveyed"), tuple(notes)


def _line(line: Line, exit_: Exit, notes: list[str]) -> Line:
    changes: dict[str, Any] = {}
    point = line.exit_point if exit_.exit_point is None else _rounded(exit_.exit_point)
    changes["exit_point"] = point
    moved = math.dist(point, line.exit_point)
    if moved > _MOVED:
        hint = "is the survey's frame the robot's? (origin and wall are set in the plan's [frame])"
        notes.append(f"exit point of {line.name} moves by {moved:.3g} m: {hint}")
    if line.winch_exit is not None:
        changes["winch_exit"] = _winch_exit(line, line.winch_exit, point, exit_, notes)
    elif exit_.winch_exit is not None:
        if line.dead_length and exit_.exit_point is not None:
            changes["dead_length"] = round(exit_.dead_length, _DIGITS)
        else:
            notes.append(f"{line.name} has no dead span in the robot file: its winch is not written")
    return line.model_copy(update=changes)


def _winch_exit(line: Line, before: Vec3, point: Vec3, exit_: Exit, notes: list[str]) -> Vec3:
    place = before if exit_.winch_exit is None else _rounded(exit_.winch_exit)
    if isinstance(line.sheave, Eyelet):
        return place
    off = 0.0 if exit_.winch_exit is None else math.dist(place[:2], point[:2])
    if off > _OFF_AXIS:
        way = math.hypot(off, place[2] - point[2]) - abs(place[2] - point[2])
        notes.append(
            f"winch of {line.name} is {1e3 * off:.0f} mm beside its sheave's axis: only its height is written, which "
            f"makes the dead span {1e3 * way:.2g} mm too short"
        )
    return point[0], point[1], place[2]


def _rounded(place: Array) -> Vec3:
    x, y, z = (round(float(value), _DIGITS) + 0.0 for value in place)
    return x, y, z
