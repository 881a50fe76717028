"""What load cells and the accelerometer say of the unknowns: one measurement of the readings of an interval.

The motion of the platform by its lines' lengths, and what that does to the tensions, is the linearisation of the
equilibrium. The platform's acceleration moves tensions as a wrench would; in the directions in which tensions balance
none they are not moved by it, and these weigh most.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cablewright.arrays import Array
from cablewright.estimation.body.settings import BodySettings
from cablewright.estimation.body.state import BodyState
from cablewright.estimation.body.unknowns import length_gradients
from cablewright.models.rotation import matrix_of
from cablewright.solvers.linearise import linearise_where_regular, tension_changes
from cablewright.solvers.taut import taut_of_body


class Slopes(NamedTuple):
    """How pose and tensions change with lengths and wrench at the present equilibrium."""

    pose: Array  # (6, m) per length
    tensions: Array  # (m, m) per length
    pose_by_wrench: Array  # (6, 6)
    tensions_by_wrench: Array  # (m, 6)


class Measurement(NamedTuple):
    """Innovations z (k,), their gradients (k, size) by the unknowns, and their noise (k, k)."""

    innovation: Array
    gradients: Array
    noise: Array
    cells: Array  # (c,) index of the line of each of the first c innovations
    tilted: bool  # whether the last two are of the accelerometer


def slopes_of(state: BodyState) -> Slopes | None:
    """Linearise the present equilibrium; None where it is singular."""
    solved = state.tracker.solved
    found, codes = linearise_where_regular(solved)
    if codes.any():
        return None
    changes = tension_changes(solved)
    pose, by_pose = found.per_length[0], changes.by_pose[0]
    wrench = np.linalg.inv(found.stiffness[0])
    tensions = np.diag(changes.per_length[0]) + by_pose @ pose
    if not (np.isfinite(pose).all() and np.isfinite(tensions).all() and np.isfinite(wrench).all()):
        return None
    return Slopes(pose, tensions, wrench, by_pose @ wrench)


def set_gradients(state: BodyState) -> None:
    """Compute anew what the unknowns do to the lengths."""
    toward = taut_of_body(state.tracker.packed.lines, state.pose).toward
    if np.isfinite(toward).all():
        state.gradients = length_gradients(state.layout, state.paid, toward, state.home_toward)


def predicted_tilt(pose: Array) -> Array:
    """Return the two components (2,) of the upward unit vector along the platform's own x and y."""
    return np.asarray(matrix_of(pose[3:])[2, :2])


def measurement_of(settings: BodySettings, state: BodyState, slopes: Slopes, acceleration: float) -> Measurement | None:
    """Return the measurement of the window's readings; None without any. *acceleration*: m/s^2, of the platform."""
    layout, window = state.layout, state.window
    parts, rows, noises = [], [], []
    mass = settings.model.robot.platform.mass
    gravity = settings.model.robot.scene.gravity
    cells = np.zeros(0, dtype=np.int64)
    if window.tensions and settings.cells is not None:
        read = np.array(window.tensions)
        known = state.cells_used & np.isfinite(read).any(axis=0)
        cells = np.flatnonzero(known)
        parts.append(_middle(read[:, cells]))
        gradients = slopes.tensions @ state.gradients
        lines = np.arange(layout.m)
        gradients[lines, layout.gain.start + lines] = state.tensions
        gradients[lines, layout.zero.start + lines] = 1.0
        gradients[:, layout.load] = slopes.tensions_by_wrench
        rows.append(gradients[cells])
        each = settings.cells.deviation**2 * 1.6 / len(read) + settings.deviations.model**2
        force = slopes.tensions_by_wrench[cells, :3] * (mass * acceleration)
        noises.append(each * np.eye(len(cells)) + force @ force.T)
    if window.tilts and settings.tilt is not None:
        parts.append(_middle(np.array(window.tilts)))
        R = matrix_of(state.pose[3:])
        by_turn = R.T @ np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
        gradients = by_turn[:2] @ slopes.pose[3:] @ state.gradients
        gradients[:, layout.tilt] = np.eye(2)
        gradients[:, layout.load] = by_turn[:2] @ slopes.pose_by_wrench[3:]
        rows.append(gradients)
        each = (settings.tilt.deviation / gravity) ** 2 * 1.6 / len(window.tilts) + (acceleration / gravity) ** 2
        noises.append(each * np.eye(2))
    if not parts:
        return None
    noise = noises[0] if len(noises) == 1 else _blocks(*noises)
    innovation = np.concatenate(parts)
    tilted = bool(window.tilts) and settings.tilt is not None
    return Measurement(innovation, np.concatenate(rows), noise, cells, tilted)


def _middle(rows: Array) -> Array:
    """Median (k,) of *rows* (j, k) of readings, some of which are missing: single wrong ones do not count."""
    if np.isfinite(rows).all():
        rows = np.sort(rows, axis=0)
        half = len(rows) // 2
        return np.asarray(rows[half] if len(rows) % 2 else 0.5 * (rows[half - 1] + rows[half]))
    return np.asarray(np.nanmedian(rows, axis=0))


def _blocks(first: Array, second: Array) -> Array:
    found = np.zeros((len(first) + len(second),) * 2)
    found[: len(first), : len(first)], found[len(first) :, len(first) :] = first, second
    return found


def update(state: BodyState, measured: Measurement) -> None:
    """Correct the unknowns by a measurement; *state* changes in place."""
    P, H = state.covariance, measured.gradients
    PH = P @ H.T
    S = H @ PH + measured.noise
    K = np.linalg.solve(S, PH.T).T
    state.unknowns = state.unknowns + K @ measured.innovation
    P = P - K @ PH.T
    state.covariance = 0.5 * (P + P.T)


def pose_covariance(state: BodyState, slopes: Slopes) -> Array:
    """Return the covariance (6, 6) of the pose: translation, m, and rotation in space, rad."""
    gradients = slopes.pose @ state.gradients
    gradients[:, state.layout.load] = slopes.pose_by_wrench
    return np.asarray(gradients @ state.covariance @ gradients.T)
