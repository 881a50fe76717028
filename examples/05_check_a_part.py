"""`check` of a sliced part written in the script."""

from pathlib import Path
from tempfile import TemporaryDirectory

import cablewright as cw

gcode = ["G21", "G90", "M83", "G0 X-1000 Y-1000 Z20 F6000"]  # mm, absolute, relative extrusion
for layer, height in enumerate((20, 40)):
    gcode += [f";LAYER:{layer}", f"G0 Z{height}"]
    gcode += [f"G1 X{x} Y{y} E50" for x, y in ((1000, -1000), (1000, 1000), (-1000, 1000), (-1000, -1000))]

with TemporaryDirectory() as folder:
    path = Path(folder) / "square.gcode"
    path.write_text("\n".join(gcode) + "\n")
    found = cw.check(cw.load("house-printer"), cw.load_job(path))

print(found.verdict)
print("not checked:", "; ".join(found.not_checked))
for cause in found.expected.causes if found.expected else ():
    print(f"{cause.words}: {100 * cause.share:.0f} % of the expected error; {1e3 * cause.without:.1f} mm without it")
print(f"{found.toolpath.layer_count} layers, {found.samples.extruded_length:.0f} m laid in {found.law.duration:.0f} s")
print(f"largest error without compensation: {1e3 * found.error_uncompensated.max():.2f} mm")
