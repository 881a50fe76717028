"""Interface of a sensor's corrections of the machine's unknowns, for the estimator of a rigid platform."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, ClassVar, Final, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array, Indices
from cablewright.foundation.errors import require_positive
from cablewright.foundation.signals import Reading

if TYPE_CHECKING:
    from cablewright.estimation.body.estimated_constants import BodyLayout
    from cablewright.estimation.body.settings import BodySettings
    from cablewright.estimation.body.state import BodyState

OF_MEDIAN: Final = 1.6
"""Variance of a median over that of a mean, of normal numbers."""


class Slopes(NamedTuple):
    """Derivatives of pose and tensions by lengths and wrench at the present equilibrium."""

    pose: Array  # (6, m) per length
    tensions: Array  # (m, m) per length
    pose_by_wrench: Array  # (6, 6)
    tensions_by_wrench: Array  # (m, 6)


class DrumPulls(NamedTuple):
    """How the tensions of m lines add up to the torques of the d winch drums that have several of them."""

    hosts: Indices  # (d,) the line that each is named for
    arms: Array  # (d,) m: torque over a tension of its host
    per_tension: Array  # (d, m) pull as one of its host


class HeldBody(NamedTuple):
    """A possible equilibrium of the platform.

    ``broken``: the line that does not hold it; None: all do.
    """

    pose: Array  # (6,)
    tensions: Array  # (m,) N
    planes: Array  # (m, 3) of the lines, see `solvers.taut`
    broken: int | None = None
    drums: DrumPulls | None = None


class UpdatePart(NamedTuple):
    """Innovations of one kind of sensor, with their gradients by the unknowns and noise."""

    innovation: Array  # (k,)
    gradients: Array  # (k, size)
    noise: Array  # (k, k)
    rows: NDArray[np.int64]  # (k,) which of its numbers they are of


class Update(ABC):
    """Data of a sensor, its standard deviations, and its corrections by readings.

    Subclasses are frozen dataclasses. ``READING``: their kind. ``UNKNOWNS``: how many numbers of the sensor itself are
    not known, besides those that `BodyLayout` names. ``MISSED``: whether its silence is a fault.
    """

    READING: ClassVar[type[Reading]]
    UNKNOWNS: ClassVar[int] = 0
    MISSED: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Raise `InputError` for numbers that are not positive and finite."""
        require_positive(**{name: value for name, value in vars(self).items() if not isinstance(value, str)})

    @classmethod
    @abstractmethod
    def told(cls, source: str, sheet: Any) -> Self:
        """Return the update (settings) of a sensor from the data *sheet* of a *source*."""

    @abstractmethod
    def read(self, settings: BodySettings, state: BodyState, reading: Reading) -> Array | None:
        """Return the numbers (k,) of a sensor reading; None if it has none. Side information is kept in *state*."""

    @abstractmethod
    def shown(self, there: HeldBody) -> Array:
        """Return the numbers (k,) that a perfect sensor would read at the equilibrium *there*; NaN: unknown."""

    @abstractmethod
    def as_known(self, state: BodyState, shown: Array) -> Array:
        """Return the reading (k,) expected of the real sensor from the reading *shown* of a perfect one."""

    @abstractmethod
    def set_prior(self, settings: BodySettings, layout: BodyLayout, variances: Array) -> None:
        """Set the *variances* (size,) of the sensor's own unknowns before any measurement."""

    def walk(self, layout: BodyLayout) -> Array:
        """Return the variances (size,) by which the sensor's unknowns drift in a second; 0 by default."""
        return np.zeros(layout.size)

    @abstractmethod
    def part(
        self, settings: BodySettings, state: BodyState, slopes: Slopes, read: Array, acceleration: float
    ) -> UpdatePart:
        """Return the innovations of readings (j, k): measured less predicted.

        *acceleration*: m/s^2, of the platform.
        """

    def wrapped(self, off: Array) -> Array:
        """Return a difference of two readings (k,), wrapped: angles to less than half a revolution."""
        return off


def middle(rows: Array) -> Array:
    """Return the median (k,) of *rows* (j, k) of readings, some of which may be missing."""
    if np.isfinite(rows).all():
        rows = np.sort(rows, axis=0)
        half = len(rows) // 2
        return np.asarray(rows[half] if len(rows) % 2 else 0.5 * (rows[half - 1] + rows[half]))
    return np.asarray(np.nanmedian(rows, axis=0))
