"""Corrections of large falls of tension for the sag that cables gain.

A cable that loses tension sags more, and so loses less of it than by the stiffness where it began. With the parabola of
a taut cable, whose sag takes w^2 l^3 / (24 T^2) from its length (Irvine 1981, Cable Structures, 2.3), the distance of
its ends grows by d = (T - T0) / k + B (1 / T0^2 - 1 / T^2), B = w^2 l^3 / 24, with w the weight per length across the
chord l, T the tension at mid-span and k the stiffness without sag. The kernels' stiffness is the derivative at T0.
Rises are left as they are by stiffness: a cable that sags less is stiffer, and the platform moves it less.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.models.statics import Equilibrium

STEPS: Final = 16
"""Of Newton's method, which comes from one side: tensions are good to 1e-6 of themselves."""

TAUT: Final = 1e-4
"""Share of sag in the compliance of a line along its chord below which it counts as straight."""


def with_sag(held: Equilibrium, by_pose: Array, falls: Array) -> Array:
    """Return the falls of tensions (N, m) at N solved poses with sag, from those by stiffness alone, *falls* (N, m), N.

    *by_pose* (N, m, n): changes of tensions with the platform's motion, N/m and N/rad. Falls that leave less than the
    weight of the span stay as they are: such a cable hangs slack.
    """
    chords = held.platform_points - held.lines.exit_point
    spans = np.linalg.norm(chords, axis=2)
    weight = held.lines.weight * np.hypot(chords[..., 0], chords[..., 1]) / spans  # N/m, across the chord
    phi, tension = held.line_states.free_angle, held.tensions
    down = tension * np.sin(phi) + 0.5 * held.lines.weight * held.line_states.free_length
    middle = np.hypot(tension * np.cos(phi), down)
    stiffness = np.einsum("nmc,nmc->nm", by_pose[..., :3], chords) / spans
    compliance = weight**2 * spans**3 / (12.0 * np.maximum(middle, 1e-300) ** 3)
    stretch = stiffness * held.line_states.free_length * held.lines.free_compliance  # share of that, at least
    share = np.clip(stiffness * compliance, TAUT, np.clip(1.0 - stretch, TAUT, 1.0 - TAUT))
    wanted = falls / np.maximum(middle, 1e-300)
    ratio = 1.0 / np.sqrt(1.0 - 2.0 * wanted / share)
    for _ in range(STEPS):
        beyond = (1.0 - share) * (ratio - 1.0) + 0.5 * share * (1.0 - ratio**-2) - wanted
        ratio -= beyond / (1.0 - share + share * ratio**-3)
    sags = (share > TAUT) & (middle * ratio > weight * spans)
    return np.where(sags, middle * (ratio - 1.0), falls)
