"""The light barrier round the machine's place."""

from __future__ import annotations

import numpy as np

from cablewright.machine.simulated.rig import Moment
from cablewright.machine.simulated.settings import BarrierSensor
from cablewright.machine.simulated.snapshot import Book
from cablewright.machine.simulated.ticks import every
from cablewright.signals import Barrier

__all__ = ["LightBarrier"]


class LightBarrier:
    """One unit. It latches: whoever was in its light since the last reading is in the next one."""

    def __init__(self, settings: BarrierSensor, period: float, random: np.random.Generator) -> None:
        """Mount it. Raises `InputError` for a rate that does not fit the machine's *period*, s."""
        self.settings, self._random = settings, random
        self._every, self._step = every(period, 1.0 / settings.rate, f"barrier.rate = {settings.rate:g} Hz"), 0
        self._read = -np.inf  # s, when it was read last

    def read(self, moment: Moment) -> Barrier | None:
        """Return a reading when one is due and not lost."""
        self._step += 1
        if self._step % self._every:
            return None
        now, chance = moment.truth.time, self._random.random()
        broken = any(begin <= now and self._read < end for begin, end in self.settings.intrusions)
        self._read = now
        if chance < self.settings.dropout:
            return None
        return Barrier(now, broken != (chance > 1.0 - self.settings.outliers))

    def keep(self, book: Book) -> None:
        """Note, or take up again, what decides on the next readings."""
        self._step, self._read = book.count("step", self._step), book.number("read", self._read)
        book.random("random", self._random)
