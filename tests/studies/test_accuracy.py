"""Accuracy over shapes: one way to ask wherever it is asked, and nothing begun that could have been rejected."""

from __future__ import annotations

import json

import numpy as np
import pytest

from cablewright.analyses.accuracy.nozzle_error import METHODS
from cablewright.analyses.accuracy.spread import FirstOrder, MonteCarlo
from cablewright.foundation.errors import AnswerError, InputError, UnknownName
from cablewright.live.position_sets import Places
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Model
from cablewright.printing.job import load_job
from cablewright.robot import load
from cablewright.robot.parameters import nominal, parameters_of, with_value
from cablewright.robot.uncertainty import Range, assumed_uncertainty
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies import accuracy as studies
from cablewright.studies.accuracy import accuracy
from cablewright.studies.accuracy_at_pose import AccuracyAtPose
from cases import nozzle_errors

HOUSE = load("house-printer")
WRONG = [
    ({"metod": FirstOrder()}, TypeError, "metod"),
    ({"method": "newton"}, UnknownName, "monte-carlo"),
    ({"seed": -1}, InputError, "at least 0"),
    ({"compensation": "fulll"}, UnknownName, "did you mean 'full'"),
    ({"tension_limits": (500.0, 20.0)}, InputError, "lowest < highest"),
    ({"home": [0.0, 0.0, 14.9]}, InputError, "home: "),
    ({"ranges": ()}, InputError, "at least one uncertain parameter"),
]


@pytest.mark.parametrize(("options", "error", "message"), WRONG, ids=lambda value: str(value)[:20])
def test_a_wrong_option_is_rejected_before_any_work(job_file, options, error, message) -> None:
    begun: list[str] = []
    options = {"progress": lambda stage, _done, _total: begun.append(stage)} | options
    job, places = load_job(job_file), Places.plane(HOUSE, 1.0, 1.0, 1.0)
    for ask in (
        lambda: accuracy(HOUSE, job, **options),
        lambda: accuracy(HOUSE, Places.workspace(2.5), **options),
        lambda: accuracy(HOUSE, places, **options),
        lambda: accuracy(HOUSE, [0.0, 0.0, 1.0], **options),
    ):
        with pytest.raises(error, match=message):
            ask()
    assert begun == []


def test_along_a_job_it_is_that_of_its_poses(job_file) -> None:
    job = load_job(job_file)
    found = accuracy(HOUSE, job, method=FirstOrder(), compensation="elastic")
    assert found.places.shape == "path"
    alone = nozzle_errors(HOUSE, found.places.positions, method=FirstOrder(), compensation="elastic")
    np.testing.assert_array_equal(found.accuracy.spread.max_error, alone.spread.max_error)
    np.testing.assert_array_equal(found.places.distance, job.samples(job.toolpath()).distance)


def test_at_one_pose_every_compensation_is_as_if_asked_alone() -> None:
    pose, home = [3.0, 2.0, 1.0], [0.0, 0.0, 1.0]
    found = accuracy(HOUSE, pose, compensation="elastic", home=home)
    for name, left in found.remains.items():
        alone = nozzle_errors(HOUSE, pose, compensation=name, home=home)
        np.testing.assert_array_equal(left.commanded, alone.commanded)
        np.testing.assert_array_equal(left.spread.max_error, alone.spread.max_error)
    assert found.remains["elastic"] is found.accuracy
    np.testing.assert_array_equal(found.region.nominal, Model(HOUSE).nozzle(found.accuracy.nominal)[0])


def test_at_one_pose_the_inverse_problem_is_solved_once(monkeypatch) -> None:
    full = []
    solve = studies.AccuracyQuestion.hold
    monkeypatch.setattr(studies.AccuracyQuestion, "hold", lambda *given: full.append(1) or solve(*given))
    assert len(accuracy(HOUSE, [0.0, 0.0, 1.0]).remains) == 4
    assert len(full) == 1


def test_places_are_in_the_frame_and_in_order() -> None:
    helix = Places.helix(HOUSE, 2.0, 1.0, 0.5, 3.0, 0.25)
    steps = np.linalg.norm(np.diff(helix.positions, axis=0), axis=1)
    assert steps.max() <= 0.25 + 1e-12
    np.testing.assert_allclose(np.diff(helix.distance), steps, rtol=1e-2)
    plane = Places.plane(HOUSE, 1.0, None, 5.0)
    x, y = plane.axes
    np.testing.assert_allclose(plane.positions.reshape(len(x), len(y), 3)[1, 2], [x[1], y[2], 1.0])
    assert (x[0], x[-1]) == (HOUSE.scene.frame_min[0], HOUSE.scene.frame_max[0])


def test_where_it_can_be_nowhere_there_is_no_answer() -> None:
    with pytest.raises(AnswerError, match="none of the 4 poses has an answer"):
        accuracy(HOUSE, Places.plane(HOUSE, 14.9, 0.5, 1.0))


def test_a_model_answers_as_its_robot_does_and_one_without_sag_is_rejected(job_file) -> None:
    poses = [[0.0, 0.0, 1.0], [3.0, 2.0, 1.0]]
    ours, own = (accuracy(it, poses, method="first-order") for it in (HOUSE, Model(HOUSE)))
    np.testing.assert_array_equal(ours.spread.max_error, own.spread.max_error)
    for where in (poses, poses[0], Places.workspace(2.5), job_file):
        with pytest.raises(InputError, match="the model is elastic, the machine itself is catenary"):
            accuracy(Model(HOUSE, Fidelity(CableLaw.ELASTIC)), where)


def test_retraction_belongs_to_poses() -> None:
    for where in ([0.0, 0.0, 1.0], Places.workspace(2.5)):
        with pytest.raises(InputError, match=r"retraction: .*poses \(N, n\)"):
            accuracy(HOUSE, where, retraction=[0.1])


@pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
def test_no_poses_have_no_errors(method) -> None:
    found = accuracy(HOUSE, np.empty((0, 3)), method=method)
    assert (len(found), found.ok.shape, found.to_dict()["max_error"]) == (0, (0,), None)


def test_results_are_one_line_and_json(job_file) -> None:
    quick = {"method": "first-order"}
    shapes = (job_file, str(job_file), load_job(job_file))
    for where in ([0.0, 0.0, 1.0], [[0.0, 0.0, 1.0], [0.0, 0.0, 99.0]], Places.plane(HOUSE, 1.0, 1.0, 1.0), *shapes):
        found = accuracy(HOUSE, where, **quick)
        assert "\n" not in repr(found)
        assert len(repr(found)) < 160
        assert json.loads(json.dumps(found.to_dict(), allow_nan=False))["robot"] == "house-printer"


def test_some_of_the_places_are_a_smaller_batch() -> None:
    found = accuracy(HOUSE, [[0.0, 0.0, 99.0], [0.0, 0.0, 1.0], [3.0, 2.0, 1.0]], method="first-order")
    last, both = found[-1], found[:2]
    assert (len(last), len(both)) == (1, 2)
    assert last.nominal_error[0] == found.nominal_error[2]
    np.testing.assert_array_equal(last.commanded, found.commanded[2:])
    np.testing.assert_array_equal(both.spread.max_error, found.spread.max_error[:2])
    with pytest.raises(IndexError):
        found[3]


def test_a_job_in_a_room_on_disk_has_the_same_errors(job_file, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr("cablewright.analyses.accuracy.nozzle_error.BLOCK", 64)
    monkeypatch.setattr("cablewright.foundation.memory_mapped.SMALL", 1)
    stages: list[tuple[int, int]] = []
    job = load_job(job_file)
    whole = accuracy(HOUSE, job, method="first-order", compensation="elastic")
    some = accuracy(HOUSE, job, method="first-order", compensation="elastic", room=tmp_path,
                    progress=lambda stage, *done: stages.append(done) if stage == "solving" else None)  # fmt: skip
    assert len(whole) > 3 * 64
    for name in ("wanted", "commanded", "codes", "nominal"):
        np.testing.assert_array_equal(getattr(whole.accuracy, name), getattr(some.accuracy, name))
    for name, values in whole.accuracy.spread.__dict__.items():
        np.testing.assert_array_equal(values, getattr(some.accuracy.spread, name))
    assert some.to_dict() == whole.to_dict()
    assert stages == sorted(stages)
    assert stages[-1] == (len(some), len(some))


def test_a_job_that_can_be_held_nowhere_has_no_answer_in_a_room(job_file, tmp_path) -> None:
    high = load_job(job_file).model_copy(update={"origin": (0.0, 0.0, 14.5)})
    with pytest.raises(AnswerError, match=r"none of the \d+ poses has an answer"):
        accuracy(HOUSE, high, method="first-order", room=tmp_path)


@pytest.mark.parametrize("method", ["vertices", "first-order", MonteCarlo(500)], ids=str)
def test_one_place_has_one_largest_deviation_in_all_tables(method) -> None:
    robot = load("hangprinter-v4")
    ranges = assumed_uncertainty(robot).of(robot)
    assert len(ranges) > 12  # too many for all corners
    found = accuracy(robot, [0.1, 0.1, 0.2], ranges, method=method, compensation="full").to_dict()
    remains = {each["compensation"]: each["max_deviation"] for each in found["remains"]}
    assert remains["full"] == found["max_deviation"]
    assert found["best_tension"]["min_norm_max_deviation"] == pytest.approx(found["max_deviation"], rel=1e-9)
    assert found["best_tension"]["max_deviation"] <= found["max_deviation"] * (1.0 + 1e-9)


def test_the_deviation_of_tensions_is_that_of_drawn_machines() -> None:
    robot = load("house-printer")
    exits = [*parameters_of(robot, "exit_point.x"), *parameters_of(robot, "exit_point.z")]
    ranges = tuple(Range(each, at := nominal(robot, each), at - 2e-4, at + 2e-4) for each in exits)
    found = accuracy(robot, (0.4, 0.2, 0.8), ranges, method="first-order")
    assert isinstance(found, AccuracyAtPose)
    held, random, off = solve_inverse(Model.full(robot), (0.4, 0.2, 0.8)), np.random.default_rng(2), []
    for _ in range(150):
        drawn = robot
        for each in ranges:
            drawn = with_value(drawn, each.parameter, random.uniform(each.low, each.high))
        off.append(solve_forward(Model.full(drawn), held.lengths, guess=held.pose).tensions)
    np.testing.assert_allclose(found.tension_deviation, np.std(off, axis=0), rtol=0.2)
