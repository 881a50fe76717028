"""The one JSON object: NaN and infinities as null, arrays as lists."""

from __future__ import annotations

import json

import numpy as np

from cablewright.apps.cli.output import print_json

NAN, INF = float("nan"), float("inf")


def test_numbers_that_are_not_finite_are_null(capsys) -> None:
    print_json({"a": NAN, "b": [1.0, -INF, {"c": INF}], "d": np.array([[1.5, NAN]]), "e": np.float64(INF), "f": "nan"})
    printed = capsys.readouterr().out
    assert printed.count("\n") == 1
    assert json.loads(printed) == {
        "schema": 3,
        "a": None,
        "b": [1.0, None, {"c": None}],
        "d": [[1.5, None]],
        "e": None,
        "f": "nan",
    }


def test_arrays_and_numpy_scalars_keep_every_digit(capsys) -> None:
    values = {"x": np.array([0.1, 1 / 3]), "n": np.int64(3), "yes": np.bool_(True), "one": np.array(1 / 7)}
    print_json(values)
    assert json.loads(capsys.readouterr().out) == {"schema": 3, "x": [0.1, 1 / 3], "n": 3, "yes": True, "one": 1 / 7}
