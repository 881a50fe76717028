"""The numbers of each line, and what the robot file does not tell about them."""

from __future__ import annotations

import numpy as np

from cablewright.apps.quantities import allowed_range, quantity
from cablewright.apps.report.digest import Digest, median
from cablewright.apps.report.page import Html, short_name, table
from cablewright.arrays import Array
from cablewright.robot import Robot


def line_table(digest: Digest) -> Html:
    """Return one row for each line; a column that has no value for any line is left out."""
    check, used = digest.check, digest.check.statics.lines
    lines = check.robot.lines
    columns: list[tuple[str, list[str]]] = [
        ("line", [short_name(line.name) for line in lines]),
        ("lowest tension", _written(np.fmin.reduce(used.lowest_tension, axis=0), "N")),
        ("median tension", _written(median(check.statics.tensions), "N")),
        ("highest tension", _written(np.fmax.reduce(used.highest_tension, axis=0), "N")),
        ("allowed tension", [allowed_range(*line.tension_limits, "N") for line in lines]),
        ("greatest length", _written(np.fmax.reduce(check.lengths, axis=0), "m")),
        ("highest speed", _written(np.fmax.reduce(np.abs(used.winch_speed), axis=0), "m/s")),
        ("highest torque", _written(np.fmax.reduce(used.winch_torque, axis=0), "N m")),
        ("swing", _ranges(used.swing)),
        ("lever", _ranges(used.lever)),
    ]
    kept = [(name, values) for name, values in columns if any(values)]
    rows = zip(*(values for _, values in kept), strict=True)
    return table([name for name, _ in kept], rows, numbers=range(1, len(kept)))


def unknowns(digest: Digest) -> list[str]:
    """Return what could not be judged, and what in the robot file is missing for it."""
    check, robot = digest.check, digest.check.robot
    told = []
    if np.isnan(check.statics.lines.winch_torque).all():
        told.append("Winch torque is not known: the robot file gives no drum radius.")
    elif not _gives(robot, "winch", "max_torque"):
        told.append("Winch torque has no limit to be judged by: the robot file gives no max_torque.")
    if not _gives(robot, "winch", "max_speed"):
        told.append("Winch speed has no limit to be judged by: the robot file gives no max_speed.")
    if not _gives(robot, "winch", "capacity"):
        told.append("Cable length has no limit to be judged by: the robot file gives no capacity.")
    kinds = {line.sheave.kind for line in robot.lines}
    if kinds != {"eyelet"} and not _gives(robot, "sheave", "swing"):
        told.append("Swing of the sheaves has no limit to be judged by: the robot file gives no swing.")
    if "universal-joint" in kinds and not _gives(robot, "sheave", "lever_range"):
        told.append("Lever angles have no limit to be judged by: the robot file gives no lever_range.")
    return told


def _gives(robot: Robot, part: str, key: str) -> bool:
    """Whether any line's part has a value for the key."""
    return any(getattr(getattr(line, part), key, None) is not None for line in robot.lines)


def _written(values: Array, unit: str) -> list[str]:
    return ["" if np.isnan(value) else quantity(float(value), unit) for value in values]


def _ranges(values: Array) -> list[str]:
    low, high = np.fmin.reduce(values, axis=0), np.fmax.reduce(values, axis=0)
    return [
        " to ".join(pair) if all(pair) else "" for pair in zip(_written(low, "rad"), _written(high, "rad"), strict=True)
    ]
