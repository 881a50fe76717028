"""Simulated sensor that measures the length of a platform that retracts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from cablewright.foundation.signals import BeamLength
from cablewright.machine.sensors.retraction import RETRACTION, RetractionDrive
from cablewright.machine.simulated.sensors.timed_sensor import SensorFlaws, Simulated, TimedSensor

if TYPE_CHECKING:
    from cablewright.machine.simulated.true_state import RigState


class BeamReader(TimedSensor[RetractionDrive, SensorFlaws]):
    """Sensor that measures the length of a platform that retracts, m."""

    def _measure(self, state: RigState) -> BeamLength | None:
        noise, chance, anywhere = self._random.standard_normal(), self._random.random(), self._random.random()
        if chance < self.flaws.dropout:
            return None
        length = state.truth.retraction
        shown = length + self.settings.deviation * noise
        if chance > 1.0 - self.flaws.outliers:
            shown = 2.0 * anywhere * length
        return BeamLength(state.time, float(shown))


SIMULATED: Final = Simulated(RETRACTION, SensorFlaws, BeamReader, place=10)
