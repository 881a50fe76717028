"""An eight-cable robot from points: matrices, wrenches, a trajectory, figures as PDF and SVG.

The figures are written into a temporary folder: take one of your own.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import cablewright as cw

CORNERS = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])  # of a rectangle, around it
TOP, FLOOR = (np.column_stack([CORNERS * [2.0, 1.5], np.full(4, z)]) for z in (3.0, 0.2))
LOW, HIGH = (np.column_stack([CORNERS * [0.1, 0.3], np.full(4, z)]) for z in (-0.2, 0.2))
EXITS, POINTS = np.vstack([TOP, FLOOR]), np.vstack([LOW, HIGH])  # crossed: cables from above end at the lower corners

robot = cw.Robot.from_points(
    EXITS, POINTS, mass="10 kg", inertia=(0.3, 0.4, 0.3), cable="dyneema-3mm", tension_limits=(20.0, 800.0), name="mine"
)
pose = [0.3, 0.2, 1.5]
print(robot)
print("condition number of the Jacobian:", round(float(cw.dexterity(robot, pose, length=0.25).condition_number), 2))
print("stiffness along z:", round(cw.stiffness(robot, pose).total[2, 2] / 1e3), "kN/m")
print("natural frequencies:", cw.natural_frequencies(robot, pose).round(1), "Hz")

wrenches = cw.available_wrenches(robot, pose)
print(f"available wrenches: {wrenches.facets} facets; the weight is {wrenches.margin:.0f} N inside")
stiffer = robot.with_(tension_limits=(100.0, 800.0))
print("with more pretension:", cw.natural_frequencies(stiffer, pose)[0].round(1), "Hz")

corners = [[0.0, 0.0, 1.2, 0, 0, 0], [0.6, 0.4, 1.6, 0, 0, 0.1], [-0.6, 0.4, 1.8, 0, 0.1, 0], [0.0, 0.0, 1.2, 0, 0, 0]]
moved = cw.inverse_dynamics(robot, cw.Trajectory.spline(corners, 6.0))
print(moved)

with TemporaryDirectory() as name:
    folder = Path(name)
    wrenches.plot(folder / "wrenches.pdf", width="one-column")
    cw.compare_tensions(robot, pose).plot(folder / "tensions.svg", width="one-column")
    moved.plot(folder / "dynamics.pdf", width="two-column")
    print("written:", ", ".join(sorted(file.name for file in folder.iterdir())))
print(f"largest power of a line: {moved.max_power.max():.1f} W")
