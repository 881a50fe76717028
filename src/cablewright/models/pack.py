"""Conversion of a robot with its chosen physics to arrays for the kernels."""

from __future__ import annotations

import math
from itertools import compress

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.kernels import layout
from cablewright.kernels.layout import Packed
from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
from cablewright.models.packed_views import LineNumbers, PlatformNumbers
from cablewright.robot import Eyelet, Line, Platform, PlatformPulley, Pulley, RigidPlatform, Robot, Swivel
from cablewright.robot.dead_span import DeadSpan
from cablewright.robot.direction import unit_vector
from cablewright.robot.mount import compliance_matrix


def pack(robot: Robot, fidelity: Fidelity, tension_limits: tuple[float, float] | None = None) -> Packed:
    """Return the arrays of *robot* under *fidelity*; *tension_limits* (N) replace those of every line.

    Raises `InputError` where the fidelity requires hardware that a line does not have, or a lever has no dead span.
    """
    lines = LineNumbers(np.zeros((robot.m, layout.COLUMNS)))
    for own, line in zip(map(LineNumbers, lines.array), robot.lines, strict=True):
        law = fidelity.sheave_of(line.sheave.kind, line.name)
        _pack_geometry(own, line, law, fidelity.sheave is not SheaveLaw.EYELET)
        if line.platform_sheave is not None and fidelity.sheave is not SheaveLaw.EYELET:
            own.end_radius = line.platform_sheave.radius
            own.end_axis = unit_vector(line.platform_sheave.axis)
            if isinstance(line.platform_sheave, PlatformPulley):
                own.end_arrival = line.platform_sheave.end_of_arc
        _pack_cable(own, line, fidelity.cable, robot.scene.gravity)
        own.counterweight = (line.counterweight or 0.0) * robot.scene.gravity / line.cables
        if line.exit_compliance is not None and fidelity.cable is not CableLaw.RIGID:
            (xx, xy, xz), (_, yy, yz), (_, _, zz) = compliance_matrix(line.exit_compliance)
            own.mount = xx, yy, zz, xy, xz, yz
        own.tension_limits = tension_limits or line.tension_limits
        own.breaking_load = line.cable.breaking_load
    platform = PlatformNumbers(np.zeros(layout.PLATFORM))
    _pack_platform(platform, robot.platform, robot.scene.gravity)
    platform.massless = (lines.weight == 0.0).any()
    general = robot.platform.plane is not None or bool(lines.guide.any())
    return Packed(robot.n, lines.array, platform.array, general or None)


def guided_lines(robot: Robot) -> Array | None:
    """Return the packed rows (m, ..) of the lines that `kernels.fitting.guided_path` draws, others 0; None without any.

    These are pulleys in a fixed plane, winches aside of the swivel's axis, and sheaves on the platform.
    """
    which = [isinstance(x.sheave, Pulley) or x.is_aside or x.platform_sheave is not None for x in robot.lines]
    if not any(which):
        return None
    rows = np.zeros((robot.m, layout.COLUMNS))
    alone = robot.model_copy(update={"lines": tuple(compress(robot.lines, which))})
    rows[which] = pack(alone, Fidelity(CableLaw.RIGID)).lines
    return rows


def pack_rows(
    robot: Robot,
    packed: Packed,
    *,
    retraction: Array | None = None,
    preferred: Array | None = None,
    exit_points: Array | None = None,
    wrenches: Array | None = None,
) -> Packed:
    """Return *packed*, the arrays of *robot*, as a batch of one row, or of N rows where values differ by row.

    *retraction* (N,): the platform's retraction length, m; *preferred* (N, m): tensions, N, to which inverse solutions
    stay near; *exit_points* (N, m, 3): m, world, instead of the robot's; winch exit points move with them; *wrenches*
    (N, 6): N and N m, world, on the platform beside its own. Raises `InputError` for a retraction that the platform
    does not have.
    """
    differing = (given for given in (retraction, preferred, exit_points, wrenches) if given is not None)
    rows = max((len(given) for given in differing), default=1)
    lines = LineNumbers(np.repeat(packed.lines[None], rows, axis=0))
    if preferred is not None:
        lines.preferred_tension = preferred
    if exit_points is not None:
        lines.exit_point = exit_points
    if retraction is not None and len(retraction):
        _retract(robot, lines, retraction)
    platform = PlatformNumbers(np.repeat(packed.platform[None], rows, axis=0))
    if wrenches is not None:
        platform.wrench = platform.wrench + wrenches
    return packed._replace(lines=lines.array, platform=platform.array)


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


def _pack_geometry(own: LineNumbers, line: Line, law: SheaveLaw, wheels: bool) -> None:
    """Points, sheave and number of unknowns of the line; without *wheels* those before its sheave are points."""
    own.exit_point = line.exit_point
    own.platform_point = line.platform_point
    own.dead_length = line.dead_length
    own.side = 1.0
    own.unknowns = 3
    own.spans = line.advantage
    own.pulls = line.advantage * line.cables
    sheave = line.sheave
    if not line.in_plane:
        _pack_out_of_plane(own, line, law, wheels)
        return
    if law is not SheaveLaw.EYELET and not isinstance(sheave, Eyelet | Pulley):
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


def _pack_out_of_plane(own: LineNumbers, line: Line, law: SheaveLaw, wheels: bool) -> None:
    """Guides of a line that no vertical plane holds; its points and spans are packed."""
    sheave, exit_point = line.sheave, np.array(line.exit_point)
    own.guide = layout.EYELET
    if line.winch_exit is not None:
        way = line.dead_span(wheels)
        _pack_dead_span(own, way)
        own.arrival = np.array(way.last.start) - exit_point
        if isinstance(sheave, Pulley) and law is not SheaveLaw.EYELET:
            own.guide, own.axis, own.radius = layout.PULLEY, unit_vector(sheave.axis), sheave.radius
            own.arrival = (np.array(way.last.end) - exit_point) / sheave.radius
    if isinstance(sheave, Swivel) and law is not SheaveLaw.EYELET:
        own.guide, own.axis = layout.SWIVEL, unit_vector(sheave.axis)
        own.radius = own.lever = sheave.radius
        own.side = 1.0 if sheave.wrap == "over" else -1.0
        if line.is_aside:
            own.guide = layout.ASIDE
            own.dead_span = own.dead_span - float(np.linalg.norm(own.arrival)) if line.guides else 0.0


def _pack_dead_span(own: LineNumbers, way: DeadSpan) -> None:
    """Lengths and heights of the cable from the winch to where it comes to its sheave; those of wheels are exact."""
    begin, end, length = way.first.start[2], way.last.end[2], way.length
    low, high = way.heights
    own.unknowns, own.dead_span = 4, length
    own.winch_height = begin - end
    own.winch_rise = (begin - end) / length
    own.mean_rise = 2.0 * (way.mean_height - end) / length
    own.rises = (low - end) / length, (high - end) / length


def _pack_cable(own: LineNumbers, line: Line, law: CableLaw, gravity: float) -> None:
    """Weight and compliances under the cable law."""
    if law is CableLaw.CATENARY:
        own.weight = line.cable.linear_density * gravity
    if law is not CableLaw.RIGID:
        compliance = 1.0 / line.cable.stiffness
        own.free_compliance = compliance
        own.dead_compliance = compliance if line.dead_elastic else 0.0
        own.arc_compliance = compliance if line.arc_elastic else 0.0
        own.spring = 0.0 if line.spring is None else line.cables / line.spring
