"""Error of linear interpolation of lengths and tensions between two samples, and jumps of the solution."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from cablewright.analyses.feasibility import INTERPOLATION, LENGTH_JUMP, TENSION_JUMP, Finding, at_most
from cablewright.foundation.arrays import Array, Indices
from cablewright.foundation.memory_mapped import blocks, let_go
from cablewright.models.job_poses import INTERPOLATED
from cablewright.models.statics import Equilibrium, Model
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.checks.path_statics import PathStatics, extreme

MEASURED: Final = 512
"""Segments that are looked at: those where a straight line would be off most, and as many that change most."""

HALVINGS: Final = 10
"""How often a segment is halved around its largest change: one that is no jump falls to about a thousandth."""

JUMP: Final = 0.01
"""Change of a tension over the last of these halves that counts as a jump, as a share of the largest tension."""

SHARE: Final = 0.05
"""Share of the error that a job allows which the interpolation of lengths may take."""

CURVED: Final = 1.5
"""Interpolation error that is allowed, in units of that of straight lines: sag, stretch and sheaves add to it."""


class BetweenSamples:
    """The k samples of a path, and the equilibria of *poses* (k, n), *retraction* (k,), m, half-way between them."""

    def __init__(self, model: Model, poses: Array, statics: PathStatics, retraction: Array | None) -> None:
        self._model, self._poses, self._statics, self._retraction = model, poses, statics, retraction
        self._names = [line.name for line in model.robot.lines]
        self._scales = np.repeat([INTERPOLATED, JUMP * extreme(np.fmax, statics.tensions)], model.m)

    def findings(self, allowed: float) -> Iterator[Finding]:
        """Yield the interpolation error of lengths, m, and the largest jumps of a length and of a tension.

        Poses go linearly between samples too. The error of a straight line of length l is step^2 / (8 l) at most in
        each span. 1.5 times that is allowed, `INTERPOLATED`, or a twentieth of the error *allowed* by the job, m.
        """
        bent, changed = self._largest()
        if len(bent):
            yield from self._interpolation(np.union1d(bent, changed), allowed)
        if len(changed):
            yield from self._jumps(changed)

    def _largest(self) -> tuple[Indices, Indices]:
        """The segments between held samples, by the first of these, that bend most, and those that change most."""
        bent, changed = _Largest(), _Largest()
        for at in blocks(len(self._poses) - 1):
            ends = slice(at.start, at.stop + 1)
            held = self._statics.codes[ends] == 0
            step, lengths = _steps(self._poses[ends]), np.where(held[:, None], self._statics.lengths[ends], np.nan)
            bent.take(at.start, np.where(step > 0.0, step**2 / np.minimum(lengths[1:], lengths[:-1]).min(axis=1), 0.0))
            beyond = lengths - self._statics.rigid_lengths[ends]
            changes = np.diff(self._scaled(beyond, self._statics.tensions[ends]), axis=0)
            changed.take(at.start, np.where(held[1:] & held[:-1], _size(changes), 0.0))
            let_go((self._poses, self._statics))
        return bent.rows, changed.rows

    def _interpolation(self, segments: Indices, allowed: float) -> Iterator[Finding]:
        """Yield the largest error of a length half-way along *segments*; nothing where none is held."""
        held = self._held(segments, np.full(len(segments), 0.5))
        between = 0.5 * (self._statics.lengths[segments] + self._statics.lengths[segments + 1])
        off = np.where(held.ok[:, None], np.abs(held.lengths - between), np.nan)
        chords = np.linalg.norm(held.platform_points - held.lines.exit_point, axis=2)
        step = _steps(self._poses[np.stack([segments, segments + 1], axis=1)].swapaxes(0, 1))[0]
        straight = float(np.nanmax(held.lines.spans * (step**2)[:, None] / (8.0 * chords)))
        bound = max(CURVED * straight, INTERPOLATED, SHARE * allowed)
        yield from self._placed(at_most(INTERPOLATION, "m", off, bound, self._names), segments)

    def _jumps(self, segments: Indices) -> Iterator[Finding]:
        """Yield the changes that stay while each of *segments* is halved around its largest change."""
        statics, ends = self._statics, (segments, segments + 1)
        low, high = np.zeros((len(segments), 1)), np.ones((len(segments), 1))
        begin, end = (statics.rigid_lengths[each] for each in ends)
        first, last = (
            self._scaled(statics.lengths[at] - statics.rigid_lengths[at], statics.tensions[at]) for at in ends
        )
        for _ in range(HALVINGS):
            share = 0.5 * (low + high)
            held = self._held(segments, share[:, 0])
            middle = self._scaled(held.lengths - begin - share * (end - begin), held.tensions)
            earlier = (_size(middle - first) > _size(last - middle))[:, None]
            low, high = np.where(earlier, low, share), np.where(earlier, share, high)
            first, last = np.where(earlier, first, middle), np.where(earlier, middle, last)
        changes = np.abs(last - first) * self._scales
        m = self._model.m
        for limit, unit, columns in ((LENGTH_JUMP, "m", slice(m)), (TENSION_JUMP, "N", slice(m, None))):
            allowed = float(self._scales[columns][0])
            yield from self._placed(at_most(limit, unit, changes[:, columns], allowed, self._names), segments)

    def _held(self, segments: Indices, share: Array) -> Equilibrium:
        """What holds the poses at a *share* (s,) of the way along *segments* (s,)."""
        begin, end = self._poses[segments], self._poses[segments + 1]
        retracted = None
        if self._retraction is not None:
            retracted = self._retraction[segments] * (1.0 - share) + self._retraction[segments + 1] * share
        return solve_inverse(self._model, begin + share[:, None] * (end - begin), retraction=retracted)

    def _scaled(self, beyond: Array, tensions: Array) -> Array:
        """Lengths *beyond* straight ones and tensions (..., m), in units of the jump that counts, (..., 2 m)."""
        return np.asarray(np.concatenate([beyond, tensions], axis=-1) / self._scales)

    def _placed(self, findings: list[Finding], segments: Indices) -> Iterator[Finding]:
        """Yield findings whose samples are the ends of *segments*."""
        return (replace(each, sample=int(segments[each.sample]) + 1) for each in findings)


class _Largest:
    """The rows with the largest values of all that were taken."""

    def __init__(self) -> None:
        self.rows, self._values = np.zeros(0, np.intp), np.zeros(0)

    def take(self, first: int, values: Array) -> None:
        """Include the *values* of the rows from the *first* on in the maximum; NaN is ignored."""
        rows = np.concatenate([self.rows, first + np.arange(len(values))])
        values = np.concatenate([self._values, np.nan_to_num(values)])
        kept = np.argsort(-values, kind="stable")[:MEASURED]
        kept = kept[values[kept] > 0.0]
        self.rows, self._values = rows[kept], values[kept]


def _steps(poses: Array) -> Array:
    """Distances between neighbouring poses, m, along the first axis."""
    return np.asarray(np.linalg.norm(np.diff(poses[..., :3], axis=0), axis=-1))


def _size(changes: Array) -> Array:
    """The largest of each row of *changes* (k, c); what is not known counts as nothing."""
    return np.asarray(np.nan_to_num(np.abs(changes)).max(axis=1))
