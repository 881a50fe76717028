"""One line 0.3 m too long: tension of a slack line."""

import cablewright as cw

robot = cw.load("merlet2023")
hold = cw.inverse(robot, [0.0, -1.0, 1.0])

lengths = hold.lengths.copy()
lengths[3] += 0.3
found = cw.forward(robot, lengths)

for line, before, after in zip(robot.lines, hold.tensions, found.tensions, strict=True):
    print(f"{line.name:<12} {before:6.1f} N before, {after:6.1f} N after")
print(f"moved by {(1e3 * (found.pose - hold.pose)).round(1)} mm")
print(f"slack line at the platform: {found.platform_tensions[3]:.2f} N")
