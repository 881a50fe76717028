"""Ends of lines that give, by mounts of exit points and springs, and cables that creep, in a calibration.

Lines that stretch count mounts and springs in their equilibria. Straight ones count them to first order by measured
tensions, and there is no calibration without these. Creep is of the time under a load, which data do not tell.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cablewright.arrays import Array
from cablewright.calibration.measured import Measured
from cablewright.errors import InputError
from cablewright.models.creep import hour_compliance
from cablewright.robot import Line, Robot


def on_stiff_mounts(robot: Robot) -> Robot:
    """Return the robot without what mounts of its exit points give."""
    return _with_compliance(robot, [None] * robot.m)


def with_mounts(robot: Robot) -> Robot:
    """Return the robot with a compliance of each mount: 0 where the file says nothing, and what it says elsewhere."""
    return _with_compliance(
        robot, [0.0 if line.exit_compliance is None else line.exit_compliance for line in robot.lines]
    )


def _with_compliance(robot: Robot, to: list[object]) -> Robot:
    lines = (line.model_copy(update={"exit_compliance": each}) for line, each in zip(robot.lines, to, strict=True))
    return robot.model_copy(update={"lines": tuple(lines)})


def require_tensions(robot: Robot, measured: Measured) -> None:
    """Raise `InputError` for straight lines whose ends give, where nothing measured by which forces."""
    if measured.tensions is not None:
        return
    for line in robot.lines:
        if line.gives_by:
            raise InputError(
                f"{measured.origin}: no column f_1: line {line.name!r} has {line.gives_by}, and straight lines tell by "
                "measured tensions only how far that gives; measure them, or calibrate with --cable elastic"
            )


def creep_share(line: Line) -> float:
    """Return the creep of a line's cable after an hour under a load, as the file has it, over its stretch by EA."""
    return hour_compliance(line.cable.creep) * line.cable.stiffness


def of_creep(robot: Robot, stretch: Array | None) -> Iterator[str]:
    """Yield a sentence on creep that the file has; *stretch* (N, m): of the lines by EA, m, None: nothing tells it."""
    shares = np.array([creep_share(line) for line in robot.lines])
    if not shares.any():
        return
    size = ""
    if stretch is not None:
        longer = (stretch * shares).max(axis=0)
        worst = int(np.argmax(longer))
        line, most = robot.lines[worst].name, 1e3 * longer[worst]
        size = f": an hour under its load makes line {line} longer by up to {most:.3g} mm"
    yield f"cable.creep of the robot file is not counted in lengths, for data tell no times{size}"
