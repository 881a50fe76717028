"""A counterweight for most of the platform: weaker winches, smaller workspace."""

import numpy as np

import cablewright as cw

plain = cw.load("merlet2023")
middle = cw.Line(
    name="middle",
    exit_point=(0.0, 0.0, 4.0),
    counterweight=30.0,  # kg, of the 40 kg that the platform weighs
    cable=plain.lines[0].cable,
    sheave=cw.Eyelet(),
    tension_limits=(1.0, 2000.0),
)
helped = plain.model_copy(update={"name": "helped", "lines": (*plain.lines, middle)})

print("x, y, z, m       largest tension of a winch, N   lowest frequency, Hz")
print("                 without   with counterweight    without   with")
for place in np.array([[0.0, 0.0, 2.0], [0.6, 0.0, 1.0], [0.6, 0.8, 1.0], [1.2, 2.5, 1.0], [0.0, 0.0, 1.0]]):
    found = [cw.modes(robot, place) for robot in (plain, helped)]
    pulls = [each.equilibrium.tensions[:4].max() for each in found]
    where = " ".join(f"{x:4.1f}" for x in place)
    if found[1].has_modes:
        print(f"{where}  {pulls[0]:8.1f} {pulls[1]:19.1f} {found[0].lowest:10.2f} {found[1].lowest:6.2f}")
    else:
        print(f"{where}  {pulls[0]:8.1f}   it cannot be held there: {found[1].equilibrium.status.word}")
print(f"largest tension of a winch below the middle: {pulls[1]:.1f} N")
