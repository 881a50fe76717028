"""A print job: path, scale, position on the machine and speeds, from TOML or from a bare G-code file.

File paths are relative to the folder of the TOML file. Lengths and speeds are the machine's, after scaling.
"""

from __future__ import annotations

import logging
import math
import os
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Final, Literal, Self

import numpy as np
from annotated_types import Ge, Le
from pydantic import AfterValidator, Field, model_validator

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.memory_mapped import MEMORY, Room, blocks, let_go
from cablewright.foundation.progress import Progress
from cablewright.foundation.toml_input import is_file, read_table, require_schema
from cablewright.foundation.units import (
    Acceleration,
    Density,
    Duration,
    Jerk,
    Length,
    MassFlow,
    Positive,
    Speed,
    VolumeFlow,
)
from cablewright.foundation.validation import Description, FileDescription, refusal, validated
from cablewright.printing.beads import ASSUMED, Beads, beads_of, section
from cablewright.printing.beads import Bead as Bead
from cablewright.printing.gcode import SHORTEST_ARC_STEP, SMALLEST_ARC_ERROR, parse
from cablewright.printing.modal import MAX_COORDINATE
from cablewright.printing.numeric_path import Helix, RandomCurve
from cablewright.printing.path import Samples, sample
from cablewright.printing.schedule import MAX_STAGES, ScheduleStep, Stage
from cablewright.printing.timing import TimeLaw, time_law
from cablewright.printing.toolpath import Material, Toolpath

log = logging.getLogger(__name__)

# Beyond any machine, but small enough that no computation overflows.
_Distance = Annotated[Length, Ge(1e-6), Le(1e3)]
_MAX_SPEED = 1e3  # m/s
_FAST, _VIOLENT, _JERKY, _WIDE = (
    5.0,
    100.0,
    1000.0,
    0.5,
)  # m/s, m/s^2, m/s^3, m: from which on a number is likely in another unit


def _possible(speed: float) -> float:
    if speed > _MAX_SPEED:
        raise ValueError(f"must be at most {_MAX_SPEED:g} m/s: {speed:g} mm/min?")
    return speed


_Speed = Annotated[Speed, Ge(1e-6), AfterValidator(_possible), Field(json_schema_extra={"maximum": _MAX_SPEED})]
_Unit = tuple[float, float, float]
_Coordinate = Annotated[Length, Ge(-MAX_COORDINATE), Le(MAX_COORDINATE)]


DEFAULT_STEP = 0.05
"""Maximum distance between samples, m, where neither the job nor a robot gives it."""


CORNER: Final = 1.0 / 12.0
"""Corner deviation, as a share of the width of strands, where the job gives none: 5 mm for the assumed strand."""


class Motion(Description):
    """Limits of the nozzle's motion. A move with a lower feed, times the scale, keeps its feed."""

    speed: Literal["gcode", "fastest"] = "gcode"
    """Whether feeds of the path count; "fastest": limits alone do, of the speeds below only those that are given."""
    flow_limit: Positive[VolumeFlow] | None = None
    """Maximum material flow; None: no limit."""
    mass_flow_limit: Positive[MassFlow] | None = None
    """The same by mass, with its ``density``."""
    density: Positive[Density] | None = None
    print_speed: _Speed = 0.3
    travel_speed: _Speed = 0.5
    acceleration: Annotated[Acceleration, Ge(1e-6), Le(1e6)] = 0.5
    corner_deviation: _Distance | None = None
    """Distance between a corner and the arc that replaces it; larger is faster. See `printing/timing.py`.

    None: `CORNER` of the width of the job's strands, and at most that of the assumed one: see `Job.with_corners`.
    """
    jerk: Annotated[Jerk, Ge(1e-6), Le(1e4)] | None = None
    """Limit of the jerk along the path; None: unlimited."""
    shaping: Literal["auto", "none"] = "auto"
    """Whether the motion is shaped so that the platform does not swing, where its modes are known."""
    pressure_advance: Annotated[Duration, Ge(-10.0), Le(10.0)] = 0.0
    """Time by which material leads the nozzle's motion; negative: lags."""

    travel: Literal["gcode", "safe"] = "gcode"
    """Whether travel moves are changed where a line would touch an obstacle: see `analyses/travel_moves.py`."""

    @model_validator(mode="after")
    def _flow_is_given_once(self) -> Self:
        if (self.mass_flow_limit is None) is not (self.density is None):
            raise refusal("density", "goes with mass_flow_limit: give both, or neither")
        if self.flow_limit is not None and self.mass_flow_limit is not None:
            raise refusal("mass_flow_limit", "flow_limit is given, too: give one of them")
        return self

    @property
    def corner(self) -> float:
        """Return the allowed corner deviation, m; if the job gives none, that of the assumed strand."""
        return CORNER * Bead().width if self.corner_deviation is None else self.corner_deviation

    @property
    def most_flow(self) -> float:
        """Return the maximum material flow, m^3/s; inf if there is no limit."""
        if self.mass_flow_limit is not None and self.density is not None:
            return self.mass_flow_limit / self.density
        return math.inf if self.flow_limit is None else self.flow_limit

    def most_speed(self, key: Literal["print_speed", "travel_speed"], fastest: bool) -> float:
        """The largest allowed speed, m/s; of the *fastest* motion inf, unless the job specifies it."""
        return math.inf if fastest and key not in self.model_fields_set else float(getattr(self, key))

    def time_law(self, samples: Samples, room: Room = MEMORY, at_samples: Array | None = None) -> TimeLaw:
        """Return the fastest time law of the samples; *room* and *at_samples* as for `timing.time_law`."""
        return time_law(samples, self.acceleration, self.corner, self.jerk, room, at_samples)


class Sampling(Description):
    """Distances of samples along the path, m, machine."""

    step: _Distance | None = None
    """Maximum distance between samples; None: by the robot and the part, at most `DEFAULT_STEP`."""
    arc_error: _Distance = 1e-4
    """Maximum distance of an arc (G2, G3) from the straight pieces that replace it."""


class Job(FileDescription):
    """A part to print: G-code, or a path computed from numbers. The defaults suit a house-sized machine."""

    name: Annotated[str, Field(min_length=1, max_length=300)]
    robot: Annotated[str, Field(min_length=1, max_length=300)] | None = None
    """Name of the only robot that may print the job; None: any robot."""
    gcode: Path | None = None
    material: Material = "E"
    """What lays material in the G-code. See `printing/toolpath.py`."""
    curve: RandomCurve | None = None
    helix: Helix | None = None
    scale: Annotated[float, Field(strict=True, ge=1e-4, le=1e4)] = 1.0
    origin: tuple[_Coordinate, _Coordinate, _Coordinate] = (0.0, 0.0, 0.0)
    """Position of the scaled path's zero, m, machine."""
    axes: tuple[_Unit, _Unit] | None = None
    """Directions of the path's X and Y on the machine, where its Z moves the tool and not the platform.

    None: by the robot's `Plane.gcode_zero`, or the machine's axes.
    """
    bead: Bead = Bead()
    """Values that the bead leaves open are taken from G-code, see `beads`."""
    motion: Motion = Motion()
    sampling: Sampling = Sampling()
    max_error: _Distance | None = None
    """Expected error that is allowed; None: half the width of each bead."""
    max_seam: _Distance | None = None
    """Distance of the prints of two stages at their seam that is allowed; None: the expected error that is allowed."""
    schedule: Annotated[tuple[ScheduleStep, ...], Field(max_length=10_000)] = ()
    """Rotation and retraction of a rigid platform by the nozzle's height, in rising order."""
    stages: Annotated[tuple[Stage, ...], Field(max_length=MAX_STAGES)] = ()
    """Other exit points from heights of the nozzle on, in rising order; below the first those of the robot file."""
    heights: tuple[_Coordinate, _Coordinate] | None = None
    """Layers that are printed: from the first nozzle height to below the second, m, machine; None: all.

    What the path lays below them exists already.
    """

    @model_validator(mode="after")
    def _parts_fit(self) -> Self:
        given = [key for key in ("gcode", "curve", "helix") if getattr(self, key) is not None]
        if len(given) != 1:
            raise ValueError(f"{' and '.join(given) or 'no path'} given: give one of gcode, [curve] and [helix]")
        if self.material != "E" and self.gcode is None:
            raise refusal("material", "is for G-code; a path in numbers lays material on all of it")
        if self.axes is not None and np.abs(np.array(self.axes) @ np.transpose(self.axes) - np.eye(2)).max() > 1e-6:
            raise refusal("axes", "must be two unit vectors at right angles, as [1, 0, 0] and [0, 0, 1]")
        for key, steps in (("schedule", self.schedule), ("stages", self.stages)):
            for low, high in pairwise(step.z for step in steps):
                if not low < high:
                    raise refusal(key, f"heights must rise; {high:g} m follows {low:g} m")
        if self.heights is not None and not self.heights[0] < self.heights[1]:
            raise refusal("heights", "the second must be over the first")
        if self.heights is not None and self.stages:
            raise refusal("heights", "is for jobs without stages: give one of both")
        return self

    def allowed_error(self, width: float) -> float:
        """Return the expected error that is allowed, m, for a bead of that *width*, m."""
        return 0.5 * width if self.max_error is None else self.max_error

    def allowed_seam(self, width: float) -> float:
        """Return the distance that is allowed between the prints of two stages, m, for a bead of that *width*, m."""
        return self.allowed_error(width) if self.max_seam is None else self.max_seam

    @property
    def path(self) -> Path | RandomCurve | Helix:
        """The G-code file or the computed path of the job."""
        return next(given for given in (self.gcode, self.curve, self.helix) if given is not None)

    @property
    def source(self) -> str:
        """Name of the path: the G-code file's name, or the title of the computed path."""
        return self.path.name if isinstance(self.path, Path) else self.path.title

    @property
    def move_name(self) -> str:
        """Word for a move of the toolpath in reports."""
        return "piece" if self.gcode is None else "G-code line"

    def toolpath(self, progress: Progress | None = None) -> Toolpath:
        """Read the G-code, with arcs cut by `sampling`, or compute the path.

        Raises `InputError`, also for a job with stages, whose moves are of several robots.
        """
        if self.stages:
            raise InputError(
                f"job {self.name}: has stages, which check, print and stages take; for other commands give the job of "
                "one stage, with its heights and without stages, and a robot with the exit points of that stage"
            )
        if isinstance(self.path, Path):
            step = max((self.sampling.step or DEFAULT_STEP) / self.scale, SHORTEST_ARC_STEP)
            error = max(self.sampling.arc_error / self.scale, SMALLEST_ARC_ERROR)
            found = parse(self.path, step, progress, arc_error=error, material=self.material)
        else:
            found = self.path.toolpath()
        found = found if self.axes is None else found.along(*self.axes)
        if self.heights is None:
            return found
        try:
            first, last = (found.first_at((each - self.origin[2]) / self.scale) for each in self.heights)
        except InputError as error:
            raise InputError(f"{self.source}: {error}") from None
        part = found.part(first, last)
        if not part.extruding.any():
            low, high = self.heights
            raise InputError(f"job {self.name}: heights = [{low:g}, {high:g}]: {self.source} lays nothing there")
        return part

    def beads(self, toolpath: Toolpath, given: Bead | None = None) -> Beads:
        """Return the beads of the moves of the *toolpath*: *given*, or else those of the job file, or of the G-code."""
        if toolpath.whole is not None:
            first, end = toolpath.first, toolpath.first + len(toolpath.end)
            below = self.samples(toolpath.whole.part(0, first)) if first else None
            return self.beads(toolpath.whole, given).part(first, end, below)
        by, bead = ("as given", given) if given is not None else ("by the job file", self.bead)
        own = given is not None or "bead" in self.model_fields_set
        if self.gcode is not None:
            return beads_of(toolpath, self.scale, bead if own else None, by)
        return beads_of(toolpath, self.scale, Bead(**bead.model_dump()), by if own else ASSUMED)

    def with_corners(self, beads: Beads) -> Job:
        """Return the job with a corner deviation: its own, or else by the typical width of its *beads*."""
        if self.motion.corner_deviation is not None:
            return self
        corner = float(np.clip(CORNER * beads.typical.width, 1e-6, self.motion.corner))
        return self.model_copy(update={"motion": self.motion.model_copy(update={"corner_deviation": corner})})

    def typical_bead(self, toolpath: Toolpath | None = None) -> tuple[Bead, tuple[str, ...]]:
        """Return the median bead of the laid moves, and notes on how those of the file differ.

        *toolpath*: toolpath of the job; None: the G-code is read if the job states no beads.
        """
        if self.gcode is None or self.bead.model_fields_set == Bead.model_fields.keys():
            return self.bead, ()
        beads = self.beads(toolpath or self.toolpath())
        return beads.typical, beads.differing

    def samples(
        self, toolpath: Toolpath, step: float = DEFAULT_STEP, room: Room = MEMORY, beads: Beads | None = None
    ) -> Samples:
        """Sample the toolpath in machine coordinates, by the step of `sampling` or else *step*, m.

        *room*: folder for the samples. *beads*: beads of the moves, which a limit of flow needs; None: they are found.
        Raises `InputError`.
        """
        speeds = self.motion.print_speed, self.motion.travel_speed
        found = sample(toolpath, self.scale, self.origin, self.sampling.step or step, *speeds, room)
        fastest = self.motion.speed == "fastest"
        if not fastest and math.isinf(self.motion.most_flow):
            return found
        limits, speed = self.speed_limits(toolpath, beads, fastest=fastest, room=room), room.empty((len(found),))
        for at in blocks(len(found)):
            speed[at] = limits[found.move[at]]
            let_go((found, speed))
        return replace(found, speed_limit=speed)

    def speed_limits(
        self, toolpath: Toolpath, beads: Beads | None = None, *, fastest: bool, room: Room = MEMORY
    ) -> Array:
        """Return the largest speed of each move (k,), m/s, by the feeds of the file, the job's speeds and its flow.

        inf where nothing limits it. *fastest*: without feeds. *beads*: beads of the moves; None: found. *room*:
        folder for the speeds.
        """
        motion, found = self.motion, room.empty((len(toolpath.start),))
        printing = motion.most_speed("print_speed", fastest)
        travelling = motion.most_speed("travel_speed", fastest)
        flows = math.isfinite(motion.most_flow)
        beads = beads or self.beads(toolpath) if flows else None
        for at in blocks(len(found)):
            laid = toolpath.extruding[at]
            limits = np.where(laid, printing, travelling)
            if not fastest:
                np.minimum(limits, toolpath.feed[at] * self.scale, out=limits)
            if beads is not None:
                areas = section(beads.width[at], beads.height[at])
                np.minimum(limits, motion.most_flow / areas, out=limits, where=laid)
            found[at] = limits
            let_go((toolpath, found))
        return found

    def time_law(self, samples: Samples, room: Room = MEMORY) -> TimeLaw:
        """Return the time law of the samples under the limits of motion.

        *room*: folder for it, where jerk has no limit.
        """
        return self.motion.time_law(samples, room)


def load_job(path: str | Path) -> Job:
    """Read a job: a ``.toml`` file, or any other file as G-code printed with the defaults at scale 1.

    ``gcode`` in the TOML file is an absolute path, or one relative to the TOML file that stays within its folder.
    Raises `InputError`, one line with file, key, value and what is allowed.
    """
    path = Path(path)
    if path.suffix.lower() != ".toml":
        return validated(Job, {"name": path.stem, "gcode": path}, path)
    table, _ = read_table(path)
    require_schema(table, path)
    job = validated(Job, table | _located(table, path), path)
    for doubt in doubts(job):
        log.warning("note: %s: %s", path, doubt)
    return job


def doubts(job: Job) -> tuple[str, ...]:
    """Return a sentence on each number of a *job* that is likely in another unit, with that unit."""
    motion, bead = job.motion, job.bead
    speed = "mm/s or mm/min" if max(motion.print_speed, motion.travel_speed) < 500.0 else "mm/min"
    limits = (
        ("motion.print_speed", motion.print_speed, _FAST, "m/s", speed),
        ("motion.travel_speed", motion.travel_speed, _FAST, "m/s", speed),
        ("motion.acceleration", motion.acceleration, _VIOLENT, "m/s^2", "mm/s^2"),
        ("bead.width", bead.width, _WIDE, "m", "mm"),
        ("bead.height", bead.height, _WIDE, "m", "mm"),
        ("max_error", job.max_error or 0.0, 2.0 * _WIDE, "m", "mm"),
        ("motion.jerk", motion.jerk or 0.0, _JERKY, "m/s^3", "mm/s^3"),
        ("motion.corner_deviation", motion.corner, _WIDE, "m", "mm"),
        ("sampling.step", job.sampling.step or 0.0, 2.0 * _WIDE, "m", "mm"),
        ("sampling.arc_error", job.sampling.arc_error, _WIDE, "m", "mm"),
        ("layer_height", getattr(job.path, "layer_height", 0.0), _WIDE, "m", "mm"),
    )
    return tuple(f"{key} = {it:g} {unit}: {it:g} {likely}?" for key, it, most, unit, likely in limits if it > most)


def _located(table: dict[str, Any], path: Path) -> dict[str, Path]:
    """Return the ``gcode`` of the job at ``path``, relative to the working folder; empty if the file is no text."""
    written = table.get("gcode")
    if not isinstance(written, str):
        return {}
    within = Path(os.path.normpath(written))
    if os.pardir in within.parts:
        why = "leaves the folder of the job; a file within it, or a full path, is allowed"
        raise InputError(f"{path}: gcode = {written!r}: {why}")
    place = path.parent / within
    if not is_file(place):
        raise InputError(f"{path}: gcode = {written!r}: no such file")
    return {"gcode": place}
