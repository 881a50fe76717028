"""Whether a part fits: against boxes and pyramids by hand, and against the solver at its points."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

import cablewright as cw
from cablewright.apps.cli.main import run
from cablewright.foundation.errors import InputError
from cablewright.models.job_poses import on_plane
from cablewright.printing.job import load_job
from cablewright.robot import Robot, load
from cablewright.studies.part_fit import fit
from cablewright.studies.reach import Reach, reach


def bar(folder: Path, length: float, height: float = 2.0, name: str = "bar.gcode") -> Path:
    """G-code of one strand along x, of a *length*, mm, about x = 100 mm."""
    x = 100.0 - 0.5 * length
    (folder / name).write_text(f"G21\nG90\nM83\n;LAYER:0\nG0 X{x} Y50 Z{height} F3000\nG1 X{x + length} Y50 E9\n")
    return folder / name


@pytest.fixture(scope="module")
def hangprinter() -> Robot:
    return load("hangprinter-v4")


def test_the_reach_of_a_grid() -> None:
    """A point is in a cell whose corners all hold; the volume is that of such cells."""
    axes = (np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0]))
    holds = np.ones((3, 3, 2), np.bool_)
    holds[2, 2, 1] = False
    found = Reach(axes, holds)
    assert found.volume == 3.0
    points = np.array([[0.5, 0.5, 0.5], [1.5, 1.5, 0.1], [2.0, 0.5, 1.0], [0.5, 0.5, 1.1]])
    assert found.within(points).tolist() == [True, False, True, False]
    assert found.up_to(0.0, 1.0).sum() == 3


def test_the_largest_scale_is_held_and_a_larger_one_is_not(hangprinter: Robot, tmp_path: Path) -> None:
    found = fit(hangprinter, load_job(bar(tmp_path, 100.0)))
    assert found.fits
    assert found.refusal == ""
    turn = np.array([math.cos(found.rotation), math.sin(found.rotation)])
    ends = np.array([[-50.0, 50.0]]).T * 1e-3 * turn
    middle = found.placed.mean(axis=0)
    for scale, whole in ((found.scale, True), (1.25 * found.scale, False)):
        at = np.concatenate([ends * scale, np.full((2, 1), 2e-3 * scale)], axis=1)
        at[:, :2] += middle[:2]
        assert cw.inverse(hangprinter, at).ok.all() is np.bool_(whole)
    assert "line" in found.limit or "frame" in found.limit


def test_the_origin_brings_the_part_there(hangprinter: Robot, tmp_path: Path) -> None:
    """A job with that origin, and no rotation, is held at all its points."""
    path = bar(tmp_path, 300.0)
    found = fit(hangprinter, load_job(path), turns=1)
    (tmp_path / "job.toml").write_text(
        f'schema = 1\nname = "bar"\ngcode = "{path.name}"\norigin = {[float(each) for each in found.origin]}\n'
    )
    job = load_job(tmp_path / "job.toml")
    laid = job.samples(job.toolpath())
    at = laid.positions[laid.extruding]
    assert cw.inverse(hangprinter, at).ok.all()
    assert found.placed.min(axis=0) == pytest.approx(at.min(axis=0) - [0.0, 0.0, 0.0], abs=0.05)


def test_a_long_part_is_turned(tmp_path: Path) -> None:
    """In a frame of a narrow box the bar has to lie along its long side."""
    robot = load("house-printer")
    scene = robot.scene.model_copy(update={"frame_min": (-1.0, -5.0, 0.0), "frame_max": (1.0, 5.0, 8.0)})
    found = fit(robot.model_copy(update={"scene": scene}), load_job(bar(tmp_path, 4000.0)))
    assert found.fits
    assert found.rotation == pytest.approx(math.pi / 2)


def test_a_part_that_is_too_large_is_rejected(hangprinter: Robot, tmp_path: Path) -> None:
    found = fit(hangprinter, load_job(bar(tmp_path, 6000.0)), turns=4)
    assert not found.fits
    assert 0.1 < found.scale < 0.5
    assert "up to a scale of" in found.refusal
    placed = found.placed
    assert np.ptp(placed[:, :2], axis=0).max() < 3.0


def test_an_error_makes_the_reach_smaller(hangprinter: Robot) -> None:
    everywhere = reach(hangprinter, nodes=9)
    near = reach(hangprinter, nodes=9, max_error=2e-3)
    assert 0 < near.holds.sum() < everywhere.holds.sum()
    assert not (near.holds & ~everywhere.holds).any()


def test_a_wall_has_an_area(tmp_path: Path) -> None:
    robot = load("hangprinter-v4")
    platform = robot.platform.model_copy(update={"plane": cw.Plane(normal=(0.0, 1.0, 0.0), one_sided=False)})
    found = reach(robot.model_copy(update={"platform": platform}), nodes=9)
    assert found.holds.shape[1] == 1
    away = platform.model_copy(update={"plane": cw.Plane(normal=(0.0, 1.0, 0.0), distance=9.0)})
    with pytest.raises(InputError, match=r"the box misses the plane y = 9 m"):
        reach(robot.model_copy(update={"platform": away}), nodes=9)


def leaning(angle: float) -> Robot:
    """The wall plotter on a board that leans back by an *angle*, rad, under gravity with 9.81 m/s^2 along the board."""
    s, c = math.sin(angle), math.cos(angle)
    table = load("wall-plotter").model_dump(by_alias=True)
    for line in table["lines"]:
        x, _, z = line["exit_point"]
        line["exit_point"] = (x, z * s, z * c)
        line["cable"]["linear_density"] = 1e-7
    low, high = table["scene"]["frame_min"], table["scene"]["frame_max"]
    table["scene"] |= {"frame_min": (low[0], low[2] * s - 0.1, low[2] * c), "gravity": 9.81 / c,
                       "frame_max": (high[0], high[2] * s + 0.1, high[2] * c)}  # fmt: skip
    table["platform"]["plane"] = {"normal": (0.0, -c, s), "one_sided": True, "gcode_zero": (0.0, 0.8 * s, 0.8 * c)}
    return Robot.model_validate(table)


def test_a_board_that_leans_has_the_reach_of_one_that_stands(tmp_path: Path) -> None:
    robot = leaning(0.3)
    found, stands = reach(robot), reach(leaning(0.0))
    assert found.holds.shape == stands.holds.shape
    assert found.volume == pytest.approx(stands.volume, rel=1e-9)
    assert found.directions[2] == pytest.approx([0.0, math.sin(0.3), math.cos(0.3)])
    (tmp_path / "square.gcode").write_text("G21\nG90\nG0 X-100 Y-100 F3000\nG1 X100\nG1 Y100\nG1 X-100\nG1 Y-100\n")
    text = 'schema = 1\nname = "square"\ngcode = "square.gcode"\nmaterial = "every G1"\n'
    (tmp_path / "job.toml").write_text(text)
    placed = fit(robot, load_job(tmp_path / "job.toml"))
    assert placed.fits
    assert placed.scale == pytest.approx(fit(leaning(0.0), load_job(tmp_path / "job.toml")).scale, rel=0.01)
    assert placed.size == pytest.approx([0.2, 0.0, 0.2], abs=1e-9)
    plane = robot.platform.plane
    assert plane is not None
    assert max(abs(plane.height(at)) for at in placed.placed) < 1e-9
    assert cw.inverse(robot, placed.placed).ok.all()
    (tmp_path / "job.toml").write_text(f"{text}origin = {[float(each) for each in placed.origin]}\n")
    job = on_plane(robot, load_job(tmp_path / "job.toml"))
    laid = job.samples(job.toolpath()).positions[1:]
    assert np.abs(laid[:, 0]).max() == pytest.approx(np.abs(placed.placed[:, 0]).max(), abs=1e-2)
    assert laid[:, 2].max() == pytest.approx(placed.placed[:, 2].max(), abs=1e-2)


def test_the_origin_has_the_height_that_the_job_gives(hangprinter: Robot, tmp_path: Path) -> None:
    bar(tmp_path, 100.0)
    (tmp_path / "job.toml").write_text('schema = 1\nname = "bar"\ngcode = "bar.gcode"\norigin = [0, 0, "0.3 m"]\n')
    found = fit(hangprinter, load_job(tmp_path / "job.toml"), turns=1)
    assert found.origin[2] == pytest.approx(0.3)
    assert found.placed[:, 2] == pytest.approx(0.302)


def test_the_picture_of_a_board_that_leans(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "bar.gcode").write_text("G21\nG90\nM83\n;LAYER:0\nG0 X-300 Y-50 F3000\nG1 X300 Y50 E9\n")
    assert run(["fit", "maslow4", str(tmp_path / "bar.gcode"), "--plot", str(tmp_path / "f.png"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["scale"] > 1.0
    assert (tmp_path / "f.png").stat().st_size > 20_000


def stl(path: Path, corners: list[tuple[int, int, int]]) -> Path:
    """A tetrahedron, mm."""
    facets = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    text = "solid s\n" + "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex {} {} {}\n".format(*corners[k]) for k in facet)
        + "endloop\nendfacet\n"
        for facet in facets
    )
    path.write_text(text + "endsolid s\n")
    return path


def test_an_stl_stands_on_the_bed(hangprinter: Robot, tmp_path: Path) -> None:
    found = fit(hangprinter, stl(tmp_path / "s.stl", [(0, 0, 10), (80, 0, 10), (0, 80, 10), (0, 0, 90)]), turns=2)
    assert found.size == pytest.approx([0.08] * 3)
    assert found.placed[:, 2].min() == pytest.approx(0.0)
    with pytest.raises(InputError, match="must be a job's TOML or G-code, or an STL"):
        fit(hangprinter, tmp_path / "s.obj")


@pytest.mark.parametrize("name", ["wall-plotter", "maslow4"])
def test_an_stl_on_a_board_is_flat(name: str, tmp_path: Path) -> None:
    solid = stl(tmp_path / "s.stl", [(0, 0, 10), (80, 0, 10), (0, 80, 10), (0, 0, 90)])
    with pytest.raises(InputError, match=r"s.stl: is not flat, and the nozzle of '.*' moves in a plane: give a job"):
        fit(load(name), solid)


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    part = str(bar(tmp_path, 6000.0))
    code = run(["fit", "hangprinter-v4", part, "--plot", str(tmp_path / "f.png"), "--json"])
    said = capsys.readouterr()
    assert code == 1
    answer = json.loads(said.out)
    assert answer["fits"] is False
    assert answer["scale"] < 1.0
    assert len(answer["origin"]) == 3
    assert (tmp_path / "f.png").stat().st_size > 20_000
    assert "up to a scale of" in said.err
