"""Tables of severities: standard deviations of a simulated machine, its room and its sensors, for three names.

They were fixed before anything was estimated with them. An owner who knows how good the survey was knows the standard
deviations, and nothing else.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final

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
"""Tolerances of the machine as built, by severity."""


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
    """Return a *table* ``[simulation]`` completed with the values of its severity."""
    name, whole = table.get("severity"), dict(table)
    for key, values in SEVERITIES.get(name, {}).items() if isinstance(name, str) else ():
        given = whole.get(key, {})
        if isinstance(given, Mapping):
            whole[key] = {**values, **given}
    return whole
