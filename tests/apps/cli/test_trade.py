"""`trade`: the contract's JSON, the table, pictures, sweeps that go on, and bad input."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import library_text, load
from cablewright.robot.design_variables import Change
from cablewright.studies.trade import TradeSettings
from cablewright.studies.trade import trade as sweep

KEYS = {
    "schema",
    "status",
    "robot",
    "cable",
    "sheave",
    "criterion",
    "count",
    "grid",
    "tolerance",
    "box",
    "point",
    "orientations",
    "retraction",
    "seed",
    "boundary_grid",
    "counts_geometric",
    "tensions",
    "sheave_clearance",
    "inertia",
    "varied",
    "combinations",
    "not_dominated",
    "file",
    "plot",
}
QUICK = ("--criterion", "closed-form", "--count", "nodes", "--grid", "15", "--boundary-grid", "9")
VARY = ("--vary", "exit-distance=0.05:0.15:3", "--vary", "width-top-x=0.04,0.1")


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_trade_prints_what_the_study_finds(cli) -> None:
    answer = cli("trade", "jung2020", *VARY, *QUICK, "--json")
    assert answer.code == 0
    found = answer.json
    asked = TradeSettings("closed-form", count="nodes", grid=15, boundary_grid=9)
    varied = {Change("exit-distance"): (0.05, 0.1, 0.15), Change("width-top-x"): (0.04, 0.1)}
    own = sweep(Model(load("jung2020"), Fidelity.of("elastic")), varied, asked)
    assert found.keys() == KEYS
    assert (found["status"], found["cable"], found["counts_geometric"]) == ("ok", "elastic", True)
    assert found["varied"] == [
        {"name": "exit-distance", "unit": "m", "values": pytest.approx([0.05, 0.1, 0.15])},
        {"name": "width-top-x", "unit": "m", "values": [0.04, 0.1]},
    ]
    rows = found["combinations"]
    assert [row["volume"] for row in rows] == [each.volume for each in own.combinations]
    assert [row["lowest_frequency"]["min"] for row in rows] == [each.least for each in own.combinations]
    assert [row["lowest_frequency"]["worst_pose"] for row in rows] == [list(e.worst_pose) for e in own.combinations]
    assert [row["not_dominated"] for row in rows] == own.best.tolist()
    assert found["not_dominated"] == [k for k, best in enumerate(own.best) if best]
    assert rows[0]["parameters"] == {"exit-distance": 0.05, "width-top-x": 0.04}
    assert rows[0]["sheaves"] == {
        "distance": pytest.approx(0.05),
        "lines": ["1", "5"],
        "margin": -0.05,
        "collide": True,
    }
    assert (rows[2]["sheaves"]["margin"], rows[2]["sheaves"]["collide"]) == (0.0, False)


def test_a_volume_is_that_of_workspace_on_the_robot_written_by_hand(cli, tmp_path: Path) -> None:
    (tmp_path / "wider.toml").write_text(library_text("jung2020").replace("0.925", "0.9").replace("10 kg", "11 kg"))
    vary = ("--vary", f"exit-distance={0.1 * 2**0.5}", "--vary", "mass=11")
    found = cli("trade", "jung2020", *vary, "--tolerance", "0.01", "--boundary-grid", "7", "--json").json
    own = cli("workspace", "wider.toml", "--tolerance", "0.01", "--json").json
    (row,) = found["combinations"]
    assert row["volume"] == pytest.approx(own["volume"], rel=1e-9)
    assert row["volume_error"] == pytest.approx(own["volume_error"], rel=1e-6)
    held = cli("modes", "wider.toml", "--boundary", "--grid", "7", "--cable", "elastic", "--json").json["boundary"]
    assert row["lowest_frequency"]["min"] == pytest.approx(held["min"], rel=1e-9)
    assert row["lowest_frequency"]["n"] == held["n"]


def test_people_get_a_table_and_a_picture(cli, tmp_path: Path) -> None:
    for vary in (VARY, VARY[:2], ("--vary", "modulus=0.5,1", "--vary", "mass=" + ",".join(map(str, range(5, 13))))):
        answer = cli("trade", "jung2020", *vary, *QUICK, "--no-geometric", "--plot", "t.png")
        assert answer.code == 0
        assert (tmp_path / "t.png").read_bytes().startswith(b"\x89PNG")
    rows = cli("trade", "jung2020", *VARY, *QUICK, "--no-geometric").rows[-7:-1]
    assert [row[0].split()[::2] for row in rows[:2]] == [["exit-distance", "width-top-x"]] * 2
    assert [row[-2:] for row in rows[:3]] == [["yes", "no"], ["yes", "no"], ["no", "yes"]]


def test_options_reach_the_study(cli) -> None:
    def row(*options: str) -> dict:
        (only,) = cli("trade", "jung2020", "--vary", "mass=10", *QUICK, *options, "--json").json["combinations"]
        return only

    plain = row()
    assert row("--seed", "3") == plain
    for option in (
        ("--retraction", "1.4"),
        ("--retraction-law=-1,2.4,1.2,2",),
        ("--wrench", "0,0,-100"),
        ("--tension-limits", "20,150"),
        ("--orientations", "0,0,0;0.1,0,0"),
        ("--box", "0,1,0,1,0,2"),
    ):
        assert row(*option)["volume"] != plain["volume"], option
        assert row(*option)["lowest_frequency"] != plain["lowest_frequency"], option
    for option in (("--no-geometric",), ("--tensions", "least"), ("--cable", "catenary"), ("--boundary-grid", "11")):
        assert row(*option)["volume"] == plain["volume"], option
        assert row(*option)["lowest_frequency"] != plain["lowest_frequency"], option
    assert not row()["sheaves"]["collide"]
    assert row("--sheave-clearance", "0.2")["sheaves"]["collide"]
    inertia = row("--inertia", "box", "--retraction", "1.4")["lowest_frequency"]["min"]
    assert inertia != row("--retraction", "1.4")["lowest_frequency"]["min"]


def test_a_sweep_continues_with_the_results_in_its_file(cli, tmp_path: Path) -> None:
    first = cli("trade", "jung2020", *VARY, *QUICK, "--json")
    assert first.json["file"] == "runs/trade-jung2020.jsonl"
    kept = (tmp_path / "runs" / "trade-jung2020.jsonl").read_bytes()
    (tmp_path / "part.jsonl").write_bytes(b"".join(kept.splitlines(keepends=True)[:4]))
    again = cli("trade", "jung2020", *VARY, *QUICK, "--out", "part.jsonl", "--json")
    assert again.json["combinations"] == first.json["combinations"]
    assert (tmp_path / "part.jsonl").read_bytes() == kept


def test_an_interrupted_sweep_says_that_it_goes_on(cli, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("cablewright.studies.trade.found_for", interrupted)
    answer = cli("trade", "jung2020", *VARY, *QUICK)
    assert answer.code == 130
    assert "runs/trade-jung2020.jsonl has the finished results; the same command resumes from there" in answer.err


def test_progress_is_reported_with_the_time_left(cli, monkeypatch: pytest.MonkeyPatch) -> None:
    seconds = iter(range(0, 100_000, 3))
    monkeypatch.setattr("cablewright.apps.cli.output.time.monotonic", lambda: float(next(seconds)))
    told = cli("trade", "jung2020", *VARY, *QUICK).err
    assert re.search(r"combinations: \d+ % of 6, \d+(/s|\.\d s each), \d+ s left", told)


def test_nothing_inside_is_a_no(cli, tmp_path: Path) -> None:
    answer = cli("trade", "jung2020", "--vary", "mass=1000,2000", *QUICK, "--plot", "t.png", "--json")
    assert answer.no == "no combination has a workspace within the box"
    assert answer.json["status"] == "empty"
    assert answer.json["combinations"][0]["lowest_frequency"]["min"] is None
    assert (answer.json["not_dominated"], answer.json["plot"]) == ([], None)
    assert not (tmp_path / "t.png").exists()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "--vary"),
        (["--vary", "mass"], "--vary = 'mass': expected NAME=FROM:TO:N"),
        (["--vary", "weight=1,2"], "unknown parameter 'weight'"),
        (["--vary", "mass=1:2"], "two numbers and how many values"),
        (["--vary", "mass=1:2:x"], "two numbers and how many values"),
        (["--vary", "mass=2:1:3"], "FROM below TO"),
        (["--vary", "mass=1:nan:3"], "FROM below TO"),
        (["--vary", "mass=1:2:1"], "2 to 10000 values"),
        (["--vary", "mass=1:2:99999999"], "2 to 10000 values"),
        (["--vary", "mass="], "numbers with commas"),
        (["--vary", "mass=heavy"], "numbers with commas"),
        (["--vary", "mass=inf"], "mass = inf: must be a finite number"),
        (["--vary", "mass=-1,2"], "mass = -1: it must be above 0"),
        (["--vary", "mass=1", "--vary", "mass=2"], "mass is varied more than once"),
        (["--vary", "mass=1:2:101", "--vary", "modulus=1:2:100"], "10100 combinations: at most 10000"),
        (["--vary", "exit_point.z@nine=1"], "unknown line 'nine'"),
        (
            ["--vary", "retraction=1:2:3"],
            "retraction = 1: retraction length 1 m: the platform of 'jung2020' retracts from",
        ),
        (["--vary", "retraction=1.5", "--retraction", "1.4"], "cannot vary while a length or a law"),
        (["--vary", "mass=1", "--retraction", "9"], "retracts from 1.2 to 2 m"),
        (["--vary", "mass=1", "--tension-limits", "9,1"], "0 <= lowest < highest"),
        (["--vary", "mass=1", "--criterion", "best"], "is not one of"),
        (["--vary", "mass=1", "--criterion", "static", "--cable", "cord"], "is not one of"),
        (["--vary", "mass=1", "--count", "cells"], "is not one of"),
        (["--vary", "mass=1", "--grid", "0"], "grid 0: 3 to 400 nodes"),
        (["--vary", "mass=1", "--boundary-grid", "500"], "grid 500: 3 to 121 nodes"),
        (["--vary", "mass=1", "--grid", "9", "--tolerance", "0.1"], "give one of them"),
        (["--vary", "mass=1", "--inertia", "ball"], "'ball' is not one of"),
        (["--vary", "mass=1", "--sheave-clearance", "-1"], "must be at least 0 m"),
        (["--vary", "mass=1", "--tensions", "high"], "'high' is not one of"),
        (["--vary", "mass=1", "--orientations", "0,0,4"], "at most pi (180 degrees)"),
        (["--vary", "mass=1", "--plot", "t.jpg"], "a name that ends in .png"),
    ],
)
def test_bad_input_is_rejected(cli, arguments: list[str], says: str, tmp_path: Path) -> None:
    assert says in cli("trade", "jung2020", *arguments).refusal
    assert list(tmp_path.iterdir()) == []


def test_a_file_of_something_else_is_not_overwritten(cli, tmp_path: Path) -> None:
    (tmp_path / "mine.json").write_text("{}")
    assert "holds no results of a study" in cli("trade", "jung2020", *VARY, "--out", "mine.json").refusal
    assert (tmp_path / "mine.json").read_text() == "{}"
