"""Equipment of a robot as built: room, mounts, masses, zeros and scales, with random deviations in the tolerances.

Each error has a random generator of its own, so that changing one tolerance changes no other error. A tolerance of 0
leaves the owner's own value, to the bit.
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import SOURCES
from cablewright.kernels.rotation import matrix
from cablewright.machine.sensors.inertial import INERTIAL
from cablewright.machine.sensors.lidars import LidarSettings
from cablewright.machine.settings import RoomSettings, WallFace
from cablewright.machine.simulated.settings import Tolerances, TwinSettings

_WALLS, _PLACE, _TURN, _MASS, _ZEROS, _ALONG, _GAINS = range(1, 8)
CLOCK: Final = 8
GAPS: Final = 9
VISITS: Final = 10
WALKS: Final = 11
ROOM: Final = 12
_HOME: Final = 13
RADII: Final = 14
CREEP: Final = 15
WIND: Final = 16
TEETH: Final = 17
PUSHES: Final = 18
BRAKES: Final = 19
CROSSINGS: Final = 20
OCCLUSIONS: Final = 21
_ON_ONE_LINE: Final = 1e-6  # m
_SHORT: Final = 1.0  # m: a shorter wall is not turned, as errors at its ends would turn it by much


def drawn(seed: int, *which: int) -> np.random.Generator:
    """Return the random generator of one error of the machine that *seed* builds."""
    return np.random.default_rng([seed, 6, *which])


def as_built_machine(twin: TwinSettings, seed: int) -> TwinSettings:
    """Return the true machine built by *seed*: room, mounts and masses with their errors."""
    owner, tolerances = twin.owner, twin.simulation.tolerances
    empty, powder = mass_factors(tolerances, seed)
    carrier = owner.carrier
    mass = {"empty_mass": carrier.empty_mass * empty, "powder": carrier.powder * powder}
    found: dict[str, Any] = {
        "drum" if owner.body is None else "body": carrier.model_copy(update=mass),
        "room": as_built_room(owner.room, tolerances.wall, seed),
        "lidars": {name: _lidar(name, lidar, tolerances, seed) for name, lidar in owner.lidars.items()},
    }
    inertial = owner.sensor(INERTIAL)
    if inertial is not None:
        place = _placed(inertial.place, INERTIAL.source, tolerances, seed)
        found[INERTIAL.table] = inertial.model_copy(update={"place": place})
    return twin.with_owner(**found)


def mass_factors(tolerances: Tolerances, seed: int) -> tuple[float, float]:
    """Return the true masses of the empty container and of its powder, relative to the specified ones."""
    empty, powder = (1.0 + tolerances.mass * drawn(seed, _MASS).standard_normal(2)).tolist()
    return empty, powder


def home_errors(tolerances: Tolerances, seed: int, lines: int) -> Array:
    """Return by how much each line is longer at the start than for the platform's assumed position, (m,) m."""
    return np.asarray(tolerances.home_length * drawn(seed, _HOME).uniform(-1.0, 1.0, lines))


def mounting(source: str, tolerances: Tolerances, seed: int) -> Array:
    """Return the true rotation (3, 3) of a sensor on the platform from its nominal one, by angles about the axes."""
    rotation = np.eye(3)
    if tolerances.mount_turn:
        matrix(tolerances.mount_turn * drawn(seed, _TURN, SOURCES[source].stream).standard_normal(3), rotation)
    return rotation


def angle_zeros(tolerances: Tolerances, seed: int, lines: int) -> Array:
    """Return the zero errors of the lines' accelerometers, (m,) rad."""
    return np.asarray(tolerances.line_angle_bias * drawn(seed, _ZEROS).standard_normal(lines))


def places_along(tolerances: Tolerances, seed: int, lines: int) -> Array:
    """Return how much farther from the platform each line's accelerometer is than described, (m,) m."""
    return np.asarray(tolerances.mount_place * drawn(seed, _ALONG).standard_normal(lines))


def tension_gains(source: str, tolerances: Tolerances, seed: int, lines: int) -> Array:
    """Return the relative error of the scale of each load cell or torque of a *source*, (m,)."""
    random = drawn(seed, _GAINS, SOURCES[source].stream)
    return np.asarray(tolerances.tension_gain * random.standard_normal(lines))


def as_built_room(room: RoomSettings, deviation: float, seed: int) -> RoomSettings:
    """Return the *room* with independent errors of that *deviation*, m, at the ends of walls, across them.

    Faces on one line are one wall, which stays straight. A wall shorter than 1 m is shifted, not turned.
    """
    if not deviation:
        return room
    walls, faces = _walls(room.walls), list(room.walls)
    errors = deviation * drawn(seed, _WALLS).standard_normal((len(walls), 2))
    for wall, (first, last) in zip(walls, errors, strict=True):
        ends = np.array([(faces[i].start, faces[i].end) for i in wall])  # (k, 2, 2)
        along = _direction(faces[wall[0]])
        across, places = np.array([-along[1], along[0]]), ends @ along
        begin, length = places.min(), np.ptp(places)
        off = first if length < _SHORT else first + (last - first) * (places - begin) / length
        moved = ends + np.multiply.outer(np.broadcast_to(off, places.shape), across)
        for i, (start, end) in zip(wall, moved.tolist(), strict=True):
            faces[i] = faces[i].model_copy(update={"start": tuple(start), "end": tuple(end)})
    return room.model_copy(update={"walls": tuple(faces)})


def _walls(faces: tuple[WallFace, ...]) -> list[list[int]]:
    """The numbers of the faces on each line, in the order of their first."""
    found: list[tuple[Array, Array, list[int]]] = []
    for i, face in enumerate(faces):
        along, start = _direction(face), np.array(face.start)
        for other, place, members in found:
            ends = (start - place, np.array(face.end) - place)
            if all(abs(other[0] * y - other[1] * x) < _ON_ONE_LINE for x, y in ends):
                members.append(i)
                break
        else:
            found.append((along, start, [i]))
    return [members for _, _, members in found]


def _direction(face: WallFace) -> Array:
    """The unit vector (2,) from a face's start to its end."""
    (x0, y0), (x1, y1) = face.start, face.end
    length = math.hypot(x1 - x0, y1 - y0)
    return np.array([(x1 - x0) / length, (y1 - y0) / length])


def _lidar(name: str, lidar: LidarSettings, tolerances: Tolerances, seed: int) -> LidarSettings:
    place = _placed(lidar.place, name, tolerances, seed)
    if not tolerances.mount_turn:
        return lidar.model_copy(update={"place": place})
    axes = np.array(lidar.axes) @ mounting(name, tolerances, seed).T
    return lidar.model_copy(update={"place": place, "axes": tuple(map(tuple, axes.tolist()))})


def _placed(
    place: tuple[float, float, float], source: str, tolerances: Tolerances, seed: int
) -> tuple[float, float, float]:
    off = drawn(seed, _PLACE, SOURCES[source].stream).standard_normal(3)
    x, y, z = (np.array(place) + tolerances.mount_place * off).tolist()
    return x, y, z
