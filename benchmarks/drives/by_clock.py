"""A print on virtual CANopen drives in a second process, by wall clock: steps of control, and how late cycles were.

`python -m benchmarks.drives 60000` runs that many cycles of 10 ms and prints a histogram of their lateness beside that
of a loop on the same computer, at the same time of day, that only sleeps.
"""

from __future__ import annotations

import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

from benchmarks.timing import Row
from cablewright.foundation.signals import PrintState
from cablewright.live.drives.actions import home
from cablewright.live.drives.printing import PersonOperator, print_on_drives
from cablewright.live.prints.loop import Printer
from cablewright.live.prints.print_job import PrintedJob
from cablewright.machine.files import load_machine
from cablewright.printing.job import Job, Motion
from cablewright.printing.numeric_path import Helix
from cablewright.robot import load

EXAMPLE = Path(__file__).parents[2] / "examples" / "virtual-drives.toml"
BEGIN = (0.7, -0.5, 1.0)
FULL, QUICK = 6000, 300
RING = 2600  # cycles of one ring
EDGES = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0)  # ms
ORDERS = {
    PrintState.FAULT: "reset",
    PrintState.OFF: "enable",
    PrintState.IDLE: "home",
    PrintState.REFILLING: "refilled",
}

Array = NDArray[np.float64]


class Orders(PersonOperator):
    """Whoever types the orders of a print, and fills the drum of the virtual drives, whose input is *beside* it."""

    def __init__(self, beside: IO[str]) -> None:
        self.beside = beside
        self.line: list[str] = []
        self.steps, self.homed = 0, False
        super().__init__(lambda: self.line, lambda: False, lambda _said: None)

    def orders(self, printer: Printer, now: float):  # type: ignore[no-untyped-def]
        """One word every half second."""
        self.steps += 1
        state = printer.supervisor.state
        self.homed |= state is PrintState.HOMING
        word = "start" if state is PrintState.IDLE and self.homed else ORDERS.get(state)
        self.line = [word] if word is not None and self.steps % 50 == 0 else []
        if state is PrintState.REFILLING and self.steps % 50 == 25:
            self.beside.write("refill\n")
            self.beside.flush()
        return super().orders(printer, now)


def rows(cycles: int) -> Iterator[Row]:
    """All rows of this file."""
    printed, late = run(cycles)
    numbers = printed.run.timing.statistics()
    mean, p99 = 1e3 * numbers["mean"], 1e3 * numbers["p99"]
    yield Row("print on drives over a bus, a step of control and log", mean, "ms", "<= 1", mean <= 1.0)
    yield Row("the same, 99 of 100", p99, "ms", "<= 5", p99 <= 5.0)
    yield Row("SYNC late, 99 of 100", float(np.percentile(1e3 * late, 99.0)), "ms", "", None)
    yield Row(
        "a loop that only sleeps, 99 of 100",
        float(np.percentile(1e3 * sleeps(min(cycles, 1000)), 99.0)),
        "ms",
        "",
        None,
    )


def run(cycles: int) -> tuple[PrintedJob, Array]:
    """Print rings for about so many cycles; also returns how late each SYNC was, s."""
    layers, radius = max(1, round(cycles / RING)), 0.4 * min(1.0, cycles / RING)
    job = Job(
        name="ring",
        origin=(BEGIN[0] - radius, BEGIN[1], 0.0),
        helix=Helix(radius=radius, layers=layers, layer_height=0.001, first_height=1.0),
        motion=Motion(print_speed=0.1, travel_speed=0.1, acceleration=0.1),
    )
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        file = folder / "machine.toml"
        file.write_text(EXAMPLE.read_text(encoding="utf-8").replace('"43113"', f'"{free_port()}"'), encoding="utf-8")
        at = ",".join(map(str, BEGIN))
        command = [sys.executable, "-m", "cablewright", "drives", "--virtual", str(file), "--at", at]
        drives = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        try:
            assert drives.stdin is not None
            assert drives.stderr is not None
            drives.stderr.readline()
            robot, settings = load("merlet2023"), load_machine(file)
            homed = home(robot, settings, folder / "machine", np.array(BEGIN))
            assert not homed.reason, homed.reason
            orders = Orders(drives.stdin)
            found = print_on_drives(robot, job, folder / "run", settings, folder / "machine", orders, inputs={})
            assert found.finished, found.run.reason
            machine = found.run.machine.machine  # type: ignore[attr-defined]  # the drives behind the counts
            return found, np.array(machine.drives.statistics.lateness, dtype=np.float64)
        finally:
            drives.terminate()
            drives.communicate()


def free_port() -> int:
    """A free UDP port of this computer."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as found:
        found.bind(("127.0.0.1", 0))
        number: int = found.getsockname()[1]
        return number


def sleeps(cycles: int, period: float = 0.01) -> Array:
    """How late a loop wakes that does nothing else, s."""
    late, due = [], time.monotonic()
    for _ in range(cycles):
        due += period
        time.sleep(max(0.0, due - time.monotonic()))
        late.append(time.monotonic() - due)
        due = max(due, time.monotonic() - period)
    return np.array(late)


def histogram(late: Array) -> list[str]:
    """Shares of cycles by lateness."""
    bounds = np.array([0.0, *EDGES, np.inf])
    counts, _ = np.histogram(np.clip(1e3 * late, 0.0, None), bounds)
    ends = [f"{edge:g}" for edge in (*EDGES, np.inf)]
    return [f"up to {end:>4} ms  {100.0 * count / len(late):8.3f} %" for end, count in zip(ends, counts, strict=True)]


def main() -> None:
    """Print the histograms."""
    cycles = int(sys.argv[1]) if len(sys.argv) > 1 else FULL
    printed, late = run(cycles)
    print(f"{len(late)} cycles; steps of control and log: {printed.run.timing.statistics()}")
    print("\n".join(histogram(late)), flush=True)
    print("a loop that only sleeps, for a minute at most:")
    print("\n".join(histogram(sleeps(min(len(late), FULL)))))
