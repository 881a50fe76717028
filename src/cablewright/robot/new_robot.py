"""Text of a new robot's file from size, layout, mass and cable; all other values assumed, and marked so."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

from cablewright.foundation.choices import CableName, LayoutName
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.units import FORCE, LENGTH, SPEED, TORQUE, three_digits
from cablewright.robot.cable_table import CABLES, StockCable
from cablewright.robot.line import MAX_LINES

GRAVITY: Final = 9.81
LOW: Final = 0.25  # height of low exit points, over that of the high ones
TURNS: Final = 80  # of a drum that holds all cable in one layer, at most
SMALLEST, LARGEST = 0.5, 100.0  # m, of a side of the frame

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,59}", re.ASCII)

Point = tuple[float, float, float]


@dataclass(frozen=True)
class LineEnds:
    """Ends of a line: its exit point, and its platform point on a body, m."""

    name: str
    exit_point: Point
    platform_point: Point | None = None


@dataclass(frozen=True, kw_only=True)
class Outline:
    """Requirements of a new robot. Raises `InputError` for those that no such robot can meet.

    ``size``: the box between the floor and the exit points, along x, y and z, m; a planar robot has no extent along y.
    ``lines``: None for those that the layout has by itself.
    """

    name: str
    layout: LayoutName = "suspended"
    size: Point = (4.0, 4.0, 3.0)
    mass: float = 10.0
    cable: CableName = "dyneema-2mm"
    lines: int | None = None

    def __post_init__(self) -> None:
        if _NAME.fullmatch(self.name) is None:
            why = "must be 1 to 60 letters, digits, - and _, and begin with a letter or digit"
            raise InputError(f"name = {self.name[:80]!r}: {why}")
        if self.layout not in LAYOUTS:
            raise UnknownName("layout", self.layout, LAYOUTS)
        if self.cable not in CABLES:
            raise UnknownName("cable", self.cable, CABLES)
        self._require_size()
        low, high = self.form.counts
        if not low <= self.count <= high:
            allowed = str(low) if low == high else f"{low} to {high}"
            raise InputError(f"lines = {self.count}: layout {self.layout} has {allowed}")
        if not 0.0 < self.mass < math.inf:
            raise InputError(f"mass = {self.mass:g} kg: must be a finite number over 0")
        self._require_strength()

    @property
    def form(self) -> Layout:
        """Layout of the lines."""
        return LAYOUTS[self.layout]

    @property
    def count(self) -> int:
        """Number of lines."""
        return self.form.lines if self.lines is None else self.lines

    @property
    def stock(self) -> StockCable:
        """Cable of the lines, from the table."""
        return CABLES[self.cable]

    def _require_size(self) -> None:
        flat = self.layout == "planar"
        for axis, side in zip("xyz", self.size, strict=True):
            if flat and axis == "y":
                if side != 0.0:
                    raise InputError(f"size along y = {side:g} m: a planar robot has 0")
            elif not SMALLEST <= side <= LARGEST:
                raise InputError(f"size along {axis} = {side:g} m: must be {SMALLEST:g} to {LARGEST:g} m")

    def _require_strength(self) -> None:
        """One line bears the platform alone near its exit point, with half as much again for the others' pull."""
        needed = 1.5 * self.mass * GRAVITY
        if self.stock.max_tension < needed:
            strong = [name for name, each in CABLES.items() if each.max_tension >= needed]
            raise InputError(
                f"cable = {self.cable!r}: bears {self.stock.max_tension:.0f} N, a fifth of its breaking load; a "
                f"platform of {self.mass:g} kg needs {needed:.0f} N, 1.5 times its weight; "
                f"{'enough: ' + ', '.join(strong) if strong else 'none of the table does'}"
            )


@dataclass(frozen=True)
class Layout:
    """A layout of lines: ``lines`` by default, ``counts`` that are allowed (min, max), and their positions."""

    summary: str
    lines: int
    counts: tuple[int, int]
    places: Callable[[Outline], list[LineEnds]]
    body: bool = False
    swivel: bool = True
    zeroed: bool = False


def robot_file(outline: Outline) -> str:
    """Return the text of the robot file, with assumed values marked so, and an uncertainty table named assumed."""
    form, stock = outline.form, outline.stock
    places = form.places(outline)
    longest = math.dist((0.0, 0.0, 0.0), outline.size) + (outline.size[2] if form.swivel else 0.0)
    capacity = float(math.ceil(1.5 * longest))
    drum = _up(max(stock.least_radius, capacity / (2.0 * math.pi * TURNS)))
    tension = three_digits(stock.max_tension)
    accuracy = min(2e-3, 1e-3 * max(outline.size))
    speed = three_digits(math.dist((0.0, 0.0, 0.0), outline.size) / 10.0)
    low, high = _frame(outline)
    return _TEMPLATE.format(
        name=outline.name,
        description=form.summary[0].upper() + form.summary[1:],
        low=_point(low),
        high=_point(high),
        platform=_platform(outline),
        cable=stock.table,
        sheave=_SWIVEL.format(radius=LENGTH.write(_up(stock.least_radius), "mm")) if form.swivel else _EYELET,
        drum=LENGTH.write(drum, "mm"),
        speed=SPEED.write(speed, "m/s"),
        torque=TORQUE.write(three_digits(1.2 * tension * drum), "N m"),
        capacity=LENGTH.write(capacity, "m"),
        min_tension=FORCE.write(three_digits(max(0.5, 0.01 * outline.mass * GRAVITY)), "N"),
        max_tension=FORCE.write(tension, "N"),
        factor=list(stock.modulus),
        exit=LENGTH.write(three_digits(accuracy), "mm"),
        zeroed=_ZEROED if form.zeroed else "",
        offset=LENGTH.write(three_digits(0.25 * accuracy), "mm"),
        lines="\n".join(_line(each, form.swivel) for each in places),
    )


def _suspended(outline: Outline) -> list[LineEnds]:
    return [LineEnds(str(k + 1), at) for k, at in enumerate(_corners(outline, outline.count, outline.size[2]))]


def _over_middle(outline: Outline) -> list[LineEnds]:
    low = _corners(outline, outline.count - 1, LOW * outline.size[2])
    return [
        *(LineEnds(f"low-{k + 1}", at) for k, at in enumerate(low)),
        LineEnds("over-middle", (0.0, 0.0, outline.size[2])),
    ]


def _planar(outline: Outline) -> list[LineEnds]:
    half, top = 0.5 * outline.size[0], outline.size[2]
    bottom = round(LOW * top, 4)
    heights = {"top-left": top, "top-right": top, "low-right": bottom, "low-left": bottom}
    return [LineEnds(name, (-half if name.endswith("left") else half, 0.0, z)) for name, z in heights.items()]


def _body(outline: Outline) -> list[LineEnds]:
    """Two lines from each corner, crossed as those of CoGiRo, so that they hold the rotation too."""
    x, y, z = 0.5 * outline.size[0], 0.5 * outline.size[1], outline.size[2]
    b, e = half_edge(outline), 0.04 * min(outline.size[:2])
    first = [
        ((e - x, -y, z), (b, -b, 0.0)),
        ((-x, e - y, z), (-b, 0.7 * b, 2.0 * b)),
        ((-x, y - e, z), (-b, -0.55 * b, 0.0)),
        ((e - x, y, z), (b, 0.7 * b, 2.0 * b)),
    ]
    turned = [((-a[0], -a[1], a[2]), (-p[0], -p[1], p[2])) for a, p in first]
    return [LineEnds(str(k + 1), a, p) for k, (a, p) in enumerate([*first, *turned])]


def half_edge(outline: Outline) -> float:
    """Return half the edge, m, of the cube assumed for a body: a 22nd of the frame's shorter side, as CoGiRo's."""
    return three_digits(min(outline.size[:2]) / 22.0)


LAYOUTS: Final[Mapping[str, Layout]] = MappingProxyType({
    "suspended": Layout("a point, suspended on lines from above", 4, (3, MAX_LINES), _suspended),
    "over-middle": Layout(
        "a point between low lines and one over the middle, as of Hangprinters", 4, (4, MAX_LINES), _over_middle,
        swivel=False, zeroed=True,
    ),
    "body": Layout("a body, suspended on 8 crossed lines, as CoGiRo", 8, (8, 8), _body, body=True),
    "planar": Layout("a point in a vertical plane on 4 lines", 4, (4, 4), _planar, swivel=False),
})  # fmt: skip
"""Layouts by name."""


def _corners(outline: Outline, count: int, height: float) -> list[Point]:
    """Corners of a regular polygon, stretched to all sides of the frame, counter-clockwise from the south-west."""
    turns = [2.0 * math.pi * (k + 0.5) / count + math.pi for k in range(count)]
    x = _stretched([math.cos(turn) for turn in turns], outline.size[0])
    y = _stretched([math.sin(turn) for turn in turns], outline.size[1])
    return [(x[k], y[k], round(height, 4)) for k in range(count)]


def _stretched(values: list[float], side: float) -> list[float]:
    """Numbers mapped so that the smallest and the largest are half a *side* from 0, to 0.1 mm."""
    low, high = min(values), max(values)
    return [round(side * ((value - low) / (high - low) - 0.5), 4) for value in values]


def _frame(outline: Outline) -> tuple[Point, Point]:
    """The box of the platform: a twentieth inside of the exit points, and below them by a tenth."""
    margin = 4.0 * outline.stock.least_radius if outline.form.swivel else 0.0
    x, y = (three_digits(0.5 * side - max(0.05 * side, margin)) for side in outline.size[:2])
    if outline.layout == "planar":
        y = 0.01
    if min(x, y) <= 0.0:
        raise InputError(f"size = {outline.size}: too small for sheaves of {LENGTH.write(margin / 4.0, 'mm')}")
    return (-x, -y, 0.0), (x, y, three_digits(0.9 * outline.size[2]))


def _platform(outline: Outline) -> str:
    mass = f'mass = "{outline.mass:g} kg"'
    if not outline.form.body:
        return f'kind = "point"\n{mass}'
    b = half_edge(outline)
    inertia = three_digits(outline.mass * (2.0 * b) ** 2 / 6.0)
    return _CUBE.format(mass=mass, edge=LENGTH.write(2.0 * b, "mm"), half=b, below=-b, inertia=inertia)


def _line(place: LineEnds, winch_below: bool) -> str:
    text = f'[[lines]]\nname = "{place.name}"\nexit_point = {_point(place.exit_point)}\n'
    if winch_below:
        text += f"winch_exit = {_point((*place.exit_point[:2], 0.0))}  # assumed: on the floor, straight below\n"
    if place.platform_point is not None:
        text += f"platform_point = {_point(place.platform_point)}  # assumed: crossed as those of CoGiRo\n"
    return text


def _point(point: Point) -> str:
    return "[" + ", ".join(f"{round(each, 4) + 0.0!r}" for each in point) + "]"


def _up(radius: float) -> float:
    """Rounded up to 5 mm."""
    return round(0.005 * math.ceil(radius / 0.005 - 1e-9), 3)


_SWIVEL: Final = """\
kind = "swivel"                # turns freely about the vertical through the exit point
radius = "{radius}"            # assumed: the least for this cable; to the cable's centre line
wrap = "over\""""

_EYELET: Final = """\
kind = "eyelet"                # assumed: a ring that the cable slides through, so that a line may hang straight down"""

_CUBE: Final = """\
kind = "rigid"
{mass}
# assumed: a cube of {edge}; the platform's origin is in the middle of its underside
centre_of_mass = [0.0, 0.0, {half}]
inertia = [{inertia}, {inertia}, {inertia}]
nozzle = [0.0, 0.0, {below}]   # assumed: half an edge below the underside"""

_ZEROED: Final = """\
zeroed_at = [0.0, 0.0, 0.0]   # assumed: all lines are pulled taut and zeroed with the nozzle there
"""

_TEMPLATE: Final = """\
# {description}. Lengths without a unit are in m; z points up, the origin is in the middle of the floor.
# Size, layout, mass and cable are as requested. Numbers marked "assumed" are not: replace them by your own data.
# All keys: docs/robots.md, or `cablewright schema robot` for an editor.

schema = 1
name = "{name}"
description = "{description}"

[scene]
gravity = "9.81 m/s^2"
frame_min = {low}   # assumed: the box in which the platform may be
frame_max = {high}   # assumed

[platform]
{platform}

[cable]
{cable}
[sheave]
{sheave}

[winch]
drum_radius = "{drum}"         # assumed: one layer of cable
max_speed = "{speed}"          # assumed: of the cable
max_torque = "{torque}"        # assumed: at the drum, for the largest tension and a fifth more
capacity = "{capacity}"        # assumed: of cable

[line]
# assumed: 1 % of the weight, or 0.5 N if that is more; a fifth of the breaking load
tension_limits = ["{min_tension}", "{max_tension}"]  # assumed

# How far the true numbers may be from these. All assumed, until something is measured: then write what you know, and
# another name. `cablewright calibrate` finds exit points, `cablewright modulus` the cable's stiffness.
[uncertainty]
name = "assumed"
{zeroed}
[[uncertainty.parameters]]
name = "exit_point"
plus_minus = "{exit}"          # along each axis: 1 mm for a metre of the longest side, up to 2 mm

[[uncertainty.parameters]]
name = "modulus"
factor = {factor}

[[uncertainty.parameters]]
name = "length_offset"
plus_minus = "{offset}"

[[uncertainty.parameters]]
name = "mass"
factor = [0.98, 1.02]

# Measure the exit points: they decide the position error of the machine. Their box has the size that you gave; where
# they are on its
# sides, and that low ones are at a quarter of its height, is assumed.

{lines}"""
