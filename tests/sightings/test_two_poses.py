"""The two poses in which a small flat tag appears nearly the same: pictures together find the right one of each."""

from __future__ import annotations

import numpy as np
from benchmarks.campaigns import tag_pictures
from benchmarks.campaigns.camera_rooms import seen
from numpy.typing import NDArray

import cablewright as cw
from cablewright.calibration.sightings.placing import _views, started
from cablewright.models.rotation import matrices

LENS = np.array([700.0, 700.0, 480.0, 360.0, 0.0, 0.0, 0.0, 0.0, 0.0])
CAMERA = cw.Camera(width=960, height=720, focal=(700.0, 700.0), principal=(480.0, 360.0))
SIZE, POSES = 0.11, 8  # m
LAYOUT = cw.TagLayout(
    tags=(cw.Tag(number=0, size=SIZE, at=(0.0, 0.0, 0.0), sigma=0.0, turn_sigma=0.0),), print_sigma=0.0
)
FACING = np.diag([1.0, -1.0, -1.0])


def off_by(rotation: NDArray[np.float64], true: NDArray[np.float64]) -> float:
    """The angle between two rotations (3, 3), rad."""
    return float(np.arccos(np.clip(0.5 * (np.trace(rotation.T @ true) - 1.0), -1.0, 1.0)))


def test_each_picture_of_one_small_tag_has_its_right_pose_or_is_left_out() -> None:
    doubtful, errors, robot = 0, [], cw.load("ipanema")
    for seed in range(6):
        rng, pictures, true, guess = np.random.default_rng(seed), [], [], np.zeros((POSES, 6))
        for pose in range(POSES):
            rotation = FACING @ matrices(rng.normal(0.0, 0.12, 3))
            guess[pose, :3] = rng.uniform(-0.8, 0.8), rng.uniform(-0.6, 0.6), rng.uniform(2.0, 2.7)
            shown = [tag_pictures.Tag(0, SIZE, guess[pose, :3], rotation)]
            grey = tag_pictures.picture(LENS, 960, 720, shown, rng)
            pictures.append(seen(grey, CAMERA, f"pose-{pose + 1}.png"))
            true.append(rotation)
        sightings = cw.Sightings(LAYOUT, CAMERA, tuple(pictures))
        doubtful += sum(len(views) == 2 for views in _views(sightings, mounted=True))
        found, _, bundle = started(sightings, robot, np.zeros((POSES, 8)), guess, "the data")
        read = [at for at, each in enumerate(pictures) if each.sightings]
        rotations = dict(zip(read, matrices(bundle.poses[:, 3:]), strict=True))
        errors += [off_by(rotations[at], true[at]) for at in read if (at, 0) not in found.left_out]
    assert doubtful >= 3
    assert len(errors) > 0.7 * POSES * 6
    assert max(errors) < 0.3  # the other pose is twice the angle to the line of sight away
