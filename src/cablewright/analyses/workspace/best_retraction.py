"""Retraction length of the end-effector by height: areas of slices by height and length, best lengths, a line fit.

Jung 2020, Eqs. 13 to 15: the area of each level slice is maximised over the length l, and a line l(z) is fitted.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from cablewright.analyses.workspace.criterion import RetractionLaw, box_of, criterion_figures
from cablewright.analyses.workspace.workspace import Workspace, workspace
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.foundation.progress import Progress
from cablewright.foundation.results import Figure, Pictured
from cablewright.models.fidelity import CableLaw, SheaveLaw
from cablewright.models.statics import Model
from cablewright.robot import Robot

STEPS = (3, 200)
HEIGHTS = (4, 1000)
LAW = (
    Figure("slope", "1", "Retraction length gained per height."),
    Figure("intercept", "m", "Length at height zero.", shown="m"),
    Figure("min", "m", "Min length.", shown="m"),
    Figure("max", "m", "Max length.", shown="m"),
    Figure("of", "", "Point of the platform whose height counts: nozzle or origin.", name="height of"),
    Figure("fitted_heights", "m", "Heights of the slices that the law is fitted to.", detail=True),
)


@dataclass(frozen=True, eq=False, repr=False)
class RetractionStudy(Pictured):
    """Areas of slices at Z heights and L lengths, and the fitted law. A height is that of the middle of its slice."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok; a robot or a workspace without a law is an error.", lambda _found: "ok"),
        *(each for each in criterion_figures("held.criterion") if each.key in ("robot", "criterion", "cable", "point")),
        Figure("box", "m", "Box that was searched: min and max corner, world.", "held.box.corners", shown="m"),
        Figure("lengths", "m", "Retraction lengths tried.", "", "constant length", shown="m", along="length"),
        Figure("volumes", "m^3", "Volume of the workspace at each constant length.", "", "volume", along="length"),
        Figure("best_volume", "m^3", "Volume with the best length in each slice."),
        Figure("law", "", "Line through the best lengths.", "fitted_law", parts=LAW),
        Figure("law_volume", "m^3", "Volume with the law in force.", "held.volume"),
        Figure("law_volume_error", "m^3", "Estimated error of that volume.", "held.volume_error", digits=2),
        Figure("law_share", "1", "Volume with the law as a share of the best.", "share", shown="%"),
        Figure("heights", "m", "Heights of the middles of the slices.", "", "height", shown="m", along="slice"),
        Figure(
            "best_lengths",
            "m",
            "Length at which the slice is largest; null where it is empty.",
            "best",
            "best length",
            shown="m",
            along="slice",
        ),
        Figure("best_areas", "m^2", "Area of the slice at its best length.", "", "area", along="slice"),
        Figure("areas", "m^2", "Area of each slice at each length.", detail=True),
    )
    HEADLINES: ClassVar = ("robot", "criterion", "best_volume", "law_volume")

    lengths: Array  # (L,) m, rising
    heights: Array  # (Z,) m, of the point whose workspace it is
    areas: Array  # (Z, L) m^2
    volumes: Array  # (L,) m^3 of the workspaces at constant lengths
    best: Array  # (Z,) m, length with the largest slice; NaN where all are empty
    best_areas: Array  # (Z,) m^2
    fitted: Mask  # (Z,) whether a slice was used in the fit
    law: RetractionLaw
    held: Workspace  # the workspace under the law

    @property
    def fitted_law(self) -> dict[str, object]:
        """The law, and the heights (m) of the slices that it was fitted to."""
        law = {"slope": self.law.slope, "intercept": self.law.intercept, "min": self.law.least, "max": self.law.most}
        return law | {"of": self.law.of, "fitted_heights": self.heights[self.fitted]}

    @property
    def slice_height(self) -> float:
        """Thickness of a horizontal slice of the workspace, m."""
        return float(self.heights[1] - self.heights[0])

    @property
    def best_volume(self) -> float:
        """Volume with the best length in each slice, m^3."""
        return float(self.best_areas.sum()) * self.slice_height

    @property
    def share(self) -> float:
        """Volume under the law as a share of `best_volume`."""
        return self.held.volume / self.best_volume


def retraction(
    robot: Robot | Model,
    criterion: str = "exact",
    *,
    cable: CableLaw | str | None = None,
    sheave: SheaveLaw | str | None = None,
    tension_limits: tuple[float, float] | None = None,
    min_length: float | None = None,
    max_length: float | None = None,
    steps: int = 9,
    heights: int = 40,
    box: ArrayLike | None = None,
    point: str = "nozzle",
    tolerance: float = 2e-3,
    progress: Progress | None = None,
) -> RetractionStudy:
    """Compute slices of the workspace at *steps* lengths, *min_length* to *max_length*, m, and fit a retraction law.

    The lengths default to the robot's own range. The best length of a slice is the peak of the parabola through the
    largest area and its neighbours. The law is the least-squares line through the best lengths inside the range, or
    through all non-empty slices if fewer than two are. It is clamped to the two lengths, and its height is that of
    *point*. *heights* is the number of slices; *cable*, *sheave*, *tension_limits*, *box*, *point* and *tolerance* are
    as for `workspace`. Raises `InputError`, and `AnswerError` where fewer than two slices are not empty.
    """
    default = CableLaw.CATENARY if criterion == "static" else CableLaw.RIGID
    model = Model.of(robot, cable=cable, sheave=sheave, tension_limits=tension_limits, default=default)
    range_of = model.robot.retraction
    if range_of is None:
        raise InputError(f"robot {model.robot.name!r} has no retraction: its platform has one length")
    min_length = range_of.least if min_length is None else min_length
    max_length = range_of.most if max_length is None else max_length
    if not min_length < max_length:
        raise InputError(f"retraction from {min_length:g} to {max_length:g} m: rising lengths are expected")
    for what, value, (low, high) in (("steps", steps, STEPS), ("heights", heights, HEIGHTS)):
        if not low <= value <= high:
            raise InputError(f"{what} = {value}: {low} to {high} are allowed")
    lengths = np.linspace(min_length, max_length, steps)
    for end in (min_length, max_length):
        model.robot.retraction_to(end)
    where = box_of(model.robot, box)
    edges = np.linspace(where.low[2], where.high[2], heights + 1)
    middles = 0.5 * (edges[1:] + edges[:-1])
    areas, volumes = np.zeros((heights, steps)), np.zeros(steps)
    given: dict[str, Any] = {"box": box, "point": point, "tolerance": tolerance}
    for k, length in enumerate(lengths):
        found = workspace(model, criterion, retraction=float(length), **given)
        areas[:, k], volumes[k] = found.slices(middles), found.volume
        if progress:
            progress("lengths", k + 1, steps)
    best, best_areas = _peaks(lengths, areas)
    law, fitted = _fit(middles, best, best_areas, (min_length, max_length))
    law = replace(law, of=point)
    held = workspace(model, criterion, retraction=law, **given)
    return RetractionStudy(lengths, middles, areas, volumes, best, best_areas, fitted, law, held)


def _peaks(lengths: Array, areas: Array) -> tuple[Array, Array]:
    """The best length (Z,) of each slice and its area (Z,): the peak of the parabola around the largest."""
    rows = np.arange(len(areas))
    at = areas.argmax(axis=1)
    inner = np.clip(at, 1, len(lengths) - 2)
    before, middle, after = (areas[rows, inner + k] for k in (-1, 0, 1))
    bend = before - 2.0 * middle + after
    usable = (at == inner) & (bend < 0.0)
    shift = np.where(usable, 0.5 * (before - after) / np.where(usable, bend, 1.0), 0.0)
    best = lengths[at] + shift * (lengths[1] - lengths[0])
    peak = areas[rows, at] - np.where(usable, 0.25 * (before - after) * shift, 0.0)
    return np.where(areas.max(axis=1) > 0.0, best, np.nan), peak


def _fit(heights: Array, best: Array, areas: Array, ends: tuple[float, float]) -> tuple[RetractionLaw, Mask]:
    """The line through the best lengths inside the range, and the slices (Z,) used in the fit."""
    some = areas > 0.0
    fitted = some & (best > ends[0]) & (best < ends[1])
    if fitted.sum() < 2:
        fitted = some
    if fitted.sum() < 2:
        raise AnswerError(
            "fewer than two slices contain a part of the workspace at any length, so no law can be "
            "fitted; give a larger box or other lengths"
        )
    slope, intercept = np.polyfit(heights[fitted], best[fitted], 1)
    return RetractionLaw(float(slope), float(intercept), *ends), fitted
