"""G-code and job of a first part for a new robot: a small square of three layers, or in a plane a short wall."""

from __future__ import annotations

import math
from typing import Final

from cablewright.foundation.units import LENGTH, SPEED, Vec3, three_digits
from cablewright.printing.beads import Bead

LAYERS: Final = 3
FLAT: Final = 0.05  # m, depth below which a frame is a plane
GCODE: Final = "part.gcode"
"""Name of the G-code file in the job."""


def first_part(name: str, frame_min: Vec3, frame_max: Vec3) -> tuple[str, str]:
    """Return the texts of the job and of its G-code, `GCODE`, for a part in the middle of the floor of robot *name*.

    Bead and speeds follow the plan of the frame between the two corners, m; one that is a plane gets a wall.
    """
    sides = [high - low for low, high in zip(frame_min, frame_max, strict=True)]
    wide, deep = sides[0], sides[1]
    flat = deep < FLAT
    size = wide if flat else math.sqrt(wide * deep)
    bead = Bead(width=_millimetres(size / 150.0), height=_millimetres(size / 600.0))
    half = _millimetres(0.1 * (wide if flat else min(wide, deep)))
    corners = [(half, 0.0), (-half, 0.0)] if flat else [(half, -half), (half, half), (-half, half), (-half, -half)]
    speed = float(f"{size / 160.0:.2g}")
    job = _JOB.format(
        name=name,
        gcode=GCODE,
        width=LENGTH.write(bead.width, "mm"),
        height=LENGTH.write(bead.height, "mm"),
        print_speed=SPEED.write(speed, "m/s"),
        travel_speed=SPEED.write(three_digits(1.5 * speed), "m/s"),
        acceleration=f"{2.0 * speed:.2g}",
        corner=LENGTH.write(_millimetres(bead.width / 4.0), "mm"),
    )
    return job, _gcode(corners, bead, speed)


def _gcode(corners: list[tuple[float, float]], bead: Bead, speed: float) -> str:
    """The corners in order, layer by layer, from the last one; E is the volume in millilitres."""
    lines = ["; three layers, as a slicer would write them; E in millilitres", "G21", "G90", "M83"]
    at = corners[-1]
    for layer in range(LAYERS):
        height = 1e3 * (layer + 1) * bead.height
        lines += [f";LAYER:{layer}", f"G0 X{1e3 * at[0]:.3f} Y{1e3 * at[1]:.3f} Z{height:.3f} F{6e4 * speed:.0f}"]
        for corner in corners:
            volume = 1e6 * bead.section * math.dist(at, corner)
            lines.append(f"G1 X{1e3 * corner[0]:.3f} Y{1e3 * corner[1]:.3f} E{volume:.4f}")
            at = corner
    return "\n".join([*lines, ""])


def _millimetres(value: float) -> float:
    """Rounded to 0.1 mm, and at least that."""
    return max(1, round(value / 1e-4)) / 1e4


_JOB: Final = """\
# A first part for {name}. Put your own G-code in the place of {gcode}; bead and speeds are assumed.

schema = 1
name = "first part of {name}"
gcode = "{gcode}"
origin = [0.0, 0.0, 0.0]         # m: where the zero of the G-code is on the machine

[bead]
width = "{width}"
height = "{height}"

[motion]
print_speed = "{print_speed}"
travel_speed = "{travel_speed}"
acceleration = "{acceleration} m/s^2"
corner_deviation = "{corner}"
"""
