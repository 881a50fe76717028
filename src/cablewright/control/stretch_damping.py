"""Damping of swings in which lines stretch: lengths follow the platform, mode by mode, by measured tensions.

The tensions that are measured beside those that are planned are a wrench on the platform. By the elastic part of the
stiffness it is how far the platform is from where its lengths hold it, q - l in the coordinate of each mode. With
l' = 2 z w (q - l) and q'' + w^2 q = w^2 l a mode of w rad/s gains the share z of critical damping: lines yield to a
pull and take its energy. Lengths that follow a motion of the platform change no tensions that balance each other.

The measurement of a mode passes three lags of the time 1/w, of which two leave its mean out: a steady force makes no
line yield. It leads by the delay of the loop. The delay may exceed the known one by 0 to `UNKNOWN_DELAY`:
the lead is that for half of it. For each rate the share z is the largest, up to `ADDED`, with which the loop is stable
by `MARGIN` at both ends of these delays, and with frequencies that are wrong by `UNKNOWN_RATE`. Modes in which that is
less than `LEAST`, which are fast ones, are left alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array
from cablewright.foundation.reading_times import ReadingTimes
from cablewright.foundation.signals import SensorFrame, Tensions
from cablewright.models.inertia import mass_matrix, with_inertia
from cablewright.models.statics import Equilibrium
from cablewright.models.stiffness import along_chords, balanced, stiffness

ADDED: Final = 0.1
"""Largest share of critical damping that is added."""

LEAST: Final = 0.01
"""Share of critical damping below which a mode is left alone."""

MARGIN: Final = 0.52
"""Least distance of the open loop from -1: a gain margin of 6 dB and a phase margin of 30 degrees."""

UNKNOWN_DELAY: Final = 0.04
"""Delay, s, beside the known one of the loop, at which it is stable by the margin."""

UNKNOWN_RATE: Final = 0.1
"""Share by which frequencies of the model may be wrong."""

MOST_RATE: Final = 0.01
"""Largest rate, m/s, at which a line follows."""

_Complex = NDArray[Any]
_DELAY: Final = f"{1e3 * UNKNOWN_DELAY:.0f} ms"
_ELASTIC: Final = 0.5  # share of a mode's stiffness from stretch, below which lengths hardly move it
_LAGS: Final = 8.0**0.5, math.pi / 4.0  # of a mode in its lags: attenuation, and lead, rad
_OWN: Final = 0.002  # share of critical damping of the mode itself: the least of real suspended robots
_RATES: Final = 2.0 * np.pi * np.geomspace(0.1, 10.0, 48)  # rad/s, at which gains are computed
_AROUND: Final = np.concatenate(
    [np.geomspace(0.01, 0.94, 80), np.linspace(0.95, 1.05, 101), np.geomspace(1.06, 40, 120)]
)
_HALVINGS: Final = 7
_PATIENCE: Final = 5.0  # times the known delay: without tensions for so long, the swing is unknown


@dataclass(frozen=True)
class DampingLoop:
    """Known delays of the loop: ``late``, s, from a tension to the speed that follows it; ``lag``, s, of winches.

    ``gain``: 1/s, at which lengths are brought back to those of the path.
    """

    late: float
    lag: float
    gain: float

    def opened(self, at: Array, rate: Array, added: Array, delay: Array, true: Array) -> _Complex:
        """Return the open loop at the rates *at*, rad/s, of a mode of *rate* whose damping by *added* is wanted.

        *delay*, s: beside the known one; *true*: its true rate, of *rate*. Arguments broadcast.
        """
        s, own = 1j * at, true * rate
        angle, own_time = self.lead(rate), s / rate
        passed = own_time**2 / (1.0 + own_time) ** 3 * (np.cos(angle) + own_time * np.sin(angle))
        mode = s * (s + 2.0 * _OWN * own)
        around = 2.0 * _LAGS[0] * added * rate / s * passed * mode / (mode + own**2)
        return np.asarray(around * self._answered(s, delay))

    def lead(self, rate: Array) -> Array:
        """Return the phase lead, rad, for a mode of *rate*, rad/s, that compensates its lags."""
        return np.asarray(-np.angle(self._answered(1j * rate, 0.5 * UNKNOWN_DELAY)) - _LAGS[1])

    def _answered(self, s: _Complex, delay: Array | float) -> _Complex:
        """Return how winches follow a speed at *s*, 1/s, *delay* later, s, less what brings lengths back."""
        late = np.exp(-s * (self.late + delay)) / (1.0 + s * self.lag)
        return np.asarray(late * s / (s + self.gain * late))

    def holds(self, rate: Array, added: Array, longest: float = UNKNOWN_DELAY, margin: float = MARGIN) -> Array:
        """Return whether modes of *rate* (k,), rad/s, are stable by the *margin* with *added* (k,) damping.

        At delays from 0 to *longest*, s, beside the known one. By Nyquist: the open loop is stable and must not go
        round -1.
        """
        delay = np.array([0.0, longest])[:, None, None, None]
        true = (1.0 + UNKNOWN_RATE * np.array([-1.0, 0.0, 1.0]))[:, None, None]
        from_one = 1.0 + self.opened(true * rate[:, None] * _AROUND, rate[:, None], added[:, None], delay, true)
        rounds = np.angle(from_one[..., 1:] / from_one[..., :-1]).sum(axis=-1)
        good = (np.abs(from_one).min(axis=-1) >= margin) & (np.abs(rounds) < 1.0)
        return np.asarray(good.all(axis=(0, 1)))


@dataclass(frozen=True)
class StretchDamping:
    """Damping by the tensions of a ``source`` in a known ``loop``."""

    source: str
    loop: DampingLoop

    @cached_property
    def _added(self) -> Array:
        """The share of critical damping that is added at `_RATES`."""
        low, high = np.zeros(len(_RATES)), np.full(len(_RATES), 2.0 * ADDED)
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            good = self.loop.holds(_RATES, middle)
            low, high = np.where(good, middle, low), np.where(good, high, middle)
        return np.where(low < LEAST, 0.0, np.minimum(low, ADDED))

    def added(self, rates: Array) -> Array:
        """Return the share (k,) of critical damping that is added to modes of *rates* (k,), rad/s; 0: left alone."""
        above = np.searchsorted(_RATES, rates)
        known = (above > 0) & (above < len(_RATES))
        above = np.clip(above, 1, len(_RATES) - 1)
        return np.where(known, np.minimum(self._added[above - 1], self._added[above]), 0.0)

    def note(self, rates: Array) -> tuple[bool, str]:
        """Return whether any of the modes of *rates* (k,), rad/s, is damped, and which are, in a sentence."""
        damped, hertz = self.added(rates) > 0.0, rates / (2.0 * np.pi)
        told = []
        if damped.any():
            told.append(f"swings of {_span(hertz[damped])} in which lines stretch are damped by {self.source}")
        if not damped.all():
            told.append(f"swings of {_span(hertz[~damped])} are too fast to be damped at {_DELAY} of delay")
        return bool(damped.any()), "; ".join(told)


def _span(hertz: Array) -> str:
    return f"{hertz.min():.3g} to {hertz.max():.3g} Hz"


class Swings(NamedTuple):
    """Vibration modes of a platform at a pose, f of them, for the damping."""

    rates: Array  # (f,) rad/s; 0 where lengths hardly move the mode, or it is unstable
    shapes: Array  # (n, f) of unit modal mass
    mass: Array  # (n, n) kg, kg m, kg m^2
    stretch: Array  # (f,) (rad/s)^2, the elastic part of the modal stiffness; infinite where lengths hardly move it
    along: Array  # (m, n) wrenches of unit forces along the lines


def swings_at(held: Equilibrium) -> Swings | None:
    """Return the natural modes of the platform at one equilibrium *held*; None if it does not balance."""
    if not (held.ok and balanced(held)):
        return None
    parts, mass = stiffness(held), mass_matrix(with_inertia(held.model.robot), held.pose)
    free = np.eye(held.model.n) if held.model.free_directions is None else held.model.free_directions
    total = free.T @ parts.total @ free
    back = np.linalg.inv(np.linalg.cholesky(free.T @ mass @ free))
    squares, vectors = np.linalg.eigh(0.5 * back @ (total + total.T) @ back.T)
    shapes = free @ back.T @ vectors
    stretch = np.einsum("if,ij,jf->f", shapes, parts.elastic, shapes)
    elastic = stretch > _ELASTIC * np.abs(squares)
    rates = np.sqrt(np.where(elastic, np.maximum(squares, 0.0), 0.0))
    along = along_chords(held.model.n, parts.chords, parts.arms)
    return Swings(rates, shapes, mass, np.where(elastic, stretch, np.inf), along)


@dataclass(eq=False)
class StretchState:
    """State of the damping, changed in place by `follow`.

    ``tensions`` (m,), N: the last ones, read at ``read``, s; ``time``: time of the last step, s. ``planned`` (n,): the
    wrench of planned tensions, with the delay of the measurement. ``filtered`` (3, n): the lags of the motion; None:
    they begin again.
    """

    tensions: Array | None = None
    read: float = -math.inf
    time: float = -math.inf
    times: ReadingTimes = field(default_factory=ReadingTimes)
    planned: Array = field(default_factory=lambda: np.zeros(0))
    filtered: Array | None = None


def listen(settings: StretchDamping, state: StretchState, frame: SensorFrame) -> None:
    """Store the measured tensions of a *frame*; repeated readings, or those without all lines, are ignored."""
    for reading in frame.of(Tensions):
        if (
            reading.source == settings.source
            and state.times.is_new(reading.source, reading.time, frame.time)
            and np.isfinite(reading.tensions).all()
        ):
            state.tensions, state.read = reading.tensions, frame.time


def follow(
    settings: StretchDamping, state: StretchState, held: Equilibrium, pushed: Array, now: float, dt: float
) -> Array:
    """Return rates (m,), m/s, of the lengths that follow the swing of a platform in the next *dt*, s.

    *held*: how lines are planned to hold it now; *pushed* (3,): m/s^2, its acceleration that is planned beside that.
    Zeros where tensions are not known or it is not held: then the swing begins again.
    """
    swings = swings_at(held) if now - state.read <= _PATIENCE * settings.loop.late else None
    if swings is None or state.tensions is None or len(state.tensions) != held.model.m:
        state.filtered = None
        return np.zeros(held.model.m)
    lines, loop = held.lines, settings.loop
    by_tension = -(lines.pulls[:, None] * swings.along).T
    planned = by_tension @ held.tensions + swings.mass[:, :3] @ pushed
    if now - state.time > 1.5 * dt:
        state.filtered = None
    if state.filtered is None:
        state.planned = planned
    late = loop.late + loop.lag + 0.5 * UNKNOWN_DELAY
    state.planned = state.planned + (planned - state.planned) * min(dt / late, 1.0)
    off = swings.shapes.T @ (state.planned - by_tension @ state.tensions) / swings.stretch
    state.time, modal = now, swings.shapes.T @ swings.mass
    lags = np.stack([off, 0.0 * off, 0.0 * off]) if state.filtered is None else state.filtered @ modal.T
    share, angle, through = -np.expm1(-swings.rates * dt), loop.lead(swings.rates), off
    for lag in lags[:2]:
        lag += share * (through - lag)
        through = through - lag
    lags[2] += share * (through - lags[2])
    state.filtered = lags @ swings.shapes.T
    leading = lags[2] * np.cos(angle) + (through - lags[2]) * np.sin(angle)
    speeds = 2.0 * _LAGS[0] * settings.added(swings.rates) * swings.rates * leading
    rates = lines.spans * (swings.along @ (swings.shapes @ speeds))
    return np.asarray(rates * min(1.0, MOST_RATE / max(float(np.abs(rates).max()), MOST_RATE)))
