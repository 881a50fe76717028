"""A guaranteed enclosure of the pose for all cable lengths within some error."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.progress import Progress
from cablewright.kernels.certificates import pose_hull as kernel
from cablewright.kernels.statics.line.upright import is_slack
from cablewright.models.statics import Equilibrium
from cablewright.solvers.certify import is_only_one
from cablewright.solvers.forward import solve_again
from cablewright.solvers.pose_box import PoseBox
from cablewright.solvers.tension import self_stresses

BUDGET = 20_000  # default limit on the number of leaves, parts of the lengths: some seconds
DEEPEST = 120  # largest number of halvings of one leaf
AT_ONCE = 250  # leaves between two progress reports
STEPS = 8  # lengths along each edge of the box of lengths that are solved first, as samples
MAX_LINES = 8  # largest number of lines for which all edges are sampled
SAMPLES = 2000  # number of samples with more lines
SPARE = 0.8  # share of the tolerance that is used, as sampled extremes may fall short of the true ones
OVERLAP = 1e-9  # overlap of neighbouring slabs, as a share of the whole width

REASONS = {
    kernel.COVERED: "the pose is in the box for all lengths within the error",
    kernel.TOO_DEEP: f"no box: some lengths are not proved, though their part was halved {DEEPEST} times",
    kernel.NO_CENTRE: "no box: no equilibrium was found in the middle of some part of the lengths",
    kernel.UNGLUED: "no box: for some lengths within the error the equilibrium could not be followed",
    kernel.UNCERTIFIED: "no box: the equilibrium itself cannot be certified",
    kernel.HALF_TURN: "no box: rotation vectors come near half a turn",
}


def enclose_poses(
    equilibrium: Equilibrium,
    length_error: ArrayLike,
    *,
    budget: int = BUDGET,
    tolerance: float = 0.03,
    progress: Progress | None = None,
) -> PoseBox:
    """Enclose the poses of a single solved *equilibrium* whose lengths are known to *length_error*, m.

    *length_error*: one number for all lines, or one for each; a line with a counterweight has none. The box exceeds the
    sampled poses by at most *tolerance* of its width; if that takes more than *budget* leaves there is no box.
    *progress* is called with a stage, the used part of *budget*, and *budget*. Raises `InputError` for an error that is
    not positive or as large as a length, a batch, rigid cables, a budget or tolerance that is not positive;
    `AnswerError` for an unsolved equilibrium.
    """
    errors = _errors(equilibrium, length_error)
    if budget < 1:
        raise InputError(f"budget = {budget}: at least one leaf is expected")
    if not tolerance > 0.0:
        raise InputError(f"tolerance = {tolerance:g}: over 0 is expected, of the box's width")
    batch = equilibrium.packed
    packed = batch._replace(lines=batch.lines[0], platform=batch.platform[0])
    states = np.array(equilibrium.states, order="C")
    if any(is_slack(row, y) for row, y in zip(packed.lines, states, strict=True)):
        return _nothing(equilibrium, 0, 0, "no box: a massless line hangs slack and has no shape")
    low, high = equilibrium.lengths - errors, equilibrium.lengths + errors
    hung = equilibrium.lines.counterweight > 0.0  # of such a line the tension is given, not the length
    low = np.where(hung, equilibrium.lengths, np.nextafter(low, -np.inf))
    high = np.where(hung, equilibrium.lengths, np.nextafter(high, np.inf))
    directions = self_stresses(equilibrium)
    farthest = np.maximum(high - equilibrium.lengths, equilibrium.lengths - low)
    reach = np.abs(directions) @ farthest * (1.0 + 1e-6)
    none = np.full(equilibrium.model.n, np.inf)
    found = np.vstack([_sampled(equilibrium, low, high), none, -none])
    search = kernel.search_of(packed, equilibrium.lengths.copy(), directions, 2.0 * OVERLAP * reach, found)
    nodes = kernel.part_list(DEEPEST, len(search.cert.step), equilibrium.model.m, equilibrium.model.n, len(directions))
    tally = np.array([0, 0, 1])
    kernel.begin(nodes, low, high, reach, equilibrium.lengths.copy(), equilibrium.pose.copy(), states)
    code = kernel.GOING
    while code == kernel.GOING and tally[kernel.LEAVES] < budget:
        upto = min(budget, int(tally[kernel.LEAVES]) + AT_ONCE)
        code = kernel.explore(packed, nodes, tally, upto, SPARE * tolerance, search)
        if progress is not None:
            progress("leaves", int(tally[kernel.LEAVES]), budget)
    leaves, tests = int(tally[kernel.LEAVES]), int(tally[kernel.TESTS])
    if code != kernel.COVERED:
        done = 1.0 - float(nodes.share[: tally[kernel.DEPTH]].sum())
        spent = f"no box within the budget of {budget} leaves: {100.0 * done:.3g} % of the lengths are covered"
        return _nothing(equilibrium, leaves, tests, REASONS.get(code, spent))
    return PoseBox(found[2], found[3], True, is_only_one(equilibrium), leaves, tests, REASONS[code])


def _errors(equilibrium: Equilibrium, given: ArrayLike) -> Array:
    """The errors of the lengths (m,), m, checked. Raises `InputError`."""
    equilibrium.model.refuse_rigid()
    if not equilibrium.single:
        raise InputError(f"a single equilibrium is expected; got {len(equilibrium)} rows")
    equilibrium.checked()
    m = equilibrium.model.m
    try:
        errors = np.array(given, dtype=np.float64)
    except (TypeError, ValueError) as reason:
        raise InputError(f"length error: numbers in m are expected ({reason})") from None
    if errors.shape not in ((), (m,)):
        raise InputError(f"length error: one number is expected, or {m}, in m; got {errors.size}")
    errors = np.ascontiguousarray(np.broadcast_to(errors, (m,)))
    if not (errors > 0.0).all():
        raise InputError(f"length error: over 0 is expected, m; got {errors[~(errors > 0.0)][0]:g}")
    long = errors >= equilibrium.lengths
    if long.any():
        i = int(np.flatnonzero(long)[0])
        name, length = equilibrium.model.robot.lines[i].name, equilibrium.lengths[i]
        raise InputError(f"length error: {errors[i]:g} m is as large as the length of line {name}, {length:g} m")
    return errors


def _nothing(equilibrium: Equilibrium, leaves: int, tests: int, reason: str) -> PoseBox:
    none = np.full(equilibrium.model.n, np.nan)
    return PoseBox(none, none.copy(), False, is_only_one(equilibrium), leaves, tests, reason)


def _sampled(equilibrium: Equilibrium, low: Array, high: Array) -> Array:
    """Min and max pose (2, n) of the solved samples on the edges of the box from *low* to *high* lengths (m,)."""
    m = len(low)
    if m <= MAX_LINES:
        corners = np.array(list(product((0.0, 1.0), repeat=m)))
        steps = (np.arange(STEPS) + 0.5) / STEPS
        edges = [np.where(np.arange(m) == i, x, corners[corners[:, i] == 0.0]) for i in range(m) for x in steps]
        share = np.concatenate([corners, *edges])
    else:
        share = np.random.default_rng(0).integers(0, 2, (SAMPLES, m)).astype(float)
    rows = replace(equilibrium[None], code=np.zeros(1, dtype=np.int64))
    solved = solve_again(rows, equilibrium.packed, low + share * (high - low), len(share))
    poses = np.concatenate([equilibrium.pose[None], solved.pose[solved.code == 0]])
    return np.array([poses.min(axis=0), poses.max(axis=0)])
