"""Keys of a robot file that another format cannot carry."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, Final

from cablewright.robot import Robot

_WHOLE: Final = (
    "bracket", "uncertainty", "platform.loads", "platform.boxes", "platform.retraction", "scene.beams", "lines.guides",
    "lines.shared_winch",
)  # fmt: skip


def keys_given(robot: Robot) -> dict[str, None]:
    """Return the keys of the robot's file, dotted and without indices, each once."""
    return dict.fromkeys(_paths(robot.model_dump(exclude_defaults=True)))


def lost_keys(given: Iterable[str], carried: str) -> list[str]:
    """Return a sentence for each key *given* that is neither *carried* (a text of keys) nor within a table that is."""
    kept = carried.split()
    lost = [key for key in given if not any(key == each or key.startswith(f"{each}.") for each in kept)]
    tables = dict.fromkeys(_table(key) for key in lost if key not in ("schema_version", "platform.kind"))
    return [f"{each}: the format has nothing like it" for each in tables]


def _table(key: str) -> str:
    """Return a key without what is inside lists of parts and optional tables, which are lost as a whole."""
    for whole in _WHOLE:
        if key.startswith(f"{whole}."):
            return whole
    return key


def _paths(value: Any, within: str = "") -> Iterator[str]:
    if isinstance(value, dict):
        for key, each in value.items():
            yield from _paths(each, f"{within}.{key}" if within else key)
    elif isinstance(value, tuple) and value and isinstance(value[0], dict):
        for each in value:
            yield from _paths(each, within)
    else:
        yield within
