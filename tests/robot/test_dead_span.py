"""The way of a cable over eyelets and wheels: against least lengths, closed forms, 30 digits and MuJoCo."""

from __future__ import annotations

from itertools import pairwise

import mujoco
import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from cablewright.foundation.errors import InputError
from cablewright.robot.dead_span import Arc, DeadSpan, Straight, dead_span
from cablewright.robot.sheave import GuideSheave
from cases import some
from oracles import wheel_paths

X = np.array([1.0, 0.0, 0.0])


def wheel(centre, axis, radius: float) -> GuideSheave:
    return GuideSheave(centre=tuple(map(float, centre)), axis=tuple(map(float, axis)), radius=float(radius))


def found_way(begin, wheels, end) -> DeadSpan:
    return dead_span(tuple(map(float, begin)), tuple(wheels), tuple(map(float, end)))


def chain(rng: np.random.Generator, count: int) -> tuple[list[np.ndarray], list[float], list[int]]:
    """Points of a zigzag in the plane y-z, radii, and the sense in which a cable turns at each inner one."""
    while True:
        points = [np.array([k + 0.2 * rng.normal(), 0.9 * rng.normal()]) for k in range(count + 2)]
        ways = [b - a for a, b in pairwise(points)]
        turns = [a[0] * b[1] - a[1] * b[0] for a, b in pairwise(ways)]
        if min(np.linalg.norm(way) for way in ways) > 0.7 and min(map(abs, turns)) > 0.35:
            return (
                points,
                [float(rng.uniform(0.05, 0.25)) for _ in turns],
                [int(np.sign(t)) for t in turns],
            )


def around(p: np.ndarray, q: np.ndarray, centre: np.ndarray, radius: float, sense: int) -> float:
    """Length of a taut string from *p* to *q* that passes a disc on one side of it, all in one plane."""
    (far, to), (near, on) = ((np.linalg.norm(x - centre), x - centre) for x in (p, q))
    turn = np.arctan2(sense * (to[0] * on[1] - to[1] * on[0]), to @ on) % (2 * np.pi)
    wrap = turn - np.arccos(radius / far) - np.arccos(radius / near)
    if wrap < 0.0:
        return float(np.linalg.norm(p - q))
    return float(np.sqrt(far**2 - radius**2) + np.sqrt(near**2 - radius**2) + radius * wrap)


def least_length(points: list[np.ndarray], radii: list[float], senses: list[int]) -> float:
    """Least length over all wheels: of strings over one wheel each, between points that may lie anywhere."""
    middles = np.array([0.5 * (a + b) for a, b in pairwise(points[1:-1])]).reshape(-1, 2)

    def length(free: np.ndarray) -> float:
        ends = [points[0], *free.reshape(-1, 2), points[-1]]
        parts = zip(pairwise(ends), points[1:-1], radii, senses, strict=True)
        return sum(around(*ends_, centre, radius, sense) for ends_, centre, radius, sense in parts)

    if not len(middles):
        return length(middles)
    at = minimize(length, middles.ravel(), method="BFGS", options={"gtol": 1e-9})
    at = minimize(length, at.x, method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-15, "maxiter": 4000})
    return float(at.fun)


@pytest.mark.parametrize("seed", some(range(12)))
def test_in_one_plane_the_length_is_the_least(seed: int) -> None:
    """Of 1 to 4 wheels in any plane, on which the cable turns either way."""
    rng = np.random.default_rng(seed)
    points, radii, senses = chain(rng, 1 + seed % 4)
    turn, shift = Rotation.from_rotvec(rng.normal(size=3)), rng.normal(size=3)
    placed = [turn.apply([0.0, *point]) + shift for point in points]
    wheels = [wheel(c, turn.apply(s * X), r) for c, s, r in zip(placed[1:-1], senses, radii, strict=True)]
    way = found_way(placed[0], wheels, placed[-1])
    assert way.length == pytest.approx(least_length(points, radii, senses), abs=1e-9)


@pytest.mark.parametrize("seed", some(range(12)))
def test_mujoco_takes_the_same_way(seed: int) -> None:
    """A tendon over cylinders, with a site on the side of each where the cable passes, and one between any two."""
    rng = np.random.default_rng(100 + seed)
    points, radii, senses = chain(rng, 1 + seed % 4)
    placed = [np.array([0.3, *point]) for point in points]
    wheels = [wheel(c, s * X, r) for c, s, r in zip(placed[1:-1], senses, radii, strict=True)]
    way = found_way(placed[0], wheels, placed[-1])
    straights = [piece for piece in way.pieces if isinstance(piece, Straight)]
    arcs = [piece for piece in way.pieces if isinstance(piece, Arc)]
    body, path = "", '<site site="s0"/>'
    sites = [placed[0], *(0.5 * (np.array(s.start) + s.end) for s in straights[1:-1]), placed[-1]]
    for k, (arc, each) in enumerate(zip(arcs, wheels, strict=True)):
        beside = np.array(each.centre) + 1.5 * (np.array(arc.at(0.5 * arc.angle)) - each.centre)
        body += (
            f'<geom name="g{k}" type="cylinder" size="{each.radius!r} 0.1" zaxis="1 0 0" pos="{numbers(each.centre)}"/>'
            f'<site name="b{k}" pos="{numbers(beside)}"/>'
        )
        path += f'<geom geom="g{k}" sidesite="b{k}"/><site site="s{k + 1}"/>'
    body += "".join(f'<site name="s{k}" pos="{numbers(at)}"/>' for k, at in enumerate(sites))
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody>{body}</worldbody><tendon><spatial>{path}</spatial></tendon></mujoco>"
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.ten_length[0] == pytest.approx(way.length, abs=1e-9)


def numbers(values) -> str:
    return " ".join(repr(float(value)) for value in values)


@pytest.mark.parametrize("senses", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
@pytest.mark.parametrize(("one", "two", "apart"), [(0.3, 0.1, 1.0), (0.05, 0.4, 0.46), (0.2, 0.2, 5.0)])
def test_open_and_crossed_tangents(senses: tuple[int, int], one: float, two: float, apart: float) -> None:
    """Between two wheels: the same sense has the outer tangent, opposite ones the inner."""
    begin, end = np.array([0.0, -0.5, 3.0 * senses[0]]), np.array([0.0, apart + 0.5, 3.0 * senses[1]])
    wheels = (wheel((0, 0, 0), senses[0] * X, one), wheel((0, apart, 0), senses[1] * X, two))
    middle = found_way(begin, wheels, end).pieces[2]
    gap = one - two if senses[0] == senses[1] else one + two
    assert isinstance(middle, Straight)
    assert middle.length == pytest.approx(np.sqrt(apart**2 - gap**2), abs=1e-12)


def in_space(rng: np.random.Generator, count: int = 3) -> tuple[np.ndarray, list[GuideSheave], np.ndarray]:
    """Wheels in planes of their own, about the axes that the turns of their centres have, or a little beside."""
    points = [np.array([k, 0.0, 0.0]) + 0.5 * rng.normal(size=3) for k in range(count + 2)]
    wheels = []
    for one, centre, two in zip(points, points[1:], points[2:], strict=False):
        axis = np.cross(centre - one, two - centre)
        wheels.append(wheel(centre, axis / np.linalg.norm(axis) + 0.15 * rng.normal(size=3), rng.uniform(0.03, 0.1)))
    return points[0], wheels, points[-1]


def stops_of(begin, wheels, end) -> list[wheel_paths.Stop]:
    return [np.array(begin), *((np.array(w.centre), np.array(w.axis), w.radius) for w in wheels), np.array(end)]


@pytest.mark.parametrize("seed", some(range(20)))
def test_in_space_both_ends_of_a_piece_are_tangent(seed: int) -> None:
    """As seen along each axis; length, mean height and contacts are those of the oracle."""
    begin, wheels, end = in_space(np.random.default_rng(seed))
    try:
        way = found_way(begin, wheels, end)
    except InputError as fault:
        pytest.skip(str(fault))
    straights = [piece for piece in way.pieces if isinstance(piece, Straight)]
    arcs = [piece for piece in way.pieces if isinstance(piece, Arc)]
    for (come, leave), arc, each in zip(pairwise(straights), arcs, wheels, strict=True):
        axis = np.array(each.axis) / np.linalg.norm(each.axis)
        for piece, touched, angle in ((come, come.end, 0.0), (leave, leave.start, arc.angle)):
            along = np.subtract(piece.end, piece.start) / piece.length
            arm = np.subtract(touched, each.centre) / each.radius
            assert abs(along @ arm) < 1e-12
            assert along @ np.cross(axis, arm) > 0.0
            assert abs(arm @ axis) < 1e-12
            np.testing.assert_allclose(arc.at(angle), touched, atol=1e-13)
    oracle = wheel_paths.way(stops_of(begin, wheels, end))
    assert way.length == pytest.approx(oracle.length, abs=1e-12)
    assert way.mean_height == pytest.approx(oracle.mean_height, abs=1e-12)
    np.testing.assert_allclose(way.last.start, oracle.comes_from, atol=1e-12)


@pytest.mark.parametrize("seed", some(range(20)))
def test_parallel_wheels_beside_each_other_have_the_tangents_of_circles(seed: int) -> None:
    """Seen along their axes, open or crossed; the way aside adds up at right angles."""
    rng = np.random.default_rng(seed)
    one, two, aside = rng.uniform(0.1, 0.5), rng.uniform(0.1, 0.5), rng.uniform(-0.3, 0.3)
    sense = 1 if seed % 2 else -1
    apart = (one + two) * rng.uniform(1.001, 2.0)
    wheels = (wheel((0, 0, 0), X, one), wheel((aside, apart, 0), sense * X, two))
    way = dead_span((0.0, -0.6, 3.0), wheels, (aside, apart + 0.6, 3.0 * sense))
    gap = one - sense * two
    assert way.pieces[2].length == pytest.approx(np.sqrt(apart**2 - gap**2 + aside**2), abs=1e-12)


def test_some_ways_in_space_are_found() -> None:
    kept = 0
    for seed in range(20):
        try:
            found_way(*in_space(np.random.default_rng(seed)))
            kept += 1
        except InputError:
            continue
    assert kept > 14


def test_small_wheels_are_eyelets() -> None:
    begin, wheels, end = in_space(np.random.default_rng(2))
    plain = dead_span(tuple(begin), tuple(each.centre for each in wheels), tuple(end)).length
    off = []
    for size in (1e-2, 1e-4, 1e-6):
        small = [each.model_copy(update={"radius": size * each.radius}) for each in wheels]
        off.append(abs(found_way(begin, small, end).length - plain))
    np.testing.assert_allclose(off[1:], [off[0] * 1e-2, off[0] * 1e-4], rtol=0.05)


@pytest.mark.parametrize("seed", some(range(8)))
def test_heights_and_moments_are_those_of_many_points(seed: int) -> None:
    rng = np.random.default_rng(seed)
    arm = rng.normal(size=3)
    arm /= np.linalg.norm(arm)
    ahead = np.cross(arm, rng.normal(size=3))
    ahead /= np.linalg.norm(ahead)
    arc = Arc((0.1, 0.2, 0.3 * seed), 0.4, tuple(arm), tuple(ahead), rng.uniform(0.1, 4.6))
    heights = np.array([arc.at(angle)[2] for angle in np.linspace(0.0, arc.angle, 200_001)])
    assert arc.heights == pytest.approx((heights.min(), heights.max()), abs=1e-9)
    assert arc.moment == pytest.approx(arc.length * 0.5 * np.mean(heights[:-1] + heights[1:]), abs=1e-9)


@pytest.mark.parametrize("flip", [False, True])
def test_the_world_can_be_turned_and_mirrored(flip: bool) -> None:
    """A mirror turns the sense of a rotation round."""
    begin, wheels, end = in_space(np.random.default_rng(2))
    turn = Rotation.from_rotvec([0.3, -0.8, 0.5]).as_matrix() @ np.diag([1.0, -1.0 if flip else 1.0, 1.0])
    moved = [wheel(turn @ w.centre, (-1 if flip else 1) * turn @ w.axis, w.radius) for w in wheels]
    there = found_way(turn @ begin, moved, turn @ end)
    assert there.length == pytest.approx(found_way(begin, wheels, end).length, abs=1e-12)


@pytest.mark.parametrize(
    ("guides", "why"),
    [
        ([((0, 0, 2), X, 0.3)], "exit_point is within the rim of guide 1, seen along its axis"),
        ([((0, 0, 0.1), X, 0.3)], "winch_exit is within the rim of guide 1, seen along its axis"),
        ([(0, 1, 1), ((0, 1.1, 1), X, 0.3)], "guide 1 is within the rim of guide 2"),
        (
            [((0, 1, 1), -X, 0.3)],
            "guide 1: the cable passes this wheel by, and would have to unwind by 65.5 deg from it",
        ),
        ([((0, 1, 1), -X, 0.3), ((0, 1.2, 1), X, 0.3)], "no straight cable leaves the rim of guide 1"),
        ([((0, 1, 1), -X, 0.3), ((0, 1, 1.1), -X, 0.5)], "no straight cable leaves the rim of guide 1"),
        ([((0, 1, 1), -X, 0.3), ((0, 1, 1), -X, 0.3)], "no straight cable leaves the rim of guide 1"),
        (
            [((0, 1, 1), X, 0.3), (0, 3, 3), ((0, 0.75, 0.5), X, 0.2)],
            "the cable from winch_exit to guide 1 goes through the wheel of guide 3",
        ),
        (
            [((0, 1, 1), X, 0.3), (0, 3, 3), ((0.05, 0.75, 0.5), (1, 1, 0), 0.2)],
            "the cable from winch_exit to guide 1 goes through the wheel of guide 3",
        ),
    ],
)
def test_rejections(guides: list, why: str) -> None:
    made = tuple(wheel(*each) if isinstance(each[1], np.ndarray | tuple) else each for each in guides)
    with pytest.raises(InputError, match=why):
        dead_span((0.0, 0.0, 0.0), made, (0.0, 0.0, 2.0))


def test_a_wheel_that_the_cable_only_touches_has_no_arc() -> None:
    way = dead_span((0.0, 0.0, 0.0), (wheel((0, 0.25, 1), -X, 0.25),), (0.0, 0.0, 2.0))
    assert way.length == pytest.approx(2.0, abs=1e-12)
    assert way.pieces[1].length == pytest.approx(0.0, abs=1e-9)
    assert way.drawn()[-1] == (0.0, 0.0, 2.0)


def test_a_wheel_beside_a_piece_is_not_in_its_way() -> None:
    guides = (wheel((0, 1, 1), X, 0.3), (0.0, 3.0, 3.0), wheel((0, 0.2, 3), X, 0.1))
    assert len(dead_span((0.0, 0.0, 0.0), guides, (0.0, 0.0, 2.0)).drawn()) > 10
