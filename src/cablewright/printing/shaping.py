"""Motion shaping: a path's time law, averaged about each time over 1.5 periods of the swing, which it does not excite.

The commanded position is the mean of the path's law about each time, with a kernel of two running means: one of 1.05
periods of the platform's slowest mode, one of 0.55. A mode answers the mean as it answers the law, times the kernel's
spectrum: at most 0.07 of it from 0.9 times the slowest mode's frequency on, at most 0.19 from 0.75 times it on. So
frequencies may be wrong by 10 or 25 %, and faster modes need no notch of their own. The kernel follows the frequency
along the path. It is symmetric and changes nothing where the law is steady; two means bound acceleration and jerk. The
mean rounds corners: by half the jump of the velocity times the kernel's mean distance from its middle, and by the law's
acceleration meanwhile. Where the sum exceeds the corner deviation, the law is slower, or waits in the corner. A bend,
of corners of less than 11 degrees, is taken as fast as the measured rounding allows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array
from cablewright.foundation.memory_mapped import MEMORY, Room, blocks, let_go
from cablewright.printing.path import Samples
from cablewright.printing.running_mean import IntegratedLaw, Kernel
from cablewright.printing.timing import TimeLaw, time_law

LONG: Final = 1.05
"""Length of the longer running mean, in periods of the slowest mode."""

SHORT: Final = 0.55
"""Length of the shorter one."""

_CHORD: Final = 0.05  # of the corner deviation: error of straight lines, in space and time, between two samples
_SHORTEST_STEP: Final = 1.0 / 16.0  # of the kernel's length, between two samples
_LONGEST_STEP: Final = 0.75  # of the shorter mean, where the law accelerates: straight lines between excite no mode
_LOOKS: Final = 4  # times in a segment, at least, at which its acceleration is looked at
_LOOK: Final = 1.0  # of the shorter mean, at most between two of them
_STEADY: Final = 1e-9  # m/s^2
_SPAN: Final = 400.0  # of the kernel's length: the longest time of one integration, against rounding
_ROWS: Final = 20_000  # samples in one block
_HALVINGS: Final = 40
_TOGETHER: Final = 8  # rounds in which corners that meet are slowed down; then the law waits in them
_SLOWER: Final = 0.9  # of the speed that would do for a corner by itself
_STRAIGHT: Final = 1e-6  # sine of half an angle that is none
_SHARP: Final = 0.1  # sine of half an angle of a corner that ends a leg, and is no part of a bend
_STEPS: Final = 3  # of a search for what is nearest
_APART: Final = 1e-9  # m, least distance of two samples along the path


@dataclass(frozen=True, eq=False)
class Shaper:
    """Settings of motion shaping.

    ``period``: function that returns the period (k,), s, of the slowest mode with the nozzle at positions (k, 3), m.
    The other fields are limits of the job.
    """

    period: Callable[[Array], Array]
    acceleration: float  # m/s^2
    corner_deviation: float  # m
    jerk: float | None = None  # m/s^3

    def kernel(self, positions: Array) -> Kernel:
        """Return the kernel (k,) with the nozzle at *positions* (k, 3), m.

        It is long enough to spread a jump of the velocity in a corner, see `timing.corner_speeds`, to the acceleration
        of the job, and a change of that from one sign to the other to its jerk.
        """
        period, most = self.period(positions), self.acceleration
        spread = 2.0 * np.sqrt(2.0 * self.corner_deviation / most)
        change = 0.0 if self.jerk is None else 2.0 * most / self.jerk
        return Kernel(np.maximum(LONG * period, max(spread, change)), SHORT * period)

    def shaped(self, samples: Samples, room: Room = MEMORY, at_samples: Array | None = None) -> tuple[Samples, TimeLaw]:
        """Return the samples of the shaped path and their time law, from rest to rest.

        *samples*: samples of the path; the result has more of them about corners. Every point of the shaped path is
        within the corner deviation of the path. A planned stop stays at its position on the path, and is as long.
        *room*: folder for the result. *at_samples*: (k,) m/s, further limits at the samples, inf for none.
        """
        allowed = room.empty((len(samples),))  # m, of the rounding in each corner, as if that were alone
        allowed[:] = (1.0 - _CHORD) * self.corner_deviation
        rounds = 0
        while True:
            motion = self._paced(samples, allowed, room, at_samples)
            counts, excess = motion.counted(room)
            if not excess.any():
                return motion.sampled(counts, room)
            rounds += 1
            for at in blocks(len(samples)):
                self._lower(samples, motion.law, allowed, excess, at, last=rounds > _TOGETHER)
                let_go((samples, motion.law, allowed, excess))

    def _lower(self, samples: Samples, law: TimeLaw, allowed: Array, excess: Array, at: slice, *, last: bool) -> None:
        """Lower what is *allowed* (k,), m, of the rounding in a block of corners by its *excess* (k,).

        Along a bend the rounding goes with the square of the speed, and the speed with the allowed rounding. *last*:
        corners that meet were slowed down often enough; now the law waits in them.
        """
        sine, blamed = _sines(samples.positions, at), excess[at] > 0.0
        less = np.zeros(len(sine)) if last else _SLOWER / np.maximum(excess[at], 1.0)
        bends = (sine > _STRAIGHT) & (sine <= _SHARP)
        now = law.speed[at] * sine * self.kernel(samples.positions[at]).mean
        lower = np.where(bends, np.minimum(allowed[at], now) * np.sqrt(less), allowed[at] * less)
        allowed[at] = np.where(blamed, lower, allowed[at])

    def _paced(self, samples: Samples, allowed: Array, room: Room, at_samples: Array | None) -> _Motion:
        """Return the motion that is to be averaged. *allowed* (k,): m, of the rounding in each corner."""
        speeds, waits = room.empty((len(samples),)), room.empty((len(samples),))
        for at in blocks(len(samples)):
            kernel, sine = self.kernel(samples.positions[at]), _sines(samples.positions, at)
            turns, dwell = np.flatnonzero(sine > _STRAIGHT), samples.dwell[at]
            blamed = allowed[at][turns] < (1.0 - _CHORD) * self.corner_deviation
            far = (
                _legs(samples.distance[at], sine)[turns] * sine[turns] > allowed[at][turns]
            )  # over short legs it is not
            turns = turns[blamed | far]
            corner = Kernel(kernel.long[turns], kernel.short[turns])
            way = allowed[at][turns] / sine[turns]  # m, mean distance from a corner
            gained = 0.5 * self.acceleration * corner.beyond(np.zeros(1)) * (sine[turns] > _SHARP)
            speeds[at], waits[at] = np.inf, 0.0
            speeds[at][turns] = np.maximum((way - gained) / corner.mean, 0.0)
            waits[at][turns] = np.where(way <= gained, _wait(corner, 2.0 * way / self.acceleration), 0.0)
            ends = np.isin(np.arange(at.start, at.stop), (0, len(samples) - 1))
            stands = np.where(ends, 1.0, 2.0) * kernel.reach
            waits[at] = np.where(ends | (dwell > 0.0), dwell + stands, waits[at])
            let_go((samples, speeds, waits, allowed))
        if at_samples is not None:
            np.minimum(speeds, at_samples, out=speeds)
        waiting = replace(samples, dwell=waits)
        law = time_law(waiting, self.acceleration, self.corner_deviation, None, room, speeds)
        return _Motion(self, waiting, law, samples.dwell)


class _Span(NamedTuple):
    """Consecutive segments whose mean motion is computed together."""

    rows: slice  # the segments, by the samples at which they begin
    about: slice  # samples on which their motion depends
    kernel: Kernel  # (b + 1,) at the ends of the segments
    begin: Array  # (b,) s, when the mean leaves the beginning of each segment
    end: Array  # (b,) s, when it reaches the end
    pieces: IntegratedLaw

    def times(self, which: NDArray[np.int64], count: NDArray[np.int64]) -> tuple[Array, NDArray[np.int64], Kernel]:
        """Return *count* (w,) times, s, in each segment of *which* (w,), to its end; their segments and kernels."""
        own = np.repeat(which, count)
        share = (np.arange(len(own)) - np.repeat(np.cumsum(count) - count, count) + 1) / np.repeat(count, count)
        time = self.begin[own] + share * (self.end - self.begin)[own]
        return np.where(share == 1.0, self.end[own], time), own, self.kernel.between(own, share)


@dataclass(frozen=True, eq=False)
class _Motion:
    """A law along samples that stand still for some time, which is to be averaged."""

    shaper: Shaper
    samples: Samples
    law: TimeLaw
    dwell: Array  # (k,) s, that the mean is to stand still

    def counted(self, room: Room) -> tuple[NDArray[np.int64], Array]:
        """Return the samples that each segment needs (k - 1,), and how far each corner is rounded too much (k,).

        That is the largest distance from the path to which the corner contributes, over the allowed one; 0: not more.
        """
        chord = _CHORD * self.shaper.corner_deviation
        counts, excess = room.empty((len(self.samples) - 1,), np.int64), room.empty((len(self.samples),))
        excess[:] = 0.0
        for span in self._spans():
            segments = np.arange(len(span.begin))
            length, short = 2.0 * span.kernel.reach[:-1], span.kernel.short[:-1]
            looks = np.maximum(np.ceil((span.end - span.begin) / (_LOOK * short)), _LOOKS).astype(np.int64)
            time, _, kernel = span.times(segments, looks)
            _, _, vector = span.pieces.mean(time, kernel)
            most = np.maximum.reduceat(np.linalg.norm(vector, axis=1), np.cumsum(looks) - looks)
            step = np.sqrt(8.0 * chord / np.maximum(most, _STEADY))  # a chord of an arc has an error of a t^2 / 8
            longest = np.where(most > _STEADY, _LONGEST_STEP * short, np.inf)
            step = np.clip(step, _SHORTEST_STEP * length, longest)
            counts[span.rows] = np.maximum(np.ceil((span.end - span.begin) / step), 1.0)
            some = np.flatnonzero(most > _STEADY)
            if len(some):
                time, own, kernel = span.times(some, counts[span.rows][some])
                place, _, _ = span.pieces.mean(time, kernel)
                self._blame(excess, span, time, self._distances(span, own, place))
                self._blame(excess, span, *self._missed(span))
            let_go((self.samples, self.law, counts, excess))
        return counts, excess

    def sampled(self, counts: NDArray[np.int64], room: Room) -> tuple[Samples, TimeLaw]:
        """Return the samples of the shaped motion, *counts* (k - 1,) for each segment, and their law."""
        old, rows = self.samples, int(counts.sum()) + 1
        made = {key: room.empty((rows, *value.shape[1:]), value.dtype) for key, value in vars(old).items()}
        time, speed, vector = room.empty((rows,)), room.empty((rows,)), room.empty((rows, 3))
        for key, column in made.items():
            column[0] = getattr(old, key)[0]
        made["dwell"][0], time[0], speed[0], vector[0] = self.dwell[0], 0.0, 0.0, 0.0
        first = 1
        for span in self._spans():
            count = counts[span.rows]
            times, own, kernel = span.times(np.arange(len(count)), count)
            into = slice(first, first + len(times))
            place, velocity, acceleration = span.pieces.mean(times, kernel)
            for key in ("speed_limit", "move", "extruding", "layer", "line"):
                made[key][into] = getattr(old, key)[span.rows.start + 1 + own]
            made["dwell"][into] = 0.0
            made["dwell"][into][np.cumsum(count) - 1] = self.dwell[span.rows.start + 1 : span.rows.stop + 1]
            made["positions"][into] = place
            steps = np.linalg.norm(np.diff(made["positions"][first - 1 : into.stop], axis=0), axis=1)
            made["distance"][into] = made["distance"][first - 1] + np.cumsum(np.maximum(steps, _APART))
            time[into], vector[into], speed[into] = times, acceleration, np.linalg.norm(velocity, axis=1)
            first = into.stop
            let_go((old, self.law, tuple(made.values()), time, speed, vector))
        speed[-1] = 0.0
        for column in (*made.values(), time, speed, vector):
            column.setflags(write=False)
        return Samples(**made), TimeLaw(time, speed, float(time[-1] + self.dwell[-1]), vector)

    def _spans(self) -> Iterator[_Span]:
        """Yield the path in spans of some segments and some time."""
        first, last = 0, len(self.samples) - 1
        while first < last:
            longest = _SPAN * 2.0 * float(self.shaper.kernel(self.samples.positions[first : first + 1]).reach[0])
            near = self.law.time[first : min(first + _ROWS, last) + 1]
            stop = first + max(int(np.searchsorted(near, near[0] + longest)) - 1, 1)
            yield self._span(slice(first, stop), self.shaper.kernel(self.samples.positions[first : stop + 1]))
            first = stop

    def _span(self, rows: slice, kernel: Kernel) -> _Span:
        samples, law, ends = self.samples, self.law, slice(rows.start, rows.stop + 1)
        last, dwell, reach = len(samples) - 1, self.dwell[ends], kernel.reach
        late = 0.5 * (samples.dwell[ends] - dwell)  # the mean stands still in the middle of the law's stop
        late[0], late[-1] = late[0] if rows.start else 0.0, reach[-1] if rows.stop == last else late[-1]
        reached = law.time[ends] + late
        begin, end = (reached + dwell)[:-1], reached[1:]
        low, high = begin[0] - 2.0 * reach.max(), end[-1] + 2.0 * reach.max()  # see `_missed`
        first = max(int(np.searchsorted(law.time, low, side="right")) - 1, 0)
        stop = min(int(np.searchsorted(law.time, high)) + 1, last + 1)
        about = slice(first, stop)
        return _Span(rows, about, kernel, begin, end, IntegratedLaw.of(samples, law, self.shaper.acceleration, about))

    def _distances(self, span: _Span, own: NDArray[np.int64], points: Array) -> Array:
        """Return distances (b,), m, of *points* (b, 3), m, of segments *own* (b,), from the path, or more than that."""
        positions, distance = self.samples.positions[span.about], self.samples.distance[span.about]
        lengths = np.diff(distance)
        way = np.diff(positions, axis=0) / lengths[:, None]
        at, found = own + (span.rows.start - span.about.start), np.full(len(points), np.inf)
        for _ in range(_STEPS):
            off = points - positions[at]
            along = (off * way[at]).sum(axis=1)
            off -= np.clip(along, 0.0, lengths[at])[:, None] * way[at]
            found = np.minimum(found, np.linalg.norm(off, axis=1))
            at = np.clip(np.searchsorted(distance, distance[at] + along, side="right") - 1, 0, len(lengths) - 1)
        return found

    def _missed(self, span: _Span) -> tuple[Array, Array]:
        """Return times (c,), s, and by how much the mean misses each corner of a span (c,), m, or more than that."""
        first = max(span.rows.start, 1)
        corners = first + np.flatnonzero(_sines(self.samples.positions, slice(first, span.rows.stop)) > _STRAIGHT)
        own = np.clip(corners - span.rows.start, 0, len(span.begin) - 1)
        kernel, place = Kernel(*(each[own] for each in span.kernel)), self.samples.positions[corners]
        passed, found = self.law.time[corners] + 0.5 * self.samples.dwell[corners], np.full(len(corners), np.inf)
        time = passed
        for _ in range(_STEPS):
            mean, speed, _ = span.pieces.mean(time, kernel)
            off = place - mean
            found = np.minimum(found, np.linalg.norm(off, axis=1))
            later = (off * speed).sum(axis=1) / np.maximum((speed * speed).sum(axis=1), _APART)
            time = np.clip(time + later, passed - kernel.reach, passed + kernel.reach)
        return passed, found

    def _blame(self, excess: Array, span: _Span, time: Array, far: Array) -> None:
        """Write to *excess* (k,) the share by which each sample contributes to a distance that is too *far* (b,), m.

        *time* (b,): s, when.
        """
        far = far / ((1.0 - _CHORD) * self.shaper.corner_deviation)
        if not (far > 1.0).any():
            return
        about, reach = span.about, float(span.kernel.reach.max())
        reached = self.law.time[about]
        first = np.searchsorted(time, reached - reach)
        stop = np.searchsorted(time, reached + self.samples.dwell[about] + reach, side="right")
        some = np.flatnonzero(first < stop)
        ranges = np.stack([first[some], stop[some]], axis=1).ravel()
        most = np.maximum.reduceat(np.append(far, 0.0), ranges)[::2]
        excess[about][some] = np.maximum(excess[about][some], np.where(most > 1.0, most, 0.0))


def _wait(kernel: Kernel, square: Array) -> Array:
    """Return how long (k,), s, to wait in corners: the kernel's mean square beyond half of that is *square* (k,)."""
    low, high = np.zeros_like(square), kernel.reach
    for _ in range(_HALVINGS):
        half = 0.5 * (low + high)
        over = kernel.beyond(half) > square
        low, high = np.where(over, half, low), np.where(over, high, half)
    return np.asarray(2.0 * high)


def _legs(distance: Array, sine: Array) -> Array:
    """Return the length (b,), m, of the shorter of the legs to the sharp corners on either side; inf where unknown."""
    sharp = np.flatnonzero(sine > _SHARP)
    ends = np.concatenate([[-np.inf], distance[sharp], [np.inf]])
    before = ends[np.searchsorted(distance[sharp], distance)]
    after = ends[np.searchsorted(distance[sharp], distance, side="right") + 1]
    return np.asarray(np.minimum(distance - before, after - distance))


def _sines(positions: Array, at: slice) -> Array:
    """Return the sines (b,) of half the angles by which the path turns at a block of its *positions* (k, 3), m."""
    before, after = max(at.start - 1, 0), min(at.stop + 1, len(positions))
    way = np.diff(positions[before:after], axis=0)
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    found = np.zeros(at.stop - at.start)
    inner = np.linalg.norm(np.diff(way, axis=0), axis=1) / 2.0
    begin = before + 1 - at.start
    found[begin : begin + len(inner)] = inner
    return found
