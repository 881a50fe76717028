"""A motion of the platform in time: through waypoints, along a spline, or along the path of a job."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Final, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.foundation.arrays import Array
from cablewright.foundation.data_frames import COORDINATES
from cablewright.foundation.errors import InputError, require_positive
from cablewright.foundation.results import Figure, Pictured
from cablewright.models.job_poses import on_plane, poses_at, sampled
from cablewright.models.rotation import rotations, turn_between
from cablewright.printing.job import Job, load_job
from cablewright.printing.path import Samples
from cablewright.printing.timing import TimeLaw, pieces
from cablewright.robot import Robot
from cablewright.solvers.arguments import as_rows

PERIOD: Final = 0.02
"""Time between samples where none is given, s."""

MAX_SAMPLES: Final = 2_000_000

_PEAK_SPEED = 1.875  # of a rest-to-rest quintic over a unit distance in a unit time
_PEAK_ACCELERATION = 10.0 / math.sqrt(3.0)


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(Pictured):
    """Poses of the platform at k times, with velocities and accelerations.

    ``times`` (k,), s, rise in equal steps from 0. ``poses`` (k, n): m and rad, as those of `inverse`. ``velocities``
    and ``accelerations`` (k, n): of the platform's origin, m/s and m/s^2, and angular, rad/s and rad/s^2; all world.
    """

    FIGURES: ClassVar = (
        Figure("source", "", "Waypoints, spline, or the name of a job."),
        Figure("samples", "1", "Number of times."),
        Figure("duration", "s", "Time at the end.", shown="s"),
        Figure("distance", "m", "Length of the path of the platform's origin.", shown="m"),
        Figure("max_speed", "m/s", "Largest speed of the platform's origin."),
        Figure("max_acceleration", "m/s^2", "Largest acceleration of the platform's origin."),
    )
    HEADLINES: ClassVar = ("source", "samples", "duration", "max_speed", "max_acceleration")

    source: str
    times: Array
    poses: Array
    velocities: Array
    accelerations: Array

    def __len__(self) -> int:
        """The number of times."""
        return len(self.times)

    @property
    def columns(self) -> dict[str, Array]:
        """Columns (k,) of `to_frame`: time, pose, velocities (v) and accelerations (a)."""
        names = COORDINATES[: self.poses.shape[1]]
        found = {"time": self.times}
        for prefix, values in (("", self.poses), ("v.", self.velocities), ("a.", self.accelerations)):
            found |= {prefix + name: values[:, k] for k, name in enumerate(names)}
        return found

    @property
    def samples(self) -> int:
        """Number of times at which the motion is given."""
        return len(self.times)

    @property
    def duration(self) -> float:
        """Duration of the motion: its last time, s."""
        return float(self.times[-1])

    @property
    def distance(self) -> float:
        """Length of the path of the platform's origin between the samples, m."""
        return float(np.linalg.norm(np.diff(self.poses[:, :3], axis=0), axis=1).sum())

    @property
    def max_speed(self) -> float:
        """Largest speed of the platform's origin at a sample, m/s."""
        return float(np.linalg.norm(self.velocities[:, :3], axis=1).max())

    @property
    def max_acceleration(self) -> float:
        """Largest acceleration of the platform's origin at a sample, m/s^2."""
        return float(np.linalg.norm(self.accelerations[:, :3], axis=1).max())

    @classmethod
    def through(
        cls,
        waypoints: ArrayLike,
        *,
        speed: float,
        acceleration: float,
        length: float = 1.0,
        period: float = PERIOD,
    ) -> Self:
        """Move straight from each of the *waypoints* (k, 3) or (k, 6), m and rad, to the next, at rest at each.

        Each leg takes the shortest time in which a polynomial of the fifth degree exceeds neither *speed*, m/s, nor
        *acceleration*, m/s^2; a rotation counts as a motion on the arm *length*, m. *period*: s, about, between
        samples. Raises `InputError`.

        Examples
        --------
        >>> import cablewright as cw
        >>> cw.Trajectory.through([[0, 0, 1], [1, 0, 1]], speed=0.5, acceleration=1.0)
        Trajectory(source='waypoints', samples=189, duration=3.75 s, max_speed=0.5 m/s, max_acceleration=0.4106 m/s^2)
        """
        require_positive(speed=speed, acceleration=acceleration, length=length, period=period)
        points = _waypoints(waypoints)
        way, turn = _legs(points)
        size = np.maximum(np.linalg.norm(way, axis=1), length * np.linalg.norm(turn, axis=1))
        spent = np.maximum(_PEAK_SPEED * size / speed, np.sqrt(_PEAK_ACCELERATION * size / acceleration))
        begin = np.concatenate([[0.0], np.cumsum(spent)])
        times = _times(begin[-1], period)
        leg = np.clip(np.searchsorted(begin, times, side="right") - 1, 0, len(spent) - 1)
        share, rate, change = _quintic(times - begin[leg], spent[leg])
        motion = np.concatenate([way, turn], axis=1)[leg]
        poses = np.column_stack([points[leg, :3] + share * way[leg], _turned(points[leg, 3:], share * turn[leg])])
        n = points.shape[1]
        return cls("waypoints", times, poses[:, :n], (rate * motion)[:, :n], (change * motion)[:, :n])

    @classmethod
    def spline(cls, waypoints: ArrayLike, duration: float, *, length: float = 1.0, period: float = PERIOD) -> Self:
        """Move smoothly through the *waypoints* (k, 3) or (k, 6), m and rad, from rest to rest, in *duration*, s.

        Positions follow a cubic spline, rotations one of continuous angular acceleration (SciPy's ``RotationSpline``),
        over the distance between waypoints; a rotation counts as a motion on the arm *length*, m. Along it the
        platform speeds up and slows down by a polynomial of the fifth degree. *period*: s, about. Raises `InputError`.
        """
        from scipy.interpolate import CubicSpline
        from scipy.spatial.transform import Rotation, RotationSpline

        require_positive(duration=duration, length=length, period=period)
        points = _waypoints(waypoints)
        way, turn = _legs(points)
        size = np.linalg.norm(np.concatenate([way, length * turn], axis=1), axis=1)
        knots = np.concatenate([[0.0], np.cumsum(size)])
        times = _times(duration, period)
        share, rate, change = (each[:, 0] * knots[-1] for each in _quintic(times, np.full(len(times), duration)))
        along = np.minimum(share, knots[-1])
        curve = CubicSpline(knots, points[:, :3])
        place, first, second = (curve(along, order) for order in range(3))
        if points.shape[1] == 6:
            turning = RotationSpline(knots, Rotation.from_rotvec(points[:, 3:]))
            turned = turning(along)
            place = np.column_stack([place, turned.as_rotvec()])
            rates = (turned.apply(turning(along, order)) for order in (1, 2))  # SciPy's are in the platform's frame
            first, second = (np.column_stack(each) for each in zip((first, second), rates, strict=True))
        velocities = first * rate[:, None]
        return cls("spline", times, place, velocities, second * rate[:, None] ** 2 + first * change[:, None])

    @classmethod
    def of_job(
        cls, robot: Robot, job: Job | str | Path, *, duration: float | None = None, period: float = PERIOD
    ) -> Self:
        """Follow the path of a *job*, or of a G-code file, by its time law, with the nozzle of *robot* on the path.

        *duration*: s, of the first part of it; None: all. *period*: s, about. Accelerations are those along the path;
        at a corner that is passed the velocity jumps. Raises `InputError` for a job that has a limit of jerk or turns
        the platform.
        """
        require_positive(period=period)
        read = job if isinstance(job, Job) else load_job(job)
        if read.motion.jerk is not None:
            raise InputError(
                f"job {read.name}: motion.jerk = {read.motion.jerk:g}: a trajectory has no limit of "
                "jerk; leave motion.jerk out"
            )
        if any(step.rotation is not None or step.retraction is not None for step in read.schedule):
            raise InputError(
                f"job {read.name}: schedule: a trajectory neither rotates nor retracts the platform; leave "
                "rotation and retraction out, or call spline with poses"
            )
        read = on_plane(robot, read)
        toolpath = read.toolpath()
        read = read.with_corners(read.beads(toolpath))
        samples, _ = sampled(robot, read, toolpath)
        law = read.time_law(samples)
        end = law.duration if duration is None else min(duration, law.duration)
        require_positive(duration=end)
        times = _times(end, period)
        place, *rates = _on_path(samples, law, read.motion.acceleration, times)
        poses, _ = poses_at(robot, read, place)
        still = np.zeros((len(times), robot.n - 3))
        return cls(read.name, times, poses, *(np.column_stack([each, still]) for each in rates))


def _waypoints(values: ArrayLike) -> Array:
    """Return two or more waypoints (k, 3) or (k, 6), m and rad. Raises `InputError`."""
    try:
        shape = np.shape(values) if not isinstance(values, str) else ()
    except ValueError:
        raise InputError("waypoints: rows of 3 or of 6 numbers, m and rad, are expected") from None
    points, single = as_rows(values, 6 if shape[-1:] == (6,) else 3, "waypoints", "m and rad")
    if single or len(points) < 2:
        raise InputError("waypoints: two rows or more are expected")
    return points


def _legs(points: Array) -> tuple[Array, Array]:
    """Return translations, m, and rotation vectors, rad, world, from each waypoint to the next, (k - 1, 3) each.

    Raises `InputError` for a waypoint that repeats the one before.
    """
    way, turned = np.diff(points[:, :3], axis=0), rotations(points)
    turn = turn_between(turned[:-1], turned[1:])
    still = np.flatnonzero(~(way.any(axis=1) | turn.any(axis=1)))
    if len(still):
        raise InputError(f"waypoints: number {still[0] + 2} is the same as the one before; leave it out")
    return way, turn


def _turned(start: Array, turn: Array) -> Array:
    """Return rotation vectors (k, 3), rad: *start* (k, 3), then *turn* (k, 3), world; none of a point."""
    from scipy.spatial.transform import Rotation

    if start.shape[1] == 0:
        return start
    return np.asarray((Rotation.from_rotvec(turn) * Rotation.from_rotvec(start)).as_rotvec())


def _times(duration: float, period: float) -> Array:
    """Return equal steps of about *period* from 0 to *duration*, s. Raises `InputError` for too many."""
    if not duration > 0.0:
        raise InputError("waypoints: they are too close to each other for a motion")
    samples = duration / period
    if not samples < MAX_SAMPLES:
        raise InputError(f"period = {period:g} s: {samples:g} samples; at most {MAX_SAMPLES}: take a longer period")
    steps = max(math.ceil(samples - 1e-9), 1)
    return np.linspace(0.0, duration, steps + 1)


def _quintic(time: Array, spent: Array) -> tuple[Array, Array, Array]:
    """Return share, its rate, 1/s, and the rate's, 1/s^2, (k, 1) each, of a motion from rest to rest in *spent*, s."""
    u, whole = np.clip(time / spent, 0.0, 1.0)[:, None], spent[:, None]
    share = u**3 * (10.0 - 15.0 * u + 6.0 * u * u)
    rate = 30.0 * u**2 * (1.0 - u) ** 2 / whole
    return share, rate, 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / whole**2


def _on_path(samples: Samples, law: TimeLaw, acceleration: float, times: Array) -> tuple[Array, Array, Array]:
    """Return places, velocities and accelerations (k, 3) at *times* (k,), s, along the samples of a path."""
    knots, segment = pieces(samples, law, acceleration, slice(0, len(samples)))
    row: NDArray[np.int64] = np.maximum(np.searchsorted(knots.time, times, side="right") - 1, 0)
    u, speed, change = times - knots.time[row], knots.speed[row], knots.acceleration[row]
    u = np.maximum(u, 0.0)
    along = knots.place[row] + u * (speed + 0.5 * u * change)
    near = np.minimum(segment[row], len(samples) - 2)
    ahead = np.diff(samples.positions, axis=0) / np.diff(samples.distance)[:, None]
    ahead, along = ahead[near], along - samples.distance[near]
    place = samples.positions[near] + ahead * along[:, None]
    return place, ahead * (speed + u * change)[:, None], ahead * change[:, None]
