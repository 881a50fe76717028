"""Whole commands and files: G-code, check of the house, start of the command line."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.timing import Row, best
from cablewright.printing.gcode import parse

HOUSE = Path(__file__).parents[1] / "examples" / "house.toml"
RUN = (
    "import resource, sys, time; begin = time.perf_counter(); from cablewright.apps.cli.main import run; "
    "code = run(sys.argv[1:]); usage = resource.getrusage(resource.RUSAGE_SELF); "
    "print('\\n', code, time.perf_counter() - begin, usage.ru_maxrss * (1 if sys.platform == 'darwin' else 1024))"
)


def rows() -> Iterator[Row]:
    """All rows of this file."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        yield gcode_row(place)
        seconds, _, _ = command(["--help"], {})
        seconds = min(seconds, *(command(["--help"], {})[0] for _ in range(4)))
        yield Row("cablewright --help", seconds, "s", "<= 0.5", seconds <= 0.5)
        check = ["check", "house-printer", str(HOUSE), "--json", "--out"]
        first, _, _ = command([*check, str(place / "first")], {"CABLEWRIGHT_CACHE_DIR": str(place / "cache")})
        yield Row("check of the house, first run ever, compile included", first, "s", "<= 90", first <= 90)
        command([*check, str(place / "compile")], {})
        seconds, memory, answer = min((command([*check, str(place / "run")], {}) for _ in range(2)), key=lambda r: r[0])
        yield Row(f"check of the house, {answer['samples']} samples", seconds, "s", "<= 30", seconds <= 30)
        yield Row("  its largest memory", memory / 1e9, "GB", "<= 2", memory <= 2e9)


def gcode_row(folder: Path) -> Row:
    """Plain G1 lines with X, Y and E, as slicers write them."""
    rng = np.random.default_rng(3)
    moves = rng.uniform(-200, 200, (100_000, 2))
    file = folder / "plain.gcode"
    lines = [f"G1 X{x:.3f} Y{y:.3f} E{0.1 * i:.5f}" for i, (x, y) in enumerate(moves)]
    file.write_text("\n".join(["G21", "G90", "M82", "G1 F1800", *lines]) + "\n")
    return Row("G-code parser, 100 000 lines", best(lambda: parse(file), 3), "s")


def command(arguments: list[str], environment: dict[str, str]) -> tuple[float, float, dict[str, object]]:
    """Wall time (s) from the first import, largest memory (bytes) and JSON of a command in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-c", RUN, *arguments],
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=True,
    )
    *output, last = done.stdout.strip().splitlines()
    code, seconds, memory = last.split()
    if code != "0":
        raise RuntimeError(f"{' '.join(arguments)} ended with {code}: {done.stderr}")
    answer = json.loads(output[0]) if "--json" in arguments else {}
    return float(seconds), float(memory), answer
