"""How a command is declared: a frozen dataclass whose fields are arguments, options, or groups of options.

The docstring of the class is the text below the command's summary in its help; ``EXAMPLE`` is the line there that tests
run; ``ANSWERS`` names the results that it prints, ``module:class`` below `cablewright`. A field that is itself such a
dataclass is a group of options; ``PANEL`` is the heading of the group in the help.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from copy import copy
from dataclasses import MISSING, Field, fields, is_dataclass
from inspect import Parameter, Signature
from typing import Annotated, Any, ClassVar, Protocol, get_args, get_origin, get_type_hints

import typer
from typer.core import TyperCommand
from typer.main import get_command


class Runnable(Protocol):
    """A command: its fields are what the command line gives."""

    EXAMPLE: ClassVar[str]
    ANSWERS: ClassVar[tuple[str, ...]]

    def run(self) -> int:
        """Do it and return the exit code."""
        ...


def command_of(kind: type[Runnable], name: str, summary: str) -> TyperCommand:
    """The command that a class declares. Its help is *summary* and the docstring; its epilogue is the example."""
    app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    paragraphs = (summary, *inspect.cleandoc(kind.__doc__ or "").split("\n\n"))
    text = "\n\n".join(" ".join(each.split()) for each in paragraphs)
    app.command(name, help=text, epilog=f"Example:  cablewright {kind.EXAMPLE}")(_callback(kind))
    made = get_command(app)
    assert isinstance(made, TyperCommand)
    return made


def _callback(kind: type[Runnable]) -> Callable[..., int]:
    """A function with one parameter for each option, in groups or not, that runs the command."""

    def run(**given: Any) -> int:
        made: Runnable = _made(kind, given)
        return made.run()

    parameters = list(_parameters(kind))
    names = [each.name for each in parameters]
    assert len(set(names)) == len(names), f"{kind.__name__}: two options have one name"
    run.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    run.__annotations__ = {}
    return run


def _parameters(kind: type[Any], panel: str | None = None) -> Iterator[Parameter]:
    hints = get_type_hints(kind, include_extras=True)
    for field in fields(kind):
        hint = hints[field.name]
        if isinstance(hint, type) and is_dataclass(hint):
            yield from _parameters(hint, getattr(hint, "PANEL", None))
            continue
        yield Parameter(field.name, Parameter.KEYWORD_ONLY, default=_default(field), annotation=_in_panel(hint, panel))


def _default(field: Field[Any]) -> Any:
    return Parameter.empty if field.default is MISSING else field.default


def _in_panel(hint: Any, panel: str | None) -> Any:
    """The annotation of an option with the heading under which help lists it."""
    if panel is None or get_origin(hint) is not Annotated:
        return hint
    kind, option = get_args(hint)
    if isinstance(option, type(typer.Argument())):
        return hint
    option = copy(option)
    option.rich_help_panel = panel
    return Annotated[kind, option]


def _made(kind: type[Any], given: dict[str, Any]) -> Any:
    """The dataclass with its groups, from the values by name."""
    hints = get_type_hints(kind, include_extras=True)
    return kind(
        **{
            each.name: _made(hints[each.name], given) if is_dataclass(hints[each.name]) else given[each.name]
            for each in fields(kind)
        }
    )
