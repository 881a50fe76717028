"""The result of a tensile test of a cable: branches, nominal modulus, and its spread."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np

from cablewright.arrays import Array
from cablewright.calibration.tensile.recording import TensileTest
from cablewright.results import Figure, Pictured
from cablewright.units import AREA, FORCE

PAPER_SPREAD: Final = 0.3
"""By how much a modulus varies about the nominal one in Paty et al. 2021, Eq. 23."""

FIGURES = (
    Figure("status", "", "ok.", lambda _: "ok"),
    Figure("modulus", "Pa", "Nominal Young's modulus: secant of the last full loading over the band.", shown="GPa"),
    Figure("axial_stiffness", "N", "EA; the section cancels out of it.", name="axial stiffness EA", shown="kN"),
    Figure("modulus_range", "1", "Min and max modulus found anywhere, over the nominal one."),
    Figure("branch_factors", "1", "Min and max secant of all full branches, over the nominal one."),
    Figure("tangent_factors", "1", "Min and max tangent of all full branches, over the nominal one."),
    Figure("loading", "Pa", "Secant modulus of each full loading.", name="loadings", shown="GPa"),
    Figure("unloading", "Pa", "Secant modulus of each full unloading.", name="unloadings", shown="GPa"),
    Figure("cycles", "1", "Number of loadings that an unloading follows, both across the band."),
    Figure("partial", "1", "Number of branches that do not span the band.", name="partial branches"),
    Figure(
        "hysteresis", "1", "Loop of each full cycle over the work of its loading, within the band.", digits=3, shown="%"
    ),
    Figure(
        "permanent_set", "m", "Elongation from each full loading to the next, at the band's lower load.", shown="mm"
    ),
    Figure("r_squared", "1", "R^2 of the secant, over the nominal branch's forces.", name="R^2"),
    Figure("initial_length", "m", "Length of the specimen at elongation zero.", digits=6, shown="m"),
    Figure("length", "m", "Length of the specimen at the band's lower load.", digits=6, shown="m"),
    Figure("stretch", "m", "Elongation over the band, on the nominal branch.", shown="mm"),
    Figure("section", "m^2", "Section of the cable.", shown="mm^2"),
    Figure("breaking_load", "N", "Breaking load of the cable.", shown="kN"),
    Figure("band", "1", "Shares of the breaking load that the modulus spans.", shown="%", digits=3),
    Figure("robot_file", "", "What a robot file has of this cable.", "robot_file_text", "for the robot file"),
    Figure("against_paper", "", "The range of the modulus beside that of Paty 2021.", name="range of the modulus"),
    Figure("notes", "", "What a careful person would ask.", detail=True),
)


@dataclass(frozen=True, eq=False)
class Branch:
    """One loading or unloading across the whole band, in order of rising force; read-only arrays."""

    rising: bool  # whether it is a loading
    place: str  # in the test: ``line 7 to line 120``
    force: Array  # (k,) N, the samples within the band
    elongation: Array  # (k,) m
    ends: tuple[float, float]  # m, elongation at the band's lower and upper load
    modulus: float  # Pa, secant over the band
    tangents: Array  # (w,) Pa, least-squares slopes, each over a fifth of the stretch
    tangent_forces: Array  # (w,) N, mean force of each

    @property
    def word(self) -> str:
        """``loading`` or ``unloading``."""
        return "loading" if self.rising else "unloading"


@dataclass(frozen=True, eq=False, repr=False)
class TensileResult(Pictured):
    """The result of `modulus`: a cable's modulus, its spread and hysteresis."""

    FIGURES: ClassVar = FIGURES
    HEADLINES: ClassVar = ("modulus", "modulus_range", "cycles", "r_squared")
    PASTED: ClassVar = ("for the robot file",)  # labels of what people copy, line by line

    test: TensileTest
    modulus: float  # Pa, nominal: secant of the last full loading
    length: float  # m, of the cable at the band's lower load, on the nominal branch: l_init of Eq. 22
    stretch: float  # m, over the band, on the nominal branch: delta l of Eq. 22
    r_squared: float  # of the secant line, over the nominal branch's forces
    branches: tuple[Branch, ...]  # those that span the band, in order of time
    hysteresis: tuple[float, ...]  # of each full cycle: area of the loop over that under the loading, within the band
    permanent_set: tuple[float, ...]  # m, from each full loading to the next, at the band's lower load
    partial: int  # branches that do not span the band
    notes: tuple[str, ...]  # sentences on what limits the result
    initial_length: float  # m
    section: float  # m^2
    breaking_load: float  # N
    band: tuple[float, float]  # shares of the breaking load

    @property
    def axial_stiffness(self) -> float:
        """EA, N, from which the section cancels out."""
        return self.modulus * self.section

    @property
    def loads(self) -> tuple[float, float]:
        """The band's lower and upper load, N."""
        return self.band[0] * self.breaking_load, self.band[1] * self.breaking_load

    @property
    def cycles(self) -> int:
        """Number of loadings that are followed by an unloading, both across the band."""
        return len(self.hysteresis)

    @property
    def loading(self) -> tuple[float, ...]:
        """Secant modulus of each full loading, Pa."""
        return tuple(branch.modulus for branch in self.branches if branch.rising)

    @property
    def unloading(self) -> tuple[float, ...]:
        """Secant modulus of each full unloading, Pa."""
        return tuple(branch.modulus for branch in self.branches if not branch.rising)

    @property
    def branch_factors(self) -> tuple[float, float]:
        """Lowest and highest secant modulus of all full branches, over the nominal one."""
        secants = self.loading + self.unloading
        return min(secants) / self.modulus, max(secants) / self.modulus

    @property
    def tangent_factors(self) -> tuple[float, float]:
        """Lowest and highest tangent modulus of all full branches, over the nominal one."""
        tangents = np.concatenate([branch.tangents for branch in self.branches])
        return float(tangents.min()) / self.modulus, float(tangents.max()) / self.modulus

    @property
    def modulus_range(self) -> tuple[float, float]:
        """Lowest and highest modulus of all secants and tangents, over the nominal one, rounded outwards to 0.01."""
        low = min(self.branch_factors[0], self.tangent_factors[0])
        high = max(self.branch_factors[1], self.tangent_factors[1])
        return math.floor(low * 100 + 1e-6) / 100, math.ceil(high * 100 - 1e-6) / 100

    @property
    def robot_file_text(self) -> str:
        """The `[cable]` of a robot file."""
        section, load = AREA.write(self.section, "mm^2"), FORCE.write(self.breaking_load, "kN")
        modulus = f"{self.modulus / 1e9:.4g} GPa"
        return f'[cable]\nyoung_modulus = "{modulus}"\nsection = "{section}"\nbreaking_load = "{load}"'

    @property
    def against_paper(self) -> str:
        """How the range compares with the one that Paty 2021 assumes, and the option of `accuracy` for it."""
        low, high = 1 - PAPER_SPREAD, 1 + PAPER_SPREAD
        kind = "within" if low <= self.modulus_range[0] and self.modulus_range[1] <= high else "wider than"
        own = f"{self.modulus_range[0]:.2f},{self.modulus_range[1]:.2f}"
        return f"{own}, {kind} the paper's {low:g} to {high:g}: --modulus-range of accuracy"
