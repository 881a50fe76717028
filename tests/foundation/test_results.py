"""What results say of themselves: figures, JSON, `repr`."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np
import pytest

from cablewright.foundation.results import Figure, Result, plain


class _Kind(StrEnum):
    SWIVEL = "swivel"


@dataclass(frozen=True, eq=False, repr=False)
class _Sample(Result):
    HEADLINES = ("name", "length")
    FIGURES = (
        Figure("name", "", "Its name."),
        Figure("length", "m", "How long it is.", digits=3),
        Figure("double", "m", "Twice as long.", lambda found: 2.0 * found.length),
        Figure("half", "m", "Half as long.", "halved.real", name="half the length"),
        Figure("gone", "", "What is not known has no parts.", "nothing.real"),
        Figure("turn", "rad", "Of a rigid platform alone.", only=lambda found: found.turn is not None),
    )
    name: str
    length: float
    turn: float | None = None
    nothing: None = None

    def halved(self) -> float:
        return 0.5 * self.length


SAMPLE = {"name": "cord", "length": 1.25, "double": 2.5, "half": 0.625, "gone": None}


def test_a_result_has_its_figures_in_order() -> None:
    assert _Sample("cord", 1.25).to_dict() == SAMPLE
    assert list(_Sample("cord", 1.0, 0.5).to_dict()) == [*SAMPLE, "turn"]
    assert [each.label for each in _Sample("cord", 1.0).figures] == [
        "name",
        "length",
        "double",
        "half the length",
        "gone",
    ]


def test_the_repr_is_one_short_line_with_units() -> None:
    assert repr(_Sample("cord", 1.23456)) == "_Sample(name='cord', length=1.23 m)"
    assert repr(_Sample("cord", math.nan)) == "_Sample(name='cord', length=None)"
    assert repr(_Sample(["a"], [1.23456, 2.0])) == "_Sample(name=['a'], length=[1.23, 2] m)"  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (math.nan, None),
        (-math.inf, None),
        (np.float64(2.5), 2.5),
        (np.bool_(True), True),
        (np.array([[1.0, math.nan], [3.0, 4.0]]), [[1.0, None], [3.0, 4.0]]),
        ({"a": (1, np.int64(2))}, {"a": [1, 2]}),
        (_Kind.SWIVEL, "swivel"),
        (Path("runs") / "a", str(Path("runs") / "a")),
        ([_Sample("cord", 1.25)], [SAMPLE]),
    ],
)
def test_values_become_what_json_has(value: object, expected: object) -> None:
    assert plain(value) == expected
    json.dumps(plain(value), allow_nan=False)
