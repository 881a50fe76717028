"""The scene of a machine's log, as far as it can be read."""

from __future__ import annotations

from array import array
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from cablewright.apps.web.motion_scene import Gone, MotionSteps, motion_scene
from cablewright.apps.web.path_scene import chosen
from cablewright.apps.web.scene import SceneDescription
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.progress import Progress, silent
from cablewright.foundation.signals import Estimate, Inertial, LineAngles, PrintState, Scan
from cablewright.machine.log.head import LogHead
from cablewright.machine.log.log import Entry, read_log
from cablewright.machine.log.scan_points import seen_points
from cablewright.models.rotation import matrix_of

_UNUSED: Final = frozenset({Scan, Inertial, LineAngles})
_MOST_STEPS: Final = 5_000_000


class _Columns:
    """Numbers of a log's steps, a row for each: time, true and estimated place of the nozzle, layer, printing."""

    WIDTH: Final = 9

    def __init__(self, nozzle: Array) -> None:
        self._values, self._nozzle = array("d"), nozzle
        self.kept: list[Entry] = []  # every `_every`-th step, for the states
        self._every, self.steps = 1, 0

    def add(self, entry: Entry) -> None:
        if self.steps >= _MOST_STEPS:
            raise InputError(f"log: more than {_MOST_STEPS} steps")
        true = _moved(_pose(entry.truth), self._nozzle)
        told = _moved(_pose(_valid(entry)), self._nozzle)
        layer = 0 if entry.progress is None else entry.progress.layer
        prints = entry.progress is not None and entry.progress.state is PrintState.PRINTING
        self._values.extend((entry.frame.time, *true, *told, layer, prints))
        if self.steps % self._every == 0:
            self.kept.append(entry)
            if len(self.kept) > 1200:
                self.kept, self._every = self.kept[::2], 2 * self._every
        self.steps += 1

    @property
    def rows(self) -> Array:
        return np.frombuffer(self._values, dtype=np.float64).reshape(-1, self.WIDTH)


def log_scene(path: Path, progress: Progress = silent) -> SceneDescription:
    """Return the scene of a log, a file or a run folder, as far as it can be read.

    Raises `InputError` where there is none.
    """
    with read_log(path) as log:
        columns = _Columns(np.array(log.head.nozzle))
        for entry in log.entries(without=_UNUSED):
            columns.add(entry)
            if columns.steps % 1000 == 0:
                progress("reading the log (bytes)", log.position, log.size)
        head, notes = log.head, list(log.notes)
    if not columns.steps:
        raise InputError(f"{path}: the log has no complete step to show")
    return _scene(path, head, columns, notes)


def _scene(path: Path, head: LogHead, columns: _Columns, faults: list[str]) -> SceneDescription:
    rows, m = columns.rows, head.robot.m
    unknown = np.full(m, np.nan)
    kept = columns.kept
    at = [kept[int(k)] for k in chosen(len(kept))]
    gone = Gone(rows[:, 0], rows[:, 1:4], rows[:, 4:7], rows[:, 7].astype(int), rows[:, 8] > 0.5)
    moments = MotionSteps(
        time=np.array([each.frame.time for each in at]),
        true=np.array([_pose(each.truth) for each in at]),
        told=np.array([_pose(_valid(each)) for each in at]),
        lengths=np.array([unknown if each.truth is None else each.truth.lengths for each in at]),
        tensions=np.array([unknown if each.truth is None else each.truth.tensions for each in at]),
        covariances=np.array([_covariance(each) for each in at]),
    )
    if not (np.isfinite(gone.true).any() or np.isfinite(gone.told).any()):
        raise InputError(f"{path}: the log has neither the truth nor a valid estimate: there is no pose to show")
    moments = replace(moments, scans=_scans(path, head, gone, moments))
    return motion_scene(f"{path.name}: {head.robot.name}", head, gone, moments, faults)


def _scans(path: Path, head: LogHead, gone: Gone, moments: MotionSteps) -> tuple[Array, ...] | None:
    """What the lidars saw at the moments, by the truth where the log has it; None of a machine without lidars."""
    if not head.settings.lidars:
        return None
    has_truth = bool(np.isfinite(gone.true).any())
    places, poses = (gone.true, moments.true) if has_truth else (gone.told, moments.told)
    known = np.isfinite(places).all(axis=1)
    way, nozzle = (gone.time[known], places[known]), np.array(head.nozzle)
    made = []
    with read_log(path) as log:
        for now, pose, scans in zip(moments.time, poses, log.scans_at(moments.time.tolist()), strict=False):
            made.append(seen_points(scans, head.settings.lidars, float(now), way, np.nan_to_num(pose[3:]), nozzle))
    return (*made, *(np.empty((0, 3)) for _ in range(len(moments.time) - len(made))))  # of a log that was cut meanwhile


def _valid(entry: Entry) -> Estimate | None:
    return entry.estimate if entry.estimate is not None and entry.estimate.valid else None


def _moved(pose: Array, offset: Array) -> Array:
    """The place (3,) of a point of the platform, *offset* (3,), m; NaN where the pose is not known."""
    return pose[:3] + matrix_of(pose[3:]) @ offset if offset.any() and np.isfinite(pose[3:]).all() else pose[:3]


def _pose(told: object) -> Array:
    position, rotation = getattr(told, "position", np.full(3, np.nan)), getattr(told, "rotation", np.full(3, np.nan))
    made = np.concatenate([position, rotation])
    if np.isfinite(made[:3]).all():
        made[3:] = np.nan_to_num(made[3:])
    return np.asarray(made)


def _covariance(entry: Entry) -> Array:
    covariance = None if entry.estimate is None else entry.estimate.covariance
    return np.full((3, 3), np.nan) if covariance is None else np.asarray(covariance, dtype=float)[:3, :3]
