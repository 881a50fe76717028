"""EtherCAT drives of the profile CiA 402, as `WinchDrives`.

A drive's place in the ring is its node, 1 the first. What stops a drive whose master has gone is the watchdog of its
outputs: it is armed and read back before anything is enabled. Where the heartbeat is to end, outputs are not sent any
more, and inputs are read without them.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Final

from cablewright.foundation.errors import CablewrightError, EnvironmentFault, InputError
from cablewright.machine.drives import objects as o
from cablewright.machine.drives.acyclic_requests import begin_speed_limits, bring_off, read_back, require_agreed
from cablewright.machine.drives.axis import Axis, Setpoint
from cablewright.machine.drives.canopen_network import LISTEN
from cablewright.machine.drives.drives_of_winches import axes_of, require_drives
from cablewright.machine.drives.ethercat.mailbox import Mailbox
from cablewright.machine.drives.ethercat.registers import armed, process_data, watchdog
from cablewright.machine.drives.ethercat.ring import ERROR, OP, PREOP, SAFEOP, STATES, Ring
from cablewright.machine.drives.identity import Asked, Identity
from cablewright.machine.drives.parameters import ObjectParameter, guards, shut
from cablewright.machine.drives.statistics import BusStatistics
from cablewright.machine.settings import MachineSettings
from cablewright.models.winch_lines import WinchLines
from cablewright.robot import Robot

_CONFIRMED: Final = 2  # cycles in a row in which no frame comes back
_OPERATE: Final = 1.0  # s for all drives to become operational
_STEP: Final = 0.005  # s between two looks at their states
_FROM_DRIVE: Final = [sum(each.size for each in mapped) for mapped in o.FROM_DRIVES]


class EthercatDrives:
    """The EtherCAT drives of a robot's winches, from its machine file."""

    def __init__(self, robot: Robot, settings: MachineSettings) -> None:
        """Raises `InputError` for a file that does not fit the robot."""
        self.settings, self._machine = require_drives(settings, robot), settings
        self.axes, self.winches = axes_of(robot, settings), WinchLines.of(robot)
        self._ring: Ring | None = None
        self._mailbox: Mailbox | None = None
        self.statistics = BusStatistics()
        self._by_place = sorted(self.axes, key=lambda axis: axis.node)
        self._left = ""  # which drive is not operational any more
        self._failing = 0  # cycles in a row in which no frame came back
        watchdog(self.settings)  # a time that it cannot have is said now

    @property
    def trouble(self) -> str:
        """Return the reason why the bus cannot be commanded, or an empty text; see `WinchDrives.trouble`."""
        return "no frame comes back: cable, interface, or supply" if self._failing >= _CONFIRMED else self._left

    @property
    def _open(self) -> tuple[Ring, Mailbox]:
        assert self._ring is not None
        assert self._mailbox is not None
        return self._ring, self._mailbox

    def now(self) -> float:
        """Return the time, s, by the clock of `cycle`; see `WinchDrives.now`."""
        return time.monotonic()

    def connect(self) -> Mailbox:
        """Listen, bring the ring to pre-operational, and ask all drives for their identity. Raises as `open`."""
        found = self._listen()
        nodes = {axis.node: axis.name for axis in self.axes}
        try:
            for node, name in nodes.items():
                if node > found:
                    why = f"the ring has {found} devices; check wiring and places" if found else "no device answers"
                    raise EnvironmentFault(f"drives.nodes.{name}.id = {node}: {why}")
            if found > len(nodes):
                why = f"of {found} devices in the ring the drives of lines are {len(nodes)}: take the others out of it"
                raise EnvironmentFault(f"drives.nodes: {why}")
            for axis in self.axes:
                identity = self._identity(axis)
                if identity is None:
                    raise EnvironmentFault(f"drives.nodes.{axis.name}.id = {axis.node}: its mailbox does not answer")
                identity.require(axis.name, self.settings.rated_torque)
        except CablewrightError:
            self._leave()
            raise
        return self._open[1]

    def _listen(self) -> int:
        """Open the interface, and count the devices."""
        self._ring = Ring.opened(self.settings.interface, self.settings.answer_timeout, LISTEN)
        self._mailbox = Mailbox(self._ring, self.axes)
        try:
            return self._ring.enumerate_devices()
        except CablewrightError:
            self._leave()
            raise

    def _identity(self, axis: Axis) -> Identity | None:
        asked = Asked(axis.transfers)
        self._open[1].finish(axis)
        return asked.identity(axis.node)

    def scan(self) -> tuple[Identity, ...]:
        """List all devices on the bus; see `WinchDrives.scan`.

        Devices are brought to pre-operational, which stops drives.
        """
        number = self._listen()
        scale = self.axes[0].scale
        try:
            found = [self._identity(Axis(f"node {k + 1}", k + 1, scale)) for k in range(number)]
            return tuple(each for each in found if each is not None)
        finally:
            self._leave()

    def read(self) -> dict[str, list[tuple[ObjectParameter, int | None]]]:
        """Return the parameters to write, and the present values of each drive; see `WinchDrives.read`.

        Devices are brought to pre-operational, which stops drives.
        """
        mailbox = self.connect()
        try:
            return read_back(mailbox, self.axes, self._parameters)
        finally:
            self._leave()

    def _parameters(self, axis: Axis) -> list[ObjectParameter]:
        """All that is written into a drive."""
        return process_data(axis.mapped) + self._guards(axis)

    def _guards(self, axis: Axis) -> list[ObjectParameter]:
        own = guards(self.settings, axis.scale, self._machine.winch.counts, self._machine.period)
        return watchdog(self.settings) + own + shut(axis.valve)

    def open(self) -> None:
        """Find the drives, and write and read back their settings; see `WinchDrives.open`."""
        self.statistics = BusStatistics()
        mailbox = self.connect()
        ring, _ = self._open
        try:
            bring_off(mailbox, self.axes, self.settings.stop_time(max(axis.scale.speed_of_cable for axis in self.axes)))
            for axis in self.axes:
                axis.begin(self.now())
                self._agree(axis, self._parameters(axis))
            self._require_sizes(ring.map_process_data())
            for axis in self.axes:
                self._agree(axis, [armed()])
            self._left, self._failing = "", 0
            if why := self._operate((Setpoint(),) * len(self.axes)):
                raise EnvironmentFault(f"drives: {why}")
        except CablewrightError:
            self._leave()
            raise

    def _agree(self, axis: Axis, parameters: list[ObjectParameter]) -> None:
        """Write parameters and read them back. Raises `InputError`."""
        axis.failure = ""
        axis.check(parameters, write=True)
        self._open[1].finish(axis)
        assert not axis.checking
        require_agreed(axis)

    def _require_sizes(self, found: list[tuple[int, int]]) -> None:
        """Raise `InputError` for a drive whose process data are of another length than the assigned one."""
        for axis, sizes in zip(self._by_place, found, strict=True):
            wanted = sum(each.size for mapped in axis.mapped for each in mapped), sum(_FROM_DRIVE)
            if sizes != wanted:
                why = f"its process data have {sizes[0]} and {sizes[1]} bytes, not {wanted[0]} and {wanted[1]}"
                raise InputError(f"the drive of line {axis.name} (node {axis.node}): {why}")

    def _operate(self, setpoints: tuple[Setpoint, ...], *, reset: bool = False) -> str:
        """Bring all drives to operational, while *setpoints* are sent; return which does not get there."""
        ring, images = self._open[0], self._images(setpoints, reset=reset)
        end = self.now() + _OPERATE
        while True:
            with_errors = self._exchanged(images)
            late = {k: state for k, state in enumerate(ring.states()) if state != OP}
            if not late:
                self._left = ""
                return ""
            if self.now() > end:
                return with_errors or self._told(*next(iter(late.items())))
            for k, state in late.items():
                if state & ERROR:
                    ring.request(k, (state & 0x0F) | ERROR)
                elif state == SAFEOP:
                    ring.request(k, OP)
            time.sleep(_STEP)

    def _exchanged(self, images: list[bytes]) -> str:
        try:
            self._open[0].exchange(images)
        except OSError as error:
            return str(error)
        return ""

    def _told(self, place: int, state: int) -> str:
        """Which drive is in a state that it should not be in, and why."""
        axis, known = self._by_place[place], STATES.get(state & 0x0F, f"state {state & 0x0F}")
        cause = f": {self._open[0].cause(place)}" if state & ERROR else ""
        return f"{axis.name}: its drive is {known}, not operational{cause}"

    def begin_checks(self) -> None:
        """Begin to write and read back the drives' own supervision, within the cycles; see `WinchDrives.begin_checks`.

        Process data are only read, since they can be changed in another state alone.
        """
        for axis in self.axes:
            axis.failure = ""
            axis.check([*[each for each in process_data(axis.mapped) if each.lasts], armed()], write=False)
            axis.check(self._guards(axis), write=True)
        self._open[1].work()

    def begin_speed_limits(self, tension: Sequence[bool]) -> None:
        """Begin to set the speed limits of drives for torque mode; see `WinchDrives.begin_speed_limits`."""
        begin_speed_limits(self.axes, tension, self.settings.tension_speed)
        self._open[1].work()

    @property
    def checking(self) -> bool:
        """Return whether parameters are still being transferred; see `WinchDrives.checking`."""
        self._open[1].work()
        going = [axis.checking for axis in self.axes]  # each judges what is finished
        return any(going)

    def cycle(self, setpoints: tuple[Setpoint, ...], due: float, *, reset: bool = False, beats: bool = True) -> float:
        """Command *setpoints*, wait until *due*, s, and take the answers; see `WinchDrives.cycle`.

        Commands go out immediately, and are sent again when answers are due.
        """
        numbers = self.statistics
        if reset and beats:
            self._operate(setpoints, reset=True)
        images = self._images(setpoints, reset=reset)
        if beats:
            self._answers(images)
        time.sleep(max(due - self.now(), 0.0))
        now = self.now()
        numbers.cycles += 1
        numbers.lateness.append(now - due)
        numbers.late_cycles += now - due > 0.5 * self._machine.period
        for axis in self.axes:
            axis.begin_cycle()
        self._take(self._answers(images if beats else None), now)
        numbers.missed += sum(bool(axis.pending) for axis in self.axes)
        numbers.answer.append(self.now() - now)
        self._judge(self._open[0].states())
        return now

    def _images(self, setpoints: tuple[Setpoint, ...], *, reset: bool) -> list[bytes]:
        """The outputs of each drive by its place in the ring."""
        now = self.now()
        by_node = {
            axis.node: b"".join(axis.commands(setpoint, now, reset=reset))
            for axis, setpoint in zip(self.axes, setpoints, strict=True)
        }
        return [by_node[node] for node in sorted(by_node)]

    def _answers(self, images: list[bytes] | None) -> list[bytes | None]:
        """The inputs by place, after *images* were sent; None: nothing is."""
        ring, numbers = self._open[0], self.statistics
        numbers.sent += 1
        try:
            found = ring.ask() if images is None else ring.exchange(images)
        except OSError:
            numbers.errors += 1
            self._failing += 1
            return [None] * len(self.axes)
        self._failing = 0
        numbers.received += 1
        return found

    def _take(self, answers: list[bytes | None], now: float) -> None:
        """Take what drives answered at *now*, s."""
        for axis, data in zip(self._by_place, answers, strict=True):
            if data is None:
                continue
            at = 0
            for which, size in enumerate(_FROM_DRIVE):
                axis.take_pdo(which, data[at : at + size], now)
                at += size

    def _judge(self, states: list[int]) -> None:
        """Notice drives that are not operational any more."""
        self._left = ""
        for place, state in enumerate(states):
            axis = self._by_place[place]
            if state & 0x0F and state & 0x0F <= PREOP:
                axis.restarted = True
            elif state and state != OP:
                self._left = self._left or self._told(place, state)

    def close(self, *, proven: bool) -> None:
        """Leave the drives and the bus; see `WinchDrives.close`.

        Devices go back to init, or are left to their watchdogs.
        """
        if self._ring is None or self._mailbox is None:
            return
        self._mailbox.end()
        if proven:
            self._ring.leave()
        self._leave()

    def _leave(self) -> None:
        ring, self._ring = self._ring, None
        if self._mailbox is not None:
            self._mailbox.end()
            self._mailbox = None
        if ring is not None:
            ring.close()
