"""Spread of the nozzle's position due to uncertain parameters, by one of three methods with the same signature.

`Vertices` solves the corners of the box of ranges, `FirstOrder` evaluates the linearisation, `MonteCarlo` solves random
samples. Each takes a `SpreadProblem` and returns a `Spread`; any other callable with that signature works as well.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from functools import partial
from statistics import NormalDist
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from cablewright.analyses.accuracy.corners import ALL_VERTICES, extreme_signs, signs_of_box, vertex_count
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError
from cablewright.foundation.progress import Progress, silent
from cablewright.models.batch_rows import rows_of
from cablewright.models.parameters import varied
from cablewright.models.rotation import angle_between, turn_between
from cablewright.models.statics import Equilibrium
from cablewright.robot.uncertainty import Range
from cablewright.solvers.forward import solve_again
from cablewright.solvers.parameter_effects import at_nozzle, departures, range_response, zeroing

SOLVES = 32_768  # forward problems between two progress reports: bounds memory and the time until an interrupt acts
LIKELY = 0.95  # share of samples within the likely error
TRIED = 8  # corners that `FirstOrder` solves besides the farthest, to measure its nonlinearity
QUANTILES = (np.arange(1001) + 0.5) / 1001.0  # at which one parameter's distribution is evaluated


@dataclass(frozen=True, eq=False)
class SpreadProblem:
    """The problem of how k uncertain parameters spread the nozzle's position at N poses.

    `commanded` (N, m): the commanded lengths, m. `nominal`: the equilibria that these reach if all parameters are
    nominal, a batch of N solved rows. `wanted` (N, n): the poses that were commanded, m and rad.
    """

    nominal: Equilibrium
    commanded: Array
    wanted: Array
    ranges: tuple[Range, ...]
    progress: Progress = silent

    def rows(self, index: slice | NDArray[np.int64]) -> SpreadProblem:
        """Return the problem for some of its poses (rows)."""
        return SpreadProblem(self.nominal[index], self.commanded[index], self.wanted[index], self.ranges)

    def departures(self, values: Array) -> Array:
        """Return how far values (..., k) are from nominal, as `solvers.parameter_effects.departures` has them."""
        nominal = np.array([each.nominal for each in self.ranges])
        return departures([each.parameter for each in self.ranges], nominal, values)

    @property
    def middle(self) -> Array:
        """Middles (k,) of the parameters' ranges, SI."""
        return np.array([each.middle for each in self.ranges])

    @property
    def half_widths(self) -> Array:
        """Half widths (k,) of the parameters' ranges, SI."""
        return np.array([each.half_width for each in self.ranges])


@dataclass(frozen=True, eq=False)
class Spread:
    """The nozzle's positions at N poses under k uncertain parameters, m and rad, in the world frame.

    A deviation is measured from the nozzle position that nominal parameters give, an error from the commanded one.
    """

    max_error: Array  # (N,) the largest error found
    worst: Array  # (N, 3) nozzle position at that error
    worst_values: Array  # (N, k) values of the parameters at that error
    max_deviation: Array  # (N,) the largest deviation
    low: Array  # (N, 3) smallest signed error along each axis
    high: Array  # (N, 3) largest signed error along each axis
    max_turn: Array  # (N,) largest angle from the commanded rotation; 0 for a point platform
    deviation: Array  # (N, 3) standard deviation along each axis
    likely_error: Array  # (N,) error that 95 % of the samples stay within; NaN without samples
    effects: Array  # (N, 3, k) displacement by half the range of each parameter alone, to first order
    nonlinearity: Array  # (N,) error of the first order, as a share of the largest deviation
    unsolved: NDArray[np.int64]  # (N,) number of sets of values without an equilibrium, which are left out


class Method(Protocol):
    """A method that computes a `Spread`, the error of the nozzle from uncertain parameters."""

    @property
    def name(self) -> str:
        """Name of the method on the command line and in reports."""
        ...

    def __call__(self, problem: SpreadProblem) -> Spread:
        """Return the spread at each pose of *problem*."""
        ...


@dataclass(frozen=True)
class Vertices:
    """Solve the corners of the box of ranges: all up to 12 parameters, else those that first order cannot rule out."""

    name = "vertices"

    def __call__(self, problem: SpreadProblem) -> Spread:
        """Return the spread over the corners."""
        return _by_blocks(problem, vertex_count(len(problem.ranges)), self._block)

    @staticmethod
    def _block(problem: SpreadProblem, linear: _Linear) -> Spread:
        signs = _corners(linear)
        values = problem.middle + signs * problem.half_widths
        points, turns, ok = sampled(problem, values)
        nonlinearity = _nonlinearity(points - linear.start[:, None], linear.offsets(signs), ok)
        return _gathered(problem, linear, values, points, turns, ok, nonlinearity)


@dataclass(frozen=True)
class FirstOrder:
    """Evaluate the corners with the linearisation: cheap, exact for small ranges. A few are solved to check it."""

    name = "first-order"

    def __call__(self, problem: SpreadProblem) -> Spread:
        """Return the spread over the corners, to first order."""
        return _by_blocks(problem, vertex_count(len(problem.ranges)), self._block)

    @staticmethod
    def _block(problem: SpreadProblem, linear: _Linear) -> Spread:
        signs = _corners(linear)
        offsets = linear.offsets(signs)
        poses, count = offsets.shape[:2]
        rows = np.arange(poses)[:, None]
        farthest = np.linalg.norm(offsets, axis=2).argmax(axis=1)
        tried = np.column_stack([farthest, np.tile(np.arange(0, count, -(-count // TRIED)), (poses, 1))])
        values = _per_pose(problem.middle + signs * problem.half_widths, poses)
        solved, _, ok = sampled(problem, values[rows, tried])
        nonlinearity = _nonlinearity(solved - linear.start[:, None], offsets[rows, tried], ok)
        every = np.ones((poses, count), dtype=bool)
        points = linear.start[:, None] + offsets
        found = _gathered(problem, linear, values, points, linear.turns(problem, signs), every, nonlinearity)
        return replace(found, unsolved=(~ok).sum(axis=1))


@dataclass(frozen=True)
class MonteCarlo:
    """Solve random samples: uniform in a range, normal where it has a standard deviation; the same at each pose."""

    name = "monte-carlo"
    samples: int = 100_000
    seed: int = 0

    def __post_init__(self) -> None:
        """Reject a number of samples or a seed out of range."""
        if not 100 <= self.samples <= 10_000_000:
            raise InputError(f"samples = {self.samples}: from 100 to 10 000 000 are allowed")
        if self.seed < 0:
            raise InputError(f"seed = {self.seed}: at least 0 is expected")

    def __call__(self, problem: SpreadProblem) -> Spread:
        """Return the spread of the samples."""
        values = drawn(problem.ranges, self.samples, self.seed)
        return _by_blocks(problem, self.samples, partial(self._block, values=values))

    @staticmethod
    def _block(problem: SpreadProblem, linear: _Linear, values: Array) -> Spread:
        points, turns, ok = sampled(problem, values)
        deviation = _deviation(points, ok)
        errors = np.sort(np.where(ok, np.linalg.norm(points - linear.wanted[:, None], axis=2), np.inf), axis=1)
        likely = np.maximum(np.ceil(LIKELY * ok.sum(axis=1)).astype(np.int64) - 1, 0)
        errors[~ok.any(axis=1)] = np.nan
        expected = np.std(problem.departures(values) @ np.swapaxes(linear.per_unit, 1, 2), axis=1)
        total = np.linalg.norm(deviation, axis=1)
        nonlinearity = np.linalg.norm(deviation - expected, axis=1) / np.maximum(total, 1e-300)
        found = _gathered(problem, linear, values, points, turns, ok, nonlinearity)
        return replace(found, deviation=deviation, likely_error=errors[np.arange(len(errors)), likely])


def _per_pose(values: Array, poses: int) -> Array:
    """*values* (S, k), the same at each pose, or (N, S, k), as (N, S, k) without a copy."""
    return np.broadcast_to(values, (poses, *values.shape[-2:]))


def sampled(problem: SpreadProblem, values: Array) -> tuple[Array, Array, Mask]:
    """Solve the N poses of *problem* for S sets of *values*, (S, k) or (N, S, k), in blocks of bounded memory.

    Returns nozzle positions (N, S, 3), m, angles (N, S) from the wanted rotation, rad, and which were solved (N, S).
    """
    model, count = problem.nominal.model, values.shape[-2]
    values = _per_pose(values, len(problem.commanded))
    points, turns = np.empty((*values.shape[:2], 3)), np.zeros(values.shape[:2])
    ok = np.empty(turns.shape, dtype=bool)
    for row, each in _pieces(len(values), count):
        own = values[row, each]
        found = settled(problem.rows(row), own)
        points[row, each] = found.nozzle.reshape(*own.shape[:2], 3)
        ok[row, each] = found.ok.reshape(own.shape[:2])
        if model.n == 6:
            wanted = np.repeat(problem.wanted[row, 3:], own.shape[1], axis=0)
            turns[row, each] = angle_between(wanted, found.pose[:, 3:]).reshape(own.shape[:2])
    return points, turns, ok


def _pieces(poses: int, count: int) -> Iterator[tuple[slice, slice]]:
    """Blocks of poses and samples with at most SOLVES problems each."""
    rows = max(1, SOLVES // count)
    for row in range(0, poses, rows):
        for first in range(0, count, SOLVES):
            yield slice(row, row + rows), slice(first, first + SOLVES)


def settled(problem: SpreadProblem, values: Array) -> Equilibrium:
    """Return the equilibria (N * S) for *values* (N, S, k), pose by pose, from the nominal ones."""
    places, each, k = values.shape
    base = problem.nominal
    packed = base.packed
    if len(packed.lines) > 1:
        packed = rows_of(packed, np.repeat(np.arange(places), each))
    lengths = np.repeat(problem.commanded, each, axis=0)
    parameters = [one.parameter for one in problem.ranges]
    values = values.reshape(-1, k)
    nominal = [each.nominal for each in problem.ranges]
    lengths = lengths + (values - nominal) @ zeroing(problem.ranges, base.model.m)
    changed, paid_out = varied(base.model.robot, packed, parameters, values, lengths)
    return solve_again(base, changed, paid_out, each)


@dataclass(frozen=True, eq=False)
class _Linear:
    """First order at N poses: the nozzle where all parameters are nominal, and its motion with each parameter."""

    start: Array  # (N, 3) m, nominal position
    wanted: Array  # (N, 3) m, commanded position
    per_unit: Array  # (N, 3, k) motion of the nozzle per unit of each parameter's departure
    shifted: Array  # (N, 3) displacement at the middle between the ends of the ranges
    effects: Array  # (N, 3, k) displacement by half of each range
    rotation: Array  # (N, 3, k) rotation of the platform by half of each range, rad
    rotation_shifted: Array  # (N, 3) rotation at the middle between the ends, rad

    @classmethod
    def of(cls, problem: SpreadProblem) -> _Linear:
        """Linearise at the problem's nominal equilibria."""
        nominal = problem.nominal
        motion = range_response(nominal, problem.ranges)
        translation, rotation = at_nozzle(nominal, motion), motion[:, 3:]
        low, high = problem.departures(np.array([[each.low, each.high] for each in problem.ranges]).T)
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
        """Return deviations (N, S, 3) at the corners *signs*, (S, k) or (N, S, k)."""
        return self.shifted[:, None] + signs @ np.swapaxes(self.effects, 1, 2)

    def turns(self, problem: SpreadProblem, signs: Array) -> Array:
        """Return angles (N, S) from the commanded rotation at the corners *signs*; valid for small angles."""
        if problem.nominal.model.n == 3:
            return np.zeros((len(self.start), signs.shape[-2]))
        turned = self.rotation_shifted[:, None] + signs @ np.swapaxes(self.rotation, 1, 2)
        away = turn_between(problem.wanted[:, 3:], problem.nominal.pose[:, 3:])
        return np.asarray(np.linalg.norm(turned + away[:, None], axis=2))


def corner_values(problem: SpreadProblem) -> Array:
    """Return values (S, k) at the corners of the box that `Vertices` solves, for a problem of one pose."""
    signs = _corners(_Linear.of(problem))
    if signs.ndim == 3:
        signs = np.unique(signs[0], axis=0)
    return problem.middle + signs * problem.half_widths


def _corners(linear: _Linear) -> Array:
    """Signs of the corners to evaluate: (S, k) for all, or (N, S, k) where first order has selected some."""
    k = linear.effects.shape[2]
    return signs_of_box(k) if k <= ALL_VERTICES else np.stack([extreme_signs(one) for one in linear.effects])


def _sigmas(problem: SpreadProblem) -> Array:
    """Standard deviations (k,) of the parameters' departures."""
    columns = []
    for each in problem.ranges:
        if each.deviation is None:
            columns.append(each.low + QUANTILES * (each.high - each.low))
        else:
            normal = NormalDist(each.nominal, each.deviation)
            below, above = normal.cdf(each.min_value), normal.cdf(each.max_value)  # impossible values are drawn again
            columns.append(np.array([normal.inv_cdf(below + u * (above - below)) for u in QUANTILES]))
    return np.asarray(problem.departures(np.column_stack(columns)).std(axis=0))


def drawn(ranges: Sequence[Range], samples: int, seed: int) -> Array:
    """Return samples (S, k) of *ranges*.

    A normal one that is physically impossible, such as a negative radius, is drawn again.
    """
    rng = np.random.default_rng(seed)
    found = np.empty((samples, len(ranges)))
    for column, each in zip(found.T, ranges, strict=True):
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
                f"{each.parameter.label}: a standard deviation of {each.deviation:g} gives mostly impossible values; "
                f"give a smaller one"
            )
    return found


def _by_blocks(problem: SpreadProblem, count: int, block: Callable[[SpreadProblem, _Linear], Spread]) -> Spread:
    """All poses by *block*, in blocks as large as SOLVES allows with *count* solves each."""
    poses, rows = len(problem.commanded), max(1, SOLVES // count)
    found = []
    for first in range(0, max(1, poses), rows):
        problem.progress("solving", first, poses)
        part = problem.rows(slice(first, first + rows))
        found.append(block(part, _Linear.of(part)))
    problem.progress("solving", poses, poses)
    return Spread(*(np.concatenate([getattr(one, each.name) for one in found]) for each in fields(Spread)))


def _gathered(
    problem: SpreadProblem,
    linear: _Linear,
    values: Array,
    points: Array,
    turns: Array,
    ok: Mask,
    nonlinearity: Array,
) -> Spread:
    """The spread of nozzle positions *points* (N, S, 3), of which those that are not *ok* (N, S) are left out."""
    errors = points - linear.wanted[:, None]
    size = np.linalg.norm(errors, axis=2)
    worst = np.where(ok, size, -1.0).argmax(axis=1)
    rows = np.arange(len(worst))
    known = np.asarray(ok.any(axis=1))[:, None]
    return Spread(
        max_error=_largest(size, ok),
        worst=np.where(known, points[rows, worst], np.nan),
        worst_values=np.where(known, _per_pose(values, len(worst))[rows, worst], np.nan),
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
    """Largest distance of *expected* from found *offsets* (N, S, 3), as a share of the largest offset."""
    largest = _largest(np.linalg.norm(offsets, axis=2), ok)
    return _largest(np.linalg.norm(offsets - expected, axis=2), ok) / np.maximum(largest, 1e-300)


def _largest(values: Array, ok: Mask) -> Array:
    """Largest (N, ...) of values (N, S, ...) along S where *ok* (N, S); NaN where none is."""
    wide = ok.reshape(*ok.shape, *(1,) * (values.ndim - 2))
    largest = np.max(values, axis=1, where=wide, initial=-np.inf)
    return np.where(np.isfinite(largest), largest, np.nan)


def _deviation(points: Array, ok: Mask) -> Array:
    """Standard deviation (N, 3) of points (N, S, 3) where *ok* (N, S); NaN where none is."""
    some = np.asarray(ok.any(axis=1))[:, None]
    counted = np.asarray(ok | ~some)[..., None]  # all points where none is ok: no division by zero
    return np.where(some, np.std(points, axis=1, where=counted), np.nan)
