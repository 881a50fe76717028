"""The cable: its stiffness, weight and breaking load."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from types import MappingProxyType
from typing import Annotated, Final, Self

from annotated_types import Ge, Gt, Le
from pydantic import Field, Strict, model_validator

from cablewright.foundation.errors import suggestion
from cablewright.foundation.units import (
    Area,
    Duration,
    Force,
    Length,
    LinearDensity,
    NonNegative,
    Positive,
    Pressure,
    ThermalExpansion,
)
from cablewright.foundation.validation import Description, refusal

CONSTRUCTIONS: Final[Mapping[str, float]] = MappingProxyType({
    "6x7-FC": 0.369, "6x7-IWRC": 0.432, "6x7-WSC": 0.432, "6x19-FC": 0.384, "6x19-IWRC": 0.449, "6x36-FC": 0.393,
    "6x36-IWRC": 0.460, "6x19M-FC": 0.357, "6x19M-WSC": 0.418, "6x37M-FC": 0.357, "6x37M-WSC": 0.418,
})  # fmt: skip
"""Metallic section of steel wire ropes over the square of their diameter, by construction: EN 12385-4, factor C."""

FIBRE: Final = 970.0
"""Density of polyethylene fibre, kg/m^3, the lightest of cables: of an assumed diameter."""

MAX_RETARDATIONS: Final = 4
"""Maximum number of Voigt elements of a cable's creep."""

_Compliance = Annotated[float, Strict(), Ge(0.0), Le(1e-2)]
_Energy = Annotated[float, Strict(), Ge(0.0), Le(1e6)]
_Celsius = Annotated[float, Strict(), Ge(-100.0), Le(200.0)]
_Humidity = Annotated[float, Strict(), Ge(0.0), Le(1.0)]
_Exponent = Annotated[float, Strict(), Ge(-20.0), Le(20.0)]
_SECTIONS = ("section", "fill_factor", "construction")


class Creep(Description):
    """Creep of a cable by the law of `models.creep`: strains per tension after an hour under it, 1/N.

    ``compliances``: compliances of the Voigt elements; ``retardations``: retardation times of these elements, s,
    rising. ``logarithmic``: that of logarithmic creep. This is at ``reference_temperature``, degrees Celsius, and
    ``reference_humidity``, relative; ``activation_energy``, J/mol, and ``humidity_exponent`` determine the rate of
    creep in another climate, see `models.climate_and_creep`; of 0 it does not depend on that.
    """

    retardations: Annotated[tuple[Positive[Duration], ...], Field(max_length=MAX_RETARDATIONS)] = ()
    compliances: Annotated[tuple[_Compliance, ...], Field(max_length=MAX_RETARDATIONS)] = ()
    logarithmic: _Compliance = 0.0
    activation_energy: _Energy = 0.0
    reference_temperature: _Celsius = 20.0
    humidity_exponent: _Exponent = 0.0
    reference_humidity: _Humidity = 0.5

    @model_validator(mode="after")
    def _pairs(self) -> Self:
        if len(self.compliances) != len(self.retardations):
            raise refusal("compliances", f"must be {len(self.retardations)}: one for each of the retardations")
        if any(b <= a for a, b in pairwise(self.retardations)):
            raise refusal("retardations", "must rise")
        return self


class Cable(Description):
    """A cable's properties per metre.

    Its axial stiffness EA is given either as ``axial_stiffness``, because the section of a cable is often a matter of
    definition while its EA is measured, or as ``young_modulus`` and the section that it refers to: ``section``; or
    ``diameter`` with ``fill_factor``, the share of its circle that is filled, or with ``construction``, one of
    `CONSTRUCTIONS`. ``thermal_expansion`` (1/K): strain per degree, negative for aramid and Dyneema; None: unknown.
    ``creep``: None: not known. All estimators count it but those of real drives, and the simulated machine creeps so.
    """

    young_modulus: Positive[Pressure] | None = None
    section: Positive[Area] | None = None
    fill_factor: Annotated[float, Strict(), Gt(0), Le(1)] | None = None
    construction: Annotated[str, Field(json_schema_extra={"enum": [*CONSTRUCTIONS]})] | None = None
    axial_stiffness: Positive[Force] | None = None
    linear_density: NonNegative[LinearDensity]
    breaking_load: Positive[Force]
    diameter: Positive[Length] | None = None
    thermal_expansion: ThermalExpansion | None = None
    creep: Creep | None = None

    @model_validator(mode="after")
    def _one_stiffness(self) -> Self:
        given = [key for key in _SECTIONS if getattr(self, key) is not None]
        if self.construction is not None and self.construction not in CONSTRUCTIONS:
            raise refusal("construction", f"unknown; {suggestion(self.construction, CONSTRUCTIONS)}")
        if self.axial_stiffness is not None:
            if self.young_modulus is not None or given:
                raise refusal("axial_stiffness", "give either this or young_modulus and section, not both")
            return self
        ways = "section, or diameter with fill_factor or construction"
        if self.young_modulus is None:
            raise refusal("young_modulus", f"is missing: give young_modulus and {ways}; or axial_stiffness")
        if len(given) > 1:
            raise refusal(given[1], f"give either this or {given[0]}, not both")
        if not given:
            key = "section" if self.diameter is None else "fill_factor"
            raise refusal(key, f"is missing: give young_modulus and {ways}; or axial_stiffness")
        if given[0] != "section" and self.diameter is None:
            raise refusal("diameter", f"is missing: {given[0]} needs it")
        return self

    @property
    def thickness(self) -> float:
        """The diameter, m; where it is not given, that of a full round of `FIBRE` with the cable's mass: assumed."""
        return math.sqrt(4.0 * self.linear_density / (math.pi * FIBRE)) if self.diameter is None else self.diameter

    @property
    def load_section(self) -> float | None:
        """The section that ``young_modulus`` refers to, m^2; None where ``axial_stiffness`` is given."""
        if self.section is not None or self.diameter is None:
            return self.section
        if self.construction is not None:
            return CONSTRUCTIONS[self.construction] * self.diameter**2
        return None if self.fill_factor is None else 0.25 * math.pi * self.fill_factor * self.diameter**2

    @property
    def stiffness(self) -> float:
        """Axial stiffness EA, N."""
        section = self.load_section
        if self.young_modulus is not None and section is not None:
            return self.young_modulus * section
        assert self.axial_stiffness is not None  # checked by _one_stiffness
        return self.axial_stiffness
