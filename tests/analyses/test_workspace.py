"""Workspaces with known answers, their laws, and agreement with the solvers that they use."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy.spatial import ConvexHull, cKDTree

import cases
from cablewright.analyses.feasibility import judge_pose
from cablewright.analyses.workspace.criterion import CRITERIA, Criterion, RetractionLaw
from cablewright.analyses.workspace.workspace import Workspace, count_nodes, workspace
from cablewright.foundation.errors import InputError
from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import Eyelet, Robot, load
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.tension import tension_distribution

RIGID = Fidelity.of("rigid")
JUNG = Model(load("jung2020"), RIGID)


def point_robot(exits: np.ndarray, limits: tuple[float, float], low: list[float], high: list[float]) -> Robot:
    """A point on lines through eyelets at *exits*, in a frame."""
    robot = load("merlet2023")
    lines = tuple(
        robot.lines[0].model_copy(
            update={
                "name": f"line {i}",
                "exit_point": tuple(map(float, place)),
                "winch_exit": None,
                "sheave": Eyelet(),
                "tension_limits": limits,
            }
        )
        for i, place in enumerate(exits)
    )
    scene = robot.scene.model_copy(update={"frame_min": tuple(low), "frame_max": tuple(high)})
    return robot.model_copy(update={"name": "points", "lines": lines, "scene": scene})


@pytest.mark.parametrize("count", [4, 6, 9])
def test_wrench_closure_of_a_point_is_the_hull_of_the_eyelets(count: int) -> None:
    """Any force can be balanced where the directions to the eyelets span all of space: inside their hull."""
    exits = np.random.default_rng(count).uniform(-1.0, 1.0, (count, 3))
    if count == 4:
        exits = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])
    robot = point_robot(exits, (0.0, 1.0), list(exits.min(axis=0) - 0.1), list(exits.max(axis=0) + 0.1))
    found = workspace(Model(robot, RIGID), "wrench-closure", tolerance=5e-3)
    assert found.converged
    assert found.mesh.is_closed
    assert abs(found.volume - ConvexHull(exits).volume) <= found.volume_error <= 5e-3 * found.volume


def test_a_box_of_eyelets_closes_all_of_its_inside() -> None:
    exits = np.array(list(product((-1.0, 1.0), repeat=3)))
    found = workspace(
        Model(point_robot(exits, (0.0, 1.0), [-1.5, -1.5, -1.0], [1.5, 1.5, 2.0]), RIGID), "wrench-closure"
    )
    assert abs(found.volume - 8.0) <= found.volume_error
    np.testing.assert_allclose(found.slices([-0.5, 0.0, 0.9, 1.1, 1.7]), [4, 4, 4, 0, 0], atol=0.01)


@pytest.mark.parametrize("criterion", ["exact", "improved-closed-form", "capacity"])
def test_a_point_hangs_below_its_ceiling_where_lines_may_pull_as_they_like(criterion: str) -> None:
    """Weight alone, limits of 0 and 1e9 N: the column below the hull of the eyelets, less 1e-6 of a slope."""
    exits = np.array([[-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [1.0, 1.0, 2.0], [-1.0, 1.0, 2.0]])
    robot = point_robot(exits, (0.0, 1e9), [-1.5, -1.5, 0.0], [1.5, 1.5, 3.0])
    found = workspace(Model(robot, RIGID), criterion)
    exact = criterion != "improved-closed-form"  # from tensions of 5e8 N it rounds and gives up more often
    if exact:
        assert abs(found.volume - 8.0) <= found.volume_error
    assert found.volume <= 8.0 + found.volume_error


def test_one_line_holds_its_point_only_straight_below() -> None:
    """A workspace without a volume, which lies on nodes: nothing to converge to, and it says so."""
    robot = point_robot(np.array([[0.0, 0.0, 2.0]]), (0.0, 1e3), [-1, -1, 0], [1, 1, 2])
    found = workspace(Model(robot, RIGID), "exact")
    assert found.volume <= found.volume_error < 1e-4
    assert not found.converged
    aside = workspace(Model(robot, RIGID), "exact", box=[0.1, 1, 0.1, 1, 0, 2])
    assert (aside.volume, len(aside.mesh.triangles)) == (0.0, 0)


def test_a_planar_robot_has_a_workspace_without_thickness() -> None:
    """All exit points in the plane y = 0: the search ends early, and the volume is nothing but error."""
    robot = point_robot(np.array([[-1.0, 0, 0], [1, 0, 0], [1, 0, 2], [-1, 0, 2]]), (10.0, 5e4), [-1, -1, 0], [1, 1, 2])
    found = workspace(robot, "exact")
    assert not found.converged
    assert found.volume <= found.volume_error
    assert found.nodes < 4_000_000
    assert found.mesh.is_closed
    np.testing.assert_allclose(found.mesh.vertices[:, 1], 0.0, atol=2.0 / max(found.cells))


def test_a_robot_is_looked_at_with_the_lines_that_suit_the_criterion() -> None:
    robot = load("jung2020")
    assert workspace(robot, "closed-form").volume == workspace(JUNG, "closed-form").volume
    static = count_nodes(robot, "static", grid=7)
    assert static.criterion.model == Model(robot)
    np.testing.assert_array_equal(static.inside, count_nodes(Model(robot), "static", grid=7).inside)


@pytest.mark.parametrize("orientations", [[], np.empty((0, 3))])
def test_without_any_orientation_nothing_is_inside(orientations: object) -> None:
    found = workspace(JUNG, "exact", orientations=orientations, retraction=RetractionLaw(-1.0, 2.4, 1.2, 2.0))
    assert (found.volume, len(found.mesh.triangles), found.converged) == (0.0, 0, True)
    assert found.slices([0.5, 1.0]).tolist() == [0.0, 0.0]
    assert count_nodes(JUNG, "exact", grid=5, orientations=orientations).counted == 0


def test_no_places_have_no_margins() -> None:
    for name in CRITERIA:
        law = RetractionLaw(-1.0, 2.4, 1.2, 2.0)
        assert Criterion.of(JUNG.robot, name, retraction=law).margin(np.empty((0, 3))).shape == (0,)


def scaled(robot: Robot, size: float, force: float) -> Robot:
    """Larger, heavier, and with stronger winches."""
    lines = tuple(
        line.model_copy(
            update={
                "exit_point": tuple(size * x for x in line.exit_point),
                "platform_point": tuple(size * x for x in line.platform_point),
                "tension_limits": tuple(force * x for x in line.tension_limits),
            }
        )
        for line in robot.lines
    )
    ends = {key: tuple(size * x for x in getattr(robot.scene, key)) for key in ("frame_min", "frame_max")}
    platform = robot.platform.model_copy(update={"mass": force * robot.platform.mass, "retraction": None})
    scene = robot.scene.model_copy(update=ends)
    return robot.model_copy(update={"lines": lines, "platform": platform, "scene": scene})


@pytest.mark.parametrize("criterion", ["closed-form", "exact"])
def test_a_larger_robot_has_a_workspace_larger_by_the_cube(criterion: str) -> None:
    small = workspace(JUNG, criterion)
    large = workspace(Model(scaled(JUNG.robot, 3.0, 7.0), RIGID), criterion)
    assert large.volume == pytest.approx(27.0 * small.volume, rel=1e-6)
    assert large.fraction == pytest.approx(small.fraction, rel=1e-6)
    assert large.mesh.area == pytest.approx(9.0 * small.mesh.area, rel=1e-4)


@pytest.fixture(scope="module", params=cases.some(["jung2020", "cogiro", "jung2020-table1"], 2))
def three(request: pytest.FixtureRequest) -> dict[str, Workspace]:
    model = Model(load(request.param), RIGID)
    told = 1e-2 if request.param == "cogiro" else 2e-3
    return {each: workspace(model, each, tolerance=told) for each in ("closed-form", "improved-closed-form", "exact")}


def test_volumes_agree_with_random_positions(three: dict[str, Workspace]) -> None:
    for criterion, found in three.items():
        places = found.box.at(np.random.default_rng(5).random((60_000, 3)))
        share = float((found.criterion.margin(places) >= 0.0).mean())
        spread = np.sqrt(share * (1.0 - share) / len(places))
        off = abs(found.volume - share * found.box.volume)
        assert off <= found.volume_error + 3.0 * spread * found.box.volume, criterion
        assert found.volume_error <= (1e-2 if found.criterion.model.robot.name == "cogiro" else 2e-3) * found.volume
        assert found.mesh.is_closed


def test_criteria_are_nested(three: dict[str, Workspace]) -> None:
    closed, improved, exact = three.values()
    assert closed.volume < improved.volume < exact.volume
    places = exact.box.at(np.random.default_rng(6).random((20_000, 3)))
    inside = [each.criterion.margin(places) >= 0.0 for each in (closed, improved, exact)]
    assert not (inside[0] & ~inside[1]).any()
    assert not (inside[1] & ~inside[2]).any()


def test_the_surface_is_where_the_margin_is_zero(three: dict[str, Workspace]) -> None:
    found = three["exact"]
    inner = ((found.mesh.vertices > found.box.low) & (found.mesh.vertices < found.box.high)).all(axis=1)
    vertices = found.mesh.vertices[inner]
    step = 0.02 * (found.box.high - found.box.low).max() / max(found.cells)
    ways = np.concatenate([np.eye(3), -np.eye(3)]) * 5 * step
    signs = np.stack([found.criterion.margin(vertices + way) >= 0.0 for way in ways])
    assert (signs.any(axis=0) & ~signs.all(axis=0)).mean() > 0.999


def test_files_in_single_precision_are_closed_too(three: dict[str, Workspace]) -> None:
    """Readers of STL join corners by their coordinates: no two vertices may become one."""
    for found in three.values():
        assert len(np.unique(found.mesh.vertices.astype(np.float32), axis=0)) == len(found.mesh.vertices)


def test_slices_make_up_the_volume(three: dict[str, Workspace]) -> None:
    found = three["closed-form"]
    low, high = found.box.low[2], found.box.high[2]
    middles = low + (high - low) * (np.arange(150) + 0.5) / 150
    assert found.slices(middles).sum() * (high - low) / 150 == pytest.approx(found.volume, rel=1e-3)
    assert found.slices([low - 0.1, high + 0.1]).tolist() == [0.0, 0.0]
    assert found.slices(low)[0] == pytest.approx(found.slices(low + 1e-6)[0], rel=1e-3)


def test_a_symmetric_robot_has_a_symmetric_surface() -> None:
    mesh = workspace(JUNG, "exact").mesh
    tree = cKDTree(mesh.vertices)
    for flip in ([-1, 1, 1], [1, -1, 1]):
        away, _ = tree.query(mesh.vertices * np.array(flip))
        assert away.max() < 1e-6


def test_refinement_and_a_fine_count_agree() -> None:
    found = workspace(JUNG, "exact")
    nodes = count_nodes(JUNG, "exact", grid=81)
    assert nodes.trapezoid_volume == pytest.approx(found.volume, rel=0.01)
    assert abs(nodes.volume - found.volume) < nodes.volume_error
    assert nodes.nodes == 81**3
    assert nodes.slices().sum() * 2.0 / 81 == pytest.approx(nodes.volume)


def test_a_count_is_that_of_the_tension_distribution() -> None:
    nodes = count_nodes(JUNG, "exact", grid=9)
    grid = np.stack(np.meshgrid(*nodes.axes, indexing="ij"), axis=-1).reshape(-1, 3)
    np.testing.assert_array_equal(nodes.inside.ravel(), tension_distribution(JUNG, grid, "exact").feasible)


TURNS = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.02], [0.1, 0.0, 0.0]]


def test_total_orientation_is_what_all_orientations_share() -> None:
    total = Criterion.of(JUNG, "exact", orientations=TURNS)
    places = cases.random_poses(JUNG, 3000)[:, :3]
    each = [Criterion.of(JUNG, "exact", orientations=[turn]).margin(places) for turn in TURNS]
    np.testing.assert_array_equal(total.margin(places), np.min(each, axis=0))
    volumes = [workspace(JUNG, "exact", orientations=[turn], tolerance=5e-3).volume for turn in TURNS]
    assert 0.0 < workspace(JUNG, "exact", orientations=TURNS, tolerance=5e-3).volume < min(volumes)


def test_a_box_of_wrenches_takes_from_the_workspace() -> None:
    none = workspace(JUNG, "capacity", tolerance=0.01)
    assert none.volume == pytest.approx(workspace(JUNG, "exact").volume, rel=0.012)
    sides = [-20.0, -20, -20, -0.1, -0.1, -0.1], [20.0, 20, 20, 0.1, 0.1, 0.1]
    some = workspace(JUNG, "capacity", wrench_box=sides, tolerance=0.01)
    assert 0.0 < some.volume < none.volume
    places = cases.random_poses(JUNG, 800)
    feasible = [
        tension_distribution(JUNG, places, "exact", wrench=corner).feasible
        for corner in product(*zip(*sides, strict=True))
    ]
    margins = some.criterion.margin(places[:, :3])
    np.testing.assert_array_equal(Criterion.of(JUNG, "capacity", wrench_box=sides).margin(places[:, :3]), margins)
    unturned = np.column_stack([places[:, :3], np.zeros((len(places), 3))])
    feasible = [
        tension_distribution(JUNG, unturned, "exact", wrench=corner).feasible
        for corner in product(*zip(*sides, strict=True))
    ]
    sure = np.abs(margins) > 1e-6
    np.testing.assert_array_equal((margins >= 0.0)[sure], np.all(feasible, axis=0)[sure])


def test_a_wrench_replaces_the_platforms_own() -> None:
    given = Criterion.of(JUNG, "exact", wrench=[0, 0, -50.0, 0, 0, 0])
    places = cases.random_poses(JUNG, 500)[:, :3]
    under = Model(JUNG.robot.under_wrench((0, 0, -50.0)), RIGID)
    np.testing.assert_array_equal(given.margin(places), Criterion.of(under, "exact").margin(places))


@pytest.mark.parametrize("name", ["house-printer", "jung2020"])
def test_static_is_where_the_inverse_problem_keeps_every_limit(name: str) -> None:
    model = Model(load(name))
    criterion = Criterion.of(model, "static")
    places = criterion.box.at(np.random.default_rng(3).random((100, 3)))
    held = [solve_inverse(model, pose) for pose in model.unrotated_at(places)]
    allowed = [bool(each.ok) and all(limit.violations == 0 for limit in judge_pose(each)) for each in held]
    assert 5 < sum(allowed) < 95
    np.testing.assert_array_equal(criterion.margin(places) >= 0.0, allowed)


def test_static_of_rigid_massless_lines_is_exact() -> None:
    places = cases.random_poses(JUNG, 2000)[:, :3]
    exact = Criterion.of(JUNG, "exact").margin(places)
    static = Criterion.of(JUNG, "static").margin(places)
    sure = np.abs(exact) > 1e-6
    np.testing.assert_array_equal((static >= 0.0)[sure], (exact >= 0.0)[sure])


def test_static_has_a_volume() -> None:
    found = workspace(Model(load("jung2020")), "static", grid=17)
    assert found.mesh.is_closed
    assert found.volume == pytest.approx(workspace(JUNG, "exact").volume, rel=0.03)  # short cables hardly sag


def test_the_point_is_the_nozzle_or_the_origin() -> None:
    """A nozzle 0.2 m below the origin: its workspace is that of the origin, lower."""
    robot = JUNG.robot
    platform = robot.platform.model_copy(update={"nozzle": (0.0, 0.0, -0.2)})
    low = Model(robot.model_copy(update={"platform": platform}), RIGID)
    nozzle = workspace(low, "exact", box=[-1, 1, -1, 1, -0.2, 1.8])
    origin = workspace(low, "exact", point="origin")
    assert nozzle.volume == pytest.approx(origin.volume, rel=1e-6)
    np.testing.assert_allclose(nozzle.slices([0.3, 0.8]), origin.slices([0.5, 1.0]), rtol=1e-6)


def test_a_retraction_is_that_of_the_retracted_robot() -> None:
    shorter = workspace(Model(JUNG.robot.retracted(1.4), RIGID), "exact")
    assert workspace(JUNG, "exact", retraction=1.4).volume == pytest.approx(shorter.volume, rel=1e-9)


@pytest.mark.parametrize("of", ["nozzle", "origin"])
def test_a_law_retracts_by_height(of: str) -> None:
    law = RetractionLaw(-1.0, 2.4, 1.2, 2.0, of)
    platform = JUNG.robot.platform.model_copy(update={"nozzle": (0.0, 0.0, -0.2)})
    model = Model(JUNG.robot.model_copy(update={"platform": platform}), RIGID)
    margins = Criterion.of(model, "exact", retraction=law, point="origin")
    for height in (0.2, 0.7, 1.1, 1.7):
        places = np.column_stack([np.random.default_rng(1).uniform(-1, 1, (100, 2)), np.full(100, height)])
        length = float(np.clip(2.4 - (height - (0.2 if of == "nozzle" else 0.0)), 1.2, 2.0))
        fixed = Criterion.of(model, "exact", retraction=length, point="origin")
        np.testing.assert_allclose(margins.margin(places), fixed.margin(places), rtol=1e-9)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"criterion": "feasible"}, "unknown criterion 'feasible'; allowed: capacity, closed-form"),
        ({"criterion": "exakt"}, "did you mean 'exact'"),
        ({"point": "tip"}, "unknown point 'tip'"),
        ({"grid": 0}, "grid 0: 3 to 400 nodes"),
        ({"grid": 401}, "3 to 400"),
        ({"grid": 11, "tolerance": 0.1}, "give one of them"),
        ({"tolerance": 0.0}, "tolerance 0: 1e-05 to 0.5"),
        ({"tolerance": float("nan")}, "tolerance nan"),
        ({"box": [0, 1, 2, 2, 1, 1]}, "y from 2 to 2 m"),
        ({"box": [0, 1, 0, 1, 1, 0.5]}, "z from 1 to 0.5 m"),
        ({"box": [0, 1, 0, 1]}, "6 finite numbers"),
        ({"box": [0, 1, 0, 1, 0, float("inf")]}, "6 finite numbers"),
        ({"orientations": [[0, 0, 3.2]]}, "3.2 rad (183.3 degrees); at most pi (180 degrees)"),
        ({"orientations": [[0, 0]]}, "orientations: 3 numbers"),
        ({"wrench_box": ([0] * 6, [1] * 6)}, "for the criterion capacity, not for exact"),
        ({"criterion": "capacity", "wrench_box": ([1] * 6, [0] * 6)}, "lowest <= highest"),
        ({"criterion": "capacity", "arm": 0.0}, "length 0 m"),
        ({"wrench": [0, 0]}, "wrench: 6 numbers"),
        ({"retraction": 2.5}, "retracts from 1.2 to 2 m"),
        ({"retraction": RetractionLaw(-1.0, 2.4)}, "leaves its range at height 0 m: retraction length 2.4 m"),
        ({"retraction": RetractionLaw(-0.6, 2.0)}, "at height 2 m: retraction length 0.8 m"),
        ({"retraction": RetractionLaw(-1.0, 2.4, 2.0, 1.2)}, "least < most"),
        ({"retraction": RetractionLaw(-1.0, 2.4, 1.2)}, "both clamps"),
        ({"retraction": RetractionLaw(-1.0, 2.4, 1.0, 2.0)}, "retraction length 1 m"),
        ({"retraction": RetractionLaw(float("nan"), 2.4, 1.2, 2.0)}, "finite numbers"),
        ({"retraction": RetractionLaw(-1.0, 2.4, 1.2, 2.0, "tip")}, "unknown point 'tip'"),
    ],
)
def test_bad_input_is_rejected(options: dict, says: str) -> None:
    with pytest.raises(InputError) as refusal:
        workspace(JUNG, **options)
    assert says in str(refusal.value)


def test_a_grid_goes_by_its_nodes_or_by_its_step() -> None:
    with pytest.raises(InputError, match="grid and step: give one of them, not both"):
        count_nodes(JUNG, "exact", grid=9, step=0.25)
    np.testing.assert_array_equal(
        count_nodes(JUNG, "exact", grid=9).inside, count_nodes(JUNG, "exact", step=0.25).inside
    )


def test_criteria_require_data_that_the_robot_has() -> None:
    with pytest.raises(InputError, match="catenary: exact requires straight lines"):
        workspace(Model(load("jung2020")), "exact")
    printer = Model(load("house-printer"), RIGID)
    with pytest.raises(InputError, match="point platform, which cannot rotate"):
        workspace(printer, "exact", orientations=[[0, 0, 0.1]])
    with pytest.raises(InputError, match="has no retraction"):
        workspace(printer, "exact", retraction=RetractionLaw(0.0, 1.0))
    assert len(CRITERIA) == 6
