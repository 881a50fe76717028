"""Search for declarations in the modules of a package, so that no list of them is needed."""

from __future__ import annotations

from collections.abc import Iterable
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType
from typing import TypeVar

_Kind = TypeVar("_Kind")


def modules_of(package: str, path: Iterable[str]) -> list[ModuleType]:
    """Import all modules of a *package* of that *path*, its ``__path__``, and return them by name."""
    return [import_module(f"{package}.{found.name}") for found in iter_modules(path)]


def declared(package: str, path: Iterable[str], kind: type[_Kind]) -> list[_Kind]:
    """Return the values of a *kind* that the modules of a *package* define under a name, each once."""
    found = [value for module in modules_of(package, path) for value in vars(module).values()]
    return list(dict.fromkeys(value for value in found if isinstance(value, kind)))
