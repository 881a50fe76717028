"""Error of the nozzle by the motion of the platform: the largest, its position and mode, and the 95th percentile."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Self

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.memory_mapped import blocks, let_go
from cablewright.printing.path import Samples
from cablewright.studies.checks.path_statics import PathStatics, largest_at

RARE: Final = 0.95
"""Share of the laid length along which the error is at most that of `MotionError.usual`."""


@dataclass(frozen=True, eq=False)
class MotionError:
    """Error by motion where material is laid, or along the whole path where none is laid."""

    largest: float  # m
    usual: float  # m, the 95th percentile over the length of path
    sample: int  # with the largest
    frequency: float  # Hz, of the mode with most of the largest

    @classmethod
    def of(cls, samples: Samples, statics: PathStatics) -> Self | None:
        """Return the error at the k samples; None where nothing is known."""
        sample = largest_at(statics.displacement, samples.extruding)
        if sample is None:
            return None
        anywhere = not samples.extruding[sample]
        errors, lengths = [], []
        for at in blocks(len(samples)):
            counted = (samples.extruding[at] | anywhere) & np.isfinite(statics.displacement[at])
            errors.append(statics.displacement[at][counted])
            lengths.append(samples.lengths(at)[counted])
            let_go((samples, statics))
        usual = _percentile(np.concatenate(errors), np.concatenate(lengths))
        return cls(float(statics.displacement[sample]), usual, sample, float(statics.frequency[sample]))


def _percentile(errors: Array, lengths: Array) -> float:
    """The least of *errors* (k,), m, that are not exceeded along `RARE` of all *lengths* (k,), m."""
    order = np.argsort(errors)
    passed = np.cumsum(lengths[order])
    return float(errors[order[min(int(np.searchsorted(passed, RARE * passed[-1])), len(order) - 1)]])
