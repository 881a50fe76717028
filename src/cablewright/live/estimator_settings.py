"""Settings of the estimators, from the owner's data of a machine: its description, a survey, and data sheets."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, Final

from cablewright.estimation import started_filter
from cablewright.estimation.camera import KnownCamera
from cablewright.estimation.clock_offset import ClockLeadSettings
from cablewright.estimation.height import HeightSettings
from cablewright.estimation.kalman.coil_layers import CoilLayers
from cablewright.estimation.kalman.settings import FilterSettings
from cablewright.estimation.lidar.localisation import WallSettings
from cablewright.estimation.lidar.room import Laser, RoomMap, RoomWall
from cablewright.estimation.lidar.scan import LidarModel
from cablewright.estimation.merlet2023 import observer
from cablewright.estimation.merlet2023.drum_radius import RadiusSettings
from cablewright.estimation.merlet2023.state import ObserverSettings
from cablewright.estimation.slackness import SlacknessSettings
from cablewright.estimation.started_filter import StartedSettings
from cablewright.estimation.tilt import TiltSettings
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import (
    CameraPose,
    Climate,
    Distance,
    Encoders,
    Estimate,
    Inertial,
    LineAngles,
    Reading,
    SensorFrame,
)
from cablewright.machine.coils import coil_of
from cablewright.machine.sensors.camera import CAMERA
from cablewright.machine.sensors.distance import DISTANCE
from cablewright.machine.sensors.inertial import INERTIAL
from cablewright.machine.sensors.lidars import LidarSettings
from cablewright.machine.sensors.line_angles import LINE_ANGLES
from cablewright.machine.settings import MachineSettings, RoomSettings
from cablewright.models.statics import Model
from cablewright.models.support_table import Capability, require
from cablewright.robot import Line, Robot

_MIN_WALL: Final = 3.0  # m; a shorter face is a window or a corner
_TOLERANCE: Final = 1e-6  # m, of faces on one line
_RADIUS_BOUNDS: Final = (0.8, 1.5)  # times the bare drum's radius
_YAW_STEP: Final = math.radians(15.0)  # largest change of the drum's yaw between two positions by lidars ...
_HELD_YAW_STEP: Final = math.radians(5.0)  # ... and of a yaw that a drive holds
_FLOOR_CONE: Final = math.radians(70.0)  # from the drum's axis: where a vertical lidar sees floor
_HORIZONTAL: Final = ("north", "south")
_READ: Final[tuple[type[Reading], ...]] = (Inertial, LineAngles, Distance, Encoders, Climate, CameraPose)
"""Readings that point estimators use besides lidar scans; a silent one is reported."""


def observer_settings(
    robot: Robot, settings: MachineSettings, lasers: Sequence[Laser] = (), *, by_camera: bool = False
) -> ObserverSettings:
    """Return the Merlet 2023 estimator's settings for the machine that *robot* and *settings* describe.

    *lasers*: an operator's distances at the start. *by_camera*: for the filter alone, of a machine whose camera takes
    the place of horizontal lidars. Raises `InputError` for a machine without the required sensors (a horizontal lidar,
    walls, line angles), and for a *laser* to no wall.
    """
    require(robot, Capability.ROOM_ESTIMATION)
    model = Model(with_drum_mass(robot, settings))
    walls = RoomMap(()) if by_camera else surveyed_walls(settings.room)
    for laser in lasers:
        walls.index(laser.wall)
    mounted = {} if by_camera else _horizontal(settings)
    sensor, camera = settings.sensor(LINE_ANGLES), settings.sensor(CAMERA)
    if not by_camera and (not mounted or sensor is None):
        missing = "line_angles" if mounted else "horizontal lidar"
        raise InputError(f"machine {settings.name!r}: has no {missing}, which the estimation needs")
    nominal = [line.winch.drum_radius for line in _wound(robot)]
    radii = tuple(radius for radius in nominal if radius is not None)
    if len(radii) < robot.m:
        raise InputError(f"robot {robot.name!r}: a winch without drum_radius, which the estimation needs")
    vertical, winch = settings.lidars.get("vertical"), settings.winch
    return ObserverSettings(
        model=model,
        walls=WallSettings(
            walls,
            tuple(_lidar(name, lidar, walls) for name, lidar in mounted.items()),
            yaw_step=_YAW_STEP if settings.point_drum.yaw_drive is None else _HELD_YAW_STEP,
        ),
        lidars=tuple(mounted),
        slackness=SlacknessSettings(model)
        if sensor is None
        else SlacknessSettings(model, sensor.from_platform, timeout=max(0.5, 2.5 / sensor.rate)),
        radius=RadiusSettings(radii, _RADIUS_BOUNDS[0] * min(radii), _RADIUS_BOUNDS[1] * max(radii)),
        counts_per_radian=winch.counts * winch.ratio / math.tau,
        height=None
        if vertical is None
        else HeightSettings(
            vertical.place,
            vertical.axes,
            sigma=vertical.deviation,
            floor_cone=_FLOOR_CONE,
            place_sigma=vertical.place_deviation,
            turn_sigma=vertical.turn_deviation,
        ),
        tilt=TiltSettings(robot.scene.gravity),
        max_drum_speed=winch.max_speed,
        valve_depth=settings.point_drum.valve,
        lasers=tuple(lasers),
        timeouts=_timeouts(settings),
        clock=clock_of(settings),
        camera=None if camera is None else KnownCamera.told(camera),
    )


def _horizontal(settings: MachineSettings) -> dict[str, LidarSettings]:
    """The horizontal lidars by name."""
    return {name: settings.lidars[name] for name in _HORIZONTAL if name in settings.lidars}


_RADII: Final = 10.0  # of the expected deviation of radii: standard deviation at the start, ...
_RADIUS: Final = 1e-3  # ... and the least, a share: no drum is measured better


def sees_position(settings: MachineSettings) -> bool:
    """Whether the sensors of a point platform's machine find its position: a camera, or lidars and line angles."""
    return settings.sensor(CAMERA) is not None or _is_by_lidars(settings)


def _is_by_lidars(settings: MachineSettings) -> bool:
    return settings.sensor(LINE_ANGLES) is not None and bool(_horizontal(settings))


def clock_of(settings: MachineSettings) -> ClockLeadSettings | None:
    """Return the settings of the clock on the platform; None where it is the machine's."""
    clock = settings.clock
    return None if clock is None else ClockLeadSettings(clock.offset, clock.drift, clock.latency, clock.age)


def started_settings(robot: Robot, settings: MachineSettings, lasers: Sequence[Laser] = ()) -> StartedSettings:
    """Return settings of the filter and of the estimator that starts it; raises errors as `observer_settings`."""
    by_camera = settings.sensor(CAMERA) is not None and not _is_by_lidars(settings)
    chain = observer_settings(robot, settings, lasers, by_camera=by_camera)
    winch, inertial, vertical = settings.winch, settings.sensor(INERTIAL), settings.lidars.get("vertical")
    bare = min(chain.radius.nominal)
    walk = winch.radius_deviation * math.sqrt(2.0 / (winch.radius_turns * math.tau)) / bare  # per root radian
    sigmas: dict[str, float] = {"radius_noise": walk} if walk > 0.0 else {}
    if walk > 0.0:  # a radius that is hardly uncertain must not explain what a camera shows
        sigmas["radius_sigma"] = min(max(_RADII * winch.radius_deviation / bare, _RADIUS), FilterSettings.radius_sigma)
    if inertial is not None:
        sigmas |= {
            "gyro_bias_sigma": max(inertial.rate_bias, 1e-5),
            "gyro_noise": max(inertial.rate_deviation, 1e-5) / math.sqrt(inertial.rate),
            "accelerometer_bias_sigma": max(
                math.hypot(inertial.acceleration_bias / robot.scene.gravity, inertial.turn_deviation), 1e-5
            ),
        }
    if vertical is not None:
        sigmas["height_bias_sigma"] = max(vertical.bias, 1e-4)
    distance, line_angles = settings.sensor(DISTANCE), settings.sensor(LINE_ANGLES)
    if distance is not None:
        sigmas["distance_sigma"] = max(distance.deviation, 1e-4)
    if line_angles is not None:
        sigmas["zero_sigma"] = line_angles.bias
    coils = [coil_of(line, winch) for line in _wound(robot)]
    layers = CoilLayers(coils, winch.held, winch.pitch, winch.radius_deviation, winch.radius_turns)
    return StartedSettings(chain, FilterSettings(chain, **sigmas, layers=layers))


def _wound(robot: Robot) -> list[Line]:
    """Return the lines, and in place of those with a counterweight, whose drum never turns, the first that has one."""
    return [robot.lines[robot.hosts[0]] if i in robot.hung else line for i, line in enumerate(robot.lines)]


@dataclass(frozen=True, eq=False)
class Observer:
    """Functions of one estimator: ``settings`` of a machine, the state at ``start``, and a ``step`` with a frame.

    ``weigh``, where it uses that: it receives the platform's mass, kg, before each step.
    """

    settings: Callable[[Robot, MachineSettings, Sequence[Laser]], Any]
    start: Callable[[Any], Any]
    step: Callable[[Any, Any, SensorFrame], Estimate]
    weigh: Callable[[Any, Any, float], None] = lambda _settings, _state, _mass: None


OBSERVERS: Final[Mapping[str, Observer]] = MappingProxyType({
    "paper": Observer(observer_settings, observer.start, observer.step),
    "filter": Observer(started_settings, started_filter.start, started_filter.step, started_filter.weigh),
})  # fmt: skip
"""By name: the estimator of Merlet and Papegay 2023, and the Kalman filter of all sensors."""


def with_drum_mass(robot: Robot, settings: MachineSettings) -> Robot:
    """Return *robot* with the initial mass of the container and its powder."""
    return robot.with_platform(mass=settings.carrier.full_mass, loads=())


def surveyed_walls(room: RoomSettings) -> RoomMap:
    """Return the walls of a room: faces on one line are one wall, with the first face's name up to its comma.

    Walls with less than 3 m of faces (windows, corners) are omitted. Raises `InputError` for a room without walls.
    """
    if not room.walls:
        raise InputError("room.walls: none, but the estimation needs walls")
    ends = [end for wall in room.walls for end in (wall.start, wall.end)]
    middle = [0.5 * (min(column) + max(column)) for column in zip(*ends, strict=True)]
    found: list[tuple[RoomWall, float, list[float]]] = []
    for face in room.walls:
        dx, dy = face.end[0] - face.start[0], face.end[1] - face.start[1]
        length = math.hypot(dx, dy)
        nx, ny = dy / length, -dx / length
        distance = nx * face.start[0] + ny * face.start[1]
        if distance < nx * middle[0] + ny * middle[1]:
            nx, ny, distance = -nx, -ny, -distance
        places = [nx * y - ny * x for x, y in (face.start, face.end)]
        for i, (wall, before, others) in enumerate(found):
            if math.dist(wall.normal, (nx, ny)) < _TOLERANCE and abs(wall.distance - distance) < _TOLERANCE:
                found[i] = wall, before + length, others + places
                break
        else:
            name = face.name.split(",")[0]
            found.append((RoomWall(name, (nx, ny), distance), length, places))
    return RoomMap(
        tuple(_surveyed(wall, places, room.deviation) for wall, length, places in found if length >= _MIN_WALL)
    )


def _surveyed(wall: RoomWall, places: list[float], deviation: float) -> RoomWall:
    """Return *wall* with the sigmas that independent errors of both its ends, at *places* m along it, give."""
    first, last = min(places), max(places)
    return replace(
        wall,
        reference=0.5 * (first + last),
        distance_sigma=deviation / math.sqrt(2.0),
        angle_sigma=deviation * math.sqrt(2.0) / (last - first),
    )


def _lidar(name: str, lidar: LidarSettings, room: RoomMap) -> LidarModel:
    """Return the model of a horizontal lidar; it sees the walls outside its masks at a yaw of 0.

    Raises `InputError` for one that is not level.
    """
    (ax, ay, az), (bx, by, bz) = lidar.axes
    if abs(az) > _TOLERANCE or abs(bz) > _TOLERANCE or ax * by - ay * bx < 0.0:
        raise InputError(f"lidars.{name}.axes: must span a level plane, x to y counter-clockwise from above")
    yaw = math.atan2(ay, ax)
    visible = tuple(wall.name for wall in room.walls if not _masked(lidar, wall.azimuth - yaw))
    return LidarModel(
        name,
        lidar.place,
        yaw,
        lidar.least,
        lidar.most,
        max(lidar.deviation, 1e-4),
        bias_sigma=lidar.bias,
        masks=lidar.masks,
        visible_walls=visible,
        place_sigma=lidar.place_deviation,
        turn_sigma=lidar.turn_deviation,
    )


def _masked(lidar: LidarSettings, bearing: float) -> bool:
    return any((bearing - begin) % math.tau <= (end - begin) for begin, end in lidar.masks)


def _timeouts(settings: MachineSettings) -> dict[str, float]:
    """Time without a reading, s, by source, after which a fault is reported."""
    timeouts = {name: 2.5 * lidar.turn for name, lidar in settings.lidars.items()}
    used = {source.name for kind in _READ for source in kind.SOURCES}
    return timeouts | {
        source: max(0.5, 2.5 / sheet.rate) for source, sheet in settings.sheets.items() if source in used
    }
