"""Inverse dynamics: lengths, tensions and winch speeds that move the platform along a trajectory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Unpack

import numpy as np

from cablewright.analyses.jacobian import jacobian
from cablewright.analyses.motion.trajectory import Trajectory
from cablewright.analyses.rigidity import HoldOptions
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.results import Figure, Pictured
from cablewright.models.fidelity import CableLaw
from cablewright.models.inertia import compensates, inertia_wrenches
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse


@dataclass(frozen=True, eq=False, repr=False)
class InverseDynamics(Pictured):
    """Lengths, tensions and winch speeds of lines along a trajectory of k times.

    ``held``: the equilibria of all forces, those of inertia among them, as a batch: ``lengths`` and ``tensions`` (k, m)
    are theirs. ``length_rates`` (k, m): m/s, at which lengths grow, by the Jacobian of straight cables.
    """

    FIGURES: ClassVar = (
        Figure("robot", "", "Name of the robot that moves along the trajectory."),
        Figure("source", "", "Waypoints, spline, or the name of a job.", "trajectory.source"),
        Figure("duration", "s", "Time at the end.", "trajectory.duration", shown="s"),
        Figure("feasible", "", "Whether tensions within the limits move the platform at all times."),
        Figure("first_failure", "s", "First time without such tensions; null: none.", shown="s"),
        Figure("lines", "", "Names of the lines.", name="line", along="line"),
        Figure("min_tension", "N", "Smallest tension at a sheave.", along="line"),
        Figure("max_tension", "N", "Largest tension at a sheave.", along="line"),
        Figure("max_speed", "m/s", "Largest speed of the cable.", along="line"),
        Figure("max_power", "W", "Largest power that all cables of the line give to the platform.", along="line"),
    )
    HEADLINES: ClassVar = ("robot", "source", "duration", "feasible", "first_failure")

    trajectory: Trajectory
    held: Equilibrium
    length_rates: Array

    @property
    def robot(self) -> str:
        """Name of the robot that moves along the trajectory."""
        return self.held.model.robot.name

    @property
    def lines(self) -> tuple[str, ...]:
        """Names of the lines."""
        return tuple(line.name for line in self.held.model.robot.lines)

    @property
    def columns(self) -> dict[str, Array]:
        """Columns (k,) of `to_frame`: the trajectory's, then each line's length, its rate, tension and power."""
        parts = {"length": self.lengths, "rate": self.length_rates, "tension": self.tensions, "power": self.power}
        own = {f"{key}.{name}": values[:, i] for key, values in parts.items() for i, name in enumerate(self.lines)}
        return self.trajectory.columns | own

    @property
    def lengths(self) -> Array:
        """Unstrained lengths (k, m), m."""
        return self.held.lengths

    @property
    def tensions(self) -> Array:
        """Tensions (k, m) at the sheaves, N."""
        return self.held.tensions

    @property
    def power(self) -> Array:
        """Power (k, m) of all cables of a line on the platform, W: tension times the speed of winding in."""
        cables = np.array([line.cables for line in self.held.model.robot.lines], dtype=np.float64)
        return -self.tensions * self.length_rates * cables

    @property
    def feasible(self) -> bool:
        """Whether tensions within the limits move the platform at all times."""
        return bool(np.all(self.held.holds))

    @property
    def first_failure(self) -> float | None:
        """First time without feasible tensions, s; None if there is none."""
        return None if self.feasible else float(self.trajectory.times[~self.held.holds][0])

    @property
    def refusal(self) -> str:
        """Sentence that explains why the trajectory cannot be followed; empty if it can."""
        if self.feasible:
            return ""
        row = int(np.argmin(self.held.holds))
        return f"at {self.trajectory.times[row]:.4g} s: {self.held[row].sentence()}"

    @property
    def min_tension(self) -> Array:
        """Smallest tension (m,) of each line, N."""
        return np.asarray(np.nanmin(self.tensions, axis=0))

    @property
    def max_tension(self) -> Array:
        """Largest tension (m,) of each line, N."""
        return np.asarray(np.nanmax(self.tensions, axis=0))

    @property
    def max_speed(self) -> Array:
        """Largest speed (m,) of each winch's cable, m/s."""
        return np.asarray(np.nanmax(np.abs(self.length_rates), axis=0))

    @property
    def max_power(self) -> Array:
        """Largest power (m,) of each winch, W."""
        return np.asarray(np.nanmax(self.power, axis=0))


def inverse_dynamics(robot: Robot | Model, trajectory: Trajectory, **options: Unpack[HoldOptions]) -> InverseDynamics:
    """Compute lengths, tensions and speeds of the lines that move the platform along a *trajectory*.

    Weight, loads and the forces of inertia of the platform (Newton and Euler) are in balance with the lines at each
    time; cables, sheaves and winches are massless, and nothing swings. *options*: options of `inverse`, which chooses
    the tensions. Where none are within the limits, the answer is no at that time, as for `inverse`. Raises `InputError`
    for a robot with fewer winches than degrees of freedom or with counterweights, for a body that turns and has no
    inertia, and for poses of another number of coordinates.

    Examples
    --------
    >>> import cablewright as cw
    >>> way = cw.Trajectory.through([[0, 0, 3], [2, 1, 5]], speed=1.0, acceleration=2.0)
    >>> cw.inverse_dynamics(cw.load("house-printer"), way).feasible
    True
    """
    if not isinstance(trajectory, Trajectory):
        raise InputError(f"trajectory = {trajectory!r:.60}: a Trajectory is expected; Trajectory.through makes one")
    laws = {key: options.get(key) for key in ("cable", "sheave", "tension_limits")}
    model = Model.of(robot, **laws)  # type: ignore[arg-type]  # of a TypedDict, by key
    if trajectory.poses.shape[1] != model.n:
        width = trajectory.poses.shape[1]
        raise InputError(f"trajectory: its poses have {width} coordinates; those of {model.robot.name} have {model.n}")
    if not compensates(model.robot):
        why = "counterweights" if model.robot.hung else "fewer winches than degrees of freedom"
        raise InputError(f"inverse dynamics: robot {model.robot.name!r} has {why}; not supported. Use simulate")
    turning = trajectory.velocities[:, 3:].any() or trajectory.accelerations[:, 3:].any()
    rates = trajectory.velocities[:, 3:] if turning else None
    wrenches = inertia_wrenches(model.robot, trajectory.poses, trajectory.accelerations, rates)
    drawn, preferred = options.get("retraction"), options.get("preferred")
    held = solve_inverse(model, trajectory.poses, path=True, retraction=drawn, preferred=preferred, wrenches=wrenches)
    straight = Model.of(model.robot, cable=CableLaw.RIGID, sheave=model.fidelity.sheave)
    along = jacobian(straight, trajectory.poses, retraction=drawn)
    return InverseDynamics(trajectory, held, np.einsum("kmn,kn->km", along, trajectory.velocities))
