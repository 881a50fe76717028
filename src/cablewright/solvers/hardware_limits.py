"""Quantities of solved lines that the hardware limits: sheave angles, clearances and winch torques."""

from __future__ import annotations

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.models.drum import drum_of
from cablewright.models.shared_winches import drum_mates
from cablewright.models.statics import Equilibrium
from cablewright.robot import Robot


def swing_angles(equilibrium: Equilibrium) -> Array:
    """Return the azimuth of each line's sheave from its mounting's facing, rad in (-pi, pi]; NaN where unknown."""
    lines = equilibrium.model.robot.lines
    facings = np.array([getattr(line.sheave, "facing", None) for line in lines], dtype=np.float64)  # None becomes NaN
    away = equilibrium.platform_points[..., :2] - [line.exit_point[:2] for line in lines]
    turned = np.arctan2(away[..., 1], away[..., 0]) - facings
    return np.asarray(np.arctan2(np.sin(turned), np.cos(turned)))


def lever_angles(equilibrium: Equilibrium) -> Array:
    """Return the angle of each line's lever above the horizontal, rad; NaN where the model has no lever."""
    return np.where(equilibrium.lines.has_lever, equilibrium.line_states.lever_angle, np.nan)


def sheave_clearances(equilibrium: Equilibrium) -> Array:
    """Return the distance of the nearest platform point from the region that each line's sheave and lever can reach, m.

    This is the ball around its exit point that contains the sheave's far rim. NaN where the model has no sheave.
    """
    lines = equilibrium.model.lines
    exits, swept = lines.exit_point, lines.lever + lines.radius
    points = equilibrium.platform_points
    nearest = np.min([np.linalg.norm(points[..., j, None, :] - exits, axis=-1) for j in range(len(exits))], axis=0)
    return np.where(lines.radius > 0.0, nearest - swept, np.nan)


def winch_torques(equilibrium: Equilibrium) -> Array:
    """Return the torque that holds each drum, N m, against all its cables; NaN where the radius is not known.

    Lines on one drum have its whole torque each, in the direction of their own cable.
    """
    return on_drums(equilibrium.model.robot, equilibrium.winch_tensions * drum_arms(equilibrium))


def on_drums(robot: Robot, torques: Array) -> Array:
    """Return the torque on the drum of each line (..., m), N m, from the torques of single lines.

    Lines on one drum have its sum each.
    """
    found = torques.copy() if robot.sharing else torques
    for i, j, sense in drum_mates(robot):
        found[..., i] += sense * torques[..., j]
    return found


def rise_on_drums(robot: Robot, drop: Array, rise: Array) -> Array:
    """Return the largest rise (..., m), N m, of a drum's torque when tensions may fall and rise.

    *drop* and *rise*: how much the tension of each line's cables may fall and rise. *drop* is at most 0. Lines on one
    drum are taken to change together in the worst way.
    """
    found = rise.copy() if robot.sharing else rise
    for i, j, sense in drum_mates(robot):
        found[..., i] += rise[..., j] if sense > 0.0 else -drop[..., j]
    return found


def drum_arms(equilibrium: Equilibrium) -> Array:
    """Return the torque on each drum per tension of one cable (..., m), m: its radius times the number of cables.

    NaN where the radius is not known. Raises `InputError` for lengths that empty a drum with a build-up.
    """
    lines, lengths = equilibrium.model.robot.lines, equilibrium.lengths
    arms = np.full(lengths.shape, np.nan)
    for i, line in enumerate(lines):
        drum = drum_of(line)
        if drum is not None:
            arms[..., i] = line.cables * (drum.radii(lengths[..., i]) if drum.build_up > 0.0 else drum.radius)
    return arms
