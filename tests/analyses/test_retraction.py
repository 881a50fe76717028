"""The best retraction by height and the law through it: peaks, the fit, and what the law keeps of the best."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.analyses.workspace.best_retraction import RetractionStudy, _fit, _peaks, retraction
from cablewright.analyses.workspace.workspace import workspace
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import load
from cases import some

JUNG = Model(load("jung2020"), Fidelity.of("rigid"))


@pytest.fixture(scope="module", params=some(["closed-form", "exact"]))
def found(request: pytest.FixtureRequest) -> RetractionStudy:
    return retraction(JUNG, request.param, steps=5)


def test_the_table_is_that_of_workspaces_of_retracted_robots(found: RetractionStudy) -> None:
    assert found.areas.shape == (len(found.heights), len(found.lengths)) == (40, 5)
    for k in (3,):
        robot = JUNG.robot.retracted(float(found.lengths[k]))
        own = workspace(Model(robot, JUNG.fidelity), found.held.criterion.name)
        assert found.volumes[k] == pytest.approx(own.volume, rel=1e-9)
        np.testing.assert_allclose(found.areas[:, k], own.slices(found.heights), atol=1e-9)
    np.testing.assert_allclose(found.areas.sum(axis=0) * found.slice_height, found.volumes, rtol=5e-3)


def test_the_law_keeps_at_least_99_percent_of_the_best(found: RetractionStudy) -> None:
    assert 0.99 <= found.share <= 1.003
    assert found.best_volume > 1.05 * found.volumes.max()  # it buys something
    assert found.held.volume == pytest.approx(found.best_volume, rel=0.01)
    assert (found.best_areas >= found.areas.max(axis=1) - 1e-12).all()


def test_the_law_is_the_line_through_the_slices_it_names(found: RetractionStudy) -> None:
    own = found.best[found.fitted]
    assert (own > 1.2).all()
    assert (own < 2.0).all()
    line = np.polynomial.Polynomial.fit(found.heights[found.fitted], own, 1).convert()
    assert (found.law.intercept, found.law.slope) == pytest.approx(tuple(line.coef))
    assert (found.law.least, found.law.most, found.law.of) == (1.2, 2.0, "nozzle")
    assert found.held.criterion.retraction == found.law
    ends = found.law.at([-9.0, 9.0])
    assert ends.tolist() == [2.0, 1.2]


def test_peaks_of_parabolas_are_exact() -> None:
    lengths = np.linspace(1.0, 2.0, 6)
    tops = np.array([1.0, 1.13, 1.5, 1.87, 2.0])
    areas = 3.0 - (lengths - tops[:, None]) ** 2
    best, peaks = _peaks(lengths, areas)
    np.testing.assert_allclose(best, tops, atol=1e-12)
    np.testing.assert_allclose(peaks, 3.0, atol=1e-12)
    best, peaks = _peaks(lengths, np.array([np.zeros(6), np.arange(6.0), 6.0 - np.arange(6)]))
    np.testing.assert_array_equal(best, [np.nan, 2.0, 1.0])
    np.testing.assert_array_equal(peaks, [0.0, 5.0, 6.0])


def test_ends_do_not_count_unless_there_is_nothing_else() -> None:
    heights, areas = np.arange(5.0), np.ones(5)
    law, fitted = _fit(heights, np.array([2.0, 1.8, 1.6, 1.4, 1.2]), areas, (1.2, 2.0))
    assert fitted.tolist() == [False, True, True, True, False]
    assert (law.slope, law.intercept) == pytest.approx((-0.2, 2.0))
    law, fitted = _fit(heights, np.full(5, 2.0), areas, (1.2, 2.0))
    assert fitted.all()
    assert law.at(3.0) == pytest.approx(2.0)
    with pytest.raises(AnswerError, match="no law"):
        _fit(heights, np.full(5, 2.0), np.array([0.0, 1, 0, 0, 0]), (1.2, 2.0))


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"min_length": 1.8, "max_length": 1.5}, "rising lengths"),
        ({"min_length": 1.0}, "retracts from 1.2 to 2 m"),
        ({"max_length": 2.5}, "retracts from 1.2 to 2 m"),
        ({"steps": 2}, "steps = 2: 3 to 200"),
        ({"heights": 3}, "heights = 3: 4 to 1000"),
        ({"criterion": "any"}, "unknown criterion"),
    ],
)
def test_bad_input_is_rejected(options: dict, says: str) -> None:
    with pytest.raises(InputError) as refusal:
        retraction(JUNG, **options)
    assert says in str(refusal.value)
    with pytest.raises(InputError, match="has no retraction"):
        retraction(Model(load("house-printer"), JUNG.fidelity))


def test_what_cannot_be_reached_at_all_is_a_no() -> None:
    with pytest.raises(AnswerError, match="fewer than two slices"):
        retraction(JUNG, box=[-0.1, 0.1, -0.1, 0.1, 5.0, 6.0], steps=3)
