"""Named views of the arrays that kernels take: each column has its name, and what is set through it is set there."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.kernels import layout
from cablewright.models.packed_views import LineNumbers, LineStates, PlatformNumbers, blank_states
from cablewright.models.statics import Model
from cablewright.robot import load

WIDTHS = {LineNumbers: layout.COLUMNS, LineStates: layout.STATE, PlatformNumbers: layout.PLATFORM}
NAMES = [(view, name) for view in WIDTHS for name, each in vars(view).items() if getattr(each, "_index", None)]


@pytest.mark.parametrize("shape", [(), (4,), (3, 4)], ids=str)
@pytest.mark.parametrize(("view", "name"), NAMES)
def test_what_is_set_through_a_name_is_set_in_the_array_and_read_again(view, name, shape) -> None:
    array = np.zeros((*shape, WIDTHS[view]))
    values = 1.0 + np.arange(getattr(view(array), name).size).reshape(np.shape(getattr(view(array), name)))
    setattr(view(array), name, values)
    np.testing.assert_array_equal(getattr(view(array), name), values)
    assert np.count_nonzero(array) == values.size  # nothing else is touched
    assert getattr(view, name).__doc__


@pytest.mark.parametrize("view", WIDTHS)
def test_every_column_has_a_name(view) -> None:
    array = np.zeros(WIDTHS[view])
    for name in (name for owner, name in NAMES if owner is view):
        setattr(view(array), name, 1.0)
    assert array.all()


def test_reading_lines_copies_nothing_and_a_single_number_is_a_number() -> None:
    lines = LineNumbers(np.zeros((4, layout.COLUMNS)))
    assert np.shares_memory(lines.exit_point, lines.array)
    assert np.shares_memory(lines.weight, lines.array)
    assert type(LineNumbers(lines.array[0]).weight) is np.float64


def test_names_are_those_of_the_description() -> None:
    model = Model(load("house-printer"))
    own, line, robot = LineNumbers(model.packed.lines[1]), model.robot.lines[1], model.robot
    assert tuple(own.exit_point) == line.exit_point
    assert tuple(own.platform_point) == line.platform_point
    assert (own.radius, own.lever) == (line.sheave.radius, line.sheave.lever)
    assert own.lever_moment == line.sheave.lever_weight * line.sheave.lever_mass_centre
    away = np.subtract(line.winch_exit, line.exit_point)
    assert (own.winch_distance, own.winch_height) == (np.hypot(*away[:2]), away[2])
    assert own.weight == line.cable.linear_density * robot.scene.gravity
    assert tuple(own.compliances) == (own.free_compliance, own.dead_compliance, own.arc_compliance)
    assert own.free_compliance == 1.0 / line.cable.stiffness
    assert tuple(own.tension_limits) == (own.tension_min, own.tension_max) == line.tension_limits
    assert own.breaking_load == line.cable.breaking_load
    assert own.has_lever
    assert own.has_dead_span
    assert own.unknowns == layout.STATE
    platform = PlatformNumbers(model.packed.platform)
    assert platform.weight == robot.platform.mass * robot.scene.gravity
    assert platform.massless == 0.0


def test_the_tension_of_a_state_is_that_of_its_logarithm() -> None:
    states = LineStates(blank_states(2, 3))
    states.log_tension = np.log(200.0)
    np.testing.assert_allclose(states.tension, np.full((2, 3), 200.0))
