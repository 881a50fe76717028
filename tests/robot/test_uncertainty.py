"""Uncertainty files of a robot: the meaning of each form, and the message for each mistake."""

import math
import tomllib
from pathlib import Path
from typing import Any

import pytest
import tomlkit
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from cablewright.analyses.accuracy.expected_error import INTERPOLATION, REMEDIES
from cablewright.foundation.errors import InputError
from cablewright.robot import (
    KINDS,
    Eyelet,
    Parameter,
    Range,
    Robot,
    Uncertainty,
    library_names,
    load,
    load_uncertainty,
    modulus_ranges,
    nominal,
)

HOUSE, BEAM = load("house-printer"), load("jung2020")
NAMES = [line.name for line in HOUSE.lines]
EXAMPLE = """
schema = 1
name = "cables and survey"
coverage = 3.0
[[parameters]]
name = "modulus"
factor = [0.7, 1.3]
[[parameters]]
name = "exit_point"
lines = ["south-west"]
plus_minus = "2 mm"
[[parameters]]
name = "mass"
range = ["190 kg", 230]
[[parameters]]
name = "sheave_radius"
deviation = "0.2 mm"
shared = true
[[parameters]]
name = "length_scale"
relative_deviation = 0.001
[[parameters]]
name = "temperature"
plus_minus = "10 K"
"""


def read(text: str, folder: Path) -> Uncertainty:
    path = folder / "uncertain.toml"
    path.write_text(text, encoding="utf-8")
    return load_uncertainty(path)


def entry(robot: Robot = HOUSE, coverage: float = 2.0, **keys: Any) -> tuple[Range, ...]:
    """The ranges of one entry."""
    return Uncertainty(coverage=coverage, parameters=[keys]).of(robot)


def test_the_example_is_read(tmp_path: Path) -> None:
    uncertainty = read(EXAMPLE, tmp_path)
    assert (uncertainty.name, uncertainty.coverage, uncertainty.schema_version) == ("cables and survey", 3.0, 1)
    found = uncertainty.of(HOUSE)
    x, y, z = HOUSE.lines[0].exit_point
    assert found == (
        *(Range(Parameter("modulus", name), 1.0, 0.7, 1.3) for name in NAMES),
        Range(Parameter("exit_point.x", "south-west"), x, x - 0.002, x + 0.002),
        Range(Parameter("exit_point.y", "south-west"), y, y - 0.002, y + 0.002),
        Range(Parameter("exit_point.z", "south-west"), z, z - 0.002, z + 0.002),
        Range(Parameter("mass"), 200.0, 190.0, 230.0),
        Range(Parameter("sheave_radius"), 0.05, 0.05 - 3 * 0.0002, 0.05 + 3 * 0.0002, 0.0002),
        *(Range(Parameter("length_scale", name), 1.0, 1 - 3 * 0.001, 1 + 3 * 0.001, 0.001) for name in NAMES),
        Range(Parameter("temperature"), 0.0, -10.0, 10.0),
    )


def test_an_uncertainty_is_frozen_compared_by_value_and_read_back(tmp_path: Path) -> None:
    one, other = read(EXAMPLE, tmp_path), read(EXAMPLE.replace("230", '"0.23 t"'), tmp_path)
    assert one == other
    assert hash(one) == hash(other)
    with pytest.raises(ValidationError, match="frozen"):
        one.coverage = 1.0
    assert Uncertainty.model_validate(one.model_dump()) == one
    assert Uncertainty.model_validate_json(one.model_dump_json()) == one


def test_coverage_is_2_and_matters_to_deviations_alone() -> None:
    assert Uncertainty(parameters=[{"name": "mass", "deviation": 1}]).coverage == 2.0
    for coverage in (0.5, 4.0):
        (one,) = entry(coverage=coverage, name="mass", deviation="5 kg")
        assert (one.low, one.high, one.deviation) == (200.0 - coverage * 5, 200.0 + coverage * 5, 5.0)
        assert entry(coverage=coverage, name="mass", plus_minus=1) == entry(name="mass", plus_minus=1)


@pytest.mark.parametrize("way", ["plus_minus", "deviation"])
@pytest.mark.parametrize("kind", [name for name, kind in KINDS.items() if kind.role in ("hardware", "command")])
def test_every_kind_takes_a_width_about_its_nominal(kind: str, way: str) -> None:
    robot = load("cogiro")
    if kind == "counterweight":
        hung = robot.lines[3].model_copy(update={"counterweight": 40.0})
        robot = robot.model_copy(update={"lines": (*robot.lines[:3], hung, *robot.lines[4:])})
    where = {"lines": [robot.lines[3].name]} if kind == "counterweight" else {}
    for one in entry(robot, name=kind, **{way: 1e-3}, **where):
        assert one.parameter.kind == kind
        assert one.nominal == nominal(robot, one.parameter)
        assert one.middle == pytest.approx(one.nominal, abs=1e-15)
        assert one.half_width == pytest.approx(1e-3 if way == "plus_minus" else 2e-3, rel=1e-9)
        assert one.low < one.nominal < one.high


@pytest.mark.parametrize("kind", ["drum_radius", "build_up", "tension_scale", "yaw_offset"])
def test_what_only_a_calibration_knows_is_not_uncertain(kind: str) -> None:
    with pytest.raises(ValidationError, match="name: unknown parameter"):
        entry(HOUSE, name=kind, plus_minus=1e-3)


def test_what_loads_do_is_uncertain_from_nothing_on() -> None:
    soft = tuple(line.model_copy(update={"exit_compliance": 0.0}) for line in HOUSE.lines)
    robot = HOUSE.model_copy(update={"lines": soft})
    for name in ("exit_compliance", "creep_compliance"):
        one = entry(robot, name=name, range=[0.0, 1e-5])[0]
        assert (one.nominal, one.low, one.high) == (0.0, 0.0, 1e-5)
        with pytest.raises(ValidationError, match=r"range.*must be at least 0"):
            entry(robot, name=name, range=[-1e-6, 1e-5])
        with pytest.raises(InputError, match=r"deviation.*: it must be at least 0"):
            entry(robot, name=name, deviation=1e-6)


def test_every_uncertain_kind_has_a_remedy() -> None:
    assert set(REMEDIES) - {INTERPOLATION} == {
        kind.base for kind in KINDS.values() if kind.role in ("hardware", "command", "load")
    }


@pytest.mark.parametrize("name", library_names())
def test_every_robot_takes_moduli_and_exit_points(name: str) -> None:
    robot = load(name)
    parts = [{"name": "modulus", "factor": [0.9, 1.1]}, {"name": "exit_point", "deviation": 1e-3}]
    both = Uncertainty(parameters=parts)
    assert len(both.of(robot)) == 4 * robot.m


def test_a_short_name_is_short_for_three() -> None:
    for short in ("exit_point", "platform_point", "centre_of_mass", "force", "moment"):
        robot = load("cogiro")
        long = [entry(robot, name=f"{short}.{axis}", plus_minus=1e-3) for axis in "xyz"]
        assert entry(robot, name=short, plus_minus=1e-3) == tuple(one for three in long for one in three)


def test_factors_of_a_negative_number_come_in_order() -> None:
    (one,) = entry(name="exit_point.x", lines=["south-west"], factor=[0.9, 1.2])
    assert one.nominal < 0
    assert (one.low, one.high) == (1.2 * one.nominal, 0.9 * one.nominal)


def test_a_relative_deviation_is_of_the_size_of_the_nominal() -> None:
    (one,) = entry(name="exit_point.x", lines=["south-west"], relative_deviation=0.01)
    assert one.deviation == 0.01 * abs(one.nominal)
    assert one.low < one.nominal < one.high


def test_a_range_may_exclude_the_nominal() -> None:
    (one,) = entry(name="mass", range=["250 kg", "300 kg"])
    assert (one.nominal, one.middle, one.half_width) == (200.0, 275.0, 25.0)


@given(st.floats(-1e300, 1e300), st.floats(1e-300, 1e300), st.none() | st.floats(1e-3, 1e3))
def test_middle_half_width_and_sigma(low: float, width: float, deviation: float | None) -> None:
    one = Range(Parameter("force.x"), 0.0, low, low + width, deviation)
    assert one.middle - one.half_width == pytest.approx(one.low, rel=1e-12, abs=1e-12 * width)
    assert one.middle + one.half_width == pytest.approx(one.high, rel=1e-12, abs=1e-12 * width)
    assert one.sigma == (pytest.approx(one.half_width / math.sqrt(3)) if deviation is None else deviation)


# What is wrong in the file itself, whatever the robot: the lines of an entry, and the message after file and entry.
WRONG_ENTRIES = [
    ('name = "modullus"', "name = 'modullus': unknown parameter; did you mean 'modulus'?"),
    ('name = "exitpoint"\nplus_minus = 1', "name = 'exitpoint': unknown parameter; did you mean 'exit_point"),
    ('name = "zzz"', "name = 'zzz': unknown parameter; allowed: "),
    ("name = 3", "name = 3: must be a text"),
    ("factor = [0.7, 1.3]", "name: is missing"),
    ('name = "mass"', "range: is missing: give one of factor, range, plus_minus, deviation, relative_deviation"),
    ('name = "mass"\nplusminus = 1', "plusminus = 1: unknown key; did you mean 'plus_minus'?"),
    ('name = "mass"\nrange = [1, 2]\nfactor = [1, 2]', "range = [1, 2]: give either this or factor, not both"),
    ('name = "mass"\ndeviation = 1\nplus_minus = 2', "deviation = 1: give either this or plus_minus, not both"),
    ('name = "mass"\nrange = [2, 1]', "range = [2, 1]: must rise: the lowest, then the highest"),
    ('name = "mass"\nrange = ["2 kg", 2]', "range = ['2 kg', 2]: must rise"),
    ('name = "mass"\nfactor = [1.0, 1.0]', "factor = [1.0, 1.0]: must rise"),
    ('name = "mass"\nfactor = [nan, 1.0]', "factor[0] = nan: must be a finite number"),
    ('name = "mass"\nrange = [1.0, inf]', "range[1] = inf: must be a finite number"),
    ('name = "mass"\nrange = [1.0]', "range[1]: is missing"),
    ('name = "mass"\nrange = [1, 2, 3]', "range = [1, 2, 3]: must have at most 2 entries, has 3"),
    ('name = "mass"\nrange = 1', "range = 1: must be a list"),
    ('name = "mass"\nrange = [true, 2]', "range[0] = True: must be a valid number"),
    ('name = "mass"\nrange = ["1 m", "2 m"]', "range = ['1 m', '2 m']: must be a finite mass: a number (kg) or a text"),
    ('name = "mass"\nplus_minus = "5 mm"', "plus_minus = '5 mm': must be a finite mass"),
    ('name = "exit_point"\nplus_minus = "5 kg"', "plus_minus = '5 kg': must be a finite length"),
    ('name = "temperature"\nplus_minus = "10 degC"', "plus_minus = '10 degC': must be a finite temperature difference"),
    ('name = "modulus"\nplus_minus = "5 %"', "plus_minus = '5 %': must be a valid number"),
    ('name = "mass"\nfactor = ["1 kg", 2]', "factor[0] = '1 kg': must be a valid number"),
    ('name = "mass"\nplus_minus = 0', "plus_minus = 0: must be greater than 0"),
    ('name = "mass"\nplus_minus = "-1 kg"', "plus_minus = '-1 kg': must be greater than 0"),
    ('name = "mass"\nrelative_deviation = 0.0', "relative_deviation = 0.0: must be greater than 0"),
    ('name = "mass"\nrange = [0, 1]', "range = [0, 1]: must be above 0"),
    ('name = "modulus"\nfactor = [0.0, 1]', "factor = [0.0, 1]: must be above 0"),
    ('name = "sheave_radius"\nrange = ["-1 mm", 1]', "range = ['-1 mm', 1]: must be above 0"),
    ('name = "length_scale"\nrange = [0, 1]', "range = [0, 1]: must be above 0"),
    ('name = "linear_density"\nrange = [-1, 1]', "range = [-1, 1]: must be above 0"),
    ('name = "modulus"\nshared = 1', "shared = 1: must be true or false"),
    (
        'name = "mass"\nplus_minus = 1\nshared = true',
        "shared = True: mass cannot be shared by lines: it is a number of",
    ),
    ('name = "exit_point"\nplus_minus = 1\nshared = true', "shared = True: exit_point.x cannot be shared by lines"),
    ('name = "mass"\nplus_minus = 1\nlines = ["a"]', "lines = ['a']: mass is a number of the platform, not of a line"),
    ('name = "temperature"\nplus_minus = 1\nlines = ["a"]', "lines = ['a']: temperature is one number for all lines"),
    ('name = "modulus"\nplus_minus = 1\nlines = []', "lines = []: must name at least one line"),
    ('name = "modulus"\nplus_minus = 1\nlines = "a"', "lines = 'a': must be a list"),
    ('name = "modulus"\nplus_minus = 1\nlines = [1]', "lines[0] = 1: must be a text"),
    ('name = "modulus"\nplus_minus = 1\nlines = ["a", "a"]', "lines = ['a', 'a']: names 'a' more than once"),
    ('name = "modulus"\nplus_minus = 1\nlines = ["a"]\nshared = true', "shared = True: is one number for all lines"),
]


@pytest.mark.parametrize(("keys", "message"), WRONG_ENTRIES)
def test_a_wrong_entry_is_reported_in_one_line(keys: str, message: str, tmp_path: Path) -> None:
    good = '[[parameters]]\nname = "force.x"\nplus_minus = 1\n'
    with pytest.raises(InputError) as error:
        read(f"schema = 1\n{good}[[parameters]]\n{keys}\n", tmp_path)
    assert str(error.value).startswith(f"{tmp_path / 'uncertain.toml'}: parameters[1].{message}")
    with pytest.raises(InputError) as alone:
        read(f"schema = 1\n[[parameters]]\n{keys}\n", tmp_path)
    assert str(alone.value) == str(error.value).replace("parameters[1]", "parameters[0]")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "missing key 'schema'"),
        ("schema = 2", "schema = 2: written for a newer cablewright"),
        ("schema = 1", "parameters: is missing"),
        ("schema = 1\nparameters = []", "parameters = []: must have at least 1 entry"),
        ("schema = 1\nparameters = [1]", "parameters[0] = 1: must be a table"),
        ("schema = 1\nparameters = {}", "parameters: must be a list"),
        ("schema = 1\n[[parameter]]", "parameter: unknown key; did you mean 'parameters'?"),
        ("schema = 1\ncoverage = 0\nparameters = []", "coverage = 0: must be greater than 0"),
        ("schema = 1\ncoverage = 1000\nparameters = []", "coverage = 1000: must be at most 100"),
        ("schema = 1\ncoverage = '2'\nparameters = []", "coverage = '2': must be a valid number"),
        ("schema = 1\nname = 3\nparameters = []", "name = 3: must be a text"),
        ("schema = [", "not TOML"),
    ],
)
def test_a_wrong_file_is_reported_in_one_line(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as error:
        read(text, tmp_path)
    assert str(error.value).startswith(f"{tmp_path / 'uncertain.toml'}: {message}")
    assert " more)" not in str(error.value)


def test_a_file_has_at_most_200_entries(tmp_path: Path) -> None:
    one = "[[parameters]]\nname = 'mass'\nplus_minus = 1\n"
    assert len(read("schema = 1\n" + 200 * one, tmp_path).parameters) == 200
    with pytest.raises(InputError, match="parameters: must have at most 200 entries"):
        read("schema = 1\n" + 201 * one, tmp_path)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        load_uncertainty(tmp_path / "none.toml")


JOINT = HOUSE.lines[0]
OVER = JOINT.winch_exit[2] if JOINT.winch_exit else math.nan


@pytest.mark.parametrize(
    ("robot", "keys", "message"),
    [
        (HOUSE, {"name": "modulus", "lines": ["sout-west"], "plus_minus": 0.1}, "lines = ['sout-west']: unknown line"),
        (HOUSE, {"name": "moment", "plus_minus": 1}, "name = 'moment': 'house-printer' is a point platform"),
        (BEAM, {"name": "sheave_radius", "plus_minus": 1}, "name = 'sheave_radius': line '1' has an eyelet"),
        (BEAM, {"name": "sheave_radius", "plus_minus": 1, "lines": ["2"]}, "lines = ['2']: line '2' has an eyelet"),
        (HOUSE, {"name": "force.x", "factor": [0.5, 2]}, "factor = [0.5, 2.0]: the force x of the file is 0, which no"),
        (HOUSE, {"name": "length_offset", "factor": [0.5, 2]}, "factor = [0.5, 2.0]: the length offset of south-west"),
        (HOUSE, {"name": "temperature", "factor": [0.5, 2]}, "factor = [0.5, 2.0]: the temperature of the file is 0"),
        (HOUSE, {"name": "force", "relative_deviation": 0.1}, "relative_deviation = 0.1: the force x of the file is 0"),
        (HOUSE, {"name": "mass", "plus_minus": 200}, "plus_minus = 200.0: mass from 0 to 400 kg: it must be above 0"),
        (HOUSE, {"name": "mass", "deviation": 150}, "deviation = 150.0: mass from -100 to 500 kg: it must be above 0"),
        (HOUSE, {"name": "modulus", "relative_deviation": 0.5}, "relative_deviation = 0.5: modulus of south-west from"),
        (HOUSE, {"name": "linear_density", "plus_minus": 1}, "plus_minus = 1.0: linear density of south-west from -0."),
        (HOUSE, {"name": "exit_compliance", "deviation": 1e-6}, "name = 'exit_compliance': line 'south-west' gives no"),
        (HOUSE, {"name": "mass", "factor": [1, 1e308]}, "factor = [1.0, 1e+308]: the mass would not be finite"),
        (HOUSE, {"name": "force.x", "deviation": 1e308}, "deviation = 1e+308: the force x would not be finite"),
        (HOUSE, {"name": "force.x", "range": [-1.7e308, 1.7e308]}, "range = [-1.7e+308, 1.7e+308]: the force x would"),
        (
            HOUSE,
            {"name": "mass", "plus_minus": 1e-20},
            "plus_minus = 1e-20: too narrow: rounding leaves one number, 20",
        ),
        (
            HOUSE,
            {"name": "sheave_radius", "range": ["40 mm", "110 mm"]},
            "range = [0.04, 0.11]: sheave radius of south-west from 0.04 to 0.11 m: the lever of 'south-west' is",
        ),
        (
            HOUSE,
            {"name": "sheave_radius", "factor": [0.5, 5], "shared": True},
            "factor = [0.5, 5.0]: sheave radius of all lines from 0.025 to 0.25 m: the lever of 'south-west' is",
        ),
        (
            HOUSE,
            {"name": "exit_point.z", "lines": ["south-west"], "range": [OVER, 20]},
            f"range = [{OVER!r}, 20.0]: exit point z of south-west from {OVER:g} to 20 m: it reaches the winch exit of",
        ),
    ],
)
def test_a_mismatch_with_the_robot_is_reported_in_one_line(robot: Robot, keys: dict[str, Any], message: str) -> None:
    uncertainty = Uncertainty(parameters=[{"name": "force.y", "plus_minus": 1}, keys])
    for origin in ("the uncertainty", "some/file.toml"):
        with pytest.raises(InputError) as error:
            uncertainty.of(robot, origin)
        assert str(error.value).startswith(f"{origin}: parameters[1].{message}")
    with pytest.raises(InputError, match=r"^the uncertainty: parameters\[1\]"):
        uncertainty.of(robot)


def test_the_height_of_an_exit_stays_on_its_side_of_the_winch() -> None:
    assert len(entry(name="exit_point.z", range=[OVER + 1e-3, 20])) == 4
    sheave = JOINT.sheave.model_copy(update={"wrap": "under"})
    line = JOINT.model_copy(update={"sheave": sheave, "winch_exit": (*JOINT.exit_point[:2], 18.0)})
    under = HOUSE.model_copy(update={"lines": (line, *HOUSE.lines[1:])})
    assert entry(under, name="exit_point.z", lines=[line.name], range=[1, 17.9])
    with pytest.raises(InputError, match="it reaches the winch exit of 'south-west', at 18 m"):
        entry(under, name="exit_point.z", lines=[line.name], range=[1, 18])
    for free in (line.model_copy(update={"winch_exit": None}), line.model_copy(update={"sheave": Eyelet()})):
        robot = HOUSE.model_copy(update={"lines": (free, *HOUSE.lines[1:])})
        assert entry(robot, name="exit_point.z", lines=[line.name], range=[1, 20])


def test_a_radius_as_long_as_the_lever_is_allowed() -> None:
    assert len(entry(name="sheave_radius", range=["40 mm", "104 mm"])) == 4


@pytest.mark.parametrize(
    ("one", "other", "label"),
    [
        ({"name": "mass"}, {"name": "mass"}, "mass"),
        ({"name": "modulus"}, {"name": "modulus", "lines": ["north-east"]}, "modulus of north-east"),
        ({"name": "modulus", "shared": True}, {"name": "modulus"}, "modulus of south-west"),
        ({"name": "modulus", "lines": ["north-east"]}, {"name": "modulus", "shared": True}, "modulus of north-east"),
        ({"name": "exit_point.y"}, {"name": "exit_point"}, "exit point y of south-west"),
        ({"name": "temperature"}, {"name": "temperature", "shared": True}, "temperature"),
    ],
)
def test_a_number_given_twice_is_rejected(one: dict[str, Any], other: dict[str, Any], label: str) -> None:
    twice = Uncertainty(parameters=[keys | {"plus_minus": 1e-3} for keys in (one, other)])
    with pytest.raises(InputError) as error:
        twice.of(HOUSE)
    assert str(error.value) == f"the uncertainty: parameters[1].name: {label} is given by parameters[0] already"


def test_different_lines_may_have_entries_of_their_own() -> None:
    parts = [{"name": "modulus", "lines": [name], "plus_minus": 0.1} for name in NAMES]
    assert Uncertainty(parameters=parts).of(HOUSE) == entry(name="modulus", plus_minus=0.1)


def test_moduli_of_every_line() -> None:
    assert modulus_ranges(HOUSE) == entry(name="modulus", factor=[0.7, 1.3])
    assert modulus_ranges(BEAM, 0.5, 0.9) == entry(BEAM, name="modulus", factor=[0.5, 0.9])


@pytest.mark.parametrize(
    ("low", "high"),
    [(1.3, 0.7), (1.0, 1.0), (0.0, 1.0), (-1.0, 1.0), (math.nan, 1.0), (0.5, math.nan), (0.5, math.inf)],
)
def test_moduli_that_cannot_be(low: float, high: float) -> None:
    with pytest.raises(InputError, match=r"^modulus range \S+ to \S+: must be two finite factors above 0 that rise"):
        modulus_ranges(HOUSE, low, high)


# The fuzz: near files, most of which some robot can have, and wild ones.
NAME = st.sampled_from([*KINDS, "exit_point", "platform_point", "centre_of_mass", "force", "moment"])
SIZE = st.floats(1e-6, 0.1) | st.sampled_from([5e-324, 1e-20, 1.0, 1e308])
NEAR_WAYS = {
    "factor": st.lists(st.floats(0.0, 2.0), min_size=2, max_size=2, unique=True).map(sorted),
    "range": st.lists(st.floats(-1.0, 300.0), min_size=2, max_size=2, unique=True).map(sorted),
    **dict.fromkeys(("plus_minus", "deviation", "relative_deviation"), SIZE),
}
NEAR_EXTRAS = {"lines": st.lists(st.sampled_from(NAMES), min_size=1, max_size=4, unique=True), "shared": st.booleans()}
NEAR_ENTRIES = st.sampled_from(list(NEAR_WAYS)).flatmap(
    lambda way: st.fixed_dictionaries({"name": NAME, way: NEAR_WAYS[way]}, optional=NEAR_EXTRAS)
)
NEAR = st.fixed_dictionaries({"parameters": st.lists(NEAR_ENTRIES, min_size=1, max_size=2)})

WIDTHS = (
    st.sampled_from([0.7, 1e308, 5e-324, 10**400, "2 mm", "1 kg", "1e400 m", "-2 mm", "1 N m", "0.2", "", "\0"])
    | st.floats()
    | st.text(max_size=10)
)
ANYTHING = st.recursive(
    WIDTHS | st.booleans(),
    lambda deeper: st.lists(deeper, max_size=3) | st.dictionaries(st.text(max_size=4), deeper, max_size=3),
    max_leaves=5,
)
KEYS = st.sampled_from(["name", *NEAR_WAYS, *NEAR_EXTRAS]) | st.text(max_size=5)
WILD_ENTRIES = st.dictionaries(KEYS, ANYTHING, max_size=4) | st.fixed_dictionaries(
    {"name": NAME}, optional=dict.fromkeys([*NEAR_WAYS, *NEAR_EXTRAS], ANYTHING)
)
WILD = st.fixed_dictionaries(
    {"parameters": st.lists(WILD_ENTRIES, max_size=4) | ANYTHING}, optional={"coverage": ANYTHING, "name": ANYTHING}
)


@given(file=NEAR | WILD, robot=st.sampled_from([HOUSE, BEAM]))
def test_whatever_a_file_says_it_is_an_uncertainty_or_one_line(
    file: dict[str, Any], robot: Robot, tmp_path_factory: pytest.TempPathFactory
) -> None:
    text = tomlkit.dumps({"schema": 1} | file)
    tomllib.loads(text)  # the strategy writes TOML: the content is rejected below
    try:
        found = read(text, tmp_path_factory.getbasetemp()).of(robot)
    except InputError:
        return
    assert len({one.parameter for one in found}) == len(found) > 0
    for one in found:
        assert -math.inf < one.low < one.high < math.inf
        assert 0.0 < one.half_width < math.inf
        assert 0.0 < one.sigma < math.inf
        assert one.low <= one.middle <= one.high
        assert KINDS[one.parameter.kind].allows(one.low)
        assert one.nominal == nominal(robot, one.parameter)
