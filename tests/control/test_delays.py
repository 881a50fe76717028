"""Winches that lag and counts that are old move no platform off its path: on a circle, by the forward problem."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cablewright.control import velocity
from cablewright.control.path_follower import Target
from cablewright.control.velocity import VelocitySettings
from cablewright.foundation.signals import Encoders, Estimate, SensorFrame, frozen
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.taut import taut_at

PERIOD, LAG = 0.05, 0.1  # s
RADIUS, SPEED = 0.3, 0.1  # m, m/s
DRUM = 0.05  # m
CASES = {
    "merlet2023": (np.array([0.4, -1.2, 1.1]), {}),
    "cogiro": (np.array([0.3, 0.2, 1.2, 0.0, 0.0, 0.0]), {"law": "model", "gain": 4.0}),
}


def farthest(model: Model, middle: np.ndarray, own: VelocitySettings, *, reads: bool) -> float:
    """How far, m, the platform leaves a circle in its second round; *reads*: the control knows how old counts are."""
    pose, state, truth = middle + RADIUS * np.eye(model.n)[0], velocity.start(own), []
    lengths = solve_inverse(model, pose).checked().lengths
    speeds, known = np.zeros(model.m), (lengths, pose)
    zeros, radii, keep = frozen(np.zeros(3)), frozen(np.full(model.m, DRUM)), math.exp(-PERIOD / LAG)
    steps = round(4.0 * math.pi * RADIUS / SPEED / PERIOD)
    corners = np.exp(1j * SPEED / RADIUS * PERIOD * np.arange(steps + 1))
    track = middle[:3] + RADIUS * np.column_stack([corners.real, corners.imag, 0.0 * corners.real])
    for k in range(steps):
        now, (seen, at), known = k * PERIOD, known, (lengths, pose)
        excess = seen - taut_at(model, at).lengths
        turn = frozen(np.pad(at[3:], (0, 6 - model.n)))
        estimate = Estimate(now, frozen(at[:3]), zeros, turn, frozen(seen), frozen(excess), excess > 1.0, radii)
        if reads:
            velocity.note_counts(state, SensorFrame(now, (Encoders(now - PERIOD * (k > 0), np.zeros(model.m)),)))
        aim = Target(track[k], (track[k + 1] - track[k]) / PERIOD, 0.0, 0, SPEED, True, False, False)
        wanted = velocity.step(own, state, estimate, aim, PERIOD)
        lengths = lengths + DRUM * (wanted * PERIOD + (speeds - wanted) * LAG * (1.0 - keep))
        speeds = wanted + (speeds - wanted) * keep
        pose = solve_forward(model, lengths, guess=pose).checked().pose
        truth.append(np.linalg.norm(pose[:2] - middle[:2]) - RADIUS)
    return float(np.abs(truth[steps // 2 :]).max())


@pytest.mark.parametrize("robot", CASES)
def test_a_circle_is_kept_by_winches_that_lag_and_counts_that_are_old(robot: str) -> None:
    """Without them the control moves the platform outwards by v^2 (T + A) K / (R (K^2 + (v / R)^2))."""
    middle, changes = CASES[robot]
    model = Model(load(robot))
    own = VelocitySettings(model, 1e3, manage_slack=False, lag=LAG, ages=True, max_correction=1.0, **changes)  # type: ignore[arg-type]
    unaware = VelocitySettings(model, 1e3, manage_slack=False, max_correction=1.0, **changes)  # type: ignore[arg-type]
    outwards = SPEED**2 * (LAG + PERIOD) / RADIUS * own.gain / (own.gain**2 + (SPEED / RADIUS) ** 2)
    assert farthest(model, middle, unaware, reads=False) == pytest.approx(outwards, rel=0.25)
    assert farthest(model, middle, own, reads=True) < 0.15 * outwards  # the lag itself makes a circle smaller


def delay_after(state: velocity.VelocityState, own: VelocitySettings, now: float) -> float:
    return velocity._delay(own, state, now, PERIOD)


def test_the_age_of_counts_is_bounded_and_never_negative() -> None:
    own = VelocitySettings(Model(load("merlet2023")), 1e3, lag=LAG, ages=True)
    state = velocity.start(own)
    assert delay_after(state, own, 0.0) == LAG  # no counts yet
    velocity.note_counts(state, SensorFrame(0.05, (Encoders(0.02, np.zeros(4)),)))
    assert delay_after(state, own, 0.05) == pytest.approx(LAG + 0.03)
    assert delay_after(state, own, 600.0) == pytest.approx(LAG + 0.1)  # after a pause without encoders
    velocity.note_counts(state, SensorFrame(600.0, (Encoders(4000.0, np.zeros(4)),)))  # from the future
    assert delay_after(state, own, 600.0) == LAG
    assert delay_after(state, own, 600.05) == pytest.approx(LAG + 0.05)
    assert delay_after(state, VelocitySettings(own.model, 1e3, lag=LAG), 600.05) == LAG  # of an estimate of now


def test_speeds_that_are_not_given_move_no_platform() -> None:
    """A command that is scaled counts by its share; one without an answer, and one after a gap, not at all."""
    model = Model(load("merlet2023"))
    middle = CASES["merlet2023"][0]
    lengths = solve_inverse(model, middle).checked().lengths
    taut = taut_at(model, middle).lengths
    aim = Target(middle, np.array([0.1, 0.0, 0.0]), 0.0, 0, SPEED, True, False, False)

    def velocity_after(most: float, seen: np.ndarray, passed: float = PERIOD) -> np.ndarray:
        own = VelocitySettings(model, most, manage_slack=False, lag=LAG)
        state = velocity.start(own)
        zeros, radii = frozen(np.zeros(3)), frozen(np.full(4, DRUM))
        for now in (0.0, passed):
            excess = frozen(seen - taut)
            estimate = Estimate(now, frozen(middle), zeros, zeros, frozen(seen), excess, excess > 1.0, radii)
            velocity.step(own, state, estimate, aim, PERIOD)
        return state.velocity[:3]

    full = (1.0 - math.exp(-PERIOD / LAG)) * aim.velocity
    assert velocity_after(1e3, lengths) == pytest.approx(full)
    assert 0.0 < velocity_after(0.1, lengths)[0] < 0.5 * full[0]
    assert velocity_after(1e3, np.full(4, np.nan)) == pytest.approx(np.zeros(3))
    assert velocity_after(1e3, lengths, 2.0 * PERIOD) == pytest.approx(np.zeros(3))
