"""Simulated load cells at the sheaves, or torques of the motors, as tensions."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from cablewright.arrays import Array
from cablewright.machine.sensors import TensionSensor
from cablewright.machine.simulated.rig import RigState
from cablewright.machine.simulated.settings import TensionFlaws
from cablewright.machine.simulated.timed_sensor import TimedSensor
from cablewright.signals import Tensions

_HOUR: Final = 3600.0  # s


class TensionSensors(TimedSensor[TensionSensor, TensionFlaws]):
    """One for each line. Their zeros are drawn once and then drift as a random walk."""

    SAVED = (*TimedSensor.SAVED, "_zeros")

    def __init__(
        self,
        key: str,
        settings: TensionSensor,
        flaws: TensionFlaws,
        period: float,
        random: np.random.Generator,
        gains: Array,
        drift: float,
    ) -> None:
        """*key* is the source too. *gains* (m,): shares that each shows too much; the rest as `TimedSensor`.

        *drift*: N, standard deviation of what a zero has drifted by after an hour, besides that of the *flaws*.
        """
        super().__init__(key, settings, flaws, period, random)
        spread = settings.bias if flaws.bias is None else flaws.bias
        self._source, self._zeros = key, spread * random.standard_normal(len(gains))  # N
        self._factors, self._drift = 1.0 + gains, math.hypot(flaws.drift, drift)

    def _measure(self, state: RigState) -> Tensions:
        settings, flaws, true = self.settings, self.flaws, state.truth.tensions
        # a motor sees the winch's side of the sheave, a load cell on its axle the mean of both
        true = state.winch_tensions if self._source == "motor_torques" else 0.5 * (true + state.winch_tensions)
        m = len(true)
        noise, walk = self._random.standard_normal((2, m))
        chance, anywhere = self._random.random(m), self._random.uniform(0.0, settings.most, m)
        self._zeros += self._drift * math.sqrt(1.0 / (settings.rate * _HOUR)) * walk
        neighbours = 0.5 * (np.roll(true, 1) + np.roll(true, -1))
        shown = self._factors * true + flaws.cross_talk * neighbours + self._zeros + settings.deviation * noise
        shown = np.where(chance > 1.0 - flaws.outliers, anywhere, np.minimum(shown, settings.most))
        shown[chance < flaws.dropout] = np.nan
        shown.flags.writeable = False
        return Tensions(self._source, state.truth.time, shown)
