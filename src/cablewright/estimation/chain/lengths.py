"""Unstrained lengths that put the drum where the lidars see it, with the line slack that the accelerometers say."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.errors import AnswerError, Status
from cablewright.estimation.slackness import SlacknessSettings, SlacknessState, Taut, exact_excess, excess_of, taut_at
from cablewright.models.statics import Equilibrium
from cablewright.solvers.continuation import Tracker, TrackerSettings
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.slack import solve_with_slack

__all__ = ["bring", "excess_now", "hang", "visible"]

Array = NDArray[np.float64]

_ROUNDS: Final = 4
_CLOSE: Final = 1e-4  # m: how near to its place the drum has to come


def visible(settings: SlacknessSettings, state: SlacknessState) -> NDArray[np.bool_]:
    """Lines whose angle tells an excess, (m,): they are heard, and sag enough to be seen."""
    return np.isfinite(state.excess) & (state.differences > settings.seen)


def excess_now(settings: SlacknessSettings, state: SlacknessState, taut: Taut, lengths: Array) -> Array:
    """Excess (m,), m: by the angle where that tells it, else by the lengths."""
    return np.where(visible(settings, state), state.excess, lengths - taut.lengths)


def _loosest(settings: SlacknessSettings, state: SlacknessState, taut: Taut) -> tuple[int, float] | None:
    """Return the line with the most excess and its excess, m, as a catenary; None if none sags visibly."""
    seen = visible(settings, state)
    if not seen.any():
        return None
    line = int(np.argmax(np.where(seen, state.excess, -np.inf)))
    return line, exact_excess(settings, taut, line, float(state.differences[line]))


def _room(settings: SlacknessSettings, state: SlacknessState, taut: Taut) -> Array:
    """Most excess (m,), m, that each line may have by its angle: what is seen, or would just be; inf if not heard."""
    differences = np.maximum(np.where(np.isnan(state.differences), 0.0, state.differences), settings.seen)
    return np.where(np.isfinite(state.excess), excess_of(settings, taut, differences), np.inf)


def hang(
    settings: SlacknessSettings, state: SlacknessState, target: Array, follow: TrackerSettings
) -> tuple[Tracker, Array] | str:
    """Hang the drum at *target* (3,), m, from nothing: a tracker there and its lengths (m,), or why it cannot hang."""
    model, loose = settings.model, _loosest(settings, state, taut_at(settings.model, target))
    held: Equilibrium | None = None
    if loose is not None:
        held = solve_with_slack(model, target, {loose[0]: max(loose[1], 0.0)})
    if held is None or not held.ok:
        held = solve_inverse(model, target)
    if not held.ok:
        return f"the drum cannot hang where the lidars put it: {held.sentence()}"
    try:
        return Tracker(model, held.lengths, follow), held.lengths.copy()
    except AnswerError as reason:
        return f"the drum cannot hang where the lidars put it: {reason}"


def bring(
    settings: SlacknessSettings, state: SlacknessState, tracker: Tracker, lengths: Array, target: Array
) -> tuple[Array, Status]:
    """Change *lengths* (m,), m, until *tracker* has the drum at *target* (3,), m. Returns them, and how that went.

    The loosest line gets the excess that its angle tells; each other grows as its straight tangent does, but to no more
    excess than its angle leaves room for.
    """
    there = taut_at(settings.model, target)
    loose = _loosest(settings, state, there)
    most = there.lengths + _room(settings, state, there)
    for _ in range(_ROUNDS):
        away = target - tracker.pose
        toward = taut_at(settings.model, tracker.pose).toward
        wanted = np.minimum(lengths + toward @ away, most)
        if loose is not None:
            wanted[loose[0]] = there.lengths[loose[0]] + loose[1]
        if not (wanted > 0.0).all():  # NaN where a line has no tangent
            return lengths, Status.INSIDE_SHEAVE
        status = tracker.step(wanted)
        if status is not Status.OK:
            return lengths, status
        lengths = wanted
        if float(np.abs(target - tracker.pose).max()) < _CLOSE:
            break
    return lengths, Status.OK
