"""The filter of all sensors, started by the estimator of Merlet 2023, which finds its first position or a lost one.

The estimator of Merlet 2023 is no part of the filter: it runs until it has a position, passes that on, and ends.
Without horizontal lidars a camera in the room finds the first position.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from cablewright.estimation import slackness
from cablewright.estimation.kalman import drum_mass
from cablewright.estimation.kalman import filter as error_state
from cablewright.estimation.kalman.filter import FirstState
from cablewright.estimation.kalman.settings import FilterSettings
from cablewright.estimation.kalman.state import FilterState
from cablewright.estimation.known_creep import KnownCreep, known_creep
from cablewright.estimation.merlet2023 import observer
from cablewright.estimation.merlet2023.state import ObserverSettings, ObserverState
from cablewright.estimation.reading_checks import ReadingChecks
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import CameraPose, Estimate, SensorFrame, frozen
from cablewright.models.rotation import matrix_of
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.taut import Taut

_SAME: Final = 0.3  # m between two pictures that agree: a single one may be wrong by any amount
_SEEN_SIGMA: Final = 0.1  # m, of a position by a camera: more than its errors, which later pictures show again


@dataclass(frozen=True, eq=False)
class StartedSettings:
    """Settings of the filter and of the estimator that starts it."""

    chain: ObserverSettings
    filter: FilterSettings


@dataclass(eq=False)
class StartedState:
    """State of the filter and of the estimator that starts it. Changed in place by `step`.

    Both share the checks of their readings, with the faults.
    """

    filter: FilterState
    chain: ObserverState | None  # until the first position is found
    seen: Array | None = None  # (3,) m, by the last picture before that

    @property
    def creep(self) -> KnownCreep | None:
        """Creep of the cables as described, shared by both estimators."""
        return self.filter.creep

    @property
    def taut(self) -> Taut | None:
        """The lines, as if straight, at the last position."""
        return self.filter.taut


def start(settings: StartedSettings) -> StartedState:
    """Return the estimator's state before the first sensor frame."""
    if not settings.chain.lidars:
        seen = error_state.start(settings.filter, ReadingChecks.of(settings.chain))
        seen.creep = known_creep(settings.chain.model.robot)
        return StartedState(seen, None)
    chain = observer.start(settings.chain)
    begun = error_state.start(settings.filter, chain.checks)
    begun.creep = chain.creep  # both know what has crept
    return StartedState(begun, chain)


def step(settings: StartedSettings, state: StartedState, frame: SensorFrame) -> Estimate:
    """Return the estimate after one frame; *state* changes in place. No frame raises an error; faults are reported."""
    if state.chain is not None:
        estimate = observer.step(settings.chain, state.chain, frame)
        first = _first(state.chain, frame.time)
        if first is None or not error_state.begin(settings.filter, state.filter, first):
            return replace(estimate, valid=False)
        state.chain = None
        return error_state.estimate(settings.filter, state.filter)
    if state.filter.taut is None:
        return _seen_first(settings, state, frame)
    estimate = error_state.step(settings.filter, state.filter, frame)
    if not error_state.is_lost(settings.filter, state.filter):
        return estimate
    if not settings.chain.lidars:
        lost, state.filter, state.seen = state.filter, error_state.start(settings.filter, state.filter.checks), None
        state.filter.creep = lost.creep
        return replace(estimate, valid=False)
    state.chain = observer.start(settings.chain)
    state.chain.checks, state.chain.creep = state.filter.checks, state.filter.creep  # active faults stay
    return replace(estimate, valid=False)


def _seen_first(settings: StartedSettings, started: StartedState, frame: SensorFrame) -> Estimate:
    """Begin at the position that two pictures show, one after the other; return the estimate, invalid before that."""
    model, m, state = settings.chain.model, settings.chain.model.m, started.filter
    readings = list(state.checks.accepted(frame)) if state.checks.has_time(frame) else []
    for pose in (each.pose for each in readings if isinstance(each, CameraPose) and np.isfinite(each.pose).all()):
        last, started.seen = started.seen, pose[:3]
        if last is None or not np.linalg.norm(pose[:3] - last) <= _SAME:
            continue
        held = solve_inverse(model, pose[:3])
        yaw, radii = float(np.arctan2(*matrix_of(pose[3:])[[1, 0], 0])), np.array(settings.chain.radius.nominal)
        begun = slackness.start(settings.chain.slackness)
        first = FirstState(frame.time, pose[:3], np.zeros(3), yaw, held.lengths, radii, begun, _SEEN_SIGMA)
        if held.is_valid() and error_state.begin(settings.filter, state, first):
            return error_state.estimate(settings.filter, state)
    state.monitor.check_timeouts(frame.time)
    unknown, still = frozen(np.full(m, np.nan)), frozen(np.zeros(3))
    position, slack = frozen(np.full(3, np.nan)), np.zeros(m, dtype=np.bool_)
    radii, faults = frozen(settings.chain.radius.nominal), state.monitor.faults
    return Estimate(frame.time, position, still, still, unknown, unknown, slack, radii, faults=faults, valid=False)


def weigh(settings: StartedSettings, state: StartedState, mass: float) -> None:
    """Set the platform's mass to *mass*, kg; the estimator of Merlet 2023 keeps the initial one."""
    drum_mass.weigh(settings.filter, state.filter, mass)


def _first(chain: ObserverState, now: float) -> FirstState | None:
    """Return the first state of the *chain*, an estimator of Merlet 2023, by *now*, s; None: none yet."""
    if chain.tracker is None or chain.lengths is None or chain.taut is None or chain.drum_angles is None:
        return None
    if chain.located.wall_pose is None or chain.located.wall_pose.status != "ok":
        return None
    yaw, radii = chain.odometry.yaw + chain.located.yaw_offset, chain.radius.radii
    return FirstState(now, chain.tracker.pose, chain.odometry.velocity, yaw, chain.lengths, radii, chain.slackness)
