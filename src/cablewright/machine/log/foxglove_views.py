"""Views of a log for Foxglove: frames (/tf) and a scene (/scene). No reader of this package needs them.

Lines are straight here, from the exit point to the platform: a log knows no sag. The scene shows the truth where the
log has it, and else the estimate.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from typing import Any, Final

import numpy as np
from pydantic_core import to_json

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Estimate, PrintState, Progress, Truth
from cablewright.machine.log.fields import FLAG, NUMBER, TEXT, WHOLE_NUMBER, XYZ, XYZW, array_schema, object_schema
from cablewright.machine.log.head import LogHead
from cablewright.machine.sensors.lidars import LidarSettings
from cablewright.models.rotation import matrix_of, placed

EVERY: Final = 0.1
"""Time between two messages of a topic, s."""

_STEP: Final = 5e-3  # m between points of the path
_MOST: Final = 200  # points of one piece of the path
_TIME: Final = object_schema(sec=WHOLE_NUMBER.schema, nsec=WHOLE_NUMBER.schema)
_TRANSFORM: Final = object_schema(
    timestamp=_TIME,
    parent_frame_id=TEXT.schema,
    child_frame_id=TEXT.schema,
    translation=XYZ.schema,
    rotation=XYZW.schema,
)
_POSE: Final = object_schema(position=XYZ.schema, orientation=XYZW.schema)
_COLOUR: Final = object_schema(**dict.fromkeys("rgba", NUMBER.schema))
_SHAPE: Final = object_schema(
    pose=_POSE, size=XYZ.schema, color=_COLOUR, bottom_scale=NUMBER.schema, top_scale=NUMBER.schema
)
_LINE: Final = object_schema(
    type=WHOLE_NUMBER.schema,
    pose=_POSE,
    thickness=NUMBER.schema,
    scale_invariant=FLAG.schema,
    points=array_schema(XYZ.schema),
    color=_COLOUR,
    colors=array_schema(_COLOUR),
    indices=array_schema(WHOLE_NUMBER.schema),
)
_TEXT: Final = object_schema(
    pose=_POSE,
    billboard=FLAG.schema,
    font_size=NUMBER.schema,
    scale_invariant=FLAG.schema,
    color=_COLOUR,
    text=TEXT.schema,
)
_ENTITY: Final = object_schema(
    timestamp=_TIME,
    frame_id=TEXT.schema,
    id=TEXT.schema,
    lifetime=_TIME,
    frame_locked=FLAG.schema,
    metadata=array_schema(object_schema(key=TEXT.schema, value=TEXT.schema)),
    **{name: array_schema(_SHAPE) for name in ("arrows", "cubes", "spheres", "cylinders", "triangles", "models")},
    lines=array_schema(_LINE),
    texts=array_schema(_TEXT),
)

VIEWS: Final = {
    "/tf": ("foxglove.FrameTransforms", object_schema(transforms=array_schema(_TRANSFORM))),
    "/scene": (
        "foxglove.SceneUpdate",
        object_schema(
            deletions=array_schema(object_schema(timestamp=_TIME, type=WHOLE_NUMBER.schema, id=TEXT.schema)),
            entities=array_schema(_ENTITY),
        ),
    ),
}
"""Name and JSON schema of the messages of each topic."""

_LINE_STRIP, _LINE_LIST = 0, 2
_INK, _GREY = (0.11, 0.14, 0.19, 1.0), (0.54, 0.58, 0.63, 1.0)
_SAND = (0.69, 0.55, 0.34, 0.6)
_BLUE, _ORANGE = (0.0, 0.45, 0.7, 1.0), (0.9, 0.62, 0.0, 1.0)
_NEVER: Final = {"sec": 0, "nsec": 0}
_SHAPES: Final = ("arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models")
_EMPTY: Final[dict[str, Any]] = {key: [] for key in ("metadata", *_SHAPES)}
_UNTURNED: Final = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
_EDGES: Final = tuple((a, b) for a in range(8) for b in range(a + 1, 8) if (a ^ b) in (1, 2, 4))


class Views:
    """Generator of the Foxglove messages of one log, in the order of its steps."""

    def __init__(self, head: LogHead) -> None:
        """For the robot and machine of *head*."""
        self._head, self._robot = head, head.robot
        self._epoch = head.epoch_ns
        self._due = -np.inf
        self._begun = False
        self._nozzle = np.array(head.nozzle)
        self._points = np.array([line.platform_point for line in head.robot.lines])
        self._exits = [_xyz(line.exit_point) for line in head.robot.lines]
        self._lidars = [_mounted(name, lidar) for name, lidar in head.settings.lidars.items()]
        self._line = _line(_LINE_LIST, (), _BLUE, 2.0)
        self._path: list[dict[str, float]] = []
        self._last = np.full(3, np.inf)  # m, where the path ends
        self._since = 0.0  # s, at the first point of the path's last piece

    def messages(
        self, time: float, truth: Truth | None, estimate: Estimate | None, progress: Progress | None
    ) -> Iterator[tuple[str, bytes]]:
        """Yield topic and JSON of the Foxglove messages due at *time*, s; nothing while no pose is known."""
        for topic, content in self.content(time, truth, estimate, progress):
            yield topic, to_json(content)

    def content(
        self, time: float, truth: Truth | None, estimate: Estimate | None, progress: Progress | None
    ) -> Iterator[tuple[str, dict[str, Any]]]:
        """Yield topic and content of the Foxglove messages due at *time*, s; nothing while no pose is known."""
        if time < self._due - 1e-9:
            return
        told = estimate if estimate is not None and estimate.valid else None
        shown = truth if truth is not None else told
        if shown is None or not _is_known(shown.position):
            return
        self._due = time + EVERY
        stamp = self._stamp(time)
        yield "/tf", {"transforms": list(self._transforms(stamp, truth, told))}
        yield "/scene", {"deletions": [], "entities": list(self._entities(stamp, shown, progress))}

    def _stamp(self, time: float) -> dict[str, int]:
        sec, nsec = divmod(self._epoch + round(time * 1e9), 1_000_000_000)
        return {"sec": sec, "nsec": nsec}

    def _transforms(
        self, stamp: dict[str, int], truth: Truth | None, told: Estimate | None
    ) -> Iterator[dict[str, Any]]:
        first, second = (truth, told) if truth is not None else (told, None)
        for each, frame in ((first, "drum"), (second, "drum_estimate")):
            if each is not None and _is_known(each.position):
                yield _transform(stamp, "world", frame, each.position, _turn(each))
        for lidar in self._lidars:
            yield lidar | {"timestamp": stamp}

    def _entities(
        self, stamp: dict[str, int], shown: Truth | Estimate, progress: Progress | None
    ) -> Iterator[dict[str, Any]]:
        if not self._begun:
            self._begun = True
            yield self._frame(stamp)
            yield self._platform(stamp)
        yield self._lines(stamp, shown)
        if progress is not None and progress.state is PrintState.PRINTING:
            turn = matrix_of(_turn(shown))
            yield from self._gone(stamp, shown.time, shown.position + turn @ self._nozzle)

    def _frame(self, stamp: dict[str, int]) -> dict[str, Any]:
        """Edges of the frame, beams, walls and exit points with their names."""
        low, high = (np.array(each) for each in (self._robot.scene.frame_min, self._robot.scene.frame_max))
        corners = [np.where([k & 4, k & 2, k & 1], high, low) for k in range(8)]
        points = [corners[k] for edge in _EDGES for k in edge]
        for beam in self._robot.scene.beams:
            points += [np.array(beam.start), np.array(beam.end)]
        room = self._head.settings.room
        for wall in room.walls:
            upright = [
                (*wall.start, low[2]),
                (*wall.end, low[2]),
                (*wall.end, room.ceiling),
                (*wall.start, room.ceiling),
            ]
            points += [np.array(upright[k % 4]) for pair in ((0, 1), (1, 2), (2, 3), (3, 4)) for k in pair]
        exits = [line.exit_point for line in self._robot.lines]
        size = 0.01 * float((high - low).max())
        return _entity(
            stamp,
            "world",
            "frame",
            lines=[_line(_LINE_LIST, points, _GREY, 1.5)],
            spheres=[_solid(place, (size, size, size), _INK) for place in exits],
            texts=[_label(line.name, line.exit_point) for line in self._robot.lines],
        )

    def _platform(self, stamp: dict[str, int]) -> dict[str, Any]:
        """The platform's boxes, or the drum, in the platform's frame."""
        platform, drum = self._robot.platform, self._head.settings.drum
        cubes = [
            _solid(0.5 * np.add(box.lowest, box.highest), np.subtract(box.highest, box.lowest), _GREY)
            for box in platform.boxes
        ]
        cylinders = []
        if drum is not None:
            wide = 2.0 * drum.radius
            cylinders = [_solid((0.0, 0.0, -0.5 * drum.valve), (wide, wide, drum.valve), _GREY)]
        return _entity(stamp, "drum", "platform", cubes=cubes, cylinders=cylinders)

    def _lines(self, stamp: dict[str, int], shown: Truth | Estimate) -> dict[str, Any]:
        """The lines, straight; orange where they are slack."""
        pose = np.concatenate([shown.position, _turn(shown)])[: self._robot.n]
        ends = [{"x": x, "y": y, "z": z} for x, y, z in placed(pose, self._points).tolist()]
        pairs = [each for pair in zip(self._exits, ends, strict=True) for each in pair]
        slack, taut = _rgba(_ORANGE), _rgba(_BLUE)
        colours = [slack if each > 0.0 else taut for each in shown.excess.tolist() for _ in range(2)]
        return _entity(stamp, "world", "lines", lines=[self._line | {"points": pairs, "colors": colours}])

    def _gone(self, stamp: dict[str, int], time: float, place: Array) -> Iterator[dict[str, Any]]:
        """The path that the nozzle printed, in pieces: the last one is sent again as it grows."""
        if self._path and np.linalg.norm(place - self._last) < _STEP:
            return
        if len(self._path) in (0, _MOST):
            self._path, self._since = self._path[-1:], time
        self._last = np.array(place)
        self._path.append(_xyz(place))
        drawn = [_line(_LINE_STRIP, (), _INK, 2.0) | {"points": self._path}]
        extrusion = self._head.settings.extrusion
        if extrusion is not None:  # what is laid, as a strand of its width
            wide = _line(_LINE_STRIP, (), _SAND, extrusion.bead.width)
            drawn.append(wide | {"points": self._path, "scale_invariant": False})
        yield _entity(stamp, "world", f"path from {self._since:.2f} s", lines=drawn)


def _mounted(name: str, lidar: LidarSettings) -> dict[str, Any]:
    """Return the transform of a lidar in the frame of the drum, without its time."""
    x, y = np.array(lidar.axes)
    turned = np.column_stack([x, y, np.cross(x, y)])
    return _between(None, "drum", f"lidar_{name}", _xyz(lidar.place), quaternion(turned))


def _is_known(place: Array) -> bool:
    return math.isfinite(sum(place.tolist()))


def _turn(shown: Truth | Estimate) -> Array:
    """Rotation (3,), rad; 0 where it is not known."""
    return shown.rotation if _is_known(shown.rotation) else np.nan_to_num(shown.rotation)


def _entity(stamp: dict[str, int], frame: str, name: str, **shapes: list[dict[str, Any]]) -> dict[str, Any]:
    about = {"timestamp": stamp, "frame_id": frame, "id": name, "lifetime": _NEVER, "frame_locked": frame != "world"}
    return about | _EMPTY | shapes


def _line(kind: int, points: Any, colour: Any, thickness: float) -> dict[str, Any]:
    return {
        "type": kind,
        "pose": {"position": _xyz((0.0, 0.0, 0.0)), "orientation": _UNTURNED},
        "thickness": thickness,
        "scale_invariant": True,
        "points": [_xyz(each) for each in points],
        "color": _rgba(colour),
        "colors": [],
        "indices": [],
    }


def _solid(place: Any, size: Any, colour: Any) -> dict[str, Any]:
    pose = {"position": _xyz(place), "orientation": _UNTURNED}
    return {"pose": pose, "size": _xyz(size), "color": _rgba(colour), "bottom_scale": 1.0, "top_scale": 1.0}


def _label(text: str, place: Any) -> dict[str, Any]:
    pose = {"position": _xyz(place), "orientation": _UNTURNED}
    look = {"billboard": True, "font_size": 14.0, "scale_invariant": True, "color": _rgba(_INK)}
    return {"pose": pose, "text": text} | look


def _transform(stamp: dict[str, int], parent: str, child: str, place: Array, rotation: Array) -> dict[str, Any]:
    return _between(stamp, parent, child, _xyz(place), quaternion(matrix_of(rotation)))


def _between(stamp: Any, parent: str, child: str, place: Any, turn: Any) -> dict[str, Any]:
    names = {"timestamp": stamp, "parent_frame_id": parent, "child_frame_id": child}
    return names | {"translation": place, "rotation": turn}


def quaternion(R: Array) -> dict[str, float]:
    """Return the unit quaternion of a rotation matrix, computed from the largest of its four parts."""
    rows = R.tolist()
    (a, _, c), (d, e, f), (g, h, i) = rows
    squares = (1.0 + a - e - i, 1.0 - a + e - i, 1.0 - a - e + i, 1.0 + a + e + i)
    k, cross = squares.index(max(squares)), (h - f, c - g, d - rows[0][1])
    parts = [*cross, squares[3]]
    if k < 3:
        parts = [squares[k] if j == k else rows[k][j] + rows[j][k] for j in range(3)] + [cross[k]]
    size = math.hypot(*parts)
    return {key: part / size for key, part in zip("xyzw", parts, strict=True)}


def _xyz(values: Any) -> dict[str, float]:
    x, y, z = np.asarray(values, dtype=float).tolist()
    return {"x": x, "y": y, "z": z}


@functools.cache
def _rgba(colour: Any) -> dict[str, float]:
    return dict(zip("rgba", colour, strict=True))
