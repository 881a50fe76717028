"""Reading of the encoders of the winches' motors."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.signals.reading import PerLine, Reading, Source


@dataclass(frozen=True, eq=False)
class Encoders(Reading, sources=[Source("encoders", stream=6, topic="/encoders")]):
    """Counts of the motors' incremental encoders; paying cable out is positive."""

    time: float  # s
    counts: Annotated[NDArray[np.int64], PerLine(winch=True)]  # (w,) since the machine's start
