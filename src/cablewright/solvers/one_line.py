"""One line at a pose, without the others: as a straight tangent, or hanging with excess length.

Planes are those of `vertical_plane.place`: ex, ey (world, towards the platform), x and z of the platform point from the
exit point, m.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from cablewright.arrays import Array
from cablewright.errors import InputError, UnknownName
from cablewright.kernels.layout import Code
from cablewright.kernels.statics.line.sheave import straight, whole_length
from cablewright.kernels.statics.line.upright import SLACK_TENSION, guess, is_slack, lever_stable, settle, start_force
from cablewright.kernels.statics.line.vertical_plane import has_plane
from cablewright.models.packed_views import LineNumbers, LineStates, blank_states
from cablewright.models.rotation import placed
from cablewright.models.statics import Model
from cablewright.solvers.arguments import as_poses

LineKey = str | int
"""A line by its name, or by its index in the robot's lines, from 0."""

TAUT = 1e9  # N; tension at which a lever's weight is negligible
FLOOR_ROUNDING = 1e-9  # m; a cable that is that far below the floor counts as on it
LEVER_PULLS = (1.0, 10.0, 100.0, 1000.0)  # tensions, times the weight of the straight line, at which levers are placed
FIRST_STEP, STEP = 1e-3, 1.2  # m, factor: steps of the search for the largest excess
RESOLUTION = 1e-9  # m per m of excess, of the ends of a range


def line_index(model: Model, line: LineKey) -> int:
    """Return the index of *line*, a name or an index from 0, in the robot's lines. Raises `InputError`."""
    names = [each.name for each in model.robot.lines]
    if isinstance(line, str):
        if line not in names:
            raise UnknownName("line", line, names)
        return names.index(line)
    try:
        index = operator.index(line)
    except TypeError:
        raise InputError(f"line {line!r}: a name or a whole number is expected") from None
    if not 0 <= index < model.m:
        raise InputError(f"line {index}: the lines of {model.robot.name!r} are 0 to {model.m - 1}")
    return index


def planes_and_arms(lines: Array, poses: Array) -> tuple[Array, Array]:
    """Return planes (N, m, 4), see `vertical_plane.place`, and arms (N, m, 3) from the platform's origin, world, m."""
    points = placed(poses, LineNumbers(lines).platform_point)
    away = points - LineNumbers(lines).exit_point
    x = np.hypot(away[..., 0], away[..., 1])
    along = np.where(x[..., None] > 0.0, away[..., :2] / np.where(x > 0.0, x, 1.0)[..., None], [1.0, 0.0])
    return np.concatenate([along, x[..., None], away[..., 2:]], axis=-1), points - poses[..., None, :3]


def taut_lengths(lines: Array, planes: Array) -> Array:
    """Return the length (m,), m, of each straight line in its plane (m, 4), unstretched; NaN inside a sheave."""
    lengths, y = np.full(len(lines), np.nan), blank_states()
    for i, (row, plane) in enumerate(zip(lines, planes, strict=True)):
        if np.isfinite(plane).all() and straight(row, plane[2], plane[3], TAUT, y):
            lengths[i] = whole_length(row, y)
    return lengths


def one_pose(model: Model, pose: ArrayLike) -> tuple[Array, Array]:
    """Return *pose* as (1, n), and the lines' planes (m, 4) there. Raises `InputError`."""
    model.robot.require_lines_in_plane("the shape of a line")
    at, single = as_poses(model, pose, "pose")
    if not single:
        raise InputError(f"pose: one pose is expected; got {len(at)} rows")
    return at, planes_and_arms(model.packed.lines, at)[0][0]


def hang(row: Array, plane: Array, length: float, y: Array) -> int:
    """Set the line state *y* to a line of unstrained *length* (m) in its plane (4,). Returns a kernel code."""
    x, z, own = plane[2], plane[3], LineNumbers(row)
    if not has_plane(row, plane):
        return Code.UNDER_EXIT
    if math.isnan(length) or (own.has_lever and math.hypot(x, z) < own.lever + own.radius):
        return Code.INSIDE_SHEAVE
    if own.weight == 0.0 and straight(row, x, z, SLACK_TENSION, y) and whole_length(row, y) <= length:
        return Code.OK
    block, rhs, settled = np.zeros((y.size, y.size)), np.zeros((y.size, 3)), np.full(y.size, np.nan)
    for pull in LEVER_PULLS:
        if not guess(row, x, z, length, pull * max(float(own.weight), 1.0) * math.hypot(x, z), y):
            return Code.INSIDE_SHEAVE
        if settle(row, x, z, length, y, block, rhs) and not _runs_back(own, LineStates(y)):
            settled[:] = y
            if lever_stable(row, y):
                break
    y[:] = settled
    return Code.NOT_CONVERGED if np.isnan(y).any() else Code.OK


def _runs_back(own: LineNumbers, state: LineStates) -> bool:
    """Whether the tension at the sheave does not carry the dead span, which then hangs below the winch."""
    if own.unknowns in (3.0, 5.0):  # without a dead span, or with one that may sag
        return False
    pull = math.exp(state.log_tension) * math.sin(state.dead_angle)
    return bool(pull < 0.0 < pull + own.weight * state.dead_length)


def end_wrench(row: Array, plane: Array, arm: Array, y: Array) -> Array:
    """Return force, N, and moment about the platform's origin, N m, of one line on the platform, world: (6,)."""
    h = v = 0.0
    if not is_slack(row, y):
        h, v = start_force(y)
        v += LineNumbers(row).weight * LineStates(y).free_length  # at the platform end
    force = LineNumbers(row).pulls * np.array([-h * plane[0], -h * plane[1], -v])
    return np.concatenate([force, np.cross(arm, force)])


def max_excess(model: Model, pose: Array, i: int) -> tuple[float, str]:
    """Return the largest excess of line *i* at *pose* (1, n), m, and what limits it: a word of `slack.SlackSet`."""
    row, planes = model.packed.lines[i], planes_and_arms(model.packed.lines, pose)[0][0]
    own = LineNumbers(row)
    taut = float(taut_lengths(model.packed.lines, planes)[i])
    line, limit, ended_by = model.robot.lines[i], math.inf, "nothing"
    if line.winch.capacity is not None:
        limit, ended_by = line.winch.capacity / line.cables - taut, "capacity"
    if own.weight == 0.0 or math.isnan(taut):
        return limit, ended_by
    y = blank_states()
    floor = min(model.robot.scene.frame_min[2] - own.exit_point[2], planes[:, 3].min())

    def ends(excess: float) -> str:
        if hang(row, planes[i], taut + excess, y) != Code.OK:
            return "sheave"
        return "floor" if _lowest(row, y) < floor - FLOOR_ROUNDING else ""

    if ends(0.0):
        return 0.0, ends(0.0)
    good, bad = 0.0, FIRST_STEP
    while bad < limit and not ends(bad):
        good, bad = bad, bad * STEP
    return (limit, ended_by) if bad >= limit else (last_fine(lambda excess: not ends(excess), good, bad), ends(bad))


def last_fine(fine: Callable[[float], bool], good: float, bad: float) -> float:
    """Return the last excess, m, between *good* and *bad* for which *fine* holds, by bisection."""
    while abs(bad - good) > RESOLUTION * (1.0 + good):
        middle = 0.5 * (good + bad)
        if fine(middle):
            good = middle
        else:
            bad = middle
    return good


def _lowest(row: Array, y: Array) -> float:
    """Height of the lowest point of a line's free span above its exit point, m."""
    h, v = start_force(y)
    own, state = LineNumbers(row), LineStates(y)
    lost = min(max(-v, 0.0), own.weight * state.free_length)  # vertical tension lost between sheave and lowest point
    begin = own.lever * math.sin(state.lever_angle) + own.side * own.radius * math.cos(state.free_angle)
    end = v + lost
    fall = (math.hypot(h, v) - math.hypot(h, end)) / own.weight
    fall += 0.5 * own.free_compliance * (v * v - end * end) / own.weight
    return float(begin - fall)
