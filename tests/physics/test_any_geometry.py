"""Twelve robots of odd geometry: each yes and no of the inverse problem against a linear program of its own."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

import cablewright as cw
import out_of_plane
import planar_robots
from cablewright.foundation.errors import Status
from cablewright.robot import PlatformSheave, Pulley, Robot, Swivel
from cases import often

POSES = often(25, 60)
CLEAR = 1e-6
"""Share of the load by which a linear program's answer has to be clear."""


def around(lines: int, size: float, body: bool, mass: float, low: float = 0.0, **own: Any) -> Robot:
    """Lines from a ring over a point or a body, every other one from the ring's *low* height, size in m."""
    rng, made = np.random.default_rng(lines), []
    for i in range(lines):
        turn = 2 * np.pi * i / lines + 0.1 * rng.normal()
        height = low * size if i % 2 and low else size
        exit_point = (0.5 * size * np.cos(turn), 0.5 * size * np.sin(turn), height)
        way = turn + (0.9 if i % 2 else -0.9)
        point = (0.06 * np.cos(way), 0.06 * np.sin(way), 0.04 if i % 2 else -0.04) if body else (0.0, 0.0, 0.0)
        point = tuple(size * each for each in point)
        made.append({
            "name": f"line {i}", "exit_point": exit_point, "platform_point": point, "sheave": {"kind": "eyelet"},
            "cable": {"axial_stiffness": 1e3 * mass * 9.81, "linear_density": 0.0, "breaking_load": 1e4 * mass},
            "tension_limits": (0.2 * mass, 40.0 * mass),
        })  # fmt: skip
    platform: dict[str, Any] = {"mass": mass} | own
    if body:
        platform |= {"kind": "rigid", "inertia": (mass, mass, mass)}
    scene = {"frame_min": (-size, -size, 0), "frame_max": (size, size, size)}
    return Robot.model_validate({"name": "odd", "scene": scene, "platform": platform, "lines": made})


def over_sheaves(robot: Robot, size: float, *kinds: str) -> Robot:
    """The robot with guides of these kinds in turn, of a radius of 1 % of its size."""
    rng, lines = np.random.default_rng(5), []
    for i, line in enumerate(robot.lines):
        kind, exit_point, own = kinds[i % len(kinds)], np.array(line.exit_point), {}
        inward = -exit_point * [1, 1, 0] / np.linalg.norm(exit_point[:2])
        axis = rng.normal(size=3)
        axis[2] = 0.5 + abs(axis[2])
        wrap = "over" if exit_point[2] > 0.5 * size else "under"  # low lines run up to the platform
        if kind == "tilted":
            own["sheave"] = Swivel(radius=0.01 * size, axis=tuple(axis), wrap=wrap)
        if kind == "aside":
            own["sheave"] = Swivel(radius=0.01 * size, wrap=wrap)
            own["winch_exit"] = tuple(exit_point + np.array([0.02, 0.03, -0.4 if wrap == "over" else 0.4]) * size)
        if kind == "pulley":
            own["sheave"] = Pulley(radius=0.01 * size, axis=tuple(np.cross([0, 0, 1], inward)))
            own["winch_exit"] = tuple(exit_point - 0.01 * size * inward - [0, 0, 0.3 * size])
        if kind == "guides":
            own["winch_exit"] = tuple(exit_point - [0, 0, 0.4 * size])
            own["guides"] = (tuple(exit_point - 0.05 * size * inward),)
        if kind == "wheel":
            own["winch_exit"] = tuple(exit_point - 0.1 * size * inward - [0, 0, 0.4 * size])
            centre = exit_point - 0.08 * size * inward
            own["guides"] = (out_of_plane.wheel(centre, np.cross([0, 0, 1], inward), 0.02 * size),)
        if kind == "end":
            own["platform_sheave"] = PlatformSheave(radius=0.01 * size, axis=tuple(rng.normal(size=3)))
        lines.append(line.model_copy(update=own))
    return out_of_plane.checked(robot.model_copy(update={"lines": tuple(lines)}))


def hung(robot: Robot, mass: float) -> Robot:
    """The robot with a counterweight at its first line."""
    first = robot.lines[0].model_copy(update={"counterweight": mass})
    return out_of_plane.checked(robot.model_copy(update={"lines": (first, *robot.lines[1:])}))


ROBOTS = {
    "a swivel over the middle, 2 m": over_sheaves(
        around(4, 2.0, False, 3.0, low=0.3), 2.0, "tilted", "aside", "pulley", "guides"
    ),
    "belts off a vertical board": planar_robots.board("vertical", off=0.06),
    "six belts off a tilted board, a body": planar_robots.board("tilted", body=True, lines=6, off=0.08),
    "three tilted swivels, 0.3 m": over_sheaves(around(3, 0.3, False, 0.2), 0.3, "tilted"),
    "twelve tilted swivels, 60 m": over_sheaves(around(12, 60.0, True, 900.0, low=0.05), 60.0, "tilted"),
    "sheaves on the platform, 10 m": over_sheaves(around(8, 10.0, True, 60.0, low=0.05), 10.0, "end"),
    "six pulleys, 5 m": over_sheaves(around(6, 5.0, False, 12.0, low=0.1), 5.0, "pulley"),
    "four lines through guides, 1 m": over_sheaves(around(4, 1.0, False, 1.0), 1.0, "guides"),
    "eight winches aside, 15 m": over_sheaves(around(8, 15.0, True, 80.0, low=0.05), 15.0, "aside"),
    "twelve lines of all kinds, 20 m": over_sheaves(
        around(12, 20.0, True, 150.0, low=0.05), 20.0, "tilted", "end", "aside", "guides"
    ),
    "a counterweight and wheels, 3 m": hung(over_sheaves(around(5, 3.0, False, 6.0), 3.0, "wheel"), 2.0),
    "a counterweight and a body, 8 m": hung(around(9, 8.0, True, 50.0, low=0.05), 20.0),
}


def poses_of(robot: Robot) -> np.ndarray:
    """Random poses, of which a robot can hold some."""
    if robot.platform.plane is not None:
        return planar_robots.places(robot, POSES, reach=1.3, turn=0.5)
    size, rng = robot.scene.frame_max[2], np.random.default_rng(11)
    poses = rng.uniform([-0.4, -0.4, 0.15], [0.4, 0.4, 0.9], (POSES, 3)) * size
    return poses if robot.n == 3 else np.hstack([poses, rng.uniform(-0.25, 0.25, (POSES, 3))])


def program(robot: Robot, pose: np.ndarray) -> float:
    """By how much the limits could be narrower and hold *pose*, as a share of the load; negative: are too narrow."""
    R = Rotation.from_rotvec(pose[3:]).as_matrix() if robot.n == 6 else np.eye(3)
    columns = []
    for line in robot.lines:
        point = pose[:3] + R @ np.array(line.platform_point)
        u, arm = out_of_plane.straight(line, point, R, pose[:3])
        columns.append(np.concatenate([-u, np.cross(arm, -u)])[: robot.n])
    load = robot.platform.mass * robot.scene.gravity
    weight = np.array([0, 0, -load, 0, 0, 0])[: robot.n]
    A, free = np.array(columns).T, 0
    if robot.platform.plane is not None:  # the plane's force and moments, of any size
        a, b, n = planar_robots.frame(robot)
        reactions = [np.concatenate([n, np.zeros(3)])[: robot.n]]
        if robot.n == 6:
            reactions += [np.concatenate([np.zeros(3), axis]) for axis in (a, b)]
        A, free = np.column_stack([A, *reactions]), len(reactions)
    m = len(robot.lines)
    limits, wound = [line.tension_limits for line in robot.lines], np.ones(m)
    for i, line in enumerate(robot.lines):
        if line.counterweight is not None:
            limits[i], wound[i] = 2 * (line.counterweight * robot.scene.gravity,), 0.0
    low, high = np.array(limits).T
    narrower = np.c_[-np.eye(m), np.zeros((m, free)), wound], np.c_[np.eye(m), np.zeros((m, free)), wound]
    found = linprog(
        np.r_[np.zeros(m + free), -1.0], A_ub=np.vstack(narrower), b_ub=np.r_[-low, high],
        A_eq=np.c_[A, np.zeros(robot.n)], b_eq=-weight, bounds=(None, None), method="highs",
    )  # fmt: skip
    return found.x[-1] / load if found.success else -np.inf


@pytest.mark.parametrize("name", ROBOTS)
def test_each_yes_and_no_is_that_of_a_linear_program(name: str) -> None:
    robot = ROBOTS[name]
    found = cw.inverse(robot, poses_of(robot), cable="elastic")
    answers = set()
    for each in found:
        share = program(robot, each.pose)
        if abs(share) < CLEAR:
            continue
        assert each.status in (Status.OK, Status.INFEASIBLE, Status.UNSTABLE), f"{each.status.word} at {each.pose}"
        assert (each.status is not Status.INFEASIBLE) == (share > 0.0), f"{share} at {each.pose}"
        if each.ok:
            assert each.is_valid()
        answers.add(each.status)
    assert {Status.OK, Status.INFEASIBLE} <= answers


@pytest.mark.parametrize("name", ROBOTS)
def test_what_sags_comes_back(name: str) -> None:
    """With cables of a hundredth of the platform's weight: lengths to pose, without a guess for a point."""
    robot = ROBOTS[name]
    heavy = 0.01 * robot.platform.mass / robot.scene.frame_max[2]
    lines = tuple(
        line.model_copy(update={"cable": line.cable.model_copy(update={"linear_density": heavy})})
        for line in robot.lines
    )
    robot = robot.model_copy(update={"lines": lines})
    found = cw.inverse(robot, poses_of(robot))
    held = found[found.ok]
    assert len(held) >= 3
    assert held.is_valid()
    back = cw.forward(robot, held.lengths, guess=held.pose)
    np.testing.assert_allclose(back.pose, held.pose, atol=1e-8)
    if robot.n == 3:
        np.testing.assert_allclose(cw.forward(robot, held.lengths).pose, held.pose, atol=1e-8)
