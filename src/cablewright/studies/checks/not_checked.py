"""Questions that a check leaves open: switched off, without numbers in the files, or outside the model."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Final

import numpy as np

from cablewright.models.inertia import with_inertia
from cablewright.models.support_table import Capability, cells
from cablewright.robot import Robot
from cablewright.robot.uncertainty import Uncertainty
from cablewright.studies.checks.job_samples import JobPath
from cablewright.studies.checks.line_vibration import slow_lines
from cablewright.studies.checks.path_statics import PathStatics

SKIPPABLE: Final = {
    "interference": "interference of lines",
    "expected-error": "expected error",
}
"""Parts of a check that can be switched off, and their names."""

_LIMITS: Final = (
    ("winch torque", "winch", "max_torque"),
    ("winch speed", "winch", "max_speed"),
    ("cable length", "winch", "capacity"),
    ("swing of the sheave", "sheave", "swing"),
    ("lever angle", "sheave", "lever_range"),
)
_LEFT_OUT: Final = (
    "platform and nozzle against the part and the frame",
    "vibration of cables between their ends, and of the frame",
    "inertia of drums and motors, and their lag",
    "friction, hysteresis and backlash",
    "wind",
)


def not_checked(
    robot: Robot, path: JobPath, uncertain: Uncertainty, statics: PathStatics, skip: Collection[str]
) -> list[str]:
    """Return the questions that a check of *robot* along a *path* leaves open."""
    found = [f"{what}: switched off" for name, what in SKIPPABLE.items() if name in skip]
    found += _without_limit(robot)
    stiff = [line.name for line in robot.lines if line.exit_compliance is None]
    found += _lacks(robot, "mounts of exit points that give", "exit_compliance", stiff)
    if all(entry.name != "creep_compliance" for entry in uncertain.parameters):
        found.append("creep of cables: the uncertainty gives no creep_compliance")
    if "interference" not in skip:
        found += _without_shape(robot)
    singular = int(np.isnan(statics.displacement).sum())
    if singular:
        what = "motion of the platform" + ("" if "expected-error" in skip else " and expected error")
        found.append(f"{what} at {singular} of {len(statics.displacement)} samples: no regular equilibrium")
    if robot.damping.is_assumed:
        found.append(f"damping of the platform: the robot file gives no dynamics.damping_ratio: {robot.damping}")
    if with_inertia(robot) is not robot:
        found.append("inertia of the platform: the robot file gives no platform.inertia: mass at the platform points")
    if robot.platform.may_lift:
        found.append("tipping on the plane")
    found += slow_lines(robot, path.poses, path.retraction)
    found += [f"{cell.because}: {cell.instead}" for _, cell in cells(robot, Capability.CHECK)]
    return [*found, *_LEFT_OUT]


def _without_limit(robot: Robot) -> Iterator[str]:
    """Yield the limits that the robot file does not give, for lines that could have them."""
    for subject, part, key in _LIMITS:
        able = [line for line in robot.lines if key in type(getattr(line, part)).model_fields]
        able = [line for line in able if part != "winch" or line.counterweight is None]
        lacking = [line.name for line in able if getattr(getattr(line, part), key) is None]
        yield from _lacks(robot, subject, f"{part}.{key}", lacking)
    able = [line for line in robot.lines if line.winch.max_torque is not None]
    lacking = [line.name for line in able if line.winch.drum_radius is None]
    yield from _lacks(robot, "winch torque", "winch.drum_radius", lacking)


def _lacks(robot: Robot, subject: str, key: str, lines: list[str]) -> Iterator[str]:
    if lines:
        whose = "" if len(lines) == robot.m else f" of line {', '.join(lines)}"
        yield f"{subject}{whose}: the robot file gives no {key}"


def _without_shape(robot: Robot) -> Iterator[str]:
    """Yield what lines may touch and the robot file does not describe."""
    if not robot.platform.boxes:
        yield "lines against the platform: the robot file gives no platform.boxes"
    if not robot.scene.beams:
        yield "lines against the frame: the robot file gives no scene.beams"
    thin = [line for line in robot.lines if line.cable.diameter is None]
    if thin:
        assumed = max(1e3 * line.cable.thickness for line in thin)
        subject = f"thickness of cables, assumed up to {assumed:.3g} mm by their mass"
        yield from _lacks(robot, subject, "cable.diameter", [line.name for line in thin])
