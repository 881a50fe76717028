"""The field's matrices.

What papers on cable robots call by these names. One pose gives one matrix, poses (N, n) give N of them; a row without
an answer is NaN, while a single pose without one raises `AnswerError`. The Jacobian, the structure matrix and the
available wrenches are of straight cables, which leave sheaves along their tangents. The stiffness and the frequencies
are of cables that stretch and sag, held by `inverse`.
"""

import numpy as np

import cablewright as cw

robot, pose = cw.load("cogiro"), [0.3, 0.2, 2.0]
J = cw.jacobian(robot, pose)  # (8, 6): how lengths follow a motion, m/m and m/rad
A = cw.structure_matrix(robot, pose)  # (6, 8): wrench per tension
assert np.allclose(A, -J.T)
K: cw.Stiffness = cw.stiffness(robot, pose)  # K.total, K.elastic, K.geometric; NumPy reads the total
assert np.linalg.eigvalsh(K)[0] > 0.0
hertz = cw.natural_frequencies(robot, [pose, [0.0, 0.0, 1.5]])  # (2, 6)
even: cw.Dexterity = cw.dexterity(robot, pose, length=0.5)  # .condition_number, .dexterity, .manipulability
available: cw.WrenchPolytope = cw.available_wrenches(robot, pose)  # .normals, .offsets, .vertices(), .volume
assert available.contains(available.required)
methods: cw.TensionComparison = cw.compare_tensions(robot, pose, ["least-norm", "exact"])

way: cw.Trajectory = cw.Trajectory.spline([[0.0, 0.0, 1.5], [1.0, 0.5, 2.0], [0.0, 1.0, 2.5]], 8.0)
point = cw.load("house-printer")
rates: cw.InverseDynamics = cw.inverse_dynamics(point, way)  # .lengths, .tensions, .length_rates, .power
assert rates.feasible
