"""The drum's mass as it changes: powder leaves, and it is refilled."""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.estimation.kalman.state import FilterSettings, FilterState

_MUCH: Final = 1e-3  # m at once, after which heights of before tell nothing


def weigh(settings: FilterSettings, state: FilterState, mass: float) -> None:
    """Take the drum to be of *mass*, kg, from now on: lines stretch by the change, and no encoder shows it.

    With K the stiffness of all lines at B, B moves by K^-1 times the change of weight, known to `load_sigma`.
    """
    change, state.mass = mass - state.mass, mass
    if change == 0.0 or state.taut is None:
        return
    weight = np.array([0.0, 0.0, -change * settings.machine.tilt.gravity])
    moved = np.linalg.solve(state.stiffness, weight)
    if float(moved @ moved) > _MUCH**2:
        state.sunk_time = state.time
    state.position = state.position + moved
    state.loosened = state.loosened - state.taut.toward @ moved
    state.coasted[:3] += moved
    position = state.layout.position
    state.P[position, position] += settings.load_sigma**2 * np.outer(moved, moved)
