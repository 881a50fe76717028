"""The error of the nozzle that is expected along a job when the robot's numbers are uncertain.

The uncertain numbers are drawn once for the whole job: they are biases of a machine, not noise. Of each drawn machine
the largest distance of the nozzle from its path counts; of all machines the 95th percentile. Each machine is solved, at
as many samples as it takes until more do not change the result. Linear interpolation of the lengths between two samples
adds to the distance. Moves that lay no material do not count.

The path's box is divided into `CELLS` cells a side, and the sample with the largest root mean square error, to first
order, represents its cell. A few machines are solved in all cells: they give the error of first order in each. With
this, each machine has its own order of cells, and is solved in the first of them. A machine without a sound equilibrium
in one of these is beyond any distance.

The same uncertain numbers give the error of tensions at rest, to first order and with lengths alone: a print that
measures tensions holds redundant ones nearer.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Final

import numpy as np

from cablewright.analyses.accuracy.spread import SpreadProblem, drawn, sampled
from cablewright.foundation.arrays import Array, Indices
from cablewright.foundation.memory_mapped import blocks
from cablewright.foundation.results import Figure
from cablewright.foundation.units import spell_length
from cablewright.kernels.layout import LENGTH
from cablewright.models.batch_rows import Rows, joined
from cablewright.models.statics import Equilibrium
from cablewright.printing.path import Samples
from cablewright.robot.uncertainty import Range
from cablewright.solvers.linearise import Linearisation, tension_changes
from cablewright.solvers.parameter_effects import at_nozzle, departures, range_response, range_tension_response

CELLS: Final = 12
DRAWS: Final = 4000
SCOUTS: Final = 64
"""Machines that are solved in all cells."""

FIRST: Final = 2
"""Cells in which each machine is solved first; then in twice as many more, and so on."""

SETTLED: Final = 0.005
"""Share of the result by which it may grow in the last cells, for no more to be solved."""

LEVEL: Final = 0.95
_DEVIATIONS: Final = 1.96
"""Standard deviations within which 95 of 100 machines have a tension: a sum of many small departures."""

BLOCK: Final = 64  # cells evaluated in one call
TINY: Final = 1e-12  # m: errors to first order that are smaller are taken as this
INTERPOLATION: Final = "interpolation"
"""Name of the cause that is no number of the robot: lengths are interpolated between samples."""

REMEDIES: Final = {
    "exit_point": "survey or calibrate the exit points",
    "platform_point": "measure or calibrate the platform points",
    "modulus": "measure the moduli of the cables",
    "sheave_radius": "measure the sheaves",
    "linear_density": "weigh the cables",
    "length_offset": "home the lines better, or calibrate their lengths",
    "length_scale": "calibrate the scale of the lengths",
    "counterweight": "weigh the counterweights",
    "creep_compliance": "home the lines again as they creep, or preload the cables before the job",
    "exit_compliance": "calibrate or stiffen the mounts of the exit points",
    "temperature": "compensate the temperature of the cables",
    "mass": "weigh the platform",
    "centre_of_mass": "measure the centre of mass",
    "force": "measure the force on the platform",
    "moment": "measure the moment on the platform",
    INTERPOLATION: "give the job a shorter sampling.step",
}
"""What makes the uncertain numbers of a kind more certain."""


@dataclass(frozen=True)
class ErrorCause:
    """A cause of the expected error: uncertain parameters of one kind, or lengths interpolated between samples."""

    name: str  # in the registry, without the axis; or `INTERPOLATION`
    share: float  # of the mean square error at the worst sample
    without: float  # m, the expected error if these numbers were exact

    @property
    def words(self) -> str:
        """Name of the cause of error, as tables print it."""
        return "interpolation between samples" if self.name == INTERPOLATION else self.name.replace("_", " ")

    FIGURES: ClassVar = (
        Figure("cause", "", "Kind of the uncertain numbers, or interpolation of the lengths between samples.",
               "name", "cause"),
        Figure("share", "1", "Share of the mean square error at the worst sample.", digits=2, shown="%"),
        Figure("without", "m", "Expected error if these numbers were exact.", name="expected error without", digits=3,
               shown="mm"),
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class ExpectedError:
    """The expected error of the nozzle over a job with k samples."""

    value: float  # m: 95 of 100 machines keep the nozzle this near to all of the path; NaN where it is not stated
    sample: int | None  # with the largest root mean square error
    rms: Array  # (k,) m, root mean square error, to first order; NaN where it is unknown or was not requested
    causes: tuple[ErrorCause, ...]  # largest share first
    ranges: tuple[Range, ...]
    curvature: float  # how much larger it is than to first order, as a share; NaN if it is not stated
    unsolved: int  # drawn machines without a sound equilibrium at some sample
    tensions: (
        Array  # (m, 2) N: between which those at rest of each line are expected on the path; (1, 2) NaN: not known
    )

    @property
    def unknown(self) -> str:
        """Reason why the expected error is not stated; empty if it is stated, or no sample is known."""
        if self.sample is None or np.isfinite(self.value):
            return ""
        return f"{self.unsolved} of {DRAWS} drawn machines have no sound equilibrium somewhere on the path"

    @property
    def notes(self) -> tuple[str, ...]:
        """Remedies that would reduce the error, and cautions on the figures."""
        if self.unknown:
            return (f"expected error is not stated: {self.unknown}",)
        notes = []
        if self.causes and self.value > 0.0:
            most = self.causes[0]
            notes.append(
                f"{100.0 * most.share:.0f} % of the expected error is by {most.words}: {REMEDIES[most.name]}; exact "
                f"numbers would leave {spell_length(most.without)}"
            )
        if self.unsolved:
            notes.append(
                f"expected error: {self.unsolved} of {DRAWS} drawn machines have no sound equilibrium somewhere on "
                "the path and count as beyond it"
            )
        return tuple(notes)


@dataclass(frozen=True, eq=False)
class _Cells(Rows):
    """The samples that represent c cells."""

    SINGLE: ClassVar = ("cell", 0)

    cell: Indices  # (c,)
    sample: Indices  # (c,)
    rms: Array  # (c,) m
    effects: Array  # (c, 3, p) displacement per departure
    offsets: Array  # (c, 3) m, by interpolation
    held: Equilibrium  # c rows

    def with_worse(self, other: _Cells | None) -> _Cells:
        """Return the cells with, in each, the sample of larger error: its own or that of the *other* cells."""
        both = self if other is None else joined(other, self)
        order = np.lexsort((both.rms, both.cell))
        return both[order[np.append(np.flatnonzero(np.diff(both.cell[order])), len(order) - 1)]]

    def straight(self, departures: Array, numbers: Array | slice = slice(None), *, interpolated: bool = True) -> Array:
        """Return errors (c, S), m, to first order, of machines with *departures* (S, p) of *numbers* (p,) alone."""
        effects, drawn_values = self.effects[:, :, numbers], departures[:, numbers].T
        offsets, errors = self.offsets * interpolated, np.empty((len(effects), len(departures)))
        for at in blocks(len(effects), BLOCK):
            errors[at] = np.linalg.norm(effects[at] @ drawn_values + offsets[at, :, None], axis=1)
        return errors

    def solved(self, ranges: tuple[Range, ...], values: Array, zero: Array) -> Array:
        """Return the errors (c, S), m, of machines with *values* (S, p) or (c, S, p); infinite where a solve fails.

        *zero* (S, 3) or (c, S, 3), m: error of each machine where its lines were zeroed; NaN where a solve fails.
        """
        points, _, ok = sampled(SpreadProblem(self.held, self.held.lengths, self.held.pose, ranges), values)
        errors = np.linalg.norm(points - (self.held.nozzle - self.offsets)[:, None] - zero, axis=2)
        return np.where(ok & np.isfinite(errors), errors, np.inf)


class ExpectedErrorSearch:
    """The search for the largest expected error along a job's samples, which come block by block."""

    def __init__(self, ranges: Sequence[Range], samples: Samples, seed: int, zero: Equilibrium | None = None) -> None:
        """Draw the machines for the path of these *samples*; those that lay material count, or all if none does.

        *zero*: the solved row where coordinates count from, whose nozzle each machine takes for that; None: the frame.
        """
        self._ranges, self._positions = tuple(ranges), samples.positions
        self._counts = samples.extruding if samples.extruding.any() else np.ones(len(samples), dtype=bool)
        self._parameters = [each.parameter for each in ranges]
        self._values = drawn(self._ranges, DRAWS, seed)
        nominal = np.array([each.nominal for each in ranges])
        self._departures = departures(self._parameters, nominal, self._values)  # (S, p)
        self._mean_square = np.mean(self._departures**2, axis=0)
        self._rms = np.full(len(samples), np.nan)
        self._low = self._positions.min(axis=0)
        self._pitch = np.maximum(np.ptp(self._positions, axis=0), 1e-9) / CELLS
        self._cells: _Cells | None = None
        self._zero, self._zero_effects = np.zeros((DRAWS, 3)), np.zeros((3, len(ranges)))
        if zero is not None:
            points, _, ok = sampled(SpreadProblem(zero, zero.lengths, zero.pose, self._ranges), self._values)
            self._zero = np.where(ok[0, :, None], points[0] - zero.nozzle, np.nan)
            self._zero_effects = at_nozzle(zero, range_response(zero, ranges))[0]
        self._tensions: list[Array] = []  # (m, 2) N, of each block

    def take(self, samples: Indices, held: Equilibrium, linear: Linearisation) -> None:
        """Add solved *samples* of the path, their equilibria *held* and the linearisation there."""
        count = self._counts[samples]
        if not count.any():
            return
        samples, held, linear = samples[count], held[count], linear[count]
        moved = range_response(held, self._ranges, linear)
        effects = at_nozzle(held, moved) - self._zero_effects
        off = range_tension_response(held, self._ranges, moved, tension_changes(held))
        apart = _DEVIATIONS * np.sqrt(off**2 @ self._mean_square)
        self._tensions.append(np.stack([(held.tensions - apart).min(0), (held.tensions + apart).max(0)], axis=-1))
        offsets = self._interpolation(samples, held, linear)
        rms = np.sqrt((effects**2).sum(axis=1) @ self._mean_square + (offsets**2).sum(axis=1))
        self._rms[samples] = rms
        self._cells = _Cells(self._cell(samples), samples, rms, effects, offsets, held).with_worse(self._cells)

    def _cell(self, samples: Indices) -> Indices:
        """The cell of each sample (s,)."""
        place = ((self._positions[samples] - self._low) / self._pitch).astype(np.intp).clip(0, CELLS - 1)
        return np.asarray(place @ np.array([CELLS * CELLS, CELLS, 1]))

    def _interpolation(self, samples: Indices, held: Equilibrium, linear: Linearisation) -> Array:
        """Displacement (s, 3), m, midway from the sample before, where lengths are interpolated linearly.

        The length l of a straight line in direction u has the second derivative (1 - (u . t)^2) / l along a path of
        tangent t. Midway over a step h the interpolated length is too long by h^2 / 8 of it, in each span.
        """
        step = self._positions[samples] - self._positions[np.maximum(samples - 1, 0)]
        lines = held.platform_points - held.model.lines.exit_point
        length = np.linalg.norm(lines, axis=2)
        along = np.einsum("smc,sc->sm", lines, step) / length
        too_long = ((step**2).sum(axis=1)[:, None] - along**2) / (8.0 * length) * held.model.lines.spans
        motion = np.einsum("snm,sm->sn", linear.motion[..., LENGTH], too_long)
        return at_nozzle(held, motion[:, :, None])[:, :, 0]

    def result(self) -> ExpectedError:
        """Return the expected error of all samples that were added."""
        cells = self._cells
        if cells is None:
            return ExpectedError(np.nan, None, self._rms, (), self._ranges, np.nan, 0, np.full((1, 2), np.nan))
        worst = int(cells.rms.argmax())
        largest = self._largest(cells)
        value = float(_percentile(largest))
        value = value if np.isfinite(value) else np.nan
        straight = _error(cells.straight(self._departures))
        ratio = value / straight if straight > 0.0 else 1.0
        found = sorted(self._causes(cells, worst), key=lambda cause: -cause.share)
        causes = tuple(replace(cause, without=ratio * cause.without) for cause in found)
        unsolved = int(np.isinf(largest).sum())
        low, high = np.moveaxis(np.array(self._tensions), -1, 0)
        tensions = np.stack([low.min(axis=0), high.max(axis=0)], axis=-1)
        sample = int(cells.sample[worst])
        return ExpectedError(value, sample, self._rms, causes, self._ranges, ratio - 1.0, unsolved, tensions)

    def _largest(self, cells: _Cells) -> Array:
        """The largest error (S,), m, of each machine, solved in more and more cells until that changes little."""
        straight = cells.straight(self._departures)
        scouts = _percentile(cells.solved(self._ranges, self._values[:SCOUTS], self._zero[:SCOUTS]))
        bent = scouts / np.maximum(_percentile(straight[:, :SCOUTS]), TINY)
        ranks = np.argsort(-straight * bent[:, None], axis=0, kind="stable").T  # (S, c)
        largest, first, count = np.zeros(len(ranks)), 0, FIRST
        while first < len(cells):
            before = _percentile(largest)
            chosen = ranks[:, first : first + count]
            machines, zero = (np.repeat(each, chosen.shape[1], axis=0)[:, None] for each in (self._values, self._zero))
            errors = cells[chosen.ravel()].solved(self._ranges, machines, zero).reshape(chosen.shape)
            largest = np.maximum(largest, errors.max(axis=1))
            first, count = first + count, 2 * count
            if _percentile(largest) <= (1.0 + SETTLED) * before or np.isinf(_percentile(largest)):
                break
        return largest

    def _causes(self, cells: _Cells, worst: int) -> Iterator[ErrorCause]:
        """Yield the causes; *worst* is the cell of the worst sample."""
        by_number = (cells.effects[worst] ** 2).sum(axis=0) * self._mean_square
        fixed = float((cells.offsets[worst] ** 2).sum())
        total = float(by_number.sum()) + fixed or 1.0
        names = np.array([each.entry.base for each in self._parameters])
        for name in dict.fromkeys(names.tolist()):
            share = float(by_number[names == name].sum()) / total
            yield ErrorCause(name, share, _error(cells.straight(self._departures, names != name)))
        yield ErrorCause(INTERPOLATION, fixed / total, _error(cells.straight(self._departures, interpolated=False)))


def _error(errors: Array) -> float:
    """The 95th percentile of the largest *errors* (c, S), m, of machines."""
    return float(_percentile(errors.max(axis=0)))


def _percentile(values: Array) -> Array:
    """The smallest of *values* (..., S) that `LEVEL` of them do not exceed, (...)."""
    return np.asarray(np.sort(values, axis=-1)[..., int(np.ceil(LEVEL * values.shape[-1])) - 1])
