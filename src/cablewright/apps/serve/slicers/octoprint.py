"""The part of OctoPrint's interface that PrusaSlicer, OrcaSlicer and Cura use, below ``/api``.

Source: OctoPrint's documentation of its REST API, and the calls in OctoPrint.cpp of PrusaSlicer and OrcaSlicer and in
OctoPrintOutputDevice.py of Cura's OctoPrint plugin. A rejection is plain text: these programs show it.
"""

from __future__ import annotations

from typing import Any, Final
from urllib.parse import quote

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from cablewright.apps.serve.slicers.answers import body_of, called
from cablewright.apps.serve.slicers.shared_actions import NO_START, Desk, Forbidden
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import OrderKind

VERSION: Final = {"api": "0.1", "server": "1.5.0", "text": "OctoPrint interface of cablewright"}
"""The version of OctoPrint's interface, whose name begins the text: slicers look for it."""


class OctoPrint:
    """Routes of OctoPrint's web interface, for slicers that send files to it."""

    def __init__(self, desk: Desk) -> None:
        """On a *desk*."""
        self.desk = desk

    def routes(self) -> list[Route]:
        """All routes of OctoPrint's web interface."""
        return [
            Route("/api/version", called(self.version)),
            Route("/api/server", called(self.version)),
            Route("/api/settings", called(self.settings)),
            Route("/api/printerprofiles", called(self.profiles)),
            Route("/api/login", called(self.login), methods=["POST"]),
            Route("/api/printer", called(self.printer)),
            Route("/api/job", called(self.job)),
            Route("/api/job", called(self.command), methods=["POST"]),
            Route("/api/files", called(self.files)),
            Route("/api/files/local", called(self.files)),
            Route("/api/files/local", called(self.upload), methods=["POST"]),
            Route("/api/files/local/{name}", called(self.file)),
            Route("/api/files/local/{name}", called(self.select), methods=["POST"]),
            Route("/api/{rest:path}", called(self.unknown), methods=["GET", "POST", "PUT", "DELETE"]),
        ]

    async def version(self, _request: Request) -> Response:
        """Return name and version of the server."""
        return JSONResponse(VERSION)

    async def settings(self, _request: Request) -> Response:
        """Return the server's settings that a client may read."""
        name = self.desk.page.feed.sitting.get("machine", "")
        return JSONResponse({
            "api": {"enabled": True},
            "appearance": {"name": name},
            "feature": {"sdSupport": False, "modelSizeDetection": False},
            "webcam": {"webcamEnabled": False},
            "plugins": {},
        })  # fmt: skip

    async def profiles(self, _request: Request) -> Response:
        """Return the machine, as the only printer profile."""
        axes = {axis: {"speed": 1, "inverted": False} for axis in "xyze"}
        name = self.desk.page.feed.sitting.get("machine", "")
        return JSONResponse({"profiles": {"_default": {"name": name, "model": name, "current": True, "axes": axes}}})

    async def login(self, request: Request) -> Response:
        """Return the user to whom the API key belongs."""
        key = request.scope["key"]
        return JSONResponse({"name": key.title, "active": True, "user": True, "admin": False})

    async def printer(self, _request: Request) -> Response:
        """Return the state of the machine."""
        return JSONResponse({"state": (await self.desk.view()).flags(), "temperature": {}, "sd": {"ready": False}})

    async def job(self, _request: Request) -> Response:
        """Return the present job and its progress."""
        view = await self.desk.view()
        job = view.job
        check = None if job is None else job["check"]
        file = {"name": None} if job is None else self._file(job)
        told = {
            "completion": 100.0 * view.progress,
            "printTime": round(view.printed),
            "printTimeLeft": None if view.left is None else round(view.left),
            "filepos": None,
        }
        about = {"file": file, "estimatedPrintTime": None if check is None else check["duration"]}
        return JSONResponse({"job": about, "progress": told, "state": view.flags()["text"], "message": view.message})

    async def command(self, request: Request) -> Response:
        """Pause or end a print; commands that would start motion are rejected."""
        given = await body_of(request)
        command, action = given.get("command"), given.get("action", "toggle")
        printing = (await self.desk.view()).print_state == "printing"
        if command == "pause" and (action == "pause" or (action == "toggle" and printing)):
            await self.desk.rest(OrderKind.PAUSE, request.scope["key"])
        elif command == "cancel":
            await self.desk.rest(OrderKind.STOP, request.scope["key"])
        else:
            raise Forbidden(NO_START)
        return Response(status_code=204)

    async def files(self, _request: Request) -> Response:
        """Return all uploaded files."""
        return JSONResponse({"files": [self._file(job) for job in await self.desk.files()]})

    async def file(self, request: Request) -> Response:
        """Return the data of one uploaded file."""
        return JSONResponse(self._file(await self.desk.file(request.path_params["name"])))

    async def select(self, request: Request) -> Response:
        """Reject the selection of a file: jobs are loaded on the page."""
        await self.desk.file(request.path_params["name"])
        raise Forbidden(NO_START)

    async def upload(self, request: Request) -> Response:
        """Receive a G-code file from a slicer."""
        job = await self.desk.upload(request, request.scope["key"])
        location = f"{request.base_url}api/files/local/{quote(job['file'])}"
        refs = {"resource": location}
        local = {"name": job["file"], "display": job["file"], "path": job["file"], "origin": "local", "refs": refs}
        told = {"files": {"local": local}, "done": True, "effectivePrint": False, "effectiveSelect": False}
        return JSONResponse(told, 201, headers={"location": location})

    async def unknown(self, request: Request) -> Response:
        """Reject requests for functions that are not offered."""
        raise InputError(f"/api/{request.path_params['rest'][:80]}: is not offered here")

    def _file(self, job: dict[str, Any]) -> dict[str, Any]:
        check = job["check"]
        return {
            "name": job["file"] or job["name"],
            "display": job["file"] or job["name"],
            "path": job["file"] or job["name"],
            "origin": "local",
            "type": "machinecode",
            "typePath": ["machinecode", "gcode"],
            "size": job["bytes"],
            "date": round(job["utc"]),
            "gcodeAnalysis": {}
            if check is None
            else {"estimatedPrintTime": check["duration"], "progress": check["answer"]},
            "cablewright": check,
        }
