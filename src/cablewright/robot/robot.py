"""The description of a cable robot."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, product
from typing import TYPE_CHECKING, Annotated, Any, Final, Self

from pydantic import Field, model_validator

from cablewright.foundation.errors import InputError, UnknownName, suggestion
from cablewright.foundation.validation import FileDescription, KeyPath, refusal, require_unique_names, validated
from cablewright.robot.bracket import Bracket
from cablewright.robot.cable import Cable
from cablewright.robot.cable_table import CABLES
from cablewright.robot.dynamics import Damping, Dynamics
from cablewright.robot.line import MAX_LINES, Line
from cablewright.robot.parameter_values import with_exit_point
from cablewright.robot.plane import OFF_PLANE
from cablewright.robot.platform import Platform, PointPlatform, Retraction, RigidPlatform
from cablewright.robot.scene import Scene
from cablewright.robot.sheave import Eyelet, Sheave
from cablewright.robot.uncertainty import Range, Uncertainty, modulus_ranges
from cablewright.robot.winch import SharedWinch, Winch

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

_POINTS: Final = ("exit_points", "platform_points")  # of all lines, in arrays


class Robot(FileDescription):
    """m lines, one platform with n degrees of freedom, and the scene. ``source``: paper or origin of the numbers.

    ``dynamics``: how vibrations decay. ``bracket``: the bracket that holds each sheave; None: unknown. ``uncertainty``:
    how far the true numbers may be from these; None: unknown.
    """

    name: Annotated[str, Field(min_length=1, max_length=100)]
    description: str = ""
    source: str = ""
    scene: Scene
    platform: Platform
    lines: Annotated[tuple[Line, ...], Field(max_length=MAX_LINES)]
    dynamics: Dynamics = Dynamics()
    bracket: Bracket | None = None
    uncertainty: Uncertainty | None = None

    @model_validator(mode="after")
    def _parts_fit(self) -> Self:
        if not self.lines:  # not by min_length, which also reports an error where every line has its own
            raise refusal("lines", "must have at least 1 entry")
        require_unique_names("lines", (line.name for line in self.lines))
        points = {line.platform_point for line in self.lines}
        if isinstance(self.platform, RigidPlatform):
            if len(points) == 1 and len(self.lines) > 1:
                raise refusal("lines", 'all platform points coincide: that is a point platform, kind = "point"')
            self._check_lines_differ()
        elif len(points) > 1:
            why = (
                'all lines of a point platform must have one platform_point; a platform that rotates has kind = "rigid"'
            )
            raise refusal("lines", why)
        self._check_plane()
        self._check_counterweights()
        self._check_shared_winches()
        names = [line.name for line in self.lines]
        if self.uncertainty is not None:
            try:
                self.uncertainty.ranges(self)
            except InputError as error:
                raise refusal("uncertainty", str(error)) from None
        for name in () if self.retraction is None else self.retraction.lines:
            if name not in names:
                why = f"no line is named {name!r}; {suggestion(name, names)}"
                raise refusal("lines", why, within=("platform", "retraction"))
        return self

    def _check_lines_differ(self) -> None:
        for one, other in combinations(self.lines, 2):  # a common platform point is allowed: NIST RoboCrane
            if (one.exit_point, one.platform_point) == (other.exit_point, other.platform_point):
                why = f"lines {one.name!r} and {other.name!r} are one line: same exit_point and platform_point"
                raise refusal("lines", why)

    def _check_counterweights(self) -> None:
        if len(self.hung) == self.m:
            raise refusal("lines", "must have at least one with a winch; all have a counterweight")
        for index, line in enumerate(self.lines):
            if line.counterweight is None:
                continue
            held = line.counterweight * self.scene.gravity / line.cables
            low, high = line.tension_limits
            if not low <= held <= high or held == 0.0:
                why = f"holds a cable with {held:g} N, which must be within its tension_limits, {low:g} to {high:g} N"
                raise refusal("counterweight", why, within=("lines", index))

    def _check_shared_winches(self) -> None:
        lines = {line.name: line for line in self.lines}
        for index, line in enumerate(self.lines):
            shared = line.shared_winch
            if shared is None:
                continue
            why = _why_not_shared(line, shared, lines)
            if why:
                raise refusal("shared_winch", why, within=("lines", index))

    def _check_plane(self) -> None:
        plane = self.platform.plane
        if plane is None:
            return
        heights = [
            plane.height(corner) for corner in product(*zip(self.scene.frame_min, self.scene.frame_max, strict=True))
        ]
        if min(heights) > OFF_PLANE or max(heights) < -OFF_PLANE:
            why = f"the plane {plane} misses the frame, the allowed box of the platform's origin"
            raise refusal("distance", why, within=("platform", "plane"))

    @classmethod
    def from_points(
        cls,
        exit_points: ArrayLike,
        platform_points: ArrayLike | None = None,
        *,
        mass: float | str,
        cable: Cable | str,
        tension_limits: tuple[float | str, float | str],
        name: str = "robot",
        sheave: Sheave | None = None,
        frame: ArrayLike | None = None,
        **platform: object,
    ) -> Robot:
        """Return a robot of m lines, each from an exit point to a platform point.

        *exit_points* (m, 3), m, world. *platform_points* (m, 3), m, platform frame: those of a rigid platform; None: a
        point, where all cables meet. *mass*: kg. *cable*: a `Cable`, or the name of one that can be bought, such as
        dyneema-2mm. *tension_limits*: min and max, N. *sheave*: sheave of all lines, by default an eyelet. *frame* (2,
        3): lowest and highest corner, m, of the box in which the platform may be; by default from the lowest exit
        point, or the floor z = 0 where all are at one height, to the highest. *platform*: further fields of
        `PointPlatform` or `RigidPlatform`, such as inertia. Numbers are SI, or texts with a unit. Raises `InputError`
        in one line.

        Examples
        --------
        >>> import cablewright as cw
        >>> corners = [[-2, -2, 3], [2, -2, 3], [2, 2, 3], [-2, 2, 3]]
        >>> cw.Robot.from_points(corners, mass=5.0, cable="dyneema-2mm", tension_limits=(1.0, 500.0))
        Robot('robot', 4 lines, point platform of 5 kg)
        """
        exits = _rows(name, "exit_points", exit_points)
        points = None if platform_points is None else _rows(name, "platform_points", platform_points, len(exits))
        if isinstance(cable, str):
            if cable not in CABLES:
                raise UnknownName("cable", cable, CABLES)
            cable = CABLES[cable].cable
        kind = PointPlatform if points is None else RigidPlatform
        unknown = sorted(platform.keys() - kind.model_fields.keys())
        if unknown:
            raise UnknownName("field of the platform", unknown[0], kind.model_fields)
        common = {"cable": cable, "sheave": sheave or Eyelet(), "tension_limits": _listed(tension_limits)}
        ends = [{"name": str(k + 1), "exit_point": at} | common for k, at in enumerate(exits)]
        for end, point in zip(ends, points or (), strict=False):
            end["platform_point"] = point
        if frame is None:
            low, high = ([side(axis) for axis in zip(*exits, strict=True)] for side in (min, max))
            low[2] = 0.0 if low[2] == high[2] > 0.0 else low[2]
        else:
            low, high = _rows(name, "frame", frame, 2)
        parts = {
            "name": name,
            "scene": {"frame_min": low, "frame_max": high},
            "platform": {"kind": kind.model_fields["kind"].default, "mass": _listed(mass)}
            | {key: _listed(value) for key, value in platform.items()},
            "lines": ends,
        }
        return validated(Robot, parts, f"robot {name!r}")

    def with_(self, **changes: object) -> Robot:
        """Return the robot with *changes*, checked as a file is.

        A name is a field of the robot (``name``, ``lines``, ``dynamics``), of its platform (``mass``, ``inertia``), of
        its scene (``gravity``, ``frame_max``), of all its lines (``sheave``, ``tension_limits``) or of all their cables
        (``axial_stiffness``), whichever has it first; or ``exit_points`` or ``platform_points`` (m, 3), m, of the lines
        in their order. A modelled winch exit moves along with its exit point. Numbers are SI, or texts with a unit.
        `changed` sets single numbers and design variables. Raises `InputError`; of an unknown name with the nearest.

        Examples
        --------
        >>> import cablewright as cw
        >>> cw.load("house-printer").with_(mass="80 kg", tension_limits=(50.0, 5000.0)).platform.mass
        80.0
        """
        lines = list(self.lines)
        for key in _POINTS:
            if key in changes:
                rows = _rows(self.name, key, changes[key], self.m)
                put = with_exit_point if key == "exit_points" else _with_platform_point
                lines = [put(line, at) for line, at in zip(lines, rows, strict=True)]
        values = self.model_copy(update={"lines": tuple(lines)}).model_dump(by_alias=True)
        every = values["lines"]
        places = (
            (Robot, [values]),
            (type(self.platform), [values["platform"]]),
            (Scene, [values["scene"]]),
            (Line, every),
            (Cable, [line["cable"] for line in every]),
        )
        within = {Line: ("lines",), Cable: ("lines", "cable"), Scene: ("scene",), type(self.platform): ("platform",)}
        for key in sorted(changes):
            kind, owners = next((each for each in places if key in each[0].model_fields), (Line, []))
            if key not in _POINTS and (not owners or key == "schema_version"):
                known = (name for kind, _ in places for name in kind.model_fields)
                raise UnknownName("change", key, {*_POINTS, *known})
            for whole in within.get(kind, ()):
                if whole in changes:
                    raise InputError(f"robot {self.name!r}: {whole} and {key}, which is part of it: give one of them")
            for part in owners:
                part[key] = _listed(changes[key])

        def locate(path: KeyPath) -> tuple[KeyPath, str]:
            """Leave out which of the lines, where the same is set in all."""
            return path[2:] if path[:1] == ("lines",) and changes.keys() & {*path} else path, ""

        return validated(Robot, values, f"robot {self.name!r}", locate)

    def __repr_args__(self) -> Iterator[tuple[str | None, Any]]:
        """The name, the number of lines and the platform, because a description fills screens."""
        yield None, self.name
        yield None, _Plain(f"{self.m} line{'s' if self.m > 1 else ''}")
        yield None, _Plain(f"{self.platform.kind} platform of {self.platform.mass:g} kg")

    def __str__(self) -> str:
        return repr(self)

    @property
    def exit_points(self) -> NDArray[Any]:
        """The exit points (m, 3), m, world."""
        return self._points("exit_point")

    @property
    def platform_points(self) -> NDArray[Any]:
        """The platform points (m, 3), m, platform frame."""
        return self._points("platform_point")

    def _points(self, key: str) -> NDArray[Any]:
        import numpy as np  # a description alone costs no NumPy

        return np.array([getattr(line, key) for line in self.lines], dtype=np.float64)

    @property
    def m(self) -> int:
        """The number of lines."""
        return len(self.lines)

    @property
    def n(self) -> int:
        """The number of pose coordinates: 3 of a point, 6 of a body."""
        return self.platform.freedoms

    @property
    def freedoms(self) -> int:
        """The number of directions in which the platform is free: n, or in a plane 2 of a point and 3 of a body."""
        return self.n if self.platform.plane is None else {3: 2, 6: 3}[self.n]

    @property
    def arm(self) -> float:
        """Arm of the farthest platform point about the platform's origin, m; 0 of a point, which does not turn."""
        return 0.0 if self.n == 3 else max(math.hypot(*line.platform_point) for line in self.lines)

    @property
    def winches(self) -> int:
        """The number of winches: m, less the lines on the drum of another and those with a counterweight."""
        return len(self.hosts)

    @property
    def hung(self) -> tuple[int, ...]:
        """The indices of the lines that a counterweight pulls."""
        return tuple(index for index, line in enumerate(self.lines) if line.counterweight is not None)

    @property
    def hosts(self) -> tuple[int, ...]:
        """The indices of the lines with a winch of their own: one for each winch, in their order."""
        return tuple(i for i, x in enumerate(self.lines) if x.counterweight is None and x.shared_winch is None)

    @property
    def winch_lines(self) -> tuple[Line, ...]:
        """Indices of the lines with a winch of their own."""
        return tuple(self.lines[i] for i in self.hosts)

    @property
    def winch_names(self) -> tuple[str, ...]:
        """The names of the winches: each is that of its line."""
        return tuple(line.name for line in self.winch_lines)

    @property
    def sharing(self) -> tuple[Line, ...]:
        """Indices of the lines whose cable is on the winch drum of another line."""
        return tuple(line for line in self.lines if line.shared_winch is not None)

    @property
    def is_plainly_driven(self) -> bool:
        """Whether no plane guides the platform, each line has its own winch, and the winches hold all coordinates."""
        own = not self.sharing and not self.hung and self.platform.plane is None
        return own and self.winches >= self.freedoms

    @property
    def meets_in_nozzle(self) -> bool:
        """Whether the lines of a point platform meet in its nozzle."""
        return self.n == 3 and not any(self.lines[0].platform_point)

    @property
    def has_plain_belts(self) -> bool:
        """Whether all lines lead straight from their exit points, without pulleys or guides."""
        return all(line.advantage == 1 and not line.guides for line in self.lines)

    @property
    def retraction(self) -> Retraction | None:
        """The platform's retraction, if it has one."""
        return self.platform.retraction if isinstance(self.platform, RigidPlatform) else None

    @property
    def damping(self) -> Damping:
        """Share of critical damping of every mode of the platform, and whether it is assumed."""
        return self.dynamics.damping

    def ranges(self) -> tuple[Range, ...]:
        """Return the ranges of the file's uncertainty, or else those of `modulus_ranges`."""
        return modulus_ranges(self) if self.uncertainty is None else self.uncertainty.of(self)

    def under_load(self, name: str) -> Robot:
        """Return the robot with the values of its platform's load ``name``, and no loads. Raises `UnknownName`."""
        return self.model_copy(update={"platform": self.platform.under_load(name)})

    def under_wrench(self, force: Sequence[float], moment: Sequence[float] = (0.0, 0.0, 0.0)) -> Robot:
        """Return the robot with *force* (N) and *moment* (N m, about the origin), world, as those of the platform.

        Raises `InputError` unless each is three finite numbers, and for a moment on a point platform.
        """
        changes = {"force": _three("force", force)}
        about_origin = _three("moment", moment)
        if self.n == 6:
            changes["moment"] = about_origin
        elif any(about_origin):
            raise InputError(f"robot {self.name!r}: a point platform takes no moment; got {about_origin} N m")
        return self.with_platform(**changes)

    def with_platform(self, **changes: object) -> Robot:
        """Return the robot with *changes* of its platform's fields, which are not checked."""
        return self.model_copy(update={"platform": self.platform.model_copy(update=changes)})

    def limited(self, tension_limits: tuple[float, float]) -> Robot:
        """Return the robot with *tension_limits*, min and max (N), of every line."""
        lines = tuple(line.model_copy(update={"tension_limits": tension_limits}) for line in self.lines)
        return self.model_copy(update={"lines": lines})

    def with_lines(self, names: Sequence[str]) -> Robot:
        """Return the robot with only the lines that *names* has, in the order of the file.

        Raises `UnknownName`, and `InputError` for a name given twice and for lines that need one that is left out.
        """
        own = [line.name for line in self.lines]
        for name in names:
            if name not in own:
                raise UnknownName("line", name, own)
            if names.count(name) > 1:
                raise InputError(f"lines: {name!r} is named more than once")
        values = self.model_dump(by_alias=True)
        values["lines"] = [line for line in values["lines"] if line["name"] in names]
        return validated(Robot, values, f"robot {self.name!r} with the lines {', '.join(names)}")

    def retraction_to(self, length: float) -> Retraction:
        """Return the platform's retraction. Raises `InputError` without one that has ``length`` (m) in its range."""
        retraction = self.retraction
        if retraction is None:
            raise InputError(f"robot {self.name!r} has no retraction: its platform has one length")
        if not retraction.least <= length <= retraction.most:
            reach = f"{retraction.least:g} to {retraction.most:g} m"
            raise InputError(f"retraction length {length:g} m: the platform of {self.name!r} retracts from {reach}")
        return retraction

    def retracted(self, length: float) -> Robot:
        """Return the robot with its platform, and the platform points that move, at the retraction ``length`` (m).

        Mass, centre of mass and inertia stay. Raises `InputError` as `retraction_to`.
        """
        retraction = self.retraction_to(length)
        lines = tuple(
            line.model_copy(update={"platform_point": retraction.moved(line.platform_point, length)})
            if line.name in retraction.lines
            else line
            for line in self.lines
        )
        changed = retraction.model_copy(update={"length": float(length)})
        platform = self.platform.model_copy(update={"retraction": changed})
        return self.model_copy(update={"platform": platform, "lines": lines})


class _Plain(str):
    """A text without quotation marks in a line about a robot."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


def _with_platform_point(line: Line, point: Sequence[float]) -> Line:
    return line.model_copy(update={"platform_point": tuple(point)})


def _listed(value: Any) -> Any:
    """Return an array or a number of NumPy as lists or a number, all else as it is."""
    return value.tolist() if hasattr(value, "tolist") else value


def _rows(robot: str, key: str, values: Any, count: int | None = None) -> list[Any]:
    """Return points (k, 3) as rows of finite numbers. Raises `InputError`."""
    try:
        rows = [tuple(float(x) for x in row) for row in _listed(values)]
    except (TypeError, ValueError):
        raise InputError(f"robot {robot!r}: {key}: rows of 3 numbers, m, are expected") from None
    wrong = next((row for row in rows if len(row) != 3 or not all(map(math.isfinite, row))), None)
    if wrong is not None or not rows or len(rows) != (count or len(rows)):
        asked = f"{count or 'one or more'} rows of 3 finite numbers, m, are expected"
        got = f"{len(rows)} rows" if wrong is None else f"{wrong}"
        raise InputError(f"robot {robot!r}: {key}: {asked}; got {got}")
    return rows


def _why_not_shared(line: Line, shared: SharedWinch, lines: Mapping[str, Line]) -> str:
    """Return why a line cannot be on the drum that it says, in words; empty if it can."""
    other = lines.get(shared.line)
    if other is None:
        return f"no line is named {shared.line!r}; {suggestion(shared.line, lines)}"
    if line.counterweight is not None:
        return "is not for a line with a counterweight, which has no winch"
    if other.counterweight is not None:
        return f"line {other.name!r} has a counterweight, and no winch"
    if other is line:
        return f"line {line.name!r} is on its own drum without saying so: name another line"
    if other.shared_winch is not None:
        return f"line {other.name!r} is itself on the drum of {other.shared_winch.line!r}: name that one"
    differing = [key for key in Winch.model_fields if getattr(line.winch, key) != getattr(other.winch, key)]
    if differing:
        return f"winch.{differing[0]} differs from that of line {other.name!r}, which is the same drum"
    if line.winch.build_up is not None and (shared.offset or shared.winds == "against"):
        return "both cables leave a drum with a build_up at one radius only if they are as long: offset = 0, along"
    return ""


def _three(what: str, values: Sequence[float]) -> tuple[float, ...]:
    """Return three finite numbers, or raise `InputError`."""
    try:
        parts = tuple(float(value) for value in values)
    except (TypeError, ValueError):
        parts = ()
    if len(parts) != 3 or not all(map(math.isfinite, parts)):
        raise InputError(f"{what} = {values!r}: must be 3 finite numbers")
    return parts
