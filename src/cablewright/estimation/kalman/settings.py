"""Settings of the Kalman filter."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from cablewright.estimation.kalman.coil_layers import CoilLayers
from cablewright.estimation.known_machine import KnownMachine
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError
from cablewright.models.winch_lines import WinchLines

_UNKNOWN_SLACK_NOISE: Final = 0.02  # m per root metre that B moves, where it is not known which line is slack


@dataclass(frozen=True, eq=False)
class FilterSettings:
    """Settings of the filter: standard deviations, random walks, and the settings of the ``machine``.

    docs/estimation.md gives the source of each number.

    Process noise, as random walks: ``travel_noise`` m per root metre that B moves, of B and of lengths, for errors of
    anchors and moduli; ``drift_noise`` m per root second, likewise; ``radius_noise`` of each radius, a share per root
    radian; ``velocity_noise`` m/s per root second, of B's velocity without encoders; ``ground_noise`` m per root metre,
    of the ground under the valve; ``gyro_noise`` rad per root second. Cables stretch by creep and hysteresis, unseen by
    encoders, at a rate of ``stretch_rate_sigma`` per second that is correlated for ``stretch_time`` s.

    Initial: ``radius_sigma`` as a share, ``gyro_bias_sigma`` rad/s, ``accelerometer_bias_sigma`` rad of tilt,
    ``height_bias_sigma`` m of the vertical lidar's range, ``zero_sigma`` rad of each line accelerometer's zero,
    ``compliance_sigma`` of the logarithm of how much more each line, with its mount, gives per tension than described.

    Measurements, besides their sensors' noise: ``wall_sigma`` m and ``wall_angle_sigma`` rad of a wall's line,
    ``height_sigma`` m of the floor, ``distance_sigma`` m of the distance sensor, ``gravity_sigma`` rad of the mean over
    a tenth of a second, ``swing_sigma`` rad of the drum's swing and ``swing_period`` s, ``line_angle_sigma`` rad of a
    smoothed line angle, ``excess_sigma`` m, ``stretch_sigma`` (besides the compliance), ``mass_sigma`` and
    ``load_sigma`` (how far B sinks for a sudden increase of mass) as shares, ``velocity_sigma`` m/s and
    ``attitude_sigma`` rad of the estimate.

    Without the IMU: ``turn_rate_sigma`` rad/s of the drum, ``skew_time`` s: error of a wall's distance, m, for each
    rad/s during the turn. ``layers``: where radii step; None: not known. ``max_position_sigma``: m in space, beyond
    which the estimate is invalid.
    """

    machine: KnownMachine
    travel_noise: float = 5e-4
    drift_noise: float = 1e-4
    radius_noise: float = 3.6e-3
    stretch_rate_sigma: float = 2e-5
    stretch_time: float = 10.0
    compliance_sigma: float = 0.5
    velocity_noise: float = 0.01
    ground_noise: float = 0.03
    radius_sigma: float = 0.1
    gyro_bias_sigma: float = 2e-3
    gyro_noise: float = 2e-4
    accelerometer_bias_sigma: float = 3e-3
    wall_sigma: float = 5e-5
    wall_angle_sigma: float = 1e-4
    height_sigma: float = 1e-4
    height_bias_sigma: float = 2e-3
    zero_sigma: float = 0.0
    distance_sigma: float = 2e-3
    gravity_sigma: float = 1e-3
    swing_sigma: float = 1e-3
    swing_period: float = 1.5
    line_angle_sigma: float = math.radians(0.05)
    excess_sigma: float = 5e-4
    mass_sigma: float = 0.2
    load_sigma: float = 1.5
    stretch_sigma: float = 0.1
    velocity_sigma: float = 1e-3
    attitude_sigma: float = 1e-4
    turn_rate_sigma: float = math.radians(1.5)
    skew_time: float = 0.15
    max_position_sigma: float = 0.1
    layers: CoilLayers | None = None

    def __post_init__(self) -> None:
        """Reject numbers that are not positive and finite."""
        for name, value in vars(self).items():
            if name == "zero_sigma":
                if not 0.0 <= value < math.inf:
                    raise InputError(f"{name} = {value:g}: a finite number from 0 on is expected")
            elif name not in ("machine", "layers") and not 0.0 < value < math.inf:
                raise InputError(f"{name} = {value:g}: a finite number over 0 is expected")

    @cached_property
    def hanging(self) -> Mask:
        """Mask (m,) of the lines with a counterweight."""
        return np.asarray(self.machine.model.lines.counterweight > 0.0)

    @cached_property
    def rolling(self) -> Array:
        """Noise of a prediction by encoders, as the kernel `predict.reel` needs it."""
        own = self.travel_noise, self.drift_noise, self.radius_noise, self.ground_noise
        return np.array([*own, _UNKNOWN_SLACK_NOISE])

    @cached_property
    def on_walls(self) -> Array:
        """Noise of a line on a wall, as the kernels `wall_matches` need it."""
        own = self.wall_angle_sigma, self.wall_sigma, self.gyro_noise, self.velocity_noise, self.travel_noise
        return np.array([*own, self.turn_rate_sigma, self.skew_time])

    @cached_property
    def drums(self) -> WinchLines:
        """Which winch moves each line, and in which direction."""
        return WinchLines.of(self.machine.model.robot)

    @cached_property
    def counting(self) -> Array:
        """Law of counts and drum rates, as the kernel `predict.reel` needs it."""
        own = self.machine
        return np.array([own.counts_per_radian, own.max_drum_speed, own.slackness.smoothing_time])

    @cached_property
    def uncrept(self) -> Array:
        """Rates of creep (m,), 1/s, of cables that do not."""
        return np.zeros(self.machine.model.m)

    @cached_property
    def shown(self) -> Array:
        """Standard deviations that are added to those of the state, as the kernel `estimate.tell` needs them."""
        return np.array([self.velocity_sigma, self.attitude_sigma, self.swing_sigma, self.turn_rate_sigma])
