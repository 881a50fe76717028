"""Write ``docs/api.md``: where mkdocstrings finds each public name. Run it: ``python tools/pages/api.py``."""

from __future__ import annotations

from pathlib import Path

import cablewright

PAGE = Path(__file__).resolve().parents[2] / "docs" / "api.md"
HEAD = """# Python interface

Every public name of `import cablewright as cw`, in alphabetical order. [Python](reference.md) uses each of them once.

This page is written by `tools/pages/api.py`.
"""


def page() -> str:
    """The whole page."""
    homes: dict[str, str] = vars(cablewright)["_HOMES"]
    return HEAD + "".join(f"\n::: {homes[name]}.{name}\n" for name in sorted(homes, key=str.lower))


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
