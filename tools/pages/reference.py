"""Write ``docs/reference.md``: the scripts of ``examples/public``, and where mkdocstrings finds each public name.

A test compares the page with this output. Run it from the repository root: ``python tools/pages/reference.py``.
"""

from __future__ import annotations

import ast
from pathlib import Path

import cablewright

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "reference.md"
HEAD = """# Reference

The public Python interface: all of it is in `import cablewright as cw`. A function of a robot takes a `Robot` or a
`Model`; laws are members of `CableLaw` and `SheaveLaw` or their names; other options are keywords. A wrong option is an
error at the call, in one line that names the choices. The scripts below are those of `examples/public`, and use every
name once; [all names](#all-names) follow.

This page is written by `tools/pages/reference.py`.
"""


def page() -> str:
    """The whole page."""
    parts = [HEAD]
    for file in sorted((ROOT / "examples" / "public").glob("*.py")):
        code = file.read_text("utf-8")
        title, text = (ast.get_docstring(ast.parse(code)) or "").split("\n\n", 1)
        parts += [f"## {title.rstrip('.')}\n", f"{text}\n", "```python", code.split('"""\n\n', 1)[1] + "```\n"]
    homes: dict[str, str] = vars(cablewright)["_HOMES"]
    parts += ["## All names\n", *(f"::: {homes[name]}.{name}\n" for name in sorted(homes, key=str.lower))]
    return "\n".join(parts)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
