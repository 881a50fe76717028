"""Batches of forward, inverse, linearisation and certificate problems: each function solves rows *first* to *last*.

Each row gets a status code. The functions release Python's global lock, so that several threads can share a batch. A
row depends at most on those before it in its chunk, so that results depend neither on the number of threads nor on
their division of the rows.
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
    """Solve a batch of N forward problems, from cable lengths to poses, in place.

    *packed* has one row or N; lengths (N, m), m. poses (N, n) and states (N, m, 6) hold the guesses that *start*
    selects (COLD: none, NEAR: poses, WARM: poses and states, CHAIN: poses and the row before) and receive the
    solutions. Written: codes, iterations and residuals (N,), m.
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
    """Solve a batch of N inverse problems, from poses (N, n) to states (N, m, 6) and lengths (N, m) of the lines.

    Writes also codes and the largest violations of a tension limit, N, (N,). *chain*: neighbouring rows are neighbours
    on a path, so that each row starts from the solution of the one before.
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
    """Write the lengths (N, m), m, of lines with a counterweight in place of a winch, from states (N, m, 6)."""
    for j in range(lengths.shape[0]):
        read_lengths(robot_of(packed, j), states[j], lengths[j])


@jit(allocates=True)
def hanging_rows(packed, poses, states, lengths, codes, violations, first, last):
    """Solve inverse problems of robots with fewer lines than degrees of freedom, see `inverse_rows`.

    Coordinates of a pose that are NaN on entry are free: the solved values are written there.
    """
    work = inverse_workspace(robot_of(packed, first))
    for j in range(first, last):
        own = robot_of(packed, j)
        codes[j], violations[j] = solve_hanging(own, poses[j], states[j], work)
        lengths_of(own, states[j], lengths[j])


@jit(allocates=True)
def shared_rows(packed, shares, poses, states, lengths, codes, violations, chain, first, last):
    """Solve inverse problems of robots with several lines on one winch drum, see `inverse_rows`.

    The table (s, 4) says which lines share a drum, see `shared_winches.program`. Coordinates of a pose that are NaN on
    entry are free: the solved values are written there.
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
    """Write the lengths (N, m), m, of straight lines to a platform at *poses* (N, n).

    *tension* (N) only decides the angle of levers. NaN where a platform point is inside a sheave.
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
    """Write lengths (N, m), m, of straight lines with weightless levers at *poses* (N, n); NaN inside a sheave."""
    work, y = workspace(robot_of(packed, 0)), np.zeros(STATE)
    for j in range(poses.shape[0]):
        own = robot_of(packed, j)
        place_lines(own, poses[j], work)
        for i in range(own.lines.shape[0]):
            drawn = taut_line(own.lines[i], y, poses[j], i, work, work.spatial)
            lengths[j, i] = drawn if drawn >= 0.0 else np.nan


@jit(allocates=True)
def shape_rows(packed, poses, lengths, states):
    """Compute the shape of each line, taut or hanging, from its length alone, at given *poses* (N, n).

    Writes the states (N, m, 6) of lines of *lengths* (N, m), m; balance of the platform is not required. A line of
    unknown length, or one too short, is straight; NaN where a pose is not known, or inside a sheave.
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
    """Compute the hanging shapes of the *slack* lines (k,) of *lengths* (N, m), m, at *poses* (N, n).

    Writes their states (N, m, 6) and adds the wrench of each on the platform to *wrenches* (N, n). *codes* (N,): that
    of the first line without a shape.
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
    """Write tangent stiffnesses (N, n, n) and motions of the platform per line parameter (N, n, m, 10) at equilibria.

    See `linearise.linearise`.
    """
    work = workspace(robot_of(packed, first))
    for j in range(first, last):
        codes[j] = linearise(robot_of(packed, j), lengths[j], poses[j], states[j], work, stiffness[j], motion[j])


@jit(allocates=True)
def tension_rows(packed, lengths, poses, states, own, by_pose, codes):
    """Write derivatives of the tensions at equilibria, by line parameters (N, m, 10) and by pose (N, m, n).

    See `linearise.tension_changes`.
    """
    work = workspace(robot_of(packed, 0))
    for j in range(lengths.shape[0]):
        codes[j] = tension_changes(robot_of(packed, j), lengths[j], poses[j], states[j], work, own[j], by_pose[j])


@jit(allocates=True)
def start_rows(packed, lengths, poses, heads, pull, states, started):
    """Guess line states (N, m, 6) at *poses* (N, n), with the levers marked in *heads* (N, m) upside down.

    See `start_at`.
    """
    work = workspace(robot_of(packed, 0))
    for j in range(lengths.shape[0]):
        started[j] = start_at(robot_of(packed, j), lengths[j], poses[j], heads[j], pull, states[j], work)


@jit(allocates=True)
def certify_rows(packed, lengths, poses, states, tolerance, codes, bounds, boxes, signs, first, last):
    """Prove by interval arithmetic that one exact equilibrium is near each solved row.

    Writes codes and lever signs (N,), bound and box of the pose (N, n), m and rad. *tolerance* (m, rad) is the largest
    bound of the pose that is accepted. See `krawczyk.certify`.
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

    *packed* must have no plane that carries the platform: the part of the wrench that a plane carries would be left
    out.
    """
    work = workspace(robot_of(packed, 0))
    for j in range(states.shape[0]):
        evaluate(robot_of(packed, j), lengths[j], poses[j], states[j], work)
        wrenches[j] = work.trial


@jit(allocates=True)
def examine(packed, lengths, poses, states, residuals, unbalanced, low, high):
    """Write how well each solved row meets its equations, and the extreme tensions along its lines.

    Written are the largest geometric residual (m) and unbalanced force (N) of each row (N,), and the smallest and
    largest tension along each line, N: low and high (N, m).
    """
    work = workspace(robot_of(packed, 0))
    for j in range(states.shape[0]):
        own = robot_of(packed, j)
        residuals[j], unbalanced[j], _ = evaluate(own, lengths[j], poses[j], states[j], work)
        for i in range(states.shape[1]):
            low[j, i], high[j, i] = extremes(own.lines[i], states[j, i])
