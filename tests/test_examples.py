"""Each example runs alone, and the last line it prints ends in its pinned number."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
PINNED = {  # the number, and how far the printed one may be from it: its last digit
    "01_hold_a_pose": (833.4, 0.1),  # N
    "02_where_does_it_hang": (19.0, 0.1),  # mm; Paty 2021, Table 1 prints 19.5
    "03_slack_line": (0.40, 0.01),  # N
    "04_stiffness": (98.88, 0.01),  # kN/m
    "05_check_a_part": (19.76, 0.01),  # mm
    "06_own_robot": (2.7283, 0.0001),  # m
}


def test_every_example_is_pinned() -> None:
    assert sorted(path.stem for path in EXAMPLES.glob("*.py")) == sorted(PINNED)


@pytest.mark.parametrize("name", sorted(PINNED))
def test_an_example_prints_its_number(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
    last = capsys.readouterr().out.splitlines()[-1]
    found = re.search(r": (-?[0-9.]+) [a-zA-Z/]+$", last)
    assert found is not None, f"the last line tells no number with its unit: {last!r}"
    number, last_digit = PINNED[name]
    assert float(found[1]) == pytest.approx(number, abs=1.001 * last_digit)
