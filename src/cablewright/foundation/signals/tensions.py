"""Reading of the tensions of the lines."""

from dataclasses import dataclass
from typing import Annotated

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals.reading import PerLine, Reading, Source


@dataclass(frozen=True, eq=False)
class Tensions(
    Reading,
    sources=[
        Source("load_cells", stream=9, topic="/tensions/load_cells"),
        Source("motor_torques", stream=10, topic="/tensions/motor_torques"),
    ],
):
    """Measured tensions of the lines, from ``load_cells`` or from ``motor_torques``.

    A motor shows the torque of its drum: with one line on it that is its tension; the tensions of several are NaN.
    """

    source: str
    time: float  # s
    tensions: Annotated[Array, PerLine("N")]  # (m,) at the sheaves; NaN: not measured
    torques: Array | None = None  # (w,) N m, with which cables turn each drum outwards; None: of load cells
