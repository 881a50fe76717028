"""Numbers of a robot that are likely in another unit than intended, each with the unit that fits."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from statistics import median
from typing import Final, NamedTuple

from cablewright.robot.line import Line
from cablewright.robot.mount import compliance_matrix
from cablewright.robot.robot import Robot

LENGTHS: Final[Mapping[str, float]] = {"mm": 1e-3, "cm": 1e-2, "inch": 0.0254, "ft": 0.3048}
FORCES: Final[Mapping[str, float]] = {"kN": 1e3, "MN": 1e6, "kgf": 9.80665}
PRESSURES: Final[Mapping[str, float]] = {"MPa": 1e6, "GPa": 1e9, "N/mm^2": 1e6, "psi": 6894.76, "ksi": 6.89476e6}
SPEEDS: Final[Mapping[str, float]] = {"mm/s": 1e-3, "m/min": 1.0 / 60.0, "mm/min": 1e-3 / 60.0}
TORQUES: Final[Mapping[str, float]] = {"kN m": 1e3, "N mm": 1e-3, "N cm": 1e-2}
INERTIAS: Final[Mapping[str, float]] = {"kg cm^2": 1e-4, "kg mm^2": 1e-6, "g mm^2": 1e-9}
STEEL: Final = 7850.0
"""Density of steel, kg/m^3: no cable has more mass in its circle."""

_LARGE: Final = 700.0  # m between exit points: the largest robot there is has 600
_LARGEST: Final = 2000.0  # m: no robot
_LIGHT: Final = 0.1  # N per metre between exit points: least load of robots over 100 m
_STRAIN: Final = 0.1  # at the largest tension allowed: of a cable that is stretched, not of one that holds
_STRAIN_AT_WORK: Final = 0.05  # at the largest tension of a job
_FAST: Final = 30.0  # m/s, of a cable
_LOOSE: Final = 300.0  # kg/m^3 in a cable's circle: a third of that of the lightest fibre
_THIN: Final = 2.0  # kg/m^3 in a platform's boxes: that of air
_TURN: Final = (-math.tau, math.tau, 1.0, {"deg": math.radians(1.0)})  # rad
_EXPANSION: Final = (-1e-3, 1e-3, 1e-5, {"ppm/K": 1e-6})  # 1/K
_COMPLIANCES: Final = {"mm/N": 1e-3, "mm/kN": 1e-6}
_RATES: Final = {"N/mm": 1e3}
_OUTSIDE: Final = 0.2  # of a robot's size, beyond which a place is not of it
_LEAST_AREA: Final = 1e-300  # m^2: the square of a diameter may be no number
_HEAVY: Final = 5.0  # weight of all cables over the load
_OUTLYING: Final = 2.5  # times the distance of the other exit points from their middle
_WORDS: Final = (("left", "right"), ("front", "back"), ("front", "rear"), ("west", "east"), ("south", "north"))
_UPRIGHT: Final = (("bottom", "top"), ("lower", "upper"), ("low", "high"))
_COMPASS: Final = {"n": "north", "e": "east", "s": "south", "w": "west"}


class Doubt(NamedTuple):
    """A doubtful number, and whether it is impossible."""

    sentence: str
    impossible: bool = False


def doubts(robot: Robot) -> tuple[Doubt, ...]:
    """Return the doubtful numbers of *robot*, a sentence each; empty for an ordinary one."""
    exits, scene = [line.exit_point for line in robot.lines], robot.scene
    size = _size(exits) or _size([scene.frame_min, scene.frame_max])
    rows = (*_of_platform(robot, size), *_of_lines(robot, size))
    found = (*_places(robot), *_whole(robot, size), *_cables(robot, size), *_odd(rows, size), *_loads(robot))
    return (*found, *_names(robot.lines)) or tuple(_odd(_of_winches(robot), size))


def overstretched(robot: Robot, tensions: Iterable[float]) -> tuple[str, ...]:
    """Return which cables strain by over 5 % at the largest *tensions* (m,), N, of a job; each kind of them once."""
    largest: dict[object, tuple[float, Line]] = {}
    for line, tension in zip(robot.lines, tensions, strict=True):
        if tension > _STRAIN_AT_WORK * line.cable.stiffness and line.spring is None:
            largest[line.cable] = max(
                largest.get(line.cable, (0.0, line)), (float(tension), line), key=lambda at: at[0]
            )
    return tuple(_stretched(line, tension, "the largest tension of the job") for tension, line in largest.values())


def units_inside(places: Sequence[Sequence[float]], robot: Robot) -> dict[str, float]:
    """Return units, with sizes in m, in which all *places* are inside the robot; none if they are inside as metres.

    A *place* is x, y and z; NaN is anywhere.
    """
    scene = robot.scene
    points = (scene.frame_min, scene.frame_max, *(line.exit_point for line in robot.lines))
    ends = [(min(axis), max(axis)) for axis in zip(*points, strict=True)]
    spare = _OUTSIDE * max(high - low for low, high in ends)

    def outside(factor: float) -> bool:
        return any(
            not math.isnan(value) and not low - spare <= factor * value <= high + spare
            for place in places
            for value, (low, high) in zip(place, ends, strict=True)
        )

    return {unit: size for unit, size in LENGTHS.items() if not outside(size)} if outside(1.0) else {}


def likely(value: float, wanted: float, units: Mapping[str, float], span: float = 10.0) -> str:
    """Return ``: VALUE UNIT?`` with the unit by which *value* is nearest to *wanted*; empty beyond a factor *span*."""
    if not (value and wanted > 0.0):
        return ""
    off = {unit: abs(math.log(abs(value) * factor / wanted)) for unit, factor in units.items()}
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
    load, gravity, scene = _carried(robot), robot.scene.gravity, robot.scene
    if size > _LARGE or (size > 100.0 and load < _LIGHT * size):
        unit = likely(size, min(10.0, max(1.0, load / 100.0)), LENGTHS, 30.0)
        yield Doubt(f"the exit points are {size:g} m apart, for a load of {load:.3g} N{unit}", size > _LARGEST)
    frame = _size([scene.frame_min, scene.frame_max])
    if not 0.04 * size <= frame <= 20.0 * size:
        unit = likely(max(frame, size), min(frame, size), LENGTHS)
        yield Doubt(f"scene: the frame is {frame:g} m large, and its exit points are {size:g} m apart{unit}")
    if gravity > 30.0:
        unit = likely(gravity, 9.81, {"mm/s^2": 1e-3, "cm/s^2": 1e-2, "ft/s^2": 0.3048}, 1.1)
        yield Doubt(f"scene: gravity = {gravity:g} m/s^2{unit}")


def _places(robot: Robot) -> Iterator[Doubt]:
    """Points that are far from the others."""
    exits = [line.exit_point for line in robot.lines]
    middle = [median(axis) for axis in zip(*exits, strict=True)]
    away = [math.dist(point, middle) for point in exits]
    usual = median(away)
    if len(exits) > 3 and max(away) > _OUTLYING * usual > 0.0:
        far = away.index(max(away))
        unit = likely(max(map(abs, exits[far])), usual, LENGTHS, 4.0)
        what = f"line {robot.lines[far].name!r}: exit_point is {away[far]:.4g} m away from the middle of the others"
        yield Doubt(f"{what}, which are {usual:.3g} m away{unit}", away[far] > 0.5 * _LARGEST)


class _Number(NamedTuple):
    """A number of a robot, and its usual range."""

    what: str
    value: float
    unit: str
    low: float
    high: float
    wanted: float  # an ordinary value
    units: Mapping[str, float]


def _odd(rows: Iterable[_Number], size: float) -> Iterator[Doubt]:
    """Numbers that are too large or too small beside a robot that is *size* m large; of equal lines the first."""
    found: dict[tuple[str, float], Doubt] = {}
    for what, value, unit, low, high, wanted, units in rows:
        if value and not low <= value <= high:
            sentence = f"{what} = {value:g} {unit}, in a robot of {size:.3g} m{likely(value, wanted, units, 30.0)}"
            found.setdefault((what.partition(": ")[2], value), Doubt(sentence))
    yield from found.values()


def _of_platform(robot: Robot, size: float) -> Iterator[_Number]:
    """Lengths of the platform, also beside its mass and inertia, and of the frame's beams."""
    platform, mass, retraction = robot.platform, robot.platform.mass, robot.retraction
    points = {f"platform.{key}": getattr(platform, key, (0.0,)) for key in ("nozzle", "centre_of_mass")}
    for k, box in enumerate(platform.boxes):
        points |= {f"platform.boxes[{k}].{key}": getattr(box, key) for key in ("lowest", "highest")}
    points |= {f"line {line.name!r}: platform_point": line.platform_point for line in robot.lines}
    for what, point in points.items():
        away = math.hypot(*point)
        yield _Number(f"{what}: distance from the origin", away, "m", 0.0, 1.5 * size, 0.03 * size, LENGTHS)
    sides = (tuple(map(operator.sub, each.highest, each.lowest)) for each in platform.boxes)
    side, light = sum(map(math.prod, sides)) ** (1 / 3), (mass / _THIN) ** (1 / 3)
    reach, inertia = max(math.hypot(*line.platform_point) for line in robot.lines), getattr(platform, "inertia", None)
    most, retracts = max(inertia or (0.0,)), 0.0 if retraction is None else retraction.most
    compact = 25.0 * math.sqrt(most / mass) or math.inf  # m, to platform points
    wide = mass * (4.0 * reach) ** 2 or math.inf  # kg m^2
    yield from (
        _Number("platform.retraction.most", retracts, "m", 0.0, 5.0 * size, 0.5 * size, LENGTHS),
        _Number("platform.boxes: side of a cube, for platform.mass", side, "m", 0.0, light, 0.3 * light, LENGTHS),
        _Number("platform_point: distance, for platform.mass", reach, "m", 0.0, 5.0 * mass, 0.05 * mass, LENGTHS),
        _Number("platform_point: distance, for platform.inertia", reach, "m", 0.0, compact, 0.08 * compact, LENGTHS),
        _Number("platform.inertia, for platform points", most, "kg m^2", 0.0, wide, wide / 64.0, INERTIAS),
    )
    for k, beam in enumerate(robot.scene.beams):
        name, length = f"scene.beams[{k}]", math.dist(beam.start, beam.end)
        yield _Number(f"{name}.radius", beam.radius, "m", 0.0, max(0.3 * size, 0.02), 0.01 * size, LENGTHS)
        yield _Number(f"{name}: length", length, "m", 0.0, 10.0 * size, size, LENGTHS)


def _of_lines(robot: Robot, size: float) -> Iterator[_Number]:
    """Lengths, angles, speeds and compliances of lines."""
    for line in robot.lines:
        name, sheave, pull = f"line {line.name!r}:", line.sheave, line.tension_limits[1] * line.cables
        stops = (line.winch_exit or line.exit_point, *(each for each in line.guides if isinstance(each, tuple)))
        dead = max(math.dist(stop, line.exit_point) for stop in stops)
        soft = 0.0 if line.exit_compliance is None else max(map(max, compliance_matrix(line.exit_compliance)))
        wheel, way = (0.0, max(0.3 * size, 0.02), 0.01 * size, LENGTHS), (0.0, 20.0 * size, 0.3 * size, LENGTHS)
        yield from (
            _Number(f"{name} sheave.radius", getattr(sheave, "radius", 0.0), "m", *wheel),
            _Number(f"{name} sheave.lever", getattr(sheave, "lever", 0.0), "m", *wheel),
            _Number(f"{name} winch.drum_radius", line.winch.drum_radius or 0.0, "m", *wheel),
            _Number(f"{name} dead_length", line.dead_length, "m", *way),
            _Number(f"{name} winch_exit or guides: distance from exit_point", dead, "m", *way),
            _Number(f"{name} sheave.facing", getattr(sheave, "facing", None) or 0.0, "rad", *_TURN),
            _Number(f"{name} winch.max_speed", line.winch.max_speed or 0.0, "m/s", 0.0, _FAST, 1.0, SPEEDS),
            _Number(f"{name} cable.thermal_expansion", line.cable.thermal_expansion or 0.0, "/K", *_EXPANSION),
            _Number(f"{name} exit_compliance", soft, "m/N", 0.0, 0.1 * size / pull, 1e-3 * size / pull, _COMPLIANCES),
            _Number(
                f"{name} spring", line.spring or 0.0, "N/m", 4.0 * pull / size, math.inf, 100.0 * pull / size, _RATES
            ),
        )


def _of_winches(robot: Robot) -> Iterator[_Number]:
    """Torques beside tension limits, and lengths of cable to the middle of the frame beside those that drums hold."""
    middle = [0.5 * (low + high) for low, high in zip(robot.scene.frame_min, robot.scene.frame_max, strict=True)]
    for line in robot.lines:
        name, winch, pull = f"line {line.name!r}:", line.winch, line.tension_limits[1] * line.cables
        turned = pull * winch.drum_radius if winch.drum_radius else math.inf
        least = 0.03 * turned if winch.drum_radius else 0.0
        away, room = line.cables * line.advantage * math.dist(line.exit_point, middle), winch.capacity or math.inf
        what = f"{name} cable to the middle of the frame, beside winch.capacity = {room:g} m,"
        yield from (
            _Number(f"{name} winch.max_torque", winch.max_torque or 0.0, "N m", least, 100.0 * turned, turned, TORQUES),
            _Number(what, away, "m", 0.0, room, 0.6 * room, LENGTHS),
        )


def _cables(robot: Robot, size: float) -> Iterator[Doubt]:
    """Cables that no material makes; each kind of them once."""
    for line in {line.cable: line for line in reversed(robot.lines)}.values():
        cable, most, name = line.cable, line.tension_limits[1], f"line {line.name!r}: cable."
        mass, diameter = cable.linear_density, cable.diameter
        area = cable.load_section if diameter is None else max(0.25 * math.pi * diameter**2, _LEAST_AREA)
        if cable.section is not None and cable.section > max(mass / 20.0, 1e-6 if mass else (0.1 * size) ** 2):
            unit = likely(cable.section, mass / 3000.0 or 1e-5, {"mm^2": 1e-6, "cm^2": 1e-4}, 30.0)
            yield Doubt(f"{name}section = {cable.section:g} m^2, with {mass:g} kg/m{unit}")
        elif area is not None and mass > 1.02 * STEEL * area:
            unit = likely(mass, 0.3 * STEEL * area, {"g/m": 1e-3}, 30.0)
            yield Doubt(f"{name}linear_density = {mass:g} kg/m has {mass / area:.3g} kg/m^3, over steel's{unit}")
        elif mass * size * robot.m * robot.scene.gravity > _HEAVY * _carried(robot):
            yield Doubt(f"{name}linear_density = {mass:g} kg/m: the cables weigh far more than the load: {mass:g} g/m?")
        if diameter is not None and (diameter > max(0.1 * size, 0.01) or 0.0 < mass < _LOOSE * (area or 0.0)):
            unit = likely(diameter, math.sqrt(mass / 1000.0) or 2e-3, LENGTHS)
            yield Doubt(f"{name}diameter = {diameter:g} m, with {mass:g} kg/m{unit}")
        if most > _STRAIN * cable.stiffness and line.spring is None:
            sentence = _stretched(line, most, "the most that tension_limits allow")
            yield Doubt(sentence, most > 1e4 * cable.stiffness)
        elif area is not None and cable.stiffness > 2e12 * area:
            unit = ": N?" if cable.young_modulus is None else ": MPa?"
            yield Doubt(f"{name}stiffness is {1e-9 * cable.stiffness / area:.3g} GPa, ten times that of steel{unit}")
        if area is not None and cable.breaking_load > 1e10 * area:
            yield Doubt(f"{name}breaking_load = {cable.breaking_load:g} N is more than any material holds: N, not kN?")


def _stretched(line: Line, tension: float, why: str) -> str:
    """The strain of a line's cable at a *tension*, N, in words, with the likely unit of its stiffness."""
    cable, strain = line.cable, 100.0 * tension / line.cable.stiffness
    if cable.young_modulus is None:
        key, unit = "axial_stiffness", likely(cable.stiffness, 200.0 * tension, FORCES, 30.0)
    else:
        key, unit = "young_modulus", likely(cable.young_modulus, 5e10, PRESSURES, 50.0)
    what = f"line {line.name!r}: cable.{key} = {getattr(cable, key):g}"
    return f"{what}: it strains by {strain:.3g} % at {tension:g} N, {why}{unit or ': is it in N or Pa?'}"


def _loads(robot: Robot) -> Iterator[Doubt]:
    """A platform that the lines cannot hold at all, or hardly notice; also with each of its loads."""
    held = sum(line.tension_limits[1] * line.advantage * line.cables for line in robot.lines)
    share = 1.0 if robot.platform.plane is None else 0.5  # a plane carries some of it
    for name in ("", *(load.name for load in robot.platform.loads)):
        loaded = robot.under_load(name) if name else robot
        what = f"load {name!r}: " if name else "platform."
        mass, force = loaded.platform.mass, loaded.platform.force
        weight, pulled = mass * robot.scene.gravity, math.hypot(*force)
        if held < share * math.hypot(force[0], force[1], force[2] - weight):
            whole, given = (f"mass = {mass:g} kg", mass) if weight > pulled else (f"force is {pulled:g} N", pulled)
            slight = max(weight, pulled) < 10.0 * held
            units = ("N" if weight > pulled else "mN", "kgf") if slight else ("g", "kN")
            what += f"{whole}: all lines together pull at most {held:.3g} N"
            yield Doubt(f"{what}: {given:g} {units[0]}, or tension_limits in {units[1]}?")
    load, mass = _carried(robot), robot.platform.mass
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
