"""Robots whose lines lie in no vertical plane, and their lines in the words of `oracles.guided_paths`."""

from __future__ import annotations

from typing import Any

import numpy as np

from cablewright.robot import Eyelet, Line, PlatformSheave, Pulley, Robot, Swivel, load
from oracles import guided_paths as oracle

KINDS = ("tilted", "horizontal", "aside", "platform sheaves", "both", "pulleys", "guides", "mixed")
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
    """The robot as if read from a file."""
    return Robot.model_validate(robot.model_dump())


def guided(line: Line, kind: str, i: int, rng: np.random.Generator) -> Line:
    """The line with another way from its winch to its platform point."""
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
    if kind == "pulleys":
        own["sheave"] = Pulley(radius=0.08, axis=tuple(np.cross([0.0, 0.0, 1.0], inward)))
        own["winch_exit"] = tuple(exit_point - 0.08 * inward - [0.0, 0.0, 3.0])
    if kind == "guides":
        own["winch_exit"] = tuple(exit_point - [0.0, 0.0, 3.0])
        ways = np.array([(0.5, 0.2, -2.0), (0.3, 0.1, 0.2)])
        own["guides"] = tuple(tuple(exit_point + way) for way in ways)
    return line.model_copy(update=own)


def frame_of(line: Line) -> oracle.Frame:
    """The oracle's description of the line at the frame."""
    sheave = line.sheave
    if isinstance(sheave, Swivel):
        side = 1 if sheave.wrap == "over" else -1
        return oracle.Swivel(line.exit_point, unit(sheave.axis), sheave.radius, side, dead_length(line))
    if isinstance(sheave, Pulley):
        assert line.last_guide is not None
        return oracle.Pulley(line.exit_point, unit(sheave.axis), sheave.radius, line.last_guide)
    return oracle.Eyelet(line.exit_point)


def end_of(line: Line) -> oracle.End:
    """The oracle's description of the line at the platform."""
    sheave = line.platform_sheave
    if sheave is None:
        return oracle.End(line.platform_point)
    return oracle.End(line.platform_point, unit(sheave.axis), sheave.radius)


def dead_length(line: Line) -> float:
    """Distance from the winch over the guides to the exit point, m; the oracle counts it of a swivel alone."""
    if line.winch_exit is None:
        return line.dead_length
    points = np.array([line.winch_exit, *line.guides, line.exit_point])
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def unit(axis: Any) -> np.ndarray:
    """The direction as a unit vector."""
    return np.asarray(axis) / np.linalg.norm(axis)
