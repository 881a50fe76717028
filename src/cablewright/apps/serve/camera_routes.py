"""Routes of the calibration by camera: files, pictures, answers of the guide, and acceptance by a person."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any, Final

from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Route

from cablewright.apps.serve import camera_folder
from cablewright.apps.serve.camera_folder import FOLDER, MAX_PART, MAX_PICTURE, PARTS, ROOM
from cablewright.apps.serve.check_worker import STAGE
from cablewright.apps.serve.feed import STALE
from cablewright.apps.serve.operators import Client
from cablewright.apps.serve.request_bodies import SMALL, not_operating, object_in, tried, whole_of
from cablewright.apps.serve.shared_state import Served
from cablewright.apps.serve.slicers.shared_actions import SENDING
from cablewright.foundation.errors import EnvironmentFault, InputError
from cablewright.foundation.signals import PrintState
from cablewright.live.serve.control_process import JOBS
from cablewright.live.serve.operated_machines import require_same
from cablewright.robot import load

_OPENING: Final = 120.0  # s that a machine may take to open
_LOOKS: Final = 0.1  # s between looks whether it has


@dataclass(frozen=True, eq=False)
class CameraRequest:
    """A request of the page that operates, its body, and the state of the machine before that was sent."""

    request: Request
    body: bytes
    before: dict[str, Any]
    client: Client


class CameraRoutes:
    """HTTP routes of the calibration by camera, for the machine that this server operates."""

    def __init__(self, page: Served) -> None:
        """Of a *page*."""
        self.page, self.folder = page, page.uploads.folder / FOLDER
        self._taking = asyncio.Lock()
        self._homed = 0  # number of the event of the last homing
        self._watching: asyncio.Task[None] | None = None

    def routes(self) -> list[Route]:
        """All routes of the calibration by camera."""
        pictures, small = "/calibration/pictures", SMALL
        return [
            Route("/calibration", self.told),
            Route("/calibration/room", self.room),
            Route(pictures, self._by_operator(self.add, MAX_PICTURE), methods=["POST"]),
            Route(pictures, self._by_operator(self.remove, small), methods=["DELETE"]),
            Route("/calibration/guide", self._by_operator(self.guide, small), methods=["POST"]),
            Route("/calibration/anew", self._by_operator(self.begin_anew, small), methods=["POST"]),
            Route("/calibration/accept", self._by_operator(self.accept, small), methods=["POST"]),
            Route("/calibration/adopt", self._by_operator(self.adopt, small), methods=["POST"]),
            Route("/calibration/stage/{job}", self._by_operator(self.adopt, small), methods=["POST"]),
            Route("/calibration/{part}", self._by_operator(self.put, MAX_PART), methods=["PUT"]),
        ]

    def _by_operator(
        self, act: Callable[[CameraRequest], Awaitable[Any]], most: int
    ) -> Callable[[Request], Awaitable[Response]]:
        """The route of an act that only the page that operates may ask for, one at a time; *most*: bytes of a body."""

        async def answered(request: Request) -> Response:
            secret = request.headers.get("x-page", "")
            if self.page.operators.of_secret(secret) is None:
                return not_operating()
            if self._watching is None:
                self._watching = asyncio.create_task(self._watch())
            before = self._present()

            async def work() -> Any:
                async with asyncio.timeout(SENDING), self.page.sending:
                    body = await whole_of(request, most)
                async with self._taking:
                    client = self.page.operators.of_secret(secret)  # sending may have taken long
                    if client is None:
                        raise InputError("this page does not operate the machine any more")
                    if FOLDER in self.page.checks.busy:
                        raise InputError("the guide is computing: wait for its answer")
                    return await act(CameraRequest(request, body, before, client))

            return await tried(work)

        return answered

    async def _watch(self) -> None:
        """Note each homing: lengths have another zero after it."""
        version = -1
        while True:
            version = await self.page.feed.next(version)
            self._look()

    def _look(self) -> None:
        begun = [
            number
            for number, _, kind, text in self.page.feed.state.get("events", ())
            if kind == "state" and text.startswith(PrintState.HOMING.value)
        ]
        self._homed = max([self._homed, *begun])

    def _present(self) -> dict[str, Any]:
        """The present state of the machine, with the name of the zero of its lengths; empty where it is old."""
        state, head = self.page.feed.state, self.page.feed.head
        if head is None or time.monotonic() - float(state.get("clock", -1e9)) > STALE:
            return {}
        self._look()
        return state | {"zero": f"{head.epoch}, {state.get('sitting')}, {self._homed}"}

    async def told(self, _request: Request) -> Response:
        """Return the files, the pictures and the guide's answer."""
        found = await asyncio.to_thread(camera_folder.told, self.folder)
        return JSONResponse(found | {"busy": self.page.checks.busy.get(FOLDER, ""), "live": bool(self.page.camera)})

    async def room(self, _request: Request) -> Response:
        """Return the picture of the room."""
        if not (self.folder / ROOM).is_file():
            return PlainTextResponse("there is no picture yet\n", 404)
        return FileResponse(self.folder / ROOM, media_type="image/png")

    async def put(self, asked: CameraRequest) -> dict[str, Any]:
        """Receive the layout of the tags, the camera, or a plan."""
        part = asked.request.path_params["part"]
        if part not in PARTS:
            raise InputError(f"{part[:40]!r}: expected {', '.join(PARTS)}")
        self._require_room()
        await asyncio.to_thread(camera_folder.put_part, self.folder, part, asked.body)
        return self._guided()

    async def add(self, asked: CameraRequest) -> dict[str, Any]:
        """Store a picture, uploaded or from the live camera, together with the present line lengths."""
        head, picture, before = self.page.feed.head, asked.body, asked.before
        if head is None or self.page.feed.state.get("state") in (None, "closed"):
            raise InputError("the machine is being opened")
        if not picture and not self.page.camera:
            raise InputError("no picture was sent, and serve has no --camera")
        self._require_room()
        if not picture:
            before = self._present()
            picture = await asyncio.to_thread(camera_folder.picture_from, self.page.camera)
        after = self._present()
        name = await asyncio.to_thread(camera_folder.add, self.folder, picture, before, after, head.robot)
        return {"picture": name} | self._guided()

    async def remove(self, _asked: CameraRequest) -> dict[str, Any]:
        """Remove the last picture."""
        self._require_room()
        await asyncio.to_thread(camera_folder.remove_last, self.folder)
        return self._guided()

    async def guide(self, _asked: CameraRequest) -> dict[str, Any]:
        """Compute the guide's answer again."""
        return self._guided()

    async def begin_anew(self, _asked: CameraRequest) -> dict[str, Any]:
        """Remove all pictures, such as after a homing."""
        self._require_room()
        await asyncio.to_thread(camera_folder.begin_anew, self.folder)
        return self._guided()

    async def accept(self, asked: CameraRequest) -> dict[str, Any]:
        """Take the calibration as it is: its robot file is written."""
        self._require_room()
        confirmed = str(object_in(asked.body).get("confirmed", ""))
        await asyncio.to_thread(camera_folder.may_accept, self.folder, confirmed)
        return self._guided("accept")

    async def adopt(self, asked: CameraRequest) -> dict[str, Any]:
        """Let the machine be the calibrated robot, or that of a stage, whose exit points have been set."""
        page, job = self.page, asked.request.path_params.get("job")
        file = f"{FOLDER}/calibrated.toml" if job is None else f"{JOBS}/{page.uploads.job(job).name}/{STAGE}"
        if not (page.uploads.folder / file).is_file():
            raise InputError("there is no accepted calibration" if job is None else "the job is no later stage")
        head, last = page.feed.head, int(page.feed.state.get("sitting", 0))
        if page.feed.sitting.get("kind") != "simulated" or head is None:
            raise InputError(f"on drives: end serve, and start it with {page.uploads.folder / file}")
        require_same(head.robot, await asyncio.to_thread(load, page.uploads.folder / file))
        found = await page.loaded(asked.client, load=None, adopt=file)
        await self._opened_after(last)
        await asyncio.to_thread(camera_folder.begin_anew, self.folder, keeps_robot=job is None)
        return found

    async def _opened_after(self, last: int) -> None:
        """Wait until a sitting after the *last* one has begun. Raises `InputError` where it does not."""
        end = time.monotonic() + _OPENING
        while int(self.page.feed.sitting.get("sitting", 0)) <= last:
            state = self.page.feed.state
            if state.get("state") == "closed" and not state.get("opening") and int(state["sitting"]) > last:
                raise InputError(f"the machine stays as it was: {state['reason']}")
            if time.monotonic() > end:
                raise EnvironmentFault(f"the machine has not opened within {_OPENING:g} s: see its state")
            await asyncio.sleep(_LOOKS)

    def _require_room(self) -> None:
        """Raise `InputError` where nothing could be computed of a change."""
        if why := self.page.checks.refusal(FOLDER):
            raise InputError(why)

    def _guided(self, what: str = "guide") -> dict[str, Any]:
        """Queue the computation once layout and camera are there; ``why`` in the answer: why it is not queued."""
        needed = [part for part in ("tags", "camera") if not (self.folder / PARTS[part]).is_file()]
        why = "" if needed else self.page.checks.ask(what, FOLDER)
        return {"missing": needed} | ({"why": why} if why else {})
