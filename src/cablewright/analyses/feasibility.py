"""Limits of the hardware and the statics along a path, each with its worst sample."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import Status
from cablewright.foundation.memory_mapped import blocks, let_go
from cablewright.foundation.results import Figure
from cablewright.models.statics import LIFTS, Equilibrium, Model, lifts
from cablewright.robot import Line, Robot
from cablewright.solvers.hardware_limits import lever_angles, sheave_clearances, swing_angles, winch_torques

Bounds = tuple[float, float] | None


@dataclass(frozen=True)
class Finding:
    """One limit evaluated over a path, with its worst sample.

    `margin` is signed, in the limit's unit: negative is a violation.
    """

    limit: str  # name of one of `LIMITS`, "frame, x" (or y, z), or a status sentence
    unit: str  # "N", "m", "rad", "m/s", "N m"
    margin: float  # smallest signed distance to the limit along the path
    value: float  # the quantity at that sample
    allowed: tuple[float, float]  # lowest and highest allowed value at that sample
    line: str | None  # name of the line; None where the limit is the platform's
    sample: int  # index of the worst sample
    violations: int  # number of samples that violate it

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
        """The purpose of the limit, in words; empty for a status."""
        return _WHY.get(self.limit, "")

    @property
    def is_status(self) -> bool:
        """Whether `limit` is the sentence of a status rather than a limit of the hardware."""
        return any(self.limit == status.value for status in Status)

    def bounds(self) -> str:
        """Return the allowed range of the limit, in words."""
        low, high = self.allowed
        if not np.isfinite(low):
            return f"at most {high:g} {self.unit}"
        if not np.isfinite(high):
            return f"at least {low:g} {self.unit}"
        return f"{low:g} to {high:g} {self.unit}"


@dataclass(frozen=True, eq=False)
class LineQuantities:
    """Quantities of lines that have hardware limits, (k, m) each, SI; NaN where one is not defined."""

    lowest_tension: Array  # along the line
    highest_tension: Array  # along the line
    cable_length: Array  # unstrained, from winch exit to platform
    swing: Array  # azimuth of the sheave from its mounting's facing
    lever: Array  # angle above the horizontal
    winch_speed: Array  # of the cable
    winch_torque: Array  # at the drum
    sheave_clearance: Array

    @classmethod
    def of(cls, rows: Equilibrium) -> LineQuantities:
        """Return the limited quantities of all lines at solved poses, at rest."""
        low, high = rows.extremes()
        still = np.zeros_like(rows.lengths)
        angles = swing_angles(rows), lever_angles(rows)
        return cls(low, high, rows.lengths, *angles, still, winch_torques(rows), sheave_clearances(rows))


@dataclass(frozen=True)
class Limit:
    """A hardware limit of the quantity of `LineQuantities` with the same name."""

    name: str
    unit: str
    bounds: Callable[[Line], Bounds]  # lowest and highest value, None where the line has no such limit
    why: str  # its purpose, as written in reports

    def values(self, lines: LineQuantities) -> Array:
        """Return the quantity (k, m) that this limit bounds, at k poses."""
        return np.asarray(getattr(lines, self.name.replace(" ", "_")))

    def allowed(self, lines: Sequence[Line]) -> Array:
        """Return the lowest and highest allowed value of each line, (m, 2); infinite for a line without this limit."""
        return np.array([self.bounds(line) or (-np.inf, np.inf) for line in lines])


def _up_to(limit: float | None) -> Bounds:
    return None if limit is None else (-np.inf, limit)


def _swing(line: Line) -> Bounds:
    swing = getattr(line.sheave, "swing", None)
    return None if swing is None else (-swing, swing)


def _drum_room(line: Line) -> Bounds:
    """Longest length of each cable: the drum holds those of all."""
    return _up_to(None if line.winch.capacity is None else line.winch.capacity / line.cables)


LIMITS: Final = (
    Limit("lowest tension", "N", lambda line: (line.tension_limits[0], np.inf), "below it the line hangs loose"),
    Limit("highest tension", "N", lambda line: _up_to(line.tension_limits[1]), "above it cable or winch is overloaded"),
    Limit("cable length", "m", _drum_room, "the drum holds no more"),
    Limit("swing", "rad", _swing, "beyond it the sheave is at its stop and the cable may leave the groove"),
    Limit("lever", "rad", lambda line: getattr(line.sheave, "lever_range", None), "beyond it the lever is at its stop"),
    Limit("winch speed", "m/s", lambda line: _up_to(line.winch.max_speed), "the winch winds no faster"),
    Limit("winch torque", "N m", lambda line: _up_to(line.winch.max_torque), "the winch holds no more"),
    Limit("sheave clearance", "m", lambda _line: (0.0, np.inf), "below it the platform may touch sheave or lever"),
)
TENSION_LIMITS: Final = ("lowest tension", "highest tension")
CLEARANCE: Final = "clearance of lines"
EXPECTED_ERROR: Final = "expected error"
PLANE_FORCE: Final = "plane force"
MOVED_ERROR: Final = "expected error with acceleration"
SLACK: Final = "length against straight line"
PACE: Final = "winch speed against nozzle speed"
INTERPOLATION: Final = "interpolation of lengths"
LENGTH_JUMP: Final = "jump of a length"
TENSION_JUMP: Final = "jump of a tension"
_OF_JOBS = {
    CLEARANCE: "below it lines touch each other, the platform, the frame or the part",
    EXPECTED_ERROR: "beyond it strands miss those below",
    MOVED_ERROR: "beyond it strands miss those below",
}
OF_CHECKS: Final = {
    PLANE_FORCE: LIFTS,
    SLACK: "above it the line hangs in a loop: give its tension_limits a larger min",
    PACE: "no geometry needs more: above it the line changes from taut to slack",
    INTERPOLATION: "beyond it the winches miss the path between samples: give the job a shorter sampling.step",
    LENGTH_JUMP: "above it the solution changes from one shape of the lines to another",
    TENSION_JUMP: "above it the solution changes from one choice of tensions to another",
}
"""Limits of figures that no robot file gives, and what to do about them."""
_FRAME = {f"frame, {axis}": "beyond it the platform leaves the frame" for axis in "xyz"}
_WHY = {limit.name: limit.why for limit in LIMITS} | _FRAME | _OF_JOBS | OF_CHECKS


def judge(
    robot: Robot,
    positions: Array,
    codes: NDArray[np.int64],
    violations: Array,
    lines: LineQuantities,
    plane_force: Array,
) -> tuple[Finding, ...]:
    """Return the findings, worst first, of a path's *positions* (k, 3), m, *codes* and *violations* (k,), N.

    The last two are of the inverse problem. *plane_force* (k,), N, along the normal; NaN where there is no plane.
    """
    findings = [_frame(robot, positions)]
    if robot.platform.may_lift:
        findings += at_most(
            PLANE_FORCE, "N", np.where(_lifts(robot, plane_force), plane_force, plane_force.clip(max=0.0)), 0.0
        )
    for limit in LIMITS:
        findings += _worst_line(limit, limit.values(lines), robot)
    findings += _statics(codes, violations)
    return ranked(findings)


def ranked(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return findings sorted: violations first, of hardware limits before statuses, and those of most samples first."""
    return tuple(sorted(findings, key=lambda found: (found.violations == 0, found.is_status, -found.violations)))


def judge_pose(equilibrium: Equilibrium) -> tuple[Finding, ...]:
    """Return findings of one solved pose, worst first: every limit except those of motion."""
    row = equilibrium[None]
    own = row.code, row.violation, LineQuantities.of(row), plane_forces(row)
    return judge(_judged_robot(row.model), row.pose[:, :3], *own)


def plane_forces(rows: Equilibrium) -> Array:
    """Return the force (N,), N, of lines and loads on the plane along its normal; NaN without a plane."""
    found = rows.plane_force
    return np.full(len(rows), np.nan) if found is None else np.asarray(found)


def at_most(
    limit: str, unit: str, values: Array, allowed: Array | float, lines: Sequence[str] | None = None
) -> list[Finding]:
    """Return the finding that *values* (k,), or (k, m) of *lines*, are at most *allowed*; none if none is known."""
    margins = np.asarray(allowed - values)
    if not margins.size or np.isnan(margins).all():
        return []
    at = int(np.nanargmin(margins))
    value, margin = float(values.flat[at]), float(margins.flat[at])
    beyond = margins < -_ROUNDING * np.maximum(1.0, np.abs(allowed))
    violations = int((beyond if beyond.ndim == 1 else beyond.any(axis=1)).sum())
    row, column = divmod(at, values[0].size)
    line = None if lines is None else lines[column]
    margin = margin if violations else max(margin, 0.0)
    return [Finding(limit, unit, margin, value, (-np.inf, value + margin), line, row, violations)]


def merged(findings: Sequence[Finding]) -> list[Finding]:
    """Return the finding of one limit along a path from its *findings* in blocks of samples; None if there are none."""
    if not findings:
        return []
    worst = min(findings, key=lambda found: found.margin)
    return [replace(worst, violations=sum(found.violations for found in findings))]


def broken_limits(rows: Equilibrium) -> tuple[tuple[str, ...], Mask]:
    """Return the names of L limits and statuses, and which of them each of N solved poses violates, (N, L).

    The limits of the hardware at rest come first, then the statuses of poses that cannot be held. An infeasible pose
    violates the lowest tension, the highest or both, as the best tensions there do; the lowest where a line would have
    to push.
    """
    quantities, lines = LineQuantities.of(rows), _judged_robot(rows.model).lines
    columns = {}
    for limit in LIMITS:
        columns[limit.name] = _beyond(limit.values(quantities), limit.allowed(lines)).any(axis=1)
    infeasible = rows.code == list(Status).index(Status.INFEASIBLE)
    columns["lowest tension"] |= infeasible & ~columns["highest tension"]
    if rows.model.robot.platform.may_lift:
        columns[PLANE_FORCE] = _lifts(_judged_robot(rows.model), plane_forces(rows))
    for code, status in enumerate(Status):
        if status not in (Status.OK, Status.INFEASIBLE):
            columns[status.value] = rows.code == code
    return tuple(columns), np.column_stack(list(columns.values()))


def _lifts(robot: Robot, plane_force: Array) -> Mask:
    """Whether each *plane_force* (N,), N, lifts the platform off the plane by more than rounding."""
    return lifts(plane_force, max(line.tension_limits[1] for line in robot.lines))


def _judged_robot(model: Model) -> Robot:
    """The robot of *model* with the tension limits of that model."""
    return model.robot if model.tension_limits is None else model.robot.limited(model.tension_limits)


def _beyond(values: Array, allowed: Array) -> Mask:
    """Whether values (N, m) are outside *allowed* (m, 2) by more than rounding; False where unknown."""
    low, high = allowed.T
    spare = _ROUNDING * np.maximum(1.0, np.where(np.isfinite(allowed), np.abs(allowed), 0.0).max(axis=1))
    return np.asarray((values < low - spare) | (values > high + spare))


# A tension distribution at its limit meets it only to rounding.
_ROUNDING = 1e-9


def _worst_line(limit: Limit, values: Array, robot: Robot) -> list[Finding]:
    """The finding of the line with the smallest margin; none where no line has this limit."""
    allowed = limit.allowed(robot.lines)
    least, rows, violations = np.full(len(allowed), np.inf), np.zeros(len(allowed), dtype=np.int64), 0
    for block in blocks(len(values)):
        own = values[block]
        margins = np.minimum(own - allowed[:, 0], allowed[:, 1] - own)
        margins[np.isnan(margins)] = np.inf
        smallest = margins.min(axis=0)
        rows = np.where(smallest < least, block.start + margins.argmin(axis=0), rows)
        least = np.minimum(least, smallest)
        violations += int(_beyond(own, allowed).any(axis=1).sum())
        let_go(values)
    if not np.isfinite(least.min(initial=np.inf)):
        return []
    i = int(least.argmin())
    at, margin = int(rows[i]), float(least[i]) if violations else max(float(least[i]), 0.0)
    bounds = float(allowed[i, 0]), float(allowed[i, 1])
    return [Finding(limit.name, limit.unit, margin, float(values[at, i]), bounds, robot.lines[i].name, at, violations)]


def _frame(robot: Robot, positions: Array) -> Finding:
    """The finding of the frame: the coordinate with the smallest margin."""
    low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    at, least, violations = 0, np.inf, 0
    for block in blocks(len(positions)):
        margins = np.minimum(positions[block] - low, high - positions[block]).min(axis=1)
        if margins.min() < least:
            at, least = block.start + int(margins.argmin()), margins.min()
        violations += int((margins < 0.0).sum())
    margins = np.minimum(positions[at] - low, high - positions[at])
    axis = int(np.argmin(margins))
    allowed, name = (float(low[axis]), float(high[axis])), f"frame, {'xyz'[axis]}"
    return Finding(name, "m", float(margins[axis]), float(positions[at, axis]), allowed, None, at, violations)


def _statics(codes: NDArray[np.int64], violations: Array) -> list[Finding]:
    """One finding for each status of poses that cannot be held, with the largest violation of tension limits, N."""
    found = []
    for code in np.unique(codes[codes != 0]):
        at = np.flatnonzero(codes == code)
        worst = int(at[np.argmax(violations[at])])
        beyond = float(violations[worst])
        sentence = Status.of(int(code)).value
        found.append(Finding(sentence, "N", -beyond, beyond, (-np.inf, 0.0), None, worst, len(at)))
    return found
