"""Files of other programs, written for these tests."""

from __future__ import annotations

from collections.abc import Sequence

_IDENTITY = "a11='1' a21='0' a31='0' a12='0' a22='1' a32='0' a13='0' a23='0' a33='1'"
DOWN = "a11='0.6' a21='0.8' a31='0' a12='0.8' a22='-0.6' a32='0' a13='0' a23='0' a33='-1'"
TILTED = "a11='0' a21='1' a31='0' a12='-0.6' a22='0' a32='0.8' a13='0.8' a23='0' a33='0.6'"
MIRRORED = "a11='1' a21='0' a31='0' a12='0' a22='1' a32='0' a13='0' a23='0' a33='-1'"

EXITS = [(-2.0, 1.5, 2.5), (2.0, 1.5, 2.5), (2.0, -1.5, 2.5), (-2.0, -1.5, 2.5)]
EXITS += [(x, y, 0.25) for x, y, _ in EXITS]
ENDS = [(-0.06, 0.07, 0.1), (0.06, 0.07, 0.1), (0.06, -0.07, 0.1), (-0.06, -0.07, 0.1)]
ENDS += [(1.5 * x, 1.5 * y, -0.1) for x, y, _ in ENDS]


def chain(
    name: str, exit_point: Sequence[float], end: Sequence[float], axes: str = _IDENTITY, radius: str = "0.05"
) -> str:
    """One line of a WireX file."""
    a, b = (f"x='{p[0]!r}' y='{p[1]!r}' z='{p[2]!r}'" for p in (exit_point, end))
    return (
        f"<chain id='{name}' winchtype='drum'><base {a} {axes} radius='{radius}'/><platform {b} {_IDENTITY}/></chain>"
    )


CHAINS = "".join(
    chain(str(k + 1), a, b, DOWN if k > 3 else (TILTED if k == 1 else _IDENTITY), "0" if k == 2 else "0.05")
    for k, (a, b) in enumerate(zip(EXITS, ENDS, strict=True))
)
CABLE = (
    "<cable name='cord' elasticity='7.5e10' radius='0.0015' breaking_load='9000' damping='1' weight='0.0091' "
    "minimum_load='12' max_length='30' meter_cost='2' material='aramid' {more}/>"
)
WINCH = (
    "<winch name='drum' description='a drum'><cable nr_cables='1' f_max='720' max_velocity='1.5' dl_max='25' "
    "max_jerk='3'/><motor motor_type='own' inertia='0.001'/><drum r_drum='0.045' l_drum='0.3'/></winch>"
)
_INERTIA = {
    "0.31": "<inertiatensor Ixx='14'/>",
    "0.32": ("<inertiatensor Ixx='2' Ixy='0.1' Ixz='0' Iyx='0.1' Iyy='3' Iyz='0' Izx='0' Izy='0' Izz='4'/>"),
}


def wirex(
    version: str = "0.32",
    chains: str = CHAINS,
    cable: str = CABLE,
    winch: str = WINCH,
    pattern: str = "3R3T",
    platform: str = "mass='31.5'",
) -> str:
    """A WireX file of one of the versions."""
    more = "min_length='2'" if version == "0.32" else ""
    return (
        f"<models version='{version}'><robot name='own' id='7' author='someone' description='a test' generator='hand' "
        f"motionpattern='{pattern}'><geometry>{chains}</geometry><platform name='p' {platform} swing_angle='50'>"
        f"{_INERTIA.get(version, '')}<centerofgravity x='0.01' y='0' z='0.2'/></platform>"
        f"<controller ipo_clock='4'/></robot>{cable.format(more=more)}{winch}</models>"
    )


BODIES = """<?xml version="1.0" encoding="utf-8"?>
<links display_range="-3 3 -3 3 0 3">
  <link_rigid num="1" name="own body">
    <joint type="SPATIAL_EULER_XYZ"/>
    <physical>
      <mass>12.5</mass>
      <com_location>0.0 0.02 0.1</com_location>
      <end_location>0.0 0.0 -0.3</end_location>
      <inertia ref="com"><Ixx>1.5</Ixx><Iyy>1.6</Iyy><Izz>1.7</Izz><Ixy>0.1</Ixy><Ixz>0.0</Ixz><Iyz>0.0</Iyz></inertia>
    </physical>
    <parent><num>0</num><location>0.0 0.0 0.0</location></parent>
  </link_rigid>
</links>
"""


def caspr_cable(
    name: str, exit_point: Sequence[float], end: Sequence[float], reference: str = "joint", kind: str = "cable_ideal"
) -> str:
    """One cable of a CASPR model."""
    places = "".join(
        f"<attachment><link>{link}</link><location>{' '.join(map(repr, at))}</location></attachment>"
        for link, at in ((0, exit_point), (1, end))
    )
    limits = "<force_min>5</force_min><force_max>800</force_max>"
    return (
        f'<{kind} name="{name}" attachment_reference="{reference}"><properties>{limits}</properties>'
        f"<attachments>{places}</attachments></{kind}>"
    )


def caspr_cables(cables: str | None = None, default: str = "WORKING") -> str:
    """A CASPR file of cables, with two sets and the document type that its files have."""
    first = cables or "".join(caspr_cable(f"cable {k}", a, b) for k, (a, b) in enumerate(zip(EXITS, ENDS, strict=True)))
    return (
        '<?xml version="1.0"?>\n<!DOCTYPE cables [\n  <!ATTLIST cable_set id ID #REQUIRED>\n]>\n'
        f'<cables default_cable_set="{default}"><cable_set id="WORKING">{first}</cable_set>'
        f'<cable_set id="OTHER">{caspr_cable("alone", EXITS[0], ENDS[0])}</cable_set></cables>'
    )


MASLOW = """board: Maslow
name: Own Board
Maslow_vertical: true
maslow_calibration_grid_size: 7
# the frame, in mm
Maslow_tlX: 25.4
Maslow_tlY: 2080.0
Maslow_tlZ: 100.0
Maslow_trX: 3000.5
Maslow_trY: 2095.25   # measured
Maslow_trZ: 56.0
Maslow_blX: 0
Maslow_blY: 0
Maslow_blZ: 34.0
Maslow_brX: 3010.0
Maslow_brY: 0
Maslow_brZ: 78.0
axes:
  x:
    max_rate_mm_per_min: 2000
"""

KLIPPER = """# four winches
[include pins.cfg]
[printer]
kinematics: winch
max_velocity: 300
[stepper_a]
step_pin: PF0
rotation_distance: 251.327412
anchor_x: 0
anchor_y: -2000.25
anchor_z: -100
[stepper_b]
rotation_distance: 251.3
anchor_x = 2000
anchor_y = 1000
anchor_z = -100
[stepper_c]
rotation_distance: 251.2
anchor_x: -2000
anchor_y: 1000
anchor_z: -100
[stepper_d]
rotation_distance: 251.1
anchor_x: 0
anchor_y: 0.125
anchor_z: 3000   ; over the middle
"""

FORK = """[printer]
kinematics: winch
max_velocity: 300
winch_mover_weight: 1.5
winch_spring_constant: 25000
winch_min_force: 0, 4, 0, 8
winch_max_force: 60, 80, 60, 120
winch_target_force: 10
winch_buildup_factor: 0.04
winch_mechanical_advantage: 2, 2, 3, 4
winch_guy_wire_lengths: 0, 1000, 0, 500
flex_compensation_algorithm: qp
[stepper_a]
rotation_distance: 220
anchor_x: 0
anchor_y: -1500
anchor_z: -100
gear_ratio: 20:1
[stepper_b]
rotation_distance: 220
anchor_x: 1200
anchor_y: 1100
anchor_z: -100
[stepper_c]
rotation_distance: 150
anchor_x: -1300
anchor_y: 800
anchor_z: -100
[stepper_d]
rotation_distance: 110
anchor_x: 0
anchor_y: 0
anchor_z: 2200
"""
"""Klipper for Hangprinters."""

RRF = """; own Hangprinter
G21
M669 K6 N4 S130
M669 A0.0:-1604.5:-114.08 B1312.5:1270.88:-162.2 C-1440.27:741.63:-161.23 D0:0:2345.0 P1500
M666 Q0.0356 R65.239:65.135:65.296:64.673
M666 U2:2:2:4 O1:1:1:1 L20:20:20:20 H255:255:255:255 J25:25:25:25
M666 W2.5 S20000 I0:0:0:10 X70:70:70:120 Y100:100:100:0 ; guy wires
M208 Z2000
"""
