"""`equilibria` on the command line."""

from __future__ import annotations

import pytest


def test_the_json_of_the_contract(cli) -> None:
    found = cli("equilibria", "paty2021", "--lengths", "33,33,33,33", "--json").json
    assert (len(found["solutions"]), found["found"], found["complete_for"]) == (16, 16, None)
    first = found["solutions"][0]
    assert (first["stable"], first["certified"], first["slack"]) == (True, True, [False] * 4)
    assert first["status"] == "ok"
    assert len(first["pose"]) == 3
    assert len(first["tensions"]) == 4
    assert not any(other["stable"] for other in found["solutions"][1:])


def test_the_text(cli) -> None:
    rows = cli("equilibria", "merlet2023", "--lengths", "9.7,9.9,9.7,9.7", "--sheave", "eyelet").out.splitlines()
    assert {"equilibria    1", "stable        1", "complete for  all equilibria whose dead spans are taut"} <= set(rows)
    head, row = rows[-2:]
    assert head.split("  ")[0] == "status"
    assert row.startswith("ok ")
    assert row.endswith("  yes")  # certified
    assert head.split()[-1] == "certified"


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("--lengths", "33,33"), "4 numbers are expected"),
        (("--lengths", "33,33,33,33", "--box", "0,0,1,1,1,1"), "X0 < X1"),
        (("--lengths", "33,33,33,33", "--starts", "0"), "starts = 0"),
        (("--lengths", "33,33,33,33", "--retraction", "1"), "has no retraction"),
    ],
)
def test_bad_input_is_one_line(cli, arguments: tuple[str, ...], told: str) -> None:
    assert told in cli("equilibria", "paty2021", *arguments).refusal


def test_nothing_found_is_a_no(cli) -> None:
    answer = cli("equilibria", "paty2021", "--lengths", "33,33,33,33", "--box", "0,1,0,1,100,101")
    assert answer.no.startswith("no equilibrium was found")


LENGTHS = "10.1187,9.3676,10.9961,11.3476"  # one line is 0.3 m too long
TAUT = "9.8237,9.3676,10.9961,11.3476"  # it is 5 mm too long


@pytest.mark.slow
def test_a_search_that_leaves_nothing_out(cli, tmp_path) -> None:
    file = tmp_path / "search.state"
    asked = ("equilibria", "merlet2023", "--lengths", LENGTHS, "--exhaustive", "--out", str(file), "--json")
    found = cli(*asked).json
    assert (found["status"], found["undecided_boxes"]) == ("ok", [])
    assert "without a loop in a dead span" in found["complete_for"]
    assert len(found["solutions"]) == 1
    assert file.exists()
    assert cli(*asked).json == found


def test_a_search_that_was_ended_goes_on(cli, tmp_path) -> None:
    file = tmp_path / "search.state"
    asked = ("equilibria", "merlet2023", "--lengths", TAUT, "--exhaustive", "--out", str(file))
    ended = cli(*asked, "--time-limit", "1e-6")
    assert ended.code == 1
    assert "the same command resumes" in ended.err
    assert "boxes are not judged yet" in ended.no
    assert file.exists()
    out = cli(*asked).out
    assert "complete for  all equilibria with the platform in the box and without a loop in a dead span" in out
    assert "the search excludes any other in the box whose dead spans are taut" in out


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("--time-limit", "5"), "are only for --exhaustive"),
        (("--exhaustive", "--time-limit", "0"), "time limit = 0"),
        (("--exhaustive", "--out", "{garbage}"), "this file is no saved state of cablewright"),
    ],
)
def test_bad_searches_are_one_line(cli, tmp_path, arguments: tuple[str, ...], told: str) -> None:
    garbage = tmp_path / "garbage.state"
    garbage.write_bytes(b"PK\x03\x04 no archive at all")
    given = [str(garbage) if part == "{garbage}" else part for part in arguments]
    assert told in cli("equilibria", "merlet2023", "--lengths", LENGTHS, *given).refusal


def test_lengths_that_cannot_meet_are_an_answer_of_no(cli) -> None:
    asked = ("equilibria", "merlet2023", "--lengths", "5,5,5,5", "--json")
    found = cli(*asked)
    assert found.code == 1
    assert found.json["status"] == "overstretched"
    assert [each["status"] for each in found.json["solutions"]] == ["overstretched"]
    assert found.err == (
        "cablewright: the lengths cannot meet: in every stable equilibrium a line is over its breaking load\n"
    )
