"""A robot under a choice of physics, and its equilibria."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import AnswerError, InputError, Status
from cablewright.foundation.results import Result
from cablewright.kernels import batches
from cablewright.kernels.layout import Packed
from cablewright.kernels.statics.inverse import TENSION_TOLERANCE
from cablewright.kernels.statics.line.upright import SLACK_TENSION
from cablewright.models.batch_rows import Rows, by_row, scalar
from cablewright.models.equilibrium_figures import FIGURES
from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
from cablewright.models.pack import pack, pack_rows
from cablewright.models.packed_views import LineNumbers, LineStates, PlatformNumbers
from cablewright.models.plane import basis
from cablewright.models.rotation import placed
from cablewright.models.shared_winches import missed_lengths
from cablewright.robot import Robot

FULL = Fidelity()


@dataclass(frozen=True, repr=False)
class Model:
    """A robot under one fidelity. `tension_limits` (N) replace those of every line where given.

    ``preferred``: (m,) N, to which the tensions of inverse solutions are nearest; None: see `preferred_tensions`.
    """

    robot: Robot
    fidelity: Fidelity = FULL
    tension_limits: tuple[float, float] | None = None
    preferred: tuple[float, ...] | None = None

    @classmethod
    def of(
        cls,
        robot: Robot | Model,
        *,
        cable: CableLaw | str | None = None,
        sheave: SheaveLaw | str | None = None,
        tension_limits: tuple[float, float] | None = None,
        default: CableLaw = CableLaw.CATENARY,
    ) -> Model:
        """Return the model of a robot under the given laws, or a model as it is: the first step of public functions.

        *default*: law of the cables if *cable* is None. Raises `UnknownName` for an unknown law, `InputError` for an
        option that contradicts the model, and for what is neither a robot nor a model.
        """
        if isinstance(robot, Robot):
            return cls(robot, Fidelity.of(default if cable is None else cable, sheave), tension_limits)
        if not isinstance(robot, Model):
            raise InputError(f"robot = {robot!r:.60}: must be a Robot or a Model; `load` reads one from a file")
        has = (robot.fidelity.cable, robot.fidelity.sheave, robot.tension_limits)
        given = (cable, sheave, None if tension_limits is None else _limits(tension_limits))
        Fidelity.of(cable or default, sheave)
        for name, value, own in zip(("cable", "sheave", "tension_limits"), given, has, strict=True):
            if value is not None and value != own:
                raise InputError(
                    f"{name} = {value}: the model has {own or 'none'}; leave {name} out, or pass the robot "
                    "in place of the model"
                )
        return robot

    @classmethod
    def full(cls, robot: Robot | Model, *, tension_limits: tuple[float, float] | None = None) -> Model:
        """Return the model of a robot with all physics. Raises `InputError` for a simplified model."""
        model = cls.of(robot, tension_limits=tension_limits)
        if model.fidelity != FULL:
            raise InputError(f"the model is {model.fidelity}, the machine itself is {FULL}; pass the robot")
        return model

    def __post_init__(self) -> None:
        """Raise `InputError` for tension limits that do not rise."""
        if self.tension_limits is not None:
            object.__setattr__(self, "tension_limits", _limits(self.tension_limits))

    def __repr__(self) -> str:
        """Name and laws, because a description of the robot fills a screen."""
        return f"Model({self.robot.name!r}, {self.fidelity})"

    @cached_property
    def packed(self) -> Packed:
        """The arrays of the model for the kernels, cached: the hash of a robot takes longer than many a solve."""
        return _packed(self)

    @cached_property
    def lines(self) -> LineNumbers:
        """The numbers of the m lines in `packed`, by name."""
        return LineNumbers(self.packed.lines)

    @cached_property
    def massless(self) -> bool:
        """Whether any line has no weight."""
        return bool((self.lines.weight == 0.0).any())

    def rows(
        self,
        *,
        retraction: Array | None = None,
        preferred: Array | None = None,
        exit_points: Array | None = None,
        wrenches: Array | None = None,
    ) -> Packed:
        """Return the arrays of the model for batches, with values that differ by row: see `pack_rows`."""
        return pack_rows(
            self.robot,
            self.packed,
            retraction=retraction,
            preferred=preferred,
            exit_points=exit_points,
            wrenches=wrenches,
        )

    def nozzle(self, poses: Array) -> Array:
        """Return the position (..., 3), m, world, of the point that prints at *poses* (..., n)."""
        return placed(poses, [self.robot.platform.nozzle])[..., 0, :]

    def at_nozzle(self, poses: Array) -> Array:
        """Return the poses (..., n) with the nozzle where the origin is at *poses* (..., n)."""
        moved, arm = np.array(poses), np.array(poses)
        arm[..., :3] = 0.0
        moved[..., :3] -= self.nozzle(arm)
        return moved

    def unrotated_at(self, positions: Array) -> Array:
        """Return the poses (..., n) of the unrotated platform with the nozzle at *positions* (..., 3), m."""
        return self.at_nozzle(np.concatenate([positions, np.zeros_like(positions)], axis=-1)[..., : self.n])

    def refuse_rigid(self) -> None:
        """Raise `InputError` if the cables are rigid: their lengths do not determine tensions and stiffness."""
        if self.fidelity.cable is CableLaw.RIGID:
            raise InputError("cable = rigid: lengths do not determine tensions; use elastic or catenary")

    @property
    def m(self) -> int:
        """The number of lines."""
        return self.robot.m

    @property
    def pushes_point(self) -> bool:
        """Whether a plane that only pushes carries a point."""
        return self.n == 3 and self.robot.platform.may_lift

    @property
    def winches(self) -> int:
        """The number of winches: see `Robot.winches`."""
        return self.robot.winches

    @property
    def freedoms(self) -> int:
        """The number of directions in which the platform is free, at most n."""
        return self.robot.freedoms

    @cached_property
    def free_directions(self) -> Array | None:
        """Orthonormal basis (n, degrees of freedom) of the motions that a plane leaves; None without a plane."""
        plane = self.robot.platform.plane
        return None if plane is None else basis(plane, self.n)

    @property
    def n(self) -> int:
        """The number of coordinates of the platform's pose."""
        return self.robot.n


def _limits(given: Sequence[float]) -> tuple[float, float]:
    """Return two rising numbers, N, or raise `InputError`."""
    try:
        low, high = (float(value) for value in given)
    except (TypeError, ValueError):
        raise InputError(f"tension limits {given!r}: must be two numbers, lowest and highest in N") from None
    if not 0.0 <= low < high < float("inf"):
        raise InputError(f"tension limits {low:g},{high:g}: must be 0 <= lowest < highest, in N")
    return low, high


_ROUNDED: Final = 1e-9  # of the largest limit of a tension: force off a plane that is due to rounding
LIFTS: Final = (
    "above it the platform lifts off its plane: let platform.plane.normal point out of the board, or give one_sided = "
    "false to a plane that holds both ways"
)
"""What a positive force on a plane that only pushes means."""


def lifts(plane_force: Array | float, tension_max: float) -> Mask:
    """Return whether each *plane_force* (...), N, lifts the platform off a plane by more than rounding.

    *tension_max*: N, the largest limit of a tension.
    """
    return np.asarray(np.asarray(plane_force) > _ROUNDED * tension_max)


@lru_cache(maxsize=32)
def _packed(model: Model) -> Packed:
    return pack(model.robot, model.fidelity, model.tension_limits)


@dataclass(frozen=True, eq=False, repr=False)
class Equilibrium(Rows, Result):
    """Pose, lengths and line states of an equilibrium, or a batch of them (see `Rows`).

    A single one has pose (n,), lengths (m,), states (m, 6) and code (); a batch has a leading axis. `packed`: arrays of
    the robot as solved, one row for all or one for each. `violation`: N, by which the tensions of an inverse solution
    exceed their limits; 0 where they hold, and for forward solutions. States are NaN without a solution, and so are
    lengths but for those of rigid lines without levers, which are geometry.
    """

    FIGURES: ClassVar = FIGURES

    model: Model
    packed: Packed
    pose: Array
    lengths: Array
    states: Array
    code: NDArray[np.int64]
    violation: Array
    iterations: NDArray[np.int64]

    def __repr__(self) -> str:
        """Robot, fidelity and status in one line."""
        if self.single:
            outcome = f"{self.status.word}, pose=[{', '.join(f'{x:.6g}' for x in self.pose)}]"
        else:
            outcome = f"{int(self.ok.sum())} of {len(self)} ok"
        return f"Equilibrium({self.model.robot.name!r}, {self.model.fidelity}, {outcome})"

    @property
    def status(self) -> Any:
        """The outcome of the solve: a `Status`, or of a batch a tuple (N) of them."""
        return by_row(Status.of, self.code)

    @property
    def ok(self) -> Any:
        """Whether the equilibrium is solved: a bool, or of a batch a mask (N,)."""
        return scalar(self.code == 0)

    @property
    def holds(self) -> Any:
        """Whether the lines hold the pose: it is solved, and presses on a plane that only pushes. (N,) of a batch."""
        if not self.model.robot.platform.may_lift:
            return self.ok
        return scalar((self.code == 0) & ~lifts(self.plane_force, float(self.lines.tension_max.max())))

    @property
    def judged_code(self) -> NDArray[np.int64]:
        """The code, () or (N,); that of `Status.OUT_OF_LIMITS` where it is solved and not held."""
        return np.where(
            (self.code == 0) & np.logical_not(self.holds), list(Status).index(Status.OUT_OF_LIMITS), self.code
        )

    @property
    def tensions(self) -> Array:
        """Tension at each sheave, N, as a force sensor there measures it; 0 where a massless line is slack."""
        tensions = self.line_states.tension
        return np.where((self.lines.weight == 0.0) & (tensions < 2.0 * SLACK_TENSION), 0.0, tensions)

    @property
    def platform_tensions(self) -> Array:
        """Tension at the platform's end of each line, N."""
        return self._end_tensions(self.line_states.free_angle, self.line_states.free_length)

    @property
    def winch_tensions(self) -> Array:
        """Tension at the winch exit of each line, N; the one at the sheave where the dead span is not modelled."""
        lines, dead = self.lines, self.line_states.dead_length
        in_plane = self._end_tensions(self.line_states.dead_angle, dead)
        at_winch = np.where(lines.in_plane, in_plane, self.tensions + lines.weight * dead * lines.winch_rise)
        return np.where(lines.has_dead_span, at_winch, self.tensions)

    def _end_tensions(self, angles: Array, lengths: Array) -> Array:
        """Return the tension at the far end of spans that leave the sheave at *angles* from the horizontal."""
        vertical = self.tensions * np.sin(angles) + self.lines.weight * lengths
        return np.hypot(self.tensions * np.cos(angles), vertical)

    @property
    def platform_points(self) -> Array:
        """Platform point of each line, world, m: (m, 3), or (N, m, 3) of a batch."""
        return placed(self.pose, self.lines.platform_point)

    @property
    def nozzle(self) -> Array:
        """The point that prints, world, m: (3,), or (N, 3) of a batch."""
        return self.model.nozzle(self.pose)

    @property
    def lines(self) -> LineNumbers:
        """Numbers of the lines as solved, by name: (m,) each, or (1, m) or (N, m) for a batch."""
        return LineNumbers(self.packed.lines[0] if self.single else self.packed.lines)

    @property
    def line_states(self) -> LineStates:
        """`states` by name: (m,) each, or (N, m) for a batch."""
        return LineStates(self.states)

    def extremes(self) -> tuple[Array, Array]:
        """Return the smallest and largest tension along each line, N, each with the shape of `tensions`."""
        _, _, low, high = self._examined
        return low, high

    def residual_norm(self) -> Any:
        """Return the largest residual of any geometric equation, m: a number, or of a batch (N,)."""
        return scalar(self._examined[0])

    def unbalanced_force(self) -> Any:
        """Return the largest unbalanced force on the platform, N: a number, or of a batch (N,)."""
        return scalar(self._examined[1])

    def margin(self) -> Any:
        """Return the min distance of a tension from its limits, N, negative where one is exceeded; (N,) of a batch.

        A tension that misses its limit by no more than solvers leave is at the limit, and has the margin 0.
        """
        low, high = self.extremes()
        slack = np.minimum(low - self.lines.tension_min, self.lines.tension_max - high).min(axis=-1)
        met = (slack < 0.0) & (slack >= -TENSION_TOLERANCE * high.max(axis=-1))
        return scalar(np.where(met, 0.0, slack))

    @property
    def plane_force(self) -> Any:
        """Force of lines and loads on the plane along its normal, N: a number, (N,) of a batch; None without a plane.

        The plane answers with the opposite, and is taken as able to hold both ways. Where the normal points out of a
        board, a negative force presses on it; a positive one lifts off, and needs a guide.
        """
        carried = self._carried
        return None if carried is None else scalar(carried[..., :3] @ PlatformNumbers(self.packed.platform[0]).normal)

    @property
    def plane_moments(self) -> Array | None:
        """Moment of lines and loads on the plane about the platform's origin, N m, world: (3,), or (N, 3) of a batch.

        It has no part along the normal. None of a point, and without a plane.
        """
        carried = self._carried
        if carried is None or self.model.n == 3:
            return None
        normal = PlatformNumbers(self.packed.platform[0]).normal
        moments = carried[..., 3:]
        return np.asarray(moments - (moments @ normal)[..., None] * normal)

    @property
    def _carried(self) -> Array | None:
        """Wrench (..., n) of lines and loads on the platform, as if there were no plane; None if there is none."""
        if self.model.robot.platform.plane is None:
            return None
        free = PlatformNumbers(self.packed.platform.copy())
        free.held = 0.0
        wrenches = np.empty((self.code.size, self.model.n))
        batches.wrench_rows(self.packed._replace(platform=free.array), *self.solved_arrays(), wrenches)
        return wrenches[0] if self.single else wrenches

    def is_valid(self, tolerance: float = 1e-9) -> bool:
        """Return whether all rows are solved with residuals up to *tolerance*: m, and share of the largest force."""
        load = np.maximum(PlatformNumbers(self.packed.platform).weight, self.tensions.max(axis=-1))
        fits = (self.residual_norm() <= tolerance) & (self.unbalanced_force() <= tolerance * load)
        return bool(np.all(self.ok & fits))

    def checked(self) -> Equilibrium:
        """Return the equilibrium itself if every row is solved.

        Raises `AnswerError` with the first failed row's sentence.
        """
        if np.all(self.ok):
            return self
        if self.single:
            raise AnswerError(self.sentence(), self.status)
        bad = np.flatnonzero(self.code)
        raise AnswerError(f"{len(bad)} of {len(self)} rows failed; row {bad[0]}: {self[int(bad[0])].sentence()}")

    def sentence(self) -> str:
        """Return the status of a single solve in one line, with the numbers that explain it, or why it is not held."""
        status = self.status
        if status is Status.OK and not self.holds:
            return f"plane force {self.plane_force:.6g} N; at most 0 N is allowed: {LIFTS}"
        if status in (Status.INFEASIBLE, Status.OVERSTRETCHED):
            return f"{status.value}: {self._worst_line()}"
        return str(status.value)

    def _worst_line(self) -> str:
        """Return the line that exceeds its limit most, and by how much."""
        if self.status is Status.INFEASIBLE and self.violation == 0.0 and self.model.robot.sharing:
            missed = missed_lengths(self.model.robot, self.lengths)
            line = self.model.robot.sharing[int(np.argmax(np.abs(missed)))]
            assert line.shared_winch is not None  # by the definition of `sharing`
            where = f"the length of line {line.name} does not fit the drum that it shares with {line.shared_winch.line}"
            return f"{where}, {np.abs(missed).max():.4g} m off, and these cables do not give"
        low, high = self.extremes()
        if self.status is Status.OVERSTRETCHED:
            over = high - self.lines.breaking_load
            worst = int(np.argmax(over))
            name, limit = self.model.robot.lines[worst].name, self.lines.breaking_load[worst]
            return f"line {name} at {high[worst]:.6g} N, {over[worst]:.4g} N over its {limit:g} N"
        if np.isnan(low).any() and self.model.robot.sharing:
            return f"tensions that fit the winches are {self.violation:.4g} N out of their limits"
        if np.isnan(low).any():
            return f"a line would have to push, {self.violation:.4g} N out of its limits"
        under, over = self.lines.tension_min - low, high - self.lines.tension_max
        worst = int(np.argmax(np.maximum(under, over)))
        name = self.model.robot.lines[worst].name
        low, high = self.lines.tension_limits[worst]
        side = f"below its minimum, {low:g} N" if under[worst] > over[worst] else f"above its maximum, {high:g} N"
        return f"at best line {name} is {self.violation:.4g} N {side}"

    def solved_arrays(self) -> list[Array]:
        """Return lengths, poses and states of all rows for the kernels."""
        arrays = (self.lengths, self.pose, self.states)
        return [np.array(a[None] if self.single else a, order="C") for a in arrays]

    @property
    def _examined(self) -> tuple[Array, Array, Array, Array]:
        rows, m = self.code.size, self.model.m
        residual, force, low, high = np.empty(rows), np.empty(rows), np.empty((rows, m)), np.empty((rows, m))
        batches.examine(self.packed, *self.solved_arrays(), residual, force, low, high)
        if self.single:
            return residual[0], force[0], low[0], high[0]
        return residual, force, low, high
