"""The verdict of a check, in words that say no more than was shown."""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.analyses.accuracy.expected_error import INTERPOLATION, ExpectedError
from cablewright.analyses.feasibility import CLEARANCE, EXPECTED_ERROR, Finding
from cablewright.robot.uncertainty import ASSUMED
from cablewright.studies.checks.result import Check
from cablewright.units import spell_length

REMEDIES: Final = {
    "exit_point": "survey or calibrate the exit points",
    "platform_point": "measure or calibrate the platform points",
    "modulus": "measure the moduli of the cables",
    "sheave_radius": "measure the sheaves",
    "linear_density": "weigh the cables",
    "length_offset": "home the lines better, or calibrate their lengths",
    "length_scale": "calibrate the scale of the lengths",
    "temperature": "compensate the temperature of the cables",
    "mass": "weigh the platform",
    "centre_of_mass": "measure the centre of mass",
    "force": "measure the force on the platform",
    "moment": "measure the moment on the platform",
    INTERPOLATION: "give the job a shorter sampling.step",
}
"""What makes the uncertain numbers of a kind more certain."""


def verdict(found: Check, nowhere: int) -> str:
    """Return the answer of a check in words.

    *nowhere*: number of places of the frame at which the robot was tried because it holds no sample, and holds none of
    them either; 0 where that is not so.
    """
    machine, part = found.robot.name, found.job.name
    if found.feasible:
        return f"{machine} can print {part}: {', and '.join(_shown(found))}."
    if found.missed.any():
        first = int(np.flatnonzero(found.missed)[0])
        return (
            f"{machine} cannot be shown to print {part}: the compensated path is not met at "
            f"{np.count_nonzero(found.missed)} samples, first {found.where(first)}."
        )
    worst, *others = (finding for finding in found.findings if finding.violations)
    told = f"{machine} cannot print {part}: {_broken(found, worst)}."
    if others:
        told += f" Also out of bounds: {', '.join(dict.fromkeys(finding.limit for finding in others))}."
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
    return parts


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
    if worst.limit == EXPECTED_ERROR:
        return (
            f"95 of 100 machines {_machines(found)} print it to within {spell_length(worst.value)} only, where "
            f"{spell_length(worst.allowed[1])} is allowed, largest {where}"
        )
    line = f" of line {worst.line}" if worst.line else ""
    return (
        f"{worst.limit}{line} is out of bounds at {worst.violations} of {total} samples, worst {worst.value:.4g} "
        f"{worst.unit} where {worst.bounds()} is allowed, {where}"
    )


def advice(expected: ExpectedError | None) -> str:
    """Return what contributes most to the expected error, and what would reduce it; empty where nothing is known."""
    if expected is None or not expected.causes or not expected.value > 0.0:
        return ""
    most = expected.causes[0]
    words = "interpolation between samples" if most.name == INTERPOLATION else most.name.replace("_", " ")
    return (
        f"most of the expected error is by {words} ({100.0 * most.share:.0f} %): {REMEDIES[most.name]}; exact numbers "
        f"would leave {spell_length(most.without)}"
    )
