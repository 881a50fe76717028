"""The platform that the lines carry: a point mass, or a rigid body."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from cablewright.foundation.errors import UnknownName
from cablewright.foundation.units import Force3, Inertia3, Length, Mass, Positive, Torque3, Vec3
from cablewright.foundation.validation import Description, KeyPath, refusal, require_box, require_unique_names
from cablewright.robot.direction import Direction, unit_vector
from cablewright.robot.dynamics import check_inertia
from cablewright.robot.plane import Plane
from cablewright.robot.scene import MAX_SHAPES

_ZERO = (0.0, 0.0, 0.0)
_OF_A_BODY = ("centre_of_mass", "inertia", "inertia_products", "moment")


class Load(Description):
    """A load of the platform, such as an empty hopper, a full one, or wind.

    Fields, units and frames are those of `RigidPlatform`; a load of a point platform has ``mass`` and ``force`` only. A
    given value replaces that of the platform; None keeps it.
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
        """Values that this load replaces, by the name of the platform's field."""
        return {key: value for key, value in self if key != "name" and value is not None}


class Box(Description):
    """A part of the platform's body that lines may touch: from ``lowest`` to ``highest``, (3,) m, platform frame."""

    lowest: Vec3
    highest: Vec3

    @model_validator(mode="after")
    def _has_a_volume(self) -> Self:
        require_box("lowest", self.lowest, "highest", self.highest)
        return self


class _PlatformWithLoads(Description):
    """What both kinds of platform have in common."""

    freedoms: ClassVar[int]
    noun: ClassVar[str]  # the type in words
    pose_sizes: ClassVar[str]  # how many numbers a place or pose may have
    pose_units: ClassVar[str]
    motion_pattern: ClassVar[str]  # its translations and rotations

    mass: Positive[Mass]
    force: Force3 = _ZERO
    loads: tuple[Load, ...] = ()
    boxes: Annotated[tuple[Box, ...], Field(max_length=MAX_SHAPES)] = ()
    plane: Plane | None = None

    @property
    def words(self) -> str:
        """The type of the platform in words, and its plane."""
        return self.noun if self.plane is None else f"{self.noun} in the plane {self.plane}"

    @property
    def guidance(self) -> str:
        """A sentence on the motion that its plane allows; empty without a plane."""
        if self.plane is None:
            return ""
        how = "holds it both ways" if self.plane.pulls else "only pushes"
        return f" It stays in the plane {self.plane}, which {how}, without friction."

    @property
    def in_tilted_plane(self) -> bool:
        """Whether the platform has a plane that is not perpendicular to an axis of the world."""
        return self.plane is not None and self.plane.axis is None

    @property
    def fixed(self) -> dict[int, float]:
        """The coordinate, m, that the plane fixes, by its axis; empty without a plane across an axis."""
        if self.plane is None or self.plane.axis is None:
            return {}
        return {self.plane.axis: self.plane.distance * self.plane.across[self.plane.axis]}

    @property
    def lays_along(self) -> Vec3:
        """The unit vector from a strand to the nozzle, world: up, or out of a board, on which it lies."""
        board = self.plane if self.may_lift else None
        return (0.0, 0.0, 1.0) if board is None else board.across

    @property
    def may_lift(self) -> bool:
        """Whether the platform has a plane that only pushes, off which lines may lift it."""
        return self.plane is not None and not self.plane.pulls

    @model_validator(mode="after")
    def _loads_have_unique_names(self) -> Self:
        require_unique_names("loads", (load.name for load in self.loads))
        return self

    def under_load(self, name: str) -> Self:
        """Return the platform with the values of its load ``name``, and no loads. Raises `UnknownName`."""
        for load in self.loads:
            if load.name == name:
                return self.model_copy(update=load.changes | {"loads": ()})
        raise UnknownName("load", name, (load.name for load in self.loads))


class PointPlatform(_PlatformWithLoads):
    """A mass at the point where all lines meet: it has three degrees of freedom, its position (m, world).

    ``force``: (3,) N, world, on the platform besides its weight and the lines. ``boxes``: its body, unrotated. With a
    ``plane`` it has the two degrees of freedom in it.
    """

    freedoms: ClassVar[int] = 3
    noun: ClassVar[str] = "point mass"
    pose_sizes: ClassVar[str] = "3"
    pose_units: ClassVar[str] = "m"
    motion_pattern: ClassVar[str] = "3T"
    drawing: ClassVar[str] = "The platform is a point mass: the ball has no size of its own."
    own_nozzle: ClassVar[None] = None  # it prints where it is

    kind: Literal["point"] = "point"
    # What only a body can be given is, of a point, that of a body all of which is at its origin.
    centre_of_mass: ClassVar[Vec3] = _ZERO
    nozzle: ClassVar[Vec3] = _ZERO
    moment: ClassVar[Torque3] = _ZERO
    inertia: ClassVar[None] = None
    inertia_products: ClassVar[Inertia3] = _ZERO
    has_inertia: ClassVar[bool] = True  # a mass is all that a point has

    @property
    def assumption(self) -> str:
        """Assumption of the model on this platform, in words."""
        return f"The platform is a point: all lines meet in it, and it has no tilt.{self.guidance}"

    @model_validator(mode="after")
    def _loads_fit(self) -> Self:
        for index, load in enumerate(self.loads):
            for key in _OF_A_BODY:
                if key in load.changes:
                    why = "a point platform has none; its loads may give mass and force"
                    raise refusal(key, why, within=("loads", index))
        return self


class Retraction(Description):
    """A platform whose length changes: the platform points of some lines move along it.

    ``length``: m, at which the robot's platform points are given; ``least`` and ``most``: m, its range; ``direction``:
    (3,) platform frame, not zero, in which the points move as it grows; ``lines``: names of the lines whose platform
    points b move. At a length l they are at b + (l - length) direction / |direction|.
    """

    length: Positive[Length]
    least: Positive[Length]
    most: Positive[Length]
    direction: Direction = (0.0, 0.0, 1.0)
    lines: Annotated[tuple[str, ...], Field(min_length=1)]

    @model_validator(mode="after")
    def _hangs_together(self) -> Self:
        if not self.least < self.most:
            raise refusal("most", f"must be above least, {self.least:g} m")
        if not self.least <= self.length <= self.most:
            raise refusal("length", f"must be from least to most, {self.least:g} to {self.most:g} m")
        for name in self.lines:
            if self.lines.count(name) > 1:
                raise refusal("lines", f"names {name!r} more than once")
        return self

    @property
    def along(self) -> Vec3:
        """Unit vector along which the platform retracts."""
        return unit_vector(self.direction)

    def moved(self, point: Vec3, length: float) -> Vec3:
        """Return a platform point (m, platform frame) that moves with the retraction, at another ``length`` (m)."""
        (x, y, z), (dx, dy, dz), by = point, self.along, length - self.length
        return x + by * dx, y + by * dy, z + by * dz


class RigidPlatform(_PlatformWithLoads):
    """A rigid body: it has six degrees of freedom, the position of its origin (m, world) and its rotation.

    ``centre_of_mass`` and ``nozzle``, the point that prints: (3,) m, platform frame. ``inertia``: (3,) Ixx, Iyy, Izz
    and ``inertia_products``: (3,) Ixy, Ixz, Iyz, kg m^2, the entries of the tensor about the centre of mass along the
    platform's axes, with the tensor's signs, as in a URDF. ``force``: (3,) N, at the platform's origin, and ``moment``:
    (3,) N m about it, both world: on the platform besides its weight and the lines. ``boxes``: its body, which does not
    move with a retraction. With a ``plane`` it has three degrees of freedom: its origin stays in it, and it rotates
    about the normal.
    """

    freedoms: ClassVar[int] = 6
    noun: ClassVar[str] = "rigid body"
    pose_sizes: ClassVar[str] = "3 or 6"
    pose_units: ClassVar[str] = "m and rad"
    motion_pattern: ClassVar[str] = "3R3T"

    kind: Literal["rigid"] = "rigid"
    centre_of_mass: Vec3 = _ZERO
    inertia: Inertia3 | None = None
    inertia_products: Inertia3 = _ZERO
    nozzle: Vec3 = _ZERO
    moment: Torque3 = _ZERO
    retraction: Retraction | None = None

    @property
    def assumption(self) -> str:
        """Assumption of the model on this platform, in words."""
        centre, nozzle = (", ".join(f"{x:g}" for x in point) for point in (self.centre_of_mass, self.nozzle))
        return (
            f"The platform is a rigid body: its centre of mass is at ({centre}) m and its nozzle at ({nozzle}) m from "
            f"its origin. Retraction moves platform points, not masses.{self.guidance}"
        )

    @property
    def drawing(self) -> str:
        """Limitation of pictures of the platform, in words; empty if there is none."""
        joined = "The robot file has no boxes of the platform: its platform points are joined by their convex hull."
        return "" if self.boxes else joined

    @property
    def own_nozzle(self) -> Vec3:
        """Position of the nozzle, m, in the platform's frame."""
        return self.nozzle

    @property
    def has_inertia(self) -> bool:
        """Whether the inertia is known."""
        return self.inertia is not None

    @model_validator(mode="after")
    def _is_a_body(self) -> Self:
        _check_inertia(self, within=())
        for index, load in enumerate(self.loads):
            _check_inertia(self.under_load(load.name), within=("loads", index))
        return self


def _check_inertia(platform: RigidPlatform, within: KeyPath) -> None:
    if platform.inertia is not None:
        check_inertia(platform.inertia, platform.inertia_products, within)
    elif platform.inertia_products != _ZERO:
        raise refusal("inertia_products", "needs inertia, the moments that go with it", within)


def _point_by_default(platform: Any) -> Any:
    """A platform without ``kind`` is a point: files older than rigid platforms have none."""
    return {"kind": "point", **platform} if isinstance(platform, dict) else platform


Platform = Annotated[PointPlatform | RigidPlatform, Field(discriminator="kind"), BeforeValidator(_point_by_default)]
