"""Uncertain numbers in arrays: as if the robot had been described with them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

import cases
from cablewright.foundation.errors import InputError
from cablewright.kernels import layout
from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
from cablewright.models.pack import pack
from cablewright.models.parameters import varied
from cablewright.models.statics import Model
from cablewright.robot import Cable, Line, Robot, load
from cablewright.robot.parameters import KINDS, Parameter, nominal, parameters_of, why_not, with_value

SEED = 5
MODELS = list(cases.models(*CableLaw))
BUILT = [Model(robot) for robot in cases.robots()]
ULP = 1e-15
ACTING_ON_LENGTHS = ("length_scale", "length_offset", "temperature")


def all_of(robot: Robot, shared: bool = False) -> list[Parameter]:
    """Every number of a robot that may be uncertain; *shared*: those that all its lines can have in common."""
    known = [kind for kind in KINDS.values() if kind.role in ("hardware", "command")]
    kinds = [kind for kind in known if why_not(robot, kind, None, shared and kind.per_line) is None]
    return [one for kind in kinds for one in parameters_of(robot, kind.name, shared=shared and kind.per_line)]


def drawn(robot: Robot, parameters: Sequence[Parameter], rows: int, seed: int = SEED) -> np.ndarray:
    """Values (rows, k) near nominal that a robot can have."""
    rng = np.random.default_rng(seed)
    base = np.array([nominal(robot, one) for one in parameters])
    return base * rng.uniform(0.9, 1.1, (rows, len(base))) + (base == 0.0) * rng.uniform(-0.05, 0.05, (rows, len(base)))


def rebuilt(robot: Robot, parameter: Parameter, value: float) -> Robot:
    """*robot* described with another value of one number; lengths are none of its description."""
    kind, axis = parameter.kind.partition(".")[::2]
    if kind in ACTING_ON_LENGTHS:
        return robot
    if not KINDS[parameter.kind].per_line:
        was = getattr(robot.platform, kind)
        platform = robot.platform.model_copy(update={kind: with_axis(was, axis, value) if axis else value})
        return robot.model_copy(update={"platform": platform})
    mine = [parameter.line in (None, line.name) for line in robot.lines]
    lines = [with_number(line, kind, axis, value) if own else line for line, own in zip(robot.lines, mine, strict=True)]
    return robot.model_copy(update={"lines": tuple(lines)})


def with_number(line: Line, kind: str, axis: str, value: float) -> Line:
    if kind == "modulus":
        changes = {"young_modulus": None, "section": None, "axial_stiffness": value * line.cable.stiffness}
        return line.model_copy(update={"cable": line.cable.model_copy(update=changes)})
    if kind == "linear_density":
        return line.model_copy(update={"cable": line.cable.model_copy(update={kind: value})})
    if kind == "sheave_radius":
        return line.model_copy(update={"sheave": line.sheave.model_copy(update={"radius": value})})
    if not axis:
        return line.model_copy(update={kind: value})
    point = with_axis(getattr(line, kind), axis, value)
    if kind == "exit_point" and axis != "z" and line.winch_exit is not None:
        moved = value + (line.winch_exit["xyz".index(axis)] - line.exit_point["xyz".index(axis)])
        return line.model_copy(update={kind: point, "winch_exit": with_axis(line.winch_exit, axis, moved)})
    return line.model_copy(update={kind: point})


@pytest.mark.parametrize("robot", cases.robots(), ids=lambda robot: robot.name)
def test_the_registry_sets_numbers_as_a_file_would(robot: Robot) -> None:
    hardware = [one for one in all_of(robot) if one.entry.role == "hardware"]
    for one, value in zip(hardware, drawn(robot, hardware, 1)[0].tolist(), strict=True):
        found, wanted = (Model(made) for made in (with_value(robot, one, value), rebuilt(robot, one, value)))
        np.testing.assert_allclose(found.packed.lines, wanted.packed.lines, rtol=ULP, atol=4 * ULP)
        np.testing.assert_array_equal(found.packed.platform, wanted.packed.platform)


def with_axis(point: tuple[float, ...], axis: str, value: float) -> tuple[float, ...]:
    return tuple(value if name == axis else old for name, old in zip("xyz", point, strict=True))


def assert_same_arrays(model: Model, parameters: Sequence[Parameter], values: np.ndarray) -> None:
    """`varied` is `pack` of the robots rebuilt, row by row."""
    lengths = np.ones((len(values), model.m))
    found, _ = varied(model.robot, model.rows(), parameters, values, lengths)
    assert found.freedoms == model.n
    for row, one in enumerate(values):
        robot = model.robot
        for parameter, value in zip(parameters, one, strict=True):
            robot = rebuilt(robot, parameter, float(value))
        wanted = pack(robot, model.fidelity)
        np.testing.assert_allclose(found.lines[row], wanted.lines, rtol=ULP, atol=4 * ULP)  # of heights to 15 m
        np.testing.assert_allclose(found.platform[row], wanted.platform, rtol=ULP, atol=0)


@pytest.mark.parametrize("model", MODELS, ids=cases.name)
def test_each_number_alone_and_all_together_are_as_if_described_so(model: Model) -> None:
    # where no dead span is modelled, arrays differ in its height, which nothing reads: see the test below
    parameters = [one for one in all_of(model.robot) if one.kind != "exit_point.z" or winches(model.robot)]
    values = drawn(model.robot, parameters, 2)
    for one, column in zip(parameters, values.T, strict=True):
        assert_same_arrays(model, [one], column[:, None])
    assert_same_arrays(model, parameters, values)


def winches(robot: Robot) -> bool:
    return all(line.winch_exit is not None for line in robot.lines)


@pytest.mark.parametrize("model", [one for one in MODELS if not winches(one.robot)], ids=cases.name)
def test_the_height_of_an_exit_point_without_a_winch_exit(model: Model) -> None:
    parameters = parameters_of(model.robot, "exit_point.z")
    values = drawn(model.robot, parameters, 2)
    found, _ = varied(model.robot, model.rows(), parameters, values, np.ones((2, model.m)))
    read = np.setdiff1d(np.arange(layout.COLUMNS), layout.WINCH_Z)
    for row, heights in enumerate(values):
        robot = model.robot
        for one, height in zip(parameters, heights, strict=True):
            robot = rebuilt(robot, one, float(height))
        np.testing.assert_array_equal(found.lines[row][:, read], pack(robot, model.fidelity).lines[:, read])


@pytest.mark.parametrize("model", BUILT, ids=cases.name)
def test_shared_numbers_are_those_of_every_line(model: Model) -> None:
    shared = [one for one in all_of(model.robot, shared=True) if KINDS[one.kind].shareable]
    assert {one.kind for one in shared} >= {"modulus", "length_offset", "length_scale"}
    values = drawn(model.robot, shared, 3)
    assert_same_arrays(model, shared, values)
    for one, column in zip(shared, values.T, strict=True):
        if not KINDS[one.kind].per_line:
            continue
        each = parameters_of(model.robot, one.kind)
        lengths = np.random.default_rng(SEED).uniform(3.0, 9.0, (3, model.m))
        together = varied(model.robot, model.rows(), [one], column[:, None], lengths)
        apart = varied(model.robot, model.rows(), each, np.repeat(column[:, None], model.m, axis=1), lengths)
        np.testing.assert_array_equal(together[0].lines, apart[0].lines)
        np.testing.assert_array_equal(together[1], apart[1])


@pytest.mark.parametrize("name", ["house-printer", "jung2020"])  # of steel, which grows, and of aramid, which shrinks
def test_lengths_are_scaled_then_warmed_then_offset_whatever_the_order(name: str) -> None:
    robot = load(name)
    rng = np.random.default_rng(SEED)
    lengths = rng.uniform(3.0, 20.0, (6, robot.m))
    parameters = [
        one for kind in ("length_offset", "temperature", "length_scale") for one in parameters_of(robot, kind)
    ]
    values = np.column_stack(
        [rng.uniform(-0.1, 0.1, (6, robot.m)), rng.uniform(-30, 30, 6), rng.uniform(0.9, 1.1, (6, robot.m))]
    )
    before = lengths.copy()
    expansion = np.array([line.cable.thermal_expansion for line in robot.lines])
    offsets, warmer, scales = values[:, : robot.m], values[:, robot.m], values[:, robot.m + 1 :]
    wanted = lengths * scales * (1.0 + expansion * warmer[:, None]) + offsets
    order = rng.permutation(len(parameters))
    for chosen in (np.arange(len(parameters)), order):
        packed, paid_out = varied(
            robot, Model(robot).rows(), [parameters[k] for k in chosen], values[:, chosen], lengths
        )
        np.testing.assert_allclose(paid_out, wanted, rtol=ULP)
        np.testing.assert_array_equal(packed.lines, np.repeat(Model(robot).rows().lines, 6, axis=0))
    np.testing.assert_array_equal(lengths, before)  # what was commanded is left alone


@pytest.mark.parametrize("model", BUILT, ids=cases.name)
def test_nominal_values_change_nothing(model: Model) -> None:
    parameters = all_of(model.robot)
    values = np.array([[nominal(model.robot, one) for one in parameters]])
    lengths = np.random.default_rng(SEED).uniform(3.0, 9.0, (1, model.m))
    packed, paid_out = varied(model.robot, model.rows(), parameters, values, lengths)
    np.testing.assert_array_equal(packed.lines, model.rows().lines)
    np.testing.assert_array_equal(packed.platform, model.rows().platform)
    np.testing.assert_array_equal(paid_out, lengths)


def test_rows_of_their_own_keep_what_sets_them_apart() -> None:
    """A batch whose rows differ already, in exit points and preferred tensions, is varied row by row."""
    robot = load("house-printer")
    model, rng = Model(robot), np.random.default_rng(SEED)
    packed = model.rows(exit_points=rng.uniform(-5.0, 5.0, (5, 4, 3)), preferred=rng.uniform(100, 900, (5, 4)))
    moduli = parameters_of(robot, "modulus")
    found, _ = varied(robot, packed, moduli, np.full((5, 4), 2.0), np.ones((5, 4)))
    wanted = packed.lines.copy()
    wanted[:, :, list(layout.COMPLIANCES)] /= 2.0
    np.testing.assert_array_equal(found.lines, wanted)


def test_platform_points_of_a_retracted_platform_stay_retracted() -> None:
    """Nominal platform points change nothing in rows that are retracted, and the others of a retracted robot move
    equally."""
    robot = load("jung2020")
    model, lengths = Model(robot), np.ones((2, robot.m))
    drawn_in = np.array([1.2, 1.7])
    rows = model.rows(retraction=drawn_in)
    points = [one for axis in "xyz" for one in parameters_of(robot, f"platform_point.{axis}")]
    values = np.array([[nominal(robot, one) for one in points]] * 2)
    found, _ = varied(robot, rows, points, values, lengths)
    np.testing.assert_allclose(found.lines, rows.lines, rtol=0, atol=4 * ULP)


@pytest.mark.parametrize("fidelity", [Fidelity(sheave=SheaveLaw.EYELET), Fidelity(CableLaw.ELASTIC)])
def test_what_a_fidelity_leaves_out_has_no_effect(fidelity: Fidelity) -> None:
    robot = load("merlet2023")
    kind = "linear_density" if fidelity.sheave is None else "sheave_radius"
    rows = Model(robot, fidelity).rows()
    found, _ = varied(robot, rows, parameters_of(robot, kind, shared=True), np.array([[0.123]]), np.ones((1, 4)))
    np.testing.assert_array_equal(found.lines, rows.lines)


def test_a_cable_without_weight_has_no_density_to_doubt() -> None:
    with pytest.raises(InputError, match="the cable of line 'south-west' has no weight"):
        parameters_of(with_density(load("house-printer"), 0.0), "linear_density")


def with_density(robot: Robot, density: float) -> Robot:
    cable: Cable = robot.lines[0].cable.model_copy(update={"linear_density": density})
    return cases.replaced(robot, robot.name, cable=cable)
