"""One line out of the plane in the inverse problem: its first guess, its state at a pull, and its column per pull.

*base* is the scratch of the equilibrium and *spatial* its part for such lines, None as in `spatial_lines`.
"""

from math import cos, exp, log, sin

from cablewright.kernels import jit
from cablewright.kernels.layout import (
    AZIMUTH,
    COUNTERWEIGHT,
    DEAD,
    DEAD_COMPLIANCE,
    FREE,
    FREE_COMPLIANCE,
    OK,
    PHI,
    PULLS,
    TAU,
    TENSION_MIN,
    UNDER_EXIT,
    WEIGHT,
)
from cablewright.kernels.statics.equilibrium import is_slack
from cablewright.kernels.statics.guides import SPAN, SPAN_BY_FORCE
from cablewright.kernels.statics.sheave import unstrain
from cablewright.kernels.statics.spatial import (
    END_FORCE,
    GIVEN,
    advance_spatial,
    dead_length,
    place_span,
    pull_along,
    settle_spatial_at_pull,
    straight_spatial,
    why_not_straight,
)
from cablewright.kernels.statics.spatial_lines import draw_placed
from cablewright.kernels.statics.spatial_wrench import add_spatial_pull, add_spatial_stiffness, wrench_change

TAUT = 1.5  # of its own weight: tension at which a line is straight enough for a first guess


@jit
def begin_placed(row, y, i, pose, base, spatial, known, share):
    """Place line *i*; unless *known*, guess it straight with the tension *share*. Returns code and pull."""
    if spatial is None:
        return UNDER_EXIT, 0.0
    record, block, rhs = spatial.records[i], spatial.blocks[i], spatial.steps[i]
    if known and not is_slack(row, y):
        if not place_span(row, y, pose, base.arms[i], base.rotation, record, block):
            return UNDER_EXIT, 0.0
        pull, _ = pull_along(row, y, record)
        return OK, pull
    tension = max(share, row[TENSION_MIN], 1.0) if row[COUNTERWEIGHT] == 0.0 else row[COUNTERWEIGHT]
    if not straight_spatial(row, y, pose, base.arms[i], base.rotation, tension, record, block, rhs):
        return why_not_straight(row, y, pose, base.arms[i]), 0.0
    tension = max(tension, TAUT * row[WEIGHT] * (y[FREE] + y[DEAD]))
    y[TAU] = log(tension)
    unstrain(y, row[FREE_COMPLIANCE], row[DEAD_COMPLIANCE])
    return OK, tension


@jit
def settle_placed(row, y, i, pose, pull, base, spatial):
    """Solve line *i* at its *pull* (N); its solved right-hand sides are left in *spatial*. True if it converges."""
    if spatial is None:
        return False
    record, block, rhs = spatial.records[i], spatial.blocks[i], spatial.steps[i]
    return settle_spatial_at_pull(row, y, pose, base.arms[i], base.rotation, pull, record, block, rhs)


@jit
def column_placed(row, y, i, pose, pull, base, spatial, column, load):
    """Solve line *i* at its *pull* (N); write minus its wrench per pull to *column* (n,), add the rest to *load* (n,).

    Returns whether it is solved, and the changes of PHI, TAU, FREE and DEAD per logarithm of the pull.
    """
    if spatial is None:
        return False, 0.0, 0.0, 0.0, 0.0
    if not settle_placed(row, y, i, pose, pull, base, spatial):
        return False, 0.0, 0.0, 0.0, 0.0
    record, rhs = spatial.records[i], spatial.steps[i]
    wrench_change(row, y, record, rhs, GIVEN, -1, -row[PULLS] / pull, column)
    add_spatial_pull(record, row[PULLS], load)
    for k in range(column.shape[0]):
        load[k] += pull * column[k]
    dphi, dtau, dfree, ddead = change_by_pull(row, y, i, spatial)
    return True, dphi, dtau, dfree, ddead


@jit
def change_by_pull(row, y, i, spatial):
    """Changes of PHI, TAU, FREE and DEAD of line *i*, solved at its pull, per logarithm of that."""
    if spatial is None:
        return 0.0, 0.0, 0.0, 0.0
    record, rhs = spatial.records[i], spatial.steps[i]
    c, s, tension = cos(y[PHI]), sin(y[PHI]), exp(y[TAU])
    outward = cos(y[AZIMUTH]) * rhs[0, GIVEN] + sin(y[AZIMUTH]) * rhs[1, GIVEN]
    grow = c * outward + s * rhs[2, GIVEN]
    _, by_tension, per_metre = dead_length(row, record[SPAN], tension)
    longer = by_tension * grow
    for k in range(3):
        longer += per_metre * record[SPAN_BY_FORCE + k] * rhs[k, GIVEN]
    return c * rhs[2, GIVEN] - s * outward, grow, rhs[3, GIVEN], longer * tension


@jit
def predict_placed(y, i, spatial, grown):
    """Move the unknowns of a solved line along their derivative by the logarithm of its pull, which has *grown*."""
    if spatial is not None:
        advance_spatial(y, spatial.steps[i], GIVEN, -grown)


@jit
def add_placed(row, i, spatial, wrench):
    """Add the wrench of a placed line to *wrench* (n,); returns the largest part of its force, N."""
    if spatial is None:
        return 0.0
    record, size = spatial.records[i], 0.0
    add_spatial_pull(record, row[PULLS], wrench)
    for k in range(3):
        size = max(size, row[PULLS] * abs(record[END_FORCE + k]))
    return size


@jit
def add_hanging(row, y, i, pose, work, spatial, restart):
    """As `underactuated.evaluate_at_pulls`, of one line."""
    if spatial is None:
        return False
    base, pull = work.base, work.pulls[i]
    if restart or not settle_placed(row, y, i, pose, pull, base, spatial):
        if draw_placed(row, y, pose, i, pull, base, spatial) < 0.0:
            return False
        unstrain(y, row[FREE_COMPLIANCE], row[DEAD_COMPLIANCE])
        if not settle_placed(row, y, i, pose, pull, base, spatial):
            return False
    record, steps = spatial.records[i], spatial.steps[i]
    add_spatial_pull(record, row[PULLS], base.wrench)
    add_spatial_stiffness(row, y, record, steps, row[PULLS], work.column, base.stiffness)
    wrench_change(row, y, record, steps, GIVEN, -1, row[PULLS], work.column)
    for k in range(pose.shape[0]):
        work.structure[k, i] = work.column[k]
    return True
