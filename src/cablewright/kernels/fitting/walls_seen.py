"""How well candidate poses explain the points of a lidar's turn."""

from math import inf

from cablewright.kernels import jit


@jit
def explain(turned, level, xy, sees, near, recess, work, scores):
    """Score candidate poses by the number of lidar points *xy* (2, n), m, that lie on the walls seen from each.

    The numbers are added to *scores* (k,). ``turned[k, w] . xy + level[k, w]``: distance of a point beyond wall w, m. A
    point adds 1 if it is within *near* (m) of a visible wall, *sees* (w,), and -1 if it is more than *recess* (m)
    beyond any wall. Scratch: *work* (2, n).
    """
    x, y, nearest, farthest = xy[0], xy[1], work[0], work[1]
    for k in range(scores.shape[0]):
        nearest[:], farthest[:] = inf, -inf
        for w in range(sees.shape[0]):
            nx, ny, here, hidden = turned[k, w, 0], turned[k, w, 1], level[k, w], 0.0 if sees[w] else inf
            for i in range(x.shape[0]):
                beyond = nx * x[i] + ny * y[i] + here
                off = abs(beyond) + hidden
                nearest[i] = off if off < nearest[i] else nearest[i]
                farthest[i] = beyond if beyond > farthest[i] else farthest[i]
        for i in range(x.shape[0]):
            if farthest[i] > recess:
                scores[k] -= 1.0
            elif nearest[i] <= near:
                scores[k] += 1.0
