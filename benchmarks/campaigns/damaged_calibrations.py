"""Damaged data files and plans for `cablewright calibrate`: every one gets an answer or one line, never anything else.

    python -m benchmarks.campaigns.damaged_calibrations 20000 0    # so many files, from this seed on

Each case takes a good data file and plan, damages cells, columns, rows, headers, keys or bytes, and runs the command
in a process that goes on to the next one. What is no answer: an exception, a warning of any library, an exit code that
the command does not have, "cannot be computed with", an error of more than one line, or five minutes of processor
time. Each is printed with its seed; `python -m benchmarks.campaigns.damaged_calibrations 1 SEED` does one again and
shows the files.
"""

from __future__ import annotations

import io
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from cablewright.apps.cli.main import NOT_COMPUTED, run

Rows = list[list[str]]

CODES: Final = {0, 1, 2}  # an answer, a no, a file that cannot be used
SLOW: Final = 300.0  # s, of the processor
CHUNK: Final = 50  # cases of a task
SENSORS: Final = (
    ("--tension-noise", "5"), ("--pose-noise", "1e-3"), ("--swivel-noise", "1e-3"), (),
    ("--tilt-noise", "1e-3", "--yaw-noise", "1e-2"),
)  # fmt: skip
ROBOTS: Final = (
    ("wang2021", ("rigid",)), ("merlet2023", ("rigid", "elastic")), ("paty2021", ("rigid", "elastic", "catenary")),
    ("cogiro", ("rigid", "elastic")),
)  # fmt: skip
CELLS: Final = (
    "", " ", "nan", "inf", "-inf", "0", "-1", "1e308", "-1e308", "1e-320", "1e9", "abc", "1,5", "1.5.2", "0x10", "٣",
    "1_000", "true", '"', "'", "\x00", "9" * 400, "1e", "--3", "3 m", "NaN", "None", "=1+1",
)  # fmt: skip
NAMES: Final = (
    "", "x", "y", "z", "dl_1", "dl_2", "dl_9", "f_1", "f_7", "swivel_1", "rx", "tilt_x", "sigma_x", "sigma_rz", "note",
    "dl_0", "dl_01", "DL_1", "x [mm]", "dl_1 (counts)", "\ufeffdl_1", "#", "dl_1;dl_2", "plane", "home",
    "dl_1 (counts/4096)", "dl_2 (turns)", "dl_1 [deg]", "yaw",
)  # fmt: skip
VALUES: Final = (
    "0", "-1", "1e308", "nan", "inf", '""', '"abc"', "[]", "[[]]", "{}", "true", "[1, 2]", '"1 mm"', '"-3 kN"',
    '"1 mm/s"', "1979-05-27",
    '["exit_point"]', '["nothing"]', '["exit_point", "exit_point"]', "[0.0, 0.0, 0.0]", "9" * 400,
    '["exit_point", "length_offset", "length_scale", "drum_radius", "sheave_radius", "platform_point", "modulus"]',
    '["build_up"]', '"absolute"', '"relative"', "[1, 2, 3, 99999999999999999999]",
)  # fmt: skip
KEYS: Final = {
    "lengths": ('"absolute"', '"relative"'),
    "shared": ('["modulus"]', '["length_scale"]', '["exit_point"]', '["modulus", "modulus"]'),
    "datum": ("[]", '["south-west"]', '["south-west", "south-east.y"]', '["north-east.z"]'),
    "level": ('"0.1 deg"', "0.001", "0", "1e300"),
    "sigma.encoder": ("1e-4", '"0.1 mm"', '"1 m"', "1e-12", "1e300"),
    "sigma.tension": ('"5 N"', "5", "1e-9", "1e300"),
    "sigma.swivel": ("0.001", "10"),
    "sigma.tilt": ("0.001", "1e-300"),
    "sigma.yaw": ("0.01", "1e300"),
    "priors": ("[]", "1"),
}
"""Keys of a plan, and values that they may have."""

TABLES: Final = (
    '[[groups]]\nname = "{u}"\nlines = ["{a}", "{b}"]\n',
    '[[priors]]\nname = "{u}"\nlines = ["{a}"]\ndeviation = {v}\n',
    '[[bounds]]\nname = "{u}"\nmin = {v}\nmax = {w}\n',
    '[[distances]]\nbetween = ["{a}", "{b}"]\nvalue = {v}\n',
    '[[points]]\nline = "{a}"\nat = [{v}, {w}, 1.0]\n',
    "[[planes]]\nposes = [1, 2, {n}]\npoint = [0.0, 0.0, {v}]\nnormal = [0.0, 0.0, {w}]\n",
    "[[ranges]]\npoint = [0.0, {v}, 0.0]\nposes = [1, {n}]\nvalues = [{w}, 2.0]\n",
)
UNKNOWNS: Final = (
    "exit_point", "length_offset", "exit_point", "length_offset", "length_scale", "drum_radius", "build_up", "modulus",
    "sheave_radius", "platform_point",
    "tension_offset", "tension_scale", "swivel_offset", "tilt_offset", "yaw_offset",
)  # fmt: skip
ODD: Final = ("exit_point.z", "exit_point.w", "mass", "", "EXIT_POINT")
NUMBERS: Final = (*("0.01", "0.02", "0.5", "1.0", "2.0") * 4, "0", "-1", "1e-9", "1e9", '"1 mm"')


@dataclass(frozen=True)
class Base:
    """A good data file of a robot."""

    robot: str
    lines: tuple[str, ...]
    cable: str
    data: str


@dataclass(frozen=True)
class Outcome:
    """What came of a case: its exit code, or what it did instead of an answer."""

    seed: int
    code: int
    seconds: float
    fault: str = ""


def bases(folder: Path) -> list[Base]:
    """Write and read the good files."""
    from cablewright.robot import load

    found = []
    for robot, cables in ROBOTS:
        for cable in cables:
            for number, sensor in enumerate(SENSORS):
                file = folder / f"{robot}-{cable}-{number}.csv"
                made = ["--poses", "30", "--noise", "1e-4", "--seed", str(number), "--cable", cable, *sensor]
                with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
                    code = run(["simulate-calibration", robot, *made, "--out", str(file)])
                if code == 0:
                    lines = tuple(line.name for line in load(robot).lines)
                    found.append(Base(robot, lines, cable, file.read_text(encoding="utf-8")))
    return found


def damaged(data: str, rng: np.random.Generator) -> str:
    """A data file with one thing wrong, or unusual."""
    notes = [line for line in data.splitlines() if line.startswith("#")]
    rows = [line.split(",") for line in data.splitlines() if not line.startswith("#")]
    if len(rows) < 2:
        return _bytes(data, rng)
    width = len(rows[0])
    rows = [(row + [""] * width)[:width] for row in rows]
    CHANGES[rng.integers(len(CHANGES))](rows, rng)
    return _bytes("\n".join([*notes, *(",".join(row) for row in rows)]) + "\n", rng)


def _cell(rows: Rows, rng: np.random.Generator) -> None:
    other = rows[rng.integers(1, len(rows))][rng.integers(len(rows[0]))]
    rows[rng.integers(1, len(rows))][rng.integers(len(rows[0]))] = str(rng.choice([*CELLS, *[other] * len(CELLS)]))


def _scaled(rows: Rows, rng: np.random.Generator) -> None:
    at, factor = rng.integers(len(rows[0])), float(10.0 ** rng.integers(-6, 7) * rng.choice([-1.0, 1.0]))
    for row in rows[1:]:
        row[at] = _changed(row[at], lambda value: value * factor)


def _noisy(rows: Rows, rng: np.random.Generator) -> None:
    at, size = rng.integers(len(rows[0])), 10.0 ** rng.uniform(-4, 2)
    for row in rows[1:]:
        more = float(rng.normal() * size * rng.integers(2))
        row[at] = _changed(row[at], lambda value, more=more: value + more)


def _constant(rows: Rows, rng: np.random.Generator) -> None:
    at, value = rng.integers(len(rows[0])), rows[1][rng.integers(len(rows[0]))]
    for row in rows[1:]:
        row[at] = value


def _blank(rows: Rows, rng: np.random.Generator) -> None:
    at, share = rng.integers(len(rows[0])), rng.random()
    for row in rows[1:]:
        row[at] = "" if rng.random() < share else row[at]


def _repeated(rows: Rows, rng: np.random.Generator) -> None:
    different = min(len(rows), 1 + int(rng.integers(1, 8)))
    rows[1:] = [list(rows[int(k)]) for k in rng.integers(1, different, len(rows) - 1)]


def _header(rows: Rows, rng: np.random.Generator) -> None:
    rows[0][rng.integers(len(rows[0]))] = str(rng.choice(NAMES))


def _columns(rows: Rows, rng: np.random.Generator) -> None:
    order = rng.permutation(len(rows[0]))[: rng.integers(1, len(rows[0]) + 1)]
    rows[:] = [[row[k] for k in order] for row in rows]


def _swapped(rows: Rows, rng: np.random.Generator) -> None:
    a, b = rng.integers(len(rows[0]), size=2)
    for row in rows[1:]:
        row[a], row[b] = row[b], row[a]


def _added(rows: Rows, rng: np.random.Generator) -> None:
    rows[0].append(str(rng.choice(NAMES)))
    for row in rows[1:]:
        row.append(str(rng.choice([*CELLS, "0.001", "1.0"])))


def _fewer(rows: Rows, rng: np.random.Generator) -> None:
    del rows[rng.integers(2, len(rows) + 1) :]


def _ragged(rows: Rows, rng: np.random.Generator) -> None:
    row = rows[rng.integers(len(rows))]
    row.extend(["1.0"] * int(rng.integers(3)))
    if rng.random() < 0.5:
        row.pop()


CHANGES: Final = (
    _cell, _cell, _scaled, _noisy, _constant, _blank, _repeated, _header, _columns, _swapped, _added, _fewer, _ragged,
)  # fmt: skip


def plan(base: Base, rng: np.random.Generator) -> str:
    """A plan with a few keys and tables, most of them with something wrong."""
    parts = [f"schema = {1 if rng.random() < 0.95 else 2}"] if rng.random() < 0.95 else []
    lines = (*base.lines, *base.lines, *base.lines, "nobody", "")
    if rng.random() < 0.5:
        parts.append(f"unknowns = {_list(rng, UNKNOWNS)}")
    keys = rng.choice(list(KEYS), size=rng.integers(3), replace=False).tolist()
    parts += [f"{key} = {rng.choice(VALUES if rng.random() < 0.1 else KEYS[key])}" for key in keys]
    for _ in range(rng.integers(3)):
        a, b = rng.choice(lines), rng.choice(lines)
        v, w = (str(rng.choice(VALUES if rng.random() < 0.05 else NUMBERS)) for _ in range(2))
        name = rng.choice(ODD if rng.random() < 0.1 else UNKNOWNS)
        parts.append(str(rng.choice(TABLES)).format(a=a, b=b, v=v, w=w, n=rng.integers(-1, 20), u=name))
    return _bytes("\n".join(parts) + "\n", rng)


def case(base: Base, rng: np.random.Generator, folder: Path) -> list[str]:
    """Write the files of a case; return the command."""
    data = folder / "d.csv"
    text = base.data
    for _ in range(rng.integers(0, 3)):
        text = damaged(text, rng)
    data.write_text(text, encoding="utf-8", errors="surrogateescape")
    command = ["calibrate", base.robot, str(data), "--cable", base.cable, "--json"]
    if rng.random() < 0.6:
        file = folder / "p.toml"
        file.write_text(plan(base, rng), encoding="utf-8", errors="surrogateescape")
        command += ["--plan", str(file)]
    if rng.random() < 0.2:
        command += ["--datum", str(rng.choice(["", "x", base.lines[0], f"{base.lines[0]},{base.lines[-1]}.x", ",,"]))]
    if rng.random() < 0.2:
        command += ["--need", str(rng.choice(["2 mm", "20 mm", "0.1", "1 m", "5 mm", "nan", "1e300"]))]
    if rng.random() < 0.2:
        command += ["--rough", str(rng.choice(["0.1", "0.02", "0.05", "1.0", "0.3", "1e-12", "nan", "1e300"]))]
    return command


def outcome(base: Base, seed: int, folder: Path) -> Outcome:
    """Run one case."""
    command = case(base, np.random.default_rng(seed), folder)
    said, began = io.StringIO(), time.process_time()
    with warnings.catch_warnings(record=True) as told, redirect_stdout(io.StringIO()), redirect_stderr(said):
        warnings.simplefilter("always")
        try:
            code = run(command)
        except Exception:  # noqa: BLE001  # whatever it is, it is a finding
            return Outcome(seed, -1, time.process_time() - began, traceback.format_exc())
    seconds = time.process_time() - began
    lines = [line for line in said.getvalue().splitlines() if line.strip()]
    faults = [f"warning: {each.category.__name__}: {each.message} ({each.filename}:{each.lineno})" for each in told]
    faults = list(dict.fromkeys(faults))
    faults += [f"code {code}"] if code not in CODES else []
    faults += [line for line in lines if NOT_COMPUTED in line or "Traceback" in line]
    faults += [f"{len(lines)} lines: {lines[:3]}"] if code == 2 and len(lines) != 1 else []
    faults += [f"{seconds:.0f} s"] if seconds > SLOW else []
    return Outcome(seed, code, seconds, "; ".join(faults))


def chunk(known: list[Base], first: int, count: int) -> list[Outcome]:
    """Run cases of some seeds."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        return [outcome(known[seed % len(known)], seed, folder) for seed in range(first, first + count)]


def show(seed: int) -> None:
    """Run one case, with its files on the terminal."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        known = bases(folder)
        print(" ".join(case(known[seed % len(known)], np.random.default_rng(seed), folder)))
        for file in (folder / "d.csv", folder / "p.toml"):
            print(file.read_text(encoding="utf-8", errors="replace") if file.exists() else f"no {file.name}")
        print(outcome(known[seed % len(known)], seed, folder))


def main(count: int, first: int) -> None:
    """Run all, and print what was no answer."""
    began, found = time.monotonic(), []
    with tempfile.TemporaryDirectory() as name:
        known = bases(Path(name))
    with ProcessPoolExecutor() as pool:
        tasks = [
            pool.submit(chunk, known, at, min(CHUNK, first + count - at)) for at in range(first, first + count, CHUNK)
        ]
        for task in tasks:
            for each in task.result():
                found.append(each)
                if each.fault:
                    print(f"seed {each.seed}: {each.fault}", flush=True)
    codes = dict(sorted(Counter(each.code for each in found).items()))
    seconds = np.array([each.seconds for each in found])
    faults = sum(bool(each.fault) for each in found)
    print(f"{len(found)} cases in {time.monotonic() - began:.0f} s: exit codes {codes}, {faults} without an answer")
    longest = found[seconds.argmax()]
    print(f"time of one: mean {seconds.mean():.3f} s, the longest {longest.seconds:.1f} s (seed {longest.seed})")


def _list(rng: np.random.Generator, names: tuple[str, ...]) -> str:
    chosen = rng.choice([*names, *ODD[: rng.integers(len(ODD)) * (rng.random() < 0.1)]], size=rng.integers(0, 6))
    chosen = chosen if rng.random() < 0.2 else np.unique(chosen)
    return "[" + ", ".join(f'"{name}"' for name in chosen) + "]"


def _changed(text: str, change: Callable[[float], float]) -> str:
    try:
        return repr(change(float(text)))
    except ValueError:
        return text


def _bytes(text: str, rng: np.random.Generator) -> str:
    """The text, now and then cut, with another byte, or with other ends of lines."""
    if not text:
        return text
    kind = rng.integers(30)
    if kind == 0:
        return text[: rng.integers(len(text))]
    if kind == 1:
        at = int(rng.integers(len(text)))
        return text[:at] + chr(int(rng.integers(1, 256))) + text[at + 1 :]
    if kind == 2:
        return text.replace("\n", "\r\n")
    return text


if __name__ == "__main__":
    if int(sys.argv[1]) == 1:
        show(int(sys.argv[2]))
    else:
        main(int(sys.argv[1]), int(sys.argv[2]))
