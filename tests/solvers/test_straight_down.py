"""A line may hang straight down from an eyelet: the limit of all directions, no singularity."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.foundation.errors import Status
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Model
from cablewright.robot import Swivel, loads
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


@pytest.mark.parametrize("cable", [CableLaw.ELASTIC, CableLaw.CATENARY])
def test_under_a_swivel_it_is_the_limit_that_is_unstable(cable: CableLaw) -> None:
    """The sheave can face any way there, and its line drives the platform the other way: that is no wall."""
    lines = (*HANG.lines[:-1], HANG.lines[-1].model_copy(update={"sheave": Swivel(radius=0.05)}))
    model = Model(HANG.model_copy(update={"lines": lines}), Fidelity(cable))
    below = solve_inverse(model, UNDER)
    assert below.status is Status.UNSTABLE
    for aside in AROUND:
        near = solve_inverse(model, UNDER + 1e-7 * np.array(aside))
        assert near.status is Status.UNSTABLE
        np.testing.assert_allclose(near.lengths, below.lengths, rtol=1e-2)
        np.testing.assert_allclose(near.lengths[-1], below.lengths[-1], atol=1e-5)
    further = solve_inverse(model, UNDER + np.array([0.3, 0.2, 0.0])).checked()
    back = solve_forward(model, further.lengths).checked()
    np.testing.assert_allclose(back.pose, further.pose, atol=1e-8)


def test_a_point_load_is_judged_where_a_line_leaves_its_sheave_backwards() -> None:
    """Inverse and forward agree on which poses near a swivel's axis the platform keeps."""
    lines = (*HANG.lines[:-1], HANG.lines[-1].model_copy(update={"sheave": Swivel(radius=0.05)}))
    model = Model(HANG.model_copy(update={"lines": lines}))
    found = solve_inverse(model, UNDER + np.geomspace(1e-8, 0.3, 60)[:, None] * [0.6, 0.8, 0.0])
    assert {Status.OK, Status.UNSTABLE} <= set(found.status)
    for each in found:
        if each.status in (Status.OK, Status.UNSTABLE):
            back = solve_forward(model, each.lengths, guess=each.pose)
            stayed = bool(back.ok) and np.abs(back.pose - each.pose).max() < 1e-6
            assert stayed == (each.status is Status.OK)


def test_a_line_may_pass_a_swivel_straight_down() -> None:
    """Under the sheave, on its own vertical: no cusp, and the limit of all directions."""
    lines = (*HANG.lines[:-1], HANG.lines[-1].model_copy(update={"sheave": Swivel(radius=0.05, wrap="under")}))
    model = Model(HANG.model_copy(update={"lines": lines}))
    below = solve_inverse(model, UNDER).checked()
    for aside in AROUND:
        near = solve_inverse(model, UNDER + 1e-6 * np.array(aside)).checked()
        np.testing.assert_allclose(near.lengths, below.lengths, atol=2e-6)
        there = linearise(near).stiffness
        np.testing.assert_allclose(linearise(below).stiffness, there, atol=1e-4 * np.abs(there).max())
    back = solve_forward(model, below.lengths).checked()
    np.testing.assert_allclose(back.pose, below.pose, atol=1e-8)


@pytest.mark.parametrize("cable", [CableLaw.ELASTIC, CableLaw.CATENARY])
@pytest.mark.parametrize("lengths", [(1.0, 1.0), (1.0, 0.55), (1.0, 2.0), (2.0, 1.4), (2.0, 1.6)])
def test_lines_may_share_one_vertical(cable: CableLaw, lengths: tuple[float, float]) -> None:
    """Two lines from one above the other: the shorter one carries, the other hangs slack beside it; no guess."""
    line, robot = HANG.lines[-1], HANG
    upper, lower = (line.model_copy(update={"name": name, "exit_point": (0.0, 0.0, z)}) for name, z in
                    (("upper", 3.0), ("lower", 2.5)))  # fmt: skip
    model = Model(robot.model_copy(update={"lines": (upper, lower)}), Fidelity(cable))
    found = solve_forward(model, lengths).checked()
    assert found.is_valid()
    hung = min(3.0 - lengths[0], 2.5 - lengths[1], key=lambda z: -z)
    np.testing.assert_allclose(found.pose, [0.0, 0.0, hung], atol=2e-3)
    assert (found.tensions[0] > found.tensions[1]) == (3.0 - lengths[0] > 2.5 - lengths[1])
