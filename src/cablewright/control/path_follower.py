"""Target of the platform: on a path with its time law, or on its return to the path after a stop.

The time law runs at a speed factor from 0 (at rest) to 1 (as planned), whose change is limited by the job's
acceleration: a print that is stopped slows down along its path and continues from there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, replace
from enum import Enum
from functools import cached_property
from typing import Final, NamedTuple, Self

import numpy as np

from cablewright.control.attitude import Attitude
from cablewright.control.speed_smoothing import STEADY, PeriodAt, RampMean
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.kernels import Direct
from cablewright.kernels.control import path_target as kernel
from cablewright.kernels.control.path_target import LawArrays, TrackArrays
from cablewright.models.path_offset import arrays_of, nearest_in, read_only
from cablewright.models.rotation import motion_between
from cablewright.printing.arc_length_path import Track
from cablewright.printing.job import Job, Motion
from cablewright.printing.path import Samples
from cablewright.printing.shaping import Shaper
from cablewright.printing.timing import TimeLaw
from cablewright.robot import Robot
from cablewright.solvers.swing_free_motion import JobMotion

_TOLERANCE: Final = 1e-6  # m, distance from the path that counts as arrival
_RESERVE: Final = 0.1  # share of the acceleration that is always available to change the speed factor
_ARM: Final = 1.0  # m: a rotation counts as motion at this arm on the return to the path
_STILL: Final = np.zeros(3)
_STILL.flags.writeable = False
_STEADY: Final = np.zeros((2, 3))
_STEADY.flags.writeable = False


class GuideMode(Enum):
    """Mode of the guide: on the path, back to it, or at rest."""

    HOLD = "slow down and stay"
    PAUSE = "slow down without a swing, and stay"
    APPROACH = "return to the path"
    FOLLOW = "follow the path"


class Target(NamedTuple):
    """Target position and velocity of the platform, and its position along the path."""

    position: Array  # (3,) m, world
    velocity: Array  # (3,) m/s, mean over the next step
    distance: float  # m along the path
    layer: int
    path_speed: float  # m/s along the path; 0 off the path
    extruding: bool  # whether the path lays material here
    arrived: bool  # at the place where the path continues
    finished: bool  # at the end of the path
    rotation: Array = _STILL  # (3,) rad, of a rigid platform
    rate: Array = _STILL  # (3,) rad/s, world, mean over the next step
    flow: float = 0.0  # m/s of strand to lay: that of the path where the motion will be after the pressure advance
    accelerations: Array = _STEADY  # (2, 3) m/s^2, at the beginning and the end of the next step
    retraction: float = math.nan  # m; NaN: as it is
    retraction_rate: float = 0.0  # m/s, mean over the next step

    def writable(self) -> Self:
        """Return the target with position, velocity and accelerations as kernels need them: doubles, to be written."""
        own = self.position, self.velocity, self.accelerations
        if all(each.flags.carray and each.dtype == np.float64 for each in own):
            return self
        place, speed, moving = (np.array(each, np.float64, order="C") for each in own)
        return self._replace(position=place, velocity=speed, accelerations=moving)


@dataclass(frozen=True, eq=False)
class TimedPath:
    """A path with its time law. Arrays have one entry for each of the k points of the track.

    The track is that of the platform point B; of a rigid platform, with an ``attitude``, that of its nozzle.
    """

    track: Track
    samples: Samples  # of the track, without the lift of the platform over the path
    motion: Motion
    lift: float  # m, of the track over the samples
    start: Array  # (k,) s, departure from each point
    arrival: Array  # (k,) s, arrival at each point
    speed: Array  # (k,) m/s, at each point
    vector: Array | None  # (k, 3) m/s^2, acceleration at each point of a shaped path
    attitude: Attitude | None = None  # of a rigid platform
    shaping: tuple[Shaper, Samples] | None = None  # of a shaped path: what shapes it, and what is shaped
    notes: tuple[str, ...] = ()  # on shaping
    tour: Array = field(default_factory=lambda: np.zeros((0, 3)))  # (t, 3) m, gone through before the path begins
    period: PeriodAt | None = None  # for which pauses, and the way to the path, are shaped; None: they are not

    @classmethod
    def of(
        cls,
        job: Job,
        layers: int | None = None,
        lift: float = 0.0,
        nozzle: tuple[float, float, float] | None = None,
        samples: Samples | None = None,
        robot: Robot | None = None,
    ) -> Self:
        """Return the timed path of the first *layers* of a *job*; None: all.

        *lift*: height of the platform over the path, m. *nozzle*: nozzle of a rigid platform, m, platform frame.
        *samples*: samples of the path; by default those of the job's file. *robot*: robot whose modes shape the motion,
        see `JobMotion`. Raises `InputError` for a path without material, and for more layers than it has.
        """
        if samples is None:
            toolpath = job.toolpath()
            job, samples = job.with_corners(job.beads(toolpath)), job.samples(toolpath)
        numbers = np.unique(samples.layer[samples.extruding])
        if not len(numbers):
            raise InputError(
                f"{job.source}: the path lays no material, so there is no layer to print; give a job with extrusion"
            )
        if layers is not None:
            if not 1 <= layers <= len(numbers):
                raise InputError(f"layers = {layers}: must be 1 to {len(numbers)}, the layers of {job.source}")
            last = np.flatnonzero(samples.extruding & (samples.layer == numbers[layers - 1]))[-1]
            samples = Samples(**{each.name: getattr(samples, each.name)[: last + 1] for each in fields(samples)})
        attitude = None if nozzle is None else Attitude.of(job.schedule, nozzle)
        if robot is None:
            return cls._timed(samples, job.time_law(samples), lift, job.motion, attitude)
        moved = JobMotion.of(robot, job, samples)
        found = cls._timed(moved.samples, moved.law, lift, job.motion, attitude)
        shaping = None if moved.shaper is None else (moved.shaper, moved.path)
        return replace(found, shaping=shaping, notes=moved.notes)

    @classmethod
    def _timed(cls, samples: Samples, law: TimeLaw, lift: float, motion: Motion, attitude: Attitude | None) -> Self:
        track, start = Track.of(samples, (0.0, 0.0, lift)), law.time + samples.dwell
        return cls(track, samples, motion, lift, start, law.time, law.speed, law.vector, attitude)

    def slower(self, acceleration: float, at_points: Array) -> TimedPath:
        """Return the path with a lower *acceleration*, m/s^2, and at most the speeds *at_points* (k,), m/s.

        A shaped path rounds its corners again, and takes no speeds *at_points*.
        """
        motion = self.motion.model_copy(update={"acceleration": acceleration})
        if self.shaping is not None:
            shaper, path = replace(self.shaping[0], acceleration=acceleration), self.shaping[1]
            slow = self._timed(*shaper.shaped(path), self.lift, motion, self.attitude)
            return replace(slow, shaping=(shaper, path), notes=self.notes, tour=self.tour, period=self.period)
        law = motion.time_law(self.samples, at_samples=at_points)
        return replace(self, motion=motion, start=law.time + self.samples.dwell, arrival=law.time, speed=law.speed)

    @property
    def acceleration(self) -> float:
        """Limit of the acceleration, m/s^2."""
        return self.motion.acceleration

    @property
    def travel_speed(self) -> float:
        """Speed of travel moves, m/s."""
        return self.motion.travel_speed

    @property
    def print_speed(self) -> float:
        """Print speed at full flow, m/s."""
        return self.motion.print_speed

    @property
    def start_pose(self) -> Array:
        """The pose (n,) of the platform where the path begins, m and rad."""
        begin = self.track.at(0.0).position
        if self.attitude is None:
            return begin
        rotation = self.attitude.rotation(float(begin[2]))
        return np.concatenate([self.attitude.origin(begin, rotation), rotation])

    @property
    def start_retraction(self) -> float:
        """Retraction length where the path begins, m; NaN: the schedule has none."""
        begin = float(self.track.at(0.0).position[2])
        return math.nan if self.attitude is None else self.attitude.retraction(begin)

    def printing_point(self, position: Array, rotation: Array) -> Array:
        """Return the point (3,), m, that must be on the track, with the platform at *position* and *rotation*."""
        return position if self.attitude is None else self.attitude.nozzle_at(position, rotation)

    @property
    def duration(self) -> float:
        """Duration of the path at a speed factor of 1, s."""
        return float(self.arrival[-1])

    @cached_property
    def arrays(self) -> tuple[TrackArrays, LawArrays]:
        """Track and time law for kernels."""
        vector = np.zeros((0, 3)) if self.vector is None else self.vector
        law = LawArrays(*map(read_only, (self.start, self.arrival, self.speed, vector)))
        return arrays_of(self.track), law

    def distance(self, path_time: float) -> float:
        """Return the distance along the path, m, at *path_time*, s, of the law."""
        return float(kernel.distance_at(*self.arrays, path_time))

    def offset(self, point: Array, around: float) -> float:
        """Return the offset of a *point* (3,), m, from the path near the distance *around*, m; see `path_offset`."""
        return nearest_in(self.arrays[0], point.tolist(), around).offset


@dataclass(eq=False)
class GuideState:
    """State of the guide, changed in place by `step`.

    `path_time`, `height_offset` and `toured` are enough to continue after a restart.
    """

    SAVED = ("path_time", "height_offset", "toured")

    path_time: float = 0.0  # s of the time law
    speed_factor: float = 0.0  # share of the law's speed
    position: Array | None = None  # (3,) m, of a target off the path; None: on the path
    speed: float = 0.0  # m/s, of a target off the path
    height_offset: float = 0.0  # m, of the platform over the path
    rotation: Array | None = None  # (3,) rad, of a target off the path; None: by the schedule
    toured: int = 0  # places of the path's tour that were reached
    factor_mean: RampMean = field(default_factory=RampMean)  # of the speed factor
    speed_mean: RampMean = field(default_factory=RampMean)  # of the speed off the path
    advance: Direct = field(default_factory=lambda: Direct(kernel.advance))

    def stand(self) -> None:
        """Stop the target where it is."""
        self.speed_factor, self.speed = 0.0, 0.0
        self.factor_mean.rest()
        self.speed_mean.rest()

    def is_touring(self, path: TimedPath) -> bool:
        """Whether there are positions to visit before the path begins."""
        return self.path_time == 0.0 and self.toured < len(path.tour)


def step(path: TimedPath, state: GuideState, dt: float, mode: GuideMode, share: float = 1.0) -> Target:
    """Return the target for the next *dt* (s) in a *mode*, at a *share* of the planned speed; *state* changes in place.

    Off the path (`state.position`), `GuideMode.APPROACH` leads back to it along a straight line; before the path
    begins, through the places of its tour.
    """
    if state.position is not None:
        return _approach(path, state, dt, mode)
    begin, motion = state.path_time, path.motion
    state.speed_factor = factor = _speed_factor(path, state, dt, mode, share)
    state.path_time = min(begin + factor * dt, path.duration)
    found = np.empty(kernel.TARGET)
    track, law = path.arrays
    lead = float(motion.pressure_advance)
    state.advance.call(track, law, begin, state.path_time, dt, lead, factor, state.height_offset, found)
    now, path_speed, flow, layer, lays = found[kernel.DISTANCE :].tolist()
    here, there = found[kernel.HERE : kernel.THERE], found[kernel.THERE : kernel.DISTANCE]
    moving = found[kernel.ACCELERATIONS : kernel.HERE].reshape(2, 3)
    if factor and state.factor_mean.rates is not STEADY:
        moving = moving + state.factor_mean.rates * (there - here) / (dt * factor)
    target = Target(
        found[: kernel.VELOCITY],
        found[kernel.VELOCITY : kernel.ACCELERATIONS],
        now,
        int(layer),
        path_speed,
        lays > 0.0,
        factor == 0.0,
        state.path_time >= path.duration,
        flow=flow,
        accelerations=moving,
    )
    if path.attitude is None:
        return target
    turned, goal = path.attitude.rotation(float(here[2])), path.attitude.rotation(float(there[2]))
    return _carrying(path.attitude, target, here, there, turned, goal, dt)


def leave_path(path: TimedPath, state: GuideState, position: Array, rotation: Array) -> None:
    """Let the target continue from the platform's *position*, m, and *rotation*, rad; *state* changes in place."""
    state.position = path.printing_point(position, rotation).copy()
    state.rotation = None if path.attitude is None else rotation.copy()


def _carrying(
    attitude: Attitude, target: Target, here: Array, there: Array, turned: Array, goal: Array, dt: float
) -> Target:
    """Return the target of the platform that carries the nozzle from *here* to *there*."""
    motion = attitude.carried(here, there, turned, goal, dt)
    retraction, then = attitude.retraction(float(here[2])), attitude.retraction(float(there[2]))
    return target._replace(
        position=motion.position,
        velocity=motion.velocity,
        rotation=motion.rotation,
        rate=motion.rate,
        retraction=retraction,
        retraction_rate=0.0 if math.isnan(then) else (then - retraction) / dt,
    )


def _speed_factor(path: TimedPath, state: GuideState, dt: float, mode: GuideMode, share: float) -> float:
    """Return the next speed factor, of the mean where the path has a period.

    A path begins at rest, and is followed by its law from there.
    """
    goal = share if mode is GuideMode.FOLLOW else 0.0
    if path.period is None or mode is GuideMode.HOLD or state.path_time == 0.0:
        state.factor_mean.rest()
        return _ramped(path, state, dt, state.speed_factor, goal)
    if state.speed_factor == goal and state.factor_mean.is_steady:
        return goal
    now, period = np.array([state.speed_factor]), path.period
    asked = _ramped(path, state, dt, float(state.factor_mean.asked(now)[0]), goal)

    def here() -> float:
        return period(path.track.at(path.distance(state.path_time)).position)

    return float(state.factor_mean.take(now, np.array([asked]), here, dt)[0])


def _ramped(path: TimedPath, state: GuideState, dt: float, factor: float, goal: float) -> float:
    """Return what follows the speed *factor*: as near to *goal* as the acceleration, less the law's own, allows."""
    if factor == goal:
        return goal
    now = state.path_time
    before, here, after = (path.distance(now + shift) for shift in (-dt, 0.0, dt))
    speed, own = (after - here) / dt, (after - 2.0 * here + before) / dt**2 * state.speed_factor**2
    reserve = _RESERVE * path.acceleration
    up, down = max(path.acceleration - own, reserve), max(path.acceleration + own, reserve)
    change = goal - factor
    needed = speed * abs(change)
    available = (up if change > 0.0 else down) * dt
    return goal if needed <= available else factor + change * available / needed


def _approach(path: TimedPath, state: GuideState, dt: float, mode: GuideMode) -> Target:
    """Return the target on the straight line back to the path, or to the next place of its tour, and not too fast."""
    assert state.position is not None
    distance, touring = path.distance(state.path_time), state.is_touring(path)
    piece = path.track.piece(distance)
    goal = path.track.at(distance).position + np.array([0.0, 0.0, state.height_offset])
    if touring:
        goal = path.tour[state.toured]
    way = goal - state.position
    turned = state.rotation if state.rotation is not None else _STILL
    scheduled = _STILL if path.attitude is None else path.attitude.rotation(float(goal[2]))
    ends = np.concatenate([_STILL, turned]), np.concatenate([_STILL, scheduled])
    turn = _STILL if path.attitude is None else motion_between(*ends)[3:]
    left = math.sqrt(float(way @ way) + _ARM * _ARM * float(turn @ turn))
    ahead = way / left if left else _STILL
    state.speed = _approach_speed(path, state, left, dt, mode)
    here = state.position
    if left <= max(_TOLERANCE, state.speed * dt):
        arrives = mode is GuideMode.APPROACH
        state.toured += int(arrives and touring)
        stays = goal if touring else None
        state.position, there = (stays, goal) if arrives else (here, here)
        state.stand()
        then = scheduled if arrives else turned
    else:
        share = state.speed * dt / left
        there, then = here + way * share, turned + turn * share  # a turn in space, which ends in the schedule's
        state.position = there
    target = Target(
        here,
        (there - here) / dt,
        distance,
        int(path.track.layer[piece]),
        0.0,
        False,
        state.position is None,
        False,
        accelerations=state.speed_mean.rates * ahead,
    )
    if path.attitude is None:
        return target
    state.rotation = None if state.position is None else then
    return _carrying(path.attitude, target, here, there, turned, then, dt)


def _approach_speed(path: TimedPath, state: GuideState, left: float, dt: float, mode: GuideMode) -> float:
    """Return the speed of the next step, m/s, on a line of which *left* m are left.

    It is that of the mean where the path has a period, but for a stop, and until the target stands after one.
    """
    change, now, mean = path.acceleration * dt, np.array([state.speed]), state.speed_mean
    period, place = path.period, state.position
    if mode is GuideMode.HOLD:
        mean.rest()
    before = float(mean.asked(now)[0])
    left = max(left - float(mean.pending(now, dt)[0]), 0.0)  # once the wanted speed is reached
    stopping = float(np.sqrt(change * change + 2.0 * path.acceleration * left)) - change  # in whole steps
    max_speed = min(path.travel_speed, stopping) if mode is GuideMode.APPROACH else 0.0
    asked = min(max(max_speed, before - change), before + change)
    prompt = mode is GuideMode.HOLD or (state.speed > 0.0 and not mean.has_begun)
    if period is None or place is None or prompt:
        return asked
    return float(mean.take(now, np.array([min(asked, left / dt)]), lambda: period(place), dt)[0])
