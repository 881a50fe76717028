"""Inverse and forward problem: lengths and tensions at a pose, and back."""

import cablewright as cw

robot = cw.load("house-printer")
hold = cw.inverse(robot, [1.0, 2.0, 1.5]).checked()  # m, world; checked() raises if the answer is no

for line, length, tension in zip(robot.lines, hold.lengths, hold.tensions, strict=True):
    print(f"{line.name:<12} {length:8.4f} m  {tension:6.1f} N")

back = cw.forward(robot, hold.lengths)  # from the lengths alone, without a guess
print(f"forward leads back to {back.pose.round(6) + 0.0} m")
print(f"largest tension: {hold.tensions.max():.1f} N")
