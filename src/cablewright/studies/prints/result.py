"""What came of a print: the values that its record, report and metrics are made of. SI; NaN is not known."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cablewright.machine.log.log import LogHead
from cablewright.printing.track import Track
from cablewright.signals import PrintState
from cablewright.studies.fault_count import FaultCount
from cablewright.studies.prints.spooling import SpoolRadii
from cablewright.studies.prints.steps_table import Columns
from cablewright.studies.prints.structure import PrintedStructure
from cablewright.studies.prints.vibration import LineVibration
from cablewright.studies.running_statistics import Histogram, Summary

__all__ = ["ErrorLocation", "LayerErrors", "LineUse", "PathFollowing", "PrintRecord", "Span"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ErrorLocation:
    """Where and when an error was largest."""

    value: float  # m
    time: float  # s
    layer: int
    distance: float  # m along the path
    place: tuple[float, float]  # m, of the path


@dataclass(frozen=True)
class Span:
    """How long a print was in one state, and why it was if it did not print."""

    state: PrintState
    begin: float  # s
    end: float  # s
    reason: str


@dataclass(frozen=True, eq=False)
class LayerErrors:
    """Cross-track errors by visit of a layer, (v,); NaN where nothing was printed."""

    number: NDArray[np.int32]
    begin: Array  # m along the path
    mean: Array  # m
    deviation: Array  # m
    min: Array  # m
    max: Array  # m


@dataclass(frozen=True, eq=False)
class PathFollowing:
    """How well the path was followed, of all steps that printed. Errors are positive left of the path."""

    error: Summary  # m beside the path, seen from above
    height: Summary  # m over what was wanted
    speed: Summary  # m/s along the path
    worst: ErrorLocation | None
    by_layer: LayerErrors
    errors: Histogram
    speeds: Histogram


@dataclass(frozen=True)
class LineUse:
    """What one line bore and did. Shares and tensions are of the steps that printed."""

    name: str
    taut: float  # share by the estimation
    true_taut: float
    mean_tension: float  # N at the sheave, true
    max_tension: float
    believed_mean_tension: float  # N, while three lines alone hold the drum where it is believed to be
    believed_max_tension: float
    max_excess: float  # m, by the estimation
    hours: float  # h in which it was taut by the estimation, whatever the state
    wound: float  # m of cable that the drum took in and paid out
    irregularity: float  # m: see `print_coil`
    true_irregularity: float
    frequency: float  # Hz, middle of all windows
    frequency_slope: float  # 1/K: see `print_vibration`
    frequency_slope_sigma: float


@dataclass(eq=False)
class PrintRecord:
    """All that is told of a print. Moments are of every step; `rows` are some of them, to draw."""

    head: LogHead
    track: Track
    print_speed: float  # m/s, wanted
    steps: int
    duration: float  # s
    begin: float  # m along the path, where this log begins
    distance: float  # m along the path, where it ends
    travelled: float  # m that the platform truly went
    layers: int  # that were finished
    layers_begun: int
    true: PathFollowing
    estimated: PathFollowing  # as the estimation believed
    estimation_error: Summary  # m: believed error less true one
    yaw: Summary  # rad, by the estimation
    tilt: Summary
    temperature: Summary  # degrees Celsius
    humidity: Summary
    states: dict[PrintState, float]  # s
    spans: tuple[Span, ...]
    barrier_stops: int
    refills: int
    faults: FaultCount
    notices: Counter[str]  # steps by condition
    rows: Columns
    drawn: dict[
        str, Array
    ]  # of the rows: `offset`, `seen_offset`, `speed`, `seen_speed` (k,); `taut`, `believed` (k, m)
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
        """The true one where it is known."""
        return self.true if self.has_truth else self.estimated
