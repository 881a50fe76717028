"""One open page: it gets the latest state, and what it asks for is examined before the control hears of it.

``/live`` is a WebSocket of JSON messages; ``t`` is the kind. From the server:

* ``hello``: ``page``, the secret of this page, for the header ``X-Page`` of requests that only the operator may make;
  ``number``; ``foxglove``; ``camera``, its address or an empty text.
* ``sitting``, what is fixed: ``robot``, ``machine``, ``lines``, ``limits``, ``frame``, ``jog_speed``, ``winch_names``
  (null if single winches cannot be turned), ``resumed`` (whether a run continues), ``plane`` (null, or of motions by
  hand ``normal``, ``distance`` and two directions ``along`` it), ``damped`` (whether swings are damped; ``damping`` of
  the state: now), ``procedures``, ``orders`` (states in which each has an effect), ``job``, ``run``, ``path``.
* ``state``, 25 a second, the latest only: ``beat``, ``age``, ``operator``, ``stops`` (how many were sent), ``curves``
  of the lines, and ``control``: state, reason, time, progress, lines, platform, faults, events, answers.
* ``lease``, ``answer``, ``jog``: ``refusal``, why not, or empty; an answer has the ``id`` of its order.

To the server:

* ``take``, ``release``: the lease, with a ``name``.
* ``order``: ``id``, higher than the last; ``kind``; ``arguments``: lists of numbers, SI; ``beat`` of the state that was
  seen, where the page has one.
* ``jog``: ``seq``, higher than the last; ``beat``; ``velocity``, m/s, or ``winch``: number and m/s of cable of one that
  turns already; the order ``take up`` with the same ``winch`` begins it.
* ``stop``, ``beat``: a stop; a sign of life.
"""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Coroutine
from typing import Any, Final, TypeGuard

from pydantic import ValidationError
from pydantic_core import from_json, to_json
from starlette.websockets import WebSocket, WebSocketDisconnect

from cablewright.apps.serve.operators import OLD_STATE, Client
from cablewright.apps.serve.shared_state import Served
from cablewright.control.orders import CALMING
from cablewright.foundation.signals import ORDER_LIFE, OrderKind
from cablewright.live.serve.messages import OrderMessage
from cablewright.live.serve.winch import HELD, WINCH

ALL_MAY: Final = (OrderKind.EMERGENCY,)
"""Orders that need no lease."""


class Live:
    """One open page: its connection, its lease and its messages."""

    def __init__(self, page: Served, socket: WebSocket) -> None:
        """Not yet accepted."""
        self.page, self.socket = page, socket
        self._waiting: set[asyncio.Task[None]] = set()

    async def run(self) -> None:
        """Serve until the page disconnects; then its lease ends."""
        client = self.page.operators.join(self.socket.scope["session"])
        if client is None:
            await self.socket.close(1013)
            return
        await self.socket.accept()
        sending = asyncio.create_task(self._send(client))
        try:
            await self._hear(client)
        except (WebSocketDisconnect, RuntimeError):
            pass  # it has gone
        finally:
            self.page.operators.leave(client)
            for each in (sending, *self._waiting):
                each.cancel()
            with contextlib.suppress(WebSocketDisconnect, RuntimeError):
                await self.socket.close(1008)

    async def _send(self, client: Client) -> None:
        """Send the latest state, and what is between two is left out."""
        feed, version, sitting = self.page.feed, 0, ""
        try:
            hello = {"t": "hello", "page": client.secret, "number": client.number}
            await self.socket.send_text(
                to_json(hello | {"foxglove": self.page.access.view_token, "camera": self.page.camera}).decode()
            )
            while True:
                if feed.sitting_text != sitting:
                    sitting = feed.sitting_text
                    await self.socket.send_text(sitting)
                version = await feed.next(version)
                await self.socket.send_text(feed.text)
        except (WebSocketDisconnect, RuntimeError):
            pass  # it has gone

    async def _hear(self, client: Client) -> None:
        while True:
            message = await self.socket.receive()
            data = message.get("text")
            if message["type"] != "websocket.receive" or data is None:
                return  # it has gone, or sends what no page does
            if not client.messages.take():
                return  # too many messages: no person at a page
            try:
                given = from_json(data)
            except ValueError:
                continue
            if isinstance(given, dict):
                self.page.operators.look()
                client.last = time.monotonic()
                self._take(client, given)

    def _take(self, client: Client, given: dict[str, Any]) -> None:
        """One message."""
        match given.get("t"):
            case "stop":
                self.page.send_stop(client.title)
            case "take":
                refusal = self._late(given) or self.page.operators.take(client, given.get("name"))
                self._tell({"t": "lease", "refusal": refusal})
                self.page.link.tell_lease(self.page.operators.lease)
            case "release":
                self.page.operators.release(client)
                self.page.link.tell_lease(self.page.operators.lease)
            case "jog":
                self._jog(client, given)
            case "order":
                self._order(client, given)

    def _jog(self, client: Client, given: dict[str, Any]) -> None:
        """One lease of a jog: newer than the last, of who operates, on a state that was seen just now."""
        number = given.get("seq")
        if not _is_whole(number) or not _is_whole(given.get("beat")) or number <= client.jog:
            return
        client.jog = number
        if self.page.operators.operator is not client:
            self._tell({"t": "jog", "refusal": "you do not operate the machine"})
        elif late := self._late(given, OLD_STATE):
            self._tell({"t": "jog", "refusal": late})
        elif not self._sent(client, *_jog_of(given), next(self.page.numbers)):
            self._tell({"t": "jog", "refusal": "it is no velocity, or the control does not answer"})

    def _late(self, given: dict[str, Any], most: float = ORDER_LIFE) -> str:
        """Why a message comes too late after the state that its page names as seen, or a hang; or an empty text."""
        if why := self.page.operators.delayed:
            return why
        beat = given.get("beat")
        age = 1e-3 * (self.page.feed.beat() - beat) if _is_whole(beat) else 0.0
        return "" if -0.1 < age < most else f"it came {age:.1f} s after the state that you saw"

    def _order(self, client: Client, given: dict[str, Any]) -> None:
        """One order, which is answered."""
        asked = given.get("id")
        if not _is_whole(asked) or asked <= client.asked:
            return
        client.asked = asked
        kind = _kind(given.get("kind"))
        if kind in ALL_MAY:
            sent = self.page.send_stop(client.title)
            self._tell({"t": "answer", "id": asked, "refusal": "" if sent else "the control does not answer"})
            return
        number = next(self.page.numbers)
        why = ""
        if kind is None or kind is OrderKind.JOG:
            why = "there is no such order"
        elif self.page.operators.operator is not client:
            why = "you do not operate the machine"
        elif kind not in CALMING and (late := self._late(given)):
            why = late
        elif not client.orders.take():
            why = "too many orders at the same time"
        elif not self._sent(client, kind, given.get("arguments", {}), number):
            why = "its arguments are no numbers, or the control does not answer"
        if why:
            self._tell({"t": "answer", "id": asked, "refusal": why})
        else:
            self._later(self._answer(asked, number, client.title))

    def _sent(self, client: Client, kind: OrderKind, arguments: object, number: int) -> bool:
        """Send an order to the control; False for one that is none, or that it cannot take now."""
        about = {"by": client.title, "number": number, "at": time.monotonic(), "lease": self.page.operators.lease}
        try:
            return self.page.link.send(OrderMessage.model_validate(about | {"kind": kind, "arguments": arguments}))
        except ValidationError:
            return False

    async def _answer(self, asked: int, number: int, by: str) -> None:
        refusal = await self.page.answer(number, by)
        await self._say({"t": "answer", "id": asked, "refusal": refusal})

    async def _say(self, message: dict[str, Any]) -> None:
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):  # it has gone
            await self.socket.send_text(to_json(message).decode())

    def _tell(self, message: dict[str, Any]) -> None:
        self._later(self._say(message))

    def _later(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.create_task(work)
        self._waiting.add(task)
        task.add_done_callback(self._waiting.discard)


def _jog_of(given: dict[str, Any]) -> tuple[OrderKind, dict[str, Any]]:
    """The order of a lease: of the platform, or of one winch that turns already."""
    if "winch" in given:
        return OrderKind.TAKE_UP, {WINCH: given["winch"], HELD: (1.0,)}
    return OrderKind.JOG, {"velocity": given.get("velocity")}


def _is_whole(value: object) -> TypeGuard[int]:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 1 << 53


def _kind(value: object) -> OrderKind | None:
    try:
        return OrderKind(value) if isinstance(value, str) else None
    except ValueError:
        return None
