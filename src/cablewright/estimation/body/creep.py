"""Creep and hysteresis of a rigid platform's cables, which no encoder measures, from the estimated tensions.

Creep as it is described lengthens the lines; its deviation from that is one unknown for each line, in standard
deviations of its law. Hysteresis is nowhere described: a strain that is another one after each change of load.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from cablewright.estimation.climate import FeltAir
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Climate
from cablewright.models.creep import CreepMemory, hour_compliance, memory_of, scaled_creep, usual_creep
from cablewright.robot import Robot
from cablewright.robot.cable import Creep

ASSUMED: Final = 2e-4
"""Standard deviation of a strain after an hour under the mean tension at home, where the file has none: that of the
severity `typical`, with the same law."""

LOOP: Final = 2e-4
"""Strain by hysteresis between the ways up and down of a large cycle of loads, where none is stated: the same severity.
"""

UNSURE: Final = 0.3
"""Standard deviation of creep and mounts that are described, as a share of them, assumed."""

_HELD: Final = 0.05  # of the mean tension at home, assumed: by so little a load may go back and forth without effect
_RENEWED: Final = 0.4  # of it, assumed: after such a change of load the strain by hysteresis is mostly another


@dataclass(eq=False)
class BodyCreep:
    """Creep state of the lines, changed in place by `read` and `advance`.

    The memory of loads and climate starts again when a state is loaded.
    """

    SAVED = ("described", "doubt")

    described: CreepMemory | None  # None: of no cable
    doubt: CreepMemory  # strain of one standard deviation
    loads: Array  # (m,) N, at the last time
    time: float = math.nan  # s
    air: FeltAir = field(default_factory=FeltAir)

    @property
    def memories(self) -> tuple[CreepMemory, ...]:
        """All parts of the creep state that remember earlier loads."""
        return (self.doubt,) if self.described is None else (self.described, self.doubt)

    def read(self, reading: Climate) -> None:
        """Set the creep rate to the climate of a *reading* of temperature and humidity."""
        self.air.read(reading, *self.memories)

    def advance(self, loads: Array, now: float, interval: float) -> None:
        """Advance creep to *now*, s, under the tensions *loads* (m,), N, if an *interval*, s, has passed.

        A clock that was set back begins again from there.
        """
        passed = now - self.time
        if 0.0 <= passed < interval - 1e-9:
            return
        for memory in self.memories if passed > 0.0 else ():
            memory.advance(self.loads, loads, passed)
        self.loads, self.time = loads.copy(), now


class LoadPath:
    """Path of the loads of m lines, up and down, without small changes (a play operator), for hysteresis."""

    SAVED = ("home", "places")

    def __init__(self, loads: Array) -> None:
        """*loads* (m,), N, at home."""
        self.home, self.mean = loads.copy(), float(loads.mean())  # N
        self.places, self._play, self._whole = loads.copy(), _HELD * self.mean, _RENEWED * self.mean  # N

    def follow(self, loads: Array) -> Array:
        """Add the new *loads* (m,), N; return the changes (m,) with signs, 1 for a change that renews hysteresis."""
        before = self.places
        self.places = np.clip(before, loads - self._play, loads + self._play)
        return np.asarray((self.places - before) / self._whole)


def creep_of(robot: Robot, loads: Array, deviation: float | None) -> BodyCreep:
    """Return the creep state of lines that pull by *loads* (m,), N, at home, with cables at rest before.

    *deviation*: standard deviation of the strain after an hour under their mean, besides the creep of *robot*; None:
    `UNSURE` of that, or `ASSUMED` where nothing is described.
    """
    laws = [line.cable.creep for line in robot.lines]
    mean = float(loads.mean())
    doubt = memory_of([_doubt(law, mean, deviation) for law in laws])
    assert doubt is not None  # a law of each line
    return BodyCreep(memory_of(laws), doubt, loads.copy())


def _doubt(law: Creep | None, mean: float, deviation: float | None) -> Creep:
    """The law of one standard deviation of the unknown part of a cable's creep."""
    if law is None or hour_compliance(law) == 0.0:
        share = deviation if deviation is not None else ASSUMED if law is None else 0.0
        return usual_creep(share / mean)
    return scaled_creep(law, UNSURE if deviation is None else deviation / mean / hour_compliance(law))
