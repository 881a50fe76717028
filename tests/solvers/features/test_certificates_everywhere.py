"""Certificates of lines out of the plane are true: the equilibrium with 50 digits is within the bound."""

from __future__ import annotations

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from mpmath import mp, mpf

import cablewright as cw
import cases
import out_of_plane
from cablewright.kernels import layout
from cablewright.kernels.certificates import krawczyk as kernel
from cablewright.kernels.certificates.system_enclosure import certificate_pool, unfold
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.solvers.certify import certify
from cablewright.solvers.continuation import Tracker
from cablewright.solvers.forward import solve_forward
from oracles import spatial_lines
from oracles.irvine import DIGITS
from oracles.platform import Place

SMALL = mpf(10) ** -22
FAST = ("tilted", "aside", "both", "pulleys on mounts")


def off(row: Equilibrium) -> np.ndarray:
    """How far the exact pose is from the row's, (n,): m, and the components of the rotation from it, rad.

    Newton with the certificate's Y on the oracle's equations: any Y that contracts leads to a zero of them.
    """
    own = row.packed._replace(lines=row.packed.lines[0], platform=row.packed.platform[0])
    work = unfold(own, certificate_pool(own))
    kernel.certify(own, row.lengths, row.pose, row.states, 1.0, work)
    ends = work.offsets
    unknowns = [[mpf(float(y)) for y in work.centre[a:b]] for a, b in pairwise(ends)]
    pose, turn = [mpf(float(x)) for x in row.pose[:3]], [mpf(0)] * 3
    start = Place.of(row.pose).rotation
    with mp.workdps(DIGITS):
        for _ in range(30):
            residual = spatial_lines.balance(own, row.lengths, pose, turn, start, row.states, unknowns)
            size = max(map(abs, residual)) or mpf(1)
            step = [size * mpf(float(v)) for v in work.inverse @ np.array([float(r / size) for r in residual])]
            if max(map(abs, step)) < SMALL:
                found = spatial_lines.minus(pose, [mpf(float(x)) for x in row.pose[:3]])
                return np.array([float(value) for value in (found + turn)[: row.model.n]])
            for y, first in zip(unknowns, ends[:-1], strict=True):
                y[:] = spatial_lines.minus(y, step[first : first + len(y)])
            moved = step[ends[-1] :]
            pose = spatial_lines.minus(pose, moved[:3])
            turn = spatial_lines.minus(turn, moved[3:]) if len(moved) == 6 else turn
    raise AssertionError(f"no equilibrium: the last step was {float(max(map(abs, step))):.3g}")


def certified_share(robot: Robot, kind: str, count: int, seed: int) -> float:
    """Certify *count* poses whose lines are *kind*, compare each certified one with 50 digits."""
    model, rng = Model(robot), np.random.default_rng(seed)
    held = cases.poses(model, count, seed)
    lengths = held.lengths.copy()
    excess = {"taut": np.zeros(count), "slack": rng.uniform(0, 0.3, count), "between": 10 ** rng.uniform(-6, -2, count)}
    lengths[np.arange(count), rng.integers(0, robot.m, count)] += excess[kind]
    found = solve_forward(model, lengths, guess=held.pose)
    found = found[found.ok]
    proofs = certify(found)
    for i in np.flatnonzero(proofs.certified):
        assert (np.abs(off(found[i])) <= proofs.bound[i]).all()
    return float(proofs.certified.mean())


@pytest.mark.parametrize("kind", FAST)
def test_the_exact_equilibrium_is_within_the_bound(kind: str) -> None:
    for build in (out_of_plane.point, out_of_plane.body):
        assert certified_share(build(kind), "between", 3, 4) == 1.0


@pytest.mark.slow
@pytest.mark.parametrize("excess", ["taut", "slack", "between"])
@pytest.mark.parametrize("kind", out_of_plane.KINDS)
def test_the_exact_equilibrium_is_within_the_bound_in_hundreds_of_poses(kind: str, excess: str) -> None:
    shares = [certified_share(build(kind), excess, 50, 6) for build in (out_of_plane.point, out_of_plane.body)]
    assert min(shares) >= (0.95 if excess == "taut" else 0.8)


@pytest.mark.parametrize("size", [1e-8, 1e-6, 1e-4])
def test_a_wrong_pose_is_never_certified(size: float) -> None:
    model, rng = Model(out_of_plane.body("both")), np.random.default_rng(8)
    held = cases.poses(model, 20, 8)
    moved = held.pose + size * rng.choice([-1.0, 1.0], held.pose.shape)
    assert not certify(dataclasses.replace(held, pose=moved)).certified.any()


@pytest.mark.parametrize("spatial", [True, False])
def test_only_lines_in_a_plane_have_none_straight_below(spatial: bool) -> None:
    robot = out_of_plane.point("guides") if spatial else cw.load("merlet2023")
    held, line = cases.poses(Model(robot), 1, 3), robot.lines[0]
    below = np.subtract(line.exit_point, line.platform_point) - [0.0, 0.0, 2.0]
    wrong = dataclasses.replace(held, pose=below[None], lengths=2.0 * held.lengths)
    reason = certify(wrong).reason()[0]
    assert reason.startswith("not certified")
    assert ("straight down" in reason) is not spatial


def test_a_tracker_certifies_its_steps() -> None:
    robot = out_of_plane.body("mixed")
    held = cw.inverse(robot, [0.3, 0.2, 1.4, 0.02, 0.03, -0.05]).checked()
    tracker = Tracker(held.model, held.lengths, begin=held)
    assert tracker.step(held.lengths + 1e-3) is cw.Status.OK


def test_plain_robots_have_no_unknowns_of_these() -> None:
    own = Model(cw.load("cogiro")).packed
    assert own.general is None
    assert (own.lines[..., layout.GUIDE] == layout.UPRIGHT).all()
