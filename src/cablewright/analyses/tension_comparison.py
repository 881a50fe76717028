"""Comparison of tension distributions: the tensions that several methods choose at the same poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Unpack

import numpy as np
from numpy.typing import ArrayLike

from cablewright.analyses.jacobian import StraightOptions, straight_model
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.data_frames import COORDINATES
from cablewright.foundation.errors import InputError
from cablewright.foundation.results import Figure, Pictured
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.solvers.tension import METHODS, Objective, tension_distribution


@dataclass(frozen=True, eq=False, repr=False)
class TensionComparison(Pictured):
    """Tensions of k methods at one pose, or at each of a batch: a ``Distribution`` each, in arrays.

    ``tensions`` (k, m), N, or (k, N, m); ``margin`` (k,), N, or (k, N): the smallest distance from the limits, negative
    outside; so is ``feasible``. ``limits`` (m, 2), N.
    """

    FIGURES: ClassVar = (
        Figure("robot", "", "Name of the robot."),
        Figure("methods", "", "How the tensions are chosen.", name="method", along="method"),
        Figure("feasible", "", "Whether they are within their limits.", along="method"),
        Figure("margin", "N", "How far within; negative outside.", along="method"),
        Figure("tensions", "N", "Tension of each line.", along="method"),
        Figure("lines", "", "Names of the lines.", detail=True),
        Figure("poses", "m, rad", "The poses.", detail=True),
    )
    HEADLINES: ClassVar = ("robot", "methods", "margin")

    @property
    def columns(self) -> dict[str, Array | Mask | list[str]]:
        """One row for each method at each pose: pose, method, margin and tensions."""
        poses = np.atleast_2d(self.poses)
        count = len(poses)
        found: dict[str, Array | Mask | list[str]] = {"method": [each for each in self.methods for _ in range(count)]}
        found |= {name: np.tile(poses[:, k], len(self.methods)) for k, name in enumerate(COORDINATES[: poses.shape[1]])}
        flat = self.tensions.reshape(-1, len(self.lines))
        found |= {"margin": self.margin.ravel(), "feasible": self.feasible.ravel()}
        return found | {f"tension.{name}": flat[:, i] for i, name in enumerate(self.lines)}

    robot: str
    lines: tuple[str, ...]
    methods: tuple[str, ...]
    limits: Array
    poses: Array
    tensions: Array
    margin: Array
    feasible: Mask


def compare_tensions(
    robot: Robot | Model,
    poses: ArrayLike,
    methods: Sequence[str | Objective] = tuple(METHODS),
    *,
    wrench: ArrayLike | None = None,
    tension_limits: tuple[float, float] | None = None,
    **options: Unpack[StraightOptions],
) -> TensionComparison:
    """Compare the tensions that *methods* of `tension_distribution` choose at *poses*, (n,) or (N, n) in m and rad.

    *wrench*, limits and *options* as there. An `Objective` has the name of its class. Raises `InputError`.

    Examples
    --------
    >>> import cablewright as cw
    >>> found = cw.compare_tensions(cw.load("jung2020"), [0.2, 0.1, 0.9])
    >>> found.tensions.shape
    (4, 8)
    """
    if isinstance(methods, str) or not len(methods):
        raise InputError(f"methods = {methods!r}: a list of one or more is expected, such as {list(METHODS)[:2]}")
    model = straight_model(robot, options, tension_limits)
    given = options.get("retraction")
    found = [tension_distribution(model, poses, each, wrench=wrench, retraction=given) for each in methods]
    names = tuple(each if isinstance(each, str) else type(each).__name__ for each in methods)
    return TensionComparison(
        model.robot.name,
        tuple(line.name for line in model.robot.lines),
        names,
        np.array(model.lines.tension_limits),
        found[0].poses,
        np.stack([each.tensions for each in found]),
        np.stack([each.margin for each in found]),
        np.stack([each.feasible for each in found]),
    )
