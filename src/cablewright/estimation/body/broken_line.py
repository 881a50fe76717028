"""Equilibrium of a platform after one of its lines breaks: where it hangs on those that remain."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.models.rotation import angle_between
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.solvers.forward import solve_forward


class Hanging(NamedTuple):
    """A possible equilibrium of the platform on the lines that remain after one broke."""

    pose: Array  # (6,) m and rad
    tensions: Array  # (m,) N; 0 of the broken line


def hanging_without(robot: Robot, lengths: Array, line: int, pose: Array, retraction: float) -> list[Hanging]:
    """Return poses at which the platform of *robot* may hang without that *line*, searched near *pose* (6,) and afar.

    *lengths* (m,), m; *retraction*: m, NaN for a platform that does not retract.
    """
    there = robot if np.isnan(retraction) else robot.retracted(retraction)
    lines = tuple(each for i, each in enumerate(there.lines) if i != line)
    platform = there.platform
    if there.retraction is not None:  # it stands; the broken line may be one that moves with it
        platform = platform.model_copy(update={"retraction": None})
    rest = Model(there.model_copy(update={"lines": lines, "platform": platform}))
    left = np.delete(lengths, line)
    solved = (solve_forward(rest, left, guess=pose), solve_forward(rest, left))
    hangs = (Hanging(each.pose, np.insert(each.tensions, line, 0.0)) for each in solved)
    return [each for each in hangs if np.isfinite(each.pose).all()]


def sentence(robot: Robot, line: int, pose: Array, found: Hanging | None) -> str:
    """Return a warning that a *line* is lost at *pose* (6,), with the pose *found* at which the platform hangs."""
    name = robot.lines[line].name
    if found is None:
        return f"line {name} pulls nothing: it broke, or left its sheave; no equilibrium of the other lines is found"
    x, y, z = found.pose[:3].tolist()
    turned = np.degrees(float(angle_between(pose[3:], found.pose[3:])))
    moved = 1e3 * float(np.linalg.norm(found.pose[:3] - pose[:3]))
    others = np.delete(found.tensions, line)
    return (
        f"line {name} pulls nothing: it broke, or left its sheave; the platform hangs on the others at "
        f"{x:.3f}, {y:.3f}, {z:.3f} m, {moved:.0f} mm and "
        f"{turned:.1f} deg away, with tensions of {others.min():.0f} to {others.max():.0f} N"
    )
