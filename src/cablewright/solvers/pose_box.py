"""Result of `cablewright.solvers.pose_hull`: a box that contains the pose.

It is apart from that search, which few need.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from cablewright.foundation.arrays import Array
from cablewright.foundation.results import Figure, Result


@dataclass(frozen=True, eq=False, repr=False)
class PoseBox(Result):
    """Enclosure of the pose for lengths known to some error.

    If `complete`, for all combinations of lengths within the error, the equilibrium that is reached continuously from
    the solved one has its pose between `low` and `high` (n,): m, and for a body the components of its rotation vector,
    rad. It is the only equilibrium if `only_one`. Otherwise both are NaN, and `reason` states why.
    """

    FIGURES: ClassVar = (
        Figure("low", "m, rad", "Min of each pose coordinate, for all lengths within the error.", digits=7, outward=-1),
        Figure("high", "m, rad", "Max of each pose coordinate.", digits=7, outward=1),
        Figure("certified", "", "Whether the box is proved.", "complete"),
        Figure("unique", "", "Whether the equilibrium is the only one, globally or locally.", "_unique"),
        Figure("leaves", "1", "Number of parts of the lengths that were examined."),
        Figure("reason", "", "What is proved, or why there is no box."),
    )
    HEADLINES: ClassVar = ("certified", "unique", "leaves")

    low: Array
    high: Array
    complete: bool
    only_one: bool
    leaves: int
    tests: int
    reason: str

    def _unique(self) -> str | None:
        if not self.complete:
            return None
        return "globally" if self.only_one else "locally"
