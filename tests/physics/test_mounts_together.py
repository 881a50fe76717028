"""Two exit points on one post: what a compliance of each exit leaves out, by a post of its own that couples them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cablewright as cw
from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import Robot, load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse

TOP = 2e-6  # m/N, sideways, at the top of a post: 4 mm under 2 kN
FIDELITY = Fidelity.of("elastic", "eyelet")
COGIRO = load("cogiro")  # four posts, two exit points on each
EXITS = np.array([line.exit_point for line in COGIRO.lines])
POSES = np.array([[x, y, z, 0.0, 0.0, 0.0] for x in (-3.0, 0.0, 3.0) for y in (-2.0, 2.0) for z in (1.5, 3.0)])


def posts() -> np.ndarray:
    """Which exit points are on one post, (m, m): those within 2 m of each other."""
    return np.linalg.norm(EXITS[:, None, :2] - EXITS[None, :, :2], axis=2) < 2.0


def compliance() -> np.ndarray:
    """Compliance (3 m, 3 m), m/N, of posts clamped at the floor: a cantilever's, equal in x and y, none along it.

    A force at height a displaces height b > a by a^2 (3 b - a) / (6 E I).
    """
    heights = EXITS[:, 2] - min(0.0, EXITS[:, 2].min())
    rigidity = heights.max() ** 3 / (3.0 * TOP)  # E I
    a, b = np.minimum.outer(heights, heights), np.maximum.outer(heights, heights)
    sideways = np.where(posts(), a * a * (3.0 * b - a) / (6.0 * rigidity), 0.0)
    return np.kron(sideways, np.diag([1.0, 1.0, 0.0]))


def on_posts(whole: np.ndarray) -> Robot:
    """The robot with the blocks of each exit: all that its file can say."""
    lines = []
    for at, line in enumerate(COGIRO.lines):
        block = whole[3 * at : 3 * at + 3, 3 * at : 3 * at + 3]
        lines.append(line.model_dump() | {"exit_compliance": tuple(map(tuple, block.tolist()))})
    return Robot.model_validate(COGIRO.model_dump() | {"lines": lines})


def lengths_on(whole: np.ndarray) -> np.ndarray:
    """Lengths at the poses with exit points where all forces together displace them: a loop about rigid mounts."""
    model, exits = Model(COGIRO, FIDELITY), np.tile(EXITS, (len(POSES), 1, 1))
    for _ in range(30):
        held = solve_inverse(model, POSES, exit_points=np.ascontiguousarray(exits)).checked()
        away = held.platform_points - exits
        force = held.tensions[..., None] * away / np.linalg.norm(away, axis=2)[..., None]
        exits = EXITS + (force.reshape(len(POSES), -1) @ whole.T).reshape(exits.shape)
    return held.lengths


def off(robot: Robot, lengths: np.ndarray) -> np.ndarray:
    """How far from the poses a robot is taken to be at these lengths, m."""
    found = solve_forward(Model(robot, FIDELITY), lengths, guess=POSES).checked()
    return np.asarray(np.linalg.norm(found.pose[:, :3] - POSES[:, :3], axis=1))


def test_posts_have_two_exit_points_each() -> None:
    assert (posts().sum(axis=0) == 2).all()


def test_blocks_of_posts_apart_leave_nothing_out() -> None:
    """The loop is an oracle of the statics of the blocks."""
    whole = compliance()
    blocks = whole * np.kron(np.eye(len(EXITS)), np.ones((3, 3)))
    assert off(on_posts(whole), lengths_on(blocks)).max() < 1e-7
    assert off(COGIRO, lengths_on(blocks)).max() > 1e-3


def test_error_of_separate_mounts_for_two_exit_points_on_a_post() -> None:
    """The page states the error: `docs/robots.md`, coupled mounts."""
    whole = compliance()
    lengths = lengths_on(whole)
    left, none = off(on_posts(whole), lengths), off(COGIRO, lengths)
    print(f"each apart {1e3 * left.max():.1f} mm, stiff {1e3 * none.max():.1f} mm")
    assert left.max() / none.max() == pytest.approx(0.5, abs=0.1)  # equally high, under equal forces
    assert (f"{1e3 * left.max():.1f}", f"{1e3 * none.max():.1f}") == ("4.9", "10.0")


def test_check_and_accuracy_say_so(tmp_path: Path) -> None:
    """Where exit points give, and only there."""
    (tmp_path / "part.gcode").write_text("G21\nG90\nM82\nG1 X0 Y0 Z1 F3000\nG1 X5 Y0 E1 F1200\nG1 X5 Y5 E2\n")
    job = 'schema = 1\nname = "part"\ngcode = "part.gcode"\norigin = [0.0, 0.0, 1.0]\n[sampling]\nstep = "5 mm"\n'
    (tmp_path / "part.toml").write_text(job)
    stiff = load("merlet2023")
    lines = tuple(line.model_copy(update={"exit_compliance": 2e-6}) for line in stiff.lines)
    soft = stiff.model_copy(update={"lines": lines})
    for robot, given in ((stiff, False), (soft, True)):
        found = cw.check(robot, tmp_path / "part.toml")
        assert any("coupled mounts" in each for each in found.not_checked) == given
        errors = cw.accuracy(robot, [[0.0, 0.0, 1.0]], cw.modulus_ranges(robot, 0.99, 1.01))
        assert any("coupled mounts" in each for each in errors.notes) == given
