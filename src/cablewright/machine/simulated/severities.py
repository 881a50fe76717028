"""Severities: sizes of a simulated machine's errors by name, and the name for given sizes.

An owner who knows how good the survey was knows the standard deviations, and nothing else.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any, Final

from cablewright.foundation.choices import SeverityName
from cablewright.foundation.errors import UnknownName
from cablewright.machine.settings import ClockSettings
from cablewright.machine.simulated.settings import SimulationSettings, TwinSettings
from cablewright.machine.simulated.severity_tables import OWN, PARTS, SEVERITIES

_LATENCY: Final = 5e-3  # s, by the data sheet of the link


def with_severity(twin: TwinSettings, name: SeverityName, parts: Collection[str] = tuple(PARTS)) -> TwinSettings:
    """Return the machine with the errors of severity *name*, and an owner who knows their standard deviations.

    Other values of these keys are replaced: in ``simulation`` those of `SEVERITIES`, and of ``owner`` the deviations of
    walls, mounts, zeros, scales and the platform's clock. ``ideal``: all are 0. With some of the `PARTS` alone, the
    others are as in ``ideal``. Raises `UnknownName`.
    """
    _require_known(name, parts)
    chosen = {key for part in parts for key in PARTS[part]}
    tables = {
        table: {key: SEVERITIES[name][table][key] if key in chosen else value for key, value in values.items()}
        for table, values in SEVERITIES["ideal"].items()
    }
    truth = {key: getattr(twin.simulation, key).model_copy(update=values) for key, values in tables.items()}
    known = _known(twin, tables["tolerances"])
    return twin.with_owner(**known).with_simulation(severity=name, **truth)


def _require_known(name: str, parts: Collection[str]) -> None:
    if name not in SEVERITIES:
        raise UnknownName("severity", name, tuple(SEVERITIES))
    for part in parts:
        if part not in PARTS:
            raise UnknownName("part of a severity", part, tuple(PARTS))


def _known(twin: TwinSettings, off: Mapping[str, float]) -> dict[str, Any]:
    """The settings of an owner who knows the tolerances *off*: new values of the owner's tables."""
    owner = twin.owner
    mounted = {"place_deviation": off["mount_place"], "turn_deviation": off["mount_turn"]}
    clock = {"offset": off["clock_offset"], "drift": off["clock_drift"], "latency": _LATENCY}
    known: dict[str, Any] = {
        "room": owner.room.model_copy(update={"deviation": off["wall"]}),
        "lidars": {key: lidar.model_copy(update=mounted) for key, lidar in owner.lidars.items()},
        "clock": ClockSettings().model_copy(update=clock) if off["clock_offset"] or off["clock_drift"] else None,
    }
    for key, update in {
        "inertial": {"turn_deviation": off["mount_turn"]},
        "line_angles": {"bias": off["line_angle_bias"]},
        "load_cells": {"gain_deviation": off["tension_gain"]},
        "motor_torques": {"gain_deviation": off["tension_gain"]},
    }.items():
        if (sensor := getattr(owner, key)) is not None:
            known[key] = sensor.model_copy(update=update)
    return known


def severity_of(simulation: SimulationSettings) -> str:
    """Return the name of the severity whose numbers the *simulation* has.

    `OWN` where there is none, or a clock jump is planned.
    """
    for name, tables in SEVERITIES.items():
        pairs = ((getattr(simulation, key), values) for key, values in tables.items())
        same = all(getattr(table, key) == value for table, values in pairs for key, value in values.items())
        if same and not simulation.clock.jumps:
            return name
    return OWN
