"""Simulated light barrier around the machine."""

from __future__ import annotations

import numpy as np

from cablewright.machine.simulated.rig import RigState
from cablewright.machine.simulated.settings import BarrierSensor
from cablewright.machine.simulated.snapshot import Archive
from cablewright.machine.simulated.ticks import steps_per_interval
from cablewright.signals import Barrier


class LightBarrier:
    """One light barrier. It latches: an interruption since the last reading shows in the next one."""

    def __init__(self, settings: BarrierSensor, period: float, random: np.random.Generator) -> None:
        """Raises `InputError` for a rate that does not fit the machine's *period*, s."""
        self.settings, self._random = settings, random
        self._interval, self._step = (
            steps_per_interval(period, 1.0 / settings.rate, f"barrier.rate = {settings.rate:g} Hz"),
            0,
        )
        self._last_read = -np.inf  # s, time of the last reading

    def read(self, state: RigState) -> Barrier | None:
        """Return a reading when one is due and not lost."""
        self._step += 1
        if self._step % self._interval:
            return None
        now, chance = state.truth.time, self._random.random()
        broken = any(begin <= now and self._last_read < end for begin, end in self.settings.intrusions)
        self._last_read = now
        if chance < self.settings.dropout:
            return None
        return Barrier(now, broken != (chance > 1.0 - self.settings.outliers))

    def archive_state(self, archive: Archive) -> None:
        """Save or load the state that the next readings depend on."""
        self._step, self._last_read = archive.count("step", self._step), archive.number("read", self._last_read)
        archive.random("random", self._random)
