"""Zeros of swivels and load cells, estimated with the exit points."""

from dataclasses import replace

import numpy as np

import cablewright as cw

robot = cw.load("wang2021")
sensors = cw.SensorNoise(tension=2.0, swivel=1e-3)  # N, rad
measured = cw.simulate_calibration(robot, 40, 1e-4, seed=1, sensors=sensors).measured
zeros, cells = np.array([0.3, -2.0, 1.0, 3.0]), np.array([6.0, -40.0, 20.0, 60.0])  # rad, N: true value less reading
measured = replace(measured, swivel=measured.swivel - zeros, tensions=measured.tensions - cells)

trusted = cw.calibrate(robot, measured, rough=0.05)
print(f"with zeros that count as right: {trusted.verdict}, {trusted.reasons[0]}")

plan = cw.CalibrationPlan(unknowns=("exit_point", "length_offset", "swivel_offset", "tension_offset"))
found = cw.calibrate(robot, measured, plan, rough=0.05)
print(f"with unknown zeros: {found.verdict}")
for unknown, value, sigma in zip(found.unknowns, found.values, found.sigma, strict=True):
    if unknown.name in ("swivel_offset", "tension_offset"):
        print(f"{unknown.label}: {value:.4g} +- {sigma:.2g} {unknown.unit}")
print(f"exit points known to: {1e3 * found.exit_sigma:.2f} mm")
