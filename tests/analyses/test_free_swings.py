"""A real robot on 4, 3 and 2 lines: frequencies of its group's own model and of its recorded swings."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cablewright.analyses.modes import Modes, modes
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.robot import Robot, load
from cablewright.solvers.forward import forward
from cablewright.solvers.inverse import inverse

GRAVITY_AXIS = (0.008698898, -0.005823757, 0.999945205)  # of the source; the library's z axis
TO_LIBRARY = Rotation.align_vectors([(0.0, 0.0, 1.0)], [GRAVITY_AXIS])[0]


class Swing(NamedTuple):
    """One row of the table, in the axes of the library's file."""

    record: int
    lines: list[str]
    pose: Any
    lengths: list[float]
    model: list[float]
    measured: list[float]


def swings() -> list[Swing]:
    """The table."""
    text = (Path(__file__).parent / "free_swings.csv").read_text("utf-8")
    lines = [each for each in text.splitlines() if not each.startswith("#")]
    return [_swing(row) for row in csv.DictReader(lines)]


def _swing(row: dict[str, str]) -> Swing:
    numbers = {key: float(text) if text else np.nan for key, text in row.items()}
    names = list(row["lines"])
    turn = TO_LIBRARY * Rotation.from_euler("XYZ", [numbers[key] for key in "abc"])
    pose = np.concatenate([TO_LIBRARY.apply([numbers[key] for key in "xyz"]), turn.as_rotvec()])
    free = range(1, 7 - len(names))
    lengths = [numbers[f"l{name}"] for name in names]
    of = {key: [numbers[f"{key}{k}"] for k in free] for key in "fm"}
    return Swing(int(row["record"]), names, pose, lengths, of["f"], of["m"])


def unstretched(robot: Robot) -> Robot:
    """The robot with cables that neither weigh nor stretch, as in that group's model."""
    stiff = {"axial_stiffness": 1e12, "linear_density": 0.0}
    lines = (
        line.model_copy(update={"cable": line.cable.model_copy(update=stiff), "tension_limits": (0.0, 1e3)})
        for line in robot.lines
    )
    return robot.model_copy(update={"lines": tuple(lines)})


def at(swing: Swing) -> Modes:
    """The modes where the lengths of the table hold the platform."""
    robot = unstretched(load("grab-prototype")).with_lines(swing.lines)
    held = forward(robot, swing.lengths, guess=swing.pose, cable="elastic").checked()
    np.testing.assert_allclose(held.pose, swing.pose, atol=5e-6)  # balance and lengths agree with the measured pose
    return modes(held)


def test_frequencies_of_49_poses_are_those_of_the_groups_own_model() -> None:
    table = swings()
    assert len(table) == 49
    found = np.concatenate([at(swing).inextensible for swing in table])
    np.testing.assert_allclose(found, np.concatenate([swing.model for swing in table]), rtol=2e-5)


def test_few_lines_leave_pendulums_beside_stretch() -> None:
    """Motions by kind: 6 - m pendulums, whose frequencies stretch hardly changes, and m of stretch."""
    for swing in swings()[::12]:
        robot = load("grab-prototype").with_lines(swing.lines)
        free = {4: [3, 4], 3: [3, 4, 5], 2: [1, 3, 4, 5]}[robot.m]
        found = modes(inverse(robot, [np.nan if k in free else value for k, value in enumerate(swing.pose)]).checked())
        assert found.motion == ["pendulum"] * (6 - robot.m) + ["stretch"] * robot.m
        np.testing.assert_allclose(found.frequencies[: 6 - robot.m], found.inextensible, rtol=2e-3)
        assert (found.frequencies[: 6 - robot.m] <= found.inextensible * (1 + 1e-9)).all()


def errors(swing: Swing, factor: float = 1.0) -> list[float]:
    """Each measured frequency over the nearest of the model times *factor*, less 1."""
    model = factor * np.array(swing.model)
    return [f / float(model[abs(np.log(model / f)).argmin()]) - 1.0 for f in {f for f in swing.measured if f == f}]


def test_measured_frequencies_lie_two_per_cent_above_the_model() -> None:
    """The table of docs/modes.md."""
    by_count = {m: [each for swing in swings() if len(swing.lines) == m for each in errors(swing)] for m in (4, 3, 2)}
    medians = {m: round(100.0 * float(np.median(each)), 1) for m, each in by_count.items()}
    assert medians == {4: 2.5, 3: 2.6, 2: 2.1}
    assert {m: len(each) for m, each in by_count.items()} == {4: 25, 3: 41, 2: 61}


def test_one_factor_fitted_to_25_poses_predicts_the_other_24() -> None:
    fitted, predicted = swings()[::2], swings()[1::2]
    factor = 1.0 + float(np.median([each for swing in fitted for each in errors(swing)]))
    assert 1.015 < factor < 1.03
    left = np.abs([each for swing in predicted for each in errors(swing, factor)])
    assert np.median(left) < 0.015
    assert np.percentile(left, 95) < 0.06


def test_lines_are_chosen_by_name() -> None:
    robot = load("grab-prototype")
    assert [line.name for line in robot.with_lines(["3", "1"]).lines] == ["1", "3"]
    with pytest.raises(UnknownName, match="unknown line '9'; allowed: 1, 2, 3, 4"):
        robot.with_lines(["1", "9"])
    with pytest.raises(InputError, match="'1' is named more than once"):
        robot.with_lines(["1", "1"])
