"""Speed limits of a rigid platform at corners and speed changes, so that its swing keeps tensions within limits.

At a corner the nozzle's velocity jumps by v. The lengths follow, late by the lag of the winches, and the platform
swings about the pose where they would hold it: mode k, with the shape s (unit modal mass) and w rad/s, by s^T M v / w
times the share that the lag leaves of it. A sudden acceleration moves it by up to twice its static displacement.
Tensions change in proportion. There is no damping here, and the modes of a corner add as if they met; swings of one
corner and of one change of speed are added, those of several are not.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.analyses.modes import modes
from cablewright.analyses.steady_acceleration import tensions_by_acceleration
from cablewright.control.path_follower import TimedPath
from cablewright.foundation.arrays import Array, Mask
from cablewright.live.prints.body_limits import chosen_places, poses_at
from cablewright.machine.settings import MachineSettings
from cablewright.models.inertia import mass_matrix
from cablewright.models.rotation import turn_between
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import Linearisation, linearise_solved, tension_changes

_SHARE: Final = 0.5  # of the room between tensions and their limits: for corners, and as much for changes of speed
_LEAST: Final = 0.1  # share of the job's acceleration that is always left
_SHARPEST: Final = 1e-3  # rad; what turns by less is no corner
_SAME: Final = 1e-6  # share of a speed
_TIMES: Final = 200  # at which a swing is looked at, in its first period


def calmed(model: Model, narrow: Model, path: TimedPath, settings: MachineSettings) -> TimedPath:
    """Return the *path*, slower where its swing would exceed the tension limits of *model*.

    *narrow*: the model with the limits that control keeps at rest. Where these leave no room to swing in, the nozzle
    stops in corners, and a tenth of the job's acceleration remains. A shaped path swings in no corner, and by its
    acceleration alone.
    """
    narrow = Model(_with_inertia(narrow.robot, settings), narrow.fidelity)
    held, linear, ok = _held(narrow, path, chosen_places(path))
    share = 0.0
    if ok.all():
        sudden = 2.0 if path.shaping is None else 1.0
        needed = sudden * path.acceleration * tensions_by_acceleration(held, linear)
        share = float(_worst_share(_room(model, held), needed).min())
    speeds = np.full(len(path.speed), np.inf)
    if path.shaping is not None:
        return path if share >= 1.0 else path.slower(path.acceleration * max(share, _LEAST), speeds)
    rows, jumps = _corners(model, path)
    held, _, ok = _held(narrow, path, path.track.positions[rows])
    speeds[rows] = 0.0
    if ok.any():
        known = rows[ok]
        swing = swings(held, jumps[ok] * path.speed[known, None], settings.winch.lag)
        speeds[known] = path.speed[known] * np.minimum(_worst_share(_room(model, held), swing), 1.0)
    return path.slower(path.acceleration * min(max(share, _LEAST), 1.0), speeds)


def told(job: TimedPath, calmed: TimedPath) -> tuple[str, ...]:
    """Return a sentence that says by how much a *calmed* path is slower than that of the *job*; none if not."""
    shaped = calmed.shaping is not None  # whose corners are others
    slower = np.zeros(0, np.int64) if shaped else np.flatnonzero(calmed.speed < job.speed * (1.0 - _SAME))
    if calmed.acceleration == job.acceleration and not len(slower):
        return ()
    words = f"acceleration {calmed.acceleration:.2g} m/s^2, job {job.acceleration:.2g}"
    if len(slower):
        least = slower[int(np.argmin(calmed.speed[slower] / job.speed[slower]))]
        words += f"; at one corner {1e3 * calmed.speed[least]:.0f} mm/s in place of {1e3 * job.speed[least]:.0f}"
    later = calmed.duration - job.duration
    return (f"slower for the sake of tensions, which a platform that swings changes: {words}; {later:.0f} s longer",)


def swings(held: Equilibrium, jumps: Array, lag: float) -> Array:
    """Return the largest changes of the tensions (k, m), N, after *jumps* (k, 6) of the twist, m/s and rad/s.

    The twist is that of the platform's origin and its rotation, world, at k solved poses. *lag*: s, of the winches.
    """
    found = modes(held)
    shapes, rates = found.shapes, 2.0 * np.pi * np.abs(found.frequencies)
    pushed = np.einsum("kni,knp,kp->ki", shapes, mass_matrix(held.model.robot, held.pose), jumps)
    amplitudes = pushed / rates * smoothed(rates * lag)
    return np.asarray(np.abs(tension_changes(held).following(shapes) * amplitudes[:, None, :]).sum(axis=2))


def smoothed(delay: Array) -> Array:
    """Return the largest deflection after a jump of speed that a lag smoothes, over that without the lag.

    *delay*: the lag times the rate of the swing, rad. With t in rad, the deflection is
    (d (e^(-t/d) - cos t) + sin t) / (1 + d^2).
    """
    times = np.linspace(0.0, 2.0 * np.pi, _TIMES)[1:]
    late = np.maximum(delay, 1e-9)[..., None]
    course = (late * (np.exp(-times / late) - np.cos(times)) + np.sin(times)) / (1.0 + late * late)
    return np.asarray(np.abs(course).max(axis=-1))


def _worst_share(room: Array, needed: Array) -> Array:
    """Return the share (k,) of the *needed* reserve (k, m), N, that half of the *room* (k, m), N, covers."""
    return np.asarray((_SHARE * np.maximum(room, 0.0) / np.maximum(needed, 1e-12)).min(axis=1))


def _room(model: Model, held: Equilibrium) -> Array:
    """Return the distances (k, m), N, of tensions from the nearer limit of *model*."""
    low, high = np.array([line.tension_limits for line in model.robot.lines]).T
    return np.asarray(np.minimum(held.tensions - low, high - held.tensions))


def _held(model: Model, path: TimedPath, places: Array) -> tuple[Equilibrium, Linearisation, Mask]:
    """Return what holds the nozzle at those of the *places* (k, 3), m, held firmly, and which they are (k,)."""
    poses, retraction = poses_at(model, path, places)
    held = solve_inverse(model, poses, path=True, retraction=retraction)
    ok, linear = linearise_solved(held)
    return held[ok], linear, ok


def _corners(model: Model, path: TimedPath) -> tuple[NDArray[np.int64], Array]:
    """Return the points (c,) at which the path turns, and the jump of the twist there (c, 6), per m/s."""
    poses, drawn = poses_at(model, path, path.track.positions)
    if np.isnan(poses).any():
        poses = solve_inverse(model, poses, path=True, retraction=drawn).pose
    turn = turn_between(poses[:-1, 3:], poses[1:, 3:])
    twists = np.concatenate([np.diff(poses[:, :3], axis=0), turn], axis=1) / np.diff(path.track.distance)[:, None]
    jumps = np.diff(twists, axis=0)
    rows = np.flatnonzero((np.linalg.norm(jumps, axis=1) > _SHARPEST) & (path.speed[1:-1] > 0.0)) + 1
    return rows, jumps[rows - 1]


def _with_inertia(robot: Robot, settings: MachineSettings) -> Robot:
    """Return the robot with the inertia of the empty machine, where its own file has none."""
    platform, body = robot.platform, settings.body
    if platform.has_inertia or body is None or body.gyration is None:
        return robot
    x, y, z = (platform.mass * radius**2 for radius in body.gyration)
    return robot.with_platform(inertia=(x, y, z))
