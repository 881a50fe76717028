"""Declaration of a command: a function whose parameters are arguments, options, or groups of options.

`command` declares its example and the results that it prints. Its docstring is the text below the command's summary in
the help. A parameter whose type is a class made by `options` is a group of options.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
from copy import copy
from dataclasses import MISSING, dataclass, fields, is_dataclass
from inspect import Parameter, Signature
from typing import Annotated, Any, NamedTuple, TypeVar, dataclass_transform, get_args, get_origin, get_type_hints

import typer
from rich.markup import escape
from typer.core import TyperCommand
from typer.main import get_command

from cablewright.apps.cli.help_examples import FURTHER

_Group = TypeVar("_Group")

_PANELS: dict[type, str | None] = {}
"""The heading of each group of options in the help."""


class DeclaredCommand(NamedTuple):
    """A declared command: its function, the example of its help, its tests, and its results.

    ``answers`` names the classes of the results, ``module:class`` below `cablewright`.
    """

    run: Callable[..., int]
    example: str
    answers: tuple[str, ...]


def command(example: str, *answers: str) -> Callable[[Callable[..., int]], DeclaredCommand]:
    """Declare a function as a command of the command line."""
    return lambda run: DeclaredCommand(run, example, answers)


@dataclass_transform(frozen_default=True, kw_only_default=True)
def options(panel: str | None = None) -> Callable[[type[_Group]], type[_Group]]:
    """Declare a class as a group of options; *panel* is the heading of the group in the help."""

    def declare(group: type[_Group]) -> type[_Group]:
        _PANELS[group] = panel
        return dataclass(frozen=True, kw_only=True)(group)

    return declare


def command_of(declared: DeclaredCommand, name: str, summary: str) -> TyperCommand:
    """Return the typer command of a declared one.

    Its help is *summary* and the docstring; its epilogue lists the examples.
    """
    app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    paragraphs = (summary, *inspect.cleandoc(declared.run.__doc__ or "").split("\n\n"))
    text = "\n\n".join(" ".join(each.split()) for each in paragraphs)
    shown = "\n\n".join(f"cablewright {each}" for each in examples_of(declared, name))
    app.command(name, help=escape(text), epilog=f"Examples:\n\n{escape(shown)}")(_callback(declared.run))
    made = get_command(app)
    assert isinstance(made, TyperCommand)
    return made


def examples_of(declared: DeclaredCommand, name: str) -> list[str]:
    """Return the examples of a command without the name of the program, each once."""
    return list(dict.fromkeys((declared.example, *FURTHER.get(name, ()))))


def _callback(run: Callable[..., int]) -> Callable[..., int]:
    """A function with one parameter for each option, in groups or not, that runs the command."""
    hints = get_type_hints(run, include_extras=True)
    own = {each.name: each for each in inspect.signature(run).parameters.values()}

    def callback(**given: Any) -> int:
        return run(**{name: _value(name, hints[name], given) for name in own})

    parameters = [each for name, one in own.items() for each in _parameters(name, hints[name], one.default)]
    names = [each.name for each in parameters]
    assert len(set(names)) == len(names), f"{run.__name__}: two options have one name"
    callback.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    callback.__annotations__ = {}
    return callback


def _parameters(name: str, hint: Any, default: Any, panel: str | None = None) -> Iterator[Parameter]:
    """An option, or all options of a group."""
    if not (isinstance(hint, type) and is_dataclass(hint)):
        yield Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=_in_panel(hint, panel))
        return
    hints = get_type_hints(hint, include_extras=True)
    for field in fields(hint):
        default = Parameter.empty if field.default is MISSING else field.default
        yield from _parameters(field.name, hints[field.name], default, _PANELS[hint])


def _value(name: str, hint: Any, given: Mapping[str, Any]) -> Any:
    """The value of an option, or a group made of the values of its options."""
    if not (isinstance(hint, type) and is_dataclass(hint)):
        return given[name]
    hints = get_type_hints(hint, include_extras=True)
    return hint(**{field.name: _value(field.name, hints[field.name], given) for field in fields(hint)})


def _in_panel(hint: Any, panel: str | None) -> Any:
    """Return the annotation of an option with its heading in the help; brackets in its text are no markup."""
    if get_origin(hint) is not Annotated:
        return hint
    kind, option = get_args(hint)
    option = copy(option)
    option.help = escape(option.help or "")
    if not isinstance(option, type(typer.Argument())):
        option.rich_help_panel = panel
    return Annotated[kind, option]
