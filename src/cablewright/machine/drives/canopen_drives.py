"""CANopen drives of the profile CiA 402, as `WinchDrives`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

from cablewright.errors import CablewrightError, EnvironmentFault, InputError
from cablewright.machine.drives import objects as o
from cablewright.machine.drives.axis import Axis, Setpoint
from cablewright.machine.drives.bus import Port
from cablewright.machine.drives.can_port import CanPort
from cablewright.machine.drives.cia402 import DISABLE_OPERATION, ENERGISED, PowerState, state_of
from cablewright.machine.drives.loopback import LoopbackPort
from cablewright.machine.drives.network import Identity, Network
from cablewright.machine.drives.parameters import (
    RAMP_AND_OFF,
    Parameter,
    communication,
    disarmed,
    guards,
    shut,
    speed_limit,
)
from cablewright.machine.drives.scale import scales_of
from cablewright.machine.drives.sdo import Transfer
from cablewright.machine.drives.settings import LOOPBACK, DriveSettings
from cablewright.machine.drives.statistics import BusStatistics, cyclic_load
from cablewright.machine.settings import MachineSettings
from cablewright.robot import Robot

_MAX_LOAD: Final = 0.7
"""Share of a bus that cyclic frames may take: the rest is for parameters, heartbeats and repeated frames."""

_POLL: Final = 0.01  # s

_SETTLED: Final = 10  # periods for drives to become operational, and to hear heartbeats


def open_port(settings: DriveSettings) -> Port:
    """Open the bus of a machine file. Raises `EnvironmentFault`."""
    if settings.interface == LOOPBACK:
        return LoopbackPort(int(settings.channel))
    return CanPort.opened(settings.interface, settings.channel, settings.bitrate)


class CanopenDrives:
    """The drives of a robot's lines, as its machine file has them."""

    def __init__(self, robot: Robot, settings: MachineSettings, port: Callable[[], Port] | None = None) -> None:
        """*port* opens the bus; None: that of the file. Raises `InputError` for a file that does not fit the robot."""
        drives = require_drives(settings, robot)
        lines = tuple(line.name for line in robot.lines)
        load = cyclic_load(len(lines), settings.period, drives.bitrate)
        if load > _MAX_LOAD:
            why = f"{len(lines)} drives in steps of {settings.period:g} s take {load:.0%} of the bus"
            raise InputError(f"drives.bitrate = {drives.bitrate}: {why}; at most {_MAX_LOAD:.0%} is allowed")
        self.settings, self._machine = drives, settings
        scales = scales_of(robot, settings)
        self.axes = tuple(
            Axis(name, drives.nodes[name].id, scale, drives.brake_time, valve_of(drives, name))
            for name, scale in zip(lines, scales, strict=True)
        )
        self._make_port = port or (lambda: open_port(drives))
        self._network: Network | None = None
        self._closed_statistics = BusStatistics()
        self.identities: tuple[Identity, ...] = ()

    @property
    def statistics(self) -> BusStatistics:
        """As `WinchDrives`."""
        return self._closed_statistics if self._network is None else self._network.statistics

    @property
    def trouble(self) -> str:
        """As `WinchDrives`."""
        bus = self._bus
        return f"another master: {bus.master}" if bus.master else bus.error

    @property
    def _bus(self) -> Network:
        assert self._network is not None, "the drives are not open"
        return self._network

    def now(self) -> float:
        """As `WinchDrives`."""
        return self._bus.port.now()

    def connect(self) -> Network:
        """Open the bus, listen, and ask all nodes who they are; nothing is written. Raises as `open`."""
        self._network = Network(self._make_port(), self.axes, self.settings.host, self.settings.heartbeat_timeout)
        try:
            self._network.listen()
            self.identities = tuple(self._identity(axis) for axis in self.axes)
        except CablewrightError:
            self._leave()
            raise
        return self._network

    def _identity(self, axis: Axis) -> Identity:
        found = self._bus.identify(axis.node)
        self._bus.require_alone()
        if found is None:
            raise EnvironmentFault(
                f"drives.nodes.{axis.name}.id = {axis.node}: nobody answers; check wiring and number"
            )
        found.require(axis.name, self.settings.rated_torque)
        return found

    def scan(self) -> tuple[Identity, ...]:
        """Who is on the bus, of this machine or not; nothing is written. Raises `EnvironmentFault`."""
        self._network = Network(self._make_port(), self.axes, self.settings.host, self.settings.heartbeat_timeout)
        try:
            self._network.listen()
            return self._network.scan()
        finally:
            self._leave()

    def read(self) -> dict[str, list[tuple[Parameter, int | None]]]:
        """What should be written, and what each drive has, by line; None: it has no such object. Raises as `open`."""
        bus = self.connect()
        try:
            found = {}
            for axis in self.axes:
                wanted = [each for each in self.parameters(axis) if each.lasts]
                read = [axis.transfers.add(Transfer(each.object)) for each in wanted]
                bus.finish(axis)
                values = [None if each.failure else each.result for each in read]
                found[axis.name] = list(zip(wanted, values, strict=True))
            return found
        finally:
            self._leave()

    def parameters(self, axis: Axis) -> list[Parameter]:
        """All that is written into a drive."""
        return self._communication(axis) + self._guards(axis)

    def _communication(self, axis: Axis) -> list[Parameter]:
        return communication(self.settings, self.settings.nodes[axis.name], axis.mapped)

    def open(self) -> None:
        """As `WinchDrives`."""
        bus = self.connect()
        try:
            self._bring_off(bus)
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

    def _bring_off(self, bus: Network) -> None:
        """Stop drives that somebody left under torque, by ramp and brake, before anything they watch is changed.

        Raises `EnvironmentFault` for one that stays under torque.
        """
        left = [axis for axis in self.axes if self._power(axis) in ENERGISED]
        for axis in left:
            ramp = axis.transfers.add(Transfer(o.DISABLE_OPTION, RAMP_AND_OFF))
            bus.finish(axis)
            if not ramp.failure:
                axis.transfers.add(Transfer(o.CONTROLWORD, DISABLE_OPERATION))
                bus.finish(axis)
        end = bus.port.now() + self.settings.stop_time(max(axis.scale.speed_of_cable for axis in self.axes))
        while left and bus.port.now() < end:
            bus.pump(bus.port.now() + _POLL)
            left = [axis for axis in left if self._power(axis) in ENERGISED]
        if left:
            why = "somebody left it under torque, and it does not switch off by request: use the emergency stop"
            raise EnvironmentFault(f"the drive of line {left[0].name} (node {left[0].node}): {why}")

    def _power(self, axis: Axis) -> PowerState:
        """The state of a drive by request; one that does not tell counts as enabled."""
        word = axis.transfers.add(Transfer(o.STATUSWORD))
        self._bus.finish(axis)
        return PowerState.ENABLED if word.failure else state_of(word.result)

    def _guards(self, axis: Axis) -> list[Parameter]:
        own = guards(self.settings, axis.scale, self._machine.winch.counts, self._machine.period)
        return own + shut(axis.valve)

    def begin_checks(self) -> None:
        """As `WinchDrives`: PDOs are read, as they can be changed in another state alone; the rest is written too."""
        for axis in self.axes:
            axis.failure = ""
            talk = [each for each in self._communication(axis) if each.lasts]
            axis.check(talk, write=False)
            axis.check(self._guards(axis), write=True)

    def begin_speed_limits(self, tension: Sequence[bool]) -> None:
        """As `WinchDrives`."""
        for axis, slow in zip(self.axes, tension, strict=True):
            scale = axis.scale
            most = min(self.settings.tension_speed / scale.radii[1], scale.max_speed) if slow else scale.max_speed
            axis.failure = ""
            axis.check([speed_limit(scale, most)], write=True)

    @property
    def checking(self) -> bool:
        """As `WinchDrives`."""
        return self._bus.checking

    def cycle(self, setpoints: tuple[Setpoint, ...], due: float, *, reset: bool = False, beats: bool = True) -> float:
        """As `WinchDrives`."""
        return self._bus.cycle(setpoints, due, self._machine.period, reset=reset, beats=beats)

    def close(self, *, proven: bool) -> None:
        """As `WinchDrives`."""
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


def valve_of(settings: DriveSettings, line: str) -> int:
    """The bit, as a mask, of the outputs of a *line*'s drive that opens the valve; 0: it has none."""
    valve = settings.valve
    return 1 << valve.bit if valve is not None and valve.line == line else 0


def require_drives(settings: MachineSettings, robot: Robot) -> DriveSettings:
    """The drives of a machine of *robot*. Raises `InputError` where it has none, or not one for each line."""
    drives, lines = settings.drives, [line.name for line in robot.lines]
    if drives is None:
        why = 'kind = "canopen" and a table [drives] are expected'
        raise InputError(f"machine {settings.name!r}: kind = {settings.kind!r}: has no real drives; {why}")
    if odd := sorted(set(drives.nodes) ^ set(lines)):
        why = f"one node for each line of the robot is expected: {', '.join(lines)}"
        raise InputError(f"drives.nodes: {odd[0]!r}: {why}")
    return drives
