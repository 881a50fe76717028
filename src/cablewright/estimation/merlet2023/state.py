"""Settings and state of the observer: the estimator of Merlet and Papegay 2023, section III."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from cablewright.estimation.height import HeightEstimate
from cablewright.estimation.known_machine import KnownMachine
from cablewright.estimation.lidar.localisation import WallPose, WallState
from cablewright.estimation.lidar.room import Laser
from cablewright.estimation.merlet2023.drum_radius import RadiusSettings, RadiusState
from cablewright.estimation.reading_checks import ClockedState
from cablewright.estimation.tilt import TiltState
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Distance
from cablewright.solvers.continuation import Tracker


@dataclass(frozen=True, eq=False, kw_only=True)
class ObserverSettings(KnownMachine):
    """The machine as described, and the limits by which readings are accepted.

    ``lasers``: an operator's distances at the start. ``deskew``: correct the rays of a scan for the platform's motion
    by odometry, not for its tilt alone. ``gather_time``: s to wait for the other lidars' scans. ``gate``: m, by which a
    lidar's position may differ from the expected one.
    """

    radius: RadiusSettings
    lasers: tuple[Laser, ...] = ()
    deskew: bool = True
    certify: bool = False
    gather_time: float = 0.1
    gate: float = 0.1


@dataclass(eq=False)
class Odometry:
    """Position and yaw of the platform without lidars, by encoders and gyro."""

    position: Array = field(default_factory=lambda: np.zeros(3))  # m
    yaw: float = 0.0  # rad
    yaw_rate: float = 0.0
    yaw_rate_bias: float = 0.0
    last_yaw_time: float = -math.inf  # s: of the last lidar yaw
    velocity: Array = field(default_factory=lambda: np.zeros(3))
    last_motion_time: float = math.inf  # s: of lines by over 1 mm/s, until there is a position; inf: not known
    distance_without_floor: float = 0.0  # m that B moved since the floor was seen


@dataclass(eq=False)
class Located:
    """Positions of the platform by lidars, as offsets from odometry, and the scans used to find lengths. Times in s."""

    wall_state: WallState
    wall_pose: WallPose | None = None
    height: HeightEstimate | None = None
    position_offset: Array = field(default_factory=lambda: np.full(3, np.nan))  # m: position less odometry
    yaw_offset: float = math.nan
    turn_ends: tuple[tuple[Array, float], ...] = ()  # odometry at the ends of the last two turns, m (3,), rad
    last_turn_times: dict[str, float] = field(default_factory=dict)  # of each lidar's last turn
    gathered_sources: set[str] = field(default_factory=set)
    gather_start: float = math.inf  # when the first of `gathered_sources` came
    lidar_states: int = 0  # number of states made from lidar positions
    rejections: int = 0
    last_position_time: float = -math.inf  # of the last lidar position ...
    last_full_position_time: float = -math.inf  # ... and of the last in both directions
    last_length_time: float = -math.inf  # of the last lidar position that gave lengths


@dataclass(eq=False, kw_only=True)
class ObserverState(ClockedState):
    """State of the estimator, changed in place by `step`. The motion of its ``turns`` is that of the odometry."""

    odometry: Odometry = field(default_factory=Odometry)
    located: Located
    radius: RadiusState
    tilt: TiltState
    drum_angles: Array | None = None  # (m,) rad, paid out
    lengths: Array | None = None
    tracker: Tracker | None = None
    last_distance: Distance | None = None
