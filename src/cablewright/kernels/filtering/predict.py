"""Predictions of the filter's state: by the winches' encoders, by the gyro, and the decay of quantities that drift."""

from math import exp, isnan, sqrt

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.covariance_prediction import add_multiples
from cablewright.kernels.filtering.update import ATTITUDE, COMPLIANCES, GROUND, GYRO, LENGTHS, POSITION, RADII, STRETCH

# Noise of a prediction by encoders: m per root metre, m per root second, share per root radian, m per root metre; and
# the first one while it is not known which line is slack.
TRAVEL, DRIFT, RADIUS, UNDERGROUND, UNKNOWN_SLACK = 0, 1, 2, 3, 4

# What counts show, see `reel`: rotations that no drum can make, or whether drums turned, and whether that moved B.
JUMPED, TURNED, ROLLED = -1, 1, 2
LEAST_TIME = 0.02  # s, of counts that come closer one after another: of the limit of rotations


@jit(allocates=True)
def reel(
    x, P, at, jacobian, toward, hung, counts, before, winch, sense, law, rolls, pauses, excess, creep, noise, dt,
    loosened, coasted, rates, angles, rotation,
):  # fmt: skip
    """Predict by *counts* (w,) of encoders, those *before* and what lies between: as `roll`, if *rolls*.

    *winch*, *sense* (m,): winch of each line, and which way it winds. *law* (3,): counts per radian, largest speed of a
    drum, rad/s, time constant of the rates, s. *pauses*: whether drums that stand still now are left to the caller.
    *excess* (m,), m: NaN where it is not known. Writes the *rotation* (m,), rad; *angles* (m,), rad: sum of those that
    moved B, in place. Returns what the counts show, see JUMPED.
    """
    m, moved, unknown = rotation.shape[0], False, 0
    for i in range(m):
        rotation[i] = sense[i] * ((counts[winch[i]] - before[winch[i]]) / law[0])
        if abs(rotation[i]) > 2.0 * law[1] * max(dt, LEAST_TIME):
            return JUMPED
        moved = moved or rotation[i] != 0.0
        unknown += isnan(excess[i])
    if not rolls or (pauses and not moved):
        return TURNED * moved
    own = noise.copy()
    if unknown > 1:
        own[TRAVEL] = noise[UNKNOWN_SLACK]
    for i in range(m):
        angles[i] += rotation[i]
    gain = min(1.0, dt / law[2])
    roll(x, P, at, jacobian, toward, hung, rotation, creep, own, dt, gain, loosened, coasted, rates)
    return TURNED * moved + ROLLED


@jit(allocates=True)
def roll(x, P, at, jacobian, toward, hung, rotation, creep, noise, dt, gain, loosened, coasted, rates):
    """Predict lengths, position B and covariance from the *rotation* (m,), rad, of the winch drums in *dt*, s.

    *jacobian* (3, m), *toward* (m, 3): of taut lines. *hung* (m,): lines with a counterweight, which follow B. *creep*
    (m,): 1/s, of lengths; *noise* (4,). In place: *loosened* (m,), m of excess; *coasted* (4,): motion that no encoder
    measures; *rates* (m,), rad/s of the drums, smoothed by a *gain*.
    """
    m = rotation.shape[0]
    paid, stretched, moved, unseen = np.empty(m), np.empty(m), np.zeros(3), np.zeros(3)
    lengths, radii, still = at[LENGTHS], at[RADII], True
    for i in range(m):
        paid[i] = x[radii + i] * rotation[i]
        stretched[i] = dt * x[at[STRETCH] + i] + dt * creep[i] * x[lengths + i]
        still = still and rotation[i] == 0.0
    for k in range(3):
        for i in range(m):
            unseen[k] += jacobian[k, i] * stretched[i]
            moved[k] += jacobian[k, i] * paid[i]
        moved[k] += unseen[k]
        coasted[k] += unseen[k]
        x[at[POSITION] + k] += moved[k]
    for i in range(m):
        along = toward[i, 0] * moved[0] + toward[i, 1] * moved[1] + toward[i, 2] * moved[2]
        if hung[i]:
            paid[i] += along
        x[lengths + i] += paid[i] + stretched[i]
        loosened[i] += paid[i] + stretched[i] - along
        if dt > 0.0 and not still:
            rates[i] += gain * (rotation[i] / dt - rates[i])
    weights, own = np.empty((3, m)), np.zeros((m, m))
    for i in range(m):
        own[i, i] = paid[i]
        for k in range(3):
            weights[k, i] = jacobian[k, i] * paid[i]
    add_multiples(P, at[POSITION], radii, weights)  # radii as shares
    add_multiples(P, lengths, radii, own)
    far = sqrt(moved[0] ** 2 + moved[1] ** 2 + moved[2] ** 2)
    variance = noise[TRAVEL] ** 2 * far + noise[DRIFT] ** 2 * dt
    for k in range(3):
        P[at[POSITION] + k, at[POSITION] + k] += variance
    for i in range(m):
        P[lengths + i, lengths + i] += variance
        P[radii + i, radii + i] += noise[RADIUS] ** 2 * abs(rotation[i])
    P[at[GROUND], at[GROUND]] += noise[UNDERGROUND] ** 2 * far


@jit
def sink(x, P, at, rising, toward, force, sigma, loosened, coasted):
    """Predict the motion of B under a change of *force* upwards, N, which stretches the lines and no encoder measures.

    *rising* (3,), m/N; *toward* (m, 3): of taut lines; *sigma*: of the motion, as a share of it. In place: *loosened*
    (m,), m of excess; *coasted* (4,): motion that no encoder measures. Returns the square of the motion, m^2.
    """
    p, squared = at[POSITION], 0.0
    for k in range(3):
        moved = force * rising[k]
        x[p + k] += moved
        coasted[k] += moved
        squared += moved * moved
        for i in range(toward.shape[0]):
            loosened[i] -= toward[i, k] * moved
    for k in range(3):
        P[p + k, p + k] += sigma**2 * squared
    return squared


@jit(allocates=True)
def turn(x, P, at, about_x, about_y, about_z, dt, noise, angular_rate):
    """Predict the attitude of the platform from the gyro's turn rates about its axes, rad/s, over *dt*, s.

    *noise*: rad per root second. Tilts are along axes that turn with the platform, and all three angles drift by the
    gyro's biases. Writes the *angular_rate* (3,), rad/s, of tilt and yaw.
    """
    first, gyro = at[ATTITUDE], at[GYRO]
    wx, wy, wz = about_x - x[gyro], about_y - x[gyro + 1], about_z - x[gyro + 2]
    angular_rate[0], angular_rate[1], angular_rate[2] = wx + wz * x[first + 1], wy - wz * x[first], wz
    turning, drifting = np.zeros((2, 2)), np.zeros((3, 3))
    turning[0, 1], turning[1, 0] = dt * wz, -dt * wz
    for k in range(3):
        x[first + k] += dt * angular_rate[k]
        drifting[k, k] = -dt
    add_multiples(P, first, first, turning)
    add_multiples(P, first, gyro, drifting)
    for k in range(3):
        P[first + k, first + k] += noise**2 * dt


@jit(allocates=True)
def spread(x, P, at, jacobian, by_compliance, loosened, dt, time, sigma):
    """Predict the rates of cable stretch over *dt*, s, and the covariance of lengths and B that follows from them.

    A rate is a Gauss-Markov process, correlated for a *time*, s, with the deviation *sigma*, 1/s, of lengths. A line
    that is more compliant than its stiffness k says moves B by less for a change e of its excess: (u'Ku) dp = u e dk,
    with *by_compliance* (3, m) and the excess *loosened* (m,), m, since the last time, which becomes 0.
    """
    m, lengths, stretch = loosened.shape[0], at[LENGTHS], at[STRETCH]
    weights, own, variances = np.empty((3, m)), np.zeros((m, m)), np.empty(m)
    if dt > 0.0:
        for i in range(m):
            own[i, i], variances[i] = dt, (sigma * x[lengths + i]) ** 2
            for k in range(3):
                weights[k, i] = dt * jacobian[k, i]
        add_multiples(P, at[POSITION], stretch, weights)
        add_multiples(P, lengths, stretch, own)
        keep = fade(P, stretch, stretch + m, dt / time, variances)
        for i in range(m):
            x[stretch + i] *= keep
    for i in range(m):
        for k in range(3):
            weights[k, i] = by_compliance[k, i] * loosened[i]
        loosened[i] = 0.0
    add_multiples(P, at[POSITION], at[COMPLIANCES], weights)


@jit
def fade(P, begin, end, share, variances):
    """Predict the covariance *P* (n, n) of states *begin* to *end*, which return to their prior with time.

    They are a Gauss-Markov process; *share*: of its correlation time that passes; *variances* (end - begin,): prior
    ones, of unknown states. Returns the factor of means.
    """
    keep = exp(-share)
    for i in range(begin, end):
        for j in range(P.shape[0]):
            P[i, j] *= keep
    for j in range(P.shape[0]):
        for i in range(begin, end):
            P[j, i] *= keep
    for i in range(begin, end):
        P[i, i] += (1.0 - keep * keep) * variances[i - begin]
    return keep
