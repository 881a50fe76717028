"""Angles of drums by lengths of lines, bare and with layers of cable."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cablewright.errors import InputError
from cablewright.machine.drums import drums_of
from cablewright.machine.files import load_machine
from cablewright.models.coil import wind
from cablewright.models.drum import Drum
from cablewright.robot import load

HELD, LENGTHS = 40.0, np.linspace(3.0, 30.0, 200)


def coiled(pitch: float = 0.004) -> Drum:
    return Drum(0.05, wind(60.0, 0.05, 0.1, 0.005, pitch), HELD)  # 20 turns a layer


@pytest.mark.parametrize("drum", [Drum(0.05), coiled()], ids=["bare", "layers"])
def test_lengths_come_back(drum: Drum) -> None:
    angles = drum.angles(LENGTHS)
    assert (np.diff(angles) > 0).all()
    np.testing.assert_allclose(drum.lengths(angles), LENGTHS, atol=1e-10)


def test_layers_without_thickness_are_a_bare_drum() -> None:
    angles = coiled(pitch=0.0).angles(LENGTHS)
    np.testing.assert_allclose(angles - angles[0], (LENGTHS - LENGTHS[0]) / 0.05, atol=1e-9)


def test_the_first_turns_off_a_full_drum_pay_out_most() -> None:
    drum = coiled()
    assert drum.per_turn(3.0) > drum.per_turn(30.0) > 2 * math.pi * 0.05
    step = 1e-6
    slope = step / float(drum.angles(np.array([10.0, 10.0 + step])) @ [-1.0, 1.0])
    assert drum.per_turn(10.0) == pytest.approx(2 * math.pi * slope, rel=1e-4)


def test_a_line_that_the_winch_does_not_hold() -> None:
    with pytest.raises(InputError, match="the winch pays out 0 to 40 m"):
        coiled().angles(np.array([10.0, 41.0]))


def test_drums_of_a_robot() -> None:
    robot, machine = load("house-printer"), load_machine("house-printer")
    assert {drum.coil is None for drum in drums_of(robot)} == {True}
    assert {drum.held for drum in drums_of(robot, machine)} == {58.0}
    with pytest.raises(InputError, match=r"gives no winch\.drum_radius"):
        drums_of(load("caroca"))
