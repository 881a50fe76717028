"""The filter of all sensors, started by the estimator of Merlet 2023, which finds its first position or a lost one.

The estimator of Merlet 2023 is no part of the filter: it runs until it has a position, passes that on, and ends.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from cablewright.estimation.kalman import drum_mass
from cablewright.estimation.kalman import filter as error_state
from cablewright.estimation.kalman.filter import FirstState
from cablewright.estimation.kalman.state import FilterSettings, FilterState
from cablewright.estimation.known_creep import KnownCreep
from cablewright.estimation.merlet2023 import observer
from cablewright.estimation.merlet2023.state import ObserverSettings, ObserverState
from cablewright.foundation.signals import Estimate, SensorFrame
from cablewright.solvers.taut import Taut


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
    estimate = error_state.step(settings.filter, state.filter, frame)
    if not error_state.is_lost(settings.filter, state.filter):
        return estimate
    state.chain = observer.start(settings.chain)
    state.chain.checks, state.chain.creep = state.filter.checks, state.filter.creep  # active faults stay
    return replace(estimate, valid=False)


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
