"""`workspace` and `retraction`: the contract's JSON, tables, files, a no, and bad input."""

from __future__ import annotations

import re
import struct

import pytest

from cablewright.analyses.workspace.best_retraction import retraction
from cablewright.analyses.workspace.workspace import count_nodes, workspace
from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import load
from cases import some

JUNG = Model(load("jung2020"), Fidelity.of("rigid"))
FAST = ("--grid", "9")
ONE_LINE = """
schema = 1
name = "one line"
[scene]
frame_min = [-1.0, -1.0, 0.0]
frame_max = [1.0, 1.0, 2.0]
[platform]
mass = 1.0
[[lines]]
name = "1"
exit_point = [0.0, 0.0, 2.0]
tension_limits = [0.0, 100.0]
cable = { axial_stiffness = 1e5, linear_density = 0.0, breaking_load = 1e3 }
sheave = { kind = "eyelet" }
"""
KEYS = {
    "schema",
    "status",
    "robot",
    "criterion",
    "cable",
    "sheave",
    "point",
    "orientations",
    "retraction",
    "retraction_law",
    "wrench_box",
    "count",
    "box",
    "volume",
    "volume_error",
    "fraction",
    "nodes",
    "slices",
}
OF_VOLUMES = {"unseen", "cells", "surface_area", "mesh", "plot"}


@pytest.mark.parametrize(
    "criterion", some(["closed-form", "exact", "wrench-closure", "improved-closed-form", "capacity"], 3)
)
def test_a_volume_is_that_of_the_analysis(cli, criterion: str) -> None:
    answer = cli("workspace", "jung2020", "--criterion", criterion, "--tolerance", "0.02", "--json")
    assert (answer.code, answer.err) == (0, "")
    found, own = answer.json, workspace(JUNG, criterion, tolerance=0.02)
    assert found.keys() == KEYS | OF_VOLUMES
    assert (found["status"], found["criterion"], found["cable"]) == ("ok", criterion, "rigid")
    assert (found["volume"], found["volume_error"]) == (own.volume, own.volume_error)
    assert found["fraction"] == own.volume / 8.0
    assert found["nodes"] == own.nodes
    assert found["box"] == [[-1.0, -1.0, 0.0], [1.0, 1.0, 2.0]]
    assert found["slices"]["areas"] == own.slices(found["slices"]["heights"]).tolist()


def test_nodes_are_counted_as_the_paper_does(cli) -> None:
    answer = cli("workspace", "jung2020-table1", "--criterion", "closed-form", "--count", "nodes", "--json")
    found = answer.json
    assert found.keys() == KEYS | {"counted"}
    assert found["nodes"] == 41**3
    assert found["fraction"] == found["counted"] / 41**3 == pytest.approx(0.371, abs=5e-4)
    assert found["volume"] == pytest.approx(2.968, abs=5e-4)
    assert len(found["slices"]["areas"]) == 41
    own = count_nodes(JUNG, "exact", grid=7)
    assert cli("workspace", "jung2020", "--count", "nodes", "--grid", "7", "--json").json["counted"] == own.counted


@pytest.mark.slow  # as other volumes, above
def test_static_is_with_sag(cli) -> None:
    found = cli("workspace", "jung2020", "--criterion", "static", *FAST, "--json").json
    assert (found["cable"], found["status"]) == ("catenary", "ok")
    assert found["volume"] == workspace(Model(load("jung2020")), "static", grid=9).volume


def test_options_reach_the_analysis(cli) -> None:
    plain = cli("workspace", "jung2020", *FAST, "--json").json["volume"]
    for option in (
        ("--retraction", "1.4"),
        ("--retraction-law=-1,2.4,1.2,2",),
        ("--wrench", "0,0,-100"),
        ("--tension-limits", "50,200"),
        ("--orientations", "0,0,0;0.1,0,0"),
        ("--box", "0,1,0,1,0,2"),
    ):
        answer = cli("workspace", "jung2020", *FAST, *option, "--json")
        assert answer.json["volume"] != pytest.approx(plain, rel=1e-3), option
        assert answer.json["volume"] > 0.0, option
    told = cli("workspace", "jung2020", *FAST, "--retraction-law=-1,2.4,1.2,2", "--point", "origin", "--json").json
    assert told["retraction_law"] == {"slope": -1.0, "intercept": 2.4, "least": 1.2, "most": 2.0, "of": "origin"}
    assert told["point"] == "origin"
    box = cli("workspace", "jung2020", *FAST, "--criterion", "capacity", "--wrench-box=-9,9,-9,9,-9,0", "--json").json
    assert box["wrench_box"] == [[-9.0, -9.0, -9.0, 0, 0, 0], [9.0, 9.0, 0.0, 0, 0, 0]]
    assert 0 < box["volume"] < plain


def test_workers_give_the_same_and_leave_nothing(cli, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    asked = ("workspace", "jung2020", *FAST, "--json")
    assert cli(*asked, "--workers", "2").json == cli(*asked).json
    assert not list(tmp_path.iterdir())


def test_people_get_a_table(cli) -> None:
    answer = cli("workspace", "jung2020", *FAST)
    assert [answer.figure(label) for label in ("robot", "criterion", "point")] == ["jung2020", "exact", "nozzle"]
    assert re.fullmatch(r"4\.\d+ m\^3", answer.figure("volume"))
    assert answer.figure("share of the box").endswith(" %")
    at = answer.rows.index(["height, m", "area, m^2"])
    assert len(answer.rows) == at + 1 + 21
    answer = cli("workspace", "jung2020", "--count", "nodes", "--grid", "11")
    assert (answer.figure("nodes"), int(answer.figure("counted")) > 0) == ("1331", True)


def test_files_are_written(cli, tmp_path) -> None:
    for name, begins in (("a.stl", b"cablewright"), ("b.glb", b"glTF")):
        answer = cli("workspace", "jung2020", *FAST, "--mesh", tmp_path / name, "--json")
        assert answer.json["mesh"] == str(tmp_path / name)
        assert (tmp_path / name).read_bytes().startswith(begins)
    raw = (tmp_path / "a.stl").read_bytes()
    assert len(raw) == 84 + 50 * struct.unpack_from("<I", raw, 80)[0]
    answer = cli("workspace", "jung2020", *FAST, "--plot", tmp_path / "c.png", "--retraction-law=-1,2.4,1.2,2")
    assert answer.code == 0
    assert answer.figure("plot") == str(tmp_path / "c.png")
    assert (tmp_path / "c.png").read_bytes().startswith(b"\x89PNG")
    assert cli("workspace", "jung2020", *FAST, "--mesh", tmp_path / "no" / "a.stl").code == 3


def test_an_empty_workspace_is_a_no(cli, tmp_path) -> None:
    nowhere = ("--box", "5,6,5,6,5,6")
    answer = cli(
        "workspace", "jung2020", *nowhere, "--mesh", tmp_path / "a.glb", "--plot", tmp_path / "a.png", "--json"
    )
    assert answer.no == "no place in the box was found inside"
    assert (answer.json["status"], answer.json["volume"], answer.json["mesh"]) == ("empty", 0.0, None)
    assert list(tmp_path.iterdir()) == []
    counted = cli("workspace", "jung2020", *nowhere, "--count", "nodes", "--grid", "5", "--json")
    assert "no place" in counted.no


def test_a_volume_that_does_not_converge_is_a_no(cli, tmp_path) -> None:
    """One line holds its point straight below: the workspace has no thickness."""
    (tmp_path / "one.toml").write_text(ONE_LINE)
    answer = cli("workspace", tmp_path / "one.toml", "--json")
    assert "give a larger --tolerance, or a smaller --box" in answer.no
    assert answer.json["status"] == "not-converged"
    assert answer.json["volume"] <= answer.json["volume_error"] < 1e-4


def test_progress_is_reported_after_two_seconds(cli, monkeypatch) -> None:
    seconds = iter(range(100_000))
    monkeypatch.setattr("time.monotonic", lambda: float(next(seconds)))
    told = cli("workspace", "jung2020", "--grid", "60", "--count", "nodes").err
    assert re.search(r"nodes: \d+ % of 216000, \d+/s, \d+ s left", told)
    assert cli("workspace", "jung2020", "--tolerance", "0.005").code == 0


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--criterion", "closed"], "'closed' is not one of 'closed-form'"),
        (["--count", "cells"], "'cells' is not one of 'volume', 'nodes'"),
        (["--grid", "0"], "grid 0: 3 to 400 nodes"),
        (["--grid", "-5", "--count", "nodes"], "grid -5"),
        (["--grid", "many"], "--grid"),
        (["--grid", "9", "--tolerance", "0.1"], "give one of them"),
        (["--tolerance", "2"], "tolerance 2"),
        (["--tolerance", "0.1", "--count", "nodes"], "--tolerance is not for --count nodes"),
        (["--tension-limits", "200,10"], "0 <= lowest < highest"),
        (["--tension-limits", "20,20"], "0 <= lowest < highest"),
        (["--orientations", "0,0,3.5"], "at most pi (180 degrees)"),
        (["--orientations", "0,0,0;0,-4,0"], "rotation of 4 rad"),
        (["--orientations", "0,0"], "orientations: 3 numbers"),
        (["--orientations", "up"], "--orientations = 'up'"),
        (["--orientations", "0,0,0;0,0"], "orientations"),
        (["--box", "0,1,0,1"], "box: 6 finite numbers"),
        (["--box", "1,0,0,1,0,1"], "x from 1 to 0 m"),
        (["--point", "tip"], "'tip' is not one of"),
        (["--retraction", "3"], "retracts from 1.2 to 2 m"),
        (["--retraction", "1.5", "--retraction-law", "0,1.5"], "give one of them"),
        (["--retraction-law=-1,2.4"], "leaves its range at height 0 m"),
        (["--retraction-law", "1"], "expected C,D"),
        (["--retraction-law=-1,2.4,1,2"], "retracts from 1.2 to 2 m"),
        (["--retraction-law=-1,2.4,2,1.2"], "least < most"),
        (["--wrench-box", "1,2"], "expected 6 numbers"),
        (["--wrench-box", "0,1,0,1,0,1"], "for the criterion capacity"),
        (["--criterion", "capacity", "--wrench-box", "1,0,0,1,0,1"], "lowest <= highest"),
        (["--criterion", "exact", "--cable", "catenary"], "requires straight lines"),
        (["--seed", "-1"], "seed -1"),
        (["--retraction-law", "nan,1,1.2,2"], "finite numbers"),
        (["--retraction-law", "0,1,nan,2"], "least < most"),
        (["--box", "0,1,0,1,0,nan"], "6 finite numbers"),
        (["--criterion", "capacity", "--arm", "nan"], "a positive number is expected"),
        (["--wrench", "1,2"], "expected 3 numbers"),
        (["--mesh", "a.obj"], "a name that ends in .stl or .glb"),
        (["--plot", "a.jpg"], "a name that ends in .png"),
        (["--count", "nodes", "--mesh", "a.stl"], "needs the surface of the workspace"),
        (["--count", "nodes", "--report", "a.html"], "--report needs the surface"),
    ],
)
def test_bad_input_is_rejected(cli, arguments: list[str], says: str) -> None:
    assert says in cli("workspace", "jung2020", *arguments).refusal


RETRACTION = {
    "schema",
    "status",
    "robot",
    "criterion",
    "cable",
    "point",
    "box",
    "lengths",
    "heights",
    "areas",
    "volumes",
    "best_lengths",
    "best_areas",
    "best_volume",
    "law",
    "law_volume",
    "law_volume_error",
    "law_share",
    "plot",
}
QUICK = ("--steps", "3", "--heights", "10", "--tolerance", "0.02", "--from", "1.2", "--to", "2.0")


@pytest.mark.slow  # analyses/test_retraction.py has the table, test_figures.py the keys
def test_retraction_is_that_of_the_analysis(cli, tmp_path) -> None:
    answer = cli("retraction", "jung2020", *QUICK, "--plot", tmp_path / "r.png", "--json")
    assert answer.code == 0
    found = answer.json
    own = retraction(JUNG, steps=3, heights=10, tolerance=0.02)
    assert found.keys() == RETRACTION
    assert found["areas"] == own.areas.tolist()
    assert found["law"]["slope"] == own.law.slope
    assert found["law"]["fitted_heights"] == own.heights[own.fitted].tolist()
    assert found["law_share"] == own.share
    assert (tmp_path / "r.png").read_bytes().startswith(b"\x89PNG")
    out = cli("retraction", "jung2020", *QUICK).out
    assert "slope " in out
    assert "law share " in out


def test_what_no_length_reaches_is_a_no(cli) -> None:
    answer = cli("retraction", "jung2020", *QUICK, "--box", "0,1,0,1,7,8", "--json")
    assert "no law can be fitted" in answer.no
    assert answer.json["status"] == "refused"


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["jung2020", "--from", "1"], "retracts from 1.2 to 2 m"),
        (["jung2020", "--from", "1.8", "--to", "1.4"], "rising lengths"),
        (["jung2020", "--steps", "1"], "steps = 1"),
        (["house-printer"], "has no retraction"),
        (["jung2020", "--criterion", "none"], "is not one of"),
        (["jung2020", "--plot", "r.jpg"], ".png"),
        (["jung2020", "--tension-limits", "5,1"], "0 <= lowest < highest"),
    ],
)
def test_bad_retraction_is_rejected(cli, arguments: list[str], says: str) -> None:
    assert says in cli("retraction", *arguments).refusal


PLANAR = """schema = 1
name = "flat"
[scene]
frame_min = [-2, -1, 0]
frame_max = [2, 1, 3]
[platform]
mass = "4 kg"
[cable]
axial_stiffness = "100 kN"
linear_density = "0 kg/m"
breaking_load = "10 kN"
[sheave]
kind = "eyelet"
[line]
tension_limits = ["0 N", "5 kN"]
[[lines]]
name = "left"
exit_point = [-2, 0, 3]
[[lines]]
name = "right"
exit_point = [2, 0, 3]
"""


def test_a_planar_robot_has_an_area(cli, tmp_path) -> None:
    file = tmp_path / "flat.toml"
    file.write_text(PLANAR)
    found = cli("workspace", file, "--plot", tmp_path / "flat.png", "--json").json
    assert (found["status"], found["count"], found["normal"]) == ("ok", "area", "y")
    assert found["area"] == pytest.approx(12.0, abs=0.03)  # tensions are too high just below the exit points
    assert {len(point) for outline in found["outlines"] for point in outline} == {3}
    assert (tmp_path / "flat.png").exists()
    assert (
        "--mesh: the workspace of a planar robot is an area"
        in cli("workspace", file, "--mesh", tmp_path / "a.stl").refusal
    )
    assert (
        "--count nodes: the workspace of a planar robot is an area"
        in cli("workspace", file, "--count", "nodes").refusal
    )


def test_a_sheave_that_is_left_out_needs_nothing(cli, tmp_path) -> None:
    """A universal joint without a winch exit cannot be solved as built, but as an eyelet."""
    joint = (
        'kind = "universal-joint"\nradius = "20 mm"\nlever = "30 mm"\nlever_weight = "1 N"\nlever_mass_centre = "10 mm"'
    )
    file = tmp_path / "joints.toml"
    file.write_text(PLANAR.replace('kind = "eyelet"', joint))
    assert cli("workspace", file, "--sheave", "eyelet", "--json").json["status"] == "ok"
