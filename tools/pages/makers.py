"""The page of makers, `docs/makers.md`, with its commands run anew on the files of `examples/makers`.

``python tools/refresh_docs.py docs/makers.md`` writes it. Of a command's answer the page keeps the lines whose first
words it has already, and all notes where it has one.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import shutil
import tempfile
from pathlib import Path

from cablewright.apps.cli.main import run

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "makers.md"
FILES = ROOT / "examples" / "makers"


def page() -> str:
    """Return the page with what its commands print now."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "makers"
        shutil.copytree(FILES, folder)
        with contextlib.chdir(folder):
            return re.sub(r"(?<=```text\n).*?(?=```)", _block, PAGE.read_text("utf-8"), flags=re.DOTALL)


def _block(found: re.Match[str]) -> str:
    sessions = re.split(r"(?m)^(?=\$ )", found[0])
    return "".join(_session(each) if each.startswith("$ ") else each for each in sessions)


def _session(text: str) -> str:
    """Return a command and what it prints, as far as the page shows it."""
    command, _, shown = text.partition("\n")
    program, *words = shlex.split(command.removeprefix("$ "))
    if program in ("cat", "tail"):
        lines = Path(words[-1]).read_text("utf-8").splitlines()
        return "\n".join([command, *(lines[-2:] if program == "tail" else lines)]) + "\n"
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        code = run(words)
    if code:
        raise SystemExit(f"makers: {command} ended with {code}: {said.getvalue()[-500:]}")
    labels = {_label(line) for line in shown.splitlines()}
    kept: list[str] = []
    for line in said.getvalue().splitlines():
        label = _label(line)
        if label in labels:
            kept.append(line)
            labels -= {label} - {"note"}  # tables below repeat some words
    return "\n".join([command, *kept]) + "\n"


def _label(line: str) -> str:
    return "note" if line.startswith("note: ") else line.partition("  ")[0]


if __name__ == "__main__":
    os.environ["COLUMNS"] = "1000"
    PAGE.write_text(page(), encoding="utf-8")
