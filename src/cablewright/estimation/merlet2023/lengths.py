"""Unstrained lengths that bring the platform to the lidars' position, with slack measured by accelerometers."""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.estimation.slackness import SlacknessSettings, SlacknessState, catenary_excess, parabolic_excess
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import AnswerError, Status
from cablewright.models.statics import Equilibrium
from cablewright.solvers.continuation import Tracker, TrackerSettings
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.slack import solve_with_slack
from cablewright.solvers.taut import Taut, taut_at

_MAX_ITERATIONS: Final = 4
_TOLERANCE: Final = 1e-4  # m, of the drum's position


def visibly_slack(settings: SlacknessSettings, state: SlacknessState) -> Mask:
    """Return the lines (m,) whose measured angle determines the excess: they have a reading, and sag enough for it.

    That of a line with a counterweight is given by the weight.
    """
    wound = settings.model.lines.counterweight == 0.0
    return np.asarray(np.isfinite(state.excess) & (state.differences > settings.visible_angle) & wound)


def current_excess(settings: SlacknessSettings, state: SlacknessState, taut: Taut, lengths: Array) -> Array:
    """Return the excess length (m,), m: by the angle of lines that are visibly slack, by length of the others."""
    return np.where(visibly_slack(settings, state), state.excess, lengths - taut.lengths)


def followed(tracker: Tracker, lengths: Array) -> Array:
    """Return *lengths* (m,), m, of which counterweighted lines have their length at the pose of *tracker*."""
    hung = tracker.model.lines.counterweight > 0.0
    return np.where(hung, tracker.solved.lengths[0], lengths) if hung.any() else lengths


def _slackest(settings: SlacknessSettings, state: SlacknessState, taut: Taut) -> tuple[int, float] | None:
    """Return the line with the largest excess, and that excess, m, as a catenary; None if none is visibly slack."""
    visible = visibly_slack(settings, state)
    if not visible.any():
        return None
    line = int(np.argmax(np.where(visible, state.excess, -np.inf)))
    return line, catenary_excess(settings, taut, line, float(state.differences[line]))


def _max_excess(settings: SlacknessSettings, state: SlacknessState, taut: Taut) -> Array:
    """Upper bound (m,), m, of each line's excess: by its angle or the visible one if larger; inf without a reading."""
    differences = np.maximum(np.where(np.isnan(state.differences), 0.0, state.differences), settings.visible_angle)
    return np.where(np.isfinite(state.excess), parabolic_excess(settings, taut, differences), np.inf)


def hang_at(
    settings: SlacknessSettings, state: SlacknessState, target: Array, follow: TrackerSettings
) -> tuple[Tracker, Array] | str:
    """Return a tracker with the platform at *target* (3,), m, and its lengths (m,), m; or a reason why not."""
    model, slackest = settings.model, _slackest(settings, state, taut_at(settings.model, target))
    held: Equilibrium | None = None
    if slackest is not None:
        held = solve_with_slack(model, target, {slackest[0]: max(slackest[1], 0.0)})
    if held is None or not held.ok:
        held = solve_inverse(model, target)
    if not held.ok:
        return f"no equilibrium at the lidars' position: {held.sentence()}"
    try:
        return Tracker(model, held.lengths, follow), held.lengths.copy()
    except AnswerError as reason:
        return f"no equilibrium at the lidars' position: {reason}"


def move_to(
    settings: SlacknessSettings, state: SlacknessState, tracker: Tracker, lengths: Array, target: Array
) -> tuple[Array, Status]:
    """Change *lengths* (m,), m, until *tracker* has the platform at *target* (3,), m. Returns lengths and status.

    The slackest line gets the excess of its angle; each other line changes as its straight tangent, with at most the
    excess that its angle allows.
    """
    taut = taut_at(settings.model, target)
    slackest = _slackest(settings, state, taut)
    max_lengths = taut.lengths + _max_excess(settings, state, taut)
    for _ in range(_MAX_ITERATIONS):
        away = target - tracker.pose
        toward = taut_at(settings.model, tracker.pose).toward
        trial = np.minimum(lengths + toward @ away, max_lengths)
        if slackest is not None:
            trial[slackest[0]] = taut.lengths[slackest[0]] + slackest[1]
        if not (trial > 0.0).all():  # NaN where a line has no tangent
            return lengths, Status.INSIDE_SHEAVE
        status = tracker.step(trial)
        if status is not Status.OK:
            return lengths, status
        lengths = followed(tracker, trial)
        if float(np.abs(target - tracker.pose).max()) < _TOLERANCE:
            break
    return lengths, Status.OK
