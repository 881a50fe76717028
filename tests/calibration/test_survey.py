"""Surveys: what a made-up surveyor measured is found again, with honest sigmas, and rejected in one line."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cablewright.calibration.survey import shape_fits
from cablewright.calibration.survey.plan import SurveyPlan
from cablewright.calibration.survey.result import Survey, surveyed
from cablewright.calibration.survey.shots import Shot, Shots, of_polar
from cablewright.calibration.survey.survey import survey
from cablewright.foundation.errors import InputError
from cablewright.robot import load
from cases import some
from oracles.room import EAST, NORTH, WEST
from oracles.surveyor import EXITS, Site, polar, site

PLAN = SurveyPlan.model_validate({"schema": 1, "exit": {"offset": [0, 0, -0.05]}})


def shots_of(rows) -> Shots:
    shots = []
    for line, (name, hz, v, slope) in enumerate(rows, 1):
        place = of_polar(hz, v, slope)
        shots.append(Shot(name, line, place, place))
    return Shots(tuple(shots), (), "here")


def exact(where: Site) -> Shots:
    return shots_of(polar(where, np.random.default_rng(0), angle=0.0, distance=0.0, ppm=0.0))


def changed(shots: Shots, **moves) -> Shots:
    """The shots with markers moved, or left out where the move is None."""
    kept = []
    for shot in shots.shots:
        move = moves.get(shot.point.replace("-", "_"), (0.0, 0.0, 0.0))
        if move is not None:
            place = tuple(np.add(shot.position, move))
            kept.append(replace(shot, position=place, sight=place))
    return Shots(tuple(kept), (), shots.origin)


def from_station(place, where: Site) -> np.ndarray:
    """A true place in the survey's frame: that of the room, with the origin under the instrument."""
    return np.subtract(place, (where.station[0], where.station[1], 0.0))


def close(found, wanted, tolerance: float = 1e-9) -> bool:
    return bool(np.allclose(found, wanted, rtol=0.0, atol=tolerance))


@pytest.mark.parametrize("turned", [0.0, 0.7, 3.0, -2.2])
def test_without_noise_all_is_found(turned: float) -> None:
    where = site(turned=turned)
    found = survey(exact(where), PLAN)
    assert [one.line for one in found.exits] == ["1", "2", "3", "4"]
    for one in found.exits:
        true = EXITS[int(one.line)]
        assert close(one.exit_point, from_station(true, where))
        assert close(one.winch_exit, from_station((*true[:2], 0.15), where))
        assert one.dead_length == pytest.approx(true[2] - 0.15, abs=1e-9)
    walls = {wall.name: wall for wall in found.walls}
    for name, normal, distance in (
        ("west", (-1, 0, 0), where.station[0] - WEST),
        ("east", (1, 0, 0), EAST - where.station[0]),
        ("north", (0, 1, 0), NORTH - where.station[1]),
        ("floor", (0, 0, -1), 0.0),
    ):
        assert close(walls[name].normal, normal)
        assert walls[name].distance == pytest.approx(distance, abs=1e-9)
    swivel, sheave = found.axes
    assert (swivel.kind, swivel.line, sheave.kind) == ("swivel", "4", "sheave")
    assert swivel.radius == pytest.approx(0.09, abs=1e-9)
    assert sheave.radius == pytest.approx(0.03, abs=1e-9)
    assert close(np.abs(sheave.direction), (0, 1, 0), 1e-8)
    assert swivel.arc == pytest.approx(2.8, abs=1e-6)
    assert found.rms < 1e-9
    assert found.notes == ()


def test_the_instrument_may_stand_anywhere() -> None:
    """Exit points relative to each other do not depend on station or circle; the frame's directions are the walls'."""
    one = survey(exact(site()), PLAN)
    other = survey(exact(site(station=(1.3, 2.2, 0.9), turned=-1.1)), PLAN)
    shift = np.subtract((0.1, -0.2, 0), (1.3, 2.2, 0))
    for a, b in zip(one.exits, other.exits, strict=True):
        assert close(a.exit_point + shift, b.exit_point)


def test_the_order_of_shots_does_not_matter() -> None:
    shots = shots_of(polar(site(), np.random.default_rng(3)))
    mixed = Shots(tuple(np.random.default_rng(4).permutation(np.array(shots.shots, dtype=object))), (), "here")
    one, other = survey(shots, PLAN), survey(mixed, PLAN)
    for a, b in zip(one.exits, other.exits, strict=True):
        assert a.line == b.line
        assert close(a.exit_point, b.exit_point, 1e-11)


@pytest.mark.parametrize("surveys", some([60, 200]))
def test_sigmas_are_honest(surveys: int) -> None:
    """Over many surveys, errors over their sigmas: what chi-squared says, for exit points jointly and for walls."""
    where, exits, walls = site(), [], []
    true = [from_station(p, where) for line in range(1, 5) for p in (EXITS[line], (*EXITS[line][:2], 0.15))]
    for seed in range(surveys):
        found = survey(shots_of(polar(where, np.random.default_rng(seed))), PLAN)
        value = [p for one in found.exits for p in (one.exit_point, one.winch_exit)]
        off = np.concatenate(value) - np.concatenate(true)
        exits.append(off @ np.linalg.solve(found.covariance, off))
        east = next(wall for wall in found.walls if wall.name == "east")
        walls.append((east.distance - (EAST - where.station[0])) / east.distance_sigma)
        walls.append(math.atan2(east.normal[1], east.normal[0]) / east.angle_sigma)
    # the mean of n chi-squared numbers with k degrees of freedom is k +- sqrt(2 k / n)
    assert np.mean(exits) == pytest.approx(24.0, abs=4 * math.sqrt(2 * 24 / surveys))
    assert np.mean(np.square(walls)) == pytest.approx(1.0, abs=4 * math.sqrt(1 / surveys))


def test_the_jacobian_by_markers_is_that_of_differences() -> None:
    """What the covariance rests on, by finite differences of the whole survey."""
    shots = exact(site())
    base, step = survey(shots, PLAN), 1e-6
    for point in ("WEST1", "X2_1", "A4_3", "S4_2", "FLOOR1", "W4_2"):
        for axis in range(3):
            push = [0.0, 0.0, 0.0]
            push[axis] = step
            moved = survey(changed(shots, **{point: tuple(push)}), PLAN)
            away = [(a.exit_point - b.exit_point) / step for a, b in zip(moved.exits, base.exits, strict=True)]
            index = 3 * [s.point.replace("-", "_") for s in shots.shots].index(point) + axis
            motions = predicted(shots)
            for line, change in enumerate(away):
                assert close(change, motions[line][:, index], 2e-4), (point, axis, line)


def predicted(shots: Shots) -> list[np.ndarray]:
    """(3, 3 N) of each exit point, from inside."""
    from cablewright.calibration.survey.survey import _Evaluation

    work = _Evaluation(shots, PLAN, None)
    kept = {}
    joint = work._joint
    work._joint = lambda placed: kept.update(placed) or joint(placed)
    work.run()
    return [
        place.jacobian for feature, place in sorted(kept.items(), key=lambda i: i[0].name) if feature.kind == "exit"
    ]


def test_both_faces_and_repeats_average() -> None:
    rows = polar(site(), np.random.default_rng(1), angle=0.0, distance=0.0)
    second = [(name, hz + math.pi, math.tau - v, slope) for name, hz, v, slope in rows]
    one, both = survey(shots_of(rows), PLAN), survey(shots_of(rows + second), PLAN)
    assert close(one.exits[0].exit_point, both.exits[0].exit_point)
    assert both.exits[0].exit_sigma == pytest.approx(one.exits[0].exit_sigma / math.sqrt(2), rel=0.01)
    assert both.residuals[0].shots == 2
    assert both.residuals[0].repeat < 1e-9


def test_offsets_turn_with_the_markers() -> None:
    """An offset is along, to the left and up of the way from the first marker to the second."""
    way = np.array([0.6, 0.8])
    base = np.array([1.0, -2.0, 3.0])
    wanted = base + np.array([*(0.1 * way + 0.02 * np.array([-way[1], way[0]])), -0.3])
    half = np.array([*(0.05 * way), 0.0])
    rows = {"X1-1": base - half, "X1-2": base + half}
    shots = Shots(tuple(Shot(name, i, tuple(p), tuple(p)) for i, (name, p) in enumerate(rows.items(), 1)), (), "here")
    plan = SurveyPlan.model_validate(
        {"schema": 1, "exit": {"offset": [0.1, 0.02, -0.3], "spacing": 0.1}, "frame": {"along": "instrument"}}
    )
    found = survey(shots, plan)
    assert close(found.exits[0].exit_point, wanted)
    assert found.residuals[0].residual == pytest.approx(0.0, abs=1e-12)
    own = SurveyPlan.model_validate(
        {"schema": 1, "lines": {"1": {"exit": {"offset": [0, 0, 0.5]}}}, "frame": {"along": "instrument"}}
    )
    assert close(survey(shots, own).exits[0].exit_point, base + np.array([0, 0, 0.5]))


def test_a_marker_that_is_wrong_is_named() -> None:
    found = survey(changed(exact(site()), EAST3=(0.05, 0.05, 0.0)), PLAN)
    suspects = {row.point for row in found.residuals if row.suspect}
    assert "EAST3" in suspects
    assert any("EAST3" in note and "measure it again" in note for note in found.notes)
    assert any("worse than the instrument" in note for note in found.notes)


def test_a_leaning_wall_is_reported() -> None:
    where = site()
    markers = dict(where.markers)
    for i, (y, z) in enumerate(((-3, 0.3), (3, 0.4), (-2, 3.5), (2, 3.4)), 1):
        markers[f"EAST{i}"] = (EAST + 0.02 * (z - 1.5), y, z)
    found = survey(exact(Site(markers)), PLAN)
    east = next(wall for wall in found.walls if wall.name == "east")
    assert east.lean == pytest.approx(math.atan(0.02), abs=1e-4)
    assert any("wall east leans out at its top by 1.1 deg" in note for note in found.notes)


def test_plan_names_points_and_heights() -> None:
    shots = changed(exact(site()), FLOOR1=None, FLOOR2=None)
    renamed = Shots(
        tuple(replace(s, point={"WEST1": "101", "WEST2": "102"}.get(s.point, s.point)) for s in shots.shots), (), "x"
    )
    plan = SurveyPlan.model_validate(
        {
            "schema": 1,
            "points": {"101": "wall west", "102": "wall west", "W4-1": "none", "W4-2": "none"},
            "instrument": {"height": 1.5},
            "exit": {"offset": [0, 0, -0.05]},
            "frame": {"origin": "exits"},
        }
    )
    found = survey(renamed, plan)
    middle = np.mean([EXITS[i] for i in EXITS], axis=0)
    for one in found.exits:
        assert close(one.exit_point, np.subtract(EXITS[int(one.line)], (*middle[:2], 0.0)))
    assert found.exits[3].winch_exit is None
    assert found.frame.floor == "height"


@pytest.mark.parametrize(
    ("moves", "says"),
    [
        ({"WEST1": None}, "wall west: 1 marker, WEST2; 2 or more are required"),
        ({"WEST1": None, "WEST2": None}, "no marker on wall 'west', which the frame's y axis follows"),
        ({"A4_1": None, "A4_2": None, "A4_3": None}, "axis of 4: 2 markers, A4-4, A4-5; 3 or more are required"),
        ({"A4_2": None, "A4_4": None, "A4_3": None}, "axis of 4: 2 markers"),
        ({"S4_1": None, "S4_2": None, "S4_3": None, "S4_4": None}, "sheave of 4: 1 marker, S4-5; 3"),
    ],
)
def test_too_few_markers(moves, says: str) -> None:
    with pytest.raises(InputError) as error:
        survey(changed(exact(site()), **moves), PLAN)
    assert says in str(error.value)
    assert str(error.value).startswith("here: ")


def built(**places) -> Shots:
    where = site()
    markers = {name: place for name, place in where.markers.items() if name[:3] not in ("A4-", "S4-")}
    markers |= {name.replace("_", "-"): place for name, place in places.items()}
    return exact(Site(markers))


@pytest.mark.parametrize(
    ("places", "says"),
    [
        (
            {f"A4_{i}": (0.01 * i, 2.0, 3.0) for i in range(4)},
            "axis of 4: its 4 markers are nearly on one line or in one place",
        ),
        ({f"S4_{i}": (1.0, 2.0, 3.0 + 0.02 * i) for i in range(3)}, "nearly on one line"),
        ({f"S4_{i}": (1.0, 2.0, 3.0) for i in range(3)}, "nearly on one line or in one place"),
        ({"EAST1": (EAST, 1.0, 1.0), "EAST2": (EAST, 1.03, 2.0), "EAST3": (EAST, 1.0, 3.0)}, "apart in plan"),
        ({"EAST1": (EAST, 1.0, 1.0), "EAST2": (EAST, 1.0, 1.0), "EAST3": (EAST, 1.0, 1.0)}, "0 m apart in plan"),
        ({"X4_1": (0, 0, 3), "A4_1": (0, 0.1, 3), "A4_2": (0.1, 0.2, 3), "A4_3": (0.1, 0, 3)}, "and of its swivel"),
        ({"SOUTH1": (-1, NORTH - 1, 1), "SOUTH2": (1, NORTH - 1, 1)}, "wall south is where north should be"),
    ],
)
def test_markers_that_decide_nothing(places, says: str) -> None:
    with pytest.raises(InputError, match=says):
        survey(built(**places), PLAN)


def test_shots_of_one_name_that_are_far_apart() -> None:
    shots = exact(site())
    first = shots.shots[0]
    again = replace(first, line=99, position=(0.0, 1.0, 0.0), sight=(0.0, 1.0, 0.0))
    with pytest.raises(InputError, match=r"marker 'WEST1' \(lines 1, 99\): the shot at line \d+ is .* m off"):
        survey(Shots((*shots.shots, again), (), "here"), PLAN)


def test_millimetres_are_asked_about() -> None:
    shots = exact(site())
    large = [replace(s, position=tuple(1e3 * np.array(s.position)), sight=None) for s in shots.shots]
    with pytest.raises(InputError, match="give a unit, as in 'x \\(mm\\)'"):
        survey(Shots(tuple(large), (), "here"), PLAN)


@pytest.mark.parametrize(
    ("plan", "says"),
    [
        ({"points": {"101": "door"}}, "101 = 'door': must be one of"),
        ({"points": {"101": "wall"}}, "must be one of"),
        ({"instrument": {"angle": 0}}, "greater than 0"),
        ({"frame": {"origin": "corner"}}, "station"),
        ({"exits": {}}, "did you mean 'exit'"),
    ],
)
def test_plans_that_are_rejected(plan, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        SurveyPlan.model_validate({"schema": 1} | plan)


def test_plan_points_must_be_in_the_file() -> None:
    plan = SurveyPlan.model_validate({"schema": 1, "points": {"777": "wall west"}})
    with pytest.raises(InputError, match="no shot of marker '777'"):
        survey(exact(site()), plan)


def test_plan_lines_must_be_lines() -> None:
    plan = SurveyPlan.model_validate({"schema": 1, "lines": {"south-wst": {"exit": {"offset": [0, 0, 0]}}}})
    with pytest.raises(InputError, match="unknown line of the plan 'south-wst'; did you mean 'south-west'"):
        survey(exact(site()), plan, robot=load("merlet2023"))
    with pytest.raises(InputError, match="unknown line of the plan 'south-wst'; allowed: 1, 2, 3, 4"):
        survey(exact(site()), plan)


def test_the_robot_has_the_exit_points() -> None:
    robot = load("merlet2023")
    found = survey(exact(site()), PLAN, robot=robot)
    made, notes = surveyed(robot, found)
    for line, one in zip(made.lines, found.exits, strict=True):
        assert line.name == one.line
        assert close(line.exit_point, one.exit_point, 6e-6)
        assert line.winch_exit[:2] == line.exit_point[:2]
        assert line.winch_exit[2] == pytest.approx(0.15, abs=6e-6)
    assert made.platform == robot.platform
    assert notes == ()
    assert isinstance(found, Survey)


def test_a_winch_beside_the_axis_is_reported() -> None:
    robot = load("merlet2023")
    markers = dict(site().markers)
    markers |= {"W1-1": (-2.5, -4.8, 0.15), "W1-2": (-2.5, -4.6, 0.15)}
    found = survey(exact(Site(markers)), PLAN, robot=robot)
    _, notes = surveyed(robot, found)
    (note,) = notes
    assert "winch of south-west is 300 mm beside its sheave's axis" in note


# Fits, against brute force


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 2**32 - 1))
def test_circles_are_least_squares(seed: int) -> None:
    """No nearby circle leaves less, for equal weights."""
    rng = np.random.default_rng(seed)
    n = rng.normal(size=3)
    n /= np.linalg.norm(n)
    u = np.cross(n, [0.3, 0.5, 0.8])
    u /= np.linalg.norm(u)
    v = np.cross(n, u)
    turn = np.sort(rng.uniform(0, math.tau, 8)) + np.linspace(0, 0.5, 8)
    centre, radius = rng.normal(size=3), rng.uniform(0.02, 0.5)
    points = centre + radius * (np.cos(turn)[:, None] * u + np.sin(turn)[:, None] * v)
    points += rng.normal(0, 0.01 * radius, points.shape)
    fit, basis = shape_fits.circle(points, np.tile(1e-6 * np.eye(3), (8, 1, 1)))
    assert fit.converged

    def left(q: np.ndarray) -> float:
        axis = q[4:] @ basis[:2] + basis[2]
        axis /= np.linalg.norm(axis)
        away = points - q[:3]
        out = away @ axis
        return float(np.sum(out**2 + (np.linalg.norm(away - out[:, None] * axis, axis=1) - q[3]) ** 2))

    least = left(fit.value)
    for i in range(6):
        for push in (1e-4, -1e-4):
            q = fit.value.copy()
            q[i] += push * (radius if i < 4 else 1.0)
            assert left(q) >= least * (1 - 1e-9)


@pytest.mark.parametrize(("move", "beyond"), [(0.0, 0), (0.05, 0), (0.3, 1), (2.0, 1)])
def test_an_exit_beyond_a_wall_is_reported(move: float, beyond: int) -> None:
    """Exit points 2 and 3 of the site are 0.1 m from the east wall; exit 2 is moved towards it, in the site itself."""
    where = site()
    markers = dict(where.markers)
    for name in ("X2-1", "X2-2"):
        x, y, z = markers[name]
        markers[name] = (x + move, y, z)
    notes = survey(exact(Site(markers)), PLAN).notes
    assert [("exit point of line 2" in note and "beyond wall east" in note) for note in notes].count(True) == beyond
    assert not any("beyond" in note and "line 2" not in note for note in notes)
