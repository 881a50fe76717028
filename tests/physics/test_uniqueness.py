"""One equilibrium: every inequality of docs/theory/uniqueness.md, at random parameters over wide ranges.

First the map from end force to end position (`oracles.monotone`, mpmath), then the bounds on the distance to the
equilibrium against solved equilibria, then many starts for the same lengths.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from mpmath import mp, mpf

import cases
from cablewright.kernels import batches, layout
from cablewright.kernels.statics import equilibrium, forward
from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot, load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from oracles.monotone import MonotoneLine, flexibility

DIGITS = 30
KINDS = ("eyelet", "eyelet, dead span", "over", "over, dead span", "under")
MERLET = load("merlet2023")
STARTS = cases.often(100, 500)


def between(rng: np.random.Generator, low: float, high: float) -> mpf:
    """A number between *low* and *high*, its logarithm uniform."""
    return mpf(10 ** rng.uniform(np.log10(low), np.log10(high)))


def random_line(rng: np.random.Generator, kind: str) -> tuple[MonotoneLine, mpf]:
    """A line, and the size of its tension: w L / T from 1e-6 to 1e4, strain from 1e-7 to a third."""
    while True:
        length, tension = between(rng, 0.3, 100.0), between(rng, 0.1, 1e5)
        weight = tension / length * between(rng, 1e-6, 1e4)
        compliance = 1 / (between(rng, 3.0, 1e7) * max(tension, weight * length))
        radius = length * between(rng, 1e-6, 0.2) if "eyelet" not in kind else mpf(0)
        drop = length * between(rng, 1e-3, 0.5) if "dead" in kind else mpf(0)
        line = MonotoneLine(length, weight, compliance, radius, -1 if kind == "under" else 1, drop)
        if modulus(line) > 0:
            return line, tension


def modulus(line: MonotoneLine) -> mpf:
    """Of an under line on the half-space of horizontal pulls over 2 w r the sheave takes twice as much."""
    return line.modulus - line.skew if line.side < 0 else line.modulus


def random_force(rng: np.random.Generator, line: MonotoneLine, tension: mpf) -> mp.matrix:
    """A force on the free end, in space: taut, or (half of them) with the lowest point somewhere on the line."""
    turn, slope = rng.uniform(-np.pi, np.pi), rng.uniform(-1.0, 1.0) * np.pi / 2
    h, up = tension * mp.cos(slope) * between(rng, 1e-4, 1.0), tension * mp.sin(slope)
    if rng.random() < 0.5:
        up += line.weight * line.length * mpf(rng.random())
    if line.side < 0:  # the half-space x > 2 w r, in which the statement on these lines holds
        turn *= 0.49
        h += 2 * line.weight * line.radius / mp.cos(turn)
    return mp.matrix([h * mp.cos(turn), h * mp.sin(turn), up])


def extremes(matrix: mp.matrix) -> tuple[mpf, mpf]:
    values = mp.eigsy((matrix + matrix.T) / 2, eigvals_only=True)
    return values[0], values[len(values) - 1]


def dot(a: Sequence[mpf], b: Sequence[mpf]) -> mpf:
    return sum(x * y for x, y in zip(a, b, strict=True))


@pytest.mark.parametrize("kind", KINDS)
def test_the_jacobian_is_the_one_of_the_proof(kind: str) -> None:
    rng = np.random.default_rng(1)
    for _ in range(25):
        line, tension = random_line(rng, kind)
        force = random_force(rng, line, tension)
        h, up = mp.hypot(force[0], force[1]), force[2]
        with mp.workdps(60):
            step = h * mpf(10) ** -20
            ends = [line.end(h + i * step, up + k * step) for i, k in ((1, 0), (-1, 0), (0, 1), (0, -1))]
            found = [[(ends[2 * k][i] - ends[2 * k + 1][i]) / (2 * step) for k in (0, 1)] for i in (0, 1)]
            claimed = line.jacobian(h, up)
            size = max(abs(x) for x in claimed)
            assert max(abs(found[i][k] - claimed[i, k]) for i in (0, 1) for k in (0, 1)) < 1e-15 * size


@pytest.mark.parametrize("kind", KINDS)
def test_the_symmetric_part_is_never_under_the_modulus(kind: str) -> None:
    rng = np.random.default_rng(2)
    with mp.workdps(DIGITS):
        for _ in range(cases.often(80, 300)):
            line, tension = random_line(rng, kind)
            force = random_force(rng, line, tension)
            jacobian = line.jacobian(mp.hypot(force[0], force[1]), force[2])
            assert extremes(jacobian)[0] >= modulus(line) * (1 - mpf(10) ** -15)
            factor = 2 if line.side < 0 else 1
            assert abs(jacobian[0, 1] - jacobian[1, 0]) / 2 <= factor * line.skew + mpf(10) ** -15 * line.compliance


@pytest.mark.parametrize("kind", KINDS)
def test_two_forces_and_their_ends_are_strongly_monotone(kind: str) -> None:
    """Also across the axis of the swivel, near to it, and over long ways through every regime."""
    rng = np.random.default_rng(3)
    with mp.workdps(DIGITS):
        for number in range(cases.often(60, 200)):
            line, tension = random_line(rng, kind)
            first, second = (random_force(rng, line, tension * between(rng, 1e-3, 1.0)) for _ in range(2))
            if number % 3 == 0 and line.side > 0:  # from one side of the axis to the other
                second = mp.matrix([-x * between(rng, 1e-6, 1.0) for x in first[:2]] + [first[2]])
            apart, moved = first - second, line.at(first) - line.at(second)
            assert dot(apart, moved) >= modulus(line) * dot(apart, apart) * (1 - mpf(10) ** -12)


def test_without_stretch_the_ends_are_still_strictly_monotone() -> None:
    rng = np.random.default_rng(4)
    with mp.workdps(DIGITS):
        for _ in range(200):
            line, tension = random_line(rng, "eyelet")
            line = replace(line, compliance=mpf(0))
            first, second = random_force(rng, line, tension), random_force(rng, line, tension)
            assert dot(first - second, line.at(first) - line.at(second)) > 0


@pytest.mark.parametrize("kind", KINDS[:-1])
def test_no_jacobian_nearby_is_over_the_steepest(kind: str) -> None:
    rng = np.random.default_rng(5)
    with mp.workdps(DIGITS):
        for _ in range(cases.often(40, 150)):
            line, tension = random_line(rng, kind)
            force = random_force(rng, line, tension)
            reach = min(line.lowest(force), mp.hypot(force[0], force[1])) * between(rng, 1e-6, 0.999)
            bound = line.steepest(force, reach)
            way = mp.matrix(rng.normal(size=3).tolist())
            near = force + way * (reach * mpf(rng.random()) / mp.norm(way))
            assert extremes(line.jacobian(mp.hypot(near[0], near[1]), near[2]))[1] <= bound * (1 + mpf(10) ** -15)


def test_a_flexibility_nearby_is_within_its_factor() -> None:
    """Lemma of the metric bound: eta C <= DP(f') <= C / eta on the lens |d| <= B, |d x t(s)| <= B_across.

    Proof. If the unit vector t' makes the angle chi with t, then for every b > 0, as its 2 x 2 determinant is zero,
    I - t' t'^T >= cos^2 chi b / (sin^2 chi + b) (I - t t^T) - b t t^T. Take b = (1 - eta) c |t'|, use sin chi <= p and
    (1 - q) |t| <= |t'| <= (1 + q) |t|. Compare c I + (I - t t^T) / |t| with its value at t' for each s, both ways.
    """
    rng = np.random.default_rng(6)
    tight = mpf(10)
    with mp.workdps(DIGITS):
        for _ in range(cases.often(80, 300)):
            line, tension = random_line(rng, "eyelet")
            force = random_force(rng, line, tension)
            lowest = line.lowest(force)
            change = lowest * between(rng, 1e-6, 0.5) * mp.matrix(rng.normal(size=3).tolist())
            if mp.norm(change) >= lowest:
                continue
            h = mp.hypot(force[0], force[1])
            e, f = force[0] / h, force[1] / h
            frame = mp.matrix([[e, 0, -f], [f, 0, e], [0, 1, 0]])
            ends = [force, force - mp.matrix([0, 0, line.weight * line.length])]
            towards = [x / mp.norm(x) for x in ends]
            middle = (towards[0] + towards[1]) / mp.norm(towards[0] + towards[1])
            beside = size(cross(change, middle)) + size(change) * size(cross(towards[0], middle))
            eta = holds_over(size(change) / lowest, beside / lowest, line.compliance * lowest)
            near = force + change
            g = mp.hypot(near[0], near[1])
            other = mp.matrix([[near[0] / g, 0, -near[1] / g], [near[1] / g, 0, near[0] / g], [0, 1, 0]])
            here = frame * flexibility(h, ends[1][2], line.length, line.weight, line.compliance) * frame.T
            there = other * flexibility(g, near[2] - line.weight * line.length, *shape(line)) * other.T
            assert extremes(there - eta * here)[0] >= -(mpf(10) ** -15) * extremes(here)[1]
            assert extremes(here - eta * there)[0] >= -(mpf(10) ** -15) * extremes(there)[1]
            tight = min(tight, eta)
        assert tight < 0.5


def shape(line: MonotoneLine) -> tuple[mpf, mpf, mpf]:
    return line.length, line.weight, line.compliance


def cross(a: mp.matrix, b: mp.matrix) -> mp.matrix:
    return mp.matrix([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def size(a: mp.matrix) -> mpf:
    return mp.norm(a)


def holds_over(q: mpf, beside: mpf, strain: mpf) -> mpf:
    """The largest eta on a grid: lens of relative half-length *q* and half-width *beside*, least strain *strain*."""
    if q >= 1 or beside >= 1 - q:
        return mpf(0)
    p = beside / (1 - q)
    for k in range(1, 200):
        eta = 1 - mpf(k) / 200
        if eta <= (1 - q) * (1 - p * p) / (1 + p * p / ((1 - eta) * strain * (1 - q))):
            return eta
    return mpf(0)


def test_an_elastic_arc_moves_the_length_by_little() -> None:
    """What an elastic arc takes back, between two forces: the estimate behind its uniqueness.

    Proof. For a rigid arc and fixed f, |dP/dL| = 1 + c T^2 / (T + w r cos phi) <= 1 + c T. With (7), two solutions
    satisfy 0 >= sum of m |df|^2 - (1 + c T) |d delta| |df|. Let t = (H, V) = f - w l e. |T - T'| <= |dt| and
    min(T, T') |phi - phi'| <= (pi/2) |dt| give |d delta| <= (3 pi/2) r c |dt|. From |dl| <= r |d phi| + |d delta|
    follows |dt| <= |df| + w |d delta| + (pi w r / 2 T) |dt|, and the last factor is at most 1/2. Together |d delta| <=
    3 pi r c / (1 - 3 pi c w r) |df| < m |df| / (1 + c T), for (pi + 1/2) + 1.101 * 3 pi / 0.9905 < 14.2.
    """
    rng = np.random.default_rng(7)
    with mp.workdps(DIGITS):
        for _ in range(cases.often(80, 300)):
            line, tension = random_line(rng, "over")
            c, w, r = line.compliance, line.weight, line.radius
            if 3 * mp.pi * c * w * r >= 0.5:
                continue
            line = replace(line, elastic_arc=True)
            ends, tensions, taken, spare = [], [], [], []
            first = random_force(rng, line, tension)
            way = mp.matrix(rng.normal(size=3).tolist()) * tension * between(rng, 1e-6, 1.0)
            for force in (first, first + way):
                h = mp.hypot(force[0], force[1])
                v = line.start(h, force[2])
                t = mp.hypot(h, v)
                arc = r * (mp.pi / 2 - mp.atan2(v, h))
                ends.append(force)
                tensions.append(t)
                taken.append(arc * c * t / (1 + c * t))
                spare.append(abs(line.free(h, v) - (line.length - arc + taken[-1])))
            assert max(spare) <= mpf(10) ** -20 * line.length
            if min(tensions) < mp.pi * w * r:
                continue
            share = 3 * mp.pi * r * c / (1 - 3 * mp.pi * c * w * r)
            assert abs(taken[0] - taken[1]) <= share * size(ends[0] - ends[1]) * (1 + mpf(10) ** -15)
            rigid = replace(line, elastic_arc=False)  # how far the end goes with the length, the force held
            longer = replace(rigid, length=line.length + taken[0])
            h, up = mp.hypot(first[0], first[1]), first[2]
            most = max(mp.hypot(h, x.start(h, up)) for x in (rigid, longer))
            moved = size(longer.at(first) - rigid.at(first))
            assert moved <= (1 + c * most) * taken[0] * (1 + mpf(10) ** -9)


@pytest.mark.parametrize("kind", ["eyelet, dead span", "over, dead span"])
def test_a_taut_dead_span_bounds_what_force_and_length_do(kind: str) -> None:
    """How fast the tension changes with the end force, and the end with the length, above the least tension."""
    rng = np.random.default_rng(13)
    checked = 0
    with mp.workdps(50):
        for _ in range(cases.often(50, 200)):
            line, tension = random_line(rng, kind)
            force = random_force(rng, line, tension)
            h, up, c = mp.hypot(force[0], force[1]), force[2], line.compliance
            t = mp.hypot(h, line.start(h, up))
            if t < line.weight * line.longest_dead * (1 + mpf(10) ** -6):
                continue
            checked += 1
            step = mpf(10) ** -20
            way = rng.normal(size=2)
            way = [mpf(x) / mpf(np.hypot(*way)) * step * h for x in way]
            other = mp.hypot(h + way[0], line.start(h + way[0], up + way[1]))
            fastest = (1 + line.radius / line.longest_dead) / (1 - line.kappa)
            assert abs(other - t) <= fastest * step * h * (1 + mpf(10) ** -9)
            longer = replace(line, length=line.length * (1 + step))
            moved = mp.hypot(*(a - b for a, b in zip(longer.end(h, up), line.end(h, up), strict=True)))
            assert moved <= (1 + c * t) / (1 - line.kappa) * line.length * step * (1 + mpf(10) ** -9)
    assert checked > 12


# The bounds on the distance to the equilibrium


def built(sheave: str, dead: bool) -> Model:
    """merlet2023 with eyelets or swivels, its dead spans modelled or not."""
    lines = MERLET.lines
    if not dead:
        lines = tuple(line.model_copy(update={"winch_exit": None}) for line in lines)
    return Model(MERLET.model_copy(update={"lines": lines}), Fidelity(sheave=SheaveLaw(sheave)))


def monotone_lines(model: Model, lengths: np.ndarray) -> list[MonotoneLine]:
    found = []
    for row, length in zip(model.packed.lines, lengths, strict=True):
        modelled = row[layout.UNKNOWNS] > 3
        constant = 0.0 if modelled else row[layout.DEAD_LENGTH]
        radius = row[layout.RADIUS]
        drop = mpf(-row[layout.WINCH_Z]) if modelled else mpf(0)
        numbers = (length - constant, row[layout.WEIGHT], row[layout.FREE_COMPLIANCE], radius)
        found.append(MonotoneLine(*(mpf(x) for x in numbers), 1, drop))
    return found


def end_forces(held: Equilibrium) -> np.ndarray:
    """Force of the platform on each line, N, world: (m, 3)."""
    rows = held.packed.lines[0]
    out = held.pose[:2] - rows[:, :2]
    out /= np.linalg.norm(out, axis=1)[:, None]
    tension, phi = np.exp(held.states[:, layout.TAU]), held.states[:, layout.PHI]
    up = tension * np.sin(phi) + rows[:, layout.WEIGHT] * held.states[:, layout.FREE]
    return np.column_stack([(tension * np.cos(phi))[:, None] * out, up])


def ends_of(model: Model, lines: list[MonotoneLine], forces: np.ndarray) -> np.ndarray:
    ends = np.array([[float(x) for x in line.at(f.tolist())] for line, f in zip(lines, forces, strict=True)])
    return ends + model.packed.lines[:, :3]


def global_bound(
    lines: list[MonotoneLine], forces: np.ndarray, off: np.ndarray, missing: float
) -> tuple[np.ndarray, float]:
    """Theorem 5: how far forces (each) and the point are at most from the one equilibrium.

    *off* (m, 3) is from the point to each line's end, *missing* (N) the size of the unbalanced force.

    Proof. Let Δ_i = f_i - f_i⋆; their sum is zero. Let D_i be the mean of P_i' over the segment from f_i⋆ to f_i (a
    jump only helps). So p_i - X⋆ = D_i Δ_i, and

    E = sum of Δ_i · D_i Δ_i = sum of Δ_i · (p_i - X⋆) = sum of Δ_i · (p_i - Y)
    sum of m_i |Δ_i|² <= E <= sum of r_i |Δ_i| <= S √(sum of m_i |Δ_i|²)

    So the sum of m_i |Δ_i|² is at most S², and E <= S². Also (√m_i |Δ_i|) lies in the ball of radius S/2 about (r_i /
    (2 √m_i)), which gives B_i. For a symmetric D with 0 < D <= Λ, |D Δ|² <= Λ Δ · D Δ. Summed over the lines, the sum
    of |p_i - X⋆|² / Λ_i is at most E. The other form needs one line: |p_j - X⋆| <= √Λ_j S + s_j |Δ_j|. For eyelets let
    K_i be the inverse of D_i. The sum of K_i (p_i - X⋆) is zero, so by Pythagoras

    sum of (p_i - Y) · K_i (p_i - Y) = E + (X⋆ - Y) · (sum of K_i) (X⋆ - Y)

    The left side is at most S² as K_i <= 1/m_i, and the sum of K_i is at least the sum of 1/Λ_i. Lines with B_i too
    large have Λ_i infinite and add nothing.
    """
    c = np.array([float(line.modulus) for line in lines])
    s = np.array([float(line.skew) for line in lines])
    r = np.linalg.norm(off, axis=1)
    extra = np.zeros(len(lines))
    if missing > 0.0:  # the line that takes it with the least effect
        reach = [
            float(line.steepest(f.tolist(), mpf(missing))) + k for line, f, k in zip(lines, forces, s, strict=True)
        ]
        taker = int(np.argmin(np.array(reach) / np.sqrt(c)))
        r[taker] += reach[taker] * missing
        extra[taker] = missing
    whole = np.sqrt((r**2 / c).sum())
    radii = 0.5 * (r / c + whole / np.sqrt(c)) + extra
    steep = np.array(
        [float(line.steepest(f.tolist(), mpf(b))) for line, f, b in zip(lines, forces, radii, strict=True)]
    )
    if (s == 0.0).all():
        return radii, whole / np.sqrt((1.0 / steep).sum()) if np.isfinite(steep).any() else np.inf
    return radii, float((r + whole * (np.sqrt(steep) + s / np.sqrt(c))).min())


@pytest.mark.parametrize("dead", [False, True])
@pytest.mark.parametrize("sheave", ["eyelet", "swivel"])
def test_the_global_bound_covers_the_distance_to_the_equilibrium(sheave: str, dead: bool) -> None:
    model = built(sheave, dead)
    rng = np.random.default_rng(8)
    held = cases.poses(model, 6)
    lengths = held.lengths.copy()
    lengths[3:, 0] += [0.01, 0.1, 0.5]  # slack
    truth = solve_forward(model, lengths).checked()
    finite, tightest = 0, np.inf
    for row in range(len(lengths)):
        exact = truth[row]
        lines, forces = monotone_lines(model, lengths[row]), end_forces(exact)
        assert np.abs(ends_of(model, lines, forces) - exact.pose).max() < 1e-11
        for scale, gap in product((1e-6, 1e-4, 1e-2, 1.0), (0.0, 1.0)):
            tried = forces + rng.normal(0.0, scale, forces.shape)
            tried[0] -= (tried - forces).sum(axis=0)
            lost = rng.normal(0.0, 1e-3 * gap * scale, 3)
            tried[1] += lost
            ends = ends_of(model, lines, tried)
            point = ends.mean(axis=0) + rng.normal(0.0, 1e-9, 3)
            radii, away = global_bound(lines, tried, ends - point, gap * np.linalg.norm(lost))
            assert (np.linalg.norm(tried - forces, axis=1) <= radii).all()
            distance = np.linalg.norm(point - exact.pose)
            assert distance <= away
            finite += np.isfinite(away)
            tightest = min(tightest, away / distance)
    assert finite >= 24
    assert 1.0 <= tightest < 1e4


def metric_bound(
    lines: list[MonotoneLine], forces: np.ndarray, ends: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """Theorem 6 for eyelets: the weighted mean of *ends*, and how far the equilibrium is from it by axis.

    Proof. Let N² be the sum of Δ_i · C_i Δ_i. With f_i⋆ in F_i, (1 - θ) N² <= E = sum of Δ_i · (p_i - Y) <= N S. As the
    sum of Δ_i is zero, K (X⋆ - Y) = - sum of K_i (D_i - C_i) Δ_i. So a · (X⋆ - Y) is at most θ N √(sum of b · K_i b)
    with b = K⁻¹ a. To show that f_i⋆ is in F_i, replace P_i by P_i - (1 - t)(p_i - Y): f_i solves this problem at t =
    0. Its solution moves continuously with t. While it is in the sets, the bound with t S keeps it in their interior.
    """
    metric = [spatial(line, f) for line, f in zip(lines, forces, strict=True)]
    stiff = [np.linalg.inv(c) for c in metric]
    whole = np.linalg.inv(sum(stiff))
    point = whole @ sum(k @ p for k, p in zip(stiff, ends, strict=True))
    off = ends - point
    size = np.sqrt(sum(r @ k @ r for r, k in zip(off, stiff, strict=True)))
    for theta in (0.003, 0.01, 0.03, 0.1, 0.2, 0.3, 0.5, 0.7, 0.9):
        if all(
            stays(line, f, c, k, theta, size / (1 - theta))
            for line, f, c, k in zip(lines, forces, metric, stiff, strict=True)
        ):
            return point, theta / (1 - theta) * size * np.sqrt(np.diag(whole))
    return None


def spatial(line: MonotoneLine, force: np.ndarray) -> np.ndarray:
    """Flexibility of an eyelet line in space."""
    h = np.hypot(force[0], force[1])
    plane = flexibility(mpf(h), mpf(force[2]) - line.weight * line.length, *shape(line))
    e, f = force[:2] / h
    frame = np.array([[e, 0, -f], [f, 0, e], [0, 1, 0]])
    return frame @ np.array(plane.tolist(), dtype=float) @ frame.T


def stays(line: MonotoneLine, force: np.ndarray, c: np.ndarray, k: np.ndarray, theta: float, size: float) -> bool:
    """Whether theta holds on the lens that *size* allows this line's force."""
    last = force - np.array([0.0, 0.0, float(line.weight * line.length)])
    towards = [x / np.linalg.norm(x) for x in (force, last)]
    n = (towards[0] + towards[1]) / np.linalg.norm(towards[0] + towards[1])
    reach = size * np.sqrt(np.linalg.eigvalsh(k)[-1])
    beside = size * np.sqrt(max(np.trace(k) - n @ k @ n, 0.0)) + reach * np.linalg.norm(np.cross(n, towards[0]))
    lowest = float(line.lowest(force.tolist()))
    eta = float(holds_over(mpf(reach / lowest), mpf(beside / lowest), line.compliance * mpf(lowest)))
    here = spatial(line, force)
    change = np.linalg.eigvals(np.linalg.solve(c, here)).real
    return eta > 0 and change.max() / eta <= 1 + theta and change.min() * eta >= 1 - theta


@pytest.mark.parametrize("slack", [0.0, 0.2])
def test_the_metric_bound_covers_the_distance_and_is_sharp(slack: float) -> None:
    model = built("eyelet", False)
    rng = np.random.default_rng(9)
    held = cases.poses(model, 3)
    lengths = held.lengths.copy()
    lengths[:, 0] += slack
    truth = solve_forward(model, lengths).checked()
    used = 0
    for row, scale in product(range(3), (1e-6, 1e-5, 1e-4)):
        exact = truth[row]
        lines, forces = monotone_lines(model, lengths[row]), end_forces(exact)
        tried = forces + rng.normal(0.0, scale, forces.shape)
        tried[0] -= (tried - forces).sum(axis=0)
        found = metric_bound(lines, tried, ends_of(model, lines, tried))
        if found is None:
            continue
        point, radii = found
        assert (np.abs(point - exact.pose) <= radii + 1e-12).all()
        assert radii.max() < 0.02 * scale
        _, away = global_bound(lines, tried, ends_of(model, lines, tried) - point, 0.0)
        assert radii.max() < 0.02 * away
        used += 1
    assert used >= 6


def length_box(lines: list[MonotoneLine], forces: np.ndarray, d: float) -> np.ndarray | None:
    """How far, by axis, the pose may be from that of *lines* with length errors up to *d*; None if not known."""
    metric = [spatial(line, f) for line, f in zip(lines, forces, strict=True)]
    stiff = [np.linalg.inv(c) for c in metric]
    whole = np.linalg.inv(sum(stiff))
    last = [f - np.array([0.0, 0.0, float(x.weight * x.length)]) for x, f in zip(lines, forces, strict=True)]
    tension = [np.linalg.norm(t) for t in last]
    slopes = [t / k * (1 + float(x.compliance) * k) for x, t, k in zip(lines, last, tension, strict=True)]
    ranges = [[replace(x, length=x.length + sign * mpf(d)) for sign in (1, -1)] for x in lines]
    rest = [
        float(x.weight * (x.compliance + 1 / long.lowest(f.tolist()))) * d * d / 2
        for x, (long, _), f in zip(lines, ranges, forces, strict=True)
    ]
    corners = []
    for corner in product((-d, d), repeat=len(lines)):
        ends = [g * x for g, x in zip(slopes, corner, strict=True)]
        middle = whole @ sum(k @ p for k, p in zip(stiff, ends, strict=True))
        corners.append(np.sqrt(sum((p - middle) @ k @ (p - middle) for p, k in zip(ends, stiff, strict=True))))
    size = max(corners) + np.sqrt(sum(e * e * np.linalg.eigvalsh(k)[-1] for e, k in zip(rest, stiff, strict=True)))
    straight = sum(np.abs(whole @ k @ g) * d for k, g in zip(stiff, slopes, strict=True))
    straight = straight + sum(np.linalg.norm(k @ whole, axis=0) * e for k, e in zip(stiff, rest, strict=True))
    for theta in np.geomspace(0.001, 0.9, 60):
        if all(
            stays(x, f, c, k, theta, size / (1 - theta))
            for pair, f, c, k in zip(ranges, forces, metric, stiff, strict=True)
            for x in pair
        ):
            return straight + theta / (1 - theta) * size * np.sqrt(np.diag(whole))
    return None


@pytest.mark.parametrize(("slack", "d", "wide"), [(0.0, 1e-5, 1.1), (0.0, 5e-5, 1.5), (0.2, 1e-6, 1.1)])
def test_the_box_of_uncertain_lengths_holds_the_pose(slack: float, d: float, wide: float) -> None:
    """Corners and random lengths between; the ball of the global bound is far wider than the box of the metric one."""
    model = built("eyelet", False)
    held = solve_inverse(model, np.array([[0.5, 1.0, 1.0]]))
    lengths = held.lengths[0].copy()
    lengths[0] += slack
    exact = solve_forward(model, lengths).checked()
    forces, lines = end_forces(exact), monotone_lines(model, lengths)
    changes = np.concatenate([list(product((-1.0, 1.0), repeat=4)), np.random.default_rng(12).uniform(-1, 1, (50, 4))])
    moved = solve_forward(model, lengths + d * changes).checked().pose - exact.pose
    box = length_box(lines, forces, d)
    assert box is not None
    assert (np.abs(moved) <= box + 1e-12).all()
    assert (box <= wide * np.abs(moved).max(axis=0)).all()
    tension = exact.tensions.max()
    r = (1 + float(lines[0].compliance) * (tension + float(lines[0].weight) * d)) * d
    short = [replace(line, length=line.length - mpf(d)) for line in lines]
    long = [replace(line, length=line.length + mpf(d)) for line in lines]
    whole = r * np.sqrt(sum(1 / float(line.modulus) for line in short))
    steep = []
    for few, more, force in zip(short, long, forces, strict=True):
        reach = mpf(0.5 * (r / float(few.modulus) + whole / np.sqrt(float(few.modulus))))
        steep.append(float(more.steepest(force.tolist(), reach)))
    ball = whole / np.sqrt(sum(1 / x for x in steep))
    assert 5.0 < ball / np.linalg.norm(moved, axis=1).max() < 500.0


# Many starts


def from_everywhere(model: Model, lengths: np.ndarray, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Where Newton ends, and which starts failed: from poses in the room, below its floor and over its ceiling."""
    rng = np.random.default_rng(seed)
    low, high = np.array(model.robot.scene.frame_min), np.array(model.robot.scene.frame_max)
    packed = model.packed
    work = equilibrium.workspace(packed)
    poses = rng.uniform(low - np.array([0.0, 0.0, 3.0]), high + np.array([0.0, 0.0, 5.0]), (count, 3))
    codes = np.zeros(count, dtype=int)
    for k, pose in enumerate(poses):
        start, states = pose.copy(), np.zeros((model.m, layout.STATE))
        codes[k] = layout.Code.NOT_CONVERGED
        if forward.guess_states(packed, lengths, pose, states, work, 10 ** rng.uniform(-2.0, 2.0)):
            codes[k] = forward.solve_warm(packed, lengths, pose, states, work)[0]
        if codes[k] != layout.Code.OK:
            pose[:] = start
            codes[k] = forward.solve_by_homotopy(packed, lengths, pose, states, work)[0]
    return poses, codes


@pytest.mark.parametrize("dead", cases.some([True, False]))
@pytest.mark.parametrize("sheave", ["eyelet", "swivel"])
def test_all_starts_for_each_of_12_sets_of_lengths_find_one_pose(sheave: str, dead: bool) -> None:
    model = built(sheave, dead)
    held = cases.poses(model, 12)
    lengths = held.lengths.copy()
    rng = np.random.default_rng(10)
    lengths[3:, 1] += rng.uniform(0.0, 0.3, 9)
    cold = solve_forward(model, lengths).checked()
    for row in range(12):
        poses, codes = from_everywhere(model, lengths[row], STARTS, row)
        found = poses[codes == 0]
        assert len(found) >= 0.9 * STARTS
        assert np.linalg.norm(found - cold.pose[row], axis=1).max() < 1e-9


def test_springs_without_weight_hang_in_one_place() -> None:
    model = Model(MERLET, Fidelity(CableLaw.ELASTIC, SheaveLaw.EYELET))
    rng = np.random.default_rng(11)
    lengths = cases.poses(model, 1).lengths[0]
    for let_out in ([0.0, 0.0, 0.0, 0.0], [0.0, 0.5, 0.0, 0.0], [0.0, 0.5, 0.0, 0.5], [0.0, 3.0, 3.0, 3.0]):
        guesses = rng.uniform([-2.4, -4.8, -3.0], [2.4, 4.8, 9.0], (100, 3))
        found = solve_forward(model, np.tile(lengths + let_out, (100, 1)), guess=guesses)
        ok = found.code != layout.Code.NOT_CONVERGED
        assert ok.mean() > 0.95
        assert np.linalg.norm(found.pose[ok] - found.pose[ok].mean(axis=0), axis=1).max() < 1e-6


def flipped(robot: Robot, at: Sequence[float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Codes, poses and lever angles of solves whose levers start flipped, all 16 ways."""
    held = solve_inverse(Model(robot), np.array(at, dtype=float)).checked()
    flips = np.array(list(product((0, 1), repeat=4)))
    poses, states = np.tile(held.pose, (16, 1)), np.tile(held.states, (16, 1, 1))
    states[..., layout.BETA] += np.pi * flips
    codes, iterations = np.zeros(16, dtype=np.int64), np.zeros(16, dtype=np.int64)
    lengths = np.tile(held.lengths, (16, 1))
    batches.forward_rows(held.packed, lengths, poses, states, codes, iterations, np.zeros(16), batches.WARM, 0, 16)
    return codes, poses, states[..., layout.BETA]


def test_levers_have_sixteen_equilibria_and_one_is_stable() -> None:
    codes, poses, beta = flipped(load("paty2021"), [1.0, -2.0, 6.0])
    assert codes.tolist() == [layout.Code.OK] + 15 * [layout.Code.LEVER_UNSTABLE]
    assert len(np.unique(np.sin(beta).round(3) > 0, axis=0)) == 16
    apart = np.linalg.norm(poses[1:] - poses[0], axis=1)
    assert 0.2 < apart.min() < apart.max() < 1.0
