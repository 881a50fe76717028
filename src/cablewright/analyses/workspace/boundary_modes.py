"""How the platform vibrates along the boundary of its workspace, where its stiffness is often least."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Unpack, get_args

import numpy as np

from cablewright.analyses.modes import FREEDOMS, Modes, modes
from cablewright.analyses.workspace.criterion import Criterion, Options, criterion_figures
from cablewright.analyses.workspace.workspace import NodeCount, count_nodes
from cablewright.arrays import Array, Mask
from cablewright.choices import TensionChoice
from cablewright.errors import InputError, UnknownName
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Model
from cablewright.progress import Progress
from cablewright.results import Figure, Pictured
from cablewright.robot import Robot

GRID = 21
GRIDS = (3, 121)  # nodes along a side: rows of modes are in memory at once
HOLDING: tuple[str, ...] = get_args(TensionChoice)


FREQUENCIES = (
    Figure("min", "Hz", "Lowest frequency of all."),
    Figure("median", "Hz", "Median of the lowest frequencies."),
    Figure("max", "Hz", "Highest of the lowest frequencies."),
    Figure("dominant", "", "Freedom that dominates the lowest mode most often.", name="mostly"),
    Figure("shares", "1", "Share of the poses at which each freedom dominates the lowest mode.", shown="%", digits=3),
    Figure("worst_pose", "m, rad", "Pose with the lowest frequency."),
)
"""Of the lowest modes along a boundary."""

ALONG = (
    Figure("grid", "1", "Nodes along each side of the box."),
    Figure("n", "1", "Number of poses along the boundary.", name="poses"),
    Figure("unheld", "1", "Poses that cannot be held; they are not counted."),
    Figure("out_of_limits", "1", "Poses held only beyond tension limits or unstably; they are counted."),
    Figure("tensions", "", "Which tensions hold the poses: least norm, or nearest to the middle of the limits."),
    *FREQUENCIES,
)


@dataclass(frozen=True, eq=False, repr=False)
class Boundary(Pictured):
    """Modes at the outermost nodes of a workspace: with K orientations K rows for each node, one orientation at a time.

    Rows that do not balance are NaN. Frequencies of properties are NaN where no row balances.
    """

    FIGURES: ClassVar = (
        Figure("status", "", "ok; unheld: no node of the boundary can be held; empty: no node is inside."),
        *(each for each in criterion_figures("nodes.criterion") if each.key != "cable"),
        Figure("cable", "", "Cable law of the modes.", "modes.equilibrium.model.fidelity.cable"),
        *(
            each.of_part("worst_modes")
            for each in Modes.FIGURES
            if each.key not in ("status", "robot", "cable", "sheave")
        ),
        Figure("boundary", "", "Lowest frequencies along the boundary.", "along", parts=ALONG),
    )
    HEADLINES: ClassVar = ("status", "robot", "criterion")

    nodes: NodeCount
    places: Array  # (N / K, 3) m, of the nozzle or the platform's origin, as the criterion has it
    holding: str
    modes: Modes  # of N rows

    @property
    def status(self) -> str:
        """ok, unheld or empty."""
        return "ok" if self.worst is not None else "unheld" if len(self.places) else "empty"

    @property
    def has_modes(self) -> bool:
        """Whether any place can be held."""
        return self.status == "ok"

    @property
    def notes(self) -> tuple[str, ...]:
        """Warnings about the worst pose."""
        return () if self.worst_modes is None else self.worst_modes.notes

    @property
    def refusal(self) -> str:
        """Why there are no modes, in a sentence; empty where there are."""
        sentences = {"ok": "", "empty": "no node of the grid is inside"}
        return sentences.get(self.status, "no node of the boundary can be held")

    @cached_property
    def worst_modes(self) -> Modes | None:
        """The modes at the row with the lowest of all frequencies; None where there are no modes."""
        return None if self.worst is None else modes(self.modes.equilibrium[self.worst], geometric=self.modes.geometric)

    @property
    def along(self) -> dict[str, Any]:
        """Frequencies along the boundary as JSON has them."""
        lowest, median, highest = self.spread
        return {
            "grid": self.nodes.inside.shape[0],
            "n": len(self.lowest),
            "unheld": int((~self.known).sum()),
            "out_of_limits": self.beyond,
            "tensions": self.holding,
            "min": lowest,
            "median": median,
            "max": highest,
            "dominant": self.dominant,
            "shares": self.shares,
            "worst_pose": None if self.worst is None else self.modes.equilibrium.pose[self.worst],
        }

    @property
    def lowest(self) -> Array:
        """The lowest frequency of each row, (N,) Hz; negative where unstable."""
        return self.modes.lowest

    @property
    def known(self) -> Mask:
        """Which rows balance (N,)."""
        return np.isfinite(self.lowest)

    @property
    def beyond(self) -> int:
        """How many rows balance, but not within the limits of tension or not stably."""
        return int((self.known & ~self.modes.equilibrium.ok).sum())

    @property
    def spread(self) -> tuple[float, float, float]:
        """The least, the median and the greatest of the lowest frequencies, Hz."""
        values = self.lowest[self.known]
        if not len(values):
            return np.nan, np.nan, np.nan
        return float(values.min()), float(np.median(values)), float(values.max())

    @property
    def shares(self) -> dict[str, float]:
        """At which share of the rows a freedom has most of the lowest mode's energy, by `FREEDOMS`; those that have."""
        named = self.modes.dominant[self.known, 0]
        counts = np.bincount(named, minlength=len(FREEDOMS))
        return {name: float(n) / len(named) for name, n in zip(FREEDOMS, counts, strict=True) if n}

    @property
    def dominant(self) -> str | None:
        """The freedom that the lowest mode has most often; None where there are no modes."""
        shares = self.shares
        return max(shares, key=shares.__getitem__, default=None)

    @property
    def worst(self) -> int | None:
        """The row with the lowest of all frequencies; None where there are no modes."""
        return int(np.nanargmin(self.lowest)) if self.known.any() else None


def boundary_modes(
    robot: Robot | Model,
    criterion: str = "exact",
    *,
    grid: int = GRID,
    geometric: bool = True,
    holding: str | None = None,
    progress: Progress | None = None,
    **options: Unpack[Options],
) -> Boundary:
    """Modes along the boundary of a workspace: at the nodes of a grid that are inside and have a neighbour that is not.

    The nodes are those of `count_nodes`, *grid* along each side of the box, counted with straight lines unless the
    *criterion* is ``static``; a node on a side of the box is on the boundary. Modes are those of *robot* with all that
    its laws have. *holding* chooses the tensions there: ``least``, those of least norm, or ``middle``, those nearest
    to the middle of the limits (default: ``middle`` for the closed forms, whose own they are; else ``least``).
    *geometric*: see `modes`. *options*: see `workspace`. Raises `InputError`.
    """
    laws: dict[str, Any] = {key: options.pop(key, None) for key in ("cable", "sheave", "tension_limits")}  # type: ignore[misc]
    model = Model.of(robot, **laws)
    if holding is None:
        holding = "middle" if criterion.endswith("closed-form") else "least"
    if holding not in HOLDING:
        raise UnknownName("tensions", holding, HOLDING)
    if model.m < model.n:
        few = f"{model.m} lines leave some of its {model.n} freedoms to gravity"
        raise InputError(f"robot {model.robot.name!r}: {few}: a grid of places says too little about its poses")
    if not GRIDS[0] <= grid <= GRIDS[1]:
        raise InputError(f"grid {grid}: {GRIDS[0]} to {GRIDS[1]} nodes along a side are allowed for a boundary")
    asked = model if criterion == "static" else straight(model)
    nodes = count_nodes(asked, criterion, grid=grid, progress=progress, **options)
    places = outermost(nodes)
    held = _modes_at(nodes.criterion, places, replace(model, robot=nodes.criterion.model.robot), geometric, holding)
    return Boundary(nodes, places, holding, held)


def straight(model: Model) -> Model:
    """The model with straight lines, which all criteria but ``static`` ask for."""
    if model.fidelity.cable is not CableLaw.CATENARY:
        return model
    return replace(model, fidelity=Fidelity(CableLaw.RIGID, model.fidelity.sheave))


def outermost(nodes: NodeCount) -> Array:
    """Places (N, 3), m, of the nodes that are inside and have one of their six neighbours outside, or none there."""
    beyond = np.pad(nodes.inside, 1)
    inner = nodes.inside.copy()
    for axis in range(3):
        for side in (-1, 1):
            inner &= np.roll(beyond, side, axis)[1:-1, 1:-1, 1:-1]
    return nodes.places[~inner[nodes.inside]]


def _modes_at(criterion: Criterion, places: Array, model: Model, geometric: bool, holding: str) -> Modes:
    poses = criterion.all_poses(places)
    preferred = _middle(model) if holding == "middle" else None
    return modes(model, poses, geometric=geometric, retraction=criterion.lengths(poses), preferred=preferred)


def _middle(model: Model) -> Array:
    """The middle (m,) of each line's tension limits, N."""
    limits = [model.tension_limits or line.tension_limits for line in model.robot.lines]
    return np.array([0.5 * (low + high) for low, high in limits])
