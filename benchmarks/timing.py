"""Measuring: the best of a few repeats, so that what else the machine does counts least."""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from importlib.util import find_spec
from pathlib import Path

from scipy import stats

HERE = Path(__file__).parents[1]


@dataclass(frozen=True)
class Row:
    """One line of the table. `aim` is a bound on `value`; `peer` and `ratio` are of another way to do the same."""

    name: str
    value: float
    unit: str
    aim: str = ""
    met: bool | None = None
    peer: str = ""
    ratio: float | None = None

    def text(self) -> str:
        """For the table."""
        verdict = "" if self.met is None else ("yes" if self.met else "NO")
        beside = "" if self.ratio is None else f"{self.ratio:,.1f} x {self.peer}"
        return f"{self.name:<52} {self.value:>12,.2f} {self.unit:<10} {self.aim:<14} {verdict:<4} {beside}"

    def fields(self) -> dict[str, object]:
        """For the JSON file, in Python's own types."""
        return {name: value.item() if hasattr(value, "item") else value for name, value in asdict(self).items()}


def installed(peer: str) -> bool:
    """Whether a library to compare with can be imported; says so where its rows are left out."""
    if find_spec(peer) is None:
        print(f"{peer} is not installed: left out", file=sys.stderr)
        return False
    return True


def best(function: Callable[[], object], repeats: int = 5) -> float:
    """Shortest time of *repeats* calls, s, after one that is not counted."""
    function()
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        function()
        times.append(time.perf_counter() - begin)
    return min(times)


def medians(functions: list[Callable[[], object]], calls: int) -> list[float]:
    """Median time of a call of each function, s, called in turn so that the machine's moods hit all alike."""
    times: list[list[float]] = [[] for _ in functions]
    for function in functions:
        function()
    for _ in range(calls):
        for function, own in zip(functions, times, strict=True):
            begin = time.perf_counter()
            function()
            own.append(time.perf_counter() - begin)
    return [statistics.median(own) for own in times]


def interval(hits: int, of: int) -> str:
    """A share of hits in per cent, with its 95 % interval (Clopper and Pearson 1934)."""
    low = stats.beta.ppf(0.025, hits, of - hits + 1) if hits else 0.0
    high = stats.beta.ppf(0.975, hits + 1, of - hits) if hits < of else 1.0
    share = 100.0 * hits / of if of else float("nan")
    return f"{share:.1f} % of {of} ({100.0 * low:.1f} to {100.0 * high:.1f})"


@contextmanager
def checked_out(revision: str) -> Iterator[Path]:
    """A working tree of *revision*, which is removed afterwards."""
    with tempfile.TemporaryDirectory() as folder:
        there = Path(folder) / "then"
        subprocess.run(["git", "worktree", "add", "-q", "--detach", there, revision], cwd=HERE, check=True)
        try:
            yield there
        finally:
            subprocess.run(["git", "worktree", "remove", "--force", there], cwd=HERE, check=True)
