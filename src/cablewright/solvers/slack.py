"""Slack lines: the excess length of a line, the tensions of the taut lines meanwhile, and the shape of the slack one.

The **excess** of a line is its unstrained length minus its taut length at the same pose: that of the massless tangent
from winch to platform over the same sheave, as with ``cable="rigid"`` (a lever stands there as if it had no weight). A
line without weight is slack if its excess is positive, and carries nothing. A line with weight is never without
tension: the larger its excess the smaller its tension, down to that of its own weight on the platform. So slack means
here that an excess >= 0 is given, and that the line has no lowest tension limit.

Source: Merlet and Papegay, ICRA 2023, section II.C; `docs/slack.md`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.results import Figure, Result
from cablewright.kernels import batches
from cablewright.kernels.layout import Code
from cablewright.kernels.shared_winches.quadratic_program import LINE, OTHER
from cablewright.kernels.statics.equilibrium import evaluate, judge
from cablewright.kernels.statics.inverse import stays
from cablewright.kernels.statics.inverse_scratch import inverse_workspace
from cablewright.kernels.statics.line.upright import extremes
from cablewright.models.fidelity import CableLaw, SheaveLaw
from cablewright.models.packed_views import LineStates, PlatformNumbers, blank_states
from cablewright.models.shared_winches import drum_mates, drums, shares
from cablewright.models.statics import Equilibrium, Model
from cablewright.models.support_table import Capability, require
from cablewright.robot import Robot
from cablewright.solvers.arguments import as_lengths, as_poses, as_rows
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.one_line import (
    LineKey,
    LoneLine,
    last_fine,
    line_index,
    one_pose,
    taut_lengths,
    winch_line,
)
from cablewright.solvers.row_threads import run

Excess = Mapping[str, float] | Mapping[int, float] | Mapping[LineKey, float]
"""Excess of slack lines, m, by the line's name or its index in the robot's lines, from 0."""

MAX_SETS = 2000  # largest number of sets of taut lines that are evaluated
SAMPLES = 32  # excesses over zero at which a set of taut lines is evaluated
FIRST_SAMPLE = 1e-4  # m; the smallest of them
ANGLES = 100  # excesses at which an angle is evaluated


def excess_lengths(equilibrium: Equilibrium) -> Array:
    """Return the excess of each line, m: (m,), or (N, m) of a batch. Negative if it is stretched more than it sags.

    NaN where there is no answer or no tangent, as the platform point is inside the sheave.
    """
    rows = equilibrium[None] if equilibrium.single else equilibrium
    excess = rows.lengths - taut_lengths(rows.packed, rows.pose)
    return np.asarray(excess[0] if equilibrium.single else excess)


def solve_with_slack(
    robot: Robot | Model,
    poses: ArrayLike,
    excess: Excess,
    *,
    cable: CableLaw | str | None = None,
    sheave: SheaveLaw | str | None = None,
    tension_limits: tuple[float, float] | None = None,
) -> Equilibrium:
    """Solve the inverse problem at *poses*, (n,) or (N, n) in m and rad, with *excess*, m, in some lines.

    *excess* maps slack lines, by name or index from 0, to their excess >= 0. They hang at the pose at their given
    length; the others are taut, with least-norm tensions within the limits (n taut lines leave no choice). In the
    answer's model the lowest tension limit of a slack line is 0; its highest tension and breaking load stay. Statuses
    are those of the inverse problem; the stability of a rigid body includes all lines. Lines on the drum of a slack one
    have the lengths that it gives them; where these are too short for slack, their limits hold.

    Massless slack lines carry nothing; on a lever they carry its weight while that straightens them. Raises
    `InputError` for a line that does not exist or is named twice, or whose drum another one turns, an excess that is
    negative or not finite, and where fewer winches of taut lines than degrees of freedom would remain.
    """
    model = Model.of(robot, cable=cable, sheave=sheave, tension_limits=tension_limits)
    require(model, Capability.SLACK)
    by = _checked(model, excess)
    pose, single = as_poses(model, poses, "pose")
    batch = _solve(model, pose, list(by), np.tile(np.array(list(by.values())), (len(pose), 1)))
    return batch[0] if single else batch


def _checked(model: Model, excess: Excess) -> dict[int, float]:
    """The excess by index of the line. Raises `InputError`."""
    by: dict[int, float] = {}
    for line, value in excess.items():
        index = winch_line(model, line)
        name = model.robot.lines[index].name
        if index in by:
            raise InputError(f"line {name!r} is named twice among the slack lines")
        try:
            by[index] = float(value)
        except (TypeError, ValueError):
            raise InputError(f"excess of line {name!r} = {value!r}: a number is expected, m") from None
        if not 0.0 <= by[index] < math.inf:
            raise InputError(f"excess of line {name!r} = {by[index]:g} m: a slack line's is finite and not negative")
        mates = [mate for one, mate, _ in drum_mates(model.robot) if one == index and mate in by]
        if mates:
            other = model.robot.lines[mates[0]].name
            raise InputError(f"excess of line {name!r}: its drum is that of {other!r}, which decides it: leave it out")
    _check_taut(model, len(by))
    return by


def _check_taut(model: Model, slack: int) -> None:
    """Raise `InputError` if too few taut lines remain besides the *slack* ones."""
    m, n = model.winches, model.freedoms
    if m - slack < n:
        spare = f"at most {m - n} can be" if m > n else "none can be"
        what = "winches" if model.robot.sharing else "taut ones"
        raise InputError(f"slack lines: {n} {what} hold {model.robot.name!r}, which has {m}: {spare} slack")


def _solve(model: Model, pose: Array, named: list[int], by: Array) -> Equilibrium:
    """A batch at *pose* (N, n), with the lines *named*, one of a drum, at their excess *by* (N, k), m."""
    hosts, senses, offsets = drums(model.robot)
    slack = np.flatnonzero(np.isin(hosts, hosts[named])).tolist()
    rows, loose = len(pose), _loosened(model, slack)
    states, lengths = blank_states(rows, model.m), np.zeros((rows, model.m))
    wrenches, hung = np.zeros((rows, model.n)), np.zeros(rows, dtype=np.int64)
    taut = taut_lengths(loose.rows(), pose)
    for i, more in zip(named, by.T, strict=True):
        turned = senses[i] * (taut[:, i] + more - offsets[i])
        mates = np.flatnonzero(hosts == hosts[i])
        lengths[:, mates] = offsets[mates] + senses[mates] * turned[:, None]
        lengths[:, i] = taut[:, i] + more
    least = np.where(lengths < taut, model.lines.tension_min, 0.0)
    batches.slack_rows(loose.rows(), pose, lengths, np.array(slack, dtype=np.int64), states, wrenches, hung)
    codes, violations = _hold(loose, pose, slack, wrenches, states, lengths)
    codes = np.where(hung == 0, codes, hung)
    states[(hung != 0) | np.isnan(states).any(axis=(1, 2))] = np.nan
    lengths[np.isnan(states).any(axis=(1, 2))] = np.nan
    violations[hung != 0] = 0.0
    _judge(loose, pose, states, lengths, slack, least, codes, violations)
    return Equilibrium(loose, loose.rows(), pose, lengths, states, codes, violations, np.zeros(rows, dtype=np.int64))


def _loosened(model: Model, slack: list[int]) -> Model:
    """The model without a lowest tension limit for its *slack* lines."""
    lines = []
    for i, line in enumerate(model.robot.lines):
        low, high = model.tension_limits or line.tension_limits
        lines.append(line.model_copy(update={"tension_limits": (0.0 if i in slack else low, high)}))
    return Model(model.robot.model_copy(update={"lines": tuple(lines)}), model.fidelity)


def _hold(
    model: Model, pose: Array, slack: list[int], wrenches: Array, states: Array, lengths: Array
) -> tuple[NDArray[np.int64], Array]:
    """Solve the taut lines under the *wrenches* (N, n) of the slack ones: codes and violations (N,).

    Writes the taut lines' part of *states* and *lengths*.
    """
    rows, packed = len(pose), model.packed
    taut = [i for i in range(model.m) if i not in slack]
    lines = np.repeat(packed.lines[None, taut], rows, axis=0)
    platform = PlatformNumbers(np.repeat(packed.platform[None], rows, axis=0))
    platform.wrench[:, : model.n] += wrenches
    found, paid = blank_states(rows, len(taut)), np.zeros((rows, len(taut)))
    codes, violations = np.zeros(rows, dtype=np.int64), np.zeros(rows)
    own = packed._replace(lines=lines, platform=platform.array)
    table = shares(model.robot)
    table = table[np.isin(table[:, LINE], taut)]
    if len(table):
        table[:, [LINE, OTHER]] = np.searchsorted(taut, table[:, [LINE, OTHER]])
        run(batches.shared_rows, rows, own, table, pose.copy(), found, paid, codes, violations, False)
    else:
        run(batches.inverse_rows, rows, own, pose, found, paid, codes, violations, False)
    states[:, taut], lengths[:, taut] = found, paid
    return codes, violations


def _judge(
    model: Model,
    pose: Array,
    states: Array,
    lengths: Array,
    slack: list[int],
    least: Array,
    codes: NDArray[np.int64],
    violations: Array,
) -> None:
    """Update *codes* and *violations* for the whole machine where the taut lines hold it: limits and stability.

    *least* (N, m): lowest tensions, N.
    """
    packed, most = model.packed, model.lines.tension_max
    work = inverse_workspace(packed)
    for j in np.flatnonzero(np.isin(codes, (Code.OK, Code.UNSTABLE, Code.SINGULAR))):
        if np.isnan(states[j]).any():
            continue
        evaluate(packed, lengths[j], pose[j], states[j], work.base)
        codes[j] = judge(packed, states[j], work.base.planes, work.base.spatial)
        if codes[j] != Code.OK:
            continue
        ends = [extremes(packed.lines[i], states[j, i]) for i in slack]
        over = [max(least[j, i] - low, high - most[i]) for i, (low, high) in zip(slack, ends, strict=True)]
        if max(over, default=0.0) > 0.0:
            codes[j], violations[j] = Code.INFEASIBLE, max(over)
        elif packed.freedoms == 6:
            codes[j] = stays(packed, pose[j], states[j], work)


@dataclass(frozen=True, eq=False, repr=False)
class SlackSet(Result):
    """A set of taut lines that hold a pose alone, and the range of the excess of the others.

    The others have one common excess, from `excess_low` to `excess_high` (m); `equilibrium` is the one at `excess_low`.
    `ended_by` is what ends the range: ``limits`` (the taut lines exceed theirs), ``floor`` (a slack line's free span
    would hang below the frame or, where that is lower, the platform points), ``sheave`` (a slack line would pull so
    little that its dead span slips back over the sheave), ``capacity`` (of a winch) or ``nothing``.
    """

    FIGURES: ClassVar = (
        Figure("taut", "", "Lines that hold the pose."),
        Figure("slack", "", "Lines that are longer than taut."),
        Figure("status", "", "Status of the pose at the min excess.", "equilibrium.status.word"),
        Figure("excess_low", "m", "Min excess of the slack lines.", name="min excess", shown="m"),
        Figure("excess_high", "m", "Max excess; null where nothing ends the range.", name="max excess", shown="m"),
        Figure("ended_by", "", "What ends the range of the excess."),
        Figure("tensions", "N", "Tensions of all lines at the sheaves, at the min excess.", shown="N"),
        Figure("lengths", "m", "Unstrained lengths at the min excess.", "equilibrium.lengths", detail=True),
    )
    HEADLINES: ClassVar = ("slack", "excess_low", "excess_high", "ended_by")

    taut: tuple[str, ...]
    slack: tuple[str, ...]
    equilibrium: Equilibrium
    excess_low: float
    excess_high: float
    ended_by: str

    @property
    def tensions(self) -> Array:
        """Tension (m,) at each sheave at `excess_low`, N."""
        return self.equilibrium.tensions


def slack_sets(
    robot: Robot | Model,
    pose: ArrayLike,
    *,
    cable: CableLaw | str | None = None,
    sheave: SheaveLaw | str | None = None,
    tension_limits: tuple[float, float] | None = None,
) -> tuple[SlackSet, ...]:
    """Find every set of lines that holds *pose* (n,), m and rad, while all others are slack.

    A set has the lines of as many winches as the platform has degrees of freedom, and all with a counterweight. The
    others have one common excess; of several lines on one drum it is the smallest, and drums whose lines wind against
    each other are in every set, as one of them is taut. A set is admissible if some excess leaves all taut lines within
    their limits. Its range starts at the smallest such excess and continues while the status is OK. It is found by 33
    samples, at 0 and logarithmically spaced up to the limit by floor or capacity, and bisection: features between
    samples and a second range are missed. In the order of the lines. Raises `InputError` if no line can be slack, if
    *pose* is not one pose, or for over 2000 sets.
    """
    model = Model.of(robot, cable=cable, sheave=sheave, tension_limits=tension_limits)
    require(model, Capability.SLACK_SETS)
    _check_taut(model, 1)
    hosts, senses, _ = drums(model.robot)
    winched, n = np.unique(hosts[model.lines.counterweight == 0.0]), model.freedoms
    count = math.comb(len(winched), n)
    if count > MAX_SETS:
        raise InputError(f"{count} sets of {n} of {len(winched)} lines are too many; at most {MAX_SETS} are allowed")
    at = one_pose(model, pose)
    free = [host for host in winched.tolist() if (senses[hosts == host] > 0.0).all()]
    found = (_slack_set(model, at, list(slack)) for slack in combinations(free, len(winched) - n))
    return tuple(each for each in found if each is not None)


def _slack_set(model: Model, pose: Array, turned: list[int]) -> SlackSet | None:
    """The range of one candidate, whose drums of the hosts *turned* are let out, or None where none is admissible."""
    hosts, _, offsets = drums(model.robot)
    slack = np.flatnonzero(np.isin(hosts, turned)).tolist()
    needed = taut_lengths(model.rows(), pose)[0] - offsets
    more = np.array([needed[hosts == host].max() - needed[host] for host in turned])
    beyond = {i: needed[hosts == hosts[i]].max() - needed[i] for i in slack}

    def solved(excess: Array) -> Equilibrium:
        return _solve(model, np.repeat(pose, len(excess), axis=0), turned, excess[:, None] + more)

    def fine(excess: float) -> bool:
        return bool(solved(np.array([excess])).ok[0])

    ends = [(LoneLine(model, pose, i).max_excess(), beyond[i]) for i in slack]
    limit, ended_by = min(((most - less, word) for (most, word), less in ends), key=lambda end: end[0])
    if not limit > 0.0:
        return None
    top = min(limit, 1e3)
    samples = np.append(0.0, np.geomspace(min(FIRST_SAMPLE, 0.5 * top), top, SAMPLES))
    good = solved(samples).ok
    if not good.any():
        return None
    first = int(np.argmax(good))
    last = first + int(np.argmin(np.append(good[first:], False))) - 1
    low, high = samples[first], limit
    if first > 0:
        low = last_fine(fine, samples[first], samples[first - 1])
    if last < SAMPLES:
        high, ended_by = last_fine(fine, samples[last], samples[last + 1]), "limits"
    names = [line.name for line in model.robot.lines]
    taut = tuple(name for i, name in enumerate(names) if i not in slack)
    loose = tuple(names[i] for i in slack)
    return SlackSet(taut, loose, solved(np.array([low]))[0], float(low), float(high), ended_by)


def tangent_angle(equilibrium: Equilibrium, line: LineKey, distance: float) -> Array:
    """Return the angle of a line's tangent above the horizontal, rad, *distance* from its platform point: () or (N,).

    *distance*, m, is measured along the unstrained cable. The tangent points from the sheave to the platform in the
    line's plane: a line that descends to its platform point has a negative angle there, one that sags below it a
    positive one. NaN where there is no answer, or where a massless line is slack and has no shape. Raises `InputError`
    for a line that does not exist, and a distance that is negative or longer than the free span.
    """
    i = line_index(equilibrium.model, line)
    states = LineStates(equilibrium.states[..., i, :])
    free, weight = states.free_length, equilibrium.lines.weight[..., i]
    _check_distance(equilibrium.model, i, distance, float(np.nanmin(free)) if np.isfinite(free).any() else math.inf)
    angle = _angle(states, weight, distance)
    return np.where((weight == 0.0) & (equilibrium.tensions[..., i] == 0.0), np.nan, angle)


def _check_distance(model: Model, i: int, distance: float, limit: float) -> None:
    if not 0.0 <= distance <= limit:
        name = model.robot.lines[i].name
        raise InputError(f"distance = {distance:g} m: 0 to {limit:g} m along line {name!r} is expected")


def _angle(states: LineStates, weight: Array | float, distance: float) -> Array:
    """Angle (...) of the tangent of free spans with *states*, rad; see `tangent_angle`."""
    tension, phi = states.tension, states.free_angle
    end = tension * np.sin(phi) + weight * (states.free_length - distance)
    return np.asarray(np.arctan2(end, tension * np.cos(phi)))


def angle_from_excess(model: Model, pose: ArrayLike, line: LineKey, distance: float, excess: ArrayLike) -> Array:
    """Return the angle of `tangent_angle`, rad, for a line that hangs at *pose* (n,) with *excess*, () or (k,) in m.

    The other lines, and whether the platform is held, are ignored. NaN where the line cannot hang so. Raises
    `InputError` as `excess_from_angle` does, except for the angle.
    """
    lone = _hanging(model, pose, line, distance)
    given, _ = as_rows(np.ravel(excess)[:, None], 1, "excess", "m")
    if not (given >= 0.0).all():
        raise InputError(f"excess: a slack line's is not negative; got {given.min():g} m")
    angles = [_hung_angle(lone, distance, value) for value in given[:, 0]]
    return np.array(angles).reshape(np.shape(excess))


def excess_from_angle(model: Model, pose: ArrayLike, line: LineKey, distance: float, angle: float) -> float:
    """Return the excess, m, of a line whose tangent at *distance* (m) from its platform point has *angle* (rad).

    The pose is (n,); angle and distance are as for `tangent_angle`, for instance from an inclinometer near the
    platform, where the angle grows with the excess. Where it decreases again, far from the platform on a steep and very
    slack line, the answer is the smaller excess. Raises `InputError` for massless cables, which have no shape, a line
    or pose that does not exist, a distance over half the taut free span, and an angle that no excess gives.
    """
    lone = _hanging(model, pose, line, distance)
    if not math.isfinite(angle):
        raise InputError(f"angle = {angle}: a finite number is expected, rad")
    name = model.robot.lines[lone.index].name
    from scipy.optimize import brentq  # takes a third of a second to load, and few ask for an angle

    limit, _ended_by = lone.max_excess()

    def beyond(excess: float) -> float:
        return _hung_angle(lone, distance, excess) - angle

    excess = np.append(0.0, np.geomspace(1e-6, max(limit, 2e-6), ANGLES))
    found = np.array([beyond(each) for each in excess])
    last = int(np.argmin(np.append(np.diff(found) > 0.0, False)))
    if not found[0] <= 0.0 <= found[last]:
        bounds = f"{found[0] + angle:.4f} to {found[last] + angle:.4f} rad"
        raise InputError(
            f"angle = {angle:g} rad: must be {bounds}, the angles that line {name!r} can have with an "
            f"excess of 0 m or more"
        )
    over = max(1, int(np.argmax(found >= 0.0)))
    return float(brentq(beyond, excess[over - 1], excess[over], xtol=1e-13, rtol=1e-13))


def _hanging(model: Model, pose: ArrayLike, line: LineKey, distance: float) -> LoneLine:
    """The line at *pose* (n,), where it has a shape. Raises `InputError`."""
    i = winch_line(model, line)
    name = model.robot.lines[i].name
    if model.lines.weight[i] == 0.0:
        raise InputError(
            f"cable = {model.fidelity.cable.value}: the shape of a slack line needs the cable's weight; use cable = "
            f"catenary"
        )
    lone = LoneLine(model, one_pose(model, pose), i)
    if math.isnan(lone.taut) or lone.hung(0.0)[0] == Code.UNDER_EXIT:
        raise InputError(
            f"pose: line {name!r} has no plane or no tangent there: under its exit point, or in its sheave"
        )
    _check_distance(model, i, distance, 0.5 * lone.taut_span)
    return lone


def _hung_angle(lone: LoneLine, distance: float, excess: float) -> float:
    code, y = lone.hung(excess)
    return float(_angle(LineStates(y), lone.numbers.weight, distance)) if code == Code.OK else math.nan


def let_out(
    robot: Robot | Model,
    lengths: ArrayLike,
    line: LineKey,
    by: ArrayLike,
    *,
    cable: CableLaw | str | None = None,
    sheave: SheaveLaw | str | None = None,
) -> Equilibrium:
    """Solve the forward problem while one *line* is *by* (k,) m longer than its length in *lengths* (m,), m.

    The others keep their lengths, except those on the same drum, which turns. The k rows of the batch are a path: the
    first is found without a guess, each other from the one before. Raises `InputError` as `forward` does and if *by* is
    empty, `AnswerError` if the first has no answer.
    """
    model = Model.of(robot, cable=cable, sheave=sheave)
    i = winch_line(model, line)
    paid, single = as_lengths(model, lengths)
    more, _ = as_rows(np.atleast_1d(np.asarray(by))[:, None], 1, "let out by", "m")
    if not single or len(more) == 0:
        what = "let out by: at least one number" if single else "lengths: one row"
        raise InputError(f"{what} is expected; got {len(more) if single else len(paid)}")
    rows = np.repeat(paid, len(more), axis=0)
    for mate, along in [(i, 1.0), *((other, along) for one, other, along in drum_mates(model.robot) if one == i)]:
        rows[:, mate] += along * more[:, 0]
    begin = solve_forward(model, rows[0]).checked()
    return solve_forward(model, rows, guess=np.repeat(begin.pose[None], len(rows), axis=0), path=True)
