"""The routes of the operator's page."""

from __future__ import annotations

import asyncio
import logging
import os
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, RedirectResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket

from cablewright.apps.serve import foxglove
from cablewright.apps.serve.assets import ASSETS, asset
from cablewright.apps.serve.camera_routes import CameraRoutes
from cablewright.apps.serve.live import Live
from cablewright.apps.serve.middleware import Guard
from cablewright.apps.serve.move_check import reach
from cablewright.apps.serve.notices.news import NewsWatch
from cablewright.apps.serve.notices.senders import receivers_of
from cablewright.apps.serve.notices.settings import load_news
from cablewright.apps.serve.operators import Client
from cablewright.apps.serve.request_bodies import body_of, json_of, not_operating, tried, whole_of
from cablewright.apps.serve.ros_state import RosState
from cablewright.apps.serve.shared_state import Served
from cablewright.apps.serve.slicers.moonraker import Moonraker
from cablewright.apps.serve.slicers.octoprint import OctoPrint
from cablewright.apps.serve.slicers.shared_actions import SENDING, Desk
from cablewright.apps.serve.slicers.slicer_comments import largest_picture
from cablewright.apps.serve.uploads import MAX_NOTES, PARTS
from cablewright.exchange.ros.dds import DdsWriter
from cablewright.foundation.errors import InputError
from cablewright.foundation.units import LARGEST
from cablewright.live.serve.jobs import GCODE
from cablewright.printing.trial_part import first_part

_ENTER: Final = 1024  # bytes of the message with a token
_REPORTS: Final = 5.0  # s between looks for runs without a report


@dataclass(eq=False, kw_only=True)
class Page(Served):
    """The web application of the operator's page, with the data that its routes share."""

    _readers: int = 0
    _reaching: asyncio.Semaphore = field(default_factory=lambda: asyncio.Semaphore(1))

    def application(self) -> Guard:
        """Return the whole web application, with its access rules."""
        desk = Desk(self)
        routes = [
            Route("/", self.index),
            Route("/enter", self.enter, methods=["GET", "POST"]),
            Route("/static/{name}", self.static),
            Route("/scene", self.scene),
            Route("/stop", self.stop, methods=["GET", "POST"]),
            Route("/jobs", self.jobs, methods=["GET", "POST"]),
            Route("/jobs/first", self.first, methods=["POST"]),
            Route("/jobs/{job}/{part}", self.put, methods=["PUT"]),
            Route("/jobs/{job}/check", self.check, methods=["POST"]),
            Route("/jobs/{job}/load", self.load, methods=["POST"]),
            Route("/jobs/{job}/report", self.job_report),
            Route("/jobs/{job}/picture", self.picture),
            Route("/jobs/{job}", self.remove, methods=["DELETE"]),
            Route("/close", self.load, methods=["POST"]),
            Route("/reach", self.reach, methods=["POST"]),
            Route("/runs", self.runs),
            Route("/runs/{run}/notes", self.notes, methods=["PUT"]),
            Route("/runs/{run}/resume", self.resume, methods=["POST"]),
            Route("/runs/{run}/report", self.run_report),
            Route("/keys", self.api_keys, methods=["GET", "POST"]),
            Route("/keys/{key}", self.remove_key, methods=["DELETE"]),
            *CameraRoutes(self).routes(),
            *OctoPrint(desk).routes(),
            *Moonraker(desk).routes(),
            WebSocketRoute("/live", self.live),
            WebSocketRoute("/foxglove/{token}", self.foxglove),
        ]
        app = Starlette(routes=routes, lifespan=self._tasks)
        return Guard(app, self.access, self.keys, self.connections, self.camera)

    @asynccontextmanager
    async def _tasks(self, _app: Starlette) -> AsyncIterator[None]:
        tasks = [asyncio.create_task(each) for each in (self.feed.run(), self.checks.run(), self._report())]
        for each in tasks:
            each.add_done_callback(_end_with)
        for others, what in ((self._tell_others(), "news"), (self._tell_ros(), "ROS 2")):
            tasks.append(asyncio.create_task(others, name=what))
            tasks[-1].add_done_callback(_go_on_without)
        try:
            yield
        finally:
            for each in tasks:
                each.cancel()

    async def _report(self) -> None:
        """Ask for the reports of runs that have ended."""
        while True:
            await asyncio.sleep(_REPORTS)
            present = self.feed.sitting.get("run")
            for name in await asyncio.to_thread(self.uploads.unreported):
                if name != present:
                    self.checks.ask("report", name)

    async def _tell_others(self) -> None:
        """Send news to the receivers; nothing waits for them."""
        if self.news is None:
            return
        receivers, watching, version = receivers_of(load_news(self.news)), NewsWatch(), 0
        while receivers:
            version = await self.feed.next(version)
            for news in watching.look(self.feed.state, self.feed.sitting):
                for receiver, wanted in receivers:
                    if news["what"] in wanted:
                        receiver.put(news)

    async def _tell_ros(self) -> None:
        """Send the state to a domain of ROS 2."""
        if self.ros2 is not None:
            await RosState(self.feed, DdsWriter(self.ros2).write).run()

    async def index(self, _request: Request) -> Response:
        """Serve the operator's page."""
        return asset("index.html")

    async def enter(self, request: Request) -> Response:
        """Serve the page on which the token is entered, and check the token."""
        if request.method == "GET":
            return asset("enter.html")
        token = (await body_of(request, _ENTER)).decode("utf-8", "replace").strip()
        if not self.access.is_token(token):
            if not self.access.may_guess():
                return PlainTextResponse("too many wrong tokens; wait a second\n", 429)
            return PlainTextResponse("that is not the token of this start of `cablewright serve`\n", 401)
        _, cookie = self.access.new_cookie()
        return PlainTextResponse("welcome\n", headers={"set-cookie": cookie})

    async def static(self, request: Request) -> Response:
        """Serve a file of the page, by its name alone."""
        name = request.path_params["name"]
        return asset(name) if name in ASSETS else PlainTextResponse("there is no such file\n", 404)

    async def scene(self, _request: Request) -> Response:
        """Serve the 3-D scene of the connected machine."""
        if self.feed.scene is None:
            return PlainTextResponse("the scene is being made\n", 503)
        return Response(self.feed.scene, media_type="application/json")

    async def stop(self, request: Request) -> Response:
        """Stop the machine.

        Everyone who may look may stop; no lease, no limit of rate, no body is needed.
        """
        if request.method == "GET":
            return asset("stop.html")
        session = request.scope["session"]
        sent = self.send_stop("a request with the token" if session == "bearer" else f"browser {session[:4]}")
        if "text/html" in request.headers.get("accept", ""):
            return RedirectResponse("/stop", 303) if sent else asset("stop.html", 503)
        return PlainTextResponse("stop was sent\n" if sent else "the control does not answer\n", 202 if sent else 503)

    async def jobs(self, request: Request) -> Response:
        """List all jobs, or create a new one."""
        if request.method == "GET":
            return JSONResponse(await asyncio.to_thread(self.uploads.jobs, self.checks.busy))
        if self._operator(request) is None:
            return not_operating()
        given = await json_of(request)
        return await tried(lambda: asyncio.to_thread(self._new_job, given.get("name")))

    def _new_job(self, name: object) -> dict[str, Any]:
        return {"id": self.uploads.new_job(name)}

    async def first(self, request: Request) -> Response:
        """Create the job of a first part for this machine, and request its check."""
        if self._operator(request) is None:
            return not_operating()

        async def make() -> dict[str, Any]:
            if self.feed.head is None:
                raise InputError("the machine is being opened")
            robot = self.feed.head.robot
            texts = first_part(robot.name, robot.scene.frame_min, robot.scene.frame_max)
            number = await asyncio.to_thread(self.uploads.new_job, "first square")
            for part, text in zip(("settings", "gcode"), texts, strict=True):
                await asyncio.to_thread(self.uploads.put_whole, number, part, text.encode())
            if why := self.checks.ask("check", number):
                raise InputError(why)
            return {"id": number}

        return await tried(make)

    async def put(self, request: Request) -> Response:
        """Receive an uploaded file of a job."""
        if self._operator(request) is None:
            return not_operating()
        job, part = request.path_params["job"], request.path_params["part"]
        if part not in PARTS:
            return PlainTextResponse("there is no such part of a job\n", 404)
        if self.sending.locked():
            return PlainTextResponse("others are sending; try again\n", 429)

        async def take() -> dict[str, Any]:
            async with self.sending, asyncio.timeout(SENDING):
                return {"bytes": await self.uploads.put(job, part, request.stream())}

        return await tried(take)

    async def check(self, request: Request) -> Response:
        """Queue the check of an uploaded job."""
        if self._operator(request) is None:
            return not_operating()
        job = request.path_params["job"]

        async def ask() -> dict[str, Any]:
            self.uploads.job(job)
            if why := self.checks.ask("check", job):
                raise InputError(why)
            return {"asked": True}

        return await tried(ask)

    async def load(self, request: Request) -> Response:
        """Load a job into the control, or unload it."""
        client = self._operator(request)
        if client is None:
            return not_operating()
        given, job = await json_of(request), request.path_params.get("job")

        async def load() -> dict[str, Any]:
            if job is not None:
                self.uploads.job(job)
            return await self.loaded(client, load=job, confirmed=str(given.get("confirmed", ""))[:64])

        return await tried(load)

    async def resume(self, request: Request) -> Response:
        """Resume a run that was interrupted."""
        client = self._operator(request)
        if client is None:
            return not_operating()
        run = request.path_params["run"]

        async def load() -> dict[str, Any]:
            if run in self.checks.busy:  # its folder is locked, and the machine would be closed for nothing
                raise InputError(f"run {run}: its report is being written: resume it after that")
            job, subject = await asyncio.to_thread(self.uploads.resumed, run)
            return await self.loaded(client, load=job, run=run, confirmed=subject)

        return await tried(load)

    async def remove(self, request: Request) -> Response:
        """Remove a job that is not loaded."""
        if self._operator(request) is None:
            return not_operating()
        job = request.path_params["job"]
        loaded = (self.feed.sitting.get("job") or {}).get("id")

        async def remove() -> dict[str, Any]:
            if job == loaded or job in self.checks.busy:
                raise InputError("the job is in use")
            await asyncio.to_thread(self.uploads.remove, job)
            return {"removed": job}

        return await tried(remove)

    async def job_report(self, request: Request) -> Response:
        """Serve the report of a job's check."""
        return await _report_of(self.uploads.job_report, request.path_params["job"])

    async def api_keys(self, request: Request) -> Response:
        """List the API keys of slicers, or make one: its text is shown once."""
        if request.method == "GET":
            return JSONResponse(self.keys.told())
        if self._operator(request) is None:
            return not_operating()
        given = await json_of(request)

        async def make() -> dict[str, Any]:
            text, key = await asyncio.to_thread(self.keys.make, given.get("name"), given.get("scope"))
            return {"key": text} | key.told()

        return await tried(make)

    async def remove_key(self, request: Request) -> Response:
        """Remove an API key, which is valid no more."""
        if self._operator(request) is None:
            return not_operating()
        number = request.path_params["key"]

        async def remove() -> dict[str, Any]:
            await asyncio.to_thread(self.keys.remove, number)
            return {"removed": number}

        return await tried(remove)

    async def runs(self, _request: Request) -> Response:
        """List all runs."""
        return JSONResponse(await asyncio.to_thread(self.uploads.runs, self.checks.busy))

    async def notes(self, request: Request) -> Response:
        """Save a person's note on a run."""
        if self._operator(request) is None:
            return not_operating()
        run = request.path_params["run"]

        async def keep() -> dict[str, Any]:
            text = (await whole_of(request, 4 * MAX_NOTES)).decode("utf-8", "replace")
            return {"notes": await asyncio.to_thread(self.uploads.keep_notes, run, text)}

        return await tried(keep)

    async def reach(self, request: Request) -> Response:
        """Answer whether the platform can be held on the straight way to a position, before that motion is ordered."""
        if self._operator(request) is None:
            return not_operating()
        goal = (await json_of(request)).get("position")

        async def found() -> dict[str, Any]:
            head, platform = self.feed.head, self.feed.state.get("platform") or {}
            if head is None or not platform.get("valid"):
                raise InputError("the position is not known: enable the machine, or home it")
            if not _is_place(goal):
                raise InputError("position: three numbers, m, are expected")
            begin = np.array([*platform["position"], *platform["rotation"]], dtype=float)[: head.robot.n]
            low, high = (np.array(each) for each in self.feed.sitting["frame"])
            async with self._reaching:
                return await asyncio.to_thread(reach, head.robot, begin, np.array(goal, dtype=float), low, high)

        return await tried(found)

    async def picture(self, request: Request) -> Response:
        """Serve the picture of the part that a slicer has put into a job's G-code."""
        try:
            found = await asyncio.to_thread(largest_picture, self.uploads.job(request.path_params["job"]) / GCODE)
        except (InputError, OSError):
            found = None
        if found is None:
            return PlainTextResponse("there is no picture in it\n", 404)
        return Response(found.content, media_type="image/png")

    async def run_report(self, request: Request) -> Response:
        """Serve the report of a run."""
        return await _report_of(self.uploads.run_report, request.path_params["run"])

    async def live(self, socket: WebSocket) -> None:
        """Serve one open page of an operator through its WebSocket."""
        await Live(self, socket).run()

    async def foxglove(self, socket: WebSocket) -> None:
        """Serve one viewer, such as Foxglove, that reads the live log."""
        allowed = self.access.is_view_token(socket.path_params["token"]) and self._readers < foxglove.MAX_CLIENTS
        if not allowed:
            await socket.close(1008)
            return
        self._readers += 1
        try:
            await foxglove.Reader(socket, self.feed).run()
        finally:
            self._readers -= 1

    def _operator(self, request: Request) -> Client | None:
        """The page that operates, if the request is its own."""
        return self.operators.of_secret(request.headers.get("x-page", ""))


def _end_with(task: asyncio.Task[None]) -> None:
    """End the process where one of its tasks has failed: it is started again, and pages connect again."""
    if not task.cancelled() and (error := task.exception()) is not None:
        logging.getLogger("cablewright").error("the page's server fails: %r", error)
        os._exit(1)


def _go_on_without(task: asyncio.Task[None]) -> None:
    """Log that nothing is sent to others any more: the page still stops the machine."""
    if not task.cancelled() and (error := task.exception()) is not None:
        logging.getLogger("cablewright").warning("nothing is sent any more, %s: %s", task.get_name(), error)


async def _report_of(read: Callable[[str], bytes], name: str) -> Response:
    try:
        return Response(await asyncio.to_thread(read, name), media_type="text/html; charset=utf-8")
    except (InputError, OSError) as reason:
        return PlainTextResponse(f"{reason}\n", 404)


def _is_place(value: object) -> bool:
    """Whether it is three numbers of m that a machine can have."""
    return (
        isinstance(value, list)
        and len(value) == 3
        and all(isinstance(v, int | float) and not isinstance(v, bool) and abs(v) <= LARGEST for v in value)
    )
