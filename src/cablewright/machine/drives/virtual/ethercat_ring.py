"""A ring of virtual EtherCAT drives on one end of a cable, by the clock: each datagram passes all of them."""

from __future__ import annotations

import select
import socket
import struct
import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import Final, NamedTuple

from cablewright.foundation.errors import EnvironmentFault
from cablewright.machine.drives.virtual.ethercat_slave import EthercatSlave
from cablewright.machine.drives.virtual.rig import MADE_UP, VirtualRig
from cablewright.machine.drives.virtual.slave_memory import STATION

_ETHERTYPE: Final = 0x88A4
_HEADER, _DATAGRAM = 14, 10  # bytes
_LONGEST: Final = 1514
_POSITION, _ADDRESS, _ALL, _LOGICAL = 0, 1, 2, 3  # how a command finds its slaves
_READS, _WRITES = 1, 2
_COMMANDS: Final = {
    1: (_POSITION, _READS), 2: (_POSITION, _WRITES), 3: (_POSITION, _READS | _WRITES),
    4: (_ADDRESS, _READS), 5: (_ADDRESS, _WRITES), 6: (_ADDRESS, _READS | _WRITES),
    7: (_ALL, _READS), 8: (_ALL, _WRITES), 9: (_ALL, _READS | _WRITES),
    10: (_LOGICAL, _READS), 11: (_LOGICAL, _WRITES), 12: (_LOGICAL, _READS | _WRITES),
}  # fmt: skip


class _Way(NamedTuple):
    """How a command is done."""

    finds: int
    reads: bool
    writes: bool

    @property
    def weight(self) -> int:
        """Increment of the working counter by a write."""
        return 2 if self.reads else 1


class VirtualRing:
    """The drives of a *rig*, in the order of their nodes, as slaves of a ring."""

    def __init__(self, rig: VirtualRig) -> None:
        """All in the state init."""
        drives = sorted(rig.drives, key=lambda drive: drive.node)
        self.rig = rig
        self.slaves = tuple(EthercatSlave(drive, last=drive is drives[-1]) for drive in drives)

    def passed(self, frame: bytes, now: float) -> bytes | None:
        """Return a frame as it comes back at *now*, s; None for a malformed one, or one that does not come back."""
        if len(frame) < _HEADER + 2 or int.from_bytes(frame[12:14], "big") != _ETHERTYPE:
            return None
        if any(slave.cut for slave in self.slaves[:1]):
            return None
        data, at, more = bytearray(frame), _HEADER + 2, True
        while more:
            if at + _DATAGRAM > len(data):
                return None
            size = int.from_bytes(data[at + 6 : at + 8], "little")
            more, size = bool(size & 0x8000), size & 0x07FF
            if at + _DATAGRAM + size + 2 > len(data):
                return None
            self._datagram(data, at, size, now)
            at += _DATAGRAM + size + 2
        data[6] |= 0x02  # as the first slave marks it
        return bytes(data)

    def _datagram(self, data: bytearray, at: int, size: int, now: float) -> None:
        finds, does = _COMMANDS.get(data[at], (None, 0))
        if finds is None:
            return
        way = _Way(finds, bool(does & _READS), bool(does & _WRITES))
        body, end = slice(at + _DATAGRAM, at + _DATAGRAM + size), at + _DATAGRAM + size
        counter = int.from_bytes(data[end : end + 2], "little")
        for slave in self.slaves:
            if slave.cut:
                break  # its port is closed: the frame turns round before it
            address, offset = struct.unpack_from("<HH", data, at + 2)
            if way.finds == _LOGICAL:
                counter += _logical(slave, way, address | offset << 16, data, body, now)
                continue
            meant = way.finds == _ALL or (
                address == 0 if way.finds == _POSITION else address == slave.memory.get(STATION, 2)
            )
            if way.finds != _ADDRESS:
                struct.pack_into("<H", data, at + 2, (address + 1) & 0xFFFF)
            if meant:
                counter += _physical(slave, way, offset, data, body, now)
        data[end : end + 2] = (counter & 0xFFFF).to_bytes(2, "little")


def _physical(slave: EthercatSlave, way: _Way, at: int, data: bytearray, body: slice, now: float) -> int:
    """Do a command in one slave's memory; return what it adds to the working counter."""
    given, counted = bytes(data[body]), 0
    if way.reads:
        found = slave.read(at, len(given))
        if found is not None and len(found) == len(given):
            counted += 1
            every = way.finds == _ALL  # whose answers are put together
            data[body] = bytes(a | b for a, b in zip(given, found, strict=True)) if every else found
    if way.writes and slave.write(at, given, now):
        counted += way.weight
    return counted


def _logical(slave: EthercatSlave, way: _Way, start: int, data: bytearray, body: slice, now: float) -> int:
    """Do a command in the windows of one slave; return what it adds to the working counter."""
    counted, end = 0, start + body.stop - body.start
    wrote = read = False
    for window in slave.windows():
        low, high = max(start, window.logical), min(end, window.logical + window.size)
        if low >= high:
            continue
        part = slice(body.start + low - start, body.start + high - start)
        place = window.physical + low - window.logical
        if window.writes and way.writes:
            wrote |= slave.write(place, bytes(data[part]), now)
        elif not window.writes and way.reads:
            found = slave.read(place, high - low)
            if found is not None:
                data[part], read = found, True
    counted += way.weight * wrote + read
    return counted


def run_ring(
    ring: VirtualRing,
    interface: str,
    ends: Callable[[], bool] = lambda: False,
    ready: Callable[[], None] = lambda: None,
) -> None:
    """Run a virtual ring by the clock on a network interface, until *ends*; a longer standstill is skipped.

    Raises `EnvironmentFault` where the interface is not available.
    """
    port = _opened(interface)
    ready()
    rig = ring.rig
    due = time.monotonic()
    with port:
        while not ends():
            due += rig.tick
            while (left := due - time.monotonic()) > 0.0:
                if not select.select([port], [], [], left)[0]:
                    break
                back = ring.passed(port.recv(2 * _LONGEST), time.monotonic())
                if back is not None:
                    port.send(back)
            now = time.monotonic()
            due = max(due, now - MADE_UP)
            rig.advance(now)
            for slave in ring.slaves:
                slave.tick(now)


def _opened(interface: str) -> socket.socket:
    with ExitStack() as stack:
        try:
            found = stack.enter_context(socket.socket(socket.AF_PACKET, socket.SOCK_RAW))
            found.bind((interface, _ETHERTYPE))
        except (AttributeError, OSError) as error:
            why = f"{error}; it takes Linux, root, and an interface that is up"
            raise EnvironmentFault(f"drives.channel = {interface!r}: cannot be had for virtual drives: {why}") from None
        stack.pop_all()
        return found
