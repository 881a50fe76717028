"""Limits of connections to the page's server, so that strangers cannot block a stop."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from enum import Enum
from typing import Final

from uvicorn.protocols.http.h11_impl import H11Protocol

MAX_OPEN: Final = 256
"""Connections that are open at a time."""

STRANGERS_TIME: Final = 10.0
"""Time in which a connection has to show a token or a key, s."""

Peer = tuple[str, int]


class Holder(Enum):
    """Kind of a connection's holder; the value is how many may be open, so that some are left for strangers."""

    TOKEN = 128
    KEY = 64


@dataclass(eq=False)
class _Open:
    transport: asyncio.Transport
    holder: Holder | None = None


@dataclass(eq=False)
class Connections:
    """All open connections, by remote address, the oldest first."""

    _open: dict[Peer, _Open] = field(default_factory=dict)

    def enter(self, peer: Peer, transport: asyncio.Transport) -> None:
        """Add a new connection, of a stranger as yet. Where there are too many, the oldest stranger is closed."""
        self._open = {at: each for at, each in self._open.items() if not each.transport.is_closing()}
        strangers = [each for each in self._open.values() if each.holder is None]
        if strangers and len(self._open) >= MAX_OPEN:
            strangers[0].transport.abort()
        made = _Open(transport)
        self._open[peer] = made
        asyncio.get_running_loop().call_later(STRANGERS_TIME, self._close_stranger, made)

    def admits(self, peer: Peer | None, holder: Holder) -> bool:
        """Return whether a connection whose request shows a token or a key stays open.

        With too many of a kind it does not.
        """
        found = None if peer is None else self._open.get(peer)
        if found is None or found.holder is holder:
            return True
        alike = (each for each in self._open.values() if each.holder is holder)
        if sum(not each.transport.is_closing() for each in alike) >= holder.value:
            return False
        found.holder = holder
        return True

    @staticmethod
    def _close_stranger(found: _Open) -> None:
        if found.holder is None and not found.transport.is_closing():
            found.transport.abort()


def protocol_with(connections: Connections) -> type[H11Protocol]:
    """Return uvicorn's HTTP protocol class, whose connections are counted in *connections*."""

    class Entered(H11Protocol):
        def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
            super().connection_made(transport)
            if self.client is not None:
                connections.enter(self.client, transport)

    return Entered
