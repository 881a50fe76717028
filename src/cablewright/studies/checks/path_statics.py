"""Statics of the samples of a path, with the motion of the platform where that changes a limited quantity."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from cablewright.analyses.accuracy.compensation import COMPENSATIONS, Reached
from cablewright.analyses.feasibility import LineQuantities, plane_forces
from cablewright.analyses.motion.path_swing import SwingExtremes
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.memory_mapped import blocks, let_go
from cablewright.models.statics import Equilibrium
from cablewright.models.stiffness import as_elastic
from cablewright.robot import Robot
from cablewright.solvers.hardware_limits import rise_on_drums


@dataclass(frozen=True, eq=False)
class PathStatics:
    """Statics of k samples of a path with m lines. Arrays have one row per sample; SI."""

    codes: NDArray[np.int64]  # (k,) status of the inverse problem
    violations: Array  # (k,) N, largest excess of a tension over its limits
    tensions: Array  # (k, m) N, at the sheave, at rest
    lines: LineQuantities  # (k, m) each: quantities that have limits, with the motion of the platform
    displacement: Array  # (k,) m, largest of the nozzle by motion up to there; NaN where it is unknown
    frequency: Array  # (k,) Hz, of the mode with most of that
    plane_force: Array  # (k,) N, largest along the plane's normal with motion; NaN without a plane
    rigid_lengths: Array  # (k, m) m, paid out without compensation: cables as rigid
    lengths: Array  # (k, m) m, paid out with full compensation, at rest
    commanded: Array  # (k, m) m, the same under the forces of acceleration, where lengths compensate these
    uncompensated: Array  # (k, n) poses of the full model with the rigid lengths; NaN where none
    elastic_only: Array  # (k, n) poses if elasticity but not sag is compensated
    compensated: Array  # (k, n) poses with the compensated lengths

    @classmethod
    def of(cls, held: Equilibrium, poses: Array, retraction: Array | None) -> Self:
        """Return the statics at rest of neighbouring *poses* (k, n), m and rad, which the full model holds as *held*.

        NaN in a pose is what equilibrium decides.

        Rows without a straight-line geometry are NaN.
        """
        full = held.model

        def reached(lengths: Array, near: Array) -> Array:
            return Reached.of(full, lengths, near, retraction=retraction, path=True).poses

        straight = COMPENSATIONS["none"].solved(full, poses, retraction=retraction)
        rigid, elastic = straight.lengths, _stretched(straight, poses, retraction)
        uncompensated = reached(rigid, held.pose)
        start = np.where(np.isnan(uncompensated), held.pose, uncompensated)
        return cls(
            codes=held.code,
            violations=held.violation,
            tensions=held.tensions,
            lines=LineQuantities.of(held),
            displacement=np.full(len(poses), np.nan),
            frequency=np.full(len(poses), np.nan),
            plane_force=plane_forces(held),
            rigid_lengths=rigid,
            lengths=held.lengths,
            commanded=held.lengths.copy(),
            uncompensated=uncompensated,
            elastic_only=reached(elastic, held.pose),
            compensated=reached(held.lengths, start),
        )

    def moving(self, robot: Robot, swing: SwingExtremes, drum_arms: Array) -> Self:
        """Return the statics with the motion of the platform; *drum_arms* (..., m), m, NaN if unknown."""
        lines, drop, rise = self.lines, swing.tension_drop, swing.tension_rise
        moved = replace(
            lines,
            lowest_tension=lines.lowest_tension + drop,
            highest_tension=lines.highest_tension + rise,
            winch_torque=lines.winch_torque + rise_on_drums(robot, drop * drum_arms, rise * drum_arms),
        )
        force = self.plane_force + swing.plane_rise
        return replace(self, lines=moved, displacement=swing.displacement, frequency=swing.frequency, plane_force=force)

    def fed_forward(self, moving: Equilibrium, rows: NDArray[np.intp]) -> Self:
        """Return the statics with the lengths that hold the *moving* platform at *rows* (r,)."""
        commanded = self.commanded.copy()
        commanded[rows] = np.where(moving.ok[:, None], moving.lengths, commanded[rows])
        return replace(self, commanded=commanded)


def extreme(choose: np.ufunc, values: Array) -> float:
    """Return the smallest or largest of *values*, by ``np.fmin`` or ``np.fmax``; NaN where none is a number."""
    return float(choose.reduce(extremes(choose, values), axis=None, initial=np.nan))


def extremes(choose: np.ufunc, values: Array) -> Array:
    """Return the minimum and maximum of an array along its first axis, which has at least one row."""
    found = np.full(values.shape[1:], np.nan)
    for at in blocks(len(values)):
        found = choose(found, choose.reduce(values[at], axis=0))
        let_go(values)
    return found


def largest_at(values: Array, preferred: Mask) -> int | None:
    """Return where *values* (k,) are largest among the *preferred* (k,), or else anywhere; None: nowhere known."""
    for anywhere in (False, True):
        best: float = -np.inf
        found: int | None = None
        for at in blocks(len(values)):
            among = np.where(np.isfinite(values[at]) & (preferred[at] | anywhere), values[at], -np.inf)
            first = int(np.argmax(among))
            if among[first] > best:
                best, found = float(among[first]), int(at.start) + first
            let_go((values, preferred))
        if found is not None:
            return found
    return None


def median(values: Array) -> Array:
    """Return the lower median along the first axis without NaN; NaN where all are NaN. Of (k,) or (k, m)."""
    return np.array([_median(each) for each in values.T]) if values.ndim > 1 else np.asarray(_median(values))


def _median(values: Array) -> float:
    ranked = np.empty(len(values))
    for at in blocks(len(values)):
        ranked[at] = values[at]
        let_go(values)
    ranked.sort()  # NaN comes last
    known = int(np.count_nonzero(~np.isnan(ranked)))
    return float(ranked[max(known - 1, 0) // 2])


def _stretched(straight: Equilibrium, poses: Array, retraction: Array | None) -> Array:
    """Lengths (k, m), m, of straight cables that stretch: of the rigid ones at their tensions.

    Where mounts give, or cables that stretch share a winch, tensions are others.
    """
    robot = straight.model.robot
    if robot.sharing or any(line.mount_gives for line in robot.lines):
        return COMPENSATIONS["elastic"].solved(straight.model, poses, retraction=retraction).lengths
    return as_elastic(straight).lengths
