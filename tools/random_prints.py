"""Random robots of the size of printers, and jobs for them: what `random_checks` and `drawn_machines` check.

Half of the robots hang from lines overhead and half pull against themselves; some slide on a plane, are bodies, have
several spans a line, soft cables or no minimum tension.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from tools.random_robots import Random, log_uniform

from cablewright.printing.job import Job
from cablewright.robot import Robot

GRAVITY = 9.81


def random_print(seed: int, number: int, folder: Path) -> tuple[Robot, Job]:
    """Return a robot and a job, number *number* of a *seed*; G-code is written to the *folder*."""
    rng = np.random.default_rng([seed, number])
    size, mass = log_uniform(rng, -0.3, 1.3), log_uniform(rng, -0.5, 2.5)
    body = rng.random() < 0.2
    flat = not body and rng.random() < 0.15
    if flat:
        exits, height = _on_board(rng, size)
    else:
        exits, height = _around(rng, size, 8 if body else int(rng.integers(3, 7)))
    points = _of_body(rng, exits, 0.08 * size) if body else np.zeros_like(exits)
    platform: dict[str, Any] = {"kind": "rigid" if body else "point", "mass": mass}
    if flat:
        sided = {} if rng.random() < 0.4 else {"one_sided": bool(rng.random() < 0.7)}
        platform["plane"] = {"normal": (0.0, 0.0, 1.0), **sided}
    low, high = exits.min(axis=0) - 0.05 * size, exits.max(axis=0) + 0.05 * size
    low[2] = min(low[2], 0.0)
    scene = {"gravity": GRAVITY, "frame_min": tuple(low), "frame_max": tuple(high)}
    lines = _lines(rng, exits, points, GRAVITY * mass / len(exits), size)
    table = {"name": f"random {number}", "scene": scene, "platform": platform, "lines": lines}
    return Robot.model_validate(table), _job(rng, number, folder, (exits.mean(axis=0), height), size)


def _around(rng: Random, size: float, m: int) -> tuple[np.ndarray, float]:
    """Return exit points (m, 3) around a space, overhead or some of them low, and the height of a part, m."""
    around = 2 * np.pi * (np.arange(m) + rng.uniform(-0.2, 0.2, m)) / m
    heights = rng.uniform(0.9, 1.1, m) * size
    if m > 3 and rng.random() < 0.5:  # some low ones, and the rest above
        low = np.arange(m) % 2 == 0 if m > 4 else np.arange(m) > 0
        heights[low] = rng.uniform(0.0, 0.1, int(low.sum())) * size
    away = np.where((m == 4) & (np.arange(m) == 0) & (heights.min() < 0.5 * size), 0.05, rng.uniform(0.6, 0.9, m))
    exits = np.column_stack([away * size * np.cos(around), away * size * np.sin(around), heights])
    return exits, size * float(rng.uniform(0.1, 0.5))


def _on_board(rng: Random, size: float) -> tuple[np.ndarray, float]:
    """Return four exit points (4, 3) around a board, and the height of the board, m."""
    corners = size * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * rng.uniform(0.7, 1.0, (4, 1))
    return np.column_stack([corners, np.full(4, size * log_uniform(rng, -2.5, -0.7))]), 0.0


def _of_body(rng: Random, exits: np.ndarray, half: float) -> np.ndarray:
    """Return points (m, 3) of a box that face the exit points; those of low lines are on top."""
    signs = np.sign(exits[:, :2])
    signs[signs == 0.0] = 1.0
    high = np.where(exits[:, 2] > exits[:, 2].mean(), -1.0, 1.0)
    return half * np.column_stack([signs * rng.uniform(0.8, 1.2, (len(exits), 1)), high])


def _lines(rng: Random, exits: np.ndarray, points: np.ndarray, share: float, size: float) -> list[dict[str, Any]]:
    most = share * log_uniform(rng, 0.5, 1.7)
    least = 0.0 if rng.random() < 0.3 else most * log_uniform(rng, -3, -0.7)
    cable = {
        "axial_stiffness": most * log_uniform(rng, 1.7, 4.0),
        "linear_density": share / GRAVITY / size * log_uniform(rng, -4, -0.3),
        "breaking_load": 3.0 * most,
    }
    spans = rng.choice([1, 2, 3], len(exits), p=[0.7, 0.2, 0.1]) if rng.random() < 0.3 else np.ones(len(exits), int)
    return [
        {
            "name": f"line {i}",
            "exit_point": tuple(map(float, at)),
            "platform_point": tuple(map(float, point)),
            "cable": cable,
            "sheave": {"kind": "eyelet"},
            "tension_limits": (least, most),
            "advantage": int(spans[i]),
        }
        for i, (at, point) in enumerate(zip(exits, points, strict=True))
    ]


def _job(rng: Random, number: int, folder: Path, middle: tuple[np.ndarray, float], size: float) -> Job:
    """Return a helix or a walk along corners around the *middle*: a point (3,) and a height, m."""
    (x, y, _), z = middle
    radius = size * log_uniform(rng, -1.2, -0.4)
    table: dict[str, Any] = {
        "name": f"part {number}",
        "motion": {
            "print_speed": log_uniform(rng, -1.5, 0.0),
            "travel_speed": log_uniform(rng, -1.0, 0.3),
            "acceleration": log_uniform(rng, -2.0, 0.5),
        },
        "max_error": size * log_uniform(rng, -2.7, -1.3),
        "origin": (float(x), float(y), 0.0),
    }
    if rng.random() < 0.3:
        table["sampling"] = {"step": float(min(radius * 0.3, size * log_uniform(rng, -2.2, -1.2)))}
    if z > 0.0 and rng.random() < 0.4:
        helix = {"radius": radius, "layers": 1, "layer_height": 0.01 * size, "first_height": z}
        return Job.model_validate(table | {"helix": helix})
    file = folder / f"part{number}.gcode"
    corners = radius * rng.uniform(-1.0, 1.0, (int(rng.integers(3, 9)), 2))
    moves = [f"G{int(rng.random() > 0.2)} X{1e3 * a:.3f} Y{1e3 * b:.3f} E1" for a, b in corners]
    begin = 1e3 * corners[-1]
    file.write_text("\n".join(["G21", "G90", "M83", f"G0 X{begin[0]:.3f} Y{begin[1]:.3f} Z{1e3 * z:.3f}", *moves, ""]))
    return Job.model_validate(table | {"gcode": str(file)})
