"""What load cells and the accelerometer say of the unknowns: one measurement of the readings of an interval.

The motion of the platform by its lines' lengths, and what that does to the tensions, is the linearisation of the
equilibrium. The platform's acceleration moves tensions as a wrench would; in the directions in which tensions balance
none they are not moved by it, and these weigh most.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array
from cablewright.estimation.body.settings import BodySettings
from cablewright.estimation.body.state import BodyState
from cablewright.estimation.body.unknowns import length_gradients
from cablewright.models.packed_views import LineNumbers
from cablewright.models.rotation import matrix_of
from cablewright.solvers.linearise import linearise_where_regular, tension_changes
from cablewright.solvers.taut import mount_share

_Rows = NDArray[np.int64]
_OF_MEDIAN: Final = 1.6  # variance of a median over that of a mean, of normal numbers
_NO_LAW: Final = 0.3  # assumed
_ARM: Final = 0.3  # m: arm of the moment that goes with a platform's acceleration
_UPWARD: Final = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
"""What a turn in space does to the upward unit vector as the platform sees it, in world axes."""


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
    rows: _Rows  # (k,) of each innovation in `predictions`
    cells: _Rows  # (c,) index of the line of each of the first c innovations
    tilted: bool  # whether the next two are of the accelerometer


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
    toward = state.taut.toward
    if np.isfinite(toward).all():
        lines, crept = LineNumbers(state.tracker.packed.lines), state.creep.doubt.strain
        changed = (state.tensions - state.load_path.home) / state.load_path.mean
        given = state.tensions * mount_share(lines, state.taut)
        state.gradients = length_gradients(
            state.layout, state.paid, toward, state.home_toward, state.lengths, crept, changed, given
        )


def predicted_tilt(pose: Array) -> Array:
    """Return the two components (2,) of the upward unit vector along the platform's own x and y."""
    return np.asarray(matrix_of(pose[3:])[2, :2])


class _Part(NamedTuple):
    """One kind of sensors' innovations, gradients and noise."""

    innovation: Array
    gradients: Array
    noise: Array
    rows: _Rows


def measurement_of(settings: BodySettings, state: BodyState, slopes: Slopes, acceleration: float) -> Measurement | None:
    """Return the measurement of the window's readings; None without any. *acceleration*: m/s^2, of the platform."""
    window, parts = state.window, []
    cells = np.zeros(0, dtype=np.int64)
    if window.tensions and settings.cells is not None:
        known = state.cells_used & np.isfinite(np.array(window.tensions)).any(axis=0)
        cells = np.flatnonzero(known)
        parts.append(_of_cells(settings, state, slopes, cells, acceleration))
    tilted = bool(window.tilts) and settings.tilt is not None
    if tilted:
        parts.append(_of_tilt(settings, state, slopes, acceleration))
    if window.swivels and settings.swivels is not None:
        parts.append(_of_swivels(settings, state, slopes))
    if not parts:
        return None
    innovation, gradients = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
    noise, at = np.zeros((len(innovation),) * 2), 0
    for part in parts:
        own = slice(at, at + len(part.innovation))
        noise[own, own] = part.noise
        at = own.stop
    rows = np.concatenate([part.rows for part in parts])
    return Measurement(innovation, gradients, noise, rows, cells, tilted)


def _of_cells(settings: BodySettings, state: BodyState, slopes: Slopes, cells: _Rows, acceleration: float) -> _Part:
    assert settings.cells is not None
    layout, lines = state.layout, np.arange(state.layout.m)
    read = np.array(state.window.tensions)
    gradients = slopes.tensions @ state.gradients
    gradients[lines, layout.gain.start + lines] = state.tensions
    gradients[lines, layout.zero.start + lines] = 1.0
    gradients[:, layout.load] = slopes.tensions_by_wrench
    each = settings.cells.deviation**2 * _OF_MEDIAN / len(read) + settings.deviations.model**2
    force = slopes.tensions_by_wrench[cells] * (settings.model.robot.platform.mass * acceleration)
    force[:, 3:] *= _ARM
    beam = settings.beam_deviation * _by_beam(settings, state, slopes)[cells]
    noise = each * np.eye(len(cells)) + force @ force.T + np.outer(beam, beam) * _OF_MEDIAN / len(read)
    return _Part(_middle(read[:, cells]), gradients[cells], noise, cells)


def _by_beam(settings: BodySettings, state: BodyState, slopes: Slopes) -> Array:
    """Change of the tensions (m,), N/m, with the length of a platform that retracts; zeros of any other."""
    robot = settings.model.robot
    if robot.retraction is None:
        return np.zeros(robot.m)
    moved = np.array([line.name in robot.retraction.lines for line in robot.lines])
    along = matrix_of(state.pose[3:]) @ np.array(robot.retraction.along)
    return np.asarray(-slopes.tensions @ (moved * (state.taut.toward @ along)))


def _of_tilt(settings: BodySettings, state: BodyState, slopes: Slopes, acceleration: float) -> _Part:
    assert settings.tilt is not None
    layout, gravity = state.layout, settings.model.robot.scene.gravity
    read = np.array(state.window.tilts)
    by_turn = (matrix_of(state.pose[3:]).T @ _UPWARD)[:2]
    gradients = by_turn @ slopes.pose[3:] @ state.gradients
    gradients[:, layout.tilt] = np.eye(2)
    gradients[:, layout.load] = by_turn @ slopes.pose_by_wrench[3:]
    each = ((settings.tilt.deviation**2) * _OF_MEDIAN / len(read) + acceleration**2) / gravity**2
    return _Part(_middle(read), gradients, each * np.eye(2), layout.m + np.arange(2))


def _of_swivels(settings: BodySettings, state: BodyState, slopes: Slopes) -> _Part:
    """Angles of the lines' planes: they turn as the platform points move across them."""
    assert settings.swivels is not None
    layout, planes = state.layout, state.taut.planes
    read = np.array(state.window.swivels)
    lines = np.flatnonzero(np.isfinite(read).any(axis=0))
    across = np.stack([-planes[:, 1], planes[:, 0], np.zeros(layout.m)], axis=1) / planes[:, 2:3]
    arms = LineNumbers(state.tracker.packed.lines).platform_point @ matrix_of(state.pose[3:]).T
    by_motion = np.concatenate([across, np.cross(arms, across)], axis=1)
    gradients = by_motion @ slopes.pose @ state.gradients
    gradients[:, layout.load] = by_motion @ slopes.pose_by_wrench
    each, places = np.arange(layout.m), layout.exit.start + 3 * np.arange(layout.m)
    gradients[each, layout.swivel.start + each] = 1.0
    for axis in range(3):
        gradients[each, places + axis] -= across[:, axis]
    noise = settings.swivels.deviation**2 * _OF_MEDIAN / len(read)
    return _Part(_middle(read[:, lines]), gradients[lines], noise * np.eye(len(lines)), layout.m + 2 + lines)


def _middle(rows: Array) -> Array:
    """Median (k,) of *rows* (j, k) of readings, some of which are missing: single wrong ones do not count."""
    if np.isfinite(rows).all():
        rows = np.sort(rows, axis=0)
        half = len(rows) // 2
        return np.asarray(rows[half] if len(rows) % 2 else 0.5 * (rows[half - 1] + rows[half]))
    return np.asarray(np.nanmedian(rows, axis=0))


def predictions(state: BodyState) -> Array:
    """Return what cells (m), accelerometer (2) and swivels (m) would read at the present unknowns."""
    unknowns, layout = state.unknowns, state.layout
    cells = (1.0 + unknowns[layout.gain]) * state.tensions + unknowns[layout.zero]
    tilt = predicted_tilt(state.pose) + unknowns[layout.tilt]
    planes, exits = state.taut.planes, unknowns[layout.exit].reshape(-1, 3)
    by_exit = (planes[:, 1] * exits[:, 0] - planes[:, 0] * exits[:, 1]) / planes[:, 2]
    swivels = np.arctan2(planes[:, 1], planes[:, 0]) + by_exit + unknowns[layout.swivel]
    return np.concatenate([cells, tilt, swivels])


def gain_of(covariance: Array, measured: Measurement) -> tuple[Array, Array]:
    """Return the Kalman gain (size, k), and the covariance after the measurement."""
    PH = covariance @ measured.gradients.T
    gain = np.linalg.solve(measured.gradients @ PH + measured.noise, PH.T).T
    after = covariance - gain @ PH.T
    return np.asarray(gain), np.asarray(0.5 * (after + after.T))


def pose_covariance(state: BodyState, slopes: Slopes) -> Array:
    """Return the covariance (6, 6) of the pose: translation, m, and rotation in space, rad.

    Creep, softness and mounts follow no law exactly: of what measurements seem to tell of them a share is not believed.
    """
    gradients, laws = slopes.pose @ state.gradients, state.layout.laws
    gradients[:, state.layout.load] = slopes.pose_by_wrench
    told = gradients[:, laws] @ (state.untold - state.covariance[laws, laws]) @ gradients[:, laws].T
    return np.asarray(gradients @ state.covariance @ gradients.T + _NO_LAW**2 * told)
