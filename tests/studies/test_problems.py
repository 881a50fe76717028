"""The named problems: cablewright finds all answers, the file is what its tool makes, and wrong answers are named."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from benchmarks.problems import answers

import cablewright as cw

ROOT = Path(__file__).resolve().parents[2]


def test_there_are_thirty_with_their_sources() -> None:
    found = cw.problems()
    assert len(found) == len({each.name for each in found}) == 30
    assert {each.kind for each in found} == {
        "forward", "tensions", "acceleration", "margin", "volume", "calibration", "frequencies",
    }  # fmt: skip
    assert all(each.oracle and each.question.endswith("?") and each.tolerance > 0.0 for each in found)
    assert sum(len(cw.problems(kind)) for kind in {each.kind for each in found}) == 30
    assert repr(found[0]).startswith("Problem(name='forward-room-3', question='Where does")


@pytest.mark.parametrize("problem", cw.problems(), ids=lambda each: each.name)
def test_cablewright_finds_the_answer(problem: cw.Problem) -> None:
    answer, seconds = problem.solve()
    assert problem.error(answer) <= problem.tolerance
    assert seconds > 0.0


@pytest.mark.slow  # as `test_cablewright_finds_the_answer`, more sharply
def test_volumes_are_within_four_sigma() -> None:
    """Without the share of the tolerance that the refinement may take."""
    for problem in cw.problems("volume"):
        sigma = float(problem.oracle.split("sigma ")[1].split()[0])
        found = cw.workspace(problem.robot, "exact", cable="rigid")
        assert problem.error([found.volume]) <= 4.0 * sigma + found.volume_error


def test_the_file_is_what_the_tool_makes() -> None:
    text = (ROOT / "src" / "cablewright" / "studies" / "problems.json").read_text("utf-8")
    kept = {each["name"]: each for each in json.loads(text)["problems"]}
    for made in (*answers.tensions(), *answers.margins(), *answers.accelerations(), answers.forwards()[0]):
        stored = kept[made["name"]]
        assert made["inputs"] == stored["inputs"]
        np.testing.assert_allclose(made["answer"], stored["answer"], rtol=1e-12)


def test_wrong_kinds_and_answers_are_named() -> None:
    with pytest.raises(cw.UnknownName, match="unknown kind of problem 'forwards'; did you mean 'forward'"):
        cw.problems("forwards")
    with pytest.raises(cw.InputError, match=r"problem margin-middle: 1 numbers are expected, not shape \(2,\)"):
        cw.problems("margin")[0].error([1.0, 2.0])
    assert cw.problems("margin")[0].error([0.0]) > 1.0
