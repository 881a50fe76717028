"""Write ``docs/library.md``: a table and a gallery of the robots of the library. Numbers are those of the files.

``python tools/pages/library.py``
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import cablewright as cw
from cablewright.robot import Robot, library_names
from cablewright.robot.cable import CONSTRUCTIONS
from cablewright.robot.cable_table import CABLES, StockCable
from cablewright.robot.new_robot import LAYOUTS

PAGE = Path(__file__).resolve().parents[2] / "docs" / "library.md"

ABOUT = {
    "building-printer": ("nothing: a design", "all data", "a nozzle without tilt, in the frame of house-printer"),
    "cable-robot-simulator": (
        "exit points, platform points, limits",
        "mass, cable, sheaves",
        "tensions of kilonewtons, held from above and below",
    ),
    "caroca": (
        "exit points, platform, limits, sheaves",
        "cable",
        "suspended on crossed lines; exit points that can be moved",
    ),
    "cogiro": (
        "exit points and platform points (as measured), masses, limits",
        "cable, sheaves",
        "suspended, 8 lines, a cube of 1 m",
    ),
    "expo2015-lucia": (
        "exit points and platform points (as measured), mass, cable",
        "tension limits",
        "cables from above",
    ),
    "fast-telescope": ("exit points, platform points", "mass, cable, min tension", "lines of 300 m: weight and sag"),
    "grab-four-lines": (
        "exit points, platform, inertia",
        "cable, limits",
        "fewer lines than degrees of freedom: it swings",
    ),
    "grab-prototype": (
        "exit points, sheaves, platform points, inertia (as measured)",
        "cable, limits",
        "fewer lines than degrees of freedom; frequencies measured by motion capture",
    ),
    "hangprinter-five": (
        "spools and advantage (the firmware's defaults)",
        "exit points, mass, cable, min tension",
        "a nozzle below the point where lines meet",
    ),
    "hangprinter-v4": (
        "exit points and spools (calibrated), advantage",
        "mass, cable, min tension",
        "advantage; a low-cost printer",
    ),
    "house-printer": ("as paty2021", "winches, low limit", "prints the house of the examples; has a simulated machine"),
    "ipanema": ("arrangement", "all numbers", "held between tight lines; has a simulated machine"),
    "ipanema1": (
        "exit points, platform points, mass, max tension, drums",
        "cable, min tension",
        "held between tight lines",
    ),
    "ipanema2": ("exit points (as measured), platform points, mass, limits", "cable", "crossed lines above and below"),
    "ipanema3": ("exit points and platform points (as measured), inertia", "cable, limits", "a large hall"),
    "jung2020": (
        "exit points, beam, EA, limits",
        "weight and strength of the cable",
        "a beam whose length changes with height",
    ),
    "jung2020-table1": (
        "exit points, beam, EA, limits",
        "weight and strength of the cable",
        "a singular layout, from the same paper",
    ),
    "maslow4": ("distance of the belts from the board", "all else", "a platform in a plane, belts that leave it"),
    "merlet2023": (
        "powder container, gears, EA and mass of the cable",
        "exit points, room, drums, limits",
        "printed 142 layers; has a simulated machine",
    ),
    "nist-robocrane": (
        "exit points, platform points, max tension",
        "mass, cable",
        "as many lines as degrees of freedom: weight alone",
    ),
    "paty2021": (
        "frame, levers, cable, limits",
        "exact exit points, sizes of the bracket",
        "universal joints with levers",
    ),
    "skycam": ("arrangement", "all numbers", "a large field: weight and sag of long lines"),
    "wall-plotter": ("arrangement", "all numbers", "two belts in a vertical plane"),
    "wang2021": ("number of lines, sheaves", "exit points, mass, cable, limits", "a point on 4 lines: calibration"),
}
"""Of each robot: the data of its source, the assumed data, and its purpose in the library."""

_HEAD = """\
# The library

These robots come with cablewright. Print the file of one to start your own: `cablewright robots NAME > mine.toml`. Each
file names its source and marks the assumed numbers. No robot was compared with its machine.

* "As measured": the source has unsymmetric coordinates, to a millimetre or finer.
* "Calibrated": the source reports the results of a calibration.

[Import](exchange.md) reads more robots from files of other programs.

"""


def page() -> str:
    """Return the text of the page."""
    rows = "".join(_row(name, cw.load(name)) for name in library_names())
    pictures = "".join(f"### {name}\n\n{_picture(name, cw.load(name))}\n" for name in library_names())
    return (
        _HEAD
        + "| robot | lines | degrees of freedom | size, m | mass | cable | source has | assumed | example of |\n"
        + "| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n"
        + rows
        + "\nThe size is that of the box around the exit points, from the floor up. Pictures are drawn by\n"
        + "`cablewright show NAME --png FILE`: at rest, near the middle of the frame.\n\n"
        + pictures
        + _stock()
    )


STOCK = """## Cables and layouts of `new`

| layout | robot | lines | allowed |
| --- | --- | --- | --- |
{layouts}
| cable | construction | EA, kN | true EA over that | mass, g/m | breaking load, kN | least radius, mm |
| --- | --- | --- | --- | --- | --- | --- |
{cables}
The comments of the files name the sources (EN 12385-4, manufacturers' data, Merlet and Papegay 2023, RepRapFirmware).
The ranges of EA and the minimum radii are assumed. [`modulus`](modulus.md) finds EA from a tensile test.

## Steel cables

Metallic section over the squared diameter, the factor C of EN 12385-4, by `cable.construction`. FC: fibre core, IWRC
and WSC: steel core; M: cross lay. The modulus of a stranded cable is its measured EA over this section.

| construction | C |
| --- | --- |
{ropes}"""


def _stock() -> str:
    """Return the tables of the layouts and cables of ``cablewright new``, and of steel wire ropes."""
    layouts = "".join(
        f"| `{name}` | {each.summary} | {each.lines} | {_span(each.counts)} |\n" for name, each in LAYOUTS.items()
    )
    cables = "".join(f"| `{name}` | {each.summary} | {_numbers(each)} |\n" for name, each in CABLES.items())
    ropes = "".join(f"| `{name}` | {factor:.3f} |\n" for name, factor in CONSTRUCTIONS.items())
    return STOCK.format(layouts=layouts, cables=cables, ropes=ropes)


def _span(counts: tuple[int, int]) -> str:
    low, high = counts
    return f"{low}" if low == high else f"{low} to {high}"


def _numbers(stock: StockCable) -> str:
    """Return the numbers of a cable as cells of the table."""
    cable, (low, high) = stock.cable, stock.modulus
    found = (1e-3 * cable.stiffness, 1e3 * cable.linear_density, 1e-3 * cable.breaking_load, 1e3 * stock.least_radius)
    return f"{found[0]:.4g} | {low:g} to {high:g} | {found[1]:.3g} | {found[2]:.4g} | {found[3]:g}"


def _row(name: str, robot: Robot) -> str:
    given, assumed, shows = ABOUT[name]
    exits = np.array([line.exit_point for line in robot.lines])
    low = np.array([*exits.min(axis=0)[:2], min(float(exits[:, 2].min()), 0.0)])
    size = " x ".join(f"{side:.3g}" for side in exits.max(axis=0) - low)
    cable = robot.lines[0].cable
    wide = "" if cable.diameter is None else f"{1e3 * cable.diameter:.3g} mm, "
    stiffness = f"{1e-6 * cable.stiffness:.3g} MN" if cable.stiffness >= 1e6 else f"{1e-3 * cable.stiffness:.3g} kN"
    return (
        f"| [`{name}`](#{name}) | {robot.m} | {robot.freedoms} | {size} | {float(f'{robot.platform.mass:.3g}'):g} kg | "
        f"{wide}EA {stiffness} | {given} | {assumed} | {shows} |\n"
    )


def _picture(name: str, robot: Robot) -> str:
    return f"{robot.description}. Source: {robot.source}.\n\n![{name} at rest](images/robot-{name}.png)\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
