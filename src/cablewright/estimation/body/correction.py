"""Correction of the machine's unknowns by a measurement, linearised repeatedly until it converges.

Tensions are not linear in the lengths: a line that sags is several times softer than one that does not. Homed lengths
have errors above a line's stretch, so that one linear step would leave the unknowns wrong, with too small sigmas.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.estimation.body import diagnosis, measurement
from cablewright.estimation.body.estimated_constants import load, wind
from cablewright.estimation.body.settings import BodySettings
from cablewright.estimation.body.state import BodyState, corrected, follow, set_load
from cablewright.estimation.body.updates.update import Slopes
from cablewright.foundation.arrays import Array

_ROUNDS: Final = 8
_SAME: Final = 3e-5  # m: by less than this no length moves any more
_LONGEST: Final = 2e-3  # m: largest change of a length in one round


def correct(settings: BodySettings, state: BodyState, acceleration: float) -> Slopes | None:
    """Correct the unknowns by the readings of the last interval, or reject these; *state* changes in place.

    *acceleration*: m/s^2, of the platform. Returns the slopes at the corrected lengths; None where there are none.
    """
    wind(
        settings,
        state.layout,
        state.belief.unknowns,
        state.belief.covariance,
        state.wound.paid - state.wound.measured_at,
    )
    load(settings, state.layout, state.belief.unknowns, state.belief.covariance, state.load_path.follow(state.tensions))
    for sensor in settings.sensors:
        walked = (state.latest.time - state.window.begin) * sensor.walk(state.layout)
        state.belief.covariance[np.diag_indices(len(walked))] += walked
    state.wound.measured_at = state.wound.paid
    measurement.set_gradients(state)
    slopes = measurement.slopes_of(state)
    measured = None if slopes is None else measurement.measurement_of(settings, state, slopes, acceleration)
    if slopes is None or measured is None or not len(measured.innovation):
        return slopes
    if not diagnosis.fits(settings, state, measured, acceleration):
        return slopes
    before, base, covariance = (
        state.belief.unknowns.copy(),
        measurement.predictions(settings, state),
        state.belief.covariance,
    )
    for _ in range(_ROUNDS):
        gain, after = measurement.gain_of(covariance, measured)
        innovation = measured.innovation + (base - measurement.predictions(settings, state))[measured.rows]
        goal = before + gain @ (innovation - measured.gradients @ (before - state.belief.unknowns))
        moved = float(np.abs(state.belief.gradients @ (goal - state.belief.unknowns)).max())
        share = min(1.0, _LONGEST / max(moved, 1e-12))
        if not _go_to(settings, state, state.belief.unknowns + share * (goal - state.belief.unknowns)):
            _go_to(settings, state, before)
            return slopes
        if share == 1.0 and moved < _SAME:
            break
        again = measurement.slopes_of(state)
        if again is None:
            return slopes
        slopes = again
        there = measurement.measurement_of(settings, state, slopes, acceleration)
        assert there is not None  # of the same window
        measured = there
    state.belief.covariance = after
    return slopes


def _go_to(settings: BodySettings, state: BodyState, unknowns: Array) -> bool:
    """Let the platform follow the lengths of other *unknowns*; whether it could."""
    state.belief.unknowns = unknowns
    set_load(state, settings.model)
    state.lengths = corrected(state)
    return follow(state)
