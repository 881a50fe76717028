"""Children forked after their parent's first parallel kernel: results are the same, and no process waits for ever."""

from __future__ import annotations

import multiprocessing
import subprocess
import sys

import pytest

PROGRAM = """
import multiprocessing, sys
import numpy as np
import cablewright as cw

ROBOT = cw.load("merlet2023")
POSES = np.random.default_rng(1).uniform([-1.5, -3.0, 0.5], [1.5, 3.0, 2.0], (200, 3))


def lengths(part):
    return cw.inverse(ROBOT, POSES[part::2]).lengths


if __name__ == "__main__":
    whole = cw.inverse(ROBOT, POSES).lengths
    with multiprocessing.get_context(sys.argv[1]).Pool(2) as pool:
        parts = pool.map(lengths, [0, 1])
    assert all((whole[part::2] == parts[part]).all() for part in (0, 1))
    print("the same")
"""


@pytest.mark.parametrize("method", sorted({"fork", "forkserver", "spawn"} & {*multiprocessing.get_all_start_methods()}))
def test_a_pool_finds_the_same(method: str, tmp_path) -> None:
    (tmp_path / "program.py").write_text(PROGRAM)
    ended = subprocess.run(
        [sys.executable, str(tmp_path / "program.py"), method], capture_output=True, text=True, timeout=240, check=False
    )
    assert ended.stdout == "the same\n", ended.stderr
