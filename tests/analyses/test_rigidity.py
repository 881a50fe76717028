"""Stiffness, natural frequencies and dexterity by name, beside linearisation, modes and singular values."""

import numpy as np
import pytest

import cablewright as cw

POSES = {"house-printer": [[1.0, 2.0, 1.5], [0.0, 0.0, 5.0]], "jung2020": [[0.2, 0.1, 0.9], [0.0, 0.0, 0.8]]}


@pytest.mark.parametrize("name", POSES)
def test_the_stiffness_is_that_of_the_linearisation(name: str) -> None:
    robot, poses = cw.load(name), POSES[name]
    found = cw.stiffness(robot, poses, cable="elastic")
    expected = cw.linearise(cw.inverse(robot, poses, cable="elastic")).stiffness
    assert found.total == pytest.approx(expected, rel=1e-7, abs=1e-6)
    one = cw.stiffness(robot, poses[1], cable="elastic")
    assert np.asarray(one) == pytest.approx(expected[1], rel=1e-7, abs=1e-6)
    assert one.elastic + one.geometric == pytest.approx(one.total)
    assert np.linalg.eigvalsh(one)[0] > 0.0


def test_a_small_force_moves_the_platform_by_the_compliance() -> None:
    robot, pose, force = cw.load("jung2020"), [0.2, 0.1, 0.9], (0.01, 0.02, -0.01)
    held = cw.inverse(robot, pose)
    pushed = cw.forward(robot.under_wrench(force), held.lengths, guess=held.pose).pose - held.pose
    wrench = np.array([*force, 0.0, 0.0, 0.0])
    assert np.asarray(cw.stiffness(held)) @ pushed == pytest.approx(wrench, abs=2e-4)


@pytest.mark.parametrize("name", POSES)
def test_frequencies_are_those_of_modes(name: str) -> None:
    robot, poses = cw.load(name), POSES[name]
    found = cw.natural_frequencies(robot, poses)
    assert found.shape == (2, robot.n)
    assert found == pytest.approx(cw.modes(robot, poses).frequencies)
    assert found[0] == pytest.approx(cw.natural_frequencies(cw.inverse(robot, poses[0])))


def test_dexterity_is_the_inverse_of_the_condition_number_that_numpy_finds() -> None:
    robot, poses = cw.load("cogiro"), [[0.3, 0.2, 2.0], [1.0, 1.0, 1.0]]
    arms = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
    found = cw.dexterity(robot, poses, length=0.5)
    expected = [np.linalg.cond(each * arms) for each in cw.jacobian(robot, poses)]
    assert found.condition_number == pytest.approx(expected)
    assert found.dexterity * found.condition_number == pytest.approx(1.0)
    assert found[1].manipulability == pytest.approx(found.manipulability[1])
    stiff = cw.dexterity(robot, poses[0], of="stiffness", length=0.5)
    K = np.asarray(cw.stiffness(robot, poses[0])) * arms * arms[:, None]
    assert stiff.condition_number == pytest.approx(np.linalg.cond(K))


def test_fewer_lines_than_degrees_of_freedom_leave_the_matrix_singular() -> None:
    found = cw.dexterity(cw.load("grab-four-lines"), [0.0, 0.0, 1.0])
    assert found.values.shape == (6,)
    assert float(found.dexterity) == 0.0
    assert np.isinf(found.condition_number)
    assert found.to_dict()["condition_number"] is None


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"of": "jacobean"}, "did you mean 'jacobian'"),
        ({"length": 0.0}, "length = 0: must be"),
        ({"length": float("nan")}, "length = nan: must be"),
    ],
)
def test_wrong_options_are_named(options: dict[str, object], text: str) -> None:
    with pytest.raises(cw.InputError, match=text):
        cw.dexterity(cw.load("cogiro"), [0.0, 0.0, 2.0], **options)


def test_a_pose_is_requested() -> None:
    with pytest.raises(cw.InputError, match="poses"):
        cw.stiffness(cw.load("cogiro"), None)
