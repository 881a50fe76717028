"""Describe a robot and a job.

A robot is a frozen description from TOML; a model adds the chosen physics. A job is a path with its speeds.
"""

import cablewright as cw

robot = cw.load("house-printer")  # one of cw.library_names(), or a file
TEXT = """
schema = 1
name = "hoist"
scene = { frame_min = [-1, -1, 0], frame_max = [1, 1, 2] }
platform = { mass = "1 kg" }
cable = { axial_stiffness = "1 kN", linear_density = "1 g/m", breaking_load = "1 kN" }
sheave = { kind = "eyelet" }
line = { tension_limits = ["0 N", "100 N"] }
lines = [{ name = "up", exit_point = [0, 0, 2] }]
"""
own: cw.Robot = cw.loads(TEXT, "hoist.toml")
assert own.name not in cw.library_names()
model = cw.Model(robot, cw.Fidelity(cw.CableLaw.ELASTIC, cw.SheaveLaw.SWIVEL))

ranges: tuple[cw.Range, ...] = cw.modulus_ranges(robot, 0.9, 1.1)
assert ranges[0].parameter == cw.Parameter("modulus", "south-west")
uncertain: cw.Uncertainty = cw.load_uncertainty("examples/uncertain.toml")
heavier = cw.changed(robot, {cw.Change("mass"): 100.0})
box = cw.with_box_inertia(cw.load("jung2020"))

job: cw.Job = cw.load_job("examples/house.toml")
drawn: cw.Curves = cw.curves(28.0, (3.6, 8.0), count=3, seed=1)
best: cw.RankedCurve = drawn.ranked[0]
curve: cw.Curve = best.curve
mesh: type[cw.TriangleMesh] = cw.TriangleMesh  # what cw.read_stl(FILE) gives
