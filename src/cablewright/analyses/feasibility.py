"""Can the robot be where a job wants it: every limit of every sample, each with its worst place."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cablewright.errors import Status
from cablewright.models.statics import Equilibrium
from cablewright.robot import Line, Robot
from cablewright.solvers.limits import lever_angles, sheave_clearances, swing_angles, winch_torques

__all__ = ["Finding", "LineQuantities", "SheaveRule", "broken_limits", "judge", "judge_pose", "sheave_rules"]

Array = NDArray[np.float64]
Bounds = tuple[float, float] | None

SHEAVE_RATIO = 20.0  # least radius of a sheave over that of its cable, Paty 2021, section 3.1.1


@dataclass(frozen=True)
class Finding:
    """One limit against the whole path. `margin` is signed, in the limit's unit: negative is a violation."""

    limit: str  # "lowest tension", "highest tension", "frame", "swing", "lever", "cable length", "winch speed", ...
    unit: str  # "N", "m", "rad", "m/s", "N m"
    margin: float  # smallest signed distance to the limit over the path
    value: float  # the quantity there
    allowed: tuple[float, float]  # lowest and highest allowed value there
    line: str | None  # the line's name, None where the limit is the platform's
    sample: int  # index of the worst sample
    violations: int  # how many samples violate it

    @property
    def is_status(self) -> bool:
        """Whether `limit` is a status sentence of poses that cannot be held, not a limit of the hardware."""
        return any(self.limit == status.value for status in Status)

    def bounds(self) -> str:
        """What is allowed, in words."""
        low, high = self.allowed
        if not np.isfinite(low):
            return f"at most {high:g} {self.unit}"
        if not np.isfinite(high):
            return f"at least {low:g} {self.unit}"
        return f"{low:g} to {high:g} {self.unit}"


@dataclass(frozen=True)
class SheaveRule:
    """Whether the sheave of a line is large enough to spare its cable, wherever the platform is."""

    line: str
    value: float  # radius of the sheave over radius of the cable
    wanted: float
    holds: bool


@dataclass(frozen=True, eq=False)
class LineQuantities:
    """What the limits speak of, (k, m) each; NaN where a quantity has no value. SI."""

    lowest_tension: Array
    highest_tension: Array
    lengths: Array
    swing: Array
    lever: Array
    speed: Array
    torque: Array
    clearance: Array

    @classmethod
    def of(cls, rows: Equilibrium) -> LineQuantities:
        """Of solved poses that are not moving."""
        low, high = rows.extremes()
        still = np.zeros_like(rows.lengths)
        angles = swing_angles(rows), lever_angles(rows)
        return cls(low, high, rows.lengths, *angles, still, winch_torques(rows), sheave_clearances(rows))


@dataclass(frozen=True)
class _Rule:
    """A limit of the hardware: its quantity, and what a line allows of it."""

    limit: str
    unit: str
    quantity: str
    bounds: Callable[[Line], Bounds]


_RULES = (
    _Rule("lowest tension", "N", "lowest_tension", lambda line: (line.tension_limits[0], np.inf)),
    _Rule("highest tension", "N", "highest_tension", lambda line: _up_to(line.tension_limits[1])),
    _Rule("cable length", "m", "lengths", lambda line: _up_to(line.winch.capacity)),
    _Rule("swing", "rad", "swing", lambda line: _swing(line)),
    _Rule("lever", "rad", "lever", lambda line: getattr(line.sheave, "lever_range", None)),
    _Rule("winch speed", "m/s", "speed", lambda line: _up_to(line.winch.max_speed)),
    _Rule("winch torque", "N m", "torque", lambda line: _up_to(line.winch.max_torque)),
    _Rule("sheave clearance", "m", "clearance", lambda _line: (0.0, np.inf)),
)


def judge(
    robot: Robot, positions: Array, codes: NDArray[np.int64], violations: Array, lines: LineQuantities
) -> tuple[Finding, ...]:
    """Findings of a path, worst first: *positions* (k, 3) m; *codes* and *violations* (k,), N, of the inverse there."""
    findings = [_frame(robot, positions)]
    for rule in _RULES:
        bounds = [rule.bounds(line) for line in robot.lines]
        findings += _worst_line(rule.limit, rule.unit, getattr(lines, rule.quantity), bounds, robot)
    findings += _statics(codes, violations)
    return tuple(sorted(findings, key=lambda found: (found.violations == 0, found.is_status, -found.violations)))


def judge_pose(equilibrium: Equilibrium) -> tuple[Finding, ...]:
    """Findings of one solved pose, worst first: every limit but those of motion."""
    row = equilibrium[None]
    model = equilibrium.model
    lines = LineQuantities.of(row)
    if model.tension_limits is not None:  # the solver has seen to the limits that replace the lines' own
        unknown = np.full_like(row.lengths, np.nan)
        lines = replace(lines, lowest_tension=unknown, highest_tension=unknown)
    return judge(model.robot, row.pose[:, :3], row.code, row.violation, lines)


def broken_limits(rows: Equilibrium) -> tuple[tuple[str, ...], NDArray[np.bool_]]:
    """Names of what can forbid a pose, and which of them each of N solved poses breaks, (N, L).

    The limits of the hardware at rest come first, then statuses of poses that cannot be held. A pose without tensions
    within their limits breaks the lowest, the highest or both, as the best tensions there do; the lowest where a line
    would have to push.
    """
    quantities = LineQuantities.of(rows)
    columns = {}
    for rule in _RULES:
        allowed = [rule.bounds(line) for line in rows.model.robot.lines]
        if rows.model.tension_limits is not None and rule.limit.endswith("tension"):
            least, most = rows.model.tension_limits
            allowed = [(least, np.inf) if rule.limit == "lowest tension" else (-np.inf, most)] * rows.model.m
        bounds = [(-np.inf, np.inf) if bound is None else bound for bound in allowed]
        columns[rule.limit] = _beyond(getattr(quantities, rule.quantity), bounds).any(axis=1)
    infeasible = rows.code == list(Status).index(Status.INFEASIBLE)
    columns["lowest tension"] |= infeasible & ~columns["highest tension"]
    for code, status in enumerate(Status):
        if status not in (Status.OK, Status.INFEASIBLE):
            columns[status.value] = rows.code == code
    return tuple(columns), np.column_stack(list(columns.values()))


def _beyond(values: Array, bounds: list[tuple[float, float]]) -> NDArray[np.bool_]:
    """Where values (N, m) are outside the lines' bounds by more than rounding; nowhere where they are not known."""
    low, high = np.array(bounds).T
    spare = _ROUNDING * np.array([_size(bound) for bound in bounds])
    return np.asarray((values < low - spare) | (values > high + spare))


def _up_to(limit: float | None) -> Bounds:
    return None if limit is None else (-np.inf, limit)


def _swing(line: Line) -> Bounds:
    swing = getattr(line.sheave, "swing", None)
    return None if swing is None else (-swing, swing)


# A tension distribution that rests on its limit meets it to rounding.
_ROUNDING = 1e-9


def _worst_line(name: str, unit: str, values: Array, bounds: list[Bounds], robot: Robot) -> list[Finding]:
    """The finding of the line that comes nearest to its bounds or breaks them most; none where no line has any."""
    worst: Finding | None = None
    violated = np.zeros(len(values), dtype=bool)
    for i, bound in enumerate(bounds):
        if bound is None or np.isnan(values[:, i]).all():
            continue
        margin = np.minimum(values[:, i] - bound[0], bound[1] - values[:, i])
        violated |= margin < -_ROUNDING * _size(bound)
        at = int(np.nanargmin(margin))
        if worst is None or margin[at] < worst.margin:
            value = float(values[at, i])
            worst = Finding(name, unit, float(margin[at]), value, bound, robot.lines[i].name, at, 0)
    if worst is None:
        return []
    smallest = worst.margin if violated.any() else max(worst.margin, 0.0)
    return [replace(worst, margin=smallest, violations=int(violated.sum()))]


def _size(bound: tuple[float, float]) -> float:
    """The larger of 1 and the finite ends of *bound*."""
    return max([1.0, *(abs(end) for end in bound if np.isfinite(end))])


def _frame(robot: Robot, positions: Array) -> Finding:
    """Whether the path stays inside the frame: the coordinate that comes nearest to a side."""
    low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    margins = np.minimum(positions - low, high - positions)
    at = int(np.argmin(margins.min(axis=1)))
    axis = int(np.argmin(margins[at]))
    violations = int((margins.min(axis=1) < 0.0).sum())
    allowed = (float(low[axis]), float(high[axis]))
    name = f"frame, {'xyz'[axis]}"
    return Finding(name, "m", float(margins[at, axis]), float(positions[at, axis]), allowed, None, at, violations)


def _statics(codes: NDArray[np.int64], violations: Array) -> list[Finding]:
    """Poses that cannot be held, by status: by how much tensions break their limits at best, or just how many."""
    found = []
    for code in np.unique(codes[codes != 0]):
        at = np.flatnonzero(codes == code)
        worst = int(at[np.argmax(violations[at])])
        beyond = float(violations[worst])
        sentence = Status.of(int(code)).value
        found.append(Finding(sentence, "N", -beyond, beyond, (-np.inf, 0.0), None, worst, len(at)))
    return found


def sheave_rules(robot: Robot) -> tuple[SheaveRule, ...]:
    """Ratio of each sheave's radius to its cable's, which should be over 20; lines without either are left out."""
    found = []
    for line in robot.lines:
        radius = getattr(line.sheave, "radius", None)
        if radius is not None and line.cable.diameter is not None:
            ratio = 2.0 * radius / line.cable.diameter
            found.append(SheaveRule(line.name, ratio, SHEAVE_RATIO, ratio > SHEAVE_RATIO))
    return tuple(found)
