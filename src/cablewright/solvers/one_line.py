"""One line at a pose, apart from the others: drawn taut, or hanging at a length that is too long.

Planes are those of `kernels.wrench.place`: ex, ey (world, towards the platform), x and z of the platform point from the
exit point, m.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.errors import InputError, UnknownName
from cablewright.kernels import batches, layout
from cablewright.kernels.layout import Code
from cablewright.kernels.statics.equilibrium import is_slack
from cablewright.kernels.statics.line import guess, lever_stable, settle, start_force
from cablewright.kernels.statics.sheave import straight, whole_length
from cablewright.models.rotation import placed
from cablewright.models.statics import Model
from cablewright.solvers.arguments import as_poses

__all__ = [
    "TAUT",
    "UNDER",
    "LineKey",
    "end_wrench",
    "hang",
    "last_fine",
    "line_index",
    "most_excess",
    "one_pose",
    "planes_and_arms",
    "taut_lengths",
]

Array = NDArray[np.float64]
LineKey = str | int
"""A line by its name, or by its place in the robot's lines, from 0."""

TAUT = 1e9  # N: at this tension a lever's weight does not count
UNDER = 1e-9  # m: nearer to the axis than this a line has no plane, as the inverse problem has it
LEVER_PULLS = (1.0, 10.0, 100.0, 1000.0)  # times the weight of the straight line, to place levers with
FIRST_STEP, STEP = 1e-3, 1.2  # m, factor: how the excess grows on the way to the most that a line can have
FINEST = 1e-9  # m per m of excess: how closely the ends of a range are found


def line_index(model: Model, line: LineKey) -> int:
    """Where *line*, a name or a place from 0, stands among the robot's lines. Raises `InputError`."""
    names = [each.name for each in model.robot.lines]
    if isinstance(line, str):
        if line not in names:
            raise UnknownName("line", line, names)
        return names.index(line)
    try:
        index = operator.index(line)
    except TypeError:
        raise InputError(f"line {line!r}: a name or a whole number is wanted") from None
    if not 0 <= index < model.m:
        raise InputError(f"line {index}: the lines of {model.robot.name!r} are 0 to {model.m - 1}")
    return index


def planes_and_arms(lines: Array, poses: Array) -> tuple[Array, Array]:
    """Planes (N, m, 4), see `kernels.wrench.place`, and arms (N, m, 3) from the platform's origin, world, m."""
    points = placed(poses, lines[..., layout.POINT_X : layout.POINT_Z + 1])
    away = points - lines[..., layout.EXIT_X : layout.EXIT_Z + 1]
    x = np.hypot(away[..., 0], away[..., 1])
    along = np.where(x[..., None] > 0.0, away[..., :2] / np.where(x > 0.0, x, 1.0)[..., None], [1.0, 0.0])
    return np.concatenate([along, x[..., None], away[..., 2:]], axis=-1), points - poses[..., None, :3]


def taut_lengths(lines: Array, planes: Array) -> Array:
    """Length (m,) of each line drawn taut in its plane (m, 4), without weight and stretch, m; NaN inside a sheave."""
    lengths, y = np.full(len(lines), np.nan), np.zeros(layout.STATE)
    for i, (row, plane) in enumerate(zip(lines, planes, strict=True)):
        if np.isfinite(plane).all() and straight(row, plane[2], plane[3], TAUT, y):
            lengths[i] = whole_length(row, y)
    return lengths


def one_pose(model: Model, pose: ArrayLike) -> tuple[Array, Array]:
    """*pose* as (1, n), and the lines' planes (m, 4) there. Raises `InputError`."""
    at, single = as_poses(model, pose, "pose")
    if not single:
        raise InputError(f"pose: one pose is wanted; got {len(at)} rows")
    return at, planes_and_arms(model.packed.lines, at)[0][0]


def hang(row: Array, plane: Array, length: float, y: Array) -> int:
    """Set *y* to the line of unstrained *length* (m) in its plane (4,). Returns a code."""
    x, z = plane[2], plane[3]
    if x <= UNDER:
        return Code.UNDER_EXIT
    if math.isnan(length) or (
        row[layout.UNKNOWNS] == 6.0 and math.hypot(x, z) < row[layout.LEVER] + row[layout.RADIUS]
    ):
        return Code.INSIDE_SHEAVE
    if row[layout.WEIGHT] == 0.0 and straight(row, x, z, batches.SLACK_TENSION, y) and whole_length(row, y) <= length:
        return Code.OK
    block, rhs = np.zeros((layout.STATE, layout.STATE)), np.zeros((layout.STATE, 3))
    settled = np.full(layout.STATE, np.nan)
    for pull in LEVER_PULLS:
        if not guess(row, x, z, length, pull * max(row[layout.WEIGHT], 1.0) * math.hypot(x, z), y):
            return Code.INSIDE_SHEAVE
        if settle(row, x, z, length, y, block, rhs) and not _runs_back(row, y):
            settled[:] = y
            if lever_stable(row, y):
                break
    y[:] = settled
    return Code.NOT_CONVERGED if np.isnan(y).any() else Code.OK


def _runs_back(row: Array, y: Array) -> bool:
    """Whether the tension at the sheave does not hold up the dead span: the excess then hangs below the winch."""
    if row[layout.UNKNOWNS] in (3.0, 5.0):  # no dead span, or one that may sag
        return False
    pull = math.exp(y[layout.TAU]) * math.sin(y[layout.PSI])
    return bool(pull < 0.0 < pull + row[layout.WEIGHT] * y[layout.DEAD])


def _end_force(row: Array, y: Array) -> tuple[float, float]:
    """Tension (h, v) at the platform's end of a hanging line, along the direction of travel, N."""
    if is_slack(row, y):
        return 0.0, 0.0
    h, v = start_force(y)
    return h, v + row[layout.WEIGHT] * y[layout.FREE]


def end_wrench(row: Array, plane: Array, arm: Array, y: Array) -> Array:
    """Force, N, and moment about the platform's origin, N m, of one line on the platform, world: (6,)."""
    h, v = _end_force(row, y)
    force = np.array([-h * plane[0], -h * plane[1], -v])
    return np.concatenate([force, np.cross(arm, force)])


def most_excess(model: Model, pose: Array, i: int) -> tuple[float, str]:
    """How far line *i* can be let out at *pose* (1, n), m, and what ends it: a word of `slack.SlackSet`."""
    row, planes = model.packed.lines[i], planes_and_arms(model.packed.lines, pose)[0][0]
    taut = float(taut_lengths(model.packed.lines, planes)[i])
    capacity = model.robot.lines[i].winch.capacity
    most, ended_by = (math.inf, "nothing") if capacity is None else (capacity - taut, "capacity")
    if row[layout.WEIGHT] == 0.0 or math.isnan(taut):
        return most, ended_by
    y = np.zeros(layout.STATE)
    floor = min(model.robot.scene.frame_min[2] - row[layout.EXIT_Z], planes[:, 3].min())

    def ends(excess: float) -> str:
        if hang(row, planes[i], taut + excess, y) != Code.OK:
            return "sheave"
        return "floor" if _lowest(row, y) < floor - UNDER else ""

    if ends(0.0):
        return 0.0, ends(0.0)
    good, bad = 0.0, FIRST_STEP
    while bad < most and not ends(bad):
        good, bad = bad, bad * STEP
    return (most, ended_by) if bad >= most else (last_fine(lambda excess: not ends(excess), good, bad), ends(bad))


def last_fine(fine: Callable[[float], bool], good: float, bad: float) -> float:
    """The last excess, m, that is *fine* on the way from *good* to *bad*."""
    while abs(bad - good) > FINEST * (1.0 + good):
        middle = 0.5 * (good + bad)
        if fine(middle):
            good = middle
        else:
            bad = middle
    return good


def _lowest(row: Array, y: Array) -> float:
    """Height of the lowest point of a line's free span over its exit point, m."""
    h, v = start_force(y)
    weight, compliance = row[layout.WEIGHT], row[layout.FREE_COMPLIANCE]
    lowest = min(max(-v, 0.0), weight * y[layout.FREE])  # of the tension's way down, what is lost to the lowest point
    turn = row[layout.SIDE] * row[layout.RADIUS]
    begin = row[layout.LEVER] * math.sin(y[layout.BETA]) + turn * math.cos(y[layout.PHI])
    end = v + lowest
    fall = (math.hypot(h, v) - math.hypot(h, end)) / weight + 0.5 * compliance * (v * v - end * end) / weight
    return float(begin - fall)
