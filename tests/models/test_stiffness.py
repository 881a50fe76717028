"""The parts of the tangent stiffness: exact for straight lines, they always add up, sag is in its own part."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cases
from cablewright.foundation.errors import AnswerError
from cablewright.kernels import layout
from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
from cablewright.models.statics import Model
from cablewright.models.stiffness import stiffness
from cablewright.robot import load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import inverse, solve_inverse
from cablewright.solvers.linearise import linearise
from oracles import complex_step

STRAIGHT = [Model(robot, Fidelity(CableLaw.ELASTIC, SheaveLaw.EYELET)) for robot in cases.robots()]
ALL = list(cases.models(CableLaw.ELASTIC, CableLaw.CATENARY))
WIND, TWIST = (3.0, -2.0, 4.0), (0.6, -0.4, 0.3)


@pytest.mark.parametrize("model", STRAIGHT, ids=cases.name)
def test_parts_are_derivatives_of_the_wrench(model: Model) -> None:
    """By complex steps: the tensions' change with nothing turning, and the turning under constant tensions."""
    held = cases.poses(model, 3)
    found = stiffness(held)
    for row in range(3):
        elastic, geometric = complex_step.parts(model.robot, held.lengths[row], held.pose[row])
        np.testing.assert_allclose(found.elastic[row], elastic, rtol=0, atol=1e-9 * np.abs(elastic).max())
        np.testing.assert_allclose(found.geometric[row], geometric, rtol=0, atol=1e-9 * np.abs(geometric).max())
        whole = complex_step.whole(model.robot, held.lengths[row], held.pose[row])
        np.testing.assert_allclose(found.total[row], whole, rtol=0, atol=1e-10 * np.abs(whole).max())


def test_a_constant_wrench_turns_nothing_but_its_arms() -> None:
    """A force in the origin and a moment held in space: the oracle has them, and the parts still are its own."""
    model = Model(load("jung2020").under_wrench(WIND, TWIST), Fidelity(CableLaw.ELASTIC))
    held = cases.poses(model, 3)
    found = stiffness(held)
    for row in range(3):
        elastic, geometric = complex_step.parts(model.robot, held.lengths[row], held.pose[row])
        np.testing.assert_allclose(found.elastic[row], elastic, rtol=0, atol=1e-9 * np.abs(elastic).max())
        np.testing.assert_allclose(found.geometric[row], geometric, rtol=0, atol=1e-9 * np.abs(geometric).max())


@pytest.mark.parametrize("model", ALL, ids=cases.name)
def test_parts_add_up_to_the_tangent_stiffness(model: Model) -> None:
    """Of every cable and sheave; the elastic part is symmetric and holds as many directions as there are lines."""
    held = cases.poses(model, 10)
    found, whole = stiffness(held), linearise(held).stiffness
    np.testing.assert_allclose(found.total, whole, rtol=0, atol=1e-12 * np.abs(whole).max())
    np.testing.assert_allclose(found.elastic, found.elastic.transpose(0, 2, 1), rtol=0, atol=1e-9)
    assert (found.axial > 0).all()
    np.testing.assert_allclose(np.linalg.norm(found.chords, axis=-1), 1.0, rtol=1e-12)
    least = np.linalg.eigvalsh(found.elastic)
    assert (least > -1e-12 * least[:, -1:]).all()
    if model.m < model.n:
        np.testing.assert_allclose(least[:, : model.n - model.m] / least[:, -1:], 0.0, atol=1e-12)


@pytest.mark.parametrize("model", [model for model in ALL if model.fidelity.cable is CableLaw.ELASTIC], ids=cases.name)
def test_a_straight_line_resists_by_its_modulus_over_its_length(model: Model) -> None:
    """EA over all that stretches, over sheaves too; the lever of a universal joint swings, and so deflects too."""
    held = cases.poses(model, 10)
    stretching = held.states[..., layout.FREE].copy()
    for i, line in enumerate(model.robot.lines):
        stretching[:, i] += held.states[:, i, layout.DEAD] if line.dead_elastic else 0.0
        if line.arc_elastic:
            pytest.skip("the cable on the sheave stretches too")
    np.testing.assert_allclose(stiffness(held).chords[..., 2], np.sin(held.states[..., layout.PHI]), atol=1e-9)
    moduli = np.array([line.cable.stiffness for line in model.robot.lines])
    if (held.packed.lines[..., layout.UNKNOWNS] == 6).any():
        assert (stiffness(held).axial < moduli / stretching).all()
    else:
        np.testing.assert_allclose(stiffness(held).axial, moduli / stretching, rtol=1e-9)


@pytest.mark.parametrize("name", ["house-printer", "cogiro"])
def test_light_cables_have_the_parts_of_massless_ones(name: str) -> None:
    robot, pose = load(name), [0.4, 0.3, 1.2]
    straight = stiffness(inverse(robot, pose, cable="elastic"))
    off = []
    for share in (1.0, 1e-2, 1e-4):
        cable = robot.lines[0].cable
        light = cable.model_copy(update={"linear_density": share * cable.linear_density})
        found = stiffness(inverse(cases.replaced(robot, name, cable=light), pose))
        off.append(
            [np.abs(a - b).max() / np.abs(b).max() for a, b in zip(_parts(found), _parts(straight), strict=True)]
        )
    off = np.array(off)
    assert (off[0] < 0.3).all()
    assert (off[1:] < 0.02 * off[:-1]).all()


def _parts(found) -> tuple[np.ndarray, np.ndarray]:
    return found.elastic, found.geometric


def test_a_sagging_line_deflects_by_stretch_and_sag_in_series() -> None:
    """Ernst: 1/k = L/EA + (w cos a)^2 L^3 / 12 T^3, so that the elastic part falls with the tension's third power."""
    cable = load("house-printer").lines[0].cable
    robot = cases.replaced(load("house-printer"), "heavy", cable=cable.model_copy(update={"linear_density": 0.2}))
    held = inverse(robot, [[0.0, 0.0, z] for z in (0.5, 2.0, 5.0)], sheave="eyelet")
    states = held.states
    L, dead = states[..., layout.FREE], states[..., layout.DEAD]
    EA, w = robot.lines[0].cable.stiffness, robot.lines[0].cable.linear_density * robot.scene.gravity
    middle = 0.5 * (held.tensions + held.platform_tensions)
    across = w * np.linalg.norm(stiffness(held).chords[..., :2], axis=-1)
    series = (L + dead) / EA + across**2 * L**3 / (12 * middle**3)
    np.testing.assert_allclose(1 / stiffness(held).axial, series, rtol=1e-2)
    assert (series > 1.05 * (L + dead) / EA).all()  # there is sag to speak of


def test_rigid_cables_are_elastic_ones_of_the_same_tensions() -> None:
    for model in cases.models(CableLaw.RIGID):
        held = cases.poses(model, 5)
        soft = Model(model.robot, Fidelity(CableLaw.ELASTIC, model.fidelity.sheave))
        if model.m < model.n:  # gravity chooses the tensions
            again = solve_forward(soft, elastic_lengths(soft, held), guess=held.pose)
        else:
            again = solve_inverse(soft, held.pose, preferred=held.tensions)
        wanted = stiffness(again)
        for part, other in zip(_parts(stiffness(held)), _parts(wanted), strict=True):
            np.testing.assert_allclose(part, other, rtol=0, atol=1e-5 * np.abs(other).max())


def elastic_lengths(soft: Model, held) -> np.ndarray:
    """Unstrained lengths of elastic lines where rigid ones of the same tensions are."""
    free, dead = held.states[..., layout.FREE], held.states[..., layout.DEAD]
    shrink = held.tensions / (np.array([line.cable.stiffness for line in soft.robot.lines]) + held.tensions)
    elastic = np.array([line.dead_elastic for line in soft.robot.lines])
    return held.lengths - shrink * (free + np.where(elastic, dead, 0.0))


def test_a_slack_massless_line_adds_nothing() -> None:
    robot = load("merlet2023")
    lengths = inverse(robot, [0.0, -1.0, 1.0], cable="elastic").lengths
    lengths[3] += 0.5
    found = stiffness(solve_forward(Model(robot, Fidelity(CableLaw.ELASTIC)), lengths).checked())
    assert (found.axial > 0).tolist() == [True, True, True, False]
    assert (found.chords[3] == 0).all()


def test_rows_are_those_of_single_ones_and_those_without_balance_are_nan() -> None:
    model = Model(load("cogiro"))
    held = solve_inverse(model, [[0.2, -0.1, 1.0], [0.0, 0.0, 20.0], [1.0, 2.0, 1.5]])
    found = stiffness(held)
    assert np.isfinite(found.total).all(axis=(1, 2)).tolist() == [True, False, True]
    for row in (0, 2):
        np.testing.assert_array_equal(stiffness(held[row]).total, found.total[row])
        np.testing.assert_array_equal(stiffness(held[row]).elastic, found.elastic[row])
    with pytest.raises(AnswerError, match="no tensions within the limits"):
        stiffness(held[1])


def test_what_was_moved_apart_is_no_equilibrium() -> None:
    """Lengths of another place, or tensions that leave a force, are rejected."""
    held = inverse(load("cogiro"), [[0.2, -0.1, 1.0]] * 3)
    lengths, states = held.lengths.copy(), held.states.copy()
    lengths[1] += 1e-3
    states[2, :, layout.TAU] += 0.01
    found = stiffness(replace(held, lengths=lengths, states=states))
    assert np.isfinite(found.total).all(axis=(1, 2)).tolist() == [True, False, False]


def test_retraction_moves_the_arms() -> None:
    robot = load("jung2020")
    poses = [[0.2, 0.1, 0.9], [0.1, 0.0, 1.0]]
    by_row = stiffness(inverse(robot, poses, retraction=[1.4, 1.8]))
    for row, length in enumerate((1.4, 1.8)):
        alone = stiffness(inverse(robot.retracted(length), poses[row]))
        np.testing.assert_allclose(by_row.elastic[row], alone.elastic, rtol=0, atol=1e-8 * np.abs(alone.elastic).max())
