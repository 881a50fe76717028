"""WireX and URDF: each number of a robot with each feature is written or named as lost, or the robot is rejected."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from itertools import product
from typing import Any

import numpy as np
import pytest

from cablewright.exchange.translation_result import ExportedFile
from cablewright.exchange.urdf import urdf
from cablewright.exchange.wirex_output import wirex
from cablewright.foundation.errors import InputError
from cablewright.models.support_table import FEATURES, Capability, Coverage, support
from cablewright.robot import Robot
from cases import some
from models import support_examples as examples

DIRECTIONS = ("axis", "normal", "leaves")  # keys of vectors whose length means nothing


def pose_of(robot: Robot) -> np.ndarray:
    """A pose in the plane of the robot, if it has one."""
    pose, plane = np.zeros(robot.n), robot.platform.plane
    if plane is not None:
        pose[:3] = plane.distance * np.array(plane.across)
    return pose


FORMATS: dict[Capability, Callable[[Robot], ExportedFile]] = {
    Capability.WIREX: wirex,
    Capability.URDF: lambda robot: urdf(robot, pose_of(robot)),
}
COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)


def numbers(value: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The way to each number of a dumped robot."""
    if isinstance(value, bool):
        return
    if isinstance(value, int | float):
        yield at
    elif isinstance(value, dict):
        for key, each in value.items():
            yield from numbers(each, (*at, key))
    elif isinstance(value, list | tuple):
        for k, each in enumerate(value):
            yield from numbers(each, (*at, k))


def changed(value: Any, way: tuple[Any, ...]) -> Any:
    """The dumped robot with another number at the end of a *way*."""
    if not way:
        return value + 1 if isinstance(value, int) else 1.013 * value + 1.7e-3
    if isinstance(value, dict):
        return value | {way[0]: changed(value[way[0]], way[1:])}
    return [changed(each, way[1:]) if k == way[0] else each for k, each in enumerate(value)]


def within(value: Any, way: tuple[Any, ...]) -> Any:
    """What is at the end of a *way*."""
    for each in way:
        value = value[each]
    return value


def dropped(robot: Robot, write: Callable[[Robot], ExportedFile]) -> tuple[set[str], int]:
    """The keys of which another number is neither in the file nor named there, and how many were tried."""
    table, body, found, tried = robot.model_dump(by_alias=True), COMMENT.sub("", write(robot).text), set(), 0
    for way in numbers(table):
        parts = [each for each in way if isinstance(each, str)]
        key = ".".join(parts)
        if parts[-1] in DIRECTIONS and np.count_nonzero(within(table, way[:-1])) < 2 and within(table, way):
            continue  # the same direction
        heads = {".".join(parts[:k]) for k in range(1, len(parts) + 1)}
        try:
            made = write(Robot.model_validate(changed(table, way)))
        except (ValueError, InputError):
            continue  # no robot, or one that the format rejects by this number
        named = any(heads & set(re.findall(r"[\w.]+", each)) for each in made.lost)
        tried += 1
        if not named and COMMENT.sub("", made.text) == body:
            found.add(key)
    return found, tried


BOTH = list(product(FORMATS, (True, False)))


@pytest.mark.parametrize(
    ("capability", "body"), [*BOTH[::3], *some([each for each in BOTH if each not in BOTH[::3]], 0)]
)
def test_each_number_is_written_or_named(capability: Capability, body: bool) -> None:
    write, seen = FORMATS[capability], 0
    for feature in FEATURES:
        robot = examples.example(feature.name, body)
        if robot is None:
            continue
        if support(robot, capability).verdict is Coverage.REJECTED:
            with pytest.raises(InputError, match="not supported"):
                write(robot)
            continue
        found, tried = dropped(robot, write)
        assert not found, feature.name
        assert tried > 20, feature.name
        seen += 1
    assert seen > 8
