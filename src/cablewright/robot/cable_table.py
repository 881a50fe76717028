"""A small table of cables that can be bought, for robots that are described from nothing.

Each is the text of a table ``[cable]`` whose comments name the source of every number. What no source gives is marked
"assumed". A cable that was measured is better than any of these: `cablewright modulus` finds its EA.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Final

from cablewright.foundation.units import FORCE, LINEAR_DENSITY, three_digits
from cablewright.robot.cable import Cable

SAFETY: Final = 5.0
"""Breaking load over the largest tension: what cable makers ask for in general use, 20 % of the breaking load."""

STRENGTH: Final = 950e6
"""Breaking load over the square of the diameter of braided Dyneema, N/m^2; see `_braided`."""

ELONGATION: Final = 0.006
"""Strain of a braided Dyneema cable at a fifth of its breaking load."""

DENSITY: Final = 756.0
"""Mass per metre over the square of the diameter of braided Dyneema, kg/m^3."""


@dataclass(frozen=True)
class StockCable:
    """A cable of the table.

    ``table``: the lines of its ``[cable]``; ``modulus``: min and max of the true EA over that of the table, assumed;
    ``least_radius``: smallest radius of the sheaves and drums over which the cable may run, m.
    """

    summary: str
    table: str
    modulus: tuple[float, float]
    least_radius: float

    @cached_property
    def cable(self) -> Cable:
        """The cable that the table describes."""
        return Cable.model_validate(tomllib.loads(self.table))

    @property
    def max_tension(self) -> float:
        """Largest tension in use, N: the breaking load over `SAFETY`."""
        return self.cable.breaking_load / SAFETY


def _braided(millimetres: float) -> str:
    """The table of a cable of 12 braided strands of Dyneema SK78.

    Cables on sale break at 951 N/mm^2 times the square of their diameter (7/64 inch, 1650 lbf), 1022 (1.5 mm, 230 daN)
    and 1059 (3/16 inch, 5400 lbf): the least is taken.
    """
    square = (1e-3 * millimetres) ** 2
    breaking = STRENGTH * square
    stiffness = FORCE.write(three_digits(breaking / SAFETY / ELONGATION), "kN")
    density = LINEAR_DENSITY.write(three_digits(DENSITY * square), "g/m")
    return f"""\
# A cable of 12 braided strands of Dyneema SK78. Makers state breaking loads of 950 to 1060 N/mm^2 times the square of
# the diameter, and up to 0.6 % of stretch at a fifth of that (tables for sailors); heat-set ones by half.
axial_stiffness = "{stiffness}"    # a fifth of the breaking load at a strain of 0.6 %
linear_density = "{density}"    # as Merlet and Papegay 2023: 6.8 g/m at 3 mm
breaking_load = "{FORCE.write(three_digits(breaking), "kN")}"      # 950 N/mm^2 times the square of the diameter
diameter = "{millimetres:g} mm"
thermal_expansion = "-12 ppm/K" # assumed: along the fibres
"""


def _belt(name: str, stiffness: str, density: str, breaking: str) -> str:
    return f"""\
# A timing belt {name}, 10 mm wide, polyurethane with steel cords: Elatech's catalogue of polyurethane belts, type M.
axial_stiffness = "{stiffness}"     # the catalogue's specific spring rate
linear_density = "{density}"
breaking_load = "{breaking}"
diameter = "10 mm"             # its width, so that distances are of its widest side
thermal_expansion = "12 ppm/K" # assumed: of its steel cords
"""


_STEEL: Final = """\
# A steel wire rope 6x19 with a fibre core, grade 1770, by EN 12385-4.
young_modulus = "100 GPa"      # assumed, of the wires' section: 80 to 120 are usual, and less when new
construction = "6x19-FC"
linear_density = "57.4 g/m"    # EN 12385-4: W = 0.359
breaking_load = "9.35 kN"      # EN 12385-4: K = 0.330
diameter = "4 mm"
thermal_expansion = "12 ppm/K" # assumed: steel
"""

_SPECTRA: Final = """\
# A braided polyethylene line (Spectra, Dyneema) of 1.1 mm, as Hangprinters use.
axial_stiffness = "45 kN"      # RepRapFirmware, HangprinterKinematics.cpp: between 20 and 100 kN; their middle by ratio
linear_density = "0.915 g/m"   # assumed: as a cable of Dyneema of that diameter
breaking_load = "1.15 kN"      # assumed: as a cable of Dyneema of that diameter
diameter = "1.1 mm"
thermal_expansion = "-12 ppm/K" # assumed: along the fibres
"""

CABLES: Final[Mapping[str, StockCable]] = MappingProxyType(
    {"steel-4mm": StockCable("steel wire rope 6x19, 4 mm", _STEEL, (0.8, 1.2), 0.05)}
    | {
        f"dyneema-{size}mm": StockCable(
            f"braided Dyneema SK78, {size} mm", _braided(size), (0.6, 1.4), max(0.02, 5e-3 * size)
        )
        for size in (1, 2, 3, 4, 5, 6)
    }
    | {
        "spectra-1.1mm": StockCable("braided Spectra line, 1.1 mm", _SPECTRA, (0.45, 2.2), 0.02),
        "belt-at5-10mm": StockCable(
            "timing belt AT5, 10 mm", _belt("AT5", "140 kN", "0.03 kg/m", "2 kN"), (0.9, 1.1), 0.03
        ),
        "belt-atl5-10mm": StockCable(
            "timing belt ATL5, 10 mm", _belt("ATL5", "275 kN", "0.04 kg/m", "4 kN"), (0.9, 1.1), 0.03
        ),
    }
)
"""Cables by name."""
