"""The error of the nozzle that is expected along a job when the robot's numbers are uncertain.

The uncertain numbers are drawn once for the whole job: they are biases of a machine, not noise. Of each drawn machine
the largest distance of the nozzle from its path counts; of all machines the 95th percentile. The distance is of first
order in the numbers, enlarged where all draws, solved at the worst sample, give more. It contains what linear
interpolation of the lengths between two samples adds. Moves that lay no material do not count.

The largest distance is sought at some hundreds of samples: the path's box is divided into `CELLS` cells a side, and the
sample with the largest root mean square error stands for its cell. The linearisation changes little within a cell.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Final

import numpy as np

from cablewright.analyses.accuracy.spread import SpreadProblem, drawn, sampled
from cablewright.arrays import Array, Indices
from cablewright.kernels.layout import LENGTH
from cablewright.models.statics import Equilibrium
from cablewright.printing.path import Samples
from cablewright.results import Figure
from cablewright.robot.uncertainty import Range
from cablewright.solvers.linearise import Linearisation
from cablewright.solvers.parameters import at_nozzle, departures, response
from cablewright.units import spell_length

CELLS: Final = 12
DRAWS: Final = 4000
LEVEL: Final = 0.95
BLOCK: Final = 64  # cells evaluated at once
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

TOO_CURVED: Final = 0.1
"""Share of the expected error by which first order may be off before a note says so."""


@dataclass(frozen=True)
class Cause:
    """Uncertain numbers of one kind, or the interpolation between samples."""

    name: str  # in the registry, without the axis; or `INTERPOLATION`
    share: float  # of the mean square error at the worst sample
    without: float  # m, the expected error if these numbers were exact

    @property
    def words(self) -> str:
        """What people call it."""
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
    """The expected error of a job with k samples."""

    value: float  # m: 95 of 100 machines keep the nozzle this near to all of the path; NaN where no sample is known
    sample: int | None  # with the largest root mean square error
    rms: Array  # (k,) m, root mean square error; NaN where it is not known or not asked for
    causes: tuple[Cause, ...]  # largest share first
    ranges: tuple[Range, ...]
    curvature: float  # how much larger the error is at that sample if all draws are solved, as a share; NaN if none is
    unsolved: int  # draws without an equilibrium at that sample
    unknown: str = ""  # why the value is not known, though samples are

    @property
    def notes(self) -> tuple[str, ...]:
        """What would reduce it, and what to know before the figures are used."""
        notes = []
        if self.causes and self.value > 0.0:
            most = self.causes[0]
            notes.append(
                f"{100.0 * most.share:.0f} % of the expected error is by {most.words}: {REMEDIES[most.name]}; exact "
                f"numbers would leave {spell_length(most.without)}"
            )
        if abs(self.curvature) > TOO_CURVED:
            notes.append(
                f"expected error: first order is off by {abs(100.0 * self.curvature):.2g} % at its worst sample; "
                "accuracy --path --method monte-carlo solves drawn machines everywhere"
            )
        if self.unsolved:
            notes.append(
                f"expected error: at its worst sample {self.unsolved} of {DRAWS} drawn machines have no sound "
                "equilibrium and are left out"
            )
        return tuple(notes)


class ExpectedErrorSearch:
    """The search along a job's samples, which come block by block."""

    def __init__(self, ranges: Sequence[Range], samples: Samples, seed: int) -> None:
        """Draw the machines for the path of these *samples*; those that lay material count, or all if none does."""
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
        cells = CELLS**3
        self._largest, self._sample = np.full(cells, -1.0), np.full(cells, -1)
        self._effects, self._offsets = np.zeros((cells, 3, len(ranges))), np.zeros((cells, 3))
        self._worst: Equilibrium | None = None

    def take(self, samples: Indices, held: Equilibrium, linear: Linearisation) -> None:
        """Add the solved rows *held* of these *samples*, with their linearisation."""
        count = self._counts[samples]
        if not count.any():
            return
        samples, held, linear = samples[count], held[count], linear[count]
        effects = at_nozzle(held, response(held, self._parameters, linear))
        offsets = self._interpolation(samples, held, linear)
        rms = np.sqrt((effects**2).sum(axis=1) @ self._mean_square + (offsets**2).sum(axis=1))
        self._rms[samples] = rms
        if rms.max() > self._largest.max():
            at = int(rms.argmax())
            self._worst = held[at : at + 1]
        cell = self._cell(samples)
        order = np.lexsort((rms, cell))
        last = order[np.append(np.flatnonzero(np.diff(cell[order])), len(order) - 1)]  # the largest of each cell
        better = last[rms[last] > self._largest[cell[last]]]
        at_cells = cell[better]
        self._largest[at_cells], self._sample[at_cells] = rms[better], samples[better]
        self._effects[at_cells], self._offsets[at_cells] = effects[better], offsets[better]

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
        """Return the expected error of all that was taken."""
        known = np.flatnonzero(self._sample >= 0)
        if self._worst is None:
            return ExpectedError(np.nan, None, self._rms, (), self._ranges, np.nan, 0)
        cells = _Cells(self._effects[known], self._offsets[known], self._departures)
        worst = int(self._largest[known].argmax())
        exact, unsolved = self._solved(self._worst)
        straight = _percentile(np.linalg.norm(self._departures @ cells.effects[worst].T, axis=1))
        curvature = exact / straight - 1.0 if straight > 0.0 else 0.0
        larger = 1.0 + max(curvature, 0.0)  # NaN is no correction
        found = sorted(self._causes(cells, worst), key=lambda cause: -cause.share)
        causes = tuple(replace(cause, without=larger * cause.without) for cause in found)
        sample = int(self._sample[known][worst])
        return ExpectedError(larger * cells.error(), sample, self._rms, causes, self._ranges, curvature, unsolved)

    def _solved(self, worst: Equilibrium) -> tuple[float, int]:
        """The 95th percentile of the error at the worst sample by solving all draws, m, and how many have no answer."""
        problem = SpreadProblem(worst, worst.lengths, worst.pose, self._ranges)
        points, _, ok = sampled(problem, self._values)
        errors = np.linalg.norm(points - worst.nozzle[:, None], axis=2)[ok]
        return _percentile(errors), int((~ok).sum())

    def _causes(self, cells: _Cells, worst: int) -> Iterator[Cause]:
        """Yield the causes; *worst* is the cell of the worst sample."""
        by_number = (cells.effects[worst] ** 2).sum(axis=0) * self._mean_square
        fixed = float((cells.offsets[worst] ** 2).sum())
        total = float(by_number.sum()) + fixed or 1.0
        names = np.array([each.entry.base for each in self._parameters])
        for name in dict.fromkeys(names.tolist()):
            yield Cause(name, float(by_number[names == name].sum()) / total, cells.error(names != name))
        yield Cause(INTERPOLATION, fixed / total, cells.error(interpolated=False))


@dataclass(frozen=True, eq=False)
class _Cells:
    """The samples that stand for c cells, and S drawn machines."""

    effects: Array  # (c, 3, p) displacement per departure
    offsets: Array  # (c, 3) m, by interpolation
    departures: Array  # (S, p)

    def error(self, numbers: Array | slice = slice(None), *, interpolated: bool = True) -> float:
        """The 95th percentile of the machines' largest errors, m, by some of the *numbers* (p,)."""
        effects, drawn_values = self.effects[:, :, numbers], self.departures[:, numbers].T
        offsets = self.offsets * interpolated
        largest = np.zeros(drawn_values.shape[1])
        for first in range(0, len(effects), BLOCK):
            block = slice(first, first + BLOCK)
            moved = effects[block] @ drawn_values + offsets[block, :, None]
            np.maximum(largest, (moved**2).sum(axis=1).max(axis=0), out=largest)
        return float(np.sqrt(_percentile(largest)))


def _percentile(values: Array) -> float:
    """The smallest of *values* that `LEVEL` of them do not exceed; NaN where there are none."""
    if len(values) == 0:
        return float("nan")
    return float(np.sort(values)[int(np.ceil(LEVEL * len(values))) - 1])
