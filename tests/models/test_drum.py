"""Angles of drums by lengths of lines, bare and with layers of cable."""

from __future__ import annotations

import math

import numpy as np
import pytest
import tomlkit

from cablewright.foundation.errors import InputError
from cablewright.machine.drums import drums_of
from cablewright.machine.files import load_machine
from cablewright.models.coil import wind
from cablewright.models.drum import WinchDrum, drum_of
from cablewright.robot import Robot, library_text, load, loads

HELD, LENGTHS = 40.0, np.linspace(3.0, 30.0, 200)


def coiled(pitch: float = 0.004) -> WinchDrum:
    return WinchDrum(0.05, wind(60.0, 0.05, 0.1, 0.005, pitch), HELD)  # 20 turns a layer


def spool(build_up: float = 0.004) -> WinchDrum:
    return WinchDrum(0.05, build_up=build_up, at=8.0)


@pytest.mark.parametrize("drum", [WinchDrum(0.05), spool(), coiled()], ids=["bare", "build-up", "layers"])
def test_lengths_come_back(drum: WinchDrum) -> None:
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
    with pytest.raises(InputError, match=r"has no winch\.drum_radius"):
        drums_of(load("caroca"))


def test_a_build_up_is_the_law_of_hangprinters() -> None:
    """k0 (sqrt(R^2 + k2 x) - R), of the angle by the length x beyond that at the origin, with k2 = -Q."""
    drum, growth = spool(), 2.0 * 0.004 * 0.05**2
    angles = (2.0 / -growth) * (np.sqrt(0.05**2 - growth * (LENGTHS - 8.0)) - 0.05)
    np.testing.assert_allclose(drum.angles(LENGTHS), angles, rtol=1e-9, atol=1e-9)


def test_a_drum_pays_out_its_radius_per_angle() -> None:
    drum, step = spool(), 1e-4
    angles = drum.angles(LENGTHS)
    slopes = (drum.lengths(angles + step) - drum.lengths(angles - step)) / (2.0 * step)
    np.testing.assert_allclose(slopes, drum.radii(LENGTHS), rtol=1e-8)
    assert drum.per_turn(8.0) == pytest.approx(2.0 * math.pi * 0.05, rel=1e-15)


def test_a_small_build_up_is_a_bare_drum() -> None:
    angles = spool(1e-12).angles(LENGTHS)
    np.testing.assert_allclose(angles, (LENGTHS - 8.0) / 0.05, rtol=1e-9)


def test_a_spool_ends_where_its_cable_does() -> None:
    with pytest.raises(InputError, match=r"build_up = 0\.05 1/m: the drum is empty with a line of 18 m"):
        spool(0.05).angles(LENGTHS)
    assert np.isnan(spool().radii(np.array([np.nan]))).all()


def test_a_build_up_needs_its_place() -> None:
    with pytest.raises(InputError, match=r"build_up.*drum_length"):
        robot_of({"drum_radius": 0.05, "build_up": 0.004})
    assert drum_of(robot_of({"drum_radius": 0.05, "build_up": 0.004, "drum_length": 8.0}).lines[0]).at == 8.0


def test_a_coil_follows_the_build_up_of_its_line() -> None:
    machine = load_machine("house-printer")
    robot = robot_of({"drum_radius": 0.05, "build_up": 0.004, "drum_length": 8.0})
    coiled_up, bare = (drums_of(robot, each)[0] for each in (machine, None))
    lengths = np.linspace(1.0, 0.99 * machine.winch.held, 50)
    np.testing.assert_allclose(coiled_up.radii(lengths), bare.radii(lengths), rtol=1e-9)
    turned = [drum.angles(lengths) for drum in (coiled_up, bare)]
    np.testing.assert_allclose(turned[0] - turned[0][0], turned[1] - turned[1][0], rtol=1e-9, atol=1e-7)


def test_a_build_up_that_leaves_no_radius_for_the_cable_of_a_machine() -> None:
    robot = robot_of({"drum_radius": 0.05, "build_up": 0.04, "drum_length": 8.0})
    with pytest.raises(InputError, match=r"build_up = 0\.04 1/m: the drum is empty with a line of 20\.5 m"):
        drums_of(robot, load_machine("house-printer"))


def robot_of(winch: dict[str, float]) -> Robot:
    text = tomlkit.parse(library_text("merlet2023"))
    text["winch"] = winch
    return loads(tomlkit.dumps(text))
