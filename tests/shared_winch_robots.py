"""Robots whose winches are fewer than their lines: hoists with a counterweight, and lines that share winches."""

from __future__ import annotations

from tools.pages.line_prints import CABLE, WINCH, hoist, pairs

from cablewright.robot import Robot

__all__ = ["CABLE", "WINCH", "crane", "hoist", "pairs", "two_on_one"]


def crane() -> Robot:
    """The `hoist` with a fourth winch, so that its lengths can be tested."""
    table = hoist().model_dump(by_alias=True)
    fourth = table["lines"][0] | {"name": "d", "exit_point": (0.3, 1.9, 2.9)}
    lines = [*table["lines"][:3], fourth, table["lines"][3]]
    return Robot.model_validate(table | {"name": "crane", "lines": lines})


def two_on_one(winds: str) -> Robot:
    """A point on two lines of one drum: of its turn alone."""
    every = {"sheave": {"kind": "eyelet"}, "winch": WINCH, "cable": CABLE, "tension_limits": (0.5, 400.0)}
    other = {"line": "a", "offset": -0.5 if winds == "along" else 3.5, "winds": winds}
    return Robot.model_validate({
        "name": "two on one",
        "scene": {"frame_min": (-0.5, -0.5, 0.0), "frame_max": (0.5, 0.5, 1.0)},
        "platform": {"kind": "point", "mass": 5.0},
        "lines": [
            every | {"name": "a", "exit_point": (-1.0, 0.0, 3.0)},
            every | {"name": "b", "exit_point": (1.0, 0.0, 3.0), "shared_winch": other},
        ],
    })  # fmt: skip
