"""Open pages, and the one that operates: one at a time, as long as that page responds."""

from __future__ import annotations

import re
import secrets
import time
from dataclasses import dataclass, field
from typing import Final

from cablewright.apps.serve.access import Bucket
from cablewright.foundation.errors import printable
from cablewright.foundation.signals import ORDER_LIFE

SILENCE: Final = 5.0
"""Time without a message after which a page operates no more, s."""

OLD_STATE: Final = 0.4
"""Age of the state that a page saw when it asks for a jog, from which that is rejected, s."""

MAX_CLIENTS: Final = 32
"""Pages that are open at a time."""

_ORDERS: Final = Bucket(40, 15.0)


@dataclass(eq=False)
class Client:
    """An open page. ``secret`` is known to this page alone; ``name``: name of the person who uses it."""

    session: str
    secret: str = field(default_factory=lambda: secrets.token_urlsafe(24))
    number: str = field(default_factory=lambda: secrets.token_hex(2))
    name: str = ""
    last: float = field(default_factory=time.monotonic)  # s, of its last message
    jog: int = -1  # of its last jog
    asked: int = -1  # of its last order
    orders: Bucket = field(default_factory=lambda: Bucket(_ORDERS.most, _ORDERS.rate))
    messages: Bucket = field(default_factory=lambda: Bucket(120, 60.0))

    @property
    def title(self) -> str:
        """Name of the operator in logs."""
        return f"{self.name or 'somebody'} (page {self.number})"


def person(name: object) -> str:
    """Return a name as it may stand in a log: letters of one line, shortened."""
    return printable(re.sub(r"\s+", " ", name[:200]).strip())[:40] if isinstance(name, str) else ""


@dataclass(eq=False)
class Operators:
    """The pages that are open, and the one that operates."""

    clients: dict[str, Client] = field(default_factory=dict)
    _operator: Client | None = None
    _number: int = field(default_factory=lambda: round(1e3 * time.monotonic()))  # of the last lease
    _looked: float = field(default_factory=time.monotonic)  # s, when the server was last seen to run
    _hung: float = -float("inf")  # s, when it continued after a hang

    def look(self) -> None:
        """Record that the server runs, and end the lease of a page that was silent for too long or during a hang."""
        before, self._looked = self._looked, time.monotonic()
        if self._looked - before > ORDER_LIFE:
            self._hung = self._looked
        if self._looked - before > SILENCE:
            self._operator = None

    @property
    def delayed(self) -> str:
        """Reason why orders are rejected now, after a hang: messages may be old; or an empty text."""
        self.look()
        return "the server hung: order it again" if self._looked - self._hung < ORDER_LIFE else ""

    @property
    def lease(self) -> int:
        """Number of the lease of the page that operates; 0 where none does."""
        return 0 if self.operator is None else self._number

    def join(self, session: str) -> Client | None:
        """Add a new page; return it, or None where too many are open."""
        if len(self.clients) >= MAX_CLIENTS:
            return None
        client = Client(session)
        self.clients[client.secret] = client
        return client

    def leave(self, client: Client) -> None:
        """End the lease of a page that has disconnected."""
        self.clients.pop(client.secret, None)
        self.release(client)

    @property
    def operator(self) -> Client | None:
        """The open page that may operate; None if no page may, it was silent too long, or the server hung."""
        self.look()
        found = self._operator
        if found is not None and time.monotonic() - found.last > SILENCE:
            self._operator = found = None
        return found

    def take(self, client: Client, name: object) -> str:
        """Make this page the operator; return why not, or an empty text."""
        holder = self.operator
        if holder is not None and holder is not client:
            return f"{holder.title} operates the machine"
        client.name = person(name)
        self._number += holder is None
        self._operator = client
        return ""

    def release(self, client: Client) -> None:
        """End the operator's lease, the sole right to give orders."""
        if self._operator is client:
            self._operator = None

    def of_secret(self, secret: str) -> Client | None:
        """Return the open page that operates, if *secret* belongs to it."""
        found = self.operator
        return found if found is not None and secrets.compare_digest(found.secret.encode(), secret.encode()) else None
