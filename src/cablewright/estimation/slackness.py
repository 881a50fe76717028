"""Which line is slack and by how much, from accelerometers on the lines (Merlet and Papegay 2023, III.B).

Near the platform a line that sags runs less steeply down than one drawn taut: the difference of the two angles,
measured less taut, tells its horizontal force and so its excess. Here gamma_taut is the straight tangent's, which a
line under 300 N has to 0.05 degrees.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.errors import InputError
from cablewright.kernels import layout
from cablewright.kernels.layout import Code
from cablewright.models.statics import Model
from cablewright.signals import LineAngles
from cablewright.solvers.one_line import hang
from cablewright.solvers.taut import Taut, taut_at

__all__ = ["SlacknessSettings", "SlacknessState", "Taut", "exact_excess", "excess_of", "start", "step", "taut_at"]

Array = NDArray[np.float64]

_LEAST: Final = 1e-6  # rad: a line that sags by less is as good as straight
_STUCK: Final = 10  # readings to the last bit alike: no sensor with noise tells so
_ASTRAY: Final = 5  # readings in a row beyond the gate before they are believed
_ROUNDS: Final = 6
_CLOSE: Final = 1e-6  # rad: how well an excess has to give the angle


@dataclass(frozen=True)
class SlacknessSettings:
    """Where the sensors sit and when a line is slack.

    ``from_platform``: m along the line before B. ``slack``: m of excess from which a line counts as slack. ``smooth``:
    s over which angles are averaged, for vibration. ``gate``: rad by which one reading may differ from the average.
    ``quiet``: s without a reading after which a line is not known.
    """

    model: Model
    from_platform: float = 0.2
    slack: float = 2.5e-3
    smooth: float = 0.2
    gate: float = 0.15
    seen: float = math.radians(0.5)
    quiet: float = 0.5

    def __post_init__(self) -> None:
        """Refuse lines without a shape."""
        if (self.model.packed.lines[:, layout.WEIGHT] == 0.0).any():
            raise InputError("slackness: lines without weight have no shape that an angle could tell; use catenary")
        for name in ("slack", "smooth", "gate", "seen", "quiet"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise InputError(f"{name} = {getattr(self, name):g}: a finite number over 0 is wanted")


class SlacknessState(NamedTuple):
    """What is known of each line; (m,) arrays."""

    differences: Array  # rad: gamma_measured - gamma_taut, smoothed; NaN: never measured
    excess: Array  # m: over the taut length, by the angle; NaN where not known
    heard: Array  # s: when each line was last measured
    last: Array  # rad: the last reading
    alike: NDArray[np.int64]  # readings in a row that were the same to the last bit
    astray: NDArray[np.int64]  # readings in a row that were gated out
    time: float

    @property
    def stuck(self) -> NDArray[np.bool_]:
        """Lines whose sensor tells the same again and again, (m,)."""
        return np.asarray(self.alike >= _STUCK)


def start(settings: SlacknessSettings) -> SlacknessState:
    """Return the state before the first reading."""
    m = settings.model.m
    nothing = np.full(m, np.nan)
    zeros = np.zeros(m, dtype=np.int64)
    return SlacknessState(nothing, nothing, np.full(m, -np.inf), nothing, zeros, zeros, -math.inf)


def step(settings: SlacknessSettings, state: SlacknessState, reading: LineAngles, taut: Taut) -> SlacknessState:
    """Take one reading at a place where the lines drawn straight are *taut*."""
    dt = reading.time - state.time
    if not dt > 0.0:
        return state
    told = reading.angles
    here = np.isfinite(told)
    alike = np.where(here, np.where(told == state.last, state.alike + 1, 0), state.alike)
    fresh = here & (alike < _STUCK)
    difference = told - taut.angles
    unknown = np.isnan(state.differences) | (reading.time - state.heard > settings.quiet)
    off = fresh & ~unknown & ~(np.abs(difference - state.differences) <= settings.gate)
    astray = np.where(off, state.astray + 1, np.where(fresh, 0, state.astray))
    taken = fresh & (~off | (astray >= _ASTRAY))
    whole = unknown | (astray >= _ASTRAY)
    share = np.where(whole, 1.0, -math.expm1(-dt / settings.smooth))
    base = np.where(whole, difference, state.differences)
    smoothed = np.where(taken, base + share * (difference - base), state.differences)
    heard = np.where(taken, reading.time, state.heard)
    excess = np.where(reading.time - heard > settings.quiet, np.nan, excess_of(settings, taut, smoothed))
    astray = np.where(taken, 0, astray)
    return SlacknessState(smoothed, excess, heard, np.where(here, told, state.last), alike, astray, reading.time)


def excess_of(settings: SlacknessSettings, taut: Taut, differences: Array) -> Array:
    """Excess (m,), m, of lines whose angles differ by *differences* (m,) rad from *taut*; as a parabola hangs.

    The horizontal force h has the tangent's slope grow by w / h per metre, which from mid-span to the sensor makes the
    difference of slopes; the span is w^2 x^2 c cos^2 / 24 h^2 longer than its chord c, less what tension stretches.
    """
    lines = settings.model.packed.lines
    weight, compliance = lines[:, layout.WEIGHT], lines[:, layout.FREE_COMPLIANCE]
    slopes = np.maximum(np.tan(np.minimum(taut.angles + differences, 1.5)) - np.tan(taut.angles), _LEAST)
    c = np.cos(taut.angles)
    h = weight * (0.5 * taut.free - settings.from_platform) / slopes
    sag = (weight * taut.free * c * c / h) ** 2 * taut.free / 24.0
    most = lines[:, layout.TENSION_MAX]
    return np.asarray(sag - compliance * np.minimum(h / c, most) * taut.lengths)


def exact_excess(settings: SlacknessSettings, taut: Taut, line: int, difference: float) -> float:
    """Excess, m, of one *line* that hangs as a catenary over its sheave with an angle *difference* (rad) from taut.

    By the secant rule from `excess_of`, whose answer comes back where the line is not slack or cannot hang so.
    """
    row, plane, length = settings.model.packed.lines[line], taut.planes[line], float(taut.lengths[line])
    first = float(excess_of(settings, taut, np.full(settings.model.m, difference))[line])
    if not first > 1e-5:
        return first
    y = np.zeros(layout.STATE)

    def beyond(log_excess: float) -> float:
        if hang(row, plane, length + math.exp(log_excess), y) != Code.OK:
            return math.nan
        end = math.exp(y[layout.TAU])
        rise = end * math.sin(y[layout.PHI]) + row[layout.WEIGHT] * (y[layout.FREE] - settings.from_platform)
        return math.atan2(rise, end * math.cos(y[layout.PHI])) - float(taut.angles[line]) - difference

    a, b = math.log(first), math.log(1.02 * first)
    fa, fb = beyond(a), beyond(b)
    for _ in range(_ROUNDS):
        if not abs(fb) > _CLOSE or fa == fb:
            break
        a, b, fa = b, b - fb * (b - a) / (fb - fa), fb
        fb = beyond(b) if b < math.log(taut.free[line]) else math.nan
    return math.exp(b) if abs(fb) < 1e-3 else first
