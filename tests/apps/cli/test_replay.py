from __future__ import annotations

import re
from pathlib import Path

import pytest

SOME = ["simulate", "merlet2023", "--loop", "28", "--seed", 2]


@pytest.fixture
def log(cli, tmp_path: Path) -> Path:
    out = tmp_path / "run.mcap"
    assert cli(*SOME, "--duration", 6, "--out", out).code == 0
    return out


def test_a_log_is_replayed_and_summed_up(cli, log: Path, tmp_path: Path) -> None:
    plot = tmp_path / "run.png"
    answer = cli("replay", log, "--plot", plot, "--json")
    assert answer.code == 0
    values = answer.json
    assert values["status"] == "ok"
    assert values["steps"] == 600
    assert values["moving"]["position"]["max"] < 0.02
    assert values["slack"]["steps"] == 0 or values["slack"]["named_share"] > 0.98
    assert len(values["taut_share"]) == 4
    assert values["radius"]["within_1_percent"] is None
    assert values["faults"] == values["notes"] == []
    assert plot.read_bytes().startswith(b"\x89PNG")


def test_a_run_folder_is_replayed_as_its_log(cli, log: Path, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    folder.mkdir()
    log.rename(folder / "log-000.mcap")
    values = cli("replay", folder, "--json").json
    assert values["steps"] == 600
    assert values["notes"] == []


def test_the_result_is_printed_as_text(cli, log: Path) -> None:
    answer = cli("replay", log)
    assert answer.code == 0
    shown = dict(re.split(r"  +", line, maxsplit=1) for line in answer.out.splitlines() if "  " in line)
    assert (shown["duration"], shown["plant"], shown["seed"]) == ("6.000 s", "dynamic", "2")
    assert shown["estimator"] == "paper"
    assert "position errors while the drum moves\n            rms, mm  95 %, mm  max, mm\nin space" in answer.out
    assert "processor time of a step\nmean" in answer.out


@pytest.mark.slow  # both are in live/test_replay.py
def test_both_estimators_stand_side_by_side(cli, log: Path, tmp_path: Path) -> None:
    plot = tmp_path / "both.png"
    answer = cli("replay", log, "--estimator", "both", "--plot", plot, "--json")
    assert answer.code == 0
    values = answer.json
    assert values["status"] == "ok"
    assert set(values["estimators"]) == {"paper", "filter"}
    paper, error_state = values["estimators"]["paper"], values["estimators"]["filter"]
    assert paper["coverage"] is None
    assert 0.5 < error_state["coverage"] <= 1.0
    assert 0.0 < error_state["nees"] < 10.0
    assert error_state["moving"]["position"]["rms"] < paper["moving"]["position"]["rms"]
    assert plot.read_bytes().startswith(b"\x89PNG")
    told = cli("replay", log, "--estimator", "both").out
    rows = [re.split(r"  +", line.strip()) for line in told.splitlines()]
    assert ["paper", "filter"] in rows
    assert ["estimator", "paper", "filter"] in rows
    assert [row[:2] for row in rows if "in space" in row] == [["paper", "in space"], ["filter", "in space"]]
    (covered,) = [row for row in rows if row[0] == "positions within their 95 % ellipsoid"]
    assert covered[1] == "-"
    assert covered[2].endswith("%")


def test_faults_and_cuts_are_reported(cli, tmp_path: Path) -> None:
    out = tmp_path / "run.mcap"
    faults = ["--fault", "north,0,100", "--fault", "south,0,100"]
    assert cli(*SOME, "--duration", 6, *faults, "--out", out).code == 0
    out.write_bytes(out.read_bytes()[:-5000])
    answer = cli("replay", out)
    assert answer.code == 1
    assert re.search(r"^north +no reading for over 2.5 s +", answer.out, re.MULTILINE)
    assert "cut or damaged" in answer.err
    assert "no step of the log has a valid estimate" in answer.err


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--estimator", "magic"], "--estimator"),
        (["--laser", "east"], "expected WALL=DISTANCE"),
        (["--laser", "moon=1"], "no wall 'moon'"),
        (["--plot", "a.gif"], "--plot"),
    ],
)
def test_bad_input_is_one_line(cli, log: Path, more: list[str], said: str) -> None:
    answer = cli("replay", log, *more)
    assert answer.code == 2
    assert said in answer.err.strip().splitlines()[-1]


def test_what_is_no_log_is_rejected(cli, tmp_path: Path) -> None:
    file = tmp_path / "no.mcap"
    file.write_bytes(b"nothing")
    assert cli("replay", file).code == 2
