"""Actions of both slicer interfaces: accept an upload, list jobs, pause or end a print. None loads a job or moves."""

from __future__ import annotations

import asyncio
import time
from dataclasses import dataclass, field
from typing import Any, Final

from starlette.requests import Request

from cablewright.apps.serve.shared_state import Served
from cablewright.apps.serve.slicers.keys import Key
from cablewright.apps.serve.slicers.machine_view import MachineView, view_of
from cablewright.apps.serve.slicers.multipart_forms import file_name, read_form
from cablewright.apps.serve.slicers.slicer_comments import GcodeNotes, notes_of
from cablewright.foundation.errors import CablewrightError, EnvironmentFault, InputError
from cablewright.foundation.signals import OrderKind
from cablewright.live.serve.jobs import GCODE

NO_START: Final = "no slicer starts or moves the machine: a person confirms that on its page"
"""Why an order that starts motion is rejected, whatever the key."""

SENDING: Final = 300.0
"""Time that one upload may take, s."""

_PART: Final = "gcode"
_MOST_NOTES: Final = 60
_FRESH: Final = 0.5  # s, for which the list of jobs is kept


class Forbidden(InputError):
    """Error: the key does not allow the action, or nothing does."""


class Busy(InputError):
    """Error: too many requests of this kind at a time."""


@dataclass(eq=False)
class Desk:
    """Actions of the operator's server that slicers can request."""

    page: Served
    _jobs: list[dict[str, Any]] = field(default_factory=list)
    _listed: float = -1e9  # s
    _notes: dict[str, GcodeNotes] = field(default_factory=dict)  # by the number of the job

    async def jobs(self) -> list[dict[str, Any]]:
        """All jobs of the served folder, the newest first."""
        if time.monotonic() - self._listed > _FRESH:
            self._jobs = await asyncio.to_thread(self.page.uploads.jobs, self.page.checks.busy)
            self._listed = time.monotonic()
        return self._jobs

    async def files(self) -> list[dict[str, Any]]:
        """The jobs that slicers have sent, the newest of each name."""
        found: dict[str, dict[str, Any]] = {}
        for job in await self.jobs():
            if job["file"] and _PART in job["parts"]:
                found.setdefault(job["file"], job)
        return list(found.values())

    async def file(self, name: object) -> dict[str, Any]:
        """Return the newest job of that name. Raises `InputError`."""
        wanted = file_name(name.removeprefix("gcodes/")) if isinstance(name, str) else ""
        for job in await self.files():
            if job["file"] == wanted:
                return job
        raise InputError(f"{wanted!r}: there is no such file")

    async def notes(self, job: dict[str, Any]) -> GcodeNotes:
        """Return the comments of the slicer in a job's G-code. Raises `InputError`."""
        if job["id"] not in self._notes:
            try:
                found = await asyncio.to_thread(notes_of, self.page.uploads.job(job["id"]) / GCODE)
            except OSError:
                raise InputError(f"{job['file']!r}: there is no such file") from None
            if len(self._notes) >= _MOST_NOTES:
                self._notes.clear()
            self._notes[job["id"]] = found
        return self._notes[job["id"]]

    async def view(self) -> MachineView:
        """Return the present state of the machine for slicers."""
        return await asyncio.to_thread(view_of, self.page, await self.jobs())

    async def upload(self, request: Request, key: Key) -> dict[str, Any]:
        """Receive a file, and request its check; return its job.

        Raises `InputError` (`TooLarge`, `Busy`) for a rejected file, `EnvironmentFault` where it cannot be stored.
        """
        if self.page.sending.locked():
            raise Busy("others are sending; send it again in a minute")
        async with self.page.sending, asyncio.timeout(SENDING):
            form = await read_form(request)
            uploads, checks = self.page.uploads, self.page.checks
            pictured = b"; thumbnail begin" in form.content[: 1 << 20]
            about = {"file": form.name, "by": key.title, "wants_print": form.wants_print, "has_picture": pictured}
            number = await asyncio.to_thread(lambda: uploads.new_job(form.name.rpartition(".")[0], **about))
            try:
                await asyncio.to_thread(uploads.put_whole, number, _PART, form.content)
                if why := checks.ask("check", number):
                    raise Busy(f"the check of {form.name!r} cannot be queued: {why}")
            except (CablewrightError, OSError):
                await asyncio.to_thread(uploads.remove, number)
                raise
        self._listed = -1e9
        return next(job for job in await self.jobs() if job["id"] == number)

    async def rest(self, kind: OrderKind, key: Key) -> None:
        """Pause or end the print. Raises `Forbidden` for a key that only uploads, `InputError` where it is rejected."""
        if not key.operates:
            raise Forbidden(
                f"the key {key.name!r} is for uploads: pausing and ending a print needs one with the scope operate"
            )
        if why := await self.page.calm(kind, key.title):
            raise InputError(why)

    def stop(self, key: Key) -> None:
        """Stop the machine. Raises `EnvironmentFault` where the control does not answer."""
        if not self.page.send_stop(key.title):
            raise EnvironmentFault("the control does not answer: use the emergency stop at the machine")
