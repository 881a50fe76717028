"""CANopen drives of the profile CiA 402, as `WinchDrives`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

from cablewright.foundation.errors import CablewrightError, EnvironmentFault, InputError
from cablewright.machine.drives import objects as o
from cablewright.machine.drives.acyclic_requests import begin_speed_limits, bring_off, read_back
from cablewright.machine.drives.axis import Axis, Setpoint
from cablewright.machine.drives.can_bus import Port
from cablewright.machine.drives.can_port import CanPort
from cablewright.machine.drives.canopen_network import Network
from cablewright.machine.drives.drives_of_winches import axes_of, require_drives
from cablewright.machine.drives.identity import Identity
from cablewright.machine.drives.local_can_bus import LoopbackPort
from cablewright.machine.drives.parameters import (
    ObjectParameter,
    communication,
    disarmed,
    guards,
    shut,
)
from cablewright.machine.drives.settings import LOOPBACK, WinchDriveSettings
from cablewright.machine.drives.statistics import BusStatistics, cyclic_load
from cablewright.machine.settings import MachineSettings
from cablewright.models.winch_lines import WinchLines
from cablewright.robot import Robot

_MAX_LOAD: Final = 0.7
"""Share of a bus that cyclic frames may take: the rest is for parameters, heartbeats and repeated frames."""

_SETTLED: Final = 10  # periods for drives to become operational, and to hear heartbeats


def open_port(settings: WinchDriveSettings) -> Port:
    """Open the bus of a machine file. Raises `EnvironmentFault`."""
    if settings.interface == LOOPBACK:
        return LoopbackPort(int(settings.channel))
    return CanPort.opened(settings.interface, settings.channel, settings.bitrate)


class CanopenDrives:
    """The CANopen drives of a robot's winches, from its machine file."""

    def __init__(self, robot: Robot, settings: MachineSettings, port: Callable[[], Port] | None = None) -> None:
        """*port* opens the bus; None: that of the file. Raises `InputError` for a file that does not fit the robot."""
        drives = require_drives(settings, robot)
        load = cyclic_load(robot.winches, settings.period, drives.bitrate)
        if load > _MAX_LOAD:
            why = f"{robot.winches} drives in steps of {settings.period:g} s take {load:.0%} of the bus"
            raise InputError(f"drives.bitrate = {drives.bitrate}: {why}; at most {_MAX_LOAD:.0%} is allowed")
        self.settings, self._machine = drives, settings
        self.axes, self.winches = axes_of(robot, settings), WinchLines.of(robot)
        self._make_port = port or (lambda: open_port(drives))
        self._network: Network | None = None
        self._closed_statistics = BusStatistics()

    @property
    def statistics(self) -> BusStatistics:
        """Return the statistics of the bus; see `WinchDrives.statistics`."""
        return self._closed_statistics if self._network is None else self._network.statistics

    @property
    def trouble(self) -> str:
        """Return the reason why the bus cannot be commanded, or an empty text; see `WinchDrives.trouble`."""
        bus = self._bus
        return f"another master: {bus.master}" if bus.master else bus.error

    @property
    def _bus(self) -> Network:
        assert self._network is not None, "the drives are not open"
        return self._network

    def now(self) -> float:
        """Return the time, s, by the clock of `cycle`; see `WinchDrives.now`."""
        return self._bus.port.now()

    def connect(self) -> Network:
        """Open the bus, listen, and ask all nodes for their identity; nothing is written. Raises as `open`."""
        self._network = Network(self._make_port(), self.axes, self.settings.host, self.settings.heartbeat_timeout)
        try:
            self._network.listen()
            for axis in self.axes:
                self._require(axis)
        except CablewrightError:
            self._leave()
            raise
        return self._network

    def _require(self, axis: Axis) -> None:
        found = self._bus.identify(axis.node)
        self._bus.require_alone()
        if found is None:
            raise EnvironmentFault(
                f"drives.nodes.{axis.name}.id = {axis.node}: no drive answers; check the wiring and this node number"
            )
        found.require(axis.name, self.settings.rated_torque)

    def scan(self) -> tuple[Identity, ...]:
        """List all devices on the bus, of this machine or not; nothing is written. Raises `EnvironmentFault`."""
        self._network = Network(self._make_port(), self.axes, self.settings.host, self.settings.heartbeat_timeout)
        try:
            self._network.listen()
            return self._network.scan()
        finally:
            self._leave()

    def read(self) -> dict[str, list[tuple[ObjectParameter, int | None]]]:
        """Return the parameters to write with each drive's present value, by line.

        None: a drive lacks the object. Raises as `open`.
        """
        bus = self.connect()
        try:
            return read_back(bus, self.axes, self.parameters)
        finally:
            self._leave()

    def parameters(self, axis: Axis) -> list[ObjectParameter]:
        """Return all parameters that are written into a drive."""
        return self._communication(axis) + self._guards(axis)

    def _communication(self, axis: Axis) -> list[ObjectParameter]:
        return communication(self.settings, self.settings.nodes[axis.name], axis.mapped)

    def open(self) -> None:
        """Find the drives, and write and read back their settings; see `WinchDrives.open`."""
        bus = self.connect()
        try:
            bring_off(bus, self.axes, self.settings.stop_time(max(axis.scale.speed_of_cable for axis in self.axes)))
            bus.command_state(o.NMT_PREOPERATIONAL)
            for axis in self.axes:
                axis.begin(bus.port.now())
            bus.check({axis.name: self.parameters(axis) for axis in self.axes}, write=True)
            bus.settle()
            bus.command_state(o.NMT_START)
            for _ in range(_SETTLED):
                bus.beat()
                bus.pump(bus.port.now() + self._machine.period)
            bus.require_alone()
        except CablewrightError:
            self._leave()
            raise

    def _guards(self, axis: Axis) -> list[ObjectParameter]:
        own = guards(self.settings, axis.scale, self._machine.winch.counts, self._machine.period)
        return own + shut(axis.valve)

    def begin_checks(self) -> None:
        """Begin to write and read back the drives' own supervision, within the cycles; see `WinchDrives.begin_checks`.

        PDOs are only read, since they can be changed in another state alone.
        """
        for axis in self.axes:
            axis.failure = ""
            talk = [each for each in self._communication(axis) if each.lasts]
            axis.check(talk, write=False)
            axis.check(self._guards(axis), write=True)

    def begin_speed_limits(self, tension: Sequence[bool]) -> None:
        """Begin to set the speed limits of drives for torque mode; see `WinchDrives.begin_speed_limits`."""
        begin_speed_limits(self.axes, tension, self.settings.tension_speed)

    @property
    def checking(self) -> bool:
        """Return whether parameters are still being transferred; see `WinchDrives.checking`."""
        return self._bus.checking

    def cycle(self, setpoints: tuple[Setpoint, ...], due: float, *, reset: bool = False, beats: bool = True) -> float:
        """Command *setpoints*, wait until *due*, s, and take the answers; see `WinchDrives.cycle`."""
        return self._bus.cycle(setpoints, due, self._machine.period, reset=reset, beats=beats)

    def close(self, *, proven: bool) -> None:
        """Leave the drives and the bus; see `WinchDrives.close`."""
        bus = self._network
        if bus is None:
            return
        if proven and not bus.master:
            for axis in self.axes:
                axis.transfers.clear()
                axis.checks.clear()
            bus.check({axis.name: [disarmed()] for axis in self.axes}, write=True)
            end = bus.port.now() + 0.5
            while bus.checking and bus.port.now() < end:
                bus.beat()
                bus.pump(bus.port.now() + 0.01)
            bus.command_state(o.NMT_PREOPERATIONAL)
        self._leave()

    def _leave(self) -> None:
        bus, self._network = self._network, None
        if bus is not None:
            self._closed_statistics = bus.statistics
            bus.port.close()
