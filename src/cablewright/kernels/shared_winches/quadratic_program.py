"""One quadratic program of the inverse problem with shared winches: pulls and free coordinates, balance and lengths.

Unknown are the m pulls and a step of each free coordinate of the pose; the n equations of the balance are followed by
one for each line on another's drum. All are linearised at the present pulls and pose, and each column and row is of
the size of forces. Steps of the pose have a small cost of their own, which vanishes with them.
"""

from math import isnan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.layout import PREFERRED
from cablewright.kernels.shared_winches.lengths import LengthWork, length_workspace
from cablewright.kernels.statics.inverse import curve
from cablewright.kernels.statics.line.interface import extremes_at_pull
from cablewright.kernels.statics.line.pull_limits import pull_limits
from cablewright.kernels.statics.platform import keep_free, rates_of_rotation
from cablewright.kernels.statics.tension_distribution import Program

# Columns of a table of lines on another's drum: L[LINE] = OFFSET + SENSE * L[OTHER].
LINE, OTHER, SENSE, OFFSET = 0, 1, 2, 3
SHARES = 4

PROXIMAL = 1e-2  # curvature of a step of the pose, relative to that of a pull
GEOMETRIC = 1e-13  # m/N: of no change per pull, lengths are those of rigid cables
AGREE = 1e-9  # m: up to which the lengths of rigid cables fit one drum
LONGEST_STEP = 0.3  # m or rad


class SharedWork(NamedTuple):
    """Working memory of the quadratic program.

    With s lines on another's drum it has m + n columns and n + s rows.
    """

    given: NDArray[np.float64]  # (n,): coordinates of the pose, NaN where free
    structure: NDArray[np.float64]  # (n + s, m + n)
    load: NDArray[np.float64]  # (n + s,)
    low: NDArray[np.float64]  # (m + n,)
    high: NDArray[np.float64]
    curvature: NDArray[np.float64]
    bias: NDArray[np.float64]
    required: NDArray[np.float64]
    multipliers: NDArray[np.float64]  # (n + s,)
    hessian: NDArray[np.float64]  # (n + s, n + s)
    step: NDArray[np.float64]  # (n + s, 3)
    column: NDArray[np.float64]  # (n + s,)
    rates: NDArray[np.float64]  # (n,): stiffness by which the step of a coordinate is multiplied, N/m and N/rad
    scales: NDArray[np.float64]  # (s,): by which the equation of a length is multiplied, N/m; 0: not known yet
    moves: NDArray[np.float64]  # (m,): the last required change of the pulls
    before: NDArray[np.float64]  # (m,): pulls of the last program
    reach: NDArray[np.float64]  # (1,): longest step of a coordinate, m or rad
    lengths: LengthWork


@jit(allocates=True)
def shared_workspace(packed, shares):
    """Allocate a `SharedWork` for *packed* and the (s, 4) table of *shares*."""
    m, n, s = packed.lines.shape[0], packed.freedoms, shares.shape[0]
    return SharedWork(
        np.zeros(n),
        np.zeros((n + s, m + n)),
        np.zeros(n + s),
        np.zeros(m + n),
        np.zeros(m + n),
        np.ones(m + n),
        np.zeros(m + n),
        np.zeros(m + n),
        np.zeros(n + s),
        np.zeros((n + s, n + s)),
        np.zeros((n + s, 3)),
        np.zeros(n + s),
        np.ones(n),
        np.zeros(s),
        np.zeros(m),
        np.zeros(m),
        np.zeros(1),
        length_workspace(n, m),
    )


@jit
def missed(shares, r, lengths):
    """Return by how much lengths (m,) miss the equation of a shared drum, row *r* of *shares*, m."""
    share = shares[r]
    return share[OFFSET] + share[SENSE] * lengths[int(share[OTHER])] - lengths[int(share[LINE])]


@jit
def begin_program(own):
    """Reset step limits, multipliers and curvatures before the first program of a solve."""
    own.scales[:], own.moves[:] = 0.0, 0.0
    own.reach[0] = LONGEST_STEP
    forget_multipliers(own)


@jit
def forget_multipliers(own):
    """Forget the last program's multipliers, and the curvatures that they gave: those of softened limits are large."""
    own.multipliers[:], own.before[:] = 0.0, 0.0
    own.curvature[:] = 1.0


@jit
def fill_program(packed, shares, pose, states, work, own):
    """Write the quadratic program, linearised at the present pulls and pose.

    The lines are evaluated and measured before. Returns False where rigid cables do not fit their drums.
    """
    n, m, most = pose.shape[0], packed.lines.shape[0], 0.0
    for i in range(m):
        most = max(most, work.pulls[i])
    for k in range(n):
        own.load[k] = work.base.wrench[k]
    rates_of_rotation(pose, work.base.rotation)
    for k in range(n):
        _fill_rate(own, k, work)
    for r in range(shares.shape[0]):
        if own.scales[r] == 0.0:
            own.scales[r] = _scale(packed, shares, r, work, own)
        gap = missed(shares, r, own.lengths.lengths)
        if own.scales[r] == 0.0 and abs(gap) > AGREE:
            return False
        own.load[n + r] = own.scales[r] * gap
    for k in range(n):
        for r in range(shares.shape[0]):
            own.rates[k] = max(own.rates[k], own.scales[r] * abs(_length_by_step(shares, r, k, work, own)))
    for i in range(m):
        _fill_pull(packed, shares, i, states[i], work, own)
    for k in range(n):
        _fill_step(packed, shares, k, most, work, own)
    return True


@jit
def _part(shares, r, i):
    """Coefficient of the length of line *i* in row *r* of *shares*: 1, minus its sense, or 0."""
    if int(shares[r, LINE]) == i:
        return 1.0
    return -shares[r, SENSE] if int(shares[r, OTHER]) == i else 0.0


@jit
def _length_by_step(shares, r, k, work, own):
    """Change of the equation of row *r* by coordinate *k* of the pose at held pulls, m/m or m/rad."""
    by_pose, one, two, sense = own.lengths.by_pose, int(shares[r, LINE]), int(shares[r, OTHER]), shares[r, SENSE]
    if k < 3:
        return by_pose[one, k] - sense * by_pose[two, k]
    change = 0.0
    for j in range(3):
        change += (by_pose[one, 3 + j] - sense * by_pose[two, 3 + j]) * work.base.rotation[j, k - 3]
    return change


@jit
def _force_by_step(k, i, work):
    """Entry *i* of minus the change of the wrench by coordinate *k* of the pose at held pulls."""
    stiffness = work.base.stiffness
    if k < 3:
        return stiffness[i, k]
    change = 0.0
    for j in range(3):
        change += stiffness[i, 3 + j] * work.base.rotation[j, k - 3]
    return change


@jit
def _fill_rate(own, k, work):
    """Write the stiffness of coordinate *k*, by which its step becomes a force."""
    own.rates[k] = 0.0
    for i in range(own.rates.shape[0]):
        own.rates[k] = max(own.rates[k], abs(_force_by_step(k, i, work)))
    if own.rates[k] == 0.0:
        own.rates[k] = 1.0


@jit
def _scale(packed, shares, r, work, own):
    """What makes the largest entry of the equation of row *r* one, N/m; 0 where nothing changes the lengths."""
    most = 0.0
    for i in range(packed.lines.shape[0]):
        if _part(shares, r, i) != 0.0:
            most = max(most, abs(own.lengths.by_pull[i]) / work.pulls[i])
    if most > GEOMETRIC:
        return 1.0 / most
    most = 0.0
    for k in range(own.given.shape[0]):
        if isnan(own.given[k]):
            most = max(most, abs(_length_by_step(shares, r, k, work, own)) / own.rates[k])
    return 1.0 / most if most > 0.0 else 0.0


@jit
def _fill_pull(packed, shares, i, y, work, own):
    """Write the column of a pull, its curvature and its limits; add to the load what is not proportional to it."""
    n, row, pull = own.given.shape[0], packed.lines[i], work.pulls[i]
    for k in range(n):
        work.column[k] = -work.structure[k, i] / pull
    keep_free(packed, work.column)
    for k in range(n):
        own.column[k] = work.column[k]
    for r in range(shares.shape[0]):
        own.column[n + r] = own.scales[r] * _part(shares, r, i) * own.lengths.by_pull[i] / pull
    program = Program(own.structure, own.load, own.low, own.high, own.curvature, own.bias)
    curve(program, own.multipliers, own.before, own.column, i, pull, row[PREFERRED])
    for k in range(own.column.shape[0]):
        own.load[k] += own.column[k] * pull
    low, high, dlow, dhigh = extremes_at_pull(row, y, i, work.base, work.base.spatial)
    own.low[i], own.high[i] = pull_limits(row, y, pull, work.slackest[0], low, high, dlow, dhigh)


@jit
def _fill_step(packed, shares, k, most, work, own):
    """Write the column of the step of coordinate *k*, which is 0 where it is given; *most*: the largest pull, N."""
    n, m = own.given.shape[0], packed.lines.shape[0]
    at, rate = m + k, own.rates[k]
    own.low[at] = own.high[at] = own.bias[at] = 0.0
    own.curvature[at] = PROXIMAL
    own.structure[:, at] = 0.0
    if not isnan(own.given[k]):
        return
    for i in range(n):
        work.column[i] = _force_by_step(k, i, work) / rate
    keep_free(packed, work.column)
    for i in range(n):
        own.structure[i, at] = work.column[i]
    for r in range(shares.shape[0]):
        own.structure[n + r, at] = own.scales[r] * _length_by_step(shares, r, k, work, own) / rate
    own.high[at] = own.reach[0] * rate + most
    own.low[at] = -own.high[at]
