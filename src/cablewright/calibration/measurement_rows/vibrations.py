"""Cable tensions from measured frequencies of lateral vibration of the free cables, as of strings."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.models.line_vibration import string_tension
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.solvers.taut import taut_at

AT_START: Final = 0.05
"""Standard deviation of a tension, as a share, where its span is that at the start value of a pose."""


def with_vibrations(
    robot: Robot, measured: Measured, plan: CalibrationPlan, poses: Array | None, share: float = 0.0
) -> Measured:
    """Return the data with tensions by their frequencies, if any, over the free spans at *poses* (N, n), m and rad.

    *share*: standard deviation of these tensions, as a share, by that of the spans.
    Raises `InputError` for a cable without weight, without poses, for a cell of both a frequency and a tension, and for
    an unknown zero or scale of load cells, which would be of these tensions too.
    """
    frequencies = measured.frequencies
    if frequencies is None:
        return measured
    if poses is None or np.isnan(poses).any():
        raise InputError(f"{measured.origin}: hz_1 .. require columns x,y,z, start values of the poses")
    weightless = next((line.name for line in robot.lines if not line.cable.linear_density), None)
    if weightless is not None:
        raise InputError(f"{measured.origin}: hz_1 ..: line {weightless!r} has no cable.linear_density; leave them out")
    shaken = np.isfinite(frequencies)
    given = np.full(shaken.shape, np.nan) if measured.tensions is None else measured.tensions
    own = np.full(shaken.shape, np.nan) if measured.tension_sigma is None else measured.tension_sigma
    both = np.argwhere(shaken & np.isfinite(given) & np.isnan(own))
    if len(both):
        row, line = (int(at) for at in both[0])
        where = f"{measured.origin}, {measured.place(row)}: hz_{line + 1}"
        raise InputError(f"{where} and f_{line + 1}: give one of them, the other blank")
    if (frequencies[shaken] <= 0.0).any():
        row, line = (int(at) for at in np.argwhere(shaken & (np.nan_to_num(frequencies) <= 0.0))[0])
        raise InputError(f"{measured.origin}, {measured.place(row)}: hz_{line + 1}: must be over 0 Hz")
    cells = bool((np.isfinite(given) & np.isnan(own)).any())
    for name in ("tension_offset", "tension_scale"):  # in the equations they are of all tensions
        if name in plan.unknowns and (cells or name == "tension_offset"):
            raise InputError(
                f"unknowns: {name}: is of load cells, but frequencies hz_1 .. are measured without load cells; leave "
                f"out {name} or the frequencies"
            )
    densities = np.array([line.cable.linear_density for line in robot.lines])
    found = string_tension(frequencies, free_spans(robot, poses), densities)
    sigma = found * np.hypot(2.0 * plan.sigma.frequency / frequencies, share)
    return replace(measured, tensions=np.where(shaken, found, given), tension_sigma=sigma)


def free_spans(robot: Robot, poses: Array) -> Array:
    """Return the free span (N, m) of each line at *poses* (N, n), m."""
    model = Model(robot)
    return np.array([taut_at(model, pose).free for pose in poses])
