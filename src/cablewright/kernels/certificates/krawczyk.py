"""A certificate of one equilibrium: Krawczyk's test around a numerical solution, in intervals.

With F the equations, Y any matrix, and a box x +- r on which every Jacobian of F is within [J], let

    k = |Y F(x)| + |I - Y [J]| r.

If k < r in every component, F has exactly one zero in the box, and it is within k of x (Krawczyk 1969; Rump 2010,
section 13). F(x) and [J] are enclosed with outward rounding, Y is an approximate inverse by blocks: one for each line,
and the platform. Rounding in the floating point sums with Y is bounded by GAMMA times the sums of absolute values.
"""

from cablewright.kernels import jit
from cablewright.kernels.certificates.interval import GAMMA, ROUNDING
from cablewright.kernels.certificates.system_enclosure import jacobian_of_all, residual_of_all
from cablewright.kernels.layout import BETA, UNKNOWNS
from cablewright.kernels.newton import solve
from cablewright.kernels.statics.equilibrium import is_slack

UNDERFLOW = 1e-290  # more than sums of products with Y lose below the smallest float
LARGEST = 1e12  # entry of Y up to which that is so
WIDEN = 2.5  # radii over the size of a Newton step
WIDTH = 1e-10  # of an unknown: the box that is tried first, far wider than a solution's error
GRAIN = 4e-16  # of an unknown: the least box
NARROWER = 1e-3
TRIES = 5

CERTIFIED, NOT_CONTRACTING, UNBOUNDED, NO_INVERSE, SLACK, IMPRECISE = 0, 1, 2, 3, 4, 5


@jit
def certify(packed, lengths, pose, states, tolerance, work):
    """Whether exactly one equilibrium lies in a box around *pose* and *states*, and within *tolerance* of the pose.

    work.radius is then the box, work.bound how far the equilibrium is from the solution: for each line its unknowns,
    then the pose (m, and a rotation from the solution's, rad). Returns a code.
    """
    for i in range(packed.lines.shape[0]):
        if is_slack(packed.lines[i], states[i]):
            return SLACK
    residual_of_all(packed, lengths, pose, states, work)
    _widen(packed, pose, states, work, WIDTH, False)
    code = UNBOUNDED
    for tried in range(TRIES):
        jacobian_of_all(packed, pose, states, work)
        if not split(packed, work):
            code = UNBOUNDED
            for k in range(work.radius.shape[0]):
                work.radius[k] *= NARROWER
            continue
        if not invert(packed, work):
            return NO_INVERSE
        if not newton_bound(work):
            return UNBOUNDED
        image(packed, work)
        if _contracts(work):
            return CERTIFIED if _is_within(packed, tolerance, work) else IMPRECISE
        code = NOT_CONTRACTING
        if tried == 0:
            _widen(packed, pose, states, work, GRAIN, True)
        else:
            for k in range(work.radius.shape[0]):
                work.radius[k] = 1.5 * max(work.radius[k], work.bound[k])
    return code


@jit
def _widen(packed, pose, states, work, width, stepped):
    """Set the box: *width* of each unknown, and where *stepped* WIDEN Newton steps at least."""
    m, n = packed.lines.shape[0], packed.freedoms
    first = work.offsets[m]
    for i in range(m):
        for k in range(int(packed.lines[i, UNKNOWNS])):
            work.radius[work.offsets[i] + k] = width * (1.0 + abs(states[i, k]))
    for k in range(n):
        work.radius[first + k] = width * (1.0 + (abs(pose[k]) if k < 3 else 0.0))
    if stepped:
        for k in range(work.radius.shape[0]):
            work.radius[k] = max(work.radius[k], WIDEN * work.step[k])


@jit
def _contracts(work):
    for k in range(work.bound.shape[0]):
        if not work.bound[k] < work.radius[k]:
            return False
    return True


@jit
def _is_within(packed, tolerance, work):
    """Whether the pose is as near to the equilibrium as is wanted."""
    for k in range(work.offsets[packed.lines.shape[0]], work.bound.shape[0]):
        if not work.bound[k] <= tolerance:
            return False
    return True


@jit
def levers(packed, work):
    """Of the certified box: 1 if every lever surely returns when pushed, -1 if some surely does not, else 0."""
    sure = 1
    for i in range(packed.lines.shape[0]):
        if packed.lines[i, UNKNOWNS] == 6.0:
            at = work.offsets[i] + BETA
            if work.low[at, at] > 0.0:
                return -1
            if not work.high[at, at] < 0.0:
                sure = 0
    return sure


@jit
def split(packed, work):
    """Middles and half widths of the Jacobian's blocks; False where an entry is not bounded."""
    m, n = packed.lines.shape[0], packed.freedoms
    first = work.offsets[m]
    bounded = True
    for i in range(m):
        start, end = work.offsets[i], work.offsets[i + 1]
        for row in range(start, end):
            for column in range(start, end):
                bounded = _halve(work, row, column) and bounded
        for row in range(start, start + 2):
            for column in range(first, first + n):
                bounded = _halve(work, row, column) and bounded
        for row in range(first, first + n):
            for column in range(start, start + 3):
                bounded = _halve(work, row, column) and bounded
    for row in range(first, first + n):
        for column in range(first, first + n):
            bounded = _halve(work, row, column) and bounded
    return bounded


@jit
def _halve(work, row, column):
    low, high = work.low[row, column], work.high[row, column]
    middle = 0.5 * (low + high)
    work.middle[row, column] = middle
    spread = max(high - middle, middle - low) * ROUNDING
    work.spread[row, column] = spread
    return spread < 1e300  # False for NaN too


@jit
def invert(packed, work):
    """Y, from inverses of the lines' blocks and of the platform's Schur complement."""
    m, n = packed.lines.shape[0], packed.freedoms
    first = work.offsets[m]
    inverse, middle, columns = work.inverse, work.middle, work.columns
    for a in range(n):
        for b in range(n):
            work.schur[a, b] = middle[first + a, first + b]
            work.identity[a, b] = 1.0 if a == b else 0.0
    for i in range(m):
        start = work.offsets[i]
        k = work.offsets[i + 1] - start
        for a in range(k):
            for b in range(k):
                work.block[a, b] = middle[start + a, start + b]
                columns[a, b] = 1.0 if a == b else 0.0
            for b in range(n):
                columns[a, k + b] = middle[start + a, first + b] if a < 2 else 0.0
        if not solve(work.block, columns, k, k + n):
            return False
        for a in range(k):
            for b in range(k):
                inverse[start + a, start + b] = columns[a, b]
            for b in range(n):
                inverse[start + a, first + b] = columns[a, k + b]  # X, for now
        for a in range(n):
            for b in range(k):
                total = 0.0
                for c in range(3):
                    total += middle[first + a, start + c] * columns[c, b]
                inverse[first + a, start + b] = total  # Z, for now
            for b in range(n):
                for c in range(3):
                    work.schur[a, b] -= middle[first + a, start + c] * columns[c, k + b]
    if not solve(work.schur, work.identity, n, n):
        return False
    _assemble(first, n, m, work)
    return True


@jit
def _assemble(first, n, m, work):
    """Y from J^-1, X, Z and the inverse of the Schur complement."""
    inverse, offsets, sums = work.inverse, work.offsets, work.sums
    for row in range(first):
        for b in range(n):
            sums[b] = 0.0
            for c in range(n):
                sums[b] -= inverse[row, first + c] * work.identity[c, b]
        for b in range(n):
            inverse[row, first + b] = sums[b]
    for i in range(m):
        for row in range(offsets[i], offsets[i + 1]):
            for column in range(first):
                total = 0.0
                for c in range(n):
                    total += inverse[row, first + c] * inverse[first + c, column]
                own = offsets[i] <= column < offsets[i + 1]
                inverse[row, column] = (inverse[row, column] if own else 0.0) - total
    for column in range(first):
        for a in range(n):
            sums[a] = 0.0
            for c in range(n):
                sums[a] -= work.identity[a, c] * inverse[first + c, column]
        for a in range(n):
            inverse[first + a, column] = sums[a]
    for a in range(n):
        for b in range(n):
            inverse[first + a, first + b] = work.identity[a, b]


@jit
def newton_bound(work):
    """|Y F|, outward; False where it is not bounded."""
    size = work.step.shape[0]
    for row in range(size):
        total, bulk = 0.0, 0.0
        for k in range(size):
            low, high = work.residual[k, 0], work.residual[k, 1]
            middle = 0.5 * (low + high)
            spread = max(high - middle, middle - low)
            y = work.inverse[row, k]
            if not abs(y) < LARGEST:
                return False
            total += y * middle
            bulk += abs(y) * (spread + GAMMA * abs(middle))
        work.step[row] = (abs(total) + bulk) * ROUNDING + UNDERFLOW
        if not work.step[row] < 1e300:
            return False
    return True


@jit
def image(packed, work):
    """The bound |Y F| + |I - Y [J]| r, outward."""
    m, n = packed.lines.shape[0], packed.freedoms
    first = work.offsets[m]
    size = first + n
    radius, inverse = work.radius, work.inverse
    for row in range(size):
        work.sums[row] = 0.0
    for i in range(m):
        start, end = work.offsets[i], work.offsets[i + 1]
        for row in range(start, end):
            _add_spread(work, row, start, end)
        for row in range(start, start + 2):
            _add_spread(work, row, first, size)
        for row in range(first, size):
            _add_spread(work, row, start, start + 3)
    for row in range(first, size):
        _add_spread(work, row, first, size)
    for row in range(size):
        _left_over(work, row, first, m)
        total = work.step[row] + GAMMA * radius[row]
        for k in range(size):
            total += abs(inverse[row, k]) * work.sums[k] + abs(work.entries[k]) * radius[k]
        work.bound[row] = total * ROUNDING + UNDERFLOW


@jit
def _left_over(work, row, first, m):
    """A row of I - Y J, of the Jacobian's middles, to work.entries."""
    middle, inverse, entries = work.middle, work.inverse, work.entries
    size = entries.shape[0]
    for k in range(size):
        entries[k] = 0.0
    entries[row] = 1.0
    for i in range(m):
        start, end = work.offsets[i], work.offsets[i + 1]
        for k in range(start, end):
            y = inverse[row, k]
            for column in range(start, end):
                entries[column] -= y * middle[k, column]
        for k in range(start, start + 2):
            y = inverse[row, k]
            for column in range(first, size):
                entries[column] -= y * middle[k, column]
        for k in range(first, size):
            y = inverse[row, k]
            for column in range(start, start + 3):
                entries[column] -= y * middle[k, column]
    for k in range(first, size):
        y = inverse[row, k]
        for column in range(first, size):
            entries[column] -= y * middle[k, column]


@jit
def _add_spread(work, row, first, last):
    """Add to a row's sum what the Jacobian's half widths, and rounding with its middles, make of the radii."""
    total = 0.0
    for column in range(first, last):
        total += (work.spread[row, column] + GAMMA * abs(work.middle[row, column])) * work.radius[column]
    work.sums[row] += total
