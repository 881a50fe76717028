"""Travel moves without collisions of lines: lifted over, or led round, frame and printed part.

Only lines are compared, as in `interference`; the platform and the nozzle are not.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from itertools import pairwise, product
from typing import Any, ClassVar, Final

import numpy as np

from cablewright.analyses.interference import distances, too_near
from cablewright.analyses.job_distances import JobDistances
from cablewright.analyses.motion.lower_acceleration import slowed
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.memory_mapped import MEMORY, Room, blocks
from cablewright.foundation.progress import Progress, silent
from cablewright.foundation.results import Figure
from cablewright.models.job_poses import on_plane, poses_at, unrounded
from cablewright.models.statics import Model
from cablewright.printing.beads import Beads
from cablewright.printing.job import Job
from cablewright.printing.path import Samples
from cablewright.printing.toolpath import Toolpath
from cablewright.robot import Robot
from cablewright.solvers.inverse import BLOCK, solve_inverse
from cablewright.solvers.path_speeds import fed, with_speeds

STEP: Final = 0.05
"""Largest distance, m, of the places of a travel move at which lines are compared."""

LIFTS: Final = (0.0, 0.005, 0.01, 0.02, 0.04, 0.08, 0.16, 0.3, 0.5)
"""Heights by which a travel move may be lifted, in heights of the frame."""

ASIDE: Final = (0.0, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5)
"""Distances by which the middle of a travel move may be moved aside, level and square to the move, in frame widths."""

_FIRST: Final = 6  # places of a way that are looked at before all


@dataclass(frozen=True)
class LedTravel:
    """A travel move that was changed, or for which no safe path was found."""

    FIGURES: ClassVar = (
        Figure("line", "", "Line of the G-code file."),
        Figure("layer", "", "Layer, counted from 1; 0 before the first."),
        Figure("lift", "m", "Height by which the travel is lifted."),
        Figure("aside", "m", "Horizontal offset of its middle; positive to the left."),
        Figure("added", "m", "Additional length; null: there is no safe path, the travel is unchanged."),
    )

    line: int  # of the file
    layer: int
    lift: float  # m
    aside: float  # m, to the left positive
    added: float  # m, that it is longer; NaN: no safe way was found, it is as it was


def driven(robot: Robot, job: Job, samples: Samples, beads: Beads) -> Samples:
    """Return *samples* of a *job* with the *robot*'s speeds and with safe travel moves. Raises as `driven_job`."""
    fast = fed(robot, job, samples)
    return fast if job.motion.travel == "gcode" else led(Model.full(robot), job, fast, beads)[0]


def driven_job(
    robot: Robot, job: Job, samples: Samples | None = None, toolpath: Toolpath | None = None
) -> tuple[Job, Samples]:
    """Return a *job* with the speeds, the acceleration and the corners of its motion on a *robot*, and its samples.

    They have the speeds and the travel moves of that motion. *samples*, *toolpath*: samples and toolpath of the job; by
    default those of its file. Raises `InputError` where nothing limits a speed, or the robot cannot follow the job's
    schedule.
    """
    job = on_plane(robot, job)
    toolpath = toolpath or job.toolpath()
    beads = job.beads(toolpath)
    job = job.with_corners(beads)
    given = samples or unrounded(robot, job, toolpath, job.samples(toolpath, beads=beads))
    if job.motion.speed == "gcode" and job.motion.travel == "gcode":
        return job, given
    found = driven(robot, job, given, beads)
    return with_speeds(slowed(robot, job, found, beads), found), found


def led(
    model: Model,
    job: Job,
    samples: Samples,
    beads: Beads,
    clearance: float = 0.0,
    *,
    room: Room = MEMORY,
    progress: Progress = silent,
) -> tuple[Samples, tuple[LedTravel, ...]]:
    """Return *samples* of a *job* whose travel moves are the shortest safe ones among those tried, and the changes.

    A travel move is safe where at all its places the platform is held, and no line is nearer than *clearance*, m, to
    another, the frame, the platform's boxes or what is laid by then; at 0 none touches. What is safe stays as it is.
    """
    grown = JobDistances.of(model.robot, beads, samples, room=room)
    search = _Search(model, job, grown, clearance)
    ways: list[tuple[int, int, Array]] = []
    found: list[LedTravel] = []
    unsafe = search.unsafe(samples)
    for number, (begin, end) in enumerate(unsafe):
        progress("travel moves", number, len(unsafe))
        asis = samples.positions[begin : end + 1]
        way = search.shortest(asis, float(grown.now[begin]))
        here = int(samples.line[end]), int(samples.layer[end])
        if way is None:
            found.append(LedTravel(*here, 0.0, 0.0, np.nan))
        else:
            found.append(LedTravel(*here, way.lift, way.aside, way.length - _length(asis)))
            ways.append((begin, end, way.corners))
    progress("travel moves", len(unsafe), len(unsafe))
    return _with(samples, ways) if ways else samples, tuple(found)


@dataclass(frozen=True, eq=False)
class _Way:
    """A way of straight legs from one place to another."""

    corners: Array  # (k, 3) m
    lift: float  # m
    aside: float  # m

    @property
    def length(self) -> float:
        """Length of the travel move, m."""
        return _length(self.corners)

    @property
    def places(self) -> Array:
        """Places (k, 3), m, along the travel move, without its ends, which belong to printed moves."""
        return _dense(self.corners)[1:-1]


def _ways(model: Model, asis: Array) -> Iterator[_Way]:
    """Yield ways from the first to the last of *asis* (k, 3), m, within the frame, the shortest first."""
    scene, begin, end = model.robot.scene, asis[0], asis[-1]
    low, high = np.array(scene.frame_min), np.array(scene.frame_max)
    level = (end - begin)[:2]
    size = float(np.linalg.norm(level))
    left = np.array([-level[1], level[0], 0.0]) / size if size > 0.0 else np.array([1.0, 0.0, 0.0])
    width = float((high - low)[:2].min())
    asides = sorted({sign * share * width for share in ASIDE for sign in (1.0, -1.0)})
    tried = []
    for share, aside in product(LIFTS, asides):
        lift = share * float(high[2] - low[2])
        up = max(begin[2], end[2]) + lift
        middle = 0.5 * (begin + end) + aside * left
        over = [[*begin[:2], up], [*end[:2], up]] if lift else []
        past = [[*middle[:2], up if lift else middle[2]]] if aside else []
        way = _Way(np.array([begin, *over[:1], *past, *over[1:], end]), lift, aside)
        if (way.corners >= low).all() and (way.corners <= high).all():
            tried.append(way)
    yield from sorted(tried, key=lambda way: way.length)


@dataclass(frozen=True, eq=False)
class _Search:
    """Robot, part and limits by which a travel move is judged."""

    model: Model
    job: Job
    grown: JobDistances
    clearance: float  # m

    def safe(self, places: Array, now: Array | float) -> Mask:
        """Return whether lines hold the platform at *places* (k, 3), m, with the clearance to all obstacles, (k,).

        *now*: the sample, one or (k,), up to which the part has been printed.
        """
        found = np.empty(len(places), dtype=np.bool_)
        when = np.broadcast_to(now, len(places))
        for at in blocks(len(places), BLOCK):
            poses, retraction = poses_at(self.model.robot, self.job, places[at])
            held = solve_inverse(self.model, poses, path=True, retraction=retraction)
            near = distances(held, part=self.grown.part, now=when[at], settings=self.grown.settings).smallest
            found[at] = held.holds & ~too_near(near, self.clearance)
        return found

    def unsafe(self, samples: Samples) -> list[tuple[int, int]]:
        """Return the first and the last sample of each run of travel moves in which a sample is not safe."""
        edges = np.diff(np.concatenate([[False], ~samples.extruding[1:], [False]]).astype(np.int8))
        begins, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
        inside = np.zeros(len(samples), dtype=np.bool_)
        for begin, end in zip(begins, ends, strict=True):
            inside[begin + 1 : end] = True  # its ends belong to laid moves
        rows = np.flatnonzero(inside)
        bad = rows[~self.safe(samples.positions[rows], self.grown.now[rows])]
        runs = np.unique(np.searchsorted(begins, bad, side="right") - 1)
        return [(int(begins[run]), int(ends[run])) for run in runs]

    def shortest(self, asis: Array, now: float) -> _Way | None:
        """Return the shortest safe detour for a travel move *asis* (k, 3), m, of those tried; None: none is safe."""
        return next((way for way in _ways(self.model, asis) if self._is_safe(way.places, now)), None)

    def _is_safe(self, places: Array, now: float) -> bool:
        """Return whether all *places* (k, 3), m, are safe; a few of the places are tested first."""
        return all(self.safe(places[:: step or 1], now).all() for step in (len(places) // _FIRST, 1))


def _with(samples: Samples, ways: list[tuple[int, int, Array]]) -> Samples:
    """Return *samples* with other *ways* (first and last sample, corners) of some travel moves."""
    parts: dict[str, list[Any]] = {each.name: [] for each in fields(samples)}
    done = 0
    for begin, end, corners in ways:
        _take(parts, samples, slice(done, begin + 1))
        legs = [_dense(np.stack(pair))[1:] for pair in pairwise(corners)]
        places = np.concatenate(legs)
        for each in fields(samples):
            parts[each.name].append(np.repeat(getattr(samples, each.name)[end : end + 1], len(places), axis=0))
        parts["positions"][-1] = places
        parts["dwell"][-1][:-1] = 0.0
        parts["dwell"][-1][-1] = samples.dwell[begin + 1 : end + 1].sum()
        # each leg is a move of its own, so that the nozzle slows down between two; no bead is of these rows
        parts["move"][-1] -= np.repeat(np.arange(len(legs))[::-1] % 2, [len(leg) for leg in legs])
        done = end + 1
    _take(parts, samples, slice(done, len(samples)))
    found = {name: np.concatenate(arrays) for name, arrays in parts.items()}
    steps = np.linalg.norm(np.diff(found["positions"], axis=0), axis=1)
    found["distance"] = np.concatenate([[0.0], np.cumsum(steps)])
    for array in found.values():
        array.setflags(write=False)
    return Samples(**found)


def _take(parts: dict[str, list[Any]], samples: Samples, rows: slice) -> None:
    for name, arrays in parts.items():
        arrays.append(getattr(samples, name)[rows])


def _dense(corners: Array) -> Array:
    """Return places along *corners* (k, 3), m, at most `STEP` apart."""
    parts = []
    for here, there in pairwise(corners):
        count = max(1, int(np.ceil(np.linalg.norm(there - here) / STEP)))
        parts.append(here + (there - here) * np.linspace(0.0, 1.0, count, endpoint=False)[:, None])
    return np.concatenate([*parts, corners[-1:]])


def _length(corners: Array) -> float:
    return float(np.linalg.norm(np.diff(corners, axis=0), axis=1).sum())
