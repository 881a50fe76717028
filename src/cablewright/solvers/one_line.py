"""One line at a pose, without the others: straight, or hanging with a given excess length."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

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


def winch_line(model: Model, line: LineKey) -> int:
    """Return the index of *line*, see `line_index`, whose length a winch sets. Raises `InputError`."""
    index = line_index(model, line)
    if model.lines.counterweight[index] > 0.0:
        raise InputError(
            f"line {model.robot.lines[index].name!r} has a counterweight instead of a winch; choose another line"
        )
    return index


def taut_lengths(packed: Packed, poses: Array) -> Array:
    """Return the unstrained length (N, m), m, of each straight line at *poses* (N, n); NaN inside a sheave.

    *packed* has one row or N.
    """
    lengths = np.empty((len(poses), packed.lines.shape[1]))
    batches.taut_rows(packed, np.ascontiguousarray(poses), lengths)
    return lengths


def one_pose(model: Model, pose: ArrayLike) -> Array:
    """Return *pose* as (1, n). Raises `InputError`."""
    at, single = as_poses(model, pose, "pose")
    if not single:
        raise InputError(f"pose: one pose is expected; got {len(at)} rows")
    return at


def hang(row: Array, plane: Array, length: float, y: Array) -> int:
    """Compute the state *y* of an upright line of unstrained *length* (m) in its plane (4,). Returns a kernel code."""
    return int(find_upright(row, y, plane, length, np.zeros((y.size, y.size)), np.zeros((y.size, 4))))


@dataclass(frozen=True, eq=False)
class LoneLine:
    """The line *index* of a robot at one *pose* (1, n), without the other lines. A winch sets its length."""

    model: Model
    pose: Array
    index: int

    @cached_property
    def packed(self) -> Packed:
        """The robot as arrays for kernels, as a batch of one row."""
        return self.model.rows()

    @property
    def numbers(self) -> LineNumbers:
        """The parameters of the line as arrays for kernels."""
        return LineNumbers(self.packed.lines[0, self.index])

    @cached_property
    def taut(self) -> float:
        """Taut length of the line, m; NaN inside a sheave."""
        return float(taut_lengths(self.packed, self.pose)[0, self.index])

    @property
    def taut_span(self) -> float:
        """Length of the free span, m, where the line is taut."""
        states = blank_states(1, self.model.m)
        batches.shape_rows(self.packed, self.pose, np.full((1, self.model.m), np.nan), states)
        return float(LineStates(states[0, self.index]).free_length)

    def hung(self, excess: float) -> tuple[int, Array]:
        """Return a kernel code and the state (6,) of the line with an *excess* length, m, over the taut one."""
        m, codes = self.model.m, np.zeros(1, dtype=np.int64)
        states, lengths = blank_states(1, m), np.full((1, m), self.taut + excess)
        arrays = (np.array([self.index]), states, np.zeros((1, self.model.n)), codes)
        batches.slack_rows(self.packed, self.pose, lengths, *arrays)
        return int(codes[0]), states[0, self.index]

    def max_excess(self) -> tuple[float, str]:
        """Return the largest excess length, m, and the reason of that limit: a word of `slack.SlackSet`."""
        line, limit, ended_by = self.model.robot.lines[self.index], math.inf, "nothing"
        if line.winch.capacity is not None:
            limit, ended_by = line.winch.capacity / line.cables - self.taut, "capacity"
        if self.numbers.weight == 0.0 or math.isnan(self.taut):
            return limit, ended_by
        heights = placed(self.pose, self.model.lines.platform_point)[0, :, 2]
        floor = min(self.model.robot.scene.frame_min[2], float(heights.min()))

        def ends(excess: float) -> str:
            code, y = self.hung(excess)
            if code != Code.OK:
                return "sheave"
            return "floor" if self._lowest(y, float(heights[self.index])) < floor - FLOOR_ROUNDING else ""

        if ends(0.0):
            return 0.0, ends(0.0)
        good, bad = 0.0, FIRST_STEP
        while bad < limit and not ends(bad):
            good, bad = bad, bad * STEP
        return (limit, ended_by) if bad >= limit else (last_fine(lambda excess: not ends(excess), good, bad), ends(bad))

    def _lowest(self, y: Array, end: float) -> float:
        """Height of the lowest point of the free span, m, whose platform point is at the height *end*.

        A sheave on the platform counts with its whole radius.
        """
        h, v = start_force(y)
        own = self.numbers
        last = v + own.weight * LineStates(y).free_length
        least = min(max(v, 0.0), last)  # vertical tension at the lowest point
        rise = (math.hypot(h, last) - math.hypot(h, least)) / own.weight
        rise += 0.5 * own.free_compliance * (last * last - least * least) / own.weight
        return float(end - own.end_radius - rise)


def last_fine(fine: Callable[[float], bool], good: float, bad: float) -> float:
    """Return the largest excess, m, between *good* and *bad* for which *fine* holds, by bisection."""
    while abs(bad - good) > RESOLUTION * (1.0 + good):
        middle = 0.5 * (good + bad)
        if fine(middle):
            good = middle
        else:
            bad = middle
    return good
