"""Line lengths from the encoders, and detection of counts that jump by more than a winch can turn."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.estimation.body.settings import BodySettings
from cablewright.estimation.body.state import BodyState
from cablewright.estimation.body.updates.update import DrumPulls
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Encoders
from cablewright.kernels import Direct
from cablewright.kernels.filtering import body_lengths

_FASTER: Final = 1.5  # times the winches' largest speed: counts that change so fast have slipped ...
_SLIDES: Final = 1e-3  # m, assumed, from rest until a cable slides over all of its sheave
_LEAST: Final = 0.05  # rad: ... and by this much of a drum at least
_WIND: Final = Direct(body_lengths.wind)


def read(settings: BodySettings, state: BodyState, reading: Encoders) -> None:
    """Process one reading of all encoders; *state* changes in place.

    Counts that jump are accepted once they are read again: then they have slipped, and the jump is left out.
    """
    if len(reading.counts) != len(settings.winches.hosts):
        state.monitor.report("encoders", "lines", f"a reading of {len(reading.counts)} winches: not used")
        return
    if not state.home.known:
        state.home.counts, state.home.known = np.array(reading.counts, dtype=np.int64), True
    if state.wound.last_counts is None:
        state.wound.last_counts = reading.time, reading.counts
        _unwind(settings, state, reading.counts)
        return
    (before, last), pending = state.wound.last_counts, state.wound.pending
    dt = reading.time - before
    if pending is None and _jumps(settings, reading.counts - last, dt).any():
        state.wound.pending = reading.counts
        return
    if pending is not None:
        jumped = _jumps(settings, pending - last, 0.5 * dt)
        if not _jumps(settings, reading.counts - pending, 0.5 * dt).any():
            _leave_out(settings, state, jumped, pending - last)
    state.wound.pending = None
    state.wound.last_counts = reading.time, reading.counts
    _unwind(settings, state, reading.counts)


def _jumps(settings: BodySettings, change: NDArray[np.int64], dt: float) -> NDArray[np.bool_]:
    most = max(_FASTER * settings.max_drum_speed * max(dt, 0.0), _LEAST)
    return np.asarray(np.abs(change) / settings.counts_per_radian > most)


def _leave_out(settings: BodySettings, state: BodyState, jumped: NDArray[np.bool_], change: NDArray[np.int64]) -> None:
    """Move the home counts of the winches whose encoders slipped, and say so."""
    state.home.counts = state.home.counts + np.where(jumped, change, 0)
    bare = settings.drums.radii(state.wound.angles)
    for winch in np.flatnonzero(jumped):
        i = int(settings.winches.hosts[winch])
        name = settings.model.robot.lines[i].name
        slipped = 1e3 * float(change[winch]) / settings.counts_per_radian * float(bare[i])
        why = f"the encoder of line {name} slipped by {slipped:.1f} mm: it jumped by more than its winch can turn"
        state.monitor.report("encoders", f"slip {name}", why)
        state.judged.danger = state.judged.danger or why


def _unwind(settings: BodySettings, state: BodyState, counts: NDArray[np.int64]) -> None:
    """Set the lengths paid out since home by the present *counts* (w,)."""
    wound, home, winches = state.wound, state.home, settings.winches
    angles, paid = np.empty(len(home.angles)), np.empty(len(home.angles))
    holds = _WIND.call(
        np.array(counts, dtype=np.int64), home.counts, winches.winch, winches.sense, settings.counts_per_radian,
        home.angles, *settings.drums.tables, _SLIDES, wound.paid, wound.sliding, angles, paid,
    )  # fmt: skip
    if not holds:
        state.monitor.report("encoders", "jump", "the counts exceed the turns of a winch drum: not used")
        return
    state.monitor.clear("encoders", "jump")
    wound.paid, wound.angles = paid, angles


def see_drums(settings: BodySettings, state: BodyState) -> None:
    """Update the radii by which tensions of several lines on one winch drum add up to its torque."""
    winches, arms = settings.winches, radii(settings, state) * [line.cables for line in settings.model.robot.lines]
    senses, hosts = winches.senses[winches.shared], winches.hosts[winches.shared]
    state.wound.drums = DrumPulls(hosts, arms[hosts], np.where(senses, senses * arms, 0.0) / arms[hosts, None])


def radii(settings: BodySettings, state: BodyState) -> Array:
    """Return the estimated radii (m,), m, at which cable leaves the winch drums."""
    return settings.drums.radii(state.wound.angles) * (1.0 + state.belief.unknowns[state.layout.radius])
