"""A job whose schedule retracts the beam layer by layer."""

from pathlib import Path
from tempfile import TemporaryDirectory

import cablewright as cw

JOB = """
schema = 1
name = "leaning wall"
gcode = "wall.gcode"
schedule = [{ z = 0.1, retraction = "2 m" }, { z = 1.5, retraction = "1.2 m" }]
"""

gcode = ["G21", "G90", "M83"]  # mm, absolute, relative extrusion
for layer in range(15):  # squares 0.1 m above each other, from 1.2 m wide to 1.46 m
    half = 600 + 130 * layer / 14
    gcode += [f";LAYER:{layer}", f"G0 X{-half} Y{-half} Z{100 + 100 * layer}"]
    gcode += [f"G1 X{x * half} Y{y * half} E50" for x, y in ((1, -1), (1, 1), (-1, 1), (-1, -1))]

robot = cw.load("jung2020")
tip = robot.platform.model_copy(update={"nozzle": (0.0, 0.0, -0.2)})  # m, platform frame: the beam's lower end
robot = robot.model_copy(update={"platform": tip})

with TemporaryDirectory() as folder:
    (Path(folder) / "wall.gcode").write_text("\n".join(gcode) + "\n")
    (Path(folder) / "job.toml").write_text(JOB)
    job = cw.load_job(Path(folder) / "job.toml")
    found = cw.check(robot, job)
    for length in (2.0, 1.8, 1.6, 1.4, 1.2):
        constant = cw.check(robot.retracted(length), job.model_copy(update={"schedule": ()}))
        print(f"{length} m long: {(constant.codes != 0).sum()} of {len(constant.codes)} samples cannot be held")

print(found.verdict)
print(f"largest error without compensation: {1e3 * found.error_uncompensated.max():.3f} mm")
