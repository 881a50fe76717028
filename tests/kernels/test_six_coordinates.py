"""The number of coordinates n of kernels is data: the same code holds a rigid body on eight lines, here from arrays
without a description."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cablewright.kernels import batches, layout
from cablewright.kernels.layout import Packed
from cablewright.kernels.statics.equilibrium import condense, evaluate, workspace

CORNERS = np.array([[x, y, z] for z in (0.0, 3.0) for x in (-2.0, 2.0) for y in (-1.5, 1.5)])
ATTACHED = np.array([[x, y, z] for z in (0.25, -0.2) for x in (0.15, -0.15) for y in (-0.1, 0.1)])  # crossed
ATTACHED[:, 0] *= np.array([-1, -1, -1, -1, 1, 1, 1, 1])


def eight_lines(weight: float = 0.3, radius: float = 0.0) -> Packed:
    """A crossed layout with some weight in its cables; swivels where *radius* is not zero."""
    lines = np.zeros((8, layout.COLUMNS))
    lines[:, :3], lines[:, 3:6] = CORNERS, ATTACHED
    lines[:, layout.RADIUS] = lines[:, layout.LEVER] = radius
    lines[:, layout.SIDE] = 1.0
    lines[:, layout.WEIGHT] = weight
    lines[:, [layout.FREE_COMPLIANCE, layout.ARC_COMPLIANCE]] = 1 / 130e3
    lines[:, [layout.TENSION_MIN, layout.TENSION_MAX, layout.BREAKING]] = 20.0, 2000.0, 5000.0
    lines[:, layout.UNKNOWNS] = 3
    lines[:, [layout.SPANS, layout.PULLS]] = 1.0
    platform = np.zeros(layout.PLATFORM)
    platform[layout.PLATFORM_WEIGHT] = 98.1
    platform[layout.MASS_X : layout.MASS_Z + 1] = 0.01, -0.02, 0.03
    return Packed(6, lines, platform, None)


def batch(packed: Packed) -> Packed:
    """*packed* as one row for a whole batch."""
    return packed._replace(lines=packed.lines[None], platform=packed.platform[None])


def held(packed: Packed, count: int = 50) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Random poses with their lengths and line states."""
    rng = np.random.default_rng(6)
    poses = np.column_stack(
        [rng.uniform([-0.5, -0.4, 1.1], [0.5, 0.4, 1.9], (count, 3)), rng.normal(0, 0.1, (count, 3))]
    )
    states, lengths = np.zeros((count, 8, layout.STATE)), np.zeros((count, 8))
    codes, violations = np.zeros(count, np.int64), np.zeros(count)
    batches.inverse_rows(batch(packed), poses, states, lengths, codes, violations, False, 0, count)
    good = codes == 0
    assert good.sum() > count // 2
    return poses[good], states[good], lengths[good]


@pytest.mark.parametrize("radius", [0.0, 0.05])
def test_forward_of_inverse_is_the_pose(radius: float) -> None:
    packed = eight_lines(radius=radius)
    wanted, _, lengths = held(packed)
    count = len(wanted)
    rng = np.random.default_rng(7)
    poses = wanted + rng.normal(0, 0.003, wanted.shape)  # millimetres and milliradians away
    states, codes = np.zeros((count, 8, layout.STATE)), np.zeros(count, np.int64)
    more = (codes, np.zeros(count, np.int64), np.zeros(count))
    batches.forward_rows(batch(packed), lengths, poses, states, *more, batches.NEAR, 0, count)
    assert not codes.any()
    np.testing.assert_allclose(poses[:, :3], wanted[:, :3], atol=1e-9)
    turned = Rotation.from_rotvec(poses[:, 3:]).inv() * Rotation.from_rotvec(wanted[:, 3:])
    assert turned.magnitude().max() < 1e-9


def stiffness_and_wrench(packed: Packed, lengths, pose, states) -> tuple[np.ndarray, np.ndarray]:
    """Tangent stiffness, and the platform's balance with each line settled at the pose."""
    work = workspace(packed)
    for _ in range(30):  # settle the lines alone
        evaluate(packed, lengths, pose, states, work)
        balance = work.trial.copy()
        assert condense(packed, states, work)
        for i in range(8):
            states[i, :3] -= work.steps[i, :3, 0]
    return work.stiffness.copy(), balance


@pytest.mark.parametrize("radius", [0.0, 0.05])
def test_stiffness_is_the_change_of_the_wrench(radius: float) -> None:
    packed = eight_lines(radius=radius)
    poses, states, lengths = held(packed, 6)
    for pose, state, length in zip(poses, states, lengths, strict=True):
        stiffness, balance = stiffness_and_wrench(packed, length, pose, state.copy())
        assert np.abs(balance).max() < 1e-7
        step = 1e-6
        for k in range(6):
            ends = []
            for sign in (1, -1):
                moved = pose.copy()
                if k < 3:
                    moved[k] += sign * step
                else:
                    turn = Rotation.from_rotvec(sign * step * np.eye(3)[k - 3]) * Rotation.from_rotvec(pose[3:])
                    moved[3:] = turn.as_rotvec()
                ends.append(stiffness_and_wrench(packed, length, moved, state.copy())[1])
            np.testing.assert_allclose(-(ends[0] - ends[1]) / (2 * step), stiffness[:, k], rtol=1e-4, atol=0.5)
        scale = np.sqrt(np.outer(np.diag(stiffness), np.diag(stiffness)))
        skew = np.abs(stiffness - stiffness.T) / scale
        assert skew.max() < (1e-9 if radius == 0.0 else 1e-4)  # a weightless arc is not quite conservative
