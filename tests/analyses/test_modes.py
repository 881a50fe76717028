"""Natural frequencies: textbook springs, pendulums and strings, laws of scale, independent dense models and MuJoCo."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation

import cases
from cablewright.analyses.modes import FREEDOMS, modes
from cablewright.foundation.errors import InputError
from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
from cablewright.models.inertia import mass_matrix
from cablewright.models.statics import Model
from cablewright.robot import Eyelet, Robot, load, loads
from cablewright.solvers.forward import forward, solve_forward
from cablewright.solvers.inverse import inverse, solve_inverse
from oracles import complex_step, mujoco_model

G, MASS, EA = 9.81, 20.0, 1e5


def strings(exits: list[tuple[float, float, float]], force: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Robot:
    """A point mass on massless strings."""
    lines = "".join(f'[[lines]]\nname = "{i}"\nexit_point = {list(point)}\n' for i, point in enumerate(exits))
    return loads(f"""
schema = 1
name = "strings"
[scene]
gravity = {G}
frame_min = [-10.0, -10.0, -10.0]
frame_max = [10.0, 10.0, 10.0]
[platform]
mass = {MASS}
force = {list(force)}
[cable]
axial_stiffness = {EA}
linear_density = 0.0
breaking_load = 1e6
[sheave]
kind = "eyelet"
[line]
tension_limits = [1.0, 1e5]
{lines}""")


def hertz(square: float) -> float:
    return float(np.sqrt(square) / (2 * np.pi))


def test_a_mass_on_a_spring_and_a_pendulum() -> None:
    """One line: along it the spring's sqrt(k / m), across it the pendulum's sqrt(g / l), from tension alone.

    A side force keeps it from being vertical, where a line has no plane; it hangs along the apparent gravity.
    """
    side = 40.0
    held = forward(strings([(0.0, 0.0, 0.0)], (side, 0.0, 0.0)), [3.0], cable="elastic").checked()
    gravity = np.hypot(side / MASS, G)
    swing, spring = hertz(gravity / np.linalg.norm(held.pose)), hertz(EA / 3.0 / MASS)
    np.testing.assert_allclose(modes(held).frequencies, [swing, swing, spring], rtol=1e-9)
    alone = modes(held, geometric=False)
    np.testing.assert_allclose(alone.frequencies, [0.0, 0.0, spring], rtol=1e-9)
    along = held.pose / np.linalg.norm(held.pose)
    np.testing.assert_allclose(np.abs(alone.shapes[:, 2]) * np.sqrt(MASS), np.abs(along), atol=1e-9)
    np.testing.assert_allclose(alone.participation[:, 2], along**2, atol=1e-9)


def test_a_mass_on_a_taut_string() -> None:
    """Between two walls, its weight taken away: 2 T / l across, 2 EA / l along."""
    held = forward(strings([(-3.0, 0.0, 0.0), (3.0, 0.0, 0.0)], (0.0, 0.0, MASS * G)), [2.99, 2.99], cable="elastic")
    tension = EA * (3.0 / 2.99 - 1.0)
    across, along = hertz(2 * tension / 3.0 / MASS), hertz(2 * EA / 2.99 / MASS)
    found = modes(held.checked())
    np.testing.assert_allclose(found.frequencies, [across, across, along], rtol=1e-6)
    assert FREEDOMS[found.dominant[2]] == "x"
    assert found.asymmetry == 0


def bodies() -> list[Model]:
    """Bodies on straight lines through eyelets."""
    found = [Model(robot, Fidelity(CableLaw.ELASTIC, SheaveLaw.EYELET)) for robot in cases.robots() if robot.n == 6]
    return [model for model in found if model.robot.platform.inertia is not None]


@pytest.mark.parametrize("model", bodies(), ids=cases.name)
def test_a_body_against_a_dense_model_of_its_own(model: Model) -> None:
    """Stiffness by complex steps about the centre of mass, where the mass matrix falls into blocks."""
    held, platform = cases.poses(model, 3), model.robot.platform
    found = modes(held)
    for row in range(3):
        pose, turn = held.pose[row], Rotation.from_rotvec(held.pose[row, 3:]).as_matrix()
        centre = turn @ np.array(platform.centre_of_mass)
        K = complex_step.whole(model.robot, held.lengths[row], pose, about=centre)
        (xx, yy, zz), (xy, xz, yz) = platform.inertia, platform.inertia_products
        M = platform.mass * np.eye(6)
        M[3:, 3:] = turn @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ turn.T
        squares, vectors = eigh((K + K.T) / 2, M)
        np.testing.assert_allclose(found.frequencies[row], np.sqrt(squares) / (2 * np.pi), rtol=1e-8)
        share = vectors[:3] ** 2 * platform.mass  # of translation; those of rotation depend on how products are shared
        np.testing.assert_allclose(found.participation[row, :3], share, atol=1e-6)
        np.testing.assert_allclose(found.participation[row].sum(axis=0), 1.0, rtol=1e-12)


@pytest.mark.parametrize("model", list(cases.models(CableLaw.ELASTIC, CableLaw.CATENARY)), ids=cases.name)
def test_modes_solve_their_own_equations(model: Model) -> None:
    """K x = (2 pi f)^2 M x, of unit modal mass, with K symmetrised; energy shares that add up."""
    if model.n == 6 and model.robot.platform.inertia is None:
        pytest.skip("its inertia is not known")
    held = cases.poses(model, 5)
    for geometric in (True, False):
        found = modes(held, geometric=geometric)
        whole = found.stiffness.total if geometric else found.stiffness.elastic
        K, M = 0.5 * (whole + whole.transpose(0, 2, 1)), mass_matrix(model.robot, held.pose)
        squares = np.sign(found.frequencies) * (2 * np.pi * found.frequencies) ** 2
        moved = M @ found.shapes * squares[:, None, :]
        grain = 1e-9 * np.abs(K).max() * np.abs(found.shapes).max()
        np.testing.assert_allclose(K @ found.shapes, moved, rtol=0, atol=grain)
        unit = found.shapes.transpose(0, 2, 1) @ M @ found.shapes
        np.testing.assert_allclose(unit, np.broadcast_to(np.eye(model.n), unit.shape), atol=1e-10)
        assert (np.diff(found.frequencies) >= 0).all()
        np.testing.assert_allclose(found.participation.sum(axis=1), 1.0, rtol=1e-12)
        assert (found.participation >= 0).all()
        np.testing.assert_array_equal(found.lowest, found.frequencies[:, 0])
        assert (found.asymmetry < 2e-3).all()


@pytest.mark.parametrize("name", ["jung2020", "cogiro", "house-printer", "merlet2023"])
def test_turning_the_whole_robot_leaves_frequencies(name: str) -> None:
    """About the vertical, and the pose with it."""
    robot, turn = load(name), Rotation.from_rotvec([0, 0, 0.7])
    pose = np.array([0.2, -0.1, 1.0, 0.02, -0.01, 0.003])[: robot.n]
    lines = tuple(
        line.model_copy(
            update={
                "exit_point": tuple(turn.apply(line.exit_point).tolist()),
                "winch_exit": None if line.winch_exit is None else tuple(turn.apply(line.winch_exit).tolist()),
            }
        )
        for line in robot.lines
    )
    there = turn.apply(pose[:3])
    if robot.n == 6:
        there = np.concatenate([there, (turn * Rotation.from_rotvec(pose[3:])).as_rotvec()])
    here = modes(inverse(robot, pose))
    turned = modes(inverse(robot.model_copy(update={"lines": lines}), there))
    np.testing.assert_allclose(turned.frequencies, here.frequencies, rtol=1e-8)
    np.testing.assert_allclose(turned.line_frequencies, here.line_frequencies, rtol=1e-8)


@pytest.mark.parametrize("cable", ["elastic", "catenary"])
def test_frequencies_fall_with_the_root_of_size(cable: str) -> None:
    """All lengths s times, all masses q times and EA with them: strains and angles stay, frequencies fall by sqrt s."""
    s, q, robot = 2.5, 3.0, load("jung2020")
    pose = np.array([0.2, 0.1, 0.9, 0.02, -0.01, 0.003])
    small = modes(inverse(robot, pose, cable=cable))
    platform = robot.platform.model_copy(
        update={"mass": q * robot.platform.mass, "inertia": tuple(q * s * s * each for each in robot.platform.inertia)}
    )
    lines = tuple(
        line.model_copy(
            update={
                "exit_point": tuple(s * x for x in line.exit_point),
                "platform_point": tuple(s * x for x in line.platform_point),
                "tension_limits": tuple(q * x for x in line.tension_limits),
                "cable": line.cable.model_copy(
                    update={"axial_stiffness": q * 130e3, "linear_density": q / s * line.cable.linear_density}
                ),
            }
        )
        for line in robot.lines
    )
    big = robot.model_copy(update={"platform": platform, "lines": lines})
    large = modes(inverse(big, pose * [s, s, s, 1, 1, 1], cable=cable))
    np.testing.assert_allclose(large.frequencies, small.frequencies / np.sqrt(s), rtol=1e-8)
    np.testing.assert_allclose(large.line_frequencies, small.line_frequencies / np.sqrt(s), rtol=1e-8)
    np.testing.assert_allclose(large.participation, small.participation, atol=1e-8)


@pytest.mark.parametrize("name", ["jung2020", "cogiro", "grab-four-lines", "merlet2023"])
def test_mujoco_finds_the_same_vibrations(name: str) -> None:
    """A free body on MuJoCo's elastic tendons, at rest where these lengths lead it."""
    model = Model(load(name), Fidelity(CableLaw.ELASTIC))
    robot = cases.replaced(model.robot, name, sheave=Eyelet(), winch_exit=None)
    held = cases.poses(Model(robot, model.fidelity), 1)[0]
    wanted = mujoco_model.frequencies(robot, held.lengths.tolist(), held.pose.tolist())
    np.testing.assert_allclose(modes(held).frequencies, wanted, rtol=1e-6)


def test_a_platform_on_its_head_has_a_negative_frequency() -> None:
    """A centre of mass so high that the lines cannot keep it up."""
    robot = load("cogiro")
    tall = robot.platform.model_copy(update={"centre_of_mass": (0.0, 0.0, 150.0)})
    held = inverse(robot.model_copy(update={"platform": tall}), [0.0, 0.0, 1.0])
    assert held.status.word == "unstable"
    found = modes(held)
    assert found.lowest < 0
    assert np.linalg.eigvalsh(found.stiffness.total + found.stiffness.total.T)[0] < 0
    assert modes(held, geometric=False).lowest > 0


def test_a_moment_held_in_space_shows_as_asymmetry() -> None:
    """It keeps no energy; symmetrising is wrong by its square."""
    robot, pose = load("cogiro"), [0.5, 0.3, 1.0]
    off = []
    for size in (1.0, 10.0):
        moment = (4.0 * size, -3.0 * size, 2.0 * size)
        held = inverse(robot.under_wrench((0.0, 0.0, 0.0), moment), pose, sheave="eyelet")
        found, M = modes(held.checked()), mass_matrix(robot, held.pose)
        exact = np.sort(np.sqrt(np.linalg.eigvals(np.linalg.solve(M, found.stiffness.total)).real)) / (2 * np.pi)
        off.append((found.asymmetry, np.abs(found.frequencies / exact - 1).max()))
    (least, first), (most, second) = off
    assert most == pytest.approx(10 * least, rel=0.1)
    assert 0 < first < least**2 * 20
    assert second == pytest.approx(100 * first, rel=0.2)


def test_line_frequencies_are_those_of_strings() -> None:
    held = inverse(load("jung2020"), [0.2, 0.1, 0.9], cable="elastic")
    chord = np.linalg.norm(held.platform_points - [line.exit_point for line in held.model.robot.lines], axis=1)
    wanted = np.sqrt(held.tensions / 2.5e-3) / (2 * chord)
    np.testing.assert_allclose(modes(held).line_frequencies, wanted, rtol=1e-9)
    massless = forward(strings([(0.0, 0.0, 0.0)], (40.0, 0, 0)), [3.0], cable="elastic")
    assert np.isnan(modes(massless).line_frequencies).all()


def test_rows_are_those_of_single_ones_and_those_without_balance_are_nan() -> None:
    model = Model(load("jung2020"))
    poses = [[0.2, 0.1, 0.9], [0.0, 0.0, 9.0], [0.3, 0.0, 0.5]]
    found = modes(model, poses, retraction=[1.9, 2.0, 1.5])
    assert np.isfinite(found.lowest).tolist() == [True, False, True]
    assert np.isnan(found.participation[1]).all()
    assert found.dominant.shape == (3, 6)
    for row, length in ((0, 1.9), (2, 1.5)):
        alone = modes(model, poses[row], retraction=length)
        np.testing.assert_array_equal(alone.frequencies, found.frequencies[row])
        np.testing.assert_array_equal(alone.shapes, found.shapes[row])
    alone = modes(model, poses[1])
    assert "no tensions within the limits" in alone.refusal
    assert not alone.has_modes
    assert alone.to_dict()["frequencies"] is None
    assert found.refusal == alone.refusal


def test_a_body_of_unknown_inertia_is_rejected() -> None:
    robot = load("cogiro")
    bare = robot.platform.model_copy(update={"inertia": None, "inertia_products": (0.0, 0.0, 0.0)})
    with pytest.raises(InputError, match=r"platform\.inertia is required"):
        modes(inverse(robot.model_copy(update={"platform": bare}), [0.0, 0.0, 1.0]))


def test_what_was_solved_forward_vibrates_too() -> None:
    """An equilibrium is one, whichever way it was found."""
    model = Model(load("house-printer"))
    held = solve_inverse(model, [1.0, 2.0, 1.5])
    np.testing.assert_allclose(
        modes(solve_forward(model, held.lengths)).frequencies, modes(held).frequencies, rtol=1e-7
    )
