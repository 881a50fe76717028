"""Commands that are killed, interrupted, without room, without their folder or in company, and their next runs."""

from __future__ import annotations

import runpy
import subprocess
import sys
from pathlib import Path

import pytest

from cases import some

TOOL = runpy.run_path(str(Path(__file__).parents[2] / "tools" / "kill_campaigns.py"), run_name="tool")
EACH_ONCE = len(TOOL["TASKS"]) * len(TOOL["DISASTERS"])
CAMPAIGNS = TOOL["listed"](2 * EACH_ONCE, 1, TOOL["TASKS"], TOOL["DISASTERS"])
FEW = some([("trade", "kill"), ("trade", "interrupt"), ("trade", "full-disk")], 0)  # as apps/cli/test_print_kills.py


@pytest.mark.parametrize(("command", "disaster"), FEW)
def test_the_next_run_is_as_if_nothing_had_happened(command: str, disaster: str) -> None:
    assert TOOL["held"](TOOL["Campaign"](command, disaster, 3)).faults == []


@pytest.mark.slow
@pytest.mark.parametrize("campaign", CAMPAIGNS, ids=lambda each: f"{each.command}-{each.disaster}-{each.seed}")
def test_all_disasters(campaign) -> None:
    assert TOOL["held"](campaign).faults == []


def test_each_command_has_each_disaster_twice() -> None:
    assert len(set(CAMPAIGNS)) == 2 * EACH_ONCE
    assert {(each.command, each.disaster) for each in CAMPAIGNS[:EACH_ONCE]} == {
        (each.command, each.disaster) for each in CAMPAIGNS[EACH_ONCE:]
    }


@pytest.mark.parametrize(
    ("program", "faults"),
    [
        ("import sys; sys.exit('cablewright: no')", []),
        ("import sys; sys.exit(1)", ["no reason"]),
        ("raise KeyError", ["traceback", "no reason"]),
        ("import sys; sys.exit('cablewright: ' + 'x' * 3000)", ["a message of 3013 characters"]),
    ],
)
def test_the_output_of_a_program_is_judged(program: str, faults: list[str]) -> None:
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    outcome = TOOL["Outcome"]()
    TOOL["judge_words"](TOOL["end"](process, 0.0), outcome)
    assert [fault.startswith(word) for fault, word in zip(outcome.faults, faults, strict=True)] == [True] * len(faults)
