"""Units of input: a number is SI, a text such as ``"50 mm"`` is converted when it is read; all values inside are SI.

Texts are not evaluated: a text is one number and one unit of the field's dimension.
"""

from __future__ import annotations

import decimal
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from numbers import Real
from types import MappingProxyType
from typing import Annotated, Any, Final, TypeVar

from annotated_types import Ge, Gt
from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

# A decimal number in a text; the pattern takes linear time.
NUMBER: Final = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_TEXT = re.compile(rf"({NUMBER}) *([^\s0-9.+-].*)", re.ASCII)
_LONGEST_TEXT = 80
LARGEST = 1e30  # of a quantity, in its SI unit: no machine is near, and the product of a few is still a number

# Decimal, so that "104 mm" is exactly the float 0.104; no traps, so that a huge exponent becomes inf and is rejected.
_EXACT = decimal.Context(prec=60, traps=[])


@dataclass(frozen=True, eq=False)
class Dimension:
    """A physical dimension: as the annotation of a float field it reads SI numbers and texts with a unit.

    ``units``: each allowed unit and its size in the SI unit, which is the first one.
    """

    name: str
    units: Mapping[str, Decimal]

    @property
    def si(self) -> str:
        """The SI unit of this dimension."""
        return next(iter(self.units))

    @property
    def requirement(self) -> str:
        """The accepted values of a field of this dimension, as the end of a sentence."""
        forms = f"a number ({self.si}) or a text such as '2 {self.si}'"
        return f"must be a finite {self.name}: {forms}, unit one of {', '.join(self.units)}"

    def read(self, value: object) -> float:
        """Return ``value`` in SI. Raises `ValueError` unless it is a finite number, or a text of number and unit.

        Above `LARGEST` it is rejected too.
        """
        if isinstance(value, str):
            return self._checked(self._parse(value))
        if isinstance(value, bool) or not isinstance(value, Real):
            raise self._refusal()
        try:
            return self._checked(float(value))
        except OverflowError:  # an integer of 400 digits
            raise self._refusal() from None

    def write(self, value: float, unit: str) -> str:
        """Return the shortest text in ``unit`` that `read` converts back to exactly ``value`` (SI)."""
        exact = _EXACT.divide(Decimal(repr(value)), self.units[unit])
        for digits in range(1, 40):
            text = f"{decimal.Context(prec=digits).plus(exact).normalize():f} {unit}"
            if len(text) <= _LONGEST_TEXT and self._parse(text) == value:
                return text
        return f"{value!r} {self.si}"

    def _parse(self, text: str) -> float:
        match = _TEXT.fullmatch(text.strip()) if len(text) <= _LONGEST_TEXT else None
        if match is None or match[2] not in self.units:
            raise self._refusal()
        return float(_EXACT.multiply(_EXACT.create_decimal(match[1]), self.units[match[2]]))

    def _checked(self, value: float) -> float:
        if not math.isfinite(value):
            raise self._refusal()
        if abs(value) > LARGEST:
            raise self._refusal(f"must be at most {LARGEST:g} {self.si}")
        return value

    def _refusal(self, requirement: str = "") -> PydanticCustomError:
        return PydanticCustomError("quantity", "{requirement}", {"requirement": requirement or self.requirement})

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Read first, so that limits such as ``Gt(0)`` apply to an SI float."""
        return core_schema.no_info_before_validator_function(self.read, handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """A number or a text with one of the units."""
        number = dict(handler(schema))
        for ours, theirs in (
            ("gt", "exclusiveMinimum"),
            ("ge", "minimum"),
            ("lt", "exclusiveMaximum"),
            ("le", "maximum"),
        ):
            if ours in number:
                number[theirs] = number.pop(ours)
        units = "|".join(re.escape(unit).replace("\\ ", " ") for unit in self.units)  # ECMA-262 has no such escape
        text = {"type": "string", "pattern": f"^ *{NUMBER} *({units}) *$", "examples": [f"2 {self.si}"]}
        return {"anyOf": [number, text], "description": f"{self.name}; a plain number is in {self.si}"}


_DIMENSIONS: list[Dimension] = []


def _dimension(name: str, units: Mapping[str, str | Decimal]) -> Dimension:
    """Register a dimension from units and their sizes, the SI unit (size 1) first."""
    _DIMENSIONS.append(Dimension(name, MappingProxyType({unit: Decimal(size) for unit, size in units.items()})))
    return _DIMENSIONS[-1]


_DEGREE, _GON, _ARCSEC = (_EXACT.divide(Decimal(math.pi), Decimal(half_turn)) for half_turn in (180, 200, 648_000))
_PER_MINUTE = _EXACT.divide(Decimal(1), Decimal(60))

LENGTH = _dimension("length", {"m": "1", "mm": "1e-3", "cm": "1e-2", "um": "1e-6", "km": "1e3"})
AREA = _dimension("area", {"m^2": "1", "mm^2": "1e-6", "cm^2": "1e-4"})
FORCE = _dimension("force", {"N": "1", "kN": "1e3", "MN": "1e6", "mN": "1e-3"})
PRESSURE = _dimension("pressure", {"Pa": "1", "kPa": "1e3", "MPa": "1e6", "GPa": "1e9"})
MASS = _dimension("mass", {"kg": "1", "g": "1e-3", "t": "1e3"})
LINEAR_DENSITY = _dimension("linear density", {"kg/m": "1", "g/m": "1e-3"})
DENSITY = _dimension("density", {"kg/m^3": "1", "g/cm^3": "1e3"})
ANGLE = _dimension("angle", {"rad": "1", "mrad": "1e-3", "deg": _DEGREE, "gon": _GON, "arcsec": _ARCSEC})
SPEED = _dimension(
    "speed",
    {"m/s": "1", "cm/s": "1e-2", "mm/s": "1e-3", "m/min": _PER_MINUTE, "mm/min": _EXACT.scaleb(_PER_MINUTE, -3)},
)
VOLUME_FLOW = _dimension(
    "volume flow",
    {"m^3/s": "1", "mm^3/s": "1e-9", "cm^3/s": "1e-6", "l/s": "1e-3", "l/min": _EXACT.scaleb(_PER_MINUTE, -3)},
)
MASS_FLOW = _dimension(
    "mass flow",
    {"kg/s": "1", "g/s": "1e-3", "kg/min": _PER_MINUTE, "g/min": _EXACT.scaleb(_PER_MINUTE, -3)},
)
ACCELERATION = _dimension("acceleration", {"m/s^2": "1", "mm/s^2": "1e-3"})
JERK = _dimension("jerk", {"m/s^3": "1", "mm/s^3": "1e-3"})
TORQUE = _dimension("torque", {"N m": "1", "kN m": "1e3", "mN m": "1e-3"})
INERTIA = _dimension("inertia", {"kg m^2": "1", "kg cm^2": "1e-4", "kg mm^2": "1e-6", "g mm^2": "1e-9"})
STIFFNESS = _dimension("stiffness", {"N/m": "1", "N/mm": "1e3", "kN/m": "1e3"})
DURATION = _dimension("duration", {"s": "1", "ms": "1e-3", "min": "60", "h": "3600"})
TEMPERATURE_DIFFERENCE = _dimension("temperature difference", {"K": "1"})
RELATIVE_HUMIDITY = _dimension("relative humidity", {"share": "1", "%": "1e-2"})
# not "1/K": a text is one number and one unit, and a unit does not start with a digit
THERMAL_EXPANSION = _dimension("thermal expansion", {"/K": "1", "ppm/K": "1e-6"})

Length = Annotated[float, LENGTH]
Area = Annotated[float, AREA]
Force = Annotated[float, FORCE]
Pressure = Annotated[float, PRESSURE]
Mass = Annotated[float, MASS]
LinearDensity = Annotated[float, LINEAR_DENSITY]
Density = Annotated[float, DENSITY]
Angle = Annotated[float, ANGLE]
Speed = Annotated[float, SPEED]
VolumeFlow = Annotated[float, VOLUME_FLOW]
MassFlow = Annotated[float, MASS_FLOW]
Acceleration = Annotated[float, ACCELERATION]
Jerk = Annotated[float, JERK]
Torque = Annotated[float, TORQUE]
Inertia = Annotated[float, INERTIA]
Duration = Annotated[float, DURATION]
Stiffness = Annotated[float, STIFFNESS]
ThermalExpansion = Annotated[float, THERMAL_EXPANSION]

Vec3 = tuple[Length, Length, Length]
Force3 = tuple[Force, Force, Force]
Torque3 = tuple[Torque, Torque, Torque]
Angle3 = tuple[Angle, Angle, Angle]
Inertia3 = tuple[Inertia, Inertia, Inertia]

_Quantity = TypeVar("_Quantity")
Positive = Annotated[_Quantity, Gt(0)]
NonNegative = Annotated[_Quantity, Ge(0)]

_SIZES: dict[str, float] = {unit: float(size) for each in _DIMENSIONS for unit, size in each.units.items()}
_SIZES |= {"kJ/mol": 1e3, "% per K": 1e-2, "mm^2/s^2": 1e-6, "mm^3": 1e-9}


def unit_size(unit: str) -> float:
    """Return the size of a *unit* in the SI unit of its dimension; 0.01 for a per cent. Raises `KeyError`."""
    return _SIZES[unit]


def is_unit(text: str) -> bool:
    """Whether *text* is a unit of some dimension."""
    return text in _SIZES


def respell(value: float, like: str) -> str:
    """Return ``value`` (SI) as a text in the same unit as the text ``like``, which `Dimension.read` accepts."""
    match = _TEXT.fullmatch(like.strip())
    for dimension in _DIMENSIONS:
        if match is not None and match[2] in dimension.units:
            return dimension.write(value, match[2])
    raise ValueError(f"{like!r} has no known unit")


def three_digits(value: float) -> float:
    """Return *value* rounded to three significant digits."""
    return float(f"{value:.3g}")


def spell_length(value: float) -> str:
    """Return a length (m) as text for a sentence: three digits, in mm below a metre."""
    return f"{value * 1e3:.3g} mm" if abs(value) < 1.0 else f"{value:.3g} m"
