"""Batches of forward, inverse, linearise and certify problems: rows *first* to *last* of one, a code per row.

They hold no lock of Python's, so that several threads can share a batch. A row depends at most on those before it in
its chunk, so that results depend neither on the number of threads nor on the rows that each of them computed.
"""

from math import log

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.certificates.krawczyk import certify, levers
from cablewright.kernels.certificates.system_enclosure import certificate_pool, unfold
from cablewright.kernels.dense_systems import copy, copy_rows
from cablewright.kernels.layout import (
    CHUNK,
    FREE,
    NOT_CONVERGED,
    NOT_FINITE,
    OK,
    SINGULAR,
    STATE,
    TAU,
    WEIGHT,
    robot_of,
)
from cablewright.kernels.shared_winches.quadratic_program import shared_workspace
from cablewright.kernels.shared_winches.solve import solve_shared
from cablewright.kernels.statics.equilibrium import evaluate, workspace
from cablewright.kernels.statics.forward import solve_cold, solve_near, solve_warm
from cablewright.kernels.statics.inverse import solve_inverse
from cablewright.kernels.statics.inverse_scratch import inverse_workspace
from cablewright.kernels.statics.inverted_lever_starts import start_at
from cablewright.kernels.statics.line.counterweight import read_lengths
from cablewright.kernels.statics.line.interface import add_line_pull, draw_line, find_line, place_lines, taut_line
from cablewright.kernels.statics.line.upright import extremes, is_slack, lengths_of
from cablewright.kernels.statics.line.vertical_plane import place
from cablewright.kernels.statics.linearise import linearise, tension_changes
from cablewright.kernels.statics.platform import between, may_be_another, place_platform, shift_pose
from cablewright.kernels.statics.underactuated import solve_hanging

DRAWN = 1e3  # of its own weight: tension at which a line out of the plane is drawn straight
NO_SOLUTION = (NOT_CONVERGED, SINGULAR, NOT_FINITE)
COLD, NEAR, WARM, CHAIN = 0, 1, 2, 3  # what a forward solve starts from; see `forward_rows`


@jit(allocates=True)
def forward_rows(packed, lengths, poses, states, codes, iterations, residuals, start, first, last):
    """Solve a batch of forward problems in place.

    *packed* has one row or N; lengths (N, m), m. poses (N, n) and states (N, m, 6) hold the guesses that *start*
    selects (COLD: none, NEAR: poses, WARM: poses and states, CHAIN: poses and the row before) and receive the
    solutions; codes, iterations and residuals (N,), m, are written.
    """
    work = workspace(robot_of(packed, first))
    guess, shift = np.zeros(packed.freedoms), np.zeros(packed.freedoms)
    for j in range(first, last):
        own = robot_of(packed, j)
        if start == COLD:
            result = solve_cold(own, lengths[j], poses[j], states[j], work)
        elif start == WARM:
            result = solve_warm(own, lengths[j], poses[j], states[j], work)
        elif start == NEAR or j == first or j % CHUNK == 0 or codes[j - 1] != OK:
            copy(poses[j], guess)
            result = solve_near(own, lengths[j], poses[j], states[j], work)
            between(guess, poses[j], shift)
        else:
            copy(poses[j], guess)
            result = _follow(own, lengths[j], poses[j], states[j], states[j - 1], shift, work)
            between(guess, poses[j], shift)
        codes[j], iterations[j], residuals[j] = result
        if codes[j] in NO_SOLUTION:
            poses[j], states[j] = np.nan, np.nan


@jit(allocates=True)
def _follow(packed, lengths, pose, states, neighbour, shift, work):
    """Solve near *pose* plus the neighbour's *shift*, from the neighbour's line states; else from the pose alone.

    A rigid body can have several equilibria, and line states of another pose may lead to one far away.
    """
    begin = pose.copy()
    shift_pose(pose, shift)
    expected, moved = pose.copy(), np.zeros(packed.freedoms)
    copy_rows(neighbour, states)
    result = solve_warm(packed, lengths, pose, states, work)
    between(expected, pose, moved)
    if result[0] != OK or may_be_another(moved):
        copy(begin, pose)
        result = solve_near(packed, lengths, pose, states, work)
    return result


@jit(allocates=True)
def inverse_rows(packed, poses, states, lengths, codes, violations, chain, first, last):
    """Solve inverse problems: poses (N, n) to states (N, m, 6), lengths (N, m), codes and violations (N,).

    *chain*: neighbouring rows are neighbours on a path, so that each row starts from the one before.
    """
    work = inverse_workspace(robot_of(packed, first))
    for j in range(first, last):
        own = robot_of(packed, j)
        known = chain and j > first and j % CHUNK != 0 and codes[j - 1] == OK
        if known:
            copy_rows(states[j - 1], states[j])
        codes[j], violations[j] = solve_inverse(own, poses[j], states[j], work, known)
        if known and codes[j] != OK:
            codes[j], violations[j] = solve_inverse(own, poses[j], states[j], work, False)
        lengths_of(own, states[j], lengths[j])


@jit(allocates=True)
def read_length_rows(packed, states, lengths):
    """Write to lengths (N, m), m, those of lines with a counterweight, which follow from states (N, m, 6)."""
    for j in range(lengths.shape[0]):
        read_lengths(robot_of(packed, j), states[j], lengths[j])


@jit(allocates=True)
def hanging_rows(packed, poses, states, lengths, codes, violations, first, last):
    """Solve rows as `inverse_rows` with fewer lines than degrees of freedom: NaN entries of poses are written."""
    work = inverse_workspace(robot_of(packed, first))
    for j in range(first, last):
        own = robot_of(packed, j)
        codes[j], violations[j] = solve_hanging(own, poses[j], states[j], work)
        lengths_of(own, states[j], lengths[j])


@jit(allocates=True)
def shared_rows(packed, shares, poses, states, lengths, codes, violations, chain, first, last):
    """Solve rows as `inverse_rows`, with lines that share drums: `shared_winches.quadratic_program`.

    Free entries of a pose are NaN on entry and are written.
    """
    work, own = inverse_workspace(robot_of(packed, first)), shared_workspace(robot_of(packed, first), shares)
    for j in range(first, last):
        robot = robot_of(packed, j)
        known = chain and j > first and j % CHUNK != 0 and codes[j - 1] == OK
        copy(poses[j], own.given)
        if known:
            copy_rows(states[j - 1], states[j])
            for k in range(poses.shape[1]):
                if np.isnan(own.given[k]):
                    poses[j, k] = poses[j - 1, k]
        codes[j], violations[j] = solve_shared(robot, shares, poses[j], states[j], work, own, known)
        if known and codes[j] != OK:
            codes[j], violations[j] = solve_shared(robot, shares, poses[j], states[j], work, own, False)
        lengths_of(robot, states[j], lengths[j])


@jit(allocates=True)
def straight_rows(packed, poses, tension, lengths):
    """Write the lengths (N, m) of straight lines at *poses* (N, n); *tension* (N) only places levers.

    NaN inside a sheave.
    """
    work, y = workspace(robot_of(packed, 0)), np.zeros(STATE)
    for j in range(poses.shape[0]):
        own = robot_of(packed, j)
        place_platform(poses[j], work.rotation)
        for i in range(own.lines.shape[0]):
            place(own.lines, i, poses[j], work.rotation, work.arms[i], work.planes[i])
            drawn = draw_line(own.lines[i], y, poses[j], i, tension, work, work.spatial)
            lengths[j, i] = drawn if drawn >= 0.0 else np.nan


@jit(allocates=True)
def taut_rows(packed, poses, lengths):
    """Write the lengths (N, m) of straight lines, levers without weight, at *poses* (N, n); NaN inside a sheave."""
    work, y = workspace(robot_of(packed, 0)), np.zeros(STATE)
    for j in range(poses.shape[0]):
        own = robot_of(packed, j)
        place_lines(own, poses[j], work)
        for i in range(own.lines.shape[0]):
            drawn = taut_line(own.lines[i], y, poses[j], i, work, work.spatial)
            lengths[j, i] = drawn if drawn >= 0.0 else np.nan


@jit(allocates=True)
def shape_rows(packed, poses, lengths, states):
    """Write states (N, m, 6) of lines of *lengths* (N, m), m, at *poses* (N, n), each without the others.

    A line of unknown length, or one too short, is straight; NaN where a pose is not known, or inside a sheave.
    """
    work = workspace(robot_of(packed, 0))
    for j in range(poses.shape[0]):
        own, known = robot_of(packed, j), np.isfinite(poses[j]).all()
        if known:
            place_lines(own, poses[j], work)
        for i in range(own.lines.shape[0]):
            row, y, length, spatial = own.lines[i], states[j, i], lengths[j, i], work.spatial
            if known and np.isfinite(length) and find_line(row, y, length, poses[j], i, work, spatial) == OK:
                continue
            if known and taut_line(row, y, poses[j], i, work, spatial) >= 0.0:
                y[TAU] = max(y[TAU], log(DRAWN * row[WEIGHT] * y[FREE] + 1e-300))
            else:
                y[:] = np.nan


@jit(allocates=True)
def slack_rows(packed, poses, lengths, slack, states, wrenches, codes):
    """Hang the *slack* lines (k,) of *lengths* (N, m), m, at *poses* (N, n): write their states (N, m, 6).

    Adds the wrench of each on the platform to *wrenches* (N, n); *codes* (N,): of the first line without a shape.
    """
    work = workspace(robot_of(packed, 0))
    for j in range(poses.shape[0]):
        own = robot_of(packed, j)
        place_lines(own, poses[j], work)
        for i in slack:
            row, y = own.lines[i], states[j, i]
            code = find_line(row, y, lengths[j, i], poses[j], i, work, work.spatial)
            if code == OK and extremes(row, y)[0] < 0.0:  # of a straight dead span, which would have to push
                code = NOT_CONVERGED
            if codes[j] == OK:
                codes[j] = code
            if code == OK and not is_slack(row, y):
                add_line_pull(row, y, i, work, work.spatial, wrenches[j])


@jit(allocates=True)
def linearise_rows(packed, lengths, poses, states, stiffness, motion, codes, first, last):
    """Tangent stiffness (N, n, n) and motion (N, n, m, 10) at solved equilibria; see `linearise.linearise`."""
    work = workspace(robot_of(packed, first))
    for j in range(first, last):
        codes[j] = linearise(robot_of(packed, j), lengths[j], poses[j], states[j], work, stiffness[j], motion[j])


@jit(allocates=True)
def tension_rows(packed, lengths, poses, states, own, by_pose, codes):
    """Derivatives (N, m, 10) and (N, m, n) of tensions at solved equilibria; see `linearise.tension_changes`."""
    work = workspace(robot_of(packed, 0))
    for j in range(lengths.shape[0]):
        codes[j] = tension_changes(robot_of(packed, j), lengths[j], poses[j], states[j], work, own[j], by_pose[j])


@jit(allocates=True)
def start_rows(packed, lengths, poses, heads, pull, states, started):
    """Guess line states (N, m, 6) at *poses* with the levers marked in *heads* (N, m) inverted; see `start_at`."""
    work = workspace(robot_of(packed, 0))
    for j in range(lengths.shape[0]):
        started[j] = start_at(robot_of(packed, j), lengths[j], poses[j], heads[j], pull, states[j], work)


@jit(allocates=True)
def certify_rows(packed, lengths, poses, states, tolerance, codes, bounds, boxes, signs, first, last):
    """Certify solved rows: codes and lever signs (N,), bound and box of the pose (N, n), m and rad.

    *tolerance* (m, rad) is the largest bound of the pose that is certified. See `krawczyk.certify`.
    """
    own = robot_of(packed, first)
    work = unfold(own, certificate_pool(own))
    at = work.offsets[-1]
    for j in range(first, last):
        own = robot_of(packed, j)
        codes[j] = certify(own, lengths[j], poses[j], states[j], tolerance, work)
        signs[j] = levers(own, work)
        copy(work.bound[at:], bounds[j])
        copy(work.radius[at:], boxes[j])


@jit(allocates=True)
def wrench_rows(packed, lengths, poses, states, wrenches):
    """Write the wrench (N, n), N and N m, of lines and loads on the platform in each row.

    *packed* is to have no plane: otherwise the part that it carries is left out.
    """
    work = workspace(robot_of(packed, 0))
    for j in range(states.shape[0]):
        evaluate(robot_of(packed, j), lengths[j], poses[j], states[j], work)
        wrenches[j] = work.trial


@jit(allocates=True)
def examine(packed, lengths, poses, states, residuals, unbalanced, low, high):
    """Write the residuals of each row's equations and the extremes of tension along its lines.

    Written are the largest geometric residual (m) and unbalanced force (N) of each row (N,), and the smallest and
    largest tension along each line, N: low and high (N, m).
    """
    work = workspace(robot_of(packed, 0))
    for j in range(states.shape[0]):
        own = robot_of(packed, j)
        residuals[j], unbalanced[j], _ = evaluate(own, lengths[j], poses[j], states[j], work)
        for i in range(states.shape[1]):
            low[j, i], high[j, i] = extremes(own.lines[i], states[j, i])
