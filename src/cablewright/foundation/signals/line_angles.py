"""Reading of the cable angles at the accelerometers on the lines."""

from dataclasses import dataclass
from typing import Annotated

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals.reading import PerLine, Reading, Source


@dataclass(frozen=True, eq=False)
class LineAngles(Reading, sources=[Source("line_angles", stream=4, topic="/line_angles", clock="drum")]):
    """Accelerometers on the lines: angle of the tangent above the horizontal, in the direction away from the sheave.

    Negative on a line that descends to the platform; as `cablewright.solvers.slack.tangent_angle`.
    """

    time: float  # s
    angles: Annotated[Array, PerLine("rad")]  # (m,); NaN: not measured
