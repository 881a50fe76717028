"""Write ``docs/support.md``: which capability supports which feature of a robot, from the table in the code.

A test compares the page with this output. Run it from the repository root: ``python tools/pages/support.py``.
"""

from __future__ import annotations

from itertools import groupby
from pathlib import Path

from cablewright.models.support_table import FEATURES, SUPPORT, Capability

PAGE = Path(__file__).resolve().parents[2] / "docs" / "support.md"
HEAD = """# Support by feature

`cablewright robots NAME --support` answers for one robot, of the library or a file: it prints the verdict of each
capability, which part of the robot decides it, and what to use instead. `--json` prints the same as JSON.

| verdict | meaning |
| --- | --- |
| works | the feature is part of the model |
| not checked | the answer is computed, and its list `not_checked` names what it leaves out |
| lost | the file is written without the feature, and a note names it |
| rejected | one line names the feature and what to use instead; the exit code is 2 |

A capability and a feature that are in no row of the next table work together. Numbers of a robot and options can be
rejected besides: the message names them.

"""


def page() -> str:
    """The whole page."""
    words = {feature.name: feature.words for feature in FEATURES}
    text = HEAD + "| capability | verdict | features | alternative, or omission |\n| --- | --- | --- | --- |\n"
    for (capability, cell), group in groupby(SUPPORT.items(), lambda item: (item[0][0], item[1])):
        named = ", ".join(words[name] for (_, name), _ in group)
        text += f"| {capability} | {cell.verdict} | {named} | {cell.instead} |\n"
    met = {capability for capability, _ in SUPPORT}
    rest = ", ".join(f"`{capability}`" for capability in Capability if capability not in met)
    text += (
        f"\nThese work with all features: {rest}.\n\n## Features\n\n| feature | where a robot has it |\n| --- | --- |\n"
    )
    text += "".join(f"| {feature.words} | `{feature.key}` |\n" for feature in FEATURES if feature.name != "lines")
    return text + "\nThis page is written by `tools/pages/support.py` from `cablewright.models.support_table`.\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
