"""Reader of a file uploaded as a form (multipart/form-data, RFC 7578), and rules for its name."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from dataclasses import dataclass
from email.parser import HeaderParser
from email.utils import collapse_rfc2231_value
from typing import Any, Final

from starlette.requests import Request
from starlette.responses import Response

from cablewright.apps.serve.uploads import DRAINED, TooLarge
from cablewright.foundation.errors import InputError, printable
from cablewright.live.serve.jobs import GCODE, MAX_BYTES

SUFFIXES: Final = (".gcode", ".gco", ".g", ".nc", ".ngc")
"""Endings of files that are taken."""

MAX_NAME: Final = 120
"""Letters of a file's name."""

_AROUND: Final = 1 << 16  # bytes of a form beside its file
_PARTS: Final = 16
_DRAINING: Final = 60.0  # s, of whoever has a key
_BRIEF: Final = 2.0  # s, of a stranger
_LIMIT: Final = f"at most {MAX_BYTES[GCODE] >> 20} MiB of G-code are taken"


@dataclass(frozen=True)
class Form:
    """An uploaded form: fields by name, and one file."""

    fields: dict[str, str]
    name: str
    content: bytes

    @property
    def wants_print(self) -> bool:
        """Whether the slicer requests that the file be printed."""
        return self.fields.get("print", "").strip().lower() == "true"


async def read_form(request: Request) -> Form:
    """Read the form of a request. Raises `InputError`; `TooLarge`, where its length is given before a byte is read."""
    most = MAX_BYTES[GCODE] + _AROUND
    given = request.headers.get("content-length", "")
    if given.isdigit() and int(given) > most:
        raise TooLarge(f"{int(given) >> 20} MiB: too large; {_LIMIT}")
    whole, size = bytearray(), 0
    async for piece in request.stream():
        size += len(piece)
        if size <= most:
            whole += piece
        else:
            whole.clear()
        if size > DRAINED:
            break
    if size > most:
        raise TooLarge(f"too large; {_LIMIT}")
    return parsed_form(request.headers.get("content-type", ""), bytes(whole))


def parsed_form(kind: str, body: bytes) -> Form:
    """Return the form in *body*, of the content type *kind*. Raises `InputError`."""
    boundary = _parameter(f"Content-Type: {kind}", "content-type", "boundary")
    if not kind.lower().startswith("multipart/form-data") or not boundary:
        raise InputError("a form is expected: multipart/form-data with a boundary")
    mark = b"--" + boundary.encode("latin-1", "replace")
    fields: dict[str, str] = {}
    file: tuple[str, bytes] | None = None
    at = body.find(mark)
    for _ in range(_PARTS):
        begin = at + len(mark)
        if at < 0 or body[begin : begin + 2] == b"--":
            break
        head = body.find(b"\r\n\r\n", begin, begin + 4096)
        at = body.find(b"\r\n" + mark, max(head, begin)) + 2
        if head < 0 or at < 2:
            raise InputError("the form is cut off")
        about, content = body[begin + 2 : head].decode("utf-8", "replace"), body[head + 4 : at - 2]
        sent = _parameter(about, "content-disposition", "filename")
        if sent is not None:
            if file is not None:
                raise InputError("more than one file was sent; send one file at a time")
            file = sent, content
        else:
            name = _parameter(about, "content-disposition", "name") or ""
            fields[name] = content[:1024].decode("utf-8", "replace")
    if file is None:
        raise InputError("no file was sent")
    _require_no_folder(fields)
    return Form(fields, file_name(file[0]), file[1])


def file_name(given: str) -> str:
    """Return a valid file name, which may begin with one slash. Raises `InputError` for an invalid name."""
    name = given.removeprefix("/")
    if not name or name.startswith(".") or set(name) & set("/\\") or printable(name) != name:
        raise InputError(
            f"name {given[:80]!r}: names a path, or has characters that a file name cannot have; send the file's "
            f"name "
            f"alone"
        )
    if len(name) > MAX_NAME:
        raise InputError(f"name {name[:40]!r}...: {len(name)} letters; at most {MAX_NAME} are taken")
    if not name.lower().endswith(SUFFIXES):
        raise InputError(f"name {name!r}: G-code is expected, {', '.join(SUFFIXES)}; choose that format in the slicer")
    return name


def _require_no_folder(fields: dict[str, str]) -> None:
    if path := fields.get("path", "").strip("/ "):
        raise InputError(f"path = {path[:80]!r}: folders are not supported; send the file without a path")
    if fields.get("root", "gcodes") != "gcodes":
        raise InputError(f"root = {fields['root'][:80]!r}: must be gcodes")


def _parameter(headers: str, header: str, name: str) -> str | None:
    """A parameter of a header; None where it is not there. Raises `InputError` for one that is malformed."""
    try:
        found = HeaderParser().parsestr(headers).get_param(name, None, header)
    except (TypeError, ValueError):  # of pieces that are not numbered, or by too large numbers (RFC 2231)
        raise InputError(f"{header}: {name}: is malformed") from None
    return None if found is None else collapse_rfc2231_value(found).strip()


class EarlyRefusal(Response):
    """An answer that is sent before a body of known length was read; then that is read, or its sender would not see it.

    Of a stranger's it is read for two seconds. The connection is closed then. A body without a length is not read: one
    whose chunks are malformed would end the answer.
    """

    media_type = "text/plain"

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        """Answer, and read on."""
        names = {name for name, _ in scope["headers"]}
        if b"content-length" not in names or b"transfer-encoding" in names:
            await super().__call__(scope, receive, send)
            return
        closing = [*self.raw_headers, (b"connection", b"close")]
        await send({"type": "http.response.start", "status": self.status_code, "headers": closing})
        await send({"type": "http.response.body", "body": self.body, "more_body": True})
        more, size = True, 0
        with suppress(TimeoutError):
            async with asyncio.timeout(_DRAINING if "key" in scope else _BRIEF):
                while more and size < DRAINED:
                    message = await receive()
                    size += len(message.get("body", b""))
                    more = message.get("more_body", False)
        await send({"type": "http.response.body", "body": b"", "more_body": False})
