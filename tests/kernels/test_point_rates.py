"""The control of a point by kernels beside the same in numpy, and how lines give beside their formula."""

from __future__ import annotations

import math

import numpy as np
import pytest

import cablewright as cw
from cablewright.control import velocity
from cablewright.control.path_follower import Target
from cablewright.control.velocity import VelocitySettings, VelocityState
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Estimate
from cablewright.models.inertia import inertia_wrenches
from cablewright.models.packed_views import LineNumbers
from cablewright.models.statics import Model
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.taut import given, mount_share, stretches, taut_at

DT = 0.01
MODEL = Model(cw.load("merlet2023"))


def softness(lines: LineNumbers, toward: Array) -> tuple[Array, Array]:
    """What mounts give, and a mount of the compliance 1, by matrices."""
    along = toward - np.outer(lines.has_dead_span * lines.side, [0.0, 0.0, 1.0])
    xx, yy, zz, xy, xz, yz = lines.mount.T
    mounts = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).transpose(2, 0, 1)
    pulled = lines.pulls / lines.spans
    return pulled * np.einsum("mi,mij,mj->m", along, mounts, along), pulled * (along * along).sum(axis=1)


def test_lines_give_as_their_mounts_do() -> None:
    rng, lines = np.random.default_rng(3), LineNumbers(MODEL.packed.lines.copy())
    lines.mount = rng.uniform(0.0, 1e-6, (MODEL.m, 6))
    for _ in range(20):
        taut = taut_at(MODEL, rng.uniform([-1.0, -1.0, 0.6], [1.0, 1.0, 1.6]))
        mount, share = softness(lines, taut.toward)
        whole = lines.free_compliance * taut.lengths + lines.spring + mount
        assert given(lines, taut) == pytest.approx(mount, rel=1e-12)
        assert mount_share(lines, taut) == pytest.approx(share, rel=1e-12)
        assert stretches(lines, taut) == pytest.approx(whole, rel=1e-12)


def expected(
    own: VelocitySettings, excess: Array, place: Array, target: Target, tensions: Array | None, line: int
) -> tuple[Array, int]:
    """Rates (m,), m/s, of the law of the model, and the slack line."""
    model = own.model
    taut, held = taut_at(model, place + 0.5 * DT * target.velocity), solve_inverse(model, target.position)
    places = np.stack([target.position, target.position + DT * target.velocity])
    wrenches = inertia_wrenches(model.robot, places, target.accelerations)
    pushed = solve_inverse(model, np.vstack([places, places]), path=True, wrenches=np.vstack([wrenches, 0 * wrenches]))
    lead, end = pushed.lengths[:2] - pushed.lengths[2:]
    error = target.position - place
    if own.by_lengths:
        error = error + np.linalg.lstsq(taut.toward, lead, rcond=None)[0]
    correction = min(own.gain, 0.5 / DT) * error
    correction *= min(1.0, own.max_correction / math.sqrt(float(correction @ correction)))
    rates = taut.toward @ (target.velocity + correction) + (end - lead) / DT
    planned, smallest = np.zeros(model.m), int(np.argmin(held.tensions))
    if own.manage_slack:
        if line < 0 or held.tensions[line] - held.tensions[smallest] > own.slack.switch_margin * held.tensions.mean():
            line = smallest
        planned[line] = own.slack.excess_rate * DT
    if tensions is None or own.manage_slack:
        off = np.nan_to_num(held.lengths - taut_at(model, held.pose).lengths + planned - excess)
    else:
        off = np.nan_to_num(stretches(model.lines, taut) * (tensions - held.tensions))
    basis, _ = np.linalg.qr(taut.toward)
    inner = min(own.internal_gain, 0.5 / DT) * (off - basis @ (basis.T @ off))
    return rates + np.clip(inner, -own.max_correction, own.max_correction), line


@pytest.mark.parametrize("manages", [True, False])
@pytest.mark.parametrize("measured", [True, False])
def test_rates_are_those_of_the_law_in_numpy(manages: bool, measured: bool) -> None:
    rng = np.random.default_rng(int(manages) + 2 * int(measured))
    own = VelocitySettings(MODEL, 1e3, "model", manage_slack=manages, by_lengths=measured)
    for _ in range(25):
        place = rng.uniform([-1.0, -1.0, 0.6], [1.0, 1.0, 1.6])
        target = Target(
            place + rng.normal(size=3) * rng.choice([1e-3, 0.2]), 0.05 * rng.normal(size=3), 0.0, 0, 0.0, False, False,
            False, accelerations=rng.normal(size=(2, 3)) * 0.1,
        )  # fmt: skip
        tensions = rng.uniform(0.0, 300.0, 4) if measured else None
        excess = rng.normal(size=4) * 5e-3
        excess[rng.integers(4)] = np.nan
        nothing = np.zeros(3)
        estimate = Estimate(
            1.0, place, nothing, nothing, np.full(4, 3.0), excess, excess > 0.0, np.full(4, 0.05), None, ()
        )
        state = VelocityState(np.zeros(4), np.zeros((2, 4, 6)), slack_line=np.array([int(rng.integers(-1, 4))]))
        wanted, line = expected(own, excess, place, target, tensions, int(state.slack_line[0]))
        found = velocity.step(own, state, estimate, target, DT, tensions) * 0.05
        assert found == pytest.approx(wanted, rel=1e-7, abs=1e-12)
        if manages:
            assert state.slack_line[0] == line
            assert state.chosen is None
        else:
            assert state.chosen == pytest.approx(solve_inverse(MODEL, target.position).tensions)


@pytest.mark.parametrize("push", [0.0, 0.1])
def test_a_step_from_the_lines_of_the_last_one_is_as_any_other(push: float) -> None:
    """Also after a leap to a place where these do not lead."""
    own, still = VelocitySettings(MODEL, 1e3, "model", manage_slack=False), np.zeros(3)
    goes_on = velocity.start(own)
    for shift in (0.0, 3e-4, 6e-4, 1.5, -1.2):
        place = np.array([0.2 + 0.5 * shift, -0.4 + shift, 1.0])
        pushed = np.array([[push, -push, 0.0], [0.9 * push, -push, 0.0]])
        target = Target(
            place + 1e-3, np.full(3, 0.01), 0.0, 0, 0.0, False, False, False, accelerations=pushed * (shift != 6e-4)
        )
        estimate = Estimate(
            1.0, place, still, still, np.full(4, 3.0), np.zeros(4), np.zeros(4, np.bool_), np.full(4, 0.05), None, ()
        )
        anew = velocity.start(own)
        wanted = velocity.step(own, anew, estimate, target, DT)
        assert velocity.step(own, goes_on, estimate, target, DT) == pytest.approx(wanted, rel=1e-7, abs=1e-10)
        assert goes_on.chosen == pytest.approx(anew.chosen, rel=1e-7)
        assert goes_on.known == (2 if push and shift != 6e-4 else 1)
