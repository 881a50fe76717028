"""A small package of kernels of the name cablewright, whose sources can be edited, and processes that use it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from cablewright import kernels
from cablewright.kernels import cache

CALLER = """
import ctypes, numpy as np
from cablewright.kernels import is_compiled, jit
from cablewright.kernels.wing.callee import rate

TABLE = np.ones(200_000)  # too large to be copied into the compiled code

@jit
def double():
    return 2.0 * rate()

@jit
def from_table(i):
    return TABLE[i]

def hits(kernel):
    return sum(kernel.stats.cache_hits.values())
"""


def planted(place: Path) -> Path:
    """Put the package, of two small kernel files in two folders, in *place*, with room for its cache."""
    package = place / "cablewright" / "kernels"
    (package / "wing").mkdir(parents=True)
    for empty in (package.parent, package / "wing"):
        (empty / "__init__.py").touch()
    for name in ("__init__.py", "cache.py", "shipped_kernels.py", "compiler.py", "resolved_calls.py"):
        shutil.copy(Path(kernels.__file__).parent / name, package)
    (package / "caller.py").write_text(CALLER)
    edit(place, 1.0)
    return place


def edit(tree: Path, rate: float) -> None:
    """Let the callee return another *rate*."""
    callee = tree / "cablewright" / "kernels" / "wing" / "callee.py"
    callee.write_text(f"from cablewright.kernels import jit\n@jit\ndef rate():\n    return {rate}\n")


def start(tree: Path, code: str, *arguments: str, folder: str = "cache", **settings: str) -> subprocess.Popen[str]:
    """A process that runs *code* in the *tree*, with *settings* in its environment."""
    return subprocess.Popen(
        [sys.executable, "-B", "-c", code, *arguments],  # Python's own cache distinguishes files by size and second
        cwd=tree,
        env=os.environ | {cache.DIRECTORY: str(tree / folder)} | settings,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def ended(process: subprocess.Popen[str], said: str = "", answered: str = "") -> str:
    """What a process that ended well printed, once *answered*; on stderr it had only *said*, once."""
    out, err = process.communicate(answered, timeout=120)
    assert process.returncode == 0, err
    assert err.count("\n") == (1 if said else 0), err
    assert said in err
    return out.strip()


def entries(folder: Path) -> list[Path]:
    """All files below *folder*, finished or not."""
    return [each for each in folder.rglob("*") if each.is_file()]


DOUBLE = "from cablewright.kernels.caller import *; print(double(), hits(double))"
