"""The layout of tags: number, size and position of each, and whether the camera is in the room or on the platform.

A tag's frame: x to the right, y up, and z out of the paper, at its centre. A camera's: x to the right, y down, z ahead.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar, Final, Literal, Self

import numpy as np
from annotated_types import Ge, Le
from pydantic import Field, Strict, model_validator

from cablewright.foundation.arrays import Array
from cablewright.foundation.results import Figure, Result
from cablewright.foundation.toml_input import load_model
from cablewright.foundation.units import Angle, Length, Vec3
from cablewright.foundation.validation import Description, FileDescription, refusal
from cablewright.robot.direction import Direction, facing

NUMBERS: Final = 587
"""The number of tags of the family 36h11."""

MODULES: Final = 8
"""The modules along the black square of a tag, of which the outer ones are black; a white one is around it."""

_Sigma = Annotated[Length, Ge(0.0), Le(100.0)]
_Turn = Annotated[Angle, Ge(0.0), Le(10.0)]


def _require_across(key: str, normal: Direction, up: Direction) -> None:
    """Raise `refusal` of *key* where two directions are along each other."""
    try:
        facing(normal, up)
    except ValueError:
        raise refusal(key, "is along the normal: give the direction of the tag's top") from None


class Tag(Description):
    """A tag: its ``number`` in the family, the side of its black square, and its position.

    ``on``: the platform or the room: ``at`` is the tag's centre in the frame of the platform, or in the world. Or fixed
    to the exit point of a ``line``: ``at`` is from there to the tag's centre, world. ``normal``: out of the paper;
    ``up``: to its top. ``sigma``, ``turn_sigma``: standard deviations of place and directions.
    """

    number: Annotated[int, Strict(), Ge(0), Le(NUMBERS - 1)]
    size: Annotated[Length, Ge(5e-3), Le(10.0)]
    on: Literal["platform", "room", "exit"] = "platform"
    line: Annotated[str, Field(min_length=1, max_length=64)] | None = None
    at: Vec3
    normal: Direction = (0.0, 0.0, 1.0)
    up: Direction = (0.0, 1.0, 0.0)
    sigma: _Sigma = 1e-3
    turn_sigma: _Turn = 0.02

    @model_validator(mode="after")
    def _has_a_top(self) -> Self:
        _require_across("up", self.normal, self.up)
        if (self.line is not None) != (self.on == "exit"):
            why = (
                "is missing: name the line whose exit point it is at"
                if self.on == "exit"
                else "is for on = 'exit' alone"
            )
            raise refusal("line", why)
        if self.on == "exit" and not self.sigma:
            raise refusal("sigma", "must be over 0 m for on = 'exit': how exactly `at` is known from the exit point on")
        return self

    @property
    def axes(self) -> Array:
        """The rotation (3, 3) of the tag's frame."""
        return np.array(facing(self.normal, self.up)).T

    @property
    def mounted(self) -> bool:
        """Return whether the tag is on the platform."""
        return self.on == "platform"


class TagMount(Description):
    """Rough position of a camera on the platform: ``at``, where it ``looks``, and ``up`` in its picture."""

    at: Vec3 = (0.0, 0.0, 0.0)
    looks: Direction = (0.0, 0.0, -1.0)
    up: Direction = (0.0, 1.0, 0.0)

    @model_validator(mode="after")
    def _has_a_top(self) -> Self:
        _require_across("up", self.looks, self.up)
        return self

    @property
    def rotation(self) -> Array:
        """The rotation (3, 3) of the camera on the platform."""
        return np.array(facing(self.looks, self.up)).T * [-1.0, -1.0, 1.0]


class TagLayout(FileDescription):
    """The layout of all tags. ``camera``: where the camera is; ``mount``: its rough position on the platform.

    ``print_sigma``: standard deviation of the size of the print, over that in the file: one number for all tags.
    """

    camera: Literal["room", "platform"] = "room"
    mount: TagMount = TagMount()
    print_sigma: Annotated[float, Strict(), Ge(0.0), Le(0.5)] = 0.02
    tags: Annotated[tuple[Tag, ...], Field(min_length=1, max_length=200)]

    @model_validator(mode="after")
    def _can_be_told_apart(self) -> Self:
        for number, count in Counter(tag.number for tag in self.tags).items():
            if count > 1:
                raise refusal("tags", f"{count} tags have the number {number}; each needs a number of its own")
        if self.camera == "platform" and all(tag.mounted for tag in self.tags):
            raise refusal("tags", "are all on the platform, as the camera is: put some into the room")
        if self.camera == "room" and not any(tag.mounted for tag in self.tags):
            raise refusal("tags", "are all in the room, as the camera is: put some on the platform")
        return self


def load_layout(path: str | Path) -> TagLayout:
    """Read a layout of tags from a TOML file.

    Raises `InputError` that names file, key, value and the allowed range.
    """
    return load_model(TagLayout, path)


@dataclass(frozen=True, eq=False, repr=False)
class PrintedTags(Result):
    """Pages of tags, ready to print, that were written to files."""

    FIGURES: ClassVar = (
        Figure("tags", "1", "Number of tags.", lambda of: len(of.layout.tags)),
        Figure("pages", "1", "Number of pages."),
        Figure("paper", "", "Size of the paper."),
        Figure("files", "", "Files that were written.", sentences=True),
    )
    HEADLINES: ClassVar = ("tags", "pages")

    layout: TagLayout
    pages: int
    paper: str
    files: tuple[str, ...]
