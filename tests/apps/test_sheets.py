"""Figures as tables: parts within parts, several things side by side, rows in order of merit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from cablewright.apps.figures import Sheet, pairs, sheets, text
from cablewright.foundation.results import Figure, Result

SIZES = (Figure("rms", "m", "Rms.", shown="mm", digits=2), Figure("count", "1", "Number.", detail=True))
ERRORS = (
    Figure("number", "1", "Number of steps."),
    Figure("above", "m", "Seen from above.", parts=SIZES),
    Figure("height", "m", "In height.", parts=SIZES),
    Figure("each", "m", "Of each line.", parts=(Figure("line", "", "Name."), *SIZES)),
)
ONE: dict[str, Any] = {
    "number": 3,
    "above": {"rms": 0.012, "count": 3},
    "height": {"rms": 0.0034, "count": 3},
    "each": [{"line": "a", "rms": 0.001, "count": 1}],
}
NONE: dict[str, Any] = {"number": 0, "above": {"rms": None}, "height": {"rms": None}, "each": []}


@dataclass(frozen=True, repr=False)
class Found(Result):
    FIGURES: ClassVar = (
        Figure("errors", "", "Errors.", parts=ERRORS),
        Figure("named", "", "What each found.", parts=(ERRORS[0], Figure("errors", "", "Errors.", parts=ERRORS))),
        Figure("yaw", "rad", "Yaw.", parts=(Figure("rms", "rad", "Rms.", shown="deg", digits=2),), along="angles"),
        Figure("curves", "", "Best first.", parts=(Figure("n", "1", "Number.", lambda n: n),), ranked=True),
    )

    errors: dict[str, Any] | None = None
    named: dict[str, Any] | None = None
    yaw: dict[str, float] | None = None
    curves: tuple[int, ...] = ()


def test_parts_of_parts_are_rows_of_a_table() -> None:
    plain, rows, each = sheets(Found(errors=ONE))
    assert plain == Sheet("errors", (), [("number", "3")], (False, False))
    assert rows == Sheet("", (" ", "rms, mm"), [("above", "12"), ("height", "3")], (False, True))
    assert each == Sheet("each", ("line", "rms, mm"), [("a", "1.0")], (False, True))


def test_a_table_without_a_value_is_left_out() -> None:
    assert [each.title for each in sheets(Found(errors=NONE))] == ["errors"]


def test_several_things_stand_side_by_side() -> None:
    one = {"number": 3, "errors": ONE}
    values, plain, rows, each = sheets(Found(named={"paper": one, "filter": one | {"number": 4}}))
    assert values == Sheet("", (" ", "paper", "filter"), [("number", "3", "4")], (False, True, True))
    assert plain == Sheet("errors", (), [("paper", "number", "3"), ("filter", "number", "3")], (False, False, False))
    assert [row[:2] for row in rows.rows] == [
        ("paper", "above"), ("filter", "above"), ("paper", "height"), ("filter", "height"),
    ]  # fmt: skip
    assert [row[0] for row in each.rows] == ["paper", "filter"]


def test_figures_with_parts_along_something_are_its_rows() -> None:
    (angles,) = sheets(Found(yaw={"rms": 0.1}))
    assert angles == Sheet("angles", (" ", "rms, deg"), [("yaw", "5.7")], (False, True))


def test_a_ranked_table_says_so() -> None:
    (curves,) = sheets(Found(curves=(3, 1, 2)))
    assert curves.ranked
    assert curves.rows == [("3",), ("1",), ("2",)]


def test_parts_in_a_line_have_their_labels() -> None:
    assert text(Figure("above", "m", "Above.", parts=SIZES), ONE["above"]) == "rms 12 mm, count 3"
    assert pairs(ERRORS[:1], ONE, NONE) == [("number", "3", "0")]
