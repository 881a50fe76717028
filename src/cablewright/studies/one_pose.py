"""Result of one inverse or forward solve: tensions, limits of the machine, a certificate, a box of poses."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

from cablewright.analyses.feasibility import OF_CHECKS, judge_pose
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import Status
from cablewright.foundation.results import Figure, Result, figures_dict
from cablewright.models.equilibrium_figures import FIGURES
from cablewright.models.statics import Equilibrium, Model
from cablewright.solvers.certify import Certificate
from cablewright.solvers.pose_box import PoseBox
from cablewright.solvers.preferred_tensions import preferred_note
from cablewright.solvers.slack import SlackSet, excess_lengths
from cablewright.solvers.uniqueness import EVERYWHERE, unique_among


def _has(part: str) -> Any:
    return lambda of: getattr(of, part) is not None


def _certificate(of: SolvedPose) -> dict[str, Any]:
    """What the certificate proves; nothing of levers where there are none."""
    proof = figures_dict(PROOF, of.certificate)
    return proof | {
        "levers": proof["levers"] if of.equilibrium.lines.has_lever.any() else None,
        "unique": of.unique,
        "unique_among": of.unique_among,
    }


PROOF = Certificate.FIGURES[1:]
_NEAR = "equilibria within the certificate's box"


@dataclass(frozen=True, eq=False, repr=False)
class SolvedPose(Result):
    """One solved inverse or forward problem. `broken_limit` is the first limit of the machine that the pose breaks."""

    FIGURES: ClassVar = (
        Figure("status", "", "What became of the solve, or out-of-limits.", lambda of: of.status.word),
        *(each.of_part("equilibrium") for each in FIGURES[1:]),
        Figure("excess", "m", "Excess of each line over a taut one.", shown="m", along="line", only=_has("excess")),
        Figure("certified", "", "Whether exactly one equilibrium is proved to be near.", "certificate.certified",
               only=_has("certificate")),
        Figure("certificate", "", "What the certificate proves.", _certificate, parts=(*PROOF,
               Figure("unique", "", "globally, conditionally or locally the only one; null where nothing is proved."),
               Figure("unique_among", "", "Equilibria of these lengths among which it is the only one.")),
               only=_has("certificate")),
        Figure("pose_box", "", "Box that contains the pose for all lengths within their error.", parts=PoseBox.FIGURES,
               only=_has("pose_box")),
    )  # fmt: skip

    equilibrium: Equilibrium
    broken_limit: str | None = None
    excess: Array | None = None
    certificate: Certificate | None = None
    pose_box: PoseBox | None = None

    @classmethod
    def judged(cls, found: Equilibrium, *, slack: bool = False) -> SolvedPose:
        """Return a solved inverse problem with the machine's limits compared. *slack*: excess of slack lines."""
        broken = _broken_limit(found) if found.ok else None
        return cls(found, broken, excess=excess_lengths(found) if slack else None)

    @classmethod
    def reached(cls, found: Equilibrium, certificate: Certificate | None, box: PoseBox | None) -> SolvedPose:
        """Return a solved forward problem; one that lifts the platform off its plane is out of limits."""
        lifts = found.sentence() if found.ok and not found.holds else None
        return cls(found, lifts, certificate=certificate, pose_box=box)

    @property
    def status(self) -> Status:
        """Status of the solve; out of limits where it is balanced beyond a limit of the machine."""
        status: Status = self.equilibrium.status
        return Status.OUT_OF_LIMITS if status is Status.OK and self.broken_limit else status

    @cached_property
    def unique_among(self) -> str | None:
        """Words for the set of equilibria among which the certified one is the only one for these lengths."""
        if self.certificate is None or not self.certificate.certified:
            return None
        return unique_among(self.equilibrium) or _NEAR

    @property
    def unique(self) -> str | None:
        """Whether the certified equilibrium is the only one: of all, under a condition, or near it."""
        among = self.unique_among
        return None if among is None else {EVERYWHERE: "globally", _NEAR: "locally"}.get(among, "conditionally")

    @property
    def notes(self) -> tuple[str, ...]:
        """Note on the choice of tensions of a redundant robot."""
        note = preferred_note(self.equilibrium.lines.preferred_tension)
        return (note,) if note else ()

    @property
    def refusal(self) -> str:
        """Reason why the pose has no solution, in a sentence."""
        if self.equilibrium.status is not Status.OK:
            return self.equilibrium.sentence()
        if self.certificate is not None and not self.certificate.certified:
            return str(self.certificate.reason())
        return self.broken_limit or ""


def _broken_limit(found: Equilibrium) -> str | None:
    """The first limit of the machine, other than tension, that a balanced pose breaks, in one line."""
    for finding in judge_pose(found):
        if finding.violations:
            who = f"line {finding.line}: " if finding.line else ""
            why = f": {finding.why}" if finding.limit in OF_CHECKS else ""
            return f"{who}{finding.limit} {finding.value:.6g} {finding.unit}; {finding.bounds()} is allowed{why}"
    return None


@dataclass(frozen=True, eq=False, repr=False)
class SlackSets(Result):
    """Every set of lines that can be slack at a pose."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok, or infeasible: no line can be slack.", lambda of: of.status.word),
        Figure("robot", "", "Name of the robot.", "model.robot.name"),
        Figure("pose", "m, rad", "The pose.", digits=7),
        Figure("lines", "", "Names of the lines, in the order of the tensions.", "_lines"),
        Figure("sets", "", "Sets of lines that can be slack while the others hold the pose.", parts=SlackSet.FIGURES),
    )

    model: Model
    pose: tuple[float, ...]
    sets: tuple[SlackSet, ...]

    @property
    def status(self) -> Status:
        """Ok, or infeasible where no line can be slack."""
        return Status.OK if self.sets else Status.INFEASIBLE

    @property
    def refusal(self) -> str:
        """Reason why no set of lines can be slack, in a sentence."""
        count = f"no {self.model.n} of the {self.model.m} lines"
        return "" if self.sets else f"{count} hold this pose within their limits with the others slack"

    def _lines(self) -> list[str]:
        return [line.name for line in self.model.robot.lines]
