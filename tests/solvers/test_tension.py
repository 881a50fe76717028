"""Tension distributions at poses of library robots, against numpy, HiGHS and each other."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
import pytest

import cases
from cablewright.foundation.errors import InputError, Status, UnknownName
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Model
from cablewright.robot import Robot, load
from cablewright.solvers.tension import METHODS, Quadratic, capacity, structures, tension_distribution, wrench_closure
from oracles import linear_program

RIGID = Fidelity(CableLaw.RIGID)
COUNTS = dict.fromkeys(("jung2020", "jung2020-table1"), cases.often(300, 2000))
COUNTS |= dict.fromkeys(("cogiro", "merlet2023", "paty2021"), cases.often(150, 400))


def model_of(name: str, **changes: object) -> Model:
    return Model(load(name), RIGID, **changes)


def upright(model: Model, count: int, seed: int = cases.SEED) -> np.ndarray:
    """Random poses in the frame; a body upright, where jung2020-table1 is singular, or else a little turned."""
    poses = cases.random_poses(model, count, seed)
    if model.robot.name.startswith("jung"):
        poses[:, 3:] = 0.0
    return poses


def limits(model: Model) -> tuple[np.ndarray, np.ndarray]:
    low, high = np.array([line.tension_limits for line in model.robot.lines]).T
    return low, high


@pytest.mark.parametrize("name", ["jung2020", "cogiro", "merlet2023", "under", "off-axis"])
def test_structure_is_that_of_the_tangents(name: str) -> None:
    robot = {each.name: each for each in cases.robots()}[name]
    model = Model(robot, RIGID)
    poses = cases.random_poses(model, 30)
    A, w = structures(model, poses)
    for row, pose in enumerate(poses):
        wanted = linear_program.structure(robot, pose)
        np.testing.assert_allclose(A[row], wanted[0], atol=1e-12)
        np.testing.assert_allclose(w[row], wanted[1], atol=1e-9)


def test_levers_stand_as_at_the_middle_of_the_limits() -> None:
    model = model_of("paty2021")
    poses = cases.random_poses(model, 20)
    A, _ = structures(model, poses)
    for row, pose in enumerate(poses):
        wanted, _ = linear_program.structure(model.robot, pose, tension=0.5 * (510 + 5150))
        np.testing.assert_allclose(A[row], wanted, atol=1e-6)


@pytest.mark.parametrize("name", COUNTS)
def test_exact_is_the_linear_programs_margin(name: str) -> None:
    model = model_of(name)
    poses = upright(model, COUNTS[name])
    low, high = limits(model)
    found = tension_distribution(model, poses, "exact")
    A, w = structures(model, poses)
    good = np.isfinite(found.margin)
    assert good.mean() > 0.95
    wanted = np.array([linear_program.margin(A[row], w[row], low, high) for row in np.flatnonzero(good)])
    scale = np.maximum(high.max(), np.abs(wanted))
    assert np.abs(found.margin[good] - wanted).max() <= 1e-9 * scale.max()
    np.testing.assert_array_less(np.abs(found.margin[good] - wanted), 1e-9 * scale)
    sure = np.abs(wanted) > 1e-9 * high.max()
    assert (found.feasible[good] == (wanted > 0.0))[sure].all()
    assert 0.1 < found.feasible.mean() < 0.99
    # and its tensions have that margin, and balance
    slack = np.minimum(found.tensions - low, high - found.tensions).min(axis=1)
    np.testing.assert_allclose(slack[good], found.margin[good], atol=1e-9 * high.max())
    left = np.einsum("rnm,rm->rn", A, found.tensions)[good] + w[good]
    assert np.abs(left).max() <= 1e-12 * np.abs(found.tensions[good]).max()


def test_table_1_is_singular_at_every_upright_pose() -> None:
    model = model_of("jung2020-table1")
    poses = upright(model, 100)
    assert (capacity(model, poses).rank == 5).all()
    twist = [0, 0, 0, 0, 0, 1.0]  # nothing holds the yaw
    for method in METHODS:
        found = tension_distribution(model, poses, method, wrench=twist)
        assert not found.feasible.any()
        assert (found.margin == -np.inf).all()
    aside = capacity(model, poses, wrench=twist, length=0.1)
    assert not aside.feasible.any()
    assert tension_distribution(model, poses, "exact").feasible.mean() > 0.5
    poses[:, 3:] = np.random.default_rng(1).normal(0.0, 1e-3, (len(poses), 3))
    assert (
        tension_distribution(model, poses, "exact").feasible.mean() < 0.1
    )  # now some line has to resist a yaw, by a lever of nothing
    assert (capacity(model, poses).rank == 6).all()


@pytest.mark.parametrize("name", COUNTS)
def test_closed_form_is_numpys_and_sets_are_nested(name: str) -> None:
    model = model_of(name)
    poses = upright(model, 300)
    closed, improved, least, exact = (tension_distribution(model, poses, method) for method in METHODS)
    A, w = structures(model, poses)
    low, high = limits(model)
    middle = 0.5 * (low + high)
    good = np.isfinite(closed.margin)
    for row in np.flatnonzero(good):
        # numpy's singular values are relative to the largest: yaw of table 1 is none
        wanted = middle - np.linalg.pinv(A[row], rcond=1e-10) @ (w[row] + A[row] @ middle)
        np.testing.assert_allclose(closed.tensions[row], wanted, rtol=0, atol=1e-9 * np.abs(wanted).max())
    assert (improved.feasible >= closed.feasible).all()
    sure = np.abs(exact.margin) > 1e-9 * high.max()
    assert (exact.feasible >= improved.feasible)[sure].all()
    assert (exact.feasible == least.feasible)[sure].all()
    assert (exact.margin[good] >= closed.margin[good] - 1e-9 * high.max()).all()
    assert closed.feasible.sum() < improved.feasible.sum() <= exact.feasible.sum()
    for each in (improved, least):
        rows = each.feasible
        left = np.einsum("rnm,rm->rn", A[rows], each.tensions[rows]) + w[rows]
        assert np.abs(left).max() <= 1e-9 * high.max()
        assert (each.margin[rows] >= 0.0).all()


def test_least_norm_is_the_inverse_problems() -> None:
    for name in ("cogiro", "merlet2023", "jung2020"):
        model = model_of(name)
        held = cases.poses(model, 20)
        found = tension_distribution(model, held.pose, "least-norm")
        np.testing.assert_allclose(found.tensions, held.tensions, rtol=1e-7)


def improved_by_hand(A: np.ndarray, w: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Pott's loop in numpy: fixed tensions go to the wrench, the others are distributed by the closed form."""
    n, m = A.shape
    free, tensions = np.ones(m, bool), np.zeros(m)
    while True:
        middle = 0.5 * (low + high)[free]
        load = w + A[:, ~free] @ tensions[~free]
        tensions[free] = middle - np.linalg.pinv(A[:, free]) @ (load + A[:, free] @ middle)
        over = np.where(free, np.maximum(low - tensions, tensions - high), 0.0)
        worst = int(np.argmax(over))
        if over[worst] <= 0.0 or free.sum() == n:
            return tensions
        tensions[worst] = np.clip(tensions[worst], low[worst], high[worst])
        free[worst] = False


def test_improved_closed_form_is_potts_loop() -> None:
    model = model_of("jung2020")
    poses = upright(model, 400)
    found = tension_distribution(model, poses, "improved-closed-form")
    A, w = structures(model, poses)
    for row in range(len(poses)):
        wanted = improved_by_hand(A[row], w[row], *limits(model))
        np.testing.assert_allclose(found.tensions[row], wanted, rtol=1e-8, atol=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_limits_and_wrench_scale_together(method: str) -> None:
    model = model_of("jung2020", tension_limits=(10.0, 200.0))
    poses = upright(model, 200)
    wrench = np.array([5.0, -3.0, 8.0, 0.4, 0.3, -0.2])
    weight = np.array([0.0, 0.0, 98.1, 0.0, 0.0, 0.0])  # taken away, so that all that acts is the wrench
    small = tension_distribution(model, poses, method, wrench=wrench + weight)
    large = tension_distribution(
        model_of("jung2020", tension_limits=(70.0, 1400.0)), poses, method, wrench=7 * wrench + weight
    )
    assert (small.feasible == large.feasible).all()
    if method != "least-norm":  # where it is infeasible its answer is soft, and only nearly the least violation
        np.testing.assert_allclose(large.margin, 7.0 * small.margin, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(large.tensions, 7.0 * small.tensions, rtol=1e-8, atol=1e-7)


def test_symmetric_poses_have_one_margin() -> None:
    model = model_of("jung2020")
    rng = np.random.default_rng(5)
    places = rng.uniform([0, 0, 0], [1, 1, 2], (50, 3))
    zero = np.zeros((50, 3))
    images = [
        np.column_stack([sx * places[:, first], sy * places[:, 1 - first], places[:, 2], zero])
        for first, sx, sy in itertools.product((0,), (1, -1), (1, -1))
    ]
    for method in METHODS:
        margins = np.array([tension_distribution(model, each, method).margin for each in images])
        np.testing.assert_allclose(margins, margins[:1].repeat(4, axis=0), rtol=1e-6, atol=1e-8)
    centre = tension_distribution(model, [0.0, 0.0, 0.5], "exact")
    assert centre.tensions.shape == (8,)
    np.testing.assert_allclose(
        np.sort(centre.tensions).reshape(2, 4), np.sort(centre.tensions)[[0, 4]][:, None].repeat(4, 1), rtol=1e-9
    )


@pytest.mark.parametrize("name", ["jung2020", "jung2020-table1", "cogiro", "merlet2023"])
def test_capacity_agrees_with_exact_and_bounds_every_push(name: str) -> None:
    model = model_of(name)
    poses = upright(model, 300)
    low, high = limits(model)
    A, w = structures(model, poses)
    length = 0.3
    found = capacity(model, poses, length=length)
    exact = tension_distribution(model, poses, "exact")
    sure = np.abs(exact.margin) > 1e-9 * high.max()
    assert (found.feasible == exact.feasible)[sure].all()
    rng = np.random.default_rng(11)
    units = np.array([1.0, 1.0, 1.0, length, length, length])[: model.n]
    for row in np.flatnonzero(found.feasible)[:6]:
        margin, nearest = found.margin[row], np.inf
        span = A[row] / units[:, None]
        left, values, _ = np.linalg.svd(span)
        rank = int((values > 1e-9 * values[0]).sum())
        assert rank == found.rank[row]
        for _ in range(cases.often(15, 60)):
            c = left[:, :rank] @ rng.standard_normal(rank)
            c /= np.linalg.norm(c)
            # no plane is nearer than the margin, and a push of the margin along any way can be balanced
            room = linear_program.support(span, low, high, c) - float(c @ (w[row] / units))
            assert room >= margin - 1e-9 * high.max()
            far = linear_program.reach(span, low, high, w[row] / units, c)
            nearest = min(nearest, far)
            assert far >= margin - 1e-7 * high.max()
        assert np.isfinite(nearest)


def facets_by_hand(A: np.ndarray, low: np.ndarray, high: np.ndarray, wrench: np.ndarray) -> float:
    """Least distance of *wrench* from planes across all choices of n - 1 columns, by singular vectors."""
    n, m = A.shape
    nearest = np.inf
    for chosen in itertools.combinations(range(m), n - 1):
        left, values, _ = np.linalg.svd(A[:, chosen])
        if values[-1] > 1e-9:
            for c in (left[:, -1], -left[:, -1]):
                nearest = min(nearest, linear_program.support(A, low, high, c) - float(c @ wrench))
    return nearest


@pytest.mark.parametrize("robot", [load("jung2020"), load("merlet2023"), cases.six_lines()], ids=lambda r: r.name)
def test_capacity_of_a_box_is_that_of_its_worst_vertex(robot: Robot) -> None:
    model = Model(robot, RIGID)
    n = robot.n
    poses = upright(model, 6)
    low, high = limits(model)
    corner_low = np.array([-12.0, -5.0, -20.0, -0.3, -0.1, -0.2])[:n]
    corner_high = np.array([4.0, 9.0, 6.0, 0.1, 0.2, 0.3])[:n]
    found = capacity(model, poses, box=(corner_low, corner_high), length=0.25)
    units = np.array([1.0, 1.0, 1.0, 0.25, 0.25, 0.25])[:n]
    A, w = structures(model, poses, wrench=np.zeros(n))
    for row in range(len(poses)):
        vertices = itertools.product(*zip(corner_low, corner_high, strict=True))
        each = [
            facets_by_hand(A[row] / units[:, None], low, high, (w[row] + np.array(vertex)) / units)
            for vertex in vertices
        ]
        assert found.margin[row] == pytest.approx(min(each), abs=1e-9 * high.max())
        single = capacity(model, poses[row], wrench=corner_high, length=0.25)
        assert single.margin == pytest.approx(each[-1], abs=1e-9 * high.max())


def test_capacity_is_zero_at_the_boundary_and_falls_as_one_pushes() -> None:
    model = model_of("jung2020")
    pose = np.array([0.1, -0.2, 0.5, 0.0, 0.0, 0.0])
    A, w = (part[0] for part in structures(model, pose))
    way = np.array([1.0, 0.5, -0.3, 0.02, 0.01, 0.0])
    far = linear_program.reach(A, *limits(model), w, way)
    edge = capacity(model, pose, wrench=far * way)
    assert edge.margin == pytest.approx(0.0, abs=1e-7)
    assert tension_distribution(model, pose, "exact", wrench=far * way).margin == pytest.approx(0.0, abs=1e-7)
    pushes = [float(capacity(model, pose, wrench=share * far * way).margin) for share in (0.5, 0.9, 1.1, 1.5)]
    assert pushes == sorted(pushes, reverse=True)
    assert pushes[1] > 0.0 > pushes[2]


@pytest.mark.parametrize("name", ["jung2020", "jung2020-table1", "cogiro", "merlet2023"])
def test_closure_is_a_positive_null_vector_of_full_rank(name: str) -> None:
    model = model_of(name)
    poses = upright(model, 100)
    found = wrench_closure(model, poses)
    A, _ = structures(model, poses)
    m = model.m
    for row in range(len(poses)):
        full = np.linalg.matrix_rank(A[row], tol=1e-9) == model.n
        # some null vector with all entries at least one, and so any
        ones = linear_program.margin(A[row], A[row] @ np.ones(m), np.zeros(m), np.full(m, 1e6))
        assert found.feasible[row] == (full and ones >= 0.0)
    rows = found.feasible
    if name == "jung2020":
        assert 0.3 < rows.mean() < 1.0
        np.testing.assert_allclose(found.tensions[rows].mean(axis=1), 1.0)
        np.testing.assert_allclose(found.tensions[rows].min(axis=1), found.margin[rows])
        left = np.einsum("rnm,rm->rn", A[rows], found.tensions[rows])
        assert np.abs(left).max() < 1e-10
        assert (found.margin[~rows] <= 1e-9).all()
    if name == "merlet2023":  # hanging
        assert not rows.any()
    if name == "jung2020-table1":
        assert (found.code == list(Status).index(Status.SINGULAR)).all()


def test_a_diagonal_quadratic_and_a_full_one_agree() -> None:
    model = model_of("jung2020")
    poses = upright(model, 20)
    rng = np.random.default_rng(3)
    diagonal, linear = rng.uniform(0.5, 2.0, 8), rng.uniform(-80.0, 20.0, 8)
    fast = tension_distribution(model, poses, Quadratic(diagonal, linear))
    slow = tension_distribution(model, poses, Quadratic(np.diag(diagonal), linear))
    assert (fast.feasible == slow.feasible).all()
    assert fast.feasible.sum() > 3
    np.testing.assert_allclose(slow.tensions[slow.feasible], fast.tensions[fast.feasible], atol=1e-3)


@dataclass(frozen=True)
class Softest:
    """A smooth maximum: pulls that are all as small as can be."""

    sharpness: float

    def value(self, tensions: np.ndarray) -> float:
        return float(np.sum(tensions**self.sharpness)) ** (1.0 / self.sharpness)

    def gradient(self, tensions: np.ndarray) -> np.ndarray:
        return (tensions / self.value(tensions)) ** (self.sharpness - 1.0)


def test_any_convex_objective_is_made_least() -> None:
    model = model_of("cogiro")
    poses = cases.poses(model, 5).pose
    objective = Softest(4.0)
    found = tension_distribution(model, poses, objective)
    assert found.feasible.all()
    A, w = structures(model, poses)
    np.testing.assert_allclose(np.einsum("rnm,rm->rn", A, found.tensions) + w, 0.0, atol=1e-8)
    rng = np.random.default_rng(1)
    for row in range(len(poses)):
        others = [tension_distribution(model, poses[row], method).tensions for method in ("least-norm", "exact")]
        for other in others:
            for share in rng.uniform(0.0, 1.0, 5):  # the set is convex: nothing between is better
                mixed = found.tensions[row] + share * (other - found.tensions[row])
                assert objective.value(mixed) >= objective.value(found.tensions[row]) * (1.0 - 1e-8)


def test_one_pose_and_many_threads_give_the_same() -> None:
    model = model_of("jung2020")
    poses = upright(model, 300)
    for method in METHODS:
        many, few = tension_distribution(model, poses, method), tension_distribution(model, poses[:10], method)
        np.testing.assert_array_equal(many.tensions[:10], few.tensions)
        single = tension_distribution(model, poses[3], method)
        np.testing.assert_array_equal(single.tensions, many.tensions[3])
        assert single.margin.shape == ()
        assert single.feasible == many.feasible[3]
    assert capacity(model, poses).margin[3] == capacity(model, poses[3]).margin


def test_retraction_by_row_is_the_retracted_robot() -> None:
    model = model_of("jung2020")
    poses = upright(model, 6)
    lengths = np.linspace(1.2, 2.0, 6)
    together = tension_distribution(model, poses, retraction=lengths)
    for row, length in enumerate(lengths):
        own = tension_distribution(Model(model.robot.retracted(float(length)), RIGID), poses[row])
        assert together.margin[row] == pytest.approx(float(own.margin), rel=1e-9)
    wrenches = np.random.default_rng(2).normal(0.0, 3.0, (6, 6))
    own_wrench = tension_distribution(model, poses, retraction=lengths, wrench=wrenches)
    assert not np.allclose(own_wrench.margin, together.margin)
    one = tension_distribution(model, poses[2], retraction=lengths[2], wrench=wrenches[2])
    assert one.margin == pytest.approx(own_wrench.margin[2], rel=1e-9)


def test_fewer_lines_than_degrees_of_freedom_balance_only_by_chance() -> None:
    model = model_of("grab-four-lines")
    pose = np.array([0.2, 0.1, 1.0, 0.1, 0.0, 0.0])
    assert tension_distribution(model, pose, "exact").margin == -np.inf
    A, _ = structures(model, pose)
    weight = -model.robot.platform.mass * model.robot.scene.gravity
    low, high = limits(model)
    middle = 0.5 * (low + high)
    made = -A[0] @ middle  # a wrench that these tensions do balance, less the weight
    _, w = structures(model, pose, wrench=np.zeros(6))
    assert w[0, 2] == pytest.approx(weight)
    found = tension_distribution(model, pose, wrench=made - w[0])
    np.testing.assert_allclose(found.tensions, middle)
    assert found.margin == pytest.approx(np.min(0.5 * (high - low)))


def test_a_pose_without_directions_says_why() -> None:
    inside = model_of("merlet2023")
    x, y, z = inside.robot.lines[0].exit_point
    found = tension_distribution(inside, [[x + 0.04, y, z], [x, y, z - 1.0]])
    assert [Status.of(int(code)) for code in found.code] == [Status.INSIDE_SHEAVE, Status.UNDER_EXIT]
    assert (found.margin == -np.inf).all()
    assert np.isnan(found.tensions).all()
    assert (capacity(inside, [[x, y, z - 1.0]]).margin == -np.inf).all()


def test_bad_input_is_one_clear_line() -> None:
    model = model_of("jung2020")
    pose = [0.0, 0.0, 1.0]
    with pytest.raises(InputError, match="method = 3: one of closed-form"):
        tension_distribution(load("jung2020"), [0.2, 0.1, 0.9], 3)
    with pytest.raises(UnknownName, match="did you mean 'closed-form'"):
        tension_distribution(model, pose, "close-form")
    with pytest.raises(InputError, match="lowest < highest"):
        model_of("jung2020", tension_limits=(200.0, 10.0))
    with pytest.raises(InputError, match="straight lines"):
        tension_distribution(Model(load("jung2020")), pose)
    with pytest.raises(InputError, match="wrench"):
        tension_distribution(model, pose, wrench=[1.0, 2.0])
    with pytest.raises(InputError, match="positive"):
        tension_distribution(model, pose, Quadratic(np.zeros(8)))
    with pytest.raises(InputError, match="eigenvalue"):
        tension_distribution(model, pose, Quadratic(-np.eye(8)))
    with pytest.raises(InputError, match="8 lines"):
        tension_distribution(model, pose, Quadratic(np.ones(3)))
    with pytest.raises(InputError, match="lowest <= highest"):
        capacity(model, pose, box=(np.ones(6), np.zeros(6)))
    with pytest.raises(InputError, match="give one"):
        capacity(model, pose, box=(np.zeros(6), np.ones(6)), wrench=np.zeros(6))
    with pytest.raises(InputError, match="length"):
        capacity(model, pose, length=0.0)
    with pytest.raises(InputError, match="retraction"):
        tension_distribution(model, pose, retraction=3.0)
