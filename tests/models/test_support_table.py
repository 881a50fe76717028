"""Every cell of the table of support: an example of each feature, as a point and as a body, for each capability."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from cablewright.exchange import klipper_config, rrf_config
from cablewright.exchange.motion_export import klipper, linuxcnc
from cablewright.foundation.errors import CablewrightError, InputError
from cablewright.models.support_table import (
    FEATURES,
    SPATIAL,
    SUPPORT,
    Capability,
    Coverage,
    cells,
    features,
    require,
    support,
)
from cablewright.robot import Robot, library_names, load
from models import support_examples as examples

BY_NUMBERS = {
    (Capability.WORKSPACE, "few-winches"): "two lines are searched, in their vertical plane",
    (Capability.WORKSPACE, "free-position"): "two lines are searched, in their vertical plane",
    (Capability.WORKSPACE, "few-lines-in-plane"): "two lines are searched, in their vertical plane",
    (Capability.STRAIGHT_WORKSPACE, "few-winches"): "there is no place at which any rotation is balanced",
    (Capability.STRAIGHT_WORKSPACE, "few-lines-in-plane"): "there is no place at which any rotation is balanced",
    **{
        (each, feature): "a point needs all of its three winches"
        for each in (Capability.SLACK, Capability.SLACK_SETS, Capability.TENSION_CHOICE)
        for feature in ("counterweight", "shared-winch")
    },
    (Capability.STRAIGHT_WORKSPACE, "shared-winch"): "rigid lines of a point fit their drum in one plane",
    (Capability.SLACK, "no-gravity"): "the tension limits leave no line slack",
    (Capability.SHAPE, "weightless"): "a line without weight has no shape",
    (Capability.SHAPE, "no-gravity"): "a line without weight has no shape",
    **{
        (each, "shared-winch"): "a point with two of four lines on one drum fits it in one plane only"
        for each in (Capability.CALIBRATION, Capability.ELASTIC_CALIBRATION)
    },
    **{
        (each, "shared-winch"): "a point with two of four lines on one drum follows no square: see `driven.pairs`"
        for each in (Capability.PRINT, Capability.KLIPPER, Capability.LINUXCNC)
    },
}
"""Cells of which the numbers of a robot decide more than the feature: they are not run."""

SLOW = (
    Capability.CHECK,
    Capability.REPRAPFIRMWARE,
    Capability.SLACK_SETS,
    Capability.STRAIGHT_WORKSPACE,
    Capability.TENSION_CHOICE,
    Capability.WORKSPACE,
)


def cells_of(capability: Capability) -> Iterator[tuple[str, Robot, Coverage]]:
    """Each feature, as a point and as a body, with its example."""
    for feature in FEATURES:
        for body in (False, True):
            robot = examples.example(feature.name, body)
            asked = (capability, feature.name)
            counted = feature.name.startswith("over-") and asked not in SUPPORT
            if robot is not None and not counted and asked not in BY_NUMBERS:
                assert feature.name in {each.name for each, _ in features(robot)}
                yield f"{feature.name}, {'body' if body else 'point'}", robot, support(robot, capability).verdict


def fault_of(robot: Robot, capability: Capability) -> str:
    """What happens with the example that its cell does not say; empty where it is as the cell says."""
    cell = support(robot, capability)
    expected = f"{capability}: {cell.because}; not supported. {cell.instead}"
    try:
        found = examples.PROBES[capability](robot)
    except CablewrightError as refused:
        return "" if cell.verdict is Coverage.REJECTED and str(refused) == expected else str(refused)
    if cell.verdict is Coverage.REJECTED:
        return "it is not rejected"
    if isinstance(found, tuple):
        notes = (
            (f"{own.because}: {own.instead}", f"{each.key}: {own.instead}") for each, own in cells(robot, capability)
        )
        return "" if all(set(each) & set(found) for each in notes) else f"a note is missing among {found}"
    return "" if found else f"the answer is {found}"


@pytest.mark.parametrize("capability", [each for each in examples.PROBES if each not in SLOW])
def test_each_cell_is_what_happens(capability: Capability) -> None:
    faults = [(name, fault_of(robot, capability)) for name, robot, _ in cells_of(capability)]
    assert not [each for each in faults if each[1]]


@pytest.mark.parametrize("capability", [each for each in SLOW if any(each is asked for asked, _ in SUPPORT)])
def test_each_rejection_is_what_happens(capability: Capability) -> None:
    rejected = [(name, robot) for name, robot, verdict in cells_of(capability) if verdict is Coverage.REJECTED]
    faults = [(name, fault_of(robot, capability)) for name, robot in rejected]
    assert faults
    assert not [each for each in faults if each[1]]


@pytest.mark.slow
@pytest.mark.parametrize("capability", SLOW)
def test_each_slow_cell_is_what_happens(capability: Capability) -> None:
    others = [(name, robot) for name, robot, verdict in cells_of(capability) if verdict is not Coverage.REJECTED]
    faults = [(name, fault_of(robot, capability)) for name, robot in others]
    assert faults
    assert not [each for each in faults if each[1]]


def test_a_rejected_cell_says_what_to_do_instead() -> None:
    for (capability, feature), cell in SUPPORT.items():
        assert cell.instead, (capability, feature)
        if cell.verdict is Coverage.REJECTED:
            assert cell.instead[0].isupper()
            assert not cell.instead.endswith(".")


def test_formats_have_as_many_lines_as_letters() -> None:
    for most, capability in (
        (len(klipper.LETTERS), Capability.KLIPPER),
        (len(klipper_config.LETTERS), Capability.KLIPPER_WINCH),
        (len(rrf_config.LETTERS), Capability.REPRAPFIRMWARE),
        (len(linuxcnc.LETTERS), Capability.LINUXCNC),
    ):
        assert SUPPORT[capability, f"over-{most}-lines"].verdict is Coverage.REJECTED


def test_every_capability_is_run_and_every_feature_has_an_example() -> None:
    assert set(Capability) - set(examples.PROBES) == {Capability.SERVE}
    names = {feature.name for feature in FEATURES}
    assert {feature for _, feature in SUPPORT} <= names
    for name in names:
        assert examples.example(name, False) or examples.example(name, True), name


@pytest.mark.parametrize("name", library_names())
def test_lines_in_a_plane_have_no_spatial_feature(name: str) -> None:
    robot = load(name)
    found = {feature.name for feature, _ in features(robot)} & set(SPATIAL.split())
    assert all(line.in_plane for line in robot.lines) == (not found)


def test_a_message_names_what_has_the_feature_and_the_way_out() -> None:
    robot = examples.example("guides", body=False)
    assert robot is not None
    with pytest.raises(InputError) as refused:
        require(robot, Capability.SURVEY)
    said = "a survey of exit points: line 'line 0' has guides; not supported. "
    said += "Write the surveyed points into the robot file"
    assert str(refused.value) == said


def test_rigid_platforms_are_served_on_fewer_winches_than_degrees_of_freedom_too() -> None:
    assert support(load("ipanema"), Capability.SERVE).verdict is Coverage.WORKS
    assert support(load("grab-four-lines"), Capability.SERVE).verdict is Coverage.WORKS
    with pytest.raises(InputError, match="has fewer winches than hold its position"):
        require(examples.example("free-position", False), Capability.SERVE)
