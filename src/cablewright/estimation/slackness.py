"""Slack of each line from the accelerometers on the lines (Merlet and Papegay 2023, III.B).

Near the platform a sagging line descends less steeply than a straight one. The difference of the two angles, measured
less taut, gives the horizontal force and so the excess: length over the taut length. gamma_taut is the angle of the
straight tangent, which a line under 300 N has to 0.05 degrees.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import LineAngles
from cablewright.kernels.layout import Code
from cablewright.models.packed_views import LineNumbers, LineStates, blank_states
from cablewright.models.statics import Model
from cablewright.solvers.one_line import hang
from cablewright.solvers.taut import Taut, stretches

_MIN_SLOPE: Final = 1e-6  # difference of slopes below which a line counts as straight
_MAX_REPEATS: Final = 10  # identical readings in a row: a sensor with noise gives none
_MAX_OUTLIERS: Final = 5  # readings in a row beyond the gate before they are accepted
_FIRST_SIGMA: Final = math.radians(5.0)  # of one reading of a line that vibrates
_SCATTER_TIMES: Final = 5.0  # smoothing times over which the scatter of readings is averaged ...
_FIRST_TIMES: Final = 0.01  # ... and for how many the first one counts, where readings are farther apart than one
_MAX_ITERATIONS: Final = 6
_TOLERANCE: Final = 1e-6  # rad, of the angle that an excess has to give


@dataclass(frozen=True)
class SlacknessSettings:
    """Where the sensors sit and when a line is slack.

    ``from_platform``: m along the line before B. ``threshold``: m of excess from which a line counts as slack.
    ``smoothing_time``: s, time constant of the angles' low-pass filter, against vibration. ``gate``: rad by which a
    reading may differ from the smoothed angle. ``visible_angle``: rad of difference from which the angle
    determines the excess. ``timeout``: s without a reading after which a line's excess is unknown.
    """

    model: Model
    from_platform: float = 0.2
    threshold: float = 2.5e-3
    smoothing_time: float = 0.2
    gate: float = 0.15
    visible_angle: float = math.radians(0.5)
    timeout: float = 0.5

    def __post_init__(self) -> None:
        """Reject lines without weight, which do not sag, and numbers that are not positive and finite."""
        if self.model.massless:
            raise InputError(
                "slackness: lines without weight do not sag, so that their angles do not show slack; use catenary"
            )
        for name in ("threshold", "smoothing_time", "gate", "visible_angle", "timeout"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise InputError(f"{name} = {getattr(self, name):g}: a finite number over 0 is expected")


class StraightLines(NamedTuple):
    """What a parabola's excess needs of straight lines, computed once for one place; (m,) arrays."""

    taut: Taut
    slopes: Array  # of their tangents
    cosines: Array
    rising: Array  # N: horizontal force times the slope that it gives up from mid-span to the sensor
    weighing: Array  # N: horizontal force times the square root of 24 excess / chord
    stretching: Array  # m/N

    @classmethod
    def at(cls, settings: SlacknessSettings, taut: Taut) -> StraightLines:
        """Return that of lines that are *taut*."""
        lines, c = settings.model.lines, np.cos(taut.angles)
        rising = lines.weight * (0.5 * taut.free - settings.from_platform)
        return cls(taut, np.tan(taut.angles), c, rising, lines.weight * taut.free * c * c, stretches(lines, taut))

    def excess(self, settings: SlacknessSettings, differences: Array) -> Array:
        """Return the excess (m,), m, as `parabolic_excess`."""
        taut = self.taut
        slopes = np.maximum(np.tan(np.minimum(taut.angles + differences, 1.5)) - self.slopes, _MIN_SLOPE)
        h = self.rising / slopes
        sag = settings.model.lines.spans * (self.weighing / h) ** 2 * taut.free / 24.0
        return np.asarray(sag - self.stretching * np.minimum(h / self.cosines, settings.model.lines.tension_max))


class SlacknessState(NamedTuple):
    """Smoothed angle and excess of each line; (m,) arrays."""

    differences: Array  # rad: gamma_measured - gamma_taut, smoothed; NaN: never measured
    excess: Array  # m: over the taut length, by the angle; NaN where not known
    last_times: Array  # s: of each line's last accepted reading
    last_angles: Array  # rad: of the last reading
    repeats: NDArray[np.int64]  # identical readings in a row
    outliers: NDArray[np.int64]  # readings in a row beyond the gate
    scatter: Array  # rad^2, of single readings about the smoothed differences
    scatter_times: float | Array  # smoothing times of readings in that, all or (m,)
    variances: Array  # rad^2, of the smoothed differences
    time: float
    straight: StraightLines | None = None  # where the last reading was

    @property
    def stuck(self) -> Mask:
        """Lines whose sensor repeats the same reading, (m,)."""
        return np.asarray(self.repeats >= _MAX_REPEATS)


def start(settings: SlacknessSettings) -> SlacknessState:
    """Return the state before the first reading."""
    m = settings.model.m
    nothing = np.full(m, np.nan)
    zeros = np.zeros(m, dtype=np.int64)
    unsure = np.full(m, _FIRST_SIGMA**2)
    never, counts = np.full(m, -np.inf), np.full(m, _FIRST_TIMES)
    return SlacknessState(nothing, nothing, never, nothing, zeros, zeros, unsure, counts, unsure, -math.inf)


def restarted(state: SlacknessState) -> SlacknessState:
    """Return *state* after a reset of the clock, whose earlier times no longer count."""
    return state._replace(time=-math.inf, last_times=np.full_like(state.last_times, -np.inf))


def step(settings: SlacknessSettings, state: SlacknessState, reading: LineAngles, taut: Taut) -> SlacknessState:
    """Return the state after one reading at a place where the straight lines are *taut*."""
    dt = reading.time - state.time
    if not dt > 0.0:
        return state
    straight = state.straight
    if straight is None or straight.taut is not taut:
        straight = StraightLines.at(settings, taut)
    angles = reading.angles
    difference = angles - taut.angles
    usual = _usual(settings, state, reading, difference, straight)
    if usual is not None:
        return usual
    known = np.isfinite(angles)
    repeats = np.where(known, np.where(angles == state.last_angles, state.repeats + 1, 0), state.repeats)
    usable = known & (repeats < _MAX_REPEATS)
    stale = np.isnan(state.differences) | (reading.time - state.last_times > settings.timeout)
    gated = usable & ~stale & ~(np.abs(difference - state.differences) <= settings.gate)
    outliers = np.where(gated, state.outliers + 1, np.where(usable, 0, state.outliers))
    accepted = usable & (~gated | (outliers >= _MAX_OUTLIERS))
    restart = stale | (outliers >= _MAX_OUTLIERS)
    gain = np.where(restart, 1.0, -math.expm1(-dt / settings.smoothing_time))
    base = np.where(restart, difference, state.differences)
    off = np.where(accepted, difference - base, 0.0)
    smoothed = np.where(accepted, base + gain * off, state.differences)
    new = np.where(accepted & ~restart, gain, 0.0)
    seen = _scatter_times(settings, state, dt, new)
    scatter = state.scatter + new / seen * (off**2 - state.scatter)
    mixed = (1.0 - gain) ** 2 * state.variances + gain**2 * scatter  # of independent readings
    variances = np.where(accepted, mixed, state.variances)
    times = np.where(accepted, reading.time, state.last_times)
    excess = np.where(reading.time - times > settings.timeout, np.nan, straight.excess(settings, smoothed))
    outliers, last = np.where(accepted, 0, outliers), np.where(known, angles, state.last_angles)
    return SlacknessState(
        smoothed, excess, times, last, repeats, outliers, scatter, seen, variances, reading.time, straight
    )


def _scatter_times(settings: SlacknessSettings, state: SlacknessState, dt: float, new: float | Array) -> float | Array:
    """Smoothing times, all or (m,), over which the scatter is averaged, with *new* ones *dt*, s, after the last.

    Readings that are closer than a smoothing time do not tell it soon: a line that vibrates hardly moves meanwhile.
    """
    if dt <= settings.smoothing_time:
        return _SCATTER_TIMES
    return np.asarray(np.minimum(state.scatter_times + new, _SCATTER_TIMES))


def _usual(
    settings: SlacknessSettings, state: SlacknessState, reading: LineAngles, difference: Array, straight: StraightLines
) -> SlacknessState | None:
    """Return the state after a reading that is as most are: of every line, new and near the smoothed one; else None.

    *difference* (m,), rad, of the reading from the straight lines. The same numbers as in `step`, to the bit, in a
    third of its time.
    """
    off = difference - state.differences
    gate = settings.gate
    if not all(abs(each) <= gate for each in off.tolist()):  # NaN is not
        return None
    if reading.time - min(state.last_times.tolist()) > settings.timeout:
        return None
    if any(map(float.__eq__, reading.angles.tolist(), state.last_angles.tolist())):
        return None
    gain = -math.expm1(-(reading.time - state.time) / settings.smoothing_time)
    keep = 1.0 - gain
    smoothed = state.differences + gain * off
    seen = _scatter_times(settings, state, reading.time - state.time, gain)
    scatter = state.scatter + gain / seen * (off * off - state.scatter)
    variances = keep * keep * state.variances + gain * gain * scatter
    times, none = np.full(len(off), reading.time), np.zeros(len(off), dtype=np.int64)
    return SlacknessState(
        smoothed, straight.excess(settings, smoothed), times, reading.angles, none, none, scatter, seen, variances,
        reading.time, straight,
    )  # fmt: skip


def parabolic_excess(settings: SlacknessSettings, taut: Taut, differences: Array) -> Array:
    """Excess (m,), m, of lines that hang as parabolas, by their angles' *differences* (m,), rad, from *taut*.

    With horizontal force h the slope grows by w / h per metre, which from mid-span to the sensor gives the difference
    of slopes. The span is w^2 x^2 c cos^2 / 24 h^2 longer than its chord c, less the elastic stretch.
    """
    return StraightLines.at(settings, taut).excess(settings, differences)


def catenary_excess(settings: SlacknessSettings, taut: Taut, line: int, difference: float) -> float:
    """Excess, m, of one *line* that hangs as a catenary over its sheave with an angle *difference* (rad) from taut.

    By the secant method from `parabolic_excess`, which is returned where the line is not slack or has no such shape, as
    one that leaves its vertical plane.
    """
    row, plane, length = settings.model.packed.lines[line], taut.planes[line], float(taut.lengths[line])
    first = float(parabolic_excess(settings, taut, np.full(settings.model.m, difference))[line])
    if not (first > 1e-5 and LineNumbers(row).in_plane):
        return first
    weight, y = float(LineNumbers(row).weight), blank_states()
    state = LineStates(y)

    def residual(log_excess: float) -> float:
        if hang(row, plane, length + math.exp(log_excess), y) != Code.OK:
            return math.nan
        tension, phi = math.exp(state.log_tension), state.free_angle
        rise = tension * math.sin(phi) + weight * (state.free_length - settings.from_platform)
        return math.atan2(rise, tension * math.cos(phi)) - float(taut.angles[line]) - difference

    a, b = math.log(first), math.log(1.02 * first)
    fa, fb = residual(a), residual(b)
    for _ in range(_MAX_ITERATIONS):
        if not abs(fb) > _TOLERANCE or fa == fb:
            break
        a, b, fa = b, b - fb * (b - a) / (fb - fa), fb
        fb = residual(b) if b < math.log(taut.free[line]) else math.nan
    return math.exp(b) if abs(fb) < 1e-3 else first
