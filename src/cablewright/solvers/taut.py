"""All lines of a platform as straight tangents, for each step of a control loop."""

from typing import NamedTuple

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.kernels.statics import taut
from cablewright.kernels.statics.line.upright_lines import TAUT
from cablewright.models.packed_views import LineNumbers, blank_states
from cablewright.models.rotation import matrix_of
from cablewright.models.statics import Model


class Taut(NamedTuple):
    """The straight lines to one pose of the platform: of a point platform, the position of the platform point B."""

    angles: Array  # (m,) rad, free angle of the taut line: gamma_taut
    free: Array  # (m,) m from the sheave to B
    lengths: Array  # (m,) m from the winch to B
    toward: Array  # (m, 3) unit vectors: gradients of the lengths with respect to B, the line's platform point
    planes: Array  # (m, 4) of the lines, see `vertical_plane.place`
    per_motion: Array  # (m, n) gradients by the motion of the platform: its translation, and its rotation in space


def taut_at(model: Model, pose: Array) -> Taut:
    """Return the straight lines to *pose* (n,), m and rad; NaN for a line without a tangent there."""
    m = model.m
    found, planes, toward = np.empty((m, taut.FOUND)), np.empty((m, 4)), np.empty((m, 3))
    place, scratch = np.array(pose, dtype=np.float64), blank_states()
    if model.n == 3:
        taut.draw(model.packed.lines, place, TAUT, scratch, found, planes, toward)
        per_motion = toward
    else:
        per_motion = _draw_of_body(model.packed.lines, place, scratch, found, planes, toward)
    angles, free, lengths = np.ascontiguousarray(found.T)
    return Taut(angles, free, lengths, toward, planes, per_motion)


def stretches(lines: LineNumbers, taut: Taut) -> Array:
    """Return by how much each straight line to a point grows per tension, m/N: its cable, and what its mount gives."""
    return np.asarray(lines.free_compliance * taut.lengths + lines.spring + given(lines, taut))


def given(lines: LineNumbers, taut: Taut) -> Array:
    """Return by how much the mount of each exit shortens the way of its straight line per tension, m/N.

    It is pulled along the free span and, where it is modelled, along a dead span below or above it.
    """
    return np.asarray(lines.mount[:, 0] * mount_share(lines, taut))


def mount_share(lines: LineNumbers, taut: Taut) -> Array:
    """Return the way that a mount of the compliance 1 shortens so, per tension: 1 without a dead span, up to 4."""
    rise = np.sin(taut.angles)
    return np.where(lines.has_dead_span, 2.0 - 2.0 * np.sign(lines.side) * rise, 1.0)


def taut_of_body(lines: Array, pose: Array) -> Taut:
    """As `taut_at`, of a rigid body with *lines* (m, ...) of `Packed`, which differ with its retraction."""
    m = len(lines)
    found, planes, toward = np.empty((m, taut.FOUND)), np.empty((m, 4)), np.empty((m, 3))
    per_motion = _draw_of_body(lines, np.array(pose, dtype=np.float64), blank_states(), found, planes, toward)
    angles, free, lengths = np.ascontiguousarray(found.T)
    return Taut(angles, free, lengths, toward, planes, per_motion)


def _draw_of_body(lines: Array, pose: Array, scratch: Array, found: Array, planes: Array, toward: Array) -> Array:
    """Draw each line to its own platform point; return the lengths' gradients (m, 6) by the body's motion."""
    arms = LineNumbers(lines).platform_point @ matrix_of(pose[3:]).T
    for i, place in enumerate(pose[:3] + arms):
        own = slice(i, i + 1)
        taut.draw(lines[own], place, TAUT, scratch, found[own], planes[own], toward[own])
    return np.concatenate([toward, _crosses(arms, toward)], axis=1)


def _crosses(a: Array, b: Array) -> Array:
    """Cross products of the rows (m, 3) of *a* and *b*; NumPy's own takes several times as long."""
    ax, ay, az = a.T
    bx, by, bz = b.T
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=1)
