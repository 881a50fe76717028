"""Wrong units are named with the unit that was likely meant, and ordinary robots and jobs are not suspected."""

from __future__ import annotations

import logging
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import cablewright as cw
from cablewright.errors import InputError
from cablewright.printing import job as jobs
from cablewright.robot import Robot, library_names
from cablewright.robot.new_robot import CABLES, LAYOUTS, Outline, robot_file
from cablewright.robot.plausibility import doubts

Table = dict[str, Any]
UNITS = {"mm": 1e3, "cm": 1e2, "inch": 1.0 / 0.0254, "ft": 1.0 / 0.3048}


def scaled(value: Any, factor: float) -> Any:
    return tuple(scaled(one, factor) for one in value) if isinstance(value, tuple | list) else factor * value


def lines(key: str, factor: float, part: str | None = None, only: int | None = None) -> Callable[[Table], None]:
    """Multiply a *key* of all lines, or of *only* one, or of a *part* of them."""

    def change(table: Table) -> None:
        for i, line in enumerate(table["lines"]):
            owner = line if part is None else line[part]
            if only in (None, i) and owner.get(key) is not None:
                owner[key] = scaled(owner[key], factor)

    return change


def platform(key: str, factor: float) -> Callable[[Table], None]:
    return lambda table: table["platform"].update({key: scaled(table["platform"][key], factor)})


def scene(factor: float, *keys: str) -> Callable[[Table], None]:
    return lambda table: table["scene"].update({key: scaled(table["scene"][key], factor) for key in keys})


def all_positions(factor: float) -> Callable[[Table], None]:
    def change(table: Table) -> None:
        scene(factor, "frame_min", "frame_max")(table)
        for key in ("exit_point", "winch_exit", "platform_point"):
            lines(key, factor)(table)

    return change


def modulus(pascals: float) -> Callable[[Table], None]:
    """A modulus with the section that gives the file's stiffness for 100 GPa."""

    def change(table: Table) -> None:
        for line, own in zip(table["lines"], Robot.model_validate(table).lines, strict=True):
            cable = line["cable"]
            for key in ("axial_stiffness", "fill_factor", "construction"):
                cable[key] = None
            cable["young_modulus"], cable["section"] = pascals, own.cable.stiffness / 100e9

    return change


def permuted(*order: int) -> Callable[[Table], None]:
    def change(table: Table) -> None:
        exits = [line["exit_point"] for line in table["lines"]]
        for line, k in zip(table["lines"], order, strict=True):
            line["exit_point"], line["winch_exit"] = exits[k], None

    return change


def mirrored(table: Table) -> None:
    for line in table["lines"]:
        x, y, z = line["exit_point"]
        line["exit_point"], line["winch_exit"] = (-x, y, z), None


MISTAKES: list[tuple[str, str, str, Callable[[Table], None]]] = [
    *((name, "apart", unit, all_positions(UNITS[unit]))
      for name, units in (("house-printer", ("mm", "cm", "inch")), ("cogiro", ("mm", "cm")),
                          ("merlet2023", ("mm", "cm")), ("hangprinter-v4", ("mm",)))
      for unit in units),
    *((name, "exit_point", unit, lines("exit_point", UNITS[unit], only=1))
      for name in ("cogiro", "ipanema") for unit in UNITS),
    *((name, "drum_radius", unit, lines("drum_radius", UNITS[unit], "winch"))
      for name, unit in (("merlet2023", "mm"), ("ipanema", "mm"), ("cogiro", "mm"))),
    ("merlet2023", "sheave.radius", "mm", lines("radius", 1e3, "sheave")),
    ("ipanema1", "sheave.radius", "cm", lines("radius", 1e2, "sheave")),
    ("ipanema", "diameter", "mm", lines("diameter", 1e3, "cable")),
    ("cogiro", "linear_density", "g/m", lines("linear_density", 1e3, "cable")),
    ("maslow4", "linear_density", "g/m", lines("linear_density", 1e3, "cable")),
    ("house-printer", "linear_density", "g/m", lines("linear_density", 1e3, "cable")),
    *((name, "axial_stiffness", unit, lines("axial_stiffness", factor, "cable"))
      for name, unit, factor in (("ipanema2", "kN", 1e-3), ("maslow4", "kN", 1e-3), ("caroca", "MN", 1e-6))),
    ("merlet2023", "young_modulus", "GPa", modulus(100.0)),
    ("cogiro", "young_modulus", "MPa", modulus(1e5)),
    ("house-printer", "mass", "g", platform("mass", 1e3)),
    ("cogiro", "mass", "g", platform("mass", 1e3)),
    ("merlet2023", "mass", "g", platform("mass", 1e3)),
    ("house-printer", "pull at most", "kN", lines("tension_limits", 1e-3)),
    ("ipanema", "pull at most", "kN", lines("tension_limits", 1e-3)),
    ("ipanema", "platform_point", "mm", lines("platform_point", 1e3)),
    ("merlet2023", "winch_exit", "mm", lines("winch_exit", 1e3)),
    ("cogiro", "frame", "mm", scene(1e3, "frame_min", "frame_max")),
    ("cogiro", "gravity", "mm/s^2", scene(1e3, "gravity")),
    ("merlet2023", "gravity", "ft/s^2", scene(1.0 / 0.3048, "gravity")),
    ("house-printer", "names", "mirrored", permuted(2, 1, 0, 3)),
    ("maslow4", "names", "exchanged", permuted(3, 1, 2, 0)),
    ("merlet2023", "names", "exchanged", permuted(1, 3, 2, 0)),
    ("wang2021", "names", "mirrored", mirrored),
]  # fmt: skip


def test_there_are_enough_mistakes() -> None:
    assert len(MISTAKES) >= 40


@pytest.mark.parametrize(("name", "what", "unit", "change"), MISTAKES)
def test_a_wrong_unit_is_named(name: str, what: str, unit: str, change: Callable[[Table], None]) -> None:
    table = cw.load(name).model_dump()
    change(table)
    table["uncertainty"] = None
    sentences = [doubt.sentence for doubt in doubts(Robot.model_validate(table))]
    assert any(what in each and re.search(rf"\b{re.escape(unit)}(\W|$)", each.split(": ")[-1]) for each in sentences)
    assert all("\n" not in sentence for sentence in sentences)


def test_one_exit_point_in_millimetres_is_named_by_its_line() -> None:
    table = cw.load("cogiro").model_dump()
    lines("exit_point", 1e3, only=2)(table)
    first = doubts(Robot.model_validate(table))[0]
    assert first.impossible
    assert first.sentence.startswith("line '3': exit_point is ")


@pytest.mark.parametrize("name", library_names())
def test_robots_of_the_library_are_not_suspected(name: str) -> None:
    assert doubts(cw.load(name)) == ()


@pytest.mark.parametrize("layout", LAYOUTS)
def test_new_robots_are_not_suspected(layout: str) -> None:
    for cable in CABLES:
        for side in (1.0, 2.0, 15.0, 60.0):
            size = (side, 0.0 if layout == "planar" else 0.8 * side, 0.6 * side)
            mass = min(0.5 * side**2, 0.5 * CABLES[cable].max_tension / 9.81)
            mine = cw.loads(robot_file(Outline(name="mine", layout=layout, cable=cable, size=size, mass=mass)))
            assert doubts(mine) == ()


def test_random_ordinary_robots_are_not_suspected() -> None:
    rng = np.random.default_rng(0)
    for _ in range(60):
        size, mass, m = 10.0 ** rng.uniform(-0.5, 1.7), 10.0 ** rng.uniform(0.0, 3.0), int(rng.integers(3, 9))
        around = 2.0 * np.pi * (np.arange(m) + rng.uniform(-0.2, 0.2, m)) / m
        points = size * np.stack([np.cos(around), np.sin(around), rng.uniform(0.2, 1.0, m)], axis=1)
        most = 9.81 * mass * rng.uniform(1.0, 5.0)
        diameter = np.sqrt(5.0 * most / 1e9)
        cable = {"axial_stiffness": most * rng.uniform(50.0, 500.0), "breaking_load": 5.0 * most}
        cable |= {"linear_density": 0.785 * diameter**2 * rng.uniform(900.0, 5500.0), "diameter": diameter}
        cable |= {} if rng.random() < 0.5 else {"diameter": None}
        each = {"cable": cable, "sheave": {"kind": "eyelet"}, "tension_limits": (0.01 * most, most)}
        table = {
            "name": "ordinary",
            "scene": {"frame_min": (-size, -size, 0.0), "frame_max": (size, size, size)},
            "platform": {"mass": mass},
            "lines": [{"name": f"line {i}", "exit_point": tuple(point), **each} for i, point in enumerate(points)],
        }
        assert doubts(Robot.model_validate(table)) == ()


@pytest.mark.parametrize("lies", [True, False])
def test_a_frame_that_lies_has_its_top_at_one_side(lies: bool) -> None:
    cable = {"axial_stiffness": 4e4, "linear_density": 0.02, "breaking_load": 1e4}
    each = {"cable": cable, "sheave": {"kind": "eyelet"}, "tension_limits": (10.0, 2000.0)}
    board = {"bottom left": (0.0, 0.0), "bottom right": (3.0, 0.0), "top left": (0.0, 2.0), "top right": (3.0, 2.0)}
    places = {name: (x, up, 0.1) if lies else (x, 0.1, up) for name, (x, up) in board.items()}
    table = {
        "name": "board",
        "scene": {"frame_min": (0.0, 0.0, 0.0), "frame_max": (3.0, 2.0, 2.0)},
        "platform": {"mass": 10.0},
        "lines": [{"name": name, "exit_point": place, **each} for name, place in places.items()],
    }
    assert doubts(Robot.model_validate(table)) == ()
    if not lies:
        for line, place in zip(table["lines"], reversed(places.values()), strict=True):
            line["exit_point"] = place
        assert any("exchanged or mirrored" in doubt.sentence for doubt in doubts(Robot.model_validate(table)))


def test_a_robot_in_millimetres_is_refused_on_loading() -> None:
    wrong = robot_file(Outline(name="mine", size=(5.0, 4.0, 3.0))).replace("exit_point = [", "exit_point = [1e3, ")
    rows = []
    for row in wrong.splitlines():
        if "[1e3, " in row:
            key, _, values = row.partition("[1e3, ")
            numbers, _, rest = values.partition("]")
            row = f"{key}[{', '.join(str(1e3 * float(value)) for value in numbers.split(','))}]{rest}"
        rows.append(row)
    with pytest.raises(InputError, match=r"own\.toml: the exit points are 5000 m apart.*: 5000 mm\?"):
        cw.loads("\n".join(rows), "own.toml")


def test_a_doubt_is_logged_where_a_robot_is_loaded(caplog: pytest.LogCaptureFixture) -> None:
    text = robot_file(Outline(name="mine", size=(5.0, 4.0, 3.0)))
    with caplog.at_level(logging.WARNING):
        cw.loads(text, "own.toml")
        assert not caplog.records
        cw.loads(text.replace('gravity = "9.81 m/s^2"', "gravity = 981.0"), "own.toml")
    assert caplog.records[0].getMessage() == "note: own.toml: scene: gravity = 981 m/s^2: 981 cm/s^2?"


@pytest.mark.parametrize(
    ("motion", "bead", "says"),
    [
        ({"print_speed": 100.0}, {}, "motion.print_speed = 100 m/s: 100 mm/s or mm/min?"),
        ({"travel_speed": 900.0}, {}, "motion.travel_speed = 900 m/s: 900 mm/min?"),
        ({"acceleration": 500.0}, {}, "motion.acceleration = 500 m/s^2: 500 mm/s^2?"),
        ({}, {"width": 60.0}, "bead.width = 60 m: 60 mm?"),
        ({}, {"height": 1.2}, "bead.height = 1.2 m: 1.2 mm?"),
    ],
)
def test_wrong_units_of_a_job_are_named(motion: Table, bead: Table, says: str) -> None:
    table = {"name": "j", "helix": {"radius": 0.5, "layers": 1, "layer_height": 1e-3}, "motion": motion, "bead": bead}
    assert jobs.doubts(cw.Job.model_validate(table)) == (says,)
    table |= {"motion": {}, "bead": {}}
    assert jobs.doubts(cw.Job.model_validate(table)) == ()


def test_a_speed_beyond_all_is_refused_with_the_likely_unit() -> None:
    table = {
        "name": "j",
        "helix": {"radius": 0.5, "layers": 1, "layer_height": 1e-3},
        "motion": {"print_speed": 2400.0},
    }
    with pytest.raises(ValueError, match=r"must be at most 1000 m/s: 2400 mm/min\?"):
        cw.Job.model_validate(table)
