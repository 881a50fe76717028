"""Calibrate.

Numbers of a robot from measurements.
"""

from datetime import UTC, datetime

import numpy as np

import cablewright as cw
from cablewright.calibration.drift.record import record_of

robot = cw.load("wang2021")
made: cw.SimulatedCalibration = cw.simulate_calibration(robot, 20, 1e-4, seed=1, sensors=cw.SensorNoise())
data: cw.Measured = made.measured
found: cw.Calibration = cw.calibrate(robot, data, cw.CalibrationPlan(sigma=cw.Sigmas(encoder=1e-4)), outliers=False)
exits, _ = cw.aligned(found.values[:12].reshape(4, 3), np.array([line.exit_point for line in robot.lines]))
advice: cw.Guidance = cw.guide(robot, data, count=2)
file = "examples/calibration.csv"
kept = cw.calibrate(robot, file)
record: cw.CalibrationRecord = record_of(kept, file, datetime.now(UTC))
drift: cw.Drift = cw.check_drift(kept.robot, file, record)
chosen: cw.CalibrationPoses = cw.calibration_poses(robot, 12, candidates=100)

lens: cw.CameraFit = cw.camera("examples/phone.yml")
phone: cw.Camera = lens.camera
tags = cw.TagLayout(tags=(cw.Tag(number=0, size=0.15, at=(0.2, 0.0, 0.1)),))
pictures = cw.read_sightings  # (folder, tags, phone, number of poses): cw.Sightings, for replace(data, sightings=...)

shots: type[cw.Shots] = cw.Shots  # rows of cw.Shot
site: cw.Survey = cw.survey("examples/survey.gsi", "examples/survey.toml", robot=cw.load("merlet2023"))
plan: type[cw.SurveyPlan] = cw.SurveyPlan
test: type[cw.TensileTest] = cw.TensileTest
cable: cw.TensileResult = cw.modulus("examples/tensile.csv", initial_length=1.0, section=12.6e-6, breaking_load=8e3)
crept = cw.creep("examples/creep.csv", initial_length=2.0)

scan: cw.FileScan = cw.read_scan("examples/scan.csv")
seen: cw.Walls = cw.walls(scan)
room = cw.RoomMap.of({"west": ((-1, 0), 2.5), "east": ((1, 0), 2.5), "north": ((0, 1), 5.0)})
laser = cw.Laser("east", 1.32)
place: type[cw.LidarPlace] = cw.LidarPlace  # of cw.walls(scan, room=room)
