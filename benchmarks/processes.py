"""Commands in a process of their own: wall time, and memory that is not the benchmark's."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).parents[1]
# A process's largest memory begins with that of the program it was started from, on Linux: a small one starts it here.
LAUNCH = """
import os, sys, time
begin = time.perf_counter()
_, status, usage = os.wait4(os.posix_spawn(sys.executable, [sys.executable, *sys.argv[1:]], os.environ), 0)
memory = usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024)
print("\\n", os.waitstatus_to_exitcode(status), time.perf_counter() - begin, memory)
"""


def alone(arguments: list[str], environment: Mapping[str, str] | None = None) -> tuple[str, float, float]:
    """Output, wall time (s) and largest memory (bytes) of Python with *arguments*, from the repository's root.

    Memory is that of the process, or of the largest that it started. Raises `RuntimeError` if it fails.
    """
    done = subprocess.run(
        [sys.executable, "-I", "-S", "-c", LAUNCH, *arguments],
        cwd=ROOT, env=os.environ | (environment or {}), capture_output=True, text=True, check=True,
    )  # fmt: skip
    output, _, last = done.stdout.rstrip().rpartition("\n")
    code, seconds, memory = last.split()
    if code != "0":
        raise RuntimeError(f"{' '.join(arguments)} ended with {code}: {done.stderr}")
    return output.strip(), float(seconds), float(memory)
