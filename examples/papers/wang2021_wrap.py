"""The length of a line by Eq. 11 of Wang, Caro 2021 as printed, by its Eqs. 3 and 6, and by cablewright."""

import numpy as np

import cablewright as cw

robot, point = cw.load("wang2021"), np.array([0.3, 0.2, 1.0])
line = robot.lines[0]
exit_point, r = np.array(line.exit_point), line.sheave.radius
towards = (point - exit_point) * [1.0, 1.0, 0.0]
towards /= np.linalg.norm(towards)


def length(m, over):
    straight = np.sqrt(m @ m - r * r)
    gamma = np.arcsin((exit_point[2] - point[2]) / np.linalg.norm(m))
    return straight + r * (np.pi - np.arctan2(straight, r) - (-gamma if over else gamma))


def ours(wrap):
    lines = tuple(
        each.model_copy(update={"sheave": each.sheave.model_copy(update={"wrap": wrap})}) for each in robot.lines
    )
    return cw.inverse(robot.model_copy(update={"lines": lines}), point, cable="rigid").lengths[0]


print(f"Eq. 11 as printed            {length(point - exit_point + r * towards, over=False):.4f} m")
print(f"Eqs. 3 and 6, under          {length(point - exit_point - r * towards, over=False):.4f} m")
print(f"Eqs. 3 and 6, over           {length(point - exit_point - r * towards, over=True):.4f} m")
print(f'cablewright, wrap = "under"  {ours("under"):.4f} m')
print(f'cablewright, wrap = "over"   {ours("over"):.4f} m')
