"""Interface of a set of winch drives to the machine made of them, whatever bus they are on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from cablewright.machine.drives.axis import Axis, Setpoint
from cablewright.machine.drives.identity import Identity
from cablewright.machine.drives.parameters import ObjectParameter
from cablewright.machine.drives.statistics import BusStatistics
from cablewright.models.winch_lines import WinchLines


class WinchDrives(Protocol):
    """Interface of the drives of all winches, in the order of the lines that these are named for."""

    def scan(self) -> tuple[Identity, ...]:
        """List all devices on the bus, of this machine or not; no parameter is written. Raises `EnvironmentFault`."""

    def read(self) -> dict[str, list[tuple[ObjectParameter, int | None]]]:
        """Return the parameters to write with each drive's present value, by line.

        None: a drive lacks the object. Raises as `open`.
        """

    @property
    def winches(self) -> WinchLines:
        """Assignment of lines to drums."""

    @property
    def axes(self) -> Sequence[Axis]:
        """The last reported state of each drive."""

    @property
    def statistics(self) -> BusStatistics:
        """Statistics of the bus."""

    @property
    def trouble(self) -> str:
        """Reason why the bus cannot be commanded now: an error, another master; empty: none."""

    def now(self) -> float:
        """The time, s, by the clock of `cycle`."""

    def open(self) -> None:
        """Find the drives, and write and read back the settings of their own supervision; nothing is enabled.

        Raises `EnvironmentFault` where the bus is not available or another master commands it, `InputError` for drives
        that are not those of the machine file.
        """

    def begin_checks(self) -> None:
        """Begin to write and read back the drives' own supervision, within the cycles, before they are enabled."""

    def begin_speed_limits(self, tension: Sequence[bool]) -> None:
        """Begin to limit the speed of each drive for torque mode where *tension*, else to that of the winch."""

    @property
    def checking(self) -> bool:
        """Whether a started transfer still runs. `Axis.failure` has the reason of an error."""

    def cycle(self, setpoints: tuple[Setpoint, ...], due: float, *, reset: bool = False, beats: bool = True) -> float:
        """Command *setpoints*, wait until *due*, s, and take the answers; return the time of measurement, s.

        *reset*: whether to reset faults, by an edge of the bit. *beats*: whether the heartbeat goes on, without which
        each drive stops by itself. Raises nothing: see `trouble`.
        """

    def close(self, *, proven: bool) -> None:
        """Leave the drives and the bus; raises nothing.

        *proven*: all drives are confirmed to be disabled, so that they need not watch this computer any more.
        """
