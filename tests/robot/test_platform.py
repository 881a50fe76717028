"""Rigid platforms, payload states and retraction: their values, and the input that each rejects."""

import itertools
import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from cablewright.foundation.errors import InputError, UnknownName
from cablewright.robot import Load, Plane, PointPlatform, Retraction, RigidPlatform, Robot, load, loads, update

FILE = """
schema = 1
name = "beam"
scene = { frame_min = [-1, -1, 0], frame_max = [1, 1, 3] }
cable = { axial_stiffness = "150 kN", linear_density = "2 g/m", breaking_load = "2 kN" }
sheave = { kind = "eyelet" }
line = { tension_limits = ["1 N", "1 kN"] }
[[lines]]
name = "east"
exit_point = [1, 0, 3]
platform_point = [0.1, 0, 0.5]
[[lines]]
name = "west"
exit_point = [-1, 0, 3]
platform_point = [-0.1, 0, 0.5]
[platform]
kind = "rigid"
mass = "10 kg"
"""
RETRACTION: dict[str, Any] = {"length": 2.0, "least": 1.2, "most": 2.0, "lines": ("a",)}
BODY: dict[str, Any] = {"mass": 10, "inertia": (3, 4, 5)}


def message(platform: str, text: str = FILE) -> str:
    """Return the line that rejects the file with more in its platform's table."""
    with pytest.raises(InputError) as caught:
        loads(text + platform, "r.toml")
    assert "\n" not in str(caught.value)
    return str(caught.value).removeprefix("r.toml: ")


def refused(kind: Any, values: dict[str, Any], match: str) -> None:
    with pytest.raises(ValidationError, match=match):
        kind(**values)


def test_a_platform_is_a_point_unless_it_says_otherwise() -> None:
    together = FILE.replace("platform_point", "winch_exit")
    assert loads(FILE).n == 6
    assert isinstance(loads(together.replace('kind = "rigid"', "")).platform, PointPlatform)
    assert loads(together.replace("rigid", "point")).n == 3
    values = load("paty2021").model_dump() | {"platform": {"mass": 1}}
    assert Robot.model_validate(values).platform == PointPlatform(mass=1)


def test_the_defaults_of_a_rigid_platform() -> None:
    zero = (0.0, 0.0, 0.0)
    platform = loads(FILE).platform
    assert platform == RigidPlatform(mass=10)
    assert isinstance(platform, RigidPlatform)
    assert (platform.freedoms, platform.inertia, platform.retraction, platform.loads) == (6, None, None, ())
    vectors = (platform.centre_of_mass, platform.inertia_products, platform.nozzle, platform.force, platform.moment)
    assert vectors == (zero,) * 5


def test_units_of_a_rigid_platform() -> None:
    platform = loads(
        FILE
        + """centre_of_mass = ["1 mm", 0, "-2 cm"]
        inertia = ["300 kg cm^2", 0.04, "5e4 kg mm^2"]
        inertia_products = ["1e6 g mm^2", 0, 0]
        nozzle = [0, 0, "-30 cm"]
        force = ["1 kN", 0, -1]
        moment = [0, "2 kN m", "3 mN m"]"""
    ).platform
    assert platform == RigidPlatform(
        mass=10,
        centre_of_mass=(0.001, 0, -0.02),
        inertia=(0.03, 0.04, 0.05),
        inertia_products=(1e-3, 0, 0),
        nozzle=(0, 0, -0.3),
        force=(1000, 0, -1),
        moment=(0, 2000, 0.003),
    )


FAULTS = [
    ("mas = 3", "platform.mas = 3: unknown key; did you mean 'mass'?"),
    ("inertia = [1, 2]", "platform.inertia[2]: is missing"),
    ("inertia = [1, 2, 'x']", "platform.inertia[2] = 'x': must be a finite inertia: a number (kg m^2) or a text"),
    ("inertia = [1, 2, '3 N m']", "platform.inertia[2] = '3 N m': must be a finite inertia"),
    ("inertia = [0, 1, 1]", "platform.inertia = [0, 1, 1]: must be positive definite"),
    (
        "inertia = [1, 2, 3.01]",
        "platform.inertia = [1, 2, 3.01]: no body has these moments: none may exceed the sum of",
    ),
    ("inertia_products = [0, 0, 1]", "platform.inertia_products = [0, 0, 1]: needs inertia, the moments that go"),
    ("moment = 3", "platform.moment = 3: must be a list"),
    ("force = ['1 m', 0, 0]", "platform.force[0] = '1 m': must be a finite force"),
    ("nozzle = [0, 0, nan]", "platform.nozzle[2] = nan: must be a finite length"),
    ("loads = [{}]", "platform.loads[0].name: is missing"),
    ("loads = [{ name = '' }]", "platform.loads[0].name = '': must not be empty"),
    ("loads = [{ name = 'a', mass = 0 }]", "platform.loads[0].mass = 0: must be greater than 0"),
    ("loads = [{ name = 'a', nozzle = 0 }]", "platform.loads[0].nozzle = 0: unknown key; allowed: centre_of_mass,"),
    ("loads = [{ name = 'a' }, { name = 'a' }]", "platform.loads: 2 loads are named 'a'; each needs a name of its own"),
    (
        "loads = [{ name = 'a' }, { name = 'b', inertia = [1, 1, 3] }]",
        "platform.loads[1].inertia = [1, 1, 3]: no body has these moments",
    ),
    (
        "loads = [{ name = 'a', inertia_products = [1, 0, 0] }]",
        "platform.loads[0].inertia_products = [1, 0, 0]: needs inertia",
    ),
    (
        "inertia = [1, 1, 1]\nloads = [{ name = 'a', inertia_products = [2, 0, 0] }]",
        "platform.loads[0].inertia: must be positive definite",
    ),
    ("[platform.retraction]", "platform.retraction.length: is missing; platform.retraction.least: is missing; "),
    ("retraction = 3", "platform.retraction = 3: must be a table"),
]

RETRACTION_FAULTS = [
    ("", "", "length = 3.1", "length = 3.1: must be from least to most, 1 to 3 m"),
    ("", "", "length = 0.9", "length = 0.9: must be from least to most, 1 to 3 m"),
    ("", "", "length = 0", "length = 0: must be greater than 0"),
    ("most = 3", "most = 1", "length = 1", "most = 1: must be above least, 1 m"),
    ("", "", "length = 2\ndirection = [0, 0, 0]", "direction = [0, 0, 0]: must not be zero"),
    ("", "", "length = 2\ndirection = [0, 1]", "direction[2]: is missing"),
    ("", "", "length = 2\ndirection = [0, 1, '1 m']", "direction[2] = '1 m': must be a valid number"),
    ("", "", "length = 2\ndirection = [0, 1, inf]", "direction[2] = inf: must be a finite number"),
    ("['east']", "[]", "length = 2", "lines = []: must have at least 1 entries, has 0"),
    ("['east']", "['east', 'east']", "length = 2", "lines = ['east', 'east']: names 'east' more than once"),
    ("['east']", "['est']", "length = 2", "lines = ['est']: no line is named 'est'; did you mean 'west' or 'east'?"),
]


@pytest.mark.parametrize(("extra", "expected"), FAULTS)
def test_each_fault_of_a_platform_names_place_value_and_what_is_allowed(extra: str, expected: str) -> None:
    assert message(extra).startswith(expected)


@pytest.mark.parametrize(("old", "new", "extra", "expected"), RETRACTION_FAULTS)
def test_each_fault_of_a_retraction(old: str, new: str, extra: str, expected: str) -> None:
    table = "[platform.retraction]\nleast = 1\nmost = 3\nlines = ['east']\n".replace(old, new)
    assert message(table + extra) == f"platform.retraction.{expected}"


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('"rigid"', '"body"', "platform.kind = 'body': must be one of 'point', 'rigid'"),
        ('"rigid"', "3", "platform.kind = 3: must be one of 'point', 'rigid'"),
        ('"rigid"', "['rigid']", "platform.kind = ['rigid']: must be one of 'point', 'rigid'"),
        ('kind = "rigid"', "", "lines: all lines of a point platform must have one platform_point; a platform that"),
        ('kind = "rigid"', "inertia = [1, 1, 1]", "platform.inertia = [1, 1, 1]: unknown key; allowed: boxes, force,"),
        ('kind = "rigid"', "loads = [{ name = 'a', mass = 0 }]", "platform.loads[0].mass = 0: must be greater than 0"),
        ('mass = "10 kg"', "", "platform.mass: is missing"),
        ("-0.1", "0.1", 'lines: all platform points coincide: that is a point platform, kind = "point"'),
        (
            "[platform]",
            "[[lines]]\nname = 'again'\nexit_point = [-1, 0, 3]\nplatform_point = ['-10 cm', 0, 0.5]\n[platform]",
            "lines: lines 'west' and 'again' are one line: same exit_point and platform_point",
        ),
    ],
)  # fmt: skip
def test_what_is_no_robot(old: str, new: str, expected: str) -> None:
    assert message("", FILE.replace(old, new)).startswith(expected)


@pytest.mark.parametrize("key", ["centre_of_mass", "inertia", "inertia_products", "moment"])
def test_a_load_of_a_point_gives_mass_and_force_only(key: str) -> None:
    text = FILE.replace("platform_point", "winch_exit").replace("rigid", "point")
    why = "a point platform has none; its loads may give mass and force"
    extra = f"loads = [{{ name = 'full', mass = 20 }}, {{ name = 'odd', {key} = [1, 1, 1] }}]"
    assert message(extra, text) == f"platform.loads[1].{key} = [1, 1, 1]: {why}"


def test_lines_may_share_a_platform_point_or_an_exit_point() -> None:
    third = "[[lines]]\nname = 'third'\nexit_point = {}\nplatform_point = {}\n[platform]"
    assert loads(FILE.replace("[platform]", third.format("[0, 1, 3]", "[0.1, 0, 0.5]"))).m == 3
    assert loads(FILE.replace("[platform]", third.format("[1, 0, 3]", "[0, 0.1, 0.5]"))).m == 3


def test_a_body_may_hang_on_one_line() -> None:
    text, _, tail = FILE.partition('[[lines]]\nname = "west"')
    assert loads(text + tail[tail.index("[platform]") :]).m == 1


# Inertia


def tensor(moments: tuple[float, ...], angle: float, axis: int) -> dict[str, Any]:
    """The principal moments of a body turned by an angle about one axis, as a platform gives them."""
    first, second = (k for k in range(3) if k != axis)
    c, s = math.cos(angle), math.sin(angle)
    turned, products = list(moments), [0.0, 0.0, 0.0]
    turned[first] = c * c * moments[first] + s * s * moments[second]
    turned[second] = s * s * moments[first] + c * c * moments[second]
    products[2 - axis] = c * s * (moments[first] - moments[second])
    return {"mass": 1, "inertia": tuple(turned), "inertia_products": tuple(products)}


ANGLES = st.floats(-math.pi, math.pi)
SECOND_MOMENTS = st.lists(st.floats(1e-3, 1e3), min_size=3, max_size=3)


@given(SECOND_MOMENTS, ANGLES, st.integers(0, 2), st.floats(1e-12, 1e12))
def test_every_body_is_allowed(spread: list[float], angle: float, axis: int, scale: float) -> None:
    x, y, z = (scale * value for value in spread)
    RigidPlatform(**tensor((y + z, x + z, x + y), angle, axis))


@given(SECOND_MOMENTS, ANGLES, st.integers(0, 2), st.integers(0, 2))
def test_a_flat_body_is_allowed_whatever_the_rounding(spread: list[float], angle: float, axis: int, flat: int) -> None:
    spread[flat] = 0.0
    x, y, z = spread
    RigidPlatform(**tensor((y + z, x + z, x + y), angle, axis))


@given(SECOND_MOMENTS, ANGLES, st.integers(0, 2), st.integers(0, 2))
def test_what_no_body_has_is_rejected(spread: list[float], angle: float, axis: int, which: int) -> None:
    spread[which] = -1e-6 * sum(spread)
    x, y, z = spread
    refused(RigidPlatform, tensor((y + z, x + z, x + y), angle, axis), "no body has these moments|must be")


@given(st.floats(0.1, 10), ANGLES, st.integers(0, 2))
def test_a_rod_without_a_thickness_is_rejected(moment: float, angle: float, axis: int) -> None:
    for moments in set(itertools.permutations((moment, moment, 0.0))):
        refused(RigidPlatform, tensor(moments, angle, axis), "must be positive definite")


@pytest.mark.parametrize("moments", [(-1, 1, 1), (-1, -1, -1), (0, 0, 0)])
def test_moments_of_nothing(moments: tuple[float, ...]) -> None:
    refused(RigidPlatform, {"mass": 1, "inertia": moments}, "inertia: must be positive definite")


def test_products_have_the_sign_of_the_tensors_entries() -> None:
    """Of a rod along (1, 1, 0) Ixy is negative; seen with the other sign, it would be one along (1, -1, 0)."""
    rod = tensor((1e-6, 1.0, 1.0), math.pi / 4, 2)
    assert rod["inertia_products"][0] == pytest.approx(-0.5, rel=1e-5)
    RigidPlatform(**rod)


# Loads


def test_under_a_load_its_values_stand_in_place() -> None:
    light = Load(name="light", mass=5)
    windy = Load(name="windy", centre_of_mass=(0, 0, 1), inertia=(2, 2, 2), force=("1 kN", 0, 0), moment=(0, 0, 7))
    platform = RigidPlatform(**BODY, inertia_products=(0.1, 0, 0), nozzle=(0, 0, -1), loads=(light, windy))
    assert platform.under_load("light") == RigidPlatform(
        mass=5, inertia=(3, 4, 5), inertia_products=(0.1, 0, 0), nozzle=(0, 0, -1)
    )
    loaded = platform.under_load("windy")
    assert (loaded.mass, loaded.centre_of_mass, loaded.inertia) == (10, (0, 0, 1), (2, 2, 2))
    assert (loaded.inertia_products, loaded.force, loaded.moment) == ((0.1, 0, 0), (1000, 0, 0), (0, 0, 7))
    assert (loaded.nozzle, loaded.loads) == ((0, 0, -1), ())
    assert RigidPlatform.model_validate(loaded.model_dump()) == loaded


def test_a_load_may_take_a_value_to_zero() -> None:
    calm = Load(name="calm", force=(0, 0, 0))
    assert PointPlatform(mass=1, force=(5, 0, 0), loads=(calm,)).under_load("calm") == PointPlatform(mass=1)


def test_a_robot_under_load() -> None:
    robot = loads(FILE + "loads = [{ name = 'empty' }, { name = 'full', mass = '30 kg' }]")
    assert robot.under_load("full") == loads(FILE.replace("10 kg", "30 kg"))
    assert robot.under_load("empty") == loads(FILE)
    with pytest.raises(UnknownName, match="unknown load 'half'; allowed: empty, full"):
        robot.under_load("half")
    with pytest.raises(UnknownName, match="unknown load 'full'; there are none"):
        load("paty2021").under_load("full")


# Retraction


def test_a_retracted_robot() -> None:
    robot = load("jung2020")
    short = robot.retracted(1.25)
    assert [line.platform_point[2] for line in short.lines] == pytest.approx([1.05] * 4 + [-0.2] * 4, rel=1e-15)
    for before, after in zip(robot.lines, short.lines, strict=True):
        assert before.model_copy(update={"platform_point": after.platform_point}) == after
        assert before.platform_point[:2] == after.platform_point[:2]
    assert short.retraction == robot.retraction.model_copy(update={"length": 1.25})
    assert short.platform.mass == robot.platform.mass
    assert robot.retracted(2.0) == robot
    assert Robot.model_validate(short.model_dump()) == short


@given(st.floats(1.2, 2.0), st.floats(1.2, 2.0))
def test_retracting_twice_is_retracting_once(first: float, second: float) -> None:
    robot = load("jung2020")
    twice, once = robot.retracted(first).retracted(second), robot.retracted(second)
    assert twice.platform == once.platform
    for ours, theirs in zip(twice.lines, once.lines, strict=True):
        assert ours.platform_point == pytest.approx(theirs.platform_point, abs=1e-15)


def test_the_direction_need_not_have_length_one() -> None:
    retraction = Retraction(**RETRACTION, direction=(0, 3, -4))
    assert retraction.moved((1, 1, 1), 1.5) == pytest.approx((1, 0.7, 1.4), rel=1e-15)
    assert Retraction(**RETRACTION).direction == (0, 0, 1)


@pytest.mark.parametrize("direction", [(5e-324, 0, 0), (1e308, 1e308, -1e308)])
def test_a_direction_of_absurd_length(direction: tuple[float, ...]) -> None:
    moved = Retraction(**RETRACTION, direction=direction).moved((0, 0, 0), 1.5)
    assert math.hypot(*moved) == pytest.approx(0.5, rel=1e-12)


@pytest.mark.parametrize("length", [1.19, 2.1, -1, math.nan, math.inf])
def test_it_goes_no_further_than_it_can(length: float) -> None:
    with pytest.raises(
        InputError, match=r"retraction length .* m: the platform of 'jung2020' retracts from 1\.2 to 2 m"
    ):
        load("jung2020").retracted(length)


@pytest.mark.parametrize("name", ["paty2021", "cogiro"])
def test_what_has_no_retraction_cannot_retract(name: str) -> None:
    with pytest.raises(InputError, match=f"robot '{name}' has no retraction"):
        load(name).retracted(1.0)


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"direction": (0, 0, True)}, "valid number"),
        ({"lines": ()}, "at least 1 item"),
        ({"least": 2.5}, "most: must be above least, 2.5 m"),
        ({"length": "1.1 m"}, "length: must be from least to most, 1.2 to 2 m"),
    ],
)
def test_a_retraction_rejects(changes: dict[str, Any], match: str) -> None:
    refused(Retraction, RETRACTION | changes, match)


POINT = FILE.replace("platform_point", "winch_exit").replace("rigid", "point")


def test_a_plane_takes_degrees_of_freedom() -> None:
    body, point = (loads(text + "plane = { normal = [0, -3, 0], distance = '20 mm' }") for text in (FILE, POINT))
    assert (body.n, body.freedoms, point.n, point.freedoms) == (6, 3, 3, 2)
    assert loads(FILE).freedoms == 6
    plane = point.platform.plane
    assert plane is not None
    assert (plane.normal, plane.across, plane.axis, plane.distance) == ((0.0, -3.0, 0.0), (0.0, -1.0, 0.0), 1, 0.02)
    assert str(plane) == "y = -0.02 m"
    assert plane.height((5.0, -1.0, 7.0)) == pytest.approx(0.98)


@given(st.tuples(*[st.floats(-1e9, 1e9)] * 3).filter(any))
def test_a_normal_has_any_length(normal: tuple[float, float, float]) -> None:
    plane = Plane(normal=normal)
    assert math.hypot(*plane.across) == pytest.approx(1.0, abs=1e-15)
    assert plane.distance == 0.0
    assert (plane.axis is None) == (sum(number != 0.0 for number in plane.across) > 1)


@pytest.mark.parametrize(
    ("plane", "why"),
    [
        ("{ normal = [0, 0, 0] }", "platform.plane.normal = [0, 0, 0]: must not be zero"),
        ("{ distance = 1 }", "platform.plane.normal: is missing"),
        ("{ normal = [0, 1] }", "platform.plane.normal"),
        ("{ normal = ['1 m', 0, 0] }", "platform.plane.normal[0] = '1 m'"),
        ("{ normal = [0, 0, nan] }", "platform.plane.normal[2]"),
        ("{ normal = [0, 1, 0], distance = '3 kg' }", "platform.plane.distance = '3 kg'"),
        ("{ normal = [0, 1, 0], offset = 1 }", "platform.plane.offset = 1: unknown key"),
        ("{ normal = [0, 1, 0], distance = '1.5 m' }", "platform.plane.distance = '1.5 m': the plane y = 1.5 m misses"),
        ("3", "platform.plane = 3: must be a table"),
    ],
)
def test_a_plane_that_is_none_is_rejected(plane: str, why: str) -> None:
    for text in (FILE, POINT):
        assert message(f"plane = {plane}", text).startswith(why)


def test_a_plane_is_written_back_in_its_units() -> None:
    text = FILE + "plane = { normal = [0, 1, 0], distance = '20 mm' }  # board\n"
    robot = loads(text)
    plane = Plane(normal=(0.0, 0.0, 2.0), distance=0.03)
    changed = robot.model_copy(update={"platform": robot.platform.model_copy(update={"plane": plane})})
    written = update(text, changed)
    assert loads(written) == changed
    assert "30 mm" in written
    assert "# board" in written
