"""CANopen drives on one bus: identification, parameters, and the cycle of SYNC and PDOs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from cablewright.foundation.errors import EnvironmentFault
from cablewright.machine.drives import objects as o
from cablewright.machine.drives.acyclic_requests import require_agreed
from cablewright.machine.drives.axis import Axis, Setpoint
from cablewright.machine.drives.can_bus import BusError, CanFrame, Port
from cablewright.machine.drives.drum_units import Scale
from cablewright.machine.drives.identity import Asked, Identity
from cablewright.machine.drives.object_transfers import TIMEOUT, Transfer
from cablewright.machine.drives.parameters import ObjectParameter
from cablewright.machine.drives.sdo import SdoClient
from cablewright.machine.drives.statistics import BusStatistics

LISTEN: Final = 0.3
"""Time for which a bus is listened to before anything is sent on it, s: whoever else commands drives is heard."""

_HEARTBEATS: Final = 4  # in the time after which drives miss them
_DOUBLE: Final = 0.02  # s after an answer in which a second node with its number would answer too
_CONFIRMED: Final = 2  # cycles in a row with an error of the bus
_WINDOW: Final = 0.5  # of a period, for the answers to a SYNC


class Network:
    """The drives of *axes* on the bus behind *port*. Nothing is sent before `listen`."""

    def __init__(self, port: Port, axes: tuple[Axis, ...], host: int, heartbeat_timeout: float) -> None:
        """*host*: node of this computer; *heartbeat_timeout*: s, after which drives stop without it."""
        self.port, self.axes, self.host = port, axes, host
        self.statistics = BusStatistics()
        self.master = ""  # what another master sent
        self.error = ""  # of the bus; while cycles run it stands as long as they fail, one after the other
        self._seen, self._failing = "", 0
        self._by_node = {axis.node: _Peer.of(axis) for axis in axes}
        self._interval, self._beaten = heartbeat_timeout / _HEARTBEATS, -float("inf")

    def listen(self) -> None:
        """Listen for another master on the bus. Raises `EnvironmentFault` if one is active, or the bus fails."""
        self.pump(self.port.now() + LISTEN)
        self.require_alone()

    def require_alone(self) -> None:
        """Raise `EnvironmentFault` where another master has been heard, or the bus has failed."""
        if self.master:
            raise EnvironmentFault(f"drives: another master is on the bus: {self.master}; end it first")
        if self.error:
            raise EnvironmentFault(f"drives: communication on the bus has failed: {self.error}")

    def send(self, frame: CanFrame) -> None:
        """Send one frame; an error is recorded."""
        self.statistics.sent += 1
        self.statistics.count(len(frame.data))
        try:
            self.port.send(frame)
        except BusError as error:
            self._failed(error)

    def command_state(self, command: int, node: int = 0) -> None:
        """Send a command of network management; node 0: to all."""
        self.send(CanFrame(o.NMT, bytes([command, node])))

    def beat(self) -> None:
        """Send this computer's heartbeat when due; in the control loop, so that it ends with the loop."""
        now = self.port.now()
        if now - self._beaten >= self._interval - 1e-9:
            self._beaten = now
            self.send(CanFrame(o.HEARTBEAT + self.host, bytes([o.OPERATIONAL])))

    def pump(self, until: float, *, answers: bool = False) -> None:
        """Process frames until that time, s; with *answers* no longer than until all drives have answered the SYNC."""
        while not (answers and not any(axis.pending for axis in self.axes)):
            self._transfer()
            try:
                frame = self.port.receive(until)
            except BusError as error:
                self._failed(error)
                frame = None
                if self.port.now() >= until:
                    return
                continue
            if frame is None:
                return
            self._take(frame)

    def cycle(
        self, setpoints: tuple[Setpoint, ...], due: float, period: float, *, reset: bool = False, beats: bool = True
    ) -> float:
        """Command *setpoints*, wait until *due*, and collect the answers to a SYNC; return its time, s.

        *beats*: whether this computer's heartbeat goes on; without it drives stop by themselves.
        """
        self._seen = ""
        for axis, setpoint in zip(self.axes, setpoints, strict=True):
            commands = axis.commands(setpoint, self.port.now(), reset=reset)
            for kind, data in zip((o.CONTROL_PDO, o.TORQUE_PDO), commands, strict=True):
                self.send(CanFrame(kind + axis.node, data))
        if beats:
            self.beat()
        self.pump(due)
        numbers, now = self.statistics, self.port.now()
        numbers.cycles += 1
        numbers.lateness.append(now - due)
        numbers.late_cycles += now - due > 0.5 * period
        for axis in self.axes:
            axis.begin_cycle()
        self.send(CanFrame(o.SYNC))
        self.pump(now + _WINDOW * period, answers=True)
        numbers.missed += sum(bool(axis.pending) for axis in self.axes)
        numbers.answer.append(self.port.now() - now)
        self._failing = self._failing + 1 if self._seen else 0
        self.error = self._seen if self._failing >= _CONFIRMED else ""
        return now

    def identify(self, node: int) -> Identity | None:
        """Ask a node for its identity; None: no answer."""
        peer = self._by_node.get(node)
        asked = _stranger(node) if peer is None else _Peer.of(Axis(f"node {node}", node, peer.axis.scale))
        known, self._by_node[node] = peer, asked
        try:
            return self._identified(asked)
        finally:
            del self._by_node[node]
            if known is not None:
                self._by_node[node] = known

    def _identified(self, asked: _Peer) -> Identity | None:
        transfers = asked.axis.transfers
        first = transfers.add(Transfer(o.DEVICE_TYPE))
        self.finish(asked.axis)
        if first.failure:
            return None
        asked.answers = 0
        told = Asked(transfers)
        self.finish(asked.axis)
        requests = asked.client.sent - 1
        self.pump(self.port.now() + _DOUBLE)
        return told.identity(asked.axis.node, twice=asked.answers > requests)

    def scan(self) -> tuple[Identity, ...]:
        """Ask all nodes of the bus for their identity."""
        asked = {node: _stranger(node) for node in range(1, o.MAX_NODE + 1) if node != self.host}
        own, self._by_node = self._by_node, asked
        try:
            first = {node: peer.axis.transfers.add(Transfer(o.DEVICE_TYPE)) for node, peer in asked.items()}
            end = self.port.now() + 2.0 * TIMEOUT
            while self.port.now() < end - 1e-6 and not all(each.done for each in first.values()):
                self.pump(min(end, self.port.now() + 0.1 * TIMEOUT))
        finally:
            self._by_node = own
        self.require_alone()
        found = [self.identify(node) for node, each in first.items() if each.done and not each.failure]
        return tuple(each for each in found if each is not None)

    def now(self) -> float:
        """Return the time, s; see `Carrier.now`."""
        return self.port.now()

    def wait(self, seconds: float) -> None:
        """Wait for this time, s; see `Carrier.wait`."""
        self.pump(self.port.now() + seconds)

    def finish(self, axis: Axis) -> None:
        """Finish the waiting transfers; see `Carrier.finish`."""
        while not axis.transfers.idle:
            self.pump(self.port.now() + 0.1 * TIMEOUT)

    def check(self, parameters: dict[str, list[ObjectParameter]], *, write: bool) -> None:
        """Begin to write parameters by line, and to read them back; see `Axis.checking`."""
        for axis in self.axes:
            axis.failure = ""
            axis.check(parameters[axis.name], write=write)

    @property
    def checking(self) -> bool:
        """Whether parameters of any drive are being transferred."""
        going = [axis.checking for axis in self.axes]  # each judges what is finished
        return any(going)

    def settle(self) -> None:
        """Transfer all parameters. Raises `InputError` for the first drive with a wrong one."""
        while self.checking:
            self.pump(self.port.now() + 0.1 * TIMEOUT)
            self.require_alone()
        for axis in self.axes:
            require_agreed(axis)

    def _transfer(self) -> None:
        now = self.port.now()
        for peer in self._by_node.values():
            if not peer.axis.transfers.idle and (frame := peer.client.due(now)) is not None:
                self.send(frame)

    def _take(self, frame: CanFrame) -> None:
        numbers = self.statistics
        numbers.received += 1
        numbers.count(len(frame.data))
        kind, node = frame.id & 0x780, frame.id & 0x7F
        if kind in _OF_MASTERS and (kind != o.SYNC or node == 0) and (kind != o.NMT or node == 0):
            self.master = self.master or f"it sends {_OF_MASTERS[kind]} (0x{frame.id:03X})"
            return
        if kind == o.HEARTBEAT and node == self.host:
            self.master = self.master or f"it has the node {node} of this computer"
            return
        peer = self._by_node.get(node)
        if peer is None:
            return
        if kind in _PDOS:
            numbers.malformed += not peer.axis.take_pdo(_PDOS[kind], frame.data, self.port.now())
        elif kind == o.SDO_ANSWER:
            peer.answers += 1
            further = peer.client.take(frame.data, self.port.now())
            if further is not None:
                self.send(further)
        elif kind == o.HEARTBEAT and frame.data[:1] == bytes([o.BOOTED]):
            peer.axis.restarted = True

    def _failed(self, error: BusError) -> None:
        self.statistics.errors += 1
        self._seen = str(error) or "the bus reports an error"
        if not self.statistics.cycles:
            self.error = self._seen


@dataclass(eq=False)
class _Peer:
    """A node and the transfers with it. ``answers``: frames that came of them."""

    axis: Axis
    client: SdoClient
    answers: int = 0

    @classmethod
    def of(cls, axis: Axis) -> _Peer:
        return cls(axis, SdoClient(axis.node, axis.transfers))


def _stranger(node: int) -> _Peer:
    return _Peer.of(Axis(f"node {node}", node, Scale(1.0, 1.0, 1.0, 1.0, (1.0, 1.0), 0.0, 0.0)))


_PDOS: Final = {o.STATE_PDO: 0, o.LOAD_PDO: 1, o.INPUT_PDO: 2}
_OF_MASTERS: Final = {
    o.NMT: "commands of network management",
    o.SYNC: "SYNC",
    o.CONTROL_PDO: "commands to drives",
    o.TORQUE_PDO: "commands to drives",
    0x400: "commands to drives",
    0x500: "commands to drives",
    o.SDO_REQUEST: "requests for objects",
}
