"""Learnt corrections of walls and mounts decay: they neither follow errors of other models nor get lost."""

from __future__ import annotations

import copy

import numpy as np
import pytest

from cablewright.estimation.kalman.gauss_markov import fade, fade_survey
from cablewright.estimation.kalman.state import FilterState, apply_update

HOURS = 5


def test_a_covariance_fades_as_that_of_a_gauss_markov_process() -> None:
    """In any steps; where nothing is known it is as at first, and no longer correlated."""
    random, own = np.random.default_rng(1), np.array([4.0, 0.25])
    factor = random.standard_normal((5, 5))
    at_once = factor @ factor.T
    in_steps, first = at_once.copy(), at_once.copy()
    kept = fade(at_once, slice(1, 3), 0.7, own)
    for _ in range(7):
        fade(in_steps, slice(1, 3), 0.1, own)
    assert kept == pytest.approx(np.exp(-0.7))
    assert in_steps == pytest.approx(at_once, rel=1e-12)
    assert at_once == pytest.approx(at_once.T)
    others = np.ix_([0, 3, 4], [0, 3, 4])
    assert (at_once[others] == first[others]).all()
    fade(at_once, slice(1, 3), 50.0, own)
    assert at_once[1:3, 1:3] == pytest.approx(np.diag(own))
    assert np.abs(at_once[1:3, [0, 3, 4]]).max() < 1e-18


def mounted(later: FilterState, sigma: float) -> FilterState:
    """A state that knows nothing of its mounts and walls but *sigma*, m and rad."""
    state, known = copy.deepcopy(later), later.layout.surveyed
    state.P[known], state.P[:, known] = 0.0, 0.0
    state.built.survey_variances = np.full(known.stop - known.start, sigma**2)
    state.P[known, known] = np.diag(state.built.survey_variances)
    return state


def test_a_mount_does_not_follow_a_wrong_height_for_hours(later: FilterState) -> None:
    """Lines believe in a height that is 60 mm off, a little each second; the floor determines height and mount
    together."""
    state, sigma = mounted(later, 2e-3), 2e-3
    lay, true = state.layout, float(later.motion.position[2])
    height, mount = lay.position.start + 2, lay.vertical_mount.start + 2
    by_lines, by_floor = np.zeros((1, lay.size)), np.zeros((1, lay.size))
    by_lines[0, height] = by_floor[0, height] = by_floor[0, mount] = 1.0
    farthest = 0.0
    for _ in range(3600 * HOURS):
        fade_survey(state, 1.0)
        state.P[height, height] += 2e-8
        apply_update(state, by_lines, np.array([true - 0.06 - state.motion.position[2]]), np.array([[0.2]]))
        seen = true - float(state.motion.position[2] + state.built.vertical_mount_error[2])
        apply_update(state, by_floor, np.array([seen]), np.array([[1e-7]]))
        farthest = max(farthest, abs(float(state.built.vertical_mount_error[2])))
    assert farthest < 2.0 * sigma
    assert abs(float(state.motion.position[2]) - true) < 2.0 * sigma
    assert state.P[mount, mount] == pytest.approx(sigma**2, rel=0.1)


def test_what_lidars_see_of_a_mount_stays_known(later: FilterState) -> None:
    """A lidar that is turned by two deviations, as each of its turns shows where yaw is known."""
    state, sigma = mounted(later, 5e-3), 5e-3
    lay = state.layout
    turned = np.zeros((1, lay.size))
    turned[0, lay.mounts.start + 2] = 1.0
    for _ in range(3600):
        fade_survey(state, 1.0)
        apply_update(state, turned, np.array([2.0 * sigma - state.built.mount_errors[0, 2]]), np.array([[1e-6]]))
    assert state.built.mount_errors[0, 2] == pytest.approx(2.0 * sigma, rel=0.01)
