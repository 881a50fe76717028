"""Settings and state of the observer: the chain of Merlet and Papegay 2023, section III."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from cablewright.arrays import Array
from cablewright.estimation.chain.drum_radius import RadiusSettings, RadiusState
from cablewright.estimation.fault_monitor import FaultMonitor
from cablewright.estimation.height import HeightEstimate
from cablewright.estimation.known_creep import KnownCreep
from cablewright.estimation.known_machine import KnownMachine
from cablewright.estimation.lidar.localisation import WallPose, WallState
from cablewright.estimation.lidar.room import Laser
from cablewright.estimation.lidar.wall_lines import LidarTurn
from cablewright.estimation.reading_checks import ReadingChecks
from cablewright.estimation.slackness import SlacknessState
from cablewright.estimation.tilt import TiltState
from cablewright.estimation.time_buffer import TimeBuffer
from cablewright.signals import Distance, Scan
from cablewright.solvers.continuation import Tracker
from cablewright.solvers.taut import Taut


@dataclass(frozen=True, eq=False, kw_only=True)
class ObserverSettings(KnownMachine):
    """The machine as described, and the limits by which readings are accepted.

    ``lasers``: an operator's distances at the start. ``deskew``: correct the rays of a turn for the drum's motion by
    odometry, not for its tilt alone. ``gather_time``: s to wait for the other lidars' turns. ``gate``: m, by which a
    lidar's position may differ from the expected one.
    """

    radius: RadiusSettings
    lasers: tuple[Laser, ...] = ()
    deskew: bool = True
    certify: bool = False
    gather_time: float = 0.1
    gate: float = 0.1


@dataclass(eq=False)
class ObserverState:
    """Changed in place by `step`. Position and yaw are odometry, which needs no lidar, plus an offset by the lidars."""

    checks: ReadingChecks
    wall_state: WallState
    slackness: SlacknessState
    radius: RadiusState
    tilt: TiltState
    position_history: TimeBuffer  # odometry x, y, z at the encoders' times
    attitude_history: TimeBuffer  # odometry yaw, tilt x and y, at the IMU's times
    time: float = -math.inf
    odometry: Array = field(default_factory=lambda: np.zeros(3))
    odometry_yaw: float = 0.0  # rad
    yaw_rate: float = 0.0
    yaw_rate_bias: float = 0.0
    position_offset: Array = field(default_factory=lambda: np.full(3, np.nan))  # m: position less odometry
    yaw_offset: float = math.nan
    last_yaw_time: float = -math.inf  # s: of the last lidar yaw
    drum_angles: Array | None = None  # (m,) rad, paid out
    last_motion_time: float = math.inf  # s: of lines by over 1 mm/s, until there is a position; inf: not known
    lengths: Array | None = None
    creep: KnownCreep | None = None  # of cables that creep as described
    tracker: Tracker | None = None
    velocity: Array = field(default_factory=lambda: np.zeros(3))
    taut: Taut | None = None
    pending_scans: list[Scan] = field(default_factory=list)
    extracted_turn: LidarTurn | None = None  # by which the next time step computes the drum's pose
    turn_ends: tuple[tuple[Array, float], ...] = ()  # odometry at the ends of the last two turns, m (3,), rad
    last_turn_times: dict[str, float] = field(default_factory=dict)  # s: of each lidar's last turn
    gathered_sources: set[str] = field(default_factory=set)
    gather_start: float = math.inf  # s: when the first of `gathered_sources` came
    lidar_states: int = 0  # number of states made from lidar positions
    rejections: int = 0
    last_position_time: float = -math.inf  # s: of the last lidar position ...
    last_full_position_time: float = -math.inf  # ... and of the last in both directions
    last_length_time: float = -math.inf  # s: of the last lidar position that gave lengths
    wall_pose: WallPose | None = None
    height: HeightEstimate | None = None
    distance_without_floor: float = 0.0  # m that B moved since the floor was seen
    clearance_offset: float = math.nan  # m: fictive height less odometry's z
    last_distance: Distance | None = None

    @property
    def monitor(self) -> FaultMonitor:
        """Active faults."""
        return self.checks.monitor
