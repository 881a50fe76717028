"""Lateral vibration of a line: tension and density from its natural frequency, and EA from its sag.

Across the plane in which it sags a line vibrates as a taut string, however much it sags. In that plane its first
symmetric mode is faster, by the parameter of Irvine and Caughey (1974), which is the only trace of EA in a frequency.
Ends count as at rest; the bending stiffness of the cable is left out.
"""

from __future__ import annotations

import math
from typing import Final, TypeVar

from scipy.optimize import brentq

from cablewright.foundation.arrays import Array

KNOWN: Final = 0.2  # standard deviation of a modulus, as a share, from which on it counts as observed
_FLATTEST: Final = 1e-9  # sag parameter of a string
_DEEPEST: Final = 40.0  # about 4 pi^2, at which the symmetric mode crosses the next one


Value = TypeVar("Value", float, Array)


def string_tension(frequency: Value, span: Value, density: Value, mode: int = 1) -> Value:
    """Return the tension, N, of a string of *span*, m, and *density*, kg/m, by the *frequency*, Hz, of a *mode*.

    Of numbers, or of arrays of one shape.
    """
    return 4.0 * density * (span * frequency / mode) ** 2


def string_density(frequency: Value, span: Value, tension: Value, mode: int = 1) -> Value:
    """Return the density, kg/m, of a string of *span*, m, under a *tension*, N, by the *frequency*, Hz, of a *mode*."""
    return 0.25 * tension / (span * frequency / mode) ** 2


def string_frequency(tension: Value, span: Value, density: Value, mode: int = 1) -> Value:
    """Return the frequency, Hz, of a *mode* of a string of *span*, m, and *density*, kg/m, under a *tension*, N."""
    found: Value = 0.5 * mode / span * (tension / density) ** 0.5
    return found


def sag_parameter(weight: float, level: float, tension: float, stiffness: float) -> float:
    """Return the parameter of Irvine and Caughey (their lambda squared) of a line between two points.

    *weight*: N/m; *level*: m, horizontal part of its span; *stiffness*: N, EA.
    """
    return (weight * level / tension) ** 2 * stiffness / tension


def sag_stiffening(parameter: float) -> tuple[float, float]:
    """Return the first in-plane frequency over that of a string, and its derivative by the sag *parameter*.

    The root of tan x = x - 4 x^3 / parameter above pi / 2 (Irvine, Caughey 1974, Eq. 2.20).
    """
    if parameter <= _FLATTEST:
        return 1.0, 0.0
    x = float(brentq(lambda x: math.sin(x) - (x - 4.0 * x**3 / parameter) * math.cos(x), 0.5 * math.pi, 1.5 * math.pi))
    steep = (x - 4.0 * x**3 / parameter) ** 2
    share = 4.0 * x * x / parameter
    return 2.0 * x / math.pi, share / (steep + 3.0 * share)


def parameter_of(ratio: float) -> float | None:
    """Return the sag parameter from the frequency *ratio* of `sag_stiffening`; None where another mode is the first."""
    x = 0.5 * math.pi * ratio
    if not 1.0 < ratio <= 2.0:  # at 2 it crosses the next mode
        return None
    return 4.0 * x**3 / (x - math.tan(x))


def observable_below(weight: float, level: float, stiffness: float, sigma: float) -> float:
    """Return the tension, N, below which two measured frequencies determine EA to `KNOWN`; else 0.

    *sigma*: their relative standard deviation. They are the first in the plane of the sag and the first across it.
    """
    needed = math.sqrt(2.0) * sigma / KNOWN
    if weight * level <= 0.0 or sag_stiffening(_DEEPEST)[1] < needed:
        return 0.0
    found = brentq(lambda at: sag_stiffening(math.exp(at))[1] - needed, math.log(1e-6 * needed), math.log(_DEEPEST))
    return math.cbrt((weight * level) ** 2 * stiffness / math.exp(found))
