"""One measurement of the unknowns by load cells and accelerometer, from the readings of an interval.

The linearisation of the equilibrium gives the motion of the platform by its lines' lengths, and the change of tensions
by this motion. The platform's acceleration changes tensions as a wrench does. It changes no combination of tensions
that balances no wrench, and these combinations have the largest weight.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.estimation.body.estimated_constants import length_gradients
from cablewright.estimation.body.law_sizes import AveragedAt, averaged
from cablewright.estimation.body.settings import BodySettings
from cablewright.estimation.body.state import BodyState
from cablewright.estimation.body.updates.camera import Seeing
from cablewright.estimation.body.updates.cells import Cells
from cablewright.estimation.body.updates.update import HeldBody, Slopes, UpdatePart
from cablewright.foundation.arrays import Array
from cablewright.models.packed_views import LineNumbers
from cablewright.solvers.linearise import linearise_where_regular, tension_changes
from cablewright.solvers.taut import mount_share

_Rows = NDArray[np.int64]
_NO_LAW: Final = 0.3  # assumed


class Measurement(NamedTuple):
    """A measurement of the machine's unknowns: innovations z (k,), gradients (k, size), and noise (k, k)."""

    innovation: Array
    gradients: Array
    noise: Array
    rows: _Rows  # (k,) of each innovation in `predictions`
    cells: _Rows  # (c,) index of the line of each of the first c innovations
    camera: slice  # of the innovations by a camera


def slopes_of(state: BodyState) -> Slopes | None:
    """Linearise the platform's present equilibrium; None if it is singular."""
    solved = state.tracker.solved
    found, codes = linearise_where_regular(solved)
    if codes.any():
        return None
    changes = tension_changes(solved)
    pose, by_pose = found.per_length[0], changes.by_pose[0]
    wrench = found.per_wrench[0]
    tensions = np.diag(changes.per_length[0]) + by_pose @ pose
    if not (np.isfinite(pose).all() and np.isfinite(tensions).all() and np.isfinite(wrench).all()):
        return None
    return Slopes(pose, tensions, wrench, by_pose @ wrench)


def set_gradients(state: BodyState) -> None:
    """Recompute the derivatives of the lengths by the unknowns."""
    toward = state.taut.toward
    if np.isfinite(toward).all():
        lines, crept = LineNumbers(state.tracker.packed.lines), state.creep.doubt.strain
        changed = (state.tensions - state.load_path.home) / state.load_path.mean
        given = state.tensions * mount_share(lines, state.taut)
        state.belief.gradients = length_gradients(
            state.layout, state.wound.paid, toward, state.home.toward, state.lengths, crept, changed, given
        )


def measurement_of(settings: BodySettings, state: BodyState, slopes: Slopes, acceleration: float) -> Measurement | None:
    """Return the measurement from the last interval's readings; None without any.

    *acceleration*: m/s^2, of the platform.
    """
    parts: list[UpdatePart] = []
    cells, camera, begin = np.zeros(0, dtype=np.int64), slice(0, 0), 0
    for sensor, expected in zip(settings.sensors, predicted(settings, state), strict=True):
        read = state.window.readings.get(sensor)
        if read is not None:
            part = sensor.part(settings, state, slopes, np.array(read), acceleration)
            cells = part.rows[part.rows < state.layout.m] if isinstance(sensor, Cells) else cells
            if isinstance(sensor, Seeing):
                first = sum(len(each.rows) for each in parts)
                camera = slice(first, first + len(part.rows))
            parts.append(part._replace(rows=begin + part.rows))
        begin += len(expected)
    if not parts:
        return None
    innovation, gradients, rows = (np.concatenate([part[k] for part in parts]) for k in (0, 1, 3))
    noise, at = np.zeros((len(innovation),) * 2), 0
    for part in parts:
        own = slice(at, at + len(part.innovation))
        noise[own, own] = part.noise
        at = own.stop
    return Measurement(innovation, gradients, noise, rows, cells, camera)


def predicted(settings: BodySettings, state: BodyState) -> list[Array]:
    """Return the predicted readings (k,) of each sensor at the present unknowns."""
    here = HeldBody(state.pose, state.tensions, state.taut.planes, drums=state.wound.drums)
    return [sensor.as_known(state, sensor.shown(here)) for sensor in settings.sensors]


def predictions(settings: BodySettings, state: BodyState) -> Array:
    """Return the predicted readings of all sensors as one array."""
    return np.concatenate([np.zeros(0), *predicted(settings, state)])


def gain_of(covariance: Array, measured: Measurement) -> tuple[Array, Array]:
    """Return the Kalman gain (size, k), and the covariance after the measurement."""
    PH = covariance @ measured.gradients.T
    gain = np.linalg.solve(measured.gradients @ PH + measured.noise, PH.T).T
    after = covariance - gain @ PH.T
    return np.asarray(gain), np.asarray(0.5 * (after + after.T))


def pose_covariance(state: BodyState, slopes: Slopes) -> Array:
    """Return the covariance (6, 6) of the pose: translation, m, and rotation in space, rad.

    Creep, softness and mounts follow no law exactly: a share of their apparent corrections is not used. Nor is their
    size known (`law_sizes`). NaN where the estimator has no covariance any more.
    """
    belief, layout, laws = state.belief, state.layout, state.layout.laws
    gradients = slopes.pose @ belief.gradients
    gradients[:, layout.load] = slopes.pose_by_wrench
    if not np.isfinite(belief.covariance).all():
        return np.full((6, 6), np.nan)
    estimate, variances = belief.unknowns[laws], np.diagonal(belief.covariance)[laws]
    if belief.averaged is None or not belief.averaged.holds(estimate, variances):
        found = averaged(estimate, belief.covariance[laws, laws], belief.untold, belief.sizes)
        belief.averaged = AveragedAt(estimate.copy(), variances.copy(), found)
    sizes = belief.averaged.found
    moved = gradients @ belief.covariance
    whole = moved @ gradients.T + moved[:, laws] @ sizes.wider @ moved[:, laws].T
    whole += _NO_LAW**2 * gradients[:, laws] @ sizes.shown @ gradients[:, laws].T
    strained = gradients[:, layout.hysteresis]  # by the same loads as what softens the cables
    loop = strained @ belief.covariance[layout.hysteresis, layout.hysteresis] @ strained.T
    return np.asarray(whole + (sizes.squares[1] - 1.0) * loop)
