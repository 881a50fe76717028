"""Access check before all routes: hosts, origins, tokens, keys and rates; and the headers of every response."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final
from urllib.parse import parse_qs

from cablewright.apps.serve.access import HEADERS, REPORT_POLICY, Access, is_safe, policy_with
from cablewright.apps.serve.connections import Connections, Holder
from cablewright.apps.serve.slicers.answers import is_slicers, refusal
from cablewright.apps.serve.slicers.keys import Key, Keys


class Guard:
    """ASGI middleware: only requests allowed by `Access` pass; every response has the headers of `HEADERS`."""

    def __init__(
        self, app: Any, access: Access, keys: Keys, connections: Connections | None = None, camera: str = ""
    ) -> None:
        """Guard *app*. *keys*: keys of slicers. *camera*: address of a picture that the page may show."""
        self.app, self.access, self.keys = app, access, keys
        self.connections = connections or Connections()
        self.policy = policy_with(camera)

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        """One request or socket."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        refused = self._refusal(scope)
        if refused is not None and scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008})
            return
        told = _with_headers(send, REPORT_POLICY if _is_report(scope["path"]) else self.policy)
        if refused is not None:
            status, text, page = refused
            if is_slicers(scope["path"]):
                await refusal(scope["path"], status, text.strip())(scope, receive, told)
                return
            if page and scope["method"] == "GET":
                await self.app(scope | {"path": "/enter", "raw_path": b"/enter"}, receive, told)
                return
            await told({
                "type": "http.response.start",
                "status": status,
                "headers": [(b"content-type", b"text/plain; charset=utf-8")],
            })  # fmt: skip
            await told({"type": "http.response.body", "body": text.encode()})
            return
        await self.app(scope, receive, told)

    def _refusal(self, scope: Any) -> tuple[int, str, bool] | None:
        """Status and text of a rejected request, and whether the page that asks for the token may answer."""
        access, headers, path = self.access, scope["headers"], scope["path"]
        if not access.knows_host(headers):
            return 421, "this server does not answer to that name\n", False
        origin = access.origin_of(headers)
        if is_slicers(path):
            return self._refusal_of_slicer(scope, origin)
        if path.startswith("/foxglove/"):
            if origin == "foreign":
                return 403, "that origin may not read here\n", False
            reads = access.is_view_token(path.removeprefix("/foxglove/"))
            return _CROWDED if reads and not self.connections.admits(scope["client"], Holder.KEY) else None
        is_socket = scope["type"] == "websocket"
        if origin not in (None, "own"):
            return 403, "requests from other origins are rejected\n", False
        if path == "/enter" or path in PUBLIC:
            return None
        session = access.session_of(headers)
        if session is None:
            return 401, "a token is needed: the one that `cablewright serve` showed when it started\n", path == "/"
        if session != "bearer" and origin is None and (is_socket or not is_safe(scope["method"])):
            return 403, "a request that changes something names its origin\n", False
        if path not in STOPS:
            if not self.connections.admits(scope["client"], Holder.TOKEN):
                return _CROWDED
            if not access.allows(session):
                return 429, "too many requests\n", False
        scope["session"] = session
        return None

    def _refusal_of_slicer(self, scope: Any, origin: str | None) -> tuple[int, str, bool] | None:
        """The same for a slicer: no page of a browser, a key in a header, and a rate."""
        if origin is not None:
            return 403, "pages of browsers are rejected: this address is for slicers", False
        if _SECRETS & set(parse_qs(scope["query_string"].decode("latin-1"), keep_blank_values=True)):
            return 400, "a key in an address stays in logs: send it in the header X-Api-Key", False
        key = self._key_of(scope["headers"])
        if key is None:
            if not self.access.may_guess():
                return 429, "too many wrong keys; wait a second", False
            why = "an API key is needed, in the header X-Api-Key: make one on the page of the machine, under Slicers"
            return 401, why, False
        if scope["path"] not in STOPS:
            if not self.connections.admits(scope["client"], Holder.KEY):
                return _CROWDED
            if not self.access.allows(f"key {key.number}"):
                return 429, "too many requests", False
        scope["key"] = key
        return None

    def _key_of(self, headers: Iterable[tuple[bytes, bytes]]) -> Key | None:
        """The API key of a request, by the header X-Api-Key or as a bearer token; None without a valid one."""
        for name, value in headers:
            text = value.decode("latin-1").strip()
            if name == b"authorization" and text.lower().startswith("bearer "):
                text = text[7:].strip()
            elif name != b"x-api-key":
                continue
            if (found := self.keys.of(text)) is not None:
                return found
        return None


STOPS: Final = ("/stop", "/printer/emergency_stop")
"""Addresses without a limit of rate or of connections."""

_CROWDED: Final = (503, "too many connections are open; a stop still gets through\n", False)
_SECRETS: Final = frozenset({"apikey", "api_key", "token", "access_token", "key"})  # of addresses

PUBLIC: Final = frozenset({"/static/enter.js", "/static/operate.css", "/static/icon.svg"})
"""What is shown to those who have not entered a token."""


def _is_report(path: str) -> bool:
    return path.endswith("/report")


def _with_headers(send: Any, policy: bytes) -> Any:
    own = ((HEADERS[0][0], policy), *HEADERS[1:])

    async def told(message: Any) -> None:
        if message["type"] == "http.response.start":
            message["headers"] = [*message.get("headers", ()), *own]
        await send(message)

    return told
