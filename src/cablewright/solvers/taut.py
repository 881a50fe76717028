"""All lines of a platform as straight cables, for each step of a control loop."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.kernels.layout import Packed
from cablewright.kernels.statics import taut as kernel
from cablewright.models.packed_views import LineNumbers
from cablewright.models.statics import Model


class Taut(NamedTuple):
    """The straight lines to one pose of the platform: of a point platform, the position of the platform point B."""

    angles: Array  # (m,) rad, free angle of the taut line: gamma_taut
    free: Array  # (m,) m from the sheave to B
    lengths: Array  # (m,) m from the winch to B
    toward: Array  # (m, 3) gradients of the lengths by the ends of their spans: as many unit vectors as spans
    planes: Array  # (m, 4) of the free spans, see `vertical_plane.place`
    per_motion: Array  # (m, n) gradients by the motion of the platform: its translation, and its rotation in space


def taut_at(model: Model, pose: Array) -> Taut:
    """Return the straight lines to *pose* (n,), m and rad; NaN for a line without a tangent there."""
    return taut_of(model.packed, pose)


def taut_of(packed: Packed, pose: Array, draw: Callable[..., None] = kernel.draw) -> Taut:
    """Return straight lines, see `taut_at`, of arrays *packed* that may differ from a model's.

    *draw*: the kernel, for callers that call it for one robot alone.
    """
    m, place = len(packed.lines), np.array(pose, dtype=np.float64)
    found, planes, toward, per_motion = (np.empty((m, size)) for size in (kernel.FOUND, 4, 3, len(place)))
    draw(packed, place, found, planes, toward, per_motion)
    angles, free, lengths = np.ascontiguousarray(found.T)
    return Taut(angles, free, lengths, toward, planes, per_motion)


def stretches(lines: LineNumbers, taut: Taut) -> Array:
    """Return the elongation of each straight line to a point per tension, m/N: of its cable and of its mount."""
    return _softness(lines, taut)[:, kernel.STRETCH]


def given(lines: LineNumbers, taut: Taut) -> Array:
    """Return by how much each exit point's mount shortens its straight line per tension, m/N.

    It is pulled along the free span and, where it is modelled, along a dead span, by all cables of the line.
    """
    return _softness(lines, taut)[:, kernel.GIVEN]


def mount_share(lines: LineNumbers, taut: Taut) -> Array:
    """Return the shortening of a line per tension on a mount of unit compliance: 1 without a dead span, up to 4."""
    return _softness(lines, taut)[:, kernel.SHARE]


def _softness(lines: LineNumbers, taut: Taut) -> Array:
    """Return how much straight lines give per tension, (m, 3), m/N."""
    found = np.empty((len(lines.array), kernel.SOFTNESS))
    kernel.soften(lines.array, taut.lengths, taut.toward, found)
    return found
