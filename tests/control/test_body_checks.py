"""Lengths and tensions of a rigid platform are tested by equilibria of the full model, at poses that are turned."""

from __future__ import annotations

import numpy as np
import pytest

import cablewright as cw
from cablewright.control.balance_check import balance
from cablewright.control.length_check import LIMIT, check_lengths
from cablewright.models.rotation import motion_between, moved
from cablewright.models.statics import Equilibrium, Model
from cablewright.solvers.inverse import solve_inverse

POSES = {
    "cogiro": (0.4, -0.6, 2.0, 0.05, -0.08, 0.1),
    "ipanema": (0.2, 0.1, 0.9, 0.05, -0.05, 0.08),
    "nist-robocrane": (0.1, 0.1, 1.0, 0.0, 0.02, 0.05),
}


def held(name: str) -> Equilibrium:
    model = Model(cw.load(name))
    return solve_inverse(model, np.array(POSES[name])).checked()


@pytest.mark.parametrize("name", POSES)
def test_an_equilibrium_is_balanced_in_forces_and_moments(name: str) -> None:
    found = held(name)
    judged = balance(found.model, found.pose, found.tensions, 0.1)
    assert judged.holds
    assert judged.size < 2e-3 * max(
        judged.weight, float(np.linalg.norm(found.tensions))
    )  # chords in place of catenaries
    heavier = balance(found.model, found.pose, 1.3 * found.tensions, 0.1)
    assert heavier.size > 0.25 * judged.weight


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize(("name", "share"), [("cogiro", 0.02), ("ipanema", 0.05)])
def test_a_place_beyond_its_reach_is_seen_and_a_turn_as_far_as_it_says(name: str, share: float, axis: int) -> None:
    found = held(name)
    judged = balance(found.model, found.pose, found.tensions, share)
    for sign in (-1.0, 1.0):
        for beyond, row in ((judged.reach, axis), (judged.turn, 3 + axis)):
            way = np.zeros(6)
            way[row] = sign * beyond
            if row < 3 or beyond < 0.2:  # farther turns are not linear any more
                assert not balance(found.model, moved(found.pose, way), found.tensions, share).holds


def test_a_turn_about_the_vertical_of_a_suspended_platform_does_not_show() -> None:
    found = held("cogiro")
    assert balance(found.model, found.pose, found.tensions, 0.1).turn > np.radians(90.0)
    turned = moved(found.pose, np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.2]))
    assert balance(found.model, turned, found.tensions, 0.1).holds


@pytest.mark.parametrize("name", POSES)
def test_lengths_meet_at_their_pose_from_far_away(name: str) -> None:
    found = held(name)
    guess = found.pose + np.array([0.2, -0.15, 0.1, 0.05, 0.1, -0.1])
    check = check_lengths(found.model, found.lengths, found.tensions, guess)
    assert check is not None
    assert check.fits
    assert check.tested == (found.model.m > 6)
    assert np.abs(motion_between(check.pose, found.pose)).max() < 1.5e-3


@pytest.mark.parametrize("offset", [-0.02, 0.02, 0.05])
@pytest.mark.parametrize("line", range(8))
def test_a_wrong_line_of_eight_is_rejected_by_the_lengths_or_by_the_tensions(line: int, offset: float) -> None:
    for name in ("cogiro", "ipanema"):
        found = held(name)
        lengths = found.lengths.copy()
        lengths[line] += offset
        check = check_lengths(found.model, lengths, found.tensions, found.pose)
        assert check is not None
        if name == "cogiro":
            assert check.misfit > LIMIT
            assert check.suspects[line] == pytest.approx(offset, abs=5e-3)
        assert not check.fits or not balance(found.model, check.pose, found.tensions, 0.1).holds
