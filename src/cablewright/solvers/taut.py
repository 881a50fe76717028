"""All lines of a platform as straight tangents, for each step of a control loop."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.kernels.layout import Packed
from cablewright.kernels.statics import taut
from cablewright.kernels.statics.line.guides import towards_winch
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


def taut_of(packed: Packed, pose: Array) -> Taut:
    """As `taut_at`, of lines that may differ from a model's, as with a platform's retraction."""
    m, place = len(packed.lines), np.array(pose, dtype=np.float64)
    found, planes, toward, per_motion = (np.empty((m, size)) for size in (taut.FOUND, 4, 3, len(place)))
    taut.draw(packed, place, found, planes, toward, per_motion)
    angles, free, lengths = np.ascontiguousarray(found.T)
    return Taut(angles, free, lengths, toward, planes, per_motion)


def stretches(lines: LineNumbers, taut: Taut) -> Array:
    """Return by how much each straight line to a point grows per tension, m/N: its cable, and what its mount gives."""
    return np.asarray(lines.free_compliance * taut.lengths + lines.spring + given(lines, taut))


def given(lines: LineNumbers, taut: Taut) -> Array:
    """Return by how much the mount of each exit shortens the way of its straight line per tension, m/N.

    It is pulled along the free span and, where it is modelled, along a dead span, by all cables of the line.
    """
    along = taut.toward + _towards_winch(lines)
    pairs = ((0, 0, 0), (1, 1, 1), (2, 2, 2), (0, 1, 3), (0, 2, 4), (1, 2, 5))
    soft = sum((1.0 if i == j else 2.0) * lines.mount[:, k] * along[:, i] * along[:, j] for i, j, k in pairs)
    return np.asarray(lines.pulls / lines.spans * soft)


def mount_share(lines: LineNumbers, taut: Taut) -> Array:
    """Return the way that a mount of the compliance 1 shortens so, per tension: 1 without a dead span, up to 4."""
    along = taut.toward + _towards_winch(lines)
    return np.asarray(lines.pulls / lines.spans * (along * along).sum(axis=1))


def _towards_winch(lines: LineNumbers) -> Array:
    """Return the directions (m, 3) of the dead spans from the exit points; zero where one is not modelled.

    Of lines in a vertical plane it is upright, as along the axis of a swivel.
    """
    upright = lines.has_dead_span[:, None] * np.outer(-np.sign(lines.side), [0.0, 0.0, 1.0])
    aside = [
        towards_winch(row) if guide else up for row, guide, up in zip(lines.array, lines.guide, upright, strict=True)
    ]
    return np.array(aside) if lines.guide.any() else upright
