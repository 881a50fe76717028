"""Ends of a line in a MuJoCo model: its guides on the frame and on the platform, rotated as at a pose.

MuJoCo's wheels have no groove: a cable that runs obliquely slides off to the shorter way, so that a wheel that is free
to swivel turns away from its cable. Here a follower, two slides without weight from the wheel's axis to the cable's
end, keeps the wheel in the cable's plane. It takes no force there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final
from xml.sax.saxutils import quoteattr

import numpy as np

from cablewright.exchange.translation_result import xml_numbers
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import printable
from cablewright.models.rotation import placed
from cablewright.robot import Eyelet, Line, PlatformPulley, Swivel, UniversalJoint
from cablewright.robot.direction import unit_vector

HUNG: Final = 1.0
"""How far below the start of its line a counterweight hangs at the pose, m; it moves up and down, without a stop."""

FEED: Final = 5e-7
"""Length of the tendon before a sheave whose winch is not known, m: as short as MuJoCo finds the side to wrap."""

_SWIVEL: Final = '<joint type="hinge" axis="0 0 1" damping="0.1"/>'
_LIGHT: Final = '<inertial pos="0 0 0" mass="0.01" diaginertia="0.001 0.001 0.001"/>'


@dataclass(frozen=True)
class Mounting:
    """MJCF text of a guide: its body, its part of the tendon, and the equality that keeps it in its plane.

    ``added``: length of the tendon that the line does not have, m; ``hung``: the same, from its counterweight. Joints
    are 0 at the pose.
    """

    body: str
    path: str
    equality: str = ""
    added: float = 0.0
    hung: float = 0.0


def mounting(line: Line, end: Array, lever: float, gravity: float) -> Mounting:
    """Return the guides of a line on the frame when it ends at *end* (3,), m, world, and its counterweight.

    *lever*: angle of its lever, rad; *gravity*: m/s^2, which makes a weight of the lever's mass.
    """
    found = _over_guides(line, end, lever, gravity)
    mass = line.counterweight or 0.0
    if not mass:
        return found
    start = np.array(line.winch_exit or line.exit_point) - [0.0, 0.0, HUNG]
    weight = f'<inertial pos="0 0 0" mass="{mass!r}" diaginertia="0.01 0.01 0.01"/>'
    body = (
        f'    <body pos="{xml_numbers(start)}"><joint type="slide" axis="0 0 1"/>{weight}'
        f"<site name={xml_name('counterweight', line)}/></body>\n"
    )
    return replace(found, body=body + found.body, path=_via("counterweight", line) + found.path, hung=HUNG)


def _over_guides(line: Line, end: Array, lever: float, gravity: float) -> Mounting:
    begin, path, longer = _guides(line)
    if isinstance(line.sheave, Eyelet):
        body = begin + _site("exit", line, line.exit_point)
        return Mounting(body, path + _via("exit", line), added=longer)
    assert isinstance(line.sheave, Swivel | UniversalJoint)  # as `mjcf` requires
    turning = _turning(line, line.sheave, end, lever, gravity or 9.81, begin, path)
    return replace(turning, added=turning.added + longer)


def platform_end(line: Line, pose: Array) -> Mounting:
    """Return the platform's end of a line at a *pose*: a site, or a sheave that swivels and its anchor."""
    sheave = line.platform_sheave
    assert not isinstance(sheave, PlatformPulley)  # as `mjcf` requires
    if sheave is None:
        return Mounting(_site("end", line, line.platform_point, 6), _via("end", line))
    point = np.array(line.platform_point)
    at, *units = placed(pose, [point, *(point + unit for unit in np.eye(3))])
    away = (np.array(units) - at) @ (np.array(line.exit_point) - at)  # in the platform's frame
    x, y, reach, height = _towards(unit_vector(sheave.axis), away)
    anchor = point - FEED * np.array(unit_vector(sheave.axis))
    wheel = _wheel("end wheel", line, sheave.radius, (sheave.radius, 0.0, 0.0), (-1.0, 1.0))
    body = (
        _site("end", line, anchor, 6)
        + f'      <body pos="{xml_numbers(line.platform_point)}" xyaxes="{xml_numbers((*x, *y))}">'
        + f"{_SWIVEL}{_LIGHT}{wheel}{_follower('end follower', line, reach, height)}</body>\n"
    )
    follow = _follow("end follower", "exit", line)
    return Mounting(body, _over("end wheel", line) + _via("end", line), follow, FEED)


def _turning(
    line: Line, sheave: Swivel | UniversalJoint, end: Array, lever: float, gravity: float, begin: str, path: str
) -> Mounting:
    """Return a sheave that turns about its axis, on a lever or not."""
    side = 1.0 if sheave.wrap == "over" else -1.0
    axis = line.swivel_axis
    A = np.array(line.exit_point)
    x, y, reach, height = _towards(axis, end - A)
    added = 0.0
    if line.winch_exit is None:
        begin, added = _site("winch", line, A - side * FEED * np.array(axis)), FEED
        path = _via("winch", line)
    if isinstance(sheave, UniversalJoint):
        mass = f'pos="{sheave.lever_mass_centre!r} 0 0" mass="{sheave.lever_weight / gravity + 1e-6!r}"'
        # at rest the lever points away from its cable, so the cable touches on the side of the joint
        wheel = _wheel("wheel", line, sheave.radius, (sheave.lever, 0.0, 0.0), (-1.0, 0.0))
        joint = f'<joint type="hinge" axis="0 -1 0" ref="{lever!r}" damping="0.1"/>'
        inner = f'{joint}<inertial {mass} diaginertia="0.001 0.001 0.001"/>{wheel}'
        axes = xml_numbers((math.cos(lever), 0.0, math.sin(lever), 0.0, 1.0, 0.0))
        parts = f'{_LIGHT}<body xyaxes="{axes}">{inner}</body>'
    else:
        parts = _LIGHT + _wheel("wheel", line, sheave.radius, (sheave.radius, 0.0, 0.0), (-1.0, side))
    parts += _follower("follower", line, reach, height)
    body = f'    <body pos="{xml_numbers(A)}" xyaxes="{xml_numbers((*x, *y))}">{_SWIVEL}{parts}</body>\n'
    follow = _follow("follower", "end", line)
    return Mounting(begin + body, path + _over("wheel", line), follow, added)


def _guides(line: Line) -> tuple[str, str, float]:
    """Return the sites of winch exit and guides, the path through them, and what that is longer than the cable, m.

    The way over wheels is the same at any pose: sites on their rims with straight tendons between them, whose lengths
    are a little shorter than the arcs.
    """
    if line.winch_exit is None:
        return "", "", 0.0
    way = line.dead_span()
    points = way.drawn()
    names = ["winch", *(f"guide {k + 1} of" for k in range(len(points) - 2))]
    sites = "".join(_site(name, line, at) for name, at in zip(names, points[:-1], strict=True))
    longer = sum(map(math.dist, points, points[1:])) - way.length if len(points) > 2 + len(line.guides) else 0.0
    return sites, "".join(_via(name, line) for name in names), longer


def _follower(what: str, line: Line, reach: float, height: float) -> str:
    """Return two slides in the plane y = 0 of a wheel, with a site at their end, at x = *reach* and z = *height*, m."""
    inertial = '<inertial pos="0 0 0" mass="1e-4" diaginertia="1e-6 1e-6 1e-6"/>'
    slides = '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>'
    at = xml_numbers((reach, 0.0, height))
    return f'<body gravcomp="1" pos="{at}">{slides}{inertial}<site name={xml_name(what, line)}/></body>'


def _follow(what: str, end: str, line: Line) -> str:
    firm = 'solref="0.002 1" solimp="0.9999 0.99999 0.001 0.5 2"'
    return f"    <connect site1={xml_name(what, line)} site2={xml_name(end, line)} {firm}/>\n"


def _wheel(what: str, line: Line, radius: float, centre: Sequence[float], side: tuple[float, float]) -> str:
    """Return a wheel in the plane y = 0, and a site to that *side* (x, z) of it, on which the cable passes."""
    beside = (centre[0] + 1.5 * side[0] * radius, 0.0, 1.5 * side[1] * radius)
    return (
        f'<geom name={xml_name(what, line)} type="cylinder" pos="{xml_numbers(centre)}" zaxis="0 1 0" '
        f'size="{radius!r} {0.1 * radius!r}" contype="0" conaffinity="0" mass="0"/>'
        f'<site name={xml_name(f"{what} side", line)} pos="{xml_numbers(beside)}"/>'
    )


def _towards(axis: Sequence[float], away: Array) -> tuple[Array, Array, float, float]:
    """Return axes x and y (3,) of a swivel about *axis* that faces a point *away* (3,), and where that is in x and z.

    A point on the axis is faced anywhere.
    """
    z = np.array(axis)
    height = float(away @ z)
    level = away - height * z
    reach = float(np.linalg.norm(level))
    if reach < 1e-9:
        level = np.eye(3)[int(np.abs(z).argmin())]
        level = level - (level @ z) * z
    x = level / np.linalg.norm(level)
    return x, np.cross(z, x), reach, height


def _site(what: str, line: Line, at: Sequence[float] | Array, indent: int = 4) -> str:
    return f'{" " * indent}<site name={xml_name(what, line)} pos="{xml_numbers(at)}"/>\n'


def _via(what: str, line: Line) -> str:
    return f"<site site={xml_name(what, line)}/>"


def _over(what: str, line: Line) -> str:
    return f"<geom geom={xml_name(what, line)} sidesite={xml_name(f'{what} side', line)}/>"


def xml_name(what: str, line: Line) -> str:
    """Return the quoted name that the part *what* of a line has in the model."""
    return quoteattr(f"{what} {printable(line.name)}")
