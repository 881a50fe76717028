"""The control process of a machine that people operate: one run of the loop after another, whoever watches."""

from __future__ import annotations

import json
import logging
import re
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final

import numpy as np

from cablewright.foundation.errors import CablewrightError, EnvironmentFault, InputError, one_line
from cablewright.foundation.file_output import write_whole
from cablewright.live.prints import loop
from cablewright.live.prints.loop import StepRecorder
from cablewright.live.prints.recorder import FolderRecorder, Timing
from cablewright.live.prints.run import CHECKPOINT, alone_in, folder_log, make_folder
from cablewright.live.prints.snapshot_writer import SnapshotWriter
from cablewright.live.serve.events import Events
from cablewright.live.serve.jobs import digest_of, folder_of, load_served, read_check, subject_of
from cablewright.live.serve.link import ControlLink
from cablewright.live.serve.messages import LoadMessage
from cablewright.live.serve.operated_machines import Sitting, Station
from cablewright.live.serve.page_orders import PageOperator
from cablewright.live.serve.status import Telling, told_sitting, waiting_state
from cablewright.machine.log.segments import next_segment
from cablewright.machine.settings import MachineSettings
from cablewright.printing.job import Job
from cablewright.robot import Robot
from cablewright.robot import load as load_robot
from cablewright.running.garbage_collection import without_old_objects
from cablewright.running.run_folders import MANIFEST, manifest_of, read_manifest
from cablewright.running.signing_key import signature

JOBS: Final = "jobs"
RUNS: Final = "runs"
ORDERS: Final = "orders.jsonl"
RUN: Final = "run.json"
STATION: Final = "station.json"
"""File in the served folder with the robot and the owner's settings of the machine."""

_MENDED: Final = "once that is mended, open the machine again"
_AGAIN: Final = 0.2  # s between looks while no machine is open
_BINS: Final = np.array([-np.inf, 0.0, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2, 5e-2, 0.1, np.inf])  # s late


@dataclass(eq=False)
class Control:
    """Runs a machine for the operator's page at the other end of the link.

    ``folder``: folder of jobs, runs and orders. ``ready``: called once, when the machine of the first sitting is made.
    """

    station: Station
    link: ControlLink
    folder: Path
    ends: Callable[[], bool]
    ready: Callable[[], None] = lambda: None
    number: int = 0  # of the sitting
    _events: Events = field(init=False)
    _begun: int = 0  # number of the last sitting in which the machine ran
    _rejected: tuple[str, str] | None = None  # number of a job that it could not take up since the last sitting; why

    def __post_init__(self) -> None:
        """Raises `EnvironmentFault` where nothing can be written."""
        for name in (JOBS, RUNS):
            make_folder(self.folder / name)
        self._events = Events.at(self.folder / ORDERS)

    def close(self) -> None:
        """Close the file that records the operators' orders."""
        self._events.close()

    def run(self) -> None:
        """Run sittings until `ends`. Raises errors before the machine has run, such as of a missing machine."""
        load: LoadMessage | None = None
        while not self.ends():
            try:
                load = self._sit(load)
            except (CablewrightError, ArithmeticError, np.linalg.LinAlgError, MemoryError, OSError) as error:
                if not self._begun:
                    raise
                why = one_line(str(error) or "there is not enough memory for this")
                broken = isinstance(error, EnvironmentFault | OSError)
                why = f"{why}; {_MENDED}" if broken else why
                self._events.tell("fault", why)
                logging.getLogger("cablewright").warning("%s", why)
                job = None if load is None else load.load
                if job is not None and self._begun < self.number:
                    self._rejected = job, why
                load = self._wait(why) if broken or job is None else None

    def _sit(self, load: LoadMessage | None) -> LoadMessage | None:
        """One sitting; return what is taken up next."""
        self.number += 1
        wanted = None if load is None else load.load
        told = "the job is being loaded" if wanted else "the machine is being opened"
        self.link.state.write(waiting_state(self.number, told, self._events, opening=True))
        job = self._job(load)
        again = None if load is None or load.run is None else self.folder / RUNS / load.run
        adopted = None if load is None else load.adopt
        sitting = self.station.sitting(job, again) if adopted is None else self._adopted(adopted)
        if self.number == 1:
            self.ready()
        run = None if job is None else self._run_name(sitting) if again is None else again.name
        with ExitStack() as stack:
            timing = Timing(sitting.printer.machine.period)
            kept = (
                None if run is None or wanted is None else stack.enter_context(self._kept(sitting, run, wanted, timing))
            )

            def ends() -> bool:
                return self.ends() or telling.gives_up(sitting.printer)

            operator = PageOperator(
                self.link, self._events, job is not None, self._may_load, sitting.refill, ends, sitting.home_at,
                sitting.winches,
            )  # fmt: skip
            telling = Telling(self.link, sitting, operator, self._events, kept, self.number)
            self.link.sitting.write(
                told_sitting(self.number, sitting, wanted, run, self._rejected, resumed=again is not None)
            )
            self._rejected = None
            if run is not None:
                self._events.tell("run", f"run {run} {'begins' if again is None else 'goes on'}")
            for note in sitting.notes:
                self._events.tell("notice", note)
            self._refuse_all("the machine was closed")
            if run is not None:
                stack.callback(self._end, sitting, run, timing)
            try:
                with without_old_objects(paced=True):
                    loop.run(sitting.printer, operator, telling)
            finally:
                self._begun = self.number if telling.begun else self._begun
            if telling.lost is not None:
                raise telling.lost
        return operator.load

    def _adopted(self, file: str) -> Sitting:
        """A sitting of the robot in a *file*, for which jobs are checked from then on; on an error nothing changes."""
        before = self.station.robot
        self.station.adopt(load_robot(self.folder / file))
        try:
            sitting = self.station.sitting(None)
            write_station(self.folder, self.station.robot, sitting.head.settings)
        except BaseException:
            self.station.robot = before
            raise
        self._events.tell("notice", f"the robot is that of {file}")
        return sitting

    def _job(self, load: LoadMessage | None) -> Job | None:
        if load is None or load.load is None:
            return None
        folder = folder_of(self.folder / JOBS, load.load)
        subject = subject_of(folder, self.station.robot)
        if why := self._may_load(load, subject):
            raise InputError(f"load: {why}")
        if load.run is not None and self._inputs(load.run) != (load.load, subject):
            raise InputError(f"load: the run {load.run} is of another job, or of a robot that has changed since")
        return load_served(folder, load.load)

    def _inputs(self, run: str) -> tuple[object, object]:
        """Number of the job of a run, and the subject of its check."""
        inputs = (read_manifest(self.folder / RUNS / run) or {}).get("inputs") or {}
        return inputs.get("job"), inputs.get("subject")

    def _may_load(self, load: LoadMessage, subject: str = "") -> str:
        """Why a job may not be taken up; an empty text: it may. Its files must be those that were checked.

        *subject*: hash of its files now; empty while the machine is open, as large files are not read then.
        """
        if load.load is None:
            return ""
        try:
            folder = folder_of(self.folder / JOBS, load.load)
            check = read_check(folder)
            if check is None:
                return "it was not checked yet"
            return check.refusal(subject or check.subject, load.confirmed, digest_of(self.station.robot))
        except InputError as error:
            return str(error)

    def _run_name(self, sitting: Sitting) -> str:
        """A name that no run has, which sorts by time."""
        assert sitting.job is not None
        words = re.sub(r"[^a-z0-9]+", "-", sitting.job.name.lower()).strip("-")[:40] or "job"
        stamp = datetime.now(UTC).strftime("%Y%m%d-%H%M%S")
        names = (f"{stamp}-{words}{f'-{k}' if k else ''}" for k in range(1000))
        return next(name for name in names if not (self.folder / RUNS / name).exists())

    @contextmanager
    def _kept(self, sitting: Sitting, run: str, job: str, timing: Timing) -> Iterator[StepRecorder]:
        """What keeps a run in its folder, one that goes on after what is there.

        Raises `EnvironmentFault`, and `InputError` for a run of a machine that has changed: its times of the path are
        no longer those of the checkpoint.
        """
        folder = self.folder / RUNS / run
        make_folder(folder)
        options = {"machine": sitting.head.settings.model_dump(mode="json")}
        if (kept := read_manifest(folder)) is not None:
            if kept.get("options") != manifest_of("serve", {}, options)["options"]:
                raise InputError(f"load: the machine file has changed since the run {run}: print it again")
        else:
            own = folder_of(self.folder / JOBS, job)
            inputs: dict[str, Any] = {"job": job, "subject": subject_of(own, self.station.robot)}
            if (check := read_check(own)) is not None:
                told = check.model_dump(include={"answer", "why", "expected_error", "duration", "section"})
                inputs["check"] = told | {"name": sitting.job.name if sitting.job is not None else ""}
            manifest = manifest_of("serve", inputs, options)
            write_whole(folder / MANIFEST, json.dumps(manifest, indent=2).encode() + b"\n")
        with (
            alone_in(folder),
            folder_log(next_segment(folder), sitting.head, drops=True) as log,
            SnapshotWriter(folder / CHECKPOINT, signature) as writer,
        ):
            (folder / RUN).unlink(missing_ok=True)  # how it ended before: it may be cut off again
            yield FolderRecorder(log, writer, timing)

    def _end(self, sitting: Sitting, run: str, timing: Timing) -> None:
        """Keep how a run ended, for its report."""
        supervised, late = sitting.printer.supervisor, np.array(sitting.lateness())
        timing.lateness.extend(late.tolist())
        status = "finished" if sitting.printer.finished else supervised.state.value
        counts = np.histogram(late, _BINS)[0].tolist()
        about = {
            "status": status,
            "reason": supervised.reason,
            "laid": _laid(sitting),
            "steps": timing.statistics(),
            "late_up_to": [None if not np.isfinite(each) else each for each in _BINS[1:].tolist()],
            "late": counts,
        }
        self._events.tell("run", f"run {run} ends: {status}")
        try:
            write_whole(self.folder / RUNS / run / RUN, json.dumps(about).encode())
        except EnvironmentFault as fault:  # whoever removed the folder has the rest
            self._events.tell("fault", str(fault))

    def _wait(self, why: str) -> LoadMessage | None:
        """Wait with the machine closed until somebody asks for it again."""
        while not self.ends():
            self.link.state.write(waiting_state(self.number, why, self._events))
            if (load := self._refuse_all("the machine is closed", but_load=True)) is not None:
                return load
            time.sleep(_AGAIN)
        return None

    def _refuse_all(self, why: str, *, but_load: bool = False) -> LoadMessage | None:
        """Reject the messages that have come while no machine was open; return the first that loads, if wanted."""
        for message in self.link.messages():
            loads = isinstance(message, LoadMessage) and but_load
            refusal = self.link.untimely(message) if loads else why
            self._events.answers.append((message.number, message.by, refusal))
            if isinstance(message, LoadMessage) and not refusal:
                return message
        return None


def write_station(folder: Path, robot: Robot, owner: MachineSettings) -> None:
    """Write the file from which checks read robot and machine. Raises `EnvironmentFault`."""
    about = {"robot": robot.model_dump_json(), "machine": owner.model_dump_json(by_alias=True)}
    write_whole(folder / STATION, json.dumps(about).encode())


def _laid(sitting: Sitting) -> float:
    """Length of the strands that a sitting has laid, m, those before it was resumed too."""
    track, done = sitting.path.track, sitting.path.distance(sitting.printer.guide.path_time)
    pieces = np.clip(done - track.distance[:-1], 0.0, np.diff(track.distance))
    return float(pieces[track.laying].sum())
