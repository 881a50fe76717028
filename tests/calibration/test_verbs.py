"""The public verbs of calibration: a robot or a model, options rejected at the call, results that describe
themselves."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import cablewright as cw
from cablewright.calibration.measurements import write_measured
from cablewright.models.fidelity import Fidelity

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
WANG = cw.load("wang2021")
RIGID = cw.Model(WANG, Fidelity.of("rigid"))


@pytest.fixture(scope="module")
def made() -> cw.SimulatedCalibration:
    return cw.simulate_calibration(WANG, 20, 1e-4, seed=1)


@pytest.fixture(scope="module")
def found(made: cw.SimulatedCalibration) -> cw.Calibration:
    return cw.calibrate(WANG, made.measured)


def describes_itself(result: object) -> dict[str, object]:
    """The figures, after what holds for every result."""
    assert len(repr(result)) < 160
    assert "\n" not in repr(result)
    told = result.to_dict()
    assert json.loads(json.dumps(told, allow_nan=False)) == told
    return told


def test_simulated_data_describe_themselves(made: cw.SimulatedCalibration) -> None:
    assert describes_itself(made) == {"status": "ok", "poses": 20, "noise": 1e-4, "seed": 1}


def test_a_calibration_describes_itself(found: cw.Calibration) -> None:
    told = describes_itself(found)
    assert (found.status, found.verdict, found.ok) == ("ok", "doubtful", False)
    assert replace(found, accepted=True).ok
    assert told["unknowns"] - told["rank"] == 4  # translation and yaw
    assert list(told["values"]) == list(told["sigma"]) == [each.label for each in found.unknowns]
    assert told["datum"] == ["inner"]
    assert found.plot().axes


def test_a_model_and_a_file_say_the_same(found: cw.Calibration, made: cw.SimulatedCalibration, tmp_path) -> None:
    again = cw.simulate_calibration(RIGID, 20, 1e-4, seed=1)
    assert np.array_equal(again.measured.counted, made.measured.counted)
    (tmp_path / "data.csv").write_text(write_measured(made.measured, WANG))
    (tmp_path / "plan.toml").write_text("schema = 1\n")
    other = cw.calibrate(RIGID, tmp_path / "data.csv", tmp_path / "plan.toml", cable="rigid")
    assert np.array_equal(other.values, found.values)


def test_a_model_chooses_the_same_poses() -> None:
    one, other = (cw.calibration_poses(each, 14, candidates=60, seed=3) for each in (WANG, RIGID))
    assert describes_itself(one) == describes_itself(other)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"cable": "catenary"}, "cable = catenary: the model has rigid"),
        ({"cable": "ropey"}, "catenary, elastic, rigid"),
        ({"rough": -1.0}, "rough = -1: must be from 0 to 100 m"),
        ({"seed": -1}, "seed = -1"),
    ],
)
def test_wrong_options_of_calibrate(made: cw.SimulatedCalibration, options, says: str) -> None:
    with pytest.raises(cw.InputError, match=says):
        cw.calibrate(RIGID, made.measured, **options)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"criterion": "best"}, "d-optimal, worst-sigma"),
        ({"count": 0}, "count = 0"),
        ({"candidates": 999_999}, "candidates = 999999"),
        ({"sigma": 0.0}, "sigma = 0"),
        ({"seed": -1}, "seed = -1"),
    ],
)
def test_wrong_options_of_poses(options, says: str) -> None:
    with pytest.raises(cw.InputError, match=says):
        cw.calibration_poses(WANG, **options)


def test_wrong_options_of_simulated_data() -> None:
    with pytest.raises(cw.InputError, match="cable = elastic: the model has rigid"):
        cw.simulate_calibration(RIGID, 20, 1e-4, cable="elastic")
    with pytest.raises(cw.InputError, match="poses = 0"):
        cw.simulate_calibration(WANG, 0, 1e-4)


def test_a_tensile_test_describes_itself() -> None:
    found = cw.modulus(EXAMPLES / "tensile.csv", initial_length=2.0, section=12.566e-6, breaking_load=10.29e3)
    assert describes_itself(found)["modulus"] == found.modulus
    assert found.axial_stiffness == pytest.approx(found.modulus * 12.566e-6)
    same = cw.modulus(found.test, initial_length=2.0, section=12.566e-6, breaking_load=10.29e3)
    assert same.to_dict() == found.to_dict()
    assert len(found.plot().axes) == 2


@pytest.mark.parametrize("kind", ["robot", "model"])
def test_a_survey_describes_itself(kind: str) -> None:
    robot = cw.load("merlet2023")
    own = robot if kind == "robot" else cw.Model(robot)
    found = cw.survey(str(EXAMPLES / "survey.gsi"), EXAMPLES / "survey.toml", robot=own)
    told = describes_itself(found)
    assert list(told["exits"]) == [line.name for line in robot.lines]
    assert all(wall["distance_sigma"] >= 0.0 for wall in told["walls"].values())
    assert found.plot().axes


def test_no_shots_are_rejected() -> None:
    with pytest.raises(cw.InputError, match="nowhere"):
        cw.survey(cw.Shots((), (), "nowhere"))
