"""The bracket that holds a sheave: sizes of its baseplate, uprights, bearing block, lever and axle.

Its frame has its origin at the joint (the line's exit point), x horizontal in the direction that the mounting faces,
z up. The baseplate is a vertical plate with four bolts at -x. Two uprights, vertical plates on it, carry a block above
the joint between them. Two bearings in the block's vertical bore hold the spindle; below the block it carries the
joint's pin, on which the two cheeks of the lever turn, with the sheave between them.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Final, Self

from pydantic import Field, model_validator

from cablewright.foundation.toml_input import read_table, require_schema
from cablewright.foundation.units import Length, Positive, Pressure
from cablewright.foundation.validation import Description, refusal, validated

_LARGEST: Final = 10.0  # m
_THINNEST: Final = 1e-4  # m

_Size = Annotated[Length, Field(ge=_THINNEST, le=_LARGEST)]


class Material(Description):
    """Isotropic material, linear up to its ``yield_strength``."""

    name: Annotated[str, Field(max_length=60)] = ""
    young_modulus: Positive[Pressure]
    poisson_ratio: Annotated[float, Field(strict=True, ge=0.0, le=0.45)]
    yield_strength: Positive[Pressure]


class Baseplate(Description):
    """The vertical plate: ``width`` along y, ``height`` along z, ``bolts``: their spacing along both.

    Each bolt clamps a square of side ``clamped`` around it: the washer's footprint.
    """

    width: _Size
    height: _Size
    thickness: _Size
    bolts: tuple[_Size, _Size]
    clamped: _Size

    @model_validator(mode="after")
    def _holds_its_bolts(self) -> Self:
        for spacing, side, name in zip(self.bolts, (self.width, self.height), ("width", "height"), strict=True):
            if spacing + self.clamped >= side:
                raise refusal("bolts", f"with clamped must stay within the plate's {name}, {side:g} m")
            if spacing <= self.clamped:
                raise refusal("bolts", f"must be further apart than clamped, {self.clamped:g} m")
        return self


class Uprights(Description):
    """The two plates on the baseplate, ``gap`` apart: ``height`` along z, ``thickness`` along y."""

    thickness: _Size
    height: _Size
    gap: _Size


class Bearing(Description):
    """The ``bore`` (diameter) through the block, and the ``width`` of each of the two bearings at its ends."""

    bore: _Size
    width: _Size


class Lever(Description):
    """The two cheeks, ``gap`` apart: plates of ``width`` and ``thickness``, with the bores of ``pin`` and ``axle``."""

    thickness: _Size
    width: _Size
    gap: _Size
    pin: _Size
    axle: _Size

    @model_validator(mode="after")
    def _holds_its_bores(self) -> Self:
        for key in ("pin", "axle"):
            if 1.5 * getattr(self, key) > self.width:
                raise refusal(key, f"must be at most two thirds of the cheek's width, {self.width:g} m")
        return self


class Axle(Description):
    """The sheave's axle, a round bar in the cheeks; ``sheave_width``: width of the sheave's hub on the axle, m."""

    material: Material
    sheave_width: _Size


class Bracket(Description):
    """A bracket without the values of the line's sheave: length, weight and mass centre of the lever, radius.

    ``standoff``: distance from the baseplate's front to the spindle's axis. ``rise``: height of the middle of
    baseplate, uprights and block above the joint.
    """

    standoff: _Size
    rise: Annotated[Length, Field(ge=-_LARGEST, le=_LARGEST)]
    material: Material
    baseplate: Baseplate
    uprights: Uprights
    bearing: Bearing
    lever: Lever
    axle: Axle

    @model_validator(mode="after")
    def _parts_fit(self) -> Self:
        gap, uprights, baseplate = self.uprights.gap, self.uprights, self.baseplate
        if 1.5 * self.bearing.bore > gap:
            raise refusal("bore", f"must be at most two thirds of the uprights' gap, {gap:g} m", within=("bearing",))
        if 2.0 * self.bearing.width >= uprights.height:
            why = f"must be under half the uprights' height, {uprights.height:g} m"
            raise refusal("width", why, within=("bearing",))
        min_standoff = 0.5 * gap + 2.0 * uprights.thickness
        if self.standoff < min_standoff:
            raise refusal("standoff", f"must leave room for the block: at least {min_standoff:g} m")
        if gap + 2.0 * uprights.thickness >= baseplate.width:
            raise refusal("gap", "with both uprights must be less than the baseplate's width", within=("uprights",))
        if uprights.height >= baseplate.height:
            raise refusal("height", "must be less than the baseplate's height", within=("uprights",))
        if self.axle.sheave_width > self.lever.gap:
            raise refusal("sheave_width", f"must be at most the lever's gap, {self.lever.gap:g} m", within=("axle",))
        return self


def load_bracket(path: str | Path) -> Bracket:
    """Read a bracket from a TOML file. Raises `InputError` that names file, key, value and the allowed range."""
    table, _ = read_table(path)
    require_schema(table, path)
    del table["schema"]  # a bracket within a robot file has none
    return validated(Bracket, table, path)
