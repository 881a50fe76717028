"""Bounds of the second derivatives of a line's equations over a box, in the frame of its chord.

A line is stiff along its chord and soft across, so that its two equations for the end of a span, and its force on the
platform, are taken along the chord and across it. Tension is relative to the middle of the box, T = T_c (1 + theta),
where first derivatives by theta equal those by log T. Derivation: docs/theory/certificates.md.
"""

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.certificates.interval import (
    ONE,
    ZERO,
    add,
    cos,
    div,
    exp,
    inflate,
    mag,
    mul,
    neg,
    point,
    root,
    scale,
    sin,
    sqr,
    sub,
)
from cablewright.kernels.layout import (
    ARC_COMPLIANCE,
    BETA,
    DEAD,
    DEAD_COMPLIANCE,
    FREE,
    FREE_COMPLIANCE,
    LEVER,
    LEVER_MOMENT,
    MOUNT,
    PHI,
    PSI,
    PULLS,
    RADIUS,
    SPANS,
    TAU,
    UNKNOWNS,
    WEIGHT,
)

PI_UP = 3.1415926535897936
ALONG, ACROSS, LENGTH, DEAD_ALONG, DEAD_ACROSS, MOMENT, PULL, SHEAR, SIDEWAYS, TURNED = range(10)
ROWS = 10
# Variables besides the line's own unknowns: the end's motion away from the exit and sideways, the body's rotation.
AWAY, ASIDE, TURN = 6, 7, 8
VARIABLES = 9

PAIRS = np.array(
    [
        (PHI, PHI), (PHI, TAU), (TAU, TAU), (PHI, FREE), (TAU, FREE), (FREE, FREE),
        (PSI, PSI), (PSI, TAU), (PSI, DEAD), (TAU, DEAD), (DEAD, DEAD),
        (BETA, BETA), (PHI, BETA), (PSI, BETA), (TAU, BETA),
        (ASIDE, ASIDE), (AWAY, ASIDE), (PHI, ASIDE), (TAU, ASIDE),
        (TURN, TURN), (PHI, TURN), (TAU, TURN), (FREE, TURN), (ASIDE, TURN),
    ]
)  # fmt: skip
(
    PHI_PHI, PHI_TAU, TAU_TAU, PHI_FREE, TAU_FREE, FREE_FREE,
    PSI_PSI, PSI_TAU, PSI_DEAD, TAU_DEAD, DEAD_DEAD,
    BETA_BETA, PHI_BETA, PSI_BETA, TAU_BETA,
    ASIDE_ASIDE, AWAY_ASIDE, PHI_ASIDE, TAU_ASIDE,
    TURN_TURN, PHI_TURN, TAU_TURN, FREE_TURN, ASIDE_TURN,
) = range(24)  # fmt: skip
LITTLE, SOME = 0.05, 0.5  # weight over tension up to which a span is integrated in 1 or 4 parts; else 16
UP = 1.0 + 1e-13  # factor for a few roundings of nonnegative terms


@jit
def _chop(a):
    """Intersect a sine or cosine with [-1, 1]."""
    return (a[0] if a[0] > -1.0 else -1.0, a[1] if a[1] < 1.0 else 1.0)


@jit
def _local(alpha, cf, sf, along, across, ct, st):
    """Direction of the span where its weight is *alpha* start tensions, as sines and cosines, q and 1/q.

    The direction is relative to that at the start and to the frame; q is the tension there over that at the start.
    """
    forward = add(ONE, mul(alpha, sf))
    up = mul(alpha, cf)
    q = root(add(sqr(forward), sqr(up)))
    inverse = div(ONE, q)
    sx, cx = _chop(mul(up, inverse)), _chop(mul(forward, inverse))
    sd = _chop(mul(add(across, scale(alpha, ct)), inverse))
    cd = _chop(mul(add(along, scale(alpha, st)), inverse))
    return sx, cx, sd, cd, q, inverse


@jit
def _turned(t, n, cd, sd):
    """Components along and across the frame of the vector (*t*, *n*) along and across the span."""
    return sub(mul(t, cd), mul(n, sd)), add(mul(t, sd), mul(n, cd))


@jit
def bend_span(cf, sf, ct, st, tension, shrink, length, weight, compliance, out):
    """Write bounds of the second derivatives of a span's end point, along and across (ct, st), to *out* (2, 6).

    Columns: angle twice, angle and theta, theta twice, angle and length, theta and length, length twice.
    """
    along = add(scale(cf, ct), scale(sf, st))
    across = sub(scale(sf, ct), scale(cf, st))
    heavy = div(point(weight), tension)
    ratio = heavy[1] * length[1]
    parts = 1 if ratio < LITTLE else (4 if ratio < SOME else 16)
    pp_t, pp_n, pt_t, pt_n, tt_t, tt_n = ZERO, ZERO, ZERO, ZERO, ZERO, ZERO
    whole = mul(heavy, length)
    share = 1.0 / parts  # exact
    for j in range(parts):
        alpha = mul(whole, (j * share, (j + 1) * share))
        sx, cx, sd, cd, q, inverse = _local(alpha, cf, sf, along, across, ct, st)
        inverse2 = sqr(inverse)
        s2, sc = sqr(sx), mul(sx, cx)
        a = neg(mul(sqr(cx), inverse2))
        b = mul(mul(sx, sub(q, scale(cx, 2.0))), inverse2)
        t, n = _turned(a, b, cd, sd)
        pp_t, pp_n = add(pp_t, t), add(pp_n, n)
        a = mul(sc, inverse2)
        b = mul(add(scale(s2, 2.0), mul(alpha, sf)), inverse2)
        t, n = _turned(a, b, cd, sd)
        pt_t, pt_n = add(pt_t, t), add(pt_n, n)
        a = neg(mul(s2, inverse2))
        b = mul(scale(sc, 2.0), inverse2)
        t, n = _turned(a, b, cd, sd)
        tt_t, tt_n = add(tt_t, t), add(tt_n, n)
    strain = mul(point(compliance), tension)
    sa, sn = mul(strain, along), mul(strain, across)
    out[0, 0] = mag(mul(length, sub(scale(pp_t, share), sa)))
    out[1, 0] = mag(mul(length, sub(scale(pp_n, share), sn)))
    each = mul(length, shrink)
    out[0, 1] = mag(mul(each, sub(scale(pt_t, share), sn)))
    out[1, 1] = mag(mul(each, add(scale(pt_n, share), sa)))
    each = mul(each, shrink)
    out[0, 2] = mag(mul(each, scale(tt_t, share)))
    out[1, 2] = mag(mul(each, scale(tt_n, share)))
    sx, cx, sd, cd, q, inverse = _local(whole, cf, sf, along, across, ct, st)
    turn = mul(cx, inverse)
    out[0, 3] = mag(add(mul(turn, sd), sn))
    out[1, 3] = mag(add(mul(turn, cd), sa))
    turn = mul(sx, inverse)
    out[0, 4] = mag(mul(shrink, add(mul(turn, sd), sa)))
    out[1, 4] = mag(mul(shrink, sub(sn, mul(turn, cd))))
    turn = mul(mul(heavy, cf), sqr(inverse))
    grow = mul(point(weight), point(compliance))
    out[0, 5] = mag(sub(mul(grow, point(st)), mul(turn, sd)))
    out[1, 5] = mag(add(mul(grow, point(ct)), mul(turn, cd)))


@jit
def bend_line(row, y, box, reach, frame, eta, omega, arm, span, bends):
    """Write bounds of the second derivatives of a line's equations and force to *bends* (ROWS, pairs).

    *box* (9,): half widths of the unknowns (TAU: relative), of the end's motion away and sideways, of the rotation;
    *reach*: an interval, m; *frame*: direction of the chord and of the dead span; *eta* and *omega*: bounds of the
    rotations of the plane and of the body, rad; *arm*: distance of the platform point, m. False where one is not
    bounded.
    """
    bends[:, :] = 0.0
    unknowns = int(row[UNKNOWNS])
    grow = inflate(ONE, box[TAU])
    if not (grow[0] > 0.0 and reach[0] > 0.0):
        return False
    middle = exp(point(y[TAU]))
    t, shrink = mul(middle, grow), div(ONE, grow)
    ct, st = frame[0], frame[1]
    phi = inflate(point(y[PHI]), box[PHI])
    cf, sf = cos(phi), sin(phi)
    free = inflate(point(y[FREE]), box[FREE])
    if not (free[0] > 0.0 and omega <= 1.0):
        return False
    bend_span(cf, sf, ct, st, t, shrink, free, row[WEIGHT], row[FREE_COMPLIANCE], span)
    for k in range(6):
        bends[ALONG, k], bends[ACROSS, k] = span[0, k], span[1, k]
    along, across = mag(add(scale(cf, ct), scale(sf, st))), mag(sub(scale(sf, ct), scale(cf, st)))
    radius = row[RADIUS]
    bends[ALONG, PHI_PHI] += radius * across
    bends[ACROSS, PHI_PHI] += radius * along
    bends[ALONG, ASIDE_ASIDE] = abs(ct) / reach[0]
    bends[ACROSS, ASIDE_ASIDE] = abs(st) / reach[0]
    if row[ARC_COMPLIANCE] > 0.0:
        _bend_arc(row, y, box, mag(middle), bends)
    _bend_force(mag(cf), mag(sf), along, across, abs(ct), abs(st), mag(t), middle[1], reach[0], eta, bends)
    if unknowns > 3:
        _bend_dead(row, y, box, frame, t, shrink, span, bends)
        if unknowns > 5:
            _bend_lever(row, y, box, phi, frame, t, shrink, bends)
    if row[MOUNT] > 0.0:
        _bend_mount(row, y, box, mag(cf), mag(sf), along, across, frame, mag(t), middle[1], bends)
    if arm > 0.0:
        _bend_turn(row[WEIGHT], mag(cf), mag(t), middle[1], free[1], reach[0], eta, omega, arm, bends)
    for i in range(ROWS):
        factor = UP * row[PULLS] if i in (PULL, SHEAR, SIDEWAYS, TURNED) else UP
        for k in range(len(PAIRS)):
            bends[i, k] *= factor
            if not bends[i, k] < 1e300:
                return False
    return True


@jit
def _bend_arc(row, y, box, middle, bends):
    """Write the bounds for the unstrained length on the sheave, R wrap / (1 + c T)."""
    c, radius = row[ARC_COMPLIANCE] * middle, row[RADIUS]
    psi = abs(y[PSI]) + box[PSI] if row[UNKNOWNS] > 4.0 else 0.5 * PI_UP
    wrapped = PI_UP + psi + abs(y[PHI]) + box[PHI]
    bends[LENGTH, PHI_TAU] = radius * c
    bends[LENGTH, PSI_TAU] = radius * c
    bends[LENGTH, TAU_TAU] = 2.0 * radius * wrapped * c * c


@jit
def _bend_force(cf, sf, along, across, ct, st, t, middle, reach, eta, bends):
    """Write the bounds for the force h e + (v + w l) z: along the chord, across it in the plane, across the plane."""
    twist = 0.5 * eta * eta
    bends[PULL, PHI_PHI], bends[PULL, PHI_TAU] = t * (along + twist), middle * (across + twist)
    bends[SHEAR, PHI_PHI], bends[SHEAR, PHI_TAU] = t * (across + twist), middle * (along + twist)
    bends[SIDEWAYS, PHI_PHI], bends[SIDEWAYS, PHI_TAU] = eta * t * cf, eta * middle * sf
    h = t * cf
    aside, away, turn, lift = h / (reach * reach), h / (reach * reach), t * sf / reach, middle * cf / reach
    for which, share in ((PULL, ct), (SHEAR, st)):
        bends[which, ASIDE_ASIDE] = aside * share
        bends[which, AWAY_ASIDE] = eta * away
        bends[which, PHI_ASIDE] = eta * turn
        bends[which, TAU_ASIDE] = eta * lift
    bends[SIDEWAYS, ASIDE_ASIDE] = eta * aside
    bends[SIDEWAYS, AWAY_ASIDE] = away
    bends[SIDEWAYS, PHI_ASIDE] = turn
    bends[SIDEWAYS, TAU_ASIDE] = lift


@jit
def _bend_dead(row, y, box, frame, t, shrink, span, bends):
    """Write the bounds for the dead span, whose direction is an unknown if the line has five."""
    dt, ds = frame[2], frame[3]
    dead = inflate(point(y[DEAD]), box[DEAD])
    turning = row[UNKNOWNS] > 4.0
    cp, sp = point(dt), point(ds)
    if turning:
        psi = inflate(point(y[PSI]), box[PSI])
        cp, sp = cos(psi), sin(psi)
    bend_span(cp, sp, dt, ds, t, shrink, dead, row[WEIGHT], row[DEAD_COMPLIANCE], span)
    for which in range(2):
        at = DEAD_ALONG + which
        bends[at, TAU_TAU], bends[at, TAU_DEAD], bends[at, DEAD_DEAD] = span[which, 2], span[which, 4], span[which, 5]
        if turning:
            bends[at, PSI_PSI], bends[at, PSI_TAU], bends[at, PSI_DEAD] = span[which, 0], span[which, 1], span[which, 3]
    if turning:
        bends[DEAD_ALONG, PSI_PSI] += row[RADIUS] * mag(sub(scale(sp, dt), scale(cp, ds)))
        bends[DEAD_ACROSS, PSI_PSI] += row[RADIUS] * mag(add(scale(cp, dt), scale(sp, ds)))


@jit
def _bend_mount(row, y, box, cf, sf, along, across, frame, t, middle, bends):
    """Add the bounds for a compliant mount under T e of the free span, and in height under a dead span.

    A spring gives in proportion to the tension, and bends nothing.
    """
    soft = row[MOUNT] * row[PULLS]
    bends[ALONG, PHI_PHI] += soft * t * along
    bends[ACROSS, PHI_PHI] += soft * t * across
    bends[ALONG, PHI_TAU] += soft * middle * across
    bends[ACROSS, PHI_TAU] += soft * middle * along
    if row[UNKNOWNS] == 3.0:
        return
    bends[DEAD_ALONG, PHI_PHI] += soft * t * sf * abs(frame[3])
    bends[DEAD_ACROSS, PHI_PHI] += soft * t * sf * abs(frame[2])
    bends[DEAD_ALONG, PHI_TAU] += soft * middle * cf * abs(frame[3])
    bends[DEAD_ACROSS, PHI_TAU] += soft * middle * cf * abs(frame[2])
    if row[UNKNOWNS] > 4.0:
        psi = inflate(point(y[PSI]), box[PSI])
        turned, grown = soft / row[SPANS] * t * mag(sin(psi)), soft / row[SPANS] * middle * mag(cos(psi))
        for first in range(2):
            c, s = abs(frame[2 * first]), abs(frame[2 * first + 1])
            at = DEAD_ALONG if first else ALONG
            bends[at, PSI_PSI] += turned * s
            bends[at + 1, PSI_PSI] += turned * c
            bends[at, PSI_TAU] += grown * s
            bends[at + 1, PSI_TAU] += grown * c


@jit
def _bend_lever(row, y, box, phi, frame, t, shrink, bends):
    """Write the bounds for the lever: the position of its end, and the moment about the joint."""
    psi, beta = inflate(point(y[PSI]), box[PSI]), inflate(point(y[BETA]), box[BETA])
    cb, sb = cos(beta), sin(beta)
    lever = row[LEVER]
    for which in range(2):
        c, s = frame[2 * which], frame[2 * which + 1]
        at = 3 * which
        bends[at, BETA_BETA] = lever * mag(add(scale(cb, c), scale(sb, s)))
        bends[at + 1, BETA_BETA] = lever * mag(sub(scale(sb, c), scale(cb, s)))
    free, dead = sin(sub(phi, beta)), sin(sub(psi, beta))
    pull = div(point(row[LEVER_MOMENT]), mul(point(lever), t))
    bends[MOMENT, PHI_PHI] = bends[MOMENT, PHI_BETA] = mag(free)
    bends[MOMENT, PSI_PSI] = bends[MOMENT, PSI_BETA] = mag(dead)
    bends[MOMENT, BETA_BETA] = mag(sub(mul(pull, cb), add(free, dead)))
    pull = mul(pull, shrink)
    bends[MOMENT, TAU_BETA] = mag(mul(pull, sb))
    bends[MOMENT, TAU_TAU] = 2.0 * mag(mul(mul(pull, shrink), cb))


@jit
def _bend_turn(weight, cf, t, middle, free, reach, eta, omega, arm, bends):
    """Write the bounds due to a body's rotation: its points move on arcs, and the arms of moments with them."""
    arc = arm * (1.0 + 2.0 * omega)  # exp(omega) <= 1 + 2 omega for omega <= 1
    stiff = t * cf / reach
    bends[ALONG, TURN_TURN] = bends[ACROSS, TURN_TURN] = arc
    bends[SIDEWAYS, TURN_TURN] = stiff * arc
    bends[PULL, TURN_TURN] = bends[SHEAR, TURN_TURN] = eta * stiff * arc
    offset = arm * omega * (1.0 + omega)
    bends[TURNED, TURN_TURN] = arc * (t + weight * free) + offset * stiff * arc
    bends[TURNED, PHI_TURN], bends[TURNED, TAU_TURN] = arm * t, arm * middle
    bends[TURNED, FREE_TURN], bends[TURNED, ASIDE_TURN] = arm * weight, arm * stiff
    bends[TURNED, PHI_PHI], bends[TURNED, PHI_TAU] = offset * t, offset * middle
    bends[TURNED, PHI_ASIDE], bends[TURNED, TAU_ASIDE] = offset * t / reach, offset * middle / reach
    bends[TURNED, ASIDE_ASIDE] = bends[TURNED, AWAY_ASIDE] = offset * stiff / reach
