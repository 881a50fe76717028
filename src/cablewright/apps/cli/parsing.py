"""Conversion of option texts to values; an error names the option, the text and the expected form."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import cablewright as cw
from cablewright.apps.cli.output import tell
from cablewright.foundation.errors import EnvironmentFault, InputError, UnknownName

if TYPE_CHECKING:
    from cablewright.foundation.units import Dimension
    from cablewright.printing.beads import Bead

_TOO_FAR = 50.0  # times the size of a robot: in mm most places are farther than that
FREE = "free"
"""How a command line marks a freedom of the pose that gravity decides."""


def numbers(text: str | None, option: str, count: int | None = None, *, free: bool = False) -> list[float] | None:
    """Return the comma-separated numbers of an option; where *free*, `FREE` among them is NaN. Raises `InputError`.

    Unless *count* is None, exactly so many finite numbers.
    """
    if text is None:
        return None
    try:
        values = [math.nan if free and part.strip() == FREE else float(part) for part in text.split(",")]
    except ValueError:
        raise InputError(f"{option} = {text!r}: expected numbers with commas between them, like 0,0,1.5") from None
    if count is not None and (len(values) != count or not all(map(math.isfinite, values))):
        raise InputError(f"{option} = {text!r}: expected {count} finite numbers with commas between them")
    return values


def begin_of(text: str | None, option: str, robot: cw.Robot) -> list[float] | None:
    """Return the numbers of an *option* such as --place: 3 of a position (m), or n of a pose (m, rad); None without it.

    Raises `InputError` for other counts, and for a text that is no number.
    """
    given = numbers(text, option)
    return numbers(text, option, robot.n if given is not None and len(given) != 3 else 3)


def pose_of(text: str | None, robot: cw.Robot) -> list[float] | None:
    """Return the pose of --at, m and rad, for a *robot*; `FREE` is NaN. Raises `InputError`, also for lengths in mm.

    A position outside of the robot, and a rotation of over half a turn, are noted with the units that explain them.
    """
    from cablewright.robot.plausibility import units_inside

    values = numbers(text, "--at", free=True)
    given = values or []
    place, turn = given[:3], math.hypot(*given[3:])
    _require_metres(place, "--at", robot, 1.0, units_inside([place], robot) if len(place) == 3 else {})
    if len(given) == robot.n and turn > math.pi * (1.0 + 1e-6):
        tell(f"note: --at: a rotation by {turn:g} rad is over half a turn; rotation vectors are in rad: are these deg?")
    return values


def lengths_of(text: str, robot: cw.Robot) -> list[float]:
    """Return the value of --lengths, m, of the lines of a *robot*. Raises `InputError`, also for lengths in mm.

    Lengths that reach across the robot and beyond are noted with the units that explain them.
    """
    from cablewright.robot.plausibility import LENGTHS

    values, times = numbers(text, "--lengths") or [], max(line.advantage for line in robot.lines)
    spans = (line.dead_span().length for line in robot.lines if line.winch_exit is not None)
    dead = max((*spans, *(line.dead_length for line in robot.lines)))
    longest, most = max(map(abs, values), default=0.0), 1.25 * times * _size(robot) + dead
    inside = {unit: size for unit, size in LENGTHS.items() if size * longest < most < longest}
    _require_metres(values, "--lengths", robot, times, inside)
    return values


def _size(robot: cw.Robot) -> float:
    """Diagonal of the frame, the exit points and the origin, m."""
    scene = robot.scene
    points = (scene.frame_min, scene.frame_max, (0.0, 0.0, 0.0), *(line.exit_point for line in robot.lines))
    return math.dist(*([pick(axis) for axis in zip(*points, strict=True)] for pick in (min, max)))


def _require_metres(
    values: list[float], option: str, robot: cw.Robot, times: float, inside: Mapping[str, float]
) -> None:
    """Raise `InputError` for a length many *times* as large as the *robot*, but not if it is in mm.

    A nearer one is noted with the units, and their sizes, m, that bring it *inside*.
    """
    from cablewright.foundation.units import spell_length

    size, largest = _size(robot), max((abs(value) for value in values if math.isfinite(value)), default=0.0)
    where = f"{option} = {largest:g}: is in m, and {robot.name!r} is {spell_length(size)} large: are these"
    if _TOO_FAR * times * size < largest < 1e3 * times * size:
        raise InputError(f"{where} mm, is {1e-3 * largest:g} meant?")
    if inside:
        tell(
            f"note: {where} {' or '.join(f'{unit} ({spell_length(each * largest)})' for unit, each in inside.items())}?"
        )


def interval(text: str, option: str) -> tuple[float, float]:
    """Return two finite numbers of an option, the first below the second. Raises `InputError`."""
    low, high = numbers(text, option, 2) or []
    if not low < high:
        raise InputError(f"{option} = {text!r}: expected MIN,MAX with MIN below MAX")
    return low, high


def tension_range(text: str | None) -> tuple[float, float] | None:
    """Return the tension limits of --tension-limits, N. Raises `InputError`."""
    values = numbers(text, "--tension-limits")
    if values is None:
        return None
    if len(values) != 2:
        raise InputError(f"--tension-limits = {text!r}: expected MIN,MAX in N")
    return values[0], values[1]


def quantity(text: str, option: str, dimension: Dimension) -> float:
    """Return a positive quantity of an option: a number in SI or a text with a unit. Raises `InputError`."""
    try:
        plain: str | float = float(text)
    except ValueError:
        plain = text
    try:
        value = dimension.read(plain)
    except ValueError as error:
        raise InputError(f"{option} = {text!r}: {error}") from None
    if not value > 0:
        raise InputError(f"{option} = {text!r}: must be over 0")
    return value


def bead_size(text: str | None) -> Bead | None:
    """Return width and height of --bead, m; a number without a unit is in m. Raises `InputError`."""
    from cablewright.foundation.units import LENGTH
    from cablewright.foundation.validation import validated
    from cablewright.printing.beads import Bead

    if text is None:
        return None
    parts = text.split(",")
    if len(parts) != 2:
        raise InputError(f"--bead = {text!r}: expected WIDTH,HEIGHT, like 1.2mm,0.6mm")
    width, height = (quantity(part.strip(), "--bead", LENGTH) for part in parts)
    return validated(Bead, {"width": width, "height": height}, "--bead")


def rotations(text: str | None) -> list[list[float]] | None:
    """Return the rotation vectors of --orientations, rad. Raises `InputError`."""
    return None if text is None else [numbers(part, "--orientations") or [] for part in text.split(";")]


def named_lengths(text: str, option: str, expected: str) -> list[tuple[str, float]]:
    """Return pairs of a name and a length, m. Raises `InputError` with the *expected* form."""
    return [named_number(part, f"{option} = {text!r}: expected {expected}") for part in text.split(",")]


def named_number(text: str, why: str) -> tuple[str, float]:
    """Return the name and the number of ``NAME=VALUE``. Raises `InputError` with the text *why*."""
    name, equals, value = (each.strip() for each in text.rpartition("="))
    try:
        number = float(value)
    except ValueError:
        name, number = "", 0.0
    if not (equals and name):
        raise InputError(why)
    return name, number


def lasers(text: str | None) -> tuple[cw.Laser, ...]:
    """Return the distances to walls of --laser, m. Raises `InputError`."""
    if text is None:
        return ()
    expected = "WALL=DISTANCE, over 0 and in m, like north=2.345"
    found = named_lengths(text, "--laser", expected)
    if not all(0.0 < distance < math.inf for _, distance in found):
        raise InputError(f"--laser = {text!r}: expected {expected}")
    return tuple(cw.Laser(*each) for each in found)


def slack_excess(robot: cw.Robot, text: str) -> dict[str, float]:
    """Return the excess (m) by line name of --slack. Raises `InputError`.

    A line is given by its name or its number from 1.
    """
    by: dict[str, float] = {}
    for given, value in named_lengths(text, "--slack", f"LINE=EXCESS in m, like {robot.lines[0].name}=0.3 or 1=0.3"):
        name = _line_name(robot, given)
        if name in by:
            raise InputError(f"--slack = {text!r}: line {name!r} is named twice")
        by[name] = value
    return by


def _line_name(robot: cw.Robot, given: str) -> str:
    names = [line.name for line in robot.lines]
    if given in names:
        return given
    if not given.isdecimal() or len(given) > len(str(len(names))):
        raise UnknownName("line", given, names)
    if not 1 <= int(given) <= len(names):
        raise InputError(f"--slack: no line {given}; the lines of {robot.name!r} are 1 to {len(names)}")
    return names[int(given) - 1]


def run_path(out: Path | None, kind: str, *names: str, suffix: str = "") -> Path:
    """Return the path of --out, or else of a new one in runs/ named by the *kind* of run, *names* and *suffix*."""
    from cablewright.running.run_folders import folder_name

    return out or Path("runs") / f"{folder_name(kind, *names)}{suffix}"


def check_suffix(file: Path | None, option: str, *suffixes: str) -> None:
    """Raise `InputError` unless a file that is to be written has one of the *suffixes*.

    Raises `EnvironmentFault` if its folder is not there.
    """
    if file is None:
        return
    if file.suffix.lower() not in suffixes:
        raise InputError(f"{option} = {str(file)!r}: expected a name that ends in {' or '.join(suffixes)}")
    if not file.parent.is_dir():
        raise EnvironmentFault(f"{option} = {str(file)!r}: cannot be written: there is no folder {file.parent}")
