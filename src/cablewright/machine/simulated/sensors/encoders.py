"""Simulated encoders of the winches' motors."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Encoders
from cablewright.machine.sensors.encoders import ENCODERS, Encoder
from cablewright.machine.simulated.sensors.timed_sensor import SensorFlaws, Simulated, TimedSensor

if TYPE_CHECKING:
    from cablewright.machine.simulated.sensor_context import Mounted
    from cablewright.machine.simulated.true_state import RigState


_BITS: Final = 24  # of a counter


class EncoderReader(TimedSensor[Encoder, SensorFlaws]):
    """All simulated encoders, read at the same time; their only error is quantisation."""

    def _measure(self, state: RigState) -> Encoders | None:
        chance, which, bit = self._random.random(), self._random.random(), int(self._random.integers(_BITS))
        if chance < self.flaws.dropout:
            return None
        counts = state.counts
        if chance > 1.0 - self.flaws.outliers:
            counts[int(which * len(counts))] ^= 1 << bit
        counts.flags.writeable = False
        return Encoders(state.time, counts)


def _slipped(slips: Array, machine: Mounted) -> Array:
    """Return the surplus of counts where the lengths *slips* (m,), m, of cable slip."""
    radii = np.array(
        [line.winch.drum_radius or np.inf for line in map(machine.robot.lines.__getitem__, machine.robot.hosts)]
    )
    turns = slips / (radii * math.tau)
    return np.rint(turns * (machine.winch.ratio * machine.winch.counts))


SIMULATED: Final = Simulated(ENCODERS, SensorFlaws, EncoderReader, {"slip": _slipped})
