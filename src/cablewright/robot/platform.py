"""The platform: what the lines carry. A point mass, or a rigid body that may turn."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, Strict, model_validator

from cablewright.errors import UnknownName
from cablewright.robot.description import Description, refusal, require_own_names
from cablewright.robot.inertia import check_inertia
from cablewright.robot.scene import MAX_SHAPES
from cablewright.units import Force3, Inertia3, Length, Mass, Positive, Torque3, Vec3

_ZERO = (0.0, 0.0, 0.0)
_Number = Annotated[float, Strict()]
_OF_A_BODY = ("centre_of_mass", "inertia", "inertia_products", "moment")


class Load(Description):
    """A state of payload: an empty hopper, a full one, wind on the platform. What is None is as the platform's own.

    Fields, units and frames are those of `RigidPlatform`; of a point platform a load may give ``mass`` and ``force``.
    Values replace the platform's, they are not added to them.
    """

    name: Annotated[str, Field(min_length=1, max_length=60)]
    mass: Positive[Mass] | None = None
    centre_of_mass: Vec3 | None = None
    inertia: Inertia3 | None = None
    inertia_products: Inertia3 | None = None
    force: Force3 | None = None
    moment: Torque3 | None = None

    @property
    def changes(self) -> dict[str, Any]:
        """What the load says, by field of the platform."""
        return {key: value for key, value in self if key != "name" and value is not None}


class Box(Description):
    """A part of the platform's body that lines may touch: a box from ``lowest`` to ``highest``, (3,) m, its frame."""

    lowest: Vec3
    highest: Vec3

    @model_validator(mode="after")
    def _has_a_volume(self) -> Self:
        for axis, low, high in zip("xyz", self.lowest, self.highest, strict=True):
            if not low < high:
                raise refusal("highest", f"must be above lowest in {axis}, where they are {high:g} and {low:g} m")
        return self


_Boxes = Annotated[tuple[Box, ...], Field(max_length=MAX_SHAPES)]


class PointPlatform(Description):
    """A mass in which all lines meet: it has three freedoms, its position (m, world).

    ``force``: (3,) N, world, what acts on it besides its weight and the lines. ``boxes``: its body, unrotated.
    """

    kind: Literal["point"] = "point"
    mass: Positive[Mass]
    force: Force3 = _ZERO
    loads: tuple[Load, ...] = ()
    boxes: _Boxes = ()

    @model_validator(mode="after")
    def _loads_fit(self) -> Self:
        _check_names(self.loads)
        for index, load in enumerate(self.loads):
            for key in _OF_A_BODY:
                if key in load.changes:
                    why = "a point platform has none; its loads may give mass and force"
                    raise refusal(key, why, within=("loads", index))
        return self

    @property
    def freedoms(self) -> int:
        """The number n of pose coordinates."""
        return 3

    def under_load(self, name: str) -> PointPlatform:
        """Return the platform with the values of its load ``name`` in place, and no loads. Raises `UnknownName`."""
        return self.model_copy(update=_named(self.loads, name).changes | {"loads": ()})


class Retraction(Description):
    """A platform whose length changes: the platform points of some lines move along it.

    ``length``: m, the one at which the robot's platform points are given; ``least`` and ``most``: m, its range;
    ``direction``: (3,) platform frame, of any length but zero, the way the points move as it grows; ``lines``: the
    names of the lines whose platform points move. At a length l they are at b + (l - length) direction / |direction|.
    """

    length: Positive[Length]
    least: Positive[Length]
    most: Positive[Length]
    direction: tuple[_Number, _Number, _Number] = (0.0, 0.0, 1.0)
    lines: Annotated[tuple[str, ...], Field(min_length=1)]

    @model_validator(mode="after")
    def _hangs_together(self) -> Self:
        if not self.least < self.most:
            raise refusal("most", f"must be above least, {self.least:g} m")
        if not self.least <= self.length <= self.most:
            raise refusal("length", f"must be from least to most, {self.least:g} to {self.most:g} m")
        if self.direction == _ZERO:
            raise refusal("direction", "must not be zero")
        for name in self.lines:
            if self.lines.count(name) > 1:
                raise refusal("lines", f"names {name!r} more than once")
        return self

    @property
    def along(self) -> Vec3:
        """The unit vector of ``direction``."""
        largest = max(abs(number) for number in self.direction)  # divided out: nothing under- or overflows
        x, y, z = (number / largest for number in self.direction)
        size = math.hypot(x, y, z)
        return x / size, y / size, z / size

    def moved(self, point: Vec3, length: float) -> Vec3:
        """Return a platform point (m, platform frame) that moves with the retraction, at another ``length`` (m)."""
        (x, y, z), (dx, dy, dz), by = point, self.along, length - self.length
        return x + by * dx, y + by * dy, z + by * dz


class RigidPlatform(Description):
    """A rigid body: it has six freedoms, the position of its origin (m, world) and its rotation.

    ``centre_of_mass`` and ``nozzle``, the point that prints: (3,) m, platform frame. ``inertia``: (3,) Ixx, Iyy, Izz
    and ``inertia_products``: (3,) Ixy, Ixz, Iyz, kg m^2, the entries of the tensor about the centre of mass along the
    platform's axes, as in a URDF: the products have the sign of the tensor's entries. ``force``: (3,) N, in the
    platform's origin, and ``moment``: (3,) N m about it, both world: what acts on it besides its weight and the lines.
    ``boxes``: its body, which does not move with a retraction.
    """

    kind: Literal["rigid"] = "rigid"
    mass: Positive[Mass]
    centre_of_mass: Vec3 = _ZERO
    inertia: Inertia3 | None = None
    inertia_products: Inertia3 = _ZERO
    nozzle: Vec3 = _ZERO
    force: Force3 = _ZERO
    moment: Torque3 = _ZERO
    loads: tuple[Load, ...] = ()
    retraction: Retraction | None = None
    boxes: _Boxes = ()

    @model_validator(mode="after")
    def _is_a_body(self) -> Self:
        _check_body(self, within=())
        _check_names(self.loads)
        for index, load in enumerate(self.loads):
            _check_body(self.under_load(load.name), within=("loads", index))
        return self

    @property
    def freedoms(self) -> int:
        """The number n of pose coordinates."""
        return 6

    def under_load(self, name: str) -> RigidPlatform:
        """Return the platform with the values of its load ``name`` in place, and no loads. Raises `UnknownName`."""
        return self.model_copy(update=_named(self.loads, name).changes | {"loads": ()})


def _check_body(platform: RigidPlatform, within: tuple[str | int, ...]) -> None:
    if platform.inertia is not None:
        check_inertia(platform.inertia, platform.inertia_products, within)
    elif platform.inertia_products != _ZERO:
        raise refusal("inertia_products", "needs inertia, the moments that go with it", within)


def _check_names(loads: tuple[Load, ...]) -> None:
    if loads:
        require_own_names("loads", (load.name for load in loads))


def _named(loads: tuple[Load, ...], name: str) -> Load:
    for load in loads:
        if load.name == name:
            return load
    raise UnknownName("load", name, (load.name for load in loads))


def _point_unless_said(platform: Any) -> Any:
    """Files from before rigid platforms need not say ``kind``."""
    return {"kind": "point", **platform} if isinstance(platform, dict) else platform


Platform = Annotated[PointPlatform | RigidPlatform, Field(discriminator="kind"), BeforeValidator(_point_unless_said)]
