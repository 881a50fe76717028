"""Violations first, in words."""

import re
from dataclasses import replace

import numpy as np
import pytest

from cablewright.analyses.feasibility import LIMITS, Finding
from cablewright.apps.report.check_summary import Digest
from cablewright.apps.report.worst_limits import findings_table, ranked

INF = np.inf
LOW = Finding("lowest tension", "N", -13.0, 7.0, (20.0, INF), "a", 5, 12)
HIGH = Finding("highest tension", "N", -100.0, 5100.0, (-INF, 5000.0), "b", 5, 1)
SWING = Finding("swing", "rad", 0.1, 0.6, (-0.7, 0.7), "b", 3, 0)
FRAME = Finding("frame, z", "m", 0.0, 0.0, (0.0, 15.0), None, 0, 0)
LOST = Finding("the solver did not converge", "", -1.0, 0.0, (0.0, 0.0), None, 4, 2)
UNKNOWN = Finding("smell", "Bq", 3.0, 1.0, (-INF, INF), "c", 3, 0)


def test_violations_come_first_and_the_worst_of_them_leads():
    assert ranked((SWING, FRAME, HIGH, UNKNOWN, LOW, LOST)) == [LOST, LOW, HIGH, FRAME, SWING, UNKNOWN]


def rows(small, *findings):
    digest = Digest(replace(small[0], findings=findings), small[1])
    table = str(findings_table(digest)).replace("\N{NO-BREAK SPACE}", " ").replace("\N{MINUS SIGN}", "-")
    cells = [re.findall(r"<td.*?</td>", row) for row in re.findall(r"<tr>.*?</tr>", table)]
    return [[re.sub(r"<[^>]+>", " ", cell).strip() for cell in row] for row in cells if row]


def test_a_violation_in_words(small):
    [row] = rows(small, LOW)
    limit, line, margin, value, allowed, where, outside = row
    assert "hangs loose" in limit
    assert (line, margin, value, allowed) == ("a", "13 N outside", "7 N", "at least 20 N")
    samples = small[0].samples
    assert f"G-code line {samples.line[5]}" in where
    assert f"layer {samples.layer[5]}" in where
    assert outside.startswith("12 (")


@pytest.mark.parametrize(
    ("finding", "words"),
    [
        (HIGH, ["100 N outside", "5.1 kN", "at most 5 kN"]),
        (SWING, ["5.7° left", "34.4°", "-40.1° to 40.1°"]),
        (FRAME, ["platform", "0 m left", "0 m to 15 m", "leaves the frame"]),
        (LOST, ["no solution", "the solver did not converge"]),
        (UNKNOWN, ["3 Bq left", "no limit"]),
    ],
)
def test_each_kind_in_words(small, finding, words):
    [row] = rows(small, finding)
    for word in words:
        assert any(word in cell for cell in row), (word, row)


@pytest.mark.parametrize("name", [*(limit.name for limit in LIMITS), "frame, x", "frame, y", "frame, z"])
def test_every_limit_states_its_purpose(small, name):
    [row] = rows(small, replace(HIGH, limit=name))
    assert len(row[0].removeprefix(name).split()) > 4


def test_no_findings(small):
    assert "nothing was judged" in findings_table(Digest(replace(small[0], findings=()), small[1]))
