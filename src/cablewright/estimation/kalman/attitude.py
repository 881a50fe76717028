"""How the drum leans and is turned: the gyro carries it on, gravity and that it hangs from one point hold it."""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.estimation.kalman.state import FilterSettings, FilterState, correct, fuse
from cablewright.signals import Inertial

__all__ = ["coast", "feel"]

_LEANS: Final = 10  # readings of the accelerometer that are used at once
_HELD: Final = 0.1  # s in which so many come
_SMOOTH: Final = 0.2  # share of B's acceleration that such a time tells


def feel(settings: FilterSettings, state: FilterState, reading: Inertial) -> None:
    """Carry the attitude on to the time of a *reading* that is believed."""
    since = reading.time - state.felt
    if not since <= state.gap:
        coast(settings, state, reading.time - 0.5 * state.gap)
        since = reading.time - state.felt if state.felt > -np.inf else 0.0
    wx, wy, wz = (reading.rate - state.gyro).tolist()
    x, y = state.tilt.tolist()
    state.turn_rate = np.array([wx + wz * y, wy - wz * x, wz])
    state.tilt = state.tilt + since * state.turn_rate[:2]
    state.yaw += since * wz
    state.gyro_yaw += since * wz
    state.felt = reading.time
    lay, P = state.layout, state.P
    turn = since * wz
    att, own = lay.attitude, P[lay.attitude]
    P[att] = own + [[turn], [-turn], [0.0]] * own[[1, 0, 2]] - since * P[lay.gyro]
    P[:, att] += P[:, att][:, [1, 0, 2]] * [turn, -turn, 0.0] - since * P[:, lay.gyro]
    diagonal = P.reshape(-1)[:: len(P) + 1]
    diagonal[att] += settings.gyro_noise**2 * since
    state.turning.add(reading.time, (state.gyro_yaw, *state.tilt.tolist()))
    fx, fy, _ = reading.acceleration.tolist()
    g = settings.chain.tilt.gravity
    state.leans.append((fy / g, -fx / g))
    if len(state.leans) >= _LEANS:
        _hold(settings, state)


def _hold(settings: FilterSettings, state: FilterState) -> None:
    """Gravity tells the tilt and what the accelerometer is off; that the drum hangs from one point, the tilt."""
    lay = state.layout
    told = np.mean(state.leans, axis=0)
    state.leans.clear()
    speed = state.jacobian[:2] @ (state.radii * state.rates)
    state.push = state.push + _SMOOTH * ((speed - state.speed) / _HELD - state.push)
    state.speed = speed
    pushed = float(state.push @ state.push) / settings.chain.tilt.gravity**2  # who is pushed leans, and feels it not
    tilt = slice(lay.attitude.start, lay.attitude.start + 2)
    H = np.zeros((4, lay.size))
    H[:2, tilt] = H[2:, tilt] = H[:2, lay.lean] = np.eye(2)
    off = np.concatenate([told - state.tilt - state.lean, -state.tilt])
    hanging = (settings.swing**2 + pushed) * settings.period / _HELD
    R = np.diag([settings.gravity**2 + pushed * settings.period / _HELD] * 2 + [hanging] * 2)
    correction, state.P = fuse(state.P, H, off, R)
    correct(state, correction)


def coast(settings: FilterSettings, state: FilterState, time: float) -> None:
    """Carry the attitude on to *time* without the inertial unit: what turns the drum is not known."""
    since = time - state.felt
    if not 0.0 < since < 1e6:
        state.felt = max(state.felt, time)
        return
    lay, P = state.layout, state.P
    state.felt = state.blind = time
    state.leans.clear()
    diagonal = P.reshape(-1)[:: len(P) + 1]
    tilt = slice(lay.attitude.start, lay.attitude.start + 2)
    P[tilt] = 0.0
    P[:, tilt] = 0.0
    diagonal[tilt] = settings.swing**2
    diagonal[lay.attitude.stop - 1] += settings.turning**2 * since * (1.0 + since)
    state.tilt, state.turn_rate = np.zeros(2), np.zeros(3)
    state.turning.add(time, (state.gyro_yaw, 0.0, 0.0))
