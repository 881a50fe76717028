"""Standard deviations of the parameters in the description of a machine with a rigid platform."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from cablewright.foundation.units import Length
from cablewright.foundation.validation import Description
from cablewright.machine.quantities import Share

_Small = Annotated[Length, Field(gt=0.0, le=1.0)]


class MachineAccuracy(Description):
    """Standard deviations that the estimator of a rigid platform uses.

    ``home_length``: m, of each line's length where the machine was homed. ``drum_radius``: share of each winch drum's.
    ``exit_point``: m, of each coordinate. ``mass``: share of the platform's; ``centre``: m, of each coordinate of its
    centre of mass. ``model``: N, of tensions that a perfect description would predict.
    ``creep``: strain of the cables after an hour under the mean tension at home, besides what the robot file describes;
    None: 30 % of that, or 2e-4 where nothing is described. ``friction``: share of a line's tension by which its load
    cell shows less while cable is paid out, and more while it is wound. ``hysteresis``: strain between the ways up and
    down of a large cycle of loads; None: 2e-4. ``exit_compliance``: m/N, of the mounts of exit points besides the
    described compliance; None: 30 % of that, or 1e-6. What neither this nor the robot file states of the three is
    more likely larger.
    """

    home_length: _Small = 2e-3
    drum_radius: Annotated[Share, Field(gt=0.0)] = 3e-3
    exit_point: _Small = 1e-3
    mass: Annotated[Share, Field(gt=0.0)] = 5e-3
    centre: _Small = 2e-3
    model: Annotated[float, Field(gt=0.0, le=1e6)] = 0.5
    creep: Annotated[Share, Field(gt=0.0, le=0.1)] | None = None
    hysteresis: Annotated[Share, Field(gt=0.0, le=0.1)] | None = None
    friction: Annotated[Share, Field(gt=0.0)] = 0.01
    exit_compliance: Annotated[float, Field(gt=0.0, le=1e-2)] | None = None
