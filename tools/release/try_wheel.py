"""A wheel in an empty environment: it is installed from the index, and a user's first minutes are timed.

    python tools/release/try_wheel.py WHEEL [EXTRA ...]

Printed are the seconds of the first `inverse` and of the block of Python in README.md, each in a fresh process, with an
empty cache of kernels. It ends with 1 where one of them takes longer than it may.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
import time
import venv
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[2]
FIRST: Final = 'import cablewright as cw\nprint(cw.inverse(cw.load("merlet2023"), [0.2, 0.1, 1.0]).lengths)\n'
MOST: Final = {"first inverse": 4.0, "README": 8.0}  # s, with compiled kernels


def main(wheel: Path, extras: list[str]) -> int:
    """Install the wheel with *extras*, and return 0 if all is fast enough."""
    block = re.search(r"```python\n(.*?)```", (ROOT / "README.md").read_text("utf-8"), re.DOTALL)
    if block is None:
        sys.exit("try: README.md has no block of Python")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        venv.create(folder / "venv", with_pip=True)
        python = folder / "venv" / "bin" / "python"
        asked = f"{wheel}[{','.join(extras)}]" if extras else str(wheel)
        subprocess.run([python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", asked], check=True)
        took = {}
        for script, text in (("first inverse", FIRST), ("README", block[1])):
            took[script] = timed(python, text, folder / script.replace(" ", "-"))
    for script, seconds in took.items():
        print(f"{script}: {seconds:.1f} s, at most {MOST[script]:g}")
    return int(any(took[script] > most for script, most in MOST.items()))


def timed(python: Path, text: str, folder: Path) -> float:
    """Run a script in an empty *folder*, with a cache of its own, and return the seconds that it took."""
    folder.mkdir()
    own = {key: value for key, value in os.environ.items() if not key.startswith(("NUMBA_", "PYTHON"))}
    began = time.monotonic()
    subprocess.run(
        [python, "-c", text], cwd=folder, check=True, env=own | {"CABLEWRIGHT_CACHE_DIR": str(folder / "cache")}
    )
    return time.monotonic() - began


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(main(Path(sys.argv[1]).absolute(), sys.argv[2:]))
