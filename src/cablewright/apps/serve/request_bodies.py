"""Bodies of requests to the page, and its answers to those that succeed, fail or are not allowed."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import suppress
from typing import Any, Final

from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, PlainTextResponse, Response

from cablewright.apps.serve.slicers.shared_actions import SENDING
from cablewright.apps.serve.uploads import TooLarge
from cablewright.foundation.errors import EnvironmentFault, InputError

SMALL: Final = 4096
"""Bytes of a message."""


async def whole_of(request: Request, most: int) -> bytes:
    """The body of a request. Raises `TooLarge` after *most* bytes, `ClientDisconnect` for one that is cut off."""
    whole = bytearray()
    async for piece in request.stream():
        whole += piece
        if len(whole) > most:
            raise TooLarge(f"too large; at most {most} bytes are taken")
    return bytes(whole)


async def body_of(request: Request, most: int) -> bytes:
    """The body of a request; empty for one that is too large or cut off."""
    with suppress(ClientDisconnect, TooLarge):
        return await whole_of(request, most)
    return b""


async def json_of(request: Request) -> dict[str, Any]:
    """Return the JSON object in the body of a request; an empty one where the body has none."""
    return object_in(await body_of(request, SMALL))


def object_in(body: bytes) -> dict[str, Any]:
    """The JSON object of a body; empty where there is none."""
    try:
        found = json.loads(body or b"{}")
    except (ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


async def tried(work: Callable[[], Any]) -> Response:
    """What *work* answers, or why it was rejected."""
    try:
        return JSONResponse(await work())
    except TooLarge as reason:
        return PlainTextResponse(f"{reason}\n", 413)
    except InputError as reason:
        return PlainTextResponse(f"{reason}\n", 409)
    except TimeoutError:
        return PlainTextResponse(f"it was not sent within {SENDING:g} s\n", 408)
    except (EnvironmentFault, OSError) as reason:
        return PlainTextResponse(f"{reason}\n", 507)
    except ClientDisconnect:
        return PlainTextResponse("it was cut off\n", 400)


def not_operating() -> Response:
    """Return the answer to a request of a page that does not operate."""
    return PlainTextResponse("only the page that operates the machine may do that\n", 403)
