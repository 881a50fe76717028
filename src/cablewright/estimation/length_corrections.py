"""Corrections of lengths learnt at measured positions: by line its length error, more creep, and mount compliance.

Of a line x are its share s of the length, its further creep c, 1/N, after an hour, and the further compliance e of its
mount, m/N. Paid out is (s + c M) L more than was counted, with M, N, what the cable remembers of its tensions
(`models.creep`, by the law of the file, or logarithmic), and mounts give by e more than in the file, in the statics. So
what creeps and gives follows each line's tension, also where nothing was measured.

A place measured is linear in x by the equilibrium's linearisation, and x is one weighted least squares of the last
places with the priors, in sequence over them (Kalman 1960), as s drifts in between. All of them are linearised again
where that arrives (Gauss and Newton): opposing lines share the error that one place leaves open, and deflect by it.
Older places are a prior for these. Creep and compliance are not negative: the used x is the nearest, by the covariance,
for which none is (Simon 2010). Combinations that places do not distinguish keep their prior, and the covariance shows
it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import astuple, dataclass, field, replace
from typing import Final

import numpy as np

from cablewright.estimation.kalman.state import kalman_update
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import AnswerError, InputError, require_positive
from cablewright.foundation.saved_state import SavedRows
from cablewright.kernels import layout
from cablewright.kernels.layout import Packed
from cablewright.models.creep import HOUR, CreepMemory, hour_compliance, memory_of
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot.cable import Creep
from cablewright.robot.mount import compliance_matrix
from cablewright.robot.parameters import Parameter
from cablewright.solvers.forward import solve_again, solve_forward
from cablewright.solvers.linearise import linearise
from cablewright.solvers.parameter_effects import mount_lengths, response

SHARE, CREEP, MOUNT = range(3)
"""Unknowns of a line: share of its length, further creep after an hour, 1/N, further compliance of its mount, m/N."""

KEPT: Final = 16
"""Places at most that are linearised again with each new one: of four visits of four."""

_UNKNOWNS: Final = 3
_ITERATIONS: Final = 10
_SHARES: Final = (1.0, 0.5, 0.25, 0.125)  # of a step, where lines would not be held after the whole of it
_SETTLED: Final = 1e-3  # of a standard deviation
_ASSUMED: Final = Creep(logarithmic=1e-6)  # of cables without a creep law: its size does not count


@dataclass(frozen=True)
class LengthPriors:
    """Standard deviations of length errors before any position is measured: assumed, not fitted to a machine.

    ``place``: m, of a measured position in each coordinate. ``share``: error of a line's length, as a share of it.
    ``creep``: creep of the length after an hour under the mean tension of all lines at the start. ``mount``: compliance
    of the mount, m/N. ``drift``: random walk of the length in an hour. ``scatter``: error of the length that is new at
    each position, by hysteresis and friction. ``radius``, m, and ``turns``: of the winding, see
    `machine.settings.WinchSettings`.
    """

    place: float
    share: float = 2e-3  # more than cables creep: docs/estimation.md
    creep: float = 2e-3  # likewise
    mount: float = 1e-5  # what the severity rough has: a mast that gives 1 cm under 1 kN
    drift: float = 2e-4  # a tenth of all that creeps, which a wrong law leaves; 16 K of steel
    scatter: float = 2.5e-4  # half of a loop of the severity rough
    radius: float = 0.0
    turns: float = 1.0

    def __post_init__(self) -> None:
        """Raise `InputError` for a number below 0, or no turns."""
        for name, value in vars(self).items():
            if not 0.0 <= value < math.inf:
                raise InputError(f"{name} = {value:g}: must be a finite number from 0 on")
        require_positive(turns=self.turns)


@dataclass(frozen=True, eq=False)
class MeasuredPlace:
    """A measured position: *place* (3,), m, at *time*, s, with lengths *counted* (m,), m.

    ``remembered`` (m,): N, by cables of their tensions; ``rotation`` (m,): rad, paid out.
    """

    counted: Array
    place: Array
    remembered: Array
    rotation: Array
    time: float


@dataclass(eq=False)
class LearntValues:
    """Estimated length errors, creep and mount compliance of m lines, by positions measured up to ``since``, s.

    Changed in place.
    """

    SAVED = ("values", "covariance", "since", "rotation")

    values: Array  # (m, 3)
    covariance: Array  # (3 m, 3 m)
    rotation: Array  # (m,) rad, paid out by ``since``
    since: float = -math.inf

    @property
    def sigmas(self) -> Array:
        """Standard deviations (m, 3) of the learnt share, creep and mount compliance of each line."""
        return np.asarray(np.sqrt(np.diag(self.covariance)).reshape(self.values.shape))

    def copy(self) -> LearntValues:
        """Return a copy of the learnt values that can be changed."""
        return LearntValues(self.values.copy(), self.covariance.copy(), self.rotation.copy(), self.since)


@dataclass(eq=False)
class LearntLengths:
    """The current corrections of the lengths of m lines, learnt at measured positions.

    Changed in place. Rotations count from 0 where state is loaded.
    """

    SAVED = ("memory", "before", "known", SavedRows("place_rows", KEPT), "counted", "rotation")

    priors: LengthPriors
    memory: CreepMemory
    hour: Array  # (m,) 1/N, creep after an hour by the law of the memory
    least: Array  # (m, 3), of the values: cables that do not creep, mounts that do not give; -inf: no bound
    before: LearntValues  # without the places that are kept
    known: LearntValues
    counted: Array  # (m,) m, out at the last step, without what was learnt
    rotation: Array  # (m,) rad, paid out by then
    places: list[MeasuredPlace] = field(default_factory=list)  # at most KEPT

    @classmethod
    def of(cls, priors: LengthPriors, model: Model, tensions: Array) -> LearntLengths:
        """Return the corrections before any position is measured: *priors* alone; *tensions* (m,), N, at the start."""
        lines = model.robot.lines
        laws = [_law_of(line.cable.creep) for line in lines]
        memory, hour = memory_of(laws), np.array([hour_compliance(law) for law in laws])
        assert memory is not None  # since each line has a law
        mounts = np.array([compliance_matrix(line.exit_compliance or 0.0) for line in lines])
        creep = np.array([hour_compliance(line.cable.creep) for line in lines])
        softest = np.maximum(np.linalg.eigvalsh(mounts)[:, 0], 0.0)
        least = np.column_stack([np.full(model.m, -np.inf), -creep, -softest])
        sigma = np.tile([priors.share, priors.creep / float(tensions.mean()), priors.mount], model.m)
        before = LearntValues(np.zeros((model.m, _UNKNOWNS)), np.diag(sigma**2), np.zeros(model.m))
        return cls(priors, memory, hour, least, before, before.copy(), np.zeros(model.m), np.zeros(model.m))

    @property
    def place_rows(self) -> Array:
        """The measured positions (k, 3 m + 4), a row each of the attributes of `MeasuredPlace` in their order."""
        rows = [np.hstack(astuple(one)) for one in self.places]
        return np.array(rows).reshape(-1, 3 * len(self.hour) + 4)

    @place_rows.setter
    def place_rows(self, rows: Array) -> None:
        ends = np.cumsum([len(self.hour), 3, len(self.hour), len(self.hour)])
        parts = [np.split(row, ends) for row in rows]
        self.places = [MeasuredPlace(out, place, held, moved, float(at[0])) for out, place, held, moved, at in parts]

    def after_load(self) -> None:
        """Express the rotations of all places relative to the loaded rotation, which becomes 0."""
        for known in (self.before, self.known):
            known.rotation = known.rotation - self.rotation
        self.places = [replace(one, rotation=one.rotation - self.rotation) for one in self.places]
        self.rotation = np.zeros_like(self.rotation)

    @property
    def used(self) -> Array:
        """Learnt values (m, 3) that lengths and statics use, with compliance and creep not below 0."""
        found, covariance, least = self.known.values.ravel(), self.known.covariance, self.least.ravel()
        values, held = found, np.zeros(found.size, dtype=bool)
        while ((below := values < least) & ~held).any():
            held |= below
            rows = covariance[held]
            values = found - rows.T @ np.linalg.solve(rows[:, held], found[held] - least[held])
            values = np.where(held, least, values)
        return values.reshape(self.known.values.shape)

    @property
    def remembered(self) -> Array:
        """Tensions (m,), N, that the cables' creep remembers: the mean over about an hour."""
        return self.memory.strain / self.hour

    def longer(self, counted: Array) -> Array:
        """Return by how much lines exceed their *counted* lengths (m,), m: (m,), m, by the learnt corrections."""
        used = self.used
        return np.asarray((used[:, SHARE] + used[:, CREEP] * self.remembered) * counted)

    def given(self, held: Equilibrium) -> Array:
        """Return the length (m,), m, that mounts yield beyond the file's, in the equilibrium *held* of a row."""
        return np.asarray(self.used[:, MOUNT] * mount_lengths(held)[0])

    def packed(self, model: Model) -> Packed:
        """Return the kernel arrays of the *model* with the estimated compliance of mounts."""
        return _softened(model, self.used)

    def told(self, model: Model, measured: MeasuredPlace) -> Equilibrium:
        """Learn from a *measured* position: update the corrections; return the estimated equilibrium there.

        Raises `AnswerError` if there is no equilibrium.
        """
        known, places = self.known, list(self.places)
        self.places.append(measured)
        try:
            return self._learnt(model)
        except AnswerError:
            self.known, self.places = known, places
            raise

    def _learnt(self, model: Model) -> Equilibrium:
        """Update the corrections by the last measured positions again; return the equilibrium at the last position."""
        at, places = self.used, self.places
        held = solve_forward(model, [one.counted for one in places], guess=[one.place for one in places]).checked()
        held = _with_values(held, places, at)
        for _ in range(_ITERATIONS):
            rows, self.known = self._rows(held, at), self.before.copy()
            for one, row in zip(places, rows, strict=True):
                self._learn(self.known, one, *row)
            settled = (np.abs(self.used - at) <= _SETTLED * self.known.sigmas).all()
            held, at = self._towards(held, at)
            if settled:
                break
        there = _with_values(held[-1:], places[-1:], self.used)[0]
        if len(places) > KEPT:
            self._learn(self.before, places.pop(0), *rows[0])
        return there

    def _towards(self, held: Equilibrium, at: Array) -> tuple[Equilibrium, Array]:
        """Go from the values *at* (m, 3) of the equilibrium *held* to the known values, or as far as possible."""
        for share in _SHARES:
            goal = at + share * (self.used - at)
            with suppress(AnswerError):
                return _with_values(held, self.places, goal), goal
        raise AnswerError(
            "length corrections: no step towards those of the measured positions has an equilibrium at all of them; "
            "measure the positions again"
        )

    def _rows(self, held: Equilibrium, at: Array) -> list[tuple[Array, Array, Array]]:
        """Return a linear equation for each measured place: derivatives (3, 3 m), residual (3,), m, covariance (3, 3).

        The residual is the displacement of the place from the *held* equilibrium, whose values are *at* (m, 3).
        """
        linear = linearise(held)
        mounts = response(held, [Parameter("exit_compliance", line.name) for line in held.model.robot.lines], linear)
        rows = []
        for one, per_length, per_mount, pose in zip(self.places, linear.per_length, mounts, held.pose, strict=True):
            by_share = per_length * one.counted
            by_line = np.stack([by_share, by_share * one.remembered, per_mount], axis=-1).reshape(len(pose), -1)
            noise = self.priors.place**2 * np.eye(len(pose)) + self.priors.scatter**2 * by_share @ by_share.T
            rows.append((by_line, one.place - pose + by_line @ at.ravel(), noise))
        return rows

    def _learn(self, known: LearntValues, one: MeasuredPlace, per_unknown: Array, made: Array, noise: Array) -> None:
        """Let shares drift until a place, and add the displacement that it *made* to the *known* unknowns."""
        hours = max(one.time - known.since, 0.0) / HOUR if math.isfinite(known.since) else 0.0
        wound = winding(self.priors, np.abs(one.rotation - known.rotation) / math.tau) / one.counted
        shares = np.arange(SHARE, known.values.size, _UNKNOWNS)
        known.covariance[shares, shares] += self.priors.drift**2 * hours + wound**2
        innovation = made - per_unknown @ known.values.ravel()
        correction, known.covariance = kalman_update(known.covariance, per_unknown, innovation, noise)
        known.values = known.values + correction.reshape(known.values.shape)
        known.since, known.rotation = one.time, one.rotation


def _softened(model: Model, values: Array) -> Packed:
    """The arrays of the *model* with mounts that are more compliant by *values* (m, 3)."""
    lines = model.packed.lines.copy()
    lines[:, layout.MOUNT : layout.MOUNT + 3] += values[:, [MOUNT]]
    return model.packed._replace(lines=lines)


def _with_values(held: Equilibrium, places: Sequence[MeasuredPlace], values: Array) -> Equilibrium:
    """Return the equilibria at *places*, one of *held* each, with other *values* (m, 3). Raises `AnswerError`."""
    lengths = [one.counted * (1.0 + values[:, SHARE] + values[:, CREEP] * one.remembered) for one in places]
    packed, rows = _softened(held.model, values), len(places)
    many = packed._replace(
        lines=np.repeat(packed.lines[None], rows, axis=0), platform=np.repeat(packed.platform[None], rows, axis=0)
    )
    return solve_again(held, many, np.array(lengths), 1).checked()


def winding(priors: LengthPriors, turns: Array) -> Array:
    """Return the standard deviation, m, of cable paid out in *turns* (m,) revolutions, by that of the drum's radius.

    That is a Gauss-Markov process over turns, and the cable its integral (Uhlenbeck and Ornstein 1930).
    """
    ratio = turns / priors.turns
    area = np.where(ratio < 1e-3, 0.5 * ratio**2, ratio + np.expm1(-ratio))  # a series where differences cancel
    return np.asarray(math.tau * priors.radius * priors.turns * np.sqrt(2.0 * area))


def _law_of(described: Creep | None) -> Creep:
    """Return the creep law of the file if it has any creep after an hour, otherwise the assumed law."""
    return described if described is not None and hour_compliance(described) > 0.0 else _ASSUMED
