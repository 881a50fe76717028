"""Simulated camera in the room: corners of tags on a platform that moves, and the pose that fits them.

From the true pose, through the camera as it is: place, direction, focal length and clock with errors of one unit,
rolling shutter, blur by motion, people in between, and an answer that arrives late. The pose is found by the camera as
its data sheet has it. Tags in one plane fit in a second pose too, mirrored about the line of sight: the better of both
is given, or none where noise may have decided.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, Final, Self

import numpy as np
from pydantic import Field, model_validator

from cablewright.foundation.arrays import Array
from cablewright.foundation.saved_state import Saved, SavedRows
from cablewright.foundation.signals import CameraPose, frozen
from cablewright.foundation.validation import refusal
from cablewright.machine.quantities import Delay, Share, Time
from cablewright.machine.sensors.camera import CAMERA, CameraSensor
from cablewright.machine.simulated.sensors.timed_sensor import SensorFlaws, Simulated, TimedSensor
from cablewright.models.rotation import matrices, motion_between, moved

if TYPE_CHECKING:
    from cablewright.machine.simulated.sensor_context import Mounted
    from cablewright.machine.simulated.true_state import RigState

_LEAST_SIDE: Final = 25.0  # px of the shortest side of a tag that is read
_MODULES: Final = 8  # along a tag's side: a smear of more than one module is not read
_SMEARED: Final = 0.1  # of a smear, standard deviation of a corner besides its own noise, assumed
_ROUNDS: Final = 5  # of Gauss and Newton
_FLAT: Final = 1e-3  # of the largest extent of corners in one plane
_SAME: Final = 1e-3  # rad between two poses that are one
_AMBIGUOUS: Final = 4.0  # squares of the second pose over those of the first, below which noise may have decided
_MOST_WAITING: Final = 10_000
_ANYWHERE: Final = np.repeat([1.0, 0.5], 3)  # m, rad, of an outlier


class CameraFlaws(SensorFlaws):
    """Flaws of a camera. ``occlusion``: share of the time in which the platform is hidden; ``hidden``: s, on average.

    ``exposure``: s; ``readout``: s from the first row of a picture to the last. ``latency``: s, the shortest and the
    longest from the exposure to the reading.
    """

    occlusion: Annotated[Share, Field(lt=1.0)] = 0.0
    hidden: Time = 2.0
    exposure: Delay = 0.0
    readout: Delay = 0.0
    latency: tuple[Delay, Delay] = (0.0, 0.0)

    @model_validator(mode="after")
    def _latency_rises(self) -> Self:
        if self.latency[0] > self.latency[1]:
            raise refusal("latency", "must be the shortest and the longest, in this order")
        return self


class RoomCamera(TimedSensor[CameraSensor, CameraFlaws]):
    """One camera; the errors of its place, direction, focal length and clock are drawn once."""

    SAVED: ClassVar[Saved] = (*TimedSensor.SAVED, SavedRows("_late", _MOST_WAITING))

    def _mount(self, machine: Mounted) -> None:
        sheet, flaws, drawn = self.settings, self.flaws, self._random.standard_normal(8)
        self._corners = np.concatenate([tag.corners for tag in sheet.tags])  # (4 t, 3)
        self._axes, self._at = sheet.axes, np.array(sheet.at)
        self._true_axes = matrices(sheet.turn_deviation * drawn[:3]) @ self._axes
        self._true_at = self._at + sheet.place_deviation * drawn[3:6]
        self._true_focal = sheet.focal_length * (1.0 + sheet.focal_deviation * float(drawn[6]))
        self._ahead = sheet.time_deviation * float(drawn[7])  # s, of the exposure before its stamp
        self._period, self._late = machine.period, np.zeros((0, 44))
        share, lengths = flaws.occlusion, (0.5 * flaws.hidden, 1.5 * flaws.hidden)
        self._hidden = machine.occlusions(flaws.hidden * (1.0 / share - 1.0), lengths) if share else None

    def read(self, state: RigState) -> CameraPose | None:
        """Return the reading that arrives in this step of the machine; see `TimedSensor.read`."""
        found = super().read(state)
        if isinstance(found, CameraPose):
            least, most = self.flaws.latency
            steps = (least + (most - least) * self._random.random()) / self._period // 1.0
            row = np.concatenate([[self._step + steps, found.time], found.pose, found.covariance])
            self._late = np.vstack([self._late, row])[-_MOST_WAITING:]
        if not len(self._late) or self._late[0, 0] > self._step:
            return None
        row, self._late = self._late[0], self._late[1:]
        return CameraPose(float(row[1]), frozen(row[2:8].copy()), frozen(row[8:].copy()))

    def _measure(self, state: RigState) -> CameraPose | None:
        truth, sheet, flaws = state.truth, self.settings, self.flaws
        noise, chance = self._random.standard_normal((len(self._corners), 2)), self._random.random()
        anywhere = self._random.uniform(-1.0, 1.0, 6)
        if chance < flaws.dropout or (self._hidden is not None and self._hidden.at(truth.time) is not None):
            return None
        arms = self._corners @ state.rotation.T
        velocities = truth.velocity + np.cross(truth.rate, arms)
        shown = self._seen(truth.position + arms)
        rows = self._ahead + flaws.readout * (shown[:, 1] / sheet.height - 0.5)  # s after the middle of the exposure
        shown = self._seen(truth.position + arms + rows[:, None] * velocities)
        smear = np.linalg.norm(self._seen(truth.position + arms + flaws.exposure * velocities) - shown, axis=1)
        shown = shown + np.hypot(sheet.corner_deviation, _SMEARED * smear)[:, None] * noise
        read = np.repeat(self._are_read(shown.reshape(-1, 4, 2), smear.reshape(-1, 4).max(axis=1)), 4)
        pose = np.concatenate([truth.position, truth.rotation])
        found = self._fitted(pose, shown[read], read) if read.any() else None
        other = None if found is None else self._mirrored(found[0], shown[read], read)
        if found is not None and other is not None:
            if max(found[2], other[2]) < _AMBIGUOUS * max(min(found[2], other[2]), self._unlikely(len(shown[read]))):
                return None  # either may be right
            found = min(found, other, key=lambda each: each[2])
        if found is None:
            return None
        pose, covariance, _ = found
        if chance > 1.0 - flaws.outliers:
            pose = pose + _ANYWHERE * anywhere
        return CameraPose(truth.time, frozen(pose), frozen(covariance.ravel()))

    def _seen(self, points: Array) -> Array:
        """Pixels (k, 2) of *points* (k, 3), m, world, by the camera as it is; NaN behind it."""
        return _pixels((points - self._true_at) @ self._true_axes, self._true_focal, self.settings)

    def _are_read(self, corners: Array, smear: Array) -> Array:
        """Whether each tag is read, (t,), by its *corners* (t, 4, 2) and its *smear* (t,), px.

        It must face the camera, be in the picture, be large enough and sharp enough.
        """
        sides = np.roll(corners, -1, axis=1) - corners
        x, y = np.moveaxis(sides, -1, 0)
        turns = x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)  # clockwise in a picture, whose y is down
        inside = ((corners >= 0.0) & (corners <= [self.settings.width - 1, self.settings.height - 1])).all(axis=(1, 2))
        least = np.linalg.norm(sides, axis=2).min(axis=1)
        return np.asarray(inside & (turns > 0.0).all(axis=1) & (least >= _LEAST_SIDE) & (smear <= least / _MODULES))

    def _unlikely(self, points: int) -> float:
        """The mean of the squares, px^2, of a right pose for corners of that number of *points*: theirs by noise."""
        return float((2 * points - 6) * self.settings.corner_deviation**2)

    def _mirrored(self, pose: Array, shown: Array, read: Array) -> tuple[Array, Array, float] | None:
        """Return the other pose in which tags in one plane appear nearly the same; None for tags in several planes."""
        corners = self._corners[read]
        middle = corners.mean(axis=0)
        _, extent, axes = np.linalg.svd(corners - middle)
        if extent[2] > _FLAT * extent[0]:
            return None
        rotation = matrices(pose[3:])
        sight = pose[:3] + rotation @ middle - self._at
        sight /= np.linalg.norm(sight)
        normal = rotation @ axes[2]
        other = 2.0 * float(sight @ normal) * sight - normal
        start = pose
        for axis in (sight, other):
            start = moved(start, np.concatenate([np.zeros(3), np.pi * axis]))
        start[:3] += (rotation - matrices(start[3:])) @ middle
        found = self._fitted(start, shown, read)
        return None if found is None or np.linalg.norm(motion_between(pose, found[0])[3:]) < _SAME else found

    def _fitted(self, pose: Array, shown: Array, read: Array) -> tuple[Array, Array, float] | None:
        """Return the pose (6,) that fits the corners *shown* (k, 2), px, of those *read*, and its covariance (6, 6).

        And the sum of the squares that are left, px^2. From *pose* on, by the data sheet. The variance of a pixel is
        the sheet's, or that of the residuals if larger.
        """
        sheet, corners = self.settings, self._corners[read]
        for _ in range(_ROUNDS):
            arms = corners @ matrices(pose[3:]).T
            local = (pose[:3] + arms - self._at) @ self._axes
            x, y, z = local.T
            per_point = np.zeros((len(local), 2, 3))
            per_point[:, 0, 0] = per_point[:, 1, 1] = sheet.focal_length / z
            per_point[:, 0, 2], per_point[:, 1, 2] = -sheet.focal_length * x / z**2, -sheet.focal_length * y / z**2
            slopes = per_point @ self._axes.T  # by the motion of each point, world
            turned = np.stack([np.cross(arms, slope) for slope in np.moveaxis(slopes, 1, 0)], axis=1)
            J = np.concatenate([slopes, turned], axis=2).reshape(-1, 6)
            off = (shown - _pixels(local, sheet.focal_length, sheet)).ravel()
            normal = J.T @ J
            if not np.linalg.cond(normal) < 1e14:
                return None
            step = np.linalg.solve(normal, J.T @ off)
            pose = moved(pose, step)
        squares = float(np.sum((off - J @ step) ** 2))
        rest = squares / max(len(off) - 6, 1)
        return pose, np.linalg.inv(normal) * max(sheet.corner_deviation**2, rest), squares


def _pixels(local: Array, focal: float, sheet: CameraSensor) -> Array:
    """Pixels (k, 2) of points *local* (k, 3), m, in the camera's frame; NaN behind it."""
    depth = np.where(local[:, 2:] > 0.0, local[:, 2:], np.nan)
    return np.asarray(focal * local[:, :2] / depth + [0.5 * (sheet.width - 1), 0.5 * (sheet.height - 1)])


SIMULATED: Final = Simulated(CAMERA, CameraFlaws, RoomCamera)
