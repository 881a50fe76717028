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
from cablewright.estimation.kalman.sag import Balanced, Sag, balanced, each_alone
from cablewright.estimation.kalman.settings import FilterSettings
from cablewright.estimation.kalman.state import FilterState, Hung, apply_update, diagonal, inflate_shaken, judge
from cablewright.foundation.arrays import Array, Indices
from cablewright.kernels import Direct
from cablewright.kernels.filtering import predict as predicting
from cablewright.kernels.filtering import sagging_lines
from cablewright.kernels.filtering.estimate import excess_of
from cablewright.kernels.filtering.sagging_lines import LAWS
from cablewright.solvers.taut import taut_at

_JACOBIAN_INTERVAL: Final = 0.05  # s between computations of the Jacobian
_ANGLE_INTERVAL: Final = 0.2  # s between updates by the angles, which are smoothed over as long
_STRETCH_TIME: Final = 10.0  # s for which the error of a taut line's stretch is correlated
_SHAKEN_TIME: Final = 2.0  # s after an acceleration that encoders do not show, without updates
_MAX_SHAKEN: Final = 10.0  # s from the first that is rejected, in which updates are left out
_CHI2_OF_LINES: Final = 31.8  # exceeded by one of 10 000
_REEL: Final = Direct(predicting.reel)
_WEIGHT_EXCESS: Final = 1e-4  # m, of the excess that a counterweight gives its line


def update_jacobian(settings: FilterSettings, state: FilterState, *, at_once: bool = False) -> None:
    """Compute the taut lines at B and the Jacobian of B by lengths, if they are old or *at_once*.

    Slow changes are predicted with them: rates of stretch, effects of compliances, and radii where layers of the coils
    end.
    """
    if not at_once and state.time - state.hung.time < _JACOBIAN_INTERVAL:
        return
    model, (x, _, at), hung, lines = settings.machine.model, state.mean, state.hung, state.lines
    predicting.spread(
        x, state.P, at, hung.jacobian, hung.by_compliance, lines.loosened,
        lines.stretching, settings.stretch_time, settings.stretch_rate_sigma,
    )  # fmt: skip
    lines.stretching = 0.0
    if settings.layers is not None:
        _predict_layers(settings.layers, state)
    there = state.motion.position.copy()
    taut = taut_at(model, there)
    if not np.isfinite(taut.toward).all():
        state.monitor.report("encoders", "lost", "a line has no tangent at the estimated position")
        return
    laws, jacobian, by_compliance = np.empty((LAWS, model.m)), np.empty((3, model.m)), np.empty((3, model.m))
    rising = sagging_lines.hang(
        model.packed.lines, x, at, settings.hanging, settings.machine.slackness.from_platform, there,
        taut.angles, taut.free, taut.lengths, taut.toward, laws, jacobian, by_compliance,
    )  # fmt: skip
    if math.isnan(rising[0]):
        state.monitor.report("encoders", "lost", "the lines leave a direction free at the estimated position")
        return
    state.monitor.clear("encoders", "lost")
    state.taut, state.hung = taut, Hung(there, state.time, Sag(laws), jacobian, rising, by_compliance)
    if settings.hanging.any():
        _hang_weights(state, model.lines.counterweight)


def _hang_weights(state: FilterState, weights: Array) -> None:
    """Set the excess of lines with counterweights of *weights* (m,), N, to the excess by their weight, at any B."""
    lay, P = state.layout, state.P
    assert state.taut is not None  # as found just now
    assert state.hung.sag is not None
    hung = np.flatnonzero(weights)
    rows = lay.lengths.start + hung
    given = state.taut.lengths + state.hung.sag.excess(np.maximum(weights, 1.0) * np.cos(state.taut.angles))
    state.lines.lengths[hung] = given[hung]
    P[rows] = state.taut.toward[hung] @ P[lay.position]
    P[:, rows] = P[rows].T
    P[np.ix_(rows, rows)] = state.taut.toward[hung] @ P[np.ix_(range(P.shape[0]), rows)][lay.position]
    P[rows, rows] += _WEIGHT_EXCESS**2


def excess(state: FilterState) -> Array:
    """Return the excess (m,), m, of each line's length over its taut length."""
    assert state.taut is not None  # `update_jacobian` has run
    found = np.empty(len(state.taut.lengths))
    excess_of(state.mean.x, state.mean.at, state.taut.lengths, state.taut.toward, state.hung.position, found)
    return found


def reel(
    settings: FilterSettings,
    state: FilterState,
    counts: tuple[Indices, Indices],
    rotation: Array,
    dt: float,
    *,
    rolls: bool,
    pauses: bool,
) -> int:
    """Predict lengths, B and the covariance by *counts* (w,) now and *dt*, s, before, see the kernel `predict.reel`."""
    motion, hung, taut, drums = state.motion, state.hung, state.taut, settings.drums
    assert taut is not None  # `begin` has found it
    (x, _, at), lines = state.mean, state.lines
    shown: int = _REEL.call(
        x, state.P, at, hung.jacobian, taut.toward, settings.hanging, *counts, drums.winch, drums.sense,
        settings.counting, rolls, pauses, state.slackness.excess,
        settings.uncrept if state.creep is None else state.creep.rates, settings.rolling, dt,
        lines.loosened, motion.coasted, motion.drum_rates, motion.drum_angles, rotation,
    )  # fmt: skip
    if shown != predicting.JUMPED and shown & predicting.ROLLED:
        lines.stretching += dt
    return shown


def _predict_layers(layers: CoilLayers, state: FilterState) -> None:
    """Predict the radii where layers of the coils end."""
    expected = layers.radii(state.lines.lengths)
    change, state.lines.layer_radii = expected - state.lines.layer_radii, expected
    if change.any():
        diagonal(state.P)[state.layout.radii] += layers.doubt(change, state.lines.radii)
        state.lines.radii += change


def update(settings: FilterSettings, state: FilterState) -> None:
    """Update the filter by the measured angles of all lines, at most every 0.2 s.

    The update changes lengths, position and accelerometer zeros. Of all line forces that balance the platform, the most
    probable ones by excesses and angles are used. The one combination of forces that the balance leaves open is not
    used.
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
    H[:m, lay.compliances] = np.diag(sag.laws[sagging_lines.STRETCHING] * alone)
    known = H @ state.P @ H.T
    zeros = state.lines.zeros[lines]
    angles = state.slackness.differences[lines] - zeros
    measured = np.column_stack([lines, angles, state.slackness.variances[lines], zeros])
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
    # lengths have unmodelled errors, which over hours would move the lidars' estimated positions wrongly
    apply_update(state, H, found.innovation, found.noise, found.spread, lay.placed)


def _doubt_zeros(settings: FilterSettings, state: FilterState, lines: NDArray[np.intp], more: Array) -> None:
    """Make the zeros of j *lines* less sure by variances *more* (j,), rad^2, and as much nearer to the specified value.

    The learnt deviation of a zero from its specified value counts less: without that it would wander off in steps.
    """
    first = settings.zero_sigma**2
    if first > 0.0:
        variances = diagonal(state.P)[state.layout.zeros]
        before = variances[lines]
        after = np.maximum(before, np.minimum(before + more, first))
        variances[lines] = after
        learnt = np.maximum(first - before, 1e-3 * first)
        state.lines.zeros[lines] *= np.clip((first - after) / learnt, 0.0, 1.0)


class _Mixture(NamedTuple):
    """Moments of the innovations over all candidate forces, each weighted by its likelihood."""

    innovation: Array  # (m + j,)
    noise: Array  # (m + j, m + j)
    spread: Array  # (m + j, m + j)
    nis: float  # normalised square of the likeliest innovation
    forces: Array  # (m,) N, horizontal


def _mixture(
    settings: FilterSettings, sag: Sag, may_be: Balanced, known: Array, now: Array, measured: Array
) -> _Mixture:
    """Return the mixture for an excess *now* (m,), m, and *measured* angles (j, 4), see `sagging_lines.weigh_forces`.

    *known*: their covariance by the state.
    """
    m, d = len(now), len(known)
    found = _Mixture(np.empty(d), np.empty((d, d)), np.empty((d, d)), 0.0, np.empty(m))
    sigmas = np.array([
        settings.stretch_sigma, settings.excess_sigma, settings.line_angle_sigma, settings.zero_sigma,
        math.sqrt(_STRETCH_TIME / _ANGLE_INTERVAL),
    ])  # fmt: skip
    nis = sagging_lines.weigh_forces(
        sag.laws, may_be.forces, may_be.unsure, known, now, measured, sigmas,
        found.innovation, found.noise, found.spread, found.forces,
    )  # fmt: skip
    return found._replace(nis=nis)
