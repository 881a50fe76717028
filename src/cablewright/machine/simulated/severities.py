"""Severities: how far a simulated machine, its room and its sensors are off what is described.

One of three names, fixed before anything was estimated with them. An owner who knows how good the survey was knows the
standard deviations, and nothing else.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from cablewright.choices import SeverityName
from cablewright.errors import UnknownName
from cablewright.machine.settings import ClockSettings

if TYPE_CHECKING:
    from cablewright.machine.simulated.settings import SimulationSettings, TwinSettings

_LATENCY: Final = 5e-3  # s, by the data sheet of the link
_GAP_EVERY: Final = 60.0  # s
_DRIFT_OF_GAIN: Final = 0.1  # of a load cell's zero in an hour, to its range, over the error of its scale

PARTS: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType({
    "walls": ("wall",),
    "mounts": ("mount_place", "mount_turn"),
    "clock": ("clock_offset", "clock_drift"),
    "zeros": ("line_angle_bias",),
    "people": ("share",),
    "gaps": ("gap_every", "gap_length"),
    "tensions": ("tension_gain", "tension_drift"),
    "creep": ("creep",),
    "hysteresis": ("hysteresis",),
    "sheaves": ("friction",),
    "exits": ("compliance",),
    "gears": ("backlash",),
    "wind": ("force",),
})  # fmt: skip
"""Keys of the parts of a severity."""

OWN: Final = "own"
"""What `severity_of` calls any other numbers than those of a severity."""

MEANINGS: Final[Mapping[str, str]] = MappingProxyType({
    "ideal": "walls, mounts and clocks are exactly as described",
    "typical": "walls, mounts, clocks, zeros, people, gaps of the link and what no model has, by the severity typical",
    "rough": "walls, mounts, clocks, zeros, people, gaps of the link and what no model has, by the severity rough",
    OWN: "walls, mounts, clocks, zeros, people, gaps of the link and what no model has, by the machine's file",
})  # fmt: skip
"""What a severity says of the machine as built."""


def _severity(
    wall: float, turn: float, offset: float, drift: float, bias: float, people: float, gap: float, gain: float
) -> Mapping[str, Mapping[str, float]]:
    """Keys by table. *wall*: mm, also of mounts; *turn* and *bias*: degrees; *offset*: ms; *drift*: ppm; *gap*: s."""
    return MappingProxyType({
        "tolerances": {
            "wall": 1e-3 * wall,
            "mount_place": 1e-3 * wall,
            "mount_turn": math.radians(turn),
            "clock_offset": 1e-3 * offset,
            "clock_drift": 1e-6 * drift,
            "line_angle_bias": math.radians(bias),
            "tension_gain": gain,
            "tension_drift": _DRIFT_OF_GAIN * gain,
            "mass": 0.0,
        },
        "people": {"share": people},
        "wifi": {"gap_every": _GAP_EVERY if gap else 0.0, "gap_length": gap},
    })  # fmt: skip


def _unmodelled(
    creep: float, hysteresis: float, compliance: float, friction: float, backlash: float, wind: float
) -> Mapping[str, Mapping[str, float]]:
    """Keys by table. The first two and *friction*: %; *compliance*: um/N; *backlash*: degrees; *wind*: N."""
    return MappingProxyType({
        "cable": {"creep": 1e-2 * creep, "hysteresis": 1e-2 * hysteresis},
        "exits": {"compliance": 1e-6 * compliance},
        "sheaves": {"friction": 1e-2 * friction},
        "gears": {"backlash": math.radians(backlash)},
        "wind": {"force": wind},
    })  # fmt: skip


SEVERITIES: Final[Mapping[str, Mapping[str, Mapping[str, float]]]] = MappingProxyType({
    "ideal": {
        **_severity(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), **_unmodelled(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    },
    "typical": {
        **_severity(1.0, 0.1, 2.0, 10.0, 0.5, 0.05, 0.2, 0.005), **_unmodelled(0.02, 0.02, 1.0, 1.0, 0.1, 1.0)
    },
    "rough": {
        **_severity(2.0, 0.3, 10.0, 50.0, 1.5, 0.2, 2.0, 0.02), **_unmodelled(0.1, 0.05, 10.0, 3.0, 0.3, 3.0)
    },
})  # fmt: skip
"""Keys of ``[simulation]``, by severity and table."""


def filled(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return a *table* ``[simulation]`` with the values of its severity for keys that it does not give."""
    name, whole = table.get("severity"), dict(table)
    for key, values in SEVERITIES.get(name, {}).items() if isinstance(name, str) else ():
        given = whole.get(key, {})
        if isinstance(given, Mapping):
            whole[key] = {**values, **given}
    return whole


def with_severity(twin: TwinSettings, name: SeverityName, parts: Collection[str] = tuple(PARTS)) -> TwinSettings:
    """Return the machine with the errors of severity *name*, and an owner who knows their standard deviations.

    Other values of these keys are replaced: in ``simulation`` those of `SEVERITIES`, and of ``owner`` the deviations of
    walls, mounts, zeros, scales and the drum's clock. ``ideal``: all are 0. With some of the `PARTS` alone, the others
    are as in ``ideal``. Raises `UnknownName`.
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
    """What an owner knows who knows the tolerances *off*: new values of the owner's tables."""
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
    """Return the severity whose numbers the *simulation* has; `OWN` where there is none, or a clock is to jump."""
    for name, tables in SEVERITIES.items():
        pairs = ((getattr(simulation, key), values) for key, values in tables.items())
        same = all(getattr(table, key) == value for table, values in pairs for key, value in values.items())
        if same and not simulation.clock.jumps:
            return name
    return OWN
