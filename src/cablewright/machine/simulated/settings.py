"""Settings of a simulated machine alone: the table ``[simulation]`` of its file.

Tolerances of the machine as built, laws of the plant, flaws of single sensors, links and planned faults. Nothing of it
is for estimation, control or plans, which see `cablewright.machine.settings` alone; an import contract enforces that.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, Self, TypeVar, get_args

from pydantic import Field, create_model, model_validator

from cablewright.foundation.choices import SeverityName
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.signals import READINGS, per_line
from cablewright.foundation.units import Angle, Duration, Length, NonNegative, Positive
from cablewright.foundation.validation import Description, refusal, validated
from cablewright.machine.files import machine_table
from cablewright.machine.quantities import Delay, Factor, Share, Size, Span, Time, Times, Width, require_pairs_rise
from cablewright.machine.sensors import SENSORS
from cablewright.machine.sensors.lidars import LidarName
from cablewright.machine.sensors.sensor_declaration import SensorSheet
from cablewright.machine.settings import MAX_WALLS, MachineSettings
from cablewright.machine.simulated.sensors import SIMULATED
from cablewright.machine.simulated.sensors.timed_sensor import SensorFlaws, Simulated
from cablewright.machine.simulated.severity_tables import filled
from cablewright.machine.simulated.unmodelled.effect_sizes import (
    CableStretch,
    ExitMounts,
    HangingHose,
    PeoplePushing,
    SheaveFriction,
    StickingMaterial,
    WinchBrakes,
    WinchGears,
    Wind,
)

MAX_FAULTS: Final = 1000

_RATED: Final = [each.sensor.source for each in SIMULATED]

BY_LINE: Final = (
    *(source.name for kind in READINGS if per_line(kind) for source in kind.SOURCES if source.name in _RATED),
    "line",
)
"""Sources with a number for each line, of which one alone may have a fault."""

SHIFTS: Final = {
    kind: tuple(other.sensor.source for other in SIMULATED if kind in other.faults)
    for each in SIMULATED
    for kind in each.faults
}
"""Kinds of faults that shift the numbers of a reading, and the sources that have them."""

FAULT_KINDS: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {"silent": (), "stuck": (), **SHIFTS, "broken": ("line",), "off_sheave": ("line",)}
)
"""Kinds of faults, and the sources that alone can have them; none: any sensor."""

_SIZED: Final = (*SHIFTS, "off_sheave")
_SheetT = TypeVar("_SheetT", bound=SensorSheet)
_FlawsT = TypeVar("_FlawsT", bound=SensorFlaws)
_Jump = Annotated[Duration, Field(ge=-1e6, le=1e6)]
_Names = Annotated[tuple[str, ...], Field(max_length=MAX_WALLS)]

if TYPE_CHECKING:
    _FaultSource = str
    _FaultKind = str
else:
    _FaultSource = Literal[(*get_args(LidarName), *_RATED, "line")]
    _FaultKind = Literal[tuple(FAULT_KINDS)]


class Tolerances(Description):
    """Standard deviations of the true machine from its description; ``modulus``: largest relative error.

    ``wall``: m, of each end of a wall, across it. ``mount_place``, m, and ``mount_turn``, rad: of each sensor's
    mounting, along and about each axis of the drum. ``clock_offset``, s, and ``clock_drift``, a share: of the clock on
    the drum and its rate. ``line_angle_bias``: rad, of each line accelerometer's zero. ``tension_gain``: relative error
    of the scale of each load cell or torque; ``tension_drift``: drift of a zero after an hour, as a share of the
    sensor's range. ``mass``: relative error of the masses of the empty drum and of its powder. ``home_length``: m,
    largest error of each line's length when the machine starts. ``drum_radius``: largest relative error of each winch
    drum's radius.
    """

    anchor: Width
    sheave_radius: Width
    modulus: Annotated[float, Field(ge=0.0, lt=1.0)]
    wall: Annotated[Width, Field(le=1.0)] = 0.0
    mount_place: Annotated[Width, Field(le=1.0)] = 0.0
    mount_turn: Annotated[NonNegative[Angle], Field(le=0.5)] = 0.0
    clock_offset: Annotated[Delay, Field(le=10.0)] = 0.0
    clock_drift: Annotated[Share, Field(le=0.01)] = 0.0
    line_angle_bias: Annotated[NonNegative[Angle], Field(le=0.5)] = 0.0
    tension_gain: Annotated[Share, Field(le=0.2)] = 0.0
    tension_drift: Share = 0.0
    mass: Annotated[Share, Field(le=0.2)] = 0.0
    home_length: Annotated[Width, Field(le=1.0)] = 0.0
    drum_radius: Annotated[Share, Field(le=0.2)] = 0.0


class DrumMotion(Description):
    """Resistance to the hanging container's motion and the twist of its lines; dampings in N m s/rad."""

    swing_damping: Size
    yaw_stiffness: Size
    yaw_damping: Size
    yaw_wander: NonNegative[Angle]
    yaw_wander_length: Span
    drag: Size


class BodyMotion(Description):
    """Resistance to a body's motion. ``drag``: N s/m on its origin's speed; ``turn_damping``: N m s on its rate."""

    drag: Size = 0.0
    turn_damping: Size = 0.0


class Winding(Description):
    """How irregularly the cable lies on the winches' drums.

    ``slide``: share of the wound or paid-out length by which cable slides out, at the reference load. ``crossing``: of
    the cable's diameter, by which it is lifted where it crosses the turn below it, once a turn of each layer but the
    first, within ``crossing_angle`` of the drum.
    """

    radius_walk: Width
    walk_turns: Factor
    sideways_walk: Width
    slide: Annotated[Share, Field(le=0.1)] = 0.0
    crossing: Share = 0.0
    crossing_angle: Annotated[Positive[Angle], Field(le=math.tau)] = math.radians(60.0)


class LineMotion(Description):
    """Relaxation and vibration of the simulated lines."""

    relaxation: Delay
    vibration: Width
    vibration_damping: Annotated[float, Field(gt=0.0, lt=1.0)]


class ClimateLaw(Description):
    """Temperature and humidity of the room over a day."""

    temperature: float
    swing: Size
    humidity: Share
    humidity_swing: Share


class RoomLaw(Description):
    """True properties of the room.

    ``cell``: m, of the grid on which material lies. ``glass`` and ``dark``: names of faces of the room. A ray that
    meets glass passes with the chance ``glass_share``, to a face 3 m behind; one that meets a dark face has no echo
    with the chance ``dark_share``.
    """

    cell: Annotated[Length, Field(ge=1e-3, le=1.0)] = 0.02
    glass: _Names = ()
    glass_share: Share = 0.5
    dark: _Names = ()
    dark_share: Share = 0.5


class People(Description):
    """People in the room: the ``share`` of the time in which one walks there."""

    share: Share = 0.0


class DrumClockLaw(Description):
    """Jumps of the platform's clock: time and size of each, s."""

    jumps: Annotated[tuple[tuple[Delay, _Jump], ...], Field(max_length=MAX_FAULTS)] = ()

    @model_validator(mode="after")
    def _jumps_follow(self) -> Self:
        times = [time for time, _ in self.jumps]
        if times != sorted(times):
            raise refusal("jumps", "must be in the order of their times")
        return self


class Link(Description):
    """Delay of readings, s: ``latency`` plus an exponentially distributed one of mean ``jitter``; ``loss``: lost share.

    ``gaps``: start and end, s, of times without connection; readings sent then arrive at the end. Besides, there are
    gaps at random: of ``gap_length``, s, and ``gap_every``, s, is the mean time from the end of one to the next (0:
    none).
    """

    latency: Delay = 0.0
    jitter: Delay = 0.0
    loss: Share = 0.0
    gaps: Times = ()
    gap_every: Delay = 0.0
    gap_length: Delay = 0.0

    @model_validator(mode="after")
    def _hangs_together(self) -> Self:
        require_pairs_rise("gaps", self.gaps)
        if 0.0 < self.gap_every < 1.0:
            raise refusal("gap_every", "must be 0 (no gaps), or at least 1 s")
        return self


class LidarFlaws(SensorFlaws):
    """Flaws of a lidar's rays. ``bias``: standard deviation, m, of the unit's bias; None: as on the data sheet.

    ``ghosts``: share of rays whose echo took a detour, so that their range is too long.
    """

    bias: Width | None = None
    ghosts: Share = 0.0


class FaultPlan(Description):
    """A planned fault: a source, or one line's part of it, is silent or stuck from ``begin`` to ``end``.

    ``size`` is of a ``slip``: m of cable that an encoder counts too much; of an ``offset``: N that a tension sensor
    shows too much. The source ``line`` is the line itself, for good: it is ``broken``, or ``off_sheave``: the cable
    lies nearer to the sheave's axle by ``size``, m, or is held lower than in its eyelet by ``size``.
    """

    source: _FaultSource
    line: str | None = None
    kind: _FaultKind = "silent"
    begin: Delay = 0.0
    end: Time = 1e9
    size: Annotated[float, Field(ge=-1e6, le=1e6)] | None = None

    @model_validator(mode="after")
    def _hangs_together(self) -> Self:
        if self.line is not None and self.source not in BY_LINE:
            raise refusal("line", f"is for {', '.join(BY_LINE)}; {self.source} is not of a line")
        if not self.begin < self.end:
            raise refusal("end", f"must be after begin, {self.begin:g} s")
        sources = FAULT_KINDS[self.kind]
        if sources and self.source not in sources:
            raise refusal("kind", f"{self.kind!r} is for {', '.join(sources)}, not for {self.source}")
        if not sources and self.source == "line":
            raise refusal("kind", "of a line must be 'broken' or 'off_sheave'")
        if self.line is None and self.kind == "slip":
            raise refusal("line", "must be given: the name of the line whose encoder slips")
        if self.source == "encoders" and self.line is not None and self.kind == "silent":
            raise refusal("line", "is for encoders that slip or are stuck; all of them are silent together")
        if self.source == "line" and self.line is None:
            raise refusal("line", "must be given: the name of the line")
        if (self.size is not None) != (self.kind in _SIZED) and not (self.size is None and self.kind == "off_sheave"):
            raise refusal("size", f"is for {', '.join(_SIZED)}, and must then be given")
        if self.kind == "off_sheave" and self.size is not None and not self.size > 0.0:
            raise refusal("size", "must be above 0 m")
        return self


class _BeforeSensors(Description):
    """What a table ``[simulation]`` says before its sensors."""

    severity: SeverityName = "ideal"
    substep: Time
    quasi_static_period: Time
    tolerances: Tolerances
    drum: DrumMotion | None = None
    body: BodyMotion | None = None
    winch: Winding
    line: LineMotion
    climate: ClimateLaw
    room: RoomLaw = RoomLaw()
    people: People = People()
    clock: DrumClockLaw = DrumClockLaw()
    cable: CableStretch = CableStretch()
    sheaves: SheaveFriction = SheaveFriction()
    exits: ExitMounts = ExitMounts()
    gears: WinchGears = WinchGears()
    brakes: WinchBrakes = WinchBrakes()
    sticking: StickingMaterial = StickingMaterial()
    wind: Wind = Wind()
    hose: HangingHose | None = None
    pushes: PeoplePushing = PeoplePushing()
    wifi: Link = Link()
    wire: Link = Link()
    lidars: dict[LidarName, LidarFlaws] = Field(default_factory=dict)


if TYPE_CHECKING:
    _WithSensors = _BeforeSensors
else:
    _WithSensors = create_model(
        "_WithSensors",
        __base__=_BeforeSensors,
        **{
            each.sensor.table: (each.flaws, each.flaws())
            for each in sorted(SIMULATED, key=lambda each: each.place or each.sensor.stream)
        },
    )


class SimulationSettings(_WithSensors):
    """All settings that only a simulation has.

    ``substep``: s, of the dynamic plant within a step of the machine. ``quasi_static_period``: length of a step of the
    quasi-static plant, s. ``severity``: size of the values of keys that are not given, see `severity_tables`.
    """

    faults: Annotated[tuple[FaultPlan, ...], Field(max_length=MAX_FAULTS)] = ()

    def flaws(self, kind: Simulated[_SheetT, _FlawsT]) -> _FlawsT:
        """Return the flaws of a sensor: ``simulation.flaws(swivels.SIMULATED)``."""
        found: _FlawsT = getattr(self, kind.sensor.table)
        return found

    @model_validator(mode="before")
    @classmethod
    def _fill_by_severity(cls, data: Any) -> Any:
        return filled(data) if isinstance(data, dict) else data


class MachineFile(MachineSettings):
    """A whole machine file: the owner's settings, and those of the simulation alone."""

    simulation: SimulationSettings | None = None

    @model_validator(mode="after")
    def _flaws_are_of_sensors(self) -> Self:
        if self.simulation is None:
            return self
        own, other = ("drum", "body") if self.body is None else ("body", "drum")
        if getattr(self.simulation, own) is None:
            raise refusal(own, f"must be given: how the [{own}] moves", ("simulation",))
        if getattr(self.simulation, other) is not None:
            raise refusal(other, f"the machine has none: no [{other}]", ("simulation",))
        for sensor in SENSORS:
            key = sensor.table
            if key in self.simulation.model_fields_set and self.sensor(sensor) is None:
                raise refusal(key, f"the machine has no such sensor: no [{key}]", ("simulation",))
        for name in self.simulation.lidars:
            if name not in self.lidars:
                raise refusal(name, f"the machine has no such lidar: no [lidars.{name}]", ("simulation", "lidars"))
        faces = {wall.name for wall in self.room.walls}
        for key in ("glass", "dark"):
            for name in getattr(self.simulation.room, key):
                if name not in faces:
                    raise refusal(key, f"the room has no wall {name!r}", ("simulation", "room"))
        return self


class TwinSettings(Description):
    """A machine that can be simulated: the settings of its ``owner``, and those of its ``simulation`` alone."""

    owner: MachineSettings
    simulation: SimulationSettings

    def with_owner(self, **changes: Any) -> Self:
        """Return the machine with other values of some fields of ``owner``, which are not checked."""
        return self.model_copy(update={"owner": self.owner.model_copy(update=changes)})

    def with_simulation(self, **changes: Any) -> Self:
        """Return the machine with other values of some fields of ``simulation``, which are not checked."""
        return self.model_copy(update={"simulation": self.simulation.model_copy(update=changes)})


def load_twin(name_or_path: str | Path) -> TwinSettings:
    """Return the simulated machine of that library name or TOML file, with its table ``[simulation]``.

    Raises `InputError`, one line; also for a file without that table, which cannot be simulated.
    """
    return twin_of_table(*machine_table(name_or_path))


def twin_of_table(table: dict[str, Any], origin: str) -> TwinSettings:
    """Return the machine of the *table* of a machine file, see `load_twin`; *origin*: its name in messages."""
    simulation = validated(MachineFile, table, origin).simulation
    if simulation is None:
        known = "`cablewright machines NAME` prints one that has it"
        raise InputError(
            f"{origin}: no table [simulation], without which a machine cannot be simulated: add it; {known}"
        )
    del table["simulation"]
    return TwinSettings(owner=validated(MachineSettings, table, origin), simulation=simulation)


def whole_machine(machine: TwinSettings | str | Path) -> TwinSettings:
    """Return the settings of a machine with its simulation. *machine* is these settings, a library name or a TOML file.

    Raises `InputError`.
    """
    if isinstance(machine, TwinSettings):
        return machine
    if isinstance(machine, MachineSettings):
        why = "load_machine returns the owner's settings; load_twin returns these and those of the simulation"
        raise InputError(f"machine {machine.name!r}: {why}")
    return load_twin(machine)


def check_faults(settings: TwinSettings, lines: tuple[str, ...], winches: tuple[str, ...]) -> None:
    """Raise `UnknownName` where a planned fault names a line or a sensor that robot and machine do not have."""
    own = settings.owner
    sources = {*own.lidars, *own.sheets, "line"}
    for fault in settings.simulation.faults:
        if fault.source not in sources:
            raise UnknownName("sensor to have a fault", fault.source, sorted(sources))
        known = winches if fault.source == "encoders" else lines
        if fault.line is not None and fault.line not in known:
            raise UnknownName("line", fault.line, known)
