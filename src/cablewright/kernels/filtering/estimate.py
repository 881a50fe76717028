"""The output of the filter: position, velocity and their covariance at the present time."""

from math import cos, sin

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.filtering.reckoning import AXES, OF_LINES, PLACE, ROTATION, SPEED
from cablewright.kernels.filtering.update import ATTITUDE, LENGTHS, POSITION, RADII, VELOCITY
from cablewright.kernels.rotation import yawed

# Standard deviations besides the state's: m/s, rad, rad of tilt and rad/s of yaw without gyro.
BY_VELOCITY, BY_ATTITUDE, BY_SWING, BY_TURN = 0, 1, 2, 3


@jit
def excess_of(x, at, taut_lengths, toward, there, excess):
    """Write the *excess* (m,), m: cable lengths less those of taut lines, with point B at *there* (3,), m."""
    p, first = at[POSITION], at[LENGTHS]
    for i in range(excess.shape[0]):
        excess[i] = x[first + i] - taut_lengths[i]
        for k in range(3):
            excess[i] -= toward[i, k] * (x[p + k] - there[k])


@jit(allocates=True)
def tell(
    x, P, at, jacobian, taut_lengths, toward, there, rates, angular_rate, sigmas, doubt, counted, turned, gap, coasting,
    found,
):  # fmt: skip
    """Write the *found* numbers of an estimate, and the velocity of point B to the state *x* (n,).

    The velocity stays while B is *coasting*. *jacobian* (3, m), *taut_lengths* (m,), *toward* (m, 3) at a position
    *there* (3,); *rates* (m,), rad/s of the winch drums; *angular_rate* (3,), rad/s; *sigmas* (4,); *doubt*
    (3, 3), m^2: added to the covariance of the position. *counted*, *turned*, s: time since the last counts and the
    last turn rate; *gap*, s: longest time over which these are relied on. Returns the variance of the position in
    space, m^2, and a number that is finite where all of the state is.
    """
    m, p, v = rates.shape[0], at[POSITION], at[VELOCITY]
    size = at[RADII] + m  # of the states that pose and velocity depend on, which come first
    since, turning = min(max(counted, 0.0), gap), min(max(turned, 0.0), gap)
    G = np.zeros((AXES, size))
    for k in range(3):
        G[k, p + k] = 1.0
        if coasting:
            G[SPEED + k, v + k], since = 1.0, 0.0
            continue
        x[v + k] = 0.0
        for i in range(m):
            G[SPEED + k, at[RADII] + i] = jacobian[k, i] * x[at[RADII] + i] * rates[i]
            x[v + k] += G[SPEED + k, at[RADII] + i]
    for k in range(3):
        found[PLACE + k], found[SPEED + k] = x[p + k] + since * x[v + k], x[v + k]
    for i in range(m):
        radius = x[at[RADII] + i]
        found[OF_LINES + i] = x[at[LENGTHS] + i] + since * radius * rates[i]
        found[OF_LINES + 2 * m + i] = radius
    excess_of(x, at, taut_lengths, toward, there, found[OF_LINES + m : OF_LINES + 2 * m])
    first = at[ATTITUDE]
    yaw, tilt_x, tilt_y = x[first + 2], x[first], x[first + 1]
    found[ROTATION], found[ROTATION + 1], found[ROTATION + 2] = yawed(
        yaw + turning * angular_rate[2], tilt_x + turning * angular_rate[0], tilt_y + turning * angular_rate[1]
    )
    c, s = cos(yaw), sin(yaw)
    G[6, first], G[6, first + 1], G[7, first], G[7, first + 1], G[8, first + 2] = c, -s, s, c, 1.0
    covariance = found[OF_LINES + 3 * m :].reshape((AXES, AXES))
    _spread(G, P, covariance)
    for k in range(3):
        covariance[SPEED + k, SPEED + k] += sigmas[BY_VELOCITY] ** 2
        covariance[ROTATION + k, ROTATION + k] += sigmas[BY_ATTITUDE] ** 2
    if turned > gap:
        covariance[6, 6] += sigmas[BY_SWING] ** 2
        covariance[7, 7] += sigmas[BY_SWING] ** 2
        covariance[8, 8] += sigmas[BY_TURN] ** 2 * turned * (1.0 + turned)
    sound = x[p] + x[p + 1] + x[p + 2]
    for i in range(P.shape[0]):
        for j in range(P.shape[0]):
            sound += P[i, j] * P[i, j]  # no number in it is near overflow
    for i in range(3):
        for j in range(3):
            covariance[i, j] += doubt[i, j]
    return covariance[0, 0] + covariance[1, 1] + covariance[2, 2], sound


@jit(allocates=True)
def _spread(G, P, covariance):
    """Write the *covariance* of G times a state with the covariance *P*: of few states each."""
    rows, size = G.shape
    GP = np.zeros((rows, size))
    for a in range(rows):
        for j in range(size):
            if G[a, j] != 0.0:
                for i in range(size):
                    GP[a, i] += G[a, j] * P[j, i]
    for a in range(rows):
        for b in range(a + 1):
            total = 0.0
            for i in range(size):
                total += GP[a, i] * G[b, i]
            covariance[a, b] = covariance[b, a] = total
