"""Sightings of tags as equations: camera and tags (bodies), their unknown numbers, and prior knowledge.

Unknown are the camera's position, its lens and the positions of tags as far as they have a standard deviation, and the
size of the print, one number for all tags.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.calibration.sightings.camera import LENS, Camera
from cablewright.calibration.sightings.detection import EDGES, SeenPicture
from cablewright.calibration.sightings.layout import Tag, TagLayout
from cablewright.calibration.unknowns import Unknown
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.units import ANGLE, LENGTH, Dimension
from cablewright.kernels.fitting import sighting
from cablewright.kernels.rotation import left_jacobian
from cablewright.models.rotation import matrices
from cablewright.robot import PointPlatform, RigidPlatform, Robot
from cablewright.robot.parameter_values import AXES, Kind

CAMERA: Final = "camera"
_PRINT: Final = "print"
_ANYWHERE: Final = 1e3  # m: max distance of a camera, or of a tag, from where it starts
_TURNED: Final = 2.5  # rad: max turn of either
_SCALED: Final = 0.5  # of a focal length, and of the size of a print: max change
_BENT: Final = 20.0  # max change of a number of a distortion
_RELEASED: Final = (10.0, 3.0)  # m, rad: standard deviations of a tag that moved


def _kinds(base: str, dimension: Dimension | None, unit: str, *names: str) -> Iterator[tuple[str, Kind]]:
    for name in names:
        yield name, Kind(name, dimension, "platform", base, role="sensor", nominal=0.0, plain_unit=unit)


_KINDS: Final[dict[str, Kind]] = dict(
    pair
    for what in (CAMERA, "tag")
    for pair in (
        *_kinds(f"place of a {what}", LENGTH, "", *(f"{what}_place.{axis}" for axis in AXES)),
        *_kinds(f"turn of a {what} from its start", ANGLE, "", *(f"{what}_turn.{axis}" for axis in AXES)),
    )
) | dict([*_kinds("lens", None, "px", *LENS[:4]), *_kinds("lens", None, "1", *LENS[4:], "print_scale")])
"""The kinds of unknowns that pictures bring."""


@dataclass(frozen=True)
class SightedUnknown(Unknown):
    """An unknown of the camera, of a tag or of the print: start value and range, over its scale."""

    start: float = 0.0
    low: float = 0.0
    high: float = 0.0

    def __post_init__(self) -> None:
        """Accept kinds that are of no robot."""

    @property
    def entry(self) -> Kind:
        """The kind of this unknown in the table of unknowns of pictures."""
        return _KINDS[self.kind]

    @property
    def label(self) -> str:
        """The name for people: "camera place x", "tag place z of tag 3"."""
        words = self.kind.replace("_", " ").replace(".", " ")
        return words if self.line in (CAMERA, _PRINT) else f"{words} of {self.line}"


class Bodies(NamedTuple):
    """Camera and tags as the kernel takes them, b of them, and rows (q, k + s) that are linear in all unknowns."""

    table: Array  # (b, BODY_COLUMNS)
    target: NDArray[np.int64]  # (b, NUMBERS)
    unknowns: tuple[SightedUnknown, ...]  # (s,), after the k of the robot
    linear: Array
    wanted: Array  # (q,)
    tags: tuple[Tag, ...]  # (b - 1,)
    of_tag: NDArray[np.int64]  # (q,): the tag of each row, -1 of none


@dataclass(frozen=True, eq=False)
class Sightings:
    """The pictures of N poses, None where there is none, by one camera of tags in a layout.

    ``place``, ``rotation``: where fits start with the camera, in the world or on the platform. ``moved``: numbers of
    tags whose stated position is wrong. ``left_out``: sightings, by pose and number of the tag, that do not count.
    """

    layout: TagLayout
    camera: Camera
    pictures: tuple[SeenPicture | None, ...]
    place: Array = field(default_factory=lambda: np.zeros(3))  # (3,) m
    rotation: Array = field(default_factory=lambda: np.eye(3))  # (3, 3)
    moved: tuple[int, ...] = ()
    left_out: frozenset[tuple[int, int]] = frozenset()
    platform: PointPlatform | RigidPlatform | None = None  # the file's, where the pictures show a body instead
    offsets: Mapping[int, Array] = field(
        default_factory=dict
    )  # from exit points to their tags (3,), by number, m, world

    def at_exits(self, robot: Robot) -> Sightings:
        """Return the sightings with tags that are on exit points where those of *robot*'s file have them.

        Raises `InputError` for a line that it does not have.
        """
        lines, tags, offsets = {line.name: line for line in robot.lines}, list[Tag](), dict(self.offsets)
        for tag in self.layout.tags:
            if tag.line is not None and tag.number not in offsets:
                if tag.line not in lines:
                    raise InputError(f"tags: tag {tag.number}: {UnknownName('line', tag.line, list(lines))}")
                offsets[tag.number] = np.array(tag.at)
                at = np.add(lines[tag.line].exit_point, tag.at).tolist()
                tag = tag.model_copy(update={"at": tuple(at)})
            tags.append(tag)
        return replace(self, layout=self.layout.model_copy(update={"tags": tuple(tags)}), offsets=offsets)

    def only(self, poses: Mask) -> Sightings:
        """Return the sightings at some *poses* (N,)."""
        kept = np.flatnonzero(poses).tolist()
        out = frozenset((kept.index(pose), tag) for pose, tag in self.left_out if pose in kept)
        return replace(self, pictures=tuple(self.pictures[at] for at in kept), left_out=out)

    @property
    def tags(self) -> tuple[Tag, ...]:
        """The tags of the layout that at least one picture shows."""
        shown = {each.number for picture in self.pictures if picture for each in picture.sightings}
        return tuple(tag for tag in self.layout.tags if tag.number in shown)

    @property
    def counts(self) -> NDArray[np.int64]:
        """The number (N,) of tags seen at each pose."""
        shown = [[] if picture is None else picture.sightings for picture in self.pictures]
        return np.array([sum((at, one.number) not in self.left_out for one in each) for at, each in enumerate(shown)])

    def rows(self) -> Iterator[tuple[int, Array, Array, Array]]:
        """Yield tag index, values (N, 8), weights (N, 8) and extras (N, 8, 6) of each tag's edges."""
        for index, tag in enumerate(self.tags):
            values, weights = np.zeros((2, len(self.pictures), EDGES))
            extras = np.zeros((len(self.pictures), EDGES, 6))
            for at, picture in enumerate(self.pictures):
                for seen in [] if picture is None else picture.sightings:
                    if seen.number == tag.number:
                        values[at], extras[at, :, 0] = seen.values, np.repeat(np.arange(4), 2)
                        extras[at, :, 1], extras[at, :, 2:4] = (
                            np.tile([1.0, -1.0], 4),
                            np.repeat(seen.normals, 2, axis=0),
                        )
                        if (at, tag.number) not in self.left_out:
                            weights[at] = 1.0 / seen.sigmas
            yield index, values, weights, extras

    def bodies(self, known: Sequence[Unknown] = (), free_camera: bool = True) -> Bodies:
        """Return camera and tags beside the unknowns *known* (k,) of a robot, none for pictures alone.

        *free_camera*: whether the camera's position is unknown.
        """
        tags, made = self.tags, list[SightedUnknown]()
        table = np.zeros((1 + len(tags), sighting.BODY_COLUMNS))
        target = np.full((len(table), sighting.NUMBERS), -1, dtype=np.int64)
        rows = list[tuple[dict[int, float], float, int]]()
        exit_of = {(each.kind, each.line): at for at, each in enumerate(known)}

        def add(body: int, column: int, kind: str, owner: str, start: float, reach: float, size: float = 1.0) -> int:
            """Make a number of the camera or of a tag unknown, up to *reach* from its start; returns its index."""
            made.append(SightedUnknown(kind, owner, size, start=start, low=start - reach, high=start + reach))
            target[body, column] = len(known) + len(made) - 1
            return len(known) + len(made) - 1

        unit = self.camera.focal[0]
        table[0, sighting.LENS : sighting.PRINT] = self.camera.lens / np.repeat([unit, 1.0], [4, 5])
        table[0, [sighting.PRINT, sighting.UNIT]] = 1.0, unit
        table[0, : sighting.TURN], table[0, sighting.MOUNTED] = self.place, float(self.layout.camera == "platform")
        table[0, sighting.BASE : sighting.HALF] = self.rotation.ravel()
        if free_camera:
            for at, axis in enumerate(AXES):
                add(0, at, f"camera_place.{axis}", CAMERA, float(self.place[at]), _ANYWHERE)
            for at, axis in enumerate(AXES):
                add(0, sighting.TURN + at, f"camera_turn.{axis}", CAMERA, 0.0, _TURNED)
        rows += [(each, value, -1) for each, value in self._lens(add)]
        if self.layout.print_sigma and tags:
            scale = add(1, sighting.PRINT, "print_scale", _PRINT, 1.0, _SCALED)
            target[1:, sighting.PRINT] = scale
            rows.append(({scale: 1.0 / self.layout.print_sigma}, 1.0 / self.layout.print_sigma, -1))
        for body, tag in enumerate(tags, 1):
            table[body, [sighting.HALF, sighting.PRINT, sighting.MOUNTED]] = 0.5 * tag.size, 1.0, float(tag.mounted)
            table[body, sighting.BASE : sighting.HALF] = tag.axes.ravel()
            table[body, : sighting.TURN] = tag.at
            sigma, turn = _RELEASED if tag.number in self.moved else (tag.sigma, tag.turn_sigma)
            exits = [exit_of.get((f"exit_point.{axis}", tag.line)) for axis in AXES]
            if tag.line is not None and not known:  # pictures alone: the exit point is unknown
                sigma = _RELEASED[0]
            for at, axis in enumerate(AXES if sigma else ""):
                start, by = float(table[body, at]), dict[int, float]()
                one = add(body, at, f"tag_place.{axis}", f"tag {tag.number}", start, _ANYWHERE)
                if (index := exits[at]) is not None:
                    start, by = float(self.offsets[tag.number][at]), {index: -1.0 / sigma}
                rows.append(({one: 1.0 / sigma} | by, start / sigma, body - 1))
            for at, axis in enumerate(AXES if turn else ""):
                one = add(body, sighting.TURN + at, f"tag_turn.{axis}", f"tag {tag.number}", 0.0, _TURNED)
                rows.append(({one: 1.0 / turn}, 0.0, body - 1))
        linear = np.zeros((len(rows), len(known) + len(made)))
        for at, (by, _, _) in enumerate(rows):
            linear[at, list(by)] = list(by.values())
        owners = np.array([owner for _, _, owner in rows], dtype=np.int64)
        return Bodies(table, target, tuple(made), linear, np.array([each[1] for each in rows]), tags, owners)

    def _lens(self, add: Any) -> Iterator[tuple[dict[int, float], float]]:
        """Yield the rows of the prior knowledge of the lens; *add*: see `bodies`."""
        lens, spread = self.camera.lens, self.camera.spread
        free = np.flatnonzero(np.diag(spread) > 0.0)
        if not len(free):
            return
        sizes = np.where(free < 4, self.camera.focal[0], 1.0)
        numbers = zip(free.tolist(), (lens[free] / sizes).tolist(), sizes.tolist(), strict=True)
        ids = [
            add(0, sighting.LENS + at, LENS[at], CAMERA, value, _BENT if at > 3 else _SCALED, size)
            for at, value, size in numbers
        ]
        sigmas = np.sqrt(np.diag(spread)[free])
        whiten = np.linalg.inv(np.linalg.cholesky(spread[np.ix_(free, free)] / np.outer(sigmas, sigmas))) / sigmas
        for row, value in zip(whiten * sizes, whiten @ lens[free], strict=True):
            yield dict(zip(ids, row.tolist(), strict=True)), float(value)


def bodies_of(seen: Sightings | None, known: Sequence[Unknown]) -> Bodies:
    """Return camera and tags, or none, beside the unknowns *known* (k,) of a robot; see `Sightings.bodies`."""
    if seen is not None:
        return seen.bodies(known)
    table, linear = np.zeros((0, sighting.BODY_COLUMNS)), np.zeros((0, len(known)))
    target, of_tag = np.zeros((0, sighting.NUMBERS), dtype=np.int64), np.zeros(0, dtype=np.int64)
    return Bodies(table, target, (), linear, np.zeros(0), (), of_tag)


def turned(rotation: Array, turn: Array) -> Array:
    """Return the rotation (3, 3) after one more rotation, the vector *turn* (3,), rad, about axes that turn with it."""
    return np.asarray(matrices(turn) @ rotation)


def motions_of(target: NDArray[np.int64], bodies: Array, count: int) -> Array:
    """Return how *count* unknowns (2, 6, k) change as the frame of the world, or the platform's, moves.

    Cameras and tags move with it: along x, y and z, then about axes through the origin. *target*, *bodies*: see
    `Bodies`, at the present unknowns.
    """
    made = np.zeros((2, 6, count))
    for own, body in zip(target, bodies, strict=True):
        frame = made[int(body[sighting.MOUNTED])]
        turn = np.zeros((3, 3))
        left_jacobian(body[sighting.TURN : sighting.LENS], turn)
        back = np.linalg.inv(turn)
        for axis, along in enumerate(np.eye(3)):
            about = np.append(np.cross(along, body[: sighting.TURN]), back @ along)
            for at in np.flatnonzero(own[: sighting.LENS] >= 0).tolist():
                frame[axis, own[at]] = float(at == axis)
                frame[3 + axis, own[at]] = about[at]
    return made
