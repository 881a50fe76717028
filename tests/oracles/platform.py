"""Oracle: a platform at a pose, with 50 digits: where its points are and what acts on it besides the lines.

A pose is the position of the platform's origin, m, world, and for a rigid body (n = 6) a rotation vector r, rad, with
R = exp([r]x) from the platform frame to the world. A wrench is a force, N, and for n = 6 a moment about the platform's
origin, N m, both in the world frame. A motion is a translation, m, and for n = 6 a small rotation in space, rad.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mpmath import mp, mpf

from cablewright.robot import Robot
from oracles.irvine import Real


@dataclass(frozen=True)
class Place:
    """The position (3) of a platform's origin, m, world, and its rotation (3, 3) from the platform frame to the world.

    A point platform is never turned.
    """

    position: tuple[mpf, ...]
    rotation: mp.matrix

    @classmethod
    def of(cls, pose: Sequence[Real]) -> Place:
        """Return the place that a pose (n,) means."""
        turn = [mpf(value) for value in pose[3:]] or [mpf(0)] * 3
        return cls(tuple(mpf(value) for value in pose[:3]), exponential(turn))

    def moved(self, motion: Sequence[Real]) -> Place:
        """Return the place after a motion (n,): R becomes exp([d]x) R."""
        turn = exponential(motion[3:]) if len(motion) == 6 else mp.eye(3)
        return Place(tuple(p + d for p, d in zip(self.position, motion[:3], strict=True)), turn * self.rotation)

    def arm(self, point: Sequence[Real]) -> list[mpf]:
        """Return where a point (3) of the platform frame is from the platform's origin, m, world axes."""
        return list(self.rotation * mp.matrix(list(point)))

    def point(self, point: Sequence[Real]) -> list[mpf]:
        """Return where a point (3) of the platform frame is in the world, m."""
        return [p + b for p, b in zip(self.position, self.arm(point), strict=True)]


def exponential(vector: Sequence[Real]) -> mp.matrix:
    """Return the rotation (3, 3) about ``vector`` (3) by its length, rad (Rodrigues)."""
    x, y, z = vector
    cross = mp.matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = mp.norm(mp.matrix(list(vector)))
    if angle == 0:
        return mp.eye(3)
    half = mp.sin(angle / 2) / angle  # 1 - cos would cancel for the small turns of differences
    return mp.eye(3) + mp.sin(angle) / angle * cross + 2 * half**2 * cross**2


def turned_by(before: mp.matrix, after: mp.matrix) -> list[mpf]:
    """Return the rotation vector (3), rad, world, of the turn from one rotation (3, 3) to another, if below pi."""
    turn = after * before.T
    axis = [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
    sine = mp.norm(mp.matrix(axis)) / 2
    if sine == 0:
        return [mpf(0)] * 3
    angle = mp.atan2(sine, (turn[0, 0] + turn[1, 1] + turn[2, 2] - 1) / 2)
    return [value / (2 * sine) * angle for value in axis]


def wrench(n: int, arm: Sequence[Real], force: Sequence[Real]) -> list[mpf]:
    """Return the wrench (n,) of a force at ``arm`` from the platform's origin."""
    x, y, z = arm
    fx, fy, fz = force
    return [fx, fy, fz, y * fz - z * fy, z * fx - x * fz, x * fy - y * fx][:n]


def load(robot: Robot, at: Place) -> list[mpf]:
    """Return the wrench (n,) of the platform's weight and of the external force and moment."""
    platform = robot.platform
    weight = mpf(platform.mass) * mpf(robot.scene.gravity)
    centre = at.arm(platform.centre_of_mass) if robot.n == 6 else [mpf(0)] * 3
    falls = wrench(robot.n, centre, (mpf(0), mpf(0), -weight))
    pushed = [*platform.force, *(platform.moment if robot.n == 6 else ())]
    return [w + mpf(p) for w, p in zip(falls, pushed, strict=True)]
