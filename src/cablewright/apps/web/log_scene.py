"""A scene of a machine's log: where the platform was and where the estimation took it to be, and the lines meanwhile."""

from __future__ import annotations

from array import array
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from cablewright.apps.web.check_scene import extent
from cablewright.apps.web.path_scene import PathScene, Quantity
from cablewright.apps.web.path_states import chosen
from cablewright.apps.web.scene import Body, SceneDescription
from cablewright.apps.web.states import States
from cablewright.arrays import Array
from cablewright.errors import InputError
from cablewright.machine.log.head import LogHead
from cablewright.machine.log.log import Entry, read_log
from cablewright.machine.settings import MachineSettings
from cablewright.models.statics import Model
from cablewright.progress import Progress, silent
from cablewright.signals import Inertial, LineAngles, PrintState, Scan
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.logged_lines import hanging_lines

_UNUSED: Final = frozenset({Scan, Inertial, LineAngles})
_MOST_STEPS: Final = 5_000_000
_MOTION: Final = (
    "The machine moves: its lines are drawn as they hang by the logged lengths between exit point and platform, and the "
    "platform need not be in equilibrium. Tensions are those of the log."
)
_GUESSED: Final = (
    "The log has no truth: what is drawn is where the estimation took the platform to be, with lines as they would hold "
    "it there at rest; it need not have been in equilibrium. Tensions are not known."
)
_ONE_SIGMA_GOAL: Final = 0.03  # of the scene's extent


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
    rows = columns.rows
    time, true, told, layer, prints = rows[:, 0], rows[:, 1:4], rows[:, 4:7], rows[:, 7].astype(int), rows[:, 8] > 0.5
    has_truth = bool(np.isfinite(true).any())
    if not has_truth and not np.isfinite(told).any():
        raise InputError(f"{path}: the log has neither the truth nor a valid estimate: there is no pose to show")
    places = true if has_truth else told
    path_scene = path_of(head.settings, head.robot.name, time, places, true, told, layer, prints, extent(head.robot))
    states = _states(head, columns.kept, time, has_truth)
    bodies = ()
    if has_truth and np.isfinite(told).any():
        bodies = (Body("path of the estimate", "--estimate", track=_thinned(told), shown=False),)
    notes = (_MOTION if has_truth else _GUESSED, *(f"{each[:1].upper()}{each[1:]}." for each in faults))
    return SceneDescription(
        f"{path.name}: {head.robot.name}",
        head.robot,
        states,
        path_scene,
        walls=walls_of(head),
        bodies=bodies,
        drum=drum_of(head),
        notes=notes,
    )


def path_of(
    settings: MachineSettings,
    name: str,
    time: Array,
    places: Array,
    true: Array,
    told: Array,
    layer: Array,
    prints: Array,
    size: float,
) -> PathScene:
    """The path that was gone, coloured by what the estimation was off, by speed and by height."""
    apart = np.linalg.norm(told - true, axis=1)
    quantities = [Quantity.of("estimation", "error of the estimate", "m", apart)] if np.isfinite(apart).any() else []
    step = np.diff(time, prepend=time[:1])
    gone = np.linalg.norm(np.diff(places, axis=0, prepend=places[:1]), axis=1)
    speed = np.divide(gone, step, out=np.full(len(step), np.nan), where=step > 0.0)
    quantities += [Quantity.of("speed", "speed", "m/s", speed), Quantity.of("height", "height", "m", places[:, 2])]
    worst = int(np.nanargmax(apart)) if np.isfinite(apart).any() else None
    bead = None if settings.extrusion is None else settings.extrusion.bead
    shape = None if bead is None else (bead.width, bead.height)
    return PathScene(places, prints, layer, size, quantities, time, bead=shape, worst=worst)


def walls_of(head: LogHead) -> tuple[tuple[str, Array], ...]:
    """The upright walls of the machine's room up to its ceiling: name and corners (4, 3), m."""
    low, high = head.robot.scene.frame_min[2], head.settings.room.ceiling
    return tuple(
        (wall.name, np.array([(*wall.start, low), (*wall.end, low), (*wall.end, high), (*wall.start, high)]))
        for wall in head.settings.room.walls
    )


def drum_of(head: LogHead) -> tuple[float, float] | None:
    """Radius and depth, m, of the drum that hangs from a point platform; None of a body."""
    drum = head.settings.drum
    return (drum.radius, drum.valve) if head.robot.n == 3 else None


def _thinned(points: Array) -> Array:
    return points[:: max(1, len(points) // 5000)]


def _states(head: LogHead, kept: list[Entry], time: Array, has_truth: bool) -> States:
    """The states of some of the steps."""
    known = [each for each in kept if (each.truth if has_truth else each.estimate) is not None]
    at = chosen(len(known))
    some = [known[int(k)] for k in at]
    true = np.array([_pose(each.truth if has_truth else each.estimate) for each in some])
    width, m = head.robot.n, head.robot.m
    model = Model(head.robot)
    lengths = np.array([each.truth.lengths if each.truth is not None else np.full(m, np.nan) for each in some])
    tensions = np.array([each.truth.tensions if each.truth is not None else np.full(m, np.nan) for each in some])
    if has_truth and all(line.in_plane for line in head.robot.lines):
        states = hanging_lines(model, true[:, :width], lengths)
    else:
        states = solve_inverse(model, np.nan_to_num(true[:, :width])).states
        states[~np.isfinite(true[:, :width]).all(axis=1)] = np.nan
    when = np.array([each.frame.time for each in some])
    drawn = States.drawn(
        model.packed, head.robot, true[:, :width], states, tensions, times=when, samples=np.searchsorted(time, when)
    )
    told = np.array([_pose(each.estimate) for each in some])
    if not has_truth or not np.isfinite(told).any():
        return _turned(drawn, true)
    covariances = np.array([_covariance(each) for each in some])
    times = _enlargement(covariances, extent(head.robot))
    return _turned(drawn, true).with_estimates(told, covariances if np.isfinite(covariances).any() else None, times)


def _turned(states: States, poses: Array) -> States:
    """With the rotation of the drum, also where the platform of the robot file is a point."""
    return replace(states, poses=poses)


def _pose(told: object) -> Array:
    position, rotation = getattr(told, "position", np.full(3, np.nan)), getattr(told, "rotation", np.full(3, np.nan))
    made = np.concatenate([position, rotation])
    if np.isfinite(made[:3]).all():
        made[3:] = np.nan_to_num(made[3:])
    return np.asarray(made)


def _covariance(entry: Entry) -> Array:
    covariance = None if entry.estimate is None else entry.estimate.covariance
    return np.full((3, 3), np.nan) if covariance is None else np.asarray(covariance, dtype=float)[:3, :3]


def _enlargement(covariances: Array, size: float) -> float:
    """How many times larger ellipsoids are drawn, so that they are seen: 1, 2 or 5 times a power of ten."""
    known = covariances[np.isfinite(covariances).all(axis=(1, 2))]
    if not len(known):
        return 1.0
    largest = float(np.sqrt(np.median(np.trace(known, axis1=1, axis2=2))))
    wanted = _ONE_SIGMA_GOAL * size / max(largest, 1e-9)
    if wanted <= 1.0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(next(step * power for step in (5.0, 2.0, 1.0) if step * power <= wanted))
