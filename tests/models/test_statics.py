"""An equilibrium that can judge itself: status, margin, residuals, rows of a batch."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest

import cases
from cablewright.foundation.errors import AnswerError, InputError, Status
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Equilibrium, Model
from cablewright.models.stiffness import stiffness
from cablewright.robot import load
from cablewright.solvers.certify import certify
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import linearise, tension_changes

HOUSE = Model(load("house-printer"))


@pytest.fixture(scope="module")
def mixed() -> Equilibrium:
    """Five poses; the second is too high for the tension limits, the fourth is inside a sheave."""
    return solve_inverse(HOUSE, [[0, 0, 1], [0, 0, 14.9], [1, 2, 3], [7.4, 7.4, 14.95], [3, 3, 3]])


def test_each_row_has_a_status(mixed: Equilibrium) -> None:
    statuses = [mixed[row].status for row in range(5)]
    assert statuses == [Status.OK, Status.INFEASIBLE, Status.OK, Status.INSIDE_SHEAVE, Status.OK]
    assert mixed.status == tuple(statuses)
    assert mixed.ok.tolist() == [True, False, True, False, True]
    assert [one.ok for one in mixed] == mixed.ok.tolist()


def test_one_answer_has_plain_numbers(mixed: Equilibrium) -> None:
    one = mixed[0]
    assert one.ok is True
    for number in (one.residual_norm(), one.unbalanced_force(), one.margin()):
        assert type(number) is float
    assert isinstance(one.violation, float)


def test_a_batch_has_a_length_and_rows(mixed: Equilibrium) -> None:
    assert len(mixed) == 5
    assert len(mixed[1:4]) == 3
    assert [one.pose.tolist() for one in mixed] == mixed.pose.tolist()
    for ask in (len, bool, list):
        with pytest.raises(TypeError, match=r"^a single Equilibrium has no length and no truth value$"):
            ask(mixed[0])


def test_repr_is_a_line_with_the_status(mixed: Equilibrium) -> None:
    assert repr(mixed) == "Equilibrium('house-printer', catenary, 3 of 5 ok)"
    assert repr(mixed[1]) == "Equilibrium('house-printer', catenary, infeasible, pose=[0, 0, 14.9])"
    assert repr(Model(HOUSE.robot, Fidelity.of("elastic", "eyelet"))) == "Model('house-printer', elastic, eyelet)"


def test_figures_are_plain_numbers_in_si(mixed: Equilibrium) -> None:
    told = mixed[2].to_dict()
    json.dumps(told, allow_nan=False)
    assert (told["status"], told["robot"], told["cable"], told["sheave"]) == ("ok", "house-printer", "catenary", None)
    assert told["pose"] == told["nozzle"] == [1.0, 2.0, 3.0]
    assert told["tensions"] == mixed.tensions[2].tolist()
    assert (told["margin"], told["violation"]) == (mixed.margin()[2], 0.0)
    assert mixed[3].to_dict()["lengths"] == [None] * 4
    rows = mixed.to_dict()
    assert rows["status"] == ["ok", "infeasible", "ok", "inside-sheave", "ok"]
    for key in ("pose", "lengths", "residual", "margin"):
        assert rows[key] == [one.to_dict()[key] for one in mixed]


@pytest.mark.parametrize("model", [HOUSE, Model(load("jung2020"), Fidelity.of("elastic"))], ids=cases.name)
def test_no_poses_have_no_answers(model: Model) -> None:
    held = solve_inverse(model, np.empty((0, model.n)))
    retracted = () if model.robot.retraction is None else (solve_inverse(model, held.pose, retraction=held.code),)
    for none in (held, solve_forward(model, np.empty((0, model.m))), held[held.ok], *retracted):
        assert (len(none), none.status, list(none)) == (0, (), [])
        assert none.tensions.shape == none.lengths.shape == (0, model.m)
        assert none.margin().shape == none.ok.shape == (0,)
        assert none.checked() is none
        assert repr(none).endswith("0 of 0 ok)")
        assert none.to_dict()["pose"] == []
        assert len(linearise(none)) == len(tension_changes(none)) == len(stiffness(none)) == len(certify(none)) == 0


def test_checked_raises_the_sentence(mixed: Equilibrium) -> None:
    assert mixed[0].checked().status is Status.OK
    assert mixed[mixed.ok].checked().ok.all()
    with pytest.raises(AnswerError) as caught:
        mixed[1].checked()
    assert str(caught.value) == mixed[1].sentence()
    assert str(caught.value).startswith(f"{Status.INFEASIBLE.value}: at best line ")
    assert caught.value.exit_code == 1
    with pytest.raises(AnswerError, match=r"^the platform point is inside a sheave$"):
        mixed[3].checked()
    with pytest.raises(AnswerError) as caught:
        mixed.checked()
    assert str(caught.value) == f"2 of 5 rows failed; row 1: {mixed[1].sentence()}"


def test_validity_is_of_every_row(mixed: Equilibrium) -> None:
    assert mixed[0].is_valid()
    assert mixed[mixed.ok].is_valid(1e-9)
    assert not mixed[1].is_valid()
    assert not mixed.is_valid()
    assert not mixed[0].is_valid(0.0) or mixed[0].residual_norm() == 0.0


def test_a_pose_that_has_an_error_is_not_valid(mixed: Equilibrium) -> None:
    off = dataclasses.replace(mixed[0], pose=mixed[0].pose + np.array([0.0, 0.0, 1e-6]))
    assert off.residual_norm() > 1e-7
    assert not off.is_valid(1e-9)
    pulled = dataclasses.replace(mixed[0], states=mixed[0].states * [1, 1 + 1e-6, 1, 1, 1, 1])
    assert not pulled.is_valid(1e-9)


@pytest.mark.parametrize("index", [0, -1, np.int64(2)])
def test_an_integer_gives_one(mixed: Equilibrium, index: int) -> None:
    one = mixed[index]
    assert (one.pose.shape, one.lengths.shape, one.states.shape, one.code.shape) == ((3,), (4,), (4, 6), ())
    np.testing.assert_array_equal(one.lengths, mixed.lengths[index])
    assert one.margin() == mixed.margin()[index]
    assert one.extremes()[0].shape == (4,)


@pytest.mark.parametrize("index", [slice(1, 4), [0, 2], np.array([True, False, True, False, False])])
def test_a_slice_or_mask_gives_a_batch(mixed: Equilibrium, index: object) -> None:
    some = mixed[index]
    np.testing.assert_array_equal(some.lengths, mixed.lengths[index])
    np.testing.assert_array_equal(some.tensions, mixed.tensions[index])
    assert some.residual_norm().shape == some.code.shape


def test_none_makes_a_batch_of_one(mixed: Equilibrium) -> None:
    row = mixed[0][None]
    assert (row.pose.shape, row.code.shape) == ((1, 3), (1,))
    assert row.margin()[0] == mixed[0].margin()


@pytest.mark.parametrize("model", list(cases.models(*CableLaw)), ids=cases.name)
def test_tensions_lie_between_the_extremes_of_their_line(model: Model) -> None:
    held = cases.poses(model, 50)
    low, high = held.extremes()
    for tensions in (held.tensions, held.platform_tensions, held.winch_tensions):
        assert tensions.shape == low.shape == (50, model.m)
        assert (low <= tensions + 1e-9).all()
        assert (tensions <= high + 1e-9).all()
    least, most = np.transpose([line.tension_limits for line in model.robot.lines])
    margin, slack = held.margin(), np.minimum(low - least, most - high).min(axis=1)
    np.testing.assert_array_equal(margin, np.maximum(slack, 0.0))  # at a limit, to rounding
    assert (margin - slack <= 1e-11 * high.max(axis=1)).all()


def test_margin_is_negative_where_a_limit_is_broken() -> None:
    lengths = cases.poses(HOUSE, 1)[0].lengths + np.array([0.0, 3.0, 0.0, 0.0])
    over = solve_forward(HOUSE, lengths).checked()  # forward imposes no limits
    assert over.extremes()[0].min() < 20.0
    assert over.margin() == pytest.approx(over.extremes()[0].min() - 20.0)
    assert over.margin() < 0.0


@pytest.mark.parametrize("limits", [(5.0, 1.0), (1.0, 1.0), (-1.0, 1.0), (np.nan, 1.0), (0.0, np.nan), (0.0, np.inf)])
def test_limits_that_do_not_rise_are_rejected(limits: tuple[float, float]) -> None:
    with pytest.raises(InputError, match="must be 0 <= lowest < highest, in N"):
        Model(HOUSE.robot, Fidelity(), limits)


def test_a_result_is_frozen(mixed: Equilibrium) -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        mixed.pose = mixed.pose  # type: ignore[misc]
    with pytest.raises(dataclasses.FrozenInstanceError):
        HOUSE.tension_limits = (1.0, 2.0)  # type: ignore[misc]
