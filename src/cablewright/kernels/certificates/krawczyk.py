"""A certificate of one equilibrium: Krawczyk's test around a numerical solution, in interval arithmetic.

With F the equations, Y any matrix, and a box x +- r on which every Jacobian of F is within [J], let k = |Y F(x)| + |I -
Y [J]| r. If k < r in every component, F has exactly one zero in the box, and it is within k of x (Krawczyk 1969; Rump
2010, section 13). F(x) and [J] are enclosed with outward rounding, Y is an approximate inverse by blocks: one for each
line, and the platform. The rounding of floating-point sums with Y is bounded by GAMMA times the sums of absolute
values.
"""

from cablewright.kernels import jit
from cablewright.kernels.certificates.interval import GAMMA, ROUNDING
from cablewright.kernels.certificates.system_enclosure import jacobian_of_all, residual_of_all
from cablewright.kernels.dense_systems import solve
from cablewright.kernels.layout import BETA
from cablewright.kernels.statics.line.enclosure import ENCLOSABLE, enclosable

UNDERFLOW = 1e-290  # bound of the underflow in sums of products with Y
LARGEST = 1e12  # largest entry of Y for which UNDERFLOW is valid
WIDEN = 2.5  # radii over the size of a Newton step
WIDTH = 1e-10  # of an unknown: half width of the first box, far larger than a solution's error
GRAIN = 4e-16  # of an unknown: min half width
NARROWER = 1e-3
TRIES = 5

CERTIFIED, NOT_CONTRACTING, UNBOUNDED, NO_INVERSE, IMPRECISE = 0, 1, 2, 3, 5  # and the codes of `enclosable`


@jit
def certify(packed, lengths, pose, states, tolerance, work):
    """Prove that exactly one equilibrium lies in a box around *pose* and *states*, within *tolerance* of the pose.

    Returns a code. If CERTIFIED, work.radius is the box and work.bound bounds the distance of the equilibrium from the
    solution: for each line its unknowns, then the pose (m, and a rotation relative to the solution's, rad).
    """
    for i in range(packed.lines.shape[0]):
        code = enclosable(packed.lines[i], states[i])
        if code != ENCLOSABLE:
            return code
    residual_of_all(packed, lengths, pose, states, work)
    _widen(packed, pose, work, WIDTH, False)
    code = UNBOUNDED
    for tried in range(TRIES):
        jacobian_of_all(packed, pose, states, work)
        if not split(work):
            code = UNBOUNDED
            for k in range(work.radius.shape[0]):
                work.radius[k] *= NARROWER
            continue
        if not invert(packed, work):
            return NO_INVERSE
        if not newton_bound(work):
            return UNBOUNDED
        image(work)
        if _contracts(work):
            return CERTIFIED if _is_within(packed, tolerance, work) else IMPRECISE
        code = NOT_CONTRACTING
        if tried == 0:
            _widen(packed, pose, work, GRAIN, True)
        else:
            for k in range(work.radius.shape[0]):
                work.radius[k] = 1.5 * max(work.radius[k], work.bound[k])
    return code


@jit
def _widen(packed, pose, work, width, stepped):
    """Set the box to *width* of each unknown, and if *stepped* to at least WIDEN Newton steps."""
    m, n = packed.lines.shape[0], packed.freedoms
    first = work.offsets[m]
    for i in range(m):
        for k in range(work.offsets[i], work.offsets[i + 1]):
            work.radius[k] = width * (1.0 + abs(work.centre[k]))
    for k in range(n):
        work.radius[first + k] = width * (1.0 + (abs(pose[k]) if k < 3 else 0.0))
    if stepped:
        for k in range(work.radius.shape[0]):
            work.radius[k] = max(work.radius[k], WIDEN * work.step[k])


@jit
def _contracts(work):
    """Whether the bound is smaller than the box in every unknown."""
    for k in range(work.bound.shape[0]):
        if not work.bound[k] < work.radius[k]:
            return False
    return True


@jit
def _is_within(packed, tolerance, work):
    """Whether the bound of the pose is at most *tolerance*."""
    for k in range(work.offsets[packed.lines.shape[0]], work.bound.shape[0]):
        if not work.bound[k] <= tolerance:
            return False
    return True


@jit
def levers(packed, work):
    """Return 1 if every lever is proved stable over the certified box, -1 if one is proved unstable, else 0."""
    sure = 1
    for i in range(packed.lines.shape[0]):
        for at in range(work.offsets[i] + BETA, work.offsets[i + 1]):  # of a line over a lever
            if work.low[at, at] > 0.0:
                return -1
            if not work.high[at, at] < 0.0:
                sure = 0
    return sure


@jit
def split(work):
    """Write the midpoints and half widths of the blocks of an interval Jacobian.

    Returns False where an entry is not bounded.
    """
    bounded = True
    for block in work.blocks:
        for row in range(block[0], block[1]):
            for column in range(block[2], block[3]):
                low, high = work.low[row, column], work.high[row, column]
                middle = 0.5 * (low + high)
                spread = max(high - middle, middle - low) * ROUNDING
                work.middle[row, column], work.spread[row, column] = middle, spread
                bounded = bounded and spread < 1e300  # False for NaN too
    return bounded


@jit
def invert(packed, work):
    """Write Y, an approximate inverse of the Jacobian, by blocks.

    It uses the inverses of the lines' blocks and the platform's Schur complement. Returns False if one is singular.
    """
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
                columns[a, k + b] = middle[start + a, first + b] if a < work.coupled[i, 0] else 0.0
        if not solve(work.block, columns, k, k + n):
            return False
        for a in range(k):
            for b in range(k):
                inverse[start + a, start + b] = columns[a, b]
            for b in range(n):
                inverse[start + a, first + b] = columns[a, k + b]  # X of `_assemble`
        for a in range(n):
            for b in range(k):
                total = 0.0
                for c in range(work.coupled[i, 1]):
                    total += middle[first + a, start + c] * columns[c, b]
                inverse[first + a, start + b] = total  # Z of `_assemble`
            for b in range(n):
                for c in range(work.coupled[i, 1]):
                    work.schur[a, b] -= middle[first + a, start + c] * columns[c, k + b]
    if not solve(work.schur, work.identity, n, n):
        return False
    _assemble(first, n, m, work)
    return True


@jit
def _assemble(first, n, m, work):
    """Write Y from J^-1, X, Z and the inverse of the Schur complement."""
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
    """Write the bound |Y F| of the Newton step, rounded outward; False where it is not bounded."""
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
def image(work):
    """Write Krawczyk's bound |Y F| + |I - Y [J]| r, rounded outward."""
    radius, inverse, size = work.radius, work.inverse, work.radius.shape[0]
    work.sums[:] = 0.0
    for block in work.blocks:
        for row in range(block[0], block[1]):
            total = 0.0
            for column in range(block[2], block[3]):
                total += (work.spread[row, column] + GAMMA * abs(work.middle[row, column])) * radius[column]
            work.sums[row] += total
    for row in range(size):
        _left_over(work, row)
        total = work.step[row] + GAMMA * radius[row]
        for k in range(size):
            total += abs(inverse[row, k]) * work.sums[k] + abs(work.entries[k]) * radius[k]
        work.bound[row] = total * ROUNDING + UNDERFLOW


@jit
def _left_over(work, row):
    """Write a row of I - Y J, with the middles of the Jacobian, to work.entries."""
    middle, inverse, entries = work.middle, work.inverse, work.entries
    entries[:] = 0.0
    entries[row] = 1.0
    for block in work.blocks:
        for k in range(block[0], block[1]):
            y = inverse[row, k]
            for column in range(block[2], block[3]):
                entries[column] -= y * middle[k, column]
