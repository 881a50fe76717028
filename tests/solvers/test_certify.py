"""Certificates are true: the equilibrium is within the bound, and where there is none nothing is certified."""

from __future__ import annotations

import dataclasses
import platform
import re
from collections.abc import Iterator
from itertools import product

import numba
import numpy as np
import pytest
from mpmath import mp, mpf

import cases
import planar_robots
from cablewright.foundation.errors import InputError
from cablewright.kernels import batches, layout
from cablewright.kernels.certificates import krawczyk as kernel
from cablewright.kernels.certificates.system_enclosure import certificate_pool, unfold
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.packed_views import PlatformNumbers
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import load
from cablewright.solvers.certify import Certificate, certify
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from oracles import machine
from oracles.irvine import DIGITS
from oracles.line import LineState
from oracles.platform import Place, exponential

LAWS = (CableLaw.ELASTIC, CableLaw.CATENARY)
MODELS = list(cases.models(*LAWS))
NAMES = ["paty2021", "merlet2023", "house-printer", "under", "six-lines", "off-axis", "cogiro", "grab-four-lines"]
NAMES += ["jung2020", "jung2020-table1", "jointed-body", "wang2021"]
BUILT = {robot.name: Model(robot) for robot in cases.robots()}
HOUSE = BUILT["house-printer"]


def full(value: float, count: int) -> np.ndarray:
    return np.full(count, value)


# --- The equilibrium with 50 digits, and how far the solution is from it


class Exact:
    """The oracle's equations of one solved row, in the kernel's order, polished with the kernel's Y.

    Any Y that contracts will do: what it leads to is a zero of the oracle's equations.
    """

    def __init__(self, row: Equilibrium) -> None:
        self.row, self.robot = row, row.model.robot
        own = row.packed._replace(lines=row.packed.lines[0], platform=row.packed.platform[0])
        work = unfold(own, certificate_pool(own))
        kernel.certify(own, row.lengths, row.pose, row.states, 1.0, work)
        self.counts = own.lines[:, layout.UNKNOWNS].astype(int)
        self.states = [list(map(mpf, y[:count])) for y, count in zip(row.states, self.counts, strict=True)]
        self.pose, self.rotation = list(map(mpf, row.pose[:3])), Place.of(row.pose).rotation
        self.turn = [mpf(0)] * (row.model.n - 3)
        self.inverse = work.inverse

    def polished(self) -> np.ndarray:
        """How far the exact pose is from the row's, (n,): m, and the components of the rotation from it, rad."""
        with mp.workdps(DIGITS):
            for _ in range(30):
                step = self._step()
                if max(map(abs, step)) < mpf(10) ** -22:
                    found = [a - mpf(b) for a, b in zip(self.pose, self.row.pose[:3], strict=True)]
                    return np.array([float(value) for value in found + self.turn])
        raise AssertionError(f"no equilibrium: the last step was {float(max(map(abs, step))):.3g}")

    def _step(self) -> list[mpf]:
        """One step in all unknowns; Y times the residual, which is scaled to fit into doubles."""
        residual = self._residual()
        size = max(map(abs, residual)) or mpf(1)
        step = [size * mpf(value) for value in self.inverse @ np.array([float(each / size) for each in residual])]
        at = 0
        for y in self.states:
            for k in range(len(y)):
                y[k] -= step[at + k]
            at += len(y)
        self.pose = [value - change for value, change in zip(self.pose, step[at : at + 3], strict=True)]
        self.turn = [value - change for value, change in zip(self.turn, step[at + 3 :], strict=True)]
        return step

    def _residual(self) -> list[mpf]:
        turned = exponential(self.turn) * self.rotation if self.turn else self.rotation
        place = Place(tuple(self.pose), turned)
        states = [self._state(i) for i in range(len(self.counts))]
        law = self.row.model.fidelity.cable.value
        checks = machine.checks(self.robot, self.row.lengths, place, states, law)
        found: list[mpf] = []
        for check, count in zip(checks, self.counts, strict=True):
            assert check is not None
            x, z = check.dead_end or (mpf(0), mpf(0))
            found += [*check.free_end, check.length, z, x, *check.moment][:count]
        return found + self._held(place, machine.total(self.robot, place, checks))

    def _held(self, place: Place, wrench: list[mpf]) -> list[mpf]:
        """The balance, and in a plane the rows of the kernel: the balance that it does not carry, and that the platform
        is in it."""
        body = PlatformNumbers(self.row.packed.platform[0])
        if not body.held:
            return wrench
        normal, a = [mpf(float(x)) for x in body.normal], int(np.argmax(np.abs(body.normal)))
        rows = [normal[a] * wrench[j] - normal[j] * wrench[a] for j in range(3)]
        rows[a] = mp.fdot(normal, self.pose) - mpf(float(body.plane_distance))
        if len(wrench) == 3:
            return rows
        to = place.rotation * mp.matrix(normal)
        tilt = [normal[j - 2] * to[j - 1] - normal[j - 1] * to[j - 2] for j in range(3)]
        tilt[a] = mp.fdot(normal, wrench[3:])
        return rows + tilt

    def _state(self, i: int) -> LineState:
        phi, tau, free, *rest = self.states[i]
        upright = -self.row.lines.side[i] * mp.pi / 2
        dead, psi, beta = [*rest, *[mpf(0), upright, mpf(0)][len(rest) :]]
        return LineState(mp.exp(tau), phi, free, psi, dead, beta)


def misses(found: Equilibrium, certificate: Certificate) -> np.ndarray:
    """The error of each row's pose as a share of its bound (N,), the worst component."""
    off = np.array([Exact(found[i]).polished() for i in range(len(found.code))])
    return np.asarray(np.abs(off) / certificate.bound).max(axis=1)


def let_out(held: Equilibrium, kind: str, rng: np.random.Generator) -> np.ndarray:
    """Lengths (N, m) of *held*, one line of each row longer: taut, slack or between."""
    rows, m = held.lengths.shape
    lengths = held.lengths.copy()
    excess = {"taut": np.zeros(rows), "slack": rng.uniform(0.0, 0.3, rows), "between": 10 ** rng.uniform(-6, -2, rows)}
    lengths[np.arange(rows), rng.integers(0, m, rows)] += excess[kind]
    return lengths


def certified_share(model: Model, kind: str, count: int, seed: int) -> float:
    """Certify *count* poses, compare each certified one with 50 digits, return the share of certified ones."""
    held = cases.poses(model, count, seed)
    found = solve_forward(model, let_out(held, kind, np.random.default_rng(seed)), guess=held.pose)
    found = found[found.code != layout.Code.NOT_CONVERGED]
    certificate = certify(found)
    sure = np.flatnonzero(certificate.certified)
    assert (misses(found[sure], certificate[sure]) <= 1.0).all()
    return len(sure) / count


# --- What is an equilibrium is certified, and the bound holds


@pytest.mark.parametrize("model", MODELS, ids=cases.name)
def test_every_taut_pose_is_certified(model: Model) -> None:
    held = cases.poses(model, 40)
    for found in (held, solve_forward(model, held.lengths)):
        certificate = certify(found)
        assert certificate.certified.all()
        assert (certificate.bound < 1e-9).all()
        assert (certificate.bound < certificate.box).all()
        assert (certificate.levers == 1).all()


@pytest.mark.parametrize("kind", ["taut", "slack", "between"])
@pytest.mark.parametrize("name", NAMES)
def test_the_equilibrium_is_within_the_bound(name: str, kind: str) -> None:
    assert certified_share(BUILT[name], kind, cases.often(4, 10), 7) == 1.0


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["taut", "slack", "between"])
@pytest.mark.parametrize("name", NAMES)
def test_the_equilibrium_is_within_the_bound_ten_thousand_times(name: str, kind: str) -> None:
    assert certified_share(BUILT[name], kind, 278, 8) >= 0.995


def test_certificates_report_reasons_by_row() -> None:
    held = solve_inverse(HOUSE, [[0.0, 0.0, 1.0], [0.0, 0.0, 2.0]])
    both, told = certify(held), certify(held[0]).to_dict()
    assert (len(both), both.certified.tolist(), both[0].certified) == (2, [True, True], True)
    assert both.reason() == (both[0].reason(), both[1].reason())
    assert repr(both) == "Certificate(2 of 2 certified)"
    assert repr(both[0]) == f"Certificate({both[0].reason()})"
    assert (told["certified"], told["levers"], told["bound"]) == (True, "stable", both.bound[0].tolist())
    assert both.to_dict()["levers"] == ["stable", "stable"]


def test_a_massless_slack_line_is_not_certified() -> None:
    model = Model(load("merlet2023"), Fidelity(CableLaw.ELASTIC))
    held = cases.poses(model, 1)[0]
    found = solve_forward(model, held.lengths + 0.5 * np.eye(4)[0]).checked()
    certificate = certify(found)
    assert not certificate.certified
    assert "massless line hangs slack" in certificate.reason()


def test_a_row_is_certified_as_it_is_alone() -> None:
    held = cases.poses(BUILT["cogiro"], 70)  # a batch of more than one chunk
    many = certify(held)
    for i in (0, 63, 64, 69):
        one = certify(held[i])
        assert one.bound.shape == one.box.shape == (6,)
        assert one.certified is True
        np.testing.assert_array_equal(one.bound, many.bound[i])
        np.testing.assert_array_equal(one.box, many.box[i])
        assert "exactly one equilibrium" in one.reason()


# --- Compliant mounts, springs, planes

SOFT = {
    "mount": {"exit_compliance": 2e-6},
    "spring": {"spring": 1.5e5},
    "both": {"exit_compliance": 8e-6, "spring": 5e4},
    "soft": {"exit_compliance": 1e-4},
}
ON = ("merlet2023", "house-printer", "six-lines", "cogiro", "paty2021")  # the last on joints, the others over swivels
SOFTENED = [f"{name} on {kind}" for name in ON for kind in ("mount", "spring", "both")]


def softened(name: str) -> Model:
    """A robot whose lines give, each by a little more than the one before."""
    robot, kind = name.split(" on ")
    built = BUILT[robot].robot
    lines = []
    for i, line in enumerate(built.lines):
        lines.append(line.model_copy(update={key: (1.0 + 0.1 * i) * value for key, value in SOFT[kind].items()}))
    return Model(built.model_copy(update={"lines": tuple(lines)}))


def certified(model: Model, held: Equilibrium, kind: str, seed: int) -> float:
    """As `certified_share`, of lines *kind* of those of *held*."""
    lengths = let_out(held, kind, np.random.default_rng(seed))
    found = solve_forward(model, lengths, guess=held.pose)
    found = found[found.ok]
    certificate = certify(found)
    sure = np.flatnonzero(certificate.certified)
    assert (misses(found[sure], certificate[sure]) <= 1.0).all()
    return len(sure) / max(len(found.code), 1)


@pytest.mark.parametrize("kind", ["taut", "between"])
@pytest.mark.parametrize("name", SOFTENED)
def test_compliant_robots_are_certified_and_within_the_bound(name: str, kind: str) -> None:
    model = softened(name)
    assert certified(model, cases.poses(model, 4, 5), kind, 5) == 1.0


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["taut", "slack", "between"])
@pytest.mark.parametrize("name", SOFTENED)
def test_compliant_robots_are_within_the_bound_in_hundreds_of_poses(name: str, kind: str) -> None:
    model = softened(name)
    assert certified(model, cases.poses(model, 60, 6), kind, 6) >= 0.95


def on_board(plane: str, body: bool, count: int, seed: int) -> tuple[Model, Equilibrium]:
    robot = planar_robots.board(plane, body, force=(3.0, -2.0, 4.0))
    held = solve_inverse(Model(robot), planar_robots.places(robot, 2 * count, seed=seed))
    held = held[held.ok]
    return held.model, held[:count]


@pytest.mark.parametrize("kind", ["taut", "between"])
@pytest.mark.parametrize(("plane", "body"), list(product(planar_robots.PLANES, (False, True))))
def test_what_a_plane_carries_is_certified_and_within_the_bound(plane: str, body: bool, kind: str) -> None:
    model, held = on_board(plane, body, 5, 3)
    assert certified(model, held, kind, 3) == 1.0


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["taut", "slack", "between"])
@pytest.mark.parametrize(("plane", "body"), list(product(planar_robots.PLANES, (False, True))))
def test_what_a_plane_carries_is_within_the_bound_in_hundreds_of_poses(plane: str, body: bool, kind: str) -> None:
    model, held = on_board(plane, body, 60, 4)
    assert certified(model, held, kind, 4) >= 0.95


@pytest.mark.parametrize("size", [1e-8, 1e-6, 1e-4])
def test_a_pose_error_above_the_tolerance_is_never_certified(size: float) -> None:
    for model, held in (on_board("tilted", True, 8, 2), (softened("merlet2023 on both"), None)):
        held = cases.poses(model, 8) if held is None else held
        wrong = disturbed(held, "pose", size, np.random.default_rng(2))
        assert not certify(wrong, 1e-9).certified.any()


# --- What is none is not


def disturbed(held: Equilibrium, what: str, size: float, rng: np.random.Generator) -> Equilibrium:
    """Rows of *held*, in each one number wrong by *size*: a length, a pose coordinate or an unknown of a line."""
    rows, each = len(held.code), np.arange(len(held.code))
    lengths, pose, states = held.lengths.copy(), held.pose.copy(), held.states.copy()
    by = size * rng.choice([-1.0, 1.0], rows)
    if what == "length":
        lengths[each, rng.integers(0, held.model.m, rows)] += by
    elif what == "pose":
        pose[each, rng.integers(0, held.model.n, rows)] += by
    else:
        line = rng.integers(0, held.model.m, rows)
        count = held.lines.unknowns[0, line].astype(int)
        at = (rng.random(rows) * count).astype(int)
        at[(count == 5) & (at == 4)] = layout.PSI
        states[each, line, at] += by
    return dataclasses.replace(held, lengths=lengths, pose=pose, states=states)


def disturbances(name: str, count: int, seed: int) -> Iterator[tuple[Equilibrium, Equilibrium]]:
    """Batches of equilibria and the same with one number wrong, by 1e-8 to 1e-3."""
    rng = np.random.default_rng(seed)
    held = cases.poses(BUILT[name], count, seed)
    for what in ("length", "pose", "state"):
        for size in (1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3):
            yield held, disturbed(held, what, size, rng)


def refuse_all(name: str, count: int, seed: int) -> None:
    """What is certified to within 1e-9 although one number of it is wrong is that near, for all that."""
    for _, wrong in disturbances(name, count, seed):
        certificate = certify(wrong, 1e-9)
        for i in np.flatnonzero(certificate.certified):
            off = np.abs(Exact(wrong[int(i)]).polished())
            assert (off <= certificate.bound[i]).all()
            assert (off <= 1e-9).all()


def test_what_is_no_equilibrium_is_not_certified() -> None:
    for name in ("merlet2023", "paty2021", "cogiro"):
        refuse_all(name, 6, 3)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_what_is_no_equilibrium_is_not_certified_ten_thousand_times(name: str) -> None:
    refuse_all(name, 47, 4)


@pytest.mark.parametrize("size", [1e-8, 1e-6, 1e-4])
@pytest.mark.parametrize("name", ["merlet2023", "jointed-body"])
def test_a_pose_that_has_an_error_is_never_certified(name: str, size: float) -> None:
    held = cases.poses(BUILT[name], 30)
    wrong = disturbed(held, "pose", size, np.random.default_rng(2))
    assert not certify(wrong, 1e-9).certified.any()


@pytest.mark.parametrize("size", [1e-13, 1e-12, 1e-11, 1e-10])
@pytest.mark.parametrize("what", ["length", "pose", "state"])
@pytest.mark.parametrize("name", ["merlet2023", "paty2021", "cogiro"])
def test_a_small_error_is_in_the_bound(name: str, what: str, size: float) -> None:
    held = cases.poses(BUILT[name], cases.often(4, 10))
    wrong = disturbed(held, what, size, np.random.default_rng(2))
    certificate = certify(wrong, 1.0)
    for i in np.flatnonzero(certificate.certified):
        assert (np.abs(Exact(wrong[int(i)]).polished()) <= certificate.bound[i]).all()


def test_the_tolerance_decides_not_the_box() -> None:
    held = cases.poses(BUILT["merlet2023"], 20)
    wrong = disturbed(held, "pose", 1e-7, np.random.default_rng(2))
    near = certify(wrong, 1e-6)
    assert near.certified.any()
    at = int(np.flatnonzero(near.certified)[0])
    assert 0.9e-7 < near.bound[at].max() < 2e-7
    far = certify(wrong[at], 1e-8)
    assert not far.certified
    np.testing.assert_allclose(far.bound, near.bound[at], rtol=1e-6)  # how near it is stays known


# --- Levers on their head


def on_their_heads(held: Equilibrium, heads: np.ndarray) -> Equilibrium:
    """Equilibria for the lengths of the single *held*, the levers of each row of *heads* (N, m) standing."""
    rows = len(heads)
    lengths, poses = np.tile(held.lengths, (rows, 1)), np.tile(held.pose, (rows, 1))
    states, started = np.zeros((rows, held.model.m, layout.STATE)), np.zeros(rows, dtype=np.bool_)
    batches.start_rows(held.packed, lengths, poses, heads, 1.0, states, started)
    assert started.all()
    codes, counts = np.zeros(rows, dtype=np.int64), np.zeros(rows, dtype=np.int64)
    batches.forward_rows(held.packed, lengths, poses, states, codes, counts, np.zeros(rows), batches.WARM, 0, rows)
    return Equilibrium(held.model, held.packed, poses, lengths, states, codes, np.zeros(rows), counts)


def test_all_sixteen_equilibria_of_four_levers_are_certified() -> None:
    held = solve_inverse(BUILT["paty2021"], [1.0, -2.0, 6.0]).checked()
    heads = np.array(list(product((False, True), repeat=4)))
    found = on_their_heads(held, heads)
    np.testing.assert_array_equal(found.code == layout.Code.LEVER_UNSTABLE, heads.any(axis=1))
    certificate = certify(found)
    assert certificate.certified.all()
    np.testing.assert_array_equal(certificate.levers, np.where(heads.any(axis=1), -1, 1))
    assert (misses(found, certificate) <= 1.0).all()
    apart = np.abs(found.pose[:, None] - found.pose[None]).max(axis=2) + np.eye(16)
    assert apart.min() > 2 * certificate.box.max()  # sixteen, and not one of them twice


# --- Bodies near a fold, bad input, code


def test_a_pose_with_rows_without_answer_is_not_certified() -> None:
    lengths = np.array([[28.0] * 4, [1.0, 1.0, 1.0, 1.0]])
    found = solve_forward(HOUSE, lengths)
    assert found.code[1] != 0
    found.pose[1], found.states[1] = np.nan, np.nan
    certificate = certify(found)
    assert certificate.certified.tolist() == [True, False]
    assert np.isnan(certificate.bound[1]).all()
    assert certificate.levers.tolist() == [1, 0]


@pytest.mark.parametrize("tolerance", [0.0, -1e-9, float("nan")])
def test_a_tolerance_that_is_not_positive_is_rejected(tolerance: float) -> None:
    with pytest.raises(InputError, match="tolerance"):
        certify(solve_forward(HOUSE, full(28.0, 4)), tolerance)


def test_rigid_cables_are_rejected() -> None:
    with pytest.raises(InputError, match="do not determine tensions"):
        certify(solve_inverse(Model(load("house-printer"), Fidelity(CableLaw.RIGID)), [0.0, 0.0, 3.0]))


def test_certificates_leave_one_compiled_signature_per_kernel() -> None:
    for name in NAMES:
        held = cases.poses(BUILT[name], 1)
        for rows in (1, 100):
            assert certify(solve_forward(BUILT[name], np.repeat(held.lengths, rows, axis=0))).certified.all()
    cases.assert_one_signature_per_kernel()


@pytest.mark.slow
@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="the mnemonics of x86")
def test_the_machine_code_fuses_nothing_and_calls_no_libm() -> None:
    @numba.njit(error_model="numpy")
    def whole(packed, lengths, pose, states, tolerance, work):  # compiled here: what comes from a cache has no listing
        return kernel.certify(packed, lengths, pose, states, tolerance, work)

    row = cases.poses(HOUSE, 1)[0]
    own = row.packed._replace(lines=row.packed.lines[0], platform=row.packed.platform[0])
    work = unfold(own, certificate_pool(own))
    assert whole(own, row.lengths, row.pose, row.states, 1e-9, work) == kernel.CERTIFIED
    code = "\n".join(whole.inspect_asm().values())
    assert len(re.findall(r"\bv?mul[sp]d\b", code)) > 500
    assert not re.findall(r"\bvfn?m(?:add|sub)\w*", code)
    assert not re.findall(r"\b(?:sin|cos|tan|exp|exp2|expm1|log|log1p|pow|hypot|atan2|fma|ldexp|frexp)\b", code)
