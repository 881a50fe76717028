"""Identification of frequencies and damping from a recorded free swing: eigensystem realisation over model orders.

The samples of all channels form a block Hankel matrix. Its left singular vectors, cut to an order, are an observability
matrix; the least-squares map between its shifted parts has the poles of the swing (Juang and Pappa 1985). A pole counts
as a mode if it is found again over model orders. Its frequency and damping are medians over these; their sigmas combine
the spread over orders and the bound of Cramer and Rao for a decaying oscillation in the noise around its frequency.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.linalg import eigh
from scipy.signal import decimate

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError

ORDERS: Final = tuple(range(2, 26, 2))
"""Numbers of poles for which the record is realised."""

PERIODS: Final = 3.0
"""Periods of a mode that a record must hold at least."""

MIN_SAMPLES: Final = 100
_MOST_SAMPLES: Final = 1000  # above twice this, a record is decimated
_MOST_CHANNELS: Final = 6  # principal components of the channels that are kept
_FILTER_ENDS: Final = 10  # samples at each end that the filter before thinning distorts
_ROWS: Final = 5  # the Hankel matrix has a block row for every 5th sample
_MOST_ROWS: Final = 600  # of the Hankel matrix
_NEAR: Final = 0.02  # relative difference of frequencies of one mode over orders
_STABLE: Final = 0.4  # share of the orders in which a mode is found
_MOST_DAMPING: Final = 0.25  # share of critical; above, a pole is a trend and no swing
_LEAST_SHARE: Final = 2e-4  # of the record's energy, of a mode
_SWUNG: Final = 0.999  # share of the record's energy up to where it is used: the remainder is noise at rest
_SWINGING: Final = 0.2  # least share of the record's energy that all modes together explain
_INEFFICIENCY: Final = 1.4  # of the realisation, over the bound of Cramer and Rao: of simulated records
_DISTINCT: Final = 10.0  # least energy of a mode over that which noise alone has around its frequency
_NORMAL: Final = 1.4826  # standard deviation over median absolute deviation


@dataclass(frozen=True, eq=False)
class IdentifiedModes:
    """The k modes of a free swing, by frequency, Hz. `damping`: shares of critical damping.

    `frequency_sigmas`, `damping_sigmas` (k,): one standard deviation. `shares` (k,): of the record's energy, which do
    not add up where modes overlap. `explained`: that of all modes together. `record`, `fit` (N, c): channels without
    their means at `times` (N,), and by these modes alone. `poles` (p, 3): order, frequency and damping of all.
    """

    times: Array
    record: Array
    fit: Array
    frequencies: Array
    frequency_sigmas: Array
    damping: Array
    damping_sigmas: Array
    shares: Array
    explained: float
    poles: Array


def identify_swing(times: Array, record: Array, highest: float | None = None) -> IdentifiedModes:
    """Identify modes of a free swing in a *record* (N, c) at even *times* (N,), s; all channels in one unit.

    *highest*: Hz, the highest frequency of interest; a long record is thinned to four samples a period of it. Raises
    `InputError` for too few samples, and for a record in which no decaying oscillation dominates.
    """
    times, record = _thinned(times, record, highest)
    count, step = len(times), float(times[1] - times[0])
    centred = record - record.mean(axis=0)
    total = float((centred**2).sum())
    if total <= 0.0:
        raise InputError("no swing: nothing moves in the record; push the platform, and record it again")
    realised = _poles(_components(centred), step)
    found = [
        (order, *_hertz(pole), energy / total)
        for order, poles in realised
        for pole, energy in _weighed(centred, poles, times)
    ]
    lowest = PERIODS / (step * count)
    table = np.array(found).reshape(-1, 4)
    table = table[(table[:, 1] >= lowest) & (table[:, 2] < _MOST_DAMPING)]
    modes = _stable(table, _STABLE * len(realised))
    poles = np.array([2.0 * np.pi * f * complex(-z, np.sqrt(1.0 - z * z)) for f, _, z, _ in modes])
    fit, amplitudes = _fitted(centred, poles, times)
    each = list(zip(poles, amplitudes, strict=True))
    energies = np.array([float((_wave(*one, times) ** 2).sum()) for one in each])
    bounds, noises = np.array([_bound(centred - fit, *one, times) for one in each]).reshape(-1, 2).T
    kept = energies > _DISTINCT * noises
    explained = 1.0 - float(((centred - fit) ** 2).sum()) / total
    if not kept.any() or explained < _SWINGING:
        what = f"oscillations from {lowest:.3g} to {0.5 / step:.3g} Hz that repeat over model orders explain"
        raise InputError(
            f"no swing: {what} {100.0 * max(explained, 0.0) * kept.any():.2g} % of the record, which needs "
            f"{100.0 * _SWINGING:g} %; push the platform, and record it with the winches at rest"
        )
    f, f_spread, z, z_spread = np.array(modes)[kept].T
    return IdentifiedModes(
        times,
        centred,
        fit,
        f,
        np.hypot(f_spread, bounds[kept] / (2.0 * np.pi)),
        z,
        np.hypot(z_spread, bounds[kept] / abs(poles[kept])),
        energies[kept] / total,
        explained,
        table[:, :3],
    )


def _thinned(times: Array, record: Array, highest: float | None) -> tuple[Array, Array]:
    """Return the record at even times, with fewer samples where it is long."""
    count = len(times)
    if count < MIN_SAMPLES:
        raise InputError(f"no swing: {count} samples; at least {MIN_SAMPLES} are needed")
    even = np.linspace(times[0], times[-1], count)
    record = np.stack([np.interp(even, times, channel) for channel in record.T], axis=1)
    rate = (count - 1) / (times[-1] - times[0])
    energy = np.cumsum(((record - record.mean(axis=0)) ** 2).sum(axis=1))
    count = max(int(np.searchsorted(energy, _SWUNG * energy[-1])) + 1, MIN_SAMPLES)
    even, record = even[:count], record[:count]
    factor = min(count // _MOST_SAMPLES, int(rate / (4.0 * highest)) if highest else 1)
    if factor < 2:
        return even, record
    inner = slice(_FILTER_ENDS, -_FILTER_ENDS)
    thin = decimate(record - record.mean(axis=0), factor, ftype="fir", axis=0)
    return even[::factor][inner], np.asarray(thin[inner])


def _components(record: Array) -> Array:
    """Return the strongest principal components (N, at most 6) of the channels."""
    return np.asarray(record @ np.linalg.svd(record, full_matrices=False)[2][:_MOST_CHANNELS].T)


def _poles(record: Array, step: float) -> list[tuple[int, Array]]:
    """Return the continuous poles in the upper half plane, rad/s, of the realisation of each order."""
    count, channels = record.shape
    rows = min(count // _ROWS, _MOST_ROWS // channels)
    hankel = np.concatenate([record[i : count - rows + i + 1].T for i in range(rows)])
    most = min(len(hankel) // 2, ORDERS[-1])
    left = eigh(hankel @ hankel.T, subset_by_index=(len(hankel) - most, len(hankel) - 1))[1][:, ::-1]
    found = []
    for order in range(ORDERS[0], most + 1, ORDERS[1] - ORDERS[0]):
        seen = left[:, :order]
        step_map = np.linalg.lstsq(seen[:-channels], seen[channels:], rcond=None)[0]
        factors = np.linalg.eigvals(step_map).astype(complex)
        found.append((order, np.log(factors[factors.imag > 0.0]) / step))
    return found


def _hertz(pole: complex) -> tuple[float, float]:
    """Return frequency, Hz, and share of critical damping of a pole."""
    return abs(pole) / (2.0 * np.pi), -pole.real / abs(pole)


def _wave(pole: complex, amplitudes: Array, times: Array) -> Array:
    """Return a decaying oscillation (N, c) of complex amplitudes (c,)."""
    return np.asarray((np.exp(pole * (times - times[0]))[:, None] * amplitudes).real)


def _fitted(record: Array, poles: Array, times: Array) -> tuple[Array, Array]:
    """Return the least-squares fit (N, c) of oscillations, and their complex amplitudes (k, c)."""
    waves = np.exp(np.outer(times - times[0], poles))
    basis = np.hstack([waves.real, -waves.imag, np.ones((len(times), 1))])
    found = np.linalg.lstsq(basis, record, rcond=None)[0]
    k = len(poles)
    return basis @ found, found[:k] + 1j * found[k : 2 * k]


def _weighed(record: Array, poles: Array, times: Array) -> list[tuple[complex, float]]:
    """Return the poles of one order, each with the energy that the record has of it."""
    poles = poles[poles.real > -_MOST_DAMPING * abs(poles)]
    poles = poles[poles.real * (times[-1] - times[0]) < 1.0]
    amplitudes = _fitted(record, poles, times)[1]
    energies = [float((_wave(pole, each, times) ** 2).sum()) for pole, each in zip(poles, amplitudes, strict=True)]
    return list(zip(poles, energies, strict=True))


def _stable(table: Array, least: float) -> list[tuple[float, float, float, float]]:
    """Return medians and spreads of frequency and damping of the modes that at least *least* orders have.

    *table*: all poles, one in each row. The mode with the most energy, summed over orders, is taken first, with the
    strongest pole near it of each order.
    """
    found = []
    left = table
    while len(left):
        near = abs(np.log(left[:, 1][:, None] / left[:, 1])) < _NEAR
        centre = left[int((near @ left[:, 3]).argmax()), 1]
        group = left[abs(np.log(left[:, 1] / centre)) < _NEAR]
        left = left[abs(np.log(left[:, 1] / centre)) >= _NEAR]
        strongest = np.array([max(group[group[:, 0] == order], key=lambda row: row[3]) for order in set(group[:, 0])])
        if len(strongest) >= least and np.median(strongest[:, 3]) >= _LEAST_SHARE:
            found.append((*_middle(strongest[:, 1]), *_middle(strongest[:, 2])))
    return sorted(found)


def _middle(values: Array) -> tuple[float, float]:
    """Return the median, and the standard deviation by the median of deviations."""
    median = float(np.median(values))
    return median, _NORMAL * float(np.median(abs(values - median)))


def _bound(rest: Array, pole: complex, amplitudes: Array, times: Array) -> tuple[float, float]:
    """Return a standard deviation of decay and angular frequency, rad/s, of one oscillation, and its noise's energy.

    *rest* (N, c): the residual without the modes; its power around the frequency is that of the noise.
    """
    t = times - times[0]
    window = np.exp(pole.real * t)
    power = window**2
    own = np.exp(-1j * pole.imag * t) * np.sqrt(power / power.sum())
    beside = [np.exp(2j * np.pi * k * t / t[-1]) * own for k in range(-3, 4)]
    noise = np.mean([abs(each @ rest) ** 2 for each in beside], axis=0)  # (c,): variance if white
    curvature = (power * t**2).sum() - (power * t).sum() ** 2 / power.sum()
    information = (abs(amplitudes) ** 2 / np.maximum(noise, 1e-300)).sum() * curvature / 2.0
    return float(_INEFFICIENCY / np.sqrt(max(information, 1e-300))), 2.0 * float(noise.sum())
