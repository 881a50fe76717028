"""The table `[dynamics]`: the share of critical damping, read, rejected, assumed and written back."""

from __future__ import annotations

import re

import pytest

from cablewright.foundation.errors import InputError
from cablewright.robot import ASSUMED_DAMPING, Dynamics, library_text, loads, update

TEXT = library_text("grab-four-lines")


def with_ratio(value: str) -> str:
    return TEXT + f"\n[dynamics]\ndamping_ratio = {value}\n"


def test_damping_of_the_file_or_an_assumed_one() -> None:
    given, assumed = loads(with_ratio("0.025")).damping, loads(TEXT).damping
    assert (given, str(given)) == ((0.025, False), "2.5 %")
    assert (assumed, str(assumed)) == ((ASSUMED_DAMPING, True), "1 % (assumed)")
    assert loads(with_ratio("0")).damping == (0.0, False)


@pytest.mark.parametrize(
    ("value", "meant"), [("1.5", "; did you mean 1.5 %, 0.015?"), ("1.0", ""), ("-0.1", ""), ("300", "")]
)
def test_damping_out_of_bounds_is_rejected(value: str, meant: str) -> None:
    why = f"= {value}: must be a share of critical damping, at least 0 and below 1{meant}"
    with pytest.raises(InputError, match=re.escape(f"robot.toml: dynamics.damping_ratio {why}") + "$"):
        loads(with_ratio(value), "robot.toml")


def test_damping_is_written_back() -> None:
    changed = loads(TEXT).model_copy(update={"dynamics": Dynamics(damping_ratio=0.02)})
    assert loads(update(TEXT, changed)) == changed
    text = with_ratio("0.01   # measured")
    assert update(text, changed) == with_ratio("0.02   # measured")
