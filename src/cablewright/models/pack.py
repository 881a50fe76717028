"""A robot under one fidelity as arrays for the kernels."""

from __future__ import annotations

import math

import numpy as np

from cablewright.arrays import Array
from cablewright.errors import InputError
from cablewright.kernels import layout
from cablewright.kernels.layout import Packed
from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
from cablewright.models.packed_views import LineNumbers, PlatformNumbers
from cablewright.robot import Line, Platform, RigidPlatform, Robot


def pack(robot: Robot, fidelity: Fidelity, tension_limits: tuple[float, float] | None = None) -> Packed:
    """Return the arrays of *robot* under *fidelity*; *tension_limits* (N) replace those of every line.

    Raises `InputError` where the fidelity requires hardware that a line does not have, or a lever has no dead span.
    """
    lines = LineNumbers(np.zeros((robot.m, layout.COLUMNS)))
    for own, line in zip(map(LineNumbers, lines.array), robot.lines, strict=True):
        _pack_geometry(own, line, fidelity.sheave_of(line.sheave.kind, line.name))
        _pack_cable(own, line, fidelity.cable, robot.scene.gravity)
        own.tension_limits = tension_limits or line.tension_limits
        own.breaking_load = line.cable.breaking_load
    platform = PlatformNumbers(np.zeros(layout.PLATFORM))
    _pack_platform(platform, robot.platform, robot.scene.gravity)
    platform.massless = (lines.weight == 0.0).any()
    return Packed(robot.n, lines.array, platform.array)


def pack_rows(
    robot: Robot,
    packed: Packed,
    *,
    retraction: Array | None = None,
    preferred: Array | None = None,
    exit_points: Array | None = None,
) -> Packed:
    """Return *packed*, the arrays of *robot*, as a batch of one row, or of N rows where values differ by row.

    *retraction* (N,): the platform's retraction length, m; *preferred* (N, m): tensions, N, to which inverse solutions
    stay near; *exit_points* (N, m, 3): m, world, instead of the robot's; winch exits move with them. Raises
    `InputError` for a retraction that the platform does not have.
    """
    differing = (given for given in (retraction, preferred, exit_points) if given is not None)
    rows = max((len(given) for given in differing), default=1)
    lines = LineNumbers(np.repeat(packed.lines[None], rows, axis=0))
    if preferred is not None:
        lines.preferred_tension = preferred
    if exit_points is not None:
        lines.exit_point = exit_points
    if retraction is not None and len(retraction):
        _retract(robot, lines, retraction)
    return Packed(packed.freedoms, lines.array, np.repeat(packed.platform[None], rows, axis=0))


def _retract(robot: Robot, lines: LineNumbers, lengths: Array) -> None:
    """Move the platform points of the retraction to its *lengths* (N,), m."""
    robot.retraction_to(float(lengths.max()))
    retraction = robot.retraction_to(float(lengths.min()))
    moving = [i for i, line in enumerate(robot.lines) if line.name in retraction.lines]
    by = (lengths - retraction.length)[:, None] * np.asarray(retraction.along)
    lines.platform_point[:, moving] += by[:, None]


def _pack_platform(own: PlatformNumbers, platform: Platform, gravity: float) -> None:
    """Weight, centre of mass, external wrench, and the plane."""
    own.weight = platform.mass * gravity
    own.wrench[:3] = platform.force
    if isinstance(platform, RigidPlatform):
        own.centre_of_mass = platform.centre_of_mass
        own.wrench[3:] = platform.moment
    if platform.plane is not None:
        own.held = 1.0
        own.normal = platform.plane.across
        own.plane_distance = platform.plane.distance


def _pack_geometry(own: LineNumbers, line: Line, law: SheaveLaw) -> None:
    """Points, sheave and number of unknowns of the line."""
    own.exit_point = line.exit_point
    own.platform_point = line.platform_point
    own.dead_length = line.dead_length
    own.side = 1.0
    own.unknowns = 3
    own.spans = line.advantage
    own.pulls = line.advantage * line.cables
    sheave = line.sheave
    if law is not SheaveLaw.EYELET and sheave.kind != "eyelet":
        own.radius = sheave.radius
        own.lever = sheave.radius
        own.side = 1.0 if sheave.wrap == "over" else -1.0
    if line.winch_exit is not None:
        away = [c - a for c, a in zip(line.winch_exit, line.exit_point, strict=True)]
        own.winch_distance = math.hypot(away[0], away[1])
        own.winch_height = away[2]
        own.unknowns = 4
        if law is SheaveLaw.EYELET:
            own.side = 1.0 if away[2] < 0.0 else -1.0
            own.unknowns = 5 if own.winch_distance > 0.0 else 4
    if law is SheaveLaw.UNIVERSAL_JOINT and sheave.kind == "universal-joint":
        if line.winch_exit is None:
            raise InputError(f"line {line.name!r}: a universal joint needs winch_exit: the dead span holds its lever")
        own.lever = sheave.lever
        own.lever_moment = sheave.lever_weight * sheave.lever_mass_centre
        own.unknowns = 6


def _pack_cable(own: LineNumbers, line: Line, law: CableLaw, gravity: float) -> None:
    """Weight and compliances under the cable law."""
    if law is CableLaw.CATENARY:
        own.weight = line.cable.linear_density * gravity
    if law is not CableLaw.RIGID:
        compliance = 1.0 / line.cable.stiffness
        own.free_compliance = compliance
        own.dead_compliance = compliance if line.dead_elastic else 0.0
        own.arc_compliance = compliance if line.arc_elastic else 0.0
