"""Accuracy over shapes: one way to ask wherever it is asked, and nothing begun that could have been refused."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.analyses.accuracy.nozzle_error import accuracy
from cablewright.analyses.accuracy.spread import FirstOrder
from cablewright.errors import AnswerError, InputError, UnknownName
from cablewright.models.statics import Model
from cablewright.printing.job import load_job
from cablewright.robot import load
from cablewright.studies import accuracy as studies
from cablewright.studies.accuracy import Places, accuracy_over, accuracy_over_job, accuracy_over_workspace
from cablewright.studies.accuracy_at_pose import accuracy_at

HOUSE = load("house-printer")
WRONG = [
    ({"metod": FirstOrder()}, TypeError, "metod"),
    ({"compensation": "fulll"}, UnknownName, "did you mean 'full'"),
    ({"tension_limits": (500.0, 20.0)}, InputError, "lowest < highest"),
    ({"home": [0.0, 0.0, 14.9]}, InputError, "home: "),
    ({"ranges": ()}, InputError, "at least one number"),
]


@pytest.mark.parametrize(("options", "error", "message"), WRONG, ids=lambda value: str(value)[:20])
def test_a_wrong_option_is_refused_before_any_work(job_file, options, error, message) -> None:
    begun: list[str] = []
    options = {"progress": lambda stage, _done, _total: begun.append(stage)} | options
    job, places = load_job(job_file), Places.plane(HOUSE, 1.0, 1.0, 1.0)
    for ask in (
        lambda: accuracy_over_job(HOUSE, job, **options),
        lambda: accuracy_over_workspace(HOUSE, 2.5, **options),
        lambda: accuracy_over(HOUSE, places, **options),
        lambda: accuracy_at(HOUSE, [0.0, 0.0, 1.0], **options),
    ):
        with pytest.raises(error, match=message):
            ask()
    assert begun == []


def test_along_a_job_it_is_that_of_its_poses(job_file) -> None:
    job = load_job(job_file)
    found = accuracy_over_job(HOUSE, job, method=FirstOrder(), compensation="elastic")
    assert found.places.shape == "path"
    alone = accuracy(HOUSE, found.places.positions, method=FirstOrder(), compensation="elastic")
    np.testing.assert_array_equal(found.accuracy.spread.max_error, alone.spread.max_error)
    np.testing.assert_array_equal(found.places.distance, job.samples(job.toolpath()).distance)


def test_at_one_pose_every_compensation_is_as_if_asked_alone() -> None:
    pose, home = [3.0, 2.0, 1.0], [0.0, 0.0, 1.0]
    found = accuracy_at(HOUSE, pose, compensation="elastic", home=home)
    for name, left in found.remains.items():
        alone = accuracy(HOUSE, pose, compensation=name, home=home)
        np.testing.assert_array_equal(left.commanded, alone.commanded)
        np.testing.assert_array_equal(left.spread.max_error, alone.spread.max_error)
    assert found.remains["elastic"] is found.accuracy
    np.testing.assert_array_equal(found.region.nominal, Model(HOUSE).nozzle(found.accuracy.nominal)[0])


def test_at_one_pose_the_inverse_problem_is_solved_once(monkeypatch) -> None:
    full = []
    solve = studies.AccuracyQuestion.hold
    monkeypatch.setattr(studies.AccuracyQuestion, "hold", lambda *given: full.append(1) or solve(*given))
    assert len(accuracy_at(HOUSE, [0.0, 0.0, 1.0]).remains) == 4
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
        accuracy_over(HOUSE, Places.plane(HOUSE, 14.9, 0.5, 1.0))
