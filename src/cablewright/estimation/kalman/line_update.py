"""Prediction by encoders, and update by line angles.

Encoders: changes of the lengths move B, each line weighted by its stiffness; that of a sagging line is reduced by its
sag (Ernst 1965), so a slack line hardly counts. Angles: a sagging line's excess is measured; a taut line is shorter
than its taut length by its stretch, which balance gives if one line is slack, else it is known only within bounds.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from cablewright.arrays import Array, Mask
from cablewright.estimation.chain.lengths import visibly_slack
from cablewright.estimation.kalman.state import (
    FilterSettings,
    FilterState,
    diagonal,
    passes_gate,
    update_state,
)
from cablewright.estimation.slackness import parabolic_excess
from cablewright.solvers.taut import taut_at

_JACOBIAN_INTERVAL: Final = 0.05  # s between computations of the Jacobian
_ANGLE_INTERVAL: Final = 0.2  # s between updates by the angles, which are smoothed over as long
_STRETCH_TIME: Final = 10.0  # s for which the error of a taut line's stretch is correlated
_TAUT_FORCE: Final = 1e6  # N, of a line that does not sag
_UNKNOWN_SLACK_NOISE: Final = 0.02  # m per root metre that B moves, where it is not known which line is slack
_MIN_EXCESS: Final = 1e-4  # m, from which a line without a measured angle counts as sagging


def update_jacobian(settings: FilterSettings, state: FilterState, *, at_once: bool = False) -> None:
    """Compute the taut lines at B and the Jacobian of B by lengths, if they are old or *at_once*."""
    if not at_once and state.time - state.taut_time < _JACOBIAN_INTERVAL:
        return
    model = settings.chain.model
    taut = taut_at(model, state.position)
    if not np.isfinite(taut.toward).all():
        state.monitor.report("encoders", "lost", "a line has no tangent at the estimated position")
        return
    state.monitor.clear("encoders", "lost")
    state.taut, state.taut_position, state.taut_time = taut, state.position.copy(), state.time
    lines, c = model.lines, np.cos(taut.angles)
    h = _horizontal_forces(settings, state)
    sag = (lines.weight * c) ** 2 * taut.free**3 / (12.0 * h**3)
    stiffness = 1.0 / (lines.free_compliance * taut.lengths + sag + 1e-12)
    weighted = taut.toward.T * stiffness  # (3, m)
    state.jacobian = np.asarray(np.linalg.solve(weighted @ taut.toward, weighted), dtype=np.float64)


def _horizontal_forces(settings: FilterSettings, state: FilterState) -> Array:
    """Horizontal force (m,), N, of each line by its angle, or by its excess; large where it does not visibly sag."""
    taut, slackness = state.taut, state.slackness
    assert taut is not None  # `update_jacobian` has run
    weight, c = settings.chain.model.lines.weight, np.cos(taut.angles)
    sensors = settings.chain.slackness
    measured = np.isfinite(slackness.excess)
    slope = np.tan(np.minimum(taut.angles + np.where(measured, slackness.differences, 0.0), 1.5)) - np.tan(taut.angles)
    known = measured & visibly_slack(sensors, slackness)
    by_angle = weight * (0.5 * taut.free - sensors.from_platform) / np.where(known, slope, 1.0)
    beyond = state.lengths - taut.lengths
    sagging = ~measured & (beyond > _MIN_EXCESS)
    by_length = weight * taut.free * c * np.sqrt(taut.free / (24.0 * np.where(sagging, beyond, 1.0)))
    return np.maximum(np.where(known, by_angle, np.where(sagging, by_length, _TAUT_FORCE)), 1e-2)


def excess(state: FilterState) -> Array:
    """Excess (m,), m, of each line over its taut length."""
    assert state.taut is not None  # `update_jacobian` has run
    moved = state.position - state.taut_position
    return np.asarray(state.lengths - state.taut.lengths - state.taut.toward @ moved)


def predict(settings: FilterSettings, state: FilterState, rotation: Array, dt: float) -> None:
    """Predict lengths, B and the covariance by the *rotation* (m,), rad, of the winch drums in *dt*, s."""
    lay, P, J = state.layout, state.P, state.jacobian
    paid_out = state.radii * rotation
    moved = J @ paid_out
    state.lengths = state.lengths + paid_out
    state.position = state.position + moved
    if dt > 0.0 and rotation.any():
        gain = min(1.0, dt / settings.chain.slackness.smoothing_time)
        state.drum_rates = state.drum_rates + gain * (rotation / dt - state.drum_rates)
    by_radius, rows = J * paid_out, P[lay.radii]  # of B, per share of each radius
    P[lay.position] += by_radius @ rows
    P[lay.lengths] += paid_out[:, None] * rows
    columns = P[:, lay.radii]
    P[:, lay.position] += columns @ by_radius.T
    P[:, lay.lengths] += columns * paid_out
    distance = math.sqrt(float(moved @ moved))
    unknown = np.count_nonzero(np.isnan(state.slackness.excess)) > 1  # which line is slack
    travel_noise = _UNKNOWN_SLACK_NOISE if unknown else settings.travel_noise
    variance = travel_noise**2 * distance + settings.drift_noise**2 * dt
    variances = diagonal(P)
    variances[lay.position] += variance
    variances[lay.lengths] += variance
    variances[lay.radii] += settings.radius_noise**2 * np.abs(rotation)
    variances[lay.ground] += settings.ground_noise**2 * distance


def update(settings: FilterSettings, state: FilterState) -> None:
    """Update by the excess of each line with a measured angle, every 0.2 s."""
    if state.time - state.last_angle_time < _ANGLE_INTERVAL or state.taut is None:
        return
    state.last_angle_time = state.time
    measured, sigmas, known = _measured_excess(settings, state)
    lay, taut = state.layout, state.taut
    H = np.zeros((len(measured), lay.size))
    H[:, lay.position] = -taut.toward
    H[:, lay.lengths] = np.eye(len(measured))
    innovation = measured - excess(state)
    for i in np.flatnonzero(known):
        R = np.array([[sigmas[i] ** 2]])
        if not passes_gate(state.P, H[i : i + 1], innovation[i : i + 1], R)[
            0
        ]:  # the position is measured, so the length must be wrong
            state.P[lay.lengths, lay.lengths][i, i] += float(innovation[i]) ** 2
        update_state(state, H[i : i + 1], innovation[i : i + 1], R)
        innovation = measured - excess(state)


def _measured_excess(settings: FilterSettings, state: FilterState) -> tuple[Array, Array, Mask]:
    """Excess (m,), m, of each line, its standard deviation (m,), m, and which lines have a measured angle (m,)."""
    taut, slackness, sensors = state.taut, state.slackness, settings.chain.slackness
    assert taut is not None  # `update_jacobian` has run
    m, compliance = settings.chain.model.m, settings.chain.model.lines.free_compliance * taut.lengths
    slack, measured = visibly_slack(sensors, slackness), np.isfinite(slackness.excess)
    tan = np.tan(taut.angles)
    slope = np.maximum(np.tan(np.minimum(taut.angles + slackness.differences, 1.5)) - tan, 1e-4)
    by_angle = parabolic_excess(sensors, taut, slackness.differences)
    sigma = 2.0 * np.abs(by_angle) / slope * settings.line_angle_sigma / np.cos(taut.angles) ** 2
    sigma = np.sqrt(sigma**2 + settings.excess_sigma**2 + (0.03 * by_angle) ** 2)
    weight = state.mass * settings.chain.tilt.gravity
    max_tension = weight / np.maximum(-np.sin(taut.angles), 0.1) / 2.0
    stretch = stretch_sigma = 0.5 * compliance * max_tension
    slack_lines = np.flatnonzero(slack)
    if len(slack_lines) == 1:
        (i,) = slack_lines
        others = np.arange(m) != i
        tension = _horizontal_forces(settings, state)[i] / math.cos(float(taut.angles[i]))
        load = np.array([0.0, 0.0, -weight]) - tension * taut.toward[i]
        if m == 4:
            tensions = np.linalg.solve(taut.toward[others].T, load)
            stretch = stretch.copy()
            stretch[others] = compliance[others] * tensions
            stretch_sigma = np.where(others, settings.stretch_sigma * np.abs(stretch), stretch_sigma)
    repeats = math.sqrt(_STRETCH_TIME / _ANGLE_INTERVAL)  # the error is the same in so many updates
    stretch_sigma = repeats * np.sqrt(stretch_sigma**2 + settings.excess_sigma**2)
    return np.where(slack, by_angle, -stretch), np.where(slack, sigma, stretch_sigma), measured
