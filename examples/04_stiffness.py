"""Linearisation: stiffness, motion per length and per modulus."""

import cablewright as cw

robot = cw.load("house-printer")
hold = cw.inverse(robot, [1.0, 2.0, 1.5])
near = cw.linearise(hold)

for line, motion in zip(robot.lines, near.per_length.T, strict=True):
    print(f"1 mm more of {line.name:<11} moves the platform by {motion.round(3)} mm")
for line, motion in zip(robot.lines, near.per_modulus.T, strict=True):
    print(f"1 % stiffer  {line.name:<11} moves the platform by {(10.0 * motion).round(3)} mm")
print(f"vertical stiffness: {near.stiffness[2, 2] / 1e3:.2f} kN/m")
