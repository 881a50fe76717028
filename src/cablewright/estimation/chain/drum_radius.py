"""The radius at which cable leaves each winch drum: what its length grew by over what the drum turned.

Merlet and Papegay 2023, III.C: between two states that lidars gave, used until the next (``rule = "paper"``). A second
of their speed pays out 3 cm at most, of which 2 mm of lidar noise are a tenth; so by default (``"filter"``) each line's
length and radius are a Kalman filter's state, and many lidar states tell the radius together.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.errors import InputError

__all__ = ["RadiusSettings", "RadiusState", "start", "step", "unhooked"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RadiusSettings:
    """What is known of winch drums.

    ``nominal`` (m,): m, of the bare drum. ``least`` and ``most``: m, what a radius may be. ``sigma``: m, of what it may
    be besides nominal. ``walk``: m per square root of a radian, how a radius changes as the drum turns.
    ``length_sigma``: m, of a lidar state's lengths. ``least_turn``: rad between two states that the paper's rule wants.
    """

    nominal: tuple[float, ...]
    least: float
    most: float
    rule: Literal["paper", "filter"] = "filter"
    sigma: float = 4e-3
    walk: float = 2e-4
    length_sigma: float = 1e-3
    least_turn: float = 0.05

    def __post_init__(self) -> None:
        """Refuse radii out of their range."""
        if not 0.0 < self.least < self.most < math.inf:
            raise InputError(f"least = {self.least:g} m and most = {self.most:g} m: 0 < least < most is wanted")
        if not self.nominal or not all(self.least <= radius <= self.most for radius in self.nominal):
            raise InputError(f"nominal = {self.nominal}: radii from {self.least:g} to {self.most:g} m are wanted")


class RadiusState(NamedTuple):
    """Radii (m,), m; and of the last lidar state: lengths, drum angles, and the filter's covariance."""

    radii: Array
    sigmas: Array  # (m,) m
    lengths: Array | None
    angles: Array | None  # (m,) rad, paid out
    covariance: Array  # (m, 2, 2) of length and radius


def start(settings: RadiusSettings) -> RadiusState:
    """Return the state before the first lidar state: bare drums."""
    radii = np.array(settings.nominal)
    covariance = np.zeros((len(radii), 2, 2))
    covariance[:, 1, 1] = settings.sigma**2
    return RadiusState(radii, np.full(len(radii), settings.sigma), None, None, covariance)


def unhooked(state: RadiusState) -> RadiusState:
    """Return *state* without the last lidar state: what drums turned since then is not known."""
    return state._replace(lengths=None, angles=None)


def step(
    settings: RadiusSettings, state: RadiusState, lengths: Array, angles: Array, known: NDArray[np.bool_]
) -> RadiusState:
    """Take a lidar state: unstrained *lengths* (m,), m, and the drums' *angles* (m,), rad, more is more paid out.

    Lines whose length is not *known* (m,) tell nothing.
    """
    if state.lengths is None or state.angles is None:
        covariance = np.zeros_like(state.covariance)
        covariance[:, 0, 0], covariance[:, 1, 1] = settings.length_sigma**2, state.covariance[:, 1, 1]
        return state._replace(lengths=lengths.copy(), angles=angles.copy(), covariance=covariance)
    turned = angles - state.angles
    if settings.rule == "paper":
        told = (np.abs(turned) >= settings.least_turn) & known
        slope = np.abs(lengths - state.lengths) / np.where(told, np.abs(turned), 1.0)
        radii = np.where(told & (slope >= settings.least) & (slope <= settings.most), slope, state.radii)
        return state._replace(radii=radii, lengths=lengths.copy(), angles=angles.copy())
    return _filtered(settings, state, lengths, angles, turned, known)


def _filtered(
    settings: RadiusSettings,
    state: RadiusState,
    lengths: Array,
    angles: Array,
    turned: Array,
    known: NDArray[np.bool_],
) -> RadiusState:
    """One step of each line's filter: length += radius * turned, the radius walks, the length is measured."""
    assert state.lengths is not None  # the first state has been taken
    P = state.covariance
    ll = P[:, 0, 0] + 2.0 * turned * P[:, 0, 1] + turned**2 * P[:, 1, 1]
    lr = P[:, 0, 1] + turned * P[:, 1, 1]
    rr = P[:, 1, 1] + settings.walk**2 * np.abs(turned)
    predicted = state.lengths + state.radii * turned
    gain = np.where(known, 1.0 / (ll + settings.length_sigma**2), 0.0)
    off = np.where(known, lengths - predicted, 0.0)
    made = np.empty_like(P)
    made[:, 0, 0] = ll - gain * ll * ll
    made[:, 0, 1] = made[:, 1, 0] = lr - gain * ll * lr
    made[:, 1, 1] = rr - gain * lr * lr
    radii = np.clip(state.radii + gain * lr * off, settings.least, settings.most)
    return RadiusState(radii, np.sqrt(made[:, 1, 1]), predicted + gain * ll * off, angles.copy(), made)
