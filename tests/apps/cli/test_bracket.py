"""`bracket`: the contract's JSON, the table for people, files, and what is rejected."""

from __future__ import annotations

import meshio
import numpy as np
import pytest

from cablewright.apps.cli import bracket as command
from cablewright.robot import library_text

AT = ("--at=-2.25,-6.75,13", "--times", "1")
KEYS = {"max_von_mises", "max_displacement", "safety", "error_estimate", "nodes"}


@pytest.fixture(scope="module")
def answer(cli, tmp_path_factory):
    folder = tmp_path_factory.mktemp("bracket")
    return cli("bracket", "house-printer", *AT, "--plot", folder / "b.png", "--vtu", folder / "b.vtu", "--json"), folder


def test_both_designs_are_reported(answer) -> None:
    found, _ = answer
    assert (found.code, found.err) == (0, "")
    values = found.json
    assert values["status"] == "ok"
    assert values["pose"] == [-2.25, -6.75, 13.0]
    for design in ("universal_joint", "conventional"):
        assert values[design].keys() >= KEYS
        assert values[design]["error_estimate"] is None  # of the coarsest mesh
        assert values[design]["nodes"] > 10_000
        assert values[design]["safety"] == pytest.approx(160e6 / values[design]["max_von_mises"])
        assert values[design]["line"] == "south-west"
    assert values["ratio"] > 1.0
    assert np.abs(values["universal_joint"]["pin_moments"]).max() < 1e-9
    assert values["conventional"]["pin_moments"][0] < -400.0


def test_the_picture_and_the_file_are_written_whole(answer) -> None:
    found, folder = answer
    assert found.json["plot"] == str(folder / "b.png")
    assert (folder / "b.png").read_bytes().startswith(b"\x89PNG")
    assert sorted(each.name for each in folder.iterdir()) == ["b.png", "b.png.csv", "b.vtu"]
    mesh = meshio.read(folder / "b.vtu")
    assert set(mesh.point_data) == {"displacement", "von_mises", "stress"}
    assert mesh.cells[0].type == "hexahedron20"
    corners = mesh.points[mesh.cells[0].data][:, [0, 1, 3, 4]]
    assert (np.linalg.det(corners[:, 1:] - corners[:, :1]) > 0).all()
    assert set(mesh.cell_data["design"][0]) == {0, 1}


def test_people_get_the_designs_side_by_side(cli) -> None:
    found = cli("bracket", "house-printer", *AT)
    assert (found.code, found.err) == (0, "")
    rows = found.out.splitlines()
    assert rows[0].split() == ["status", "ok"]
    assert rows[1].split() == ["robot", "house-printer"]
    assert "conventional over universal joint  1." in found.out
    head = next(k for k, row in enumerate(rows) if row.split() == ["universal", "joint", "conventional"])
    assert rows[head + 1].split() == ["line", "south-west", "south-west"]
    assert rows.count(rows[head + 1]) == 1


def test_limits_of_the_paper_exclude_the_pose(cli) -> None:
    found = cli("bracket", "paty2021", *AT, "--json")
    assert "below its minimum, 510 N" in found.no
    assert found.json["status"] == "infeasible"
    assert found.json["universal_joint"] is None
    assert found.json["conventional"] is None


def test_a_pose_out_of_reach_is_a_no(cli) -> None:
    assert "a line would have to push" in cli("bracket", "house-printer", "--at", "0,0,20", "--times", "1").no


def test_rigid_cables_have_stresses_but_move_no_platform(cli) -> None:
    found = cli("bracket", "house-printer", *AT, "--cable", "rigid", "--json")
    assert found.code == 0
    assert found.json["universal_joint"]["max_von_mises"] > 5e7
    assert found.json["universal_joint"]["platform_motion"] == [None] * 3
    assert found.json["platform_motion_cables"] == [None] * 3


def test_a_search_that_finds_no_pose_is_a_no(cli) -> None:
    limits = ("--tension-limits", "5000,5100")
    found = cli("bracket", "house-printer", "--workspace", "7.5", "--times", "1", *limits, "--json")
    assert "no position of a grid with a step of 7.5 m is within all limits" in found.no
    assert found.json["universal_joint"] is None


def test_a_bracket_that_yields_is_a_no(cli, tmp_path) -> None:
    file = tmp_path / "soft.toml"
    text = library_text("house-printer")
    table = text[text.index("[bracket]") : text.index("[winch]")].replace("[bracket]", "").replace("[bracket.", "[")
    file.write_text("schema = 1\n" + table.replace('"160 MPa"', '"40 MPa"'))
    found = cli("bracket", "house-printer", *AT, "--bracket", file, "--json")
    assert "the bracket of line south-west yields" in found.no
    assert found.json["status"] == "yields"


REFUSED = [
    ((), "expected one of --at X,Y,Z, --job JOB and --workspace STEP"),
    (("--at", "0,0,1", "--workspace", "5"), "one of --at X,Y,Z"),
    (("--at", "0,0,1", "--times", "9"), "times = 9: one of 1, 2 is allowed"),
    (("--at", "0,0,1", "--vtu", "b.txt"), "expected a name that ends in .vtu"),
    (("--at", "0,0,1", "--plot", "b.jpg"), "expected a name that ends in .png"),
    (("--at", "0,0"), "3 numbers are expected"),
    (("--workspace", "0", "--times", "1"), "step 0 m"),
    (("--workspace", "5", "--retraction", "1"), "--retraction is only for --at"),
    (("--at", "0,0,1", "--bracket", "none.toml"), "none.toml: no such file"),
]


@pytest.mark.parametrize(("options", "told"), REFUSED)
def test_bad_input_gets_one_line(cli, options, told) -> None:
    assert told in cli("bracket", "house-printer", *options).refusal


def test_robots_without_a_bracket_or_a_lever_are_reported(cli) -> None:
    assert "has a swivel as its sheave; not supported" in cli("bracket", "merlet2023", "--at", "0,0,1").refusal


def test_without_the_extra_the_command_says_what_to_install(cli, monkeypatch) -> None:
    monkeypatch.setattr(command, "find_spec", lambda name: None)
    found = cli("bracket", "house-printer", *AT)
    assert found.code == 3
    assert found.err == (
        "cablewright: finite elements are an extra that is not installed: pip install cablewright[fem]\n"
    )


def test_the_highest_stress_over_the_workspace(cli) -> None:
    found = cli("bracket", "house-printer", "--workspace", "7.5", "--times", "1", "--json").json
    searched = found["searched"]
    assert 0 < searched["held"] <= searched["poses"]
    assert found["pose"] == searched["universal_joint"]["pose"]
    assert found["universal_joint"]["max_von_mises"] == pytest.approx(searched["universal_joint"]["max_von_mises"])
