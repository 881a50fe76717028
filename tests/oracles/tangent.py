"""Oracle: a line whose cable is a straight thread, tangent to its sheave. Plain floats, from school geometry.

Plane, angles and units as in `oracles.line`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.optimize import brentq

from cablewright.robot import Eyelet, Line, UniversalJoint
from oracles.line import LineState


def straight(line: Line, platform_point: Sequence[float], tension: float = 1.0, beta: float | None = None) -> LineState:
    """Return the state of a straight line under ``tension`` (N), its lever at ``beta`` or else where it rests."""
    if beta is None:
        beta = resting_lever(line, platform_point, tension) if isinstance(line.sheave, UniversalJoint) else 0.0
    A, B = np.array(line.exit_point), np.array(platform_point)
    reach = math.hypot(*(B - A)[:2])
    if isinstance(line.sheave, Eyelet):
        free = (reach, B[2] - A[2])
        dead = (0.0, 0.0) if line.winch_exit is None else _upright(np.array(line.winch_exit) - A)
        lengths = math.hypot(*free), math.hypot(*dead)
        return LineState(tension, math.atan2(free[1], free[0]), lengths[0], math.atan2(dead[1], dead[0]), lengths[1])
    sheave, side = line.sheave, 1.0 if line.sheave.wrap == "over" else -1.0
    arm = sheave.lever if isinstance(sheave, UniversalJoint) else sheave.radius
    centre = np.array([arm * math.cos(beta), arm * math.sin(beta)])
    phi, free_length = _tangent(np.array([reach, B[2] - A[2]]) - centre, sheave.radius, -side)
    if line.winch_exit is None:
        return LineState(tension, phi, free_length, -side * math.pi / 2, 0.0, beta)
    psi, dead_length = _tangent(np.array([0.0, line.winch_exit[2] - A[2]]) - centre, sheave.radius, side)
    return LineState(tension, phi, free_length, psi, dead_length, beta)


def length(line: Line, state: LineState) -> float:
    """Return the length of a straight line in that state, m: free span, arc and dead span (or its substitute)."""
    dead = line.dead_length if line.winch_exit is None else state.dead_length
    if isinstance(line.sheave, Eyelet):
        return float(state.free_length + dead)
    side = 1 if line.sheave.wrap == "over" else -1
    return float(state.free_length + dead + line.sheave.radius * (side * (state.psi - state.phi) + math.pi))


def resting_lever(line: Line, platform_point: Sequence[float], tension: float) -> float:
    """Return the angle at which the lever of a straight line rests and to which it returns, nearest to -45 degrees."""
    assert isinstance(line.sheave, UniversalJoint)
    lever, weight, arm = line.sheave.lever, line.sheave.lever_weight, line.sheave.lever_mass_centre

    def moment(beta: float) -> float:
        at = straight(line, platform_point, tension, beta)
        up = tension * (math.sin(at.phi) + math.sin(at.psi))
        out = tension * (math.cos(at.phi) + math.cos(at.psi))
        return lever * (math.cos(beta) * up - math.sin(beta) * out) - arm * math.cos(beta) * weight

    grid = np.linspace(-math.pi, math.pi, 361) + 1e-3
    values = [moment(beta) for beta in grid]
    rests = [
        brentq(moment, *grid[i : i + 2], xtol=1e-15, rtol=1e-14) for i in range(360) if values[i] > 0 >= values[i + 1]
    ]
    return min(rests, key=lambda beta: abs(beta + math.pi / 4))


def _tangent(point: np.ndarray, radius: float, side: float) -> tuple[float, float]:
    """Return direction and length of the tangent from a circle about the origin to ``point``."""
    distance = math.hypot(*point)
    return math.atan2(point[1], point[0]) + side * math.asin(radius / distance), math.sqrt(distance**2 - radius**2)


def _upright(vector: np.ndarray) -> tuple[float, float]:
    return math.hypot(vector[0], vector[1]), float(vector[2])
