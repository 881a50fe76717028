"""The enclosures of a line's equations hold: at random points of random boxes with 40 digits, and around `line`'s."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp, mpf

import cases
from cablewright.kernels import layout
from cablewright.kernels.statics import platform_enclosure
from cablewright.kernels.statics.line import upright as kernel
from cablewright.kernels.statics.line.enclosure import enclose_jacobian, enclose_residual
from cablewright.models.fidelity import CableLaw
from cablewright.models.statics import Model
from cablewright.solvers.forward import solve_forward
from oracles.platform import exponential

MODELS = list(cases.models(CableLaw.ELASTIC, CableLaw.CATENARY))
HANGING = [  # slack lines differ from taut ones where cables have weight
    pytest.param(each, slack, id=f"{cases.name(each)}-{'slack' if slack else 'taut'}")
    for each in MODELS
    for slack in (False, True)
    if not slack or each.fidelity.cable is CableLaw.CATENARY
]
SIZES = (0.0, 1e-12, 1e-6, 1e-3, 1e-2, 0.1)


def span(h: mpf, v: mpf, length: mpf, weight: mpf, compliance: mpf) -> tuple[mpf, mpf]:
    """Where a hanging span that starts with the tension (h, v) ends: the textbook's formulas."""
    t0 = mp.hypot(h, v)
    if weight == 0:
        return h * length * (compliance + 1 / t0), v * length * (compliance + 1 / t0)
    v1 = v + weight * length
    x = h * compliance * length + h / weight * (mp.asinh(v1 / abs(h)) - mp.asinh(v / abs(h)))
    return x, compliance * length * (v + v1) / 2 + (mp.hypot(h, v1) - t0) / weight


def equations(row: np.ndarray, y: list[mpf], x: mpf, z: mpf, length: mpf) -> list[mpf]:
    """The equations of one line as `docs/theory/statics.md` has them, from a packed row."""
    number = [mpf(float(value)) for value in row]
    count, side = int(row[layout.UNKNOWNS]), number[layout.SIDE]
    phi, t, free = y[0], mp.exp(y[1]), y[2]
    dead = y[3] if count > 3 else number[layout.DEAD_LENGTH]
    psi = y[4] if count > 4 else -side * mp.pi / 2
    beta = y[5] if count > 5 else mpf(0)
    radius, weight, lever = number[layout.RADIUS], number[layout.WEIGHT], number[layout.LEVER]
    hx, hz = lever * mp.cos(beta), lever * mp.sin(beta)
    ends = span(t * mp.cos(phi), t * mp.sin(phi), free, weight, number[layout.FREE_COMPLIANCE])
    arc = radius * (side * (psi - phi) + mp.pi) / (1 + t * number[layout.ARC_COMPLIANCE])
    found = [
        hx - side * radius * mp.sin(phi) + ends[0] - x,
        hz + side * radius * mp.cos(phi) + ends[1] - z,
        free + dead + arc - length,
    ]
    if count > 3:
        down = t * (mp.cos(psi) if count > 4 else 0), t * mp.sin(psi)
        ends = upright(down[1], dead, weight, number[layout.DEAD_COMPLIANCE]) if count == 4 else None
        ends = ends or span(*down, dead, weight, number[layout.DEAD_COMPLIANCE])
        found.append(hz - side * radius * mp.cos(psi) + ends[1] - number[layout.WINCH_Z])
        found.append(hx + side * radius * mp.sin(psi) + ends[0] - number[layout.WINCH_X])
    if count > 5:
        pull = number[layout.LEVER_MOMENT] / (lever * t)
        across = (mp.sin(phi) + mp.sin(psi)) * mp.cos(beta) - (mp.cos(phi) + mp.cos(psi)) * mp.sin(beta)
        found.append(across - pull * mp.cos(beta))
    return found[:count]


def upright(v: mpf, length: mpf, weight: mpf, compliance: mpf) -> tuple[mpf, mpf]:
    """As `span`, of one that hangs upright."""
    v1 = v + weight * length
    stretch = compliance * length * (v + v1) / 2
    return mpf(0), stretch + ((abs(v1) - abs(v)) / weight if weight else length * mp.sign(v))


def some_lines(model: Model, rng: np.random.Generator, slack: bool) -> list[tuple[np.ndarray, np.ndarray, float]]:
    """A line of each of four poses: its packed row, solved unknowns and length."""
    held = cases.poses(model, 4)
    lengths = held.lengths.copy()
    if slack and model.fidelity.cable is CableLaw.CATENARY:
        lengths[:, 0] += rng.uniform(0.0, 0.3, 4)
        held = solve_forward(model, lengths, guess=held.pose)
    rows = held.packed.lines[0]
    picked = [0, *rng.integers(0, model.m, 3)]
    return [(rows[i], held.states[j, i], float(held.lengths[j, i])) for j, i in enumerate(picked) if held.ok[j]]


def box(row: np.ndarray, y: np.ndarray, size: float) -> np.ndarray:
    """Half widths of a box for the unknowns, of that relative size."""
    radius = np.zeros(layout.STATE)
    count = int(row[layout.UNKNOWNS])
    radius[:count] = 0.3 * size * (1.0 + np.abs(y[:count]))
    return radius


def jacobian_of(row: np.ndarray, y: np.ndarray, radius: np.ndarray) -> tuple[np.ndarray, np.ndarray, tuple]:
    count = int(row[layout.UNKNOWNS])
    low, high = np.full((2, count, count + 1), np.nan)[:, :, :count]  # parts of larger arrays, as the kernels pass them
    ends = enclose_jacobian(row, y, radius, low, high)
    return low, high, ends


@pytest.mark.parametrize(("model", "slack"), HANGING)
def test_the_residual_is_in_its_enclosure(model: Model, slack: bool) -> None:
    rng = np.random.default_rng(11)
    with mp.workdps(40):
        for row, solved, length in some_lines(model, rng, slack):
            for size in SIZES[:5]:  # the equations hold anywhere, not only where they are solved
                count = int(row[layout.UNKNOWNS])
                y = solved.copy()
                y[:count] += box(row, y, size)[:count] * rng.uniform(-1, 1, count)
                x, z = rng.uniform(0.1, 9.0), rng.uniform(-9.0, 9.0)
                out = np.full((count, 2), np.nan)
                h, v = enclose_residual(row, y, (x, x), (z, z), (length, length), out)
                unknowns = [mpf(float(value)) for value in y]
                exact = equations(row, unknowns, mpf(x), mpf(z), mpf(length))
                for (low, high), value in zip(out, exact, strict=True):
                    assert mpf(float(low)) <= value <= mpf(float(high))
                    assert high - low < 1e-11
                assert mpf(h[0]) <= mp.exp(unknowns[1]) * mp.cos(unknowns[0]) <= mpf(h[1])
                assert mpf(v[0]) <= mp.exp(unknowns[1]) * mp.sin(unknowns[0]) <= mpf(v[1])


@pytest.mark.parametrize(("model", "slack"), HANGING)
def test_the_jacobian_is_in_its_enclosure(model: Model, slack: bool) -> None:
    """Central differences with 60 digits, at corners and inside of boxes; the miss of the difference is 1e-25."""
    rng = np.random.default_rng(12)
    step = mpf(10) ** -15
    with mp.workdps(60):
        for row, solved, length in some_lines(model, rng, slack):
            count = int(row[layout.UNKNOWNS])
            for size in rng.permutation(SIZES)[: cases.often(1, 2)]:  # of another line other sizes
                radius = box(row, solved, size)
                low, high, _ = jacobian_of(row, solved, radius)
                for where in (rng.choice([-1.0, 1.0], count), rng.uniform(-1, 1, count)):
                    at = [mpf(float(a)) + mpf(float(b)) for a, b in zip(solved, radius[:count] * where, strict=False)]
                    for k in range(count):
                        ends = [
                            equations(row, [a + sign * step * (j == k) for j, a in enumerate(at)], 1, 1, mpf(length))
                            for sign in (1, -1)
                        ]
                        for i in range(count):
                            exact = (ends[0][i] - ends[1][i]) / (2 * step)
                            slip = mpf(10) ** -22 * (1 + abs(exact))
                            assert mpf(float(low[i, k])) - slip <= exact <= mpf(float(high[i, k])) + slip


@pytest.mark.parametrize("model", MODELS, ids=cases.name)
def test_thin_boxes_are_near_what_the_solver_computes(model: Model) -> None:
    """They enclose the same equations: those that `line.system` evaluates in floats."""
    rng = np.random.default_rng(13)
    for row, y, length in some_lines(model, rng, slack=True):
        count = int(row[layout.UNKNOWNS])
        jacobian, columns = np.full((6, 6), np.nan), np.full((6, 3), np.nan)
        residual = columns[:, 0]  # as solvers pass it: one compiled signature
        h, v = kernel.system(row, y, 2.0, -1.0, length, jacobian, residual)
        out = np.full((count, 2), np.nan)
        ends = enclose_residual(row, y, (2.0, 2.0), (-1.0, -1.0), (length, length), out)
        low, high, again = jacobian_of(row, y, np.zeros(layout.STATE))
        np.testing.assert_allclose(out.mean(axis=1), residual[:count], rtol=0, atol=1e-12)
        np.testing.assert_allclose(0.5 * (low + high), jacobian[:count, :count], rtol=1e-11, atol=1e-11)
        np.testing.assert_allclose(np.mean(ends, axis=1), [h, v], rtol=1e-13, atol=1e-12)
        np.testing.assert_allclose(np.mean(again, axis=1), [h, v], rtol=1e-13, atol=1e-12)


@pytest.mark.parametrize("size", [0.0, 1e-300, 1e-12, 1e-5, 0.9e-4, 1.1e-4, 1e-3, 0.1, 1.0, 3.0, 3.14159, 6.0, 50.0])
def test_the_rotation_is_in_its_enclosure(size: float) -> None:
    rng = np.random.default_rng(14)
    for axis in (*np.eye(3), *rng.normal(size=(10, 3))):
        vector = size * axis / np.linalg.norm(axis)
        out = np.full((3, 3, 2), np.nan)
        platform_enclosure.enclose_rotation(np.concatenate([np.zeros(3), vector]), out)
        with mp.workdps(60):
            exact = exponential([mpf(float(value)) for value in vector])
            for i in range(3):
                for j in range(3):
                    assert mpf(float(out[i, j, 0])) <= exact[i, j] <= mpf(float(out[i, j, 1]))
        assert (out[..., 1] - out[..., 0]).max() < 1e-12


def test_a_rotation_that_is_not_finite_is_anything() -> None:
    out = np.zeros((3, 3, 2))
    platform_enclosure.enclose_rotation(np.array([0.0, 0.0, 0.0, np.nan, 0.0, 0.0]), out)
    assert not np.isfinite(out[1, 1]).any()


def test_a_turned_body_is_turned_as_the_chart_says() -> None:
    """A point turned by increments within omega, and its derivatives by each of them, are in the enclosure."""
    rng = np.random.default_rng(15)
    for omega in (1e-12, 1e-6, 1e-3, 0.3):
        for _ in range(10):
            pose, point = np.concatenate([np.zeros(3), rng.normal(size=3)]), rng.normal(size=3)
            rotation, arm, moved = np.zeros((3, 3, 2)), np.zeros((3, 2)), np.zeros((3, 2))
            platform_enclosure.enclose_rotation(pose, rotation)
            platform_enclosure.turn(*point, omega, rotation, arm)
            increment = rng.dirichlet(np.ones(3)) * omega * rng.choice([-1.0, 1.0], 3)
            with mp.workdps(60):
                place = exponential([mpf(float(value)) for value in pose[3:]]) * mp.matrix(list(map(mpf, point)))
                given = [mpf(float(value)) for value in increment]
                held(arm, exponential(given) * place)
                for k in range(3):
                    platform_enclosure.along(3 + k, omega, arm, moved)
                    step = mpf(10) ** -20
                    more, less = ([a + s * step * (j == k) for j, a in enumerate(given)] for s in (1, -1))
                    held(moved, (exponential(more) - exponential(less)) * place / (2 * step))


def held(enclosure: np.ndarray, vector: mp.matrix) -> None:
    for k in range(3):
        slip = mpf(10) ** -35
        assert mpf(float(enclosure[k, 0])) - slip <= vector[k] <= mpf(float(enclosure[k, 1])) + slip
