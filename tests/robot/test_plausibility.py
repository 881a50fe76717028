"""Wrong units are named with the unit that was likely meant, and ordinary robots and jobs are not suspected."""

from __future__ import annotations

import logging
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tools.random_prints import random_print

import cablewright as cw
from cablewright.exchange.formats import read_robot
from cablewright.exchange.robot_toml import plain_toml
from cablewright.foundation.errors import InputError
from cablewright.foundation.validation import validated
from cablewright.machine.settings import Extrusion
from cablewright.printing import job as jobs
from cablewright.printing.job import load_job
from cablewright.printing.schedule import ScheduleStep
from cablewright.robot import Robot, library_names
from cablewright.robot.new_robot import CABLES, LAYOUTS, Outline, robot_file
from cablewright.robot.plausibility import doubts
from cablewright.robot.sheave import Swivel, UniversalJoint
from exchange.samples import BODIES, FORK, KLIPPER, MASLOW, RRF, caspr_cables, wirex

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


def put(part: str | None, key: str, value: Any) -> Callable[[Table], None]:
    """Give all lines, or a *part* of them, a *value*."""

    def change(table: Table) -> None:
        for line in table["lines"]:
            (line if part is None else line[part])[key] = value

    return change


def put_platform(key: str, value: Any) -> Callable[[Table], None]:
    return lambda table: table["platform"].update({key: value})


def boxes(factor: float) -> Callable[[Table], None]:
    box = {"lowest": (-0.4 * factor, -0.4 * factor, 0.0), "highest": (0.4 * factor, 0.4 * factor, 0.3 * factor)}
    return put_platform("boxes", (box,))


def section(square_metres: float) -> Callable[[Table], None]:
    """A section in mm^2, with a modulus that is right."""

    def change(table: Table) -> None:
        for line in table["lines"]:
            cable = line["cable"]
            for key in ("axial_stiffness", "fill_factor", "construction", "diameter"):
                cable[key] = None
            cable["young_modulus"], cable["section"] = 100e9, square_metres

    return change


def stiffness(factor: float, load: float) -> Callable[[Table], None]:
    """Cables that *load* times the file's tensions strain at the limits, in other units."""

    def change(table: Table) -> None:
        for line in table["lines"]:
            line["cable"]["breaking_load"] *= load
        lines("tension_limits", load)(table)
        lines("axial_stiffness", factor, "cable")(table)

    return change


def beam(factor: float) -> Callable[[Table], None]:
    beams = ({"start": (0.0, -factor, factor), "end": (0.0, factor, factor), "radius": 0.05 * factor},)
    return lambda table: table["scene"].update({"beams": beams})


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
      for name, units in (("house-printer", ("mm", "cm")), ("cogiro", ("mm", "cm")),
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
    ("house-printer", "capacity", "inch", all_positions(UNITS["inch"])),
    ("expo2015-lucia", "capacity", "ft", all_positions(UNITS["ft"])),
    ("building-printer", "inertia", "inch", all_positions(UNITS["inch"])),
    ("cogiro", "inertia", "inch", all_positions(UNITS["inch"])),
    ("caroca", "inertia", "inch", all_positions(UNITS["inch"])),
    ("building-printer", "inertia", "kg cm^2", platform("inertia", 1e4)),
    ("ipanema", "inertia", "kg mm^2", platform("inertia", 1e6)),
    ("grab-four-lines", "inertia", "g mm^2", platform("inertia", 1e9)),
    ("house-printer", "facing", "deg", put("sheave", "facing", 90.0)),
    ("merlet2023", "facing", "deg", put("sheave", "facing", -45.0)),
    ("house-printer", "max_speed", "mm/s", put("winch", "max_speed", 1000.0)),
    ("merlet2023", "max_speed", "mm/min", put("winch", "max_speed", 11e3)),
    ("expo2015-lucia", "max_speed", "m/min", put("winch", "max_speed", 72.0)),
    ("house-printer", "max_torque", "N mm", lines("max_torque", 1e3, "winch")),
    ("building-printer", "max_torque", "kN m", lines("max_torque", 1e-3, "winch")),
    ("cogiro", "thermal_expansion", "ppm/K", put("cable", "thermal_expansion", 12.0)),
    ("ipanema", "thermal_expansion", "ppm/K", put("cable", "thermal_expansion", -6.0)),
    ("cogiro", "exit_compliance", "mm/N", put(None, "exit_compliance", 1e-3)),
    ("maslow4", "spring", "N/mm", put(None, "spring", 200.0)),
    ("hangprinter-v4", "dead_length", "mm", put(None, "dead_length", 800.0)),
    ("cogiro", "section", "mm^2", section(12.6)),
    ("jung2020", "section", "mm^2", section(3.1)),
    ("ipanema", "diameter", "inch", lines("diameter", UNITS["inch"], "cable")),
    ("caroca", "diameter", "ft", lines("diameter", UNITS["ft"], "cable")),
    ("maslow4", "axial_stiffness", "kgf", stiffness(1.0 / 9.80665, 4.0)),
    ("cogiro", "young_modulus", "psi", modulus(1.45e7)),
    ("building-printer", "nozzle", "mm", put_platform("nozzle", (0.0, 0.0, -300.0))),
    ("cogiro", "centre_of_mass", "mm", put_platform("centre_of_mass", (0.0, 20.0, 150.0))),
    ("cogiro", "boxes", "mm", boxes(1e3)),
    ("cogiro", "boxes", "inch", boxes(UNITS["inch"])),
    ("cogiro", "beams", "mm", beam(1e3)),
    ("jung2020", "load 'full'", "g", put_platform("loads", ({"name": "full", "mass": 20e3},))),
    ("hangprinter-v4", "pull at most", "N", platform("mass", 1.3 * 9.80665)),
    ("hangprinter-v4", "pull at most", "kgf", lines("tension_limits", 1.0 / (1.3 * 9.80665))),
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
    for _ in range(150):
        half, m = 10.0 ** rng.uniform(-0.82, 2.4), int(rng.integers(3, 9))  # 0.3 m to 500 m from side to side
        mass = half ** rng.uniform(0.5, 1.5) * 10.0 ** rng.uniform(0.0, 2.0)
        around = 2.0 * np.pi * (np.arange(m) + rng.uniform(-0.2, 0.2, m)) / m
        points = half * np.stack([np.cos(around), np.sin(around), rng.uniform(0.2, 1.0, m)], axis=1)
        most = 9.81 * mass * rng.uniform(1.0, 5.0)
        diameter = np.sqrt(5.0 * most / 1e9)
        cable = {"axial_stiffness": most * rng.uniform(50.0, 500.0), "breaking_load": 5.0 * most}
        cable |= {"linear_density": 0.785 * diameter**2 * rng.uniform(700.0, 5500.0), "diameter": diameter}
        cable |= {} if rng.random() < 0.5 else {"diameter": None}
        drum = max(0.02, 20.0 * diameter)
        winch = {
            "drum_radius": drum,
            "max_torque": drum * most * rng.uniform(0.5, 3.0),
            "max_speed": rng.uniform(0.05, 5.0),
        }
        winch |= {"capacity": half * rng.uniform(3.0, 10.0)} if rng.random() < 0.5 else {}
        sheave = (
            {"kind": "eyelet"}
            if rng.random() < 0.5
            else {"kind": "swivel", "radius": drum, "facing": rng.uniform(-3, 3)}
        )
        each = {"cable": cable, "sheave": sheave, "tension_limits": (0.01 * most, most), "winch": winch}
        reach = half * rng.uniform(0.01, 0.3)
        body = {"kind": "rigid", "mass": mass, "inertia": (0.3 * mass * reach**2,) * 3, "nozzle": (0.0, 0.0, -reach)}
        body |= {"boxes": ({"lowest": (-0.5 * reach,) * 3, "highest": (0.5 * reach, 0.5 * reach, 0.0)},)}
        is_body = bool(m > 5 and rng.random() < 0.5 and mass > 0.5 * reach and mass > 3.0 * reach**3)
        generous = rng.uniform(0.2, 4.0)
        table = {
            "name": "ordinary",
            "scene": {"frame_min": (-generous * half, -generous * half, 0.0), "frame_max": (generous * half,) * 3},
            "platform": body if is_body else {"mass": mass},
            "lines": [{"name": f"line {i}", "exit_point": tuple(point), **each} for i, point in enumerate(points)],
        }
        for i, line in enumerate(table["lines"] if is_body else ()):
            line["platform_point"] = tuple(reach * points[i] / half)
        assert doubts(Robot.model_validate(table)) == ()


def imports(folder: Path) -> Iterator[Robot]:
    """The robots of files of other programs, of each format that is read."""
    texts = {"vertical.yaml": MASLOW, "flat.yaml": MASLOW.replace("vertical: true", "vertical: false")}
    texts |= {"printer.cfg": KLIPPER, "fork.cfg": FORK, "config.g": RRF}
    texts |= {f"own{version}.wcrfx": wirex(version) for version in ("0.31", "0.32")}
    texts["example.wcrfx"] = Path("examples/robot.wcrfx").read_text()
    for name, text in texts.items():
        (folder / name).write_text(text)
        yield read_robot([folder / name]).robot
    (folder / "own_bodies.xml").write_text(BODIES)
    (folder / "own_cables.xml").write_text(caspr_cables())
    yield read_robot([folder / "own_bodies.xml"]).robot


def test_imports_are_not_suspected(tmp_path: Path) -> None:
    robots = list(imports(tmp_path))
    assert len(robots) == 9
    for robot in robots:
        assert doubts(robot) == ()
        assert doubts(cw.loads(plain_toml(robot))) == ()


def test_robots_with_random_prints_are_not_suspected(tmp_path: Path) -> None:
    for number in range(40):
        robot, job = random_print(5, number, tmp_path)
        assert doubts(robot) == ()
        assert jobs.doubts(job) == ()


@pytest.mark.parametrize("name", ["house.toml", "helix.toml"])
def test_jobs_of_the_examples_are_not_suspected(name: str) -> None:
    assert jobs.doubts(load_job(Path("examples") / name)) == ()


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


def test_a_robot_in_millimetres_is_rejected_on_loading() -> None:
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
        ({"jerk": 5000.0}, {}, "motion.jerk = 5000 m/s^3: 5000 mm/s^3?"),
        ({"corner_deviation": 5.0}, {}, "motion.corner_deviation = 5 m: 5 mm?"),
        ({}, {"height": 1.2}, "bead.height = 1.2 m: 1.2 mm?"),
    ],
)
def test_wrong_units_of_a_job_are_named(motion: Table, bead: Table, says: str) -> None:
    table = {"name": "j", "helix": {"radius": 0.5, "layers": 1, "layer_height": 1e-3}, "motion": motion, "bead": bead}
    assert jobs.doubts(cw.Job.model_validate(table)) == (says,)
    table |= {"motion": {}, "bead": {}}
    assert jobs.doubts(cw.Job.model_validate(table)) == ()


def test_a_speed_beyond_all_is_rejected_with_the_likely_unit() -> None:
    table = {
        "name": "j",
        "helix": {"radius": 0.5, "layers": 1, "layer_height": 1e-3},
        "motion": {"print_speed": 2400.0},
    }
    with pytest.raises(ValueError, match=r"must be at most 1000 m/s: 2400 mm/min\?"):
        cw.Job.model_validate(table)


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("swing", 45.0, "swing = 45.0: must be at most 3.14159 rad: 45 deg?"),
        ("swing", "45 deg", ""),
        ("lever_range", [-30.0, 60.0], "lever_range[0] = -30.0: must be at least -3.14159 rad: -30 deg?"),
    ],
)
def test_angles_out_of_bounds_are_named_in_degrees(key: str, value: Any, said: str) -> None:
    table = {"kind": "swivel", "radius": 0.05, "facing": 0.0}
    if key == "lever_range":
        table |= {"kind": "universal-joint", "lever": 0.2, "lever_weight": 1.0, "lever_mass_centre": 0.1}
    model = Swivel if key == "swing" else UniversalJoint
    if not said:
        assert validated(model, table | {key: value}, "own").swing == pytest.approx(np.pi / 4)
        return
    with pytest.raises(InputError, match=re.escape(said)):
        validated(model, table | {key: value}, "own")


def test_rotations_and_densities_in_other_units_are_rejected() -> None:
    with pytest.raises(ValueError, match=r"must be no longer than pi rad, half a turn: are these deg\?"):
        ScheduleStep(z=0.0, rotation=(0.0, 0.0, 30.0))
    with pytest.raises(InputError, match=r"density = 2\.1: must be at least 10 kg/m\^3: 2\.1 g/cm\^3\?"):
        validated(Extrusion, {"density": 2.1}, "own")


def test_a_diameter_whose_square_is_no_number_is_named() -> None:
    robot = cw.load("paty2021")
    lines = tuple(
        line.model_copy(update={"cable": line.cable.model_copy(update={"diameter": 1e-200})}) for line in robot.lines
    )
    assert any("kg/m" in str(each) for each in doubts(robot.model_copy(update={"lines": lines})))
