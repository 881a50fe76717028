"""`robots`, `new`, `schema` and `warm`: library of robots, new robot files, JSON schemas, compiled kernels."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import typer

import cablewright as cw
from cablewright.apps.cli.command import command
from cablewright.apps.cli.options import AsJson
from cablewright.apps.cli.output import answer, tell_compiling
from cablewright.apps.cli.parsing import numbers
from cablewright.foundation.choices import CableName, FileKind, LayoutName
from cablewright.foundation.errors import EnvironmentFault, InputError, suggestion
from cablewright.foundation.results import Figure, Result


@command(
    "robots merlet2023", "apps.cli.robots:RobotList", "apps.cli.robots:LibraryFile", "apps.cli.robots:RobotSupport"
)
def robots_command(
    *,
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="NAME", help="Robot of the library, or with --support a file; without it, list all robots."
        ),
    ] = None,
    support: Annotated[
        bool,
        typer.Option(
            "--support", help="Print which capabilities support the robot, and for each other one an alternative."
        ),
    ] = False,
    as_json: AsJson = False,
) -> int:
    """To start your own robot from one of them: `cablewright robots NAME > mine.toml`."""
    from cablewright.robot import library_text

    if support:
        if name is None:
            raise InputError("--support: give the NAME of a robot, or its file")
        return answer(RobotSupport.of(cw.load(name)), as_json)
    if name is not None:
        return LibraryFile(name, library_text(name)).show(as_json)
    return answer(RobotList(tuple(map(cw.load, cw.library_names()))), as_json)


@command("new workshop --size 4,4,3 --mass 10 --cable dyneema-2mm", "studies.new_robot:NewRobot")
def new_command(
    *,
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the robot and of its new folder.")],
    layout: Annotated[
        LayoutName | None,
        typer.Option(
            "--layout", help="Arrangement of the lines, one of those in docs/robots.md; by default suspended."
        ),
    ] = None,
    size: Annotated[
        str | None,
        typer.Option(
            "--size",
            metavar="X,Y,Z",
            help="Sides X,Y,Z of the frame up to the highest exit points, m, or X,Z for a planar robot; by default "
            "4,4,3.",
        ),
    ] = None,
    mass: Annotated[
        float | None, typer.Option("--mass", metavar="KG", help="Mass of the platform, kg; by default 10.")
    ] = None,
    cable: Annotated[
        CableName | None,
        typer.Option(
            "--cable",
            help="Cable of all lines, by its name in the table of cables in docs/robots.md; by default dyneema-2mm.",
        ),
    ] = (None),
    lines: Annotated[
        int | None, typer.Option("--lines", metavar="N", help="Number of lines; by default that of the layout.")
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Creates a folder with a robot file, the file of a simulated machine, and a first part that the robot can print.

    On a terminal the command asks for missing options; otherwise it takes defaults. The files mark all assumed numbers.
    """
    from cablewright.robot.cable_table import CABLES
    from cablewright.robot.new_robot import LAYOUTS, Outline
    from cablewright.studies.new_robot import new_robot

    people = sys.stdin.isatty() and sys.stderr.isatty() and not as_json

    def ask(question: str, default: object, read: Callable[[str], Any]) -> Any:
        return _asked(question, str(default), read) if people else read(str(default))

    arranged = layout or ask(f"layout ({', '.join(LAYOUTS)})", Outline.layout, _one_of(LAYOUTS))
    form, usual = ("X,Z", Outline.size[::2]) if arranged == "planar" else ("X,Y,Z", Outline.size)

    def sides(text: str) -> list[float]:
        return numbers(text, "--size", form.count(",") + 1) or []

    x, *y, z = ask(f"size {form}, m", ",".join(f"{side:g}" for side in usual), sides) if size is None else sides(size)
    outline = Outline(
        name=name,
        layout=arranged,
        size=(x, y[0] if y else 0.0, z),
        mass=ask("mass of the platform, kg", Outline.mass, float) if mass is None else mass,
        cable=cable or ask(f"cable ({', '.join(CABLES)})", Outline.cable, _one_of(CABLES)),
        lines=ask("number of lines", LAYOUTS[arranged].lines, int) if lines is None else lines,
    )
    return answer(new_robot(outline), as_json)


@command("schema job")
def schema_command(
    *,
    kind: Annotated[
        FileKind, typer.Argument(metavar="[KIND]", help="Kind of file whose JSON schema is printed.")
    ] = "robot",
) -> int:
    """An editor with the schema completes keys and marks errors."""
    from cablewright.apps.schemas import json_schema

    typer.echo(json.dumps(json_schema(kind), indent=2))
    return 0


@command("warm", "apps.cli.robots:Warmed")
def warm_command(
    *,
    as_json: AsJson = False,
) -> int:
    """Compiles the kernels that most commands need, in several processes.

    The cache depends on the versions of cablewright, Python and Numba, and on the processor.
    """
    from cablewright.apps.compilation import TASKS, prepare
    from cablewright.kernels.cache import open_folder

    begin, folder = time.monotonic(), open_folder()
    if folder is None or not os.access(folder, os.W_OK):
        raise EnvironmentFault(
            f"compiled kernels cannot be saved on this computer: {folder or 'no folder'} cannot be written to"
        )
    prepare(tuple(TASKS), tell_compiling)
    return answer(Warmed(tuple(TASKS), time.monotonic() - begin, str(folder)), as_json)


@dataclass(frozen=True)
class Warmed(Result):
    """Result of `warm`: kernels that are compiled."""

    FIGURES: ClassVar = (
        Figure("kernels", "", "What is compiled."),
        Figure("seconds", "s", "Time that it took.", digits=2),
        Figure("folder", "", "Where it is kept."),
    )

    kernels: tuple[str, ...]
    seconds: float
    folder: str


def _asked(question: str, default: str, read: Callable[[str], Any]) -> Any:
    """The answer of the person at the terminal, asked again until it can be read."""

    def heard(text: str) -> Any:
        try:
            return read(text)
        except (InputError, ValueError) as reason:
            raise typer.BadParameter(str(reason)) from None

    return typer.prompt(question, default=default, value_proc=heard, err=True)


def _one_of(names: Iterable[str]) -> Callable[[str], str]:
    """A reader of one of these names."""

    def read(text: str) -> str:
        if text not in names:
            raise InputError(suggestion(text, names))
        return text

    return read


@dataclass(frozen=True, repr=False)
class RobotList(Result):
    """The robots of the library."""

    FIGURES: ClassVar = (
        Figure("robots", "", "The robots of the library.", parts=(
            Figure("name", "", "Name of the robot."),
            Figure("lines", "1", "Number of lines.", "m"),
            Figure("freedoms", "1", "Degrees of freedom of the platform: 3 of a point, 6 of a rigid one.", "n"),
            Figure("description", "", "Description of the robot in a sentence."),
        )),
    )  # fmt: skip

    robots: tuple[cw.Robot, ...]


@dataclass(frozen=True)
class RobotSupport(Result):
    """Which commands and features support a robot."""

    FIGURES: ClassVar = (
        Figure("robot", "", "Name of the robot."),
        Figure("capabilities", "", "Each capability.", parts=(
            Figure("capability", "", "What is done with the robot."),
            Figure("verdict", "", "works, not checked, lost or rejected."),
            Figure("because", "", "What of the robot decides it."),
            Figure("instead", "", "Alternative, or the omitted effect."),
        )),
    )  # fmt: skip

    robot: str
    capabilities: tuple[dict[str, str], ...]

    @classmethod
    def of(cls, robot: cw.Robot) -> RobotSupport:
        """Return which capabilities support a robot, see `cablewright.models.support_table`."""
        from cablewright.models.support_table import Capability, support

        found = ((capability, support(robot, capability)) for capability in Capability)
        rows = ({"capability": str(of), **{key: str(each) for key, each in vars(cell).items()}} for of, cell in found)
        return cls(robot.name, tuple(rows))


@dataclass(frozen=True, repr=False)
class LibraryFile(Result):
    """A robot or machine file of the library."""

    FIGURES: ClassVar = (
        Figure("name", "", "Name of the described object."),
        Figure("file", "", "Text of the TOML file, with its comments."),
    )

    name: str
    file: str

    def show(self, as_json: bool) -> int:
        """Print the text of the file alone, or one JSON object; return the exit code."""
        if as_json:
            return answer(self, as_json)
        typer.echo(self.file, nl=False)
        return 0
