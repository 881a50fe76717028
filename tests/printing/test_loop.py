from __future__ import annotations

import numpy as np
import pytest

from cablewright.errors import InputError
from cablewright.printing.loop import Loop, random_loop

LOW, HIGH = (-1.6, -3.8), (1.6, 3.8)


@pytest.mark.parametrize("seed", range(6))
def test_a_loop_is_as_asked(seed: int) -> None:
    loop = random_loop(28.0, LOW, HIGH, seed=seed)
    assert loop.length == pytest.approx(28.0, rel=1e-9)
    assert loop.crossings >= 2
    assert (loop.points >= np.array(LOW) - 1e-9).all()
    assert (loop.points <= np.array(HIGH) + 1e-9).all()
    np.testing.assert_allclose(loop.points[0], loop.points[-1], atol=1e-12)
    steps = np.linalg.norm(np.diff(loop.at(np.linspace(0, 56, 5601)), axis=0), axis=1)
    np.testing.assert_allclose(steps, 0.01, rtol=2e-3)  # a centimetre along is one apart, over the end too
    directions = np.diff(loop.points, axis=0)
    turns = np.arctan2(*directions[:, ::-1].T)
    assert np.abs((np.diff(turns) + np.pi) % (2 * np.pi) - np.pi).max() < 0.1


def test_the_same_seed_gives_the_same_loop() -> None:
    one, same, other = (random_loop(28.0, LOW, HIGH, seed=seed) for seed in (4, 4, 5))
    np.testing.assert_array_equal(one.points, same.points)
    assert not np.array_equal(one.points, other.points)


@pytest.mark.parametrize("waves", [1, 2, 3])
def test_crossings_are_counted(waves: int) -> None:
    """A Lissajous curve of 1 : n crosses itself n - 1 times."""
    phase = np.linspace(0.0, 2 * np.pi, 4001) + 0.123
    points = np.stack([np.sin(phase), np.sin(waves * phase + 0.4)], axis=1)
    steps = np.hypot(*np.diff(points, axis=0).T)
    assert Loop(points, np.concatenate([[0.0], np.cumsum(steps)])).crossings == waves - 1


def test_what_no_loop_is_is_refused() -> None:
    for length, low, high in ((28.0, HIGH, LOW), (0.0, LOW, HIGH), (1e4, LOW, HIGH), (0.1, LOW, HIGH)):
        with pytest.raises(InputError):
            random_loop(length, low, high, seed=0)
