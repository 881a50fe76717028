"""Units: exact conversion, closed to everything that is not one finite number with a unit of the right dimension."""

import contextlib
import math
import re
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from cablewright.foundation import units
from cablewright.foundation.units import (
    Angle,
    Area,
    Force,
    Length,
    LinearDensity,
    NonNegative,
    Positive,
    Pressure,
    Speed,
    Torque,
)

DIMENSIONS = [value for value in vars(units).values() if isinstance(value, units.Dimension)]
SPELLINGS = [(dimension, unit) for dimension in DIMENSIONS for unit in dimension.units]


def read(kind: object, value: object) -> float:
    return TypeAdapter(kind).validate_python(value)


@pytest.mark.parametrize(
    ("kind", "text", "si"),
    [
        (Length, "50 mm", 0.05),
        (Length, "104mm", 0.104),
        (Length, "  -3.5  cm ", -0.035),
        (Length, "+.5 m", 0.5),
        (Length, "1.e3 um", 1e-3),
        (Pressure, "102.2 GPa", 102.2e9),
        (Area, "12.566 mm^2", 12.566e-6),
        (Angle, "45 deg", math.pi / 4),
        (Angle, "-180 deg", -math.pi),
        (LinearDensity, "30 g/m", 0.03),
        (Force, "6.85 N", 6.85),
        (Force, "10.29 kN", 10290.0),
        (Speed, "0.1 m/s", 0.1),
        (Speed, "6000 mm/min", 0.1),
        (Speed, "3 m/min", 0.05),
        (Torque, "600 N m", 600.0),
        (units.Inertia, "12 kg m^2", 12.0),
        (units.Inertia, "12 kg mm^2", 12e-6),
        (units.Inertia, "250 kg cm^2", 0.025),
        (units.Inertia, "250 g mm^2", 250e-9),
        (units.Mass, "200 kg", 200.0),
        (units.Acceleration, "2 m/s^2", 2.0),
        (units.Density, "1.5 g/cm^3", 1500.0),
        (units.Duration, "2 h", 7200.0),
    ],
)
def test_a_text_with_a_unit_is_exactly_the_si_number(kind: object, text: str, si: float) -> None:
    assert read(kind, text) == si


def test_three_components_are_read_one_by_one() -> None:
    vectors = [
        (units.Vec3, ("1 m", 2, "3 mm"), (1.0, 2.0, 3e-3)),
        (units.Force3, ("1 kN", 2, "3 mN"), (1e3, 2.0, 3e-3)),
        (units.Torque3, ("1 kN m", 2, "3 mN m"), (1e3, 2.0, 3e-3)),
        (units.Inertia3, ("1 kg m^2", 2, "3 kg mm^2"), (1.0, 2.0, 3e-6)),
    ]
    for kind, texts, si in vectors:
        assert TypeAdapter(kind).validate_python(texts) == si
        for wrong in (texts[:2], (*texts, 0), ("1 s", 0, 0), 1.0):
            with pytest.raises(ValidationError):
                TypeAdapter(kind).validate_python(wrong)


@pytest.mark.parametrize("value", [0.05, np.float64(0.05), Fraction(1, 20)])
def test_a_number_is_si(value: object) -> None:
    assert read(Length, value) == 0.05
    assert type(read(Length, value)) is float


@pytest.mark.parametrize(
    "value",
    [
        *("50 kg", "50 kN", "50", "mm", "", " ", "50 mm mm", "50 MM", "50 mm\n5", "1,5 m", "1_000 m", "0x10 m", "٣ m"),
        *("9**9**9 mm", "__import__('os') m", "1+1 m", "nan m", "inf m", "1e999 m", "1e99999999999999999999 m"),
        *("1" * 100 + " m", True, None, [1], {"m": 1}, b"1 m", 1j, math.nan, math.inf, -math.inf, 10**400),
    ],
)
def test_anything_else_is_rejected_with_the_allowed_units(value: object) -> None:
    with pytest.raises(ValidationError, match=r"must be a finite length.*unit one of m, mm, cm, um, km"):
        read(Length, value)


def test_limits_see_the_si_value() -> None:
    assert read(Positive[Length], "1 um") == 1e-6
    assert read(NonNegative[Length], "0 mm") == 0.0
    for kind, value in [(Positive[Length], "0 mm"), (Positive[Length], -1), (NonNegative[Length], "-1 um")]:
        with pytest.raises(ValidationError, match="greater"):
            read(kind, value)


def test_every_dimension_starts_with_its_si_unit_and_no_unit_means_two_things() -> None:
    assert all(dimension.units[dimension.si] == 1 for dimension in DIMENSIONS)
    names = [unit for _, unit in SPELLINGS]
    assert len(names) == len(set(names))


@given(st.sampled_from(SPELLINGS), st.floats(-units.LARGEST, units.LARGEST))
def test_writing_and_reading_again_gives_the_very_same_number(spelling: tuple, value: float) -> None:
    dimension, unit = spelling
    assert dimension.read(dimension.write(value, unit)) == value


@pytest.mark.parametrize("value", [1.001e30, -1e300, "1e309 mm", "1e28 km", 10**31])
def test_no_quantity_is_so_large_that_products_overflow(value: object) -> None:
    with pytest.raises(ValueError, match=re.escape("must be at most 1e+30 m")):
        units.LENGTH.read(value)


def test_writing_keeps_the_unit_and_is_short() -> None:
    assert units.respell(0.0512, "50 mm") == "51.2 mm"
    assert units.respell(math.radians(30), "45deg") == "30 deg"
    assert units.respell(1.1e11, "102.2 GPa") == "110 GPa"
    assert units.respell(1e300, "1 mm") == "1e+300 m"
    with pytest.raises(ValueError, match="no known unit"):
        units.respell(1.0, "5 parsecs")


@given(st.text(max_size=30) | st.from_regex(r"[0-9.eE+*-]{1,12} ?(mm|m|kN|m m)?", fullmatch=True))
def test_no_text_does_worse_than_be_rejected(text: str) -> None:
    with contextlib.suppress(ValidationError):
        assert math.isfinite(read(Length, text))


def test_json_schema_allows_number_or_text() -> None:
    number, text = TypeAdapter(Positive[Length]).json_schema()["anyOf"]
    assert number == {"type": "number", "exclusiveMinimum": 0}
    assert text["type"] == "string"
    assert "(m|mm|cm|um|km)" in text["pattern"]
    assert TypeAdapter(NonNegative[Force]).json_schema()["anyOf"][0] == {"type": "number", "minimum": 0}
