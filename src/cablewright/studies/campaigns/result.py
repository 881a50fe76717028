"""The result of a print campaign: how many machines succeed, their errors, and which tolerance matters."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.results import Figure, Pictured
from cablewright.studies.campaigns.one_print import REMEDIES, CampaignPrint

CONFIDENCE: Final = 0.95
"""Of the interval of the success rate."""


@dataclass(frozen=True)
class MachinePrint:
    """Result of the print on one machine of a campaign."""

    seed: int
    finished: bool
    status: str
    reason: str
    max_error: float  # m, largest distance beside the path
    rms: float  # m, of the distance from the target
    distance: float  # m along the path, reached
    duration: float  # s

    FIGURES: ClassVar = (
        Figure("seed", "1", "Seed by which the machine is built."),
        Figure("status", "", "finished, or the state in which the print stopped."),
        Figure("reason", "", "Why it stopped; empty where it is finished.", detail=True),
        Figure("max_path_error", "m", "Largest distance beside the path.", "max_error", shown="mm"),
        Figure("position_rms", "m", "Root of the mean square of the distance from the target.", "rms", shown="mm"),
        Figure("distance", "m", "Distance along the path, travel included, that was reached.", shown="m"),
        Figure("duration", "s", "Duration of the print on the machine's clock.", detail=True),
    )  # fmt: skip


@dataclass(frozen=True)
class Sensitivity:
    """Change of the campaign's result if one tolerance is set to zero, on the same machines."""

    tolerance: str
    value: float  # SI
    machines: int
    change: float  # m, mean change of the largest error
    change_error: float  # m, standard error of that mean
    succeeded: int

    FIGURES: ClassVar = (
        Figure("tolerance", "", "Name of the tolerance."),
        Figure("value", "SI", "Its value in the campaign.", digits=3),
        Figure("machines", "1", "Number of machines that were also printed on with it exact.", name="tried on"),
        Figure("change", "m", "Mean change of the largest error beside the path on the same machines.",
               name="change of the largest error", digits=2, shown="mm"),
        Figure("change_error", "m", "Standard error of that mean; null of a single machine.", name="standard error",
               digits=2, shown="mm"),
        Figure("succeeded", "1", "How many of these succeed with it.", name="succeed with it"),
        Figure("remedy", "", "What would make it exact.", lambda of: REMEDIES[of.tolerance], name="by"),
    )  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class Campaign(Pictured):
    """Result of a campaign: prints on N machines, and on some of them with one tolerance at a time set to zero."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok: every machine succeeded; some-failed, or all-failed."),
        Figure("robot", "", "Name of the robot.", "what.robot.name"),
        Figure("job", "", "Name of the job.", "what.job.name"),
        Figure("machines", "1", "Number of machines.", lambda of: len(of.prints)),
        Figure("succeeded", "1", "Number of machines that finish within the allowed error."),
        Figure("success_rate", "1", "Share of them.", shown="%", name="success rate"),
        Figure("success_interval", "1", "Interval with confidence 95 % of the share in all machines within the "
               "tolerances (Clopper and Pearson).", shown="%", name="its 95 % interval", digits=3),
        Figure("allowed_error", "m", "Largest error beside the path with which a print counts as a success.",
               shown="mm"),
        Figure("stopped", "", "Number of machines by the state in which they stopped before the end.",
               lambda of: dict(Counter(each.status for each in of.prints if not each.finished))),
        Figure("median_error", "m", "Median of the machines' largest errors beside the path.",
               lambda of: of.quantile(0.5), shown="mm"),
        Figure("error_of_95", "m", "Error that 95 % of these machines stay within.", lambda of: of.quantile(0.95),
               "error of 95 %", shown="mm"),
        Figure("smallest_error", "m", "Largest error of the best machine.", lambda of: of.quantile(0.0), shown="mm"),
        Figure("largest_error", "m", "Largest error of the worst machine.", lambda of: of.quantile(1.0), shown="mm"),
        Figure("sensitivities", "", "Each tolerance met exactly, that which helps most first.",
               name="one tolerance met exactly", parts=Sensitivity.FIGURES),
        Figure("prints", "", "Each machine.", name="machines", parts=MachinePrint.FIGURES, detail=True),
    )  # fmt: skip
    HEADLINES: ClassVar = ("robot", "job", "machines", "success_rate", "error_of_95")

    what: CampaignPrint
    prints: tuple[MachinePrint, ...]
    sensitivities: tuple[Sensitivity, ...]
    allowed_error: float  # m
    notes: tuple[str, ...] = ()  # what machines do not lay as the job says

    @cached_property
    def errors(self) -> Array:
        """Largest errors (N,) of the machines, m; NaN where nothing was printed."""
        return np.array([each.max_error for each in self.prints])

    @property
    def succeeded(self) -> int:
        """Number of machines that finish within the allowed error."""
        return sum(succeeds(each, self.allowed_error) for each in self.prints)

    @property
    def success_rate(self) -> float:
        """Share of successful machines."""
        return self.succeeded / len(self.prints)

    @property
    def success_interval(self) -> tuple[float, float]:
        """Confidence interval of the success rate: the exact interval of a binomial share."""
        from scipy.stats import binomtest

        found = binomtest(self.succeeded, len(self.prints)).proportion_ci(CONFIDENCE, "exact")
        return float(found.low), float(found.high)

    @property
    def status(self) -> str:
        """ok, some-failed or all-failed."""
        return {len(self.prints): "ok", 0: "all-failed"}.get(self.succeeded, "some-failed")

    @property
    def refusal(self) -> str:
        """Sentence with the reason if not one machine succeeds."""
        return "" if self.succeeded else "no machine finishes the print within the allowed error"

    def quantile(self, share: float) -> float | None:
        """Return the largest error, m, of this *share* of the machines; None where none has one.

        The smallest of the errors for which that holds: nothing between two machines is interpolated.
        """
        known = np.sort(self.errors[np.isfinite(self.errors)])
        return float(np.quantile(known, share, method="inverted_cdf")) if len(known) else None


def succeeds(found: MachinePrint, allowed: float) -> bool:
    """Return whether a print counts as a success of the campaign."""
    return found.finished and found.max_error <= allowed


def machine_print(seed: int, value: dict[str, Any]) -> MachinePrint:
    """Return the print of a seed from the data that `one_print` returned."""
    return MachinePrint(seed=seed, **value)
