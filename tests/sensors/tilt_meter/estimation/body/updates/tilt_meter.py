"""The upward direction, by a tilt meter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from cablewright.foundation.signals.tilt_meter import TiltMeter

from cablewright.estimation.body.updates.tilt import UPWARD
from cablewright.estimation.body.updates.update import OF_MEDIAN, HeldBody, Slopes, Update, UpdatePart, middle
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Reading
from cablewright.models.rotation import matrix_of

if TYPE_CHECKING:
    from cablewright.estimation.body.estimated_constants import BodyLayout
    from cablewright.estimation.body.settings import BodySettings
    from cablewright.estimation.body.state import BodyState


@dataclass(frozen=True)
class Leaning(Update):
    """Noise and zero, rad, standard deviations."""

    READING: ClassVar[type[Reading]] = TiltMeter
    UNKNOWNS: ClassVar[int] = 2

    deviation: float
    zero: float

    @classmethod
    def told(cls, source: str, sheet: Any) -> Self:
        return cls(max(sheet.deviation, 1e-6), max(sheet.bias, 1e-6))

    def read(self, settings: BodySettings, state: BodyState, reading: Reading) -> Array | None:
        assert isinstance(reading, TiltMeter)
        return reading.tilt

    def shown(self, there: HeldBody) -> Array:
        return np.asarray(matrix_of(there.pose[3:])[2, :2])

    def as_known(self, state: BodyState, shown: Array) -> Array:
        return shown + state.belief.unknowns[state.layout.own[Leaning]]

    def set_prior(self, settings: BodySettings, layout: BodyLayout, variances: Array) -> None:
        variances[layout.own[Leaning]] = self.zero**2

    def part(
        self, settings: BodySettings, state: BodyState, slopes: Slopes, read: Array, acceleration: float
    ) -> UpdatePart:
        by_turn = (matrix_of(state.pose[3:]).T @ UPWARD)[:2]
        gradients = by_turn @ slopes.pose[3:] @ state.belief.gradients
        gradients[:, state.layout.own[Leaning]] = np.eye(2)
        gradients[:, state.layout.load] = by_turn @ slopes.pose_by_wrench[3:]
        return UpdatePart(middle(read), gradients, self.deviation**2 * OF_MEDIAN / len(read) * np.eye(2), np.arange(2))
