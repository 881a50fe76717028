"""Runs of a simulated machine with an observer beside it, and laws of hanging lines, for tests of several ranks."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np

from cablewright.estimation.kalman.sag import Balanced, Sag
from cablewright.estimation.slackness import SlacknessState
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Estimate, SensorFrame, Truth
from cablewright.kernels.filtering import sagging_lines, smoothed_line_angles
from cablewright.live.drive_along_path import DriveSettings, Pilot, random_loop
from cablewright.live.estimator_settings import OBSERVERS
from cablewright.machine.simulated.settings import FaultPlan, TwinSettings
from cablewright.robot import load
from twins import TWIN, machine


def drive(
    seconds: float, settings: TwinSettings = TWIN, *, seed: int = 1, held: bool = False, plant: str = "dynamic"
) -> list[tuple[SensorFrame, Truth]]:
    """Frames and truths of a machine that goes round a loop, or is *held* where the loop begins."""
    way = random_loop(load("merlet2023"), 28.0, seed)
    twin = machine(settings, seed=seed, plant=plant, start=[*way[0], 1.2])
    pilot, recording = Pilot(twin, None if held else way, DriveSettings(), seed), []
    for _ in range(round(seconds / twin.period)):
        frame = twin.step(pilot.command())
        recording.append((frame, twin.truth))
    return recording


def observe(
    recording: list[tuple[SensorFrame, Truth]],
    settings: TwinSettings = TWIN,
    each: Callable[[Estimate, Truth], None] | None = None,
    *,
    estimator: str = "paper",
    **changes: Any,
) -> list[Estimate]:
    """Estimates of all frames."""
    one = OBSERVERS[estimator]
    known = dataclasses.replace(one.settings(load("merlet2023"), settings.owner, ()), **changes)
    state, found = one.start(known), []
    for frame, truth in recording:
        found.append(one.step(known, state, frame))
        if each is not None:
            each(found[-1], truth)
    return found


def broken(*plans: dict[str, Any]) -> TwinSettings:
    """The machine with faults to come."""
    return TWIN.with_simulation(faults=tuple(FaultPlan(**plan) for plan in plans))


def errors(found: list[Estimate], recording: list[tuple[SensorFrame, Truth]], since: float) -> np.ndarray:
    """Distances (k,), m, from the true position, from *since* (s) on."""
    return np.array([
        float(np.linalg.norm(estimate.position - truth.position))
        for estimate, (frame, truth) in zip(found, recording, strict=True)
        if frame.time > since
    ])  # fmt: skip


_ROWS = {
    "differences": smoothed_line_angles.DIFFERENCE,
    "excess": smoothed_line_angles.EXCESS,
    "variances": smoothed_line_angles.VARIANCE,
}


def forces_at(may_be: Balanced, shares: Array) -> Array:
    """Forces (k, m), N, by *shares* (k,) of their range."""
    return np.asarray(may_be.forces[0] + shares[:, None] * may_be.forces[1])


def unsure_at(may_be: Balanced, shares: Array) -> Array:
    """How forces change with the q numbers, (k, m, q), N, by *shares* (k,)."""
    return np.asarray(may_be.unsure[0] + shares[:, None, None] * may_be.unsure[1])


def differences(sag: Sag, forces: Array) -> Array:
    """Angles near the platform less those of straight lines (..., m), rad, by horizontal *forces* (..., m), N."""
    steep = sag.laws[sagging_lines.SLOPE] + sag.laws[sagging_lines.RISING] / forces
    return np.asarray(np.arctan(steep) - sag.laws[sagging_lines.ANGLE])


def shown(state: SlacknessState, **values: Array) -> SlacknessState:
    """*state* with other *values* (m,)."""
    rows = state.rows.copy()
    for name, each in values.items():
        rows[_ROWS[name]] = each
    return SlacknessState(rows, state.time)
