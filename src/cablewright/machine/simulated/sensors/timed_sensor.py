"""Simulated sensors that are read at a fixed rate, and the declaration of each."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, Generic, TypeVar

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.saved_state import Saved
from cablewright.foundation.signals import Reading
from cablewright.foundation.validation import Description
from cablewright.machine.quantities import Share
from cablewright.machine.sensors.sensor_declaration import Sensor, SensorSheet

if TYPE_CHECKING:
    from cablewright.machine.simulated.sensor_context import Mounted
    from cablewright.machine.simulated.true_state import RigState

_SheetT = TypeVar("_SheetT", bound=SensorSheet)
_FlawsT = TypeVar("_FlawsT", bound="SensorFlaws")


class SensorFlaws(Description):
    """Shares of a sensor's readings that are lost, and that are outliers."""

    dropout: Share = 0.0
    outliers: Share = 0.0


def steps_per_interval(period: float, interval: float, what: str) -> int:
    """Return the number of steps of *period* (s) in an *interval* (s).

    Raises `InputError`, naming *what*, for less than one.
    """
    count = interval / period
    whole = round(count)
    if whole < 1 or abs(count - whole) > 1e-6 * whole:
        raise InputError(
            f"{what}: every {interval:g} s is no whole number of the machine's steps, {period:g} s; "
            f"allowed: {period:g}, {2 * period:g}, {3 * period:g} s and so on"
        )
    return whole


class TimedSensor(ABC, Generic[_SheetT, _FlawsT]):
    """A sensor that is read at the rate of its *settings*, with the *flaws* of one unit."""

    SAVED: ClassVar[Saved] = ("_step", "_random")

    def __init__(self, sensor: Sensor[_SheetT], settings: _SheetT, flaws: _FlawsT, machine: Mounted) -> None:
        """Mount it on *machine*. Raises `InputError` for a rate that does not fit the machine's steps."""
        self.source, self.settings, self.flaws = sensor.source, settings, flaws
        self._random, self._step = machine.random(sensor.source), 0
        what = f"{sensor.table}.rate = {settings.rate:g} Hz"
        self._interval = steps_per_interval(machine.period, 1.0 / settings.rate, what)
        self._mount(machine)

    def _mount(self, machine: Mounted) -> None:
        """Draw what is drawn once, and see where it sits; of most sensors nothing."""

    def read(self, state: RigState) -> Reading | None:
        """Return a reading when one is due and not lost; to be called in each step of the machine."""
        self._step += 1
        return None if self._step % self._interval else self._measure(state)

    @abstractmethod
    def _measure(self, state: RigState) -> Reading | None:
        """Return a reading; None if it is lost."""


@dataclass(frozen=True, eq=False)
class Simulated(Generic[_SheetT, _FlawsT]):
    """Simulation of a sensor: the flaws of one unit, and its reader.

    ``faults``: kinds of planned faults besides silent and stuck, each with the change of a reading by sizes (m,).
    ``place``: index of the flaws' table among those of ``[simulation]``; 0: chosen by the sensor's stream.
    """

    sensor: Sensor[_SheetT]
    flaws: type[_FlawsT]
    reader: Callable[[Sensor[_SheetT], _SheetT, _FlawsT, Mounted], TimedSensor[_SheetT, _FlawsT]]
    faults: Mapping[str, Callable[[Array, Mounted], Array]] = field(default_factory=dict)
    place: int = 0
