"""Feed mutated files to every reader and to whole commands: no traceback, no hang, no full memory, no long message.

    python tools/fuzz.py --seconds 120            # all formats in turn; what fails is saved below tests/fuzz_cases/
    python tools/fuzz.py --only gcode --inputs 100000 --seed 7

Inputs are mutations of the examples by format, in this process, and determined by the seed. A failure is an exception
other than ours, one that takes over 10 s or 1.5 GB, or a message over 2 kB or with control characters. It is reduced as
long as the same failure stays, and its file is then a test (tests/test_fuzz.py). Exit code 1 if there was one.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import io
import json
import logging
import random
import resource
import runpy
import shutil
import signal
import struct
import sys
import tempfile
import time
import traceback
import warnings
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from pathlib import Path

from cablewright.apps.cli import main as command_line
from cablewright.calibration.measurements import read_measured
from cablewright.calibration.plan import load_plan as load_calibration_plan
from cablewright.calibration.survey.plan import load_plan as load_survey_plan
from cablewright.calibration.survey.shots import read_shots
from cablewright.calibration.tensile.recording import read_test
from cablewright.estimation.lidar.scan_file import read_scan
from cablewright.exchange.formats import read_robot
from cablewright.exchange.length_log import read_lengths
from cablewright.foundation.errors import MAX_MESSAGE, CablewrightError
from cablewright.foundation.saved_state import read_snapshots, write_snapshots
from cablewright.foundation.signals import Command
from cablewright.machine.files import load_machine, machine_text
from cablewright.machine.log.head import LogHead
from cablewright.machine.log.log import read_log, write_log
from cablewright.machine.simulated.settings import load_twin
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.printing.job import load_job
from cablewright.printing.stl import read_stl
from cablewright.robot import library_names, library_text, load, load_bracket, load_uncertainty
from cablewright.running.run_folders import read_manifest

ROOT = Path(__file__).resolve().parent.parent
CASES = ROOT / "tests" / "fuzz_cases"
OTHERS: dict[str, bytes] = runpy.run_path(str(ROOT / "tools" / "fuzz_samples.py"))  # files of other programs
LONGEST = 10.0  # s
MOST = 1.5e9  # bytes over what the program had before
REDUCED = 20.0  # s of reducing a failure

WORDS = (
    b"1e309", b"-1e309", b"nan", b"inf", b"-inf", b"0", b"-0.0", b"1e-320", b"1e200", b"-1", b"9" * 400, b"0x10",
    b"1_0", b"", b"\0", b"\x1b[31m", b"\xff\xfe", b"\xef\xbb\xbf", "é\u2028\U0001f916".encode(), b'"', b"'", b'"""',
    b"[", b"]", b"{", b"}", b"[[", b"=", b",", b";", b"(", b")", b"\n", b"\r\n", b"\r", b"#", b"true", b"null", b"2 m",
    b"50 mn", b"../../etc/passwd", b"%s%n", b"G2", b"X1e30", b"P99999999", b"A" * 5000, b"[" * 200, b"1979-05-27",
    b"..", b"/dev/zero", b"--json", b"--help",
)  # fmt: skip
"""Pieces that readers of text stumble over."""


SCANS = (
    b'{"angles": [0, 0.1, 0.2, 0.3], "ranges": [1.0, 1.1, 1.2, 1.3]}',
    b'[{"angle": 0, "distance": 1000, "quality": 15}, {"angle": 1, "distance": 1010, "quality": 15}]',
)
SOLIDS = (
    b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n",
    bytes(80) + struct.pack("<I", 2) + bytes(100),
)
SPANS = b"""schema = 1
name = "a"
[scene]
gravity = 0
frame_min = [-2, -2, 0]
frame_max = [2, 2, 3]
[platform]
mass = 5
[cable]
axial_stiffness = 1e5
linear_density = 0.01
breaking_load = 1e5
[sheave]
kind = "eyelet"
[line]
tension_limits = [5, 2000]
advantage = 2
cables = 3
[[lines]]
name = "a"
exit_point = [-2, -2, 3]
[[lines]]
name = "b"
exit_point = [2, -2, 3]
advantage = 1
[[lines]]
name = "c"
exit_point = [0, 2, 3]
cables = 1
[[lines]]
name = "d"
exit_point = [0, 0, 0]
"""
GUIDES = b"""schema = 1
name = "g"
[scene]
frame_min = [-2, -2, 0]
frame_max = [2, 2, 3]
[platform]
kind = "rigid"
mass = 8
[cable]
axial_stiffness = 1e5
linear_density = 0.02
breaking_load = 4e3
[sheave]
kind = "swivel"
radius = 0.03
[line]
tension_limits = [5, 400]
[[lines]]
name = "a"
exit_point = [-2, -2, 3]
sheave = { axis = [0, 0.5, 1] }
platform_point = [0.1, 0, 0.1]
platform_sheave = { radius = 0.02, axis = [0, 0, -1] }
[[lines]]
name = "b"
exit_point = [2, -2, 3]
winch_exit = [2.1, -2.05, 0.2]
platform_point = [-0.1, 0, 0.1]
[[lines]]
name = "c"
exit_point = [2, 2, 3]
winch_exit = [2, 2, 0]
guides = [[2.3, 2, 0.1], { centre = [2.1, 2, 0.9], axis = [0.1, -1, 0], radius = "20 mm" }, [2, 2, 1]]
[[lines]]
name = "d"
exit_point = [-2, 2, 3]
sheave = { kind = "pulley", radius = 0.04, axis = [0, 1, 0] }
winch_exit = [-2.3, 2, 0.2]
"""
BOARD = SPANS.replace(b"mass = 5", b"mass = 5\nplane = { normal = [0, 1, 0.2], distance = 0.01 }").replace(
    b"= 0\n", b"= 9\n", 1
)
ROBOTS = (SPANS, GUIDES, BOARD)
ARGUMENTS = (
    b"inverse merlet2023 --at 0,0,1 --json",
    b"inverse jung2020 --at 0.3,0.2,0.4,0.1,0,0 --retraction 1.4",
    b"inverse merlet2023 --at 0,0,1.2 --slack south-west=0.3 --json",
    b"forward merlet2023 --lengths 10,10,10,10 --json",
    b"machines --for merlet2023",
    b"new mine --size 4,4,3 --mass 10 --cable dyneema-2mm --lines 5",
    b"schema job",
    b"robots wang2021",
)


@dataclass(frozen=True)
class Format:
    """A kind of file: valid ones to begin with, and what reads one. ``binary``: without words."""

    name: str
    suffix: str
    seeds: Callable[[], Sequence[bytes]]
    read: Callable[[Path], object]
    binary: bool = False
    finish: Callable[[bytes], bytes] = field(default=lambda data: data)


def _files(*patterns: str) -> Callable[[], Sequence[bytes]]:
    return lambda: [path.read_bytes()[:20_000] for each in patterns for path in sorted((ROOT / "examples").glob(each))]


def _pages(page: str) -> Callable[[], Sequence[bytes]]:
    """The TOML blocks of a page of the documentation."""
    text = (ROOT / "docs" / f"{page}.md").read_text("utf-8")
    return lambda: [block.split("```")[0].encode() for block in text.split("```toml\n")[1:]]


def _log() -> Sequence[bytes]:
    """A short log with every kind of reading."""
    robot, settings = load("merlet2023"), load_twin("merlet2023")
    machine = SimulatedMachine(robot, settings, [0.5, 1.0, 1.2], seed=4)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.mcap"
        simulation = settings.simulation
        head = LogHead(robot, settings.owner, machine.period, simulation=simulation, plant="dynamic", seed=4)
        with write_log(path, head) as log:
            for _ in range(120):
                command = Command(machine.time, machine.truth.radii * 0.0, 0.5)
                log.write(machine.step(command), command, machine.truth, None, None)
        return [path.read_bytes()]


def _machine(path: Path) -> None:
    """Read both parts of a machine file."""
    load_machine(path)
    load_twin(path)


def _state() -> Sequence[bytes]:
    machine = SimulatedMachine(load("merlet2023"), load_twin("merlet2023"), [0.5, 1.0, 1.2], seed=4)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "state"
        write_snapshots(path, {"machine": machine.snapshot()})
        return [path.read_bytes()[:60_000]]


def _checked(data: bytes) -> bytes:
    """A state whose checksum fits, so that what is behind it is read."""
    if len(data) < 16:
        return data
    return data[:12] + struct.pack("<I", zlib.crc32(data[16:])) + data[16:]


def _read_log(path: Path) -> None:
    with read_log(path) as log:
        for _ in log.entries():
            pass


def _resume(path: Path) -> None:
    state = read_snapshots(path)
    if "machine" in state:
        SimulatedMachine.resumed(load("merlet2023"), load_twin("merlet2023"), state["machine"], seed=4)


def _words(path: Path) -> None:
    """Run the command that a file holds, in its folder."""
    words = path.read_bytes().decode("utf-8", "replace").replace("{", "{{").replace("}", "}}").split()
    with contextlib.chdir(path.parent):
        _command(*words)(path)
        shutil.rmtree("mine", ignore_errors=True)


def _command(*arguments: str) -> Callable[[Path], None]:
    """Run a command on the file ``{}``; its exit code and its output are judged too."""

    def run(path: Path) -> None:
        out, err = io.StringIO(), io.StringIO()
        with redirect_stdout(out), redirect_stderr(err):
            code = command_line.run([each.format(path) for each in arguments])
        if code not in (0, 1, 2, 3):
            raise AssertionError(f"exit code {code}")
        last = err.getvalue().splitlines()[-1:] if code else []
        if code and not last:
            raise AssertionError(f"exit code {code} without a reason")
        for line in err.getvalue().splitlines():
            _judge_message(line)
            if command_line.NOT_COMPUTED in line or command_line.NO_ROBOT in line:
                raise AssertionError(line)
        if "--json" in arguments and code in (0, 1):
            json.loads(out.getvalue())

    return run


def _caspr(path: Path) -> None:
    """Read a file of bodies and of cables, one after the other, cut at the line between."""
    bodies, _, cables = path.read_bytes().partition(b"<!-- cut -->")
    files = [path.with_name(f"{name}.xml") for name in ("bodies", "cables")]
    for file, content in zip(files, (bodies, cables), strict=True):
        file.write_bytes(content)
    read_robot(files)


FORMATS = (
    Format("robot", ".toml", lambda: [*ROBOTS, *(library_text(name).encode() for name in library_names())],
           lambda path: load(str(path))),
    Format("bracket", ".toml", lambda: [library_text("house-printer").encode()], load_bracket),
    Format("uncertainty", ".toml", _files("uncertain.toml"), load_uncertainty),
    Format("machine", ".toml", lambda: [machine_text("merlet2023").encode()], _machine),
    Format("job", ".toml", lambda: [*_files("helix.toml", "blind-machines.toml")(), *_pages("jobs")()], load_job),
    Format("calibration-plan", ".toml", _pages("calibration"), load_calibration_plan),
    Format("survey-plan", ".toml", _files("survey.toml"), load_survey_plan),
    Format("gcode", ".gcode", _files("house.gcode"), lambda path: load_job(path).toolpath()),
    Format("survey", ".gsi", _files("survey.gsi"), read_shots),
    Format("survey-csv", ".csv", lambda: [b"point,x,y,z\nX1-1,1,2,3\nX2-1,0,1,2\nNORTH1,1,1,1\n"], read_shots),
    Format("tensile", ".csv", _files("tensile.csv"), read_test),
    Format("calibration", ".csv", _files("calibration.csv"), lambda path: read_measured(path, load("wang2021"))),
    Format("scan", ".csv", _files("scan.csv"), read_scan),
    Format("scan-json", ".json", lambda: SCANS, read_scan),
    Format("stl", ".stl", lambda: SOLIDS, read_stl),
    Format("log", ".mcap", _log, _read_log, binary=True),
    Format("state", ".state", _state, _resume, binary=True, finish=_checked),
    Format("manifest", ".json", lambda: [b'{"schema": 1, "command": "print", "cablewright": "0", "inputs": {}}'],
           lambda path: read_manifest(path.parent)),
    Format("wirex", ".wcrfx", _files("robot.wcrfx"), lambda path: read_robot([path])),
    Format("caspr", ".xml", lambda: [OTHERS["CASPR"], OTHERS["CASPR_PLANAR"]], _caspr),
    Format("maslow", ".yaml", lambda: [OTHERS["MASLOW"], OTHERS["MASLOW_SECTION"]], lambda path: read_robot([path])),
    Format("wallplotter", ".yaml", lambda: [OTHERS["WALL"]], lambda path: read_robot([path])),
    Format("maslow-classic", ".txt", lambda: [OTHERS["CLASSIC"]], lambda path: read_robot([path])),
    Format("polargraph", ".h", lambda: [OTHERS["MARLIN"]], lambda path: read_robot([path])),
    Format("makelangelo", ".gcode", lambda: [OTHERS["M101"], OTHERS["M665"]], lambda path: read_robot([path])),
    Format("klipper", ".cfg", lambda: [OTHERS["KLIPPER"], OTHERS["KLIPPER_FORK"]], lambda path: read_robot([path])),
    Format("reprapfirmware", ".g", lambda: [OTHERS["RRF"], OTHERS["RRF_2019"]], lambda path: read_robot([path])),
    Format("lengths", ".csv", lambda: [OTHERS["LENGTHS"]], lambda path: read_lengths(path, load("hangprinter-v4"))),
    Format("inverse", ".toml", lambda: [*ROBOTS, *(library_text(name).encode() for name in ("merlet2023", "wang2021"))],
           _command("inverse", "{}", "--at", "0,0,1", "--json")),
    Format("walls", ".csv", _files("scan.csv"), _command("walls", "{}", "--json")),
    Format("modulus", ".csv", _files("tensile.csv"),
           _command("modulus", "{}", "--initial-length", "2", "--robot", "paty2021", "--json")),
    Format("creep", ".csv", _files("creep.csv"), _command("creep", "{}", "--initial-length", "2", "--json")),
    Format("arguments", ".txt", lambda: ARGUMENTS, _words),
    Format("survey-command", ".gsi", _files("survey.gsi"), _command("survey", "{}", "--json")),
)  # fmt: skip
"""All formats; the last ones are whole commands."""


class TooSlow(BaseException):
    """The time of an input is over. No `Exception`, so that no handler in between catches it."""


@dataclass(frozen=True)
class Failure:
    """A failure: a word for its kind, which distinguishes it from others, and a sentence."""

    kind: str
    what: str


def mutated(random_: random.Random, seeds: Sequence[bytes], binary: bool) -> bytes:
    """Return one of the *seeds* with one to a few changes."""
    data = bytearray(random_.choice(seeds))
    for _ in range(random_.choice((1, 1, 1, 2, 3, 8))):
        at, end = sorted(random_.randrange(len(data) + 1) for _ in range(2))
        match random_.randrange(8):
            case 0:
                data[at:at] = bytes([random_.randrange(256)])
            case 1 if data:
                data[min(at, len(data) - 1)] ^= 1 << random_.randrange(8)
            case 2:
                del data[at : min(end, at + 200)]
            case 3:
                data[at:at] = data[at : min(end, at + 200)]
            case 4:
                del data[at:]
            case 5 if binary:
                data[at : at + 8] = struct.pack("<q", random_.choice((0, -1, 1, 2**31, 2**62, 10**20 % 2**63)))
            case 5 | 6:
                begin, stop = _number(data, at)
                data[begin:stop] = random_.choice(WORDS)
            case _:
                lines = bytes(data).split(b"\n")
                lines.insert(random_.randrange(len(lines) + 1), lines.pop(random_.randrange(len(lines))))
                lines.insert(random_.randrange(len(lines) + 1), random_.choice(lines))
                data = bytearray(b"\n".join(lines))
    return bytes(data)


def _judge_message(message: str) -> None:
    """Raise `AssertionError` for a message that is too long, or that a terminal would obey."""
    if len(message) > MAX_MESSAGE + len("cablewright: "):
        raise AssertionError(f"a message of {len(message)} characters: {message[:100]!r}")
    if not message.isprintable():
        raise AssertionError(f"control characters in a message: {message[:200]!r}")


def _memory() -> float:
    """The most memory that this program had so far, bytes."""
    return 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def _place(error: BaseException) -> str:
    """Function of ours in which an error was raised."""
    frames = [each for each in traceback.extract_tb(error.__traceback__) if "/cablewright/" in each.filename]
    return f"{Path(frames[-1].filename).stem}.{frames[-1].name}" if frames else "elsewhere"


def _over(_number: int, _frame: object) -> None:
    raise TooSlow


def main() -> int:
    """Fuzz for a while; return 1 if something failed."""
    parser = argparse.ArgumentParser(description="Mutated files for every reader and for whole commands.")
    parser.add_argument("--seconds", type=float, default=120.0, help="time for all formats together")
    parser.add_argument("--inputs", type=int, default=10**9, help="inputs of each format, at most")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", action="append", choices=[form.name for form in FORMATS], help="these formats only")
    parser.add_argument("--keep", type=Path, default=CASES, help="folder for what fails")
    given = parser.parse_args()
    formats = [form for form in FORMATS if given.only is None or form.name in given.only]
    prepare()
    failures = 0
    for failure in run(formats, seed=given.seed, seconds=given.seconds, inputs=given.inputs, cases=given.keep):
        failures += 1
        print(f"  {failure.kind}: {failure.what}", flush=True)
    return 1 if failures else 0


def prepare() -> None:
    """Have alarms and NumPy's warnings raised, and suppress notes of the program."""
    signal.signal(signal.SIGALRM, _over)
    logging.disable(logging.WARNING)
    warnings.simplefilter("error", RuntimeWarning)


def _number(data: bytearray, at: int) -> tuple[int, int]:
    """Where the next word of digits after *at* begins and ends; *at* itself without one."""
    begin = next((k for k in range(at, min(len(data), at + 400)) if 48 <= data[k] <= 57), None)
    if begin is None:
        return at, at
    end = begin
    while end < len(data) and (48 <= data[end] <= 57 or data[end] in b".eE+-"):
        end += 1
    return begin, end


def tried(form: Format, data: bytes, folder: Path) -> Failure | None:
    """Read a file with this content. None, or what is wrong with the answer."""
    path = folder / ("manifest.json" if form.name == "manifest" else f"input{form.suffix}")
    path.write_bytes(data)
    before = _memory()
    signal.setitimer(signal.ITIMER_REAL, LONGEST)
    try:
        form.read(path)
    except CablewrightError as error:
        try:
            _judge_message(str(error))
        except AssertionError as reason:
            return Failure("message", str(reason))
    except TooSlow:
        return Failure("slow", f"over {LONGEST:g} s")
    except Exception as error:  # noqa: BLE001 the purpose of this program
        return Failure(f"{type(error).__name__} {_place(error)}", f"{type(error).__name__}: {str(error)[:300]}")
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
    grown = _memory() - before
    return Failure("memory", f"{grown / 1e9:.1f} GB") if grown > MOST else None


def reduced(form: Format, data: bytes, failure: Failure, folder: Path) -> bytes:
    """Leave out parts of *data* as long as the same failure stays."""
    if failure.kind in ("slow", "memory"):
        return data
    end, size = time.monotonic() + REDUCED, len(data) // 2
    while size and time.monotonic() < end:
        at = 0
        while at < len(data) and time.monotonic() < end:
            less = form.finish(data[:at] + data[at + size :])
            found = tried(form, less, folder)
            if found is not None and found.kind == failure.kind and len(less) < len(data):
                data = less
            else:
                at += size
        size //= 2
    return data


def run(formats: Sequence[Format], *, seed: int, seconds: float, inputs: int, cases: Path | None) -> Iterator[Failure]:
    """Yield each new kind of failure; those are saved, reduced, to *cases*."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for form in formats:
            seeds, random_, known = form.seeds(), random.Random(f"{seed} {form.name}"), set[str]()
            end, count = time.monotonic() + seconds / len(formats), 0
            assert tried(form, form.finish(seeds[0]), folder) is None, f"{form.name}: its own example fails"
            while count < inputs and time.monotonic() < end:
                count += 1
                data = form.finish(mutated(random_, seeds, form.binary))
                failure = tried(form, data, folder)
                if failure is None or failure.kind in known:
                    continue
                known.add(failure.kind)
                if cases is not None:
                    least = reduced(form, data, failure, folder)
                    cases.mkdir(parents=True, exist_ok=True)
                    (cases / f"{form.name}-{hashlib.sha256(least).hexdigest()[:12]}").write_bytes(least)
                yield Failure(f"{form.name}: {failure.kind}", failure.what)
            print(f"{form.name}: {count} inputs, {len(known)} kinds of failure", flush=True)


if __name__ == "__main__":
    sys.exit(main())
