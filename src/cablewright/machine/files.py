"""Machine files of the library or of the user, and the part of each that the machine's owner knows."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Any

from cablewright.foundation.errors import InputError, UnknownName, suggestion
from cablewright.foundation.toml_input import is_file, parse_table, read_table, require_schema
from cablewright.foundation.validation import validated
from cablewright.machine.settings import MachineSettings


def load_machine(name_or_path: str | Path) -> MachineSettings:
    """Return the machine of that library name or TOML file, without its table ``[simulation]``.

    For simulations use `load_twin`. Raises `InputError`, one line.
    """
    table, origin = machine_table(name_or_path)
    table.pop("simulation", None)
    return validated(MachineSettings, table, origin)


def machine_table(name_or_path: str | Path) -> tuple[dict[str, Any], str]:
    """Return the whole table of a machine file, and its name in messages. Raises `InputError`."""
    if isinstance(name_or_path, str) and name_or_path in machine_names():
        origin = f"{name_or_path} (library)"
        return parse_table(machine_text(name_or_path), origin), origin
    path = Path(name_or_path)
    if not str(name_or_path).endswith(".toml") and not is_file(path):
        hint = suggestion(str(name_or_path), machine_names())
        raise InputError(f"no machine {str(name_or_path)!r} in the library and no file of that name; {hint}")
    table, _ = read_table(path)
    require_schema(table, path)
    return table, str(path)


def machine_names() -> tuple[str, ...]:
    """Return the names of the machines that come with cablewright, sorted."""
    folder = resources.files("cablewright.machine") / "library"
    return tuple(sorted(item.name.removesuffix(".toml") for item in folder.iterdir() if item.name.endswith(".toml")))


def machine_text(name: str) -> str:
    """Return the TOML text of a library machine. Raises `UnknownName`."""
    if name not in machine_names():
        raise UnknownName("machine", name, machine_names())
    return resources.files("cablewright.machine").joinpath("library", f"{name}.toml").read_text("utf-8")
