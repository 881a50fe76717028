"""Running mean of a motion along straight segments with pieces of constant acceleration.

With the kernel of two running means, the mean position is a second difference of the second integral of the position,
over the lengths of both; so are mean velocity and acceleration, with as many integrations. All are exact.
"""

from __future__ import annotations

from typing import Final, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array
from cablewright.printing.path import Samples
from cablewright.printing.timing import TimeLaw, pieces

_LONG_AGO: Final = 1e6  # s before the first piece: from when on the nozzle stands there
_ENDS: Final = np.array([[0.5, 0.5], [0.5, -0.5], [-0.5, 0.5], [-0.5, -0.5]])  # of both means
_SIGNS: Final = np.array([1.0, -1.0, -1.0, 1.0])[:, None, None]


class Kernel(NamedTuple):
    """Kernel of two running means about a time, one after the other; arrays (k,), s.

    The first is no shorter than the second.
    """

    long: Array
    short: Array

    @property
    def reach(self) -> Array:
        """Half of the time over which the motion is averaged, s."""
        return np.asarray(0.5 * (self.long + self.short))

    @property
    def mean(self) -> Array:
        """Mean distance of the kernel from its middle, s."""
        return np.asarray(self.long / 4.0 + self.short**2 / (12.0 * self.long))

    def beyond(self, wait: Array) -> Array:
        """Return the mean square (k,), s^2, of the distance from the middle that is more than *wait* (k,), s."""
        inner = self.reach - self.short
        far = np.maximum(self.reach - wait, 0.0) ** 4 - np.maximum(inner - wait, 0.0) ** 4
        return np.asarray(far / (6.0 * self.long * self.short))

    def between(self, row: NDArray[np.int64], share: Array) -> Kernel:
        """Return the kernels (b,) at a *share* (b,) of the way from *row* (b,) to the next."""
        return Kernel(*(each[row] + share * (each[row + 1] - each[row]) for each in self))


class IntegratedLaw(NamedTuple):
    """A time law as pieces of constant acceleration, with the integrals of the position up to each piece."""

    origin: Array  # (3,) m
    time: Array  # (p,) s, where each begins
    terms: tuple[Array, ...]  # (p, 3) each: acceleration, velocity, place from the origin, its integral and that of it

    @classmethod
    def of(cls, samples: Samples, law: TimeLaw, acceleration: float, about: slice) -> Self:
        """Return the pieces along samples *about*.

        *law*: time law by `time_law` at that *acceleration*, m/s^2, without a limit of jerk.
        """
        knots, near = pieces(samples, law, acceleration, about)
        positions, along = samples.positions[about], samples.distance[about] - samples.distance[about.start]
        way = (np.diff(positions, axis=0) / np.diff(along)[:, None])[near]
        place = positions[near] - positions[0] + way * (knots.place - along[near])[:, None]
        time = np.concatenate([[knots.time[0] - _LONG_AGO], knots.time])
        x, v, a = (
            np.concatenate([np.zeros((1, 3)), each])
            for each in (place, way * knots.speed[:, None], way * knots.acceleration[:, None])
        )
        u = np.append(np.diff(time), 0.0)[:, None]
        step = u * (x + u * (v / 2.0 + u * a / 6.0))
        area = np.cumsum(step, axis=0) - step
        step = u * (area + u * (x / 2.0 + u * (v / 6.0 + u * a / 24.0)))
        return cls(positions[0], time, (a, v, x, area, np.cumsum(step, axis=0) - step))

    def mean(self, time: Array, kernel: Kernel) -> tuple[Array, Array, Array]:
        """Return mean position, velocity and acceleration (b, 3) about *time* (b,), s, each with its *kernel* (b,)."""
        at = time + _ENDS @ np.stack(kernel)  # (4, b)
        row = np.searchsorted(self.time, at, side="right") - 1
        u = (at - self.time[row])[..., None]
        a, v, x, area, second = (each[row] for each in self.terms)
        integrals = (
            second + u * (area + u * (x / 2.0 + u * (v / 6.0 + u * a / 24.0))),
            area + u * (x + u * (v / 2.0 + u * a / 6.0)),
            x + u * (v + u * a / 2.0),
        )
        place, velocity, acceleration = (
            (_SIGNS * each).sum(axis=0) / (kernel.long * kernel.short)[:, None] for each in integrals
        )
        return self.origin + place, velocity, acceleration
