"""Queue of checks, reports and calibrations: one at a time, each in a process with limits."""

from __future__ import annotations

import asyncio
import logging
import os
import sys
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Final

from cablewright.apps.serve.camera_folder import FOLDER, write_answer
from cablewright.apps.serve.check_worker import TIME
from cablewright.apps.serve.uploads import FAILED, Uploads
from cablewright.foundation.errors import CablewrightError, one_line
from cablewright.foundation.file_output import write_whole
from cablewright.live.serve.jobs import JobCheck, forget_check, read_check, write_check

WAITING: Final = 10
"""Checks that may wait."""

_DOING: Final = {"check": "is being checked", "report": "is being written"}
_WALL_TIME: Final = 2 * TIME  # s
_NOTHING: Final = "0" * 64


@dataclass(eq=False)
class Checks:
    """The queue of checks and reports for `Uploads`. ``busy``: the present task, by job or run."""

    uploads: Uploads
    busy: dict[str, str] = field(default_factory=dict)
    _queue: asyncio.Queue[tuple[str, str]] = field(default_factory=lambda: asyncio.Queue(WAITING))

    def ask(self, what: str, subject: str) -> str:
        """Queue the ``check`` of a job, the ``report`` of a run, or ``guide`` or ``accept`` of the calibration.

        Return why it is not queued, or an empty text. Raises `EnvironmentFault` where an earlier answer cannot be
        removed.
        """
        if why := self.refusal(subject):
            return why
        if what == "check":
            forget_check(self.uploads.job(subject))
        self._queue.put_nowait((what, subject))
        self.busy[subject] = "waits"
        return ""

    def refusal(self, subject: str) -> str:
        """Return why nothing of a job, run or calibration can be queued now, or an empty text."""
        if subject in self.busy:
            return "it is being done already"
        return f"{WAITING} wait already; try again later" if self._queue.full() else ""

    async def run(self) -> None:
        """Run the queued checks and reports one after the other."""
        while True:
            what, subject = await self._queue.get()
            self.busy[subject] = _DOING.get(what, "is being computed")
            try:
                await self._do(what, subject)
            finally:
                self.busy.pop(subject, None)

    async def _do(self, what: str, subject: str) -> None:
        try:
            worker = await asyncio.create_subprocess_exec(
                sys.executable, "-m", "cablewright.apps.serve.check_worker", what, str(self.uploads.folder), subject,
                stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.DEVNULL, stderr=asyncio.subprocess.PIPE,
                env=os.environ | {"NUMBA_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
            )  # fmt: skip
        except OSError as reason:
            self._failed(what, subject, f"no process could be started: {reason.strerror or reason}")
            return
        assert worker.stderr is not None
        try:
            async with asyncio.timeout(_WALL_TIME):
                said = (await worker.stderr.read())[-2000:]
                code = await worker.wait()
        except TimeoutError:
            code, said = -1, b"it took too long"
        finally:
            if worker.returncode is None:
                worker.kill()
                await worker.wait()
        if code:
            last = said.decode(errors="replace").strip().splitlines()[-1:] or ["it was ended by the system"]
            limits = f"processor time of {TIME} s, or memory, may be over" if code < 0 else "exit code " + str(code)
            self._failed(what, subject, one_line(f"{last[0]} ({limits})"))

    def _failed(self, what: str, subject: str, why: str) -> None:
        with suppress(CablewrightError, OSError):
            if what in ("guide", "accept"):
                write_answer(self.uploads.folder / FOLDER, {"failed": why})
            elif what == "report":
                write_whole(self.uploads.run_folder(subject) / FAILED, why.encode())
            elif read_check(folder := self.uploads.job(subject)) is None:
                write_check(folder, JobCheck(subject=_NOTHING, answer="failed", why=why))
            else:  # the answer may be in use
                logging.getLogger("cablewright").warning("job %s has no report: %s", subject, why)
