"""Where the platform should be: along a path by its time law, or on the way back to it after a stop.

The law's time is gone through at a pace from 0 (stands) to 1 (as planned) that changes no faster than the job's
acceleration allows. So a print that is stopped slows down along its path, and goes on at the place where it stood.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, fields
from enum import Enum
from typing import Final, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from cablewright.errors import InputError
from cablewright.printing.job import Job
from cablewright.printing.path import Samples
from cablewright.printing.track import Track

__all__ = ["GuideState", "Target", "TimedPath", "Wish", "step"]

Array = NDArray[np.float64]

_THERE: Final = 1e-6  # m: nearer to where it should begin it is there
_ROOM: Final = 0.1  # of the acceleration that is always left to change the pace


class Wish(Enum):
    """What the guide is asked for."""

    HOLD = "slow down and stay"
    APPROACH = "go to where the path goes on"
    FOLLOW = "follow the path"


class Target(NamedTuple):
    """Where the platform should be now, how fast, and what of the path that is."""

    position: Array  # (3,) m, world
    velocity: Array  # (3,) m/s, over the step to come
    distance: float  # m along the path
    layer: int
    pace: float  # m/s along the path; 0 off it
    laying: bool  # whether material is laid here
    there: bool  # whether this is the place where the path goes on
    over: bool  # whether the path has come to its end


@dataclass(frozen=True, eq=False)
class TimedPath:
    """A path with its time law, as a guide takes it. Times are by place of the track."""

    track: Track
    start: Array  # (k,) s, when each place is left
    arrival: Array  # (k,) s, when it is reached
    speed: Array  # (k,) m/s there
    acceleration: float  # m/s^2
    travel_speed: float  # m/s, off the path
    print_speed: float  # m/s, at which material is laid at full flow

    @classmethod
    def of(cls, job: Job, layers: int | None = None, lift: float = 0.0) -> Self:
        """That of the first so many *layers* of a *job*, or of all. *lift*: of the platform over the path, m.

        Raises `InputError` for a path that lays nothing, and layers that it does not have.
        """
        samples = job.samples(job.toolpath())
        numbers = np.unique(samples.layer[samples.extruding])
        if not len(numbers):
            raise InputError(f"{job.source}: nothing is laid along the path: there is no layer to print")
        if layers is not None:
            if not 1 <= layers <= len(numbers):
                raise InputError(f"layers = {layers}: 1 to {len(numbers)} is wanted, the layers of {job.source}")
            last = np.flatnonzero(samples.extruding & (samples.layer == numbers[layers - 1]))[-1]
            samples = Samples(**{each.name: getattr(samples, each.name)[: last + 1] for each in fields(samples)})
        law = job.time_law(samples)
        motion = job.motion
        return cls(
            Track.of(samples, (0.0, 0.0, lift)),
            law.time + samples.dwell,
            np.asarray(law.time),
            np.asarray(law.speed),
            motion.acceleration,
            motion.travel_speed,
            motion.print_speed,
        )

    @property
    def duration(self) -> float:
        """All of it at full pace, s."""
        return float(self.arrival[-1])

    def distance(self, clock: float) -> float:
        """How far along the path the law is at *clock*, s: m.

        Between two places as a cubic with their speeds, which is exact where acceleration or speed stay.
        """
        i = min(max(bisect_right(self.arrival, clock) - 1, 0), len(self.arrival) - 2)
        begin, end = float(self.track.distance[i]), float(self.track.distance[i + 1])
        left, reached = float(self.start[i]), float(self.arrival[i + 1])
        if clock <= left:
            return begin
        whole = reached - left
        u = min((clock - left) / whole, 1.0)
        a, b, rise = float(self.speed[i]) * whole, float(self.speed[i + 1]) * whole, end - begin
        along = u * (a + u * (3.0 * rise - 2.0 * a - b + u * (a + b - 2.0 * rise)))
        return begin + min(max(along, 0.0), rise)


@dataclass(eq=False)
class GuideState:
    """What `step` changes. `clock` and `lift` are all that has to be kept to go on after a break."""

    clock: float = 0.0  # s of the time law
    pace: float = 0.0  # share of the law's speed
    place: Array | None = None  # (3,) m: where the target is while off the path; None: on it
    speed: float = 0.0  # m/s of the target off the path
    lift: float = 0.0  # m: by how much the platform is higher than the path says


def step(path: TimedPath, state: GuideState, dt: float, wish: Wish) -> Target:
    """Go on by *dt* (s) as one *wish*es; *state* changes in place. Raises nothing.

    A guide that was put off the path (`state.place`) comes back to it by a straight way: `Wish.APPROACH`.
    """
    if state.place is not None:
        return _approach(path, state, dt, wish)
    state.pace = _pace(path, state, dt, 1.0 if wish is Wish.FOLLOW else 0.0)
    now = path.distance(state.clock)
    state.clock = min(state.clock + state.pace * dt, path.duration)
    then = path.distance(state.clock)
    here, there = path.track.at(now).position, path.track.at(then).position
    piece = path.track.piece(0.5 * (now + then))
    lifted = np.array([0.0, 0.0, state.lift])
    over = state.clock >= path.duration
    laying = bool(path.track.laying[piece])
    layer = int(path.track.layer[piece])
    pace = (then - now) / dt
    return Target(here + lifted, (there - here) / dt, now, layer, pace, laying, state.pace == 0.0, over)


def _pace(path: TimedPath, state: GuideState, dt: float, wanted: float) -> float:
    """The next pace: as near to *wanted* as the acceleration leaves room for beside the law's own."""
    clock = state.clock
    before, here, after = (path.distance(clock + shift) for shift in (-dt, 0.0, dt))
    speed, own = (after - here) / dt, (after - 2.0 * here + before) / dt**2 * state.pace**2
    least = _ROOM * path.acceleration
    up, down = max(path.acceleration - own, least), max(path.acceleration + own, least)
    change = wanted - state.pace
    most = speed * abs(change)
    room = (up if change > 0.0 else down) * dt
    return wanted if most <= room else state.pace + change * room / most


def _approach(path: TimedPath, state: GuideState, dt: float, wish: Wish) -> Target:
    """Straight on to where the path goes on, with bounded acceleration."""
    assert state.place is not None
    distance = path.distance(state.clock)
    piece = path.track.piece(distance)
    goal = path.track.at(distance).position + np.array([0.0, 0.0, state.lift])
    away = goal - state.place
    left = float(np.sqrt(away @ away))
    change = path.acceleration * dt
    stopping = float(np.sqrt(change * change + 2.0 * path.acceleration * left)) - change  # in whole steps
    most = min(path.travel_speed, stopping) if wish is Wish.APPROACH else 0.0
    state.speed = min(max(most, state.speed - change), state.speed + change)
    here = state.place
    if left <= max(_THERE, state.speed * dt):
        state.place, state.speed, gone = (None, 0.0, goal) if wish is Wish.APPROACH else (here, 0.0, here)
    else:
        gone = here + away * (state.speed * dt / left)
        state.place = gone
    return Target(
        here, (gone - here) / dt, distance, int(path.track.layer[piece]), 0.0, False, state.place is None, False
    )
