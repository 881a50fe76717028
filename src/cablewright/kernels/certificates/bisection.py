"""Choice of the direction in which a set of lengths is bisected, where no tube was proved or the tube is too wide."""

from cablewright.kernels import jit
from cablewright.kernels.certificates.branch_tube import UNBOUNDED, reach_now, slopes
from cablewright.kernels.certificates.jets import OWN
from cablewright.kernels.layout import GUIDE, STATE, TAU, UPRIGHT
from cablewright.kernels.statics.line.hessian_bounds import ASIDE, PAIRS, ROWS, TURN
from cablewright.kernels.statics.line.spatial_hessian_bounds import LOCAL_PAIRS

COUNTED = 6  # number of unknowns by which a bisection is judged


@jit
def worst_cut(packed, code, row, linear, slabs, cert, work):
    """Choose the slab or length to bisect: the one that reduces the width of *row*, or helps the proof, most.

    Returns the slab's index (0 to K - 1) or that of the length (from K). *row* < 0: nothing was proved, for the reason
    *code*. *linear*: the row is too wide by the linearisation, not by its error.
    """
    pulls = work.base  # no longer needed
    pulls[:] = 0.0
    if code == UNBOUNDED:
        for i in range(packed.lines.shape[0]):
            pulls[cert.offsets[i] + TAU] = work.reach[cert.offsets[i] + TAU]
    elif linear:
        pulls[row] = 1.0
    else:
        _pull_all(packed, _weakest(work) if row < 0 else row, cert, pulls, work)
    work.gains[:] = 0.0
    for _ in range(COUNTED):
        j = 0
        for k in range(pulls.shape[0]):
            if pulls[k] * work.reach[k] > pulls[j] * work.reach[j]:
                j = k
        if not pulls[j] > 0.0:
            break
        slopes(cert, j, work.row)
        for cut in range(work.gains.shape[0]):
            reach, balance = _halved(cut, slabs, work)
            work.gains[cut] += pulls[j] * (work.reach[j] - reach) * balance
        pulls[j] = 0.0
    best = 0
    for cut in range(work.gains.shape[0]):
        if work.gains[cut] > work.gains[best]:
            best = cut
    return best if work.gains[best] > 0.0 else _widest(work)


@jit
def _widest(work):
    """The length whose smaller side from the centre is widest."""
    best, widest = 0, -1.0
    for i in range(work.left.shape[0]):
        side = min(-work.left[i], work.right[i])
        if side > widest:
            best, widest = i, side
    return work.below.shape[0] + best


@jit
def _halved(cut, slabs, work):
    """Bound of |work.row . (L - L_c)| with a slab or length halved at the centre, and the share of its smaller part."""
    count = work.below.shape[0]
    if cut < count:
        low, high = 0.0, 0.0
        for i in range(work.left.shape[0]):
            a, b = slabs[cut, i] * work.left[i], slabs[cut, i] * work.right[i]
            low += min(a, b)
            high += max(a, b)
        first, last = work.below[cut], work.above[cut]
        low, high = max(low, first), min(high, last)
        work.below[cut], work.above[cut] = 0.5 * low, 0.5 * high
        reach = reach_now(slabs, work)
        work.below[cut], work.above[cut] = first, last
    else:
        low, high = work.left[cut - count], work.right[cut - count]
        work.left[cut - count], work.right[cut - count] = 0.5 * low, 0.5 * high
        reach = reach_now(slabs, work)
        work.left[cut - count], work.right[cut - count] = low, high
    return reach, max(0.0, min(-low, high)) / (high - low) if high > low else 0.0


@jit
def _weakest(work):
    """The unknown whose bound is largest relative to its reach."""
    worst, row = -1.0, 0
    for k in range(work.bound.shape[0]):
        ratio = work.bound[k] / (work.reach[k] + 1e-9)
        if ratio > worst:
            worst, row = ratio, k
    return row


@jit
def _pull_all(packed, row, cert, pulls, work):
    """Add the derivatives of the bound of unknown *row* by the half widths of all unknowns to *pulls*."""
    first = cert.offsets[packed.lines.shape[0]]
    for i in range(packed.lines.shape[0]):
        if packed.general is not None and packed.lines[i, GUIDE] != UPRIGHT:
            _pull_spatial(row, i, cert, pulls, work)
            continue
        ex, ey = abs(work.planes[i, 0]), abs(work.planes[i, 1])
        for k in range(len(PAIRS)):
            weight = _weight(row, i, k, work)
            for side in range(2):
                p, q = PAIRS[k, side], PAIRS[k, 1 - side]
                amount = weight * work.boxes[i, q]
                if (side == 1 and p == q) or amount == 0.0:
                    continue
                if p < STATE:
                    if p < cert.offsets[i + 1] - cert.offsets[i]:
                        pulls[cert.offsets[i] + p] += amount
                elif p == TURN:
                    for axis in range(3):
                        pulls[first + 3 + axis] += amount
                else:
                    pulls[first] += amount * (ey if p == ASIDE else ex)
                    pulls[first + 1] += amount * (ex if p == ASIDE else ey)


@jit
def _weight(row, i, k, work):
    """Effect of the second derivatives by pair *k* of line *i* on unknown *row*."""
    weight = 0.0
    for which in range(ROWS):
        weight += work.effects[row, i, which] * work.bends[i, which, k]
    return weight


@jit
def _pull_spatial(row, i, cert, pulls, work):
    """As `_pull_all`, of a line out of the plane."""
    start, rotations, size = cert.offsets[i], cert.offsets[-1] + 3, pulls.shape[0]
    for k in range(len(LOCAL_PAIRS)):
        p, q, weight = LOCAL_PAIRS[k, 0], LOCAL_PAIRS[k, 1], _weight(row, i, k, work)
        for one, other in ((p, q), (q, p)):
            at = start + one if one < OWN else rotations + one - OWN
            if at < size:
                pulls[at] += weight * work.boxes[i, other] * (0.5 if p == q else 1.0)
