"""Values that a calibration plan gives instead of the robot file, and the standard deviation of each."""

from __future__ import annotations

from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.unknowns import column_of, line_index
from cablewright.foundation.arrays import Array
from cablewright.robot import Robot


def put_known(robot: Robot, lines: Array, plan: CalibrationPlan) -> None:
    """Write the values of a plan into the numbers *lines* (m, COLUMNS).

    Raises `InputError` for a line that the robot does not have.
    """
    for at, each in enumerate(plan.known):
        names = each.lines or [line.name for line in robot.lines]
        which = [line_index(robot, name, f"known[{at}]") for name in names]
        if each.value is not None:
            lines[which, column_of(each.name)] = each.value


def known_deviation(plan: CalibrationPlan, name: str, line: str | None, otherwise: float) -> float:
    """Return the standard deviation of a number by the plan, the largest of several lines, or *otherwise*."""
    given = (each.deviation for each in plan.known if each.is_of(name, line) and each.deviation is not None)
    return max(given, default=otherwise)


def uncertain(plan: CalibrationPlan) -> tuple[str, ...]:
    """Return the names of the known numbers of a plan whose standard deviation is not 0."""
    return tuple(each.name for each in plan.known if each.deviation)
