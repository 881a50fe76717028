"""The part of changes of lengths that moves a platform, beside numpy's own."""

import numpy as np
import pytest

from cablewright.kernels.control.length_change_split import split
from cases import some


@pytest.mark.parametrize("seed", some(range(50)))
def test_moving_part_is_the_least_squares_fit(seed: int) -> None:
    rng = np.random.default_rng(seed)
    p = int(rng.integers(1, 7))
    gradients = rng.normal(size=(p + int(rng.integers(0, 5)), p))
    change, moving, motion = rng.normal(size=len(gradients)), np.empty(len(gradients)), np.empty(p)
    split(np.column_stack([gradients, change]), moving, motion)
    expected = np.linalg.lstsq(gradients, change, rcond=None)[0]
    assert moving == pytest.approx(gradients @ expected, abs=1e-9)
    assert gradients @ motion == pytest.approx(gradients @ expected, abs=1e-9)


def test_fewer_lengths_than_motions_all_move() -> None:
    gradients, change, moving, motion = np.ones((2, 3)), np.array([1.0, 2.0]), np.empty(2), np.empty(3)
    gradients[1, 1] = 3.0
    split(np.column_stack([gradients, change]), moving, motion)
    assert moving == pytest.approx(change)
    assert gradients @ motion == pytest.approx(change)


def test_a_motion_that_depends_on_another_is_zero() -> None:
    gradients = np.array([[1.0, 2.0], [0.0, 0.0], [2.0, 4.0]])
    moving, motion = np.empty(3), np.empty(2)
    split(np.column_stack([gradients, [1.0, 0.0, 2.0]]), moving, motion)
    assert motion == pytest.approx([1.0, 0.0])
