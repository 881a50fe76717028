"""Limits of a check that no robot file contains: bounds of straight lines, the nozzle's speed, the sum of errors."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from cablewright.analyses.feasibility import MOVED_ERROR, PACE, SLACK, Finding, at_most, merged
from cablewright.foundation.arrays import Array
from cablewright.foundation.memory_mapped import blocks, let_go
from cablewright.printing.path import Samples
from cablewright.printing.timing import TimeLaw
from cablewright.robot import Robot
from cablewright.studies.checks.path_statics import PathStatics

LOOSE: Final = 1.05
"""Length of a line, in units of its straight length, above which it is slack: it carries less than its own weight."""

QUICK: Final = 0.1
"""Change of a length that stretch and sag may add, in units of the nozzle's way times the spans of the line."""


def paces(samples: Samples, law: TimeLaw, segments: slice) -> Array:
    """Return the largest speed (b,) along each of a slice of *segments*, in units of their lengths, 1/s."""
    ends = slice(segments.start, segments.stop + 1)
    distance, speed = np.diff(samples.distance[ends]), law.speed[ends]
    duration = np.diff(law.time[ends]) - samples.dwell[segments]
    return np.asarray(np.maximum(np.maximum(speed[1:], speed[:-1]), distance / duration) / distance)


def line_findings(robot: Robot, samples: Samples, law: TimeLaw, statics: PathStatics) -> Iterator[Finding]:
    """Yield the limit of each line's length by a straight line, m, and of its winch's speed by straight lines, m/s.

    A winch is as fast as straight lines between the samples need, or as the nozzle times the spans, and a tenth of the
    latter more. Samples that are not held do not count.
    """
    names, spans = [line.name for line in robot.lines], np.array([line.advantage for line in robot.lines])
    slack: list[Finding] = []
    quick: list[Finding] = []
    for at in blocks(len(samples) - 1):
        ends = slice(at.start, at.stop + 1)
        held = (statics.codes[ends] == 0)[:, None]
        lengths, rigid = statics.lengths[ends], statics.rigid_lengths[ends]
        found = at_most(SLACK, "m", np.where(held, lengths, np.nan), LOOSE * rigid, names)
        slack += (replace(each, sample=at.start + each.sample) for each in found)
        way = spans * np.diff(samples.distance[ends])[:, None]
        bound = np.maximum((1.0 + QUICK) * way, np.abs(np.diff(rigid, axis=0)) + QUICK * way)
        speeds = np.where(held[1:] & held[:-1], statics.lines.winch_speed[ends][1:], np.nan)
        found = at_most(PACE, "m/s", speeds, bound * paces(samples, law, at)[:, None], names)
        quick += (replace(each, sample=at.start + 1 + each.sample) for each in found)
        let_go((samples, law, statics))
    yield from (*merged(slack), *merged(quick))


def error_finding(displacement: Array, expected: Array, allowed: Array) -> list[Finding]:
    """Return the sum of the *expected* error (k,) and the *displacement* (k,) by motion as a limit, m.

    *allowed* (k,): m, inf where there is no limit. Samples whose error is not known do not count.
    """
    found = []
    for at in blocks(len(displacement)):
        each = at_most(MOVED_ERROR, "m", expected[at] + displacement[at], allowed[at])
        found += [replace(one, sample=at.start + one.sample) for one in each]
        let_go((displacement, expected))
    return merged(found)
