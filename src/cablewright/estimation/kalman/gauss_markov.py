"""Decay of estimated corrections: states as Gauss-Markov processes about the values of the machine file.

Lidars cannot measure a shift of all walls and mounts together. Without decay, errors in the models of lines, the same
in each layer of a print, would move them farther and farther.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.estimation.kalman.state import FilterState
from cablewright.foundation.arrays import Array
from cablewright.kernels.filtering import predict as kernel

_SURVEY_TIME: Final = 1000.0  # s over which what was learnt of surveyed numbers fades
_INTERVAL: Final = 1.0  # s between two times at which it does
_CLOCK_TIME: Final = 60.0  # s over which the drum's clock wanders


def fade(P: Array, states: slice, share: float, variances: float | Array) -> float:
    """Predict the covariance *P* (n, n) of *states* that decay over a *share* of their correlation time.

    Returns the factor of their means. *variances*: prior ones, of unknown states.
    """
    known = np.full(states.stop - states.start, 0.0) + variances
    return float(kernel.fade(P, states.start, states.stop, float(share), known))


def fade_clock(state: FilterState, dt: float) -> None:
    """Predict the error of the platform's clock over *dt*, s: a random walk within the bounds of its lag."""
    clock, at = state.checks.clock, state.layout.clock
    if clock is not None:
        state.built.clock_error *= fade(state.P, slice(at, at + 1), dt / _CLOCK_TIME, clock.sigma**2)
        state.P[at, at] = max(state.P[at, at], clock.doubt**2)


def fade_survey(state: FilterState, dt: float) -> None:
    """Predict errors of walls, lidar mounts and camera by *dt*, s: they decay to the values of the machine file."""
    state.built.unfaded += dt
    if state.built.unfaded < _INTERVAL:
        return
    share, begin = state.built.unfaded / _SURVEY_TIME, 0
    for states in (state.layout.surveyed, state.layout.camera):
        end = begin + states.stop - states.start
        state.mean.x[states] *= fade(state.P, states, share, state.built.survey_variances[begin:end])
        begin = end
    state.built.unfaded = 0.0
