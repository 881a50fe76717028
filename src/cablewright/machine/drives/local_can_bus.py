"""A CAN bus between processes of this computer alone, over UDP bound to 127.0.0.1: virtual drives run in their own.

The process of the drives is the hub: it passes each frame on to all other members. python-can's own UDP bus cannot
be used for it, since that listens on all networks of the computer.
"""

from __future__ import annotations

import select
import socket
import time
from typing import Final

from cablewright.foundation.errors import EnvironmentFault
from cablewright.machine.drives.can_bus import BusError, CanFrame

_HOME: Final = "127.0.0.1"
_HELLO: Final = b""  # joins the bus, and is answered by the same
_MEMBER_TIME: Final = 10.0  # s without a frame after which the hub drops a member
_MAX_MEMBERS: Final = 16
_ANSWER_TIME: Final = 1.0  # s for the hub to answer
_STANDARD: Final = 1 << 11  # identifiers


def _packed(frame: CanFrame) -> bytes:
    return frame.id.to_bytes(2, "little") + frame.data


def _unpacked(data: bytes) -> CanFrame | None:
    """The frame of a datagram; None for one that is no frame."""
    number = int.from_bytes(data[:2], "little")
    return CanFrame(number, data[2:]) if 2 <= len(data) <= 10 and number < _STANDARD else None


def _waits(end: socket.socket, until: float) -> bool:
    """Whether a datagram is there by that time, s; a socket's own timeout is in whole milliseconds."""
    return bool(select.select([end], [], [], max(until - time.monotonic(), 0.0))[0])


class LoopbackPort:
    """A `Port` of a process that takes part in the bus of a hub."""

    def __init__(self, number: int) -> None:
        """Join the hub at that UDP port of this computer. Raises `EnvironmentFault` where none answers."""
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.connect((_HOME, number))
        try:
            self._socket.settimeout(_ANSWER_TIME)
            self._socket.send(_HELLO)
            self._socket.recv(64)
            self._socket.settimeout(None)
        except OSError:
            self._socket.close()
            why = "no drive answers there; `cablewright drives --virtual FILE` starts virtual drives"
            raise EnvironmentFault(f"drives: the bus loopback {number} cannot be opened: {why}") from None

    def now(self) -> float:
        """Return the time, s, by the clock of `receive`; see `Port.now`."""
        return time.monotonic()

    def send(self, frame: CanFrame) -> None:
        """Send one frame; see `Port.send`."""
        try:
            self._socket.send(_packed(frame))
        except OSError as error:
            raise BusError(f"the virtual drives are gone: {error.strerror}") from None

    def receive(self, until: float) -> CanFrame | None:
        """Return the next frame of other members until a time, s; see `Port.receive`."""
        while True:
            if not _waits(self._socket, until):
                return None
            try:
                frame = _unpacked(self._socket.recv(64))
            except OSError as error:
                raise BusError(f"the virtual drives are gone: {error.strerror}") from None
            if frame is not None:
                return frame

    def close(self) -> None:
        """Leave the bus; see `Port.close`."""
        self._socket.close()


class Hub:
    """The bus itself; its owner, the virtual drives, takes part in it as a `Port`."""

    def __init__(self, number: int) -> None:
        """Bind that UDP port of this computer. Raises `EnvironmentFault` where another program has it."""
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind((_HOME, number))
        except OSError as error:
            self._socket.close()
            raise EnvironmentFault(f"drives: UDP port {number} of {_HOME} cannot be opened: {error.strerror}") from None
        self._members: dict[tuple[str, int], float] = {}

    def now(self) -> float:
        """Return the time, s, by the clock of `receive`; see `Port.now`."""
        return time.monotonic()

    def send(self, frame: CanFrame) -> None:
        """Send one frame to all members; see `Port.send`."""
        self._tell(_packed(frame), None)

    def receive(self, until: float) -> CanFrame | None:
        """Return the next frame of other members until a time, s; see `Port.receive`.

        Received frames go to the other members too.
        """
        while True:
            if not _waits(self._socket, until):
                return None
            try:
                data, member = self._socket.recvfrom(64)
            except OSError:  # a member has gone
                continue
            if member not in self._members and len(self._members) >= _MAX_MEMBERS:
                continue
            self._members[member] = time.monotonic()
            if data == _HELLO:
                self._reply(member)
            elif (frame := _unpacked(data)) is not None:
                self._tell(data, member)
                return frame

    def close(self) -> None:
        """Leave the bus; see `Port.close`."""
        self._socket.close()

    def _reply(self, member: tuple[str, int]) -> None:
        try:
            self._socket.sendto(_HELLO, member)
        except OSError:
            self._members.pop(member, None)

    def _tell(self, data: bytes, sender: tuple[str, int] | None) -> None:
        oldest = time.monotonic() - _MEMBER_TIME
        for member, heard in list(self._members.items()):
            if heard < oldest:
                del self._members[member]
            elif member != sender:
                try:
                    self._socket.sendto(data, member)
                except OSError:
                    del self._members[member]
