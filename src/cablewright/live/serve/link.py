"""The link between the control process and the page's server: states one way, messages the other.

Neither end ever waits for the other: states are replaced, messages that do not fit are rejected immediately. Stops have
a channel of their own, so that no other message is before them.
"""

from __future__ import annotations

import socket
import struct
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Final

from cablewright.control.orders import STOPS
from cablewright.foundation.signals import ORDER_LIFE
from cablewright.live.serve.latest_shared_message import Latest, shared
from cablewright.live.serve.messages import MAX_MESSAGE, ChannelName, Message, OrderMessage, parsed

STATE_SIZE: Final = 4 << 20
"""Bytes of the state and its topics."""

SITTING_SIZE: Final = 2 << 20
"""Bytes of the data that are fixed for a sitting."""

LEASE: Final = struct.Struct("=Qd")
"""Number of the lease, and when the server reported it, s of the monotonic clock."""

_MOST: Final = 32  # messages of a channel that are taken in one step


@dataclass(eq=False)
class ControlLink:
    """The control's end of the link.

    ``state``, ``sitting``: its reports; ``told_lease``: the lease that the server has reported. It outlives the servers
    at its other end.
    """

    state: Latest
    sitting: Latest
    told_lease: Latest
    _orders: socket.socket | None = None
    _stops: socket.socket | None = None
    clock: Callable[[], float] = time.monotonic  # that of the server
    _stopped: float = 0.0  # s, when the server received the latest order to stop or pause

    @classmethod
    def new(cls) -> ControlLink:
        """Return a new link of the machine's control, not yet connected to a server."""
        return cls(shared(STATE_SIZE), shared(SITTING_SIZE), shared(LEASE.size))

    def connect(self) -> tuple[socket.socket, socket.socket]:
        """Return the server's ends of new channels for orders and stops; old messages and the lease are dropped."""
        self.told_lease.write(LEASE.pack(0, 0.0))
        ours, theirs = zip(*(socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM) for _ in range(2)), strict=True)
        for each in ours:
            each.setblocking(False)
        old = self._orders, self._stops
        self._stops, self._orders = ours[1], ours[0]
        for channel in old:
            if channel is not None:
                channel.close()
        return theirs[0], theirs[1]

    def close(self) -> None:
        """Free the control's shared memory and channels."""
        for channel in (self._orders, self._stops):
            if channel is not None:
                channel.close()
        for memory in (self.state, self.sitting, self.told_lease):
            memory.close()

    @property
    def lease(self) -> int:
        """Number of the operator's lease; 0: no operator, or the server does not confirm it any more."""
        _, data = self.told_lease.read()
        number, time_told = LEASE.unpack(data) if data else (0, 0.0)
        return int(number) if self.clock() - time_told <= ORDER_LIFE else 0

    def age(self, message: Message) -> float:
        """Age of the server's last message, s, not under 0."""
        return max(0.0, self.clock() - message.at)

    def untimely(self, message: Message) -> str:
        """Return why a message must not be carried out; empty: it may.

        Reasons: a stop overtook it, its lease has ended, or it is old. The loop judges the age of an order by the
        machine's clock.
        """
        if message.at < self._stopped:
            return "it was ordered before the last stop"
        if not message.lease or message.lease != self.lease:
            return f"{message.by} does not operate the machine any more"
        old = 0.0 if isinstance(message, OrderMessage) else self.age(message)
        return f"it was ordered {old:.1f} s ago; at most {ORDER_LIFE:g} s are allowed" if old > ORDER_LIFE else ""

    def messages(self) -> Iterator[Message]:
        """Return the messages that have arrived, stops first; invalid ones are left out."""
        for channel in (self._stops, self._orders):
            for _ in range(_MOST if channel is not None else 0):
                assert channel is not None
                try:
                    data = channel.recv(MAX_MESSAGE)
                except OSError:  # nothing is there, or the server has gone
                    break
                message = parsed(data)
                if isinstance(message, OrderMessage) and message.kind in STOPS:
                    self._stopped = max(self._stopped, message.at)
                if message is not None:
                    yield message


@dataclass(eq=False)
class ServerLink:
    """The server's end of the link, on files and sockets that it inherited."""

    state: Latest
    sitting: Latest
    lease: Latest
    _orders: socket.socket
    _stops: socket.socket
    clock: Callable[[], float] = time.monotonic

    @classmethod
    def of(cls, state: int, sitting: int, lease: int, orders: int, stops: int) -> ServerLink:
        """Return the server's end of the link from file descriptors."""
        ends = [socket.socket(fileno=number) for number in (orders, stops)]
        for each in ends:
            each.setblocking(False)
        memories = Latest(state, STATE_SIZE), Latest(sitting, SITTING_SIZE), Latest(lease, LEASE.size)
        return cls(*memories, ends[0], ends[1])

    def close(self) -> None:
        """Free the server's shared memory and channels."""
        for each in (self._orders, self._stops):
            each.close()
        for memory in (self.state, self.sitting, self.lease):
            memory.close()

    def tell_lease(self, number: int) -> None:
        """Pass the operator's lease to the control, or 0 without an operator. It expires after `ORDER_LIFE`."""
        self.lease.write(LEASE.pack(number, self.clock()))

    def send(self, message: Message, channel: ChannelName = "orders") -> bool:
        """Send a message; return whether the control can receive it now."""
        data = message.model_dump_json().encode()
        with suppress(OSError):
            return (self._stops if channel == "stops" else self._orders).send(data) == len(data)
        return False
