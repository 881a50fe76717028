"""Platforms whose weight is next to nothing beside what loads their lines: a force, a moment, or their own tensions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import cablewright as cw
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse

GRAVITY = 9.81


def robot(rng: np.random.Generator, by: str, share: float) -> tuple[Model, np.ndarray]:
    """Return a robot whose weight is the *share* of its load, which is *by* a force, a moment or tensions; a pose."""
    size, load = 10.0 ** rng.uniform(0.0, 2.5), 10.0 ** rng.uniform(2.0, 5.0)
    n = 6 if by == "moment" or rng.random() < 0.3 else 3
    m = int(rng.integers(n, n + 3))
    around = 2.0 * np.pi * (np.arange(m) + rng.uniform(-0.2, 0.2, m)) / m
    heights = size * rng.uniform(0.9, 1.1, m)
    if by != "force":
        heights[1::2] = size * rng.uniform(0.0, 0.1, m // 2)
    away = size * rng.uniform(0.7, 1.0, m)
    platform: dict[str, Any] = {"kind": "rigid" if n == 6 else "point", "mass": share * load / GRAVITY}
    if by == "force":
        platform["force"] = tuple(load * np.array([*rng.uniform(-0.3, 0.3, 2), -1.0]))
    elif by == "moment":
        platform["moment"] = tuple(5e-3 * size * load * rng.uniform(-1.0, 1.0, 3))
    if rng.random() < 0.2 and m > 3:
        platform["plane"] = {"normal": (0.0, 1.0, 0.0)}
    law = CableLaw(rng.choice(["elastic", "catenary"]))
    cable = {"axial_stiffness": load * 10.0 ** rng.uniform(2.0, 5.0), "breaking_load": 1e5 * load}
    cable["linear_density"] = (
        0.0 if law is CableLaw.ELASTIC else load / GRAVITY / size * 10.0 ** rng.uniform(-6.0, -1.0)
    )
    swivel = {"kind": "swivel", "radius": 0.01 * size}
    each = {"cable": cable, "tension_limits": (load * (0.05 if by == "force" else 0.3), 1e4 * load)}
    points = 0.1 * size * rng.uniform(-1.0, 1.0, (m, 3)) if n == 6 else np.zeros((m, 3))
    lines = [
        {
            "name": f"line {i}",
            "exit_point": (away[i] * np.cos(around[i]), away[i] * np.sin(around[i]), heights[i]),
            "platform_point": tuple(points[i]),
            "sheave": swivel if rng.random() < 0.5 else {"kind": "eyelet"},
            **each,
        }
        for i in range(m)
    ]
    scene = {"gravity": GRAVITY, "frame_min": (-2.0 * size,) * 3, "frame_max": (2.0 * size,) * 3}
    pose = np.zeros(n)
    pose[:3] = size * np.array([rng.uniform(-0.2, 0.2), 0.0, rng.uniform(0.3, 0.6)])
    made = Robot.model_validate({"name": "light", "scene": scene, "platform": platform, "lines": lines})
    return Model(made, Fidelity(law)), pose


def round_trips(by: str, share: float, count: int) -> list[tuple[Equilibrium, Equilibrium]]:
    rng, found = np.random.default_rng([len(by), int(-np.log10(share))]), []
    for _ in range(count):
        model, pose = robot(rng, by, share)
        held = solve_inverse(model, pose)
        if held.ok:
            found.append((held, solve_forward(model, held.lengths)))
    assert len(found) > count // 14
    return found


@pytest.mark.parametrize("share", [1.0, 1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("by", ["force", "moment", "tensions"])
def test_forward_finds_the_pose_of_the_lengths_of_inverse(by: str, share: float) -> None:
    for held, found in round_trips(by, share, 40):
        assert found.ok
        assert found.is_valid()
        size = np.abs(held.lines.exit_point).max()
        if held.model.n == 3:  # a body may hang in several poses
            np.testing.assert_allclose(found.pose, held.pose, rtol=0.0, atol=1e-9 * size)


@pytest.mark.parametrize("grams", [1e-3, 1.0, 100.0, 2e7])
def test_a_gram_under_200_kilonewtons(grams: float) -> None:
    """In a frame of 480 m: the last digit of a coordinate is more force than the weight."""
    each = {
        "cable": {"axial_stiffness": 700e6, "linear_density": 0.3, "breaking_load": 100e6},
        "sheave": {"kind": "eyelet"},
        "tension_limits": (0.0, 10e6),
    }
    exits = {"e": (240.0, 0.0, 260.0), "w": (-240.0, 0.0, 260.0), "n": (0.0, 240.0, 260.0), "s": (0.0, -240.0, 260.0)}
    four = Robot.model_validate(
        {
            "name": "four",
            "scene": {"frame_min": (-900.0,) * 3, "frame_max": (900.0,) * 3},
            "platform": {"mass": 1e-3 * grams, "force": (0.0, 0.0, -200e3)},
            "lines": [{"name": name, "exit_point": exit_point, **each} for name, exit_point in exits.items()],
        }
    )
    found = cw.forward(four, cw.inverse(four, [0.0, 0.0, 0.0]).checked().lengths)
    assert found.ok
    np.testing.assert_allclose(found.pose, 0.0, atol=1e-9)
