"""Numbers of a robot that are likely in another unit than was meant: each in one line, with the unit that fits."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from statistics import median
from typing import Final, NamedTuple

from cablewright.robot.line import Line
from cablewright.robot.robot import Robot

LENGTHS: Final[Mapping[str, float]] = {"mm": 1e-3, "cm": 1e-2, "inch": 0.0254, "ft": 0.3048}
FORCES: Final[Mapping[str, float]] = {"kN": 1e3, "MN": 1e6}
STEEL: Final = 7850.0
"""Density of steel, kg/m^3: no cable has more mass in its circle."""

_LARGEST: Final = 2000.0  # m between exit points: twice as much as the largest robot there is
_LIGHT: Final = 100.0  # N per metre between exit points: least load of robots over 100 m
_STRAIN: Final = 0.1  # at the largest tension allowed: of a cable that is stretched, not of one that holds
_HEAVY: Final = 5.0  # weight of all cables over the load
_OUTLYING: Final = 2.5  # times the distance of the other exit points from their middle
_WORDS: Final = (("left", "right"), ("front", "back"), ("front", "rear"), ("west", "east"), ("south", "north"))
_UPRIGHT: Final = (("bottom", "top"), ("lower", "upper"), ("low", "high"))
_COMPASS: Final = {"n": "north", "e": "east", "s": "south", "w": "west"}


class Doubt(NamedTuple):
    """What is doubtful, and whether it is impossible."""

    sentence: str
    impossible: bool = False


def doubts(robot: Robot) -> tuple[Doubt, ...]:
    """Return what is doubtful about the numbers of *robot*, a sentence each; none of an ordinary one."""
    size = _size([line.exit_point for line in robot.lines])
    return (*_places(robot, size), *_whole(robot, size), *_cables(robot, size), *_loads(robot), *_names(robot.lines))


def likely(value: float, wanted: float, units: Mapping[str, float], span: float = 10.0) -> str:
    """Return ``: VALUE UNIT?`` with the unit by which *value* is nearest to *wanted*; empty beyond a factor *span*."""
    if not (value > 0.0 and wanted > 0.0):
        return ""
    off = {unit: abs(math.log(value * factor / wanted)) for unit, factor in units.items()}
    best = min(off, key=lambda unit: off[unit])
    return f": {value:g} {best}?" if off[best] < math.log(span) else ""


def _size(points: Sequence[Sequence[float]]) -> float:
    """The largest extent of points along an axis, m."""
    return float(max(max(axis) - min(axis) for axis in zip(*points, strict=True)))


def _carried(robot: Robot) -> float:
    """Weight of the platform and the force on it, N."""
    return robot.platform.mass * robot.scene.gravity + math.hypot(*robot.platform.force)


def _whole(robot: Robot, size: float) -> Iterator[Doubt]:
    """What is doubtful about the robot as a whole, *size* m large."""
    load, gravity = _carried(robot), robot.scene.gravity
    if size > _LARGEST or (size > 100.0 and load < _LIGHT * size):
        unit = likely(size, min(10.0, max(1.0, load / 100.0)), LENGTHS, 30.0)
        yield Doubt(f"the exit points are {size:g} m apart, for a load of {load:.3g} N{unit}", size > _LARGEST)
    frame = _size([robot.scene.frame_min, robot.scene.frame_max])
    if size > 0.0 and not 0.02 <= frame / size <= 20.0:
        unit = likely(frame, size, LENGTHS)
        yield Doubt(f"scene: the frame is {frame:g} m large, and its exit points are {size:g} m apart{unit}")
    if gravity > 30.0:
        unit = likely(gravity, 9.81, {"mm/s^2": 1e-3, "cm/s^2": 1e-2, "ft/s^2": 0.3048}, 1.1)
        yield Doubt(f"scene: gravity = {gravity:g} m/s^2{unit}")


def _places(robot: Robot, size: float) -> Iterator[Doubt]:
    """Points that are far from the others, and wheels that are too large."""
    exits = [line.exit_point for line in robot.lines]
    middle = [median(axis) for axis in zip(*exits, strict=True)]
    away = [math.dist(point, middle) for point in exits]
    usual = median(away)
    if len(exits) > 3 and max(away) > _OUTLYING * usual > 0.0:
        far = away.index(max(away))
        unit = likely(max(map(abs, exits[far])), usual, LENGTHS, 4.0)
        what = f"line {robot.lines[far].name!r}: exit_point is {away[far]:.4g} m away from the middle of the others"
        yield Doubt(f"{what}, which are {usual:.3g} m away{unit}", away[far] > 0.5 * _LARGEST)
    for line in robot.lines:
        reach = math.hypot(*line.platform_point)
        if reach > 1.5 * size:
            unit = likely(reach, 0.1 * size, LENGTHS)
            yield Doubt(f"line {line.name!r}: platform_point is {reach:g} m from the platform's origin{unit}")
        dead = 0.0 if line.winch_exit is None else math.dist(line.winch_exit, line.exit_point)
        if dead > 20.0 * size > 0.0:
            unit = likely(max(map(abs, line.winch_exit or ())), size, LENGTHS)
            yield Doubt(f"line {line.name!r}: winch_exit is {dead:g} m away from exit_point{unit}")
        wheels = {"sheave.radius": getattr(line.sheave, "radius", 0.0), "winch.drum_radius": line.winch.drum_radius}
        for key, radius in wheels.items():
            if (radius or 0.0) > max(0.3 * size, 0.02):
                unit = likely(radius or 0.0, 0.01 * size, LENGTHS, 30.0)
                yield Doubt(f"line {line.name!r}: {key} = {radius:g} m, in a robot of {size:.3g} m{unit}")


def _cables(robot: Robot, size: float) -> Iterator[Doubt]:
    """Cables that no material makes; each kind of them once."""
    for line in {line.cable: line for line in reversed(robot.lines)}.values():
        cable, most, name = line.cable, line.tension_limits[1], f"line {line.name!r}: cable."
        mass, diameter = cable.linear_density, cable.diameter
        area = cable.load_section if diameter is None else 0.25 * math.pi * diameter**2
        if area is not None and mass > 1.02 * STEEL * area:
            unit = likely(mass, 0.3 * STEEL * area, {"g/m": 1e-3}, 30.0)
            yield Doubt(f"{name}linear_density = {mass:g} kg/m has {mass / area:.3g} kg/m^3, over steel's{unit}")
        elif mass * size * robot.m * robot.scene.gravity > _HEAVY * _carried(robot):
            yield Doubt(f"{name}linear_density = {mass:g} kg/m: the cables weigh far more than the load: {mass:g} g/m?")
        if diameter is not None and (diameter > max(0.1 * size, 0.01) or mass < 50.0 * (area or 0.0)):
            unit = likely(diameter, math.sqrt(mass / 1000.0) or 2e-3, LENGTHS)
            yield Doubt(f"{name}diameter = {diameter:g} m, with {mass:g} kg/m{unit}")
        if most > _STRAIN * cable.stiffness and line.spring is None:
            strain = 100.0 * most / cable.stiffness
            what = f"strains by {strain:.3g} % at {most:g} N, the most that tension_limits allow"
            if cable.young_modulus is None:
                key, unit = "axial_stiffness", likely(cable.stiffness, 200.0 * most, FORCES, 30.0)
            else:
                pressures = {"MPa": 1e6, "GPa": 1e9, "N/mm^2": 1e6}
                key, unit = "young_modulus", likely(cable.young_modulus, 5e10, pressures, 50.0)
            yield Doubt(f"{name}{key} = {getattr(cable, key):g}: it {what}{unit}", strain > 1e6)
        elif area is not None and cable.stiffness > 2e12 * area:
            unit = ": N?" if cable.young_modulus is None else ": MPa?"
            yield Doubt(f"{name}stiffness is {1e-9 * cable.stiffness / area:.3g} GPa, ten times that of steel{unit}")
        if area is not None and cable.breaking_load > 1e10 * area:
            yield Doubt(f"{name}breaking_load = {cable.breaking_load:g} N is more than any material holds: N, not kN?")


def _loads(robot: Robot) -> Iterator[Doubt]:
    """A platform that the lines cannot hold at all, or hardly notice."""
    held = sum(line.tension_limits[1] * line.advantage * line.cables for line in robot.lines)
    load, mass = _carried(robot), robot.platform.mass
    if held < 0.5 * robot.platform.mass * robot.scene.gravity and held < load:
        what = f"platform.mass = {mass:g} kg: all lines together pull at most {held:.3g} N"
        yield Doubt(f"{what}: {mass:g} g, or tension_limits in kN?")
    if load > 0.0 and held > 3000.0 * load and all(line.tension_limits[0] > 2.0 * load for line in robot.lines):
        yield Doubt(f"platform.mass = {mass:g} kg: each line pulls at least twice its weight: {mass:g} t?")


def _names(lines: Sequence[Line]) -> Iterator[Doubt]:
    """Exit points that are not where the names of their lines say."""
    words = {line.name: _words(line.name) for line in lines}
    found: dict[tuple[str, str], list[tuple[int, float]]] = {}
    for low, high in (*_WORDS, *_UPRIGHT):
        below, above = ([line for line in lines if word in words[line.name]] for word in (low, high))
        if not below or not above:
            continue
        axes = (2, 0, 1) if (low, high) in _UPRIGHT else (0, 1)  # a frame that lies has its top at one side
        found[low, high] = ways = [
            (axis, sign)
            for axis in axes
            for sign in ((1.0,) if axis == 2 else (1.0, -1.0))
            if max(sign * a.exit_point[axis] for a in below) < min(sign * b.exit_point[axis] for b in above)
        ]
        if not ways:
            names = f"{below[0].name!r} and {above[0].name!r}"
            yield Doubt(
                f"lines {names}: exit_point: {low!r} and {high!r} of the names do not fit: exchanged or mirrored?"
            )
    east, north = found.get(("west", "east")), found.get(("south", "north"))
    if east and north and not any(_turns_left(a, b) for a in east for b in north):
        yield Doubt("lines: exit_point: 'north' of the names is not to the left of 'east', from above: mirrored?")


def _turns_left(east: tuple[int, float], north: tuple[int, float]) -> bool:
    """Whether *north* is a quarter of a turn from *east*, anticlockwise; each an axis and its sign."""
    return east[0] != north[0] and (1.0 if east[0] == 0 else -1.0) * east[1] * north[1] > 0.0


def _words(name: str) -> set[str]:
    """The words of a name; N, NE, SW and others as words, too."""
    words = set(re.split(r"[^a-z]+", name.lower()))
    points = {word for word in words if 0 < len(word) <= 2 and set(word) <= _COMPASS.keys() and name.upper() == name}
    return words | {_COMPASS[letter] for word in points for letter in word}
