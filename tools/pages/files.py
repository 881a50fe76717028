"""Write ``docs/files.md``: the files of ``src`` by folder, each with the first line of its docstring.

``python tools/pages/files.py``
"""

from __future__ import annotations

import ast
import textwrap
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SOURCE = ROOT / "src" / "cablewright"
PAGE = ROOT / "docs" / "files.md"

HEAD = """# Files

This page lists the files of `src/cablewright` with the first line of each module's docstring. For how they work
together see [Architecture](architecture.md). It is written by `tools/pages/files.py` from the code.
"""


def page() -> str:
    """Return the page."""
    folders: dict[str, list[tuple[str, str]]] = defaultdict(list)
    for path in sorted(SOURCE.rglob("*.py")):
        text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
        if path.name != "__init__.py" or text:
            folders[path.parent.relative_to(SOURCE).as_posix()].append((path.name, text.partition("\n")[0]))
    parts = [HEAD]
    for folder, files in sorted(folders.items()):
        title = "cablewright" if folder == "." else folder
        parts.append(f"\n## `{title}/`\n")
        parts += [textwrap.fill(f"* `{name}`: {line}", 120, subsequent_indent="  ") for name, line in files]
    return "\n".join(parts) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
