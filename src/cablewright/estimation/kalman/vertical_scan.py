"""One scan of the vertical lidar: positions of its points by the estimate, and the mean height that some measure."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from cablewright.estimation.height import HeightSettings
from cablewright.estimation.kalman.lidar_update import noise_factor
from cablewright.estimation.kalman.settings import FilterSettings
from cablewright.estimation.kalman.state import FilterState, MotionSince, moving_velocity
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.signals import Scan
from cablewright.kernels.filtering import vertical_turn as kernel

CONE: Final = 70.0
"""Degrees from the drum's axis, within which ground is seen."""

GATE: Final = 3.0
"""Sigmas from the expected value, of points and heights."""


class VerticalTurn(NamedTuple):
    """The rays of one vertical lidar scan with an echo, and the position of B by which they were computed."""

    rays: Array  # (k, ROTATION + m): columns as `vertical_turn.COSINE` and following
    estimate: Array  # (3,) m, world


def turn_of(
    state: FilterState, height: HeightSettings, scan: Scan, attitudes: Array, motion: MotionSince
) -> VerticalTurn:
    """Return the rays of one *scan* with an echo, by *attitudes* (n, 3), rad, of the platform and its *motion*."""
    attitude, yaw, (x, _, at) = state.attitude, state.attitude.yaw - state.attitude.gyro_yaw, state.mean
    rays = kernel.rays(
        np.array(scan.ranges), scan.first_angle, scan.angle_step, scan.begin, scan.period, height.lidar, attitudes, yaw,
        *motion, x, at, attitude.last_imu_time, state.motion.last_encoder_time,
    )  # fmt: skip
    return VerticalTurn(rays, state.motion.position.copy())


def located(state: FilterState, height: HeightSettings, turn: VerticalTurn) -> tuple[Array, Array]:
    """Return positions (k, 2), m, world, and heights (k,), m, above the floor of the points of a vertical scan."""
    (x, _, at), k = state.mean, len(turn.rays)
    places, heights = np.empty((k, 2)), np.empty(k)
    kernel.locate(turn.rays, x, at, moving_velocity(state), turn.estimate, height.floor, places, heights)
    return places, heights


def range_sigma(settings: FilterSettings, height: HeightSettings) -> float:
    """Return the standard deviation, m, of the noise of one range."""
    return height.sigma or settings.height_bias_sigma


def mean_height(
    settings: FilterSettings, state: FilterState, height: HeightSettings, turn: VerticalTurn, good: Mask
) -> tuple[float, Array, Array]:
    """Return the mean height, m, of the *good* points, its Jacobian (1, n), and its noise variance (1, 1), m^2."""
    (x, layout, at), mean, sigma = state.mean, np.empty(turn.rays.shape[1]), range_sigma(settings, height)
    H = np.empty((1, layout.size))
    over = kernel.write_height(
        turn.rays, good, x, at, state.hung.jacobian, moving_velocity(state), turn.estimate, height.floor, mean, H[0]
    )
    own = settings.height_sigma**2 + coasting_variance(settings, mean[kernel.COASTING_TIME])
    variance = sigma**2 * mean[kernel.Z_SQUARE] / int(np.count_nonzero(good)) + own
    return over, H, np.array([[noise_factor(state) * variance]])


def level_sigma(state: FilterState) -> float:
    """Return the standard deviation, m, of the summed errors of a vertical ray: height, range bias and mount."""
    lay = state.layout
    below = np.array([lay.position.start + 2, lay.range_bias.stop - 1, lay.vertical_mount.start + 2])
    return math.sqrt(max(0.0, float(state.P[below[:, None], below].sum())))


def coasting_variance(settings: FilterSettings, coasting_time: float) -> float:
    """Return the variance, m^2, of B's position after a prediction without encoders over *coasting_time*, s."""
    return settings.velocity_noise**2 * coasting_time**3
