"""The scene of a machine's log, as far as it can be read."""

from __future__ import annotations

from array import array
from pathlib import Path
from typing import Final

import numpy as np

from cablewright.apps.web.motion_scene import Gone, Moments, motion_scene
from cablewright.apps.web.path_states import chosen
from cablewright.apps.web.scene import SceneDescription
from cablewright.arrays import Array
from cablewright.errors import InputError
from cablewright.machine.log.head import LogHead
from cablewright.machine.log.log import Entry, read_log
from cablewright.progress import Progress, silent
from cablewright.signals import Inertial, LineAngles, PrintState, Scan

_UNUSED: Final = frozenset({Scan, Inertial, LineAngles})
_MOST_STEPS: Final = 5_000_000


class _Columns:
    """Numbers of a log's steps, a row for each: time, true and estimated place, layer, whether it prints."""

    WIDTH: Final = 9

    def __init__(self) -> None:
        self._values = array("d")
        self.kept: list[Entry] = []  # every `_every`-th step, for the states
        self._every, self.steps = 1, 0

    def add(self, entry: Entry) -> None:
        if self.steps >= _MOST_STEPS:
            raise InputError(f"log: more than {_MOST_STEPS} steps")
        nowhere = (np.nan, np.nan, np.nan)
        true = nowhere if entry.truth is None else entry.truth.position
        told = nowhere if entry.estimate is None or not entry.estimate.valid else entry.estimate.position
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
    """The scene of a log, a file or a run folder, as far as it can be read. Raises `InputError` where there is none."""
    columns = _Columns()
    with read_log(path) as log:
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
    moments = Moments(
        time=np.array([each.frame.time for each in at]),
        true=np.array([_pose(each.truth) for each in at]),
        told=np.array([_pose(each.estimate if each.estimate and each.estimate.valid else None) for each in at]),
        lengths=np.array([unknown if each.truth is None else each.truth.lengths for each in at]),
        tensions=np.array([unknown if each.truth is None else each.truth.tensions for each in at]),
        covariances=np.array([_covariance(each) for each in at]),
    )
    gone = Gone(rows[:, 0], rows[:, 1:4], rows[:, 4:7], rows[:, 7].astype(int), rows[:, 8] > 0.5)
    if not (np.isfinite(gone.true).any() or np.isfinite(gone.told).any()):
        raise InputError(f"{path}: the log has neither the truth nor a valid estimate: there is no pose to show")
    return motion_scene(f"{path.name}: {head.robot.name}", head, gone, moments, faults)


def _pose(told: object) -> Array:
    position, rotation = getattr(told, "position", np.full(3, np.nan)), getattr(told, "rotation", np.full(3, np.nan))
    made = np.concatenate([position, rotation])
    if np.isfinite(made[:3]).all():
        made[3:] = np.nan_to_num(made[3:])
    return np.asarray(made)


def _covariance(entry: Entry) -> Array:
    covariance = None if entry.estimate is None else entry.estimate.covariance
    return np.full((3, 3), np.nan) if covariance is None else np.asarray(covariance, dtype=float)[:3, :3]
