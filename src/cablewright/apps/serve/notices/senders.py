"""Delivery of news: each receiver has a thread and a bounded queue of its own, so that nothing waits for it."""

from __future__ import annotations

import hashlib
import hmac
import json
import logging
import queue
import threading
import time
from collections.abc import Callable
from http.client import HTTPException
from typing import Any, Final, Protocol
from urllib.error import HTTPError
from urllib.parse import urlsplit
from urllib.request import HTTPRedirectHandler, Request, build_opener

from cablewright.apps.serve.notices.news import News
from cablewright.apps.serve.notices.settings import MqttSettings, NewsSettings, WebhookSettings, secret_of

WAITING: Final = 100
"""News that wait for a receiver; later ones are dropped."""

TIME: Final = 5.0
"""Time that a receiver has to answer, s."""

SIGNATURE: Final = "X-Cablewright-Signature"
"""Header with ``sha256=`` and the HMAC of the body by the secret."""

_SAID_EVERY: Final = 60.0  # s between two complaints about a receiver
_SENT, _NOT_CONNECTED = 0, 4  # codes of MQTT: without a connection a message waits in the queue


class Receiver(Protocol):
    """Interface of a receiver of news about a print."""

    def put(self, news: News) -> bool:
        """Queue one message, without waiting; return whether there was room for it."""


class _Complaints:
    """Warnings in the log about one receiver, at most one in `_SAID_EVERY` seconds."""

    def __init__(self, name: str) -> None:
        self.name, self._last = name, -_SAID_EVERY

    def say(self, why: object) -> None:
        if time.monotonic() - self._last >= _SAID_EVERY:
            self._last = time.monotonic()
            logging.getLogger("cablewright").warning("news for %s: %s", self.name, why)


class _Refused(HTTPRedirectHandler):
    """Follows no redirection: the address in the file is the one that gets the news."""

    def redirect_request(self, *_given: Any) -> None:
        return None


class Webhook:
    """A `Receiver` that sends news about a print by HTTP POST."""

    def __init__(self, settings: WebhookSettings, send: Callable[[Request], None] | None = None) -> None:
        """Begin. *send*: sends one; by default over the network."""
        self.settings = settings
        self._secret = None if settings.secret is None else secret_of(settings.secret)
        self._complaints = _Complaints(urlsplit(settings.address).netloc)
        self._send = send or _sent
        self._queue: queue.Queue[News] = queue.Queue(WAITING)
        threading.Thread(target=self._run, daemon=True).start()

    def put(self, news: News) -> bool:
        """Send one message; see `Receiver.put`."""
        try:
            self._queue.put_nowait(news)
        except queue.Full:
            self._complaints.say("it is too slow, and does not get all")
            return False
        return True

    def _run(self) -> None:
        while True:
            body = json.dumps(self._queue.get()).encode()
            headers = {"Content-Type": "application/json"}
            if self._secret is not None:
                headers[SIGNATURE] = "sha256=" + hmac.new(self._secret, body, hashlib.sha256).hexdigest()
            try:
                self._send(Request(self.settings.address, body, headers, method="POST"))
            except HTTPError as reason:
                self._complaints.say(f"it answers {reason.code}")
            except (OSError, HTTPException, ValueError) as reason:  # the last one of a host that no name can be
                self._complaints.say(reason)


def _sent(request: Request) -> None:
    with build_opener(_Refused).open(request, timeout=TIME):
        pass


class Mqtt:
    """A `Receiver` of news through an MQTT broker: the kind of news is the last level of the topic."""

    def __init__(self, settings: MqttSettings) -> None:
        """Connect, and again where the connection is lost. Needs the extra mqtt."""
        from paho.mqtt.client import Client
        from paho.mqtt.enums import CallbackAPIVersion

        self.settings = settings
        self._complaints = _Complaints(settings.host)
        self._client = Client(CallbackAPIVersion.VERSION2)
        self._client.connect_timeout = TIME
        self._client.max_queued_messages_set(WAITING)
        if settings.user is not None:
            password = None if settings.password is None else secret_of(settings.password).decode()
            self._client.username_pw_set(settings.user, password)
        if settings.tls:
            self._client.tls_set()
        self._client.on_connect = self._connected
        self._client.on_connect_fail = lambda *_given: self._complaints.say("the broker cannot be reached")
        self._client.connect_async(settings.host, settings.port)
        self._client.loop_start()

    def _connected(self, _client: Any, _data: Any, _flags: Any, reason: Any, _properties: Any) -> None:
        """Say why the broker rejects this client, as for a wrong password: it is tried again and again."""
        if reason.is_failure:
            self._complaints.say(f"the broker rejects the connection: {reason}")

    def put(self, news: News) -> bool:
        """Send one message; see `Receiver.put`."""
        sent = self._client.publish(f"{self.settings.topic}/{news['what']}", json.dumps(news), qos=1)
        if sent.rc not in (_SENT, _NOT_CONNECTED):
            self._complaints.say("the broker is not reached, and does not get all")
        return sent.rc in (_SENT, _NOT_CONNECTED)


def receivers_of(settings: NewsSettings) -> list[tuple[Receiver, frozenset[str]]]:
    """Return the receivers of news, each with the kinds that it wants.

    Raises `InputError` for a secret that cannot be read.
    """
    found: list[tuple[Receiver, frozenset[str]]] = [(Webhook(each), frozenset(each.what)) for each in settings.webhook]
    return found + ([(Mqtt(settings.mqtt), frozenset(settings.mqtt.what))] if settings.mqtt is not None else [])
