"""Correction of the estimate by measured tensions, from load cells or motor torques."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final, Self

import numpy as np

from cablewright.estimation.body.updates.update import (
    OF_MEDIAN,
    DrumPulls,
    HeldBody,
    Slopes,
    Update,
    UpdatePart,
    middle,
)
from cablewright.foundation.arrays import Array, Indices
from cablewright.foundation.signals import Reading, Tensions
from cablewright.models.rotation import matrix_of

if TYPE_CHECKING:
    from cablewright.estimation.body.estimated_constants import BodyLayout
    from cablewright.estimation.body.settings import BodySettings
    from cablewright.estimation.body.state import BodyState

_LEAST_GAIN: Final = 1e-3  # share: no load cell's scale is known better ...
_LEAST_ZERO: Final = 0.1  # N: ... nor its zero ...
_LEAST_DRIFT: Final = 0.1  # N: ... nor does that stay for an hour
_HOUR: Final = 3600.0  # s
_AT_THE_WINCH: Final = "motor_torques"  # which contain the whole friction of a sheave; a cell on its axle half of that
_ARM: Final = 0.3  # m: arm of the moment that goes with a platform's acceleration


@dataclass(frozen=True)
class Cells(Update):
    """Load cells or torques: standard deviations of noise and zero, N, and of the gain (relative); name of the source.

    ``drift``: N, by which a zero walks in an hour. Without it an estimated zero would count for ever: its later drift
    would be taken for other errors of the machine, in the least known directions. A motor of a drum with several lines
    shows the pull of all: numbers of such drums follow those of the lines, as tensions of the line that each is named
    for, whose gain, zero and friction they have.
    """

    READING: ClassVar[type[Reading]] = Tensions

    source: str
    deviation: float
    zero: float
    gain: float
    drift: float = _LEAST_DRIFT

    @classmethod
    def told(cls, source: str, sheet: Any) -> Self:
        noise, zero = max(sheet.deviation, _LEAST_ZERO), max(sheet.bias, _LEAST_ZERO)
        return cls(source, noise, zero, max(sheet.gain_deviation, _LEAST_GAIN), max(sheet.walk, _LEAST_DRIFT))

    def read(self, settings: BodySettings, state: BodyState, reading: Reading) -> Array | None:
        """Return the tensions (k,) of a reading; see `Update.read`.

        Readings of the other source yield none. A cell that is silent is a fault.
        """
        assert isinstance(reading, Tensions)  # its kind
        if reading.source != self.source:
            return None
        silent, drums = np.isnan(reading.tensions), self._drums(state.wound.drums)
        if self.source == _AT_THE_WINCH:
            silent &= settings.winches.alone
        for i in np.flatnonzero(silent != state.judged.silent):
            name = settings.model.robot.lines[i].name
            what = f"the cell of line {name} gives no reading"
            state.monitor.set("load_cells", f"silent {name}", what, active=bool(silent[i]))
        state.judged.silent = silent
        if drums is None:
            return reading.tensions
        winches, torques = settings.winches, reading.torques
        if torques is None or len(torques) != len(winches.hosts):
            torques = np.full(len(winches.hosts), np.nan)
        return np.concatenate([reading.tensions, torques[winches.shared] / drums.arms])

    def shown(self, there: HeldBody) -> Array:
        return _with_drums(there.tensions, self._drums(there.drums))

    def _drums(self, drums: DrumPulls | None) -> DrumPulls | None:
        """Return the drums that are measured: by motors."""
        return drums if self.source == _AT_THE_WINCH else None

    def _hosts(self, state: BodyState) -> Indices:
        """The line (k,) whose gain, zero and friction each number has."""
        drums, lines = self._drums(state.wound.drums), np.arange(state.layout.m)
        return lines if drums is None else np.concatenate([lines, drums.hosts])

    def as_known(self, state: BodyState, shown: Array) -> Array:
        layout, unknowns, own = state.layout, state.belief.unknowns, self._hosts(state)
        lost = unknowns[layout.friction] * state.wound.sliding
        return np.asarray((1.0 + unknowns[layout.gain] - lost)[own] * shown + unknowns[layout.zero][own])

    def set_prior(self, settings: BodySettings, layout: BodyLayout, variances: Array) -> None:
        variances[layout.gain], variances[layout.zero] = self.gain**2, self.zero**2
        loss = settings.deviations.friction * (2.0 if self.source == _AT_THE_WINCH else 1.0)
        variances[layout.friction] = loss**2

    def walk(self, layout: BodyLayout) -> Array:
        """Return the variances (size,) by which the unknowns drift in a second; see `Update.walk`. Only zeros drift."""
        found = np.zeros(layout.size)
        found[layout.zero] = self.drift**2 / _HOUR
        return found

    def part(
        self, settings: BodySettings, state: BodyState, slopes: Slopes, read: Array, acceleration: float
    ) -> UpdatePart:
        """Return innovations, gradients and noise of the load cells in use; see `Update`."""
        layout, own, drums = state.layout, self._hosts(state), self._drums(state.wound.drums)
        pulls, by_wrench = _with_drums(state.tensions, drums), _with_drums(slopes.tensions_by_wrench, drums)
        used = np.pad(state.judged.cells_used, (0, len(own) - layout.m), constant_values=True)
        cells, rows = np.flatnonzero(used & np.isfinite(read).any(axis=0)), np.arange(len(own))
        gradients = _with_drums(slopes.tensions @ state.belief.gradients, drums)
        gradients[rows, layout.gain.start + own] = pulls
        gradients[rows, layout.zero.start + own] = 1.0
        gradients[rows, layout.friction.start + own] = -pulls * state.wound.sliding[own]
        gradients[:, layout.load] = by_wrench
        each = self.deviation**2 * OF_MEDIAN / len(read) + settings.deviations.model**2
        force = by_wrench[cells] * (settings.model.robot.platform.mass * acceleration)
        force[:, 3:] *= _ARM
        beam = settings.beam_deviation * _with_drums(_by_beam(settings, state, slopes), drums)[cells]
        noise = each * np.eye(len(cells)) + force @ force.T + np.outer(beam, beam) * OF_MEDIAN / len(read)
        return UpdatePart(middle(read[:, cells]), gradients[cells], noise, cells)


def _with_drums(tensions: Array, drums: DrumPulls | None) -> Array:
    """Return *tensions* (m, ...), followed by the pulls on *drums*, (m + d, ...)."""
    return tensions if drums is None else np.concatenate([tensions, drums.per_tension @ tensions])


def _by_beam(settings: BodySettings, state: BodyState, slopes: Slopes) -> Array:
    """Change of the tensions (m,), N/m, with the length of a platform that retracts; zeros of any other."""
    robot = settings.model.robot
    if robot.retraction is None:
        return np.zeros(robot.m)
    moved = np.array([line.name in robot.retraction.lines for line in robot.lines])
    along = matrix_of(state.pose[3:]) @ np.array(robot.retraction.along)
    return np.asarray(-slopes.tensions @ (moved * (state.taut.toward @ along)))
