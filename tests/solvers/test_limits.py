"""How each line stands against its own hardware: swing, lever and drum."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import Winch, load
from cablewright.solvers.hardware_limits import lever_angles, swing_angles, winch_torques
from cablewright.solvers.inverse import inverse, solve_inverse

HOUSE = load("house-printer")


def test_in_the_middle_every_sheave_looks_where_it_faces() -> None:
    found = inverse(HOUSE, [[0, 0, 1], [0, 0, 9]])
    np.testing.assert_allclose(swing_angles(found), 0.0, atol=1e-12)


def test_swing_is_the_azimuth_of_the_platform() -> None:
    x, y = 3.0, -4.0
    angles = swing_angles(inverse(HOUSE, [x, y, 1.0]))
    for angle, line in zip(angles, HOUSE.lines, strict=True):
        azimuth = np.arctan2(y - line.exit_point[1], x - line.exit_point[0])
        assert np.angle(np.exp(1j * (azimuth - line.sheave.facing))) == pytest.approx(angle, abs=1e-12)
        assert abs(angle) < line.sheave.swing


def test_without_a_facing_there_is_no_swing() -> None:
    assert np.isnan(swing_angles(inverse(load("merlet2023"), [0, 0, 1]))).all()


def test_levers_hang_within_their_range_and_are_reported_only_where_modelled() -> None:
    angles = lever_angles(inverse(HOUSE, [[0, 0, 1], [3, 3, 8]]))
    assert ((angles > -np.pi / 2) & (angles < 0)).all()
    assert np.isnan(lever_angles(inverse(HOUSE, [0, 0, 1], sheave="swivel"))).all()
    assert np.isnan(lever_angles(inverse(load("merlet2023"), [0, 0, 1]))).all()


def test_torque_is_the_winchs_tension_on_its_drum() -> None:
    found = solve_inverse(Model(HOUSE, Fidelity()), [1.0, 2.0, 3.0])
    np.testing.assert_allclose(winch_torques(found), found.winch_tensions * 0.1, rtol=1e-15)
    assert np.isnan(winch_torques(inverse(load("paty2021"), [0, 0, 1]))).all()


def test_a_build_up_takes_torque_with_the_radius() -> None:
    poses = [[1.0, 2.0, 3.0], [0.0, 0.0, 8.0]]
    held = solve_inverse(Model(HOUSE, Fidelity()), poses)
    spool = Winch(drum_radius=0.1, build_up=0.002, drum_length=12.0)
    lines = tuple(line.model_copy(update={"winch": spool}) for line in HOUSE.lines)
    wound = solve_inverse(Model(HOUSE.model_copy(update={"lines": lines}), Fidelity()), poses)
    radii = 0.1 * np.sqrt(1.0 - 0.004 * (held.lengths - 12.0))
    np.testing.assert_allclose(winch_torques(wound), held.winch_tensions * radii, rtol=1e-14)
