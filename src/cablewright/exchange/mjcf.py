"""Export of MuJoCo models (MJCF) of a robot at a pose. Cables are spatial tendons without stretch and weight.

Each cable runs from its winch over a sheave that swivels to the platform, and cannot get longer than it is at the pose:
`forward` in another physics engine. A motor pulls at each for users who control tensions instead. A counterweight is a
mass at the other end of its cable, which slides up and down.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final
from xml.sax.saxutils import quoteattr

import numpy as np

from cablewright.exchange.losses import keys_given, lost_keys
from cablewright.exchange.mjcf_lines import Mounting, mounting, platform_end, xml_name
from cablewright.exchange.translation_result import ExportedFile, Notes, xml_numbers
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import AnswerError, InputError, printable
from cablewright.models.fidelity import CableLaw
from cablewright.models.plane import directions
from cablewright.models.rotation import placed, rotations
from cablewright.models.statics import Equilibrium
from cablewright.models.support_table import Capability, losses, require
from cablewright.robot import Box, Line, Robot

TIMESTEP: Final = 1e-3  # s
EQUAL: Final = 2e-6  # m, within which a tendon counts as long as its line: it has two starts of `FEED`
_FIRM = 'solreflimit="0.002 1" solimplimit="0.9999 0.99999 0.001 0.5 2"'  # gives less than 1e-7 m under a load
_CARRIED: Final = (
    "name description platform.mass platform.centre_of_mass platform.inertia platform.inertia_products platform.plane "
    "platform.boxes platform.nozzle scene.gravity scene.beams lines.name lines.exit_point lines.winch_exit "
    "lines.guides lines.dead_length lines.advantage lines.platform_point lines.platform_sheave lines.sheave.kind "
    "lines.sheave.radius lines.sheave.wrap lines.sheave.axis lines.sheave.lever lines.sheave.lever_weight "
    "lines.sheave.lever_mass_centre lines.tension_limits lines.counterweight"
)


def mjcf(at: Equilibrium) -> ExportedFile:
    """Return the MuJoCo model of the robot of a single equilibrium with rigid cables, at its pose.

    Raises `InputError` for an equilibrium of other cables, `AnswerError` for a pose that has no lengths.
    """
    robot, notes = at.model.robot, Notes()
    if at.model.fidelity.cable is not CableLaw.RIGID or at.model.fidelity.sheave is not None:
        raise InputError("mjcf: tendons do not stretch: solve with cable = rigid, and the sheaves as built")
    require(robot, Capability.MJCF)
    if not np.isfinite(at.lengths).all():
        raise AnswerError(f"no lengths at this pose: {at.sentence()}", at.status)
    notes.add_all(losses(robot, Capability.MJCF))
    notes.add_all(lost_keys(keys_given(robot), f"{_CARRIED} lines.cables"))
    if not robot.platform.has_inertia:
        notes.add("platform.inertia: not known; that of a ball of the platform's mass and 0.3 m radius is written")
    points = placed(at.pose, [line.platform_point for line in robot.lines])
    levers = at.line_states.lever_angle
    mounts = [mounting(line, points[i], float(levers[i]), robot.scene.gravity) for i, line in enumerate(robot.lines)]
    ends = [platform_end(line, at.pose) for line in robot.lines]
    _note_lengths(robot, mounts, ends, notes)
    return ExportedFile(_document(robot, at, mounts, ends, notes), notes.all)


def _note_lengths(robot: Robot, mounts: Sequence[Mounting], ends: Sequence[Mounting], notes: Notes) -> None:
    """Note where a tendon is not as long as its line."""
    longer: dict[str, list[str]] = {}
    for line, begin, end in zip(robot.lines, mounts, ends, strict=True):
        if begin.hung:
            notes.add(f"tendon of {line.name!r} is {begin.hung:g} m longer than the line: down to its counterweight")
        difference = begin.added + end.added - line.dead_length
        if abs(difference) > EQUAL:
            words = f"{1e3 * abs(difference):.4g} mm {'longer' if difference > 0.0 else 'shorter'}"
            longer.setdefault(words, []).append(repr(line.name))
    for words, names in longer.items():
        notes.add(
            f"tendons of {', '.join(names)} are {words} than the lines: dead_length and arcs on guides are no part"
        )


def _document(robot: Robot, at: Equilibrium, mounts: Sequence[Mounting], ends: Sequence[Mounting], notes: Notes) -> str:
    bodies = "".join(m.body for m in mounts)
    motors = "".join(_motor(line) for line, mount in zip(robot.lines, mounts, strict=True) if not mount.hung)
    tendons = zip(robot.lines, at.lengths, mounts, ends, strict=True)
    comments = "".join(f"  <!-- lost: {printable(each).replace('--', '- -')} -->\n" for each in notes.all)
    return (
        f"<mujoco model={quoteattr(printable(robot.name))}>\n{comments}"
        '  <compiler angle="radian" autolimits="true"/>\n'
        f'  <option timestep="{TIMESTEP!r}" gravity="0 0 {-robot.scene.gravity!r}" integrator="implicitfast"/>\n'
        f"  <worldbody>\n{_platform(robot, at.pose, ends)}{bodies}{_beams(robot)}  </worldbody>\n"
        f"  <tendon>\n{''.join(_tendon(line, float(length), m, e) for line, length, m, e in tendons)}  </tendon>\n"
        f"  <equality>\n{''.join(part.equality for part in (*ends, *mounts))}  </equality>\n"
        f"  <actuator>\n{motors}  </actuator>\n</mujoco>\n"
    )


def _platform(robot: Robot, pose: Array, ends: Sequence[Mounting]) -> str:
    platform = robot.platform
    tensor = [0.4 * 0.09 * platform.mass] * 3 + [0.0] * 3
    if platform.inertia is not None:
        tensor = [*platform.inertia, *platform.inertia_products]
    at = f'pos="{xml_numbers(pose[:3])}" quat="{xml_numbers(_quaternion(pose))}"'
    inertial = (
        f'mass="{platform.mass!r}" pos="{xml_numbers(platform.centre_of_mass)}" fullinertia="{xml_numbers(tensor)}"'
    )
    return (
        f'    <body name="platform" {at}>\n{_joints(robot, pose)}      <inertial {inertial}/>\n'
        f'      <site name="nozzle" pos="{xml_numbers(platform.nozzle)}"/>\n'
        f"{''.join(end.body for end in ends)}{''.join(map(_box, platform.boxes))}    </body>\n"
    )


def _joints(robot: Robot, pose: Array) -> str:
    """Return the platform's degrees of freedom, whose coordinates are those of the pose; a plane takes some."""
    plane = robot.platform.plane
    if plane is None and robot.n == 6:
        return "      <freejoint/>\n"
    joints = ""
    for way in directions(plane, robot.n).T:
        at = 0 if way[:3].any() else 3
        axis = way[at : at + 3]
        joints += _joint("hinge" if at else "slide", axis, float(axis @ pose[at : at + 3]))
    return joints


def _joint(kind: str, axis: Array, value: float) -> str:
    return f'      <joint type="{kind}" axis="{xml_numbers(axis)}" ref="{value!r}"/>\n'


def _quaternion(pose: Array) -> list[float]:
    """Return the rotation of a pose (n,) as a quaternion, the scalar first."""
    vector = rotations(pose)
    angle = float(np.linalg.norm(vector))
    axis = vector / angle if angle else vector
    return [math.cos(0.5 * angle), *map(float, math.sin(0.5 * angle) * axis)]


def _tendon(line: Line, length: float, begin: Mounting, end: Mounting) -> str:
    """Return the tendon with its max length: that of the line, without a constant that no span has."""
    back = f"<site site={xml_name('exit', line)}/>"  # to and fro: an advantage goes with eyelets alone
    spans = [begin.path, end.path, *(back if k % 2 else end.path for k in range(1, line.advantage))]
    longest = length - line.dead_length + begin.added + end.added + begin.hung
    return (
        f'    <spatial name={quoteattr(printable(line.name))} range="0 {longest!r}" {_FIRM}>\n'
        f"      {''.join(spans)}\n    </spatial>\n"
    )


def _motor(line: Line) -> str:
    high = line.tension_limits[1] * line.cables
    name = quoteattr(printable(line.name))
    return f'    <motor name={name} tendon={name} gear="-1" ctrlrange="0 {high!r}"/>\n'


def _box(box: Box) -> str:
    low, high = np.array(box.lowest), np.array(box.highest)
    sizes = f'pos="{xml_numbers(0.5 * (low + high))}" size="{xml_numbers(0.5 * (high - low))}"'
    return f'      <geom type="box" {sizes} contype="0" conaffinity="0" mass="0"/>\n'


def _beams(robot: Robot) -> str:
    return "".join(
        f'    <geom type="capsule" fromto="{xml_numbers((*beam.start, *beam.end))}" size="{beam.radius!r}" '
        'contype="0" conaffinity="0" mass="0"/>\n'
        for beam in robot.scene.beams
    )
