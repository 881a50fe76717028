"""Modes along the boundary of a workspace: their positions, their solutions, and their figures."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import planar_robots
from cablewright.analyses.modes import FREEDOMS, modes
from cablewright.analyses.workspace.boundary_frequencies import Boundary, boundary_modes, straight
from cablewright.analyses.workspace.criterion import RetractionLaw
from cablewright.foundation.errors import InputError
from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.robot.design_variables import Change
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.tension import tension_distribution

BEAM = Model(load("jung2020"), Fidelity.of("elastic"))
RIGID = replace(BEAM, fidelity=Fidelity.of("rigid"))


@pytest.fixture(scope="module")
def found() -> Boundary:
    return boundary_modes(BEAM, "closed-form", grid=11)


def test_places_are_inside_and_have_a_neighbour_that_is_not(found: Boundary) -> None:
    assert tension_distribution(RIGID, found.places, "closed-form").feasible.all()
    step = (found.nodes.box.high - found.nodes.box.low) / 10
    beyond = np.array(
        [found.places + sign * step * np.eye(3)[axis] for axis in range(3) for sign in (-1, 1)]
    )  # (6, N, 3)
    low, high = found.nodes.box.low - 1e-9, found.nodes.box.high + 1e-9
    outside = ((beyond < low) | (beyond > high)).any(axis=-1)
    no = ~tension_distribution(RIGID, beyond.reshape(-1, 3), "closed-form").feasible.reshape(outside.shape)
    assert (outside | no).any(axis=0).all()
    inner = found.nodes.counted - len(found.places)
    assert 0 < inner < found.nodes.counted


def test_a_box_all_within_has_its_sides_for_boundary() -> None:
    inside = boundary_modes(BEAM, "exact", grid=5, box=[-0.1, 0.1, -0.1, 0.1, 0.8, 1.0])
    assert (inside.nodes.counted, len(inside.places)) == (125, 125 - 27)


def test_modes_are_those_at_the_places(found: Boundary) -> None:
    own = modes(BEAM, found.places, preferred=np.full(8, 105.0))
    np.testing.assert_array_equal(found.lowest, own.lowest)
    assert found.spread == (own.lowest.min(), np.median(own.lowest), own.lowest.max())
    assert found.worst == own.lowest.argmin()
    names = [FREEDOMS[k] for k in own.dominant[:, 0]]
    assert found.shares == {name: pytest.approx(names.count(name) / len(names)) for name in set(names)}
    assert found.dominant == max(set(names), key=names.count)
    plain = boundary_modes(BEAM, "closed-form", grid=11, geometric=False)
    alone = modes(BEAM, found.places, preferred=np.full(8, 105.0), geometric=False)
    np.testing.assert_array_equal(plain.lowest, alone.lowest)
    assert plain.spread[0] < 0.5 * found.spread[0]


@pytest.mark.parametrize("mirror", [(-1, 1, 1), (1, -1, 1)])
def test_a_robot_that_is_its_mirror_image_has_the_same_on_either_side(found: Boundary, mirror: tuple[int, ...]) -> None:
    at = {tuple(np.round(place, 6) + 0.0): value for place, value in zip(found.places, found.lowest, strict=True)}
    other = [at[tuple(np.round(place * mirror, 6) + 0.0)] for place in found.places]
    np.testing.assert_allclose(other, found.lowest, rtol=1e-6)


def test_tensions_are_least_or_nearest_to_the_middle() -> None:
    least = boundary_modes(BEAM, "exact", grid=7)
    middle = boundary_modes(BEAM, "exact", grid=7, holding="middle")
    np.testing.assert_array_equal(least.places, middle.places)
    assert (least.holding, middle.holding) == ("least", "middle")
    np.testing.assert_allclose(least.modes.equilibrium.tensions, solve_inverse(BEAM, least.places).tensions)
    for found, about in ((least, 0.0), (middle, 105.0)):
        other = least if found is middle else middle
        own, theirs = (np.linalg.norm(each.modes.equilibrium.tensions - about, axis=1) for each in (found, other))
        assert (own <= theirs + 1e-6).all()
    tight = boundary_modes(replace(BEAM, tension_limits=(50.0, 150.0)), "exact", grid=7, holding="middle")
    assert tight.modes.equilibrium.tensions.min() >= 50.0 - 1e-6


def test_each_orientation_has_its_rows() -> None:
    turns = [[0.0, 0.0, 0.0], [0.05, 0.0, 0.0]]
    found = boundary_modes(BEAM, "exact", grid=9, orientations=turns)
    poses = found.modes.equilibrium.pose.reshape(2, -1, 6)
    assert len(found.lowest) == 2 * len(found.places)
    for turn, rows in zip(turns, poses, strict=True):
        np.testing.assert_array_equal(rows[:, 3:], np.broadcast_to(turn, (len(rows), 3)))
        np.testing.assert_allclose(BEAM.nozzle(rows), found.places, atol=1e-12)


def test_a_law_sets_the_length_of_each_row() -> None:
    law = RetractionLaw(-1.0, 2.4, 1.2, 2.0)
    found = boundary_modes(BEAM, "exact", grid=9, retraction=law)
    for k in (0, len(found.places) // 2):
        one = replace(BEAM, robot=BEAM.robot.retracted(float(law.at(found.places[k, 2]))))
        assert found.lowest[k] == pytest.approx(float(modes(one, found.places[k]).lowest), rel=1e-6)


def test_a_wrench_pulls_on_the_modes_too() -> None:
    found = boundary_modes(BEAM, "exact", grid=7, wrench=[0, 0, -100, 0, 0, 0])
    robot = BEAM.robot.under_wrench((0.0, 0.0, -100.0))
    own = boundary_modes(replace(BEAM, robot=robot), "exact", grid=7)
    np.testing.assert_array_equal(found.lowest, own.lowest)


def test_sag_is_in_the_modes_of_a_boundary_of_straight_lines() -> None:
    heavy = Change("linear_density").on(BEAM.robot, 0.05)
    model = Model(heavy, Fidelity.of("catenary"))
    assert straight(model).fidelity.cable.value == "rigid"
    assert straight(BEAM) is BEAM
    found = boundary_modes(model, "exact", grid=7)
    np.testing.assert_array_equal(found.places, boundary_modes(BEAM, "exact", grid=7).places)
    np.testing.assert_array_equal(found.lowest, modes(model, found.places).lowest)
    static = boundary_modes(model, "static", grid=7)
    assert static.modes.equilibrium.ok.all()
    assert len(static.places) <= len(found.places)


def test_a_wider_beam_is_stiffer_about_z() -> None:
    """The elastic yaw stiffness grows with the difference of top and bottom: with equal ones the robot is all but
    singular."""
    last = -1.0
    for width in (0.04, 0.08, 0.16):
        robot = Change("width-top-x+width-bottom-y").on(BEAM.robot, width)
        found = boundary_modes(replace(BEAM, robot=robot), "closed-form", grid=9, geometric=False)
        least = float(found.modes.stiffness.elastic[:, 5, 5].min())
        assert least > last
        last = least


@pytest.mark.parametrize(("plane", "body"), [("vertical", False), ("horizontal", True)])
def test_the_boundary_in_a_plane_is_in_it(plane: str, body: bool) -> None:
    """Each node once: inside, with a neighbour in the plane that is not; modes are those of poses in the plane."""
    robot = planar_robots.board(plane, body, force=(3.0, -2.0, 4.0))
    found = boundary_modes(robot, "exact", grid=5)
    at, step = robot.platform.plane, 1.0
    assert found.status == "ok"
    assert len(np.unique(found.places, axis=0)) == len(found.places)
    np.testing.assert_allclose([at.height(each) for each in found.places], 0.0, atol=1e-12)
    u, v, _ = planar_robots.frame(robot)
    ways = step * np.array([u, -u, v, -v])
    straight_model = Model.of(robot, cable="rigid")

    def inside(places: np.ndarray) -> np.ndarray:
        poses = np.hstack([places, np.zeros((len(places), robot.n - 3))])
        held = tension_distribution(straight_model, poses, "exact").feasible
        return held & (np.abs(places).max(axis=1) <= 2.0 + 1e-9)

    assert inside(found.places).all()
    for place in found.places:
        assert not inside(place + ways).all()
    rows = modes(solve_inverse(Model.of(robot), found.modes.equilibrium.pose))
    np.testing.assert_allclose(found.lowest[found.known], rows.lowest[found.known], rtol=1e-6)


def test_an_empty_workspace_has_no_modes() -> None:
    found = boundary_modes(BEAM, "exact", grid=5, box=[5, 6, 5, 6, 5, 6])
    assert (len(found.lowest), found.worst, found.dominant, found.shares) == (0, None, None, {})
    assert np.isnan(found.spread).all()


def test_a_point_platform_has_three_degrees_of_freedom() -> None:
    found = boundary_modes(Model(load("house-printer"), Fidelity.of("elastic")), "exact", grid=7)
    assert found.known.all()
    assert set(found.shares) <= set("xyz")


@pytest.mark.parametrize(
    ("robot", "given", "says"),
    [
        ("jung2020", {"holding": "most"}, "unknown tensions 'most'"),
        ("jung2020", {"grid": 122}, "3 to 121 nodes"),
        ("jung2020", {"grid": 2}, "grid 2: 3 to 121"),
        ("jung2020", {"criterion": "all"}, "unknown criterion"),
        ("grab-four-lines", {}, "fewer winches than degrees of freedom; not supported. Use modes at a pose"),
    ],
)
def test_bad_questions_are_rejected(robot: str, given: dict[str, object], says: str) -> None:
    with pytest.raises(InputError, match=says):
        boundary_modes(Model(load(robot), Fidelity.of("elastic")), **given)


@pytest.mark.parametrize("given", [{"orientations": []}, {"box": [5.0, 6.0, 5.0, 6.0, 5.0, 6.0]}])
def test_an_empty_workspace_has_an_empty_boundary(given: dict[str, object]) -> None:
    law = RetractionLaw(-1.0, 2.4, 1.2, 2.0)
    nothing = boundary_modes(BEAM, "exact", grid=5, retraction=law, **given)
    assert (len(nothing.places), len(nothing.lowest), nothing.worst, nothing.shares) == (0, 0, None, {})
    assert np.isnan(nothing.spread).all()
