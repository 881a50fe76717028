"""Errors of simulated sensors that are read in nearly each step: noise, outliers, losses.

Random numbers are drawn before. *numbers* of a sensor begin with its standard deviation, and the shares of its readings
that are lost and that are outliers.
"""

from math import nan, pi

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.plant.dynamics import RATE
from cablewright.kernels.plant.machine_step import ANGLES, LINES, PULLS, SWIVELS, WINCH_PULLS, feel

DEVIATION, LOST, OUTLIERS = 0, 1, 2

# Numbers of tension sensors, after these: largest reading, N; step of the zeros' random walk, N; share of cross-talk.
MOST, WALK, CROSS_TALK = 3, 4, 5

# Draws of an inertial unit besides its noise: whether something happens, then six places of outliers.
CHANCE, ANYWHERE = 0, 1


@jit
def show_angles(told, zeros, numbers, noise, chance, shown):
    """Write the angles (m,), rad, that accelerometers on the lines show; NaN where a reading is lost.

    *told*: see `machine_step.observe`; *zeros* (m,), rad: zero errors. *noise* (m,): standard normal; *chance*
    (2 m,): from 0 to 1.
    """
    m = shown.shape[0]
    for i in range(m):
        shown[i] = told[LINES + ANGLES * m + i] + zeros[i] + numbers[DEVIATION] * noise[i]
        if chance[i] > 1.0 - numbers[OUTLIERS]:
            shown[i] = pi * chance[m + i] - 0.5 * pi
        if chance[i] < numbers[LOST]:
            shown[i] = nan


@jit
def show_swivels(told, swivels, zeros, numbers, noise, chance, shown):
    """Write the angles (m,), rad, that encoders of sheaves show; NaN where one is lost, or not one of *swivels* (m,).

    Other arguments are those of `show_angles`.
    """
    m = shown.shape[0]
    for i in range(m):
        angle = told[LINES + SWIVELS * m + i] + zeros[i] + numbers[DEVIATION] * noise[i]
        shown[i] = angle - 2.0 * pi * np.rint(angle / 2.0 / pi)
        if chance[i] > 1.0 - numbers[OUTLIERS]:
            shown[i] = -pi + 2.0 * pi * chance[m + i]
        if chance[i] < numbers[LOST] or not swivels[i]:
            shown[i] = nan


@jit
def pull_of_cells(told, pulls):
    """Write the *pulls* (m,), N, on load cells at the axles of sheaves: the mean of both sides."""
    m = pulls.shape[0]
    for i in range(m):
        pulls[i] = 0.5 * (told[LINES + PULLS * m + i] + told[LINES + WINCH_PULLS * m + i])


@jit
def show_tensions(pulls, factors, zeros, numbers, noise, chance, shown):
    """Write the tensions (m,), N, that sensors show of true *pulls* (m,), N; NaN: lost. Their *zeros* (m,) drift.

    *factors* (m,): of their scales. *noise* (2 m,): standard normal, *chance* (2 m,): from 0 to 1.
    """
    m = shown.shape[0]
    for i in range(m):
        zeros[i] += numbers[WALK] * noise[m + i]
        shown[i] = factors[i] * pulls[i]
        if numbers[CROSS_TALK] != 0.0:
            shown[i] += numbers[CROSS_TALK] * (0.5 * (pulls[i - 1] + pulls[(i + 1) % m]))
        shown[i] += zeros[i]
        shown[i] += numbers[DEVIATION] * noise[i]
        if shown[i] > numbers[MOST]:
            shown[i] = numbers[MOST]
        if chance[i] > 1.0 - numbers[OUTLIERS]:
            shown[i] = numbers[MOST] * chance[m + i]
        if chance[i] < numbers[LOST]:
            shown[i] = nan


@jit(allocates=True)
def show_motion(
    rotation, place, acceleration, told, gravity, axes, bias, deviation, outliers, most, noise, draws, shown
):
    """Write acceleration and turn rate (6,), m/s^2 and rad/s, that an inertial unit shows, with its *bias* (6,).

    *deviation* (6,): standard deviations; *outliers*: share of readings that are, up to the *most* (6,) that it can
    show. *noise* (6,): standard normal; *draws* (7,): see CHANCE. For other arguments see `machine_step.feel`.
    """
    for k in range(6):
        shown[k] = bias[k] + deviation[k] * noise[k]
    feel(rotation, place, acceleration, told[RATE:LINES], gravity, axes, shown)
    if draws[CHANCE] > 1.0 - outliers:
        for k in range(6):
            shown[k] = (2.0 * draws[ANYWHERE + k] - 1.0) * most[k]
