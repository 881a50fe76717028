"""A robot under one fidelity as the arrays that kernels take."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cablewright.errors import InputError
from cablewright.kernels import layout
from cablewright.kernels.layout import Packed
from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
from cablewright.robot import Line, Platform, RigidPlatform, Robot

__all__ = ["pack", "pack_rows"]

Array = NDArray[np.float64]


def pack(robot: Robot, fidelity: Fidelity, tension_limits: tuple[float, float] | None = None) -> Packed:
    """Arrays of *robot* under *fidelity*; *tension_limits* (N) replace those of every line.

    Raises `InputError` where the fidelity asks for hardware that is not there, or for a lever without the dead span
    that holds it.
    """
    lines = np.zeros((robot.m, layout.COLUMNS))
    for row, line in zip(lines, robot.lines, strict=True):
        _pack_geometry(row, line, fidelity.sheave_of(line.sheave.kind, line.name))
        _pack_cable(row, line, fidelity.cable, robot.scene.gravity)
        row[[layout.TENSION_MIN, layout.TENSION_MAX]] = tension_limits or line.tension_limits
        row[layout.BREAKING] = line.cable.breaking_load
    platform = np.zeros(layout.PLATFORM)
    _pack_platform(platform, robot.platform, robot.scene.gravity)
    platform[layout.MASSLESS] = float((lines[:, layout.WEIGHT] == 0.0).any())
    return Packed(robot.n, lines, platform)


def pack_rows(
    robot: Robot,
    packed: Packed,
    *,
    retraction: Array | None = None,
    preferred: Array | None = None,
    exit_points: Array | None = None,
) -> Packed:
    """*packed*, the arrays of *robot*, as a batch: one row for all, or one for each where something differs by row.

    *retraction* (N,) is the platform's retraction length, m; *preferred* (N, m) are the tensions, N, that inverse
    solutions stay near to; *exit_points* (N, m, 3), m, take the place of the robot's, and winch exits move with them.
    Raises `InputError` for a retraction that the platform does not have.
    """
    differing = (given for given in (retraction, preferred, exit_points) if given is not None)
    rows = max((len(given) for given in differing), default=1)
    lines = np.repeat(packed.lines[None], rows, axis=0)
    if preferred is not None:
        lines[:, :, layout.PREFERRED] = preferred
    if exit_points is not None:
        lines[:, :, layout.EXIT_X : layout.EXIT_Z + 1] = exit_points
    if retraction is not None:
        _retract(robot, lines, retraction)
    return Packed(packed.freedoms, lines, np.repeat(packed.platform[None], rows, axis=0))


def _retract(robot: Robot, lines: NDArray[np.float64], lengths: NDArray[np.float64]) -> None:
    """Move the platform points that move with the retraction."""
    robot.retraction_to(float(lengths.max()))
    drawn = robot.retraction_to(float(lengths.min()))
    moving = [i for i, line in enumerate(robot.lines) if line.name in drawn.lines]
    by = (lengths - drawn.length)[:, None] * np.asarray(drawn.along)
    lines[:, moving, layout.POINT_X : layout.POINT_Z + 1] += by[:, None]


def _pack_platform(row: NDArray[np.float64], platform: Platform, gravity: float) -> None:
    """Weight, centre of mass and external wrench."""
    row[layout.PLATFORM_WEIGHT] = platform.mass * gravity
    row[layout.WRENCH : layout.WRENCH + 3] = platform.force
    if isinstance(platform, RigidPlatform):
        row[layout.MASS_X : layout.MASS_Z + 1] = platform.centre_of_mass
        row[layout.WRENCH + 3 : layout.WRENCH + 6] = platform.moment


def _pack_geometry(row: NDArray[np.float64], line: Line, law: SheaveLaw) -> None:
    """Points, sheave and which unknowns the line has."""
    row[layout.EXIT_X : layout.EXIT_Z + 1] = line.exit_point
    row[layout.POINT_X : layout.POINT_Z + 1] = line.platform_point
    row[layout.DEAD_LENGTH] = line.dead_length
    row[layout.SIDE] = 1.0
    row[layout.UNKNOWNS] = 3
    sheave = line.sheave
    if law is not SheaveLaw.EYELET and sheave.kind != "eyelet":
        row[layout.RADIUS] = sheave.radius
        row[layout.LEVER] = sheave.radius
        row[layout.SIDE] = 1.0 if sheave.wrap == "over" else -1.0
    if line.winch_exit is not None:
        away = [c - a for c, a in zip(line.winch_exit, line.exit_point, strict=True)]
        row[layout.WINCH_X] = math.hypot(away[0], away[1])
        row[layout.WINCH_Z] = away[2]
        row[layout.UNKNOWNS] = 4
        if law is SheaveLaw.EYELET:
            row[layout.SIDE] = 1.0 if away[2] < 0.0 else -1.0
            row[layout.UNKNOWNS] = 5 if row[layout.WINCH_X] > 0.0 else 4
    if law is SheaveLaw.UNIVERSAL_JOINT and sheave.kind == "universal-joint":
        if line.winch_exit is None:
            raise InputError(
                f"line {line.name!r}: a universal joint needs winch_exit, for the dead span holds its lever"
            )
        row[layout.LEVER] = sheave.lever
        row[layout.LEVER_MOMENT] = sheave.lever_weight * sheave.lever_mass_centre
        row[layout.UNKNOWNS] = 6


def _pack_cable(row: NDArray[np.float64], line: Line, law: CableLaw, gravity: float) -> None:
    """Weight and compliances under the cable law."""
    if law is CableLaw.CATENARY:
        row[layout.WEIGHT] = line.cable.linear_density * gravity
    if law is not CableLaw.RIGID:
        compliance = 1.0 / line.cable.stiffness
        row[layout.FREE_COMPLIANCE] = compliance
        row[layout.DEAD_COMPLIANCE] = compliance if line.dead_elastic else 0.0
        row[layout.ARC_COMPLIANCE] = compliance if line.arc_elastic else 0.0
