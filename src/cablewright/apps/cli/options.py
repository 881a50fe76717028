"""Arguments and options that several commands share."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from cablewright.apps.cli.output import numbers
from cablewright.errors import InputError

if TYPE_CHECKING:
    from cablewright.robot import Robot

__all__ = ["AsJson", "Cable", "Limits", "LoadName", "Retracted", "RobotName", "Sheave", "Wrench", "described"]

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
Retracted = Annotated[float | None, typer.Option("--retraction", metavar="L", help="Retraction length, m.")]


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
