"""Live log for Foxglove by its WebSocket protocol, with the JSON topics of the log; read only.

Each topic's latest message is sent, ten times a second; the log of a run has them all. Both names of the protocol are
accepted.
"""

from __future__ import annotations

import asyncio
import json
import struct
from typing import Any, Final

from pydantic_core import from_json, to_json
from starlette.websockets import WebSocket, WebSocketDisconnect

from cablewright.apps.serve.feed import Feed
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Estimate, Progress
from cablewright.machine.log.foxglove_views import VIEWS, Views
from cablewright.machine.log.log import SCHEMAS
from cablewright.machine.log.messages import decode

PROTOCOLS: Final = ("foxglove.sdk.v1", "foxglove.websocket.v1")
"""Names of the protocol, the newer one first."""

MAX_CLIENTS: Final = 8
"""Programs that read at a time."""

EVERY: Final = 0.05
"""Between two looks at the latest messages, s."""

_HEAD: Final = struct.Struct("<BIQ")  # message data, subscription, time in ns
_MOST: Final = 200  # subscriptions of a client


class Reader:
    """One connected client of the live log."""

    def __init__(self, socket: WebSocket, feed: Feed) -> None:
        """Not yet accepted."""
        self.socket, self.feed = socket, feed
        self.channels: dict[str, int] = {}  # number of each topic that was advertised
        self.subscribed: dict[int, int] = {}  # subscription, by channel
        self._sent: dict[str, int] = {}  # time of the last message, by topic
        self._sitting: Any = None
        self._views: Views | None = None

    async def run(self) -> None:
        """Serve until the client disconnects."""
        offered = self.socket.scope.get("subprotocols", [])
        chosen = next((each for each in PROTOCOLS if each in offered), None)
        if chosen is None:
            await self.socket.close(1002)
            return
        await self.socket.accept(subprotocol=chosen)
        about = {
            "op": "serverInfo",
            "name": "cablewright",
            "capabilities": [],
            "supportedEncodings": [],
            "metadata": {},
        }
        await self.socket.send_text(json.dumps(about | {"sessionId": str(self.feed.beat())}))
        hearing = asyncio.create_task(self._hear())
        try:
            while not hearing.done():
                await self._send()
                await asyncio.sleep(EVERY)
        except (WebSocketDisconnect, RuntimeError):
            pass  # it has gone
        finally:
            hearing.cancel()

    async def _hear(self) -> None:
        while True:
            try:
                given = from_json(await self.socket.receive_text())
            except (WebSocketDisconnect, RuntimeError, KeyError):
                return
            except ValueError:
                continue
            if isinstance(given, dict):
                self._take(given)

    def _take(self, given: dict[str, Any]) -> None:
        """Subscribe or unsubscribe; nothing else is obeyed."""
        if given.get("op") == "subscribe":
            for each in _dicts(given.get("subscriptions")):
                channel, number = each.get("channelId"), each.get("id")
                if not isinstance(channel, int) or not isinstance(number, int) or not 0 <= number < 1 << 32:
                    continue
                if channel in self.channels.values() and len(self.subscribed) < _MOST:
                    self.subscribed[channel] = number
                    self._sent.clear()
        elif given.get("op") == "unsubscribe":
            ids = given.get("subscriptionIds")
            gone = {each for each in ids if isinstance(each, int)} if isinstance(ids, list) else set()
            self.subscribed = {channel: number for channel, number in self.subscribed.items() if number not in gone}

    async def _send(self) -> None:
        """Advertise what is new, and send what is newer."""
        feed = self.feed
        if feed.sitting is not self._sitting:
            self._sitting, self._views = feed.sitting, None if feed.head is None else Views(feed.head)
            self._sent.clear()
        messages = [(str(topic), int(stamp), data) for topic, stamp, data in from_json(feed.topics)]
        messages += self._seen(messages)
        new = [topic for topic, _, _ in messages if topic not in self.channels and topic in SCHEMAS]
        if new:
            await self.socket.send_text(
                json.dumps({"op": "advertise", "channels": [self._channel(each) for each in new]})
            )
        for topic, stamp, data in messages:
            number = self.subscribed.get(self.channels.get(topic, -1))
            if number is not None and self._sent.get(topic) != stamp:
                self._sent[topic] = stamp
                await self.socket.send_bytes(_HEAD.pack(1, number, max(stamp, 0)) + to_json(data))

    def _seen(self, messages: list[tuple[str, int, Any]]) -> list[tuple[str, int, Any]]:
        """What is for those who look: frames and a scene, from the latest estimate."""
        if self._views is None or not any(self.channels.get(topic) in self.subscribed for topic in VIEWS):
            return [] if self._views is None else self._first(messages)
        told = {topic: data for topic, _, data in messages}
        stamp = next((stamp for topic, stamp, _ in messages if topic == "/estimate"), 0)
        try:
            estimate = decode("/estimate", to_json(told["/estimate"]), "live")
            progress = decode("/progress", to_json(told["/progress"]), "live")
        except (InputError, KeyError):
            return []
        assert isinstance(estimate, Estimate)
        assert isinstance(progress, Progress)
        return [
            (topic, stamp, from_json(data))
            for topic, data in self._views.messages(estimate.time, None, estimate, progress)
        ]

    def _first(self, messages: list[tuple[str, int, Any]]) -> list[tuple[str, int, Any]]:
        """The topics of views by name, so that they are advertised where there is an estimate."""
        if not any(topic == "/estimate" for topic, _, _ in messages):
            return []
        return [(topic, 0, {}) for topic in VIEWS if topic not in self.channels]

    def _channel(self, topic: str) -> dict[str, Any]:
        number = self.channels[topic] = len(self.channels) + 1
        name, content = SCHEMAS[topic]
        about = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": name}
        schema = {"schemaName": name, "schema": json.dumps(about | content), "schemaEncoding": "jsonschema"}
        return {"id": number, "topic": topic, "encoding": "json"} | schema


def _dicts(values: object) -> list[dict[str, Any]]:
    return [each for each in values if isinstance(each, dict)] if isinstance(values, list) else []
