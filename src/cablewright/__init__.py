"""cablewright models, checks, calibrates and runs cable-driven parallel robots that print large parts.

The file `__init__.pyi` beside this one declares the public names, each once. A name is loaded when it is first used,
so that a description alone (`cablewright.robot`) costs neither Numba nor plotting. The page Reference of the
documentation lists the names by subject.
"""

import ast
from importlib import import_module
from inspect import isfunction
from pathlib import Path
from typing import Any

from cablewright.foundation.argument_checks import checked
from cablewright.foundation.errors import suggestion
from cablewright.foundation.results import Pictured, Result

_HOMES = {
    alias.name: str(node.module)
    for node in ast.parse(Path(__file__).with_suffix(".pyi").read_text("utf-8")).body
    if isinstance(node, ast.ImportFrom)
    for alias in node.names
}
"""The module of each public name, as type checkers read it in the stub."""

__all__ = sorted(_HOMES)  # a list, by `sorted`


def _draw(result: Pictured, *file: Any, **look: Any) -> Any:
    from cablewright.apps.pictures.gallery import draw

    return draw(result, *file, **look)


def _html(result: Result) -> str:
    from cablewright.apps.notebook_display import result_html

    return result_html(result)


Pictured.draw, Result.html = _draw, _html


def __getattr__(name: str) -> object:
    """Return the value of a public name, whose module is imported when the name is first used (PEP 562)."""
    if name not in _HOMES:
        raise AttributeError(f"module 'cablewright' has no attribute {name!r}; {suggestion(name, _HOMES)}")
    value = getattr(import_module(_HOMES[name]), name)
    if isfunction(value):
        value = checked(value, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return the public names, loaded or not."""
    return __all__
