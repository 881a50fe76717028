"""Write ``docs/states.md``: the states of a print, and the error codes of drives, from their tables in the code.

A test compares the page with this output. Run it from the repository root: ``python tools/pages/states.py``.
"""

from __future__ import annotations

from pathlib import Path

from cablewright.control.transitions import TRANSITIONS, Event
from cablewright.foundation.signals import OrderKind, PrintState
from cablewright.machine.drives import faults

PAGE = Path(__file__).resolve().parents[2] / "docs" / "states.md"
HEAD = """# States of a print, error codes of drives

This page is written by `tools/pages/states.py` from the tables in the code.

## States

The table is complete: any other order has no effect, and the answer gives the reason. [Print](print.md#states) explains
stops, faults and manual motion.
"""
CODES = """
## Error codes of drives

Object 0x603F of CiA 301 and CiA 402. [Drives](drives.md#faults) lists the texts of the machine itself.

| code | meaning | what to do |
| --- | --- | --- |
"""


def page() -> str:
    """The whole page."""
    codes = "".join(f"| `0x{code:04X}` | {each.meaning} | {each.remedy} |\n" for code, each in faults.TEXTS.items())
    return f"{HEAD}\n{_states()}\n{CODES}{codes}"


def _states() -> str:
    """The transitions: a row for each event and the state that follows."""
    rows: dict[tuple[Event, PrintState], list[PrintState]] = {}
    for (state, event), then in TRANSITIONS.items():
        rows.setdefault((event, then), []).append(state)
    lines = ["| event | in | leads to |", "| --- | --- | --- |"]
    for (event, then), states in rows.items():
        what = f"order: {event.value}" if isinstance(event, OrderKind) else event.value
        where = "every state" if len(states) == len(PrintState) else ", ".join(states)
        lines.append(f"| {what} | {where} | {then.value} |")
    return "\n".join(lines)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
