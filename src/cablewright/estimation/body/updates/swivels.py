"""Correction of the estimate by angles of swivelling sheaves, which turn as platform points move across."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final, Self

import numpy as np

from cablewright.estimation.body.updates.update import OF_MEDIAN, HeldBody, Slopes, Update, UpdatePart, middle
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Reading, Swivels
from cablewright.models.packed_views import LineNumbers
from cablewright.models.rotation import matrix_of

if TYPE_CHECKING:
    from cablewright.estimation.body.estimated_constants import BodyLayout
    from cablewright.estimation.body.settings import BodySettings
    from cablewright.estimation.body.state import BodyState

_LEAST: Final = 1e-5  # rad: no encoder is known better


@dataclass(frozen=True)
class Swivelling(Update):
    """Encoders of the swivelling sheaves: standard deviations of noise and zero, rad."""

    READING: ClassVar[type[Reading]] = Swivels
    MISSED: ClassVar[bool] = False

    deviation: float
    zero: float

    @classmethod
    def told(cls, source: str, sheet: Any) -> Self:
        return cls(max(sheet.deviation, _LEAST), max(sheet.bias, _LEAST))

    def read(self, settings: BodySettings, state: BodyState, reading: Reading) -> Array | None:
        assert isinstance(reading, Swivels)  # its kind
        return reading.angles

    def shown(self, there: HeldBody) -> Array:
        """Return the swivel angles (k,) that a perfect sensor reads *there*; see `Update.shown`.

        The angle of a broken line is unknown.
        """
        angles = np.arctan2(there.planes[:, 1], there.planes[:, 0])
        if there.broken is not None:
            angles[there.broken] = np.nan
        return np.asarray(angles)

    def as_known(self, state: BodyState, shown: Array) -> Array:
        planes, exits = state.taut.planes, state.belief.unknowns[state.layout.exit].reshape(-1, 3)
        by_exit = (planes[:, 1] * exits[:, 0] - planes[:, 0] * exits[:, 1]) / planes[:, 2]
        return np.asarray(shown + by_exit + state.belief.unknowns[state.layout.swivel])

    def set_prior(self, settings: BodySettings, layout: BodyLayout, variances: Array) -> None:
        variances[layout.swivel] = self.zero**2

    def part(
        self, settings: BodySettings, state: BodyState, slopes: Slopes, read: Array, acceleration: float
    ) -> UpdatePart:
        layout, planes = state.layout, state.taut.planes
        lines = np.flatnonzero(np.isfinite(read).any(axis=0))
        across = np.stack([-planes[:, 1], planes[:, 0], np.zeros(layout.m)], axis=1) / planes[:, 2:3]
        arms = LineNumbers(state.tracker.packed.lines).platform_point @ matrix_of(state.pose[3:]).T
        by_motion = np.concatenate([across, np.cross(arms, across)], axis=1)
        gradients = by_motion @ slopes.pose @ state.belief.gradients
        gradients[:, layout.load] = by_motion @ slopes.pose_by_wrench
        each, places = np.arange(layout.m), layout.exit.start + 3 * np.arange(layout.m)
        gradients[each, layout.swivel.start + each] = 1.0
        for axis in range(3):
            gradients[each, places + axis] -= across[:, axis]
        noise = self.deviation**2 * OF_MEDIAN / len(read)
        return UpdatePart(middle(read[:, lines]), gradients[lines], noise * np.eye(len(lines)), lines)

    def wrapped(self, off: Array) -> Array:
        return np.asarray(np.arctan2(np.sin(off), np.cos(off)))
