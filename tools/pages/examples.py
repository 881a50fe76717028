"""Write ``docs/examples.md``: the scripts of ``examples/``, their first lines, and the numbers that the tests pin.

A test compares the page with this output. Run it from the repository root: ``python tools/pages/examples.py``.
"""

from __future__ import annotations

import ast
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "examples.md"
PINNED = re.compile(r'^    "([\w/]+)": \((-?[\d.]+), [\d.]+\),  # ([^;\n]+)', re.MULTILINE)
HEAD = """# Examples

`examples/` holds short scripts. Each runs in seconds from the repository root, `python examples/01_hold_a_pose.py`. Its
last line prints one number, which is in the table. The tests run each script and compare the number.

| script | purpose | prints |
| --- | --- | --- |
"""
FOOT = """
`examples/papers/` has scripts for the papers, which print their numbers beside those of cablewright ([The four
papers](papers.md)). The other files are inputs: jobs (`house.toml`, `blind-machines.toml`), G-code, a survey, a lidar
scan, two cable tests, a free swing, calibration data and an uncertainty file.

This page is written by `tools/pages/examples.py`.
"""


def page() -> str:
    """The whole page."""
    rows = ""
    for name, number, unit in PINNED.findall((ROOT / "tests" / "test_examples.py").read_text("utf-8")):
        text = ast.get_docstring(ast.parse((ROOT / "examples" / f"{name}.py").read_text("utf-8"))) or ""
        rows += f"| `{name}.py` | {text.splitlines()[0].rstrip('.')} | {number} {unit} |\n"
    return HEAD + rows + FOOT


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
