"""One line in a vertical plane: dead span, sheave, free span and lever as one block of three to six equations.

Unknowns y and their order: see `layout`. Equations, in metres and (the last) as a fraction of the tension: free span
ends at the platform point (x, z); unstrained lengths sum to the given length; dead span ends at the winch exit (z, x);
moment about the joint. Signs and kinds: Paty 2021, Eqs. 2 to 6, 11 to 19; `docs/theory/statics.md`.
"""

from math import atan2, atanh, cos, cosh, exp, log, sin, sinh, sqrt

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import largest_of_column, solve
from cablewright.kernels.layout import (
    ARC_COMPLIANCE,
    BETA,
    CONTACT,
    DEAD,
    DEAD_COMPLIANCE,
    END_SPRING,
    FREE,
    FREE_COMPLIANCE,
    GUIDE,
    HIGH_RISE,
    LEVER,
    LEVER_MOMENT,
    LOW_RISE,
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
from cablewright.kernels.statics.line.catenary import span
from cablewright.kernels.statics.line.sheave import constant_length, straight, unstrain, wrap

STEPS = 80
LENGTH_TOLERANCE = 1e-15  # m per m of line: a few roundings
SLACK_FROM = 1.001  # lengths per chord: from here the catenary is a better guess than the parabola
STALLED = 1e-12  # Newton step after which the next one is rounding
SLACK_TENSION = 1e-30  # N: marks a slack massless line; no taut one, of the smallest machine, has as little
LOG_SLACK = log(SLACK_TENSION) + 1e-9
SETTLED, SLACK, FAILED = 1, 0, -1  # what `interface.settle_line` returns


@jit
def system(row, y, x, z, length, jacobian, residual):
    """Write residual (k,) and Jacobian (k, k) of the line's k equations at *y*.

    Returns the force (h, v) at the start of the free span, N.
    """
    unknowns = int(row[UNKNOWNS])
    radius, side, weight = row[RADIUS], row[SIDE], row[WEIGHT]
    turn = side * radius
    t = exp(y[TAU])
    cf, sf = cos(y[PHI]), sin(y[PHI])
    cb, sb = 1.0, 0.0
    if unknowns == 6:
        cb, sb = cos(y[BETA]), sin(y[BETA])
    hx, hz = row[LEVER] * cb, row[LEVER] * sb
    gx, gz = given_way(row, y)
    hz += gz
    sx, sz, hh, hv, vv, xl, zl, _ = span(t * cf, t * sf, y[FREE], weight, row[FREE_COMPLIANCE])
    residual[0] = hx + gx - turn * sf + sx - x
    residual[1] = hz + turn * cf + sz - z
    jacobian[0, PHI] = t * (hv * cf - hh * sf) - turn * cf
    jacobian[1, PHI] = t * (vv * cf - hv * sf) - turn * sf
    jacobian[0, TAU] = t * (hh * cf + hv * sf)
    jacobian[1, TAU] = t * (hv * cf + vv * sf)
    jacobian[0, FREE] = xl
    jacobian[1, FREE] = zl
    taken = 1.0 / (1.0 + t * row[ARC_COMPLIANCE])
    arc = radius * wrap(row, y) * taken
    spring = t * row[END_SPRING]
    residual[2] = row[SPANS] * y[FREE] + y[DEAD] + arc + constant_length(row) - spring - length
    jacobian[2, PHI] = -turn * taken
    jacobian[2, TAU] = -arc * taken * t * row[ARC_COMPLIANCE] - spring
    jacobian[2, FREE] = row[SPANS]
    if unknowns > 3:
        cp, sp = cos(y[PSI]), sin(y[PSI])
        dx, dz, hh, hv, vv, xl, zl, _ = span(t * cp, t * sp, y[DEAD], weight, row[DEAD_COMPLIANCE])
        residual[3] = hz - turn * cp + dz - row[WINCH_Z]
        jacobian[3, PHI] = jacobian[3, FREE] = jacobian[0, DEAD] = jacobian[1, DEAD] = 0.0
        jacobian[3, TAU] = t * (hv * cp + vv * sp)
        jacobian[3, DEAD] = zl
        jacobian[2, DEAD] = 1.0
        if unknowns > 4:
            residual[4] = hx + turn * sp + dx - row[WINCH_X]
            jacobian[4, PHI] = jacobian[4, FREE] = jacobian[0, PSI] = jacobian[1, PSI] = 0.0
            jacobian[4, TAU] = t * (hh * cp + hv * sp)
            jacobian[4, DEAD] = xl
            jacobian[4, PSI] = t * (hv * cp - hh * sp) + turn * cp
            jacobian[3, PSI] = t * (vv * cp - hv * sp) + turn * sp
            jacobian[2, PSI] = turn * taken
        if unknowns > 5:
            _moment(row, t, cf, sf, cp, sp, cb, sb, jacobian, residual)
    if row[MOUNT] > 0.0:
        _add_mount(row, y, gx, gz, jacobian)
    return t * cf, t * sf


@jit
def given_way(row, y):
    """Return the deflection of the exit point's mount (m, in the line's plane).

    It deflects under the free span's force, and in height under that of a dead span, whose winch moves along sideways.
    """
    if row[MOUNT] == 0.0:
        return 0.0, 0.0
    along, up = force_on_mount(row, y)
    return row[MOUNT] * along, row[MOUNT] * up


@jit
def force_on_mount(row, y):
    """Return a line's force on its exit point, N: horizontal, of the free span, and upward, of free and dead span."""
    pull = row[PULLS] * exp(y[TAU])
    dead = sin(y[PSI]) / row[SPANS] if row[UNKNOWNS] > 3.0 else 0.0
    return pull * cos(y[PHI]), pull * (sin(y[PHI]) + dead)


@jit
def _add_mount(row, y, gx, gz, jacobian):
    """Add the derivatives of `given_way` to the Jacobian of `system`."""
    soft = row[MOUNT] * row[PULLS] * exp(y[TAU])
    rise = soft * cos(y[PHI])
    jacobian[0, PHI] -= soft * sin(y[PHI])
    jacobian[1, PHI] += rise
    jacobian[0, TAU] += gx
    jacobian[1, TAU] += gz
    if row[UNKNOWNS] > 3.0:
        jacobian[3, PHI] += rise
        jacobian[3, TAU] += gz
    if row[UNKNOWNS] > 4.0:
        rise = soft * cos(y[PSI]) / row[SPANS]
        jacobian[1, PSI] += rise
        jacobian[3, PSI] += rise


@jit
def _moment(row, t, cf, sf, cp, sp, cb, sb, jacobian, residual):
    """Write the moment about the joint, divided by lever and tension (Paty 2021, Eq. 6), and the lever's column."""
    lever = row[LEVER]
    pull = row[LEVER_MOMENT] / (lever * t)
    free, dead = cf * cb + sf * sb, cp * cb + sp * sb  # cosines of the spans against the lever
    residual[5] = (sf + sp) * cb - (cf + cp) * sb - pull * cb
    jacobian[5, PHI] = free
    jacobian[5, TAU] = pull * cb
    jacobian[5, FREE] = jacobian[5, DEAD] = jacobian[2, BETA] = 0.0
    jacobian[5, PSI] = dead
    jacobian[5, BETA] = pull * sb - free - dead
    jacobian[0, BETA] = jacobian[4, BETA] = -lever * sb
    jacobian[1, BETA] = jacobian[3, BETA] = lever * cb


@jit
def start_force(y):
    """Return the in-plane tension (h, v), N, where the free span leaves the sheave, along the direction of travel."""
    t = exp(y[TAU])
    return t * cos(y[PHI]), t * sin(y[PHI])


@jit
def force_change(h, v, weight, changes, k):
    """Return the change of the force at the free span's end for changes[:, k] of the unknowns.

    The force is (h, v + weight * length).
    """
    turn, grow = changes[PHI, k], changes[TAU, k]
    return h * grow - v * turn, v * grow + h * turn + weight * changes[FREE, k]


@jit
def lever_stable(row, y):
    """Return whether the lever is stable: the moment about the joint falls with the lever angle."""
    if row[UNKNOWNS] < 6.0:
        return True
    pull = row[LEVER_MOMENT] / (row[LEVER] * exp(y[TAU]))
    return pull * sin(y[BETA]) - cos(y[PHI] - y[BETA]) - cos(y[PSI] - y[BETA]) < 0.0


@jit
def extremes(row, y):
    """Smallest and largest tension along the line, N."""
    low, high, _, _ = extremes_and_change(row, y, 0.0, 0.0, 0.0, 0.0, 0.0)
    return low, high


@jit
def extremes_and_change(row, y, dphi, dtau, dfree, ddead, dpsi):
    """Smallest and largest tension along the line, N, and their changes for the given changes of the unknowns."""
    t = exp(y[TAU])
    weight = row[WEIGHT]
    h, v = t * cos(y[PHI]), t * sin(y[PHI])
    dh, dv = h * dtau - v * dphi, v * dtau + h * dphi
    low, high, dlow, dhigh = _span_extremes(h, v, weight * y[FREE], dh, dv, weight * dfree)
    if row[UNKNOWNS] > 3.0:
        if row[GUIDE] > 0.0:  # a straight dead span, whose tension changes with height
            carried, dcarried = weight * y[DEAD], weight * ddead
            low2, high2 = t + carried * row[LOW_RISE], t + carried * row[HIGH_RISE]
            dlow2, dhigh2 = t * dtau + dcarried * row[LOW_RISE], t * dtau + dcarried * row[HIGH_RISE]
        else:
            h, v = t * cos(y[PSI]), t * sin(y[PSI])
            turn = dpsi if row[UNKNOWNS] > 4.0 else 0.0
            dh, dv = h * dtau - v * turn, v * dtau + h * turn
            low2, high2, dlow2, dhigh2 = _span_extremes(h, v, weight * y[DEAD], dh, dv, weight * ddead)
        if low2 < low:
            low, dlow = low2, dlow2
        if high2 > high:
            high, dhigh = high2, dhigh2
    return low, high, dlow, dhigh


@jit
def _span_extremes(h, v, carried, dh, dv, dcarried):
    """As `extremes_and_change`, of one span from its start force, its weight and their changes."""
    end, dend = v + carried, dv + dcarried
    first, last = sqrt(h * h + v * v), sqrt(h * h + end * end)
    dfirst, dlast = (h * dh + v * dv) / first, (h * dh + end * dend) / max(last, 1e-300)
    high, dhigh = (first, dfirst) if first > last else (last, dlast)
    if v * end < 0.0:
        return abs(h), high, (dh if h >= 0.0 else -dh), dhigh
    if first < last:
        return first, high, dfirst, dhigh
    return last, high, dlast, dhigh


@jit
def length_of(row, y):
    """Return the unstrained length of a line from the winch exit to the platform point, m."""
    t = exp(y[TAU])
    contact = y[CONTACT] if row[GUIDE] > 0.0 else row[RADIUS] * wrap(row, y)
    spans = row[SPANS] * y[FREE] + y[DEAD] + contact / (1.0 + t * row[ARC_COMPLIANCE])
    return spans + constant_length(row) - t * row[END_SPRING]


@jit
def lengths_of(packed, states, out):
    """Write the unstrained lengths of all lines, m, to *out* (m,)."""
    for i in range(packed.lines.shape[0]):
        out[i] = length_of(packed.lines[i], states[i])


@jit
def advance(row, y, step, scale):
    """Take a Newton step: add minus *scale* times *step* to *y*, shortened where an unknown would change too much.

    Returns True if it is not shortened.
    """
    unknowns = int(row[UNKNOWNS])
    held = scale
    for k in range(unknowns):
        size = abs(step[k])
        if k in (FREE, DEAD):
            allowed = 0.7 * y[k] if step[k] > 0.0 else 0.7 * y[k] + 0.5
        else:
            allowed = 1.5 if k == TAU else 0.5
        if size * held > allowed:
            held = allowed / size
    for k in range(unknowns):
        y[k] -= held * step[k]
    return held == scale


@jit
def guess(row, x, z, length, tension, y):
    """Set *y* close to the line of unstrained *length* to (x, z), taut or slack. False inside a sheave.

    *tension* (N) only places the lever. The free span's tension T solves the parabola's balance of stretch and sag,
    L (1 + c T) - w^2 x^2 chord / (24 T^2) = chord.
    """
    if not straight(row, x, z, tension, y):
        return False
    chord, weight = y[FREE], row[WEIGHT]
    unstrain(y, 0.0, row[DEAD_COMPLIANCE])
    free = (length - y[DEAD] - row[RADIUS] * wrap(row, y) - constant_length(row)) / row[SPANS]
    free = max(free, 0.05 * chord)
    shape_span(row, chord, free, tension, y)
    if row[UNKNOWNS] > 3.0:  # the dead span must at least carry itself
        y[TAU] = max(y[TAU], log(max(1.02 * weight * y[DEAD], 1e-300)))
    return True


@jit
def shape_span(row, chord, free, tension, y):
    """Set *y* close to a span of unstrained length *free* over a *chord* (m) in the direction y[PHI]."""
    weight, compliance, soft = row[WEIGHT], row[FREE_COMPLIANCE], row[END_SPRING] / row[SPANS]
    reach = chord * cos(y[PHI])
    sag = weight * weight * reach * reach * chord / 24.0
    t = max(weight * chord, 1e-3 * tension, (chord - free) / (free * compliance + soft))
    for _ in range(40):
        excess = free * (1.0 + compliance * t) + soft * t - sag / (t * t) - chord
        step = excess / ((free * compliance + soft) * t + 2.0 * sag / (t * t))
        t *= exp(-min(max(step, -1.5), 1.5))
        if abs(step) < 1e-3:
            break
    h = t * cos(y[PHI])
    v = t * sin(y[PHI]) - 0.5 * weight * free
    if free > SLACK_FROM * chord:
        h, v = _hanging(max(reach, 1e-6 * chord), chord * sin(y[PHI]), free, weight)
    y[TAU] = log(sqrt(h * h + v * v))
    c, s = cos(y[PHI]), sin(y[PHI])
    y[PHI] -= atan2(s * h - c * v, c * h + s * v)
    y[FREE] = free + soft * t


@jit
def _hanging(x, z, length, weight):
    """Force at the start of the inextensible catenary to (x, z), x > 0, whose *length* exceeds the distance.

    With u = w x / 2H: sinh(u) / u = sqrt(L^2 - z^2) / x, and the middle of the span is at atanh(z / L).
    """
    ratio = sqrt((length - z) * (length + z)) / x
    u = sqrt(6.0 * (ratio - 1.0)) if ratio < 3.0 else log(2.0 * ratio) + log(log(2.0 * ratio))
    for _ in range(6):
        u -= (sinh(u) - ratio * u) / (cosh(u) - ratio)
    h = 0.5 * weight * x / u
    return h, h * sinh(atanh(z / length) - u)


@jit
def settle(row, x, z, length, y, jacobian, rhs):
    """Solve the line for a fixed platform point and unstrained length from the guess in *y*. True if it converges."""
    scale = LENGTH_TOLERANCE * (1.0 + abs(x) + abs(z) + length)
    for _ in range(STEPS):
        system(row, y, x, z, length, jacobian, rhs[:, 0])
        if largest_of_column(rhs, int(row[UNKNOWNS])) < scale:
            return True
        if not solve(jacobian, rhs, int(row[UNKNOWNS]), 1):
            return False
        stalled = largest_of_column(rhs, int(row[UNKNOWNS])) < STALLED
        advance(row, y, rhs[:, 0], 1.0)
        if stalled:
            return True
    return False


@jit
def is_slack(row, y):
    """Return whether a massless line is slack: it carries no tension and has no shape."""
    return row[WEIGHT] == 0.0 and y[TAU] <= LOG_SLACK
