"""Robots whose lines lie in no vertical plane, and their lines in the words of `oracles.guided_paths`."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from cablewright.robot import Eyelet, GuideSheave, Line, PlatformPulley, PlatformSheave, Pulley, Robot, Swivel, load
from oracles import guided_paths as oracle
from oracles import wheel_paths

KINDS = (
    "tilted", "horizontal", "aside", "platform sheaves", "both", "pulleys", "guides", "mixed", "mounts",
    "pulleys on mounts", "platform pulleys", "wheels",
)  # fmt: skip
MIXED = ("tilted", "platform sheaves", "pulleys", "both", "guides", "aside")
FEED = 2.0  # m of dead span before every other tilted swivel


def body(kind: str) -> Robot:
    """The cogiro, whose eight lines carry a rigid body, with other guides."""
    robot, rng = load("cogiro"), np.random.default_rng(7)
    lines = tuple(guided(line, MIXED[i % 6] if kind == "mixed" else kind, i, rng) for i, line in enumerate(robot.lines))
    return checked(robot.model_copy(update={"name": kind, "lines": lines}))


def point(kind: str) -> Robot:
    """merlet2023, whose four lines carry a point, with other guides."""
    robot, rng = load("merlet2023"), np.random.default_rng(8)
    lines = tuple(guided(line, kind, i, rng) for i, line in enumerate(robot.lines))
    return checked(robot.model_copy(update={"name": f"point, {kind}", "lines": lines}))


def checked(robot: Robot) -> Robot:
    """The robot as if read from a file, without an uncertainty: that of the library's may be of sheaves it has lost."""
    return Robot.model_validate(robot.model_dump() | {"uncertainty": None})


def guided(line: Line, kind: str, i: int, rng: np.random.Generator) -> Line:
    """The line with another way from its winch to its platform point."""
    if "mounts" in kind:
        way = "pulleys" if "pulleys" in kind else ("platform sheaves", "tilted", "both", "guides")[i % 4]
        soft = 3e-6 * rng.normal(size=(3, 3))
        own = {"exit_compliance": 8e-6 if i in (0, 3, 5) else tuple(map(tuple, (soft @ soft.T / 1e-6).tolist()))}
        return guided(line, way, i, rng).model_copy(update=own)
    exit_point, own = np.array(line.exit_point), {"winch_exit": None, "dead_length": 0.0, "sheave": Eyelet()}
    inward = -exit_point * [1.0, 1.0, 0.0] / np.linalg.norm(exit_point[:2])
    if kind in ("tilted", "horizontal", "both"):
        axis = rng.normal(size=3)
        axis[2] = 0.0 if kind == "horizontal" else 0.4 + abs(axis[2])
        wrap = "under" if i == 3 else "over"
        own["sheave"] = Swivel(radius=0.06, axis=tuple(axis), wrap=wrap)
        if i % 2:
            feed = FEED if wrap == "over" else -FEED
            own["winch_exit"] = tuple(exit_point - feed * axis / np.linalg.norm(axis))
    if kind == "aside":
        own["sheave"] = Swivel(radius=0.06, axis=(0.0, 0.1 * i, 1.0) if i % 2 else (0.0, 0.0, 1.0))
        own["winch_exit"] = tuple(exit_point + rng.uniform([-0.3, -0.3, -3.0], [0.3, 0.3, -1.5]))
    if kind in ("platform sheaves", "both"):
        own["platform_sheave"] = PlatformSheave(radius=0.05, axis=tuple(rng.normal(size=3)))
    if kind == "platform pulleys":
        toward = unit(np.add(line.platform_point, [0.0, 0.0, 1.6]) - exit_point)
        way = unit(np.cross(toward, [0.0, 0.0, 1.0]) + 0.3 * rng.normal(size=3) + 0.4 * toward)
        axis = unit(unit(np.cross(toward, way)) + 0.1 * rng.normal(size=3))
        leaves = way - (way @ axis) * axis
        own["platform_sheave"] = PlatformPulley(radius=0.05, axis=tuple(axis), leaves=tuple(leaves))
    if kind == "pulleys":
        own["sheave"] = Pulley(radius=0.08, axis=tuple(np.cross([0.0, 0.0, 1.0], inward)))
        own["winch_exit"] = tuple(exit_point - 0.08 * inward - [0.0, 0.0, 3.0])
    if kind == "guides":
        own["winch_exit"] = tuple(exit_point - [0.0, 0.0, 3.0])
        ways = np.array([(0.5, 0.2, -2.0), (0.3, 0.1, 0.2)])
        own["guides"] = tuple(tuple(exit_point + way) for way in ways)
    if kind == "wheels":
        own |= over_wheels(exit_point, inward, i)
    return line.model_copy(update=own)


def over_wheels(exit_point: np.ndarray, inward: np.ndarray, i: int) -> dict[str, Any]:
    """Wheels before an eyelet, a pulley, a swivel and a winch aside, in turn."""
    up, level = np.array([0.0, 0.0, 1.0]), np.cross([0.0, 0.0, 1.0], inward)

    def at(back: float, aside: float, above: float) -> np.ndarray:
        return exit_point - back * inward + aside * level + above * up

    if i % 4 == 0:  # three planes
        wheels = (
            wheel(at(1.0, 0.1, -2.5), -level, 0.2),
            wheel(at(0.9, 0.6, 0.3), 0.3 * inward + 0.2 * level - up, 0.15),
        )
        return {"winch_exit": tuple(at(3.0, 0.0, -2.8)), "guides": (tuple(at(1.5, 0.0, -2.7)), *wheels)}
    if i % 4 == 1:  # all in one plane, the first two crossed
        wheels = (wheel(at(0.6, 0.0, -3.0), level, 0.1), wheel(at(0.3, 0.0, -2.2), -level, 0.12))
        return {
            "sheave": Pulley(radius=0.08, axis=tuple(level)), "winch_exit": tuple(at(0.1, 0.0, -3.5)), "guides": wheels
        }  # fmt: skip
    if i % 4 == 2:  # onto the axis of a swivel
        wheels = (wheel(at(0.11, 0.0, -2.0), -level, 0.11),)
        own = {"sheave": Swivel(radius=0.06), "winch_exit": tuple(at(1.5, 0.2, -2.4)), "guides": wheels}
        return own | {"platform_sheave": PlatformSheave(radius=0.05, axis=(0.1, 0.2, -1.0))}
    wheels = (wheel(at(0.5, 0.1, -2.0), level + 0.2 * up, 0.1), tuple(at(0.1, 0.2, -1.5)))
    return {"sheave": Swivel(radius=0.06), "winch_exit": tuple(at(1.5, 0.2, -2.9)), "guides": wheels}


def wheel(centre: Any, axis: Any, radius: float) -> GuideSheave:
    """A wheel that stands still."""
    return GuideSheave(centre=tuple(map(float, centre)), axis=tuple(map(float, axis)), radius=radius)


def way_of(line: Line, pulley: bool = True) -> wheel_paths.Way:
    """The oracle's way from the winch to the exit point, or to the *pulley* there."""
    last = line.sheave if pulley and isinstance(line.sheave, Pulley) else None
    return _way((line.winch_exit, *line.guides, line.exit_point), last)


@cache
def _way(places: tuple[Any, ...], pulley: Pulley | None) -> wheel_paths.Way:
    """The way along *places*, solved once: it is that of every pose."""
    stops: list[wheel_paths.Stop] = []
    for stop in places:
        at = stop if isinstance(stop, GuideSheave) else None
        stops.append(np.array(stop) if at is None else (np.array(at.centre), np.array(at.axis), at.radius))
    if pulley is not None:
        stops[-1] = (np.array(places[-1]), np.array(pulley.axis), pulley.radius)
    return wheel_paths.way(stops)


def comes_from(line: Line) -> np.ndarray:
    """Where the cable leaves its last guide, or its winch."""
    return way_of(line).comes_from


def frame_of(line: Line) -> oracle.Frame:
    """The oracle's description of the line at the frame."""
    sheave = line.sheave
    if isinstance(sheave, Swivel):
        side = 1 if sheave.wrap == "over" else -1
        return oracle.Swivel(line.exit_point, unit(sheave.axis), sheave.radius, side, dead_length(line))
    if isinstance(sheave, Pulley):
        return oracle.Pulley(line.exit_point, unit(sheave.axis), sheave.radius, comes_from(line))
    return oracle.Eyelet(line.exit_point)


def end_of(line: Line) -> oracle.End:
    """The oracle's description of the line at the platform."""
    sheave = line.platform_sheave
    if sheave is None:
        return oracle.End(line.platform_point)
    leaves = unit(sheave.leaves) if isinstance(sheave, PlatformPulley) else None
    return oracle.End(line.platform_point, unit(sheave.axis), sheave.radius, leaves)


def dead_length(line: Line) -> float:
    """Distance from the winch over the guides to the exit point, m; the oracle counts it of a swivel alone."""
    return line.dead_length if line.winch_exit is None else way_of(line).length


def before_pulley(line: Line) -> float:
    """Distance from the winch to where the last straight piece to a pulley begins, m; the oracle counts that piece."""
    way = way_of(line)
    return way.length - float(np.linalg.norm(way.contacts[-1][0] - way.comes_from))


def unit(axis: Any) -> np.ndarray:
    """The direction as a unit vector."""
    return np.asarray(axis) / np.linalg.norm(axis)


def touched(line: Line, force: np.ndarray | None, away: np.ndarray | None = None) -> tuple[np.ndarray, float]:
    """Where a cable under *force* leaves the frame (None: where it comes to a pulley), world, and its contact, m.

    A swivel faces *away*, or as the force does.
    """
    exit_point = np.array(line.exit_point)
    if line.is_aside:
        aside = Aside(line, force, away)
        return exit_point + aside.leaves, aside.contact
    if isinstance(line.sheave, Swivel):
        side = 1 if line.sheave.wrap == "over" else -1
        slip, contact = over_swivel(unit(line.sheave.axis), line.sheave.radius, side, force, away)
        return exit_point + slip, contact
    if isinstance(line.sheave, Pulley):
        normal, radius = unit(line.sheave.axis), line.sheave.radius
        away = comes_from(line) - exit_point
        ahead, distance = np.cross(normal, away), np.linalg.norm(away)
        arrival = (radius * away + np.sqrt(distance**2 - radius**2) * ahead) / distance**2
        if force is None:
            return exit_point + radius * arrival, 0.0
        flat = force - (force @ normal) * normal
        radial = np.cross(flat, normal) / np.linalg.norm(flat)
        turn = np.arctan2(np.cross(arrival, radial) @ normal, arrival @ radial) % (2 * np.pi)
        return exit_point + radius * radial, radius * turn
    return exit_point, 0.0


def towards_winch(line: Line) -> np.ndarray:
    """Unit vector along the dead span at the exit point; zero where it is not modelled."""
    if line.winch_exit is None:
        return np.zeros(3)
    back = comes_from(line) - line.exit_point
    if isinstance(line.sheave, Pulley):
        back = comes_from(line) - touched(line, None)[0]
    return unit(back)


def given_way(line: Line, force: np.ndarray) -> np.ndarray:
    """How far the exit goes, m, under the *force* of the free span on one cable, N, and that of the dead span."""
    compliance = np.array(line.exit_compliance or 0.0)
    compliance = compliance * np.eye(3) if compliance.ndim == 0 else compliance
    load = line.advantage * line.cables * force + line.cables * np.linalg.norm(force) * towards_winch(line)
    return compliance @ load


class Aside:
    """A swivel whose winch is aside: it turns until both tensions have no moment about its axis."""

    def __init__(self, line: Line, force: np.ndarray, away: np.ndarray | None = None) -> None:
        self.axis, self.radius = unit(line.sheave.axis), line.sheave.radius
        self.side = 1 if line.sheave.wrap == "over" else -1
        self.force = force / np.linalg.norm(force)
        self.winch = comes_from(line) - line.exit_point
        self.first = force - (force @ self.axis) * self.axis
        self.first /= np.linalg.norm(self.first) * (1.0 if away is None or self.first @ away > 0.0 else -1.0)
        reach = next(reach for reach in (0.5, 1.0, 1.5) if self.moment(-reach) * self.moment(reach) < 0.0)
        self.moment(brentq(self.moment, -reach, reach, xtol=1e-15, rtol=1e-15))

    def moment(self, angle: float) -> float:
        """Moment about the axis of unit tensions, with the sheave turned by *angle* from the force's plane."""
        outward = Rotation.from_rotvec(angle * self.axis).apply(self.first)
        normal = np.cross(self.axis, outward)
        centre = self.radius * outward
        radial = self.side * np.cross(self.force, normal)
        radial /= np.linalg.norm(radial)
        self.leaves = centre + self.radius * radial
        flat = self.winch - (self.winch @ normal) * normal - centre
        far = np.linalg.norm(flat)
        share, along = self.radius / far, flat / far
        spoke = share * along - self.side * np.sqrt(1 - share**2) * np.cross(along, normal)
        self.enters = centre + self.radius * spoke
        turn = np.arctan2(self.side * np.cross(spoke, radial) @ normal, spoke @ radial)
        self.contact = self.radius * (turn % (2 * np.pi))
        entering = (self.winch - self.enters) / np.linalg.norm(self.winch - self.enters)
        return float((np.cross(self.leaves, self.force) + np.cross(self.enters, entering)) @ self.axis)


def at_platform(
    line: Line, R: np.ndarray, force: np.ndarray, back: np.ndarray | None = None
) -> tuple[np.ndarray, float]:
    """Where a span that arrives with *force* meets the sheave on the platform, from its point, and the contact, m."""
    sheave = line.platform_sheave
    if sheave is None:
        return np.zeros(3), 0.0
    axis = R @ unit(sheave.axis)
    if not isinstance(sheave, PlatformPulley):
        return over_swivel(axis, sheave.radius, 1, -force, back)
    arm, last = np.cross(force, axis), np.cross(R @ unit(sheave.leaves), axis)
    arm /= np.linalg.norm(arm)
    turn = np.arctan2(np.cross(arm, last) @ axis, arm @ last) % (2 * np.pi)
    return sheave.radius * arm, sheave.radius * turn


def over_swivel(
    axis: np.ndarray, radius: float, side: int, force: np.ndarray, away: np.ndarray | None = None
) -> tuple[np.ndarray, float]:
    """Contact point from the exit point, and contact length: the rim's normal is square to the force."""
    normal = np.cross(axis, force)
    normal /= np.linalg.norm(normal)
    outward = np.cross(normal, axis)
    if away is not None and outward @ away < 0.0:
        normal, outward = -normal, -outward
    radial = side * np.cross(force, normal) / np.linalg.norm(force)
    turn = np.arctan2(side * np.cross(-outward, radial) @ normal, -outward @ radial)
    return radius * (outward + radial), radius * (turn % (2 * np.pi))


def straight(line: Line, point: np.ndarray, R: np.ndarray, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Direction of the straight line from the frame to the platform, and its arm there, by turns of both ends."""
    arm, u = R @ np.array(line.platform_point), point - line.exit_point
    for _ in range(200):
        u = u / np.linalg.norm(u)
        left, _ = touched(line, u, point - line.exit_point)
        end = arm + at_platform(line, R, u, line.exit_point - point)[0]
        there = position + end - left
        if np.abs(there / np.linalg.norm(there) - u).max() < 1e-15:
            break
        u = there
    return there / np.linalg.norm(there), end
