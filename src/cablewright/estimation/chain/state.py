"""What an observer is told of the machine, and what it keeps from step to step."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.errors import InputError
from cablewright.estimation.chain.drum_radius import RadiusSettings, RadiusState
from cablewright.estimation.fault_monitor import Watch
from cablewright.estimation.height import HeightEstimate, HeightSettings
from cablewright.estimation.lidar.localisation import KeptTurn, LidarTurn, WallPose, WallSettings, WallState
from cablewright.estimation.lidar.room import Laser
from cablewright.estimation.reading_checks import Intake
from cablewright.estimation.slackness import SlacknessSettings, SlacknessState, Taut
from cablewright.estimation.tilt import TiltSettings, TiltState
from cablewright.estimation.time_buffer import Trail
from cablewright.models.statics import Model
from cablewright.signals import DistanceReading, Scan
from cablewright.solvers.continuation import Tracker

__all__ = ["Looked", "ObserverSettings", "ObserverState"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ObserverSettings:
    """What is believed of the machine, and how its sensors are judged.

    ``model``: the robot as described, with the drum's mass. ``lidars``: sources of ``walls.lidars``, in their order.
    ``counts``: of an encoder for a radian of a winch drum. ``fastest``: rad/s of a winch drum. ``valve``: m, from B
    down to the distance sensor. ``lasers``: what an operator measured at the start. ``straighten``: bring the rays of
    a turn to its end by odometry, not by tilt alone. ``gather``: s to wait for the other lidars' turns. ``gate``: m,
    by which lidars may put the drum elsewhere than expected; after ``believe`` times in a row they are believed.
    ``lost``: s without lidars until the position is a guess. ``quiet``: s by source, without a reading, until it is
    said.
    """

    model: Model
    walls: WallSettings
    lidars: tuple[str, ...]
    slackness: SlacknessSettings
    radius: RadiusSettings
    counts: float
    height: HeightSettings | None = None
    tilt: TiltSettings = field(default_factory=TiltSettings)
    fastest: float = math.inf
    valve: float | None = None
    lasers: tuple[Laser, ...] = ()
    straighten: bool = True
    certify: bool = False
    gather: float = 0.1
    gate: float = 0.1
    believe: int = 4
    lost: float = 30.0
    quiet: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse what does not hang together."""
        if len(self.lidars) != len(self.walls.lidars):
            raise InputError(f"lidars: {len(self.lidars)} sources for {len(self.walls.lidars)} lidars")
        if self.model.n != 3:
            raise InputError(f"robot {self.model.robot.name!r}: only a point platform's state can be observed")
        if not self.counts > 0.0:
            raise InputError(f"counts = {self.counts:g}: over 0 is wanted")


class Looked(NamedTuple):
    """A turn of a horizontal lidar whose lines are found; where the drum is by them comes in the next step."""

    scan: Scan
    turn: LidarTurn
    kept: KeptTurn
    end: Array  # (3,) m, by odometry, at the end of the turn; of the filter, from there to now
    yaw: float  # rad, likewise


@dataclass(eq=False)
class ObserverState:
    """What `step` changes. Odometry (x, y, z, yaw) goes on without the lidars; `anchor` is what they add to it."""

    intake: Intake
    walls: WallState
    slackness: SlacknessState
    radius: RadiusState
    tilt: TiltState
    places: Trail  # x, y, z by odometry, at the encoders' times
    attitudes: Trail  # yaw by odometry, tilt x and y, at the inertial readings' times
    time: float = -math.inf
    odometry: Array = field(default_factory=lambda: np.zeros(3))
    yaw: float = 0.0  # rad by odometry
    yaw_rate: float = 0.0
    yaw_bias: float = 0.0
    anchor: Array = field(default_factory=lambda: np.full(3, np.nan))  # m: position less odometry
    anchor_yaw: float = math.nan
    yaw_fixed: float = -math.inf  # s: when the lidars told a yaw last
    angles: Array | None = None  # (m,) rad paid out
    lengths: Array | None = None
    tracker: Tracker | None = None
    velocity: Array = field(default_factory=lambda: np.zeros(3))
    taut: Taut | None = None
    pending: list[Scan] = field(default_factory=list)
    looked: Looked | None = None
    turn_end: tuple[Array, float] | None = None  # odometry at the end of the last turn that was used
    turns_end: dict[str, float] = field(default_factory=dict)  # s: when each lidar turned last
    gathered: set[str] = field(default_factory=set)
    gathering: float = math.inf  # s: since when
    settled: int = 0  # how many states were made of what lidars told
    refused: int = 0
    fixed: float = -math.inf  # s: when the lidars told a place last ...
    whole: float = -math.inf  # ... and when not along one direction only
    settled_at: float = -math.inf  # s: when lengths were made of it last
    pose: WallPose | None = None
    height: HeightEstimate | None = None
    floorless: float = 0.0  # m that B went since the floor was seen
    clearance: float = math.nan  # m: fictive height less height by odometry
    depth: DistanceReading | None = None

    @property
    def watch(self) -> Watch:
        """Faults."""
        return self.intake.watch
