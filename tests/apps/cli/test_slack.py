"""`inverse --slack` and `--all-slack-sets`: what they print, the yes and the no, and what they reject."""

from __future__ import annotations

import runpy
import struct
from pathlib import Path

import pytest

from cablewright.apps import style
from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import library_text, load
from cablewright.solvers.slack import slack_sets, solve_with_slack

MERLET = ("inverse", "merlet2023", "--at", "0,-1,1")
BODY = ("inverse", "cogiro", "--at", "3,3,2")


@pytest.mark.parametrize("line", ["north-west", "4", " north-west ", "4 "])
def test_a_slack_line_by_name_or_number(cli, line: str) -> None:
    answer = cli(*MERLET, "--slack", f"{line}=0.3", "--json")
    assert (answer.code, answer.err) == (0, "")
    found = answer.json
    solved = solve_with_slack(Model(load("merlet2023")), [0.0, -1.0, 1.0], {3: 0.3})
    assert found["status"] == "ok"
    assert found["lengths"] == solved.lengths.tolist()
    assert found["tensions"] == solved.tensions.tolist()
    assert found["excess"][3] == pytest.approx(0.3, abs=1e-12)
    assert max(found["excess"][:3]) < 0.0
    assert found["residual"] < 1e-9


def test_a_name_comes_before_a_number(cli, tmp_path: Path) -> None:
    file = tmp_path / "robot.toml"
    file.write_text(library_text("merlet2023").replace('"north-east"', '"4"'), encoding="utf-8")
    at = ("inverse", file, "--at", "0,-1,1", "--json")
    assert cli(*at, "--slack", "4=0.3").json["excess"][2] == pytest.approx(0.3, abs=1e-12)
    assert cli(*at, "--slack", "3=0.2").json["excess"][2] == pytest.approx(0.2, abs=1e-12)
    both = cli(*BODY, "--slack", "1=0.05,2=0.4", "--json").json
    assert both["excess"][:2] == pytest.approx([0.05, 0.4], abs=1e-12)


def test_people_see_the_excess(cli) -> None:
    answer = cli(*MERLET, "--slack", "north-west=0.3")
    assert answer.code == 0
    assert answer.rows[-5][-1] == "excess, m"
    assert (answer.rows[-1][0], float(answer.rows[-1][-1])) == ("north-west", pytest.approx(0.3, abs=1e-4))
    assert "excess" not in cli(*MERLET).out
    assert "excess" not in cli(*MERLET, "--json").json


def test_a_line_that_cannot_be_slack_is_a_no(cli) -> None:
    answer = cli(*MERLET, "--slack", "south-west=0.3", "--json")
    assert "a line would have to push" in answer.no
    assert answer.json["status"] == "infeasible"
    assert answer.json["excess"] == [None] * 4


def test_the_machines_other_limits_hold_with_slack_lines_too(cli) -> None:
    answer = cli("inverse", "merlet2023", "--at", "0,-1,-0.2", "--slack", "4=0.1", "--json")
    assert answer.json["status"] == "out-of-limits"
    assert "frame, z -0.2 m" in answer.no
    assert cli("inverse", "merlet2023", "--at", "0,-1,1", "--slack", "4=239").code == 1  # more than the drum holds


@pytest.mark.parametrize("cable", ["rigid", "elastic", "catenary"])
def test_all_slack_sets(cli, cable: str) -> None:
    found = cli(*MERLET, "--all-slack-sets", "--cable", cable, "--json").json
    assert found["status"] == "ok"
    sets = slack_sets(Model(load("merlet2023"), Fidelity.of(cable)), [0.0, -1.0, 1.0])
    assert len(found["sets"]) == len(sets) == 2
    for printed, solved in zip(found["sets"], sets, strict=True):
        assert (printed["taut"], printed["slack"]) == (list(solved.taut), list(solved.slack))
        assert (printed["excess_low"], printed["excess_high"]) == (solved.excess_low, solved.excess_high)
        assert printed["ended_by"] == solved.ended_by == ("floor" if cable == "catenary" else "capacity")
        assert printed["tensions"] == solved.tensions.tolist()
        assert printed["lengths"] == solved.equilibrium.lengths.tolist()
        assert printed["status"] == "ok"


def test_all_slack_sets_for_people(cli) -> None:
    answer = cli(*BODY, "--all-slack-sets")
    assert (answer.code, answer.err) == (0, "")
    assert (answer.figure("status"), answer.figure("robot")) == ("ok", "cogiro")
    assert answer.rows[-5][:3] == ["taut", "slack", "status"]
    assert [row[1] for row in answer.rows[-4:]] == ["1, 2", "1, 8", "2, 7", "7, 8"]


def test_no_set_is_a_no(cli) -> None:
    answer = cli(*MERLET, "--all-slack-sets", "--tension-limits", "100,200", "--json")
    assert answer.no == "no 3 of the 4 lines hold this pose within their limits with the others slack"
    assert (answer.json["status"], answer.json["sets"]) == ("infeasible", [])


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--slack", "north-wst=1"], "unknown line 'north-wst'; did you mean 'north-west'"),
        (["--slack", "0=1"], "no line 0; the lines of 'merlet2023' are 1 to 4"),
        (["--slack", "5=1"], "no line 5; the lines"),
        (["--slack", f"{'9' * 5000}=1"], "unknown line '999"),
        (["--slack", "-1=1"], "unknown line '-1'"),
        (["--slack", "4"], "expected LINE=EXCESS in m, like south-west=0.3 or 1=0.3"),
        (["--slack", ""], "expected LINE=EXCESS"),
        (["--slack", "4=0.1,"], "expected LINE=EXCESS"),
        (["--slack", "4="], "expected LINE=EXCESS"),
        (["--slack", "4=30 cm"], "expected LINE=EXCESS"),
        (["--slack", "=1"], "expected LINE=EXCESS"),
        (["--slack", "4=-1"], "excess of line 'north-west' = -1 m"),
        (["--slack", "4=nan"], "= nan m"),
        (["--slack", "4=1e999"], "= inf m"),
        (["--slack", "4=1,north-west=1"], "line 'north-west' is named twice"),
        (["--slack", "3=1,4=1"], "at most 1 can be slack"),
        (["--slack", "4=1", "--all-slack-sets"], "give one of them"),
        (["--slack", "4=1", "--retraction", "2"], "has no retraction"),
        (["--all-slack-sets", "--retraction", "2"], "has no retraction"),
    ],
)
def test_bad_input_is_one_line(cli, options: list[str], says: str) -> None:
    assert says in cli(*MERLET, *options).refusal


def test_a_pose_with_free_parts_has_no_slack_lines(cli) -> None:
    assert "finite; got nan" in cli("inverse", "merlet2023", "--at", "free,0,1", "--slack", "4=1").refusal
    grab = ("inverse", "grab-four-lines", "--at", "1.0,0.3,-0.2,free,free,0")
    assert "fewer winches than degrees of freedom" in cli(*grab, "--slack", "1=0.1").refusal
    assert "fewer winches than degrees of freedom" in cli(*grab, "--all-slack-sets").refusal


def test_the_pictures_of_the_page_are_drawn() -> None:
    tool = runpy.run_path(str(Path(__file__).parents[3] / "tools" / "slack_pictures.py"), run_name="tool")
    with style.drawing():
        for name, made in (("let-out", tool["draw_let_out"]()), ("angle", tool["draw_angles"]())):
            kept = (tool["IMAGES"] / f"slack-{name}.png").read_bytes()
            assert made.startswith(b"\x89PNG")
            assert max(len(made), len(kept)) < 150_000
            assert struct.unpack(">II", made[16:24]) == struct.unpack(">II", kept[16:24])  # width and height
