"""What lines tell the filter: how B moves as they grow, and how much longer than taut each is.

Encoders: B goes where the lengths' changes lead it, each line counting by its stiffness, which of a sagging one is what
its sag leaves (Ernst 1965); a slack line hardly counts. Angles: the excess of a line that sags; of one that does not,
that it is shorter than taut by its stretch, which is known from balance if one line is slack, else only within bounds.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.estimation.chain.lengths import visible
from cablewright.estimation.kalman.state import FilterSettings, FilterState, correct, fuse, likely
from cablewright.estimation.slackness import excess_of, taut_at
from cablewright.kernels import layout

__all__ = ["carry", "draw", "excess", "listen"]

Array = NDArray[np.float64]

_DRAWN: Final = 0.05  # s after which the lines are drawn anew
_LISTEN: Final = 0.2  # s between uses of the angles, which are smoothed over as long
_SAME: Final = 10.0  # s for which what a taut line's stretch is off stays the same
_TAUT: Final = 1e6  # N: as good as straight
_DEAF: Final = 0.02  # m per root metre that B goes otherwise, if a slack line is taken for taut
_LOOSE: Final = 1e-4  # m of excess from which a line whose angle is not told sags


def draw(settings: FilterSettings, state: FilterState, *, at_once: bool = False) -> None:
    """Draw the lines straight where B is, and find how B moves as they grow."""
    if not at_once and state.time - state.drawn < _DRAWN:
        return
    model = settings.chain.model
    taut = taut_at(model, state.position)
    if not np.isfinite(taut.toward).all():
        state.watch.say("encoders", "lost", "a line has no tangent where the drum is believed to be")
        return
    state.watch.clear("encoders", "lost")
    state.taut, state.taut_at, state.drawn = taut, state.position.copy(), state.time
    lines, c = model.packed.lines, np.cos(taut.angles)
    h = _pulls(settings, state)
    sag = (lines[:, layout.WEIGHT] * c) ** 2 * taut.free**3 / (12.0 * h**3)
    stiffness = 1.0 / (lines[:, layout.FREE_COMPLIANCE] * taut.lengths + sag + 1e-12)
    weighted = taut.toward.T * stiffness  # (3, m)
    state.jacobian = np.asarray(np.linalg.solve(weighted @ taut.toward, weighted), dtype=np.float64)


def _pulls(settings: FilterSettings, state: FilterState) -> Array:
    """Horizontal force (m,) in each line, N, by its angle, or by its excess; much where it does not sag visibly."""
    taut, heard = state.taut, state.slackness
    assert taut is not None  # drawn
    weight, c = settings.chain.model.packed.lines[:, layout.WEIGHT], np.cos(taut.angles)
    angular = settings.chain.slackness
    told = np.isfinite(heard.excess)
    slope = np.tan(np.minimum(taut.angles + np.where(told, heard.differences, 0.0), 1.5)) - np.tan(taut.angles)
    known = told & visible(angular, heard)
    by_angle = weight * (0.5 * taut.free - angular.from_platform) / np.where(known, slope, 1.0)
    out = state.lengths - taut.lengths
    loose = ~told & (out > _LOOSE)
    by_length = weight * taut.free * c * np.sqrt(taut.free / (24.0 * np.where(loose, out, 1.0)))
    return np.maximum(np.where(known, by_angle, np.where(loose, by_length, _TAUT)), 1e-2)


def excess(state: FilterState) -> Array:
    """Excess (m,), m, of each line over its taut length."""
    assert state.taut is not None  # drawn
    away = state.position - state.taut_at
    return np.asarray(state.lengths - state.taut.lengths - state.taut.toward @ away)


def carry(settings: FilterSettings, state: FilterState, turned: Array, since: float) -> None:
    """Carry lengths and B on as the winch drums *turned* (m,), rad, in *since* s."""
    lay, P, J = state.layout, state.P, state.jacobian
    paid = state.radii * turned
    moved = J @ paid
    state.lengths = state.lengths + paid
    state.position = state.position + moved
    if since > 0.0 and turned.any():
        share = min(1.0, since / settings.chain.slackness.smooth)
        state.rates = state.rates + share * (turned / since - state.rates)
    by_place, rows = J * paid, P[lay.radii]  # per share of each radius
    P[lay.position] += by_place @ rows
    P[lay.lengths] += paid[:, None] * rows
    columns = P[:, lay.radii]
    P[:, lay.position] += columns @ by_place.T
    P[:, lay.lengths] += columns * paid
    way = math.sqrt(float(moved @ moved))
    deaf = np.count_nonzero(np.isnan(state.slackness.excess)) > 1  # which line is slack is not known
    spread = (_DEAF if deaf else settings.travel) ** 2 * way + settings.time**2 * since
    diagonal = P.reshape(-1)[:: len(P) + 1]
    diagonal[lay.position] += spread
    diagonal[lay.lengths] += spread
    diagonal[lay.radii] += settings.radius_walk**2 * np.abs(turned)
    diagonal[lay.ground] += settings.ground**2 * way


def listen(settings: FilterSettings, state: FilterState) -> None:
    """Let the line angles tell excesses, those that were not used yet."""
    if state.time - state.listened < _LISTEN or state.taut is None:
        return
    state.listened = state.time
    told, sigmas, known = _told(settings, state)
    lay, taut = state.layout, state.taut
    H = np.zeros((len(told), lay.size))
    H[:, lay.position] = -taut.toward
    H[:, lay.lengths] = np.eye(len(told))
    off = told - excess(state)
    for i in np.flatnonzero(known):
        R = np.array([[sigmas[i] ** 2]])
        fits, size = likely(state.P, H[i : i + 1], off[i : i + 1], R)
        if state.nis is not None:
            state.nis.append(("line", size, 1))
        if not fits:  # the place is measured, the length is what is not known: let it go
            state.P[lay.lengths, lay.lengths][i, i] += float(off[i]) ** 2
        correction, state.P = fuse(state.P, H[i : i + 1], off[i : i + 1], R)
        correct(state, correction)
        off = told - excess(state)


def _told(settings: FilterSettings, state: FilterState) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Excess of each line (m,), m, its standard deviation, and of which lines anything is known."""
    taut, heard, angular = state.taut, state.slackness, settings.chain.slackness
    assert taut is not None  # drawn
    lines = settings.chain.model.packed.lines
    compliance = lines[:, layout.FREE_COMPLIANCE] * taut.lengths
    sags, told = visible(angular, heard), np.isfinite(heard.excess)
    tan = np.tan(taut.angles)
    slope = np.maximum(np.tan(np.minimum(taut.angles + heard.differences, 1.5)) - tan, 1e-4)
    by_angle = excess_of(angular, taut, heard.differences)
    spread = 2.0 * np.abs(by_angle) / slope * settings.angle / np.cos(taut.angles) ** 2
    spread = np.sqrt(spread**2 + settings.excess**2 + (0.03 * by_angle) ** 2)
    weight = state.mass * settings.chain.tilt.gravity
    most = weight / np.maximum(-np.sin(taut.angles), 0.1) / 2.0
    stretch, doubt = 0.5 * compliance * most, 0.5 * compliance * most
    loose = np.flatnonzero(sags)
    if len(loose) == 1:
        (i,) = loose
        others = np.arange(len(lines)) != i
        pull = _pulls(settings, state)[i] / math.cos(float(taut.angles[i]))
        held = np.array([0.0, 0.0, -weight]) - pull * taut.toward[i]
        if len(lines) == 4:
            tensions = np.linalg.solve(taut.toward[others].T, held)
            stretch = stretch.copy()
            stretch[others] = compliance[others] * tensions
            doubt = np.where(others, settings.stretch * np.abs(stretch), doubt)
    lasting = math.sqrt(_SAME / _LISTEN)
    doubt = lasting * np.sqrt(doubt**2 + settings.excess**2)
    return np.where(sags, by_angle, -stretch), np.where(sags, spread, doubt), told
