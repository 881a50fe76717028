"""Smoothed angles of the cables near the platform, and the excess lengths that follow from them."""

from math import cos, expm1, isfinite, isnan, nan, tan

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.layout import SPANS, TENSION_MAX, WEIGHT
from cablewright.kernels.statics.taut import SOFTNESS, STRETCH, soften

# Rows of numbers of m lines: difference of the angle from a taut line's, rad, smoothed, NaN: never measured;
# excess, m, NaN: not known; time of the last accepted reading, s; angle of the last one, rad; identical ones in a row,
# ones beyond the gate in a row; scatter of single readings, rad^2, and the smoothing times in it; variance, rad^2.
DIFFERENCE, EXCESS, LAST_TIME, LAST_ANGLE, REPEATS, OUTLIERS, SCATTER, SCATTER_TIMES, VARIANCE = (
    0,
    1,
    2,
    3,
    4,
    5,
    6,
    7,
    8,
)
KNOWN = 9

MAX_REPEATS = 10  # identical readings in a row: a sensor with noise gives none
MAX_OUTLIERS = 5  # readings in a row beyond the gate before they are accepted
AVERAGED = 5.0  # smoothing times over which the scatter of readings is averaged
MIN_SLOPE = 1e-6  # difference of slopes below which a line counts as straight


@jit
def smooth(rows, angles, straight, now, dt, smoothing_time, gate, timeout):
    """Smooth measured cable *angles* (m,), rad, read at *now*, s, in the *rows* (KNOWN, m) of the filter's memory.

    *dt*, s: since the last ones. The excess stays. *straight* (m,): angles of taut lines, rad. *smoothing_time*,
    *timeout*: s; *gate*: rad.
    """
    for i in range(angles.shape[0]):
        angle, before, last = angles[i], rows[DIFFERENCE, i], rows[LAST_ANGLE, i]
        if not isfinite(angle):
            if dt <= smoothing_time:
                rows[SCATTER_TIMES, i] = AVERAGED
            continue
        difference = angle - straight[i]
        rows[REPEATS, i] = rows[REPEATS, i] + 1.0 if angle == last else 0.0
        rows[LAST_ANGLE, i] = angle
        usable = rows[REPEATS, i] < MAX_REPEATS
        stale = isnan(before) or now - rows[LAST_TIME, i] > timeout
        gated = usable and not stale and not abs(difference - before) <= gate
        if usable:
            rows[OUTLIERS, i] = rows[OUTLIERS, i] + 1.0 if gated else 0.0
        many = rows[OUTLIERS, i] >= MAX_OUTLIERS
        accepted, anew = usable and (not gated or many), stale or many
        gain = 1.0 if anew else -expm1(-dt / smoothing_time)
        base = difference if anew else before
        off, new = (difference - base, 0.0 if anew else gain) if accepted else (0.0, 0.0)
        seen = AVERAGED if dt <= smoothing_time else min(rows[SCATTER_TIMES, i] + new, AVERAGED)
        rows[SCATTER_TIMES, i] = seen
        rows[SCATTER, i] += new / seen * (off * off - rows[SCATTER, i])
        if accepted:
            rows[DIFFERENCE, i] = base + gain * off
            rows[VARIANCE, i] = (1.0 - gain) ** 2 * rows[VARIANCE, i] + gain**2 * rows[SCATTER, i]
            rows[LAST_TIME, i], rows[OUTLIERS, i] = now, 0.0


@jit(allocates=True)
def show_excess(rows, lines, angles, free, lengths, toward, from_platform, now, timeout):
    """Write the excess length by the smoothed angles to *rows* (KNOWN, m).

    NaN where the last reading is older than *timeout*, s, at *now*, s.
    """
    parabolic_excess(lines, angles, free, lengths, toward, from_platform, rows[DIFFERENCE], rows[EXCESS])
    for i in range(rows.shape[1]):
        if now - rows[LAST_TIME, i] > timeout:
            rows[EXCESS, i] = nan


@jit(allocates=True)
def step(rows, read, lines, angles, free, lengths, toward, from_platform, now, dt, smoothing_time, gate, timeout):
    """Process new cable angles *read* (m,), rad: smooth them in *rows* (KNOWN, m) and write the excess lengths.

    *angles*, *free*, *lengths*, *toward*: of straight lines. See `smooth`, `show_excess`.
    """
    smooth(rows, read, angles, now, dt, smoothing_time, gate, timeout)
    show_excess(rows, lines, angles, free, lengths, toward, from_platform, now, timeout)


@jit(allocates=True)
def parabolic_excess(lines, angles, free, lengths, toward, from_platform, differences, excess):
    """Write the *excess* (m,), m, of sagging cables from the difference, rad, of their angles from straight ones.

    With horizontal force h the slope grows by w / h per metre, which from mid-span to the sensor gives the difference
    of slopes. The span is w^2 x^2 c cos^2 / 24 h^2 longer than its chord c, less the elastic stretch.
    """
    m = lines.shape[0]
    softness = np.empty((m, SOFTNESS))
    soften(lines, lengths, toward, softness)
    for i in range(m):
        weight, c = lines[i, WEIGHT], cos(angles[i])
        slope = max(tan(min(angles[i] + differences[i], 1.5)) - tan(angles[i]), MIN_SLOPE)
        h = weight * (0.5 * free[i] - from_platform) / slope
        sag = lines[i, SPANS] * (weight * free[i] * c * c / h) ** 2 * free[i] / 24.0
        excess[i] = sag - softness[i, STRETCH] * min(h / c, lines[i, TENSION_MAX])
