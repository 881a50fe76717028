"""A beam that retracts by its law prints a leaning wall; fixed, it cannot."""

from pathlib import Path
from tempfile import TemporaryDirectory

import cablewright as cw

JOB = """
schema = 1
name = "leaning wall"
gcode = "wall.gcode"
bead = { width = "10 mm", height = "4 mm" }
motion = { print_speed = "10 cm/s", travel_speed = "8 mm/s", acceleration = "50 mm/s^2" }
"""
LAW = 'schedule = [{ z = 0.1, retraction = "2 m" }, { z = 1.5, retraction = "1.2 m" }]\n'

gcode = ["G21", "G90", "M83"]  # mm, absolute, relative extrusion
for layer, half in enumerate((600, 665, 730)):  # squares of example 09: its lowest, its middle and its highest one
    gcode += [f";LAYER:{layer}", f"G0 X{-half} Y{-half} Z{100 + 700 * layer}"]
    gcode += [f"G1 X{x * half} Y{y * half} E50" for x, y in ((1, -1), (1, 1), (-1, 1), (-1, -1))]

robot = cw.load("jung2020")
tip = robot.platform.model_copy(update={"nozzle": (0.0, 0.0, -0.2)})  # m, platform frame: the beam's lower end
robot = robot.model_copy(update={"platform": tip})
options = cw.PrintOptions(plant="quasi-static", period=0.2, seed=1)

with TemporaryDirectory() as folder:
    (Path(folder) / "wall.gcode").write_text("\n".join(gcode) + "\n")
    (Path(folder) / "law.toml").write_text(JOB + LAW)
    (Path(folder) / "fixed.toml").write_text(JOB)
    fixed = cw.load_job(Path(folder) / "fixed.toml")
    unheld = {}
    for length in (1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8, 1.9, 2.0):
        found = cw.check(robot.retracted(length), fixed, skip=("interference", "expected-error"))
        unheld[length] = int((found.codes != 0).sum())
    best = min(unheld, key=unheld.__getitem__)
    print(f"fixed at its best length, {best} m, {unheld[best]} of {len(found.codes)} samples cannot be held")
    try:
        cw.print_job(robot.retracted(best), fixed, Path(folder) / "fixed", options=options)
    except cw.CablewrightError as reason:
        print(f"so that a print is rejected: {reason}")
    done = cw.print_job(robot, cw.load_job(Path(folder) / "law.toml"), Path(folder) / "law", options=options)

whole = done.record.whole
print(f"by its law: {done.run.reason}, nozzle within {1e3 * whole.position_max:.1f} mm of its target")
print(f"the least distance of a tension inside its limits: {whole.min_tension_margin:.1f} N")
