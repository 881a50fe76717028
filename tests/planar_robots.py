"""Robots whose platform moves in a plane, on belts that run off it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from cablewright.robot import Robot

STIFFNESS, LIMITS, MASS = 5e4, (2.0, 300.0), 5.0  # N, N, kg
PLANES = {"vertical": (0.0, 1.0, 0.0), "horizontal": (0.0, 0.0, -2.0), "tilted": (0.2, 1.0, 0.3)}
DISTANCE = 0.02  # m
CORNERS = np.array([(-1.2, -0.8), (1.2, -0.8), (1.2, 0.8), (-1.2, 0.8)])
SLED = """
schema = 1
name = "table"
scene = { frame_min = [-1.0, -1.0, -0.01], frame_max = [1.0, 1.0, 0.4] }
platform = { mass = "MASS kg", plane = { normal = [0.0, 0.0, 1.0] } }
cable = { axial_stiffness = "140 kN", linear_density = "30 g/m", breaking_load = "2 kN" }
sheave = { kind = "eyelet" }
line = { tension_limits = ["80 N", "400 N"] }
"""
EXITS = {"a": (-1.0, -1.0), "b": (1.0, -1.0), "c": (1.0, 1.0), "d": (-1.0, 1.0)}
POINTS = np.array([(-0.1, 0.06), (0.11, 0.05), (0.1, -0.05), (-0.12, -0.06)])  # crossed: they hold the body's turn


def frame(robot: Robot) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Two unit vectors in the plane of the board, and its normal."""
    return axes(robot.platform.plane.normal)


def axes(normal: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Two unit vectors across *normal*, the first horizontal and the second upwards, and the unit normal."""
    n = np.array(normal, float) / np.linalg.norm(normal)
    first = np.cross(n, [0.0, 0.0, 1.0]) if abs(n[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    first /= np.linalg.norm(first)
    return first, np.cross(first, n), n


def board(
    plane: str = "vertical", body: bool = False, lines: int = 4, off: float = 0.05, held: bool = True, **own: Any
) -> Robot:
    """A point or a body on *lines* from four corners, each farther *off* the board than the one before, m.

    *held*: whether the plane carries it, both ways; *own*: values of the platform.
    """
    a, b, n = axes(PLANES[plane])
    described = []
    for i in range(lines):
        away = DISTANCE + off * (1.0 + 0.4 * i)
        (u, v), (p, q) = CORNERS[i % 4], POINTS[i % 4]
        line = {
            "name": f"line {i}",
            "exit_point": tuple(u * a + v * b + away * n),
            "cable": {"axial_stiffness": STIFFNESS, "linear_density": 0.02, "breaking_load": 1e5},
            "sheave": {"kind": "eyelet"},
            "tension_limits": LIMITS,
        }
        described.append(line | ({"platform_point": tuple(p * a + q * b + 0.01 * i * n)} if body else {}))
    platform: dict[str, Any] = {"mass": MASS} | own
    if body:
        platform |= {"kind": "rigid", "inertia": (0.1, 0.12, 0.14)}
    if held:
        platform["plane"] = {"normal": PLANES[plane], "distance": DISTANCE, "one_sided": False}
    scene = {"frame_min": (-2, -2, -2), "frame_max": (2, 2, 2)}
    return Robot.model_validate({"name": "board", "scene": scene, "platform": platform, "lines": described})


def places(robot: Robot, count: int, reach: float = 0.6, turn: float = 0.1, seed: int = 1) -> np.ndarray:
    """Random poses in the plane, within *reach* of its centre (m) and *turn* (rad) of no rotation."""
    a, b, n = frame(robot)
    rng = np.random.default_rng(seed)
    u, v = rng.uniform(-reach, reach, (2, count, 1))
    poses = u * a + v * b + DISTANCE * n
    return poses if robot.n == 3 else np.hstack([poses, rng.uniform(-turn, turn, (count, 1)) * n])


def sled(folder: Path, mass: float) -> Path:
    """Belts that come from above a level board pull the sled off, unless it is heavy."""
    lines = "".join(f'[[lines]]\nname = "{name}"\nexit_point = [{x}, {y}, 0.4]\n' for name, (x, y) in EXITS.items())
    file = folder / f"sled-{mass:g}.toml"
    file.write_text(SLED.replace("MASS", f"{mass:g}") + lines)
    return file
