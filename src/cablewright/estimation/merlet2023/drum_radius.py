"""Estimate of each winch drum's radius: change of cable length over rotation of the drum.

Merlet and Papegay 2023, III.C: from the last two lidar states (``rule = "paper"``). At their speed at most 3 cm are
paid out in a second, and 2 mm of lidar noise are a tenth of that. So by default (``"filter"``) a Kalman filter for each
line estimates length and radius from all lidar states.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError


@dataclass(frozen=True)
class RadiusSettings:
    """Prior knowledge of the winch drums.

    ``nominal`` (m,): m, of the bare drum. ``min_radius``, ``max_radius``: m, bounds. ``sigma``: m, standard deviation
    at the start. ``random_walk``: m per root radian, of the radius as the drum turns. ``length_sigma``: m, of a lidar
    state's lengths. ``min_rotation``: rad between two lidar states that the paper's rule needs.
    """

    nominal: tuple[float, ...]
    min_radius: float
    max_radius: float
    rule: Literal["paper", "filter"] = "filter"
    sigma: float = 4e-3
    random_walk: float = 2e-4
    length_sigma: float = 1e-3
    min_rotation: float = 0.05

    def __post_init__(self) -> None:
        """Reject bounds that do not rise and nominal radii outside them."""
        if not 0.0 < self.min_radius < self.max_radius < math.inf:
            bounds = f"min_radius = {self.min_radius:g} m and max_radius = {self.max_radius:g} m"
            raise InputError(f"{bounds}: 0 < min_radius < max_radius is expected")
        if not self.nominal or not all(self.min_radius <= radius <= self.max_radius for radius in self.nominal):
            bounds = f"{self.min_radius:g} to {self.max_radius:g} m"
            raise InputError(f"nominal = {self.nominal}: the radius of each bare drum must be from {bounds}")


class RadiusState(NamedTuple):
    """Estimated radii (m,), m, of the winch drums; and lengths, drum angles and covariance at the last lidar state."""

    radii: Array
    sigmas: Array  # (m,) m
    last_lengths: Array | None
    last_angles: Array | None  # (m,) rad, paid out
    covariance: Array  # (m, 2, 2) of length and radius


def start(settings: RadiusSettings) -> RadiusState:
    """Return the drum radii before the first lidar state: bare drums."""
    radii = np.array(settings.nominal)
    covariance = np.zeros((len(radii), 2, 2))
    covariance[:, 1, 1] = settings.sigma**2
    return RadiusState(radii, np.full(len(radii), settings.sigma), None, None, covariance)


def without_reference(state: RadiusState) -> RadiusState:
    """Return *state* without the last lidar state, because the rotation since then is not known."""
    return state._replace(last_lengths=None, last_angles=None)


def step(settings: RadiusSettings, state: RadiusState, lengths: Array, angles: Array, known: Mask) -> RadiusState:
    """Update the drum radii by a lidar state: unstrained *lengths* (m,), m, and drum *angles* (m,), rad, paid out.

    Only lines whose length is *known* (m,) are updated.
    """
    if state.last_lengths is None or state.last_angles is None:
        covariance = np.zeros_like(state.covariance)
        covariance[:, 0, 0], covariance[:, 1, 1] = settings.length_sigma**2, state.covariance[:, 1, 1]
        return state._replace(last_lengths=lengths.copy(), last_angles=angles.copy(), covariance=covariance)
    rotation = angles - state.last_angles
    if settings.rule == "paper":
        usable = (np.abs(rotation) >= settings.min_rotation) & known
        slope = np.abs(lengths - state.last_lengths) / np.where(usable, np.abs(rotation), 1.0)
        radii = np.where(usable & (slope >= settings.min_radius) & (slope <= settings.max_radius), slope, state.radii)
        return state._replace(radii=radii, last_lengths=lengths.copy(), last_angles=angles.copy())
    return _kalman_step(settings, state, lengths, angles, rotation, known)


def _kalman_step(
    settings: RadiusSettings,
    state: RadiusState,
    lengths: Array,
    angles: Array,
    rotation: Array,
    known: Mask,
) -> RadiusState:
    """Predict length += radius * rotation with a random walk of the radius, then update with the measured length."""
    assert state.last_lengths is not None  # `step` has taken the first state
    P = state.covariance
    ll = P[:, 0, 0] + 2.0 * rotation * P[:, 0, 1] + rotation**2 * P[:, 1, 1]
    lr = P[:, 0, 1] + rotation * P[:, 1, 1]
    rr = P[:, 1, 1] + settings.random_walk**2 * np.abs(rotation)
    predicted = state.last_lengths + state.radii * rotation
    gain = np.where(known, 1.0 / (ll + settings.length_sigma**2), 0.0)
    innovation = np.where(known, lengths - predicted, 0.0)
    updated = np.empty_like(P)
    updated[:, 0, 0] = ll - gain * ll * ll
    updated[:, 0, 1] = updated[:, 1, 0] = lr - gain * ll * lr
    updated[:, 1, 1] = rr - gain * lr * lr
    radii = np.clip(state.radii + gain * lr * innovation, settings.min_radius, settings.max_radius)
    return RadiusState(radii, np.sqrt(updated[:, 1, 1]), predicted + gain * ll * innovation, angles.copy(), updated)
