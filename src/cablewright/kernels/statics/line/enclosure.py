"""Interval enclosures of the equations of a line in a vertical plane and of their Jacobian.

The formulas are those of `line.system`, also of springs and compliant mounts, with every operation rounded outward. The
packed doubles are taken as exact model data; pi and the direction of a vertical dead span are enclosed.
"""

from cablewright.kernels import jit
from cablewright.kernels.certificates.interval import (
    HALF_PI,
    ONE,
    PI,
    ZERO,
    add,
    cos,
    div,
    exp,
    inflate,
    log1p_ratio,
    mul,
    neg,
    point,
    root,
    sin,
    sqr,
    sub,
)
from cablewright.kernels.layout import (
    ARC_COMPLIANCE,
    BETA,
    DEAD,
    DEAD_COMPLIANCE,
    DEAD_LENGTH,
    END_SPRING,
    FREE,
    FREE_COMPLIANCE,
    LEVER,
    LEVER_MOMENT,
    MOUNT,
    PHI,
    PSI,
    PULLS,
    RADIUS,
    SIDE,
    SPANS,
    TAU,
    UNKNOWNS,
    WEIGHT,
    WINCH_X,
    WINCH_Z,
)
from cablewright.kernels.statics.line.upright import is_slack

ENCLOSABLE, SLACK = 0, 4  # codes of a line, which are those of a certificate


@jit
def enclosable(row, y):
    """Return ENCLOSABLE, or a code of why these equations do not describe the line with the unknowns *y*."""
    return SLACK if is_slack(row, y) else ENCLOSABLE


@jit
def enclose_end(h, v, length, weight, compliance):
    """Enclose the end point x, z of `catenary.span` for interval arguments. *weight*, *compliance*: doubles."""
    v1, t0, t1, reach = span_tensions(sqr(h), v, length, weight)
    c = point(compliance)
    x = mul(h, add(mul(c, length), reach))
    z = mul(length, mul(add(v, v1), add(mul((0.5, 0.5), c), div(ONE, add(t0, t1)))))
    return x, z


@jit
def span_tensions(hh, v, length, weight):
    """Enclose the vertical tension at a span's end, the tensions at both ends, and the integral of ds / T.

    *hh*: horizontal tension, squared.
    """
    v1 = add(v, mul(point(weight), length)) if weight > 0.0 else v
    t0, t1 = root(add(hh, sqr(v))), root(add(hh, sqr(v1)))
    p = div(hh, sub(t0, v)) if v[1] < 0.0 else add(t0, v)
    q = div(hh, add(t1, v1)) if v1[0] > 0.0 else sub(t1, v1)
    half = div(mul((2.0, 2.0), length), add(p, q))
    if weight > 0.0:
        half = mul(half, log1p_ratio(mul(point(weight), half)))
    return v1, t0, t1, half


@jit
def enclose_flexibility(h, v, length, weight, compliance):
    """Enclose the derivatives x_h, x_v (= z_h), z_v, x_l, z_l of `catenary.span` for intervals."""
    v1, t0, t1, reach = span_tensions(sqr(h), v, length, weight)
    c = point(compliance)
    stretch, both, across = mul(c, length), add(v, v1), mul(t0, t1)
    hl = mul(h, length)
    if weight == 0.0:
        slope = div(mul(h, hl), mul(sqr(t0), t0))
    elif v[0] > 0.0 or v1[1] < 0.0:
        slope = div(mul(mul(h, hl), both), mul(across, add(mul(v1, t0), mul(v, t1))))
    else:
        slope = div(sub(div(v1, t1), div(v, t0)), point(weight))
    per_length = add(c, div(ONE, t1))
    return (
        sub(add(stretch, reach), slope),
        neg(div(mul(hl, both), mul(add(t0, t1), across))),
        add(stretch, slope),
        mul(h, per_length),
        mul(v1, per_length),
    )


@jit
def enclose_residual(row, y, x, z, length, out):
    """Enclose the residuals of the line's equations at *y* in rows of *out* (k, 2).

    *x*, *z*, *length* are intervals. Returns the force (h, v) at the start of the free span.
    """
    unknowns = int(row[UNKNOWNS])
    turn, lever = point(row[SIDE] * row[RADIUS]), point(row[LEVER])  # exact: the side is a sign
    phi, free = point(y[PHI]), point(y[FREE])
    t = exp(point(y[TAU]))
    cf, sf = cos(phi), sin(phi)
    cb, sb = ONE, ZERO
    if unknowns == 6:
        cb, sb = cos(point(y[BETA])), sin(point(y[BETA]))
    hx, hz = mul(lever, cb), mul(lever, sb)
    psi = point(y[PSI]) if unknowns > 4 else upright(row[SIDE])
    h, v = mul(t, cf), mul(t, sf)
    gx, gz = given_way(row, psi, t, h, v)
    hz = add(hz, gz)
    sx, sz = enclose_end(h, v, free, row[WEIGHT], row[FREE_COMPLIANCE])
    out[0, 0], out[0, 1] = sub(add(sub(add(hx, gx), mul(turn, sf)), sx), x)
    out[1, 0], out[1, 1] = sub(add(add(hz, mul(turn, cf)), sz), z)
    taken, _ = taken_up(row, t)
    rest = point(y[DEAD]) if unknowns > 3 else point(row[DEAD_LENGTH])
    if row[END_SPRING] > 0.0:
        rest = sub(rest, mul(t, point(row[END_SPRING])))
    out[2, 0], out[2, 1] = sub(add(add(mul(point(row[SPANS]), free), arc_length(row, psi, phi, taken)), rest), length)
    if unknowns > 3:
        cp, sp = dead_direction(row, psi)
        rest = point(y[DEAD])
        dx, dz = enclose_end(mul(t, cp), mul(t, sp), rest, row[WEIGHT], row[DEAD_COMPLIANCE])
        out[3, 0], out[3, 1] = sub(add(sub(hz, mul(turn, cp)), dz), point(row[WINCH_Z]))
        if unknowns > 4:
            out[4, 0], out[4, 1] = sub(add(add(hx, mul(turn, sp)), dx), point(row[WINCH_X]))
        if unknowns > 5:
            pull = div(point(row[LEVER_MOMENT]), mul(lever, t))
            across = sub(mul(add(sf, sp), cb), mul(add(cf, cp), sb))
            out[5, 0], out[5, 1] = sub(across, mul(pull, cb))
    return h, v


@jit
def enclose_jacobian(row, y, radius, low, high):
    """Enclose the Jacobian (k, k) of the line's equations between *low* and *high* for unknowns within *radius* of *y*.

    Returns the force (h, v) at the start of the free span.
    """
    unknowns = int(row[UNKNOWNS])
    low[:unknowns, :unknowns] = 0.0
    high[:unknowns, :unknowns] = 0.0
    turn = point(row[SIDE] * row[RADIUS])
    phi, free = _unknown(y, radius, PHI), _unknown(y, radius, FREE)
    t = exp(_unknown(y, radius, TAU))
    cf, sf = cos(phi), sin(phi)
    h, v = mul(t, cf), mul(t, sf)
    hh, hv, vv, xl, zl = enclose_flexibility(h, v, free, row[WEIGHT], row[FREE_COMPLIANCE])
    rsf, rcf = mul(turn, sf), mul(turn, cf)
    low[0, PHI], high[0, PHI] = sub(sub(mul(hv, h), mul(hh, v)), rcf)
    low[1, PHI], high[1, PHI] = sub(sub(mul(vv, h), mul(hv, v)), rsf)
    low[0, TAU], high[0, TAU] = add(mul(hh, h), mul(hv, v))
    low[1, TAU], high[1, TAU] = add(mul(hv, h), mul(vv, v))
    low[0, FREE], high[0, FREE] = xl
    low[1, FREE], high[1, FREE] = zl
    psi = _unknown(y, radius, PSI) if unknowns > 4 else upright(row[SIDE])
    taken, stretch = taken_up(row, t)
    low[2, PHI], high[2, PHI] = neg(mul(turn, taken))
    low[2, TAU], high[2, TAU] = neg(mul(arc_length(row, psi, phi, taken), mul(taken, stretch)))
    low[2, FREE] = high[2, FREE] = row[SPANS]
    if unknowns > 3:
        cp, sp = dead_direction(row, psi)
        _enclose_dead(row, t, cp, sp, _unknown(y, radius, DEAD), turn, taken, low, high)
        if unknowns > 5:
            beta = _unknown(y, radius, BETA)
            _enclose_moment(row, t, cf, sf, cp, sp, cos(beta), sin(beta), low, high)
    if row[END_SPRING] > 0.0:
        _add_to_block(low, high, 2, TAU, neg(mul(t, point(row[END_SPRING]))))
    if row[MOUNT] > 0.0:
        _enclose_mount(row, psi, t, h, v, low, high)
    return h, v


@jit
def add_entry(low, high, i, j, value):
    """Add *value* to an entry of a matrix with the lower ends *low* and the upper ends *high*."""
    low[i, j], high[i, j] = add((low[i, j], high[i, j]), value)


@jit
def _add_to_block(low, high, i, j, value):
    """As `add_entry`, of a line's own block, whose rows are not contiguous: so each has one compiled signature."""
    low[i, j], high[i, j] = add((low[i, j], high[i, j]), value)


@jit
def given_way(row, psi, t, h, v):
    """Enclose the deflection of the mount of the exit point, m, see `upright.given_way`."""
    if row[MOUNT] == 0.0:
        return ZERO, ZERO
    soft, up = mul(point(row[MOUNT]), point(row[PULLS])), v
    if row[UNKNOWNS] > 3.0:
        _, sp = dead_direction(row, psi)
        up = add(up, div(mul(t, sp), point(row[SPANS])))
    return mul(soft, h), mul(soft, up)


@jit
def _enclose_mount(row, psi, t, h, v, low, high):
    """Add the entries of the compliant mount, as `upright._add_mount`."""
    gx, gz = given_way(row, psi, t, h, v)
    soft = mul(point(row[MOUNT]), point(row[PULLS]))
    rise = mul(soft, h)
    _add_to_block(low, high, 0, PHI, neg(mul(soft, v)))
    _add_to_block(low, high, 1, PHI, rise)
    _add_to_block(low, high, 0, TAU, gx)
    _add_to_block(low, high, 1, TAU, gz)
    if row[UNKNOWNS] > 3.0:
        _add_to_block(low, high, 3, PHI, rise)
        _add_to_block(low, high, 3, TAU, gz)
    if row[UNKNOWNS] > 4.0:
        cp, _ = dead_direction(row, psi)
        turned = div(mul(soft, mul(t, cp)), point(row[SPANS]))
        _add_to_block(low, high, 1, PSI, turned)
        _add_to_block(low, high, 3, PSI, turned)


@jit
def _unknown(y, radius, k):
    """The interval of unknown *k*."""
    return inflate(point(y[k]), radius[k])


@jit
def upright(side):
    """Enclose the direction of a vertical dead span, rad: -pi/2 for a positive side, else pi/2."""
    return neg(HALF_PI) if side > 0.0 else HALF_PI


@jit
def dead_direction(row, psi):
    """Enclose cosine and sine of the dead span's direction."""
    if row[UNKNOWNS] > 4.0:
        return cos(psi), sin(psi)
    return ZERO, point(-row[SIDE])


@jit
def taken_up(row, t):
    """Enclose the ratio of unstrained to strained length of the cable on the sheave, and its strain."""
    if row[ARC_COMPLIANCE] == 0.0:
        return ONE, ZERO
    stretch = mul(t, point(row[ARC_COMPLIANCE]))
    return div(ONE, add(ONE, stretch)), stretch


@jit
def arc_length(row, psi, phi, taken):
    """Enclose the unstrained length of cable on the sheave, m."""
    if row[RADIUS] == 0.0:
        return ZERO
    return mul(mul(point(row[RADIUS]), contact(row, phi, psi)), taken)


@jit
def contact(row, phi, psi):
    """Enclose the angle of contact of the cable with the sheave, rad."""
    return add(mul(point(row[SIDE]), sub(psi, phi)), PI)


@jit
def _enclose_dead(row, t, cp, sp, dead, turn, taken, low, high):
    """Enclose the entries of the dead span's end at the winch exit."""
    h, v = mul(t, cp), mul(t, sp)
    hh, hv, vv, xl, zl = enclose_flexibility(h, v, dead, row[WEIGHT], row[DEAD_COMPLIANCE])
    low[3, TAU], high[3, TAU] = add(mul(hv, h), mul(vv, v))
    low[3, DEAD], high[3, DEAD] = zl
    low[2, DEAD], high[2, DEAD] = ONE
    if row[UNKNOWNS] > 4.0:
        low[4, TAU], high[4, TAU] = add(mul(hh, h), mul(hv, v))
        low[4, DEAD], high[4, DEAD] = xl
        low[4, PSI], high[4, PSI] = add(sub(mul(hv, h), mul(hh, v)), mul(turn, cp))
        low[3, PSI], high[3, PSI] = add(sub(mul(vv, h), mul(hv, v)), mul(turn, sp))
        low[2, PSI], high[2, PSI] = mul(turn, taken)


@jit
def _enclose_moment(row, t, cf, sf, cp, sp, cb, sb, low, high):
    """Enclose the entries of the moment about the joint, divided by lever and tension, and the lever's column."""
    lever = point(row[LEVER])
    pull = div(point(row[LEVER_MOMENT]), mul(lever, t))
    free, dead = add(mul(cf, cb), mul(sf, sb)), add(mul(cp, cb), mul(sp, sb))
    low[5, PHI], high[5, PHI] = free
    low[5, TAU], high[5, TAU] = mul(pull, cb)
    low[5, PSI], high[5, PSI] = dead
    low[5, BETA], high[5, BETA] = sub(sub(mul(pull, sb), free), dead)
    sine, cosine = mul(lever, sb), mul(lever, cb)
    low[0, BETA], high[0, BETA] = neg(sine)
    low[4, BETA], high[4, BETA] = neg(sine)
    low[1, BETA], high[1, BETA] = cosine
    low[3, BETA], high[3, BETA] = cosine
