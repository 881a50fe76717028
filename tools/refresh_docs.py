"""Run the commands of the docs and replace the output on the pages.

A block of commands (``sh``) that is followed by a block of text (``text``) is such a pair; tests hold them equal. A
page that a tool writes, as ``docs/files.md`` by ``tools/pages/files.py``, is written by it.
Run it from the repository root: ``python tools/refresh_docs.py docs/walls.md ..``.
"""

from __future__ import annotations

import re
import runpy
import shlex
import subprocess
import sys
from pathlib import Path

PAIR = re.compile(r"(```sh\n(cablewright [^\n]*)\n```\n+```text\n)(.*?)(```)", re.DOTALL)


def main(files: list[str]) -> None:
    """Refresh the pairs of each file."""
    for name in files:
        page = Path(name)
        maker = Path(__file__).parent / "pages" / page.with_suffix(".py").name
        if maker.exists():
            runpy.run_path(str(maker), run_name="__main__")
            continue
        text = page.read_text(encoding="utf-8")
        page.write_text(PAIR.sub(lambda pair: pair[1] + _printed(pair[2]) + pair[4], text), encoding="utf-8")


def _printed(command: str) -> str:
    return subprocess.run(shlex.split(command), check=False, capture_output=True, text=True).stdout


if __name__ == "__main__":
    main(sys.argv[1:])
