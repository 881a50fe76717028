"""The part of Moonraker's interface that PrusaSlicer, OrcaSlicer and Cura use, by HTTP and by WebSocket.

Source: Moonraker's documentation of its web API (JSON-RPC 2.0 and HTTP), and the calls in Moonraker.cpp of PrusaSlicer,
MoonrakerPrinterAgent.cpp of OrcaSlicer and MoonrakerOutputDevice.py of Cura's Moonraker plugin. A method by HTTP has
its name with slashes: ``printer.objects.query`` is ``/printer/objects/query``.
"""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Awaitable, Callable
from typing import Any, Final

from pydantic_core import from_json, to_json
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from cablewright.apps.serve.access import Bucket
from cablewright.apps.serve.slicers.answers import body_of, called, result, status_of
from cablewright.apps.serve.slicers.keys import Key
from cablewright.apps.serve.slicers.shared_actions import NO_START, Desk, Forbidden
from cablewright.apps.serve.slicers.slicer_comments import GcodeNotes
from cablewright.foundation.errors import CablewrightError, InputError
from cablewright.foundation.signals import OrderKind

MAX_SOCKETS: Final = 16
"""Sockets that are open at a time."""

_EVERY: Final = 0.25  # s between two states of a subscription
_ORDERS: Final = ("printer.print.pause", "printer.print.cancel", "printer.emergency_stop")  # by POST alone
_STARTS: Final = ("printer.print.start", "printer.print.resume", "printer.gcode.script", "printer.restart")

Parameters = dict[str, Any]
Method = Callable[[Key, Parameters], Awaitable[Any]]


class Moonraker:
    """The part of Moonraker's interface for slicers: methods, routes and sockets."""

    def __init__(self, desk: Desk) -> None:
        """On a *desk*."""
        self.desk, self._sockets = desk, 0
        self.methods: dict[str, Method] = {
            "server.info": self._server_info,
            "server.connection.identify": self._identify,
            "server.files.list": self._list,
            "server.files.roots": self._roots,
            "server.files.metadata": self._metadata,
            "server.files.thumbnails": self._thumbnails,
            "printer.info": self._printer_info,
            "printer.objects.list": self._objects,
            "printer.objects.query": self._query,
            "printer.print.pause": self._pause,
            "printer.print.cancel": self._cancel,
            "printer.emergency_stop": self._stop,
        }

    def routes(self) -> list[Route | WebSocketRoute]:
        """All routes of Moonraker's interface."""
        return [
            Route("/server/files/upload", called(self.upload), methods=["POST"]),
            Route("/server/files/gcodes/.thumbs/{name}", called(self.picture)),
            WebSocketRoute("/websocket", self.socket),
            *(
                Route(f"/{begin}/{{rest:path}}", called(self.call), methods=["GET", "POST", "PUT", "DELETE"])
                for begin in ("server", "printer", "machine", "access")
            ),
        ]

    async def call(self, request: Request) -> Response:
        """Answer one method of Moonraker's interface by HTTP."""
        name = request.url.path.strip("/").replace("/", ".")
        if name in _ORDERS and request.method != "POST":
            raise InputError(f"{name}: requires POST")
        given: Parameters = dict(request.query_params)
        if request.method == "POST":
            given |= await body_of(request)
        elif name == "printer.objects.query":
            given = {"objects": {each: fields.split(",") if fields else None for each, fields in given.items()}}
        return result(await self.method(name, request.scope["key"], given))

    async def method(self, name: str, key: Key, given: Parameters) -> Any:
        """Return the result of a method of Moonraker's interface. Raises `CablewrightError`."""
        if name in _STARTS:
            raise Forbidden(NO_START)
        if name not in self.methods:
            raise InputError(f"{name[:80]}: is not offered here")
        return await self.methods[name](key, given)

    async def upload(self, request: Request) -> Response:
        """Receive a G-code file from a slicer."""
        job = await self.desk.upload(request, request.scope["key"])
        item = {"path": job["file"], "root": "gcodes", "modified": job["utc"], "size": job["bytes"], "permissions": "r"}
        told = {"item": item, "print_started": False, "print_queued": job["wants_print"], "action": "create_file"}
        return JSONResponse(told, 201, headers={"location": f"{request.base_url}server/files/gcodes/{job['id']}"})

    async def picture(self, request: Request) -> Response:
        """Serve one picture of a file, by the path in its metadata."""
        name, _, size = request.path_params["name"].removesuffix(".png").rpartition("-")
        notes = await self.desk.notes(await self.desk.file(name))
        for each in notes.pictures:
            if f"{each.width}x{each.height}" == size:
                return Response(each.content, media_type="image/png")
        raise InputError("there is no such picture")

    async def _server_info(self, _key: Key, _given: Parameters) -> Parameters:
        view = await self.desk.view()
        return {
            "klippy_connected": view.klippy == "ready",
            "klippy_state": view.klippy,
            "components": ["file_manager", "klippy_apis"],
            "failed_components": [],
            "registered_directories": ["gcodes"],
            "warnings": [],
            "websocket_count": self._sockets,
            "machine_name": self.desk.page.feed.sitting.get("machine", ""),
            "moonraker_version": "cablewright",
            "api_version": [1, 5, 0],
            "api_version_string": "1.5.0",
        }

    async def _printer_info(self, _key: Key, _given: Parameters) -> Parameters:
        view = await self.desk.view()
        name = self.desk.page.feed.sitting.get("machine", "")
        return {
            "state": view.klippy,
            "state_message": view.message,
            "hostname": name,
            "software_version": "cablewright",
        }

    async def _identify(self, key: Key, _given: Parameters) -> Parameters:
        return {"connection_id": int(key.number, 16)}

    async def _list(self, _key: Key, _given: Parameters) -> list[Parameters]:
        return [
            {"path": job["file"], "modified": job["utc"], "size": job["bytes"], "permissions": "r"}
            for job in await self.desk.files()
        ]

    async def _roots(self, _key: Key, _given: Parameters) -> list[Parameters]:
        return [{"name": "gcodes", "path": "gcodes", "permissions": "r"}]

    async def _metadata(self, _key: Key, given: Parameters) -> Parameters:
        job = await self.desk.file(given.get("filename"))
        notes, check = await self.desk.notes(job), job["check"]
        planned = {} if check is None or check["duration"] is None else {"estimated_time": check["duration"]}
        return {
            "filename": job["file"],
            "size": job["bytes"],
            "modified": job["utc"],
            "uuid": job["id"],
            "slicer": notes.slicer,
            "slicer_version": notes.version,
            **notes.numbers,
            **planned,
            "thumbnails": _thumbnails(job["file"], notes, "relative_path"),
            "cablewright": {"busy": job["busy"], "check": check},
        }

    async def _thumbnails(self, _key: Key, given: Parameters) -> list[Parameters]:
        job = await self.desk.file(given.get("filename"))
        return _thumbnails(job["file"], await self.desk.notes(job), "thumbnail_path")

    async def _objects(self, _key: Key, _given: Parameters) -> Parameters:
        return {"objects": list((await self.desk.view()).objects())}

    async def _query(self, _key: Key, given: Parameters) -> Parameters:
        return {
            "eventtime": time.monotonic(),
            "status": _chosen((await self.desk.view()).objects(), given.get("objects")),
        }

    async def _pause(self, key: Key, _given: Parameters) -> str:
        await self.desk.rest(OrderKind.PAUSE, key)
        return "ok"

    async def _cancel(self, key: Key, _given: Parameters) -> str:
        await self.desk.rest(OrderKind.STOP, key)
        return "ok"

    async def _stop(self, key: Key, _given: Parameters) -> str:
        self.desk.stop(key)
        return "ok"

    async def socket(self, socket: WebSocket) -> None:
        """Serve one slicer through its WebSocket."""
        if self._sockets >= MAX_SOCKETS:
            await socket.close(1013)
            return
        await socket.accept()
        self._sockets += 1
        try:
            with contextlib.suppress(WebSocketDisconnect, RuntimeError):  # the client has gone
                await _Socket(self, socket).run()
        finally:
            self._sockets -= 1
            with contextlib.suppress(WebSocketDisconnect, RuntimeError):
                await socket.close(1008)


class _Socket:
    """JSON-RPC on one socket: sends responses, and subscribed objects when they change."""

    def __init__(self, moonraker: Moonraker, socket: WebSocket) -> None:
        self.moonraker, self.socket = moonraker, socket
        self.key: Key = socket.scope["key"]
        self._rate = Bucket(60, 20.0)
        self._wanted: object = None
        self._shown: dict[str, Any] = {}

    async def run(self) -> None:
        """Answer requests until the client disconnects."""
        telling = asyncio.create_task(self._tell())
        try:
            while True:
                message = await self.socket.receive()
                text = message.get("text")
                if message["type"] != "websocket.receive" or text is None:
                    return
                if not self._rate.take() or not self._is_valid():
                    return
                if (answer := await self._answer(text)) is not None:
                    await self.socket.send_text(to_json(answer, inf_nan_mode="null").decode())
        finally:
            telling.cancel()

    def _is_valid(self) -> bool:
        """Whether the key was not removed since the socket was opened."""
        return self.moonraker.desk.page.keys.holds(self.key)

    async def _answer(self, text: str) -> Parameters | None:
        try:
            asked = from_json(text)
        except ValueError:
            return _error(None, -32700, "no JSON")
        if not isinstance(asked, dict) or not isinstance(asked.get("method"), str):
            return _error(None, -32600, "a method is expected")
        number, given = asked.get("id"), asked.get("params")
        given = given if isinstance(given, dict) else {}
        try:
            if asked["method"] == "printer.objects.subscribe":
                found = await self.moonraker.method("printer.objects.query", self.key, given)
                self._wanted, self._shown = given.get("objects"), found["status"]
            else:
                found = await self.moonraker.method(asked["method"], self.key, given)
        except CablewrightError as reason:
            return _error(number, status_of(reason), str(reason))
        except OSError as reason:
            return _error(number, 507, f"it cannot be read: {reason.strerror or reason}")
        return None if number is None else {"jsonrpc": "2.0", "result": found, "id": number}

    async def _tell(self) -> None:
        """Send what has changed of the objects that are subscribed to, as long as the key is valid."""
        with contextlib.suppress(WebSocketDisconnect, RuntimeError, OSError):  # it has gone, or the folder of jobs
            while self._is_valid():
                await asyncio.sleep(_EVERY)
                if not isinstance(self._wanted, dict):
                    continue
                now = _chosen((await self.moonraker.desk.view()).objects(), self._wanted)
                changed = {name: _changed(self._shown.get(name, {}), each) for name, each in now.items()}
                self._shown = now
                if told := {name: each for name, each in changed.items() if each}:
                    news = {"jsonrpc": "2.0", "method": "notify_status_update", "params": [told, time.monotonic()]}
                    await self.socket.send_text(to_json(news, inf_nan_mode="null").decode())
            await self.socket.close(1008)


def _chosen(objects: dict[str, Parameters], wanted: object) -> dict[str, Parameters]:
    """The requested objects and fields; unknown ones are left out."""
    if not isinstance(wanted, dict):
        raise InputError("objects: a table of names is expected")
    found = {}
    for name, fields in wanted.items():
        if name in objects:
            only = fields if isinstance(fields, list) else list(objects[name])
            found[name] = {each: value for each, value in objects[name].items() if each in only}
    return found


def _changed(before: Parameters, now: Parameters) -> Parameters:
    return {name: value for name, value in now.items() if name not in before or before[name] != value}


def _thumbnails(file: str, notes: GcodeNotes, key: str) -> list[Parameters]:
    return [
        {
            "width": each.width,
            "height": each.height,
            "size": len(each.content),
            key: f".thumbs/{file}-{each.width}x{each.height}.png",
        }
        for each in notes.pictures
    ]


def _error(number: object, code: int, why: str) -> Parameters:
    return {"jsonrpc": "2.0", "error": {"code": code, "message": why}, "id": number}
