"""Disturb commands while they run, run each again, and judge both: nothing corrupt, nothing laid twice, no traceback.

    python tools/kill_campaigns.py                             # 72 campaigns: 6 tasks, 6 disasters, 2 seeds each
    python tools/kill_campaigns.py --only print --seed 7       # those of one command, other times
    python tools/kill_campaigns.py --only print-body --disaster kill --campaigns 20

A campaign starts a command as its user has it, has a disaster happen to it at a random time of its run or while it
writes, and judges its exit code, its messages and the files that it left. Then the command is run again, undisturbed
(``print`` resumes): its answer and files must be those of a run that nothing happened to; of a print, nothing may be
laid twice or left out. Exit code 1 if a campaign failed. For POSIX systems.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np

from cablewright.control.path_follower import TimedPath
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import MAX_MESSAGE
from cablewright.foundation.saved_state import read_snapshots
from cablewright.foundation.signals import Scan
from cablewright.machine.log.log import read_log
from cablewright.models.path_offset import nearest
from cablewright.printing.job import load_job
from cablewright.running.signing_key import DIRECTORY

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = "from pathlib import Path; from cablewright.apps.cli.main import main; Path({!r}).touch(); main()"
YES, NO, BAD_INPUT, ENVIRONMENT, INTERRUPTED = 0, 1, 2, 3, 130
KILLED = -9
LONGEST = 0.03  # m of path that may be laid twice or not at all
PATIENCE = 120.0  # s until a program that should end is taken for hung
MAX_PATH_ERROR = 0.015  # m, of a print that nothing is wrong with
STEPS = "run/steps.png"  # durations of the steps: a print that was at its end before has none to show
BOTH = 0.15  # of the run: the share in which two programs start nearly at the same time

JOB = """schema = 1
name = "a ring"
origin = [0.3, -0.5, 0.0]
[helix]
radius = 0.3
layers = 1
layer_height = "1 mm"
first_height = "1 m"
[motion]
print_speed = "3 cm/s"
travel_speed = "3 cm/s"
acceleration = "20 mm/s^2"
"""


@dataclass(frozen=True)
class Task:
    """A command whose results are in ``out/``. ``read``: reads a file that it may leave unfinished, to go on from."""

    name: str
    arguments: tuple[str, ...]
    read: Callable[[Path], object] | None = None

    @property
    def command(self) -> str:
        """The command's own name: of prints of several machines, the same."""
        return self.name.partition("-")[0]

    @property
    def prints(self) -> bool:
        """Whether it is a print, which can be resumed."""
        return self.command == "print"


TASKS = {
    each.name: each
    for each in (
        Task("print", ("merlet2023", "ring.toml", "--plant", "quasi-static", "--period", "0.2", "--out", "out/run")),
        Task("print-body", ("cogiro", "ring.toml", "--plant", "quasi-static", "--period", "0.2", "--out", "out/run")),
        Task("check", ("merlet2023", "ring.toml", "--out", "out/run")),
        Task(
            "trade",
            ("jung2020", "--vary", "exit-distance=0.05:0.15:20", "--vary", "width-top-x=0.04,0.1",
             "--criterion", "closed-form", "--count", "nodes", "--grid", "31", "--boundary-grid", "13",
             "--out", "out/sweep.jsonl"),
            Path.read_bytes,
        ),
        Task(
            "equilibria",
            ("merlet2023", "--lengths", "10.1187,9.3676,10.9961,11.3476", "--exhaustive", "--out", "out/search.state"),
            read_snapshots,
        ),
        Task("calibrate", ("wang2021", "calibration.csv", "--accept", "--out", "out/robot.toml")),
    )
}  # fmt: skip
SIGNALS = {"kill": signal.SIGKILL, "terminate": signal.SIGTERM, "interrupt": signal.SIGINT}
DISASTERS = (*SIGNALS, "full-disk", "deleted", "two-at-once")


@dataclass(frozen=True)
class Campaign:
    """One disaster of one command."""

    command: str
    disaster: str
    seed: int


@dataclass(frozen=True)
class Ended:
    """What a program answered, and in which time, s."""

    code: int
    out: bytes
    err: str
    seconds: float

    @property
    def last(self) -> str:
        """The last line on stderr."""
        return self.err.strip().rpartition("\n")[2]


@dataclass(frozen=True)
class Reference:
    """A run that nothing happened to, and its files by their paths."""

    ended: Ended
    files: Mapping[str, bytes]


@dataclass(frozen=True)
class Moment:
    """When a disaster happens: so many seconds after the start, or after so many files have appeared."""

    seconds: float
    files: int = 0

    def __str__(self) -> str:
        return f"{self.seconds:.2f} s" + (f" after file {self.files}" if self.files else "")


@dataclass
class Outcome:
    """What happened in a campaign, in words, and what was wrong with it. ``second``: the second of two's options."""

    when: str = ""
    second: tuple[str, ...] = ()
    events: list[str] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)

    def expect(self, holds: bool, fault: str) -> None:
        """Note a *fault* unless something *holds*."""
        if not holds:
            self.faults.append(fault)


def start(arguments: Sequence[object], folder: Path, most: int | None = None) -> subprocess.Popen[bytes]:
    """Start the command with these *arguments* in *folder*, able to write files of *most* bytes.

    Returns once its own code runs: Python's own start can be interrupted, but not by us.
    """

    def prepare() -> None:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # which a job in the background ignores
        if most is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)

    with tempfile.TemporaryDirectory() as name:
        begun = Path(name) / "begun"
        command = [sys.executable, "-c", PROGRAM.format(str(begun)), *map(str, arguments)]
        process = subprocess.Popen(
            command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, preexec_fn=prepare
        )
        while not begun.exists() and process.poll() is None:
            time.sleep(0.002)
    return process


def end(process: subprocess.Popen[bytes], begin: float) -> Ended:
    """Wait for the end of a program; one that hangs is killed, with no exit code that is expected of any."""
    try:
        out, err = process.communicate(timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
        out, err = process.communicate()
        return Ended(-1000, out, f"{err.decode()}\nhangs", PATIENCE)
    return Ended(process.returncode, out, err.decode(), time.monotonic() - begin)


def run_to_end(task: Task, folder: Path, *options: str) -> Ended:
    """Run a command undisturbed."""
    begin = time.monotonic()
    return end(start(_words(task, *options), folder), begin)


def _words(task: Task, *options: str) -> tuple[str, ...]:
    return (task.command, *task.arguments, "--json", *options)


def prepared(folder: Path) -> Path:
    """Write the inputs of all commands to *folder*, with an empty folder for their results; return it."""
    (folder / "out").mkdir(parents=True)
    (folder / "ring.toml").write_text(JOB)
    shutil.copy(ROOT / "examples" / "calibration.csv", folder)
    return folder


@cache
def reference(name: str) -> Reference:
    """The answer and the files of a command that nothing happens to, after its kernels are compiled."""
    with tempfile.TemporaryDirectory() as place:
        folder = prepared(Path(place) / "work")
        ended = run_to_end(TASKS[name], folder)
        files = _files(folder / "out")
    assert ended.code in (YES, NO), f"{name} does not run: {ended.err}"
    return reference.__wrapped__(name) if "compiling kernels" in ended.err else Reference(ended, files)


def _files(folder: Path) -> dict[str, bytes]:
    """Contents of all files below *folder* by their paths in it; those that vanish meanwhile are left out."""
    found = {}
    for path in _names(folder):
        with suppress(OSError):
            if (folder / path).is_file():
                found[path] = (folder / path).read_bytes()
    return found


def _names(folder: Path) -> list[str]:
    """Paths of all files and folders below *folder*, in it."""
    return [
        str((Path(place) / name).relative_to(folder))
        for place, folders, files in os.walk(folder)
        for name in (*folders, *files)
    ]


def _rubbish(folder: Path) -> list[str]:
    """What no run should leave: temporary files and folders."""
    return [name for name in _names(folder) if Path(name).name.startswith(".")]


def moment_of(campaign: Campaign, known: Reference, random_: random.Random) -> Moment:
    """Some time of the run, or soon after one of the result's files appears."""
    if campaign.disaster == "two-at-once" and random_.random() < 0.5:
        return Moment(random_.uniform(0.0, BOTH) * known.ended.seconds)
    if random_.random() < 0.5:
        return Moment(random_.uniform(0.0, 0.05), random_.randint(1, len(known.files)))
    return Moment(random_.uniform(0.0, 1.0) * known.ended.seconds)


def await_moment(process: subprocess.Popen[bytes], out: Path, moment: Moment) -> None:
    """Wait until the *moment*, or the end of the process."""
    begin, seen = time.monotonic(), set[str]()
    while moment.files and process.poll() is None and time.monotonic() - begin < PATIENCE:
        seen.update(_names(out))
        if len(seen) >= moment.files:
            break
        time.sleep(0.002)
    with suppress(subprocess.TimeoutExpired):
        process.wait(moment.seconds)


def disturbed(campaign: Campaign, folder: Path, random_: random.Random, outcome: Outcome) -> list[Ended]:
    """Run the command with its disaster; what it answered, and the second program of two."""
    task, known, out = TASKS[campaign.command], reference(campaign.command), folder / "out"
    begin = time.monotonic()
    if campaign.disaster == "full-disk":
        most = random_.randrange(max(map(len, known.files.values())))
        outcome.when = f"over {most} B"
        return [end(start(_words(task), folder, most), begin)]
    moment = moment_of(campaign, known, random_)
    process, others = start(_words(task), folder), list[subprocess.Popen[bytes]]()
    await_moment(process, out, moment)
    if campaign.disaster in SIGNALS:
        process.send_signal(SIGNALS[campaign.disaster])
    elif campaign.disaster == "deleted":
        delete(out)
    else:
        outcome.second = ("--resume",) if task.prints and random_.random() < 0.5 else ()
        others.append(start(_words(task, *outcome.second), folder))
    outcome.when = " ".join([str(moment), *outcome.second])
    return [end(each, begin) for each in (process, *others)]


def delete(folder: Path) -> None:
    """Remove a folder although a program writes to it."""
    for _ in range(100):
        shutil.rmtree(folder, ignore_errors=True)
        if not folder.exists():
            return


def judge_words(ended: Ended, outcome: Outcome) -> None:
    """What a program may say: no traceback, no long message, and why its exit code is not 0."""
    outcome.expect("Traceback" not in ended.err, f"traceback: {ended.err[-3000:]}")
    long = [line for line in ended.err.splitlines() if len(line) > MAX_MESSAGE + len("cablewright: ")]
    outcome.expect(not long, f"a message of {max(map(len, long), default=0)} characters")
    if ended.code in (NO, BAD_INPUT, ENVIRONMENT, INTERRUPTED):
        outcome.expect(ended.last.startswith("cablewright: "), f"no reason in {ended.err[-500:]!r}")


def judge_end(campaign: Campaign, ended: Ended, outcome: Outcome) -> None:
    """The exit code and the words of a program that the disaster happened to, or that ended before."""
    judge_words(ended, outcome)
    usual = reference(campaign.command).ended.code
    codes = {"kill": KILLED, "terminate": INTERRUPTED, "interrupt": INTERRUPTED}
    allowed = (usual, codes.get(campaign.disaster, ENVIRONMENT))
    outcome.events.append("unharmed" if ended.code == usual else f"exit {ended.code}")
    outcome.expect(ended.code in allowed, f"exit code {ended.code}, {allowed} expected: {ended.err[-500:]!r}")


def judge_two(campaign: Campaign, pair: Sequence[Ended], outcome: Outcome) -> None:
    """Two programs on one output: at least one succeeds, and the other does or says that it cannot, in one line."""
    usual = reference(campaign.command).ended.code
    for ended in pair:
        judge_words(ended, outcome)
        outcome.events.append("unharmed" if ended.code == usual else f"rejected: {ended.last}")
        outcome.expect(ended.code in (usual, BAD_INPUT, ENVIRONMENT), f"exit code {ended.code}: {ended.err[-500:]!r}")
    outcome.expect(any(ended.code == usual for ended in pair), "neither of two came to its end")
    if TASKS[campaign.command].prints and not outcome.second:
        outcome.expect(any(ended.code != usual for ended in pair), "two programs printed to one folder")


def judge_files(task: Task, out: Path, outcome: Outcome, *, killed: bool) -> None:
    """Files are whole or absent, or a state to go on from; nothing temporary is left, unless by a *killed* program."""
    known = reference(task.name).files
    found = {name: data for name, data in _files(out).items() if not any(p[0] == "." for p in Path(name).parts)}
    if not killed:
        outcome.expect(not _rubbish(out), f"left behind: {_rubbish(out)}")
    if task.prints:
        return  # a folder to go on from
    for name, data in found.items():
        if task.read is not None:
            try:
                task.read(out / name)
            except (OSError, ValueError) as error:
                outcome.faults.append(f"{name} cannot be read: {error}")
        else:
            outcome.expect(
                _undated(data) == _undated(known.get(name, b"")), f"{name} is not that of an undisturbed run"
            )
    if task.name == "check":
        outcome.expect(not found or found.keys() == known.keys(), f"only {sorted(found)} of the run folder")


def _undated(data: bytes) -> bytes:
    """Content of a file except the date of the record of a calibration."""
    return re.sub(rb"(?m)^date = .*$", b"", data)


def judge_again(task: Task, folder: Path, outcome: Outcome, *, killed: bool) -> None:
    """Run the command again; its answer and files are those of a run that nothing happened to."""
    known, again = reference(task.name), run_to_end(task, folder)
    judge_words(again, outcome)
    outcome.events.append(f"again: {again.code}")
    outcome.expect(again.code == known.ended.code, f"the next run: exit code {again.code}: {again.err[-500:]!r}")
    outcome.expect(again.out == known.ended.out, "the next run answers differently")
    judge_files(task, folder / "out", outcome, killed=killed)
    missing = known.files.keys() - _files(folder / "out").keys()
    outcome.expect(not missing, f"the next run wrote no {sorted(missing)}")


def judge_print(task: Task, folder: Path, outcome: Outcome) -> None:
    """Resume the print, or do what the rejection names; it comes to its end, and nothing is laid twice or left out."""
    again = run_to_end(task, folder, "--resume")
    judge_words(again, outcome)
    if again.code == BAD_INPUT:
        outcome.events.append(f"--resume: {again.last}")
        outcome.expect(again.err.count("\n") == 1, f"a rejection of several lines: {again.err!r}")
        again = run_to_end(task, folder, *(["--restart"] if "--restart" in again.last else []))
        judge_words(again, outcome)
    if again.code != YES:
        outcome.faults.append(f"the print cannot go on: exit code {again.code}: {again.err[-500:]!r}")
        return
    values = json.loads(again.out)
    outcome.expect(values["status"] == "finished", f"the print is {values['status']}")
    outcome.expect(values["max_path_error"] < MAX_PATH_ERROR, f"path error {values['max_path_error']:.3f} m")
    run = folder / "out" / "run"
    gap, back = flaws(laid(run, folder / "ring.toml"))
    outcome.events.append(f"printed, gap {100 * gap:.1f} cm, twice {100 * back:.1f} cm")
    outcome.expect(max(gap, back) <= LONGEST, f"{100 * gap:.1f} cm left out, {100 * back:.1f} cm laid twice")
    missing = reference(task.name).files.keys() - _files(run.parent).keys() - {STEPS}
    outcome.expect(not missing, f"the resumed print wrote no {sorted(missing)}")


def laid(out: Path, job: Path) -> Array:
    """Stretches of path (k, 2), m, along which the valve was open, in the order of time, by the true place."""
    track = TimedPath.of(load_job(job)).track
    stretches: list[tuple[float, float]] = []
    before: float | None = None
    with read_log(out) as log:
        for entry in log.entries(without={Scan}):
            assert entry.truth is not None
            assert entry.command is not None
            assert entry.progress is not None
            here = nearest(track, entry.truth.position, entry.progress.distance, 0.1).distance
            if entry.command.valve > 0.0 and before is not None:
                stretches.append((before, here))
            before = here
        assert log.notes == []
    return np.array(stretches)


def flaws(stretches: Array) -> tuple[float, float]:
    """The longest gap in the laid material, and the longest way back before it continued, m."""
    reached = np.maximum.accumulate(stretches[:, 1])
    gaps = stretches[1:, 0] - reached[:-1]
    return float(gaps.max()), float(-gaps.min())


def held(campaign: Campaign) -> Outcome:
    """Hold a campaign in a folder of its own."""
    task, outcome = TASKS[campaign.command], Outcome()
    random_ = random.Random(f"{campaign.seed} {campaign.command} {campaign.disaster}")
    reference(task.name)
    with tempfile.TemporaryDirectory() as place:
        folder = prepared(Path(place) / "work")
        ended = disturbed(campaign, folder, random_, outcome)
        if campaign.disaster == "two-at-once":
            judge_two(campaign, ended, outcome)
        else:
            judge_end(campaign, ended[0], outcome)
        killed = campaign.disaster == "kill"
        judge_files(task, folder / "out", outcome, killed=killed)
        (folder / "out").mkdir(exist_ok=True)  # as the user would who deleted it
        if task.prints:
            judge_print(task, folder, outcome)
        else:
            judge_again(task, folder, outcome, killed=killed)
    return outcome


def listed(count: int, seed: int, commands: Iterable[str], disasters: Iterable[str]) -> list[Campaign]:
    """Campaigns of all commands and disasters: first those of one seed, then those of the next."""
    pairs = list(product(commands, disasters))
    return [Campaign(*pairs[k % len(pairs)], seed + k // len(pairs)) for k in range(count)]


def run(campaigns: Iterable[Campaign]) -> Iterator[tuple[Campaign, Outcome]]:
    """Run *campaigns*, and report each in a line as it ends; yield them with their outcomes."""
    for each in campaigns:
        outcome = held(each)
        word = "failed" if outcome.faults else "ok"
        head = f"{each.command:<11}{each.disaster:<12} seed {each.seed}  {outcome.when:<32}"
        print(f"{head} {word}: {'; '.join(outcome.events)}", flush=True)
        for fault in outcome.faults:
            print(f"    {fault}", flush=True)
        yield each, outcome


def main() -> int:
    """Hold campaigns; return 1 if one failed."""
    parser = argparse.ArgumentParser(description="Commands that are killed, interrupted, without room or in company.")
    parser.add_argument("--campaigns", type=int, help="number of campaigns; by default two seeds of each")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", action="append", choices=list(TASKS), help="these commands only")
    parser.add_argument("--disaster", action="append", choices=DISASTERS, help="these disasters only")
    given = parser.parse_args()
    commands, disasters = given.only or list(TASKS), given.disaster or DISASTERS
    count = 2 * len(commands) * len(disasters) if given.campaigns is None else given.campaigns
    begin = time.monotonic()
    with tempfile.TemporaryDirectory() as key:
        os.environ.setdefault(DIRECTORY, key)  # the user's own is not touched
        outcomes = [outcome for _, outcome in run(listed(count, given.seed, commands, disasters))]
    failed = sum(bool(outcome.faults) for outcome in outcomes)
    print(f"{len(outcomes)} campaigns in {time.monotonic() - begin:.0f} s, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
