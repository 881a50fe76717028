"""The scene of a robot agrees with the robot's statics."""

import json
import re
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import to_hex

from apps.report.synthetic import make_check, ring_robot, small_job
from cablewright.apps.report.document import script, view, with_terms
from cablewright.apps.report.show import show_page
from cablewright.apps.web.check_scene import check_scene, job_scene
from cablewright.apps.web.colours import RAMPS
from cablewright.apps.web.detail_levels import unpacked
from cablewright.apps.web.path_scene import chosen
from cablewright.apps.web.robot_scene import one_state, robot_scene
from cablewright.apps.web.viewer_states import States
from cablewright.live.logged_line_shapes import hanging_lines
from cablewright.live.rest_pose import rest_pose
from cablewright.models.rotation import placed
from cablewright.models.statics import Model
from cablewright.printing.job import load_job
from cablewright.robot import library_names, load
from cablewright.solvers.inverse import inverse

ROOT = Path(__file__).parents[3]


@pytest.mark.parametrize("name", library_names())
def test_every_robot_of_the_library_rests(name):
    found = rest_pose(load(name))
    assert found.held
    assert found.equilibrium.is_valid()
    assert found.equilibrium.margin() >= 0.0


@pytest.mark.parametrize("name", ["house-printer", "jung2020", "maslow4", "grab-four-lines"])
def test_poses_of_the_sliders_are_solved_or_say_that_they_are_not(name):
    scene = robot_scene(load(name))
    states, (x, y, z) = scene.states, scene.states.lattice
    assert len(states) == len(x) * len(y) * len(z) == len(states.notes)
    found = rest_pose(load(name)).lattice.found
    at_rest = np.array([note.startswith("At rest") for note in states.notes])
    assert at_rest[states.shown]
    assert (at_rest == found.ok).all()
    assert (found.residual_norm()[at_rest] < 1e-6).all()
    assert (np.isfinite(states.tensions).all(axis=1) == at_rest).all()
    nozzles = Model(load(name)).nozzle(states.poses[at_rest])
    chosen = np.array([(a, b, c) for c in z for b in y for a in x])[at_rest]
    decided = [len(axis) > 1 for axis in (x, y, z)]
    assert np.allclose(nozzles[:, decided], chosen[:, decided], atol=1e-9)


def test_a_robot_that_holds_nothing_says_so():
    robot = load("house-printer")
    tight = robot.limited((5000.0, 5100.0))
    found = rest_pose(tight)
    assert not found.held
    assert found.note.startswith("not in equilibrium")
    assert "Not in equilibrium" in robot_scene(tight).notes[0]


@pytest.mark.parametrize("name", library_names())
def test_lines_end_on_the_platform_and_leave_their_sheaves(name):
    scene = robot_scene(load(name))
    states, robot, k = scene.states, scene.robot, scene.states.shown
    points = placed(states.poses[k], [line.platform_point for line in robot.lines])
    for line, curve, point, sheave in zip(robot.lines, states.curves[k], points, states.sheaves[k], strict=True):
        assert np.linalg.norm(curve[-1] - point) < 1e-6 + (line.platform_sheave is not None)
        if line.sheave.kind == "eyelet":
            assert np.isnan(sheave).all()
            assert np.linalg.norm(curve[0] - line.exit_point) < 1e-9
        else:  # the cable leaves the sheave on its circle, along a tangent, in its plane
            away, along = curve[0] - sheave[:3], curve[1] - curve[0]
            assert np.linalg.norm(away) == pytest.approx(line.sheave.radius, abs=1e-9)
            assert abs(away @ along) < 2e-2 * np.linalg.norm(away) * np.linalg.norm(along)
            assert abs(away @ sheave[3:]) < 1e-9


def test_a_line_sags_as_its_weight_has_it():
    """At the lowest point of a span between two heights the horizontal force is weight times radius of curvature."""
    found = inverse(load("wang2021"), [0.0, 0.0, 1.2])
    curve = States.held(found).curves[0][1]
    ends, middle = curve[[0, -1]], curve[len(curve) // 2]
    chord = ends[0] + (ends[1] - ends[0]) * np.linalg.norm((middle - ends[0])[:2]) / np.linalg.norm(
        (ends[1] - ends[0])[:2]
    )
    way = np.linalg.norm((ends[1] - ends[0])[:2])
    share = np.linalg.norm((middle - ends[0])[:2])
    weight = found.model.lines.weight[1]
    horizontal = found.tensions[1] * np.cos(found.line_states.free_angle[1])
    parabola = weight * np.linalg.norm(ends[1] - ends[0]) / way * share * (way - share) / (2 * horizontal)
    assert chord[2] - middle[2] == pytest.approx(parabola, rel=0.05)


def test_lines_by_their_length_hang_as_at_rest():
    robot = load("merlet2023")
    found = inverse(robot, [[0.3, -0.5, 1.0], [-0.4, 0.8, 1.4]])
    states = hanging_lines(Model(robot), found.pose, found.lengths)
    assert np.allclose(np.exp(states[..., 1]), found.tensions, rtol=1e-5)
    longer = hanging_lines(Model(robot), found.pose, found.lengths + 0.05)
    assert (np.exp(longer[..., 1]) < 0.5 * found.tensions).all()


def test_the_scene_as_json_has_what_it_was_made_of():
    scene = robot_scene(load("jung2020"))
    data = json.loads(scene.as_json())
    low, step = (
        np.array(data["bounds"]["low"]),
        max(np.subtract(data["bounds"]["high"], data["bounds"]["low"])) / 65_535,
    )
    curves = unpacked(data["frames"]["curves"]) * step + low
    k = scene.states.shown
    assert np.abs(curves[k, 3, 0] - scene.states.curves[k][3][0]).max() <= step
    assert np.allclose(unpacked(data["frames"]["tensions"]), scene.states.tensions, rtol=1e-6)
    assert data["lines"][0]["limits"] == list(scene.robot.lines[0].tension_limits)


def test_names_with_markup_stay_text():
    robot = load("wang2021")
    evil = "</script><img src=x onerror=alert(1)>"
    line = robot.lines[0].model_copy(update={"name": evil})
    named = robot.model_copy(update={"name": f"<b>{evil}", "lines": (line, *robot.lines[1:])})
    page = show_page(robot_scene(named))
    assert "<img src=x" not in page
    assert evil in json.loads(re.search(r'id="scene">(.*?)</script>', page, re.S)[1])["lines"][0]["name"]


def test_terms_leave_data_and_pictures_alone():
    scene = robot_scene(load("wang2021"))
    page = "".join(with_terms([view(scene)]))
    assert json.loads(re.search(r'id="scene">(.*?)</script>', page, re.S)[1])["title"] == "wang2021"


def test_a_job_is_shown_along_its_path():
    job = load_job(ROOT / "examples" / "helix.toml")
    scene = job_scene(load("house-printer"), job)
    assert len(scene.states) == len(chosen(len(scene.path.positions), scene.path.time))
    nozzles = scene.states.poses[:, :3]
    assert np.allclose(nozzles, scene.path.positions[scene.states.samples], atol=1e-9)
    data = json.loads(scene.as_json())
    assert unpacked(data["frames"]["fileLines"]).tolist() == scene.path.line[scene.states.samples].tolist()


def test_a_check_is_shown_with_its_own_tensions_and_its_worst_place(tmp_path):
    check, _ = make_check(ring_robot(4), small_job(tmp_path))
    scene = check_scene(check)
    worst = scene.path.worst
    assert worst in scene.states.samples
    assert scene.states.samples[scene.states.shown] == worst
    assert np.array_equal(scene.states.tensions, check.statics.tensions[scene.states.samples], equal_nan=True)


def test_states_are_the_first_the_last_and_the_worst():
    at = chosen(1000, np.linspace(0, 10, 1000), worst=777, most=20)
    assert {0, 777, 999} <= set(at.tolist())
    assert len(at) <= 23


def test_a_pose_that_cannot_be_held_is_reported():
    found = inverse(load("wang2021"), [0.0, 0.0, 40.0])
    scene = one_state(found, "high", f"not in equilibrium: {found.sentence()}")
    assert not found.ok
    assert "ot in equilibrium" in scene.notes[0]
    json.loads(scene.as_json())


def test_colours_are_those_of_pictures():
    for name, (key, low, high) in {"error": ("plasma", 0.0, 0.82), "tension": ("viridis", 0.0, 0.85)}.items():
        expected = [to_hex(each) for each in mpl.colormaps[key](np.linspace(low, high, 16))]
        assert list(RAMPS[name]["light"]) == expected


def test_the_program_asks_for_nothing_of_others():
    text = script()
    assert "</script" not in text
    assert len(text) < 700_000
    assert not re.search(r"\beval\(|innerHTML|document\.write|new Function", text)


def test_the_program_is_of_the_version_that_is_locked():
    wanted = json.loads((ROOT / "tools" / "viewer" / "package.json").read_text("utf-8"))["dependencies"]["three"]
    locked = json.loads((ROOT / "tools" / "viewer" / "package-lock.json").read_text("utf-8"))
    assert locked["packages"]["node_modules/three"]["version"] == wanted
    assert script().startswith(f"/* Built by tools/viewer/build.mjs. Contains three.js {wanted}, MIT")


def test_the_licence_is_beside_the_program():
    folder = ROOT / "src" / "cablewright" / "apps" / "web" / "viewer"
    assert "MIT" in (folder / "LICENSE-three.txt").read_text("utf-8")
