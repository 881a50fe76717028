"""How much a plant has of what no model knows: tables of ``[simulation]``. All of it is 0, so absent, by default."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import numpy as np
from pydantic import Field

from cablewright.arrays import Array
from cablewright.machine.quantities import Share, Size, Time
from cablewright.robot.mount import Compliance, compliance_matrix
from cablewright.units import Angle, NonNegative
from cablewright.validation import Description


class CableStretch(Description):
    """What a cable stretches by besides its elasticity, as strains at the reference load, see `Unmodelled`.

    ``creep``: after an hour under it; of each line off by a uniform share of at most ``creep_spread``.
    ``hysteresis``: between the ways up and down of a cycle that is larger than the load.
    """

    creep: Annotated[Share, Field(le=0.1)] = 0.0
    creep_spread: Annotated[Share, Field(lt=1.0)] = 0.3
    hysteresis: Annotated[Share, Field(le=0.1)] = 0.0


class SheaveFriction(Description):
    """``friction``: share of the tension that is lost over a sheave by which the cable turns by a right angle."""

    friction: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.0


class ExitMounts(Description):
    """``compliance`` of the exits' mounts, m/N, and other ones of some lines ``by_line``."""

    compliance: Compliance = 0.0
    by_line: dict[str, Compliance] = Field(default_factory=dict)

    def matrices(self, lines: Sequence[str]) -> Array:
        """Return the compliance (m, 3, 3), m/N, of each exit by the names of the *lines*."""
        return np.array([compliance_matrix(self.by_line.get(name, self.compliance)) for name in lines])


class WinchGears(Description):
    """``backlash`` of the gears, rad at the drum.

    ``bearing_friction``: pull of a line, N, below which the drum's bearings hold it, so that it lies at no flank.
    """

    backlash: Annotated[NonNegative[Angle], Field(le=0.5)] = 0.0
    bearing_friction: Size = 10.0


class Wind(Description):
    """A horizontal force on the platform, a first-order Gauss-Markov process.

    ``force``: its root mean square, N; ``correlation``: s, in which it forgets all but 1/e.
    """

    force: Size = 0.0
    correlation: Time = 2.0
