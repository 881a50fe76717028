"""`robots` and `schema`: what can be described, and what is described already."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from cablewright.apps.cli.options import AsJson
from cablewright.apps.cli.output import print_json


def robots(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="Print this robot's file.")] = None,
    as_json: AsJson = False,
) -> None:
    """List the robots of the library, or print the file of one."""
    from cablewright.robot import library_names, library_text, load

    if name is not None:
        text = library_text(name)
        if as_json:
            print_json({"name": name, "file": text})
        else:
            typer.echo(text, nl=False)
        return
    known = [load(each) for each in library_names()]
    if as_json:
        rows = [{"name": r.name, "lines": r.m, "freedoms": r.n, "description": r.description} for r in known]
        print_json({"robots": rows})
        return
    for robot in known:
        typer.echo(f"{robot.name:<16} {robot.m} lines, {robot.n} freedoms  {robot.description}")


def schema() -> None:
    """Print the JSON Schema of robot files, for editors."""
    from cablewright.robot import json_schema

    typer.echo(json.dumps(json_schema(), indent=2))
