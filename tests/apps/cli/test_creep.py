"""`creep`: what it prints, writes and refuses."""

from __future__ import annotations

from pathlib import Path

import pytest

import cablewright as cw

ROOT = Path(__file__).resolve().parents[3]
TEST = ROOT / "examples" / "creep.csv"
GIVEN = ("--initial-length", "2 m")
KEYS = {
    "schema", "status", "stiffness", "stiffness_sigma", "expansion", "loaded", "creep", "parts", "noise", "widened",
    "uncertainty_file", "notes", "plot",
}  # fmt: skip


def test_json(cli) -> None:
    answer = cli("creep", TEST, *GIVEN, "--json")
    assert (answer.code, answer.err) == (0, "")
    assert answer.json.keys() == KEYS
    assert answer.json["stiffness"] == pytest.approx(480e3, rel=1e-3)
    assert answer.json["creep"][-1]["time"] == answer.json["loaded"]


def test_the_entry_is_that_of_an_uncertainty_file(cli, tmp_path: Path) -> None:
    found = cli("creep", TEST, *GIVEN, "--json").json
    (tmp_path / "crept.toml").write_text("schema = 1\n" + found["uncertainty_file"])
    one = cw.load_uncertainty(tmp_path / "crept.toml").of(cw.load("house-printer"))[0]
    assert (one.parameter.kind, one.low) == ("creep_compliance", 0.0)
    assert one.high == pytest.approx(found["creep"][-1]["compliance"], rel=0.05)


def test_elements_are_chosen(cli) -> None:
    plain = cli("creep", TEST, *GIVEN, "--retardations", "none", "--json").json
    assert [part["part"] for part in plain["parts"]] == ["logarithmic"]
    own = cli("creep", TEST, *GIVEN, "--retardations", "30 s,10 min,1 h", "--json").json
    assert [part["part"] for part in own["parts"]][:3] == ["element of 30 s", "element of 600 s", "element of 3600 s"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--retardations", "20 min,1 min"), "retardations = 1200, 60 s: expected up to 4 that rise"),
        (("--retardations", "4 h"), "the element of 4 h needs a load for 4 h, the test has 3 h: hold longer"),
        (("--retardations", "1 fortnight"), "--retardations"),
        (("--initial-length", "2 kg"), "--initial-length"),
    ],
)
def test_what_is_wrong_is_one_line(cli, options: tuple[str, ...], message: str) -> None:
    answer = cli("creep", TEST, *GIVEN, *options)
    assert answer.code == 2
    assert message in answer.err
    assert answer.err.count("\n") == 1


def test_a_tensile_test_is_too_short(cli) -> None:
    answer = cli("creep", ROOT / "examples" / "tensile.csv", *GIVEN)
    assert answer.code == 2
    assert "the element of 20 min needs a load for 20 min, the test has 5.98 min" in answer.err
