"""One line at a pose, without the others: as a straight tangent, or hanging with excess length.

Planes are those of `vertical_plane.place`: ex, ey (world, towards the platform), x and z of the platform point from the
exit point, m.
"""

import math
import operator
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.kernels import batches
from cablewright.kernels.layout import Code, Packed
from cablewright.kernels.statics.line.upright import start_force
from cablewright.kernels.statics.line.upright_lines import find_upright
from cablewright.models.packed_views import LineNumbers, LineStates, blank_states
from cablewright.models.rotation import placed
from cablewright.models.statics import Model
from cablewright.models.support import Capability, require
from cablewright.solvers.arguments import as_poses

LineKey = str | int
"""A line by its name, or by its index in the robot's lines, from 0."""

FLOOR_ROUNDING = 1e-9  # m; a cable that is that far below the floor counts as on it
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


def planes_of(lines: Array, poses: Array) -> Array:
    """Return the planes (N, m, 4) of lines, see `vertical_plane.place`."""
    away = placed(poses, LineNumbers(lines).platform_point) - LineNumbers(lines).exit_point
    x = np.hypot(away[..., 0], away[..., 1])
    along = np.where(x[..., None] > 0.0, away[..., :2] / np.where(x > 0.0, x, 1.0)[..., None], [1.0, 0.0])
    return np.concatenate([along, x[..., None], away[..., 2:]], axis=-1)


def taut_lengths(packed: Packed, poses: Array) -> Array:
    """Return the length (N, m), m, of each straight line at *poses* (N, n), unstretched; NaN inside a sheave.

    *packed* has one row or N.
    """
    lengths = np.empty((len(poses), packed.lines.shape[1]))
    batches.taut_rows(packed, np.ascontiguousarray(poses), lengths)
    return lengths


def one_pose(model: Model, pose: ArrayLike) -> tuple[Array, Array]:
    """Return *pose* as (1, n), and the lines' planes (m, 4) there. Raises `InputError`."""
    require(model, Capability.SHAPE)
    at, single = as_poses(model, pose, "pose")
    if not single:
        raise InputError(f"pose: one pose is expected; got {len(at)} rows")
    return at, planes_of(model.packed.lines, at)[0]


def hang(row: Array, plane: Array, length: float, y: Array) -> int:
    """Set the state *y* of an upright line to unstrained *length* (m) in its plane (4,). Returns a kernel code."""
    return int(find_upright(row, y, plane, length, np.zeros((y.size, y.size)), np.zeros((y.size, 4))))


def max_excess(model: Model, pose: Array, i: int) -> tuple[float, str]:
    """Return the largest excess of line *i* at *pose* (1, n), m, and what limits it: a word of `slack.SlackSet`."""
    row, planes = model.packed.lines[i], planes_of(model.packed.lines, pose)[0]
    own = LineNumbers(row)
    taut = float(taut_lengths(model.rows(), pose)[0, i])
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
