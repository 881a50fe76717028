"""Diagnosis of readings that contradict the statics: a wrong load cell, a line of wrong length or that broke, a camera.

Each single cause predicts its own pattern of tensions, tilt and swivels. A wrong cell changes one number alone; a
line that is longer or shorter than its encoder says changes all tensions together, by the equilibrium of the changed
length; a line that broke pulls nothing, and the others carry the platform. The cause with the smallest residual is
named. After a line is lost the platform swings, and readings with it: then the machine must stop immediately, and the
line is named by the mean of some measurements that follow.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from cablewright.estimation.body import broken_line
from cablewright.estimation.body.broken_line import Hanging
from cablewright.estimation.body.measurement import Measurement
from cablewright.estimation.body.settings import BodySettings
from cablewright.estimation.body.state import BodyState, Contradiction
from cablewright.estimation.body.updates.update import HeldBody
from cablewright.foundation.arrays import Array
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.taut import taut_of

_SIGMAS: Final = 5.5  # of a normal distribution: how unlikely readings must be
_DOUBTS: Final = 2  # measurements in a row that contradict before a cause is named
_SWINGING: Final = 0.3  # m/s^2: acceleration of a platform that swings
_SEARCHED: Final = 8  # further measurements from which a line is named where it does
_PATIENCE: Final = (5.0, 30)  # s and frames after which waiting for them ends
_SHIFTS: Final = (0.003, 0.006, 0.01, 0.015, 0.02, 0.03, 0.04, 0.06)  # m
_TRIED: Final = np.array([*(-shift for shift in reversed(_SHIFTS)), *_SHIFTS])
_LEFT: Final = 0.5  # share of the contradiction that a cause may leave
_ALIKE: Final = 25.0  # of the sum of squares: causes that differ by less are indistinguishable
_TORN: Final = 0.055  # m: a line that seems longer by more may have broken ...
_PULLS: Final = 2.0  # sigmas of its cell: ... if it pulls no more than this
_LOOSE: Final = 1.0  # m: assumed extra length of a broken line
_PENALTY: Final = (
    0.5  # of the sum of squares that all numbers of a camera may have by chance: as a cause it takes them all
)
_OWN_SIGMA: Final = 2e-3  # m, of a length that was found to be off


class Cause(NamedTuple):
    """A possible cause of contradictory measurements, and how much of the contradiction it leaves.

    Of the camera as a cause ``left`` counts its numbers, as a single other cause has but one.

    ``shift``: additional length of a line, m. ``hangs``: where the platform hangs without a line that broke.
    """

    left: float
    kind: str  # cell, camera, length or break
    line: int
    shift: float = 0.0
    hangs: Hanging | None = None


def fits(settings: BodySettings, state: BodyState, measured: Measurement, acceleration: float) -> bool:
    """Return whether a measurement agrees with the statics; after some that do not, a cause is named.

    *acceleration*: m/s^2, of the platform.
    """
    if state.judged.search is not None:
        _search(settings, state, measured)
        return False
    inverse, contradiction = _weighed(state, measured)
    count = len(measured.innovation)
    state.judged.consistency = {"statics": contradiction / count}
    has_picture = measured.innovation[measured.camera].size > 0
    if contradiction <= most_likely(count):
        if has_picture or not state.judged.pictured:
            state.judged.doubts, state.judged.pictured = 0, False
            state.monitor.clear("load_cells", "contradiction")
        return True
    state.judged.pictured = has_picture and (state.judged.pictured or not state.judged.doubts)
    state.judged.doubts += 1
    if not len(measured.cells) and has_picture:
        if state.judged.doubts > _DOUBTS:  # nothing shows which of both is wrong
            state.belief.covariance[state.layout.home, state.layout.home] += _OWN_SIGMA**2 * np.eye(state.layout.m)
            what = "its poses contradict the lengths: did a line slip, or was the camera moved? Mend it, and home again"
            state.monitor.report("camera", "contradiction", what)
        return False
    if state.judged.doubts > _DOUBTS and not state.judged.danger:
        causes = _causes(settings, state, measured, inverse, contradiction)
        if acceleration > _SWINGING and causes[0].kind not in ("cell", "camera"):
            size = math.sqrt(contradiction)
            state.judged.danger = (
                f"tensions contradict the statics by {size:.0f} sigma: a line slipped, left its sheave or broke"
            )
            state.judged.search = Contradiction(state.latest.time)
        else:
            _name(settings, state, measured, causes, contradiction)
    return False


def give_up(state: BodyState) -> None:
    """Stop the search for a cause, since its readings are missing."""
    search = state.judged.search
    if search is None:
        return
    search.frames += 1
    time, frames = _PATIENCE
    if state.latest.time - search.begin > time and search.frames > frames:
        state.judged.search, state.judged.danger = (
            None,
            f"{state.judged.danger}; there are too few readings to say which",
        )


def _search(settings: BodySettings, state: BodyState, measured: Measurement) -> None:
    """Add a measurement to those from which a line is to be named, and name it once there are enough."""
    search = state.judged.search
    assert search is not None
    measured = _without_camera(measured)
    if not len(measured.innovation):
        return
    search.add(measured.innovation, measured.rows)
    if search.count < _SEARCHED:
        return
    mean, state.judged.search = measured._replace(innovation=search.mean), None
    inverse, whole = _weighed(state, mean)
    _name(settings, state, mean, _causes(settings, state, mean, inverse, whole), whole)


def _without_camera(measured: Measurement) -> Measurement:
    """Return a measurement without the camera's rows, which come more rarely than others."""
    kept = np.delete(np.arange(len(measured.innovation)), measured.camera)
    innovation, gradients, rows = measured.innovation[kept], measured.gradients[kept], measured.rows[kept]
    return Measurement(innovation, gradients, measured.noise[np.ix_(kept, kept)], rows, measured.cells, slice(0, 0))


def _weighed(state: BodyState, measured: Measurement) -> tuple[Array, float]:
    """Return the inverse of the innovations' covariance, and their sum of squares by it."""
    spread = measured.gradients @ state.belief.covariance @ measured.gradients.T + measured.noise
    inverse = np.asarray(np.linalg.inv(spread))
    return inverse, float(measured.innovation @ inverse @ measured.innovation)


def most_likely(count: int) -> float:
    """Return the largest plausible sum of squares of *count* standard normal numbers.

    It is as unlikely as `_SIGMAS` (Wilson and Hilferty).
    """
    part = 2.0 / (9.0 * count)
    return float(count * (1.0 - part + _SIGMAS * math.sqrt(part)) ** 3)


def _causes(
    settings: BodySettings, state: BodyState, measured: Measurement, inverse: Array, whole: float
) -> list[Cause]:
    """Return what may have happened, the likeliest first."""
    causes = [*_cells(measured, inverse, whole), *_lines(settings, state, measured, inverse)]
    if own := measured.innovation[measured.camera].size:
        weighted, block = (inverse @ measured.innovation)[measured.camera], inverse[measured.camera, measured.camera]
        without = whole - float(weighted @ np.linalg.solve(block, weighted))
        causes.append(Cause(without + _PENALTY * most_likely(own), "camera", 0))
    return sorted(causes, key=lambda cause: cause.left)


def _name(settings: BodySettings, state: BodyState, measured: Measurement, causes: list[Cause], whole: float) -> None:
    """Name the first of the *causes* of a contradiction, and go on with the other sensors."""
    best = _slackest(state, measured, causes, causes[0])
    robot = settings.model.robot
    name = robot.lines[best.line].name
    alike = [
        robot.lines[each.line].name
        for each in causes
        if each.kind == best.kind == "length" and each.line != best.line and each.left < best.left + _ALIKE
    ]
    if best.left > max(_LEFT * whole, most_likely(len(measured.innovation))):
        why = f"tensions contradict the statics by {math.sqrt(whole):.0f} sigma, and no single cause explains it"
        state.monitor.report("load_cells", "contradiction", why)
        state.judged.danger = why
    elif best.kind == "camera":
        what = "its poses contradict the other sensors: they are ignored; was it, or a tag on the platform, moved?"
        state.monitor.report("camera", "off", what)
        state.judged.camera_used, state.judged.doubts = False, 0
        if state.judged.danger:  # it stands already
            state.judged.danger = f"camera: {what}"
    elif best.kind == "cell":
        off = float(measured.innovation[np.flatnonzero(measured.cells == best.line)[0]])
        what = f"the load cell of line {name} contradicts the others by {off:.0f} N: its readings are ignored"
        state.monitor.report("load_cells", f"off {name}", what)
        state.judged.cells_used[best.line], state.judged.doubts = False, 0
        if state.judged.danger:  # it stands already
            state.judged.danger = what
        elif state.judged.cells_used.sum() < settings.model.n:
            state.judged.danger = f"too few load cells are left that agree: {what}"
    elif best.kind == "length":
        what = f"line {name} is {1e3 * best.shift:+.1f} mm longer than its encoder says: it slipped, or left its sheave"
        if alike:
            what += f"; the same error of line {' or '.join(alike)} would show the same"
        state.monitor.report("encoders", f"length {name}", what)
        state.judged.danger = what
        _shift(state, best.line, best.shift, _OWN_SIGMA)
    else:
        state.judged.danger = broken_line.sentence(robot, best.line, state.pose, best.hangs)
        state.monitor.report("load_cells", f"broken {name}", state.judged.danger)
        state.judged.cells_used[best.line] = False
        _shift(state, best.line, _LOOSE, _OWN_SIGMA)


def _slackest(state: BodyState, measured: Measurement, causes: list[Cause], best: Cause) -> Cause:
    """Decide between a line that is too long and one that broke: a broken one pulls nothing at all."""
    rows = np.flatnonzero(measured.cells == best.line)
    if best.kind in ("cell", "camera") or not len(rows):
        return best
    place = state.layout.zero.start + best.line
    sigma = math.sqrt(float(measured.noise[rows[0], rows[0]] + state.belief.covariance[place, place]))
    pulls = float(state.tensions[best.line] + measured.innovation[rows[0]])
    kind = best.kind
    if kind == "break" and pulls > _PULLS * sigma:
        kind = "length"
    elif kind == "length" and best.shift >= _TORN and pulls <= _PULLS * sigma:
        kind = "break"
    others = [each for each in causes if each.kind == kind and each.line == best.line]
    return min(others, key=lambda each: each.left)._replace(left=best.left) if others else best


def _shift(state: BodyState, line: int, shift: float, sigma: float) -> None:
    """Take a line to be longer by *shift*, m."""
    place = state.layout.home.start + line
    state.belief.unknowns[place] += shift
    state.belief.covariance[place, place] += sigma**2
    state.judged.doubts = 0


def _cells(measured: Measurement, inverse: Array, whole: float) -> list[Cause]:
    """The residual without each one of the cells."""
    weighted = inverse @ measured.innovation
    return [
        Cause(whole - float(weighted[k]) ** 2 / float(inverse[k, k]), "cell", int(line))
        for k, line in enumerate(measured.cells)
    ]


def _lines(settings: BodySettings, state: BodyState, measured: Measurement, inverse: Array) -> list[Cause]:
    """The residual with each line longer or shorter than by its encoder, and with each one broken."""
    m, found = state.layout.m, []
    here = _solved(settings, state, state.lengths[None])
    shifted = state.lengths + np.kron(np.eye(m), _TRIED[:, None])
    left = _left(measured, inverse, here, _solved(settings, state, shifted)).reshape(m, -1)
    for i, row in enumerate(left):
        k = int(np.argmin(row))
        if np.isfinite(row[k]):
            found.append(_refined(settings, state, measured, inverse, here, i, k))
        for rest in broken_line.hanging_without(settings.model.robot, state.lengths, i, state.pose, state.retraction):
            after = _shown(settings, state, rest.pose, rest.tensions, i)
            found.append(Cause(float(_left(measured, inverse, here, after[None])[0]), "break", i, hangs=rest))
    return found


def _refined(
    settings: BodySettings, state: BodyState, measured: Measurement, inverse: Array, here: Array, line: int, k: int
) -> Cause:
    """The best shift of a *line* between the neighbours of the tried one *k*."""
    low, high = _TRIED[max(k - 1, 0)], _TRIED[min(k + 1, len(_TRIED) - 1)]
    shifts = np.linspace(low, high, 17)
    rows = np.repeat(state.lengths[None], len(shifts), axis=0)
    rows[:, line] += shifts
    left = _left(measured, inverse, here, _solved(settings, state, rows))
    best = int(np.argmin(left))
    return Cause(float(left[best]), "length", line, float(shifts[best]))


def _solved(settings: BodySettings, state: BodyState, lengths: Array) -> Array:
    """What the sensors show (k, s) at *lengths* (k, m), from the present pose; NaN: nothing is found."""
    model, retraction = settings.model, None if math.isnan(state.retraction) else np.array([state.retraction])
    rows = len(lengths)
    found = solve_forward(
        model,
        lengths,
        guess=np.repeat(state.pose[None], rows, axis=0),
        retraction=None if retraction is None else np.repeat(retraction, rows),
    )
    return np.array([_shown(settings, state, *there) for there in zip(found.pose, found.tensions, strict=True)])


def _shown(
    settings: BodySettings, state: BodyState, pose: Array, tensions: Array, broken_line: int | None = None
) -> Array:
    """What the sensors show (s,) at an equilibrium: *pose* (6,) and *tensions* (m,), perhaps without a line."""
    planes = taut_of(state.tracker.packed, pose).planes
    there = HeldBody(pose, tensions, planes, broken_line, state.wound.drums)
    return np.concatenate([sensor.shown(there) for sensor in settings.sensors])


def _left(measured: Measurement, inverse: Array, here: Array, after: Array) -> Array:
    """The residual (k,) of the contradiction where predictions were *after* (k, s), not *here* (1, s).

    Where they are not known, nothing is left.
    """
    change = (after - here)[:, measured.rows]
    rest = np.where(np.isnan(change), 0.0, measured.innovation - change)
    rest[np.isnan(change).all(axis=1)] = np.inf
    with np.errstate(invalid="ignore"):
        left = np.einsum("ki,ij,kj->k", rest, inverse, rest)
    return np.where(np.isfinite(left), left, np.inf)
