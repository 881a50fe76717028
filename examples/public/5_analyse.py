"""Analyse.

Workspace, accuracy, vibration and interference of a robot. Results with a picture have `plot()`.
"""

import numpy as np

import cablewright as cw

robot, beam = cw.load("house-printer"), cw.load("jung2020")
pose: cw.AccuracyAtPose = cw.accuracy(robot, [2.0, 1.0, 3.0])
rows: cw.Accuracy = cw.accuracy(robot, [[2.0, 1.0, 3.0], [0.0, 0.0, 5.0]], method=cw.FirstOrder())
plane: cw.AccuracyStudy = cw.accuracy(robot, cw.Places.plane(robot, 1.0, 4.0, 2.0), method=cw.Vertices())
drawn = cw.accuracy(robot, [2.0, 1.0, 3.0], method=cw.MonteCarlo(200))

volume: cw.Workspace = cw.workspace(beam, "closed-form", tolerance=0.05)
level: cw.WorkspaceArea = cw.workspace_area(beam, "closed-form", box=[-1, 1, -1, 1, 0.8, 0.8])
nodes: cw.NodeCount = cw.count_nodes(beam, "closed-form", grid=9)
drawn_in: cw.RetractionStudy = cw.retraction(beam, "closed-form", steps=3, heights=8, tolerance=0.05)
law: cw.RetractionLaw = drawn_in.law
swing: cw.Modes = cw.modes(beam, [0.2, 0.1, 0.9])
assert swing.mostly[0] in cw.FREEDOMS
two_lines, held_at = cw.load("grab-prototype").with_lines(["1", "3"]), [0.982, np.nan, -0.204, np.nan, np.nan, np.nan]
measured: cw.MeasuredModes = cw.measured_modes(two_lines, "examples/free-swing.csv", held_at)
edge: cw.Boundary = cw.boundary_modes(beam, "closed-form", grid=5)
plucked: cw.LineVibration = cw.line_vibration(beam, [0.2, 0.1, 0.9], "1", 29.0)
settings = cw.TradeSettings("closed-form", count="nodes", grid=5, boundary_grid=5)
found: cw.Trade = cw.trade(beam, {"exit-distance": [0.1, 0.2]}, settings)
quick = {"evaluations": 10, "population": 5}
better: cw.Designed = cw.design(robot, "examples/helix.toml", ["exit_point.z=8:15"], ["expected_error"], **quick)

near: cw.Interference = cw.interference(beam, [0.2, 0.1, 0.9], settings=cw.InterferenceSettings(ends=0.2))
stress: cw.BracketStress = cw.bracket(robot, [-2.25, -6.75, 13.0], times=1)
along_a_job: tuple[type[cw.Check], type[cw.JobInterference]] = (cw.Check, cw.JobInterference)  # of cw.check(robot, job)
