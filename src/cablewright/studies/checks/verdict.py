"""The verdict of a check, in words that say no more than was shown."""

from __future__ import annotations

import numpy as np

from cablewright.analyses.feasibility import CLEARANCE, EXPECTED_ERROR, MOVED_ERROR, OF_CHECKS, TENSION_LIMITS, Finding
from cablewright.foundation.units import spell_length
from cablewright.robot.uncertainty import ASSUMED
from cablewright.studies.checks.result import Check


def verdict(found: Check, nowhere: int) -> str:
    """Return the answer of a check in words.

    *nowhere*: number of places of the frame at which the robot was tried because it holds no sample, and holds none of
    them either; 0 where that is not so.
    """
    machine, part = found.robot.name, found.job.name
    if found.feasible:
        return f"{machine} can print {part}: {'; '.join(_shown(found))}."
    if found.missed.any():
        first = int(np.flatnonzero(found.missed)[0])
        return (
            f"{machine} cannot be shown to print {part}: the compensated path is not met at "
            f"{np.count_nonzero(found.missed)} samples, first {found.where(first)}."
        )
    worst, *others = (finding for finding in found.findings if finding.violations)
    told = f"{machine} cannot print {part}: {_broken(found, worst)}."
    limits = [finding.limit for finding in others if not finding.is_status]
    if limits:
        told += f" Also out of bounds: {', '.join(limits)}."
    if slack := next(
        (each.line for each in (worst, *others) if each.limit == TENSION_LIMITS[0] and each.value <= 0.0), None
    ):
        told += (
            f" Line {slack} goes slack, which this linear model of motion does not follow: cablewright print ROBOT JOB "
            "--plant dynamic does."
        )
    told += "".join(f" At {each.violations} samples {each.limit}." for each in others if each.is_status)
    if nowhere:
        told += (
            f" Its lines hold the platform at none of {nowhere} places tried in the frame: check tension limits, exit "
            "points and units of the robot file."
        )
    return told


def _shown(found: Check) -> list[str]:
    """What was shown of a job that can be printed."""
    parts = ["every sample is within all limits"]
    if found.nearest is not None:
        parts.append(f"lines keep {spell_length(found.nearest.margin)} from all that is described")
    if found.expected is not None and found.expected.sample is not None:
        parts.append(f"95 of 100 machines {_machines(found)} print it to within {spell_length(found.expected.value)}")
    if (motion := found.motion) is not None:
        parts.append(
            f"the platform's motion adds at most {spell_length(motion.largest)}{_swinging(motion.frequency)} with "
            f"{found.robot.damping} of damping"
        )
    return parts


def _swinging(frequency: float) -> str:
    """At which frequency the platform swings, in words; empty at rest."""
    return f" at {frequency:.3g} Hz" if frequency > 0.0 else ""


def _machines(found: Check) -> str:
    return "with assumed uncertainties" if found.uncertainty == ASSUMED else "within the given uncertainties"


def _broken(found: Check, worst: Finding) -> str:
    """Which limit is broken, by how much, and where."""
    where, total = found.where(worst.sample), len(found.samples)
    if worst.is_status:
        return f"at {worst.violations} of {total} samples {worst.limit}, worst {where}"
    if worst.limit == CLEARANCE and found.nearest is not None:
        one, other = found.nearest.pair
        other = f"line {other}" if found.nearest.kind == "line" else other
        how = "touches" if worst.value <= 0.0 else "comes too near to"
        least = "" if worst.allowed[0] == 0.0 else f" where at least {spell_length(worst.allowed[0])} is asked for"
        return (
            f"line {one} {how} {other}, a distance of {spell_length(worst.value)}{least}, {where}; lines are too near "
            f"to something at {worst.violations} of {total} samples"
        )
    if worst.limit == EXPECTED_ERROR and not np.isfinite(worst.value):
        assert found.expected is not None
        return f"its expected error is not stated: {found.expected.unknown}, {where}"
    if worst.limit == EXPECTED_ERROR:
        return (
            f"95 of 100 machines {_machines(found)} print it to within {spell_length(worst.value)} only, where "
            f"{spell_length(worst.allowed[1])} is allowed, largest {where}"
        )
    if worst.limit == MOVED_ERROR:
        return (
            f"expected error and error by motion are {spell_length(worst.value)} together, where "
            f"{spell_length(worst.allowed[1])} is allowed, largest {where}"
            f"{_swinging(found.statics.frequency[worst.sample])}"
        )
    line = f" of line {worst.line}" if worst.line else ""
    why = f": {worst.why}" if worst.limit in OF_CHECKS else ""
    if worst.limit in TENSION_LIMITS:
        where += _swinging(found.statics.frequency[worst.sample])
    return (
        f"{worst.limit}{line} is out of bounds at {worst.violations} of {total} samples, worst {worst.value:.4g} "
        f"{worst.unit} where {worst.bounds()} is allowed, {where}{why}"
    )
