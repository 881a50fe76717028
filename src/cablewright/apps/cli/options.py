"""Arguments and options that several commands share."""

from __future__ import annotations

from typing import Annotated

import typer

__all__ = ["AsJson", "Cable", "Limits", "RobotName", "Sheave"]

RobotName = Annotated[str, typer.Argument(metavar="ROBOT", help="A robot's TOML file, or a name that `robots` lists.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object in SI units.")]
Limits = Annotated[
    str | None, typer.Option("--tension-limits", metavar="MIN,MAX", help="Tension limits of every line, N.")
]
Cable = Annotated[str, typer.Option("--cable", help="rigid, elastic or catenary.")]
Sheave = Annotated[
    str | None, typer.Option("--sheave", help="eyelet, swivel or universal-joint; as built when left out.")
]
