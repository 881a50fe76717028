"""Lateness of the control's steps while a print is watched, and while it is not: histograms beside each other.

`python tools/serve_lateness.py` prints a ring of three layers twice on the simulated house-printer, at the pace of the
clock: alone, and watched by a client at the page's rate. It counts the states that the client got, and the processor
time of the page's server. The computer must have a core to spare: a busy one is late by its other work.
Needs the extra web, and Linux.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Final

ROOT: Final = Path(__file__).resolve().parent.parent
TICKS: Final = os.sysconf("SC_CLK_TCK")


def _processor_time(process: int) -> float:
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def _checked_job(server: Any, page: Any, settings: str) -> str:
    """Send a job and wait for its check; return its number."""
    own = {"authorization": f"Bearer {server.token}", "x-page": page.page}
    number = str(json.loads(server.ask("POST", "/jobs", '{"name": "ring"}', **own)[1])["id"])
    server.ask("PUT", f"/jobs/{number}/settings", settings, **own)
    server.ask("POST", f"/jobs/{number}/check", "", **own)
    while True:
        page.during(0.5)
        found = next(each for each in json.loads(server.ask("GET", "/jobs")[1]) if each["id"] == number)
        if found["check"] is not None and not found["busy"]:
            return number


def measured(watched: bool, settings: str) -> dict[str, Any]:
    """Print once; return how late its steps were."""
    tests = importlib.import_module("served")
    client, served = tests.client, tests.served
    with (
        tempfile.TemporaryDirectory() as folder,
        served(Path(folder) / "out", "house-printer", "--seed", "1") as server,
    ):
        with client(server) as page:
            assert not page.take("bench")
            number = _checked_job(server, page, settings)
            own = {"authorization": f"Bearer {server.token}", "x-page": page.page}
            server.ask("POST", f"/jobs/{number}/load", "{}", **own)
            page.until(lambda state: page.sitting.get("job") and state.get("sitting") == page.sitting["sitting"])
            page.ready()
            page.order("start")
            page.until(lambda state: state["state"] == "printing")
            process, begin = server.server(), time.monotonic()
            before, states = _processor_time(process), len(page.states)
            while watched and not (page.state.get("finished") or page.state["state"] in ("fault", "closed")):
                page.during(1.0)
            states = len(page.states) - states
            taken = time.monotonic() - begin
            used = _processor_time(process) - before
        run = Path(folder) / "out" / "runs"
        while not (ends := list(run.glob("*/run.json"))):
            time.sleep(0.5)
            if not watched:
                taken, used = time.monotonic() - begin, _processor_time(process) - before
        about = json.loads(ends[0].read_text())
    steps = about["steps"]
    return {
        "watched": watched,
        "status": about["status"],
        "load": round(os.getloadavg()[0], 1),
        "states a second": round(states / taken, 1) if watched else 0.0,
        "server, share of a core": round(used / taken, 4),
        "steps": steps["count"],
        "late up to, ms": [None if each is None else 1e3 * each for each in about["late_up_to"]],
        "share of steps": [round(each / sum(about["late"]), 5) for each in about["late"]],
        "processor time of a step, ms: mean, p99": [1e3 * steps["processor_mean"], 1e3 * steps["processor_p99"]],
    }


def main() -> int:
    """Measure both, and print them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--layers", type=int, default=3)
    given = parser.parse_args()
    sys.path.insert(0, str(ROOT / "tests"))
    settings = importlib.import_module("served").RING.replace("layers = 3", f"layers = {given.layers}")
    for watched in (False, True):
        print(json.dumps(measured(watched, settings)), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
