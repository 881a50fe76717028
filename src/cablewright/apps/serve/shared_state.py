"""Data that the routes and the open pages share: the link to the control and its latest state."""

from __future__ import annotations

import asyncio
import itertools
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from cablewright.apps.serve.access import Access
from cablewright.apps.serve.checks import Checks
from cablewright.apps.serve.connections import Connections
from cablewright.apps.serve.feed import Feed
from cablewright.apps.serve.operators import Client, Operators
from cablewright.apps.serve.slicers.keys import Keys
from cablewright.apps.serve.uploads import Uploads
from cablewright.foundation.errors import EnvironmentFault, InputError
from cablewright.foundation.signals import OrderKind
from cablewright.live.serve.link import ServerLink
from cablewright.live.serve.messages import LoadMessage, OrderMessage

_ANSWER: Final = 2.0  # s to wait for the control's answer
_PARALLEL: Final = 2  # uploads at a time
_ALIKE: Final = 0.05  # s in which repeated stops count as one


@dataclass(eq=False, kw_only=True)
class Served:
    """A machine that is served. ``numbers``: numbers of orders, each used once."""

    access: Access
    link: ServerLink
    feed: Feed
    operators: Operators
    uploads: Uploads
    checks: Checks
    keys: Keys
    camera: str = ""  # address of a picture that the page shows
    news: Path | None = None  # file that names who gets news
    ros2: int | None = None  # domain of ROS 2 that gets the state
    connections: Connections = field(default_factory=Connections)
    sending: asyncio.Semaphore = field(default_factory=lambda: asyncio.Semaphore(_PARALLEL))
    numbers: Iterator[int] = field(default_factory=lambda: itertools.count(round(1e3 * time.monotonic())))
    _stopped: float = -1.0

    def send_stop(self, by: str) -> bool:
        """Send an order to stop by a channel of its own; return whether the control received it."""
        now = time.monotonic()
        self.feed.stops += 1
        if now - self._stopped < _ALIKE:
            return True
        message = OrderMessage(by=by, number=next(self.numbers), at=now, kind=OrderKind.EMERGENCY)
        sent = self.link.send(message, "stops")
        self._stopped = now if sent else -1.0
        return sent

    async def calm(self, kind: OrderKind, by: str) -> str:
        """Send an order to stop or pause, which needs no lease; return why it was rejected, or an empty text."""
        number = next(self.numbers)
        self.feed.stops += 1
        message = OrderMessage(by=by, number=number, at=time.monotonic(), kind=kind)
        return await self.answer(number, by) if self.link.send(message, "stops") else "the control does not answer"

    async def loaded(self, client: Client, **what: Any) -> dict[str, Any]:
        """Ask the control to load *what*. Raises `InputError`, `EnvironmentFault`."""
        number = next(self.numbers)
        about = {"by": client.title, "number": number, "at": time.monotonic(), "lease": self.operators.lease}
        if not self.link.send(LoadMessage(**about, **what)):
            raise EnvironmentFault("the control does not answer")
        if why := await self.answer(number, client.title):
            raise InputError(why)
        return {"loaded": what["load"]}

    async def answer(self, number: int, by: str) -> str:
        """Wait for the control's answer to a message: the reason of a rejection, or an empty text."""
        end = time.monotonic() + _ANSWER
        while time.monotonic() < end:
            found = self.feed.answer_of(number, by)
            if found is not None:
                return found
            await asyncio.sleep(0.02)
        return "the control has not answered yet"
