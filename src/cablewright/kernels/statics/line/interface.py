"""Functions of one line that solvers call, whatever guides the cable: the only file of this folder that they use.

A line is a row (COLUMNS,) of `Packed.lines`; *y* (6,) are its unknowns, written in place; *i* is its index in the
scratch *work*, see `equilibrium.Work`, where `place` has placed it at the *pose* (n,). *spatial* is always
work.spatial: for a robot that is not general it is None, and Numba, which prunes on arguments, then compiles upright
lines alone (`docs/decisions/0014-plain-robots-apart.md`). Wrenches are (n,), N and N m about the platform's origin.
"""

from math import cos, inf, sqrt

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import copy
from cablewright.kernels.layout import (
    COUNTERWEIGHT,
    DEAD_LENGTH,
    DEAD_SPAN,
    EXIT_X,
    GUIDE,
    OK,
    PHI,
    RADIUS,
    SPANS,
    TENSION_MAX,
    TENSION_MIN,
    UNDER_EXIT,
    UNKNOWNS,
)
from cablewright.kernels.statics.line.spatial import GIVEN, advance_spatial
from cablewright.kernels.statics.line.spatial_lines import (
    aim_placed,
    condense_moving_placed,
    condense_placed,
    draw_placed,
    evaluate_placed,
    find_placed,
    guess_placed,
    judge_placed,
    settle_placed,
    step_placed,
    stiffen_placed,
)
from cablewright.kernels.statics.line.spatial_parameter_derivatives import write_placed, write_tension_placed
from cablewright.kernels.statics.line.spatial_pull import (
    add_placed,
    begin_placed,
    column_placed,
    extremes_placed,
    hang_placed,
    measure_placed,
    settle_placed_at_pull,
)
from cablewright.kernels.statics.line.upright import SLACK_TENSION, guess
from cablewright.kernels.statics.line.upright_lines import (
    TAUT,
    aim_upright,
    condense_moving_upright,
    condense_upright,
    dips_upright,
    draw_upright,
    evaluate_upright,
    find_upright,
    judge_upright,
    settle_upright,
    step_upright,
    stiffen_upright,
)
from cablewright.kernels.statics.line.upright_parameter_derivatives import write_tension_upright, write_upright
from cablewright.kernels.statics.line.upright_pull import (
    add_upright,
    begin_upright,
    column_upright,
    extremes_upright,
    hang_upright,
    measure_upright,
    settle_at_pull,
)
from cablewright.kernels.statics.line.vertical_plane import NO_PLANE, is_eyelet, place
from cablewright.kernels.statics.platform import place_arm, place_platform

MIN_SPRING = 1e-3  # m
PREDICTED = 1e-9  # of a pull: change up to which the predicted state of an upright line is exact to rounding


@jit
def evaluate_line(row, y, length, pose, i, work, spatial):
    """Evaluate the equations of a line for its *length* (m): leave Jacobian block and residual in *work*.

    Adds the line's wrench to work.trial. Returns the largest residual, m, NaN without a solution, and the largest part
    of the force on the platform, N.
    """
    if spatial is not None and row[GUIDE] > 0.0:
        return evaluate_placed(row, y, length, pose, i, work, spatial)
    return evaluate_upright(row, y, length, i, work)


@jit
def condense_line(row, y, i, work, spatial):
    """Eliminate an evaluated line's unknowns: add its wrench to work.wrench and its stiffness to work.stiffness.

    The wrench is that after the line's own Newton step. False if its block is singular.
    """
    if spatial is not None and row[GUIDE] > 0.0:
        return condense_placed(row, y, i, work, spatial)
    return condense_upright(row, y, i, work)


@jit
def condense_moving_line(row, y, i, rate, work, spatial, pulled, turning):
    """Eliminate a line whose length changes by *rate*, m/s, see `condense_line`.

    Adds by how much its wrench changes per time by that, with the arm held, to *pulled* (n,), N/s and N m/s; and to
    *turning* (3, 6) the part of its stiffness against moments that its force has on an arm that turns or slips.
    """
    if spatial is not None and row[GUIDE] > 0.0:
        return condense_moving_placed(row, y, i, rate, work, spatial, pulled, turning)
    return condense_moving_upright(row, y, i, rate, work, pulled, turning)


@jit
def advance_line(row, y, i, move, work, spatial):
    """Take the Newton step of an eliminated line after the platform's *move* (n, 1). Returns whether it is full."""
    if spatial is not None and row[GUIDE] > 0.0:
        return step_placed(y, i, move, spatial)
    return step_upright(row, y, work.steps[i], work.arms[i], work.planes[i], move)


@jit
def guess_line(row, y, pose, i, length, tension, work, spatial):
    """Set *y* close to the line of unstrained *length* (m), taut or slack; *tension* (N) only places a lever.

    False where the platform point lies inside a sheave.
    """
    if spatial is not None and row[GUIDE] > 0.0:
        return guess_placed(row, y, pose, i, length, tension, work, spatial)
    plane = work.planes[i]
    return guess(row, plane[2], plane[3], length, tension, y)


@jit
def draw_line(row, y, pose, i, tension, work, spatial):
    """Set *y* to the straight line at *tension* (N), with strained lengths. Returns its length, m.

    Negative where the platform point lies inside a sheave.
    """
    if spatial is not None and row[GUIDE] > 0.0:
        return draw_placed(row, y, pose, i, tension, work, spatial)
    plane = work.planes[i]
    return draw_upright(row, y, plane[2], plane[3], tension)


@jit
def aim_line(row, y, pose, i, tension, work, spatial):
    """Draw the straight line at *tension* (N). Returns a code and the unit vector along which it pulls the platform.

    work.arms[i] then reaches to where it leaves the platform.
    """
    if spatial is not None and row[GUIDE] > 0.0:
        return aim_placed(row, y, pose, i, tension, work, spatial)
    return aim_upright(row, y, tension, work.planes[i])


@jit
def settle_line(row, y, length, pose, i, tension, work, spatial):
    """Solve for *length* (m) at a fixed pose, from *y* or else from a guess at *tension* (N); leave it evaluated.

    Returns SETTLED, SLACK of a massless line that carries nothing, or FAILED.
    """
    if spatial is not None and row[GUIDE] > 0.0:
        return settle_placed(row, y, length, pose, i, tension, work, spatial)
    plane = work.planes[i]
    return settle_upright(row, y, plane[2], plane[3], length, i, tension, work)


@jit
def find_line(row, y, length, pose, i, work, spatial):
    """Solve for *length* (m) at a fixed pose without a guess, taut or hanging; where it has no weight perhaps slack.

    Returns a code. It need not be stable: of a lever the first stable angle is taken, else the last.
    """
    if spatial is not None and row[GUIDE] > 0.0:
        return find_placed(row, y, length, pose, i, work, spatial)
    return find_upright(row, y, work.planes[i], length, work.blocks[i], work.steps[i])


@jit
def taut_line(row, y, pose, i, work, spatial):
    """Set *y* to a straight line, see `draw_line`, with weightless levers and undeflected exit points."""
    if spatial is not None and row[GUIDE] > 0.0:
        return draw_placed(row, y, pose, i, SLACK_TENSION, work, spatial)
    plane = work.planes[i]
    return draw_upright(row, y, plane[2], plane[3], TAUT)


@jit
def place_lines(packed, pose, work):
    """Compute the platform points and planes of all lines at the *pose* (n,)."""
    place_platform(pose, work.rotation)
    for i in range(packed.lines.shape[0]):
        place(packed.lines, i, pose, work.rotation, work.arms[i], work.planes[i])


@jit
def judge_line(row, y, i, planes, spatial):
    """Code of a solved line, as evaluated: OK if a machine can have it; *planes* (m, 4): see `Work`."""
    if spatial is not None and row[GUIDE] > 0.0:
        return judge_placed(row, y, i, spatial)
    return judge_upright(row, y, planes[i])


@jit
def begin_line(row, y, pose, i, known, share, work, spatial):
    """Return code and pull (N) of a line from its *known* state or a straight guess with the tension *share* (N)."""
    if spatial is not None and row[GUIDE] > 0.0:
        return begin_placed(row, y, pose, i, known, share, work, spatial)
    return begin_upright(row, y, i, known, share, work)


@jit
def settle_line_at_pull(row, y, pose, i, pull, work, spatial):
    """Solve for *pull* (N) at a fixed pose from *y*; leave its derivative by the pull in *work*. True if it converges.

    The pull is the mid-length force of the free span along its chord, N, see `upright_pull.pull_of`.
    """
    if spatial is not None and row[GUIDE] > 0.0:
        return settle_placed_at_pull(row, y, pose, i, pull, work, spatial)
    plane = work.planes[i]
    return settle_at_pull(row, plane[2], plane[3], pull, y, work.blocks[i], work.steps[i])


@jit
def column_line(row, y, i, pull, work, spatial, column, load):
    """Write minus the derivative of a line's wrench by its *pull* (N) to *column* (n,); add the rest to *load*."""
    if spatial is not None and row[GUIDE] > 0.0:
        column_placed(row, y, i, pull, spatial, column, load)
    else:
        column_upright(row, y, i, pull, work, column, load)


@jit
def extremes_at_pull(row, y, i, work, spatial):
    """Smallest and largest tension of a line solved at its pull, N, and their changes per logarithm of the pull."""
    if spatial is not None and row[GUIDE] > 0.0:
        return extremes_placed(row, y, i, spatial)
    return extremes_upright(row, y, work.steps[i])


@jit
def predict_line(row, y, i, grown, work, spatial):
    """Predict *y* of a line solved at its pull, to first order, after the logarithm of the pull has *grown*."""
    if spatial is not None and row[GUIDE] > 0.0:
        advance_spatial(y, spatial.steps[i], GIVEN, -grown)
    else:
        for k in range(int(row[UNKNOWNS])):
            y[k] += grown * work.steps[i, k, 1]


@jit
def is_predicted_exactly(row, pull, moved):
    """Return whether `predict_line` is exact to rounding for a *pull* (N) that has *moved* by so few newtons."""
    return row[GUIDE] == 0.0 and not abs(moved) > PREDICTED * pull


@jit
def add_line_pull(row, y, i, work, spatial, wrench):
    """Add a solved line's wrench to *wrench* (n,); returns the largest part of its force, N."""
    if spatial is not None and row[GUIDE] > 0.0:
        return add_placed(row, i, spatial, wrench)
    return add_upright(row, y, i, work, wrench)


@jit
def hang_line(row, y, pull, pose, i, restart, work, spatial, column):
    """Solve a line for its *pull* (N); add its wrench and its stiffness at a held pull to *work*.

    *restart*: from a straight line. Writes the wrench's change per logarithm of the pull to *column* (n,). False
    without a solution.
    """
    if spatial is not None and row[GUIDE] > 0.0:
        return hang_placed(row, y, pull, pose, i, restart, work, spatial, column)
    return hang_upright(row, y, pull, i, restart, work, column)


@jit
def length_changes(row, y, pose, i, work, spatial, by_pose):
    """Return the derivative of a line's length by the logarithm of its pull, m, after `hang_line`.

    Writes that per motion of the platform at a held pull to *by_pose* (n,), m/m and m/rad about world axes.
    """
    if spatial is not None and row[GUIDE] > 0.0:
        return measure_placed(row, y, pose, i, work, spatial, by_pose)
    return measure_upright(row, y, i, work, by_pose)


@jit
def change_line(row, y, length, pose, i, work, spatial, right):
    """Write the derivatives of an eliminated line's wrench by its parameters, see `linearise`, to *right* (n, 10 m)."""
    if spatial is not None and row[GUIDE] > 0.0:
        return write_placed(row, y, length, pose, i, work, spatial, right)
    return write_upright(row, y, length, i, work, right)


@jit
def change_tension(row, y, length, pose, i, work, spatial, own, by_pose):
    """Write the derivatives of a line's tension by its parameters, *own* (10,), and by the pose, *by_pose* (n,).

    The line is eliminated, and both arrays are zero before; see `tension_changes`.
    """
    if spatial is not None and row[GUIDE] > 0.0:
        return write_tension_placed(row, y, length, pose, i, work, spatial, own, by_pose)
    return write_tension_upright(row, y, length, i, work, own, by_pose)


@jit
def stiffen_line(row, y, i, work, spatial, chord, arm):
    """Return the stiffness of an eliminated line along its *chord* (3,), N/m; writes that and the *arm* of its end."""
    if spatial is not None and row[GUIDE] > 0.0:
        return stiffen_placed(row, y, i, spatial, chord, arm)
    copy(work.arms[i], arm)
    return stiffen_upright(row, y, i, work, chord)


@jit
def dips_line(row, y):
    """Return whether the dead span has a lowest point between its ends.

    That of a line outside a vertical plane is straight.
    """
    return row[GUIDE] == 0.0 and row[UNKNOWNS] > 3.0 and dips_upright(row, y)


@jit
def leaves_backwards(row, y):
    """Return whether the free span leaves its sheave away from the platform, or may.

    The platform point is then under the sheave. Of lines outside a vertical plane nothing is proved: they may.
    """
    return row[GUIDE] > 0.0 or (row[RADIUS] > 0.0 and cos(y[PHI]) < 0.0)


@jit
def may_tip(packed, states):
    """Return whether a solved platform may be unstable.

    A body may be, and a point with a line that leaves its sheave backwards.
    """
    if packed.freedoms == 6:
        return True
    for i in range(packed.lines.shape[0]):
        if leaves_backwards(packed.lines[i], states[i]):
            return True
    return False


@jit
def spring_line(row, y, length, pose, i, tension, work, spatial):
    """Return the length, m, of the spring from the exit point that replaces a placed line of *length*, m.

    That is less what the straight line at *tension* (N) needs up to its exit. Negative inside a sheave.
    """
    plane = work.planes[i]
    if spatial is not None and row[GUIDE] > 0.0:
        distance = sqrt(plane[2] * plane[2] + plane[3] * plane[3])
        drawn = draw_placed(row, y, pose, i, tension, work, spatial)
        taut = drawn if drawn > 0.0 else row[SPANS] * distance + row[DEAD_SPAN] + row[DEAD_LENGTH]
        return max((length - taut) / row[SPANS] + distance, MIN_SPRING)
    x = max(plane[2], 4.0 * row[RADIUS])  # clear of the sheave, where there is no tangent
    drawn = draw_upright(row, y, x, plane[3], tension)
    if drawn < 0.0:
        return drawn
    return max((length - drawn) / row[SPANS] + sqrt(x * x + plane[3] * plane[3]), MIN_SPRING)


@jit
def aim_line_at(lines, i, pose, y, work, spatial):
    """Return a code and the unit vector along which the straight, massless line *i* pulls the platform at the *pose*.

    A lever has its angle at the mean of the line's tension limits. Writes the line's arm to work.arms[0]; *work* is
    scratch of one line, with the platform placed.
    """
    row, arm = lines[i], work.arms[0]
    if not is_eyelet(row):
        place(lines, i, pose, work.rotation, arm, work.planes[0])
        tension = 0.5 * (row[TENSION_MIN] + row[TENSION_MAX])
        return aim_line(row, y, pose, 0, tension, work, spatial)
    place_arm(lines, i, pose, work.rotation, arm)
    x = row[EXIT_X] - pose[0] - arm[0]
    y = row[EXIT_X + 1] - pose[1] - arm[1]
    z = row[EXIT_X + 2] - pose[2] - arm[2]
    square = x * x + y * y + z * z
    if not square > NO_PLANE * NO_PLANE:
        return UNDER_EXIT, 0.0, 0.0, 0.0
    inverse = 1.0 / sqrt(square)
    return OK, x * inverse, y * inverse, z * inverse


@jit
def reach_of_line(row, length):
    """Return the distance (m) up to which a line of unstrained *length* (m) reaches; of a counterweight's no bound."""
    return length / row[SPANS] if row[COUNTERWEIGHT] == 0.0 else inf
