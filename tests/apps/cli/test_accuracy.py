"""`accuracy` on the command line: its JSON, its run folders, what it rejects."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest

P1 = ("accuracy", "paty2021", "--at", "0,0,0", "--json")
HOUSE = ("accuracy", "house-printer")


def test_one_place_has_the_keys_of_the_contract(cli) -> None:
    found = cli(*P1).json
    assert found["status"] == "ok"
    assert found["difference"] == pytest.approx(found["max_error"] - found["nominal_error"])
    assert found["max_error_factors"] == [0.7] * 4
    assert len(found["vertices"]) == 16
    worst = max(found["vertices"], key=lambda corner: corner["error"])
    assert worst["error"] == pytest.approx(found["max_error"], rel=1e-9)
    assert worst["values"] == found["max_error_factors"]
    assert found["interior"]["corner_is_worst"]
    assert [each["compensation"] for each in found["remains"]] == ["none", "elastic", "eyelets", "full"]
    assert found["best_tension"]["max_deviation"] <= found["best_tension"]["min_norm_max_deviation"]
    assert found["hull_volume"] == pytest.approx(1.97e-6, rel=5e-3)


def test_the_same_twice_and_a_seed_is_an_argument(cli) -> None:
    sampled = (*HOUSE, "--at", "1,2,3", "--method", "monte-carlo", "--samples", "2000", "--json")
    first, again, other = cli(*sampled), cli(*sampled), cli(*sampled, "--seed", "1")
    assert first.out == again.out
    assert first.json["max_error"] != other.json["max_error"]
    assert first.json["likely_error"] < first.json["max_error"]


def test_a_home_removes_the_error_there(cli) -> None:
    found = cli(*HOUSE, "--at", "1,2,3", "--home", "1,2,3", "--json").json
    assert found["nominal_error"] < 1e-9


@pytest.mark.slow  # bodies are in analyses/accuracy, such files below
def test_a_rigid_body_with_an_uncertainty_file(cli, tmp_path: Path) -> None:
    file = tmp_path / "known.toml"
    file.write_text(
        'schema = 1\n[[parameters]]\nname = "platform_point"\nplus_minus = "1 mm"\n'
        '[[parameters]]\nname = "mass"\nfactor = [0.9, 1.1]\n'
    )
    found = cli("accuracy", "cogiro", "--at", "1,1,1", "--uncertainty", str(file), "--method", "first-order", "--json")
    assert len(found.json["parameters"]) == 25
    assert "max_error_factors" not in found.json
    assert found.json["max_turn"] > 0


@pytest.mark.usefixtures("undrawn_here")
@pytest.mark.parametrize(
    ("shape", "places"),
    [
        (("--plane", "0", "--half-width", "6", "--step", "3"), 25),
        (("--helix", "3,2,0,4", "--step", "2"), 20),
        (("--workspace", "--step", "3"), 80),
    ],
    ids=lambda value: value[0] if isinstance(value, tuple) else "",
)
def test_a_shape_leaves_a_run_folder(cli, tmp_path: Path, shape: tuple[str, ...], places: int) -> None:
    found = cli(*HOUSE, *shape, "--out", str(tmp_path / "run"), "--json").json
    table = pyarrow.parquet.read_table(tmp_path / "run" / "places.parquet").to_pydict()
    assert found["answered"] == places
    assert np.nanmax(table["max_error"]) == found["max_error"]
    assert (tmp_path / "run" / "report.html").stat().st_size > 10_000
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text())
    assert manifest["command"] == "accuracy"
    assert manifest["options"]["compensation"] == "none"


@pytest.mark.usefixtures("undrawn_here")
def test_along_a_job(cli, tmp_path: Path) -> None:
    (tmp_path / "part.gcode").write_text("G21\nG90\nM83\nG1 Z1000\nG1 X500\nG1 X500 Y500 E5\n")
    found = cli(*HOUSE, "--path", str(tmp_path / "part.gcode"), "--out", str(tmp_path / "run"), "--json").json
    assert found["shape"] == "path"
    assert found["answered"] == found["places"] > 10


@pytest.mark.slow  # in running/executors/test_shared_spread.py
@pytest.mark.usefixtures("undrawn_here")
def test_workers_give_the_same_and_what_they_kept_goes_with_the_answer(cli, tmp_path: Path) -> None:
    shape = ("--plane", "2", "--step", "4", "--json")
    alone = cli(*HOUSE, *shape, "--out", str(tmp_path / "alone")).json
    shared = cli(*HOUSE, *shape, "--out", str(tmp_path / "shared"), "--workers", "2").json
    del alone["report"], shared["report"]
    assert shared == alone
    assert sorted(each.name for each in tmp_path.iterdir()) == ["alone", "shared"]
    refused = cli(*HOUSE, "--at", "0,0,1", "--workers", "2")
    assert (refused.code, refused.err) == (
        2,
        "cablewright: --workers and --cluster: leave them out for a single pose (--at); they are for many positions\n",
    )


@pytest.mark.usefixtures("undrawn_here")
def test_places_beyond_the_limits_are_counted(cli, tmp_path: Path) -> None:
    arguments = (
        "accuracy",
        "paty2021",
        "--plane",
        "0",
        "--half-width",
        "6",
        "--step",
        "1",
        "--out",
        str(tmp_path / "run"),
    )
    found = cli(*arguments, "--json").json
    assert found["refused"]["infeasible"] == found["places"] - found["answered"] > 0


@pytest.mark.parametrize("arguments", [("--at", "6,6,0"), ("--plane", "0", "--tension-limits", "3000,5000")])
def test_a_no_is_one_object_and_exit_1(cli, tmp_path: Path, arguments: tuple[str, ...]) -> None:
    answer = cli("accuracy", "paty2021", *arguments, "--out", str(tmp_path / "run"), "--json")
    assert answer.json["status"] == "refused"
    assert "no tensions within the limits" in answer.no
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ((), "expected one of --at, --helix, --path, --plane and --workspace; got none"),
        (("--at", "0,0,0", "--plane", "0"), "got --at and --plane"),
        (("--at", "0,0,0", "--modulus-range", "1.3,0.7"), "modulus range 1.3 to 0.7"),
        (("--at", "0,0,0", "--modulus-range", "0,1"), "modulus range 0 to 1"),
        (("--at", "0,0,0", "--modulus-range", "1"), "expected 2 finite numbers"),
        (("--at", "0,0,0", "--modulus-range", "1,2", "--uncertainty", "x.toml"), "give one of them"),
        (("--at", "0,0,0", "--uncertainty", "nowhere.toml"), "nowhere.toml: no such file"),
        (("--at", "0,0"), "3 numbers are expected"),
        (("--at", "0,0,0", "--method", "vertex"), "is not one of 'vertices', 'first-order', 'monte-carlo'"),
        (("--at", "0,0,0", "--compensation", "ful"), "is not one of 'none', 'elastic', 'eyelets', 'full'"),
        (("--at", "0,0,0", "--step", "1"), "--step does not go with --at"),
        (("--at", "0,0,0", "--method", "monte-carlo", "--samples", "5"), "samples = 5"),
        (("--at", "0,0,0", "--home", "99,0,0"), "home: "),
        (("--plane", "16"), "the frame of house-printer is from 0 to 15 m high"),
        (("--plane", "nan"), "plane at nan m"),
        (("--plane", "0", "--half-width", "8"), "allows at most 7.5 m"),
        (("--plane", "0", "--step", "0"), "step 0 m"),
        (("--plane", "0", "--step", "1e-5"), "take a larger step"),
        (("--plane", "0", "--half-width", "-1"), "half-width -1 m"),
        (("--helix", "1,2,3"), "expected 4 finite numbers"),
        (("--helix", "9,1,0,10"), "helix radius 9 m"),
        (("--helix", "1,1,10,0"), "Z0 < Z1"),
        (("--helix", "1,1,0,20"), "helix at 20 m"),
        (("--workspace", "--step", "0"), "step 0 m"),
        (("--workspace", "--half-width", "1"), "--half-width does not go with --workspace"),
        (("--workspace", "--step", "0.001"), "nodes; at most"),
        (("--path", "nowhere.toml"), "nowhere.toml: no such file"),
    ],
)
def test_bad_input_is_one_line(cli, arguments: tuple[str, ...], told: str) -> None:
    assert told in cli(*HOUSE, *arguments).refusal


def test_an_unknown_parameter_names_the_nearest(cli, tmp_path: Path) -> None:
    file = tmp_path / "known.toml"
    file.write_text('schema = 1\n[[parameters]]\nname = "modulos"\nfactor = [0.9, 1.1]\n')
    line = cli(*HOUSE, "--at", "0,0,0", "--uncertainty", str(file)).refusal
    assert "did you mean 'modulus'" in line
    assert "known.toml" in line


@pytest.mark.usefixtures("undrawn_here")
def test_the_report_states_the_request(cli, tmp_path: Path) -> None:
    cli(*HOUSE, "--at", "3,2,1", "--home", "0,0,1", "--tension-limits", "50,5000", "--out", str(tmp_path / "run"))
    page = (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
    assert "<td>zeroed at</td><td>0,0,1</td>" in page
    assert "<td>50,5000</td>" in page


def test_without_an_equilibrium_at_any_corner_there_is_no_answer(cli, tmp_path: Path) -> None:
    file = tmp_path / "heavy.toml"
    file.write_text('schema = 1\n[[parameters]]\nname = "mass"\nrange = ["50 t", "60 t"]\n')
    answer = cli(*HOUSE, "--at", "3,2,1", "--uncertainty", str(file), "--json")
    assert answer.json["status"] == "refused"
    assert "at this pose no set of parameter values has an equilibrium" in answer.no


def test_another_controllers_failure_is_not_the_answer(cli) -> None:
    """At this pose the lengths of a model without sheaves break a line; the requested ones do not."""
    found = cli("accuracy", "wang2021", "--at", "0,0,1", "--json").json
    assert [each["compensation"] for each in found["remains"]] == ["none", "elastic", "full"]


@pytest.mark.parametrize("arguments", [("--seed", "-1"), ("--samples", "1000"), ("--home", "0,0")])
def test_more_bad_input(cli, arguments: tuple[str, ...]) -> None:
    assert arguments[0].lstrip("-") in cli(*HOUSE, "--at", "0,0,1", *arguments).refusal
