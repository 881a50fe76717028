"""Export of robots in the plane of a wall or board to their firmware's settings, in the layout of the imports.

FluidNC's WallPlotter and Maslow 4, Marlin's polargraph and the classic Maslow. Lengths are mm, x to the right, y up.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final

from cablewright.exchange.losses import keys_given, lost_keys
from cablewright.exchange.maslow import CORNERS, TILT, middle, require_unmirrored
from cablewright.exchange.millimetres import to_mm, turn_of_radius
from cablewright.exchange.translation_result import ExportedFile, Notes
from cablewright.exchange.walls.maslow_classic import LEAN
from cablewright.exchange.walls.two_belts import ORIGIN
from cablewright.foundation.errors import InputError, printable
from cablewright.robot import Line, Robot

_EXITS: Final = "name lines.name lines.exit_point lines.platform_point lines.sheave.kind platform.plane uncertainty"
_TIDY: Final = 10  # decimals of m: rounding of a coordinate in a leaning plane is below any length
_OFF_ZERO: Final = 1e-6  # m
_PER_MINUTE: Final = 6e4  # mm/min of m/s

Place = tuple[float, float, float]


class _Board:
    """Exit points of a robot as its plane has them, m: x level, y up the plane, z out of it.

    From the nozzle at the zero of G-code in the plane; without one, as of a Maslow, from that at the world's origin.
    """

    def __init__(self, robot: Robot, program: str, count: int, *, has_own_zero: bool = False) -> None:
        plane = robot.platform.plane
        name, m, winches = repr(robot.name), robot.m, robot.winches
        if plane is None or robot.n != 3:
            raise InputError(
                f"robot {name} has no point platform in a platform.plane, in which {program} moves: export klipper"
            )
        if (m, winches) != (count, count):
            raise InputError(f"robot {name} has {m} lines on {winches} winches; {program} has {count}: export klipper")
        if not robot.has_plain_belts:
            raise InputError(
                f"robot {name}: has lines.advantage over 1 or lines.guides; {program} supports only straight belts: "
                "export klipper"
            )
        self.robot, self.program, self.notes = robot, program, Notes()
        self.x, self.y = plane.directions
        self.out, self.distance = plane.across, plane.distance
        self.zero = ORIGIN if has_own_zero else plane.gcode_zero or ORIGIN
        self.own_zero = plane.gcode_zero
        if self.own_zero is None:
            self.notes.add(f"job: G-code in the world's coordinates; {program} has X to the right and Y up the plane")
        self.exits = sorted(((self._place(line), line) for line in robot.lines), key=lambda each: each[0][0])

    def _place(self, line: Line) -> Place:
        at = [a - b for a, b in zip(line.exit_point, line.platform_point, strict=True)]
        x, y, z = (sum(a * b for a, b in zip(at, axis, strict=True)) for axis in (self.x, self.y, self.out))
        x, y = x - self._zero_along(self.x), y - self._zero_along(self.y)
        return round(x, _TIDY) + 0.0, round(y, _TIDY) + 0.0, round(z - self.distance, _TIDY) + 0.0

    def _zero_along(self, axis: Place) -> float:
        return sum(a * b for a, b in zip(self.zero, axis, strict=True))

    @property
    def low(self) -> float:
        """The lowest y of the platform, m."""
        ends = zip(self.y, self.robot.scene.frame_min, self.robot.scene.frame_max, strict=True)
        lowest = sum(up * (low if up >= 0.0 else high) for up, low, high in ends)
        return round(lowest - self._zero_along(self.y), _TIDY) + 0.0

    def note_lean(self, degrees: float, program: str) -> None:
        """Note that the lean of the plane differs from the one that the *program* assumes."""
        lean = math.degrees(math.acos(min(1.0, abs(self.y[2]))))
        if abs(lean - degrees) > 0.01:
            self.notes.add(f"platform.plane: leans by {lean:.3g} degrees; {program} is read as {degrees:g}")

    def note_zero(self, middle: tuple[float, float]) -> None:
        """Note a zero of G-code that is not in the *middle* of the anchors, x and y, m, where the firmware has it."""
        if self.own_zero is None:
            return
        x, y = (sum(a * b for a, b in zip(self.own_zero, axis, strict=True)) for axis in (self.x, self.y))
        if math.dist((x, y), middle) > _OFF_ZERO:
            self.notes.add(
                f"platform.plane.gcode_zero: {self.program} has X0 Y0 where the diagonals meet: add "
                f"{1e3 * (x - middle[0]):.4g} mm to X and {1e3 * (y - middle[1]):.4g} mm to Y of G-code"
            )

    def require_level(self) -> float:
        """Return the y of both exit points, m. Raises `InputError` where they differ."""
        (_, left, _), (_, right, _) = (place for place, _ in self.exits)
        if left != right:
            raise InputError(
                f"robot {self.robot.name!r}: exit points are {1e3 * abs(left - right):g} mm apart in height; "
                f"{self.program} has both at one height: export wallplotter, which has two"
            )
        return left

    def written(self, text: str, carried: str, mark: str) -> ExportedFile:
        """Return the file of a *text*, with the values that are not *carried* as comments after a *mark*."""
        if any(place[2] for place, _ in self.exits) and "z" not in carried.split():
            self.notes.add(f"lines.exit_point: out of the plane; {self.program} has belts in it")
        self.notes.add_all(lost_keys(keys_given(self.robot), f"{_EXITS} {carried}"))
        head = "".join(f"{mark} lost: {printable(each)}\n" for each in self.notes.all)
        return ExportedFile(head + text, self.notes.all)

    def speeds(self, axes: Mapping[str, Line]) -> str:
        """Return the largest speed of each axis, as FluidNC has it."""
        known = {axis: line.winch.max_speed for axis, line in axes.items() if line.winch.max_speed is not None}
        rows = (f"  {axis}:\n    max_rate_mm_per_min: {_number(_PER_MINUTE * v)}\n" for axis, v in known.items())
        self.notes.add("axes: steps_per_mm, drivers and pins of the motors: add them, as your board has them")
        return "axes:\n" + "".join(rows) if known else ""


def wall_plotter(robot: Robot) -> ExportedFile:
    """Return FluidNC's configuration of a WallPlotter, but for its motors. Raises `InputError`."""
    board = _Board(robot, "FluidNC's WallPlotter", 2)
    board.note_lean(0.0, "a WallPlotter")
    text = "kinematics:\n  WallPlotter:\n"
    for k, (side, (place, _)) in enumerate(zip(("left", "right"), board.exits, strict=True)):
        keys = {"axis": str(k), "anchor_x": to_mm(place[0]), "anchor_y": to_mm(place[1])}
        text += "".join(f"    {side}_{key}: {value}\n" for key, value in keys.items())
    text += "    segment_length: 10\n"
    axes = dict(zip("xy", (line for _, line in board.exits), strict=True))
    return board.written(text + board.speeds(axes), "lines.winch.max_speed", "#")


def maslow(robot: Robot) -> ExportedFile:
    """Return a Maslow 4's kinematics, of firmware since 2025, but for its motors. Raises `InputError`.

    Its Z is how far a belt falls from the sled to its anchor, or rises: lengths are the same.
    """
    board = _Board(robot, "a Maslow 4", 4, has_own_zero=True)
    (one, two), (three, four) = (sorted(board.exits[k : k + 2], key=lambda each: each[0][1]) for k in (0, 2))
    corners = dict(zip(CORNERS, (two, four, one, three), strict=True))
    places = {corner: (x, y, abs(z)) for corner, ((x, y, z), _) in corners.items()}
    require_unmirrored(places, f"robot {robot.name!r}")
    board.note_zero(middle(places))
    vertical = abs(board.y[2]) > math.sqrt(0.5)
    if vertical:
        board.note_lean(TILT, "Maslow_vertical")
    else:
        board.note_lean(90.0, "a board without Maslow_vertical")
    text = f"Maslow_vertical: {'true' if vertical else 'false'}\nkinematics:\n  MaslowKinematics:\n"
    for corner, place in places.items():
        text += "".join(f"    {corner}{axis}: {to_mm(at)}\n" for axis, at in zip("XYZ", place, strict=True))
    axes = {axis: line for axis, (_, line) in zip("abcd", corners.values(), strict=True)}
    return board.written(text + board.speeds(axes), "lines.winch.max_speed z", "#")


def polargraph(robot: Robot) -> ExportedFile:
    """Return M665 and M203 of Marlin's polargraph, which M500 keeps. Raises `InputError`."""
    board = _Board(robot, "Marlin's polargraph", 2)
    board.note_lean(0.0, "a polargraph")
    top = board.require_level()
    (left, first), (right, second) = board.exits
    words = {"L": left[0], "R": right[0], "T": top, "B": board.low}
    belts = [line.winch.capacity for line in (first, second)]
    if belts[0] is not None and belts[0] == belts[1]:
        words["H"] = belts[0]
    text = "M665 " + " ".join(f"{letter}{to_mm(at)}" for letter, at in words.items()) + "\n"
    speeds = {axis: line.winch.max_speed for axis, line in zip("XY", (first, second), strict=True)}
    if given := [f"{axis}{_number(1e3 * v)}" for axis, v in speeds.items() if v is not None]:
        text += f"M203 {' '.join(given)}\n"
    capacity = " lines.winch.capacity" if "H" in words else ""
    return board.written(f"{text}M500\n", f"scene.frame_min lines.winch.max_speed{capacity}", ";")


def maslow_classic(robot: Robot) -> ExportedFile:
    """Return the $-settings of a classic Maslow's firmware that have its geometry. Raises `InputError`."""
    board = _Board(robot, "a classic Maslow", 2)
    board.note_lean(math.degrees(LEAN), "a classic Maslow")
    y = board.require_level()
    (left, first), (right, second) = board.exits
    height = -2.0 * board.low
    if abs(left[0] + right[0]) > 1e-9 or not 0.0 < height <= 2.0 * y:
        raise InputError(
            f"robot {robot.name!r}: motors at x = {left[0]:g} and {right[0]:g} m, lowest place at y = {board.low:g} m: "
            "a classic Maslow has its origin in the middle of the sheet, below the middle of its motors"
        )
    rows = [
        (1, height, "height of the sheet, mm"), (2, right[0] - left[0], "distance between motors, mm"),
        (3, round(y - 0.5 * height, _TIDY), "motors above the sheet, mm"),
    ]  # fmt: skip
    carried = "scene.frame_min"
    for number, key, what in ((10, "capacity", "chain, mm"), (13, "drum_radius", "chain of a turn, mm")):
        one, other = (getattr(line.winch, key) for line in (first, second))
        if one is not None and one == other:
            rows.append((number, one, what))
            carried += f" lines.winch.{key}"
    text = "".join(f"${k}={turn_of_radius(v) if k == 13 else to_mm(v)} ({what})\n" for k, v, what in rows)
    board.notes.add(
        "platform.mass, lines.cable: sledWeight (N) and chainElongationFactor (1/N) of GroundControl have them"
    )
    return board.written(f"{text}$7=2 (kinematics: triangular)\n", f"{carried} platform.mass", ";")


def _number(value: float) -> str:
    """Return *value* with 12 digits, so that converted units show no rounding errors."""
    return f"{value:.12g}"


WALLS: Final[Mapping[str, Callable[[Robot], ExportedFile]]] = MappingProxyType({
    "wallplotter": wall_plotter, "maslow": maslow, "polargraph": polargraph, "maslow-classic": maslow_classic,
})  # fmt: skip
"""Writers by the name of the format."""
