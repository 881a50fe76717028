"""Settings of a simulated machine: tolerances, drum, winches, room and sensors, in one file."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Annotated, Final, Literal, Self

from pydantic import Field, model_validator

from cablewright.errors import InputError, UnknownName, suggestion
from cablewright.printing.job import Bead
from cablewright.robot import Robot
from cablewright.toml_input import is_file, load_model, parse_table
from cablewright.units import Angle, Density, Duration, Length, Mass, NonNegative, Positive, Torque, Vec3
from cablewright.validation import Description, FileDescription, refusal, require_unique_names, validated

MAX_WALLS: Final = 200
MAX_RAYS: Final = 20_000
MAX_FAULTS: Final = 1000

# Beyond any machine, but so far from the ends of floats that nothing computed from them leaves those.
_Span = Annotated[Length, Field(ge=1e-6, le=1e5)]
_Width = Annotated[Length, Field(ge=0.0, le=1e5)]
_Time = Annotated[Duration, Field(ge=1e-6, le=1e9)]
_Delay = Annotated[Duration, Field(ge=0.0, le=1e9)]
_Heavy = Annotated[Mass, Field(ge=1e-6, le=1e9)]
_Factor = Annotated[float, Field(ge=1e-6, le=1e9)]
_Share = Annotated[float, Field(ge=0.0, le=1.0)]
_Rate = Annotated[float, Field(gt=0.0, le=1e5)]
_Size = Annotated[float, Field(ge=0.0, le=1e6)]
_Axis = tuple[float, float, float]
_Place = tuple[Length, Length]
_LidarName = Literal["north", "south", "vertical"]


def _require_rising(key: str, spans: tuple[tuple[float, float], ...], unit: str = "s") -> None:
    for begin, end in spans:
        if not begin < end:
            raise refusal(key, f"must each rise; {begin:g} to {end:g} {unit} does not")


class Tolerances(Description):
    """Standard deviations of the true machine from its description; ``modulus``: largest relative error."""

    anchor: _Width
    sheave_radius: _Width
    modulus: Annotated[float, Field(ge=0.0, lt=1.0)]


class Drum(Description):
    """The drum that hangs from the platform point B. Depths are below B, along its axis; dampings in N m s/rad.

    Without ``capacity`` it holds no powder: material comes through a hose, without end. ``flow``: kg/s.
    """

    empty_mass: _Heavy
    powder: NonNegative[Mass] = 0.0
    capacity: NonNegative[Mass] = 0.0
    powder_density: Positive[Density] = 1500.0
    flow: NonNegative[float]
    radius: _Span = 0.1
    powder_bottom: _Span = 0.1
    empty_centre: _Span
    empty_gyration: tuple[_Span, _Span, _Span]
    valve: _Span
    swing_damping: _Size
    yaw_stiffness: _Size
    yaw_damping: _Size
    yaw_wander: NonNegative[Angle]
    yaw_wander_length: _Span
    drag: _Size

    @model_validator(mode="after")
    def _powder_fits(self) -> Self:
        if self.powder > self.capacity:
            raise refusal("powder", f"must be at most capacity, {self.capacity:g} kg")
        if self.capacity:
            for key in ("powder_density", "radius", "powder_bottom"):
                if key not in self.model_fields_set:
                    raise refusal(key, "must be given where capacity is")
        return self


class Extrusion(Description):
    """Material of a machine that lays strands instead of powder; the job sets their width and height."""

    density: Positive[Density]
    bead: Bead = Bead()


class WinchSettings(Description):
    """Each winch: motor, drum, and the winding of the cable. Speeds and torques are the drum's."""

    max_speed: _Factor
    max_torque: Positive[Torque]
    lag: _Delay
    ratio: _Factor
    counts: Annotated[int, Field(strict=True, ge=1, le=10_000_000)]
    held: _Span
    capacity: Annotated[Length, Field(gt=0.0, le=10_000.0)]
    width: _Span
    pitch: _Span
    radius_walk: _Width
    walk_turns: _Factor
    sideways_walk: _Width

    @model_validator(mode="after")
    def _cable_fits(self) -> Self:
        if self.held > self.capacity:
            raise refusal("held", f"must be at most capacity, {self.capacity:g} m")
        return self


class LineSettings(Description):
    """Relaxation and vibration of the lines."""

    relaxation: _Delay
    vibration: _Width
    vibration_damping: Annotated[float, Field(gt=0.0, lt=1.0)]


class ClimateLaw(Description):
    """Temperature and humidity of the room over a day."""

    temperature: float
    swing: _Size
    humidity: _Share
    humidity_swing: _Share


class WallFace(Description):
    """A vertical face from the floor to the ceiling, seen from above; m, world."""

    name: Annotated[str, Field(min_length=1, max_length=60)]
    start: Annotated[_Place, Field(alias="from")]
    end: Annotated[_Place, Field(alias="to")]

    @model_validator(mode="after")
    def _has_a_length(self) -> Self:
        if self.start == self.end:
            raise refusal("to", "must differ from from")
        return self


class RoomSettings(Description):
    """Walls and ceiling that lidars see. ``cell``: m, grid of the material on the floor."""

    cell: Annotated[Length, Field(ge=1e-3, le=1.0)] = 0.02
    ceiling: _Span
    walls: Annotated[tuple[WallFace, ...], Field(max_length=MAX_WALLS)]

    @model_validator(mode="after")
    def _walls_have_names(self) -> Self:
        if self.walls:
            require_unique_names("walls", (wall.name for wall in self.walls))
        return self


class Link(Description):
    """Delay of readings, s: ``latency`` plus an exponentially distributed one of mean ``jitter``; ``loss``: lost share.

    ``gaps``: start and end, s, of times without connection; readings sent then arrive at the end.
    """

    latency: _Delay = 0.0
    jitter: _Delay = 0.0
    loss: _Share = 0.0
    gaps: Annotated[tuple[tuple[Duration, Duration], ...], Field(max_length=MAX_FAULTS)] = ()

    @model_validator(mode="after")
    def _gaps_rise(self) -> Self:
        _require_rising("gaps", self.gaps)
        return self


class LidarSettings(Description):
    """A planar lidar on the drum. ``axes``: x and y of its plane in the drum's frame; ``masks``: masked angles, rad."""

    turn: _Time
    rays: Annotated[int, Field(strict=True, ge=8, le=MAX_RAYS)]
    least: _Span
    most: _Span
    deviation: _Width
    resolution: _Span
    bias: _Width
    dropout: _Share = 0.0
    outliers: _Share = 0.0
    place: Vec3
    axes: tuple[_Axis, _Axis]
    masks: Annotated[tuple[tuple[Angle, Angle], ...], Field(max_length=20)] = ()

    @model_validator(mode="after")
    def _hangs_together(self) -> Self:
        x, y = self.axes
        products = (_dot(x, x) - 1.0, _dot(y, y) - 1.0, _dot(x, y))
        if max(map(abs, products)) > 1e-9:
            raise refusal("axes", "must be two unit vectors at right angles")
        if not self.least < self.most:
            raise refusal("most", f"must be above least, {self.least:g} m")
        _require_rising("masks", self.masks, "rad")
        return self


class _TimedSensor(Description):
    """Base of the timed sensors: rate, and shares of lost readings and of outliers."""

    rate: _Rate
    dropout: _Share = 0.0
    outliers: _Share = 0.0


class InertialSensor(_TimedSensor):
    """Accelerometer and gyro. Deviations are of one reading, biases of one unit; m/s^2 and rad/s."""

    place: Vec3
    acceleration_deviation: _Size
    acceleration_bias: _Size
    rate_deviation: _Size
    rate_bias: _Size


class LineSensor(_TimedSensor):
    """Accelerometers on the lines, ``from_platform`` along the cable before B."""

    from_platform: _Width
    deviation: NonNegative[Angle]


class DistanceSensor(_TimedSensor):
    """Distance from the valve along the drum's axis."""

    least: _Width
    most: _Span
    deviation: _Width


class Encoder(_TimedSensor):
    """Encoders; an outlier is one counter with one bit flipped."""


class ClimateSensor(Description):
    """Temperature and relative humidity."""

    rate: _Rate
    temperature_deviation: _Size
    humidity_deviation: _Share
    dropout: _Share = 0.0
    outliers: _Share = 0.0


class BarrierSensor(_TimedSensor):
    """The light barrier. ``intrusions``: start and end of interruptions; an outlier is the opposite state."""

    intrusions: Annotated[tuple[tuple[Duration, Duration], ...], Field(max_length=MAX_FAULTS)] = ()

    @model_validator(mode="after")
    def _intrusions_rise(self) -> Self:
        _require_rising("intrusions", self.intrusions)
        return self


TimedSettings = InertialSensor | LineSensor | DistanceSensor | Encoder | ClimateSensor | BarrierSensor
"""Settings of the sensors that are read at a rate."""


class FaultPlan(Description):
    """A planned fault: a source, or one line's accelerometer, is silent or stuck from ``begin`` to ``end``."""

    source: Literal[
        "north", "south", "vertical", "inertial", "line_angles", "distance", "encoders", "climate", "barrier"
    ]
    line: str | None = None
    kind: Literal["silent", "stuck"] = "silent"
    begin: _Delay = 0.0
    end: _Time = 1e9

    @model_validator(mode="after")
    def _hangs_together(self) -> Self:
        if self.line is not None and self.source != "line_angles":
            raise refusal("line", f"is for line_angles; {self.source} is not of a line")
        if not self.begin < self.end:
            raise refusal("end", f"must be after begin, {self.begin:g} s")
        return self


class MachineSettings(FileDescription):
    """All settings. ``period``: s, of one step of the machine; ``substep``: s, of the dynamic plant within it.

    ``robot``: name of the only robot that it is a machine of; None: any.
    """

    name: Annotated[str, Field(min_length=1, max_length=100)]
    robot: Annotated[str, Field(min_length=1, max_length=100)] | None = None
    period: _Time
    substep: _Time
    quasi_static_period: _Time
    tolerances: Tolerances
    drum: Drum
    extrusion: Extrusion | None = None
    winch: WinchSettings
    line: LineSettings
    climate: ClimateLaw
    room: RoomSettings
    wifi: Link = Link()
    wire: Link = Link()
    lidars: dict[_LidarName, LidarSettings] = Field(default_factory=dict)
    inertial: InertialSensor | None = None
    line_angles: LineSensor | None = None
    distance: DistanceSensor | None = None
    encoders: Encoder | None = None
    climate_sensor: ClimateSensor | None = None
    barrier: BarrierSensor | None = None
    faults: Annotated[tuple[FaultPlan, ...], Field(max_length=MAX_FAULTS)] = ()


def load_machine(name_or_path: str | Path) -> MachineSettings:
    """Return the settings of that library name, or of that TOML file. Raises `InputError`, one line."""
    if isinstance(name_or_path, str) and name_or_path in machine_names():
        origin = f"{name_or_path} (library)"
        return validated(MachineSettings, parse_table(machine_text(name_or_path), origin), origin)
    path = Path(name_or_path)
    if not str(name_or_path).endswith(".toml") and not is_file(path):
        hint = suggestion(str(name_or_path), machine_names())
        raise InputError(f"no machine {str(name_or_path)!r} in the library and no file of that name; {hint}")
    return load_model(MachineSettings, path)


def machine_names() -> tuple[str, ...]:
    """Return the names of the machines that come with cablewright, sorted."""
    folder = resources.files("cablewright.machine.simulated") / "library"
    return tuple(sorted(item.name.removesuffix(".toml") for item in folder.iterdir() if item.name.endswith(".toml")))


def machine_text(name: str) -> str:
    """Return the TOML text of a library machine. Raises `UnknownName`."""
    if name not in machine_names():
        raise UnknownName("machine", name, machine_names())
    return resources.files("cablewright.machine.simulated").joinpath("library", f"{name}.toml").read_text("utf-8")


def extruding(settings: MachineSettings, bead: Bead, speed: float) -> MachineSettings:
    """Return the settings of a machine that extrudes *bead* at *speed* (m/s) with the valve open.

    Those of a machine that pours powder are returned unchanged.
    """
    if settings.extrusion is None:
        return settings
    extrusion = settings.extrusion.model_copy(update={"bead": bead})
    drum = settings.drum.model_copy(update={"flow": extrusion.density * bead.section * speed})
    return settings.model_copy(update={"extrusion": extrusion, "drum": drum})


def require_hanging(robot: Robot) -> None:
    """Raise `InputError` for lines that no plant can hang: of several spans, without weight, or without gravity."""
    robot.require_plain("the simulated machine")
    origin = f"robot {robot.name!r}"
    if robot.scene.gravity == 0.0:
        raise InputError(f"{origin}: gravity = 0: a drum that hangs, and powder that falls, need some")
    for line in robot.lines:
        if line.cable.linear_density == 0.0:
            raise InputError(f"{origin}: the cable of line {line.name!r} has no weight, which a plant needs")


def require_robot(settings: MachineSettings, robot: str) -> None:
    """Raise `InputError` where the settings are those of another robot than the one called *robot*."""
    if settings.robot not in (None, robot):
        why = f"but the robot is {robot!r}; leave the key out if the machine is one for any robot"
        raise InputError(f"machine {settings.name!r}: robot = {settings.robot!r}, {why}")


def check_faults(settings: MachineSettings, lines: tuple[str, ...]) -> None:
    """Raise `UnknownName` where a planned fault names a line that the robot does not have."""
    for fault in settings.faults:
        if fault.line is not None and fault.line not in lines:
            raise UnknownName("line", fault.line, lines)


def _dot(a: _Axis, b: _Axis) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
