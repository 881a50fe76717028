"""Position error with the lengths of rigid cables: Paty 2021, Table 1, P1.

The paper prints 19.5 mm; see docs/papers.md for what differs.
"""

import cablewright as cw

robot = cw.load("paty2021")
wanted = [0.0, 0.0, 0.0]

rigid = cw.inverse(robot, wanted, cable="rigid")  # what a controller without compensation pays out
real = cw.forward(robot, rigid.lengths)  # the same lengths on cables that stretch and sag

off = real.pose - wanted
print(f"error: {off.round(6) + 0.0} m")
print(f"distance: {1e3 * (off @ off) ** 0.5:.1f} mm")
