"""A job printed on a real machine, in a run folder, commanded by a person."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from cablewright.analyses.travel_moves import driven_job
from cablewright.control.procedure import Procedure
from cablewright.foundation.choices import LawName
from cablewright.foundation.errors import InputError
from cablewright.foundation.file_output import write_whole
from cablewright.foundation.progress import Progress
from cablewright.foundation.saved_state import Snapshot, write_snapshots
from cablewright.foundation.signals import Command, Drives, Encoders, Estimate, Order, OrderKind, PrintState, Tensions
from cablewright.live.drives.session import RealMachine, taking_up
from cablewright.live.prints import loop
from cablewright.live.prints.limits import path_of
from cablewright.live.prints.loop import Operator, Printer
from cablewright.live.prints.part_contact import check_clear
from cablewright.live.prints.print_job import PrintedJob
from cablewright.live.prints.record import finish
from cablewright.live.prints.recorder import (
    FolderRecorder,
    Timing,
    checkpoint_of,
    read_checkpoint,
)
from cablewright.live.prints.run import (
    CHECKPOINT,
    PrintRun,
    alone_in,
    clear_folder,
    folder_log,
    make_folder,
    require_folder,
)
from cablewright.live.prints.snapshot_writer import SnapshotWriter
from cablewright.machine.drives.can_bus import Port
from cablewright.machine.log.head import LogHead
from cablewright.machine.log.log import read_log
from cablewright.machine.log.segments import next_segment
from cablewright.machine.settings import MachineSettings, extruding
from cablewright.models.job_poses import on_plane
from cablewright.models.statics import Model
from cablewright.printing.job import Job
from cablewright.robot import Robot
from cablewright.running.garbage_collection import without_old_objects
from cablewright.running.run_folders import MANIFEST, manifest_of
from cablewright.running.signing_key import signature

_UNREAD: Final = (Command, Drives, Encoders, Estimate, Tensions)
_GAP: Final = 1.0  # s at least between the steps of two runs

WORDS: Final = {
    each.value: each
    for each in (
        OrderKind.RESET,
        OrderKind.ENABLE,
        OrderKind.TAKE_UP,
        OrderKind.HOME,
        OrderKind.START,
        OrderKind.PAUSE,
        OrderKind.RESUME,
        OrderKind.REFILLED,
        OrderKind.STOP,
        OrderKind.RELEASE,
    )
}
"""Orders that a person types, by their words; ``quit`` ends the program, with all winches stopped and braked."""


@dataclass(eq=False)
class PersonOperator:
    """An `Operator`: a person who types orders.

    ``typed`` returns the lines since the last call, ``over`` whether no more come. ``age``: returns that of those
    lines, s, as they may have been typed while the control hung.
    """

    typed: Callable[[], list[str]]
    over: Callable[[], bool]
    say: Callable[[str], None]
    age: Callable[[], float] = field(default=lambda: 0.0, kw_only=True)
    _quits: bool = field(default=False, repr=False)
    _shown: tuple[PrintState | None, str] = field(default=(None, ""), repr=False)

    def orders(self, printer: Printer, now: float) -> tuple[Order, ...]:
        """Return the orders since the last call, at *now*, s; see `Operator.orders`.

        Other input is reported and ignored.
        """
        shown = printer.supervisor.state, printer.supervisor.reason
        if shown != self._shown:
            self._shown = shown
            self.say(f"{shown[0]}{f': {shown[1]}' if shown[1] else ''}")
        given = []
        for line in self.typed():
            word = " ".join(line.split())
            if word == "quit":
                self._quits = True
            elif word in WORDS:
                if WORDS[word] is OrderKind.REFILLED and shown[0] is PrintState.REFILLING:
                    printer.refilled()
                given.append(Order(WORDS[word], "terminal", now - self.age()))
            elif word:
                self.say(f"no order {word!r}; orders: {', '.join(WORDS)}, quit")
        return tuple(given)

    def is_over(self, printer: Printer) -> bool:
        """Return whether the run ends; see `Operator.is_over`.

        True after the print, or when the person quits or has gone.
        """
        return printer.finished or self._quits or self.over()


@dataclass(eq=False)
class _Telling(FolderRecorder):
    """A recorder that also reports why orders were rejected, and why the position is doubted."""

    say: Callable[[str], None] = lambda _line: None
    doubt: Callable[[], str] = lambda: ""
    _told: str = field(default="", repr=False)

    def add(self, printer: Printer, step: loop.Step, *, last: bool) -> None:
        """Record one step; see `StepRecorder.add`."""
        super().add(printer, step, last=last)
        for order in step.orders:
            if order.refusal:
                self.say(f"rejected: {order.refusal}")
        if (doubt := self.doubt()) != self._told:
            self._told = doubt
            if doubt:
                self.say(doubt)


def print_on_drives(
    robot: Robot,
    job: Job,
    folder: Path,
    settings: MachineSettings,
    state: Path,
    operator: Operator,
    *,
    inputs: Mapping[str, str],
    law: LawName = "model",
    layers: int | None = None,
    resume: bool = False,
    restart: bool = False,
    log_every: int = 1,
    say: Callable[[str], None] = lambda _line: None,
    progress: Progress | None = None,
    port: Callable[[], Port] | None = None,
) -> PrintedJob:
    """Print a *job* on the real machine of *settings*, as *operator* orders; the print in *folder* can be resumed.

    *state*: path without suffix of the machine's counts and lengths. *inputs* identify robot and job, see
    `run_folders.manifest_of`. *log_every*: see `LogHead.every`. Raises `InputError`, `AnswerError` and
    `EnvironmentFault` before anything moves.
    """
    if job.robot not in (None, robot.name):
        raise InputError(f"job {job.name!r}: robot = {job.robot!r}, but the robot is {robot.name!r}")
    job = on_plane(robot, job)
    toolpath = job.toolpath()
    job, samples = driven_job(robot, job, toolpath=toolpath)
    bead, differing = job.typical_bead(toolpath)
    owner = extruding(settings, bead, job.motion.print_speed)
    machine = RealMachine.of(robot, owner, state, port)
    path = path_of(robot, job, samples, owner, machine.estimator, law, layers)
    options = {"control": law, "layers": layers, "machine": owner.model_dump(mode="json"), "log_every": log_every}
    manifest = manifest_of("print", inputs, options)
    option = "--restart" if restart else "--resume" if resume else ""
    require_folder(folder, manifest, option)
    assert owner.drives is not None
    for note in (*owner.drives.valve_notes, *(() if owner.extrusion is None else differing)):
        say(note)
    signature(b"")  # a key that cannot be had is said before the work
    procedures: dict[PrintState, Procedure] = {
        PrintState.TENSIONING: taking_up(machine),
        PrintState.HOMING: machine.homing(path.start_pose),
    }
    saved, epoch, begin = taken_up(folder) if resume and not restart else (None, datetime.now(UTC), 0.0)
    printer = machine.printer(path, law, procedures, saved, begin)
    if path.attitude is not None:
        check_clear(Model(robot), job, layers)
    machine.reckon_powder(printer)
    if not option:
        make_folder(folder)
    with alone_in(folder):
        require_folder(folder, manifest, option)
        if restart:
            clear_folder(folder)
        write_whole(folder / MANIFEST, json.dumps(manifest, indent=2).encode() + b"\n")
        run = PrintRun(folder, machine.machine, printer, Timing(owner.period))
        if saved is None:
            write_snapshots(folder / CHECKPOINT, checkpoint_of(printer), sign=signature)
        head = LogHead(robot, owner, owner.period, kind="real", epoch=epoch, every=log_every)
        if printer.finished:
            say("the print was finished before: there is nothing to resume")
        else:
            _run(run, head, operator, say, progress, lambda: machine.keeper.doubt)
        if machine.bus_machine.left:
            say(machine.bus_machine.left)
        record, log = finish(folder, path.track, path.print_speed, None, progress, path.attitude)
        return PrintedJob(machine.estimator, run, record, log).written()


def _run(
    run: PrintRun,
    head: LogHead,
    operator: Operator,
    say: Callable[[str], None],
    progress: Progress | None,
    doubt: Callable[[], str],
) -> None:
    log_path = next_segment(run.folder)
    with (
        folder_log(log_path, head, drops=True) as log,
        SnapshotWriter(run.folder / CHECKPOINT, signature) as writer,
    ):
        recorder = _Telling(log, writer, run.timing, progress, say=say, doubt=doubt)
        with without_old_objects(paced=True):
            run.steps = loop.run(run.printer, operator, recorder)


def taken_up(folder: Path) -> tuple[dict[str, Snapshot], datetime, float]:
    """Return progress of the print in *folder*, UTC of its time 0, and the time after its last logged step, s.

    Raises `InputError` where one of them is lost.
    """
    path = folder / CHECKPOINT
    if not path.exists():
        raise InputError(f"--resume: {folder}: the checkpoint is missing: put {CHECKPOINT} back, or --restart")
    found = read_checkpoint(path)
    last = 0.0
    with read_log(folder) as log:
        epoch = log.head.epoch
        for entry in log.entries(without=_UNREAD):
            last = max(last, entry.frame.time)
    if epoch is None:
        raise InputError(f"--resume: {folder}: the log has no start time: it is not of a real machine")
    return found, epoch, max((datetime.now(UTC) - epoch).total_seconds(), last + _GAP)
