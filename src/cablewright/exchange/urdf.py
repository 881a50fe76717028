"""Export of a URDF of frame and platform. It has no cables; they are listed as lost.

The platform floats, slides in a plane, or where it is a point keeps its rotation as URDF has no joint of three slides.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final
from xml.sax.saxutils import quoteattr

import numpy as np

from cablewright.exchange.losses import keys_given, lost_keys
from cablewright.exchange.translation_result import ExportedFile, Notes, xml_numbers
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import printable
from cablewright.models.rotation import placed
from cablewright.models.support_table import Capability, losses
from cablewright.robot import Robot

BALL: Final = 0.3
"""Radius, m, of the ball that represents a platform of unknown inertia."""

_CARRIED: Final = (
    "name platform.kind platform.mass platform.centre_of_mass platform.inertia platform.inertia_products "
    "platform.boxes platform.nozzle platform.plane scene.beams"
)


def urdf(robot: Robot, pose: Array) -> ExportedFile:
    """Return the URDF of a robot whose platform is at a *pose* (n,), m and rotation vector, rad."""
    notes = Notes()
    notes.add_all(losses(robot, Capability.URDF))
    notes.add_all(lost_keys(keys_given(robot), f"{_CARRIED} lines"))
    if robot.platform.inertia is None:
        notes.add(f"platform.inertia: not known; that of a ball of {BALL:g} m is written")
    if robot.n == 3 and robot.platform.plane is None:
        notes.add("a point that does not rotate: URDF has no such joint, the platform is a body that floats")
    comments = "".join(f"  <!-- lost: {printable(each).replace('--', '- -')} -->\n" for each in notes.all)
    text = f'<?xml version="1.0"?>\n<robot name={quoteattr(printable(robot.name))}>\n{comments}'
    text += f'  <link name="frame">\n{"".join(map(_visual, _bars(robot)))}  </link>\n'
    text += f"{_joint(robot, pose)}{_platform(robot)}{_nozzle(robot)}</robot>\n"
    return ExportedFile(text, notes.all)


def _bars(robot: Robot) -> list[str]:
    """Return shape and place of each bar of the frame: a cylinder, whose axis is z in URDF."""
    found = []
    for beam in robot.scene.beams:
        start, end = np.array(beam.start), np.array(beam.end)
        length = float(np.linalg.norm(end - start))
        along = (end - start) / length if length else np.array([0.0, 0.0, 1.0])
        # roll 0: pitch tilts z towards x, yaw turns it about the vertical
        pitch, yaw = float(np.arccos(np.clip(along[2], -1.0, 1.0))), float(np.arctan2(along[1], along[0]))
        place = _origin(0.5 * (start + end), (0.0, pitch, yaw))
        found.append(f'{place}<geometry><cylinder radius="{beam.radius!r}" length="{length!r}"/></geometry>')
    return found


def _platform(robot: Robot) -> str:
    platform = robot.platform
    tensor = [0.4 * platform.mass * BALL**2] * 3 + [0.0] * 3
    if platform.inertia is not None:
        tensor = [*platform.inertia, *platform.inertia_products]
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    inertia = " ".join(f'{name}="{value!r}"' for name, value in zip(names, tensor, strict=True))
    shapes = [
        f"{_origin(0.5 * (np.array(box.lowest) + np.array(box.highest)))}"
        f'<geometry><box size="{xml_numbers(np.array(box.highest) - np.array(box.lowest))}"/></geometry>'
        for box in platform.boxes
    ]
    return (
        f'  <link name="platform">\n    <inertial>{_origin(platform.centre_of_mass)}<mass value="{platform.mass!r}"/>'
        f"<inertia {inertia}/></inertial>\n{''.join(map(_visual, shapes))}  </link>\n"
    )


def _nozzle(robot: Robot) -> str:
    return (
        '  <link name="nozzle"/>\n  <joint name="nozzle" type="fixed"><parent link="platform"/><child link="nozzle"/>'
        f"{_origin(robot.platform.nozzle)}</joint>\n"
    )


def _joint(robot: Robot, pose: Array) -> str:
    """Return the joint of the platform at a pose; that in a plane slides across its axis and turns about it."""
    plane = robot.platform.plane
    kind, axis = ("floating", "") if plane is None else ("planar", f'<axis xyz="{xml_numbers(plane.across)}"/>')
    return (
        f'  <joint name="platform" type="{kind}"><parent link="frame"/><child link="platform"/>'
        f"{_origin(pose[:3], _roll_pitch_yaw(pose))}{axis}</joint>\n"
    )


def _roll_pitch_yaw(pose: Array) -> tuple[float, float, float]:
    """Return the rotation of a pose as turns about the world's x, y and z in this order, rad."""
    R = (placed(pose, np.eye(3)) - pose[:3]).T
    pitch = float(np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0])))
    if np.hypot(R[0, 0], R[1, 0]) < 1e-12:  # straight up or down: yaw is taken as 0
        return float(np.arctan2(-R[1, 2], R[1, 1])), pitch, 0.0
    return float(np.arctan2(R[2, 1], R[2, 2])), pitch, float(np.arctan2(R[1, 0], R[0, 0]))


def _visual(shape: str) -> str:
    return f"    <visual>{shape}</visual>\n"


def _origin(at: Sequence[float] | Array, turns: Sequence[float] = (0.0, 0.0, 0.0)) -> str:
    return f'<origin xyz="{xml_numbers(at)}" rpy="{xml_numbers(turns)}"/>'
