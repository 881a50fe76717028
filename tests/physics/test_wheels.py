"""Statics of lines over wheels that stand still: weight and stretch on arcs, packed numbers, other fidelities."""

from __future__ import annotations

import numpy as np
import pytest

import cablewright as cw
import out_of_plane
from cablewright.foundation.errors import InputError
from cablewright.models.fidelity import Fidelity
from cablewright.models.pack import pack
from cablewright.models.parameters import varied
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import GuideSheave, Line, Pulley, Robot
from cablewright.robot.parameters import Parameter, with_value

ROBOTS = [out_of_plane.body("wheels"), out_of_plane.point("wheels")]
POSES = {6: [0.4, -0.3, 1.6, 0.02, 0.05, -0.03], 3: [0.4, -0.6, 1.2]}


def held(robot: Robot, cable: str = "catenary", **own) -> Equilibrium:
    return cw.inverse(robot, [POSES[robot.n]], cable=cable, tension_limits=(10.0, 8000.0), **own).checked()


def heights(line: Line, count: int = 20_000) -> tuple[np.ndarray, np.ndarray]:
    """Distances and heights of many points from the sheave to the winch, of the oracle's way."""
    way, points = out_of_plane.way_of(line), []
    stops = [line.winch_exit, *line.guides, line.exit_point]
    for k, ((come, leave), stop, angle) in enumerate(zip(way.contacts, stops, way.angles, strict=True)):
        if k:
            share = np.linspace(0.0, 1.0, count)[:, None]
            points.append(way.contacts[k - 1][1] + share * (come - way.contacts[k - 1][1]))
        if isinstance(stop, GuideSheave):
            axis, arm = out_of_plane.unit(stop.axis), come - stop.centre
            turn = np.linspace(0.0, angle, count)[:, None]
            points.append(stop.centre + np.cos(turn) * arm + np.sin(turn) * np.cross(axis, arm))
            np.testing.assert_allclose(points[-1][-1], leave, atol=1e-12)
    path = np.vstack(points)[::-1]
    far = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    return far, path[:, 2]


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
def test_tension_is_that_of_its_height(robot: Robot) -> None:
    """At the winch, and where it is least and most, which may be on an arc."""
    each = held(robot)[0]
    low, high = each.extremes()
    on_arc = False
    for i, line in enumerate(robot.lines):
        way, weight = out_of_plane.way_of(line), line.cable.linear_density * robot.scene.gravity
        end = way.contacts[-1][0][2]
        density = each.line_states.dead_length[i] / way.length
        if line.is_aside:  # heights count from the exit point, and the last piece is the sheave's
            density = 1.0
        along = each.tensions[i] + weight * density * (heights(line)[1] - end)
        slight = 2.0 * line.sheave.radius * weight if line.is_aside else 1e-9 * each.tensions[i]
        assert each.winch_tensions[i] == pytest.approx(along[-1], abs=slight)
        assert high[i] == pytest.approx(max(along.max(), each.platform_tensions[i]), abs=slight)
        assert low[i] <= along.min() + slight
        on_arc |= along.max() > max(along[0], along[-1]) + 1e-3
    assert on_arc


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
@pytest.mark.parametrize("cable", ["elastic", "catenary"])
def test_the_stretch_is_the_integral_along_the_way(robot: Robot, cable: str) -> None:
    """Of the strain by the tension at each point, with the weight of the cable below, unstrained."""
    each = held(robot, cable)[0]
    for i, line in enumerate(robot.lines):
        if line.is_aside:
            continue  # its last straight piece is part of the unknowns
        weight = line.cable.linear_density * robot.scene.gravity if cable == "catenary" else 0.0
        far, height = heights(line)
        tension, unstrained = each.tensions[i] + weight * (height - height[0]), 0.0
        for _ in range(3):
            share = 1.0 / (1.0 + tension / line.cable.stiffness)  # unstrained over strained
            step = 0.5 * (share[1:] + share[:-1])
            tension = each.tensions[i] + weight * np.concatenate([[0.0], np.cumsum(step * np.diff(height))])
            unstrained = float(step @ np.diff(far))
        assert each.line_states.dead_length[i] == pytest.approx(unstrained, abs=2e-8)
        assert out_of_plane.way_of(line).length - unstrained > 1e-4


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
def test_a_dead_span_that_does_not_stretch_keeps_its_arcs(robot: Robot) -> None:
    lines = tuple(line.model_copy(update={"dead_elastic": False}) for line in robot.lines)
    each = held(robot.model_copy(update={"lines": lines}))[0]
    for i, line in enumerate(lines):
        if not line.is_aside:
            assert each.line_states.dead_length[i] == pytest.approx(out_of_plane.way_of(line).length, abs=1e-12)


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
def test_forward_finds_the_pose_again(robot: Robot) -> None:
    for cable in ("elastic", "catenary"):
        there = held(robot, cable)
        back = cw.forward(robot, there.lengths, cable=cable)
        np.testing.assert_allclose(back.pose, there.pose, atol=1e-9)


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
def test_an_exit_point_that_moves_takes_its_wheels_along(robot: Robot) -> None:
    """The robot with another value has the arrays of the value alone."""
    fidelity = Fidelity.of()
    packed, lengths = pack(robot, fidelity), np.ones((1, robot.m))
    for i, line in enumerate(robot.lines):
        parameter = Parameter("exit_point.x", line.name)
        value = line.exit_point[0] + 0.0125
        alone, _ = varied(robot, Model.of(robot).rows(), [parameter], np.array([[value]]), lengths)
        moved = with_value(robot, parameter, value)
        np.testing.assert_allclose(pack(moved, fidelity).lines, alone.lines[0], atol=1e-12)
        assert out_of_plane.checked(moved) == moved
        assert not np.allclose(packed.lines[i], alone.lines[0, i], atol=1e-3)


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
def test_as_eyelets_wheels_are_points_at_their_centres(robot: Robot) -> None:
    lines = []
    for line in robot.lines:
        guides = tuple(each.centre if isinstance(each, GuideSheave) else each for each in line.guides)
        lines.append(line.model_copy(update={"guides": guides}))
    plain = robot.model_copy(update={"lines": tuple(lines)})
    one, two = (pack(each, Fidelity.of("catenary", "eyelet")).lines for each in (robot, plain))
    np.testing.assert_array_equal(one, two)


def test_what_no_cable_passes_any_more_is_rejected_by_the_name_of_its_line() -> None:
    """Of a robot that was changed without being read again."""
    robot = out_of_plane.point("wheels")
    line = next(line for line in robot.lines if isinstance(line.sheave, Pulley))
    large = line.model_copy(update={"sheave": line.sheave.model_copy(update={"radius": 2.3})})
    lines = tuple(large if each is line else each for each in robot.lines)
    with pytest.raises(InputError, match=f"line {line.name!r}: guides: no straight cable leaves the rim of guide 2"):
        cw.inverse(robot.model_copy(update={"lines": lines}), [0.0, 0.0, 1.0])
