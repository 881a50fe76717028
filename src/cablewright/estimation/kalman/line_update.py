"""Prediction by encoders, and update by line angles.

Encoders: changes of the lengths, and creep as it is described, move B, each line weighted by its stiffness; that of a
sagging line is reduced by its sag (Ernst 1965), so a slack line hardly counts. Angles: a sagging line's excess is
measured; a taut line is shorter than its taut length by its stretch, which balance gives if one line is slack, else it
is known only within bounds.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.estimation.kalman.coil_layers import CoilLayers
from cablewright.estimation.kalman.gauss_markov import fade
from cablewright.estimation.kalman.sag import Balanced, Sag, balanced, each_alone, share_at
from cablewright.estimation.kalman.state import (
    FilterSettings,
    FilterState,
    apply_update,
    diagonal,
    inflate_shaken,
    judge,
)
from cablewright.foundation.arrays import Array
from cablewright.kernels.covariance import add_multiples
from cablewright.solvers.taut import stretches, taut_at

_JACOBIAN_INTERVAL: Final = 0.05  # s between computations of the Jacobian
_ANGLE_INTERVAL: Final = 0.2  # s between updates by the angles, which are smoothed over as long
_STRETCH_TIME: Final = 10.0  # s for which the error of a taut line's stretch is correlated
_PLACES: Final = np.linspace(0.0, 1.0, 80)  # in the range of the unknown force
_REFINEMENTS: Final = 4
_ENOUGH: Final = 10  # likely forces
_UNLIKELY: Final = 12.0  # twice the logarithm of a likelihood below the largest
_SHAPE_ERROR: Final = 0.01  # of an angle near the platform
_SHAKEN_TIME: Final = 2.0  # s after an acceleration that encoders do not show, without updates
_MAX_SHAKEN: Final = 10.0  # s from the first that is rejected, in which updates are left out
_CHI2_OF_LINES: Final = 31.8  # exceeded by one of 10 000
_WEIGHT_EXCESS: Final = 1e-4  # m, of the excess that a counterweight gives its line
_UNKNOWN_SLACK_NOISE: Final = 0.02  # m per root metre that B moves, where it is not known which line is slack


def update_jacobian(settings: FilterSettings, state: FilterState, *, at_once: bool = False) -> None:
    """Compute the taut lines at B and the Jacobian of B by lengths, if they are old or *at_once*.

    What changes as slowly is predicted with them: rates of stretch, what compliances did, and radii where layers of the
    coils end.
    """
    if not at_once and state.time - state.hung.time < _JACOBIAN_INTERVAL:
        return
    _spread_stretch(settings, state)
    _spread_compliances(state)
    if settings.layers is not None:
        _predict_layers(settings.layers, state)
    model = settings.machine.model
    taut = taut_at(model, state.motion.position)
    if not np.isfinite(taut.toward).all():
        state.monitor.report("encoders", "lost", "a line has no tangent at the estimated position")
        return
    state.monitor.clear("encoders", "lost")
    state.taut, state.hung.position, state.hung.time = taut, state.motion.position.copy(), state.time
    lines, c = model.lines, np.cos(taut.angles)
    state.hung.sag = Sag.at(settings.machine.slackness, taut, state.lines.compliances)
    h = state.hung.sag.forces(excess(state))
    sag = lines.spans * (lines.weight * c) ** 2 * taut.free**3 / (12.0 * h**3)
    stretching = state.lines.compliances * stretches(lines, taut)
    stiffness = np.where(lines.counterweight > 0.0, 0.0, 1.0 / (stretching + sag + 1e-12))
    weighted = taut.toward.T * stiffness  # (3, m)
    state.hung.stiffness = weighted @ taut.toward
    state.hung.jacobian = np.asarray(np.linalg.solve(state.hung.stiffness, weighted), dtype=np.float64)
    state.hung.by_compliance = -state.hung.jacobian * (stiffness * stretching)
    if settings.hung is not None:
        _hang_weights(state, lines.counterweight, c)


def _hang_weights(state: FilterState, weights: Array, cosines: Array) -> None:
    """Let lines with counterweights of *weights* (m,), N, have the excess that these give them, at B wherever it is."""
    lay, P = state.layout, state.P
    assert state.taut is not None  # as found just now
    assert state.hung.sag is not None
    hung = np.flatnonzero(weights)
    rows = lay.lengths.start + hung
    given = state.taut.lengths + state.hung.sag.excess(np.maximum(weights, 1.0) * cosines)
    state.lines.lengths = np.where(weights > 0.0, given, state.lines.lengths)
    P[rows] = state.taut.toward[hung] @ P[lay.position]
    P[:, rows] = P[rows].T
    P[np.ix_(rows, rows)] = state.taut.toward[hung] @ P[np.ix_(range(P.shape[0]), rows)][lay.position]
    P[rows, rows] += _WEIGHT_EXCESS**2


def excess(state: FilterState) -> Array:
    """Excess (m,), m, of each line over its taut length."""
    assert state.taut is not None  # `update_jacobian` has run
    moved = state.motion.position - state.hung.position
    return np.asarray(state.lines.lengths - state.taut.lengths - state.taut.toward @ moved)


def predict(settings: FilterSettings, state: FilterState, rotation: Array, dt: float) -> None:
    """Predict lengths, B and the covariance by the *rotation* (m,), rad, of the winch drums in *dt*, s."""
    lay, P, J = state.layout, state.P, state.hung.jacobian
    paid_out = state.lines.radii * rotation
    stretched = dt * state.lines.stretch_rates
    if state.creep is not None:
        stretched = stretched + dt * state.creep.rates * state.lines.lengths
    state.lines.stretching += dt
    unseen = J @ stretched
    moved = J @ paid_out + unseen
    state.motion.coasted[:3] += unseen
    assert state.taut is not None  # `begin` has found it
    if settings.hung is not None:
        paid_out = paid_out + np.where(settings.hung, state.taut.toward @ moved, 0.0)  # their lines follow B
    state.lines.lengths = state.lines.lengths + paid_out + stretched
    state.lines.loosened = state.lines.loosened + paid_out + stretched - state.taut.toward @ moved
    state.motion.position = state.motion.position + moved
    if dt > 0.0 and any(rotation.tolist()):
        gain = min(1.0, dt / settings.machine.slackness.smoothing_time)
        state.motion.drum_rates = state.motion.drum_rates + gain * (rotation / dt - state.motion.drum_rates)
    add_multiples(P, lay.position.start, lay.radii.start, J * paid_out)  # radii as shares
    add_multiples(P, lay.lengths.start, lay.radii.start, np.diag(paid_out))
    distance = math.sqrt(float(moved @ moved))
    unknown = np.count_nonzero(np.isnan(state.slackness.excess)) > 1  # which line is slack
    travel_noise = _UNKNOWN_SLACK_NOISE if unknown else settings.travel_noise
    variance = travel_noise**2 * distance + settings.drift_noise**2 * dt
    variances = diagonal(P)
    variances[lay.position] += variance
    variances[lay.lengths] += variance
    variances[lay.radii] += settings.radius_noise**2 * np.abs(rotation)
    variances[lay.ground] += settings.ground_noise**2 * distance


def _predict_layers(layers: CoilLayers, state: FilterState) -> None:
    """Predict the radii where layers of the coils end."""
    expected = layers.radii(state.lines.lengths)
    change, state.lines.layer_radii = expected - state.lines.layer_radii, expected
    if change.any():
        diagonal(state.P)[state.layout.radii] += layers.doubt(change, state.lines.radii)
        state.lines.radii = state.lines.radii + change


def _spread_stretch(settings: FilterSettings, state: FilterState) -> None:
    """Predict the rates of stretch, and what they did to the covariance of lengths and B, since the last time.

    A rate is a Gauss-Markov process.
    """
    lay, P, J, dt = state.layout, state.P, state.hung.jacobian, state.lines.stretching
    if not dt > 0.0:
        return
    state.lines.stretching = 0.0
    add_multiples(P, lay.position.start, lay.stretch.start, dt * J)
    add_multiples(P, lay.lengths.start, lay.stretch.start, dt * np.eye(len(state.lines.lengths)))
    keep = fade(P, lay.stretch, dt / settings.stretch_time, (settings.stretch_rate_sigma * state.lines.lengths) ** 2)
    state.lines.stretch_rates = keep * state.lines.stretch_rates


def _spread_compliances(state: FilterState) -> None:
    """Predict what compliances did to the covariance of B, since the last time.

    A line that gives more than its stiffness k tells moves B by less for a change e of its excess: (u'Ku) dp = u e dk.
    """
    lay = state.layout
    add_multiples(state.P, lay.position.start, lay.compliances.start, state.hung.by_compliance * state.lines.loosened)
    state.lines.loosened = np.zeros_like(state.lines.loosened)


def update(settings: FilterSettings, state: FilterState) -> None:
    """Update lengths, position and the accelerometers' zeros by the angles of all lines, every 0.2 s.

    Of all forces that balance the drum the likeliest are taken, by their excesses and angles; along the number that the
    balance leaves open they are not relied on.
    """
    if state.time - state.lines.last_angle_time < _ANGLE_INTERVAL or state.taut is None or state.hung.sag is None:
        return
    state.lines.last_angle_time = state.time
    sensors, lay, m = settings.machine.slackness, state.layout, len(state.lines.lengths)
    lines = np.flatnonzero(np.isfinite(state.slackness.excess))
    if not len(lines):
        return
    sag, now = state.hung.sag, excess(state)
    alone = sag.forces(now)
    H = np.zeros((m + len(lines), lay.size))
    H[:m, lay.position] = -state.taut.toward
    H[:m, lay.lengths] = np.eye(m)
    H[m + np.arange(len(lines)), lay.zeros.start + lines] = 1.0
    H[:m, lay.compliances] = np.diag(sag.stretching * alone)
    known = H @ state.P @ H.T
    angles = (state.slackness.differences - state.lines.zeros)[lines]
    measured = _Angles(lines, angles, state.slackness.variances[lines], state.lines.zeros[lines])
    weight = state.motion.mass * settings.machine.tilt.gravity
    may_be = balanced(sensors, state.taut, weight, settings.mass_sigma * weight) or each_alone(alone)
    found = _mixture(settings, sag, may_be, known, now, measured)
    if state.creep is not None:
        state.creep.follow(found.forces / np.cos(state.taut.angles), state.time)
    if state.time - state.attitude.shaken_time < _SHAKEN_TIME or state.time < state.motion.bounce_end:
        return
    refused = not found.nis <= _CHI2_OF_LINES
    state.lines.angles_refused_since = min(state.lines.angles_refused_since, state.time) if refused else math.inf
    if (
        state.time - state.lines.angles_refused_since < _MAX_SHAKEN and refused
    ):  # a shaken drum's forces do not balance it
        inflate_shaken(state)
        return
    if refused:  # the position is measured, so lengths must be wrong
        diagonal(state.P)[lay.lengths] += found.innovation[:m] ** 2
        _doubt_zeros(settings, state, lines, found.innovation[m:] ** 2)
    judge(state, "line_angles", found.nis, len(found.innovation) - 1)
    # a length is off by what no model has, which over hours would tell where lidars are, wrongly
    apply_update(state, H, found.innovation, found.noise, found.spread, lay.surveyed)


def _doubt_zeros(settings: FilterSettings, state: FilterState, lines: NDArray[np.intp], more: Array) -> None:
    """Make the zeros of j *lines* less sure by variances *more* (j,), rad^2, and as much less far from what was told.

    What was learnt of a zero besides what its owner was told counts less: without that it would wander off in steps.
    """
    first = settings.zero_sigma**2
    if first > 0.0:
        variances = diagonal(state.P)[state.layout.zeros]
        before = variances[lines]
        after = np.maximum(before, np.minimum(before + more, first))
        variances[lines] = after
        learnt = np.maximum(first - before, 1e-3 * first)
        state.lines.zeros[lines] *= np.clip((first - after) / learnt, 0.0, 1.0)


class _Angles(NamedTuple):
    """Smoothed angles of j lines near the platform less those of straight lines, and less their sensors' zeros."""

    lines: NDArray[np.intp]
    angles: Array  # (j,) rad
    variances: Array  # (j,) rad^2
    zeros: Array  # (j,) rad, that were taken off


class _Mixture(NamedTuple):
    """Moments of the innovations that all forces together give, each weighted by its likelihood."""

    innovation: Array  # (m + j,)
    noise: Array  # (m + j, m + j)
    spread: Array  # (m + j, m + j)
    nis: float  # normalised square of the likeliest innovation
    forces: Array  # (m,) N, horizontal


def _mixture(
    settings: FilterSettings, sag: Sag, may_be: Balanced, known: Array, now: Array, measured: _Angles
) -> _Mixture:
    """Return the mixture for an excess *now* (m,), m, and *measured* angles.

    *known*: their covariance by the state. The grid of forces is refined until several of them are about as likely.
    """
    places = _PLACES
    for _ in range(_REFINEMENTS):
        shares = share_at(places)
        forces = may_be.forces(shares)
        differences = sag.differences(forces)[:, measured.lines]
        noise = _noise(settings, sag, forces, differences, may_be.unsure(shares), measured)
        off = np.hstack([sag.excess(forces) - now, measured.angles - differences])  # (k, m + j)
        S = known + noise
        nis = np.einsum("ki,ki->k", off, np.linalg.solve(S, off[:, :, None])[:, :, 0])
        cost = nis + np.linalg.slogdet(S)[1] - 2.0 * np.log(np.gradient(shares))
        if settings.zero_sigma > 0.0:  # what was learnt step by step may not leave what the owner was told
            told = settings.zero_sigma**2 + settings.line_angle_sigma**2 + measured.variances
            cost += ((off[:, len(now) :] + measured.zeros) ** 2 / told).sum(axis=1)
        likely = np.flatnonzero(cost <= cost.min() + _UNLIKELY)
        if len(likely) >= _ENOUGH:
            break
        low, high = places[max(likely[0] - 1, 0)], places[min(likely[-1] + 1, len(places) - 1)]
        places = np.linspace(low, high, len(places))
    weights = np.exp(-0.5 * (cost - cost.min()))
    weights /= weights.sum()
    mean = weights @ off
    spread = (weights * (off - mean).T) @ (off - mean)
    return _Mixture(mean, np.tensordot(weights, noise, 1), spread, float(nis.min()), weights @ forces)


def _noise(
    settings: FilterSettings, sag: Sag, forces: Array, differences: Array, unsure: Array, measured: _Angles
) -> Array:
    """Covariances (k, m + j, m + j) of excesses, m, and of measured angles, rad.

    *differences* (k, j), rad: of these by the forces. *unsure* (k, m, j), N: what is not sure in the forces (k, m), as
    in `Balanced`.
    """
    stretch, slack = sag.stretching * forces, sag.sagging / forces**2
    repeats = math.sqrt(_STRETCH_TIME / _ANGLE_INTERVAL)  # the error is the same in so many updates
    by_length = (repeats * settings.stretch_sigma * stretch) ** 2 + settings.excess_sigma**2 + (0.03 * slack) ** 2
    shape = repeats * _SHAPE_ERROR * differences  # no line is a parabola
    own = settings.line_angle_sigma**2 + shape**2 + measured.variances
    slopes = np.hstack([-sag.excess_slopes(forces), sag.difference_slopes(forces)[:, measured.lines]])  # (k, m + j)
    moved = slopes[:, :, None] * np.concatenate([unsure, unsure[:, measured.lines]], axis=1)
    noise = moved @ moved.transpose(0, 2, 1)
    np.einsum("kii->ki", noise)[:] += np.hstack([by_length, own])
    return np.asarray(noise)
