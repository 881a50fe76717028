"""Closed loops side by side: ours and a user's own run with the same seeds, and what is wrong is named."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cablewright as cw

ROBOT = cw.load("merlet2023")
WAY = cw.Trajectory.through([[0.0, 0.0, 1.2], [0.1, 0.0, 1.2]], speed=0.1, acceleration=0.1)


def still(robot: cw.Robot, settings: cw.MachineSettings) -> Any:
    """A controller that never moves."""
    return lambda estimate, target, period: np.zeros(robot.m)


def test_each_controller_runs_on_the_same_machines() -> None:
    found = cw.compare_loops(ROBOT, WAY, controllers=["model", still], estimators=["truth"], seeds=[1, 2])
    assert [(run.controller, run.seed) for run in found.runs] == [
        ("model", 1),
        ("model", 2),
        ("still", 1),
        ("still", 2),
    ]
    assert found.status == "ok"
    assert all(run.errors.max() < 3e-3 for run in found.runs[:2])
    at_rest = [float(run.errors[-1]) for run in found.runs[2:]]
    assert at_rest == pytest.approx([0.1, 0.1], abs=5e-3)  # as far as the trajectory goes
    assert at_rest[0] != at_rest[1]  # machines as built differ
    assert found.to_frame().shape == (4, 11)
    assert all(np.array_equal(run.estimate_errors, np.zeros(len(run.times))) for run in found.runs)


def test_the_same_seeds_give_the_same_runs() -> None:
    first, again = (cw.compare_loops(ROBOT, WAY, seeds=[3]).runs[0] for _ in range(2))
    np.testing.assert_array_equal(first.errors, again.errors)
    np.testing.assert_array_equal(first.tensions, again.tensions)


def test_a_rigid_platform_follows() -> None:
    way = cw.Trajectory.spline([[0, 0, 0.9, 0, 0, 0], [0.1, 0.05, 1.0, 0, 0, 0]], 3.0)
    (run,) = cw.compare_loops(cw.load("jung2020"), way, estimators=["truth"]).runs
    assert 0.0 < run.errors.max() < 5e-3
    assert run.tensions.min() > 0.0


def test_an_estimate_that_never_becomes_valid_ends_the_run() -> None:
    class Blind:
        def __init__(self, robot: cw.Robot, settings: cw.MachineSettings, start: np.ndarray) -> None:
            self.m = robot.m

        def step(self, frame: cw.SensorFrame) -> cw.Estimate:
            none, nowhere = np.full(self.m, math.nan), np.full(3, math.nan)
            told = frame.time, nowhere, nowhere, nowhere, none, none
            return cw.Estimate(*told, slack=np.zeros(self.m, dtype=bool), radii=none, valid=False)

    found = cw.compare_loops(ROBOT, WAY, estimators=[Blind])
    assert found.status == "stopped"
    assert found.refusal == "model, Blind, quasi-static, seed 0: the estimate is not valid after 20 s"
    assert found.runs[0].times.shape == (0,)
    assert "Blind" in found._repr_html_()


def test_wrong_ones_are_named() -> None:
    def with_rates(values: Any) -> Any:
        def mine(robot: cw.Robot, settings: cw.MachineSettings) -> Any:
            return lambda estimate, target, period: values

        return mine

    cases = (
        ({"controllers": ["modelx"]}, "unknown controller 'modelx'; did you mean 'model'?"),
        ({"estimators": ["kalman"]}, "unknown estimator 'kalman'"),
        ({"plants": ["dynamics"]}, "did you mean 'dynamic'?"),
        ({"controllers": ["model", "model"]}, "controller model: this name occurs twice"),
        (
            {"controllers": [with_rates([0.0, 1.0])]},
            "controller mine: 4 finite rates, m/s, are expected, not shape (2,)",
        ),
        ({"controllers": [with_rates([math.nan] * 4)]}, "controller mine: 4 finite rates, m/s, are expected, not [nan"),
    )
    for options, text in cases:
        with pytest.raises(cw.InputError) as raised:
            cw.compare_loops(ROBOT, WAY, **{"estimators": ["truth"], **options})
        assert text in str(raised.value)
        assert "\n" not in str(raised.value)
    with pytest.raises(cw.InputError, match="poses of 6 numbers are expected for 'jung2020', not 3"):
        cw.compare_loops(cw.load("jung2020"), WAY)


def test_a_plant_without_a_truth_is_named() -> None:
    class Silent:
        period = 0.1
        abilities = cw.Abilities(4)

        def __init__(self, robot: cw.Robot, start: np.ndarray, seed: int) -> None:
            """Nothing to build."""

    with pytest.raises(cw.InputError, match="plant Silent: its abilities have no truth"):
        cw.compare_loops(ROBOT, WAY, plants=[Silent])


def test_own_parts_of_the_example_are_twenty_lines() -> None:
    text = (Path(__file__).resolve().parents[2] / "examples" / "24_own_control_loop.py").read_text("utf-8")
    classes = text.split("\nclass ")[1:]
    assert len(classes) == 3
    for each in classes:
        body = each.split("\n\n\nrobot = ")[0].rstrip().splitlines()
        assert len([line for line in body if line.strip()]) <= 24, body[0]


def test_the_picture_has_a_curve_for_each_run(tmp_path: Path) -> None:
    found = cw.compare_loops(ROBOT, WAY, controllers=["model", still], estimators=["truth"], seeds=[1, 2])
    drawn = found.plot(tmp_path / "loops.pdf", width="one-column")
    assert len(drawn.axes[0].get_lines()) == 4
    assert [text.get_text() for text in drawn.legends[0].get_texts()] == [
        "model, truth, quasi-static", "still, truth, quasi-static",
    ]  # fmt: skip
