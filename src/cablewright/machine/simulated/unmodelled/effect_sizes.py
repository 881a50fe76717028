"""Settings of a simulated machine's unmodelled effects: tables of ``[simulation]``.

All are 0, so absent, by default.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, TypeVar

import numpy as np
from pydantic import Field

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import UnknownName
from cablewright.foundation.units import Angle, Length, LinearDensity, NonNegative, Positive, Torque, Vec3
from cablewright.foundation.validation import Description
from cablewright.machine.quantities import Factor, Heavy, Share, Size, Time
from cablewright.robot.mount import Compliance, compliance_matrix

_Value = TypeVar("_Value")


def of_lines(lines: Sequence[str], by_line: Mapping[str, _Value], other: _Value) -> list[_Value]:
    """Return a value for each of the *lines*: that of its name in *by_line*, or *other*.

    Raises `UnknownName` for a name that is no line.
    """
    for name in by_line:
        if name not in lines:
            raise UnknownName("line", name, tuple(lines))
    return [by_line.get(name, other) for name in lines]


class CableStretch(Description):
    """Strains of a cable besides elasticity, at the reference load, see `Unmodelled`.

    ``creep``: after an hour under it; of each line with a uniform relative error of at most ``creep_spread``.
    ``hysteresis``: difference between loading and unloading in a cycle that is larger than the load. ``settling``: for
    good, of a new cable, when it is first under that load. ``stiffening``: share by which it is stiffer at twice the
    load than at it, where it is as the robot file says.
    """

    creep: Annotated[Share, Field(le=0.1)] = 0.0
    creep_spread: Annotated[Share, Field(lt=1.0)] = 0.3
    hysteresis: Annotated[Share, Field(le=0.1)] = 0.0
    settling: Annotated[Share, Field(le=0.1)] = 0.0
    stiffening: Annotated[Share, Field(le=0.9)] = 0.0


class SheaveFriction(Description):
    """Friction of sheaves. ``friction``: share of tension lost over a sheave that turns the cable by a right angle."""

    friction: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.0


class ExitMounts(Description):
    """Mounts of exit points. ``compliance``: m/N, and other ones of some lines ``by_line``."""

    compliance: Compliance = 0.0
    by_line: dict[str, Compliance] = Field(default_factory=dict)

    def matrices(self, lines: Sequence[str]) -> Array:
        """Return the compliance (m, 3, 3), m/N, of each exit by the names of the *lines*; raises `UnknownName`."""
        return np.array([compliance_matrix(each) for each in of_lines(lines, self.by_line, self.compliance)])


class WinchGears(Description):
    """Gears of the winches. ``backlash``: rad at the drum.

    ``bearing_friction``: pull of a line, N, below which the drum's bearings hold it, so that it lies at no flank.
    ``torsion``: rad per N m at the drum, by which they twist. ``ripple``: rad at the drum, the amplitude of a sine of
    its angle, ``ripple_periods`` of which make a turn.
    """

    backlash: Annotated[NonNegative[Angle], Field(le=0.5)] = 0.0
    bearing_friction: Size = 10.0
    torsion: Annotated[float, Field(ge=0.0, le=0.1)] = 0.0
    ripple: Annotated[NonNegative[Angle], Field(le=0.1)] = 0.0
    ripple_periods: Factor = 1.0


class WinchBrakes(Description):
    """Brakes of the simulated winches.

    ``torque``: N m at the drum, holding limit; 0: none. ``by_line``: torques of some lines, by name. Each has a uniform
    relative error of at most ``spread``.
    """

    torque: Annotated[NonNegative[Torque], Field(le=1e6)] = 0.0
    by_line: dict[str, Annotated[NonNegative[Torque], Field(le=1e6)]] = Field(default_factory=dict)
    spread: Annotated[Share, Field(lt=1.0)] = 0.0

    @property
    def give(self) -> bool:
        """Return whether any closed winch brake can slip."""
        return any((self.torque, *self.by_line.values()))


class Wind(Description):
    """A horizontal force on the platform, a first-order Gauss-Markov process.

    ``force``: its root mean square, N; ``correlation``: s, in which its correlation falls to 1/e.
    """

    force: Size = 0.0
    correlation: Time = 2.0


class StickingMaterial(Description):
    """Material that sticks to a clean nozzle: the ``share`` of the released material; ``most``: kg that stay on it.

    None: without limit.
    """

    share: Share = 0.0
    most: Heavy | None = None


class HangingHose(Description):
    """A hose or cable chain that hangs from ``start``, (3,) m, world, to the platform's origin.

    ``length``: m; ``linear_density``: kg/m, with its content.
    """

    start: Vec3
    length: Positive[Length]
    linear_density: Positive[LinearDensity]


class PeoplePushing(Description):
    """A person who pushes the platform horizontally by a ``force``, N, for a ``length``, s, after a ``pause``, s.

    Both times are means.
    """

    force: Size = 0.0
    pause: Time = 600.0
    length: Time = 2.0
