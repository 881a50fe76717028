"""Arguments and options that several commands share."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Protocol

import typer

from cablewright.apps.cli.output import numbers
from cablewright.errors import InputError, UnknownName

if TYPE_CHECKING:
    from cablewright.analyses.workspace.criterion import RetractionLaw
    from cablewright.robot import Robot

RobotName = Annotated[str, typer.Argument(metavar="ROBOT", help="A robot's TOML file, or a name that `robots` lists.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object in SI units.")]
Limits = Annotated[
    str | None, typer.Option("--tension-limits", metavar="MIN,MAX", help="Tension limits of every line, N.")
]
Cable = Annotated[str, typer.Option("--cable", help="rigid, elastic or catenary.")]
Sheave = Annotated[
    str | None, typer.Option("--sheave", help="eyelet, swivel or universal-joint; as built when left out.")
]
LoadName = Annotated[str | None, typer.Option("--load", metavar="NAME", help="A load of the platform, by name.")]
Wrench = Annotated[
    str | None,
    typer.Option(
        "--wrench", metavar="FX,FY,FZ[,MX,MY,MZ]", help="External force, N, and moment about the origin, N m."
    ),
]
Slack = Annotated[
    str | None,
    typer.Option(
        "--slack",
        metavar="LINE=EXCESS[,LINE=EXCESS]",
        help="Lines that are too long by so much, m; a line by its name, or its number counted from 1.",
    ),
]
StraightCable = Annotated[
    str | None, typer.Option("--cable", help="rigid, elastic or catenary; catenary of static, else rigid.")
]
Box = Annotated[
    str | None, typer.Option("--box", metavar="X0,X1,Y0,Y1,Z0,Z1", help="Where to look, m; the robot's frame.")
]
Point = Annotated[str, typer.Option("--point", help="What is at a place: nozzle, or the platform's origin.")]
Criterion = Annotated[
    str,
    typer.Option(
        "--criterion", help="closed-form, improved-closed-form, exact, capacity, wrench-closure or static (with sag)."
    ),
]
Count = Annotated[str, typer.Option("--count", help="volume, with an error, or nodes of a grid.")]
Grid = Annotated[int | None, typer.Option("--grid", metavar="N", help="Nodes along a side.")]
Tolerance = Annotated[
    float | None, typer.Option("--tolerance", metavar="T", help="Error of the volume as a share of it; 0.002.")
]
Seed = Annotated[int, typer.Option("--seed", help="Seed of the random places.")]
Orientations = Annotated[
    str | None,
    typer.Option("--orientations", metavar="RX,RY,RZ;...", help="Inside under all of these, rotation vectors, rad."),
]
LawOfRetraction = Annotated[
    str | None,
    typer.Option("--retraction-law", metavar="C,D[,LEAST,MOST]", help="Retraction length C z + D with its clamps, m."),
]
Geometric = Annotated[
    bool,
    typer.Option(
        "--geometric/--no-geometric", help="Whether what tension adds to the stiffness counts for the frequencies."
    ),
]
Holding = Annotated[
    str | None,
    typer.Option(
        "--tensions", help="Along the boundary: least, or nearest to the middle of the limits, as the closed forms'."
    ),
]
Plot = Annotated[Path | None, typer.Option("--plot", metavar="FILE.png", help="Write a picture.")]
Retracted = Annotated[float | None, typer.Option("--retraction", metavar="L", help="Retraction length, m.")]


class _Command(Protocol):
    def run(self) -> int: ...


def command(asked: type[_Command]) -> Callable[..., int]:
    """The command whose arguments and options are the fields of a dataclass, and whose help is its docstring."""

    @wraps(asked)
    def run(**given: Any) -> int:
        return asked(**given).run()

    run.__annotations__ = {}  # Typer reads those of the fields, from the signature
    return run


def described(name: str, load: str | None = None, wrench: str | None = None) -> Robot:
    """The robot that a command line speaks of. Raises `InputError`."""
    from cablewright.robot import load as load_robot

    robot = load_robot(name)
    if load is not None:
        robot = robot.under_load(load)
    values = numbers(wrench, "--wrench")
    if values is None:
        return robot
    if len(values) not in (3, 6):
        raise InputError(f"--wrench = {wrench!r}: 3 numbers are wanted, N, or 6, N and N m")
    x, y, z, *moment = values
    a, b, c = moment or (0.0, 0.0, 0.0)
    return robot.under_wrench((x, y, z), (a, b, c))


def check_plot(plot: Path | None) -> None:
    """Raise `InputError` unless --plot names a PNG, or nothing."""
    if plot is not None and plot.suffix.lower() != ".png":
        raise InputError(f"--plot = {str(plot)!r}: a name that ends in .png is wanted")


def turns(text: str | None) -> list[list[float]] | None:
    """Rotation vectors, apart by semicolons."""
    if text is None:
        return None
    return [numbers(part, "--orientations") or [] for part in text.split(";")]


def retracting(length: float | None, law: str | None, point: str) -> float | RetractionLaw | None:
    """What --retraction and --retraction-law ask for. Raises `InputError`."""
    from cablewright.analyses.workspace.criterion import RetractionLaw

    if law is not None and length is not None:
        raise InputError("--retraction and --retraction-law: give one of them")
    values = numbers(law, "--retraction-law")
    if values is None:
        return length
    if len(values) not in (2, 4):
        raise InputError(f"--retraction-law = {law!r}: 2 numbers are wanted, C,D of C z + D in m, or 4 with its clamps")
    slope, intercept, *clamps = values
    low, high = clamps or (None, None)
    return RetractionLaw(slope, intercept, low, high, point)


def slack_excess(robot: Robot, text: str) -> dict[str, float]:
    """Excess (m) by the names of the lines that --slack speaks of. Raises `InputError`."""
    by: dict[str, float] = {}
    for part in text.split(","):
        who, equals, value = part.rpartition("=")
        if not equals:
            raise InputError(f"--slack = {text!r}: LINE=EXCESS is wanted, like {robot.lines[0].name}=0.3 or 1=0.3")
        name = _line_name(robot, who.strip())
        if name in by:
            raise InputError(f"--slack = {text!r}: line {name!r} is named twice")
        try:
            by[name] = float(value)
        except ValueError:
            raise InputError(f"--slack = {text!r}: {value!r} is no number of metres") from None
    return by


def _line_name(robot: Robot, given: str) -> str:
    """The name of the line that a command line calls *given*: its name, or else its number from 1."""
    names = [line.name for line in robot.lines]
    if given in names:
        return given
    if not given.isdecimal() or len(given) > len(str(len(names))):
        raise UnknownName("line", given, names)
    if not 1 <= int(given) <= len(names):
        raise InputError(f"--slack: no line {given}; the lines of {robot.name!r} are 1 to {len(names)}")
    return names[int(given) - 1]
