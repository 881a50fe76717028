"""A print that is killed goes on where it was: nothing laid twice, nothing left out."""

from __future__ import annotations

import os
import runpy
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from print_logs import RING

TOOL = runpy.run_path(str(Path(__file__).parents[3] / "tools" / "kill_campaigns.py"), run_name="tool")
pytestmark = pytest.mark.usefixtures("undrawn")
JOB = RING.format(radius=0.4)
UNDRAWN = (
    "import io; from PIL import Image; from cablewright.apps import style; pixel = io.BytesIO(); "
    "Image.new('RGB', (1, 1)).save(pixel, 'PNG'); style.png = lambda drawn: pixel.getvalue(); "
)  # pictures of its report take longer than the print
TOOL["start"].__globals__["PROGRAM"] = UNDRAWN + TOOL["PROGRAM"]


def start(job: Path, out: Path, *options: str, most: int | None = None) -> subprocess.Popen[bytes]:
    """The print as its user has it, with files of *most* bytes."""
    return TOOL["start"](["print", "merlet2023", job, "--out", out, "--json", *options], job.parent, most)


def killed(job: Path, out: Path, after: float, *options: str) -> None:
    """Start it, and kill it so many seconds after it began to print, or as it ends."""
    before = len(list(out.glob("log-*"))) if out.exists() else 0
    process = start(job, out, *options)
    while len(list(out.glob("log-*"))) <= before and process.poll() is None:
        time.sleep(0.01)
    time.sleep(after)
    process.send_signal(signal.SIGKILL)
    process.communicate()


def resumed(cli: Callable[..., Any], job: Path, out: Path, *options: str) -> dict[str, Any]:
    """The figures of the print that goes on, in this process."""
    answer = cli("print", "merlet2023", job, "--out", out, "--json", *options, "--resume")
    assert answer.code == 0, answer.err
    assert max(TOOL["flaws"](TOOL["laid"](out, job))) <= TOOL["LONGEST"]
    return dict(answer.json)


def campaign(cli: Callable[..., Any], tmp_path: Path, kills: int, seed: int, *options: str) -> None:
    """Prints, each killed and resumed at random until it is at its end or was killed ten times."""
    job = tmp_path / "job.toml"
    job.write_text(JOB)
    random = np.random.default_rng(seed)
    done, run = 0, 0
    while done < kills:
        out, own = tmp_path / f"run{run}", (*options, "--seed", str(run))
        here = 0
        while done < kills and here < 10 and not (out / "metrics.json").exists():
            killed(job, out, float(random.uniform(0.0, 1.5)), *own, *(["--resume"] if here else []))
            done, here = done + 1, here + 1
        values = resumed(cli, job, out, *own)
        assert values["status"] == "finished"
        assert values["max_path_error"] < 0.015
        run += 1


def test_a_killed_print_goes_on_where_it_was(cli: Callable[..., Any], tmp_path: Path) -> None:
    campaign(cli, tmp_path, 1, 1, "--plant", "quasi-static", "--period", "0.2")


@pytest.mark.slow
def test_fifty_kills(cli: Callable[..., Any], tmp_path: Path) -> None:
    campaign(cli, tmp_path, 50, 2)


def test_a_full_disk_stops_the_print_and_it_goes_on_once_there_is_room(cli: Callable[..., Any], tmp_path: Path) -> None:
    job, out = tmp_path / "job.toml", tmp_path / "run"
    job.write_text(JOB)
    options = ("--plant", "quasi-static", "--period", "0.2")
    full = start(job, out, *options, most=600_000 if os.name == "posix" else None)
    _, said = full.communicate()
    assert full.returncode == 3
    assert said.decode().strip().splitlines()[-1].endswith("File too large")
    assert resumed(cli, job, out, *options)["status"] == "finished"
