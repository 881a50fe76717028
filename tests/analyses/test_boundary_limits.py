"""The static workspace and the limits on its boundary: what is inside is allowed, what ends it is broken beyond."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import cases
from cablewright.analyses.feasibility import broken_limits, judge_pose
from cablewright.analyses.sheave_ratio import sheave_rules
from cablewright.analyses.workspace.boundary_limits import CLOSE, BoundaryLimits, boundary_limits
from cablewright.analyses.workspace.workspace import count_nodes
from cablewright.foundation.errors import InputError
from cablewright.models.statics import Model
from cablewright.robot import Robot, load
from cablewright.solvers.inverse import inverse, solve_inverse

TENSION = ("lowest tension", "highest tension")


def framed(robot: Robot, low: tuple[float, ...], high: tuple[float, ...]) -> Robot:
    """*robot* in another frame."""
    return robot.model_copy(update={"scene": robot.scene.model_copy(update={"frame_min": low, "frame_max": high})})


def sheaved(robot: Robot, **changes: object) -> Robot:
    """*robot* with changed sheaves, each facing as it does."""
    lines = tuple(line.model_copy(update={"sheave": line.sheave.model_copy(update=changes)}) for line in robot.lines)
    return robot.model_copy(update={"lines": lines})


PATY = load("paty2021")
SWINGING = sheaved(load("house-printer"), swing=0.5)
LEVERED = sheaved(load("house-printer"), lever_range=(-1.4, -0.35))
WINCHED = cases.replaced(
    load("house-printer"), "winched", winch=load("house-printer").lines[0].winch.model_copy(update={"capacity": 33.0})
)
MODELS = {
    "paty2021": (Model(PATY), 1.25),
    "house-printer": (Model(load("house-printer")), 1.5),
    "looser": (Model(PATY, tension_limits=(100.0, 3000.0)), 1.25),
    "swinging": (Model(SWINGING), 1.25),
    "levered": (Model(LEVERED), 1.25),
    "winched": (Model(WINCHED), 1.25),
    "merlet2023": (Model(load("merlet2023")), 0.5),
    "cogiro": (Model(load("cogiro")), 1.4),
    "jung2020": (Model(load("jung2020")), 0.4),
}


def limited(model: Model, step: float) -> BoundaryLimits:
    """The limits that end the static workspace of *model*, by a grid of *step*, m."""
    return boundary_limits(count_nodes(model, "static", step=step))


@pytest.fixture(scope="module", params=MODELS)
def reached(request: pytest.FixtureRequest) -> tuple[Model, BoundaryLimits]:
    """A model and what ends its workspace."""
    model, step = MODELS[request.param]
    return model, limited(model, step)


def at(model: Model, places: np.ndarray) -> dict[str, np.ndarray]:
    """By limit, which of the *places* (N, 3) break it, each on its own: no place is its neighbour's start."""
    names, broken = broken_limits(solve_inverse(model, places))
    low, high = np.array(model.robot.scene.frame_min), np.array(model.robot.scene.frame_max)
    outside = ((places < low) | (places > high)).any(axis=1)
    return dict(zip((*names, "frame"), (*broken.T, outside), strict=True))


def test_every_node_inside_is_allowed_by_the_judge_and_no_other(reached: tuple[Model, BoundaryLimits]) -> None:
    model, found = reached
    inside = found.nodes.inside
    assert 20 < inside.sum() < inside.size
    places = found.nodes.box.grid(inside.shape)
    rng = np.random.default_rng(1)
    for wanted in (True, False):
        for place in rng.permutation(places[inside == wanted])[: cases.often(20, 60)]:
            held = solve_inverse(model, place)
            allowed = bool(held.ok) and all(one.violations == 0 for one in judge_pose(held))
            assert allowed == wanted, (place, judge_pose(held)[0])


def test_a_millimetre_beyond_the_boundary_its_limit_is_broken(reached: tuple[Model, BoundaryLimits]) -> None:
    model, found = reached
    assert not np.column_stack(list(at(model, found.points).values())).any()
    ways = np.concatenate([np.eye(3), -np.eye(3)]) * CLOSE
    steps = [at(model, found.points + way) for way in ways]
    names = np.array(found.limits)[found.ended_by]
    for limit in np.unique(names):
        mine = names == limit
        # where tensions would break a limit they may as well not balance at all, and the other way round
        names_of_it = TENSION if limit in TENSION else (limit,)
        assert np.any([step[one][mine] for step in steps for one in names_of_it], axis=0).all(), limit


def test_limits_sum_up_the_points(reached: tuple[Model, BoundaryLimits]) -> None:
    _, found = reached
    counts = [each.ends for each in found.by_limit]
    assert sum(counts) == len(found.points) == len(found.ended_by)
    assert counts == sorted(counts, reverse=True)
    for each in found.by_limit:
        own = found.points[np.array(found.limits)[found.ended_by] == each.limit]
        assert each.ends == len(own)
        assert each.lowest[2] == own[:, 2].min()
        assert each.highest[2] == own[:, 2].max()


def test_a_node_on_a_side_represents_half_a_cell(reached: tuple[Model, BoundaryLimits]) -> None:
    nodes = reached[1].nodes
    widths = [axis[1] - axis[0] for axis in nodes.axes]
    node = [np.where((axis == axis[0]) | (axis == axis[-1]), 0.5, 1.0) for axis in nodes.axes]
    share = node[0][:, None, None] * node[1][:, None] * node[2]
    assert nodes.trapezoid_volume == pytest.approx(share[nodes.inside].sum() * np.prod(widths), rel=1e-12)
    sides = [axis[-1] - axis[0] for axis in nodes.axes]
    assert share.sum() * np.prod(widths) == pytest.approx(np.prod(sides), rel=1e-12)


def test_every_way_out_along_the_grid_has_its_end(reached: tuple[Model, BoundaryLimits]) -> None:
    _, found = reached
    inside = found.nodes.inside
    crossings = sum(int(np.abs(np.diff(inside.astype(int), axis=axis)).sum()) for axis in range(3))
    on_sides = inside.sum() - inside[1:-1, 1:-1, 1:-1].sum()
    assert len(found.points) == crossings + on_sides


@pytest.mark.parametrize("name", ["paty2021", "looser", "swinging"])
def test_of_a_square_machine_it_is_square(name: str) -> None:
    model, step = MODELS[name]
    inside = count_nodes(model, "static", step=2.0 * step).inside
    assert inside.any()
    for other in (inside[::-1], inside[:, ::-1], inside.transpose(1, 0, 2)):
        np.testing.assert_array_equal(other, inside)


REACH = {0.0: 1.25, 1.0: 1.5, 3.0: 2.0, 5.0: 2.5, 7.5: 3.5, 10.0: 4.75, 12.0: 6.0, 13.0: 6.5, 13.5: 6.75}
TENSIONS = {0.0: 600, 1.0: 615, 3.0: 654, 5.0: 715, 7.5: 849, 10.0: 1152, 12.0: 1810, 13.0: 2669, 13.75: 4256}


def test_reach_of_paty_2021_is_an_inverted_funnel() -> None:
    """Against a prototype's grid of 0.25 m, straight cables: the last node inside, so up to a cell less."""
    strip = framed(PATY, (-7.5, -0.5, 0.0), (7.5, 0.5, 14.0))
    found = limited(Model(strip), 0.5)
    on_axis = found.points[(np.abs(found.points[:, 1]) < 1e-9) & (found.points[:, 0] > 0.1)]
    middle = int(np.argmin(np.abs(found.nodes.axes[1])))
    widest = []
    for height, node in REACH.items():
        at_height = on_axis[np.abs(on_axis[:, 2] - height) < 1e-9]
        reach = float(at_height[:, 0].max())
        assert node - 0.01 <= reach < node + 0.25 + 0.01, height
        widest.append(reach)
    assert widest == sorted(widest)
    assert 1.25 < widest[0] < 1.34
    assert not found.nodes.inside[:, middle, -1].any()  # at 14 m the centre itself takes 5333 N
    assert {each.limit for each in found.by_limit} >= {"lowest tension", "frame"}


@pytest.mark.parametrize("height", TENSIONS)
def test_tensions_of_paty_2021_at_the_centre(height: float) -> None:
    rigid = inverse(PATY, [0.0, 0.0, height], cable="rigid").checked()
    np.testing.assert_allclose(rigid.tensions, TENSIONS[height], atol=0.6)


def test_wider_limits_hold_more_and_all_that_was_held() -> None:
    limits = (510.0, 5150.0), (200.0, 5150.0), (20.0, 8000.0)
    nested = [count_nodes(Model(PATY, tension_limits=one), "static", step=1.5) for one in limits]
    for tight, wide in pairwise(nested):
        assert (wide.inside | ~tight.inside).all()
        assert wide.trapezoid_volume > tight.trapezoid_volume


def test_a_machine_scaled_in_all_forces_reaches_as_far() -> None:
    """Twice the mass, the cables' weight and stiffness, the levers' weight and the limits."""
    lines = []
    for line in PATY.lines:
        cable = line.cable.model_copy(
            update={
                "young_modulus": 2.0 * line.cable.young_modulus,
                "linear_density": 2.0 * line.cable.linear_density,
                "breaking_load": 2.0 * line.cable.breaking_load,
            }
        )
        sheave = line.sheave.model_copy(update={"lever_weight": 2.0 * line.sheave.lever_weight})
        limits = tuple(2.0 * limit for limit in line.tension_limits)
        lines.append(line.model_copy(update={"cable": cable, "sheave": sheave, "tension_limits": limits}))
    platform = PATY.platform.model_copy(update={"mass": 2.0 * PATY.platform.mass})
    twice = PATY.model_copy(update={"lines": tuple(lines), "platform": platform})
    one, other = limited(Model(PATY), 1.25), limited(Model(twice), 1.25)
    np.testing.assert_array_equal(other.nodes.inside, one.nodes.inside)
    np.testing.assert_array_equal(other.ended_by, one.ended_by)
    np.testing.assert_allclose(other.points, one.points, atol=CLOSE)


@pytest.mark.parametrize(
    ("robot", "limit"),
    [(SWINGING, "swing"), (LEVERED, "lever"), (WINCHED, "cable length")],
    ids=lambda one: str(one)[:5],
)
def test_a_machine_that_hardware_limits_ends_by_it(robot: Robot, limit: str) -> None:
    found = limited(Model(robot), 1.25)
    free = count_nodes(Model(load("house-printer")), "static", step=1.25)
    assert limit in [each.limit for each in found.by_limit]
    assert found.by_limit[0].limit in (limit, "lowest tension", "frame")
    assert (free.inside | ~found.nodes.inside).all()
    assert found.nodes.volume < free.volume


def test_swing_ends_it_in_the_plane_where_the_sheave_turned_so_far() -> None:
    found = limited(Model(SWINGING), 1.25)
    ends = found.points[np.array(found.limits)[found.ended_by] == "swing"]
    turned = []
    for line in SWINGING.lines:
        away = ends[:, :2] - line.exit_point[:2]
        turned.append(np.abs(np.angle(np.exp(1j * (np.arctan2(*away.T[::-1]) - line.sheave.facing)))))
    np.testing.assert_allclose(np.max(turned, axis=0), 0.5, atol=2e-3)


def test_a_frame_of_which_all_is_reached_ends_it_alone() -> None:
    small = framed(load("house-printer"), (-1.0, -1.0, 1.0), (1.0, 1.0, 3.0))
    told: list[tuple[str, int, int]] = []
    nodes = count_nodes(Model(small), "static", step=0.5, progress=lambda *each: told.append(each))
    found = boundary_limits(nodes)
    assert nodes.inside.all()
    assert [each.limit for each in found.by_limit] == ["frame"]
    assert found.by_limit[0].ends == 5**3 - 3**3
    assert told == [("nodes", 125, 125)]
    nothing = limited(Model(framed(PATY, (-7.0, -7.0, 0.0), (-6.0, -6.0, 1.0))), 0.5)
    assert (nothing.nodes.trapezoid_volume, nothing.by_limit, len(nothing.points)) == (0.0, (), 0)


def test_no_orientation_leaves_nothing_to_end() -> None:
    nodes = count_nodes(load("jung2020"), "static", grid=3, orientations=[])
    assert (nodes.counted, boundary_limits(nodes).by_limit) == (0, ())


def test_total_orientation_ends_where_one_orientation_ends() -> None:
    """Turned by 0.1 rad and unturned: all points are inside of both, and a millimetre on one of them is broken."""
    model, turns = Model(load("jung2020")), [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]]
    found = boundary_limits(count_nodes(model, "static", grid=6, orientations=turns))
    alone = count_nodes(model, "static", grid=6)
    assert 0 < found.nodes.counted < alone.counted
    assert (alone.inside | ~found.nodes.inside).all()
    poses = [np.column_stack([found.points, np.broadcast_to(turn, found.points.shape)]) for turn in turns]
    assert not any(broken_limits(solve_inverse(model, model.at_nozzle(each)))[1].any() for each in poses)


def test_only_the_static_criterion_knows_its_limits() -> None:
    with pytest.raises(InputError, match="criterion exact: only the criterion static"):
        boundary_limits(count_nodes(load("jung2020"), "exact", grid=3))


@pytest.mark.parametrize("step", [0.0, -1.0, 15.1, np.nan, np.inf, 0.05])
def test_a_step_that_is_none_is_rejected(step: float) -> None:
    with pytest.raises(InputError, match="step"):
        count_nodes(PATY, "static", step=step)


@pytest.mark.parametrize("step", [15.0, 7.5, 4.0, 1.0, 0.7])
def test_nodes_reach_from_side_to_side(step: float) -> None:
    axes = count_nodes(PATY, "wrench-closure", step=step).axes
    for axis, low, high in zip(axes, PATY.scene.frame_min, PATY.scene.frame_max, strict=True):
        assert (axis[0], axis[-1]) == (low, high)
        assert np.diff(axis).max() <= step * (1.0 + 1e-9)
        assert np.diff(axis).max() > 0.5 * step


@pytest.mark.parametrize(("radius", "holds"), [(0.0400001, True), (0.04, False), (0.0399999, False)])
def test_sheaves_spare_cables_whose_radius_they_are_over_twenty_of(radius: float, holds: bool) -> None:
    rules = sheave_rules(sheaved(PATY, radius=radius))  # the cable's is 2 mm
    assert [rule.line for rule in rules] == [line.name for line in PATY.lines]
    assert [rule.holds for rule in rules] == [holds] * 4
    assert rules[0].value == pytest.approx(radius / 0.002, rel=1e-12)
    assert rules[0].required == 20.0
    assert sheave_rules(load("jung2020")) == ()
