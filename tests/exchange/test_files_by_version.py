"""Own files in the styles of the firmwares' versions: what each holds, against values by hand."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import cablewright as cw
from cablewright.exchange.formats import ImportOptions, read_robot
from cablewright.exchange.robot_toml import robot_toml
from cablewright.exchange.rrf_config import rrf_config
from cablewright.exchange.translation_result import ImportedRobot
from cablewright.foundation.errors import InputError
from cablewright.machine.drums import drums_of
from cablewright.robot import loads

ANCHORS = "A0:-1500:-100 B1300:1200:-100 C-1300:800:-100"
RRF_2019 = f"""M669 K6
M669 {ANCHORS} D2200
M669 Q0.7 R60:61:62:63
M669 U2:2:2:4 O2:2:2:3
M669 L20:20:20:20 H255:255:255:255 J25:25:25:25
M666 X0.5
"""
RRF_33 = f"""M669 K6
M669 {ANCHORS} D2200.5 P1500
M666 Q0.05 R65:65:65:65
M666 U2:2:2:4 O1:1:1:1
M666 L20:20:20:20 H255:255:255:255 J25:25:25:25
"""
RRF_34 = f"""; W turns on the compensation of stretch
M669 K6
M669 {ANCHORS} D0:0:2200
M666 Q0.05 R65:65:65:65
M666 U2:2:2:4
M666 W2.5
"""
RRF_36 = f"""M669 K6 N5 {ANCHORS} D1200:-900:-100 I0:0:2400
M666 A1 Q0.03 R64:65:66:67:68 U2:2:2:2:4 O1:1:1:1:1
M666 W3 S25000 I5:5:5:5:20 X80:80:80:80:160 Y100:100:100:100:0 C0.025:0.025:0.025:0.025:0.025
M98 P"home.g"
M501
"""
RRF_37 = f"""M669 K6 N8 {ANCHORS} D1200:-900:-100
M669 I-1200:-900:2000 J1200:-900:2000 L1200:900:2000 O-1200:900:2000
M666 Q0 R64:64:64:64:64:64:64:64 U2:2:2:2:1:1:1:1 O1:1:1:1:1:1:1:1 F1 B0 P1
"""
KLIPPER_2018 = """[printer]
kinematics: winch
[stepper_a]
rotation_distance: 100
anchor_x: 0
anchor_y: -1500
anchor_z: -100
[stepper_b]
rotation_distance: 100
anchor_x: 1300
anchor_y: 1200
anchor_z: -100
[stepper_c]
rotation_distance: 100
anchor_x: -1300
anchor_y: 800
anchor_z: -100
"""
FORK_DEFAULTS = KLIPPER_2018.replace("kinematics: winch", "kinematics: winch\nwinch_mover_weight: 2.5")
MASLOW_OLD = """Maslow_vertical: false
Maslow_tlX: 0
Maslow_tlY: 2000
Maslow_trX: 3000
Maslow_trY: 2000
Maslow_brX: 3000
Maslow_brY: 0
axes:
  a:
    max_rate_mm_per_min: 2400
"""
MASLOW_NEW = """Maslow_vertical: false
kinematics:
  MaslowKinematics:
    tlX: 0
    tlY: 2000
    tlZ: 100
    trX: 3000
    trY: 2000
    trZ: 56
    blX: 0
    blY: 0
    blZ: 34
    brX: 3000
    brY: 0
    brZ: 78
    beltEndExtension: 30
    armLength: 123.4
    workThickness: 18
    fixedZ: true
"""
WALL = """board: Own
kinematics:
  WallPlotter:
    left_axis: 1
    left_anchor_x: -267.5
    left_anchor_y: 250
    right_axis: 0
    right_anchor_x: 267.5
    right_anchor_y: 255
    segment_length: 10
axes:
  x:
    max_rate_mm_per_min: 600
  y:
    max_rate_mm_per_min: 1200
"""
GROUND = """[Maslow Settings]
motorspacingx = 2978.4
bedwidth = 2438.4
bedheight = 1219.2
motoroffsety = 463
[Advanced Settings]
kinematicstype = Triangular
chainlength = 3360
rotationradius = 139.1
sledweight = 98.1
chainelongationfactor = 5e-6
distperrot = 63.5
"""
REPORT = """$0=2438.40 (machine width, mm)
$1=1200.00 (machine height, mm)
$2=3000.00 (distance between motors, mm)
$3=500.00 (motor offset height, mm)
$7=1 (Kinematics Type 1=Quadrilateral, 2=Triangular)
$13=63.50 (distance / rotation, mm)
"""
MARLIN_H = """// Marlin
#define POLARGRAPH
#if ENABLED(POLARGRAPH)
  #define POLARGRAPH_MAX_BELT_LEN 1035.0 // mm
#endif
#define X_BED_SIZE 650
#define Y_BED_SIZE 1000
#define X_MIN_POS (-(X_BED_SIZE/2))
#define Y_MIN_POS -(Y_BED_SIZE/2)
#define X_MAX_POS X_BED_SIZE/2
#define Y_MAX_POS (Y_BED_SIZE / 2)
#define DEFAULT_MAX_FEEDRATE { 40, 50, 100 }
"""
M503 = """echo:  M203 X150.00 Y160.00 Z100.00
echo:  M665 S5.00 L-300.00 R310.00 T400.00 B-450.00 H1100.00
"""
MAKELANGELO = """D5
M101 A0 T242.5 B-242.5
M101 A1 T464 B-464
M101 A2 T170 B90
"""
RRF_35 = """; Kinematics
G21 ; mm
M669 K6 N4 A0.00:-1620.00:-106.00 B1460.50:815.20:-112.60 C-1450.00:830.10:-110.40 D0.00:0.00:2350.00 P1000.0 ; anchors
M666 A0 Q0.128 R66.5:66.5:66.5:66.5 U2:2:2:4 O1:1:1:1 L20:20:20:20 H255:255:255:255 J25:25:25:25
M666 W0.0 S22000.0 I8:8:8:8 X120:120:120:120 T10:10:10:10
"""
RRF_THREE = "m669 k6 n3 a0:-900:1500 b800:500:1500 c-800:500:1450.5\r\nm666 q0.01 r30:30:31 u1:1:1 o1:1:1\r\n"
RRF_FIVE = f"""M669 K6 N5 {ANCHORS} D1200:-900:-100 I10:-20:2400
M666 F1 B0 P2 Q0.02 R64:65:66:67:68 U2:2:2:2:4 O1:1:1:1:2
M666 W1.75 S30000 I0:0:0:0:40 X60:60:60:60:240
"""
RRF_2019_SHORT = f"M669 K6 {ANCHORS} D2000 P800\nM669 R54.5:54.5:54.5:54.5\n"
KLIPPER_FOUR = """[mcu]
serial = /dev/ttyACM0
[printer]
kinematics = winch
max_velocity = 250
max_accel = 900
[stepper_a]
step_pin = PA1 ; a comment
microsteps = 32
gear_ratio = 255:20
rotation_distance = 408.407
anchor_x = 0
anchor_y = -2000.5
anchor_z = -120
[stepper_b]
rotation_distance = 408.407
anchor_x = 2000
anchor_y = 1000
anchor_z = -120
[stepper_c]
rotation_distance = 408.407
anchor_x = -2000
anchor_y = 1000
anchor_z = -120
[stepper_d]
rotation_distance = 204.204
anchor_x = 0
anchor_y = 0
anchor_z = 2900
"""
FORK_FULL = KLIPPER_FOUR.replace(
    "max_accel = 900",
    """max_accel = 900
winch_mechanical_advantage = 2, 2, 2, 4
winch_mover_weight = 1.9
winch_min_force = 6, 6, 6, 8
winch_max_force = 100, 100, 100, 120
winch_spring_constant = 21000
winch_buildup_factor = 0.038
winch_guy_wire_lengths = 50, 0, 0, 150""",
)
MASLOW_WALL = MASLOW_OLD.replace("false", "true").replace("tlX: 0\n", "tlX: 10\nMaslow_tlZ: 100\n")
MASLOW_WIDE = """kinematics:
  MaslowKinematics:
    tlX: -30.5
    tlY: 2060.5
    tlZ: 100.0
    trX: 3500
    trY: 2070
    trZ: 56.0
    brX: 3510.25
    brY: 0.0
    brZ: 78.0
    spoilboardThickness: 5
    workThickness: 12.5
axes:
  a:
    max_rate_mm_per_min: 3000
  d:
    max_rate_mm_per_min: 1500
"""
WALL_SMALL = """kinematics:
  WallPlotter:
    left_axis: 0
    left_anchor_x: -100.000
    left_anchor_y: 100.000
    right_axis: 1
    right_anchor_x: 100.000
    right_anchor_y: 100.000
    segment_length: 5.000
axes:
  x:
    steps_per_mm: 80
    max_rate_mm_per_min: 3000
"""
M665_SHORT = "M665 L-500.5 R500.5 T400 B-600\n"
MAKELANGELO_LARGE = "M101 A0 T500 B-500\nM101 A1 T800 B-300.5\n"
GROUND_SLED = """[Maslow Settings]
motorspacingx = 2900
bedwidth = 2438.4
bedheight = 1220
motoroffsety = 600
[Advanced Settings]
kinematicstype = Quadrilateral
chainlength = 3000
sledweight = 109.0
distperrot = 63.5
"""
REPORT_LONG = "$1=1219.20\n$2=2978.40\n$3=463.00\n$7=2\n$10=3360.00\n$13=63.50\n"


def read(folder: Path, name: str, text: str) -> ImportedRobot:
    (folder / name).write_text(text)
    return read_robot([folder / name])


def radii(robot: cw.Robot) -> list[float | None]:
    return [line.winch.drum_radius for line in robot.lines]


def spans(robot: cw.Robot) -> list[int]:
    return [line.advantage for line in robot.lines]


def exits(robot: cw.Robot) -> list[tuple[float, ...]]:
    return [line.exit_point for line in robot.lines]


def limits(robot: cw.Robot) -> list[tuple[float, float]]:
    return [line.tension_limits for line in robot.lines]


def growth(robot: cw.Robot) -> list[float]:
    """By how much the square of the radius grows per length of one cable, mm: Q."""
    found = [(line.winch.build_up or 0.0) * 2e3 * (line.winch.drum_radius or 0.0) ** 2 / line.cables
             for line in robot.lines]  # fmt: skip
    return [round(each, 9) for each in found]


STYLES: dict[str, tuple[str, str, str, dict[Callable[[cw.Robot], object], object], tuple[str, ...]]] = {
    "rrf 2019": (
        "config.g", RRF_2019, "as of 2019",
        {radii: [0.06, 0.061, 0.062, 0.063], spans: [2, 2, 2, 4], growth: [0.7] * 4,
         lambda r: [line.cables for line in r.lines]: [2, 2, 2, 3]},
        ("M666 L: teeth of the gear; an export has it, as --gear", "M666 X: the end switch"),
    ),
    "rrf 3.3": (
        "config.g", RRF_33, "2020 to 3.4",
        {radii: [0.065] * 4, growth: [0.05] * 4, lambda r: r.lines[3].exit_point: (0.0, 0.0, 2.2005)},
        ("M669 P: the radius", "M666 J: an export has it, as --full-steps"),
    ),
    "rrf 3.4, weight alone": (
        "config.g", RRF_34, "2020 to 3.4",
        {limits: [(0.0, 35.0)] * 3 + [(0.0, 17.5)], lambda r: r.platform.mass: 2.5,
         lambda r: {line.cable.stiffness for line in r.lines}: {20000.0}},
        (),
    ),
    "rrf 3.6": (
        "config.g", RRF_36, "3.5 or newer",
        {radii: [0.064, 0.065, 0.066, 0.067, 0.068], limits: [(2.5, 40.0)] * 4 + [(5.0, 40.0)],
         lambda r: [line.dead_length for line in r.lines]: [0.1] * 4 + [0.0],
         lambda r: r.lines[4].exit_point: (0.0, 0.0, 2.4)},
        ('M98 P"home.g": commands of other files', "M501: config-override.g is not read", "M666 C: torque constants"),
    ),
    "rrf 3.7": (
        "config.g", RRF_37, "3.7 or newer",
        {lambda r: [line.name for line in r.lines]: list("ABCDIJLO"), growth: [0.0] * 8, radii: [0.064] * 8,
         lambda r: r.lines[7].exit_point: (-1.2, 0.9, 2.0)},
        ("M666 F: whether the firmware compensates", "M666 P: of the compensation"),
    ),
    "klipper": (
        "printer.cfg", KLIPPER_2018 + "[include pins.cfg]\n", "since 2018",
        {radii: [pytest.approx(0.1 / math.tau)] * 3, spans: [1, 1, 1]}, ("[include pins.cfg]: other files",),
    ),
    "klipper's fork": (
        "printer.cfg", FORK_DEFAULTS, "the fork for Hangprinters",
        {lambda r: r.platform.mass: 2.5, limits: [(0.0, 120.0)] * 3}, (),
    ),
    "maslow of 2024": (
        "maslow.yaml", MASLOW_OLD, "before 2025",
        {exits: [(0.0, 2.0, 0.0), (3.0, 2.0, 0.0), (0.0, 0.0, 0.0), (3.0, 0.0, 0.0)],
         lambda r: [line.winch.max_speed for line in r.lines]: [pytest.approx(0.04), None, None, None]},
        (),
    ),
    "maslow of 2025": (
        "maslow.yaml", MASLOW_NEW, "since 2025",
        {lambda r: [round(line.platform_point[2] - line.exit_point[2], 12) for line in r.lines]:
             [0.118, 0.074, 0.052, 0.096]},
        ("arms of 153.4 mm that stay level", "fixedZ: whether belts follow"),
    ),
    "fluidnc": (
        "wall.yaml", WALL, "FluidNC's WallPlotter",
        {exits: [(-0.2675, 0.0, 0.25), (0.2675, 0.0, 0.255)],
         lambda r: [line.winch.max_speed for line in r.lines]: [pytest.approx(0.02), pytest.approx(0.01)],
         lambda r: r.scene.frame_min[2]: pytest.approx(0.25 - 0.535)},
        ("segment_length: the firmware cuts",),
    ),
    "maslow classic": (
        "groundcontrol.ini", GROUND, "GroundControl's settings",
        {lambda r: r.lines[0].exit_point[0]: -1.4892,
         lambda r: math.hypot(*r.lines[0].exit_point[1:]): pytest.approx(1.2192 / 2 + 0.463),
         lambda r: r.platform.mass: pytest.approx(10.0), lambda r: r.lines[0].cable.stiffness: pytest.approx(2e5),
         lambda r: r.lines[1].winch.capacity: 3.36, radii: [pytest.approx(0.0635 / math.tau)] * 2,
         lambda r: r.platform.plane.across[2]: pytest.approx(math.sin(math.radians(15)))},
        ("rotationRadius: chains end on a ring", "chains wrap around their sprockets"),
    ),
    "maslow classic's $$": (
        "settings.txt", REPORT, "the firmware's $$",
        {lambda r: r.lines[1].exit_point[0]: 1.5,
         lambda r: math.hypot(*r.lines[0].exit_point[1:]): pytest.approx(1.1)},
        ("kinematicsType: Quadrilateral",),
    ),
    "marlin": (
        "Configuration.h", MARLIN_H, "Configuration.h",
        {exits: [(-0.325, 0.0, 0.5), (0.325, 0.0, 0.5)], lambda r: r.scene.frame_min[2]: -0.5,
         lambda r: [line.winch.max_speed for line in r.lines]: [0.04, 0.05],
         lambda r: r.lines[0].winch.capacity: 1.035},
        (),
    ),
    "marlin's M503": (
        "settings.gcode", M503, "M665",
        {exits: [(-0.3, 0.0, 0.4), (0.31, 0.0, 0.4)], lambda r: r.lines[1].winch.max_speed: 0.16,
         lambda r: r.lines[1].winch.capacity: 1.1},
        ("M665 S: segments",),
    ),
    "makelangelo": (
        "limits.gcode", MAKELANGELO, "Makelangelo's own firmware",
        {exits: [(-0.2425, 0.0, 0.464), (0.2425, 0.0, 0.464)], lambda r: r.scene.frame_min[2]: -0.464},
        ("M101 A2 T170 B90: the pen", "D5: a robot file has no such thing"),
    ),
    "rrf 3.5, of a configuration tool": (
        "config.g", RRF_35, "3.5 or newer",
        {exits: [(0.0, -1.62, -0.106), (1.4605, 0.8152, -0.1126), (-1.45, 0.8301, -0.1104), (0.0, 0.0, 2.35)],
         limits: [(4.0, 60.0)] * 3 + [(2.0, 30.0)], growth: [0.128] * 4,
         lambda r: {line.cable.stiffness for line in r.lines}: {22000.0}},
        ("M669 P: the radius", "M666 A: which places", "M666 T: a robot file has no such key"),
    ),
    "rrf, three anchors in small letters": (
        "config.g", RRF_THREE, "3.5 or newer",
        {exits: [(0.0, -0.9, 1.5), (0.8, 0.5, 1.5), (-0.8, 0.5, 1.4505)], radii: [0.03, 0.03, 0.031],
         spans: [1, 1, 1], growth: [0.01] * 3},
        (),
    ),
    "rrf 3.7, five anchors": (
        "config.g", RRF_FIVE, "3.7 or newer",
        {lambda r: r.lines[4].exit_point: (0.01, -0.02, 2.4), limits: [(0.0, 30.0)] * 4 + [(10.0, 60.0)],
         lambda r: r.platform.mass: 1.75, lambda r: [line.cables for line in r.lines]: [1, 1, 1, 1, 2],
         growth: [0.02] * 5},
        ("M666 B: of the compensation",),
    ),
    "rrf 2019, radii alone": (
        "config.g", RRF_2019_SHORT, "as of 2019",
        {radii: [0.0545] * 4, spans: [1] * 4, lambda r: [line.cables for line in r.lines]: [2, 2, 2, 3],
         growth: [0.007] * 4},
        ("M669 P: the radius",),
    ),
    "klipper, with = and a gear": (
        "printer.cfg", KLIPPER_FOUR, "since 2018",
        {radii: [pytest.approx(0.065, abs=1e-7)] * 3 + [pytest.approx(0.0325, abs=1e-7)],
         lambda r: r.lines[0].exit_point: (0.0, -2.0005, -0.12)},
        ("stepper.gear_ratio: a machine file has it", "mcu.serial", "printer.max_accel: a job has it"),
    ),
    "klipper's fork, complete": (
        "printer.cfg", FORK_FULL, "the fork for Hangprinters",
        {radii: [pytest.approx(0.13, abs=1e-6)] * 4, spans: [2, 2, 2, 4],
         limits: [(3.0, 50.0)] * 3 + [(2.0, 30.0)], lambda r: r.platform.mass: 1.9, growth: [0.038] * 4,
         lambda r: [line.dead_length for line in r.lines]: [0.05, 0.0, 0.0, 0.15]},
        (),
    ),
    "maslow of 2024, on a wall": (
        "maslow.yaml", MASLOW_WALL, "before 2025",
        {lambda r: np.subtract(r.lines[0].exit_point, r.lines[0].platform_point).tolist(): pytest.approx(
            (0.01, 2.0 * math.sin(math.radians(15)) + 0.1 * math.cos(math.radians(15)),
             2.0 * math.cos(math.radians(15)) - 0.1 * math.sin(math.radians(15)))),
         lambda r: r.platform.plane.directions[1]: pytest.approx(
             (0.0, math.sin(math.radians(15)), math.cos(math.radians(15))))},
        (),
    ),
    "maslow of 2025, wide": (
        "maslow.yaml", MASLOW_WIDE, "since 2025",
        {lambda r: r.lines[0].exit_point: pytest.approx((-0.0305, 2.0605, 0.0)),
         lambda r: r.lines[2].exit_point: pytest.approx((0.0, 0.0, 0.1)),
         lambda r: r.lines[2].platform_point: pytest.approx((0.0, 0.0, 0.1175)),
         lambda r: [line.winch.max_speed for line in r.lines]: [pytest.approx(0.05), None, None, pytest.approx(0.025)],
         # the line from 0, 0 to 3500, 2070 meets that from 3510.25, 0 to -30.5, 2060.5 mm
         lambda r: r.platform.plane.gcode_zero: pytest.approx((1.7409303, 1.0296359, 0.0), abs=1e-6)},
        (),
    ),
    "fluidnc, of its page": (
        "wall.yaml", WALL_SMALL, "FluidNC's WallPlotter",
        {exits: [(-0.1, 0.0, 0.1), (0.1, 0.0, 0.1)], lambda r: r.platform.plane.gcode_zero: (0.0, 0.0, 0.0),
         lambda r: r.uncertainty.zeroed_at: (0.0, 0.0, 0.0), lambda r: r.lines[0].winch.max_speed: pytest.approx(0.05),
         lambda r: r.scene.frame_min[2]: pytest.approx(-0.1)},
        ("axes: steps_per_mm and drivers",),
    ),
    "marlin's M665 alone": (
        "settings.gcode", M665_SHORT, "M665",
        {exits: [(-0.5005, 0.0, 0.4), (0.5005, 0.0, 0.4)], lambda r: r.scene.frame_min[2]: -0.6,
         lambda r: r.lines[0].winch.max_speed: None},
        (),
    ),
    "makelangelo, large": (
        "limits.gcode", MAKELANGELO_LARGE, "Makelangelo's own firmware",
        {exits: [(-0.5, 0.0, 0.8), (0.5, 0.0, 0.8)], lambda r: r.scene.frame_min[2]: -0.3005}, (),
    ),
    "maslow classic, a sled on two points": (
        "groundcontrol.ini", GROUND_SLED, "GroundControl's settings",
        {lambda r: r.lines[1].exit_point[0]: 1.45,
         lambda r: math.hypot(*r.lines[0].exit_point[1:]): pytest.approx(0.61 + 0.6),
         lambda r: r.platform.mass: pytest.approx(109.0 / 9.81), lambda r: r.lines[0].winch.capacity: 3.0},
        ("Quadrilateral",),
    ),
    "maslow classic's $$ without words": (
        "settings.txt", REPORT_LONG, "the firmware's $$",
        {lambda r: r.lines[1].exit_point[0]: 1.4892, lambda r: r.lines[1].winch.capacity: 3.36,
         lambda r: math.hypot(*r.lines[0].exit_point[1:]): pytest.approx(0.6096 + 0.463)},
        (),
    ),
    "rrf 3.6, an override": (
        "config.g", RRF_36 + "M669 P1800\nM666 R70:70:70:70:71\n", "3.5 or newer",
        {radii: [0.07, 0.07, 0.07, 0.07, 0.071], growth: [0.03] * 5}, ("M669 P: the radius",),
    ),
    "fluidnc, anchors of two heights": (
        "wall.yaml", WALL_SMALL.replace("right_anchor_y: 100", "right_anchor_y: 120"), "FluidNC's WallPlotter",
        {exits: [(-0.1, 0.0, 0.1), (0.1, 0.0, 0.12)], lambda r: r.scene.frame_min[2]: pytest.approx(-0.1)}, (),
    ),
}  # fmt: skip


@pytest.mark.parametrize("style", STYLES)
def test_a_style_of_file(style: str, tmp_path: Path) -> None:
    name, text, version, values, lost = STYLES[style]
    found = read(tmp_path, name, text)
    assert version in found.format
    for of, value in values.items():
        assert of(found.robot) == value
    for words in lost:
        assert any(words in each for each in found.lost), (words, found.lost)
    assert loads(robot_toml(found, "cablewright import")) == found.robot


def test_defaults_of_a_firmware_are_listed(tmp_path: Path) -> None:
    told = " ".join(read(tmp_path, "config.g", RRF_34).assumed)
    for words in ("up to 70 N over the spans", "axial_stiffness: 20000 N", "cables: 1, 1, 1, 1, what RepRapFirmware"):
        assert words in told
    told = " ".join(read(tmp_path, "printer.cfg", FORK_DEFAULTS).assumed)
    assert "up to 120 N over the spans, what the fork takes" in told
    told = " ".join(read(tmp_path, "maslow.yaml", MASLOW_OLD).assumed)
    assert "Maslow_blX: 0 mm, the file has none" in told
    assert "Maslow_tlZ: 0 mm, the file has none" in told
    assert "origin is [1.5000, 1.0000, 0.0000] m" in told


def test_arms_that_stay_level_are_measured(tmp_path: Path) -> None:
    """In the middle of the frame: sqrt((d - arm)^2 + z^2) and sqrt(d^2 + z^2) - arm, of the highest belt."""
    found = read(tmp_path, "maslow.yaml", MASLOW_NEW)
    d, arm, z = math.hypot(1500, 1000), 153.4, 118.0
    longer = math.hypot(d - arm, z) - (math.hypot(d, z) - arm)
    assert f"up to {longer:.2g} mm longer (top left)" in " ".join(found.lost)


def belts(text: str, x: float, y: float) -> np.ndarray:
    """Lengths, mm, of the belts with the router at x, y of its own zero, as the firmware computes them in float32."""
    f = np.float32
    given = {key: f(value) for key, value in re.findall(r"(\w+): (-?[0-9.]+)", text)}
    a = (given["trY"] - given["blY"]) / (given["trX"] - given["blX"])
    b = (given["brY"] - given["tlY"]) / (given["brX"] - given["tlX"])
    middle = (given["brY"] - b * given["brX"] + a * given["trX"] - given["trY"]) / (a - b)
    at = np.array([f(x) + middle, f(y) + a * (middle - given["trX"]) + given["trY"]], f)
    arm = given.get("beltEndExtension", f(0)) + given.get("armLength", f(0))
    found = []
    for corner in ("tl", "tr", "bl", "br"):
        flat = np.sqrt((given[f"{corner}X"] - at[0]) ** 2 + (given[f"{corner}Y"] - at[1]) ** 2) - arm
        fall = given[f"{corner}Z"] + given.get("workThickness", f(0))
        found.append(np.sqrt(flat * flat + fall * fall) + arm)
    return np.array(found, float)


@pytest.mark.parametrize("arms", [False, True])
def test_belts_in_the_firmware(arms: bool, tmp_path: Path) -> None:
    """In float32 belts are those of the robot to 0.01 mm; with arms that stay level, as reported, longer than here."""
    text = MASLOW_NEW if arms else MASLOW_NEW.replace("armLength: 123.4", "").replace("beltEndExtension: 30", "")
    found = read(tmp_path, "maslow.yaml", text)
    off = []
    for x, y in ((0.0, 0.0), (400.0, 250.0), (-700.0, 300.0), (600.0, -400.0)):
        at = (1.5 + 1e-3 * x, 1.0 + 1e-3 * y, 0.0)
        ours = 1e3 * cw.inverse(found.robot, at, cable="rigid").lengths
        off.append(belts(text, x, y) - ours)
    if arms:
        told = float(re.search(r"up to ([0-9.]+) mm longer", " ".join(found.lost))[1])  # type: ignore[index]
        assert off[0].max() == pytest.approx(told, abs=0.01)
        assert np.min(off) > 0.0
    else:
        assert np.abs(off).max() < 0.01


def test_a_plotter_hangs_as_by_hand(tmp_path: Path) -> None:
    """Two belts at 45 degrees each pull with weight over the root of 2."""
    text = WALL.replace("right_anchor_y: 255", "right_anchor_y: 250")
    robot = read(tmp_path, "wall.yaml", text).robot
    found = cw.inverse(robot, (0.0, 0.0, 0.25 - 0.2675), cable="rigid")
    assert found.tensions == pytest.approx([0.3 * 9.81 / math.sqrt(2.0)] * 2, rel=1e-9)
    assert found.lengths == pytest.approx([0.2675 * math.sqrt(2.0)] * 2, rel=1e-9)


def test_the_speed_of_a_belt_by_name(tmp_path: Path) -> None:
    """A name in the list of speeds is that of its own belt, not left out with the next in its place."""
    text = MARLIN_H.replace("{ 40, 50, 100 }", "{ FAST, 50, 100 } // mm/s\n#define FAST (2 * 20.0)")
    robot = read(tmp_path, "Configuration.h", text).robot
    assert [line.winch.max_speed for line in robot.lines] == pytest.approx([0.04, 0.05])


def test_spellings_that_firmware_reads(tmp_path: Path) -> None:
    """Codes without a space, in small letters, with numbers and Windows' line ends; macros with repeated lines."""
    plain = read(tmp_path, "config.g", RRF_33).robot
    odd = RRF_33.replace("M669 K6", "n10 m669k6").replace("M666 Q", "M666Q").replace("\n", "\r\n")
    odd += 'if {global.a}\n  M98 P"b.g"\nG28\n'
    assert read(tmp_path, "config.g", odd).robot == plain
    macro = "[gcode_macro GO]\ngcode:\n  {% set a = 1 %}\n  x = 1\n  x = 1\n  [stepper_z]\n"
    spaced = KLIPPER_2018.replace("kinematics: winch", "  kinematics: winch")
    assert read(tmp_path, "printer.cfg", spaced + macro).robot == read(tmp_path, "printer.cfg", KLIPPER_2018).robot


BAD = {
    "corexy": ("config.g", "M669 K1 X1:1:0\n", "K1 is CoreXY"),
    "delta by M669": ("config.g", "M669 K3\n", "K3 is a linear delta"),
    "delta by M665": ("config.g", "M665 R105 L215 B85 H250\n", "M665 is of a linear delta"),
    "nine anchors": ("config.g", RRF_36.replace("N5", "N9"), "must be 3 to 5 anchors before RepRapFirmware 3.7"),
    "six radii of eight": ("config.g", RRF_37.replace("R64:64:64", "R64"), "R = .* 6 values; give one for each"),
    "no radii of eight": (
        "config.g", RRF_37.replace("R64:64:64:64:64:64:64:64", ""), "has no R; with over 5 anchors"
    ),
    "condition": (
        "config.g", "if exists(global.x)\n  M669 K6\n" + RRF_33, "M669 stands under 'if': give a config.g without"
    ),
    "expression": ("config.g", RRF_33.replace("Q0.05", "Q{global.q}"), "an expression; write its value"),
    "anchor in m": ("config.g", RRF_33.replace("D2200.5", "D2.2005"), "anchor D is 2.2005 mm from the origin"),
    "cut": ("config.g", RRF_33[: RRF_33.index(":65\n") - 2], "3 values; give one for each|letters, each with"),
    "klipper, delta": ("printer.cfg", KLIPPER_2018.replace("winch", "delta"), "kinematics = 'delta': must be winch"),
    "klipper, elsewhere": (
        "printer.cfg", "[include winches.cfg]\n[printer]\nmax_velocity: 3\n", r"in a file that \[include winches.cfg\]"
    ),
    "klipper, anchor in m": (
        "printer.cfg", KLIPPER_2018.replace("-1300", "-1.3").replace("800", "0.8").replace("-100\n", "-0.1\n"),
        "give all anchors in mm",
    ),
    "klipper, cut": ("printer.cfg", KLIPPER_2018[:-16], "has no anchor_z, mm|anchor_y"),
    "maslow, cut": ("maslow.yaml", MASLOW_NEW[: MASLOW_NEW.index("trY")], "has no trY"),
    "maslow, an anchor in inches": (
        "maslow.yaml", MASLOW_NEW.replace("tlY: 2000", "tlY: 78.74"),
        "sides tl to bl and tr to br are 78.74 and 2000 mm long: give all anchors in mm",
    ),
    "maslow, in inches": (
        "maslow.yaml", MASLOW_NEW.replace("2000", "78.74").replace("3000", "118.11"), "anchors in mm, opposite sides",
    ),
    "wall, cut": ("wall.yaml", WALL[: WALL.index("    right_anchor_y")], "has no right_anchor_y, mm"),
    "wall, exchanged": ("wall.yaml", WALL.replace("right_anchor_x: 2", "right_anchor_x: -3"), "not to the right of"),
    "wall, an axis": ("wall.yaml", WALL.replace("left_axis: 1", "left_axis: 9"), "must be 0 to 5, for x to c"),
    "wall, a unit": ("wall.yaml", WALL.replace("250", "250 mm"), "without a unit"),
    "classic, no motors": ("own.ini", GROUND.replace("motorspacingx = 2978.4", "motorspacingx ="), "motorspacingx"),
    "classic, an elongation": ("own.ini", GROUND.replace("5e-6", "0"), "must be at least 1e-09"),
    "marlin, another kinematics": (
        "Configuration.h", MARLIN_H.replace("POLARGRAPH\n", "POLARGRAPHS\n", 1), "POLARGRAPH is not defined"
    ),
    "marlin, a sum": ("Configuration.h", MARLIN_H.replace("Y_BED_SIZE 1000", "Y_BED_SIZE tall"), "has no #define tall"),
    "marlin, no number": (
        "Configuration.h", MARLIN_H.replace("Y_BED_SIZE 1000", "Y_BED_SIZE [1]"), "must be a number in mm, or a formula"
    ),
    "marlin, 400 digits": ("Configuration.h", MARLIN_H.replace("_SIZE 650", "_SIZE " + "9" * 400), "must be a"),
    "marlin, 100000 signs": ("Configuration.h", MARLIN_H.replace("_SIZE 650", "_SIZE " + "-" * 100_000), "must be a"),
    "marlin, blanks": ("Configuration.h", MARLIN_H.replace("_SIZE 650", f"_SIZE x{' ' * 200_000}y"), "must be a"),
    "blanks of no format": ("config.g", " " * 200_000 + "x\nM669 K6\n", "longer than 4096 bytes"),
    "maslow, one place": (
        "maslow.yaml", re.sub(r"(?m)^( *(?:tl|tr|bl|br)[XY]:).*", r"\1 0", MASLOW_NEW), "not to the right of the left"
    ),
    "marlin, itself": ("Configuration.h", MARLIN_H.replace("X_BED_SIZE 650", "X_BED_SIZE X_BED_SIZE"), "must be a"),
    "m665 without a side": ("settings.gcode", M503.replace(" R310.00", ""), "M665 has no R, mm"),
    "makelangelo, half": ("limits.gcode", MAKELANGELO.replace("M101 A1 T464 B-464", ""), "has no M101 A1"),
}  # fmt: skip


@pytest.mark.parametrize("kind", BAD)
def test_a_bad_file_is_rejected_in_a_line(kind: str, tmp_path: Path) -> None:
    name, text, why = BAD[kind]
    with pytest.raises(InputError, match=why) as caught:
        read(tmp_path, name, text)
    assert "\n" not in str(caught.value)


def test_a_nozzle_below_the_lines(tmp_path: Path) -> None:
    """Anchors are as the point above the nozzle sees them: they come back, and the lines are as long as before."""
    (tmp_path / "config.g").write_text(RRF_36)
    plain = read_robot([tmp_path / "config.g"]).robot
    found = read_robot([tmp_path / "config.g"], options=ImportOptions(nozzle_below=0.12))
    assert found.robot.lines[0].platform_point == (0.0, 0.0, 0.12)
    assert found.robot.lines[0].exit_point == pytest.approx((0.0, -1.5, 0.02))
    at = (0.2, 0.1, 0.3)
    lengths = [cw.inverse(robot, at, cable="rigid").lengths for robot in (plain, found.robot)]
    assert lengths[1] == pytest.approx(lengths[0], abs=1e-12)
    text = rrf_config(found.robot, drums_of(found.robot), None, 25, np.array([(0.3, -0.2, 0.1), (-0.3, 0.4, 0.6)])).text
    again = read(tmp_path, "again.g", text).robot
    for one, other in zip(again.lines, plain.lines, strict=True):
        assert one.exit_point == pytest.approx(other.exit_point, abs=1e-12)
    (tmp_path / "m.yaml").write_text(MASLOW_NEW)
    with pytest.raises(InputError, match="no point where all lines meet"):
        read_robot([tmp_path / "m.yaml"], options=ImportOptions(nozzle_below=0.12))


MARLIN_IF = """
#define POLARGRAPH // two belts
//#define DELTA
#ifdef DELTA
  #define X_MAX_POS 140
#elif ENABLED(POLARGRAPH)
  #define POLARGRAPH_MAX_BELT_LEN 1035.0
  #define X_MAX_POS 300.5
#else
  #define X_MAX_POS 10
#endif
#if DISABLED(DELTA)
  #define X_MIN_POS -X_MAX_POS
#endif
#define Y_MAX_POS 400
#if 0
  #define Y_MAX_POS 1
#endif
#ifndef POLARGRAPH
  #define Y_MAX_POS 2
#endif
#define Y_MIN_POS -500
"""


def test_conditions_of_marlin(tmp_path: Path) -> None:
    robot = read(tmp_path, "Configuration.h", MARLIN_IF).robot
    assert [line.exit_point for line in robot.lines] == [(-0.3005, 0.0, 0.4), (0.3005, 0.0, 0.4)]
    assert robot.lines[0].winch.capacity == 1.035


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("#if DISABLED(DELTA)", "#if MOTHERBOARD > 3", r"line 13: X_MIN_POS stands under #if MOTHERBOARD > 3: give it"),
        ("#endif\n#define Y_MIN_POS -500\n", "", r"#ifndef POLARGRAPH has no #endif: is the file whole"),
        ("#ifdef DELTA\n", "", r"line 5: #elif without an #if"),
        ("#define POLARGRAPH // two belts", "#if 0\n#define POLARGRAPH\n#endif", "POLARGRAPH is not defined"),
    ],
)
def test_conditions_that_are_not_known(old: str, new: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=message):
        read(tmp_path, "Configuration.h", MARLIN_IF.replace(old, new))
