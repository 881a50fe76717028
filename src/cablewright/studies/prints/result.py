"""The record of a print, for its report and metrics. SI; NaN: unknown."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array
from cablewright.machine.log.log import LogHead
from cablewright.printing.track import Track
from cablewright.signals import PrintState
from cablewright.studies.fault_count import FaultCount
from cablewright.studies.prints.spooling import SpoolRadii
from cablewright.studies.prints.steps_table import Rows
from cablewright.studies.prints.structure import PrintedStructure
from cablewright.studies.prints.vibration import LineVibration
from cablewright.studies.running_statistics import Histogram, Summary


@dataclass(frozen=True)
class ErrorLocation:
    """Place and time of the largest error."""

    value: float  # m
    time: float  # s
    layer: int
    distance: float  # m along the path
    place: tuple[float, float]  # m, on the path


@dataclass(frozen=True)
class Span:
    """Time span of one state of a print, and the reason for it."""

    state: PrintState
    begin: float  # s
    end: float  # s
    reason: str


@dataclass(frozen=True, eq=False)
class LayerErrors:
    """Cross-track errors for each of v visits of layers, (v,); NaN where nothing was printed."""

    number: NDArray[np.int32]
    begin: Array  # m along the path
    mean: Array  # m
    deviation: Array  # m
    min: Array  # m
    max: Array  # m


@dataclass(frozen=True, eq=False)
class PathFollowing:
    """Path-following errors of all steps that printed. Positive: left of the path."""

    error: Summary  # m, cross-track, from above
    height: Summary  # m, above the target
    speed: Summary  # m/s along the path
    worst: ErrorLocation | None
    by_layer: LayerErrors
    errors: Histogram
    speeds: Histogram


@dataclass(frozen=True)
class LineUse:
    """Load and motion of one line in a print. Shares and tensions are of the steps that printed."""

    name: str
    taut: float  # share of the steps, estimated
    true_taut: float
    mean_tension: float  # N at the sheave, true
    max_tension: float
    believed_mean_tension: float  # N, from the estimated position, while exactly three lines are taut
    believed_max_tension: float
    max_excess: float  # m, estimated
    hours: float  # h, estimated to be taut, in any state
    wound: float  # m of cable wound in and paid out
    irregularity: float  # m: see `spooling`
    true_irregularity: float
    frequency: float  # Hz, median of all windows
    frequency_slope: float  # 1/K: see `vibration`
    frequency_slope_sigma: float


@dataclass(eq=False)
class PrintRecord:
    """The record of a print. Statistics are of every step; `rows` are a subset of the steps, to plot."""

    head: LogHead
    track: Track
    print_speed: float  # m/s, planned
    steps: int
    duration: float  # s
    begin: float  # m along the path, at the start of the log
    distance: float  # m along the path, at the end
    travelled: float  # m, true path of the platform
    layers: int  # finished
    layers_begun: int
    true: PathFollowing
    estimated: PathFollowing  # by the estimates
    estimation_error: Summary  # m: estimated error less true one
    yaw: Summary  # rad, estimated
    tilt: Summary
    temperature: Summary  # degrees Celsius
    humidity: Summary
    states: dict[PrintState, float]  # s
    spans: tuple[Span, ...]
    barrier_stops: int
    refills: int
    faults: FaultCount
    notices: Counter[str]  # steps by condition
    rows: Rows
    lines: tuple[LineUse, ...]
    spools: tuple[SpoolRadii, ...]
    vibration: LineVibration
    structure: PrintedStructure | None
    notes: tuple[str, ...] = ()

    @property
    def has_truth(self) -> bool:
        """Whether the log has the truth."""
        return self.true.error.count > 0

    @property
    def best(self) -> PathFollowing:
        """True errors if known, else estimated ones."""
        return self.true if self.has_truth else self.estimated
