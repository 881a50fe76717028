"""Modes out of records: frequencies, damping and sigmas of swings whose modes are known, and records without any."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from cablewright.analyses.swing_identification import identify_swing
from cablewright.foundation.errors import InputError
from cases import often, some

Array = NDArray[np.float64]
FREQUENCIES, DAMPING = np.array([0.65, 1.01, 2.57, 3.58]), np.array([0.0025, 0.005, 0.004, 0.02])


def swing(times: Array, sizes: tuple[float, ...] = (0.02, 0.03, 0.005, 0.004)) -> Array:
    """Markers, (N, 9) m, that swing in four modes, like those of a platform on two lines."""
    random = np.random.default_rng(4)
    moved = np.zeros((len(times), 9))
    for f, z, size in zip(FREQUENCIES, DAMPING, sizes, strict=True):
        rate = 2.0 * np.pi * f
        wave = np.exp(-z * rate * times) * np.cos(rate * np.sqrt(1.0 - z * z) * times + random.uniform(0.0, 6.0))
        moved += wave[:, None] * size * random.normal(size=9)
    return moved + random.normal(size=9)


def test_without_noise_it_is_exact() -> None:
    times = np.arange(501) * 0.02
    found = identify_swing(times, swing(times))
    np.testing.assert_allclose(found.frequencies, FREQUENCIES, rtol=1e-5)
    np.testing.assert_allclose(found.damping, DAMPING, rtol=1e-2)
    assert found.explained > 0.999
    alone = identify_swing(times, swing(times, (0.0, 0.03, 0.0, 0.0)))
    np.testing.assert_allclose([*alone.frequencies, *alone.damping], [1.01, 0.005], rtol=1e-3)


@pytest.mark.parametrize("noise", [3e-4, 2e-3])
def test_errors_are_as_large_as_their_sigmas(noise: float) -> None:
    times, random = np.arange(501) * 0.02, np.random.default_rng(0)
    errors = []
    for _ in range(often(10, 25)):
        found = identify_swing(times, swing(times) + noise * random.normal(size=(501, 9)))
        nearest = abs(np.log(found.frequencies[:, None] / FREQUENCIES)).argmin(axis=0)
        errors += [
            *((found.frequencies[nearest] - FREQUENCIES) / found.frequency_sigmas[nearest]),
            *((found.damping[nearest] - DAMPING) / found.damping_sigmas[nearest]),
        ]
    assert 0.7 < np.sqrt(np.mean(np.square(errors))) < 1.4
    assert np.mean(np.abs(errors) < 2.0) > 0.9


def test_a_long_record_is_thinned() -> None:
    times = np.arange(12_000) * 0.005
    noisy = swing(times) + 1e-3 * np.random.default_rng(1).normal(size=(12_000, 9))
    found = identify_swing(times, noisy, highest=4.0)
    assert len(found.times) < 2100
    nearest = abs(np.log(found.frequencies[:, None] / FREQUENCIES)).argmin(axis=0)
    np.testing.assert_allclose(found.frequencies[nearest], FREQUENCIES, rtol=2e-3)
    np.testing.assert_allclose(found.damping[nearest], DAMPING, rtol=0.2)


@pytest.mark.parametrize("seed", some(range(5)))
def test_noise_is_no_swing(seed: int) -> None:
    noise = np.random.default_rng(seed).normal(size=(800, 6))
    with pytest.raises(InputError, match=r"no swing: oscillations from 0\.188 to 25 Hz .* push the platform"):
        identify_swing(np.arange(800) * 0.02, noise)


def test_rest_and_few_samples_are_no_swing() -> None:
    with pytest.raises(InputError, match="no swing: nothing moves"):
        identify_swing(np.arange(200) * 0.02, np.ones((200, 3)))
    with pytest.raises(InputError, match="no swing: 50 samples; at least 100"):
        identify_swing(np.arange(50) * 0.02, np.ones((50, 3)))


def test_drift_is_no_swing() -> None:
    """A platform that creeps, or that a slow gust pushes: no period repeats."""
    times = np.arange(600) * 0.02
    drift = np.outer(0.01 * times + 2e-4 * times**2, [1.0, 0.5, -0.2])
    with pytest.raises(InputError, match="no swing"):
        identify_swing(times, drift + 1e-5 * np.random.default_rng(0).normal(size=(600, 3)))
