"""A box that contains the pose for all cable lengths within given errors, proved by bisection of the lengths.

The box of lengths is bisected, by lengths and by slabs, until each part, a leaf, has a narrow enough tube
(`branch_tube.prove_tube`). The two halves share a point whose solution is certified and shown to be in both tubes. By
induction over the bisections the tubes enclose one continuous branch. Proof: docs/theory/certificates.md.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.certificates.bisection import worst_cut
from cablewright.kernels.certificates.branch_tube import PROVED, TubeWork, prove_tube, reach_towards, slopes, tube_work
from cablewright.kernels.certificates.interval import (
    GAMMA,
    ROUNDING,
    down,
    exp,
    inflate,
    mag,
    point,
    sub,
    up,
)
from cablewright.kernels.certificates.krawczyk import CERTIFIED, certify
from cablewright.kernels.certificates.length_polytope import centre_of, holds, offset
from cablewright.kernels.certificates.system_enclosure import (
    CertificateWork,
    certificate_pool,
    unfold,
)
from cablewright.kernels.dense_systems import copy, solve
from cablewright.kernels.layout import OK, STATE, TAU, UNKNOWNS
from cablewright.kernels.rotation import left_jacobian
from cablewright.kernels.statics.equilibrium import Work, refine, workspace
from cablewright.kernels.statics.line.spatial_hessian_bounds import between_spatial
from cablewright.kernels.statics.platform_enclosure import rotation_between, width_that_counts

COVERED, GOING, TOO_DEEP, NO_CENTRE, UNGLUED, HALF_TURN, UNCERTIFIED = 0, 1, 2, 3, 4, 5, 6
NO_SOLUTION, OTHER_BRANCH = -1, 9  # codes of a part, in addition to those of a tube
LEAVES, TESTS, DEPTH = 0, 1, 2  # entries of a tally
NEAR = 1e-6  # m: tolerance of a point's certificate, far above the usual bounds
FLOOR = 1e-10  # m, rad: min excess width that is tolerated
HALF = 3.1  # rad: rotation vectors are unique up to this angle


class Leaves(NamedTuple):
    """Stack of the parts of the box of lengths that are not proved yet, each with a solution of the branch in it."""

    low: NDArray[np.float64]  # (D, m)
    high: NDArray[np.float64]
    slab_low: NDArray[np.float64]  # (D, K)
    slab_high: NDArray[np.float64]
    share: NDArray[np.float64]  # (D,): of the whole box
    lengths: NDArray[np.float64]  # (D, m)
    pose: NDArray[np.float64]  # (D, n)
    states: NDArray[np.float64]  # (D, m, 6)
    unknowns: NDArray[np.float64]  # (D, N): as in a certificate
    bound: NDArray[np.float64]  # (D, N)
    known: NDArray[np.bool_]  # (D,): whether the solution is proved to be on the branch


class HullSearch(NamedTuple):
    """Constants, results and working memory of the search for the box of poses."""

    origin: NDArray[np.float64]  # (m,): the point where slabs are zero
    slabs: NDArray[np.float64]  # (K, m)
    pads: NDArray[np.float64]  # (K,): overlap of neighbours
    found: NDArray[np.float64]  # (4, n): min and max of known poses, then of the leaves' bounds
    centre: NDArray[np.float64]  # (m,)
    pose: NDArray[np.float64]  # (n,)
    states: NDArray[np.float64]  # (m, 6)
    ends: NDArray[np.float64]  # (2, n): of the leaf
    increment: NDArray[np.float64]  # (3, 6)
    jacobian: NDArray[np.float64]  # (3, 3)
    apart: NDArray[np.float64]  # (6, 2): of a line's unknowns
    cert: CertificateWork  # of the leaf
    own: CertificateWork  # of points
    tube: TubeWork
    newton: Work


@jit(allocates=True)
def part_list(deepest, size, m, n, slabs):
    """Allocate a stack of up to *deepest* parts of the lengths, for *size* unknowns."""
    return Leaves(
        np.zeros((deepest, m)),
        np.zeros((deepest, m)),
        np.zeros((deepest, slabs)),
        np.zeros((deepest, slabs)),
        np.ones(deepest),
        np.zeros((deepest, m)),
        np.zeros((deepest, n)),
        np.zeros((deepest, m, STATE)),
        np.zeros((deepest, size)),
        np.zeros((deepest, size)),
        np.zeros(deepest, dtype=np.bool_),
    )


@jit(allocates=True)
def search_of(packed, origin, slabs, pads, found):
    """Return a `HullSearch` with *slabs* (K, m) through *origin* (m,).

    *found* (4, n): see `HullSearch`.
    """
    m, n = packed.lines.shape[0], packed.freedoms
    cert, own = unfold(packed, certificate_pool(packed)), unfold(packed, certificate_pool(packed))
    return HullSearch(
        origin,
        slabs,
        pads,
        found,
        np.zeros(m),
        np.zeros(n),
        np.zeros((m, STATE)),
        np.zeros((2, n)),
        np.zeros((3, 6)),
        np.zeros((3, 3)),
        np.zeros((STATE, 2)),
        cert,
        own,
        tube_work(cert.step.shape[0], m, slabs.shape[0]),
        workspace(packed),
    )


@jit
def begin(nodes, low, high, reach, lengths, pose, states):
    """Start the search with the whole box of lengths from *low* to *high* and a solution in it.

    *reach* (K,): half widths of its slabs.
    """
    copy(low, nodes.low[0])
    copy(high, nodes.high[0])
    for k in range(reach.shape[0]):
        nodes.slab_low[0, k], nodes.slab_high[0, k] = -reach[k], reach[k]
    copy(lengths, nodes.lengths[0])
    copy(pose, nodes.pose[0])
    for i in range(states.shape[0]):
        copy(states[i], nodes.states[0, i])


@jit
def explore(packed, nodes, tally, upto, tolerance, search):
    """Continue the search until the box of lengths is covered or *upto* leaves are proved.

    Returns a code; the bounds of the pose are in search.found. A leaf is narrow enough if it exceeds the known poses by
    at most *tolerance*, a share of their width.
    """
    if tally[TESTS] == 0 and not _know(packed, nodes, 0, search):
        return UNCERTIFIED
    while tally[DEPTH] > 0:
        if tally[LEAVES] >= upto:
            return GOING
        at = tally[DEPTH] - 1
        if not nodes.known[at]:
            return UNGLUED
        tally[TESTS] += 1
        inside = _open(nodes, at, search)
        code = _prove(packed, nodes, at, search)
        row, linear = -1, False
        if code == PROVED:
            if not _measure(packed, search):
                return HALF_TURN
            row, linear = _too_wide(packed, tolerance, search)
            if row < 0:
                tally[LEAVES] += 1
                tally[DEPTH] -= 1
                if not _take(packed, nodes, at, search):
                    return UNGLUED
                continue
            row += search.cert.offsets[packed.lines.shape[0]]
        if code == NO_SOLUTION or not inside:
            return NO_CENTRE
        if at + 2 > nodes.low.shape[0]:
            return TOO_DEEP
        cut = worst_cut(packed, code, row, linear, search.slabs, search.cert, search.tube)
        _halve(nodes, at, cut, tally, search)
    return COVERED


@jit
def _open(nodes, at, search):
    """Find the part's centre, and write the part relative to it. Returns whether the centre is in it."""
    low, high, first, last = nodes.low[at], nodes.high[at], nodes.slab_low[at], nodes.slab_high[at]
    pads, known = search.pads, nodes.lengths[at]
    centre, tube = search.centre, search.tube
    inside = centre_of(low, high, first, last, search.slabs, search.origin, centre, pads, known)
    for i in range(centre.shape[0]):
        tube.left[i], tube.right[i] = low[i] - centre[i], high[i] - centre[i]
    for k in range(pads.shape[0]):  # slabs are widened by a pad on either side, and rounded outward
        position, bulk = offset(search.slabs, k, search.origin, centre)
        spare = pads[k] + GAMMA * bulk
        tube.below[k], tube.above[k] = first[k] - position - spare, last[k] - position + spare
    return inside


@jit
def _prove(packed, nodes, at, search):
    """Solve the centre, prove its tube, and that the part's known solution is in it. Returns a code."""
    copy(nodes.pose[at], search.pose)
    for i in range(search.states.shape[0]):
        copy(nodes.states[at, i], search.states[i])
    code, _, _ = refine(packed, search.centre, search.pose, search.states, search.newton)
    if code != OK:
        return NO_SOLUTION
    code = prove_tube(packed, search.centre, search.pose, search.states, search.slabs, search.cert, search.tube)
    if code == PROVED and not _is_in_tube(packed, nodes, at, search):
        return OTHER_BRANCH
    return code


@jit
def _measure(packed, search):
    """Write bounds of the leaf's poses to search.ends. False where a rotation is near half a turn."""
    m, n = packed.lines.shape[0], packed.freedoms
    first, cert, tube = search.cert.offsets[m], search.cert, search.tube
    for k in range(3):
        slopes(cert, first + k, tube.row)
        _add_ends(k, search.pose[k], tube.bound[first + k], search)
    if n == 3:
        return True
    left_jacobian(search.pose[3:], search.jacobian)
    size, turn = 0.0, 0.0
    for k in range(3):
        size += search.pose[3 + k] ** 2
        turn += (tube.reach[first + 3 + k] + tube.bound[first + 3 + k]) ** 2
        for j in range(3):
            search.increment[k, j] = 1.0 if k == j else 0.0
    if not sqrt(size) + 2.0 * sqrt(turn) < HALF or not solve(search.jacobian, search.increment, 3, 3):
        return False
    for k in range(3):
        spread = 1.05 * turn + 1e-13  # of the second order, docs/theory/certificates.md
        tube.row[:] = 0.0
        for j in range(3):
            share = search.increment[k, j]
            spread += abs(share) * (tube.bound[first + 3 + j] + 1e-13 * tube.reach[first + 3 + j])
            for i in range(m):
                tube.row[i] += share * cert.inverse[first + 3 + j, cert.offsets[i] + 2]
        _add_ends(3 + k, search.pose[3 + k], spread * ROUNDING, search)
    return True


@jit
def _add_ends(k, middle, spread, search):
    """Write bounds of pose coordinate *k*, which is *middle* plus tube.row per length, with the error *spread*."""
    low, high = reach_towards(-1.0, search.slabs, search.tube), reach_towards(1.0, search.slabs, search.tube)
    search.ends[0, k] = down(middle - up(low + spread))
    search.ends[1, k] = up(middle + up(high + spread))


@jit
def _too_wide(packed, tolerance, search):
    """The pose coordinate in which the leaf is too wide, or -1; and whether because of its linearisation alone.

    A plane leaves no width to some coordinates: there the widest of positions, or of rotations, counts.
    """
    worst, row, linear = 1.0, -1, False
    found, ends, first = search.found, search.ends, search.cert.step.shape[0] - search.pose.shape[0]
    for k in range(search.pose.shape[0]):
        found[0, k], found[1, k] = min(found[0, k], search.pose[k]), max(found[1, k], search.pose[k])
    for k in range(search.pose.shape[0]):
        allowed = 0.5 * tolerance * width_that_counts(packed.platform, found, k) + FLOOR
        beyond = max(found[0, k] - ends[0, k], ends[1, k] - found[1, k])
        if beyond > worst * allowed:
            worst, row, linear = beyond / allowed, k, search.tube.bound[first + k] < 0.5 * allowed
    return row, linear


@jit
def _take(packed, nodes, at, search):
    """Add a leaf to the bounds, and prove the solutions in it of parts still to do."""
    found, ends = search.found, search.ends
    for k in range(search.pose.shape[0]):
        found[2, k], found[3, k] = min(found[2, k], ends[0, k]), max(found[3, k], ends[1, k])
    low, high, first, last = nodes.low[at], nodes.high[at], nodes.slab_low[at], nodes.slab_high[at]
    for i in range(at):
        if nodes.known[i]:
            continue
        if not holds(low, high, first, last, search.slabs, search.origin, nodes.lengths[i], search.pads):
            continue
        if not (_know(packed, nodes, i, search) and _is_in_tube(packed, nodes, i, search)):
            return False
    return True


@jit
def _know(packed, nodes, i, search):
    """Certify the solution of a part."""
    code = certify(packed, nodes.lengths[i], nodes.pose[i], nodes.states[i], NEAR, search.own)
    copy(search.own.centre, nodes.unknowns[i])
    copy(search.own.bound, nodes.bound[i])
    nodes.known[i] = code == CERTIFIED
    return nodes.known[i]


@jit
def _halve(nodes, at, cut, tally, search):
    """Bisect a part at its centre. The half with the known solution is next; the other half gets the centre's."""
    count, up = search.slabs.shape[0], at + 1
    for each in (nodes.low, nodes.high, nodes.slab_low, nodes.slab_high, nodes.lengths, nodes.pose):
        copy(each[at], each[up])
    copy(nodes.unknowns[at], nodes.unknowns[up])
    copy(nodes.bound[at], nodes.bound[up])
    if cut < count:
        here, _ = offset(search.slabs, cut, search.origin, search.centre)
        known, _ = offset(search.slabs, cut, search.origin, nodes.lengths[at])
        _part(nodes.slab_low, nodes.slab_high, at, cut, here, known <= here)
    else:
        here = search.centre[cut - count]
        _part(nodes.low, nodes.high, at, cut - count, here, nodes.lengths[at, cut - count] <= here)
    nodes.share[at] *= 0.5
    nodes.share[up] = nodes.share[at]
    for i in range(nodes.low.shape[1]):
        copy(nodes.states[at, i], nodes.states[up, i])
        copy(search.states[i], nodes.states[at, i])
    copy(search.centre, nodes.lengths[at])
    copy(search.pose, nodes.pose[at])
    nodes.known[up], nodes.known[at] = True, False
    tally[DEPTH] += 1


@jit
def _part(low, high, at, k, here, lower):
    """Put the lower or upper half at *at* + 1; the other half stays at *at*."""
    if lower:
        high[at + 1, k], low[at, k] = here, here
    else:
        low[at + 1, k], high[at, k] = here, here


@jit
def _is_in_tube(packed, nodes, at, search):
    """Whether the known solution of part *at*, with its error bound, is in the tube."""
    lengths, other_pose, other_states = nodes.lengths[at], nodes.pose[at], nodes.states[at]
    bound = nodes.bound[at]
    pose, states, centre, cert, work = search.pose, search.states, search.centre, search.cert, search.tube
    m = packed.lines.shape[0]
    first = cert.offsets[m]
    for line in range(m):
        row, start, end = packed.lines[line], cert.offsets[line], cert.offsets[line + 1]
        own, known, middle = bound[start:end], nodes.unknowns[at, start:end], cert.centre[start:end]
        if between_spatial(packed.general, row, other_states[line], states[line], known, own, middle, search.apart):
            for k in range(end - start):
                off = (search.apart[k, 0], search.apart[k, 1])
                if not _is_near(off, start + k, lengths, centre, cert, work):
                    return False
            continue
        for k in range(int(row[UNKNOWNS])):
            j = start + k
            off = sub(inflate(point(other_states[line, k]), bound[j]), point(states[line, k]))
            if k == TAU:  # the tube has relative tensions
                off = sub(exp(off), (1.0, 1.0))
            if not _is_near(off, j, lengths, centre, cert, work):
                return False
    for k in range(3):
        off = sub(inflate(point(other_pose[k]), bound[first + k]), point(pose[k]))
        if not _is_near(off, first + k, lengths, centre, cert, work):
            return False
    rotations = rotation_between(other_pose, pose, bound[first:], cert.rotation, work.rotation, work.turned)
    for k in range(rotations):
        off = (work.turned[k, 0], work.turned[k, 1])
        if not _is_near(off, first + 3 + k, lengths, centre, cert, work):
            return False
    return True


@jit
def _is_near(off, j, lengths, centre, cert, work):
    """Whether *off*, the difference of unknown *j* from the centre's, is within the radius of the linearisation."""
    move, bulk = 0.0, 0.0
    for i in range(lengths.shape[0]):
        part = cert.inverse[j, cert.offsets[i] + 2] * (lengths[i] - centre[i])
        move += part
        bulk += abs(part)
    return mag(sub(off, (move, move))) + GAMMA * bulk < work.radius[j]
