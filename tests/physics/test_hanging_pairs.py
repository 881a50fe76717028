"""Robots with so few winches that gravity decides a part of the pose: two pairs, a plate, pairs over sheaves."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize, root

import cablewright as cw
import cases
import out_of_plane
from cablewright.robot import Pulley, Robot, Swivel
from physics.test_shared_winches import FREE, Straight, parallelograms

NAN = float("nan")


@pytest.mark.parametrize("place", [[0.2, NAN, 1.0], [-0.1, NAN, 1.3]])
def test_two_pairs_hang_in_the_plane_between_them(place: list[float]) -> None:
    """Two winches hold two coordinates; sideways, and how it turns, is where the energy is least."""
    robot = parallelograms(2)
    found = cw.inverse(robot, [*place, *FREE], cable="elastic").checked()
    np.testing.assert_allclose(found.pose[[0, 2]], [place[0], place[2]], atol=0.0)
    np.testing.assert_allclose(found.lengths[1::2], found.lengths[::2], atol=1e-12)
    own = Straight(robot)
    start = found.pose + np.array([0.01, -0.02, 0.01, 0.02, -0.01, 0.02])
    least = minimize(own.energy, start, args=(found.lengths,), method="BFGS", options={"gtol": 1e-6})
    there = root(own.wrench, least.x, args=(found.lengths,), tol=1e-14)
    np.testing.assert_allclose(there.x, found.pose, atol=1e-8)


def plate(sheave: dict[str, Any]) -> Robot:
    """A body in a vertical plane on two parallelograms, one to each side."""
    ends = {"l1": (-1.2, 1.9), "l2": (-1.2, 2.1), "r1": (1.2, 1.9), "r2": (1.2, 2.1)}
    cable = {"axial_stiffness": 20e3, "linear_density": 2e-3, "breaking_load": 1e3}
    lines = [
        {
            "name": name,
            "exit_point": (x, 0.0, z),
            "platform_point": (x / 6.0, 0.0, z - 2.0),
            "cable": cable,
            "sheave": sheave,
            "tension_limits": (0.1, 300.0),
        }
        | ({"shared_winch": {"line": f"{name[0]}1"}} if name[1] == "2" else {})
        for name, (x, z) in ends.items()
    ]
    return Robot.model_validate(
        {
            "name": "plate",
            "scene": {"frame_min": (-1.0, -0.1, 0.0), "frame_max": (1.0, 0.1, 2.0)},
            "platform": {"kind": "rigid", "mass": 2.0, "plane": {"normal": (0.0, 1.0, 0.0)}},
            "lines": lines,
        }
    )


@pytest.mark.parametrize("sheave", [{"kind": "eyelet"}, {"kind": "swivel", "radius": 0.02}])
@pytest.mark.parametrize("cable", ["elastic", "catenary"])
def test_a_plate_on_two_parallelograms(sheave: dict[str, Any], cable: str) -> None:
    robot = plate(sheave)
    assert (robot.freedoms, robot.winches) == (3, 2)
    found = cw.inverse(robot, [0.1, NAN, 1.0, 0.0, NAN, 0.0], cable=cable).checked()
    np.testing.assert_allclose(found.lengths[1::2], found.lengths[::2], atol=1e-12)
    assert 1e-4 < abs(found.pose[4]) < 0.01
    back = cw.forward(robot, found.lengths, cable=cable)
    np.testing.assert_allclose(back.pose, found.pose, atol=1e-9)
    with pytest.raises(
        cw.InputError, match="4 lines on 2 winches hold 2 of the 3 degrees of freedom; 3 are given: leave 1 free"
    ):
        cw.inverse(robot, [0.1, 0.0, 1.0, 0.0, 0.0, 0.0])


def swivelling(kind: str) -> Robot:
    """Four pairs over sheaves, with dead spans; of `pulleys` and `aside` out of the vertical plane."""
    robot = parallelograms(4, density=0.005)
    lines = []
    for line in robot.lines:
        x, y, _ = line.exit_point
        sheave = Pulley(radius=0.03, axis=(-y, x, 0.0)) if kind == "pulleys" else Swivel(radius=0.03)
        aside = 1.0 if kind == "swivels" else 1.1
        own = {"sheave": sheave, "winch_exit": (aside * x, aside * y, 0.2)}
        lines.append(line.model_copy(update=own))
    return out_of_plane.checked(robot.model_copy(update={"lines": tuple(lines)}))


@pytest.mark.parametrize("kind", ["swivels", "aside", "pulleys"])
@pytest.mark.parametrize("cable", ["elastic", "catenary"])
def test_pairs_over_sheaves(kind: str, cable: str) -> None:
    robot = swivelling(kind)
    found = cw.inverse(robot, [0.1, 0.05, 1.0, *FREE], cable=cable).checked()
    np.testing.assert_allclose(found.lengths[1::2], found.lengths[::2], atol=1e-10)
    assert found.is_valid()
    back = cw.forward(robot, found.lengths, cable=cable, guess=found.pose)
    np.testing.assert_allclose(back.pose, found.pose, atol=1e-8)


def test_three_lines_on_one_drum() -> None:
    """A drum with all lines of one corner: two ties, each with the line whose drum it is."""
    robot = parallelograms(3)
    lines = list(robot.lines)
    at = cw.inverse(robot, [0.0, 0.0, 1.2, *FREE]).checked().lengths
    own = lines[1].shared_winch
    assert own is not None
    lines[2] = lines[2].model_copy(update={"shared_winch": own.model_copy(update={"offset": float(at[2] - at[0])})})
    lines[3] = lines[3].model_copy(update={"shared_winch": own.model_copy(update={"offset": float(at[3] - at[0])})})
    robot = out_of_plane.checked(robot.model_copy(update={"lines": tuple(lines)}))
    assert robot.winches == 2
    found = cw.inverse(robot, [NAN, 0.0, 1.2, *FREE]).checked()
    np.testing.assert_allclose(found.lengths, at, atol=1e-6)
    back = cw.forward(robot, found.lengths, guess=found.pose)
    np.testing.assert_allclose(back.pose, found.pose, atol=1e-8)


def test_kernels_keep_one_signature() -> None:
    test_pairs_over_sheaves("pulleys", "catenary")
    test_pairs_over_sheaves("swivels", "catenary")
    cases.assert_one_signature_per_kernel()


@pytest.mark.parametrize("lowest", [1.0, 0.2, 0.0])
def test_no_pose_is_lost_by_sag_or_by_wider_limits(lowest: float) -> None:
    """What straight lines hold with tensions from 2 N on, those that sag hold within wider limits."""
    robot, poses = parallelograms(4), np.full((50, 6), np.nan)
    poses[:, :3] = np.random.default_rng(5).uniform([-0.9, -0.9, 0.3], [0.9, 0.9, 2.0], (50, 3))
    narrow = cw.inverse(robot, poses, cable="elastic", tension_limits=(2.0, 100.0))
    assert narrow.ok.sum() > 10
    for cable in ("elastic", "catenary"):
        wide = cw.inverse(robot, poses, cable=cable, tension_limits=(lowest, 110.0))
        assert wide.ok[narrow.ok].all()
        np.testing.assert_allclose(wide[wide.ok].lengths[:, 1::2], wide[wide.ok].lengths[:, ::2], atol=1e-9)
