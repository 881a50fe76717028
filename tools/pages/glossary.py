"""Write ``docs/glossary.md`` from the terms that reports use. A test compares the page with this output."""

from __future__ import annotations

from pathlib import Path

from cablewright.apps.glossary import GLOSSARY

PAGE = Path(__file__).resolve().parents[2] / "docs" / "glossary.md"
HEAD = """# Glossary

One line a term, with the symbol that the papers have for it. Reports link to the terms that they use inside themselves.
This page is written by `tools/pages/glossary.py`.
"""


def page() -> str:
    """The whole page."""
    parts = [HEAD]
    for title, terms in GLOSSARY.items():
        rows = [f"| {each.name} | {each.symbol} | {each.meaning} |" for each in terms]
        parts.append("\n".join([f"## {title}\n", "| term | symbol | meaning |", "| --- | --- | --- |", *rows, ""]))
    return "\n".join(parts)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
