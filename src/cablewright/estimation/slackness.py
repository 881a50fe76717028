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

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import LineAngles
from cablewright.kernels import Direct
from cablewright.kernels.filtering import smoothed_line_angles as kernel
from cablewright.kernels.layout import Code
from cablewright.models.packed_views import LineNumbers, LineStates, blank_states
from cablewright.models.statics import Model
from cablewright.solvers.one_line import hang
from cablewright.solvers.taut import Taut

_FIRST_SIGMA: Final = math.radians(5.0)  # of one reading of a line that vibrates
_FIRST_TIMES: Final = 0.01  # smoothing times for which the first reading counts in the scatter, where they are longer
_MAX_ITERATIONS: Final = 6
_STEP: Final = Direct(kernel.step)
_TOLERANCE: Final = 1e-6  # rad, of the angle that an excess has to give


@dataclass(frozen=True)
class SlacknessSettings:
    """Positions of the line sensors, and the threshold of slack.

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


class SlacknessState(NamedTuple):
    """Smoothed angle and excess length of each line."""

    rows: Array  # (KNOWN, m), see `kernels.filtering.smoothed_line_angles`
    time: float

    @property
    def differences(self) -> Array:
        """Smoothed angles less those of taut lines, (m,) rad; NaN: never measured."""
        return np.asarray(self.rows[kernel.DIFFERENCE])

    @property
    def excess(self) -> Array:
        """Excess over the taut length, (m,) m, by the angle; NaN where not known."""
        return np.asarray(self.rows[kernel.EXCESS])

    @property
    def scatter(self) -> Array:
        """Variance of single readings about the smoothed differences, (m,) rad^2."""
        return np.asarray(self.rows[kernel.SCATTER])

    @property
    def variances(self) -> Array:
        """Variance of the smoothed differences, (m,) rad^2."""
        return np.asarray(self.rows[kernel.VARIANCE])

    @property
    def all_measure(self) -> bool:
        """Whether no line's excess is unknown, and no sensor repeats the same reading."""
        excess, repeats = self.rows[kernel.EXCESS].tolist(), self.rows[kernel.REPEATS].tolist()
        return not math.isnan(sum(excess)) and max(repeats) < kernel.MAX_REPEATS

    @property
    def stuck(self) -> Mask:
        """Lines whose sensor repeats the same reading, (m,)."""
        return np.asarray(self.rows[kernel.REPEATS] >= kernel.MAX_REPEATS)


def start(settings: SlacknessSettings) -> SlacknessState:
    """Return the slackness state before the first reading."""
    rows = np.zeros((kernel.KNOWN, settings.model.m))
    rows[[kernel.DIFFERENCE, kernel.EXCESS, kernel.LAST_ANGLE]] = np.nan
    rows[kernel.LAST_TIME], rows[kernel.SCATTER_TIMES] = -np.inf, _FIRST_TIMES
    rows[[kernel.SCATTER, kernel.VARIANCE]] = _FIRST_SIGMA**2
    return SlacknessState(rows, -math.inf)


def restarted(state: SlacknessState) -> SlacknessState:
    """Return *state* after a reset of the clock, whose earlier times no longer count."""
    rows = state.rows.copy()
    rows[kernel.LAST_TIME] = -np.inf
    return SlacknessState(rows, -math.inf)


def unknown(state: SlacknessState) -> SlacknessState:
    """Return *state* after so long without a reading that no excess is known."""
    rows = state.rows.copy()
    rows[kernel.EXCESS] = np.nan
    return SlacknessState(rows, state.time)


def step(settings: SlacknessSettings, state: SlacknessState, reading: LineAngles, taut: Taut) -> SlacknessState:
    """Update the slackness by one reading of all angles at a position where the straight lines are *taut*."""
    dt = reading.time - state.time
    if not dt > 0.0:
        return state
    rows = state.rows.copy()
    own, angles = settings, np.array(reading.angles, dtype=np.float64)
    numbers = own.from_platform, reading.time, dt, own.smoothing_time, own.gate, own.timeout
    _STEP.call(
        rows, angles, own.model.packed.lines, taut.angles, taut.free, taut.lengths, taut.toward, *map(float, numbers)
    )
    return SlacknessState(rows, reading.time)


def parabolic_excess(settings: SlacknessSettings, taut: Taut, differences: Array) -> Array:
    """Return the excess (m,), m, of lines that hang as parabolas, by their angles' *differences*, rad, from *taut*."""
    lines, found = settings.model.packed.lines, np.empty(len(differences))
    straight = taut.angles, taut.free, taut.lengths, taut.toward
    kernel.parabolic_excess(lines, *straight, settings.from_platform, differences, found)
    return found


def catenary_excess(settings: SlacknessSettings, taut: Taut, line: int, difference: float) -> float:
    """Return the excess, m, of one *line* that hangs as a catenary with an angle *difference* (rad) from taut.

    It runs over its sheave. By the secant method from `parabolic_excess`, which is returned where the line is not slack
    or has no such shape, as one that leaves its vertical plane.
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
