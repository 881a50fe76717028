"""The simulated clock on the platform, which stamps readings over the wireless link."""

from __future__ import annotations

import bisect
from itertools import accumulate

from cablewright.foundation.signals import Reading
from cablewright.machine.simulated.as_built_parts import CLOCK, drawn
from cablewright.machine.simulated.settings import SimulationSettings


class DrumClock:
    """A clock with an offset, a relative rate error, and planned jumps."""

    def __init__(self, simulation: SimulationSettings, seed: int) -> None:
        """Draw offset and rate by *seed*."""
        offset, drift = drawn(seed, CLOCK).standard_normal(2)
        self.offset = float(simulation.tolerances.clock_offset * offset)  # s
        self.drift = float(simulation.tolerances.clock_drift * drift)
        self._times = [time for time, _ in simulation.clock.jumps]
        self._sums = [0.0, *accumulate(size for _, size in simulation.clock.jumps)]
        self._is_right = not (self.offset or self.drift or self._times)

    def shown(self, time: float) -> float:
        """Return the time that the platform's clock shows at a *time* of the machine's clock, s."""
        return (1.0 + self.drift) * time + self.offset + self._sums[bisect.bisect_right(self._times, time)]

    def stamped(self, reading: Reading) -> Reading:
        """Return the *reading* stamped with the time of this clock; of a scan, at its begin."""
        if self._is_right:
            return reading
        return reading.stamped(self.shown(reading.stamp), 1.0 + self.drift)
