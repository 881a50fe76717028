"""Responses to slicers: results, and rejections in the form of each interface."""

from __future__ import annotations

import json
from collections.abc import Awaitable, Callable
from typing import Any, Final

from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response

from cablewright.apps.serve.slicers.multipart_forms import EarlyRefusal
from cablewright.apps.serve.slicers.shared_actions import SENDING, Busy, Forbidden
from cablewright.apps.serve.uploads import TooLarge
from cablewright.foundation.errors import CablewrightError, EnvironmentFault

PREFIXES: Final = ("/api", "/server", "/printer", "/machine", "/access", "/websocket")
"""Begins of addresses that take an API key, and nothing else."""

_MAX_BODY: Final = 4096  # bytes

Handler = Callable[[Request], Awaitable[Response]]


def is_slicers(path: str) -> bool:
    """Return whether an address belongs to the slicers' interfaces."""
    return f"/{path.split('/')[1]}" in PREFIXES if path.startswith("/") else False


def refusal(path: str, status: int, why: str, *, unread: bool = True) -> Response:
    """Return an error response: text below ``/api``, Moonraker's JSON elsewhere. *unread*: without reading the body."""
    kind = EarlyRefusal if unread else Response
    if path.startswith("/api"):
        return kind(f"{why}\n", status, headers={"content-type": "text/plain"})
    error = {"error": {"code": status, "message": why, "traceback": ""}}
    return kind(json.dumps(error), status, headers={"content-type": "application/json"})


def status_of(reason: CablewrightError) -> int:
    """Return the HTTP status of an error answer."""
    if isinstance(reason, TooLarge):
        return 413
    if isinstance(reason, Busy):
        return 429
    if isinstance(reason, Forbidden):
        return 403
    return 507 if isinstance(reason, EnvironmentFault) else 400


def called(handler: Handler) -> Handler:
    """Return *handler* with exceptions converted to HTTP error answers."""

    async def call(request: Request) -> Response:
        unread = True

        async def receive() -> Any:
            nonlocal unread
            message = await request.receive()
            unread = message.get("more_body", False)
            return message

        def refused(status: int, why: str) -> Response:
            return refusal(request.url.path, status, why, unread=unread)

        try:
            return await handler(Request(request.scope, receive))
        except CablewrightError as reason:
            return refused(status_of(reason), str(reason))
        except OSError as reason:
            return refused(507, f"it cannot be kept: {reason.strerror or reason}")
        except TimeoutError:
            return refused(408, f"it was not sent within {SENDING:g} s")
        except ClientDisconnect:
            return refused(400, "it was cut off")

    return call


async def body_of(request: Request) -> dict[str, Any]:
    """Return the JSON object of a request; empty where there is none."""
    whole = b""
    async for piece in request.stream():
        whole += piece
        if len(whole) > _MAX_BODY:
            return {}
    try:
        found = json.loads(whole or b"{}")
    except (ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def result(value: object) -> Response:
    """Return a result in the form of Moonraker's interface."""
    return JSONResponse({"result": value})
