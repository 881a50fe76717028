"""`modes`: the contract's JSON, the table for people, and what becomes of a pose that cannot be held."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from cablewright.analyses.modes import FREEDOMS, modes
from cablewright.analyses.workspace.boundary_frequencies import boundary_modes
from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import library_text, load
from cablewright.studies.measured_modes import MeasuredModes

KEYS = {
    "schema",
    "status",
    "robot",
    "cable",
    "sheave",
    "pose",
    "lengths",
    "tensions",
    "lines",
    "notes",
    "freedoms",
    "counts_geometric",
    "frequencies",
    "dominant",
    "participation",
    "shapes",
    "stiffness",
    "elastic",
    "geometric",
    "axial_stiffness",
    "line_frequencies",
    "asymmetry",
    "damping",
    "damping_assumed",
    "elastic_share",
    "motion",
    "plot",
}
OF_BOUNDARIES = {
    "criterion",
    "point",
    "orientations",
    "retraction",
    "retraction_law",
    "wrench_box",
    "boundary",
}
AT = ("--at", "0.2,0.1,0.9")


@pytest.mark.parametrize("cable", ["rigid", "elastic", "catenary"])
@pytest.mark.parametrize("option", [(), ("--no-geometric",)])
def test_modes_prints_what_the_analysis_finds(cli, cable: str, option: tuple[str, ...]) -> None:
    answer = cli("modes", "jung2020", *AT, "--cable", cable, *option, "--json")
    assert answer.code == 0
    found = answer.json
    assert found.keys() == KEYS
    assert found["status"] == "ok"
    assert found["counts_geometric"] == (option == ())
    solved = modes(Model(load("jung2020"), Fidelity.of(cable)), [0.2, 0.1, 0.9], geometric=option == ())
    assert found["frequencies"] == solved.frequencies.tolist()
    assert found["dominant"] == [FREEDOMS[k] for k in solved.dominant]
    assert found["participation"] == solved.participation.T.tolist()  # a row for each mode
    assert found["shapes"] == solved.shapes.T.tolist()
    assert found["tensions"] == solved.equilibrium.tensions.tolist()
    np.testing.assert_allclose(np.add(found["elastic"], found["geometric"]), found["stiffness"], rtol=1e-12)
    assert found["axial_stiffness"] == solved.stiffness.axial.tolist()
    assert found["line_frequencies"] == solved.line_frequencies.tolist()


def test_tension_stiffens_the_beam_against_turning_about_z(cli) -> None:
    whole = cli("modes", "jung2020", *AT, "--json").json
    paper = cli("modes", "jung2020", *AT, "--no-geometric", "--json").json
    assert whole["dominant"][0] == paper["dominant"][0] == "rz"
    assert whole["frequencies"][0] > 2 * paper["frequencies"][0]
    assert whole["stiffness"] == paper["stiffness"]


def test_options_reach_the_solver(cli) -> None:
    plain = cli("modes", "jung2020", *AT, "--json").json["frequencies"]
    for option in (
        ("--retraction", "1.4"),
        ("--wrench", "0,0,-50"),
        ("--tension-limits", "50,200"),
    ):
        other = cli("modes", "jung2020", *AT, *option, "--json").json["frequencies"]
        assert other[0] != pytest.approx(plain[0], rel=1e-3)


def test_people_get_a_table(cli) -> None:
    answer = cli("modes", "jung2020", *AT)
    assert (answer.code, answer.figure("status")) == (0, "ok")
    first = answer.rows[-6]
    assert first[1] == "rz"
    assert sum(map(float, first[2].split(", "))) == pytest.approx(100, abs=0.4)
    assert "lines vibrate sideways from 18.65 Hz" in answer.err
    assert answer.figure("counts geometric") == "yes"
    assert cli("modes", "jung2020", *AT, "--no-geometric").figure("counts geometric") == "no"


def test_a_pose_out_of_its_limits_has_modes_and_is_a_no(cli) -> None:
    answer = cli("modes", "house-printer", "--at", "0,0,14.9", "--json")
    assert "above its maximum, 5150 N" in answer.no
    assert answer.json["status"] == "infeasible"
    assert len(answer.json["frequencies"]) == 3


def test_a_pose_that_nothing_balances_has_none(cli) -> None:
    answer = cli("modes", "house-printer", "--at", "0,0,20", "--json")
    assert "a line would have to push" in answer.no
    assert answer.json.keys() == KEYS
    assert answer.json["frequencies"] is None
    assert cli("modes", "house-printer", "--at", "0,0,20").figure("status") == "infeasible"


def test_a_platform_on_its_head_is_a_no_with_a_negative_frequency(cli, tmp_path) -> None:
    text = library_text("cogiro").replace("centre_of_mass = [-0.034, -0.013, 0.264]", "centre_of_mass = [0, 0, 150.0]")
    (tmp_path / "tall.toml").write_text(text)
    answer = cli("modes", tmp_path / "tall.toml", "--at", "0,0,1", "--json")
    assert answer.json["status"] == "unstable"
    assert answer.json["frequencies"][0] < 0
    assert "would leave this pose" in answer.no
    assert cli("modes", tmp_path / "tall.toml", "--at", "0,0,1").figure("status") == "unstable"


@pytest.mark.parametrize(("robot", "at"), [("jung2020", "0.2,0.1,0.9"), ("house-printer", "0,0,1")])
def test_a_picture_is_written(cli, tmp_path, robot: str, at: str) -> None:
    file = tmp_path / "modes.png"
    answer = cli("modes", robot, "--at", at, "--plot", file, "--json")
    assert (answer.code, answer.json["plot"]) == (0, str(file))
    assert file.read_bytes().startswith(b"\x89PNG")
    assert sorted(each.name for each in tmp_path.iterdir()) == ["modes.png", "modes.png.csv"]
    nowhere = cli("modes", robot, "--at", at, "--plot", tmp_path / "no" / "modes.png")
    assert nowhere.code == 3
    assert cli("modes", robot, "--at", "0,0,90", "--plot", tmp_path / "b.png", "--json").json["plot"] is None
    assert not (tmp_path / "b.png").exists()


@pytest.mark.parametrize("at", ["0,0,1", "5,5,5"])
def test_a_body_of_unknown_inertia_is_rejected(cli, tmp_path, at: str) -> None:
    lines = library_text("cogiro").splitlines()
    (tmp_path / "bare.toml").write_text("\n".join(line for line in lines if not line.startswith("inertia")))
    assert "platform.inertia is required" in cli("modes", tmp_path / "bare.toml", "--at", at).refusal


def test_along_the_boundary(cli, tmp_path) -> None:
    given = ("--boundary", "--criterion", "closed-form", "--grid", "11", "--no-geometric")
    answer = cli("modes", "jung2020", *given, "--plot", tmp_path / "b.png", "--json")
    assert answer.code == 0
    found, own = answer.json, boundary_modes(Model(load("jung2020")), "closed-form", grid=11, geometric=False)
    assert found.keys() == KEYS | OF_BOUNDARIES
    assert (found["criterion"], found["cable"], found["counts_geometric"]) == ("closed-form", "catenary", False)
    told = found["boundary"]
    assert (told["min"], told["median"], told["max"]) == own.spread
    assert (told["n"], told["unheld"], told["out_of_limits"]) == (len(own.lowest), 0, 0)
    assert (told["grid"], told["tensions"]) == (11, "middle")
    assert (told["shares"], told["dominant"]) == (own.shares, "rz")
    assert told["worst_pose"] == found["pose"] == own.modes.equilibrium.pose[own.worst].tolist()
    assert found["frequencies"][0] == pytest.approx(told["min"], rel=1e-12)
    assert (tmp_path / "b.png").read_bytes().startswith(b"\x89PNG")
    text = cli("modes", "jung2020", *given)
    assert re.fullmatch(r"1\.\d+ Hz", text.figure("min"))
    assert re.fullmatch(r"2\.\d+ Hz", text.figure("max"))
    assert (text.figure("criterion"), text.figure("mostly"), text.figure("counts geometric")) == (
        "closed-form",
        "rz",
        "no",
    )


def test_options_reach_the_boundary(cli) -> None:
    def told(*options: str) -> dict:
        return cli("modes", "jung2020", "--boundary", "--grid", "7", *options, "--json").json["boundary"]

    plain = told()
    for option in (
        ("--criterion", "closed-form"),
        ("--tensions", "middle"),
        ("--box", "0,1,0,1,0,2"),
        ("--orientations", "0,0,0;0.1,0,0"),
        ("--retraction", "1.4"),
        ("--retraction-law=-1,2.4,1.2,2",),
        ("--tension-limits", "20,100"),
        ("--wrench", "0,0,-50"),
        ("--no-geometric",),
        ("--cable", "rigid"),
    ):
        assert told(*option) != plain, option


def test_poses_out_of_their_limits_are_reported(cli) -> None:
    given = ("--boundary", "--grid", "9", "--criterion", "wrench-closure", "--tension-limits", "10,30")
    told = cli("modes", "jung2020", *given, "--json").json["boundary"]
    assert 0 < told["out_of_limits"] <= told["n"]
    assert cli("modes", "jung2020", *given).figure("out of limits") == str(told["out_of_limits"])


def test_an_empty_boundary_is_a_no(cli, tmp_path) -> None:
    nowhere = ("--boundary", "--grid", "5", "--box", "5,6,5,6,5,6")
    answer = cli("modes", "jung2020", *nowhere, "--plot", tmp_path / "b.png", "--json")
    assert answer.no == "no node of the grid is inside"
    assert answer.json.keys() == KEYS | OF_BOUNDARIES
    assert (answer.json["status"], answer.json["frequencies"], answer.json["boundary"]["min"]) == (
        "empty",
        None,
        None,
    )
    assert list(tmp_path.iterdir()) == []
    assert cli("modes", "jung2020", *nowhere).code == 1


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "give either --at X,Y,Z or --boundary"),
        ([*AT, "--boundary"], "give either --at X,Y,Z or --boundary"),
        ([*AT, "--grid", "9"], "--grid: only with --boundary"),
        ([*AT, "--criterion", "exact"], "--criterion: only with --boundary"),
        (["--boundary", "--grid", "1000"], "3 to 121 nodes"),
        (["--boundary", "--tensions", "many"], "'many' is not one of"),
        (["--boundary", "--orientations", "0,0,4"], "at most pi (180 degrees)"),
        (["--boundary", "--retraction", "1.5", "--retraction-law", "0,1.5"], "give one of them"),
        (["--at", "1,2"], "6 numbers are expected"),
        (["--at", "here"], "numbers with commas"),
        ([*AT, "--cable", "cord"], "'cord' is not one of"),
        ([*AT, "--sheave", "swivel"], "has only a sheave of kind eyelet"),
        ([*AT, "--retraction", "3"], "retracts from 1.2 to 2 m"),
        ([*AT, "--tension-limits", "20,10"], "0 <= lowest < highest"),
        ([*AT, "--plot", "modes.jpg"], "a name that ends in .png"),
    ],
)
def test_bad_input_is_rejected(cli, arguments: list[str], says: str) -> None:
    assert says in cli("modes", "jung2020", *arguments).refusal


def test_measured_modes_of_a_recorded_swing(cli, tmp_path) -> None:
    recorded = Path(__file__).parents[3] / "examples" / "free-swing.csv"
    at = ("--at", "0.982,free,-0.2038,free,free,free")
    command = ("modes", "grab-prototype", "--lines", "1,3", "--log", recorded)
    drawn = tmp_path / "swing.png"
    found = cli(*command, *at, "--json", "--plot", drawn).json
    assert {each.key for each in MeasuredModes.FIGURES} <= found.keys()
    assert [each["frequency"] for each in found["modes"]] == pytest.approx(
        [0.651, 1.011, 1.658, 2.021, 2.573, 3.588], abs=2e-3
    )
    assert found["explanations"][0]["explains"] > 0.85
    assert drawn.stat().st_size > 10_000
    assert cli(*command, *at, "--boundary").refusal == "--log and --boundary: give one of them, not both"
    assert "give --at X,Y,Z" in cli(*command).refusal
    assert cli("modes", "jung2020", "--at", "0.2,0.1,0.9", "--span", "1,2").refusal == "--span: only with --log"
