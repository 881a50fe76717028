"""Print a wall that is higher than its printer: two stages, and how far apart their prints may be at the seam."""

from pathlib import Path
from tempfile import TemporaryDirectory

import cablewright as cw

robot = cw.load("examples/rails.toml")  # its exit points stand at 2.5 m, on rails
gcode = ["G21", "G90", "M83"]  # mm, absolute, relative extrusion
for layer, height in enumerate((500, 1500, 2200, 3000)):
    far = 300 if layer % 2 else -300
    gcode += [f";LAYER:{layer}", f"G0 X{-far} Y0 Z{height} F12000", f"G1 X{far} E50 F6000"]

with TemporaryDirectory() as folder:
    (Path(folder) / "wall.gcode").write_text("\n".join(gcode) + "\n")
    text = 'schema = 1\nname = "wall"\ngcode = "wall.gcode"\nmax_error = "5.6 mm"\nmax_seam = "9 mm"\n'
    motion = '[motion]\nprint_speed = "0.1 m/s"\ntravel_speed = "0.2 m/s"\nacceleration = "0.2 m/s^2"\n'
    bead = '[bead]\nwidth = "60 mm"\nheight = "20 mm"\n'
    (Path(folder) / "wall.toml").write_text(text + bead + motion)
    job = cw.load_job(Path(folder) / "wall.toml")
    found = cw.find_stages(robot, job, (2.5, 3.5), layers=2)

print(found.proof)
for each in found.checked.stages if found.checked else ():
    print(f"from {each.begin:.2f} m on: exit points at {each.stage.exit_height:.2f} m, {each.check.verdict}")
for seam in found.checked.seams if found.checked else ():
    print(f"seam at {seam.height:.2f} m, of exit points that are measured to 2 mm: {1e3 * seam.value:.1f} mm")
