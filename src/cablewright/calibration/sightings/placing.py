"""Start values for fits with pictures: the platform's pose in each picture, and the camera's in the world.

A picture of tags whose positions are roughly known gives the pose of their frame in the camera's. Where no tag of the
room is visible, the camera's own position comes from the counts: lengths of straight lines from the positions in the
camera's frame are linear in each line's exit point, its home length and their squares.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from cablewright.calibration.sightings.bundle import Bundle, consistent
from cablewright.calibration.sightings.detection import Sighting
from cablewright.calibration.sightings.layout import Tag
from cablewright.calibration.sightings.sighted import Sightings, turned
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.models.rotation import matrices, placed, rotation_onto, turn_between
from cablewright.robot import Robot

_SQUARE: Final = np.array([[-1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [-1.0, -1.0, 0.0]])
_AMBIGUOUS: Final = 3.0  # errors of the second way to see a plane over those of the first, below which it may be right
_FLIPPED: Final = 0.35  # rad from the start to the fit of a picture, beyond which that is the other pose of a plane
_FAR: Final = 0.3  # of the frame's diagonal: max rms distance of exit points found by lengths from the file's
_LINEAR: Final = 6  # poses with which exit points follow from lengths
_FLAT: Final = 0.02  # of the largest extent of the positions: flatter ones do not determine exit points


def tag_corners(tag: Tag) -> Array:
    """Return the corners (4, 3) of a tag, m, in the frame of the platform or in the world."""
    return np.asarray(tag.at + 0.5 * tag.size * _SQUARE @ tag.axes.T)


def _views(seen: Sightings, mounted: bool) -> list[list[tuple[Array, Array]]]:
    """Return, for each picture, how the platform (or else the room) may be in the camera's frame, the likelier first.

    Each is a rotation (3, 3) and a place (3,). A plane seen from afar may be seen in two ways.
    """
    import cv2

    tags, made = (
        {tag.number: tag for tag in seen.layout.tags if tag.mounted == mounted},
        list[list[tuple[Array, Array]]](),
    )
    for picture in seen.pictures:
        shown: list[Sighting] = [] if picture is None else [one for one in picture.sightings if one.number in tags]
        if not shown:
            made.append([])
            continue
        points = np.concatenate([tag_corners(tags[one.number]) for one in shown])
        pixels = seen.camera.directions(np.concatenate([one.corners for one in shown]))
        flat = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[2] < 1e-3 * np.ptp(points, axis=0).max()
        how = cv2.SOLVEPNP_IPPE if flat else cv2.SOLVEPNP_SQPNP
        _, turns, places, errors = cv2.solvePnPGeneric(points, pixels[:, None], np.eye(3), None, flags=how)
        order = np.argsort(np.ravel(errors))
        views = [(matrices(turns[at].ravel()), places[at].ravel()) for at in order if places[at].ravel()[2] > 0.0]
        likely = [
            view for view, at in zip(views, order, strict=False) if np.ravel(errors)[at] < _AMBIGUOUS * np.min(errors)
        ]
        made.append(likely or views[:1])
    return made


def _chosen(views: list[list[tuple[Array, Array]]]) -> list[tuple[Array, Array] | None]:
    """Return one view of each picture: of two possible ones that whose rotation is nearer to those of the others."""
    sure = [each[0][0] for each in views if len(each) == 1] or [each[0][0] for each in views if each]
    found: list[tuple[Array, Array] | None] = []
    for each in views:
        fits = [sum(float(np.trace(one @ rotation.T)) for one in sure) for rotation, _ in each]
        found.append(each[int(np.argmax(fits))] if each else None)
    return found


def _vector(rotation: Array) -> Array:
    """Return the rotation vector (3,), rad, of a rotation (3, 3)."""
    import cv2

    return np.array(cv2.Rodrigues(rotation)[0], dtype=np.float64).ravel()


def in_own_frame(seen: Sightings) -> tuple[Sightings, Array, bool]:
    """Return sightings with a start of the camera, start poses (N, 6), and whether these are in the world.

    They are in the world by tags in the room; else in the camera's frame. NaN without a picture.
    """
    of_camera = seen.layout.camera == "platform"
    poses = np.full((len(seen.pictures), 6), np.nan)
    views = _chosen(_views(seen, mounted=not of_camera))
    room = [] if of_camera else _chosen(_views(seen, mounted=False))
    known = next((view for view in room if view is not None), None)
    rotation, place = np.eye(3), np.zeros(3)
    if of_camera:
        rotation, place = seen.layout.mount.rotation, np.array(seen.layout.mount.at)
    elif known is not None:
        rotation, place = known[0].T, -known[0].T @ known[1]
    for at, view in enumerate(views):
        if view is None:
            continue
        turn, where = view
        if of_camera:
            turn = turn.T @ rotation.T
            where = -view[0].T @ view[1] - turn @ place
        else:
            turn, where = rotation @ turn, rotation @ where + place
        poses[at] = np.append(where, _vector(turn))
    return replace(seen, place=place, rotation=rotation), poses, of_camera or known is not None


def camera_of_world(
    robot: Robot, counted: Array, poses: Array, guess: Array | None, origin: str
) -> tuple[Array, Array]:
    """Return rotation (3, 3) and position (3,) in the world of the frame of *poses* (N, 6).

    By start values of positions, *guess* (N, n), where there are three, else by the lengths *counted* (N, m). Raises
    `InputError` where neither is enough.
    """
    seen = np.isfinite(poses).all(axis=1)
    known = seen & (np.isfinite(guess).all(axis=1) if guess is not None else False)
    if known.sum() >= 3 and guess is not None:
        return _moved_onto(poses[known, :3], guess[known, :3])
    points = poses[seen, :3]
    extent = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    ask = "give start values x, y, z of three poses that are not on a line, or put a tag with a known place in the room"
    if len(points) < _LINEAR or extent[2] < _FLAT * extent[0]:
        raise InputError(
            f"{origin}: {len(points)} poses with pictures are too few, or in a plane, to find the camera; {ask}"
        )
    arms, exits = placed(poses[seen], [line.platform_point for line in robot.lines]), []
    for at, line in enumerate(robot.lines):
        p, count = arms[:, at], counted[seen, at] / line.advantage
        rows = np.column_stack([2.0 * p, 2.0 * count, np.ones(len(p))])
        exits.append(np.linalg.lstsq(rows, np.sum(p * p, axis=1) - count**2, rcond=None)[0][:3])
    file = np.array([line.exit_point for line in robot.lines])
    rotation, place = _moved_onto(np.array(exits), file)
    off = float(np.sqrt(np.mean(np.sum((np.array(exits) @ rotation.T + place - file) ** 2, axis=1))))
    if off > _FAR * float(np.linalg.norm(np.subtract(robot.scene.frame_max, robot.scene.frame_min))):
        raise InputError(
            f"{origin}: lengths and pictures put exit points {off:.3g} m from the file's; check lines; {ask}"
        )
    return rotation, place


def _moved_onto(points: Array, others: Array) -> tuple[Array, Array]:
    """Return the rotation (3, 3) and the translation (3,) that move *points* (k, 3) nearest to *others*."""
    rotation = rotation_onto(points, others)
    return rotation, others.mean(axis=0) - rotation @ points.mean(axis=0)


def started(
    seen: Sightings, robot: Robot, counted: Array, guess: Array | None, origin: str
) -> tuple[Sightings, Array, Bundle]:
    """Return sightings that agree with each other, with a start of the camera, and start values (N, 6) of the poses.

    Poses without a picture keep their *guess* (N, n), or are NaN. The bundle is that of the pictures by themselves.
    Raises `InputError` for pictures without tags of the layout, and as `camera_of_world`.
    """
    seen, poses, in_world = in_own_frame(seen.at_exits(robot))
    pictured = np.asarray(np.isfinite(poses).all(axis=1))
    if not pictured.any():
        reasons = [word for picture in seen.pictures if picture is not None for word in picture.left_out]
        raise InputError(f"{origin}: no picture shows a tag of the layout that can be used: {'; '.join(reasons[:3])}")
    room = [tag for tag in seen.tags if tag.mounted == (seen.layout.camera == "platform")]
    agreed, bundle = consistent(seen.only(pictured), poses[pictured], bool(room))
    which = np.flatnonzero(pictured).tolist()
    out = frozenset((which[at], number) for at, number in agreed.left_out) | _flipped(
        seen, poses[pictured], bundle, which
    )
    poses[pictured] = bundle.poses
    if room:  # the camera's place is among the unknowns, its numbers first
        agreed = replace(agreed, place=bundle.theta[:3], rotation=turned(seen.rotation, bundle.theta[3:6]))
    seen = replace(agreed, pictures=seen.pictures, left_out=out)
    if not in_world:
        rotation, place = camera_of_world(robot, counted, poses, guess, origin)
        poses[:, :3] = poses[:, :3] @ rotation.T + place
        vector = _vector(rotation)
        poses[pictured, 3:] = turn_between(-poses[pictured, 3:], np.tile(vector, (int(pictured.sum()), 1)))
        seen = replace(seen, place=rotation @ seen.place + place, rotation=rotation @ seen.rotation)
    if guess is not None:
        full = np.zeros((len(poses), 6))
        full[:, : guess.shape[1]] = guess
        poses = np.where(pictured[:, None], poses, np.where(np.isfinite(guess[:, :1]), full, np.nan))
    return seen, poses, bundle


def _flipped(seen: Sightings, begun: Array, bundle: Bundle, which: list[int]) -> frozenset[tuple[int, int]]:
    """Return the sightings, by pose and tag, of pictures that were fitted with the wrong one of two possible poses.

    The tags fit there, by noise, no worse than at the pose that agrees with the other pictures, where they *begun*
    (N, 6). *which*: the pose of each of these.
    """
    away = np.linalg.norm(turn_between(begun[:, 3:], bundle.poses[:, 3:]), axis=1)
    shown = ((which[at], seen.pictures[which[at]]) for at in np.flatnonzero(away > np.median(away) + _FLIPPED).tolist())
    return frozenset((pose, one.number) for pose, picture in shown if picture for one in picture.sightings)


def words_of(seen: Sightings) -> Iterator[str]:
    """Yield sentences on the pictures: tags that moved, and sightings that are left out, by picture."""
    for number in seen.moved:
        yield f"tag {number} is not where the layout has it: its place is taken from the pictures"
    for at, picture in enumerate(seen.pictures):
        if picture is not None:
            reasons = [
                *picture.left_out,
                *(f"tag {tag}: does not fit the others" for pose, tag in sorted(seen.left_out) if pose == at),
            ]
            if reasons:
                yield f"{picture.path.name}: left out: {'; '.join(reasons)}"
