"""Counts of the encoders of the winches' motors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from cablewright.signals.reading import PerLine, Reading, Source


@dataclass(frozen=True, eq=False)
class Encoders(Reading):
    """Counts of the motors' incremental encoders; paying cable out is positive."""

    SOURCES: ClassVar = (Source("encoders", stream=6, topic="/encoders"),)

    time: float  # s
    counts: Annotated[NDArray[np.int64], PerLine()]  # (m,) since the machine's start
