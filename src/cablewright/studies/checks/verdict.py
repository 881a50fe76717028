"""Sentences of the verdict of a check. They state only results that the check computed."""

from __future__ import annotations

import numpy as np

from cablewright.analyses.feasibility import CLEARANCE, EXPECTED_ERROR, MOVED_ERROR, OF_CHECKS, TENSION_LIMITS, Finding
from cablewright.foundation.units import spell_length
from cablewright.robot.uncertainty import ASSUMED
from cablewright.studies.checks.result import Check


def verdict(found: Check, nowhere: int) -> str:
    """Return the verdict of a check as text.

    *nowhere*: number of positions of the frame that were tried because no sample has an equilibrium, if none of these
    has one either; otherwise 0.
    """
    machine, part = found.robot.name, found.job.name
    if found.feasible:
        return f"{machine} can print {part}. {' '.join(_shown(found))}"
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
            f" Line {slack} becomes slack. The linear model of motion does not cover slack lines: simulate the print "
            "with cablewright print ROBOT JOB --plant dynamic."
        )
    told += "".join(f" At {each.violations} samples {each.limit}." for each in others if each.is_status)
    if nowhere:
        told += (
            f" The lines cannot hold the platform at any of {nowhere} positions tried in the frame: check tension "
            "limits, exit points and units of the robot file."
        )
    return told


def _shown(found: Check) -> list[str]:
    """Return the results for a job that can be printed, a sentence each."""
    parts = ["All samples are within the limits."]
    if found.nearest is not None:
        parts.append(f"Smallest distance between a line and an obstacle: {spell_length(found.nearest.margin)}.")
    if found.expected is not None and found.expected.sample is not None:
        parts.append(f"Expected position error: {spell_length(found.expected.value)} {_percentile(found)}.")
    if (motion := found.motion) is not None:
        parts.append(
            f"Motion of the platform adds at most {spell_length(motion.largest)}{_swinging(motion.frequency)} with a "
            f"damping ratio of {found.robot.damping}."
        )
    return parts


def _swinging(frequency: float) -> str:
    """Return the frequency of the platform's swing as text; empty at rest."""
    return f" at {frequency:.3g} Hz" if frequency > 0.0 else ""


def _percentile(found: Check) -> str:
    return f"(95th percentile, {'assumed' if found.uncertainty == ASSUMED else 'given'} tolerances)"


def _broken(found: Check, worst: Finding) -> str:
    """Return the limit that is violated, the worst value and its position."""
    where, total = found.where(worst.sample), len(found.samples)
    if worst.is_status:
        return f"at {worst.violations} of {total} samples {worst.limit}, worst {where}"
    if worst.limit == CLEARANCE and found.nearest is not None:
        one, other = found.nearest.pair
        other = f"line {other}" if found.nearest.kind == "line" else other
        how = "touches" if worst.value <= 0.0 else "comes too near to"
        least = "" if worst.allowed[0] == 0.0 else f" (required: at least {spell_length(worst.allowed[0])})"
        return (
            f"line {one} {how} {other}, distance {spell_length(worst.value)}{least}, {where}; distances are too small "
            f"at {worst.violations} of {total} samples"
        )
    if worst.limit == EXPECTED_ERROR and not np.isfinite(worst.value):
        assert found.expected is not None
        return f"the expected error is unknown: {found.expected.unknown}, {where}"
    if worst.limit == EXPECTED_ERROR:
        return (
            f"the expected position error is {spell_length(worst.value)} {_percentile(found)}, largest {where} "
            f"(allowed: at most {spell_length(worst.allowed[1])})"
        )
    if worst.limit == MOVED_ERROR:
        return (
            f"the sum of expected error and error by motion is {spell_length(worst.value)}, largest {where}"
            f"{_swinging(found.statics.frequency[worst.sample])} (allowed: at most {spell_length(worst.allowed[1])})"
        )
    line = f" of line {worst.line}" if worst.line else ""
    why = f": {worst.why}" if worst.limit in OF_CHECKS else ""
    if worst.limit in TENSION_LIMITS:
        where += _swinging(found.statics.frequency[worst.sample])
    return (
        f"{worst.limit}{line} is out of bounds at {worst.violations} of {total} samples, worst {worst.value:.4g} "
        f"{worst.unit} {where} (allowed: {worst.bounds()}){why}"
    )
