"""Interference at poses: sagging lines against dense sampling, what is shared, signs, and what must not matter."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

import cases
from cablewright.analyses import interference as analysis
from cablewright.analyses.interference import Interference, InterferenceSettings, distances, free_region
from cablewright.foundation.errors import InputError
from cablewright.foundation.triangle_mesh import TriangleMesh
from cablewright.kernels import layout
from cablewright.kernels.statics.line.catenary import span
from cablewright.models.fidelity import Fidelity
from cablewright.models.obstacles import Obstacle, of_mesh
from cablewright.models.rotation import placed
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Beam, Box, PlatformPulley, PlatformSheave, Robot, load
from cablewright.solvers.inverse import solve_inverse

SEED = 20200613
FINE = 4000  # points of a densely sampled line
NAMES = ("house-printer", "cogiro", "jung2020", "merlet2023", "wang2021")


def dense(row: Equilibrium, count: int = FINE) -> list[np.ndarray]:
    """Points (count, 3) of each free span, from the states and the platform points alone: by arc from its start."""
    lines, found = row.packed.lines[0], []
    for own, y, exit_line, point in zip(lines, row.states, row.model.robot.lines, row.platform_points, strict=True):
        t, phi = np.exp(y[layout.TAU]), y[layout.PHI]
        h, v = t * np.cos(phi), t * np.sin(phi)
        arcs = np.linspace(0.0, y[layout.FREE], count)
        own_shape = [span(h, v, arc, own[layout.WEIGHT], own[layout.FREE_COMPLIANCE])[:2] for arc in arcs]
        away = np.array(own_shape) - own_shape[-1]  # in the plane, from the platform point
        level = point[:2] - np.array(exit_line.exit_point)[:2]
        level /= np.linalg.norm(level)
        found.append(point + np.column_stack([away[:, :1] * level, away[:, 1]]))
    return found


def with_shapes(robot: Robot) -> Robot:
    """The robot with three beams across its frame and a body about its lines' ends."""
    low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    size = high - low
    ends = [((0.2, 0.0, 0.9), (0.2, 1.0, 0.9)), ((0.0, 0.6, 0.5), (1.0, 0.7, 0.6)), ((0.9, 0.9, 0.0), (0.8, 0.9, 1.2))]
    beams = tuple(
        Beam(start=tuple(low + size * np.array(a)), end=tuple(low + size * np.array(b)), radius=0.01 * (k + 1))
        for k, (a, b) in enumerate(ends)
    )
    boxes = (Box(lowest=(-0.1, -0.15, -0.3), highest=(0.12, 0.1, 0.05)),)
    scene, platform = robot.scene.model_copy(update={"beams": beams}), robot.platform
    update = {"scene": scene, "platform": platform.model_copy(update={"boxes": boxes})}
    return robot.model_copy(update=update)


def of_corners(triangles: np.ndarray) -> Obstacle:
    """A part of triangles (F, 3, 3), m."""
    return of_mesh(TriangleMesh.of_corners(triangles))


def hills(seed: int, count: int = 300, size: float = 0.3) -> Obstacle:
    """Scattered triangles above and about the floor."""
    rng = np.random.default_rng(seed)
    at = rng.uniform([-2.0, -2.0, 0.0], [2.0, 2.0, 1.5], (count, 1, 3))
    return of_corners(at + size * rng.normal(size=(count, 3, 3)))


def held(name: str, count: int = 6, **limits: object) -> Equilibrium:
    return cases.poses(Model(with_shapes(load(name)), **limits), count)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("tolerance", [1e-2, 1e-4])
def test_polylines_are_as_near_to_the_lines_as_they_say(name: str, tolerance: float) -> None:
    found = distances(held(name, 3), settings=InterferenceSettings(tolerance=tolerance))
    for row in range(3):
        for curve, real in zip(found.curves(row), dense(found.equilibrium[row]), strict=True):
            np.testing.assert_allclose(curve[[0, -1]], real[[0, -1]], atol=1e-8)
            assert off(real, curve) <= found.bounds[row] + 1e-9
    assert found.bounds.max() <= tolerance


@pytest.mark.parametrize("tolerance", [1e-7, 1e-9, 1e-15])
def test_too_few_points_report_the_required_number(tolerance: float) -> None:
    found = distances(held("house-printer", 3), settings=InterferenceSettings(tolerance=tolerance))
    for row in range(3):
        assert tolerance < found.bounds[row] < 1e-3
        for curve, real in zip(found.curves(row), dense(found.equilibrium[row]), strict=True):
            assert len(curve) > 32
            assert off(real, curve) <= found.bounds[row] + 1e-9


def off(points: np.ndarray, curve: np.ndarray) -> float:
    """Largest distance of any of *points* from a polyline."""
    least = np.full(len(points), np.inf)
    for p, q in pairwise(curve):
        way = q - p
        t = np.clip((points - p) @ way / max(way @ way, 1e-300), 0.0, 1.0)
        least = np.minimum(least, np.linalg.norm(points - p - t[:, None] * way, axis=1))
    return float(least.max())


@pytest.mark.parametrize("limits", [(0.05, 5000.0), (1.0, 5000.0)])
def test_slack_lines_too(limits: tuple[float, float]) -> None:
    """wang2021 with next to no lowest tension: lines that hang below the platform, sampled to the stated error."""
    model = Model(load("wang2021"), tension_limits=limits)
    low, high = np.array(model.robot.scene.frame_min), np.array(model.robot.scene.frame_max)
    poses = np.random.default_rng(SEED).uniform(low + 0.1 * (high - low), high - 0.3 * (high - low), (40, 3))
    states = solve_inverse(model, poses)
    states = states[states.ok]
    found = distances(states, settings=InterferenceSettings(tolerance=1e-3))
    worst = 0.0
    for row in range(min(10, len(states.code))):
        for curve, real in zip(found.curves(row), dense(states[row], 1500), strict=True):
            assert off(real, curve) <= found.bounds[row] + 1e-9
            worst = max(worst, off(real, curve[[0, -1]]))
    assert worst > 1e-3  # chords alone would not have done
    assert found.bounds.max() <= 1e-3


@pytest.mark.parametrize("name", NAMES)
def test_distances_are_those_of_dense_lines_within_the_bound(name: str) -> None:
    states = held(name, 2)
    settings = InterferenceSettings(tolerance=2e-3)
    found = distances(states, part=hills(SEED), settings=settings)
    robot = states.model.robot
    radii = np.array([0.5 * line.cable.diameter for line in robot.lines])
    for row in range(2):
        lines = dense(states[row])
        steps = max(np.linalg.norm(np.diff(line, axis=0), axis=1).max() for line in lines)
        wanted = dense_margins(robot, states[row], lines, radii, settings.ends)
        allowed = [2.0 * found.bounds[row], found.bounds[row], found.bounds[row]]
        for kind in range(3):
            assert found.margins[row, kind] == pytest.approx(wanted[kind], abs=allowed[kind] + steps + 1e-9)


def dense_margins(robot, row: Equilibrium, lines, radii, ends: float) -> list[float]:
    """Smallest distances of densely sampled lines from each other, the body and the beams."""
    cut = []
    for line, free in zip(lines, row.states[:, layout.FREE], strict=True):
        arc = np.linspace(0.0, free, len(line))
        cut.append((line, arc >= min(ends, 0.5 * free), arc <= free - min(ends, 0.5 * free)))
    among = body = frame = np.inf
    for i, (line, beyond, before) in enumerate(cut):
        for j in range(i):
            one, two = robot.lines[i], robot.lines[j]
            both = []
            for own, late, early in (cut[i], cut[j]):
                kept = np.ones(len(own), bool)
                kept &= late if one.exit_point == two.exit_point else True
                kept &= early if one.platform_point == two.platform_point else True
                both.append(own[kept])
            among = min(among, cKDTree(both[0]).query(both[1])[0].min() - radii[i] - radii[j])
        local = line[before] - row.pose[:3]
        if len(row.pose) == 6:
            local = Rotation.from_rotvec(row.pose[3:]).inv().apply(local)
        for box in robot.platform.boxes:
            middle, half = np.add(box.highest, box.lowest) / 2, np.subtract(box.highest, box.lowest) / 2
            past = np.abs(local - middle) - half
            signed = np.linalg.norm(np.maximum(past, 0.0), axis=1) + np.minimum(past.max(axis=1), 0.0)
            body = min(body, signed.min() - radii[i])
        for beam in robot.scene.beams:
            a, b = np.array(beam.start), np.array(beam.end)
            t = np.clip((line[beyond] - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
            away = np.linalg.norm(line[beyond] - a - t[:, None] * (b - a), axis=1)
            frame = min(frame, away.min() - beam.radius - radii[i])
    return [float(among), float(body), float(frame)]


@pytest.mark.parametrize("name", ["house-printer", "cogiro"])
def test_a_tree_finds_what_trying_every_triangle_finds(name: str) -> None:
    states = held(name, 40)
    part = hills(SEED + 1)
    found = distances(states, part=part)
    least = np.full(40, np.inf)
    for triangle in part.solid.pieces[:, :9].reshape(-1, 1, 3, 3):
        least = np.minimum(least, distances(states, part=of_corners(triangle)).margins[:, 3])
    np.testing.assert_array_equal(found.margins[:, 3], least)
    alone = [distances(states[row : row + 1], part=part).margins[0, 3] for row in range(40)]
    np.testing.assert_array_equal(found.margins[:, 3], alone)  # what the row before found is a hint, no more


def test_what_has_grown_counts_and_no_more() -> None:
    """A wall of two triangles that grows: to every height it is the wall that is built to there."""
    states = held("house-printer", 20)
    wall = np.array([[[-3, 1, 0], [3, 1, 0], [3, 1, 9]], [[-3, 1, 0], [3, 1, 9], [-3, 1, 9]]], dtype=float)
    part = of_corners(wall)
    for height in (-1.0, 0.5, 3.0, 7.0, 20.0):
        found = distances(states, part=part, now=height).margins[:, 3]
        if height < 0.0:
            assert (found == np.inf).all()
            continue
        low = wall.copy()
        low[:, :, 2] = np.minimum(low[:, :, 2], height)
        low[0, 2, 0] = 3.0
        built = distances(states, part=of_corners(low)).margins[:, 3]
        np.testing.assert_allclose(found, built, atol=1e-12)
    rising = distances(states, part=part, now=np.linspace(0.0, 9.0, 20)).margins[:, 3]
    one = [distances(states[k : k + 1], part=part, now=z).margins[0, 3] for k, z in enumerate(np.linspace(0, 9, 20))]
    np.testing.assert_array_equal(rising, one)


@pytest.mark.parametrize("name", ["house-printer", "cogiro"])
def test_where_the_machine_stands_and_faces_does_not_matter(name: str) -> None:
    robot, angle, by = with_shapes(load(name)), 0.7, np.array([3.0, -2.0, 0.5])
    turn = Rotation.from_rotvec([0.0, 0.0, angle])

    def moved(point):
        return tuple(float(x) for x in turn.apply(point) + by)

    lines = tuple(
        line.model_copy(
            update={"exit_point": moved(line.exit_point)}
            | ({} if line.winch_exit is None else {"winch_exit": moved(line.winch_exit)})
        )
        for line in robot.lines
    )
    beams = tuple(
        beam.model_copy(update={"start": moved(beam.start), "end": moved(beam.end)}) for beam in robot.scene.beams
    )
    scene = robot.scene.model_copy(update={"beams": beams})
    platform = robot.platform
    if robot.n == 3:  # its body does not turn with it
        platform = platform.model_copy(update={"boxes": ()})
        robot = robot.model_copy(update={"platform": platform})
    other = robot.model_copy(update={"lines": lines, "scene": scene})
    states = cases.poses(Model(robot), 5)
    poses = states.pose.copy()
    poses[:, :3] = turn.apply(poses[:, :3]) + by
    if robot.n == 6:
        poses[:, 3:] = (turn * Rotation.from_rotvec(poses[:, 3:])).as_rotvec()
    triangles = hills(SEED + 2).solid.pieces[:, :9].reshape(-1, 3)
    here = distances(states, part=of_corners(triangles.reshape(-1, 3, 3)))
    there = distances(
        solve_inverse(Model(other), poses), part=of_corners((turn.apply(triangles) + by).reshape(-1, 3, 3))
    )
    np.testing.assert_allclose(there.margins, here.margins, atol=1e-6)


def test_a_beam_is_touched_as_deep_as_it_is_pushed_in() -> None:
    """A straight line and a beam across it: the margin falls by the motion of the beam, through zero."""
    robot = load("cogiro")
    model = Model(robot, Fidelity.of("elastic", "eyelet"))
    states = solve_inverse(model, [0.0, 0.0, 1.0])
    a, b = np.array(robot.lines[0].exit_point), states.platform_points[0]
    across = np.cross(b - a, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across)
    up = np.cross(across, (b - a) / np.linalg.norm(b - a))
    thick = 0.5 * robot.lines[0].cable.diameter
    for away in (0.05, 0.0303, 0.03, 0.01):
        middle = 0.3 * a + 0.7 * b + away * up
        beam = Beam(start=tuple(middle - 0.1 * across), end=tuple(middle + 0.1 * across), radius=0.03)
        other = robot.model_copy(update={"scene": robot.scene.model_copy(update={"beams": (beam,)})})
        found = distances(solve_inverse(Model(other, model.fidelity), [0.0, 0.0, 1.0]))
        assert found.margins[0, 2] == pytest.approx(away - 0.03 - thick, abs=1e-9)
        contact = found.nearest("frame")
        assert (contact.line, contact.other) == (robot.lines[0].name, "beam 1")
        np.testing.assert_allclose(contact.place, 0.3 * a + 0.7 * b, atol=1e-9)


def test_a_body_about_the_ends_of_lines_is_measured_beyond_the_ends() -> None:
    robot = with_shapes(load("house-printer"))
    body = (Box(lowest=(-0.3, -0.3, -0.3), highest=(0.3, 0.3, 0.3)),)
    robot = robot.model_copy(update={"platform": robot.platform.model_copy(update={"boxes": body})})
    states = solve_inverse(Model(robot), [1.0, 2.0, 3.0])
    deep = [distances(states, settings=InterferenceSettings(ends=ends)).margins[0, 1] for ends in (0.0, 0.1, 0.2, 1.0)]
    assert deep[0] == pytest.approx(-0.302, abs=1e-3)
    assert deep[0] < deep[1] < deep[2] < 0.0 < deep[3]


def test_lines_of_one_end_are_as_far_apart_as_their_angle_says() -> None:
    """Straight lines from a point: at the distance e from it, 2 e sin(angle / 2) apart."""
    model = Model(load("wang2021"), Fidelity.of("elastic", "eyelet"))
    states = solve_inverse(model, [0.1, -0.2, 1.0])
    away = np.array([line.exit_point for line in model.robot.lines]) - states.pose
    away /= np.linalg.norm(away, axis=1)[:, None]
    angle = min(np.arccos(away[i] @ away[j]) for i in range(4) for j in range(i))
    for ends in (0.05, 0.3):
        found = distances(states, settings=InterferenceSettings(ends=ends))
        thick = model.robot.lines[0].cable.diameter
        assert found.margins[0, 0] == pytest.approx(2.0 * ends * np.sin(0.5 * angle) - thick, rel=1e-3)


def test_nothing_there_is_inf_and_no_answer_is_nan() -> None:
    model = Model(load("house-printer"))
    states = solve_inverse(model, [[0.0, 0.0, 1.0], [0.0, 0.0, 20.0], [1.0, 0.0, 1.0]])
    found = distances(states)
    assert np.isfinite(found.margins[[0, 2], 0]).all()
    assert (found.margins[[0, 2], 1:] == np.inf).all()
    assert np.isnan(found.margins[1]).all()
    assert np.isnan(found.smallest[1])
    assert found.nearest("part") is None
    assert found.nearest().row in (0, 2)
    assert [len(curve) for curve in found.curves(1)] == [0] * 4


def test_a_pose_of_a_batch_is_that_pose_alone() -> None:
    model = Model(with_shapes(load("cogiro")))
    poses = np.vstack([cases.poses(model, 5).pose, [[0.0, 0.0, 90.0, 0.0, 0.0, 0.0]]])
    held = solve_inverse(model, poses)
    found = np.where(held.ok, distances(held, part=hills(SEED + 3)).smallest, np.nan)
    assert found.shape == (6,)
    assert np.isfinite(found[:5]).all()
    assert np.isnan(found[5])
    single = distances(solve_inverse(model, poses[0]), part=hills(SEED + 3))
    assert isinstance(single, Interference)
    assert found[0] == single.smallest[0]


def test_the_free_region_ends_on_top_of_a_block() -> None:
    """Above a wide low block the nozzle is free just over it; far aside at any height."""
    block = np.array([[[-1, -1, 1], [1, -1, 1], [1, 1, 1]], [[-1, -1, 1], [1, 1, 1], [-1, 1, 1]]], dtype=float)
    model = Model(load("house-printer"))
    found = free_region(model, of_corners(block), (-6, -6, 0.5), (6, 6, 2.5), (13, 13, 21), clearance=0.01)
    floor = found.floor
    assert floor[6, 6] == pytest.approx(1.0, abs=0.11)
    assert floor[0, 0] == 0.5
    assert 0.0 < found.fraction < 1.0
    np.testing.assert_array_equal(found.free, found.margins >= 0.01)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [({"ends": -1.0}, "ends = -1 m"), ({"ends": np.nan}, "ends"), ({"tolerance": 0.0}, "tolerance = 0 m")],
)
def test_settings_are_lengths(arguments: dict[str, float], says: str) -> None:
    with pytest.raises(InputError, match=says):
        InterferenceSettings(**arguments)


def test_a_region_without_a_volume_or_with_too_many_nodes_is_rejected() -> None:
    model, part = Model(load("house-printer")), hills(0, 3)
    with pytest.raises(InputError, match="lowest corner below"):
        free_region(model, part, (0, 0, 1), (1, 1, 1))
    with pytest.raises(InputError, match="2 or more each"):
        free_region(model, part, (0, 0, 0), (1, 1, 1), (1, 5, 5))
    with pytest.raises(InputError, match=f"at most {analysis.MAX_NODES}"):
        free_region(model, part, (0, 0, 0), (1, 1, 1), (1000, 1000, 1000))


def test_a_platform_point_is_where_its_line_ends() -> None:
    states = held("cogiro", 2)
    points = placed(states.pose, [line.platform_point for line in states.model.robot.lines])
    for row in range(2):
        for curve, point in zip(distances(states).curves(row), points[row], strict=True):
            np.testing.assert_allclose(curve[-1], point, atol=1e-8)


def crossed(**cable: float) -> Equilibrium:
    """Return a body in a vertical plane, whose upper lines cross in it, at rest."""
    points = {"a": (-1.0, 0.2), "b": (1.0, -0.2), "c": (-1.0, -0.2), "d": (1.0, 0.2)}
    own = {"axial_stiffness": 1e6, "breaking_load": 1e4, "linear_density": 0.03} | cable
    lines = [
        {
            "name": name,
            "exit_point": (x, 0.0, 2.0 if name in "ab" else 0.0),
            "platform_point": (end, 0.0, 0.1 if name in "ab" else -0.1),
            "cable": own,
            "sheave": {"kind": "eyelet"},
            "tension_limits": (1.0, 1e4),
        }
        for name, (x, end) in points.items()
    ]
    table = {
        "name": "crossed",
        "scene": {"frame_min": (-1.0, -1.0, 0.0), "frame_max": (1.0, 1.0, 2.0)},
        "platform": {
            "kind": "rigid",
            "mass": 200.0,
            "centre_of_mass": (0.0, 0.0, -0.5),
            "plane": {"normal": (0.0, 1.0, 0.0)},
        },
        "lines": lines,
    }
    return solve_inverse(Model(Robot.model_validate(table)), np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]))


def test_crossing_lines_without_a_diameter_touch() -> None:
    """They have that of a round of 970 kg/m^3 with their mass: 6.28 mm of 0.03 kg/m."""
    found = distances(crossed()[None])
    assert found.contacts.line.margin == pytest.approx(-6.275e-3, abs=1e-5)
    assert found.status == "touching"
    assert "assumed by the cable's mass, up to 6.28 mm" in found.notes[0]
    given = distances(crossed(diameter=2e-3)[None])
    assert given.contacts.line.margin == pytest.approx(-2e-3, abs=1e-5)
    assert given.notes == ()


def over_wheels(kinds: str) -> Robot:
    """CoGiRo with a sheave on the platform for each line, swivels or pulleys, and beams among them."""
    robot = load("cogiro")
    lines = []
    for i, line in enumerate(robot.lines):
        own = {"radius": 0.06 + 0.01 * i, "axis": (0.1 * i - 0.3, 0.2, -1.0)}
        if kinds == "pulleys":
            towards = np.array(line.exit_point) - [0.0, 0.0, 1.0]
            axis = np.cross(towards, [0.0, 0.0, 1.0]) + 0.1
            own |= {"axis": tuple(axis), "leaves": tuple(np.cross(axis, towards))}
        kind = PlatformPulley if kinds == "pulleys" else PlatformSheave
        lines.append(line.model_copy(update={"platform_sheave": kind(**own)}))
    beams = (Beam(start=(-2.0, 1.3, 1.2), end=(2.0, 0.9, 1.7), radius=0.02),)
    scene = robot.scene.model_copy(update={"beams": beams})
    return robot.model_copy(update={"lines": tuple(lines), "scene": scene})


def disc_points(row: Equilibrium, i: int, contact: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Points of the sheave of line *i*, world, that its cable meets at *contact* after *before*: on its rim."""
    line = row.model.robot.lines[i]
    sheave, R = line.platform_sheave, Rotation.from_rotvec(row.pose[3:])
    point, axis = row.platform_points[i], R.apply(np.array(sheave.axis) / np.linalg.norm(sheave.axis))
    centre, normal = point, axis
    if isinstance(sheave, PlatformSheave):
        out = contact - point - axis * (axis @ (contact - point))
        out /= np.linalg.norm(out)
        centre, normal = point + sheave.radius * out, np.cross(axis, out)
        assert abs((contact - before) @ normal) < 1e-4  # the plane of the sheave has its cable, but for its sag
    assert np.linalg.norm(contact - centre) == pytest.approx(sheave.radius, abs=1e-8)
    one = np.cross(normal, [0.3, 0.5, 0.9])
    one /= np.linalg.norm(one)
    two = np.cross(normal, one)
    r, turn = np.meshgrid(np.linspace(0.0, sheave.radius, 25), np.linspace(0.0, 2.0 * np.pi, 121))
    flat = (r * np.cos(turn)).reshape(-1, 1) * one + (r * np.sin(turn)).reshape(-1, 1) * two
    return centre + flat


@pytest.mark.parametrize("kinds", ["swivels", "pulleys"])
def test_sheaves_on_the_platform_are_discs_against_sampled_points(kinds: str) -> None:
    robot = over_wheels(kinds)
    poses = [[0.2, -0.3, 1.5, 0.02, -0.03, 0.1], [0.5, 0.6, 1.2, -0.05, 0.03, -0.2]]
    states = solve_inverse(Model(robot), poses)
    found = distances(states, settings=InterferenceSettings(tolerance=1e-5))
    bare = distances(states, settings=InterferenceSettings(tolerance=1e-5, ends=0.0))
    radii = [0.5 * line.cable.thickness for line in robot.lines]
    (beam,) = robot.scene.beams
    steel = np.array(beam.start) + np.linspace(0.0, 1.0, 2001)[:, None] * np.subtract(beam.end, beam.start)
    for row in range(len(poses)):
        curves = bare.curves(row)
        near: dict[tuple[str, int, int], float] = {}
        fine = [np.vstack([p + np.linspace(0, 1, 21)[:, None] * (q - p) for p, q in pairwise(c)]) for c in curves]
        for i, curve in enumerate(curves):
            disc = cKDTree(disc_points(states[row], i, curve[-1], curve[-2]))
            near["frame", i, 1] = disc.query(steel)[0].min() - beam.radius - radii[i]
            for j in set(range(robot.m)) - {i}:
                near["platform", j, i] = disc.query(fine[j])[0].min() - radii[i] - radii[j]
            to_beam = [np.linalg.norm(steel - p, axis=1).min() for p in fine[i]]
            near["frame", i, 0] = min(to_beam) - beam.radius - radii[i]
        for kind in ("platform", "frame"):
            of_kind = {key: value for key, value in near.items() if key[0] == kind}
            key = min(of_kind, key=of_kind.__getitem__)
            contact = found[row].nearest(kind)
            assert contact.margin == pytest.approx(of_kind[key], abs=3e-3)
            assert contact.margin <= of_kind[key] + 1e-5  # the samples are of the disc
            assert contact.line == robot.lines[key[1]].name
            other = f"platform sheave of line {robot.lines[key[2]].name}"
            assert contact.other == (other if kind == "platform" else f"beam 1{' at its platform sheave' * key[2]}")
