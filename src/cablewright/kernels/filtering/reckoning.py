"""Dead reckoning by encoders: lengths from counts, and the numbers of an estimate at the equilibrium of these."""

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.plant.winding import paid_out, radii_by
from cablewright.kernels.statics.taut import FOUND, WHOLE, draw

# Numbers of an estimate: position, velocity, rotation, then m lengths, m of excess, m radii; of filters also the
# covariance (9, 9).
PLACE, SPEED, ROTATION, OF_LINES = 0, 3, 6, 9
AXES = 9


@jit(allocates=True)
def unwind(counts, before, winch, sense, per_radian, begin, radii, wound, turns, rotation, paid):
    """Write the *rotation* (m,), rad, of drums, and lengths *paid* out (m,), m, by *counts* (w,) since those *before*.

    *winch*, *sense* (m,): winch of each line, and which way it winds; *per_radian*: counts per radian; *begin* (m,),
    rad, was wound then. *radii*, *wound*, *turns*: see `winding.paid_out`. Returns whether the drums hold the angles;
    if not, *paid* is not valid.
    """
    m = rotation.shape[0]
    now = np.empty(m)
    for i in range(m):
        rotation[i] = sense[i] * (counts[winch[i]] - before[winch[i]]) / per_radian
        now[i] = begin[i] - rotation[i]
    return paid_out(radii, wound, turns, begin, now, paid)


@jit(allocates=True)
def tell(packed, pose, before, share, dt, velocity, lengths, begin, rotation, radii, turns, found):
    """Write the numbers *found* (9 + 3 m,) of an estimate at the *pose* (3,), m, in balance with *lengths* (m,), m.

    *before* (3,), m: the pose *dt*, s, before. In place: *velocity* (3,), m/s, to which the present one counts with a
    *share*. Other arguments are those of `unwind`.
    """
    m = lengths.shape[0]
    drawn, planes, toward, per_motion = np.empty((m, FOUND)), np.empty((m, 4)), np.empty((m, 3)), np.empty((m, 3))
    draw(packed, pose, drawn, planes, toward, per_motion)
    for k in range(3):
        velocity[k] += share * ((pose[k] - before[k]) / dt - velocity[k])
        found[PLACE + k], found[SPEED + k], found[ROTATION + k] = pose[k], velocity[k], 0.0
    for i in range(m):
        found[OF_LINES + i], found[OF_LINES + m + i] = lengths[i], lengths[i] - drawn[i, WHOLE]
    radii_by(radii, turns, begin - rotation, found[OF_LINES + 2 * m :])
