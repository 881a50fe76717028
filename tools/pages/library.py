"""Write ``docs/library.md``: a table and a gallery of the robots of the library. Numbers are those of the files.

``python tools/pages/library.py``
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import cablewright as cw
from cablewright.robot import Robot, library_names

PAGE = Path(__file__).resolve().parents[2] / "docs" / "library.md"

ABOUT = {
    "building-printer": ("nothing: a design", "all", "a head that does not tilt, in the frame of house-printer"),
    "cable-robot-simulator": (
        "exits, platform points, limits",
        "mass, cable, sheaves",
        "tensions of kilonewtons, held from above and below",
    ),
    "caroca": ("exits, platform, limits, sheaves", "cable", "suspended on crossed lines; exits that can be moved"),
    "cogiro": (
        "exits and platform points (as measured), masses, limits",
        "cable, sheaves",
        "suspended, 8 lines, a cube of 1 m",
    ),
    "expo2015-lucia": ("exits and platform points (as measured), mass, cable", "tension limits", "cables from above"),
    "fast-telescope": ("exits, platform points", "mass, cable, min tension", "lines of 300 m: weight and sag"),
    "grab-four-lines": ("exits, platform, inertia", "cable, limits", "fewer lines than freedoms: it swings"),
    "grab-prototype": (
        "exits, sheaves, platform points, inertia (as measured)",
        "cable, limits",
        "fewer lines than freedoms; frequencies measured by motion capture",
    ),
    "hangprinter-five": (
        "spools and advantage (the firmware's defaults)",
        "exits, mass, cable, min tension",
        "a nozzle below the point where lines meet",
    ),
    "hangprinter-v4": (
        "exits and spools (calibrated), advantage",
        "mass, cable, min tension",
        "advantage; a low-cost printer",
    ),
    "house-printer": ("as paty2021", "winches, low limit", "prints the house of the examples; has a simulated machine"),
    "ipanema": ("arrangement", "all numbers", "held between tight lines; has a simulated machine"),
    "ipanema1": ("exits, platform points, mass, max tension, drums", "cable, min tension", "held between tight lines"),
    "ipanema2": ("exits (as measured), platform points, mass, limits", "cable", "crossed lines above and below"),
    "ipanema3": ("exits and platform points (as measured), inertia", "cable, limits", "a large hall"),
    "jung2020": (
        "exits, beam, EA, limits",
        "weight and strength of the cable",
        "a beam whose length changes with height",
    ),
    "jung2020-table1": (
        "exits, beam, EA, limits",
        "weight and strength of the cable",
        "a singular layout, from the same paper",
    ),
    "maslow4": ("how far belts are off the board", "all else", "a platform in a plane, belts that run off it"),
    "merlet2023": (
        "drum of powder, gears, EA and mass of the cable",
        "exits, room, drums, limits",
        "printed 142 layers; has a simulated machine",
    ),
    "nist-robocrane": ("exits, platform points, max tension", "mass, cable", "as many lines as freedoms: weight alone"),
    "paty2021": ("frame, levers, cable, limits", "exact exits, sizes of the bracket", "universal joints with levers"),
    "skycam": ("arrangement", "all numbers", "a large field: weight and sag of long lines"),
    "wall-plotter": ("arrangement", "all numbers", "two belts in a vertical plane"),
    "wang2021": ("number of lines, sheaves", "exits, mass, cable, limits", "a point on 4 lines: calibration"),
}
"""Of each robot: what its source gives, what is assumed, what it shows."""

_HEAD = """\
# The library

Robots that come with cablewright, to look at, to compare with and to start from: `cablewright robots NAME > mine.toml`.
Each file names its source and marks what is assumed. None of them is a measurement of ours, and none was checked
against the machine. "As measured": unsymmetric in the source, to a millimetre or finer, as measured points are; the
source does not always say so. "Calibrated": results of a calibration, says the source.
[Import](exchange.md) reads more of them from files of other programs.

"""


def page() -> str:
    """The text of the page."""
    rows = "".join(_row(name, cw.load(name)) for name in library_names())
    pictures = "".join(f"### {name}\n\n{_picture(name, cw.load(name))}\n" for name in library_names())
    return (
        _HEAD
        + "| robot | lines | freedoms | exits within, m | platform | cable | given by the source | assumed | shows |\n"
        + "| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n"
        + rows
        + "\nThe size is that of the box around the exit points, from the floor up. Pictures: at rest, as\n"
        + "`cablewright show NAME --png FILE` draws them, near the middle of the frame.\n\n"
        + pictures.rstrip("\n")
        + "\n"
    )


def _row(name: str, robot: Robot) -> str:
    given, assumed, shows = ABOUT[name]
    exits = np.array([line.exit_point for line in robot.lines])
    low = np.array([*exits.min(axis=0)[:2], min(float(exits[:, 2].min()), 0.0)])
    size = " x ".join(f"{side:.3g}" for side in exits.max(axis=0) - low)
    cable = robot.lines[0].cable
    wide = "" if cable.diameter is None else f"{1e3 * cable.diameter:.3g} mm, "
    rope = f"{wide}EA {1e-3 * cable.stiffness:.3g} kN"
    return (
        f"| [`{name}`](#{name}) | {robot.m} | {robot.freedoms} | {size} | {robot.platform.mass:g} kg | {rope} | "
        f"{given} | {assumed} | {shows} |\n"
    )


def _picture(name: str, robot: Robot) -> str:
    return f"{robot.description}. Source: {robot.source}.\n\n![{name} at rest](images/robot-{name}.png)\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
