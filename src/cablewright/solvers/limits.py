"""Is this pose allowed: how each line stands against its own hardware. Angles, speeds and torques of solved lines."""

from __future__ import annotations

import math

import numpy as np

from cablewright.arrays import Array
from cablewright.models.statics import Equilibrium
from cablewright.robot import Robot


def swing_angles(equilibrium: Equilibrium) -> Array:
    """Azimuth of each line's sheave from where its mounting faces, rad in (-pi, pi]; NaN where it is not told."""
    robot = equilibrium.model.robot
    angles = np.full(equilibrium.lengths.shape, np.nan)
    points = equilibrium.platform_points
    for i, line in enumerate(robot.lines):
        facing = getattr(line.sheave, "facing", None)
        if facing is None:
            continue
        point = points[..., i, :2] - np.asarray(line.exit_point[:2])
        turned = np.arctan2(point[..., 1], point[..., 0]) - facing
        angles[..., i] = np.arctan2(np.sin(turned), np.cos(turned))
    return angles


def lever_angles(equilibrium: Equilibrium) -> Array:
    """Angle of each line's lever above the horizontal, rad; NaN where the model has no lever."""
    return np.where(equilibrium.lines.has_lever, equilibrium.line_states.lever_angle, np.nan)


def sheave_clearances(equilibrium: Equilibrium) -> Array:
    """Distance of the nearest platform point from all that a line's sheave and lever can sweep, m.

    That is the ball about its exit point which reaches to the sheave's far rim. NaN where the model has no sheave.
    """
    lines = equilibrium.model.lines
    exits, swept = lines.exit_point, lines.lever + lines.radius
    points = equilibrium.platform_points
    nearest = np.min([np.linalg.norm(points[..., j, None, :] - exits, axis=-1) for j in range(len(exits))], axis=0)
    return np.where(lines.radius > 0.0, nearest - swept, np.nan)


def winch_torques(equilibrium: Equilibrium) -> Array:
    """Torque that holds each drum, N m; NaN where the drum's radius is not known."""
    return equilibrium.winch_tensions * _drum_radii(equilibrium.model.robot)


def _drum_radii(robot: Robot) -> Array:
    radii = [line.winch.drum_radius for line in robot.lines]
    return np.array([math.nan if radius is None else radius for radius in radii])
