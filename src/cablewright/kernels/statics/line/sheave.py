"""Straight massless lines over a sheave: tangents at both ends of the contact, and the lever's angle."""

from math import asin, atan2, cos, exp, log, pi, sin, sqrt

from cablewright.kernels import jit
from cablewright.kernels.layout import (
    BETA,
    DEAD,
    DEAD_LENGTH,
    FREE,
    LEVER,
    LEVER_MOMENT,
    PHI,
    PSI,
    RADIUS,
    SIDE,
    SPANS,
    TAU,
    UNKNOWNS,
    WINCH_X,
    WINCH_Z,
)

LEVER_ROUNDS = 3  # each reduces the lever angle's error about a hundredfold


@jit
def tangent(x, z, turn):
    """Return direction (rad) and length (m) of the tangent from a circle about zero to the point (x, z).

    *turn* is the radius times the sense of contact: for a positive sense the contact point lies a quarter turn ahead of
    the direction. The length is negative where the point lies inside the circle.
    """
    distance = sqrt(x * x + z * z)
    if not distance > abs(turn):
        return 0.0, -1.0
    return atan2(z, x) - asin(turn / distance), sqrt((distance - turn) * (distance + turn))


@jit
def straight(row, x, z, tension, y):
    """Set *y* to the straight line from the winch over the sheave to (x, z) at *tension*, with strained lengths.

    Exact except the lever angle, whose error is about 1e-4 rad. x, z: the platform point from the exit point,
    in the line's plane (m). Returns False if the point or the winch exit lies inside the sheave.
    """
    unknowns = int(row[UNKNOWNS])
    radius, lever, side = row[RADIUS], row[LEVER], row[SIDE]
    y[TAU] = log(tension)
    y[DEAD] = 0.0
    y[BETA] = 0.0
    y[PSI] = -side * 0.5 * pi
    if unknowns < 6:
        y[PHI], y[FREE] = tangent(x - lever, z, side * radius)
        if unknowns == 4:
            y[DEAD] = abs(row[WINCH_Z])
        elif unknowns == 5:
            y[PSI], y[DEAD] = tangent(row[WINCH_X], row[WINCH_Z], 0.0)
        return y[FREE] > 0.0
    pull = row[LEVER_MOMENT] / lever
    beta = 0.5 * (atan2(z, x) - side * 0.5 * pi)
    for _ in range(LEVER_ROUNDS):
        hx, hz = lever * cos(beta), lever * sin(beta)
        y[PHI], y[FREE] = tangent(x - hx, z - hz, side * radius)
        y[PSI], y[DEAD] = tangent(row[WINCH_X] - hx, row[WINCH_Z] - hz, -side * radius)
        if y[FREE] < 0.0 or y[DEAD] < 0.0:
            return False
        beta = atan2(tension * (sin(y[PHI]) + sin(y[PSI])) - pull, tension * (cos(y[PHI]) + cos(y[PSI])))
    y[BETA] = beta
    return True


@jit
def wrap(row, y):
    """Return the angle of contact of a cable with its sheave, rad; zero where there is none."""
    return row[SIDE] * (y[PSI] - y[PHI]) + pi if row[RADIUS] > 0.0 else 0.0


@jit
def whole_length(row, y):
    """Return the length (m) of the straight line that `straight` wrote to *y*: spans, contact and constant part."""
    return row[SPANS] * y[FREE] + y[DEAD] + row[RADIUS] * wrap(row, y) + constant_length(row)


@jit
def unstrain(y, free_compliance, dead_compliance):
    """Convert the strained lengths of a straight line in *y* to unstrained ones at its tension."""
    tension = exp(y[TAU])
    y[FREE] /= 1.0 + tension * free_compliance
    y[DEAD] /= 1.0 + tension * dead_compliance


@jit
def constant_length(row):
    """Length of the dead span where it is not modelled, m."""
    return row[DEAD_LENGTH] if row[UNKNOWNS] == 3.0 else 0.0


@jit
def contact_angle(row, y):
    """Angle (rad) by which a cable turns between its dead span and its free span; in an eyelet the shorter way."""
    contact = row[SIDE] * (y[PSI] - y[PHI]) + pi
    if row[RADIUS] > 0.0:
        return max(contact, 0.0)
    contact %= 2.0 * pi
    return min(contact, 2.0 * pi - contact)
