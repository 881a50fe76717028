"""The record of a print, for its report and metrics. SI; NaN: unknown."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array
from cablewright.foundation.results import Figure, Result
from cablewright.foundation.signals import PrintState
from cablewright.live.fault_count import FaultCount, fault_figures
from cablewright.live.prints.spooling_regularity import SpoolRadii
from cablewright.live.prints.steps_table import Rows
from cablewright.live.prints.structure import PrintedStructure
from cablewright.live.prints.tracking_errors import WholeErrors
from cablewright.live.prints.vibration import VibrationRecord
from cablewright.machine.log.head import LogHead
from cablewright.printing.arc_length_path import Track
from cablewright.running.running_statistics import Histogram, Summary


@dataclass(frozen=True, repr=False)
class ErrorLocation(Result):
    """Position and time of a print's largest error."""

    FIGURES: ClassVar = (
        Figure("value", "m", "The error, positive left of the path.", name="error", shown="mm"),
        Figure("time", "s", "Time of the step.", shown="s"),
        Figure("layer", "", "Layer, counted from 1; 0 before the first."),
        Figure("distance", "m", "Distance along the path.", shown="m"),
        Figure("place", "m", "Place on the path: x and y, world.", shown="m"),
    )

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


@dataclass(frozen=True, repr=False)
class StateUse(Result):
    """Time that a print spent in one state, and how often."""

    FIGURES: ClassVar = (
        Figure("state", "", "State of the print."),
        Figure("time", "s", "Time in it."),
        Figure("share", "1", "Share of the duration.", shown="%", digits=3),
        Figure("times", "1", "How many times the print was in it."),
        Figure("reasons", "", "Why, at most four reasons.", name="why"),
    )

    state: PrintState
    time: float
    share: float
    times: int
    reasons: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class LayerErrors:
    """Cross-track errors for each of v visits of layers, (v,), m; NaN where nothing was printed."""

    number: NDArray[np.int32]
    begin: Array  # m along the path
    mean: Array  # m
    deviation: Array  # m
    min: Array  # m
    max: Array  # m


@dataclass(frozen=True, eq=False, repr=False)
class PathFollowing(Result):
    """Path-following errors of all steps that printed. Positive: left of the path. m."""

    FIGURES: ClassVar = (
        Figure("mean_path_error", "m", "Mean distance beside the path, seen from above; left of it is positive.",
               "error.mean", shown="mm"),
        Figure("path_error_variance", "m^2", "Variance of the distance beside the path.", "error.variance",
               shown="mm^2"),
        Figure("path_error_deviation", "m", "Standard deviation of the distance beside the path.", "error.deviation",
               detail=True, shown="mm"),
        Figure("max_path_error", "m", "Largest distance beside the path.", "error.size", shown="mm"),
        Figure("worst_place", "", "Where and when the distance beside the path was largest; null where it is not "
               "known.", "worst", parts=ErrorLocation.FIGURES, detail=True),
        Figure("mean_height_error", "m", "Mean height above the target.", "height.mean", detail=True, shown="mm"),
        Figure("height_error_variance", "m^2", "Variance of the height above the target.", "height.variance",
               detail=True, shown="mm^2"),
        Figure("height_error_deviation", "m", "Standard deviation of the height above the target.", "height.deviation",
               detail=True, shown="mm"),
        Figure("max_height_error", "m", "Largest height above or below the target.", "height.size", shown="mm"),
        Figure("mean_error_in_space", "m", "Mean distance from the path: beside it, and above or below the target.",
               "space.mean", shown="mm"),
        Figure("max_error_in_space", "m", "Largest distance from the path.", "space.max", shown="mm"),
        Figure("mean_speed", "m/s", "Mean speed along the path.", "speed.mean", shown="mm/s"),
        Figure("speed_variance", "m^2/s^2", "Variance of the speed along the path.", "speed.variance",
               shown="mm^2/s^2"),
        Figure("steps_printing", "1", "Number of steps that printed at a known position.", "error.count", detail=True),
    )  # fmt: skip

    error: Summary  # m, cross-track, from above
    height: Summary  # m, above the target
    space: Summary  # m, distance from the path in space
    speed: Summary  # m/s along the path
    worst: ErrorLocation | None
    by_layer: LayerErrors
    errors: Histogram
    speeds: Histogram


@dataclass(frozen=True, repr=False)
class LineUse(Result):
    """Load and motion of one line in a print. Shares and tensions are of the steps that printed."""

    FIGURES: ClassVar = (
        Figure("name", "", "Name of the line.", name="line"),
        Figure("taut", "1", "Share of the steps in which the line was estimated to be taut.", shown="%", digits=3),
        Figure("true_taut", "1", "Share of the steps in which it was taut.", name="truly taut", shown="%", digits=3),
        Figure("mean_tension", "N", "Mean true tension at the sheave.", name="true mean tension", shown="N", digits=3),
        Figure("max_tension", "N", "Largest true tension at the sheave.", name="true max tension", shown="N",
               digits=3),
        Figure("estimated_mean_tension", "N", "Mean tension at the estimated position, while only three lines are "
               "taut.", "believed_mean_tension", "estimated mean tension", shown="N", digits=3),
        Figure("estimated_max_tension", "N", "Largest tension at the estimated position, while only three lines are "
               "taut.", "believed_max_tension", "estimated max tension", shown="N", digits=3),
        Figure("max_excess", "m", "Largest estimated excess over a taut line.", shown="mm", digits=3),
        Figure("hours", "h", "Time that the line was estimated to be taut, in any state.", name="taut for", digits=3),
        Figure("wound", "m", "Cable that was wound in and paid out.", name="cable wound", shown="m"),
        Figure("irregularity", "m", "Standard deviation of the estimated radius at which cable leaves the drum from "
               "that of an even coil.", name="coil irregular by", shown="mm", digits=3),
        Figure("true_irregularity", "m", "The same of the true radius.", name="truly irregular by", shown="mm",
               digits=3),
        Figure("frequency", "Hz", "Median of the line's first frequency."),
        Figure("frequency_slope", "1/K", "Change of the frequency relative to that of a string with the temperature.",
               name="frequency by temperature", shown="% per K", digits=3),
        Figure("frequency_slope_sigma", "1/K", "Standard deviation of that change.", name="its sigma", shown="% per K",
               digits=3),
    )  # fmt: skip

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


def _is_simulated(found: PrintRecord) -> bool:
    return found.head.severity is not None


def _of(who: str, prefix: str) -> tuple[Figure, ...]:
    """The figures of `PathFollowing` of one attribute of a record, by keys with a *prefix*."""
    return tuple(
        replace(each.of_part(who), key=f"{prefix}{each.key}", meaning=f"{each.meaning[:-1]} ({who}).")
        for each in PathFollowing.FIGURES
    )


def _range(key: str, unit: str, meaning: str, shown: str) -> Figure:
    """Mean, min and max of a figure."""
    parts = tuple(
        Figure(part, unit, f"{word} value; null where it is not known.", shown=shown)
        for part, word in (("mean", "Mean"), ("min", "Smallest"), ("max", "Largest"))
    )
    return Figure(key, unit, meaning, parts=parts, detail=True)


@dataclass(frozen=True, eq=False, repr=False)
class PrintRecord(Result):
    """The record of a print. Statistics are of every step; `rows` are a subset of the steps, to plot."""

    FIGURES: ClassVar = (
        Figure("layers", "1", "Number of layers finished."),
        Figure("layers_begun", "1", "Number of layers begun.", detail=True),
        Figure("distance", "m", "Distance along the path, travel included.", lambda of: of.distance - of.begin,
               "path with travel", shown="m"),
        Figure("end", "m", "Distance along the path at which the print ended.", "distance", detail=True),
        Figure("travelled", "m", "True path of the platform; null where it is not known.", detail=True, shown="m"),
        Figure("steps", "1", "Number of steps in the log.", detail=True),
        Figure("duration", "s", "Duration of the print on the machine's clock."),
        *(each.of_part("whole") for each in WholeErrors.FIGURES),
        *_of("true", ""),
        *_of("estimated", "estimated_"),
        Figure("mean_estimation_error", "m", "Mean of the estimated less the true distance beside the path.",
               "estimation_error.mean", detail=True, shown="mm"),
        Figure("estimation_error_variance", "m^2", "Variance of the estimated less the true distance beside the path.",
               "estimation_error.variance", detail=True, shown="mm^2"),
        Figure("severity", "", "Deviations of the simulated machine from its description: ideal, typical, rough, "
        "or own numbers.", "head.severity", only=_is_simulated),
        Figure("built", "", "What that says of the machine as built.", "head.built", "as built", only=_is_simulated),
        Figure("print_speed", "m/s", "Speed that the job requires.", shown="mm/s", name="required speed", detail=True),
        _range("yaw", "rad", "Estimated yaw of the drum.", "deg"),
        _range("tilt", "rad", "Estimated angle of the drum's axis from the vertical.", "deg"),
        _range("temperature", "°C", "Temperature of the room.", "°C"),
        _range("humidity", "1", "Relative humidity of the room.", "%"),
        Figure("states", "s", "Time in each state, by state."),
        Figure("barrier_stops", "1", "Number of stops by the light barrier.", name="stops by the light barrier"),
        Figure("refills", "1", "Number of refills of the drum."),
        Figure("faults", "", "Faults that the estimates reported.", lambda of: list(of.faults.items()),
               name="sensor messages", parts=fault_figures("since", "until")),
        Figure("notices", "1", "Number of steps with each notice of the machine, by notice.",
               name="steps with a notice", detail=True),
        Figure("lines", "", "Load and motion of each line.", parts=LineUse.FIGURES, detail=True),
        Figure("structure", "", "The printed structure; null where nothing of it is known.",
               parts=PrintedStructure.FIGURES),
        Figure("notes", "", "Errors of the log, and where the record says less than it seems.", detail=True),
    )  # fmt: skip

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
    whole: WholeErrors
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
    vibration: VibrationRecord
    structure: PrintedStructure | None
    log_notes: tuple[str, ...] = ()

    @property
    def notes(self) -> tuple[str, ...]:
        """Errors of the log, and limitations of the record."""
        return self.log_notes if self.structure is None else (*self.log_notes, *self.structure.notes)

    @property
    def has_truth(self) -> bool:
        """Whether the log has the true state of a simulated machine."""
        return self.true.error.count > 0

    @property
    def best(self) -> PathFollowing:
        """Errors of the true position if known, else of the estimated one."""
        return self.true if self.has_truth else self.estimated

    def state_uses(self) -> list[StateUse]:
        """Time, share, number and reasons of each state."""
        whole, found = max(sum(self.states.values()), 1e-9), []
        for state, time in self.states.items():
            spans = [span for span in self.spans if span.state is state]
            reasons = tuple(dict.fromkeys(span.reason for span in spans if span.reason))[:4]
            found.append(StateUse(state, time, time / whole, len(spans), reasons))
        return found
