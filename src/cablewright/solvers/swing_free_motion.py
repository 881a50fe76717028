"""Motion of a job on a robot, shaped to avoid exciting the platform's slowest mode along the path."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from typing import Final, Self

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.memory_mapped import MEMORY, Room, blocks, let_go
from cablewright.models.inertia import moving_masses, with_inertia
from cablewright.models.job_poses import poses_at
from cablewright.models.plane import leaving
from cablewright.models.statics import Model
from cablewright.models.stiffness import stiffness
from cablewright.printing.job import Job
from cablewright.printing.layers import LayerTable, layer_table
from cablewright.printing.path import Samples
from cablewright.printing.shaping import Shaper
from cablewright.printing.timing import TimeLaw
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse

SLOWEST: Final = 0.1
"""Frequency, Hz, of the slowest mode that motion is shaped for: a slower one would take 15 s in each corner."""

PosesAt = Callable[[Array], tuple[Array, Array | None]]
"""Poses (k, n), m and rad, with the nozzle at places (k, 3), m, and retraction lengths (k,), m, or None."""

_ALONG: Final = 7  # places along each side of a box, at which modes are computed


@dataclass(frozen=True, eq=False)
class SlowestMode:
    """Frequencies of the platform's slowest mode on a grid in a box, interpolated in between.

    Beyond the box they are those of the nearest position in it.
    """

    low: Array  # (3,) m
    size: Array  # (3,) m; 0 along an axis with one place
    frequencies: Array  # (a, b, c) Hz

    @classmethod
    def within(
        cls, model: Model, low: Array, high: Array, through: Array, poses_at: PosesAt, least: float = 0.0
    ) -> Self | None:
        """Return the frequencies on a grid between two corners *low* and *high* (3,), m; None where no pose is stable.

        Where a position of the grid cannot be held, or its slowest mode is below the *least*, Hz, it has the least
        frequency of all others. A body whose inertia is not known has that of `with_inertia`. A platform in a tilted
        plane is in that *through* a position (3,), m.
        """
        axes = [np.linspace(a, b, _ALONG if b > a else 1) for a, b in zip(low, high, strict=True)]
        places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
        places -= leaving(model.robot.platform.plane, places - through)  # as a box about a path in a tilted plane does
        found = lowest_frequencies(Model(with_inertia(model.robot)), *poses_at(places.reshape(-1, 3)))
        known = found >= least  # NaN is not
        if not known.any():
            return None
        return cls(low, high - low, np.where(known, found, found[known].min()).reshape(places.shape[:3]))

    def period_at(self, place: Array) -> float:
        """Return the slowest mode's period, s, with the nozzle at one position (3,), m."""
        return float(self.period(place[None])[0])

    @property
    def least(self) -> float:
        """Lowest natural frequency on the grid of positions, Hz."""
        return float(self.frequencies.min())

    def period(self, positions: Array) -> Array:
        """Return the slowest mode's period (k,), s, with the nozzle at *positions* (k, 3), m."""
        counts = np.array(self.frequencies.shape) - 1
        share = np.divide(positions - self.low, self.size, out=np.zeros_like(positions), where=self.size > 0.0)
        at = np.clip(share, 0.0, 1.0) * counts
        cell = np.minimum(at.astype(np.int64), np.maximum(counts - 1, 0))
        part, found = at - cell, np.zeros(len(positions))
        for corner in product((0, 1), repeat=3):
            weight = np.where(corner, part, 1.0 - part).prod(axis=1)
            found += weight * self.frequencies[tuple(np.minimum(cell + corner, counts).T)]
        return 1.0 / found


@dataclass(frozen=True, eq=False)
class JobMotion:
    """The commanded motion of a job, and the time that shaping adds to it."""

    samples: Samples
    law: TimeLaw
    path: Samples  # of the job, before it is shaped
    unshaped: float  # s, duration without shaping
    shaper: Shaper | None  # None: the motion is not shaped
    slowest: float  # Hz, least frequency of the slowest mode along the path; NaN where it is not shaped for that
    why: str  # why it is not shaped; else empty
    layers: LayerTable  # without shaping

    @classmethod
    def of(cls, robot: Robot, job: Job, samples: Samples, room: Room = MEMORY) -> Self:
        """Return the motion of a *job* on a *robot* along its *samples*, shaped where possible.

        *room*: folder for its arrays.
        """
        law, motion = job.time_law(samples, room), job.motion
        mode, layers = slowest_mode(robot, job, samples), layer_table(samples, law)
        if isinstance(mode, str):
            return cls(samples, law, samples, law.duration, None, np.nan, mode, layers)
        shaper = Shaper(mode.period, motion.acceleration, motion.corner, motion.jerk)
        return cls(*shaper.shaped(samples, room), samples, law.duration, shaper, mode.least, "", layers)

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on the time that shaping adds, and on layers shorter than the shaper."""
        if self.shaper is None:
            return ()
        more, layers = self.law.duration - self.unshaped, self.layers
        share, low = more / self.unshaped, self.slowest
        notes = [f"motion is shaped for modes from {low:.3g} Hz on, which takes {more:.0f} s ({share:.2%}) more"]
        length = 2.0 * float(self.shaper.kernel(self.samples.positions[:1]).reach[0])
        if len(layers) and (shortest := float(layers.duration.min())) < length:
            number = layers.number[int(layers.duration.argmin())]
            notes.append(
                f"the mean of {length:.3g} s that shapes the motion is longer than layer {number}, {shortest:.3g} s: "
                'motion.shaping = "none" is faster, and swings'
            )
        return tuple(notes)


def slowest_mode(robot: Robot, job: Job, samples: Samples) -> SlowestMode | str:
    """Return the slowest mode on a grid about a job's path, or a sentence why its motion is not shaped."""
    if job.motion.shaping == "none":
        return 'motion.shaping = "none"'
    low, high = samples.positions[0].copy(), samples.positions[0].copy()
    for at in blocks(len(samples)):
        np.minimum(low, samples.positions[at].min(axis=0), out=low)
        np.maximum(high, samples.positions[at].max(axis=0), out=high)
        let_go(samples.positions)
    found = SlowestMode.within(
        Model(robot), low, high, samples.positions[0], lambda places: poses_at(robot, job, places)
    )
    if found is None:
        return "no pose about the path is stable"
    if found.least < SLOWEST:
        return f"the slowest mode, {found.least:.2g} Hz, is below {SLOWEST:g} Hz"
    return found


def lowest_frequencies(model: Model, poses: Array, retraction: Array | None = None) -> Array:
    """Return the lowest natural frequency (N,), Hz, at *poses* (N, n), winches held; NaN where none is stable.

    *retraction*: (N,) m. As the first of `modes`. Raises `InputError` for a body whose inertia is not known.
    """
    held = solve_inverse(model, poses, retraction=retraction)
    parts = stiffness(held)
    mass, tangent = moving_masses(model.robot, held)[0], 0.5 * (parts.total + np.swapaxes(parts.total, 1, 2))
    free = model.free_directions
    if free is not None:
        mass, tangent = free.T @ mass @ free, free.T @ tangent @ free
    found = np.full(len(poses), np.nan)
    good = np.isfinite(tangent).all(axis=(1, 2)) & held.ok
    if not good.any():
        return found
    squares = np.linalg.eigvals(np.linalg.solve(mass[good], tangent[good])).real.min(axis=1)
    found[good] = np.sqrt(np.where(squares > 0.0, squares, np.nan)) / (2.0 * np.pi)
    return found
