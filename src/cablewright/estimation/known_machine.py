"""Description of the machine for the estimators of a point platform, and the limits by which they accept readings."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from cablewright.estimation.camera import KnownCamera
from cablewright.estimation.clock_offset import ClockLeadSettings
from cablewright.estimation.height import HeightSettings
from cablewright.estimation.lidar.localisation import WallSettings
from cablewright.estimation.slackness import SlacknessSettings
from cablewright.estimation.tilt import TiltSettings
from cablewright.foundation.errors import InputError
from cablewright.models.statics import Model


@dataclass(frozen=True, eq=False, kw_only=True)
class KnownMachine:
    """The machine as described, and limits of accepted readings.

    ``model``: the robot with the platform's mass. ``lidars``: sources of ``walls.lidars``, in their order.
    ``counts_per_radian``: encoder counts for a radian of a winch drum. ``max_drum_speed``: rad/s of a winch drum.
    ``valve_depth``: m, from B down to the distance sensor. ``max_rejections``: scans in a row whose lidar position is
    rejected, after which it is accepted. ``position_timeout``: s without an accepted lidar position until the estimate
    is invalid. ``timeouts``: time without a reading after which a source is at fault, s, by source. ``clock``: clock of
    the platform; None: it is the machine's. ``camera``: camera in the room, if there is one.
    """

    model: Model
    walls: WallSettings
    lidars: tuple[str, ...]
    slackness: SlacknessSettings
    counts_per_radian: float
    height: HeightSettings | None = None
    tilt: TiltSettings = field(default_factory=TiltSettings)
    max_drum_speed: float = math.inf
    valve_depth: float | None = None
    max_rejections: int = 4
    position_timeout: float = 30.0
    timeouts: Mapping[str, float] = field(default_factory=dict)
    clock: ClockLeadSettings | None = None
    camera: KnownCamera | None = None

    def __post_init__(self) -> None:
        """Reject lidars without a model, platforms with a rotation and counts that are not positive."""
        if len(self.lidars) != len(self.walls.lidars):
            raise InputError(
                f"lidars: {len(self.lidars)} sources of scans for {len(self.walls.lidars)} lidars; give "
                f"one source for each lidar"
            )
        if self.model.n != 3:
            raise InputError(f"robot {self.model.robot.name!r}: only a point platform's state can be observed")
        if not self.counts_per_radian > 0.0:
            raise InputError(f"counts_per_radian = {self.counts_per_radian:g}: over 0 is expected")
