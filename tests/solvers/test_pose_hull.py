"""A box of poses holds every pose: for corners and random lengths, by the solver and by 50 digits; or there is none."""

from __future__ import annotations

import dataclasses
from itertools import product

import numpy as np
import pytest

import cases
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.kernels import layout
from cablewright.kernels.certificates import branch_tube
from cablewright.kernels.certificates.system_enclosure import (
    certificate_pool,
    jacobian_of_all,
    residual_of_all,
    unfold,
)
from cablewright.kernels.rotation import compose, left_jacobian
from cablewright.kernels.statics.line import hessian_bounds
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Eyelet, load
from cablewright.solvers.forward import solve_again, solve_forward
from cablewright.solvers.pose_box import PoseBox
from cablewright.solvers.pose_hull import enclose_poses
from solvers.test_certify import Exact, softened

BUILT = {robot.name: Model(robot) for robot in cases.robots()}
EXCESS = {"taut": 0.0, "slack": 0.3, "between": 1e-3}


def hanging(name: str, kind: str, row: int = 0) -> Equilibrium:
    """One of some feasible poses, its second line too long."""
    held = cases.poses(softened(name) if " on " in name else BUILT[name], row + 1)[row]
    longer = held.lengths + EXCESS[kind] * np.eye(held.model.m)[1]
    return solve_forward(held.model, longer, guess=held.pose).checked()


def lengths_within(found: Equilibrium, error: float, count: int, seed: int) -> np.ndarray:
    """Corners of the box of lengths, sixteen at least, *count* random lengths in it, and as many on its faces."""
    m = found.model.m
    rng = np.random.default_rng(seed)
    corners = np.array(list(product((-1.0, 1.0), repeat=m)))
    inner = rng.uniform(-1.0, 1.0, (2 * count, m))
    inner[np.arange(count), rng.integers(0, m, count)] = rng.choice([-1.0, 1.0], count)
    return found.lengths + error * np.concatenate([corners, inner])


def poses_at(found: Equilibrium, lengths: np.ndarray) -> np.ndarray:
    """Poses of the branch of *found* at *lengths* (N, m)."""
    solved = solve_again(as_batch(found), found.packed, lengths, len(lengths)).checked()
    return solved.pose


def as_batch(found: Equilibrium) -> Equilibrium:
    names = ("pose", "lengths", "states", "code", "violation", "iterations")
    return dataclasses.replace(found, **{name: np.asarray(getattr(found, name))[None] for name in names})


def held_by(box: PoseBox, poses: np.ndarray) -> bool:
    return bool((box.low <= poses).all() and (poses <= box.high).all())


def excess_width(box: PoseBox, poses: np.ndarray) -> float:
    """By how much the box is wider than the sampled poses, its worst coordinate."""
    return float(((box.high - box.low) / np.ptp(poses, axis=0)).max() - 1.0)


@pytest.mark.parametrize("kind", ["taut", "slack", "between"])
@pytest.mark.parametrize(
    ("name", "error"),
    [
        ("merlet2023", 1e-3),
        ("merlet2023", 1e-5),
        ("paty2021", 1e-3),
        ("off-axis", 3e-4),
        ("under", 3e-4),
        ("merlet2023 on both", 3e-4),
        ("paty2021 on mount", 1e-3),
    ],
)
def test_the_box_holds_all_poses_and_little_more(name: str, error: float, kind: str) -> None:
    found = hanging(name, kind)
    box = enclose_poses(found, error)
    assert box.complete
    poses = poses_at(found, lengths_within(found, error, 200, 5))
    assert held_by(box, poses)
    assert excess_width(box, poses) < 0.03


@pytest.mark.parametrize(("name", "error"), [("jung2020", 1e-6), ("cogiro", 1e-4), ("grab-four-lines", 1e-4)])
def test_the_box_of_a_body_holds_all_poses(name: str, error: float) -> None:
    found = hanging(name, "taut")
    box = enclose_poses(found, error)
    assert box.complete
    assert box.low.shape == box.high.shape == (6,)
    poses = poses_at(found, lengths_within(found, error, 200, 6))
    assert held_by(box, poses)
    assert excess_width(box, poses) < 0.03


def test_a_line_may_go_slack_and_taut_within_the_error() -> None:
    found = hanging("merlet2023", "between")
    box = enclose_poses(found, 2e-3)
    assert box.complete
    lengths = lengths_within(found, 2e-3, 300, 7)
    solved = solve_again(as_batch(found), found.packed, lengths, len(lengths)).checked()
    assert (solved.tensions.min(axis=0) < 10.0).any()
    assert (solved.tensions.max(axis=0) > 10.0 * solved.tensions.min(axis=0)).any()
    assert held_by(box, solved.pose)


@pytest.mark.parametrize("kind", ["taut", "slack", "between"])
@pytest.mark.parametrize("name", ["merlet2023", "paty2021", "merlet2023 on both", "paty2021 on mount"])
def test_exact_poses_of_corners_are_in_the_box(name: str, kind: str) -> None:
    found = hanging(name, kind)
    box = enclose_poses(found, 1e-3)
    corners = lengths_within(found, 1e-3, 0, 0)[[0, 5, 10, 15]]
    solved = solve_again(as_batch(found), found.packed, corners, len(corners)).checked()
    for row in range(len(corners)):
        assert held_by(box, solved.pose[row] + Exact(solved[row]).polished())


def test_a_box_a_tenth_smaller_misses_poses() -> None:
    for kind in ("taut", "slack", "between"):
        found = hanging("merlet2023", kind)
        box = enclose_poses(found, 1e-3)
        poses = poses_at(found, lengths_within(found, 1e-3, 200, 8))
        less = 0.05 * (box.high - box.low)
        for k in range(3):
            assert (poses[:, k] < box.low[k] + less[k]).any()
            assert (poses[:, k] > box.high[k] - less[k]).any()


def test_each_line_may_have_its_own_error() -> None:
    found = hanging("merlet2023", "taut")
    errors = [1e-3, 1e-5, 2e-4, 1e-4]
    box = enclose_poses(found, errors)
    assert box.complete
    poses = poses_at(found, found.lengths + np.array(errors) * np.array(list(product((-1.0, 1.0), repeat=4))))
    assert held_by(box, poses)
    wide = enclose_poses(found, 1e-3)
    assert (box.low > wide.low).all()
    assert (box.high < wide.high).all()


def test_a_budget_that_is_spent_gives_no_box() -> None:
    box = enclose_poses(hanging("merlet2023", "taut"), 1e-3, budget=1)
    assert not box.complete
    assert np.isnan(box.low).all()
    assert np.isnan(box.high).all()
    assert box.reason.startswith("no box within the budget of 1 leaves")
    assert box.leaves <= 1


def test_errors_that_tear_a_line_off_its_catenary_give_no_box() -> None:
    box = enclose_poses(hanging("merlet2023", "taut"), 0.5, budget=200)
    assert not box.complete
    assert box.reason.startswith("no box")


def test_progress_is_reported() -> None:
    told: list[tuple[str, int, int]] = []
    box = enclose_poses(hanging("merlet2023", "taut"), 1e-3, progress=lambda *each: told.append(each))
    assert told[-1] == ("leaves", box.leaves, 20_000)


def test_only_eyelets_without_dead_spans_have_one_pose() -> None:
    plain = cases.replaced(load("merlet2023"), "plain", sheave=Eyelet(), winch_exit=None)
    held = cases.poses(Model(plain), 1)[0]
    assert enclose_poses(held, 1e-5).only_one
    assert not enclose_poses(hanging("merlet2023", "taut"), 1e-5).only_one


def test_massless_lines() -> None:
    model = Model(load("merlet2023"), Fidelity(CableLaw.ELASTIC))
    held = cases.poses(model, 1)[0]
    box = enclose_poses(held, 1e-5)
    assert box.complete
    assert held_by(box, poses_at(held, lengths_within(held, 1e-5, 50, 9)))
    slack = solve_forward(model, held.lengths + 0.5 * np.eye(4)[0]).checked()
    assert "massless line hangs slack" in enclose_poses(slack, 1e-5).reason


def test_bad_input_is_rejected() -> None:
    found = hanging("merlet2023", "taut")
    for wrong in (0.0, -1e-3, float("nan"), [1e-3, 0.0, 1e-3, 1e-3]):
        with pytest.raises(InputError, match="over 0 is expected"):
            enclose_poses(found, wrong)
    for wrong in ([1e-3, 1e-3], np.full((4, 4), 1e-3)):
        with pytest.raises(InputError, match="one number is expected, or 4"):
            enclose_poses(found, wrong)
    with pytest.raises(InputError, match="numbers in m are expected"):
        enclose_poses(found, "wide")
    with pytest.raises(InputError, match="as large as the length of line"):
        enclose_poses(found, 100.0)
    with pytest.raises(InputError, match="budget = 0"):
        enclose_poses(found, 1e-3, budget=0)
    with pytest.raises(InputError, match="tolerance = 0"):
        enclose_poses(found, 1e-3, tolerance=0.0)
    with pytest.raises(InputError, match="a single equilibrium is expected"):
        enclose_poses(as_batch(found), 1e-3)
    with pytest.raises(AnswerError):
        enclose_poses(dataclasses.replace(found, code=np.array(1)), 1e-3)


# --- The second derivatives: what Jacobians differ by is within them


@pytest.mark.slow  # compiles what it alone calls; a bound that is too narrow shows above as a box without its poses
@pytest.mark.parametrize("kind", ["taut", "slack"])
@pytest.mark.parametrize(
    "name",
    [
        "merlet2023",
        "paty2021",
        "off-axis",
        "under",
        "jung2020",
        "jointed-body",
        "wang2021",
        "merlet2023 on both",
        "merlet2023 on soft",
        "paty2021 on soft",
        "six-lines on soft",
    ],
)
def test_jacobians_differ_by_no_more_than_the_second_derivatives(name: str, kind: str) -> None:
    """|Y (J(x + d) - J(x)) v| <= |Y| H[|d|, |v|] for random small d and v, in float Jacobians."""
    found = hanging(name, kind) if name not in ("jung2020", "jointed-body") else hanging(name, "taut")
    checked = SecondOrder(found, 1e-7 if name == "jung2020" else 5e-6)
    rng = np.random.default_rng(4)
    shares = [checked.share(rng) for _ in range(60)]
    assert max(shares) <= 1.0
    assert max(shares) > 1e-3  # a bound, not a wall


def is_spatial(packed: layout.Packed, i: int) -> bool:
    """Whether line *i* lies out of the vertical plane."""
    return packed.general is not None and packed.lines[i, layout.GUIDE] != layout.UPRIGHT


class SecondOrder:
    """One equilibrium's bound of the second derivatives, over a random box, against Jacobians in it."""

    def __init__(self, found: Equilibrium, error: float, proved: bool = True) -> None:
        self.found, (n, lines, platform, general) = found, found.packed
        self.packed = layout.Packed(n, lines[0], platform[0], general)
        self.cert = unfold(self.packed, certificate_pool(self.packed))
        m, size = found.model.m, len(self.cert.step)
        self.work = branch_tube.tube_work(size, m, 0)
        self.work.left[:], self.work.right[:] = -error, error
        code = branch_tube.prove_tube(
            self.packed,
            found.lengths.copy(),
            found.pose.copy(),
            np.ascontiguousarray(found.states),
            np.zeros((0, m)),
            self.cert,
            self.work,
        )
        assert (code == branch_tube.PROVED) >= proved
        self.inverse = self.cert.inverse.copy()
        self.middle = self.jacobian(np.zeros(size))

    def jacobian(self, off: np.ndarray) -> np.ndarray:
        """The Jacobian *off* the equilibrium, its tensions' columns by theta."""
        m, n = self.found.model.m, self.found.model.n
        pose, states = self.found.pose.copy(), np.ascontiguousarray(self.found.states).copy()
        cert, first = unfold(self.packed, certificate_pool(self.packed)), int(self.cert.offsets[m])
        residual_of_all(self.packed, self.found.lengths.copy(), pose, states, cert)
        grown = np.ones(len(off))
        for i in range(m):
            start, end = self.cert.offsets[i], self.cert.offsets[i + 1]
            step = off[start:end].copy()
            if is_spatial(self.packed, i):
                cert.centre[start:end] += step
                continue
            grown[start + layout.TAU] = 1.0 + step[layout.TAU]
            step[layout.TAU] = np.log1p(step[layout.TAU])
            states[i, : end - start] += step
        pose[:3] += off[first : first + 3]
        if n == 6:
            compose(*off[first + 3 :], pose[3:])
        cert.radius[:] = 0.0
        jacobian_of_all(self.packed, pose, states, cert)
        middle = 0.5 * (cert.low + cert.high) / grown
        if n == 6:
            turn = np.zeros((3, 3))
            left_jacobian(off[first + 3 :], turn)
            middle[:, first + 3 :] = middle[:, first + 3 :] @ turn
        return middle

    def share(self, rng: np.random.Generator) -> float:
        """What part of the bound one difference takes, the worst equation."""
        size = len(self.cert.step)
        d = (self.work.reach[:size] + self.work.radius) * rng.uniform(-1.0, 1.0, size)
        v = self.work.radius * rng.choice([-1.0, 1.0], size)
        taken = np.abs(self.inverse @ ((self.jacobian(d) - self.middle) @ v))
        allowed = self.allowed()
        return float((taken / allowed).max())

    def allowed(self) -> np.ndarray:
        """|Y| H[a + r, r], as the prover left it."""
        return np.einsum("kir,ir->k", self.work.effects, self.work.curved) + 1e-13


def test_pairs_of_unknowns_are_single() -> None:
    assert len({tuple(sorted(pair)) for pair in hessian_bounds.PAIRS.tolist()}) == len(hessian_bounds.PAIRS)
