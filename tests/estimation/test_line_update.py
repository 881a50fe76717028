"""The filter's prediction by encoders and update by line angles, against differences and known results."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Callable

import numpy as np
import pytest

from cablewright.estimation import started_filter
from cablewright.estimation.kalman import line_update
from cablewright.estimation.kalman.filter import FirstState, begin
from cablewright.estimation.kalman.sag import balanced
from cablewright.estimation.kalman.settings import FilterSettings
from cablewright.estimation.kalman.state import FilterState, inject_correction
from cablewright.foundation.arrays import Array
from cablewright.live.estimator_settings import started_settings
from cablewright.robot import load
from cablewright.solvers.taut import taut_at
from observer_runs import differences, forces_at, shown
from twins import SETTINGS

KNOWN = started_settings(load("merlet2023"), SETTINGS).filter


def slackest(settings: FilterSettings, state: FilterState) -> tuple[int, Callable[[float], Array]]:
    """The line that pulls least, and angles (m,), rad, of all lines less those of taut ones by its excess, m."""
    assert state.taut is not None
    assert state.hung.sag is not None
    sag, weight = state.hung.sag, state.motion.mass * settings.machine.tilt.gravity
    may_be = balanced(settings.machine.slackness, state.taut, weight, 0.2 * weight)
    assert may_be is not None
    line, shares = int(np.argmin(may_be.forces[0])), np.geomspace(1e-3, 0.2, 400)
    by_share = sag.excess(forces_at(may_be, shares))[:, line]

    def hanging(excess: float) -> Array:
        share = np.interp(excess, by_share[::-1], shares[::-1])
        return np.asarray(differences(sag, forces_at(may_be, np.array([share])))[0])

    return line, hanging


def predict(settings: FilterSettings, state: FilterState, rotation: Array, dt: float) -> None:
    """Predict by counts that are as fine as the *rotation* (m,), rad, of the drums in *dt*, s, is given."""
    fine = dataclasses.replace(settings, machine=dataclasses.replace(settings.machine, counts_per_radian=1e6))
    counts, turned = np.rint(1e6 * rotation).astype(np.int64), np.empty(len(rotation))
    line_update.reel(fine, state, (counts, np.zeros_like(counts)), turned, dt, rolls=True, pauses=False)
    assert turned == pytest.approx(rotation, rel=1e-12)


def test_lines_lead_where_taut_lines_lead(later: FilterState) -> None:
    """Lengths that grow as the taut ones do from here to there move B from here to there."""
    assert later.taut is not None
    for way in np.eye(3):
        assert later.hung.jacobian @ (later.taut.toward @ way) == pytest.approx(way, abs=1e-9)
    before, slack = later.motion.position.copy(), line_update.excess(later)
    state = copy.deepcopy(later)
    predict(KNOWN, state, np.array([1e-3, -2e-3, 1e-3, 0.0]), 0.01)
    assert np.linalg.norm(state.motion.position - before) < 3e-4
    assert np.abs(line_update.excess(state) - slack).max() < 3e-4
    assert np.linalg.eigvalsh(state.P)[0] > -1e-12


def test_a_drum_that_its_lines_leave_free_across_their_plane_is_lost() -> None:
    settings = started_settings(load("wall-plotter"), SETTINGS)
    state, place = started_filter.start(settings).filter, np.array([0.1, 0.0, 0.8])
    lengths = taut_at(settings.filter.machine.model, place).lengths
    first = FirstState(1.0, place, np.zeros(3), 0.0, lengths, np.full(2, 6e-3), state.slackness)
    assert not begin(settings.filter, state, first)
    assert state.taut is None
    assert [fault.sentence for fault in state.monitor.faults] == [
        "the lines leave a direction free at the estimated position"
    ]


def test_a_doubted_zero_returns_to_the_specified_one(later: FilterState) -> None:
    settings, lines = dataclasses.replace(KNOWN, zero_sigma=0.026), np.arange(4)
    state = copy.deepcopy(later)
    rows, first = np.arange(state.layout.zeros.start, state.layout.zeros.stop), 0.026**2
    state.P[rows, rows] = 0.1 * first
    state.lines.zeros = np.full(4, 0.03)
    line_update._doubt_zeros(settings, state, lines[:2], np.array([0.3, 9.0]) * first)
    assert state.P[rows, rows] == pytest.approx(first * np.array([0.4, 1.0, 0.1, 0.1]))
    # specified and learnt together, before: 0.03; the learnt part is unchanged where its weight is less
    assert state.lines.zeros == pytest.approx([0.03 * 0.6 / 0.9, 0.0, 0.03, 0.03])
    for _ in range(100):
        line_update._doubt_zeros(settings, state, lines, np.full(4, first))
    assert np.abs(state.lines.zeros).max() < 1e-9


def test_a_line_that_gets_slack_uncounted_is_followed_by_its_angle(later: FilterState) -> None:
    """Half a millimetre each 0.2 s: by the weight, which is hardly known, its force is as small as its angle says."""
    settings, state = dataclasses.replace(KNOWN, layers=None), copy.deepcopy(later)
    m, (line, hanging) = len(state.lines.lengths), slackest(settings, state)
    begin = max(float(line_update.excess(state)[line]), 1e-3)
    for k in range(80):
        angles, seen = hanging(begin + 5e-4 * k), state.slackness
        variances, excess = np.full(m, np.radians(0.1) ** 2), np.where(np.isnan(seen.excess), 0.0, seen.excess)
        state.slackness = shown(seen, differences=angles, variances=variances, excess=excess)
        predict(settings, state, np.zeros(m), 0.2)
        state.time += 0.2
        line_update.update(settings, state)
    twelve_seconds_ago, now = begin + 5e-4 * (79 - 60), begin + 5e-4 * 79
    assert twelve_seconds_ago < line_update.excess(state)[line] < 1.1 * now


def test_the_zero_of_a_slack_line_stays_near_the_specified_one(later: FilterState) -> None:
    """A line that the state takes for taut hangs loose by 20 mm: its length is wrong, and not its accelerometer."""
    settings, state = dataclasses.replace(KNOWN, layers=None, zero_sigma=np.radians(0.5)), copy.deepcopy(later)
    lay, m, (line, hanging) = state.layout, len(state.lines.lengths), slackest(settings, state)
    angles = hanging(0.02)
    state.lines.lengths[line] -= line_update.excess(state)[line]
    for states, sigma in ((lay.lengths, 7e-3), (lay.zeros, settings.zero_sigma)):
        state.P[states], state.P[:, states] = 0.0, 0.0
        state.P[states, states] = sigma**2 * np.eye(m)
    variances, seen = np.full(m, np.radians(0.1) ** 2), state.slackness
    state.slackness = shown(seen, differences=angles, variances=variances, excess=np.zeros(m))
    for _ in range(60):
        predict(settings, state, np.zeros(m), 1.0)
        state.time += 1.0
        line_update.update(settings, state)
        assert np.abs(state.lines.zeros).max() < 2.0 * settings.zero_sigma
    assert line_update.excess(state)[line] == pytest.approx(0.02, abs=4e-3)


def test_stretch_that_no_count_shows_moves_lengths_and_the_drum_with_its_covariance(later: FilterState) -> None:
    """The covariance of a prediction is that of its own differences, but for what it adds as noise."""
    lay, rotation, dt = later.layout, np.array([1e-3, -2e-3, 1e-3, 5e-4]), 0.01
    settings, later = dataclasses.replace(KNOWN, layers=None), copy.deepcopy(later)
    later.lines.stretching, later.lines.loosened = 0.0, np.zeros(4)
    later.P[lay.compliances] = later.P[:, lay.compliances] = 0.0  # their part is in test_compliances
    parts = np.r_[lay.position, lay.lengths, lay.radii, lay.stretch]

    def predicted(by: np.ndarray) -> FilterState:
        state = copy.deepcopy(later)
        inject_correction(state, by)
        predict(settings, state, rotation, dt)
        line_update.update_jacobian(settings, state, at_once=True)
        return state

    def numbers(state: FilterState) -> np.ndarray:
        return np.concatenate(
            [state.motion.position, state.lines.lengths, np.log(state.lines.radii), state.lines.stretch_rates]
        )

    state, step = predicted(np.zeros(lay.size)), 1e-5
    ways = step * np.eye(lay.size)[parts]
    F = np.column_stack([(numbers(predicted(way)) - numbers(state)) / step for way in ways])
    whole = np.ix_(parts, parts)
    noise = state.P[whole] - F @ later.P[whole] @ F.T
    scale = np.sqrt(np.outer(np.diag(later.P)[parts], np.diag(later.P)[parts]))
    assert (np.abs(noise - np.diag(np.diag(noise))) < 1e-6 * scale).all()
    assert (np.diag(noise) > -1e-9 * np.diag(scale)).all()
