"""Load of a machine's lines, by its owner: a container that hangs from a point platform (drum), or a rigid body."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, ClassVar, Self

from pydantic import Field, model_validator

from cablewright.foundation.units import Angle, Mass, NonNegative, Positive, Torque, Vec3
from cablewright.foundation.validation import Description, refusal
from cablewright.machine.quantities import Delay, Dense, Factor, Heavy, Span, Width


class _Carrier(Description):
    """What drum and body have in common: their own mass, and the material that they carry and lay.

    Without ``capacity`` nothing is carried: material comes through a hose, without end. ``flow``: kg/s. ``radius``: m,
    of the material, a cylinder.
    """

    OF_POWDER: ClassVar[tuple[str, ...]] = ("powder_density", "radius")

    empty_mass: Heavy
    powder: NonNegative[Mass] = 0.0
    capacity: NonNegative[Mass] = 0.0
    powder_density: Dense = 1500.0
    flow: NonNegative[float]
    radius: Span = 0.1

    @model_validator(mode="after")
    def _powder_fits(self) -> Self:
        if self.powder > self.capacity:
            raise refusal("powder", f"must be at most capacity, {self.capacity:g} kg")
        if self.capacity:
            for key in self.OF_POWDER:
                if key not in self.model_fields_set:
                    raise refusal(key, "must be given where capacity is")
        return self

    @property
    def full_mass(self) -> float:
        """Mass, kg, with all of ``powder``, by weighing."""
        return self.empty_mass + self.powder

    def fill_height(self, powder: float) -> float:
        """Return the height, m, of the given mass of *powder*, kg, in the container."""
        return powder / (self.powder_density * math.pi * self.radius**2)


class YawDrive(Description):
    """A geared drive that turns the container about its axis, against the suspension that the lines carry.

    ``max_speed``, rad/s, and ``max_torque`` are the container's; ``travel``: how far it turns to either side. ``held``:
    yaw of the container that a print holds. It needs no encoder, as lidars measure the yaw, and may have one.
    """

    max_speed: Factor
    max_torque: Positive[Torque]
    lag: Delay = 0.0
    travel: Annotated[Positive[Angle], Field(le=math.tau)] = math.pi / 2.0
    held: Annotated[Angle, Field(ge=-math.pi / 6.0, le=math.pi / 6.0)] = (
        0.0  # beyond, a lidar's walls are behind its mask
    )


class Drum(_Carrier):
    """The container that hangs from the platform point B. Depths are below B, along its axis.

    ``yaw_drive``: None where nothing turns it.
    """

    WORD: ClassVar[str] = "drum"
    MOVED: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("swing_damping", "yaw_stiffness", "yaw_damping", "yaw_wander", "yaw_wander_length", "drag"),
        "[simulation.drum]",
    )
    OF_POWDER: ClassVar[tuple[str, ...]] = ("powder_density", "radius", "powder_bottom")

    powder_bottom: Span = 0.1
    empty_centre: Span
    empty_gyration: tuple[Span, Span, Span]
    valve: Width
    yaw_drive: YawDrive | None = None


class Body(_Carrier):
    """A rigid platform with its material. Its centre of mass, inertia and nozzle are those of the robot's description.

    ``empty_mass``: without material; the described inertia goes with it in proportion. ``hopper``: (3,) m, platform
    frame: middle of the bottom on which the material stands, along the platform's z. ``gyration``: (3,) m, radii of
    gyration about the centre of mass, of a robot that gives no inertia. ``tour``: (3,) m each: positions that the
    nozzle goes through before a print begins, by which its sensors find the lengths of the lines.
    """

    WORD: ClassVar[str] = "platform"
    MOVED: ClassVar[Mapping[str, str]] = dict.fromkeys(("turn_damping", "drag"), "[simulation.body]")
    OF_POWDER: ClassVar[tuple[str, ...]] = ("powder_density", "radius", "hopper")

    hopper: Vec3 = (0.0, 0.0, 0.0)
    gyration: tuple[Span, Span, Span] | None = None
    tour: Annotated[tuple[Vec3, ...], Field(max_length=100)] = ()
