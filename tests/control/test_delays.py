"""Winches that lag and counts that are old move no platform off its path: on a circle, by the forward problem."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cablewright.control import velocity
from cablewright.control.guide import Target
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
            velocity.listen(own, state, SensorFrame(now, (Encoders(now - PERIOD * (k > 0), np.zeros(model.m)),)))
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
    own = VelocitySettings(model, 1e3, manage_slack=False, lag=LAG, max_correction=1.0, **changes)  # type: ignore[arg-type]
    unaware = VelocitySettings(model, 1e3, manage_slack=False, max_correction=1.0, **changes)  # type: ignore[arg-type]
    outwards = SPEED**2 * (LAG + PERIOD) / RADIUS * own.gain / (own.gain**2 + (SPEED / RADIUS) ** 2)
    assert farthest(model, middle, unaware, reads=False) == pytest.approx(outwards, rel=0.25)
    assert farthest(model, middle, own, reads=True) < 0.15 * outwards  # the lag itself makes a circle smaller
