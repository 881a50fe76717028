"""Natural frequencies of the platform along the boundary of its workspace, where its stiffness is often lowest."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Unpack, get_args

import numpy as np
from scipy.ndimage import binary_erosion, generate_binary_structure

from cablewright.analyses.modes import FREEDOMS, Modes, modes
from cablewright.analyses.workspace.criterion import Options, criterion_figures
from cablewright.analyses.workspace.workspace import NodeCount, count_nodes
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.choices import TensionChoice
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.progress import Progress
from cablewright.foundation.results import Figure, Pictured
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Model
from cablewright.models.support_table import Capability, require
from cablewright.robot import Robot

GRID = 21
GRIDS = (3, 121)  # allowed nodes along a side: memory holds the modes of all boundary nodes
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
    """Modes at the P boundary nodes of a workspace: N = K P rows for K orientations, orientation by orientation.

    Rows without an equilibrium are NaN. Properties are NaN, None or empty where no row has one.
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
    places: Array  # (P, 3) m, of the nozzle or the platform's origin, as in the criterion
    holding: str
    modes: Modes  # of N rows

    @property
    def status(self) -> str:
        """ok; unheld, if no node has an equilibrium; or empty, if no node is inside."""
        return "ok" if self.worst is not None else "unheld" if len(self.places) else "empty"

    @property
    def has_modes(self) -> bool:
        """Whether any node at the boundary has an equilibrium."""
        return self.status == "ok"

    @property
    def notes(self) -> tuple[str, ...]:
        """Warnings about the pose with the lowest frequency."""
        return () if self.worst_modes is None else self.worst_modes.notes

    @property
    def refusal(self) -> str:
        """Reason why there are no natural frequencies along the boundary; empty if there are."""
        sentences = {"ok": "", "empty": "no node of the grid is inside"}
        return sentences.get(self.status, "no node of the boundary can be held")

    @cached_property
    def worst_modes(self) -> Modes | None:
        """The modes at the row with the lowest frequency; None if there are no modes."""
        return None if self.worst is None else modes(self.modes.equilibrium[self.worst], geometric=self.modes.geometric)

    @property
    def along(self) -> dict[str, Any]:
        """Frequencies along the workspace's boundary, as JSON has them."""
        lowest, median, highest = self.spread
        return {
            "grid": max(self.nodes.inside.shape),
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
        """Lowest frequency (N,) of each row, Hz; negative where unstable."""
        return self.modes.lowest

    @property
    def known(self) -> Mask:
        """Mask (N,) of boundary poses with an equilibrium."""
        return np.isfinite(self.lowest)

    @property
    def beyond(self) -> int:
        """Number of rows with an equilibrium that violates the tension limits or is unstable."""
        return int((self.known & ~self.modes.equilibrium.holds).sum())

    @property
    def spread(self) -> tuple[float, float, float]:
        """The minimum, median and maximum of the lowest frequencies, Hz."""
        values = self.lowest[self.known]
        if not len(values):
            return np.nan, np.nan, np.nan
        return float(values.min()), float(np.median(values)), float(values.max())

    @property
    def shares(self) -> dict[str, float]:
        """Share of the rows by the degree of freedom with most energy in the lowest mode, without zeros."""
        named = self.modes.dominant[self.known, 0]
        counts = np.bincount(named, minlength=len(FREEDOMS))
        return {name: float(n) / len(named) for name, n in zip(FREEDOMS, counts, strict=True) if n}

    @property
    def dominant(self) -> str | None:
        """The most frequent degree of freedom of the lowest mode; None if there are no modes."""
        shares = self.shares
        return max(shares, key=shares.__getitem__, default=None)

    @property
    def worst(self) -> int | None:
        """The row with the lowest frequency; None if there are no modes."""
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
    """Compute modes along the boundary of a workspace: at inside nodes of a grid with a neighbour outside.

    The nodes are those of `count_nodes`, *grid* along each side of the box, counted with straight lines unless the
    *criterion* is ``static``; inside nodes on a side of the box are on the boundary. The modes use all laws of *robot*.
    Of a platform in a plane along a coordinate plane the nodes are in that plane.
    *holding* selects the tensions there: ``least`` for least norm, ``middle`` for those nearest to the middle of the
    limits (default: ``middle`` for the closed forms, as they do so themselves; else ``least``). *geometric*: see
    `modes`. *options*: see `workspace`. Raises `InputError`.
    """
    cable, sheave = options.pop("cable", None), options.pop("sheave", None)
    model = Model.of(robot, cable=cable, sheave=sheave, tension_limits=options.pop("tension_limits", None))
    if holding is None:
        holding = "middle" if criterion.endswith("closed-form") else "least"
    if holding not in HOLDING:
        raise UnknownName("tensions", holding, HOLDING)
    require(model, Capability.BOUNDARY_MODES)
    if not GRIDS[0] <= grid <= GRIDS[1]:
        raise InputError(f"grid {grid}: {GRIDS[0]} to {GRIDS[1]} nodes along a side are allowed for a boundary")
    counting = model if criterion == "static" else straight(model)
    flat = model.robot.platform.plane is not None
    nodes = count_nodes(counting, criterion, grid=grid, progress=progress, flat=flat, **options)
    places = outermost(nodes)
    poses, built = nodes.criterion.all_poses(places), replace(model, robot=nodes.criterion.model.robot)
    preferred = None
    if holding == "middle":
        preferred = np.mean([model.tension_limits or line.tension_limits for line in built.robot.lines], axis=1)
    retraction = nodes.criterion.lengths(poses)
    held = modes(built, poses, geometric=geometric, retraction=retraction, preferred=preferred)
    return Boundary(nodes, places, holding, held)


def straight(model: Model) -> Model:
    """Return the model with straight lines, as all criteria but ``static`` require."""
    if model.fidelity.cable is not CableLaw.CATENARY:
        return model
    return replace(model, fidelity=Fidelity(CableLaw.RIGID, model.fidelity.sheave))


def outermost(nodes: NodeCount) -> Array:
    """Return positions (P, 3), m, of the inside nodes that have a neighbour outside or off the grid.

    A node has six neighbours, in a plane four.
    """
    near = generate_binary_structure(3, 1)
    boundary: Mask = nodes.inside.copy()
    if nodes.box.is_flat:  # two nodes are in each place
        near[tuple(slice(None) if axis != nodes.box.flat_axis else slice(0, None, 2) for axis in range(3))] = False
        np.moveaxis(boundary, nodes.box.flat_axis, 0)[1] = False
    boundary &= ~binary_erosion(nodes.inside, near)
    return nodes.box.grid(nodes.inside.shape)[boundary]
