"""Laws of lines with a spring at the winch end: energy, a longer line, derivatives, and what does not cover them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

import cablewright as cw
import out_of_plane
from cablewright.control.length_check import lengths_at
from cablewright.foundation.errors import InputError
from cablewright.models.statics import Model
from cablewright.models.stiffness import stiffness
from cablewright.robot import Eyelet, Robot, load
from cablewright.robot.parameters import Parameter
from cablewright.solvers.line_cover import refuse_unfit
from cablewright.solvers.parameter_effects import response
from physics.test_lines_out_of_plane import differences

POSE = [0.4, -0.3, 1.2]
RATES = (4e3, 2e4, 1e5, 5e4)  # N/m
LAWS = ("elastic", "catenary")


def sprung(robot: Robot, rates: tuple[float, ...] = RATES, **own: Any) -> Robot:
    lines = tuple(line.model_copy(update={"spring": rates[i % len(rates)]} | own) for i, line in enumerate(robot.lines))
    return out_of_plane.checked(robot.model_copy(update={"lines": lines}))


def held(robot: Robot, cable: str) -> cw.Equilibrium:
    at = {"cogiro": [0.4, -0.3, 1.2, 0.02, -0.01, 0.03], "house-printer": [1.0, -0.7, 2.0]}
    pose = [0.4, -0.3, 1.6, 0.0, 0.0, 0.02] if robot.name in ("tilted", "mounts") else at.get(robot.name, POSE)
    return cw.inverse(robot, pose, cable=cable).checked()


ROBOTS = ("merlet2023", "cogiro", "house-printer", "tilted", "mounts")


def of(name: str) -> Robot:
    return out_of_plane.body(name) if name in ("tilted", "mounts") else load(name)


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("cable", LAWS)
def test_a_line_is_shorter_by_the_stretch_of_its_spring(name: str, cable: str) -> None:
    """At the same pose tensions are the same, and lengths paid out less by tension over rate."""
    plain = held(of(name), cable)
    robot = sprung(of(name))
    found = cw.inverse(robot, plain.pose, cable=cable).checked()
    rates = np.array([line.spring / line.cables for line in robot.lines])
    np.testing.assert_allclose(found.tensions, plain.tensions, rtol=1e-6)
    np.testing.assert_allclose(found.lengths, plain.lengths - plain.tensions / rates, rtol=1e-9)
    there = cw.forward(robot, found.lengths, cable=cable, guess=found.pose)
    np.testing.assert_allclose(there.pose, found.pose, atol=1e-9)
    if robot.n == 3:
        cold = cw.forward(robot, found.lengths, cable=cable)
        np.testing.assert_allclose(cold.pose, found.pose, atol=1e-8)


def test_the_platform_rests_where_the_energy_is_least() -> None:
    """Straight lines through eyelets: strain energy of cables and springs, over the place and their split."""
    robot = sprung(load("merlet2023"), sheave=Eyelet(), winch_exit=None)
    lengths = cw.inverse(robot, POSE, cable="elastic").checked().lengths - [0.02, 0.0, 0.01, -0.01]
    found = cw.forward(robot, lengths, cable="elastic")
    exits = np.array([line.exit_point for line in robot.lines])
    hard, rates = np.array([line.cable.stiffness for line in robot.lines]), np.array(RATES)
    weight = robot.platform.mass * robot.scene.gravity

    def energy(q: np.ndarray) -> float:
        chord, more = np.linalg.norm(q[:3] - exits, axis=1), 0.1 * q[3:]
        free = lengths + more  # what the spring lets out
        drawn = np.maximum(chord - free, 0.0)
        # cable that the spring lets out is cable too: at its tension it holds what it was strained by
        return float((0.5 * hard * drawn**2 / free).sum() + 0.5 * (rates * more**2).sum() + weight * q[2])

    least = minimize(energy, np.append(found.pose + 1e-3, np.zeros(4)), method="BFGS", options={"gtol": 1e-7})
    strains = found.tensions / hard
    assert strains.max() < 2e-3  # of the split, whose energy has an error of that share
    np.testing.assert_allclose(least.x[:3], found.pose, atol=2e-4)


@pytest.mark.parametrize("name", ROBOTS)
def test_motions_are_differences(name: str) -> None:
    robot = sprung(of(name))
    each, model = held(robot, "catenary"), Model.of(robot)
    for kind, step in (("modulus", 1e-4), ("exit_point.x", 1e-6), ("length_offset", 1e-6), ("linear_density", 1e-4)):
        parameter = Parameter(kind, robot.lines[0].name)
        apart = differences(model, each, parameter, step)
        motion = response(each[None], [parameter])[0, :, 0]
        np.testing.assert_allclose(motion, apart, rtol=5e-5, atol=5e-6 * np.abs(apart).max(), err_msg=kind)
    matrix = cw.linearise(each).stiffness
    assert np.abs(matrix - matrix.T).max() < 1e-4 * np.abs(matrix).max()


def test_its_stiffness_is_in_series() -> None:
    plain, soft = load("merlet2023"), sprung(load("merlet2023"))
    cut = {"sheave": Eyelet(), "winch_exit": None}
    plain, soft = (
        out_of_plane.checked(
            each.model_copy(update={"lines": tuple(line.model_copy(update=cut) for line in each.lines)})
        )
        for each in (plain, soft)
    )
    first, second = (stiffness(cw.inverse(each, POSE, cable="elastic").checked()).axial for each in (plain, soft))
    np.testing.assert_allclose(1.0 / second, 1.0 / first + 1.0 / np.array(RATES), rtol=1e-3)
    rigid = stiffness(cw.inverse(soft, POSE, cable="rigid").checked()).axial
    np.testing.assert_allclose(rigid, second, rtol=1e-2)


def test_homing_counts_them() -> None:
    robot = sprung(load("house-printer"))
    found = held(robot, "catenary")
    np.testing.assert_allclose(lengths_at(Model.of(robot), found.pose, found.tensions), found.lengths, atol=1.5e-3)


def test_several_cables_share_one_spring() -> None:
    one = sprung(load("merlet2023"), (1e4,))
    two = sprung(load("merlet2023"), (1e4,), cables=2)
    first, second = (cw.inverse(each, POSE).checked() for each in (one, two))
    stretched = [
        cw.inverse(load("merlet2023"), POSE).checked().lengths - first.lengths,
        cw.inverse(sprung(load("merlet2023"), (1e12,), cables=2), POSE).checked().lengths - second.lengths,
    ]
    np.testing.assert_allclose(stretched[0], first.tensions / 1e4, rtol=1e-5)
    np.testing.assert_allclose(stretched[1], 2.0 * second.tensions / 1e4, rtol=1e-3)


def test_what_does_not_cover_them_says_so(tmp_path: Path) -> None:
    robot = sprung(load("merlet2023"))
    found = held(robot, "catenary")
    with pytest.raises(InputError, match=r"exhaustive: line '.*' has a spring; not supported"):
        refuse_unfit(found.model, found.lengths)
    text = (Path(cw.robot.__file__).parent / "library" / "merlet2023.toml").read_text()
    for value, why in (("0", "greater than 0"), ('"3 N"', "spring"), ("-1", "greater than 0")):
        (tmp_path / "bad.toml").write_text(text.replace("[line]", f"[line]\nspring = {value}", 1))
        with pytest.raises(InputError, match=why):
            load(tmp_path / "bad.toml")
