"""The cable: its stiffness, weight and breaking load."""

from __future__ import annotations

from typing import Self

from pydantic import model_validator

from cablewright.units import Area, Force, Length, LinearDensity, NonNegative, Positive, Pressure, ThermalExpansion
from cablewright.validation import Description, refusal


class Cable(Description):
    """A cable's properties per metre.

    Its axial stiffness EA is given either as ``young_modulus`` and ``section`` or as ``axial_stiffness``, because the
    section of a rope is often a matter of definition while its EA is measured. ``thermal_expansion`` (1/K): strain per
    degree, negative for aramid and Dyneema; None: unknown.
    """

    young_modulus: Positive[Pressure] | None = None
    section: Positive[Area] | None = None
    axial_stiffness: Positive[Force] | None = None
    linear_density: NonNegative[LinearDensity]
    breaking_load: Positive[Force]
    diameter: Positive[Length] | None = None
    thermal_expansion: ThermalExpansion | None = None

    @model_validator(mode="after")
    def _one_stiffness(self) -> Self:
        if self.axial_stiffness is not None:
            if self.young_modulus is not None or self.section is not None:
                raise refusal("axial_stiffness", "give either this or young_modulus and section, not both")
        elif self.young_modulus is None or self.section is None:
            missing = "young_modulus" if self.young_modulus is None else "section"
            raise refusal(missing, "is missing: give young_modulus and section, or axial_stiffness")
        return self

    @property
    def stiffness(self) -> float:
        """EA, N."""
        if self.young_modulus is not None and self.section is not None:
            return self.young_modulus * self.section
        assert self.axial_stiffness is not None  # checked by _one_stiffness
        return self.axial_stiffness
