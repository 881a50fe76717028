"""Working memory of the inverse problem, allocated once and used by one thread at a time."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.layout import COLUMNS
from cablewright.kernels.statics.equilibrium import Work, workspace


class InverseWork(NamedTuple):
    """Working memory of the inverse problem in addition to that of the equilibrium."""

    base: Work
    structure: NDArray[np.float64]  # (n, m): wrench per pull, reversed
    load: NDArray[np.float64]  # (n,)
    low: NDArray[np.float64]  # (m,): limits on the pull
    high: NDArray[np.float64]
    pulls: NDArray[np.float64]  # (m,)
    required: NDArray[np.float64]  # (m,): pulls that the last program requires
    multipliers: NDArray[np.float64]  # (n,)
    moves: NDArray[np.float64]  # (m,): the last required change of the pulls
    before: NDArray[np.float64]  # (m,): pulls of the last program
    curvature: NDArray[np.float64]  # (m,): of the Lagrangian
    bias: NDArray[np.float64]  # (m,)
    column: NDArray[np.float64]  # (n,)
    step: NDArray[np.float64]  # (n, 3)
    slackest: NDArray[np.float64]  # (1,): min tension of a line as a share of its weight
    lengths: NDArray[np.float64]  # (m,)
    lines: NDArray[np.float64]  # (m, COLUMNS): as packed, but with elastic cables only
    mixed: NDArray[np.float64]  # (n, n): of an underconstrained robot, wrench per free freedom and per pull


@jit(allocates=True)
def inverse_workspace(packed):
    """Allocate an `InverseWork` for the robot *packed*."""
    m, n = packed.lines.shape[0], packed.freedoms
    return InverseWork(
        workspace(packed),
        np.zeros((n, m)),
        np.zeros(n),
        np.zeros(m),
        np.zeros(m),
        np.zeros(m),
        np.zeros(m),
        np.zeros(n),
        np.zeros(m),
        np.zeros(m),
        np.ones(m),
        np.zeros(m),
        np.zeros(n),
        np.zeros((n, 3)),
        np.zeros(1),
        np.zeros(m),
        np.zeros((m, COLUMNS)),
        np.zeros((n, n)),
    )
