"""Rooms with a robot, tags and a camera, from which a calibration's data are made: counts, and pictures from pixels.

The true robot differs from the file, the tags are off their stated places, and the camera's file has its own errors.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import cablewright as cw
from benchmarks.campaigns import tag_pictures
from cablewright.calibration.poses.simulation import measure, random_poses
from cablewright.calibration.sightings.detection import SeenPicture, Sighting, detected, in_light, measured
from cablewright.calibration.sightings.layout import TagMount
from cablewright.calibration.sightings.sighted import Sightings
from cablewright.models.rotation import matrices
from cablewright.models.statics import Model

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Setup:
    """A set-up: the camera in the room or on the platform, its picture, the tags, and what is wrong."""

    camera: str = "room"
    at: tuple[float, float, float] = (3.2, -2.6, 1.4)  # m, of a camera in the room
    width: int = 1280
    height: int = 720
    focal: float = 1000.0  # px
    size: float = 0.2  # m, of a tag
    exits: int = 0  # lines with a tag below the exit point
    floor: int = 0  # tags on the floor, whose places are surveyed
    poses: int = 14
    encoder: float = 5e-4  # m
    tag_sigma: float = 1e-3  # m, of places on the platform
    floor_sigma: float = 1e-3  # m
    focal_error: float = 0.0  # share, beside that of the camera's covariance
    focal_sigma: float = 4e-3  # share
    print_scale: float = 1.0
    moved: int = -1  # a tag that is 22 mm away from where it should be
    rough: float = 0.03  # m, of the file's exit points
    flaws: tag_pictures.Flaws = field(default_factory=tag_pictures.Flaws)


@dataclass(frozen=True)
class Room:
    """A true robot, what was measured of it, its poses (N, 6) and the true places of its tags by number."""

    robot: cw.Robot
    data: cw.Measured
    poses: Array
    tags: dict[int, tuple[Array, Array]]
    lens: Array
    camera: tuple[Array, Array]  # place and rotation, in the world or on the platform


def room(robot: cw.Robot, setup: Setup, seed: int, pixels: bool = True) -> Room:
    """Return a room drawn with a *seed*; *pixels*: whether pictures are taken, else there are none."""
    rng = np.random.default_rng(seed)
    lines = [
        line.model_copy(update={"exit_point": tuple((line.exit_point + rng.uniform(-1, 1, 3) * setup.rough).tolist())})
        for line in robot.lines
    ]
    true = cw.Robot.model_validate(robot.model_copy(update={"lines": tuple(lines)}).model_dump())
    poses = random_poses(Model.of(true), setup.poses, rng)
    made = measure(true, poses, setup.encoder, rng)
    full = np.zeros((setup.poses, 6))
    full[:, : robot.n] = poses
    if robot.n == 3:  # what hangs on a point swings and turns a little
        full[:, 3:] = rng.normal(0.0, 0.03, (setup.poses, 3))
    return _seen(true, made.measured, full, setup, rng, pixels)


def layout_of(robot: cw.Robot, setup: Setup, middle: Array) -> tuple[cw.TagLayout, Array, Array]:
    """Return the layout, and place and rotation of the camera, in the world or on the platform."""
    low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    if setup.camera == "platform":
        across, along = (np.linspace(low[axis], high[axis], 2 * count + 1)[1::2] for axis, count in ((0, 5), (1, 4)))
        spots = [(x, y) for x in across for y in along]
        tags = [
            cw.Tag(
                number=at,
                size=setup.size,
                on="room",
                at=(*spot, float(low[2])),
                sigma=setup.floor_sigma,
                turn_sigma=0.005,
            )
            for at, spot in enumerate(spots)
        ]
        return cw.TagLayout(camera="platform", tags=tuple(tags)), np.array([0.02, -0.01, -0.05]), TagMount().rotation
    at = np.array(setup.at)
    view = (middle - at) / np.linalg.norm(middle - at)
    x = np.cross(view, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    rotation = np.column_stack([x, np.cross(view, x), view])
    ahead = -view * [1.0, 1.0, 0.0]
    ahead /= np.linalg.norm(ahead)
    side = np.cross([0.0, 0.0, 1.0], ahead)
    up = np.array([0.0, 0.0, 1.0])
    places = [0.15 * ahead + 0.28 * side, 0.15 * ahead - 0.28 * side, 0.28 * up, 0.25 * ahead - 0.24 * up]
    normals = [ahead + 0.5 * side, ahead - 0.5 * side, ahead + 0.6 * up, ahead]
    tags = [
        cw.Tag(number=k, size=setup.size, at=tuple(p), normal=tuple(n), up=(0.0, 0.0, 1.0), sigma=setup.tag_sigma)
        for k, (p, n) in enumerate(zip(places, normals, strict=True))
    ]
    for k in range(setup.floor):
        spot = 0.5 * (low + high) + 0.25 * (high - low) * [np.cos(2.1 * k), np.sin(2.1 * k), 0.0]
        spot[2] = low[2]
        tags.append(
            cw.Tag(
                number=20 + k,
                size=1.5 * setup.size,
                on="room",
                at=tuple(spot),
                sigma=setup.floor_sigma,
                turn_sigma=0.005,
            )
        )
    for k, line in enumerate(robot.lines[: setup.exits]):
        x, y, _ = (at - line.exit_point).tolist()
        tags.append(
            cw.Tag(
                number=40 + k,
                size=setup.size,
                on="exit",
                line=line.name,
                at=(0.0, 0.0, -0.2),
                normal=(x, y, 0.0),
                up=(0.0, 0.0, 1.0),
                sigma=setup.tag_sigma,
            )
        )
    return cw.TagLayout(tags=tuple(tags)), at, rotation


def _seen(
    true: cw.Robot, data: cw.Measured, poses: Array, setup: Setup, rng: np.random.Generator, pixels: bool
) -> Room:
    focal, lens = setup.focal, np.zeros(9)
    lens[:] = focal, focal, setup.width / 2 + 3.0, setup.height / 2 - 4.0, -0.08, 0.03, 5e-4, -4e-4, 0.0
    layout, place, rotation = layout_of(true, setup, poses[:, :3].mean(axis=0))
    tags = {}
    exit_of = {line.name: np.array(line.exit_point) for line in true.lines}
    for tag in layout.tags:
        off = (
            exit_of.get(tag.line or "", np.zeros(3))
            + rng.normal(0.0, tag.sigma, 3)
            + (np.array([0.018, 0.0, -0.012]) if tag.number == setup.moved else 0.0)
        )
        tags[tag.number] = (
            np.array(tag.at) + off,
            matrices(rng.normal(0.0, 0.5 * tag.turn_sigma, 3)) @ tag.axes,
        )
    sigmas = np.array([setup.focal_sigma * focal] * 2 + [0.003 * focal] * 2 + [3e-3, 3e-3, 3e-4, 3e-4, 0.0])
    draw = sigmas * rng.normal(0.0, 1.0, 9)
    draw[1] = draw[0]
    spread = np.diag(sigmas**2)
    spread[0, 1] = spread[1, 0] = 0.999 * sigmas[0] ** 2
    told = (lens + draw) * np.repeat([1.0 + setup.focal_error, 1.0], [2, 7])
    camera = cw.Camera(
        width=setup.width, height=setup.height,
        focal=tuple(told[:2]), principal=tuple(told[2:4]), distortion=tuple(told[4:]),
        covariance=tuple(tuple(spread[at, : at + 1]) for at in range(9)),
    )  # fmt: skip
    pictures: list[SeenPicture | None] = []
    for at, pose in enumerate(poses if pixels else []):
        shown = _shown(layout, setup, tags, pose, (place, rotation))
        grey = tag_pictures.picture(lens, setup.width, setup.height, shown, rng, setup.flaws)
        pictures.append(seen(grey, camera, f"pose-{at + 1:02d}.png"))
    sightings = Sightings(layout, camera, tuple(pictures) if pixels else (None,) * len(poses))
    return Room(true, replace(data, guess=None, sightings=sightings), poses, tags, lens, (place, rotation))


def _shown(
    layout: cw.TagLayout,
    setup: Setup,
    tags: dict[int, tuple[Array, Array]],
    pose: Array,
    camera: tuple[Array, Array],
) -> list[tag_pictures.Tag]:
    """Return the tags in the frame of the camera at a *pose* (6,)."""
    return [
        tag_pictures.Tag(
            tag.number,
            setup.print_scale * tag.size,
            *in_camera(tag.mounted, *tags[tag.number], pose, layout, *camera),
        )
        for tag in layout.tags
    ]


def in_camera(
    mounted: bool, place: Array, rotation: Array, pose: Array, layout: cw.TagLayout, at: Array, looks: Array
) -> tuple[Array, Array]:
    """Return place and rotation of a tag in the frame of the camera, at a *pose* (6,) of the platform."""
    turn = matrices(pose[3:])
    if mounted:
        place, rotation = pose[:3] + turn @ place, turn @ rotation
    if layout.camera == "platform":
        at, looks = pose[:3] + turn @ at, turn @ looks
    return looks.T @ (place - at), looks.T @ rotation


def seen(grey: NDArray[np.uint8], camera: cw.Camera, name: str) -> SeenPicture:
    """Return what grey levels show to the detection, without a file."""
    found = [measured(in_light(grey), camera, number, corners) for number, corners in detected(grey.astype(float))]
    sightings = tuple(each for each in found if isinstance(each, Sighting))
    return SeenPicture(Path(name), sightings, tuple(each for each in found if isinstance(each, str)))


def later(before: Room, setup: Setup, seed: int, bump: float = 0.0) -> tuple[Room, str]:
    """Return three more poses of a room, with the same home and tags, and the line whose exit point moved by *bump*, m.

    The camera stands elsewhere, by some centimetres and degrees.
    """
    rng = np.random.default_rng(seed)
    at = int(rng.integers(before.robot.m))
    way = rng.normal(size=3)
    lines = list(before.robot.lines)
    moved = lines[at].exit_point + bump * way / np.linalg.norm(way)
    lines[at] = lines[at].model_copy(update={"exit_point": tuple(moved.tolist())})
    robot = cw.Robot.model_validate(before.robot.model_copy(update={"lines": tuple(lines)}).model_dump())
    n = robot.n
    poses = random_poses(Model.of(before.robot), 3, rng)
    every = np.concatenate([before.poses[:1, :n], poses])
    home = measure(before.robot, every, 0.0, rng).home_lengths
    made = measure(robot, every, setup.encoder, rng)
    counted = made.measured.counted[1:] + (made.home_lengths - home)  # the counts are from the old home
    full = np.zeros((3, 6))
    full[:, :n] = poses
    data = replace(made.measured.only(np.array([False, True, True, True])), counted=counted, guess=None)
    place, rotation = before.camera
    camera = place + rng.normal(0.0, 0.05, 3), matrices(rng.normal(0.0, 0.03, 3)) @ rotation
    seen_of = before.data.sightings
    assert seen_of is not None
    pictures: list[SeenPicture | None] = []
    shift = moved - before.robot.lines[at].exit_point
    of_line = {tag.number for tag in seen_of.layout.tags if tag.line == robot.lines[at].name}
    tags = {number: (p + shift * (number in of_line), turn) for number, (p, turn) in before.tags.items()}
    for pose in full:
        shown = _shown(seen_of.layout, setup, tags, pose, camera)
        grey = tag_pictures.picture(before.lens, setup.width, setup.height, shown, rng, setup.flaws)
        pictures.append(seen(grey, seen_of.camera, f"later-{len(pictures) + 1}.png"))
    sightings = Sightings(seen_of.layout, seen_of.camera, tuple(pictures))
    return Room(robot, replace(data, sightings=sightings), full, before.tags, before.lens, camera), robot.lines[at].name


def exit_errors(true: cw.Robot, found: cw.Robot, own_frame: bool) -> Array:
    """Return the errors (m, 3) of exit points, m; *own_frame*: after the best motion onto the true ones."""
    exits, there = (np.array([line.exit_point for line in each.lines]) for each in (found, true))
    return (cw.aligned(exits, there, tilt=True)[0] if own_frame else exits) - there
