"""Where uncertain numbers can take the nozzle: three methods, one signature.

`Vertices` solves the corners of the box of ranges, `FirstOrder` reads the one linearisation, `MonteCarlo` draws
samples. Each takes a `SpreadProblem` and returns a `Spread`; whatever else has that signature will do as well.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from cablewright.analyses.accuracy.corners import ALL_VERTICES, extreme_signs, signs_of_box, vertex_count
from cablewright.arrays import Array, Mask
from cablewright.errors import InputError
from cablewright.models.parameters import varied
from cablewright.models.rotation import angle_between, turn_between
from cablewright.models.rows import rows_of
from cablewright.models.statics import Equilibrium
from cablewright.progress import Progress, silent
from cablewright.robot.uncertainty import Range
from cablewright.solvers.forward import solve_again
from cablewright.solvers.parameters import at_nozzle, departures, response

SOLVES = 32_768  # forward problems solved between two reports: bounds memory, and the wait for an interrupt
LIKELY = 0.95  # share of samples that stay within the likely error
TRIED = 8  # corners that first order solves to tell how far it is off, beside the farthest
QUANTILES = (np.arange(1001) + 0.5) / 1001.0  # of one number's distribution


@dataclass(frozen=True, eq=False)
class SpreadProblem:
    """N places with what is uncertain there.

    `commanded` (N, m) are the lengths that the machine believes it pays out, m; `nominal` is where they take the
    platform if all numbers are nominal: a batch of N rows, all solved. `wanted` (N, n) are the poses meant.
    """

    nominal: Equilibrium
    commanded: Array
    wanted: Array
    ranges: tuple[Range, ...]
    progress: Progress = silent

    def rows(self, index: slice | NDArray[np.int64]) -> SpreadProblem:
        """Some of its places."""
        return SpreadProblem(self.nominal[index], self.commanded[index], self.wanted[index], self.ranges)

    @property
    def nominal_values(self) -> Array:
        """(k,) in each number's unit."""
        return np.array([each.nominal for each in self.ranges])

    def departures(self, values: Array) -> Array:
        """How far values (..., k) are from nominal, in what first order is linear in; see `departures`."""
        return departures([each.parameter for each in self.ranges], self.nominal_values, values)

    @property
    def middle(self) -> Array:
        """(k,) the middles of the ranges."""
        return np.array([each.middle for each in self.ranges])

    @property
    def half_widths(self) -> Array:
        """(k,) half the widths of the ranges."""
        return np.array([each.half_width for each in self.ranges])


@dataclass(frozen=True, eq=False)
class Spread:
    """What a method found at N places, k uncertain numbers; m and rad. Points are the nozzle's, in the world.

    Offsets are from where the nominal numbers take the nozzle, errors from where it is wanted.
    """

    max_error: Array  # (N,) the largest error found
    worst: Array  # (N, 3) the nozzle there
    worst_values: Array  # (N, k) the uncertain numbers there
    max_deviation: Array  # (N,) the largest offset
    low: Array  # (N, 3) smallest error by axis, signed
    high: Array  # (N, 3) largest error by axis, signed
    max_turn: Array  # (N,) largest angle from the wanted rotation; 0 for a point
    deviation: Array  # (N, 3) standard deviation by axis
    likely_error: Array  # (N,) the error that 95 % of samples stay within; NaN where nothing is sampled
    effects: Array  # (N, 3, k) offset by each number alone, half its range, first order
    nonlinearity: Array  # (N,) how far first order is off, as a share of the spread
    unsolved: NDArray[np.int64]  # (N,) how many of the places' solves have no answer; they are left out


class Method(Protocol):
    """How a spread is found."""

    @property
    def name(self) -> str:
        """What it is called on the command line and in reports."""
        ...

    def __call__(self, problem: SpreadProblem) -> Spread:
        """The spread at each place of *problem*."""
        ...


@dataclass(frozen=True)
class Vertices:
    """The corners of the box: all of them up to 12 numbers, beyond that those which first order cannot rule out."""

    name = "vertices"

    def __call__(self, problem: SpreadProblem) -> Spread:
        """The spread over the corners."""
        count = vertex_count(len(problem.ranges))
        return _by_blocks(problem, count, self._block)

    @staticmethod
    def _block(problem: SpreadProblem) -> Spread:
        linear = _Linear.of(problem)
        signs = _corners(linear)
        values = problem.middle + signs * problem.half_widths
        points, turns, ok = sampled(problem, values)
        nonlinearity = _nonlinearity(points - linear.start[:, None], linear.offsets(signs), ok)
        return _gathered(problem, linear, values, points, turns, ok, nonlinearity)


@dataclass(frozen=True)
class FirstOrder:
    """The one linearisation: cheap, and exact for small ranges. A few corners are solved to tell how far it is off."""

    name = "first-order"

    def __call__(self, problem: SpreadProblem) -> Spread:
        """The spread over the corners, as first order has them."""
        count = vertex_count(len(problem.ranges))
        return _by_blocks(problem, count, self._block)

    @staticmethod
    def _block(problem: SpreadProblem) -> Spread:
        linear = _Linear.of(problem)
        signs = _corners(linear)
        offsets = linear.offsets(signs)
        count = offsets.shape[1]
        rows = np.arange(len(offsets))[:, None]
        farthest = np.linalg.norm(offsets, axis=2).argmax(axis=1)
        tried = np.column_stack([farthest, *(np.full(len(rows), k) for k in range(0, count, -(-count // TRIED)))])
        values = problem.middle + signs * problem.half_widths
        solved, _, ok = sampled(problem, values[rows, tried] if values.ndim == 3 else values[tried])
        nonlinearity = _nonlinearity(solved - linear.start[:, None], offsets[rows, tried], ok)
        every = np.ones(offsets.shape[:2], dtype=bool)
        points = linear.start[:, None] + offsets
        found = _gathered(problem, linear, values, points, linear.turns(problem, signs), every, nonlinearity)
        return replace(found, unsolved=(~ok).sum(axis=1))


@dataclass(frozen=True)
class MonteCarlo:
    """Random samples: uniform in a range, normal where a standard deviation is given; the same at each place."""

    name = "monte-carlo"
    samples: int = 100_000
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse too few samples to tell a standard deviation."""
        if not 100 <= self.samples <= 10_000_000:
            raise InputError(f"samples = {self.samples}: from 100 to 10 000 000 are allowed")
        if self.seed < 0:
            raise InputError(f"seed = {self.seed}: at least 0 is wanted")

    def __call__(self, problem: SpreadProblem) -> Spread:
        """The spread of the samples."""
        drawn = _drawn(problem.ranges, self.samples, self.seed)
        return _by_blocks(problem, self.samples, lambda rows: self._block(rows, drawn))

    @staticmethod
    def _block(problem: SpreadProblem, drawn: Array) -> Spread:
        linear = _Linear.of(problem)
        points, turns, ok = sampled(problem, drawn)
        deviation = _deviation(points, ok)
        errors = np.sort(np.where(ok, np.linalg.norm(points - linear.wanted[:, None], axis=2), np.inf), axis=1)
        likely = np.maximum(np.ceil(LIKELY * ok.sum(axis=1)).astype(np.int64) - 1, 0)
        errors[~ok.any(axis=1)] = np.nan
        expected = np.std(problem.departures(drawn) @ np.swapaxes(linear.per_unit, 1, 2), axis=1)
        total = np.linalg.norm(deviation, axis=1)
        nonlinearity = np.linalg.norm(deviation - expected, axis=1) / np.maximum(total, 1e-300)
        found = _gathered(problem, linear, drawn, points, turns, ok, nonlinearity)
        return replace(found, deviation=deviation, likely_error=errors[np.arange(len(errors)), likely])


def sampled(problem: SpreadProblem, values: Array) -> tuple[Array, Array, Mask]:
    """The nozzle (N, S, 3), its turn from what is wanted (N, S) and whether there is an answer, for *values*.

    *values*: (S, k), the same at each place, or (N, S, k). In blocks, however many there are.
    """
    model, places = problem.nominal.model, len(problem.commanded)
    count = values.shape[-2]
    points, turns = np.empty((places, count, 3)), np.zeros((places, count))
    ok = np.empty((places, count), dtype=bool)
    for row, first in _pieces(places, count):
        each = slice(first, first + SOLVES)
        own = (
            values[row, each]
            if values.ndim == 3
            else np.broadcast_to(values[each], (len(points[row]), *values[each].shape))
        )
        found = settled(problem.rows(row), own)
        shape = own.shape[:2]
        points[row, each] = model.nozzle(found.pose).reshape(*shape, 3)
        ok[row, each] = found.ok.reshape(shape)
        if model.n == 6:
            wanted = np.repeat(problem.wanted[row, 3:], shape[1], axis=0)
            turns[row, each] = angle_between(wanted, found.pose[:, 3:]).reshape(shape)
    return points, turns, ok


def _pieces(places: int, count: int) -> list[tuple[slice, int]]:
    """Blocks of places and first samples with at most SOLVES problems each."""
    rows = max(1, SOLVES // count)
    return [(slice(row, row + rows), first) for row in range(0, places, rows) for first in range(0, count, SOLVES)]


def settled(problem: SpreadProblem, values: Array) -> Equilibrium:
    """The equilibria (N * S) of *values* (N, S, k), row by row."""
    places, each, k = values.shape
    base = problem.nominal
    packed = base.packed
    if len(packed.lines) > 1:
        packed = rows_of(packed, np.repeat(np.arange(places), each))
    lengths = np.repeat(problem.commanded, each, axis=0)
    parameters = [one.parameter for one in problem.ranges]
    changed, paid_out = varied(base.model.robot, packed, parameters, values.reshape(-1, k), lengths)
    return solve_again(base, changed, paid_out, each)


@dataclass(frozen=True, eq=False)
class _Linear:
    """First order at N places: the nozzle where all is nominal, and its motion per half range."""

    start: Array  # (N, 3)
    wanted: Array  # (N, 3)
    per_unit: Array  # (N, 3, k)
    shifted: Array  # (N, 3) the offset midway between the ends of the ranges
    effects: Array  # (N, 3, k)
    rotation: Array  # (N, 3, k) of the platform, per half range
    rotation_shifted: Array  # (N, 3)

    @classmethod
    def of(cls, problem: SpreadProblem) -> _Linear:
        """At the problem's places."""
        nominal = problem.nominal
        motion = response(nominal, [each.parameter for each in problem.ranges])
        translation, rotation = at_nozzle(nominal, motion), motion[:, 3:]
        low, high = (
            problem.departures(np.array(ends)) for ends in zip(*((r.low, r.high) for r in problem.ranges), strict=True)
        )
        shift, half = 0.5 * (low + high), 0.5 * (high - low)
        return cls(
            start=nominal.nozzle,
            wanted=nominal.model.nozzle(problem.wanted),
            per_unit=translation,
            shifted=translation @ shift,
            effects=translation * half,
            rotation=rotation * half,
            rotation_shifted=rotation @ shift,
        )

    def offsets(self, signs: Array) -> Array:
        """Offsets (N, S, 3) of the corners *signs*, (S, k) or (N, S, k)."""
        return self.shifted[:, None] + signs @ np.swapaxes(self.effects, 1, 2)

    def turns(self, problem: SpreadProblem, signs: Array) -> Array:
        """Angles (N, S) of the corners from the wanted rotation, for small ones."""
        if problem.nominal.model.n == 3:
            return np.zeros((len(self.start), signs.shape[-2]))
        turned = self.rotation_shifted[:, None] + signs @ np.swapaxes(self.rotation, 1, 2)
        away = turn_between(problem.wanted[:, 3:], problem.nominal.pose[:, 3:])
        return np.asarray(np.linalg.norm(turned + away[:, None], axis=2))


def corner_values(problem: SpreadProblem) -> Array:
    """Values (S, k) of the corners of the box that `Vertices` looks at, of a problem of one place."""
    signs = _corners(_Linear.of(problem))
    if signs.ndim == 3:
        signs = np.unique(signs[0], axis=0)
    return problem.middle + signs * problem.half_widths


def _corners(linear: _Linear) -> Array:
    """Signs of the corners to look at: (S, k) for all, or (N, S, k) where first order has chosen."""
    k = linear.effects.shape[2]
    return signs_of_box(k) if k <= ALL_VERTICES else np.stack([extreme_signs(one) for one in linear.effects])


def _sigmas(problem: SpreadProblem) -> Array:
    """Standard deviations (k,) of the numbers' departures."""
    columns = []
    for each in problem.ranges:
        if each.deviation is None:
            columns.append(each.low + QUANTILES * (each.high - each.low))
        else:
            normal = NormalDist(each.nominal, each.deviation)
            below, above = (
                normal.cdf(each.min_value),
                normal.cdf(each.max_value),
            )  # drawn again where there is no such number
            columns.append(np.array([normal.inv_cdf(below + u * (above - below)) for u in QUANTILES]))
    return np.asarray(problem.departures(np.column_stack(columns)).std(axis=0))


def _drawn(ranges: Sequence[Range], samples: int, seed: int) -> Array:
    """Samples (S, k); a normal one that no machine can have, such as a negative radius, is drawn again."""
    rng = np.random.default_rng(seed)
    drawn = np.empty((samples, len(ranges)))
    for column, each in zip(drawn.T, ranges, strict=True):
        if each.deviation is None:
            column[:] = rng.uniform(each.low, each.high, samples)
            continue
        column[:] = rng.normal(each.nominal, each.deviation, samples)
        for _ in range(100):
            wrong = ~((column > each.min_value) & (column < each.max_value))
            if not wrong.any():
                break
            column[wrong] = rng.normal(each.nominal, each.deviation, int(wrong.sum()))
        else:
            raise InputError(
                f"{each.parameter.label}: a deviation of {each.deviation:g} is too wide for what it can be"
            )
    return drawn


def _by_blocks(problem: SpreadProblem, count: int, block: Callable[[SpreadProblem], Spread]) -> Spread:
    """All places, as many at once as SOLVES allows."""
    places, rows = len(problem.commanded), max(1, SOLVES // count)
    found = []
    for first in range(0, max(1, places), rows):
        problem.progress("solving", first, places)
        found.append(block(problem.rows(slice(first, first + rows))))
    problem.progress("solving", places, places)
    names = Spread.__dataclass_fields__
    return Spread(**{name: np.concatenate([getattr(one, name) for one in found]) for name in names})


def _gathered(
    problem: SpreadProblem,
    linear: _Linear,
    values: Array,
    points: Array,
    turns: Array,
    ok: Mask,
    nonlinearity: Array,
) -> Spread:
    """The spread of nozzles *points* (N, S, 3); where *ok* is false they count for nothing."""
    errors = points - linear.wanted[:, None]
    size = np.linalg.norm(errors, axis=2)
    worst = np.where(ok, size, -1.0).argmax(axis=1)
    rows = np.arange(len(worst))
    known = np.asarray(ok.any(axis=1))[:, None]
    return Spread(
        max_error=_largest(size, ok),
        worst=np.where(known, points[rows, worst], np.nan),
        worst_values=np.where(known, values[rows, worst] if values.ndim == 3 else values[worst], np.nan),
        max_deviation=_largest(np.linalg.norm(points - linear.start[:, None], axis=2), ok),
        low=-_largest(-errors, ok),
        high=_largest(errors, ok),
        max_turn=_largest(turns, ok),
        deviation=np.sqrt(((linear.per_unit * _sigmas(problem)) ** 2).sum(axis=2)),
        likely_error=np.full(len(worst), np.nan),
        effects=linear.effects,
        nonlinearity=nonlinearity,
        unsolved=(~ok).sum(axis=1),
    )


def _nonlinearity(offsets: Array, expected: Array, ok: Mask) -> Array:
    """How far the *expected* offsets (N, S, 3) are from those found, as a share of the largest."""
    largest = _largest(np.linalg.norm(offsets, axis=2), ok)
    return _largest(np.linalg.norm(offsets - expected, axis=2), ok) / np.maximum(largest, 1e-300)


def _largest(values: Array, ok: Mask) -> Array:
    """Largest (N, ...) of values (N, S, ...) along S where *ok* (N, S); NaN where there is none."""
    wide = ok.reshape(*ok.shape, *(1,) * (values.ndim - 2))
    largest = np.where(wide, values, -np.inf).max(axis=1)
    return np.where(np.isfinite(largest), largest, np.nan)


def _deviation(points: Array, ok: Mask) -> Array:
    """Standard deviation (N, 3) of points (N, S, 3) where *ok*; NaN where there is none."""
    count = ok.sum(axis=1)[:, None]
    number = np.where(count > 0, count, np.nan)
    mean = np.where(ok[..., None], points, 0.0).sum(axis=1) / number
    away = np.where(ok[..., None], points - mean[:, None], 0.0)
    return np.asarray(np.sqrt((away * away).sum(axis=1) / number))
