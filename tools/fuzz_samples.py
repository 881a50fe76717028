"""Small files of other programs for the fuzzer to mutate."""

from __future__ import annotations

_LINK = (
    b'<links><link_rigid num="1" name="body"><joint type="SPATIAL_EULER_XYZ"/><physical><mass>2</mass>'
    b'<com_location>0 0 0.1</com_location><inertia ref="joint"><Ixx>1</Ixx><Iyy>1</Iyy><Izz>1</Izz><Ixy>0</Ixy>'
    b"<Ixz>0</Ixz><Iyz>0</Iyz></inertia></physical><parent><num>0</num><location>0 0 0</location></parent></link_rigid>"
    b"</links>"
)
_CABLE = (
    b'<cable_ideal name="%d" attachment_reference="com"><properties><force_min>1</force_min><force_max>90</force_max>'
    b"</properties><attachments><attachment><link>0</link><location>%d %d 3</location></attachment><attachment>"
    b"<link>1</link><location>0.1 0 %d</location></attachment></attachments></cable_ideal>"
)
CASPR = (
    _LINK
    + b"<!-- cut --><!DOCTYPE cables [<!ATTLIST cable_set id ID #REQUIRED>]>"
    + b'<cables default_cable_set="a"><cable_set id="a">'
    + b"".join(_CABLE % (k, k % 2, k // 2, k) for k in range(4))
    + b"</cable_set></cables>"
)
"""Bodies, and cables after the cut."""

CASPR_PLANAR = CASPR.replace(b'"SPATIAL_EULER_XYZ"', b'"PLANAR_XZ" q_min="-1 0 -3" q_max="1 2 3"')

MASLOW = b"".join(
    b"Maslow_%s: %s\n" % pair
    for pair in zip(
        b"vertical tlX tlY tlZ trX trY trZ blX blY blZ brX brY brZ".split(),
        b"true 0 2000 100 3000 2000 90 0 0 30 3000 0 70".split(),
        strict=True,
    )
)
MASLOW_SECTION = (
    b"Maslow_vertical: false\nkinematics:\n  MaslowKinematics:\n    armLength: 123.4\n    workThickness: 12\n"
    + MASLOW.replace(b"Maslow_vertical: true\n", b"").replace(b"Maslow_", b"    ")
)
KLIPPER = b"[printer]\nkinematics: winch\n" + b"".join(
    b"[stepper_%c]\nrotation_distance: 250.5\nanchor_x: %d\nanchor_y: %d\nanchor_z: 1000\n" % (97 + k, 100 * k, 200 * k)
    for k in range(4)
)
KLIPPER_FORK = KLIPPER.replace(
    b"winch\n",
    b"winch\nwinch_mover_weight: 1.2\nwinch_spring_constant: 20000\nwinch_max_force: 70, 70, 70, 70\n"
    b"winch_buildup_factor: 0.05\nwinch_mechanical_advantage: 2, 2, 2, 4\nwinch_guy_wire_lengths: 0, 0, 100, 0\n",
    1,
)
RRF_2019 = (
    b"M669 K6 A0:-1600:-100 B1300:1200:-160 C-1440:741.5:-161 D2345\nM669 Q0.7 R65:65:65:64 U2:2:2:4\nM666 X0 Y0\n"
)
RRF = (
    b"M669 K6 N4 A0:-1600:-100 B1300:1200:-160 C-1440:741.5:-161 D2345\n"
    b"M666 Q0.03 R65:65:65:64 U2:2:2:4 X70:70:70:70 W2\n"
)
LENGTHS = (
    b"time (s),length A (mm),length B (mm),length C (mm),length D (mm)\n0,3000,3000,3000,3000\n1,3001,3001,3001,2990\n"
)

WALL = b"""kinematics:
  WallPlotter:
    left_axis: 0
    left_anchor_x: -267
    left_anchor_y: 250
    right_axis: 1
    right_anchor_x: 268.5
    right_anchor_y: 250
    segment_length: 10
axes:
  x:
    max_rate_mm_per_min: 5000
"""
CLASSIC = b"""$1=1219.2 (machine height, mm)
$2=2978.4 (distance between motors, mm)
$3=463 (motor height, mm)
$10=3360
$13=63.5
"""
MARLIN = b"""#define POLARGRAPH
#if ENABLED(POLARGRAPH)
  #define POLARGRAPH_MAX_BELT_LEN 1035.0
  #define X_MAX_POS (650.0 / 2) // half
#elif ENABLED(DELTA)
  #define X_MAX_POS 140
#else
  #define X_MAX_POS X_BED_SIZE
#endif
#define X_MIN_POS -X_MAX_POS
#define Y_MAX_POS 400
#define Y_MIN_POS -400
#define DEFAULT_MAX_FEEDRATE { 100, 100, 4 }
"""
M101 = b"M101 A0 T325 B-325\nM101 A1 T500 B-500\nM101 A2 T170 B90\n"
M665 = b"M665 S5 L-300 R300 T500 B-500 H1200\nM203 X100 Y100\n"
