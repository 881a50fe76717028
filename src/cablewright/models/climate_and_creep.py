"""How much faster cables creep in a warmer or damper climate: by their pace, the time that creep counts per time.

Time and temperature are exchanged (Williams, Landel and Ferry 1955, doi 10.1021/ja01619a008): time of creep runs faster
by exp(E / R (1 / T0 - 1 / T)), with activation energy E (Arrhenius). For fibres of polyethylene O'Connor and Robbins
(2020, J. Chem. Phys. 153, 144904) have 145 kJ/mol at no load, so twice as fast for 4 K. That humidity h makes it faster
by exp(k (h - h0)) is assumed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cablewright.foundation.arrays import Array
from cablewright.robot.cable import Creep

GAS: Final = 8.31446  # J/(mol K)
ZERO_CELSIUS: Final = 273.15  # K
COLDEST, HOTTEST = -100.0, 200.0  # degrees Celsius, in which there are cables


class Air(NamedTuple):
    """Temperature, degrees Celsius, and relative humidity, 0 to 1; None: not known, taken for that of each law."""

    temperature: float | None
    humidity: float | None


def by_temperature(temperature: ArrayLike, reference: ArrayLike) -> Array:
    """Return the logarithm of the creep pace at a *temperature*, per activation energy, mol/J.

    At the *reference* it is 0. Both in degrees Celsius.
    """
    inverse, at_reference = (1.0 / np.add(each, ZERO_CELSIUS, dtype=np.float64) for each in (temperature, reference))
    return np.asarray((at_reference - inverse) / GAS)


class CreepPace:
    """Factors on the creep rate of m lines, by the climate."""

    def __init__(self, laws: Sequence[Creep | None]) -> None:
        """*laws*: creep laws of the lines' cables; laws that do not depend on the climate, and None, have pace 1."""
        known = [law or Creep() for law in laws]
        self._energies = np.array([law.activation_energy for law in known])
        self._temperatures = np.array([law.reference_temperature for law in known])
        self._exponents = np.array([law.humidity_exponent for law in known])
        self._humidities = np.array([law.reference_humidity for law in known])

    @property
    def varies(self) -> bool:
        """Whether the pace of any line depends on the climate."""
        return bool(self._energies.any() or self._exponents.any())

    def at(self, air: Air) -> Array:
        """Return the factors (m,) on the creep rate in the climate *air*."""
        logarithms = np.zeros(len(self._energies))
        if air.temperature is not None:
            logarithms += self._energies * by_temperature(air.temperature, self._temperatures)
        if air.humidity is not None:
            logarithms += self._exponents * (air.humidity - self._humidities)
        return np.asarray(np.exp(logarithms))
