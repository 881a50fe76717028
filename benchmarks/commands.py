"""Whole commands and files: G-code, check of the house, start of the command line."""

from __future__ import annotations

import json
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from benchmarks.processes import ROOT, alone
from benchmarks.timing import Row, best
from cablewright.analyses.motion.path_swing import PathSwing, SwingExtremes
from cablewright.apps.cli.main import COMMANDS
from cablewright.printing.gcode import parse
from cablewright.robot import load
from cablewright.studies.checks.check import check

EXAMPLES = ROOT / "examples"
CABLEWRIGHT = ("-m", "cablewright")


@dataclass(frozen=True)
class Size:
    """How much is measured."""

    lines: int = 100_000  # of G-code
    moves: int | None = None  # lines of the house's G-code; None: all
    compiled: bool = True  # whether all kernels are compiled again, which takes a minute or two
    starts: int = 5  # of the command line
    commands: int | None = None  # how many commands print their help; None: all
    checks: int = 2


FULL, QUICK = Size(), Size(100, 40, compiled=False, starts=1, commands=3, checks=1)


def rows(size: Size) -> Iterator[Row]:
    """All rows of this file."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        yield gcode_row(place, size.lines)
        yield from help_rows(size.starts, size.commands)
        check = [*CABLEWRIGHT, "check", "house-printer", str(house(place, size.moves)), "--json", "--out"]
        if size.compiled:
            _, first, _ = alone([*check, str(place / "first")], {"CABLEWRIGHT_CACHE_DIR": str(place / "cache")})
            yield Row("check of the house, first run ever, compile included", first, "s", "<= 55", first <= 55)
            alone([*check, str(place / "compile")])
        bare = [*check, str(place / "bare"), "--no-interference", "--no-expected-error"]
        pairs = [(alone([*check, str(place / "run")]), alone(bare)[1]) for _ in range(size.checks)]
        output, seconds, memory = min((whole for whole, _ in pairs), key=lambda run: run[1])
        samples = json.loads(output)["samples"]
        yield Row(f"check of the house, {samples} samples", seconds, "s", "<= 30", seconds <= 30)
        ratio = seconds / min(limits for _, limits in pairs)
        yield Row("  over that of its limits alone", ratio, "x", "<= 1.7", ratio <= 1.7)
        yield Row("  its largest memory", memory / 1e9, "GB", "<= 0.5", memory <= 0.5e9)
        yield motion_row(house(place, size.moves))


def motion_row(job: Path) -> Row:
    """Time of the limits along a job over that without the motion of the platform, in this process."""
    spent, take = [0.0], PathSwing.take

    def timed(*given: Any) -> SwingExtremes:
        begin = time.perf_counter()
        found = take(*given)
        spent[0] += time.perf_counter() - begin
        return found

    def limits() -> None:
        spent[0] = 0.0
        check(load("house-printer"), job, skip=("interference", "expected-error"))

    with patch.object(PathSwing, "take", timed):
        whole = best(limits, 1)
    ratio = whole / (whole - spent[0])
    return Row("  its limits, over that without motion of the platform", ratio, "x", "<= 1.5", ratio <= 1.5)


def help_rows(starts: int, most: int | None) -> Iterator[Row]:
    """Time until the help stands there: of the program, and of the slowest of *most* commands."""

    def seconds(*arguments: str) -> float:
        return min(alone([*CABLEWRIGHT, *arguments, "--help"])[1] for _ in range(starts))

    whole = seconds()
    yield Row("cablewright --help", whole, "s", "<= 0.3", whole <= 0.3)
    names = [name for commands in COMMANDS.values() for name in commands]
    slowest = max((seconds(name), name) for name in names[:most])
    yield Row(f"  the slowest of a command's: {slowest[1]} --help", slowest[0], "s", "<= 0.5", slowest[0] <= 0.5)


def house(folder: Path, lines: int | None) -> Path:
    """The house's job in *folder*, with the first *lines* of its G-code, or all."""
    moves = (EXAMPLES / "house.gcode").read_text().splitlines(keepends=True)
    (folder / "house.gcode").write_text("".join(moves[:lines]))
    job = folder / "house.toml"
    job.write_text((EXAMPLES / "house.toml").read_text())
    return job


def gcode_row(folder: Path, count: int) -> Row:
    """Plain G1 lines with X, Y and E, as slicers write them."""
    rng = np.random.default_rng(3)
    moves = rng.uniform(-200, 200, (count, 2))
    file = folder / "plain.gcode"
    lines = [f"G1 X{x:.3f} Y{y:.3f} E{0.1 * i:.5f}" for i, (x, y) in enumerate(moves)]
    file.write_text("\n".join(["G21", "G90", "M82", "G1 F1800", *lines]) + "\n")
    return Row(f"G-code parser, {count} lines", best(lambda: parse(file), 3), "s")
