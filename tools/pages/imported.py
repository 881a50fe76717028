"""Write ``docs/imported.md``: what the import takes from each format, as the readers declare it.

A test compares the page with this output. Run it from the repository root: ``python tools/pages/imported.py``.
"""

from __future__ import annotations

from pathlib import Path

from cablewright.exchange.formats import READ

PAGE = Path(__file__).resolve().parents[2] / "docs" / "imported.md"
HEAD = """# Imported values

`cablewright import` takes these values from the files of other programs. [Files of other programs](exchange.md) has the
limits of each format. Keys are those of [robot files](keys.md#robot-files).

This page is written by `tools/pages/imported.py` from the readers in the code.
"""


def page() -> str:
    """The whole page."""
    parts = [HEAD]
    for name, each in READ.items():
        parts += [f"## {each.title}\n", f"`--format {name}`\n", "| in the file | in the robot file |", "| --- | --- |"]
        parts += [f"| {one.theirs} | {one.ours}{f': {one.note}' if one.note else ''} |" for one in each.carried]
        parts += [""]
    return "\n".join(parts).rstrip() + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
