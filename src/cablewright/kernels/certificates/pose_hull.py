"""A box that holds the pose for every lengths within some error: a box of lengths in leaves, each with a tube.

The box is halved again and again, by lengths and by slabs, until each part has a tube (`tube.prove_tube`) that is
narrow enough. Halves are glued at one point that both hold: the solution there is certified and shown to be in the
tubes of both. By induction over the halvings the tubes hold one continuous branch. Proof: docs/theory/certificates.md.
"""

from math import inf, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.certificates.bisection import worst_cut
from cablewright.kernels.certificates.branch_tube import PROVED, TubeWork, prove_tube, slopes, tube_work
from cablewright.kernels.certificates.interval import (
    GAMMA,
    ROUNDING,
    add,
    down,
    exp,
    inflate,
    mag,
    mul,
    point,
    scale,
    sqr,
    sub,
    up,
)
from cablewright.kernels.certificates.krawczyk import CERTIFIED, certify
from cablewright.kernels.certificates.length_polytope import centre_of, holds, most, offset
from cablewright.kernels.certificates.system_enclosure import (
    CertificateWork,
    certificate_pool,
    enclose_rotation,
    unfold,
)
from cablewright.kernels.layout import STATE, TAU, UNKNOWNS
from cablewright.kernels.newton import solve
from cablewright.kernels.rotation import left_jacobian
from cablewright.kernels.statics.equilibrium import OK, Work, refine, workspace

COVERED, GOING, TOO_DEEP, NO_CENTRE, UNGLUED, HALF_TURN, UNCERTIFIED = 0, 1, 2, 3, 4, 5, 6
NO_SOLUTION, OTHER_BRANCH = -1, 9  # of a part, besides those of a tube
LEAVES, TESTS, DEPTH = 0, 1, 2  # of a tally
NEAR = 1e-6  # m: far over what a point's certificate leaves open
FLOOR = 1e-10  # m, rad: of what a box may be too wide by
HALF = 3.1  # rad: rotation vectors up to here are no matter of which way round


class Leaves(NamedTuple):
    """The parts that are left to do: of each its set, and a solution of the branch that is in it."""

    low: NDArray[np.float64]  # (D, m)
    high: NDArray[np.float64]
    slab_low: NDArray[np.float64]  # (D, K)
    slab_high: NDArray[np.float64]
    share: NDArray[np.float64]  # (D,): of the whole
    lengths: NDArray[np.float64]  # (D, m)
    pose: NDArray[np.float64]  # (D, n)
    states: NDArray[np.float64]  # (D, m, 6)
    bound: NDArray[np.float64]  # (D, N)
    known: NDArray[np.bool_]  # (D,): whether the solution is proved to be of the branch


class HullSearch(NamedTuple):
    """What does not change, and scratch."""

    origin: NDArray[np.float64]  # (m,): where slabs are counted from
    slabs: NDArray[np.float64]  # (K, m)
    pads: NDArray[np.float64]  # (K,): by how much neighbours overlap
    found: NDArray[np.float64]  # (4, n): least and largest pose that is known; of the leaves
    centre: NDArray[np.float64]  # (m,)
    pose: NDArray[np.float64]  # (n,)
    states: NDArray[np.float64]  # (m, 6)
    ends: NDArray[np.float64]  # (2, n): of the leaf
    increment: NDArray[np.float64]  # (3, 6)
    jacobian: NDArray[np.float64]  # (3, 3)
    cert: CertificateWork  # of the leaf
    own: CertificateWork  # of points
    tube: TubeWork
    newton: Work


@jit(allocates=True)
def part_list(deepest, size, m, n, slabs):
    """Room for so many parts of *size* unknowns."""
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
        np.zeros(deepest, dtype=np.bool_),
    )


@jit(allocates=True)
def search_of(packed, origin, slabs, pads, found):
    """A search by *slabs* (K, m) from *origin* (m,). *found* (4, n): least and largest pose, known and proved."""
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
        cert,
        own,
        tube_work(cert.step.shape[0], m, slabs.shape[0]),
        workspace(packed),
    )


@jit
def begin(nodes, low, high, reach, lengths, pose, states):
    """Set the first part: the whole box from *low* to *high*, *reach* (K,) of its slabs, a solution in it."""
    _copy(low, nodes.low[0])
    _copy(high, nodes.high[0])
    for k in range(reach.shape[0]):
        nodes.slab_low[0, k], nodes.slab_high[0, k] = -reach[k], reach[k]
    _copy(lengths, nodes.lengths[0])
    _copy(pose, nodes.pose[0])
    for i in range(states.shape[0]):
        _copy(states[i], nodes.states[0, i])


@jit
def explore(packed, nodes, tally, upto, tolerance, search):
    """Go on until the box is covered or *upto* leaves are proved. Returns a code; the bounds are in search.found.

    A leaf is narrow enough if it is within *tolerance*, of the width, of poses that are known.
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
            row, linear = _too_wide(tolerance, search)
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
def _copy(source, target):
    for i in range(source.shape[0]):
        target[i] = source[i]


@jit
def _open(nodes, at, search):
    """Find the part's centre, and measure it from there. Whether the centre is in it."""
    low, high, first, last = nodes.low[at], nodes.high[at], nodes.slab_low[at], nodes.slab_high[at]
    pads, known = search.pads, nodes.lengths[at]
    inside = centre_of(low, high, first, last, search.slabs, search.origin, search.centre, pads, known)
    _measure_from(low, high, first, last, search.centre, search)
    return inside


@jit
def _measure_from(low, high, slab_low, slab_high, centre, search):
    """A set from *centre*, its slabs a pad wider on either side; outward."""
    tube = search.tube
    for i in range(centre.shape[0]):
        tube.left[i], tube.right[i] = low[i] - centre[i], high[i] - centre[i]
    for k in range(search.pads.shape[0]):
        at, bulk = offset(search.slabs, k, search.origin, centre)
        spare = search.pads[k] + GAMMA * bulk
        tube.below[k], tube.above[k] = slab_low[k] - at - spare, slab_high[k] - at + spare


@jit
def _prove(packed, nodes, at, search):
    """Solve the centre, prove its tube, and that the part's known solution is in it. Returns a code."""
    _copy(nodes.pose[at], search.pose)
    for i in range(search.states.shape[0]):
        _copy(nodes.states[at, i], search.states[i])
    code, _, _ = refine(packed, search.centre, search.pose, search.states, search.newton)
    if code != OK:
        return NO_SOLUTION
    code = prove_tube(packed, search.centre, search.pose, search.states, search.slabs, search.cert, search.tube)
    if code == PROVED and not _joins(packed, nodes, at, search):
        return OTHER_BRANCH
    return code


@jit
def _joins(packed, nodes, at, search):
    """Whether the solution of a part is in the tube."""
    return in_tube(packed, nodes.lengths[at], nodes.pose[at], nodes.states[at], nodes.bound[at], search)


@jit
def _measure(packed, search):
    """Bounds of the leaf's poses, to search.ends. False where a rotation comes near half a turn."""
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
        for i in range(m):
            tube.row[i] = 0.0
        for j in range(3):
            share = search.increment[k, j]
            spread += abs(share) * (tube.bound[first + 3 + j] + 1e-13 * tube.reach[first + 3 + j])
            for i in range(m):
                tube.row[i] += share * cert.inverse[first + 3 + j, cert.offsets[i] + 2]
        _add_ends(3 + k, search.pose[3 + k], spread * ROUNDING, search)
    return True


@jit
def _add_ends(k, middle, spread, search):
    """Bounds of pose coordinate *k*: from *middle* by tube.row per length, and *spread* more."""
    tube = search.tube
    high = most(tube.row, 1.0, tube.left, tube.right, search.slabs, tube.below, tube.above, tube.weights)
    low = most(tube.row, -1.0, tube.left, tube.right, search.slabs, tube.below, tube.above, tube.weights)
    search.ends[0, k] = down(middle - up(low + spread))
    search.ends[1, k] = up(middle + up(high + spread))


@jit
def _too_wide(tolerance, search):
    """The pose coordinate by which the leaf is too wide, or -1; and whether by its linearisation alone."""
    worst, row, linear = 1.0, -1, False
    found, ends, first = search.found, search.ends, search.cert.step.shape[0] - search.pose.shape[0]
    for k in range(search.pose.shape[0]):
        found[0, k], found[1, k] = min(found[0, k], search.pose[k]), max(found[1, k], search.pose[k])
        allowed = 0.5 * tolerance * (found[1, k] - found[0, k]) + FLOOR
        beyond = max(found[0, k] - ends[0, k], ends[1, k] - found[1, k])
        if beyond > worst * allowed:
            worst, row, linear = beyond / allowed, k, search.tube.bound[first + k] < 0.5 * allowed
    return row, linear


@jit
def _take(packed, nodes, at, search):
    """Count a leaf in, and prove the solutions of parts still to do that are in it."""
    found, ends = search.found, search.ends
    for k in range(search.pose.shape[0]):
        found[2, k], found[3, k] = min(found[2, k], ends[0, k]), max(found[3, k], ends[1, k])
    low, high, first, last = nodes.low[at], nodes.high[at], nodes.slab_low[at], nodes.slab_high[at]
    for i in range(at):
        if nodes.known[i]:
            continue
        if not holds(low, high, first, last, search.slabs, search.origin, nodes.lengths[i], search.pads):
            continue
        if not (_know(packed, nodes, i, search) and _joins(packed, nodes, i, search)):
            return False
    return True


@jit
def _know(packed, nodes, i, search):
    """Certify the solution of a part."""
    code = certify(packed, nodes.lengths[i], nodes.pose[i], nodes.states[i], NEAR, search.own)
    _copy(search.own.bound, nodes.bound[i])
    nodes.known[i] = code == CERTIFIED
    return nodes.known[i]


@jit
def _halve(nodes, at, cut, tally, search):
    """Cut a part through its centre. The half with the known solution comes next; the centre is the other's."""
    count, up = search.slabs.shape[0], at + 1
    _copy(nodes.low[at], nodes.low[up])
    _copy(nodes.high[at], nodes.high[up])
    _copy(nodes.slab_low[at], nodes.slab_low[up])
    _copy(nodes.slab_high[at], nodes.slab_high[up])
    if cut < count:
        here, _ = offset(search.slabs, cut, search.origin, search.centre)
        known, _ = offset(search.slabs, cut, search.origin, nodes.lengths[at])
        _part(nodes.slab_low, nodes.slab_high, at, cut, here, known <= here)
    else:
        here = search.centre[cut - count]
        _part(nodes.low, nodes.high, at, cut - count, here, nodes.lengths[at, cut - count] <= here)
    nodes.share[at] *= 0.5
    nodes.share[up] = nodes.share[at]
    _copy(nodes.lengths[at], nodes.lengths[up])
    _copy(nodes.pose[at], nodes.pose[up])
    _copy(nodes.bound[at], nodes.bound[up])
    for i in range(nodes.low.shape[1]):
        _copy(nodes.states[at, i], nodes.states[up, i])
        _copy(search.states[i], nodes.states[at, i])
    _copy(search.centre, nodes.lengths[at])
    _copy(search.pose, nodes.pose[at])
    nodes.known[up], nodes.known[at] = True, False
    tally[DEPTH] += 1


@jit
def _part(low, high, at, k, here, lower):
    """The lower half above *at*, or the upper one; what is left stays at *at*."""
    if lower:
        high[at + 1, k], low[at, k] = here, here
    else:
        low[at + 1, k], high[at, k] = here, here


@jit
def in_tube(packed, lengths, other_pose, other_states, bound, search):
    """Whether all within *bound* of a solution for *lengths*, a point of the set, is in the tube."""
    pose, states, centre, cert, work = search.pose, search.states, search.centre, search.cert, search.tube
    m, n = packed.lines.shape[0], packed.freedoms
    first = cert.offsets[m]
    for line in range(m):
        for k in range(int(packed.lines[line, UNKNOWNS])):
            j = cert.offsets[line] + k
            off = sub(inflate(point(other_states[line, k]), bound[j]), point(states[line, k]))
            if k == TAU:  # counts relative in the tube
                off = sub(exp(off), (1.0, 1.0))
            if not _is_near(off, j, lengths, centre, cert, work):
                return False
    for k in range(3):
        off = sub(inflate(point(other_pose[k]), bound[first + k]), point(pose[k]))
        if not _is_near(off, first + k, lengths, centre, cert, work):
            return False
    if n == 6:
        _turn_between(other_pose, pose, bound, first, cert, work)
        for k in range(3):
            off = (work.turned[k, 0], work.turned[k, 1])
            if not _is_near(off, first + 3 + k, lengths, centre, cert, work):
                return False
    return True


@jit
def _is_near(off, j, lengths, centre, cert, work):
    """Whether *off*, from the centre's, is within the radius of the linearisation."""
    move, bulk = 0.0, 0.0
    for i in range(lengths.shape[0]):
        part = cert.inverse[j, cert.offsets[i] + 2] * (lengths[i] - centre[i])
        move += part
        bulk += abs(part)
    return mag(sub(off, (move, move))) + GAMMA * bulk < work.radius[j]


@jit
def _turn_between(other, pose, bound, first, cert, work):
    """Enclose the rotation vectors from *pose* to all within *bound* of *other*, to work.turned."""
    a, b, spare = cert.rotation, work.rotation, 0.0
    enclose_rotation(other, a)
    enclose_rotation(pose, b)
    trace, square = (0.0, 0.0), (0.0, 0.0)
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        trace = add(trace, _product(a, b, k, k))
        sine = scale(sub(_product(a, b, j, i), _product(a, b, i, j)), 0.5)
        work.turned[k, 0], work.turned[k, 1] = sine
        square = add(square, sqr(sine))
        spare += 1.6 * bound[first + 3 + k] * ROUNDING  # a rotation's vector grows by pi/2 of what it is turned
    small = trace[0] > 1.0 and square[1] < 0.25  # asin(s) / s < 1 + s^2 there
    for k in range(3):
        off = mul((work.turned[k, 0], work.turned[k, 1]), (1.0, 1.0 + 1.01 * square[1]))
        work.turned[k, 0], work.turned[k, 1] = inflate(off, spare) if small else (-inf, inf)


@jit
def _product(a, b, i, j):
    """Entry of A B^T."""
    total = (0.0, 0.0)
    for k in range(3):
        total = add(total, mul((a[i, k, 0], a[i, k, 1]), (b[j, k, 0], b[j, k, 1])))
    return total
