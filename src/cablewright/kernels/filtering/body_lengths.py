"""Lengths of a rigid platform's lines by encoders, and the numbers of its estimate."""

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.filtering.reckoning import AXES, OF_LINES, PLACE, ROTATION, SPEED, unwind
from cablewright.kernels.plant.winding import radii_by


@jit(allocates=True)
def wind(counts, home, winch, sense, per_radian, begin, radii, wound, turns, slides, before, sliding, angles, paid):
    """Compute the *angles* (m,), rad, wound on drums and lengths *paid* out (m,), m, from *counts* (w,) since *home*.

    In place: *sliding* (m,), how cables slide over their sheaves: 1 after *slides*, m, that are paid out, -1 after as
    much that is wound; *before* (m,), m, was paid out the last time. Other arguments are those of `unwind`. Returns
    whether the drums hold the angles; if not, nothing else is valid.
    """
    rotation = np.empty(angles.shape[0])
    if not unwind(counts, home, winch, sense, per_radian, begin, radii, wound, turns, rotation, paid):
        return False
    for i in range(angles.shape[0]):
        angles[i] = begin[i] - rotation[i]
        sliding[i] = min(max(sliding[i] + (paid[i] - before[i]) / slides, -1.0), 1.0)
    return True


@jit
def tell(pose, velocity, lengths, straight, radii, turns, angles, uneven, covariance, variance, found):
    """Write the numbers *found* of an estimate at the *pose* (6,), with a *velocity* (6,), m/s and rad/s.

    They are 9 + 3 m + 81. *straight* (m,), m: lengths of straight lines. *radii*, *turns*: see `winding.radii_by`, at
    the *angles* (m,), rad, wound; *uneven* (m,): share of each radius that is to be added. *covariance* (6, 6): of the
    pose; *variance*, m^2/s^2: of the velocity. Returns the trace of the covariance.
    """
    m, total = lengths.shape[0], 0.0
    for k in range(3):
        found[PLACE + k], found[SPEED + k], found[ROTATION + k] = pose[k], velocity[k], pose[3 + k]
    own = found[OF_LINES + 2 * m : OF_LINES + 3 * m]
    radii_by(radii, turns, angles, own)
    for i in range(m):
        found[OF_LINES + i], found[OF_LINES + m + i] = lengths[i], lengths[i] - straight[i]
        own[i] *= 1.0 + uneven[i]
    whole = found[OF_LINES + 3 * m :].reshape((AXES, AXES))
    whole[:, :] = 0.0
    for i in range(6):
        total += covariance[i, i]
        for j in range(6):
            whole[i + (3 if i >= 3 else 0), j + (3 if j >= 3 else 0)] = covariance[i, j]
    for k in range(3):
        whole[SPEED + k, SPEED + k] = variance
    return total
