"""Sensors of a machine as their data sheets and a tape measure have them: where they sit, rates, ranges and noise.

A deviation is the noise of one reading; a bias is constant for one unit, and its number is the standard deviation over
all units of the kind.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Final, Literal, Self

from pydantic import Field, model_validator

from cablewright.machine.carriers import RetractionDrive
from cablewright.machine.quantities import Factor, Rate, Share, Size, Span, Time, Width, require_pairs_rise
from cablewright.units import Angle, NonNegative, Vec3
from cablewright.validation import Description, refusal

MAX_RAYS: Final = 20_000

LidarName = Literal["north", "south", "vertical"]
_Axis = tuple[float, float, float]


def _flaws(table: str) -> dict[str, str]:
    """Where the flaws of one unit, once keys of its *table*, belong now."""
    return dict.fromkeys(("dropout", "outliers"), f"[simulation.{table}]")


class LidarSettings(Description):
    """A planar lidar on the drum. ``axes``: x and y of its plane in the drum's frame; ``masks``: masked angles, rad.

    ``place_deviation``, m, and ``turn_deviation``, rad: standard deviations of where it is mounted, along and about
    each axis of the drum.
    """

    MOVED: ClassVar[Mapping[str, str]] = _flaws("lidars.NAME")

    turn: Time
    rays: Annotated[int, Field(strict=True, ge=8, le=MAX_RAYS)]
    least: Span
    most: Span
    deviation: Width
    resolution: Span
    bias: Width
    place: Vec3
    axes: tuple[_Axis, _Axis]
    place_deviation: Annotated[Width, Field(le=1.0)] = 0.0
    turn_deviation: Annotated[NonNegative[Angle], Field(le=0.5)] = 0.0
    masks: Annotated[tuple[tuple[Angle, Angle], ...], Field(max_length=20)] = ()

    @model_validator(mode="after")
    def _hangs_together(self) -> Self:
        x, y = self.axes
        products = (_dot(x, x) - 1.0, _dot(y, y) - 1.0, _dot(x, y))
        if max(map(abs, products)) > 1e-9:
            raise refusal("axes", "must be two unit vectors at right angles")
        if not self.least < self.most:
            raise refusal("most", f"must be above least, {self.least:g} m")
        require_pairs_rise("masks", self.masks, "rad")
        return self


class InertialSensor(Description):
    """Accelerometer and gyro at ``place``. ``turn_deviation``: rad, of its mounting about each axis."""

    MOVED: ClassVar[Mapping[str, str]] = _flaws("inertial")

    rate: Rate
    place: Vec3
    acceleration_deviation: Size
    acceleration_bias: Size
    rate_deviation: Size
    rate_bias: Size
    turn_deviation: Annotated[NonNegative[Angle], Field(le=0.5)] = 0.0


class LineSensor(Description):
    """Accelerometers on the lines, ``from_platform`` along the cable before B. ``bias``: rad, of each one's zero."""

    MOVED: ClassVar[Mapping[str, str]] = _flaws("line_angles")

    rate: Rate
    from_platform: Width
    deviation: NonNegative[Angle]
    bias: Annotated[NonNegative[Angle], Field(le=0.5)] = 0.0


class DistanceSensor(Description):
    """Distance from the valve along the drum's axis."""

    MOVED: ClassVar[Mapping[str, str]] = _flaws("distance")

    rate: Rate
    least: Width
    most: Span
    deviation: Width


class Encoder(Description):
    """Encoders of the winches' motors."""

    MOVED: ClassVar[Mapping[str, str]] = _flaws("encoders")

    rate: Rate


class ClimateSensor(Description):
    """Temperature and relative humidity."""

    MOVED: ClassVar[Mapping[str, str]] = _flaws("climate_sensor")

    rate: Rate
    temperature_deviation: Size
    humidity_deviation: Share


class BarrierSensor(Description):
    """The light barrier around the machine."""

    MOVED: ClassVar[Mapping[str, str]] = _flaws("barrier") | {"intrusions": "[simulation.barrier]"}

    rate: Rate


class TensionSensor(Description):
    """Tensions at the sheaves, N: by load cells, or by the torques of the motors. ``most``: what one shows at most.

    ``gain_deviation``: standard deviation of each one's scale, as a share.
    """

    rate: Rate
    deviation: Size
    bias: Size = 0.0
    gain_deviation: Share = 0.0
    most: Factor


class SwivelSensor(Description):
    """Angles at which the swivelling sheaves stand, rad. ``bias``: of each one's zero, standard deviation."""

    rate: Rate
    deviation: NonNegative[Angle]
    bias: Annotated[NonNegative[Angle], Field(le=0.5)] = 0.0


TimedSettings = (
    InertialSensor
    | LineSensor
    | DistanceSensor
    | Encoder
    | ClimateSensor
    | BarrierSensor
    | TensionSensor
    | SwivelSensor
    | RetractionDrive
)
"""Data of the sensors that are read at a rate."""


def _dot(a: _Axis, b: _Axis) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
