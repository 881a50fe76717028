"""Data sheets of the planar lidars on the platform."""

from collections.abc import Mapping
from typing import Annotated, ClassVar, Final, Literal, Self

from pydantic import Field, model_validator

from cablewright.foundation.units import Angle, NonNegative, Vec3
from cablewright.foundation.validation import Description, refusal
from cablewright.machine.quantities import Span, Time, Width, require_pairs_rise
from cablewright.machine.sensors.sensor_declaration import moved_flaws

MAX_RAYS: Final = 20_000

LidarName = Literal["north", "south", "vertical"]
_Axis = tuple[float, float, float]


class LidarSettings(Description):
    """Data of a planar lidar on the platform.

    ``axes``: x and y of its plane in the platform's frame; ``masks``: masked angles, rad. ``place_deviation``, m, and
    ``turn_deviation``, rad: standard deviations of its mounting, along and about each axis of the platform.
    """

    MOVED: ClassVar[Mapping[str, str]] = moved_flaws("lidars.NAME")

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


def _dot(a: _Axis, b: _Axis) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
