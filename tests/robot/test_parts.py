"""The parts of a robot: their values, and the input that each rejects."""

import math
import subprocess
import sys
from typing import Any

import pytest
from pydantic import ValidationError

from cablewright.robot import (
    Cable,
    Eyelet,
    Line,
    Parameter,
    PointPlatform,
    Robot,
    Scene,
    Swivel,
    UniversalJoint,
    Winch,
    library_text,
    loads,
    update,
    with_value,
)
from cablewright.robot.cable import CONSTRUCTIONS, Creep

CABLE = Cable(axial_stiffness="700 kN", linear_density="30 g/m", breaking_load="10 kN")
SWIVEL: dict[str, Any] = {"kind": "swivel", "radius": "50 mm"}
JOINT: dict[str, Any] = {
    "kind": "universal-joint",
    "radius": 0.05,
    "lever": 0.104,
    "lever_weight": "6.85 N",
    "lever_mass_centre": "70.6 mm",
}
PULLEY: dict[str, Any] = {"kind": "pulley", "radius": 0.05, "axis": (2, 0, 0)}
TURNED = PULLEY | {"axis": (0, 1, 0)}
WHEEL: dict[str, Any] = {"centre": (0.1, 0, 1), "radius": "100 mm", "axis": (0, 2, 0)}
WHEELED: dict[str, Any] = {"winch_exit": (1, 0, 0), "guides": [WHEEL]}
END: dict[str, Any] = {"radius": 0.02, "axis": (0, 0, -1)}
LINE: dict[str, Any] = {
    "name": "a",
    "exit_point": (0, 0, 3),
    "winch_exit": (0, 0, 0),
    "cable": CABLE,
    "sheave": SWIVEL,
    "tension_limits": ("10 N", "1 kN"),
}
SCENE = Scene(frame_min=(-1, -1, 0), frame_max=(1, 1, 3))


def robot(**changes: Any) -> Robot:
    parts = {"name": "r", "scene": SCENE, "platform": PointPlatform(mass=10), "lines": [Line(**LINE)]}
    return Robot(**(parts | changes))


def on(**changes: Any) -> dict[str, Any]:
    """A line whose cable passes a wheel."""
    return WHEELED | {"guides": [WHEEL | changes]}


def refused(kind: Any, values: dict[str, Any], match: str) -> None:
    with pytest.raises(ValidationError, match=match):
        kind(**values)


def test_a_cable_is_as_stiff_as_either_way_says() -> None:
    assert CABLE.stiffness == 700e3
    by_section = Cable(young_modulus="100 GPa", section="10 mm^2", linear_density=0, breaking_load=1)
    assert by_section.stiffness == pytest.approx(1e6, rel=1e-15)
    rope = {"young_modulus": "100 GPa", "diameter": "4 mm", "linear_density": 0, "breaking_load": 1}
    assert Cable(**rope, fill_factor=0.5).stiffness == pytest.approx(1e11 * 0.5 * math.pi * 2e-3**2)
    assert Cable(**rope, construction="6x19-IWRC").stiffness == pytest.approx(1e11 * 0.449 * 16e-6)
    assert Cable(axial_stiffness="1.5 MN", linear_density=0, breaking_load=1).stiffness == 1.5e6


def test_cable_constructions_leave_room_between_their_wires() -> None:
    for name, factor in CONSTRUCTIONS.items():
        assert 0.35 < factor < 0.25 * math.pi * 0.65, name  # less than a strand of round wires fills


def test_a_cable_that_is_given_by_its_construction_is_written_back() -> None:
    text = library_text("house-printer").replace('section = "12.566370614359172 mm^2"', 'construction = "6x7-FC"')
    robot = loads(text.partition("  # assumed: full")[0] + "\n" + text.partition("  # assumed: full 4 mm circle\n")[2])
    assert robot.lines[0].cable.stiffness == pytest.approx(102.2e9 * 0.369 * 16e-6)
    stiffer = with_value(robot, Parameter("modulus", robot.lines[0].name), 1.1)
    assert stiffer.lines[0].cable.stiffness == pytest.approx(1.1 * robot.lines[0].cable.stiffness)
    assert loads(update(text, robot)) == robot


@pytest.mark.parametrize(
    ("stiffness", "match"),
    [
        ({}, "young_modulus: is missing"),
        ({"young_modulus": 1e9}, "section: is missing: give young_modulus and section, or diameter with fill_factor"),
        ({"young_modulus": 1e9, "diameter": 1e-3}, "fill_factor: is missing"),
        ({"young_modulus": 1e9, "fill_factor": 0.5}, "diameter: is missing: fill_factor needs it"),
        ({"young_modulus": 1e9, "diameter": 1e-3, "fill_factor": 1.1}, "less than or equal to 1"),
        (
            {"young_modulus": 1e9, "diameter": 1e-3, "fill_factor": 0.5, "section": 1e-6},
            "fill_factor: give either this",
        ),
        ({"young_modulus": 1e9, "diameter": 1e-3, "construction": "6x9-FC"}, "construction: unknown; did you mean"),
        ({"axial_stiffness": 1, "construction": "6x7-FC"}, "axial_stiffness: give either"),
        ({"section": 1e-6}, "young_modulus: is missing"),
        ({"axial_stiffness": 1, "section": 1e-6}, "axial_stiffness: give either"),
        ({"axial_stiffness": 1, "young_modulus": 1e9, "section": 1e-6}, "axial_stiffness: give either"),
        ({"axial_stiffness": 0}, "greater than 0"),
        ({"axial_stiffness": 1, "linear_density": -1}, "greater than or equal to 0"),
        ({"axial_stiffness": 1, "breaking_load": 0}, "greater than 0"),
        ({"axial_stiffness": 1, "diameter": 0}, "greater than 0"),
    ],
)
def test_a_cable_rejects(stiffness: dict[str, Any], match: str) -> None:
    refused(Cable, {"linear_density": 0.03, "breaking_load": 1e4} | stiffness, match)


def test_creep_rejects_what_no_cable_does() -> None:
    for values, match in (
        ({"retardations": [60, 1200], "compliances": [1e-8]}, "compliances: must be 2: one for each"),
        ({"retardations": [1200, 60], "compliances": [1e-8, 1e-8]}, "retardations: must rise"),
        ({"retardations": ["1 min"], "compliances": [-1e-8]}, "greater than or equal to 0"),
        ({"logarithmic": 1.0}, "less than or equal to 0.01"),
        ({"retardations": [1, 2, 3, 4, 5], "compliances": [0, 0, 0, 0, 0]}, "at most 4"),
    ):
        refused(Creep, values, match)


def test_sheaves_are_distinguished_by_kind() -> None:
    sheaves = {kind: Line(**LINE | {"sheave": values}).sheave for kind, values in
               {"eyelet": {"kind": "eyelet"}, "swivel": SWIVEL, "universal-joint": JOINT}.items()}  # fmt: skip
    assert [type(sheave) for sheave in sheaves.values()] == [Eyelet, Swivel, UniversalJoint]
    assert all(sheave.kind == kind for kind, sheave in sheaves.items())


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"lever": 0.04}, "lever: must be at least the sheave's radius"),
        ({"radius": 0}, "greater than 0"),
        ({"lever_weight": -1}, "greater than or equal to 0"),
        ({"lever_mass_centre": "-1 mm"}, "greater than or equal to 0"),
        ({"wrap": "around"}, "'over' or 'under'"),
        ({"swing": "45 deg"}, "swing: needs facing"),
        ({"swing": "0 deg", "facing": 0}, "greater than 0"),
        ({"swing": "181 deg", "facing": 0}, "less than or equal to"),
        ({"lever_range": ("0 deg", "-90 deg")}, "lever_range: must rise"),
        ({"lever_range": (0, 0)}, "lever_range: must rise"),
        ({"lever_range": ("-90 deg", "200 deg")}, "less than or equal to"),
        ({"lever_range": (0,)}, "lever_range.1"),
    ],
)
def test_a_universal_joint_rejects(changes: dict[str, Any], match: str) -> None:
    refused(UniversalJoint, JOINT | changes, match)


def test_a_lever_as_long_as_the_radius_is_allowed() -> None:
    assert UniversalJoint(**JOINT | {"lever": 0.05}).lever == 0.05


def test_a_swivel_rejects_a_swing_about_nothing() -> None:
    refused(Swivel, SWIVEL | {"swing": 1}, "swing: needs facing")
    assert Swivel(**SWIVEL, facing="90 deg", swing="45 deg").facing == math.pi / 2


@pytest.mark.parametrize("key", Winch.model_fields)
def test_a_winch_may_be_unknown_but_not_zero(key: str) -> None:
    assert getattr(Winch(), key) is None
    refused(Winch, {key: 0}, "greater than 0")


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"tension_limits": (100, 100)}, "tension_limits: must rise"),
        ({"tension_limits": (-1, 100)}, "greater than or equal to 0"),
        ({"tension_limits": ("1 N", "10.1 kN")}, "tension_limits: must end at or below the breaking load, 10000 N"),
        ({"tension_limits": (1, 2, 3)}, "at most 2 items"),
        ({"winch_exit": (0, 0, 3)}, "winch_exit: must differ from exit_point"),
        ({"winch_exit": (0, 0, 3), "sheave": {"kind": "eyelet"}}, "winch_exit: must differ from exit_point"),
        ({"winch_exit": (1, 0, 0), "sheave": JOINT}, "is 1 m off the vertical"),
        ({"winch_exit": (0, 0, 4)}, "must be below exit_point"),
        ({"winch_exit": (0, 1e-10, 3)}, "must be below exit_point"),
        ({"sheave": SWIVEL | {"wrap": "under"}}, "must be above exit_point"),
        ({"sheave": SWIVEL | {"axis": (0, 0, 0)}}, "must not be zero"),
        ({"sheave": SWIVEL | {"axis": (1, 0, 0), "facing": 1}}, "facing: is an azimuth about a vertical axis"),
        ({"sheave": SWIVEL | {"axis": (0, 0, -1)}}, "must be before exit_point along the axis"),
        ({"sheave": JOINT | {"axis": (1, 0, 0)}}, "axis: unknown key"),
        ({"sheave": SWIVEL, "winch_exit": (0.05, 0, 2.96)}, "winch_exit: is within reach of the sheave, whose radius"),
        (
            {"sheave": SWIVEL | {"facing": 0, "swing": 1}, "winch_exit": (1, 0, 0)},
            "swing: is of lines in a vertical plane",
        ),
        ({"sheave": PULLEY, "winch_exit": None}, "winch_exit: is needed for a pulley"),
        ({"sheave": PULLEY, "winch_exit": (0.1, 0, 0)}, "winch_exit: is 0.1 m out of the plane of the pulley"),
        ({"sheave": PULLEY, "winch_exit": (0, 0.01, 3)}, "winch_exit: is inside the pulley, whose radius is 0.05 m"),
        ({"sheave": {"kind": "pulley", "radius": 0.05}}, "sheave.pulley.axis\n  Field required"),
        ({"guides": [(0, 0, 1)], "winch_exit": None}, "guides: needs winch_exit"),
        ({"guides": [(0, 0, 0)]}, "guides: .* follows itself: a cable passes a point once"),
        ({"guides": [(0, 0, 3)]}, "guides: .* follows itself"),
        ({"guides": [(0, 0, z / 10) for z in range(1, 27)]}, "at most 24 items"),
        ({"sheave": JOINT, "guides": [(0, 0, 1)]}, "guides: is for lines without a universal joint"),
        (WHEELED | {"sheave": JOINT}, "guides: is for lines without a universal joint"),
        (on(axis=(0, 0, 0)), "axis\n  must not be zero"),
        (on(radius=0), "greater than 0"),
        (on(radius="3 kg"), "must be a finite length"),
        (on(colour=0), "colour: unknown key"),
        ({"guides": [(1, 0, 1), {"centre": (0, 0, 1), "axis": (1, 0, 0)}]}, "radius\n  Field required"),
        ({"guides": [(1, 0)]}, "Field required"),
        ({"guides": [WHEEL, WHEEL]}, "guides: a wheel follows itself: a cable passes a point once"),
        ({"guides": [WHEEL] * 25}, "at most 24 items"),
        (WHEELED | {"winch_exit": None}, "guides: needs winch_exit"),
        (on(axis=(0, -1, 0)), "guides: guide 1: the cable passes this wheel by, and would have to unwind by"),
        (on(radius=2), "guides: winch_exit is within the rim of guide 1, seen along its axis"),
        (on(centre=(0.2, 0, 1)), "guides: guide 1: the cable leaves this wheel 0.100124 m off the axis of its swivel"),
        (
            WHEELED | {"sheave": SWIVEL | {"axis": (0, 0.1, 1)}},
            "guide 1: the cable leaves this wheel .* m off the axis",
        ),
        (
            {"guides": [(1, 0, 3), (0, 0, 5)], "winch_exit": (-1, 0, 3), "sheave": TURNED},
            "goes through the wheel of the",
        ),
        (WHEELED | {"sheave": SWIVEL | {"wrap": "under"}}, "guides: must be above exit_point"),
        (WHEELED | {"sheave": TURNED | {"axis": (0, 1, 0.001)}}, "guides: is 0.002.* m out of the plane of the pulley"),
        (
            on(centre=(0.06, 0, 2.95), axis=(0, -1, 0)) | {"sheave": TURNED},
            "no straight cable leaves the rim of guide 1",
        ),
        ({"sheave": JOINT, "platform_sheave": END}, "platform_sheave: is for lines without a universal joint"),
        ({"platform_sheave": END | {"radius": 0}}, "greater than 0"),
        ({"platform_sheave": END | {"axis": (0, 0)}}, "axis"),
        (
            {"platform_sheave": {"radius": 0.1, "axis": (0, 0, 1), "leaves": (1, 0, 0.2)}},
            "leaves: must be across the axis, in the plane of the wheel; its angle to the axis is 78.69",
        ),
        ({"platform_sheave": {"radius": 0.1, "axis": (0, 0, 1), "leaves": (0, 0, 0)}}, "leaves"),
        ({"platform_sheave": END, "advantage": 2, "sheave": {"kind": "eyelet"}}, "advantage: must be 1 over a sheave"),
        ({"dead_length": 1}, "dead_length: is for a dead span that is not modelled"),
        ({"dead_length": -1, "winch_exit": None}, "greater than or equal to 0"),
        ({"exit_point": (0, 0)}, "exit_point.2"),
        ({"exit_point": (0, 0, math.nan)}, "must be a finite length"),
        ({"name": ""}, "at least 1 character"),
        ({"name": 3}, "valid string"),
        ({"dead_elastic": "yes"}, "valid boolean"),
        ({"arc_elastic": 1}, "valid boolean"),
        ({"sheave": {"kind": "swivle"}}, "'swivel'"),
        ({"sheave": {"radius": 1}}, "kind"),
        ({"exitpoint": (0, 0, 0)}, "exitpoint: unknown key; did you mean 'exit_point'"),
    ],
)
def test_a_line_rejects(changes: dict[str, Any], match: str) -> None:
    refused(Line, LINE | changes, match)


@pytest.mark.parametrize(
    "changes",
    [
        {"winch_exit": None, "dead_length": "2 m"},
        {"winch_exit": (1, 2, 5), "sheave": {"kind": "eyelet"}},
        {"winch_exit": (0, 1e-10, 0)},
        {"winch_exit": (0, 0, 4), "sheave": SWIVEL | {"wrap": "under"}},
        {"tension_limits": (0, "10 kN")},
        {"winch_exit": (0, 2e-9, 0)},
        {"winch_exit": (1, 0, 0), "sheave": SWIVEL | {"axis": (-1, 0, 3)}},
        {"sheave": PULLEY, "winch_exit": (0, 1e-10, 0), "platform_sheave": END},
        {"guides": [(1, 0, 0), (0, 0, 2)]},
        WHEELED,
        WHEELED | {"guides": [WHEEL, (0, 0.3, 2)]},
        WHEELED | {"sheave": TURNED},
        on(centre=(0.2, 1, 1)) | {"sheave": {"kind": "eyelet"}},
    ],
)
def test_a_line_allows(changes: dict[str, Any]) -> None:
    Line(**LINE | changes)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_scene_is_a_box_with_a_volume(axis: int) -> None:
    flat = [1.0, 1.0, 1.0]
    flat[axis] = 0.0
    refused(Scene, {"frame_min": (0, 0, 0), "frame_max": flat}, f"frame_max: must be above frame_min in {'xyz'[axis]}")
    refused(Scene, {"frame_min": (0, 0, 0), "frame_max": (1, 1, 1), "gravity": -1}, "greater than or equal to 0")


def test_a_robot_counts_its_lines_and_degrees_of_freedom() -> None:
    lines = [Line(**LINE | {"name": str(k)}) for k in range(64)]
    assert (robot(lines=lines).m, robot(lines=lines).n) == (64, 3)
    with pytest.raises(ValidationError, match="at most 64 items"):
        robot(lines=[*lines, Line(**LINE)])


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"lines": []}, "lines: must have at least 1 entry"),
        ({"lines": [Line(**LINE)] * 2}, "2 lines are named 'a'"),
        ({"schema": 2}, "less than or equal to 1"),
        ({"schema": 0}, "greater than or equal to 1"),
        ({"schema": True}, "valid integer"),
        ({"name": ""}, "at least 1 character"),
        ({"platform": {"mass": 0}}, "greater than 0"),
        ({"platform": {"kind": "body", "mass": 1}}, "'point'"),
    ],
)
def test_a_robot_rejects(changes: dict[str, Any], match: str) -> None:
    with pytest.raises(ValidationError, match=match):
        robot(**changes)


def test_lines_of_a_point_platform_meet_in_one_point() -> None:
    apart = [Line(**LINE), Line(**LINE | {"name": "b", "platform_point": (0, 0, 0.1)})]
    with pytest.raises(ValidationError, match="must have one platform_point"):
        robot(lines=apart)


def test_descriptions_are_frozen_hashable_and_compared_by_value() -> None:
    one, other = robot(), robot(lines=[LINE])
    assert one == other
    assert hash(one) == hash(other)
    assert one != robot(platform=PointPlatform(mass=11))
    with pytest.raises(ValidationError, match="frozen"):
        one.platform.mass = 3.0


def test_a_dump_is_read_back() -> None:
    assert Robot.model_validate(robot().model_dump()) == robot()
    assert Robot.model_validate_json(robot().model_dump_json()) == robot()


def test_importing_descriptions_loads_no_numerics() -> None:
    code = (
        "import sys, cablewright.robot; print(*{'numpy', 'numba', 'scipy', 'matplotlib', 'pyarrow'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""
