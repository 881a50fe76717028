"""Interference along a job: a tower that grows into a line, layer by layer, at heights known by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tools.pages.line_prints import on_the_board

from cablewright.analyses.interference import KINDS, distances, free_region
from cablewright.foundation import memory_mapped
from cablewright.foundation.errors import InputError
from cablewright.foundation.triangle_mesh import TriangleMesh
from cablewright.models.fidelity import Fidelity
from cablewright.models.plane import within
from cablewright.models.statics import Model
from cablewright.printing.beads import Bead
from cablewright.printing.job import Job, load_job
from cablewright.robot import Robot, load, loads
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.interference import interference

ROBOT = """
schema = 1
name = "three lines"
scene = { frame_min = [-3, -3, 0], frame_max = [3, 3, 3] }
platform = { mass = "10 kg" }
cable = { axial_stiffness = "1 GN", linear_density = 0, breaking_load = "9 kN" }
sheave = { kind = "eyelet" }
line = { tension_limits = [1, "2 kN"] }
lines = [
    { name = "west", exit_point = [-2, 0, 2] },
    { name = "north", exit_point = [2, 2, 2] },
    { name = "south", exit_point = [2, -2, 2] },
]
""".replace("1 GN", "1000000 kN")
TOWER = 50  # layers of 20 mm
HALF = 0.03  # m, half the bead's width


def code() -> str:
    """At x = 0 a tower of beads along y; after each of its layers the nozzle goes back to lay one at (1, 0, 20 mm)."""
    rows = ["G21 G90 M83", "G0 X0 Y-100 Z20 F6000"]
    for layer in range(TOWER):
        z = 20 * (layer + 1)
        rows += [
            f";LAYER:{layer}",
            f"G0 Z{z + 60}",
            f"G0 X0 Y-100 Z{z + 60}",
            f"G0 Z{z}",
            "G1 X0 Y100 E5",
            f"G0 Z{z + 60}",
            f"G0 X1000 Y-50 Z{z + 60}",
            "G0 Z20",
            "G1 X1000 Y0 E5",
            "G1 X1000 Y50 E5",
        ]
    return "\n".join(rows) + "\n"


@pytest.fixture(scope="module")
def job(tmp_path_factory) -> Job:
    folder: Path = tmp_path_factory.mktemp("tower")
    (folder / "tower.gcode").write_text(code())
    (folder / "tower.toml").write_text(
        'schema = 1\nname = "tower"\ngcode = "tower.gcode"\nsampling = { step = 0.025 }\n'
    )
    return load_job(folder / "tower.toml")


@pytest.fixture(scope="module")
def model() -> Model:
    robot: Robot = loads(ROBOT)
    return Model(robot, Fidelity.of("elastic"))


def height_over_the_tower() -> float:
    """Height of the line from (1, 0, 20 mm) to (-2, 0, 2 m) over the near edge of the tower, m."""
    return 0.02 + (2.0 - 0.02) * (1.0 - HALF) / 3.0


def test_given_beads_are_those_of_the_part(job: Job, model: Model) -> None:
    wide = interference(model, job)
    thin = interference(model, job, bead=Bead(width=0.002, height=0.001))
    assert thin.to_dict()["line_part"] > wide.to_dict()["line_part"]
    found = thin.to_dict()
    assert (found["bead_width"], found["bead_height"], found["bead_by"]) == (0.002, 0.001, "as given")
    solid = TriangleMesh.of_corners(np.array([[[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]]]))
    with pytest.raises(InputError, match="bead is the size of the strands"):
        interference(model, job, part=solid, bead=Bead())
    with pytest.raises(InputError, match="bead is the size of the strands"):
        interference(model, [0.0, 0.0, 1.0], bead=Bead())


def test_the_layer_that_first_reaches_a_line_is_found(job: Job, model: Model) -> None:
    touched = int(np.floor(height_over_the_tower() / 0.02)) + 1  # whose top is the first above the line
    assert touched == 34
    seen = []
    found = interference(model, job, progress=lambda stage, done, total: seen.append(stage))
    assert found.unheld == 0
    assert found.first_layer == touched
    x, _, z = found.samples.positions[found.first_sample]
    assert x == pytest.approx(1.0)
    assert 0.02 <= z < 0.05  # on its way down, or there
    assert set(seen) == {"reading G-code", "distances of lines", "free region"}
    contact = found.contacts.part
    assert contact.line == "west"
    assert contact.margin < 0.0
    assert found.worst is not None


def test_a_clearance_is_met_earlier_by_as_many_layers_as_it_takes(job: Job, model: Model) -> None:
    slope = (2.0 - 0.02) / 3.0
    for clearance in (0.01, 0.05, 0.1):
        found = interference(model, job, clearance=clearance)
        if found.first_sample is None or found.first_layer == 1:
            continue  # the nozzle's own strand is as near
        near = height_over_the_tower() - clearance * np.sqrt(1.0 + slope * slope)  # of the edge, at a right angle
        assert found.first_layer == int(np.floor(near / 0.02)) + 1


def test_each_layer_reports_its_distance(job: Job, model: Model) -> None:
    found = interference(model, job)
    numbers, least = found.layers()
    assert (numbers[-TOWER:] == np.arange(1, TOWER + 1)).all()
    assert (least[-TOWER:][:33] >= 0.0).all()
    assert (least[-TOWER:][33:] < 0.0).all()
    np.testing.assert_array_equal(np.fmin.reduce(found.margins[:, 3]), np.fmin.reduce(least))


def test_a_sample_alone_says_the_same(job: Job, model: Model) -> None:
    found = interference(model, job)
    for at in np.linspace(10, len(found.samples) - 1, 25).astype(int):
        held = solve_inverse(model, found.samples.positions[at])
        alone = distances(held, part=found.part, now=float(at))
        np.testing.assert_allclose(alone.margins[0], found.margins[at], atol=1e-9)


def test_a_mesh_that_grows_with_the_job_is_touched_in_the_same_layer(job: Job, model: Model) -> None:
    """The tower as a closed mesh, cut at the height that has been laid."""
    corners = np.array([[x, y, z] for x in (-HALF, HALF) for y in (-0.1, 0.1) for z in (0.0, 1.0)])
    sides = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    mesh = TriangleMesh(corners, np.array([row for a, b, c, d in sides for row in ((a, b, c), (a, c, d))]))
    assert mesh.is_closed
    found = interference(model, job, part=mesh)
    assert found.first_layer == 34
    assert found.contacts.part.margin == 0.0  # cables without a diameter, through a face without a depth


def test_what_lies_in_files_is_the_same(job: Job, model: Model, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(memory_mapped, "SMALL", 1)
    kept, own = interference(model, job, room=tmp_path), interference(model, job)
    assert kept.to_dict() == own.to_dict()
    np.testing.assert_array_equal(kept.margins, own.margins)
    assert not list(tmp_path.iterdir())


def test_the_region_above_the_part_is_free(job: Job, model: Model) -> None:
    region = interference(model, job, clearance=0.02).region
    x, y, z = region.axes
    assert 0.0 < region.fraction < 1.0
    assert region.free[:, :, -1][np.isfinite(region.margins[:, :, -1])].all()
    behind = np.abs(x - 0.4).argmin(), np.abs(y).argmin()  # seen from the west, behind the tower
    assert region.floor[behind] > 0.5
    assert z[0] == 0.0


def test_a_board_has_a_free_region_too(tmp_path: Path) -> None:
    """Nodes off the plane count as their nearest place in it: where the board leans, those along its normal agree."""
    robot = load("maslow4")
    found = interference(robot, on_the_board(tmp_path))
    assert found.region.free.any()
    box = np.array(found.region.box)
    straight = free_region(Model(robot), found.part, box[:, 0], box[:, 1], (2, 2, 2)).margins
    plane, places = robot.platform.plane, np.stack(np.meshgrid(*box, indexing="ij"), axis=-1).reshape(-1, 3)
    assert plane is not None
    held = solve_inverse(Model(robot), within(plane, places), path=True)
    known = np.isfinite(straight.ravel())
    own = distances(held, part=found.part).margins[:, KINDS.index("part")]
    assert straight.ravel()[known] == pytest.approx(own[known], abs=1e-9)
