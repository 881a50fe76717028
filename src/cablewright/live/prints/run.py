"""A whole print on a simulated machine, in a run folder from which an interrupted print can be resumed.

While it runs the folder holds ``manifest.json`` (the inputs), the log's segments, and ``checkpoint.bin``: machine and
print at one time, at most half a second old. A resumed print starts with the machine as in the checkpoint, estimates
the platform's position, returns to its position on the path and continues.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final

from cablewright.control.path_follower import TimedPath
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.file_output import cannot_write, is_unfinished, write_whole
from cablewright.foundation.progress import Progress
from cablewright.foundation.saved_state import write_snapshots
from cablewright.foundation.signals import Estimate, PrintState, Scan, Truth
from cablewright.live.estimators import Estimator, estimator
from cablewright.live.prints import loop
from cablewright.live.prints.loop import Printer, PrintPlan
from cablewright.live.prints.plan import MACHINE_FILE, MachineTwin, PrintOptions, plan_print
from cablewright.live.prints.record import Recorder
from cablewright.live.prints.recorder import (
    CHECKPOINT_INTERVAL,
    FolderRecorder,
    Timing,
    checkpoint_of,
    read_checkpoint,
)
from cablewright.live.prints.simulated_operator import attendant_of
from cablewright.live.prints.snapshot_writer import SnapshotWriter
from cablewright.machine.interface import Machine
from cablewright.machine.log.head import LogHead
from cablewright.machine.log.log import LogWriter, read_log, write_log
from cablewright.machine.log.segments import FIRST_SEGMENT, JOINED_NAME, log_files, next_segment
from cablewright.machine.real_time_machine import Paced
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.robot import Robot
from cablewright.running.garbage_collection import without_old_objects
from cablewright.running.locks import locked
from cablewright.running.run_folders import MANIFEST, manifest_of, read_manifest
from cablewright.running.signing_key import signature

CHECKPOINT: Final = "checkpoint.bin"
LOCK: Final = "lock"

_BEGUN_LOG: Final = 1024  # bytes; the head of a log has more, so that a smaller one holds no step


@dataclass(eq=False)
class PrintRun:
    """A print that has ended, with its ``state`` and ``reason``."""

    folder: Path
    machine: Machine
    printer: Printer
    timing: Timing
    steps: int = 0
    record: Recorder | None = None  # of all steps of the print, where this program has seen all as its log has them

    @property
    def finished(self) -> bool:
        """Whether the print has reached the end of its path."""
        return self.printer.finished

    @property
    def state(self) -> PrintState:
        """Present state of the print."""
        return self.printer.supervisor.state

    @property
    def status(self) -> str:
        """``finished``, or the present state."""
        return "finished" if self.finished else self.state.value

    @property
    def reason(self) -> str:
        """Reason for the present state of the print, such as a stop."""
        return self.printer.supervisor.reason


def run_print(
    twin: MachineTwin,
    folder: Path,
    inputs: Mapping[str, str],
    options: Mapping[str, object],
    *,
    resume: bool = False,
    restart: bool = False,
    real_time: bool = False,
    progress: Progress | None = None,
) -> PrintRun:
    """Print until the end of the path or until the machine stops; the print in *folder* can be resumed.

    *inputs* and *options* identify the print, see `run_folders.manifest_of`; with *resume* they must be those of the
    print in *folder*, and with *restart* too, which prints it again from the beginning. With *real_time* a step waits
    for its time, partly in a busy loop, which needs a core of its own.

    Raises `InputError` for a folder that holds something else, or nothing to resume, or has lost its checkpoint or its
    log, so that the laid material or the measurements are unknown; `AnswerError` for a path that cannot be printed;
    `EnvironmentFault` where the folder cannot be written: the print can then be resumed.
    """
    manifest, option = manifest_of("print", inputs, options), "--restart" if restart else "--resume" if resume else ""
    require_folder(folder, manifest, option)
    signature(b"")  # a key that cannot be had is said before the work
    plan = plan_print(twin)
    begun = None if resume and not restart else begin_print(twin, plan)  # a print that is rejected leaves no folder
    if begun is not None and not restart:
        make_folder(folder)
    with alone_in(folder):
        require_folder(folder, manifest, option)  # again: another program may have begun a print here meanwhile
        if restart:
            clear_folder(folder)
        if begun is not None:
            write_whole(folder / MANIFEST, json.dumps(manifest, indent=2).encode() + b"\n")
            if twin.built:
                write_whole(folder / MACHINE_FILE, twin.built.encode())
        machine, printer = begun or _taken_up(twin, plan, folder)
        run = PrintRun(folder, machine, printer, Timing(machine.period))
        if not run.finished:
            plant, seed, simulation = twin.choices.plant, twin.choices.seed, machine.simulation
            begin = twin.path.start_pose
            head = LogHead(
                started(twin.robot, twin.path),
                machine.settings,
                machine.period,
                simulation=simulation,
                plant=plant,
                seed=seed,
                epoch=log_epoch(folder, real_time),
                home=tuple(begin.tolist()),
                every=twin.choices.log_every,
            )
            path = next_segment(folder)
            if begun is not None and head.every == 1 and not real_time:
                run.record = Recorder(head, twin.path.track, twin.path.print_speed, twin.path.attitude)
            if begun is not None:  # before anything is laid, so that a log never stands alone
                write_snapshots(folder / CHECKPOINT, checkpoint_of(printer), sign=signature)
            with (
                folder_log(path, head, drops=real_time) as log,
                SnapshotWriter(folder / CHECKPOINT, signature) as writer,
            ):
                recorder = FolderRecorder(log, writer, run.timing, progress, run.record)
                _run(run, twin.choices, recorder, real_time)
        return run


def folder_log(path: Path, head: LogHead, *, drops: bool) -> AbstractContextManager[LogWriter]:
    """Open a log in a run folder, written by a thread; *drops*: see `LogWriter`."""
    return write_log(path, head, flush_every=CHECKPOINT_INTERVAL, clock=time.monotonic, threaded=True, drops=drops)


def log_epoch(folder: Path, real_time: bool) -> datetime | None:
    """Return the UTC of time 0 of a print: that of the log in *folder*, or now for one that begins in real time.

    None for a simulation faster than real time: its log is a function of its input.
    """
    if any(folder.glob("log*.mcap")):
        with suppress(InputError), read_log(folder) as log:  # one that was never flushed has no head
            return log.head.epoch
    return datetime.now(UTC).replace(microsecond=0) if real_time else None


def _run(run: PrintRun, choices: PrintOptions, recorder: FolderRecorder, real_time: bool) -> None:
    """Run steps until the print ends, with a simulated attendant."""
    machine, printer = run.machine, run.printer
    assert isinstance(machine, SimulatedMachine)
    paced = Paced(machine) if real_time else None
    if paced is not None:
        printer.machine, run.timing.lateness = paced, paced.lateness
    attendant = attendant_of(machine, printer, choices)
    with without_old_objects(paced=real_time):
        run.steps = loop.run(printer, attendant, recorder)


def alone_in(folder: Path) -> AbstractContextManager[None]:
    """Lock *folder* for this program; the system releases the lock when the program ends, even if it is killed.

    Raises `EnvironmentFault` where another program holds the lock, or where it cannot be made: a link is not followed.
    """
    return locked(folder / LOCK, f"{folder}: another program works in this folder")


def started(robot: Robot, path: TimedPath) -> Robot:
    """Return *robot* with its platform retracted as at the beginning of *path*."""
    length = path.start_retraction
    return robot if math.isnan(length) else robot.retracted(length)


def begin_print(twin: MachineTwin, plan: PrintPlan) -> tuple[SimulatedMachine, Printer]:
    """Return the machine and the control loop of a print at the start of the path."""
    choices, begin = twin.choices, twin.path.start_pose
    machine = SimulatedMachine(_described(twin), twin.settings, begin, seed=choices.seed, plant=choices.plant)
    if twin.upon is not None and twin.upon.ground is not None:
        machine.rig.ground.take_over(twin.upon.ground)
    return machine, Printer(plan, machine, _maker(twin, machine), now=machine.time)


def _taken_up(twin: MachineTwin, plan: PrintPlan, folder: Path) -> tuple[SimulatedMachine, Printer]:
    """Machine and print from the checkpoint, or at the start of the path if nothing was laid yet."""
    path, choices = folder / CHECKPOINT, twin.choices
    if not path.exists():
        done = _logged_distance(folder)
        if done > 0.0:
            why = f"the checkpoint is missing, and the log shows that {done:.2f} m of the path were printed"
            raise InputError(f"--resume: {folder}: {why}: put {CHECKPOINT} back, or --restart to print all again")
        return begin_print(twin, plan)
    found = read_checkpoint(path)
    if "machine" not in found:
        raise InputError(f"{path}: holds no machine and print")
    machine = SimulatedMachine.resumed(
        _described(twin), twin.settings, found["machine"], seed=choices.seed, plant=choices.plant
    )
    if machine.time > 0.0 and not _has_log(folder):
        why = f"the log is missing, so the printed material is unknown until {CHECKPOINT}"
        raise InputError(f"--resume: {folder}: {why}: put it back, or --restart to print all again")
    return machine, Printer(plan, machine, _maker(twin, machine), now=machine.time, saved=found)


def _described(twin: MachineTwin) -> Robot:
    """Return the robot of which the machine is built."""
    return started(twin.robot if twin.upon is None else twin.upon.described, twin.path)


def _has_log(folder: Path) -> bool:
    """Whether the folder holds a part of a log."""
    return next_segment(folder).name != FIRST_SEGMENT or (folder / JOINED_NAME).exists()


def _logged_distance(folder: Path) -> float:
    """The path length, m, that the log of *folder* shows as printed; 0 without one, or before its first flush.

    Raises `InputError` for one that cannot be read.
    """
    if not _has_log(folder) or sum(file.stat().st_size for file in log_files(folder)) < _BEGUN_LOG:
        return 0.0
    try:
        with read_log(folder) as log:
            known = (each.progress for each in log.entries(without={Scan, Truth, Estimate}))
            return max((each.distance for each in known if each is not None), default=0.0)
    except InputError as error:
        raise InputError(f"--resume: the checkpoint is missing, and {error}; --restart prints all again") from None


def _maker(twin: MachineTwin, machine: SimulatedMachine) -> Callable[[Array, Array], Estimator]:
    """Return what makes the print's estimator, from a place and the radii of the drums."""
    robot, choices = started(twin.robot, twin.path), twin.choices
    sigma = choices.place_sigma if choices.place_learn else None
    return lambda place, radii: estimator(
        twin.estimator, robot, machine.settings, place, choices.lasers, radii, place_sigma=sigma
    )


def require_folder(folder: Path, manifest: Mapping[str, Any], option: str) -> None:
    """Raise `InputError` unless *folder* may hold a new print, or, with an *option*, holds the same print already."""
    if option:
        kept = read_manifest(folder)
        if kept is None or kept["command"] != "print":
            raise InputError(f"{option}: {folder} holds no print")
        for each in (kept, manifest):
            if isinstance(each.get("options"), dict):
                each["options"].setdefault("log_every", 1)  # as in earlier versions
        for key in manifest.keys() - {"cablewright"}:
            if kept.get(key) != manifest[key]:
                raise InputError(f"{option}: {folder} holds a print of another {_difference(key, kept, manifest)}")
        return
    if folder.exists() and not folder.is_dir():
        raise InputError(f"--out = {folder}: is no folder")
    if folder.is_dir() and any(each.name != LOCK and not is_unfinished(each) for each in folder.iterdir()):
        raise InputError(f"--out = {folder}: is not empty; --resume the run in it, or give another folder")


def make_folder(folder: Path) -> None:
    """Create the folder of a new print, if it does not exist."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as reason:
        raise cannot_write(folder, reason) from None


def clear_folder(folder: Path) -> None:
    """Remove checkpoint and log of an earlier print, so that they cannot be mistaken for those of the new one."""
    try:
        (folder / CHECKPOINT).unlink(missing_ok=True)  # first: a log without it is rejected by --resume
        for file in log_files(folder) if _has_log(folder) else ():
            file.unlink()
    except OSError as reason:
        raise cannot_write(folder, reason) from None


def _difference(key: str, kept: Mapping[str, Any], requested: Mapping[str, Any]) -> str:
    """Describe the first difference in *key* of two manifests, or of two tables in them."""
    old, new = kept.get(key), requested.get(key)
    if isinstance(old, dict) and isinstance(new, dict):
        other = [k for k in old.keys() | new.keys() if old.get(k) != new.get(k)]
        return _difference(min(other, key=lambda k: (isinstance(old.get(k), dict), k)), old, new)  # options first
    return f"{key}: {str(old)[:60]}, requested: {str(new)[:60]}"
