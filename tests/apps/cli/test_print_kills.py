"""A print that is killed goes on where it was: nothing laid twice, nothing left out."""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from cablewright.control.guide import TimedPath
from cablewright.machine.log.log import read_log
from cablewright.printing.job import load_job
from cablewright.signals import Scan
from printed import RING

JOB = RING.format(radius=0.4)
LONGEST = 0.03  # m of path that may be laid twice or not at all


def start(job: Path, out: Path, *options: str, most: int | None = None) -> subprocess.Popen[bytes]:
    """The command as its user has it, with files of *most* bytes."""

    def bound() -> None:
        if most is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)

    program = "from cablewright.apps.cli.main import main; main()"
    command = [sys.executable, "-c", program, "print", "merlet2023", str(job), "--out", str(out)]
    return subprocess.Popen(
        [*command, "--json", *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, preexec_fn=bound
    )


def killed(job: Path, out: Path, after: float, *options: str) -> None:
    """Start it, and kill it so many seconds after it began to print, or as it ends."""
    before = len(list(out.glob("log-*"))) if out.exists() else 0
    process = start(job, out, *options)
    while len(list(out.glob("log-*"))) <= before and process.poll() is None:
        time.sleep(0.01)
    time.sleep(after)
    process.send_signal(signal.SIGKILL)
    process.communicate()


def laid(out: Path, job: Path) -> np.ndarray:
    """Stretches of path (k, 2), m, along which the valve was open, in the order of time, by the true place."""
    track = TimedPath.of(load_job(job)).track
    stretches, before = [], None
    with read_log(out) as log:
        for entry in log.entries(without={Scan}):
            assert entry.truth is not None
            assert entry.command is not None
            assert entry.progress is not None
            here = track.nearest(entry.truth.position, entry.progress.distance, 0.1).distance
            if entry.command.valve > 0.0 and before is not None:
                stretches.append((before, here))
            before = here
        assert log.notes == []
    return np.array(stretches)


def flaws(stretches: np.ndarray) -> tuple[float, float]:
    """The longest gap between what was laid, and the longest way back before it went on, m."""
    reached = np.maximum.accumulate(stretches[:, 1])
    gaps = stretches[1:, 0] - reached[:-1]
    return float(gaps.max()), float(-gaps.min())


def campaign(tmp_path: Path, kills: int, seed: int, *options: str) -> None:
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
        end = start(job, out, *own, "--resume")
        told, said = end.communicate()
        assert end.returncode == 0, said.decode()
        values = json.loads(told)
        assert values["status"] == "finished"
        assert values["max_path_error"] < 0.015
        assert max(flaws(laid(out, job))) <= LONGEST
        run += 1


def test_a_killed_print_goes_on_where_it_was(tmp_path: Path) -> None:
    campaign(tmp_path, 3, 1, "--plant", "quasi-static", "--period", "0.2")


@pytest.mark.slow
def test_fifty_kills(tmp_path: Path) -> None:
    campaign(tmp_path, 50, 2)


def test_a_full_disk_stops_the_print_and_it_goes_on_once_there_is_room(tmp_path: Path) -> None:
    job, out = tmp_path / "job.toml", tmp_path / "run"
    job.write_text(JOB)
    full = start(job, out, "--plant", "quasi-static", most=1_200_000 if os.name == "posix" else None)
    _, said = full.communicate()
    assert full.returncode == 3
    assert said.decode().strip().splitlines()[-1].endswith("File too large")
    again = start(job, out, "--plant", "quasi-static", "--resume")
    told, said = again.communicate()
    assert again.returncode == 0, said.decode()
    assert json.loads(told)["status"] == "finished"
    assert max(flaws(laid(out, job))) <= LONGEST
