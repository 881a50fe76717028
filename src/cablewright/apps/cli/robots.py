"""`robots` and `schema`: the library of robots, and the JSON Schema of robot files."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

import typer

from cablewright.apps.cli.options import AsJson
from cablewright.apps.cli.output import answer
from cablewright.choices import FileKind
from cablewright.results import Figure, Result

if TYPE_CHECKING:
    from cablewright.robot import Robot


@dataclass(frozen=True, kw_only=True)
class RobotsCommand:
    """Start your own description from one of them: `cablewright robots NAME > mine.toml`."""

    EXAMPLE: ClassVar = "robots merlet2023"
    ANSWERS: ClassVar = ("apps.cli.robots:RobotList", "apps.cli.robots:LibraryFile")

    name: Annotated[
        str | None, typer.Argument(metavar="NAME", help="Robot whose file is printed; without it, all are listed.")
    ] = None
    as_json: AsJson = False

    def run(self) -> int:
        """Print the list, or the file."""
        from cablewright.robot import library_names, library_text, load

        if self.name is not None:
            return LibraryFile(self.name, library_text(self.name)).show(self.as_json)
        return answer(RobotList(tuple(map(load, library_names()))), self.as_json)


@dataclass(frozen=True, kw_only=True)
class SchemaCommand:
    """An editor that knows it completes keys of a file and marks errors."""

    EXAMPLE: ClassVar = "schema job"
    ANSWERS: ClassVar = ()

    kind: Annotated[FileKind, typer.Argument(metavar="[KIND]", help="Kind of the file.")] = "robot"

    def run(self) -> int:
        """Print it."""
        from cablewright.apps.schemas import json_schema

        typer.echo(json.dumps(json_schema(self.kind), indent=2))
        return 0


@dataclass(frozen=True, repr=False)
class RobotList(Result):
    """The robots of the library."""

    FIGURES: ClassVar = (
        Figure("robots", "", "The robots of the library.", parts=(
            Figure("name", "", "Name of the robot."),
            Figure("lines", "1", "Number of lines.", "m"),
            Figure("freedoms", "1", "Freedoms of the platform: 3 of a point, 6 of a body.", "n"),
            Figure("description", "", "What the robot is, in a sentence."),
        )),
    )  # fmt: skip

    robots: tuple[Robot, ...]


@dataclass(frozen=True, repr=False)
class LibraryFile(Result):
    """A file of the library."""

    FIGURES: ClassVar = (
        Figure("name", "", "Name of what the file describes."),
        Figure("file", "", "Text of the TOML file, with its comments."),
    )

    name: str
    file: str

    def show(self, as_json: bool) -> int:
        """Print the text alone, or one JSON object; return the exit code."""
        if as_json:
            return answer(self, as_json)
        typer.echo(self.file, nl=False)
        return 0
