"""Three simultaneous threads, each of which shares its batches with the same others; and the requested number of
threads."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

THREE_AT_ONCE = """
import threading
import numpy as np
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import linearise

model = Model(load("merlet2023"))
poses = np.random.default_rng(0).uniform([-1, -2, 0.5], [1, 2, 2], (1000, 3))
wanted = solve_inverse(model, poses).checked()
poses_back = solve_forward(model, wanted.lengths).pose
motion = linearise(wanted).motion
wrong = []

def work():
    for _ in range(2):
        held = solve_inverse(model, poses)
        back = solve_forward(model, held.lengths)
        same = (held.lengths == wanted.lengths).all() and (back.pose == poses_back).all()
        if not (same and (linearise(held).motion == motion).all()):
            wrong.append(1)

threads = [threading.Thread(target=work) for _ in range(3)]
[t.start() for t in threads]
[t.join() for t in threads]
print("wrong" if wrong else "right")
"""


@pytest.mark.parametrize("count", ["2", "5", pytest.param("1", marks=pytest.mark.slow)])
def test_threads_may_solve_batches_simultaneously(count: str) -> None:
    ended = subprocess.run(
        [sys.executable, "-c", THREE_AT_ONCE],
        env=os.environ | {"NUMBA_NUM_THREADS": count},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert (ended.returncode, ended.stdout.strip()) == (0, "right"), ended.stderr[-2000:]
