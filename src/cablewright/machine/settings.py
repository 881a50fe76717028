"""Settings of a machine that its owner knows: winches, platform, room and sensors.

All that estimation and control may use. Properties of a simulation alone, such as errors of the machine as built, are
in `cablewright.machine.simulated.settings`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Literal, Self, TypeVar

from pydantic import Field, create_model, model_validator

from cablewright.foundation.errors import InputError
from cablewright.foundation.units import Length, Positive, Torque
from cablewright.foundation.validation import Description, FileDescription, refusal, require_unique_names
from cablewright.machine.carried_load import Body, Drum
from cablewright.machine.description_sigmas import MachineAccuracy
from cablewright.machine.drives.settings import LOOPBACK, WinchDriveSettings
from cablewright.machine.quantities import Delay, Dense, Factor, Share, Span, Time, Width
from cablewright.machine.sensors import SENSORS
from cablewright.machine.sensors.lidars import LidarName, LidarSettings
from cablewright.machine.sensors.retraction import RetractionDrive
from cablewright.machine.sensors.sensor_declaration import Sensor, SensorSheet
from cablewright.machine.sensors.tensions import LOAD_CELLS, MOTOR_TORQUES, TensionSensor
from cablewright.machine.sensors.yaw_encoder import YAW_ENCODER
from cablewright.printing.beads import Bead

MAX_WALLS: Final = 200

_SheetT = TypeVar("_SheetT", bound=SensorSheet)
_Name = Annotated[str, Field(min_length=1, max_length=100)]
_Place = tuple[Length, Length]
_Kind = Literal["simulated", "canopen", "ethercat"]


class Extrusion(Description):
    """Material of a machine that lays strands instead of powder; the job sets their width and height."""

    density: Dense
    bead: Bead = Bead()


class WinchSettings(Description):
    """Data of each winch: motor, drum, and the cable on it. Speeds and torques are the drum's.

    ``radius_deviation``: standard deviation, m, expected of the radius at which cable leaves from that of its layer (0:
    not known), and ``radius_turns``: turns over which it changes.
    """

    MOVED: ClassVar[Mapping[str, str]] = {
        "radius_walk": "[simulation.winch], and what the filter expects of it is winch.radius_deviation: both",
        "walk_turns": "[simulation.winch], and what the filter expects of it is winch.radius_turns: both",
        "sideways_walk": "[simulation.winch]",
    }

    max_speed: Factor
    max_torque: Positive[Torque]
    lag: Delay
    ratio: Factor
    counts: Annotated[int, Field(strict=True, ge=1, le=10_000_000)]
    held: Span
    capacity: Annotated[Length, Field(gt=0.0, le=10_000.0)]
    width: Span
    pitch: Span
    radius_deviation: Annotated[Width, Field(le=1.0)] = 0.0
    radius_turns: Annotated[Factor, Field(ge=0.01)] = 10.0

    @model_validator(mode="after")
    def _cable_fits(self) -> Self:
        if self.held > self.capacity:
            raise refusal("held", f"must be at most capacity, {self.capacity:g} m")
        return self


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
    """Walls and ceiling that lidars see, as surveyed.

    ``deviation``: standard deviation, m, of each end of a wall from where it was surveyed, across the wall.
    """

    MOVED: ClassVar[Mapping[str, str]] = {"cell": "[simulation.room]"}

    ceiling: Span
    deviation: Annotated[Width, Field(le=1.0)] = 0.0
    walls: Annotated[tuple[WallFace, ...], Field(max_length=MAX_WALLS)]

    @model_validator(mode="after")
    def _walls_have_names(self) -> Self:
        if self.walls:
            require_unique_names("walls", (wall.name for wall in self.walls))
        return self


class ClockSettings(Description):
    """Owner's settings of the clock on the platform, which stamps readings over the wireless link.

    ``offset``: standard deviation, s, of its difference from the machine's at the start; ``drift``: standard deviation
    of the rate of that difference. ``latency``: s, the shortest time that a reading takes. ``age``: s, how old the
    youngest one of a step may be beyond that; None: as the step is long.
    """

    offset: Annotated[Delay, Field(le=10.0)] = 0.0
    drift: Annotated[Share, Field(le=0.01)] = 0.0
    latency: Annotated[Delay, Field(le=10.0)] = 0.0
    age: Annotated[Delay, Field(le=10.0)] | None = None


class _BeforeSensors(FileDescription):
    """What a machine file says before its sensors."""

    name: _Name
    robot: _Name | None = None
    kind: _Kind = "simulated"
    period: Time
    drum: Drum | None = None
    body: Body | None = None
    retraction: RetractionDrive | None = None
    accuracy: MachineAccuracy | None = None
    extrusion: Extrusion | None = None
    winch: WinchSettings
    room: RoomSettings
    clock: ClockSettings | None = None
    lidars: dict[LidarName, LidarSettings] = Field(default_factory=dict)


if TYPE_CHECKING:
    _WithSensors = _BeforeSensors
else:
    _WithSensors = create_model(
        "_WithSensors",
        __base__=_BeforeSensors,
        **{each.table: (each.sheet | None, None) for each in SENSORS if each.table not in _BeforeSensors.model_fields},
    )


class MachineSettings(_WithSensors):
    """A machine as its owner knows it. ``period``: s, of one step of its control.

    ``robot``: name of the only robot that it is a machine of; None: any. ``kind``: what it runs on. Lines carry
    either a ``drum``, below a point platform, or a ``body``.
    """

    MOVED: ClassVar[Mapping[str, str]] = {
        **dict.fromkeys(("substep", "quasi_static_period"), "[simulation]"),
        **{key: f"[simulation.{key}]" for key in ("tolerances", "line", "climate", "wifi", "wire")},
        "faults": "[[simulation.faults]]",
    }

    drives: WinchDriveSettings | None = None

    def sensor(self, kind: Sensor[_SheetT]) -> _SheetT | None:
        """Return the data sheet of a sensor, ``settings.sensor(SWIVELS)``; None: the machine has none."""
        found: _SheetT | None = getattr(self, kind.table)
        return found

    @property
    def tension_sensor(self) -> Sensor[TensionSensor] | None:
        """The sensor of tensions: load cells if there are any, or else motor torques; None if there are neither."""
        return next((each for each in (LOAD_CELLS, MOTOR_TORQUES) if self.sensor(each) is not None), None)

    @property
    def sheets(self) -> dict[str, SensorSheet]:
        """The data sheets of all its sensors that are read at a rate, by source."""
        found = {each.source: self.sensor(each) for each in SENSORS}
        return {source: sheet for source, sheet in found.items() if sheet is not None}

    @model_validator(mode="after")
    def _kind_fits(self) -> Self:
        real, drives = self.kind != "simulated", self.drives
        if real and drives is None:
            raise refusal("drives", f'must be given where kind is "{self.kind}"')
        if not real and drives is not None:
            raise refusal("kind", 'must be "canopen" or "ethercat" where there is a table [drives]')
        if real and self.drum is not None and self.drum.yaw_drive is not None:
            raise refusal(
                "yaw_drive", f'must be left out where kind is "{self.kind}": [drives] has no axis for it', ("drum",)
            )
        if real and self.retraction is not None:
            why = f'must be left out where kind is "{self.kind}": [drives] has no axis for it'
            raise refusal("retraction", f"{why}, and the platform keeps its platform.retraction.length")
        if drives is not None and self.kind == "canopen" and not drives.channel:
            raise refusal("channel", "must be given on CAN", ("drives",))
        if drives is not None and self.kind == "ethercat" and drives.interface == LOOPBACK:
            raise refusal("interface", "must be a network interface: loopback is CAN's", ("drives",))
        return self

    @model_validator(mode="after")
    def _carries_one(self) -> Self:
        if self.drum is None and self.body is None:
            raise refusal("drum", "must be given, or [body] for a rigid platform")
        if self.drum is not None and self.body is not None:
            raise refusal("body", "must be left out where there is a [drum]: a platform is a point or a body")
        if self.sensor(YAW_ENCODER) is not None and (self.drum is None or self.drum.yaw_drive is None):
            raise refusal("yaw_encoder", "needs drum.yaw_drive, whose angle it measures")
        if self.retraction is not None and self.body is None:
            raise refusal("retraction", "needs [body]: a point platform has no length")
        return self

    @property
    def carrier(self) -> Drum | Body:
        """Load on the lines: the hanging container or the body."""
        carrier = self.body if self.drum is None else self.drum
        assert carrier is not None  # one of both is given
        return carrier

    @property
    def point_drum(self) -> Drum:
        """The container below a point platform. Raises `InputError` for a machine with a body."""
        if self.drum is None:
            raise InputError(f"machine {self.name!r}: has a rigid platform ([body]); one with a [drum] is needed here")
        return self.drum

    def with_carrier(self, **changes: Any) -> Self:
        """Return the settings with other values of some fields of the container or body, which are not checked."""
        key = "drum" if self.body is None else "body"
        return self.model_copy(update={key: self.carrier.model_copy(update=changes)})


def extruding(settings: MachineSettings, bead: Bead, speed: float) -> MachineSettings:
    """Return the settings of a machine that extrudes strands of size *bead* at *speed* (m/s) with the valve open.

    Those of a machine that pours powder are returned unchanged.
    """
    if settings.extrusion is None:
        return settings
    extrusion = settings.extrusion.model_copy(update={"bead": bead})
    made = settings.with_carrier(flow=extrusion.density * bead.section * speed)
    return made.model_copy(update={"extrusion": extrusion})


def require_robot(settings: MachineSettings, robot: str) -> None:
    """Raise `InputError` if a machine's settings are not for the robot called *robot*."""
    if settings.robot not in (None, robot):
        why = f"but the robot is {robot!r}; leave the key out if the machine is one for any robot"
        raise InputError(f"machine {settings.name!r}: robot = {settings.robot!r}, {why}")
