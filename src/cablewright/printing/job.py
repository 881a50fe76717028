"""A job: which path is printed, how large, where on the machine and how fast. TOML in, or a bare G-code file.

Paths are relative to the folder of the TOML file. Lengths and speeds are the machine's, after scaling.
"""

from __future__ import annotations

import math
import os
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Final, Self

from annotated_types import Ge, Le
from pydantic import BaseModel, ConfigDict, Field, model_validator

from cablewright.errors import InputError
from cablewright.printing.gcode import SHORTEST_ARC_STEP, Toolpath, parse
from cablewright.printing.modal import MAX_COORDINATE
from cablewright.printing.numeric_path import Helix, RandomCurve
from cablewright.printing.path import Samples, sample
from cablewright.printing.schedule import ScheduleStep
from cablewright.printing.timing import TimeLaw, time_law
from cablewright.progress import Progress
from cablewright.toml_input import read_table, require_schema, validated
from cablewright.units import Acceleration, Jerk, Length, Speed

NEWEST_SCHEMA: Final = 1

# Wide of any machine, yet no number within can overflow what is computed from it.
_Distance = Annotated[Length, Ge(1e-6), Le(1e3)]
_Speed = Annotated[Speed, Ge(1e-6), Le(1e3)]
_Coordinate = Annotated[Length, Ge(-MAX_COORDINATE), Le(MAX_COORDINATE)]


class _Part(BaseModel):
    """Frozen, comparable, closed to unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, serialize_by_alias=True)


class Bead(_Part):
    """The strand of material as it lies, m."""

    width: _Distance = 0.06
    height: _Distance = 0.02

    @property
    def section(self) -> float:
        """Its section, m^2: the rectangle with round sides."""
        return self.width * self.height - (1.0 - 0.25 * math.pi) * min(self.width, self.height) ** 2


class Motion(_Part):
    """Limits of the nozzle's motion. A move runs at its own feed, times the scale, where that is slower."""

    print_speed: _Speed = 0.3
    travel_speed: _Speed = 0.5
    acceleration: Annotated[Acceleration, Ge(1e-6), Le(1e6)] = 0.5
    corner_deviation: _Distance = 0.005
    """How far beside a corner the arc passes that stands for it; larger is faster. See `printing/timing.py`."""
    jerk: Annotated[Jerk, Ge(1e-6), Le(1e4)] | None = None
    """Bound of the change of acceleration along the path; none when left out."""


class Sampling(_Part):
    """How finely the path is looked at, m."""

    step: _Distance = 0.05


class Job(_Part):
    """A part to print: G-code, or a path in numbers. The defaults suit a house-sized machine."""

    schema_version: Annotated[int, Field(alias="schema", strict=True, ge=1, le=NEWEST_SCHEMA)] = NEWEST_SCHEMA
    name: Annotated[str, Field(min_length=1, max_length=300)]
    robot: Annotated[str, Field(min_length=1, max_length=300)] | None = None
    """The one robot that it is for; any when left out."""
    gcode: Path | None = None
    curve: RandomCurve | None = None
    helix: Helix | None = None
    scale: Annotated[float, Field(strict=True, ge=1e-4, le=1e4)] = 1.0
    origin: tuple[_Coordinate, _Coordinate, _Coordinate] = (0.0, 0.0, 0.0)
    """Where the zero of the scaled path comes to, m, machine."""
    bead: Bead = Bead()
    motion: Motion = Motion()
    sampling: Sampling = Sampling()
    schedule: Annotated[tuple[ScheduleStep, ...], Field(max_length=10_000)] = ()
    """Rotation and retraction of a rigid platform by the nozzle's height, rising."""

    @model_validator(mode="after")
    def _has_one_path(self) -> Self:
        given = [key for key in ("gcode", "curve", "helix") if getattr(self, key) is not None]
        if len(given) != 1:
            raise ValueError(f"{' and '.join(given) or 'no path'} given: one of gcode, [curve] and [helix] is wanted")
        return self

    @model_validator(mode="after")
    def _schedule_rises(self) -> Self:
        heights = [height.z for height in self.schedule]
        for low, high in pairwise(heights):
            if not low < high:
                raise ValueError(f"schedule: heights must rise; {high:g} m follows {low:g} m")
        return self

    @property
    def path(self) -> Path | RandomCurve | Helix:
        """The path that is given."""
        return next(given for given in (self.gcode, self.curve, self.helix) if given is not None)

    @property
    def source(self) -> str:
        """What to call the path: the G-code file's name, or what the job itself describes."""
        return self.path.name if isinstance(self.path, Path) else self.path.title

    @property
    def move_name(self) -> str:
        """What a report calls a move of the toolpath, before its number."""
        return "piece" if self.gcode is None else "G-code line"

    def toolpath(self, progress: Progress | None = None) -> Toolpath:
        """Read the G-code, arcs cut as finely as the samples will be, or make the path. Raises `InputError`."""
        if isinstance(self.path, Path):
            return parse(self.path, max(self.sampling.step / self.scale, SHORTEST_ARC_STEP), progress)
        return self.path.toolpath()

    def samples(self, toolpath: Toolpath) -> Samples:
        """Sample the toolpath on the machine. Raises `InputError`."""
        motion = self.motion
        step = self.sampling.step
        return sample(toolpath, self.scale, self.origin, step, motion.print_speed, motion.travel_speed)

    def time_law(self, samples: Samples) -> TimeLaw:
        """Time the samples within the limits of the motion."""
        return time_law(samples, self.motion.acceleration, self.motion.corner_deviation, self.motion.jerk)


def load_job(path: str | Path) -> Job:
    """Read a job: a ``.toml`` file, or any other file as G-code printed with the defaults at scale 1.

    ``gcode`` in the TOML file is a full path, or one relative to the TOML file that stays within its folder. Raises
    `InputError`, one line naming file, key, value and what is allowed.
    """
    path = Path(path)
    if path.suffix.lower() != ".toml":
        return validated(Job, {"name": path.stem, "gcode": path}, path)
    table, _ = read_table(path)
    require_schema(table, NEWEST_SCHEMA, path)
    return validated(Job, table | _located(table, path), path)


def _located(table: dict[str, Any], path: Path) -> dict[str, Path]:
    """Return the place of the G-code which the job at ``path`` names, where it names one by a text."""
    written = table.get("gcode")
    if not isinstance(written, str):
        return {}
    within = Path(os.path.normpath(written))
    if os.pardir in within.parts:
        raise InputError(
            f"{path}: gcode = {written!r}: leaves the folder of the job; a file within it, or a full path, is allowed"
        )
    place = path.parent / within
    if not place.is_file():
        raise InputError(f"{path}: gcode = {written!r}: no such file")
    return {"gcode": place}
