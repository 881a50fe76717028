"""Generation of a machine file for any robot: numbers from its own file, else assumed ones."""

from __future__ import annotations

import math
from itertools import product
from typing import Final

from cablewright.foundation.toml_input import parse_table
from cablewright.foundation.units import FORCE, LENGTH, TORQUE, three_digits
from cablewright.machine.simulated.settings import TwinSettings, twin_of_table
from cablewright.models.support_table import Capability, require
from cablewright.models.winch_lines import WinchLines
from cablewright.robot import PointPlatform, RigidPlatform, Robot

SPEED: Final = 1.0  # m/s of a cable whose winch has no limit
RESERVE: Final = 1.25  # cable on the winch, over the longest line in the frame
LAYER: Final = 1.1  # turns of the coil's one layer, over those that the cable takes
PITCH: Final = 1.05  # of two turns, over the cable's diameter
SIZE: Final = 0.02  # radius of gyration of the platform, over the frame's width


def machine_file(robot: Robot) -> str:
    """Return the text of a machine file for *robot*, each number with its source in a comment.

    Sensors are encoders and a light barrier: with them `print` uses dead reckoning. A body has load cells and an
    inertial unit besides. Raises `InputError` for a robot that cannot be simulated: see `models.support_table`.
    """
    require(robot, Capability.MACHINE_FILE)
    radius, speed, torque = _winch(robot)
    length = RESERVE * _longest(robot)
    pitch = PITCH * max(line.cable.diameter or 0.0 for line in robot.lines)
    width = LAYER * pitch * length / (2.0 * math.pi * min(line.winch.drum_radius or radius for line in robot.lines))
    scene = robot.scene
    size = max(high - low for low, high in zip(scene.frame_min[:2], scene.frame_max[:2], strict=True))
    is_point = isinstance(robot.platform, PointPlatform)
    carried, motion, sensors = _point(robot, SIZE * size) if is_point else _body(robot, SIZE * size, torque / radius)
    return _TEMPLATE.format(
        name=_quoted(robot.name),
        carried=carried,
        motion=motion,
        sensors=sensors,
        speed=three_digits(speed / radius),
        torque=TORQUE.write(three_digits(torque), "N m"),
        held=LENGTH.write(three_digits(length), "m"),
        capacity=LENGTH.write(three_digits(1.1 * length), "m"),
        width=LENGTH.write(three_digits(1.1 * width), "mm"),
        pitch=LENGTH.write(three_digits(pitch), "mm"),
        ceiling=LENGTH.write(three_digits(scene.frame_max[2] + size), "m"),
        pull=FORCE.write(three_digits(torque / radius), "N"),
    )


def built_machine(robot: Robot) -> tuple[TwinSettings, str]:
    """Return the settings and the text of a machine file for *robot*, with assumed numbers: see `machine_file`.

    Raises `InputError` as `machine_file` does.
    """
    text = machine_file(robot)
    origin = f"the machine built for {robot.name!r}"
    return twin_of_table(parse_table(text, origin), origin), text


def _point(robot: Robot, gyration: float) -> tuple[str, str, str]:
    """What hangs from a point platform, with that radius of *gyration*, m; how it moves; no sensors on it."""
    mass, gravity = robot.platform.mass, robot.scene.gravity
    inertia = mass * gyration**2
    is_tool = robot.platform.plane is not None or any(robot.lines[0].platform_point)
    valve = _TOOL if is_tool else _VALVE
    drum = _DRUM.format(mass=f"{mass:g}", gyration=LENGTH.write(three_digits(gyration), "mm"), valve=valve)
    motion = _DRUM_MOTION.format(
        damping=three_digits(0.6 * inertia * math.sqrt(gravity / gyration)),
        yaw=three_digits(inertia),
        drag=three_digits(0.1 * mass),
    )
    return drum, motion, ""


def _body(robot: Robot, gyration: float, pull: float) -> tuple[str, str, str]:
    """A rigid platform with its drive, if it retracts; how it moves; sensors of it, and of lines that *pull* (N)."""
    platform = robot.platform
    assert isinstance(platform, RigidPlatform)
    assumed = LENGTH.write(three_digits(gyration), "mm")
    known = "" if platform.inertia is not None else _GYRATION.format(gyration=assumed)
    body = _BODY.format(mass=f"{platform.mass:g}", gyration=known, drive="" if robot.retraction is None else _DRIVE)
    inertia = platform.mass * gyration**2 if platform.inertia is None else max(platform.inertia)
    motion = _BODY_MOTION.format(drag=three_digits(0.1 * platform.mass), turn=three_digits(0.5 * inertia))
    return body, motion, _BODY_SENSORS.format(deviation=three_digits(2e-3 * pull), most=three_digits(2.0 * pull))


def _quoted(name: str) -> str:
    """A name as a TOML text, in which a terminal finds nothing to obey."""
    plain = (each if each.isprintable() and each not in '"\\' else f"\\U{ord(each):08x}" for each in name)
    return f'"{"".join(plain)}"'


def _winch(robot: Robot) -> tuple[float, float, float]:
    """Radius of the largest drum, m, speed of its cable, m/s, and torque at it, N m, of all cables on it."""
    radius = max(line.winch.drum_radius or 0.0 for line in robot.lines)  # which the table of support requires
    speeds = [line.winch.max_speed for line in robot.lines if line.winch.max_speed is not None]
    torques = [line.winch.max_torque for line in robot.lines if line.winch.max_torque is not None]
    host = WinchLines.of(robot).host
    pulls = [line.tension_limits[1] * line.cables for line in robot.lines]
    strongest = max(sum(pull for own, pull in zip(host, pulls, strict=True) if own == i) for i in robot.hosts)
    return radius, min(speeds, default=SPEED), min(torques, default=1.2 * strongest * radius)


def _longest(robot: Robot) -> float:
    """The longest cable within the frame, m, with its dead span."""
    scene = robot.scene
    corners = list(product(*zip(scene.frame_min, scene.frame_max, strict=True)))
    lengths = []
    for line in robot.lines:
        dead = line.dead_length if line.winch_exit is None else line.dead_span().length
        wheels = 2.0 * math.pi * sum(line.radii)
        lengths.append(dead + wheels + line.advantage * max(math.dist(line.exit_point, corner) for corner in corners))
    return max(lengths)


_TEMPLATE: Final = """\
# A machine for the robot {name}. Numbers marked "robot" are from its file; all others are assumed: replace them by the
# numbers of your machine.

schema = 1
name = {name}
robot = {name}                  # the only robot that this is a machine of
period = "10 ms"                # of the control

{carried}
[extrusion]
density = "2000 kg/m^3"         # of the laid material; the job sets width and height of the bead

[winch]
max_speed = {speed}             # rad/s of the drum: the robot's speed of the cable, or 1 m/s
max_torque = "{torque}"         # at the drum: the robot's, or for {pull} of pull
lag = "20 ms"
ratio = 20.0                    # of the gear
counts = 4096                   # of the encoder, a turn of the motor
held = "{held}"                 # cable of each line: a quarter more than the farthest corner of the frame takes
capacity = "{capacity}"
width = "{width}"               # of the drum: one layer
pitch = "{pitch}"
radius_deviation = "20 um"      # expected of the radius from its layer's
radius_turns = 10.0             # over which it changes

[room]                          # without lidars no wall is needed
ceiling = "{ceiling}"
walls = []

[encoders]
rate = 100.0
{sensors}
[climate_sensor]
rate = 0.1
temperature_deviation = 0.1
humidity_deviation = 0.01

[barrier]
rate = 20.0

# Parameters of the simulation alone, hidden from estimation and control: all assumed. A real machine needs none.

[simulation]
substep = "2 ms"
quasi_static_period = "200 ms"

[simulation.tolerances]         # deviations of the machine as built from the robot file
anchor = "1 mm"                 # each coordinate of an exit point, standard deviation
sheave_radius = "0.1 mm"
modulus = 0.05                  # uniform, +- this share

{motion}
[simulation.winch]              # how irregularly the cable lies
radius_walk = "20 um"
walk_turns = 10.0
sideways_walk = "0.2 mm"

[simulation.line]
relaxation = "1 ms"
vibration = "0.1 mm"
vibration_damping = 0.01

[simulation.climate]
temperature = 22.0
swing = 2.0
humidity = 0.5
humidity_swing = 0.1

[simulation.wire]
latency = "1 ms"
"""

_DRUM: Final = """\
[drum]                          # the platform, in which the lines meet
empty_mass = "{mass} kg"        # robot
flow = 0.1                      # kg/s, valve open; a job with strands sets its own
empty_centre = "{gyration}"     # of mass, below the lines' point
empty_gyration = ["{gyration}", "{gyration}", "{gyration}"]
{valve}"""

_VALVE: Final = """\
valve = "20 mm"                 # nozzle, below the lines' point
"""

_TOOL: Final = """\
valve = "0 mm"                  # the tool is the platform's origin
"""

_DRUM_MOTION: Final = """\
[simulation.drum]
swing_damping = {damping}       # N m s/rad
yaw_stiffness = {yaw}           # N m/rad
yaw_damping = {yaw}             # N m s/rad
yaw_wander = "1 deg"
yaw_wander_length = "5 m"
drag = {drag}                   # N s/m
"""

_BODY: Final = """\
[body]                          # the platform; its centre of mass, inertia and nozzle are the robot's
empty_mass = "{mass} kg"        # robot
flow = 0.1                      # kg/s, valve open; a job with strands sets its own
{gyration}{drive}
[accuracy]                      # standard deviations of the robot file's numbers
home_length = "0.5 mm"          # of each line where the machine is homed
"""

_GYRATION: Final = """\
gyration = ["{gyration}", "{gyration}", "{gyration}"]  # as the robot gives no inertia
"""

_DRIVE: Final = """\

[retraction]                    # the masses stay where the robot file has them
max_speed = 0.02                # m/s
max_force = "1 kN"
lag = "50 ms"
rate = 100.0
deviation = "0.1 mm"
"""

_BODY_SENSORS: Final = """\

[load_cells]                    # at the sheaves
rate = 100.0
deviation = {deviation}         # N
bias = {deviation}              # N
gain_deviation = 0.005
most = {most}

[inertial]
rate = 100.0
place = ["0 m", "0 m", "0 m"]
acceleration_deviation = 0.03   # m/s^2
acceleration_bias = 0.03
rate_deviation = 0.002          # rad/s
rate_bias = 0.002
"""

_BODY_MOTION: Final = """\
[simulation.body]
drag = {drag}                   # N s/m
turn_damping = {turn}           # N m s
"""
