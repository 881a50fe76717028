"""Workspaces in a plane: known areas, sections of volumes, and what planar robots are."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import linprog

import cablewright as cw
from cablewright.analyses.workspace.area import WorkspaceArea
from cablewright.analyses.workspace.criterion import is_planar
from cablewright.foundation.errors import InputError
from cablewright.robot import Robot

UP = [(-2.0, 0.5, 3.0), (2.0, 0.5, 3.0)]
ROUND = [(-2.0, -1.0, 1.0), (2.0, -1.0, 1.0), (1.5, 2.0, 1.0), (-1.0, 1.5, 1.0)]


def planar(exits: list[tuple[float, float, float]], limits=(0.0, 1e7), gravity: float = 9.81, **platform: Any) -> Robot:
    cable = {"axial_stiffness": 1e6, "linear_density": 0.0, "breaking_load": 1e9}
    lines = [
        {"name": f"line {i}", "exit_point": at, "cable": cable, "sheave": {"kind": "eyelet"}, "tension_limits": limits}
        for i, at in enumerate(exits)
    ]
    scene = {"frame_min": (-3, -2, 0), "frame_max": (3, 3, 4), "gravity": gravity}
    return Robot.model_validate({"name": "flat", "scene": scene, "platform": {"mass": 4} | platform, "lines": lines})


def area(robot: Robot, criterion: str = "exact", **options: Any) -> WorkspaceArea:
    return cw.workspace_area(robot, criterion, **options)


def test_between_two_lines_from_above() -> None:
    found = area(planar(UP))
    assert (found.status, found.normal, found.box.low[1]) == ("ok", "y", 0.5)
    assert found.area == pytest.approx(4.0 * 3.0, abs=found.area_error)
    assert found.area_error < 0.03
    assert found.perimeter == pytest.approx(14.0, rel=0.01)
    assert len(found.outlines) == 1
    assert (found.outlines[0][:, 1] == 0.5).all()


def test_lying_flat_it_is_the_hull_of_the_exit_points() -> None:
    """Lines that pull with at least next to nothing, and up to very much, reach all that lies between them."""
    found = area(planar(ROUND, limits=(1.0, 1e5), gravity=0.0))
    x, y, _ = np.array(ROUND).T
    hull = 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    assert (found.status, found.normal) == ("ok", "z")
    assert found.area == pytest.approx(hull, abs=found.area_error)


def test_its_places_are_those_of_a_linear_program() -> None:
    robot = planar(ROUND, limits=(10.0, 40.0), gravity=0.0, force=(6.0, -3.0, 0.0))
    found, exits = area(robot), np.array(ROUND)[:, :2]
    places = np.random.default_rng(0).uniform([-3, -2], [3, 3], (800, 2))
    held = []
    for place in places:
        pulls = (exits - place) / np.linalg.norm(exits - place, axis=1)[:, None]
        held.append(linprog(np.ones(4), A_eq=pulls.T, b_eq=[-6.0, 3.0], bounds=[(10.0, 40.0)] * 4).status == 0)
    share = float(np.mean(held))
    assert 0.05 < share < 0.6
    assert found.area == pytest.approx(30.0 * share, abs=4.0 * 30.0 * np.sqrt(share * (1.0 - share) / 800))
    inside = np.array([_is_inside(found.outlines, place) for place in places])
    assert (inside != held).mean() < 0.01


def _is_inside(outlines: tuple[np.ndarray, ...], place: np.ndarray) -> bool:
    """By the number of turns of all outlines around it."""
    turns = 0.0
    for outline in outlines:
        away = (outline[:, :2] - place) @ [1.0, 1.0j]
        turns += np.angle(np.roll(away, -1) / away).sum()
    return abs(turns) > np.pi


@pytest.mark.parametrize(("axis", "at"), [(0, 0.3), (1, -0.25), (2, 0.8)])
def test_a_flat_box_is_a_section_of_the_volume(axis: int, at: float) -> None:
    robot = cw.load("jung2020")
    ends = [-1.0, 1.0, -1.0, 1.0, 0.0, 2.0]
    volume = cw.workspace(robot)
    ends[2 * axis] = ends[2 * axis + 1] = at
    found = area(robot, box=ends)
    assert found.area == pytest.approx(volume.mesh.section_area(axis, at), rel=4e-3)
    assert found.normal == "xyz"[axis]


def test_sagging_lines_reach_an_area_too() -> None:
    light = planar([*UP, (0.0, 0.5, 3.5)], limits=(0.5, 1e4))
    exact, static = area(light, tolerance=0.01), area(light, "static", tolerance=0.01)
    assert static.area == pytest.approx(exact.area, rel=0.02)


def test_what_is_planar() -> None:
    """Exit points at one height do not make a plane of the platform below them, nor do those in a line without a
    load."""
    assert is_planar(planar(UP), None)
    assert is_planar(planar(UP), [-1, 1, 0.5, 0.5, 0, 1])
    assert not is_planar(planar(UP), [-1, 1, 0, 1, 0, 1])
    assert is_planar(planar(ROUND, gravity=0.0), None)
    assert not is_planar(planar(ROUND), None)
    assert not is_planar(planar(UP[:1]), None)
    assert not is_planar(planar(UP, gravity=0.0), None)
    assert not is_planar(planar(UP, force=(0.0, 1.0, 0.0)), None)
    assert not is_planar(cw.load("merlet2023"), None)


def test_the_plane_is_that_of_the_platforms_places() -> None:
    """Lines that meet 0.3 m beside the origin of the platform."""
    robot = planar(UP)
    lines = tuple(line.model_copy(update={"platform_point": (0.0, 0.3, 0.0)}) for line in robot.lines)
    found = area(robot.model_copy(update={"lines": lines}))
    assert found.box.low[1] == pytest.approx(0.2)
    assert found.area == pytest.approx(12.0, abs=found.area_error)


def test_two_lines_hang_in_their_plane() -> None:
    found = area(planar(UP, limits=(0.5, 1e4)), "static", tolerance=0.01)
    assert found.area == pytest.approx(area(planar(UP, limits=(0.5, 1e4))).area, rel=0.02)
    with pytest.raises(InputError, match="static: 2 lines hold 2 of the 3 degrees of freedom"):
        cw.workspace(planar(UP), "static", box=[-1, 1, 0, 1, 0, 1])


def test_nothing_pulls_across_the_plane() -> None:
    robot = planar(ROUND, limits=(1.0, 1e3), gravity=0.0)
    with pytest.raises(InputError, match="lines of a planar robot cannot pull across its plane"):
        cw.workspace_area(robot, "wrench-closure")
    with pytest.raises(InputError, match="wrench box: no lines pull across the plane; give 0 to 0 along z"):
        cw.workspace_area(robot, "capacity", wrench_box=([-1, -1, -1], [1, 1, 1]))
    some = area(robot, "capacity", wrench_box=([-1, -1, 0], [1, 1, 0]))
    assert 0.0 < some.area < area(robot).area


@pytest.mark.parametrize("criterion", ["exact", "capacity", "improved-closed-form"])
def test_limp_lines_hold_nothing(criterion: str) -> None:
    """Without a load and with least tensions of zero, all lines may be slack anywhere."""
    with pytest.raises(InputError, match="a line's tension_limits must begin above 0, or all are slack"):
        cw.workspace_area(planar(ROUND, gravity=0.0), criterion)
    with pytest.raises(InputError, match="or all are slack"):
        cw.tension_distribution(planar(ROUND, gravity=0.0), [0.0, 0.0, 1.0])


def test_what_is_empty_and_what_is_no_plane() -> None:
    none = area(planar(UP, limits=(1e6, 1e7)))
    assert (none.status, none.area, none.outlines) == ("empty", 0.0, ())
    with pytest.raises(InputError, match="box: x from 1 to 1 m: lowest < highest is expected"):
        cw.workspace_area(planar(UP), box=[1, 1, 0, 0, 0, 1])
    with pytest.raises(InputError, match="workspace_area: the robot is not planar; give a flat box"):
        cw.workspace_area(cw.load("merlet2023"))
    with pytest.raises(InputError, match="box: y from 0 to 0 m: lowest < highest is expected"):
        cw.workspace(planar(UP), box=[-1, 1, 0, 0, 0, 1])
    with pytest.raises(InputError, match="box: y from 0 to 0 m: lowest < highest is expected"):
        cw.count_nodes(planar(UP), box=[-1, 1, 0, 0, 0, 1])


def test_a_picture_of_it(tmp_path) -> None:
    file = tmp_path / "area.png"
    area(planar(ROUND, limits=(1.0, 1e5), gravity=0.0)).plot(file)
    assert file.stat().st_size > 10_000
