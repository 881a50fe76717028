"""Conversion of log metadata of schema 1, which did not separate the owner's settings from the simulation's."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from cablewright.foundation.errors import InputError
from cablewright.foundation.validation import Description
from cablewright.machine import carried_load, settings
from cablewright.machine.sensors import SENSORS
from cablewright.machine.sensors.lidars import LidarSettings

_TABLES: Final[Mapping[str, type[Description]]] = {
    "drum": carried_load.Drum,
    "winch": settings.WinchSettings,
    "room": settings.RoomSettings,
    **{each.table: each.sheet for each in SENSORS if each.sheet.MOVED},
}


def from_first_schema(head: Mapping[str, Any]) -> dict[str, Any]:
    """Convert a *head* of schema 1, without its key ``schema``, to schema 2 of a simulated machine.

    A key without a counterpart stays where it is, so that it is rejected there by name. Raises `InputError` for keys of
    schema 2.
    """
    for key in ("kind", "simulation", "versions", "epoch"):
        if key in head:
            raise InputError(f"the head's {key}: schema 1 has no such key")
    found = dict(head)
    if not isinstance(found.get("settings"), dict):
        return found
    owner = dict(found["settings"])
    simulation = _taken(owner, settings.MachineSettings)
    for name, kind in _TABLES.items():
        if isinstance(owner.get(name), dict):
            owner[name] = dict(owner[name])
            simulation[name] = _taken(owner[name], kind)
    if isinstance(owner.get("lidars"), dict):
        lidars = {name: dict(lidar) for name, lidar in owner["lidars"].items() if isinstance(lidar, dict)}
        simulation["lidars"] = {name: _taken(lidar, LidarSettings) for name, lidar in lidars.items()}
        owner["lidars"] = owner["lidars"] | lidars
    walk, winch = simulation.get("winch", {}), owner.get("winch")
    if isinstance(winch, dict) and {"radius_walk", "walk_turns"} <= walk.keys():  # the filter's belief was the truth
        winch |= {"radius_deviation": walk["radius_walk"], "radius_turns": walk["walk_turns"]}
    return found | {"settings": owner, "simulation": simulation, "kind": "simulated", "versions": {}}


def _taken(table: dict[str, Any], kind: type[Description]) -> dict[str, Any]:
    """Remove from a *table* of that *kind* the keys that belong into the simulation now, and return them."""
    return {key: table.pop(key) for key in kind.MOVED if key in table}
