"""One winch pays out: the length at which its line goes slack."""

import numpy as np

import cablewright as cw

robot = cw.load("merlet2023")
hold = cw.inverse(robot, [0.0, -1.0, 1.0])
by = np.linspace(0.0, 0.02, 201)
found = cw.let_out(robot, hold.lengths, "north-west", by).checked()

print("let out by  moved    south-west  south-east  north-east  north-west")
for row in range(0, len(by), 40):
    moved = np.linalg.norm(found.pose[row] - hold.pose)
    print(f"{1e3 * by[row]:7.0f} mm {1e3 * moved:5.2f} mm", *(f"{t:9.1f} N" for t in found.tensions[row]))

excess = cw.excess_lengths(found)[:, 3]
print(f"slack when let out by: {1e3 * np.interp(0.0, excess, by):.2f} mm")
