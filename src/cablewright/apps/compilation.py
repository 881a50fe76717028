"""Compilation of the kernels that a command needs, before its work begins, by several processes.

A process of its own compiles kernels for the others, which find them in the folder of compiled kernels: it reads names
of `TASKS` from its input, one a line, and repeats each when it is done. Progress is reported to people who wait.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from queue import SimpleQueue
from typing import TYPE_CHECKING, Final

from cablewright.foundation.errors import AnswerError
from cablewright.kernels import thread_count
from cablewright.kernels.cache import open_folder
from cablewright.solvers.row_threads import saying_more

if TYPE_CHECKING:
    from cablewright.models.statics import Equilibrium

MAX_PROCESSES: Final = 4  # each lowers again what kernels share

Say = Callable[[int, int, float], None]
"""Called with the kernels that are done, all of them, and about how many seconds are left."""


def _inverse() -> None:
    from cablewright.solvers.inverse import solve_inverse

    solve_inverse(_unsolved().model, _unsolved().pose)


def _forward() -> None:
    from cablewright.solvers.forward import solve_forward

    solve_forward(_unsolved().model, _unsolved().lengths)


def _linearise() -> None:
    from cablewright.solvers.linearise import linearise_where_regular

    linearise_where_regular(_unsolved())


def _tension_changes() -> None:
    from cablewright.solvers.linearise import tension_changes

    with suppress(AnswerError):
        tension_changes(_unsolved())


def _residuals() -> None:
    _unsolved().residual_norm()


def _certify() -> None:
    from cablewright.solvers.certify import certify

    certify(_unsolved())


def _distances() -> None:
    from cablewright.analyses.interference import distances

    distances(_unsolved())


def _line_shapes() -> None:
    from cablewright.analyses.line_shapes import polylines

    found = _unsolved()
    polylines(found.packed, found.pose[0], found.states[0], 1e-3)


def _stiffness() -> None:
    from cablewright.models.stiffness import stiffness

    stiffness(_unsolved())


TASKS: Final[dict[str, tuple[Callable[[], None], float]]] = {
    "inverse": (_inverse, 10.0),
    "forward": (_forward, 10.0),
    "linearise": (_linearise, 5.0),
    "tension changes": (_tension_changes, 4.0),
    "residuals": (_residuals, 4.0),
    "certify": (_certify, 6.0),
    "distances": (_distances, 5.0),
    "line shapes": (_line_shapes, 3.0),
    "stiffness": (_stiffness, 8.0),
}
"""What compiles each kernel of a plain robot, and about how many seconds one process takes for it."""


@cache
def _unsolved() -> Equilibrium:
    """Arrays as kernels take them; all entries are NaN, so that kernels end immediately."""
    import numpy as np

    from cablewright.models.statics import Equilibrium, Model
    from cablewright.robot import load

    model = Model(load("merlet2023"))
    numbers = np.full(1, np.nan), np.zeros(1, np.int64)
    pose, lengths, states = np.zeros((1, model.n)), np.ones((1, model.m)), np.full((1, model.m, 6), np.nan)
    return Equilibrium(model, model.rows(), pose, lengths, states, numbers[1], numbers[0], numbers[1])


@dataclass(eq=False)
class _Work:
    """Tasks to do, and how it goes."""

    names: tuple[str, ...]
    waiting: deque[str]
    say: Say
    processes: int
    begin: float = field(default_factory=time.monotonic)
    done: list[str] = field(default_factory=list)

    def ended(self, name: str) -> None:
        """Record a finished task, and report the progress."""
        self.done.append(name)
        self.tell()

    def tell(self) -> None:
        """Report how many tasks are done, and how long the others may take, by the pace so far."""
        running = [name for name in self.names if name not in self.waiting and name not in self.done]
        done, half, known = (sum(TASKS[name][1] for name in names) for names in (self.done, running, self.names))
        worked = done + 0.5 * half  # those that run may be anywhere between begin and end
        pace = (time.monotonic() - self.begin) / worked if self.done else 1.0 / self.processes
        self.say(len(self.done), len(self.names), pace * (known - worked))


def prepare(names: tuple[str, ...], say: Say) -> None:
    """Compile the numerical kernels of the tasks with the given *names*, in this process and others."""
    processes = min(len(names), thread_count(), MAX_PROCESSES) if _is_shared() else 1
    work = _Work(names, deque(names), say, processes)
    work.tell()
    workers = [_begun() for _ in range(processes - 1)]
    helpers = [threading.Thread(target=_fed, args=(each, work), daemon=True) for each in workers]
    try:
        with saying_more():
            for helper in helpers:
                helper.start()
            _here(work)
            for helper in helpers:
                helper.join()
            _here(work)  # what a process that was ended left undone
    finally:
        for each in workers:
            each.kill()
            each.communicate()


def _is_shared() -> bool:
    """Whether what another process compiles is found by this one."""
    folder = open_folder()
    return folder is not None and os.access(folder, os.W_OK)


def _here(work: _Work) -> None:
    """Do tasks in this process, from the first on."""
    while work.waiting:
        with suppress(IndexError):
            name = work.waiting.popleft()
            TASKS[name][0]()
            work.ended(name)


def _begun() -> subprocess.Popen[str]:
    """A process that compiles the kernels named on its input. It ends with its input."""
    optimised = ["-" + "O" * sys.flags.optimize] if sys.flags.optimize else []
    return subprocess.Popen(
        [sys.executable, *optimised, "-m", "cablewright.apps.compilation"],
        env=os.environ | {"NUMBA_NUM_THREADS": "1"},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )


def _fed(worker: subprocess.Popen[str], work: _Work) -> None:
    """Let *worker* do tasks, from the last on, as long as it answers."""
    assert worker.stdin is not None
    assert worker.stdout is not None
    while work.waiting:
        try:
            name = work.waiting.pop()
        except IndexError:
            return
        try:
            worker.stdin.write(f"{name}\n")
            worker.stdin.flush()
            answer = worker.stdout.readline().strip()
        except (OSError, ValueError):  # it has ended, or was ended
            answer = ""
        if answer != name:
            work.waiting.append(name)
            return
        work.ended(name)


def main() -> None:
    """Compile the tasks that are read from the standard input; end with that input, even in the middle of a task."""
    asked: SimpleQueue[str] = SimpleQueue()
    threading.Thread(target=_listen, args=(asked,), daemon=True).start()
    while True:
        name = asked.get()
        TASKS[name][0]()
        print(name, flush=True)


def _listen(asked: SimpleQueue[str]) -> None:
    for line in sys.stdin:
        asked.put(line.strip())
    os._exit(0)  # whoever asked has ended, or needs no more


if __name__ == "__main__":
    main()
