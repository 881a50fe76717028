"""A line may hang straight down from an eyelet: the limit of all directions, no singularity."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.errors import Status
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Model
from cablewright.robot import load, loads
from cablewright.robot.new_robot import Outline, robot_file
from cablewright.solvers.certify import certify
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import linearise
from cablewright.solvers.slack import solve_with_slack
from cablewright.solvers.uniqueness import unique_among

HANG = loads(robot_file(Outline(name="hang", layout="over-middle", size=(4.0, 3.0, 3.0))))
UNDER = np.array([0.0, 0.0, 0.5])
AROUND = [(np.cos(turn), np.sin(turn), 0.0) for turn in np.linspace(0.0, 6.0, 7)]


@pytest.mark.parametrize("cable", [CableLaw.ELASTIC, CableLaw.CATENARY])
def test_it_is_the_limit_from_every_side(cable: CableLaw) -> None:
    model = Model(HANG, Fidelity(cable))
    below = solve_inverse(model, UNDER).checked()
    for aside in AROUND:
        near = [solve_inverse(model, UNDER + sign * 1e-5 * np.array(aside)).checked() for sign in (1.0, -1.0)]
        np.testing.assert_allclose(0.5 * (near[0].lengths + near[1].lengths), below.lengths, atol=1e-9)
        np.testing.assert_allclose(0.5 * (near[0].tensions + near[1].tensions), below.tensions, rtol=1e-7)
        there = linearise(near[0]).stiffness
        np.testing.assert_allclose(linearise(below).stiffness, there, atol=1e-4 * np.abs(there).max())


def test_the_way_back_needs_no_guess() -> None:
    model = Model(HANG)
    for height in (0.1, 0.75, 2.6):
        held = solve_inverse(model, [0.0, 0.0, height]).checked()
        assert np.abs(solve_forward(model, held.lengths).checked().pose - held.pose).max() < 1e-8


def test_a_weight_on_one_line_is_a_pendulum() -> None:
    robot = HANG.model_copy(update={"lines": HANG.lines[-1:]})
    found = solve_forward(Model(robot, Fidelity(CableLaw.ELASTIC)), [2.5]).checked()
    weight, own = robot.platform.mass * 9.81, robot.lines[0].cable.stiffness
    chord = 2.5 * (1.0 + weight / own)
    np.testing.assert_allclose(found.pose, [0.0, 0.0, robot.lines[0].exit_point[2] - chord], atol=1e-8)
    assert found.tensions[0] == pytest.approx(weight, rel=1e-9)
    np.testing.assert_allclose(np.diag(linearise(found).stiffness), [weight / chord] * 2 + [own / 2.5], rtol=1e-6)


def test_a_slack_line_hangs_as_a_hairpin() -> None:
    model = Model(HANG)
    below = solve_with_slack(model, UNDER, {"over-middle": 0.3})
    near = solve_with_slack(model, UNDER + np.array([1e-6, 0.0, 0.0]), {"over-middle": 0.3})
    assert below.status is near.status is Status.OK
    np.testing.assert_allclose(below.lengths, near.lengths, atol=2e-6)
    hairpin, weight = below.lengths[-1], HANG.lines[-1].cable.linear_density * 9.81
    drop = HANG.lines[-1].exit_point[2] - UNDER[2]
    assert below.tensions[-1] == pytest.approx(0.5 * weight * (hairpin + drop), rel=1e-3)


def test_a_proof_that_needs_its_plane_says_so() -> None:
    """Theorem 1 knows nothing of planes: there is one equilibrium nevertheless."""
    model = Model(HANG)
    poses = [UNDER, UNDER + np.array([0.1, 0.0, 0.0])]
    found = solve_forward(model, solve_inverse(model, poses).checked().lengths).checked()
    proofs = certify(found)
    assert list(proofs.certified) == [False, True]
    assert "a line hangs straight down" in proofs[0].reason()
    assert unique_among(found[0]) == "all equilibria"


def test_in_the_eyelet_itself_it_has_no_direction() -> None:
    assert solve_inverse(Model(HANG), HANG.lines[-1].exit_point).status is Status.UNDER_EXIT


def test_over_a_sheave_a_line_has_no_plane_there() -> None:
    model = Model(load("merlet2023"))
    x, y, _ = model.robot.lines[0].exit_point
    assert solve_inverse(model, [x, y, 1.0]).status is Status.UNDER_EXIT
