"""Proof that each vector of lengths in a set has exactly one equilibrium in a tube around the linearisation.

With F the equations, L their lengths, x a solution at L_c, Y an approximate inverse of its Jacobian J, S = -Y F_L, and
H bounds of all second derivatives within a + r, where a bounds |S (L - L_c)| over the set, let

    k = |Y F(x)| + |I - Y J| (a + r) + |Y| H[a + r, a + r] / 2
    u = |Y F(x)| + |I - Y J| (a + r) + |Y| H[a + r, r]

If k < r and u < r, then for each L of the set F has exactly one zero within r of x + S (L - L_c), and that zero is
within k of it. Proof: docs/theory/certificates.md. The products with Y are taken in each line's own frame.
"""

from math import cos, sin, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.certificates.interval import ROUNDING, inflate, point
from cablewright.kernels.certificates.jets import OWN
from cablewright.kernels.certificates.krawczyk import image, invert, newton_bound, split
from cablewright.kernels.certificates.length_polytope import upper_bound
from cablewright.kernels.certificates.system_enclosure import jacobian_of_all, place_line, residual_of_all
from cablewright.kernels.dense_systems import copy
from cablewright.kernels.layout import (
    BETA,
    GUIDE,
    LEVER,
    MASS_X,
    PHI,
    PLATFORM_WEIGHT,
    PSI,
    RADIUS,
    SIDE,
    STATE,
    UNKNOWNS,
    UPRIGHT,
)
from cablewright.kernels.statics.line.hessian_bounds import (
    ACROSS,
    ALONG,
    ASIDE,
    AWAY,
    DEAD_ACROSS,
    DEAD_ALONG,
    LENGTH,
    MOMENT,
    PAIRS,
    PULL,
    ROWS,
    SHEAR,
    SIDEWAYS,
    TURN,
    TURN_TURN,
    TURNED,
    VARIABLES,
    bend_line,
)
from cablewright.kernels.statics.line.spatial_hessian_bounds import (
    LOCAL_PAIRS,
    bend_spatial,
    box_spatial,
    frame_spatial,
    share_spatial,
)
from cablewright.kernels.statics.platform_enclosure import (
    bend_of_tilt,
    enclose_arm,
    rotation_of,
    share_balance,
    turning_arm,
)

PROVED, NOT_CONTRACTING, UNBOUNDED, SINGULAR = 0, 1, 2, 3
MARGIN = 0.25  # of the reach: initial margin of the box of second derivatives around it
MORE = 1.6  # factor on the required margin in the next try
TRIES = 4
STEPS = 12
HOPELESS = 1e3
WIDER = 1.05
GRAIN = 1e-10  # of an unknown: min radius in addition to the error bound of the centre's solution
SIDE_SLACK = 1e-14


class TubeWork(NamedTuple):
    """Working memory of the proof of one tube, for N unknowns as in `CertificateWork` and K slabs."""

    left: NDArray[np.float64]  # (m,): lower ends of the set's lengths, relative to the centre
    right: NDArray[np.float64]  # (m,): upper ends
    below: NDArray[np.float64]  # (K,): lower ends of its slabs, relative to the centre
    above: NDArray[np.float64]  # (K,): upper ends
    weights: NDArray[np.float64]  # (K,)
    row: NDArray[np.float64]  # (m,)
    reach: NDArray[np.float64]  # (N + 2m,): a; then of each line's end, away from the exit and sideways
    gains: NDArray[np.float64]  # (K + m,): benefit of halving each slab and length
    margin: NDArray[np.float64]  # (N,): largest r for which the second derivatives are valid
    radius: NDArray[np.float64]  # (N,): r
    bound: NDArray[np.float64]  # (N,): k
    base: NDArray[np.float64]  # (N,): the part of k without second derivatives
    planes: NDArray[np.float64]  # (m, 4): ex, ey, distance from the exit, of the platform point from the origin
    arms: NDArray[np.float64]  # (m, 3)
    frames: NDArray[np.float64]  # (m, 4): of the chord and of the dead span
    axes: NDArray[np.float64]  # (m, 3, 3): of a line out of the plane, along the chord and across
    turns: NDArray[np.float64]  # (m,): bounds of the planes' rotations, rad
    boxes: NDArray[np.float64]  # (m, 9): a + r in the variables of each line
    radii: NDArray[np.float64]  # (m, 9): r in the variables of each line
    bends: NDArray[np.float64]  # (m, rows, pairs): H
    curved: NDArray[np.float64]  # (m, rows)
    effects: NDArray[np.float64]  # (N, m, rows): |Y|
    span: NDArray[np.float64]  # (2, 6)
    wrench: NDArray[np.float64]  # (6,): entries of Y at the balance
    rotation: NDArray[np.float64]  # (3, 3, 2)
    turned: NDArray[np.float64]  # (3, 2)


@jit(allocates=True)
def tube_work(size, m, slabs):
    """Allocate a `TubeWork` for *size* unknowns, *m* lines and a number of slabs."""
    return TubeWork(
        np.zeros(m),
        np.zeros(m),
        np.zeros(slabs),
        np.zeros(slabs),
        np.zeros(slabs),
        np.zeros(m),
        np.zeros(size + 2 * m),
        np.zeros(slabs + m),
        np.zeros(size),
        np.zeros(size),
        np.zeros(size),
        np.zeros(size),
        np.zeros((m, 4)),
        np.zeros((m, 3)),
        np.zeros((m, 4)),
        np.zeros((m, 3, 3)),
        np.zeros(m),
        np.zeros((m, VARIABLES)),
        np.zeros((m, VARIABLES)),
        np.zeros((m, ROWS, len(LOCAL_PAIRS))),
        np.zeros((m, ROWS)),
        np.zeros((size, m, ROWS)),
        np.zeros((2, 6)),
        np.zeros(6),
        np.zeros((3, 3, 2)),
        np.zeros((3, 2)),
    )


@jit
def prove_tube(packed, lengths, pose, states, slabs, cert, work):
    """Prove that each vector of lengths has exactly one equilibrium within work.radius of the linearisation.

    *pose* and *states* are the solution for *lengths*, the set's centre; work.left to work.above are the set relative
    to it. If PROVED is returned, work.bound bounds the distance of the equilibrium from the linearisation, whose slopes
    are columns of cert.inverse.
    """
    size = cert.step.shape[0]
    residual_of_all(packed, lengths, pose, states, cert)
    cert.radius[:] = 0.0
    jacobian_of_all(packed, pose, states, cert)
    if not (split(cert) and _frame_lines(packed, pose, states, cert, work)):
        return UNBOUNDED
    if not invert(packed, cert):
        return SINGULAR
    if not newton_bound(cert):
        return UNBOUNDED
    _reach(packed, slabs, cert, work)
    _find_effects(packed, cert, work)
    for k in range(size):
        work.margin[k] = MARGIN * work.reach[k] + 10.0 * (cert.step[k] + GRAIN)
    for tried in range(TRIES):
        for k in range(size):
            cert.radius[k] = (work.reach[k] + work.margin[k]) * ROUNDING
        image(cert)
        copy(cert.bound, work.base)
        if not _bend_all(packed, pose, states, cert, work):
            return UNBOUNDED
        if _settles(packed, cert, work):
            return PROVED
        for k in range(size):
            if not work.bound[k] < HOPELESS:
                return UNBOUNDED if tried == 0 else NOT_CONTRACTING
            work.margin[k] = max(work.margin[k], MORE * work.bound[k])
    return NOT_CONTRACTING


@jit
def _frame_lines(packed, pose, states, cert, work):
    """Write planes, arms and chords at the centre; False under an exit point."""
    n = packed.freedoms
    first = cert.offsets[packed.lines.shape[0]]
    for i in range(packed.lines.shape[0]):
        row, y = packed.lines[i], states[i]
        work.planes[i, 3] = turning_arm(packed, row)
        if frame_spatial(packed.general, row, y, work.axes[i]):
            enclose_arm(row, n, 0.0, cert.rotation, cert.arm)
            _write_arm(cert, work.arms[i])
            continue
        ex, ey, reach, z = place_line(row, pose, 0.0, n, cert.radius[first:], cert)
        if not reach[0] > 0.0:
            return False
        work.planes[i, 0], work.planes[i, 1] = 0.5 * (ex[0] + ex[1]), 0.5 * (ey[0] + ey[1])
        work.planes[i, 2] = reach[0]
        _write_arm(cert, work.arms[i])
        turn, unknowns = row[SIDE] * row[RADIUS], row[UNKNOWNS]
        lever = row[LEVER] if unknowns > 5.0 else 0.0
        cx = reach[0] - lever * cos(y[BETA]) + turn * sin(y[PHI])
        cz = z[0] - lever * sin(y[BETA]) - turn * cos(y[PHI])
        chord = sqrt(cx * cx + cz * cz)
        work.frames[i, 0], work.frames[i, 1] = cx / chord, cz / chord
        work.frames[i, 2], work.frames[i, 3] = 0.0, -row[SIDE]
        if unknowns > 4.0:
            work.frames[i, 2], work.frames[i, 3] = cos(y[PSI]), sin(y[PSI])
    return True


@jit
def _write_arm(cert, arm):
    for k in range(3):
        arm[k] = 0.5 * (cert.arm[k, 0] + cert.arm[k, 1])


@jit
def _reach(packed, slabs, cert, work):
    """Bound the linearisation over the set: each unknown, and each line's end in its plane and sideways."""
    m, size = packed.lines.shape[0], cert.step.shape[0]
    for j in range(size):
        slopes(cert, j, work.row)
        work.reach[j] = reach_now(slabs, work)
    for line in range(m):
        ex, ey = work.planes[line, 0], work.planes[line, 1]
        slack = _end_slopes(packed, line, ex, ey, cert, work)
        work.reach[size + 2 * line] = reach_now(slabs, work) + slack
        slack = _end_slopes(packed, line, -ey, ex, cert, work)
        work.reach[size + 2 * line + 1] = reach_now(slabs, work) + slack


@jit
def slopes(cert, j, row):
    """Write the derivatives of unknown *j* by the lengths to *row*: entries of the approximate inverse Y."""
    for i in range(row.shape[0]):
        row[i] = cert.inverse[j, cert.offsets[i] + 2]


@jit
def _end_slopes(packed, line, a, b, cert, work):
    """Write the motion of the line's end along the horizontal (a, b) per length to work.row; returns its rounding."""
    first, bulk = cert.offsets[packed.lines.shape[0]], 0.0
    for i in range(packed.lines.shape[0]):
        at, far = cert.offsets[i] + 2, max(abs(work.left[i]), abs(work.right[i]))
        x, y = cert.inverse[first, at], cert.inverse[first + 1, at]
        bulk += (abs(x) + abs(y)) * far
        p, q, r = rotation_of(cert.inverse[first:, at], packed.freedoms)
        arm = work.arms[line]
        x += q * arm[2] - r * arm[1]
        y += r * arm[0] - p * arm[2]
        bulk += 2.0 * work.planes[line, 3] * (abs(p) + abs(q) + abs(r)) * far
        work.row[i] = a * x + b * y
    return SIDE_SLACK * bulk


@jit
def reach_now(slabs, work):
    """Return a bound of the change |work.row . (L - L_c)| of a linear function over the set of lengths L."""
    return max(reach_towards(-1.0, slabs, work), reach_towards(1.0, slabs, work))


@jit
def reach_towards(sign, slabs, work):
    """Return an upper bound of *sign* * work.row . (L - L_c), a linear function, over the set of lengths L."""
    return upper_bound(work.row, sign, work.left, work.right, slabs, work.below, work.above, work.weights)


@jit
def _find_effects(packed, cert, work):
    """Write |Y| for each unknown and each equation of a line in the line's frame."""
    m, n = packed.lines.shape[0], packed.freedoms
    first, wrench = cert.offsets[m], work.wrench
    for k in range(cert.step.shape[0]):
        row = cert.inverse[k]
        bulk, tilt = share_balance(packed.general, packed.platform, row[first:], wrench)
        for i in range(m):
            start, unknowns = cert.offsets[i], int(packed.lines[i, UNKNOWNS])
            frame, arm, out = work.frames[i], work.arms[i], work.effects[k, i]
            a, b, c = rotation_of(wrench[0::1], n)  # with a step Numba has one type for rows and columns
            turned = sqrt(a * a + b * b + c * c) * ROUNDING
            slack, end = bulk + 6.0 * turned * work.planes[i, 3], cert.offsets[i + 1]
            own = row[start:end]
            if share_spatial(packed.general, packed.lines[i], own, wrench, turned, slack, arm, work.axes[i], out):
                continue
            _turn_effect(row[start], row[start + 1], frame[0], frame[1], ALONG, ACROSS, 0.0, out)
            out[LENGTH] = abs(row[start + 2])
            z = row[start + 3] if unknowns > 3 else 0.0
            x = row[start + 4] if unknowns > 4 else 0.0
            _turn_effect(x, z, frame[2], frame[3], DEAD_ALONG, DEAD_ACROSS, 0.0, out)
            out[MOMENT] = abs(row[start + 5]) if unknowns > 5 else 0.0
            x, y, z = wrench[0], wrench[1], wrench[2]
            out[TURNED] = turned
            x += b * arm[2] - c * arm[1]
            y += c * arm[0] - a * arm[2]
            z += a * arm[1] - b * arm[0]
            ex, ey = work.planes[i, 0], work.planes[i, 1]
            _turn_effect(ex * x + ey * y, z, frame[0], frame[1], PULL, SHEAR, slack, out)
            out[SIDEWAYS] = abs(ex * y - ey * x) + 4e-15 * slack
        work.effects[k, 0, TURNED] += tilt * ROUNDING  # of the plane's rows, whose bend is in the first line's


@jit
def _turn_effect(x, z, c, s, along, across, slack, out):
    """Write the absolute entries along and across (c, s) from those of equations in x and z; 4e-15 covers rounding."""
    slack = 4e-15 * (abs(x) + abs(z) + slack)
    out[along], out[across] = abs(c * x + s * z) + slack, abs(c * z - s * x) + slack


@jit
def _find_boxes(packed, whole, radius, cert, work, boxes):
    """Write *radius*, if *whole* plus the reach, in each line's variables; returns the body's whole rotation, rad."""
    m, n, size = packed.lines.shape[0], packed.freedoms, cert.step.shape[0]
    first = cert.offsets[m]
    omega, wide = 0.0, 0.0
    for k in range(first + 3, first + n):
        omega += radius[k] ** 2
        wide += (radius[k] + work.reach[k]) ** 2
    omega, wide = sqrt(omega) * ROUNDING, sqrt(wide) * ROUNDING
    own = wide if whole else omega
    for i in range(m):
        row, box = packed.lines[i], boxes[i]
        start, end = cert.offsets[i], cert.offsets[i + 1]
        if box_spatial(packed.general, row, start, end, first, radius, work.reach, whole, box):
            continue
        for k in range(STATE):
            box[k] = 0.0
        for k in range(int(row[UNKNOWNS])):
            at = cert.offsets[i] + k
            box[k] = radius[at] + (work.reach[at] if whole else 0.0)
        ex, ey, arm = abs(work.planes[i, 0]), abs(work.planes[i, 1]), work.planes[i, 3]
        more = arm * (omega + 1.5 * wide * own)  # motion of the end by the rotation of its arm
        away = ex * radius[first] + ey * radius[first + 1] + more
        aside = ey * radius[first] + ex * radius[first + 1] + more
        if whole:
            away += work.reach[size + 2 * i]
            aside += work.reach[size + 2 * i + 1]
        eta = work.turns[i]  # the plane rotates too
        box[AWAY], box[ASIDE], box[TURN] = (away + eta * aside) * ROUNDING, (aside + eta * away) * ROUNDING, own
    return wide


@jit
def _bend_all(packed, pose, states, cert, work):
    """Bound the second derivatives of all equations over reach and margin; False where one is not bounded."""
    m = packed.lines.shape[0]
    work.turns[:] = 0.0
    omega = _find_boxes(packed, True, work.margin, cert, work, work.boxes)
    for i in range(m):
        if packed.general is not None and packed.lines[i, GUIDE] != UPRIGHT:
            continue
        near = work.planes[i, 2] - work.boxes[i, AWAY] - work.boxes[i, ASIDE]
        work.turns[i] = work.boxes[i, ASIDE] / near * ROUNDING + 1e-13
        if not (near > 0.0 and work.turns[i] < 0.5):
            return False
    _find_boxes(packed, True, work.margin, cert, work, work.boxes)
    for i in range(m):
        row, y, box, frame, eta = packed.lines[i], states[i], work.boxes[i], work.frames[i], work.turns[i]
        bounded = bend_spatial(packed.general, row, y, i, pose, omega, cert, work)
        if bounded >= 0:
            if bounded == 0:
                return False
            continue
        reach = inflate(point(work.planes[i, 2]), box[AWAY] + box[ASIDE])
        if not bend_line(row, y, box, reach, frame, eta, omega, work.planes[i, 3], work.span, work.bends[i]):
            return False
    body = packed.platform
    arm = sqrt(body[MASS_X] ** 2 + body[MASS_X + 1] ** 2 + body[MASS_X + 2] ** 2)  # 0 of a point
    moment = body[PLATFORM_WEIGHT] * arm + bend_of_tilt(packed)
    moment *= (1.0 + 2.0 * omega) * ROUNDING
    if packed.general is not None and packed.lines[0, GUIDE] != UPRIGHT:
        for k in range(len(LOCAL_PAIRS)):
            work.bends[0, TURNED, k] += moment if LOCAL_PAIRS[k, 0] >= OWN else 0.0
    else:
        work.bends[0, TURNED, TURN_TURN] += moment
    return True


@jit
def _settles(packed, cert, work):
    """Find radii r within the margin with k < r and u < r; False if there are none."""
    size = cert.step.shape[0]
    work.radius[:] = 0.0
    good = False
    for _ in range(STEPS):
        _find_boxes(packed, True, work.radius, cert, work, work.boxes)
        _curve(packed, work.boxes, work.boxes, 0.5, work)
        good, fits = True, True
        for k in range(size):
            work.bound[k] = _image_of(k, work)
            good = good and work.bound[k] < work.radius[k]
            fits = fits and work.bound[k] <= work.margin[k]
        if good or not fits:
            break
        for k in range(size):
            work.radius[k] = min(work.margin[k], WIDER * work.bound[k] + 2.0 * cert.step[k] + GRAIN)
    if not good:
        return False
    _find_boxes(packed, False, work.radius, cert, work, work.radii)
    _curve(packed, work.boxes, work.radii, 1.0, work)
    for k in range(size):
        if not _image_of(k, work) < work.radius[k]:
            return False
    return True


@jit
def _curve(packed, first, second, factor, work):
    """Write *factor* H[first, second] of each line to work.curved."""
    work.curved[:, :] = 0.0
    for i in range(first.shape[0]):
        if packed.general is not None and packed.lines[i, GUIDE] != UPRIGHT:
            _curve_line(LOCAL_PAIRS, first[i], second[i], factor, work.bends[i], work.curved[i])
        else:
            _curve_line(PAIRS, first[i], second[i], factor, work.bends[i], work.curved[i])


@jit
def _curve_line(pairs, a, b, factor, bends, out):
    for k in range(len(pairs)):
        p, q = pairs[k, 0], pairs[k, 1]
        product = a[p] * b[p] if p == q else a[p] * b[q] + a[q] * b[p]
        if product > 0.0:
            for row in range(ROWS):
                out[row] += bends[row, k] * product
    for row in range(ROWS):
        out[row] *= factor


@jit
def _image_of(k, work):
    """Bound of unknown *k*: its base and |Y| times work.curved."""
    total = work.base[k]
    for i in range(work.curved.shape[0]):
        for row in range(ROWS):
            total += work.effects[k, i, row] * work.curved[i, row]
    return total * ROUNDING
