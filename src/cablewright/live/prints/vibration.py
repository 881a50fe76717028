"""First natural frequency of the lines, by their accelerometers, and its dependence on temperature.

Merlet and Papegay 2023 (III.B) consider it as an indicator of a cable's wear. It is the wave speed over twice the
length, so it changes along the path; only a deviation from that can indicate wear.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import LineAngles
from cablewright.running.running_statistics import ThinnedRows

WINDOW: Final = 20.0
"""Length of a window, s."""

_MAX_READINGS: Final = 20_000  # in a window
_BAND: Final = 0.25  # half width of the band that is searched, as a share of the expected frequency
_MAX_FREQUENCY: Final = 0.4  # share of the sampling rate
_MIN_PEAK: Final = 12.0  # power of a peak over the median of its band
_MIN_KNOWN: Final = 0.95  # share of a window's readings that a line must have
_MIN_WINDOWS: Final = 8
_MIN_SPREAD: Final = 0.2  # K, standard deviation


@dataclass(frozen=True, eq=False)
class VibrationRecord:
    """Frequencies of each line in w time windows, and their dependence on temperature. NaN: unknown."""

    times: Array  # (w,) s
    temperatures: Array  # (w,) degrees Celsius
    frequencies: Array  # (w, m) Hz
    expected: Array  # (w, m) Hz, of a string under the estimated tension
    slopes: Array  # (m,) 1/K: relative change of measured over expected
    slope_sigmas: Array  # (m,) 1/K


class VibrationWindows:
    """Collects accelerometer readings in time windows, and finds each window's peak frequency."""

    def __init__(self, m: int) -> None:
        """Start with no readings of *m* lines."""
        self._m = m
        self._times: list[float] = []
        self._angles: list[Array] = []
        self._windows = ThinnedRows(2 + 2 * m)

    def add(self, reading: LineAngles) -> bool:
        """Add a reading; return whether the window is complete and `close` is due."""
        if self._times:
            since = reading.time - self._times[-1]
            if not 0.0 < since < 1.0 or len(self._times) >= _MAX_READINGS:
                self.drop()
        self._times.append(reading.time)
        self._angles.append(reading.angles)
        return self._times[-1] - self._times[0] >= WINDOW

    @property
    def window_begins(self) -> bool:
        """Whether the last reading was the first of a window."""
        return len(self._times) == 1

    def drop(self) -> None:
        """Discard the present window of line vibration readings."""
        self._times.clear()
        self._angles.clear()

    def close(self, temperature: float, expected: Array) -> None:
        """Complete the window: find peaks near *expected* (m,), Hz, or none for NaN. *temperature*: degrees Celsius."""
        times, angles = np.array(self._times), np.array(self._angles)
        self.drop()
        found = [peak_frequency(times, column, float(near)) for column, near in zip(angles.T, expected, strict=True)]
        self._windows.add(np.array([[times.mean(), temperature, *found, *expected]]))

    def result(self) -> VibrationRecord:
        """Return the vibration frequencies of all windows."""
        rows, m = self._windows.rows, self._m
        temperatures, frequencies, expected = rows[:, 1], rows[:, 2 : 2 + m], rows[:, 2 + m :]
        slopes = np.array([_slope(temperatures, frequencies[:, i] / expected[:, i]) for i in range(m)]).reshape(m, 2)
        return VibrationRecord(rows[:, 0], temperatures, frequencies, expected, slopes[:, 0], slopes[:, 1])


def peak_frequency(times: Array, angles: Array, near: float) -> float:
    """Frequency (Hz) of a clear peak of *angles* (k,) at *times* (k,), s, within 25 % of *near* (Hz); NaN without one.

    From a periodogram with a Hann window; a parabola through the logarithms interpolates between bins.
    """
    known = np.isfinite(angles)
    if not math.isfinite(near) or np.count_nonzero(known) < max(64, _MIN_KNOWN * len(angles)):
        return math.nan
    rate = (len(times) - 1) / float(times[-1] - times[0])
    if near > _MAX_FREQUENCY * rate:
        return math.nan
    even = np.linspace(times[0], times[-1], len(times))
    values = np.interp(even, times[known], angles[known])
    values -= np.polynomial.Polynomial.fit(even, values, 1)(even)
    power = np.abs(np.fft.rfft(values * np.hanning(len(values)))) ** 2
    frequencies = np.arange(len(power)) * rate / len(values)
    band = np.flatnonzero(np.abs(frequencies - near) <= _BAND * near)
    if len(band) < 8:
        return math.nan
    top = int(band[power[band].argmax()])
    if power[top] < _MIN_PEAK * np.median(power[band]) or top in (band[0], band[-1]):
        return math.nan
    left, middle, right = np.log(power[top - 1 : top + 2])
    return float(frequencies[1] * (top + 0.5 * (left - right) / (left - 2.0 * middle + right)))


def _slope(temperatures: Array, ratios: Array) -> tuple[float, float]:
    """Relative change of *ratios* (w,) by temperature, 1/K, and its standard deviation; NaN with too little data."""
    known = np.isfinite(temperatures) & np.isfinite(ratios) & (ratios > 0.0)
    x, y = temperatures[known], np.log(ratios[known])
    if len(x) < _MIN_WINDOWS or float(np.std(x)) < _MIN_SPREAD:
        return math.nan, math.nan
    x = x - x.mean()
    square = float(x @ x)
    slope = float(x @ y) / square
    left = y - y.mean() - slope * x
    return slope, math.sqrt(float(left @ left) / (len(x) - 2) / square)
