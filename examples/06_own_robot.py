"""A robot of your own, described in TOML."""

import cablewright as cw

TEXT = """
schema = 1
name = "workshop"
scene = { frame_min = [-2.0, -2.0, 0.0], frame_max = [2.0, 2.0, 3.0] }
platform = { mass = "3 kg" }
cable = { axial_stiffness = "150 kN", linear_density = "2 g/m", breaking_load = "2 kN" }
sheave = { kind = "swivel", radius = "25 mm" }
line = { tension_limits = ["2 N", "400 N"] }
lines = [
    { name = "front", exit_point = ["0 cm", "-190 cm", "2.9 m"] },
    { name = "left", exit_point = [-1.9, 1.5, 2.9] },
    { name = "right", exit_point = [1.9, 1.5, 2.9] },
]
"""

robot = cw.loads(TEXT, "workshop.toml")
hold = cw.inverse(robot, [0.0, 0.0, 1.0]).checked()
print(f"{robot.m} lines, {robot.n} degrees of freedom, tensions {hold.tensions.round(2)} N")
print(f"length of line {robot.lines[0].name}: {hold.lengths[0]:.4f} m")
