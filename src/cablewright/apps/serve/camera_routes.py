"""Routes of the calibration by camera: files, pictures, answers of the guide, and acceptance by a person."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Route

from cablewright.apps.serve import camera_folder
from cablewright.apps.serve.camera_folder import FOLDER, MAX_PART, MAX_PICTURE, PARTS, ROOM
from cablewright.apps.serve.check_worker import STAGE, write_station
from cablewright.apps.serve.request_bodies import json_of, not_operating, tried, whole_of
from cablewright.apps.serve.shared_state import Served
from cablewright.foundation.errors import InputError
from cablewright.live.serve.control_process import JOBS
from cablewright.robot import load


class CameraRoutes:
    """Routes of the calibration by camera of a machine that is served."""

    def __init__(self, page: Served) -> None:
        """Of a *page*."""
        self.page, self.folder = page, page.uploads.folder / FOLDER
        self._taking = asyncio.Lock()

    def routes(self) -> list[Route]:
        """All routes of the calibration by camera."""
        return [
            Route("/calibration", self.told),
            Route("/calibration/room", self.room),
            Route("/calibration/pictures", self._by_operator(self.add), methods=["POST"]),
            Route("/calibration/pictures", self._by_operator(self.remove), methods=["DELETE"]),
            Route("/calibration/accept", self._by_operator(self.accept), methods=["POST"]),
            Route("/calibration/adopt", self._by_operator(self.adopt), methods=["POST"]),
            Route("/calibration/stage/{job}", self._by_operator(self.adopt), methods=["POST"]),
            Route("/calibration/{part}", self._by_operator(self.put), methods=["PUT"]),
        ]

    def _by_operator(self, act: Callable[[Request], Awaitable[Any]]) -> Callable[[Request], Awaitable[Response]]:
        """The route of an act that only the page that operates may ask for, one at a time."""

        async def answered(request: Request) -> Response:
            if self.page.operators.of_secret(request.headers.get("x-page", "")) is None:
                return not_operating()

            async def work() -> Any:
                async with self._taking:
                    if FOLDER in self.page.checks.busy:
                        raise InputError("the guide is computing: wait for its answer")
                    return await act(request)

            return await tried(work)

        return answered

    async def told(self, _request: Request) -> Response:
        """Return the files, the pictures and the guide's answer."""
        found = await asyncio.to_thread(camera_folder.told, self.folder)
        return JSONResponse(found | {"busy": self.page.checks.busy.get(FOLDER, ""), "live": bool(self.page.camera)})

    async def room(self, _request: Request) -> Response:
        """Return the picture of the room."""
        if not (self.folder / ROOM).is_file():
            return PlainTextResponse("there is no picture yet\n", 404)
        return FileResponse(self.folder / ROOM, media_type="image/png")

    async def put(self, request: Request) -> dict[str, Any]:
        """Receive the layout of the tags, the camera, or a plan."""
        part = request.path_params["part"]
        if part not in PARTS:
            raise InputError(f"{part[:40]!r}: expected {', '.join(PARTS)}")
        content = await whole_of(request, MAX_PART)
        await asyncio.to_thread(camera_folder.put_part, self.folder, part, content)
        return self._guided()

    async def add(self, request: Request) -> dict[str, Any]:
        """Keep a picture, that of the body or of the live camera, with the present lengths."""
        head = self.page.feed.head
        if head is None or self.page.feed.state.get("state") in (None, "closed"):
            raise InputError("the machine is being opened")
        picture = await whole_of(request, MAX_PICTURE)
        if not picture and not self.page.camera:
            raise InputError("no picture was sent, and serve has no --camera")
        before = dict(self.page.feed.state)
        if not picture:
            picture = await asyncio.to_thread(camera_folder.picture_from, self.page.camera)
            if any(self.page.feed.state.get("speeds") or ()):
                raise InputError("the winches have turned meanwhile: take the picture again once the platform stands")
        name = await asyncio.to_thread(camera_folder.add, self.folder, picture, before, head.robot)
        return {"picture": name} | self._guided()

    async def remove(self, _request: Request) -> dict[str, Any]:
        """Remove the last picture."""
        await asyncio.to_thread(camera_folder.remove_last, self.folder)
        return self._guided()

    async def accept(self, request: Request) -> dict[str, Any]:
        """Take the calibration as it is: its robot file is written."""
        confirmed = str((await json_of(request)).get("confirmed", ""))
        await asyncio.to_thread(camera_folder.may_accept, self.folder, confirmed)
        return self._guided("accept")

    async def adopt(self, request: Request) -> dict[str, Any]:
        """Let the machine be the calibrated robot, or that of a stage, whose exit points have been set."""
        page, job = self.page, request.path_params.get("job")
        file = f"{FOLDER}/calibrated.toml" if job is None else f"{JOBS}/{page.uploads.job(job).name}/{STAGE}"
        if not (page.uploads.folder / file).is_file():
            raise InputError("there is no accepted calibration" if job is None else "the job is no later stage")
        client = page.operators.of_secret(request.headers.get("x-page", ""))
        head = page.feed.head
        if page.feed.sitting.get("kind") != "simulated" or head is None or client is None:
            raise InputError(f"on drives: end serve, and start it with {page.uploads.folder / file}")
        robot = await asyncio.to_thread(load, page.uploads.folder / file)
        found = await page.loaded(client, load=None, adopt=file)
        await asyncio.to_thread(write_station, page.uploads.folder, robot, head.settings)
        if job is not None:
            await asyncio.to_thread(camera_folder.begin_anew, self.folder)
        return found

    def _guided(self, what: str = "guide") -> dict[str, Any]:
        """Queue the computation, once both files are there. Raises `InputError`."""
        needed = [part for part in ("tags", "camera") if not (self.folder / PARTS[part]).is_file()]
        if not needed and (why := self.page.checks.ask(what, FOLDER)):
            raise InputError(why)
        return {"missing": needed}
