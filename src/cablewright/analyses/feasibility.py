"""Can the robot be where a job wants it: every limit of every sample, each with its worst place."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array, Mask
from cablewright.errors import Status
from cablewright.models.statics import Equilibrium, Model
from cablewright.results import Figure
from cablewright.robot import Line, Robot
from cablewright.solvers.limits import lever_angles, sheave_clearances, swing_angles, winch_torques

Bounds = tuple[float, float] | None


@dataclass(frozen=True)
class Finding:
    """One limit against the whole path. `margin` is signed, in the limit's unit: negative is a violation."""

    limit: str  # the name of one of `LIMITS`, "frame, x" (or y, z), or a status sentence
    unit: str  # "N", "m", "rad", "m/s", "N m"
    margin: float  # smallest signed distance to the limit over the path
    value: float  # the quantity there
    allowed: tuple[float, float]  # lowest and highest allowed value there
    line: str | None  # the line's name, None where the limit is the platform's
    sample: int  # index of the worst sample
    violations: int  # how many samples violate it

    FIGURES: ClassVar = (
        Figure("limit", "", "Name of the limit, or why poses cannot be held."),
        Figure("line", "", "Name of the line; null where the limit is the platform's."),
        Figure("unit", "", "Unit of the numbers."),
        Figure("margin", "SI", "Smallest distance to the limit; negative: it is broken."),
        Figure("value", "SI", "Value there.", name="worst value"),
        Figure("allowed", "SI", "Min and max value there; null where there is none."),
        Figure("violations", "1", "Number of samples that break the limit."),
        Figure("sample", "", "Index of the worst sample.", detail=True),
    )

    @property
    def why(self) -> str:
        """What the limit is for, in words; nothing of a status."""
        return _WHY.get(self.limit, "")

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


@dataclass(frozen=True, eq=False)
class LineQuantities:
    """What limits bound, (k, m) each; NaN where a quantity has no value. SI."""

    lowest_tension: Array  # along the line
    highest_tension: Array  # along the line
    cable_length: Array  # unstrained, from winch exit to platform
    swing: Array  # azimuth of the sheave from where its mounting faces
    lever: Array  # angle above the horizontal
    winch_speed: Array  # of the cable
    winch_torque: Array  # at the drum
    sheave_clearance: Array

    @classmethod
    def of(cls, rows: Equilibrium) -> LineQuantities:
        """Of solved poses that are not moving."""
        low, high = rows.extremes()
        still = np.zeros_like(rows.lengths)
        angles = swing_angles(rows), lever_angles(rows)
        return cls(low, high, rows.lengths, *angles, still, winch_torques(rows), sheave_clearances(rows))


@dataclass(frozen=True)
class Limit:
    """A limit of the hardware on the quantity of the same name of each line."""

    name: str
    unit: str
    bounds: Callable[[Line], Bounds]  # lowest and highest, or None where the line has no such limit
    why: str  # what it is for, in the words of a report

    def values(self, lines: LineQuantities) -> Array:
        """What is bounded, (k, m)."""
        return np.asarray(getattr(lines, self.name.replace(" ", "_")))

    def allowed(self, lines: Sequence[Line]) -> Array:
        """Lowest and highest value of each line, (m, 2); infinite where it has no such limit."""
        return np.array([self.bounds(line) or (-np.inf, np.inf) for line in lines])


def _up_to(limit: float | None) -> Bounds:
    return None if limit is None else (-np.inf, limit)


def _swing(line: Line) -> Bounds:
    swing = getattr(line.sheave, "swing", None)
    return None if swing is None else (-swing, swing)


def _lever(line: Line) -> Bounds:
    return getattr(line.sheave, "lever_range", None)


LIMITS: Final = (
    Limit(
        "lowest tension",
        "N",
        lambda line: (line.tension_limits[0], np.inf),
        "below it a line hangs loose and no longer holds the platform",
    ),
    Limit(
        "highest tension",
        "N",
        lambda line: _up_to(line.tension_limits[1]),
        "above it cable, winch or mounting may be overloaded",
    ),
    Limit("cable length", "m", lambda line: _up_to(line.winch.capacity), "more than that the drum does not hold"),
    Limit("swing", "rad", _swing, "beyond it the sheave turns against its stop and the cable may leave the groove"),
    Limit("lever", "rad", _lever, "beyond it the lever runs against its stop"),
    Limit("winch speed", "m/s", lambda line: _up_to(line.winch.max_speed), "faster than that the winch cannot wind"),
    Limit("winch torque", "N m", lambda line: _up_to(line.winch.max_torque), "more than that the winch cannot hold"),
    Limit("sheave clearance", "m", lambda _line: (0.0, np.inf), "below it the platform may touch sheave or lever"),
)
_FRAME = {f"frame, {axis}": "beyond it the platform leaves the space it may be in" for axis in "xyz"}
_WHY = {limit.name: limit.why for limit in LIMITS} | _FRAME


def judge(
    robot: Robot, positions: Array, codes: NDArray[np.int64], violations: Array, lines: LineQuantities
) -> tuple[Finding, ...]:
    """Findings of a path, worst first: *positions* (k, 3) m; *codes* and *violations* (k,), N, of the inverse there."""
    findings = [_frame(robot, positions)]
    for limit in LIMITS:
        findings += _worst_line(limit, limit.values(lines), robot)
    findings += _statics(codes, violations)
    return tuple(sorted(findings, key=lambda found: (found.violations == 0, found.is_status, -found.violations)))


def judge_pose(equilibrium: Equilibrium) -> tuple[Finding, ...]:
    """Findings of one solved pose, worst first: every limit but those of motion."""
    row = equilibrium[None]
    return judge(_judged_robot(row.model), row.pose[:, :3], row.code, row.violation, LineQuantities.of(row))


def broken_limits(rows: Equilibrium) -> tuple[tuple[str, ...], Mask]:
    """Names of what can forbid a pose, and which of them each of N solved poses breaks, (N, L).

    The limits of the hardware at rest come first, then statuses of poses that cannot be held. A pose without tensions
    within their limits breaks the lowest, the highest or both, as the best tensions there do; the lowest where a line
    would have to push.
    """
    quantities, lines = LineQuantities.of(rows), _judged_robot(rows.model).lines
    columns = {}
    for limit in LIMITS:
        columns[limit.name] = _beyond(limit.values(quantities), limit.allowed(lines)).any(axis=1)
    infeasible = rows.code == list(Status).index(Status.INFEASIBLE)
    columns["lowest tension"] |= infeasible & ~columns["highest tension"]
    for code, status in enumerate(Status):
        if status not in (Status.OK, Status.INFEASIBLE):
            columns[status.value] = rows.code == code
    return tuple(columns), np.column_stack(list(columns.values()))


def _judged_robot(model: Model) -> Robot:
    """The robot of *model* with the tension limits that hold there."""
    return model.robot if model.tension_limits is None else model.robot.limited(model.tension_limits)


def _beyond(values: Array, allowed: Array) -> Mask:
    """Where values (N, m) are outside what is *allowed* (m, 2) by more than rounding; nowhere where not known."""
    low, high = allowed.T
    spare = _ROUNDING * np.array([_size(bound) for bound in allowed])
    return np.asarray((values < low - spare) | (values > high + spare))


# A tension distribution that rests on its limit meets it to rounding.
_ROUNDING = 1e-9


def _worst_line(limit: Limit, values: Array, robot: Robot) -> list[Finding]:
    """The finding of the line that comes nearest to its bounds or breaks them most; none where no line has any."""
    worst: Finding | None = None
    violated = np.zeros(len(values), dtype=bool)
    for i, line in enumerate(robot.lines):
        bound = limit.bounds(line)
        if bound is None or np.isnan(values[:, i]).all():
            continue
        margin = np.minimum(values[:, i] - bound[0], bound[1] - values[:, i])
        violated |= margin < -_ROUNDING * _size(bound)
        at = int(np.nanargmin(margin))
        if worst is None or margin[at] < worst.margin:
            value = float(values[at, i])
            worst = Finding(limit.name, limit.unit, float(margin[at]), value, bound, line.name, at, 0)
    if worst is None:
        return []
    smallest = worst.margin if violated.any() else max(worst.margin, 0.0)
    return [replace(worst, margin=smallest, violations=int(violated.sum()))]


def _size(bound: Iterable[float]) -> float:
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
