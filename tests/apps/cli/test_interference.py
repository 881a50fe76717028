"""`interference`: the contract's JSON, the text for people, what is a no and what is rejected."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from cablewright.models.statics import Model
from cablewright.robot import library_text, load
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.interference import interference

AT = ("--at", "0.2,0.1,0.9")
KEYS = {
    "schema",
    "status",
    "robot",
    "smallest_distance",
    "kind",
    "pair",
    "place",
    "line_line",
    "line_platform",
    "line_frame",
    "line_part",
    "nearest",
    "clearance",
    "ends",
    "tolerance",
    "bound",
    "first_layer",
    "plot",
}
OF_A_POSE = {"pose", "tensions"}
OF_A_JOB = {
    "job",
    "first_gcode_line",
    "layer",
    "gcode_line",
    "samples",
    "bead_width",
    "bead_height",
    "bead_by",
    "unheld",
    "layers",
    "layer_distances",
    "free_fraction",
    "free_box",
}
CODE = "G21 G90 M83\n;LAYER:0\nG1 X0 Y0 Z100 F6000\nG1 X500 Y0 E5\nG1 X500 Y300 E5\n;LAYER:1\nG1 X0 Y0 Z120 E9\n"


@pytest.fixture
def machine(tmp_path) -> Path:
    """cogiro with a beam beside one of its lines and a body."""
    more = (
        "[[scene.beams]]\nstart = [0, -9, 4]\nend = [0, 9, 4]\nradius = 0.05\n"
        "[[platform.boxes]]\nlowest = [-0.2, -0.2, -0.1]\nhighest = [0.2, 0.2, 0.1]\n"
    )
    file = tmp_path / "machine.toml"
    file.write_text(library_text("cogiro") + more)
    return file


@pytest.fixture
def wall(tmp_path) -> Path:
    """A wall through the middle, two triangles."""
    corners = np.array([[0, -1, 0], [0, 1, 0], [0, 1, 2], [0, -1, 2]], dtype=float)
    rows = corners[[[0, 1, 2], [0, 2, 3]]]
    records = b"".join(struct.pack("<12fH", 0, 0, 0, *row.ravel(), 0) for row in rows)
    file = tmp_path / "wall.stl"
    file.write_bytes(b"\0" * 80 + struct.pack("<I", 2) + records)
    return file


@pytest.fixture
def job(tmp_path) -> Path:
    (tmp_path / "part.gcode").write_text(CODE)
    (tmp_path / "part.toml").write_text('schema = 1\nname = "part"\ngcode = "part.gcode"\n')
    return tmp_path / "part.toml"


def test_a_pose_prints_what_the_analysis_finds(cli, machine: Path) -> None:
    answer = cli("interference", machine, *AT, "--json")
    found = answer.json
    assert found.keys() == KEYS | OF_A_POSE
    wanted = interference(solve_inverse(Model(load(machine)), [0.2, 0.1, 0.9]))
    assert [found[key] for key in ("line_line", "line_platform", "line_frame")] == wanted.margins[0, :3].tolist()
    assert found["line_part"] is None
    assert found["smallest_distance"] == wanted.smallest[0] == found[f"line_{found['kind']}"]
    assert found["nearest"]["line_frame"]["pair"][1] == "beam 1"
    assert found["nearest"]["line_platform"]["pair"][1] == "platform box 1"
    assert found["first_layer"] is None
    assert answer.code == (0 if found["status"] == "free" else 1)


def test_a_line_through_a_wall_is_a_no(cli, wall: Path) -> None:
    answer = cli("interference", "house-printer", "--at", "1,0.2,0.1", "--mesh", wall, "--json")
    assert answer.json["status"] == "touching"
    assert answer.json["line_part"] == pytest.approx(-0.002)
    assert "touches triangle" in answer.no
    assert "the mesh is not closed" in answer.err
    far = cli("interference", "house-printer", "--at", "1,0.2,0.1", "--mesh", wall, "--mesh-scale", "0.01", "--json")
    assert (far.code, far.json["status"]) == (0, "free")
    assert far.json["line_part"] > 0.3


def test_too_near_is_a_no_too(cli) -> None:
    apart = cli("interference", "jung2020", *AT, "--json").json["smallest_distance"]
    assert cli("interference", "jung2020", *AT, "--clearance", 0.99 * apart).code == 0
    near = cli("interference", "jung2020", *AT, "--clearance", 1.01 * apart, "--json")
    assert near.json["status"] == "near"
    assert "line 1 comes too near to line" in near.no


def test_a_job(cli, job: Path, tmp_path) -> None:
    answer = cli("interference", "house-printer", job, "--plot", tmp_path / "a.png", "--json")
    assert (answer.code, answer.json["status"]) == (0, "free")
    found = answer.json
    assert found.keys() == KEYS | OF_A_JOB
    assert found["first_layer"] is None
    assert found["layers"][-2:] == [1, 2]
    assert found["unheld"] == 0
    assert 0.0 < found["free_fraction"] <= 1.0
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    text = cli("interference", "house-printer", job).out.splitlines()
    assert {tuple(row.rsplit(maxsplit=1)) for row in text[:2]} == {("status", "free"), ("robot", "house-printer")}
    assert "first layer touched -" in {" ".join(row.split()) for row in text}


def test_a_job_that_grows_through_a_wall(cli, job: Path, wall: Path) -> None:
    """The wall counts as far up as the job has laid: 0.1 m, over which the nozzle is as it begins."""
    answer = cli("interference", "house-printer", job, "--mesh", wall, "--clearance", "0.5", "--json")
    assert answer.json["status"] == "near"
    assert answer.json["first_layer"] == 1
    assert answer.json["first_gcode_line"] == 4
    assert "in layer" in answer.no


def test_what_cannot_be_held_is_a_no(cli, job: Path, tmp_path) -> None:
    answer = cli("interference", "house-printer", "--at", "0,0,20", "--json")
    assert answer.json["status"] == "infeasible"
    assert answer.json["smallest_distance"] is None
    assert "cannot be held: infeasible" in answer.no
    assert cli("interference", "house-printer", "--at", "0,0,20", "--plot", tmp_path / "a.png").code == 1
    tight = cli("interference", "house-printer", job, "--tension-limits", "700,710", "--json")
    assert tight.json["unheld"] == tight.json["samples"]
    assert "cannot be held at" in tight.no


def test_pictures(cli, machine: Path, wall: Path, tmp_path) -> None:
    for robot, extra in ((machine, ()), ("house-printer", ("--mesh", wall))):
        file = tmp_path / "picture.png"
        answer = cli("interference", robot, *AT, *extra, "--plot", file, "--json")
        assert answer.json["plot"] == str(file)
        assert file.read_bytes().startswith(b"\x89PNG")
        file.unlink()


def test_people_get_a_table(cli, machine: Path) -> None:
    rows = cli("interference", machine, *AT).out.splitlines()
    head, *table = rows[rows.index("nearest of each kind") + 1 :]
    assert "distance, mm  line, nearest to" in head
    assert [row.split()[0] for row in table] == ["line_line", "line_platform", "line_frame", "line_part"]
    assert "beam 1" in table[2]
    assert table[3].split() == ["line_part", "-", "-", "-"]


def test_a_cable_of_unknown_diameter_is_reported(cli, tmp_path) -> None:
    text = "\n".join(line for line in library_text("merlet2023").splitlines() if not line.startswith("diameter"))
    (tmp_path / "thin.toml").write_text(text)
    assert (
        "cable.diameter is not given, and assumed" in cli("interference", tmp_path / "thin.toml", "--at", "0,0,1").err
    )


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "expected either a JOB or --at"),
        (["part.toml", *AT], "expected either a JOB or --at"),
        (["part.toml", "--retraction", "1.3"], "--retraction is only for --at"),
        ([*AT, "--clearance", "-1"], "clearance = -1"),
        ([*AT, "--clearance", "nan"], "clearance = nan"),
        ([*AT, "--ends", "-1"], "ends = -1 m"),
        ([*AT, "--tolerance", "0"], "tolerance = 0 m"),
        ([*AT, "--mesh", "no.stl"], "no such file"),
        ([*AT, "--mesh-scale", "0", "--mesh", "no.stl"], "mesh scale 0"),
        ([*AT, "--plot", "a.jpg"], "expected a name that ends in .png"),
        (["--at", "1,2"], "6 numbers are expected"),
    ],
)
def test_bad_input_is_rejected(cli, arguments: list[str], says: str) -> None:
    assert says in cli("interference", "jung2020", *arguments).refusal


def test_beads_are_given_as_for_check(cli, job: Path, wall: Path) -> None:
    found = cli("interference", "cogiro", job, "--bead", "12mm,6mm", "--json").json
    assert (found["bead_width"], found["bead_height"], found["bead_by"]) == (0.012, 0.006, "as given")
    assert "--bead is the size of the strands" in cli("interference", "cogiro", *AT, "--bead", "12mm,6mm").refusal
    assert "--bead is the size" in cli("interference", "cogiro", job, "--mesh", wall, "--bead", "12mm,6mm").refusal
