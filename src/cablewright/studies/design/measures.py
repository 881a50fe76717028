"""Figures by which a candidate design is judged: of its part, its workspace, and the robot itself."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, Final

import numpy as np

from cablewright.analyses.accuracy.spread import drawn
from cablewright.analyses.feasibility import LIMITS, TENSION_LIMITS, LineQuantities
from cablewright.analyses.interference import distances
from cablewright.analyses.modes import modes
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.results import Figure
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.robot.uncertainty import assumed_uncertainty
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import linearise_where_regular
from cablewright.solvers.parameter_effects import at_nozzle, departures, range_response
from cablewright.studies.trade import Combination, TradeSettings, found_for

MACHINES: Final = 500
"""Machines that are drawn for the expected error."""

LEVEL: Final = 0.95


@dataclass(frozen=True)
class Prices:
    """Prices in any one currency: of a metre of ``cable``, a ``winch``, and a newton metre of a winch's ``torque``."""

    cable: float = 0.0
    winch: float = 0.0
    torque: float = 0.0

    @classmethod
    def of(cls, given: Mapping[str, float]) -> Prices:
        """Return prices by name. Raises `InputError` for one that is unknown, negative or not finite."""
        names = [each.name for each in fields(cls)]
        for name, value in given.items():
            if name not in names:
                raise UnknownName("price", name, names)
            if not (value >= 0.0 and math.isfinite(value)):
                raise InputError(f"price of {name} = {value:g}: must be a finite number of 0 or more")
        return cls(**given)


@dataclass(frozen=True, eq=False)
class DesignCandidate:
    """A candidate robot with its task: poses (k, n) along a part, retraction lengths (k,) or None, or no part."""

    robot: Robot
    poses: Array | None
    retraction: Array | None
    workspace: TradeSettings
    seed: int
    prices: Prices = Prices()

    @cached_property
    def held(self) -> Equilibrium:
        """Equilibria of the platform at the poses, under the full model."""
        assert self.poses is not None
        return solve_inverse(Model.full(self.robot), self.poses, retraction=self.retraction)

    @cached_property
    def lines(self) -> LineQuantities:
        """Quantities of the lines that have limits, at the poses; NaN where a pose is not held."""
        return LineQuantities.of(self.held)

    @cached_property
    def good(self) -> Equilibrium:
        """Mask of the poses with an equilibrium. Raises `InputError` if there is none."""
        found = self.held[self.held.holds]
        if not len(found.pose):
            raise InputError("the lines cannot hold the platform at any position of the part")
        return found

    @cached_property
    def shortfalls(self) -> dict[str, float]:
        """Violation of each limit of the hardware at its worst position, as a share of it; 0: it holds.

        That of poses which cannot be held is their share.
        """
        if self.poses is None:
            return {}
        found = {"held": float(np.mean(~self.held.holds))}
        for limit in LIMITS:
            allowed, values = limit.allowed(self.robot.lines), limit.values(self.lines)
            beyond = np.maximum(allowed[:, 0] - values, values - allowed[:, 1])
            size = np.where(np.isfinite(allowed), np.abs(allowed), 0.0).max(axis=1)
            worst = np.nan_to_num(beyond / np.where(size > 0.0, size, 1.0), nan=0.0)
            found[limit.name] = max(0.0, float(worst.max(initial=0.0)) - _ROUNDING)
        return found

    @cached_property
    def combination(self) -> Combination:
        """Workspace, frequencies along its boundary and distance of exit points, as `trade` computes them."""
        return found_for(Model(self.robot, Fidelity.of(CableLaw.ELASTIC)), (), self.workspace)


_ROUNDING: Final = 1e-9  # a distribution at its limit meets it only to rounding


def _tension_margin(of: DesignCandidate) -> float:
    margins = []
    for limit in LIMITS:
        if limit.name in TENSION_LIMITS:
            allowed, values = limit.allowed(of.robot.lines), limit.values(of.lines)
            margins.append(np.nanmin(np.minimum(values - allowed[:, 0], allowed[:, 1] - values)))
    return float(min(margins))


def _expected_error(of: DesignCandidate) -> float:
    """The 95th percentile of drawn machines' largest error, to first order, as `check` has it without interpolation."""
    ranges = (of.robot.uncertainty or assumed_uncertainty(of.robot)).of(of.robot)
    linear, codes = linearise_where_regular(of.good)
    held, linear = of.good[codes == 0], linear[codes == 0]
    parameters = [each.parameter for each in ranges]
    effects = at_nozzle(held, range_response(held, ranges, linear))  # (k, 3, p)
    off = departures(parameters, np.array([each.nominal for each in ranges]), drawn(ranges, MACHINES, of.seed))
    largest = np.zeros(MACHINES)
    for each in effects:  # place by place, so that memory is bounded and no sum depends on how many there are
        np.maximum(largest, ((each @ off.T) ** 2).sum(axis=0), out=largest)
    return float(np.sqrt(np.quantile(largest, LEVEL, method="inverted_cdf")))


def _cable_length(of: DesignCandidate) -> float:
    return float(np.nanmax(of.held.lengths, axis=0).sum())


def _cost(of: DesignCandidate) -> float:
    """Raises `InputError` for torques that cost something but are not known."""
    prices = of.prices
    found = prices.cable * _cable_length(of) + prices.winch * of.robot.winches
    if not prices.torque:
        return found
    torques = np.fmax.reduce(of.lines.winch_torque, axis=0)  # (m,)
    names = [line.name for line in of.robot.lines]
    for line in of.robot.sharing:  # its drum is paid once, by the larger torque in either direction
        assert line.shared_winch is not None  # by the definition of `sharing`
        own, drum = names.index(line.name), names.index(line.shared_winch.line)
        torques[drum], torques[own] = max(torques[drum], torques[own]), 0.0
    torques[list(of.robot.hung)] = 0.0
    if not np.isfinite(torques).all():
        raise InputError("cost: torque has a price, but a winch without drum_radius has none")
    return found + prices.torque * float(torques.sum())


def _clearance(of: DesignCandidate) -> float:
    return float(np.fmin.reduce(distances(of.good).margins, axis=None))


def _largest(path: str) -> Callable[[DesignCandidate], float]:
    return lambda of: float(np.fmax.reduce(getattr(of.lines, path), axis=None))


@dataclass(frozen=True)
class Measure:
    """A figure of a candidate design; ``higher``: whether more of it is better; ``of_part``: whether it needs a job."""

    figure: Figure
    higher: bool
    of_part: bool
    scale: float
    """A difference of it that matters, for comparing how far different constraints are from being met."""

    @property
    def key(self) -> str:
        """Name of the figure that rates a design."""
        return self.figure.key

    def of(self, candidate: DesignCandidate) -> float:
        """Return the value of the figure for a candidate design; NaN if it is unknown."""
        value = self.figure.of(candidate)
        return float("nan") if value is None else float(value)


def _part(key: str, unit: str, meaning: str, value: Any, higher: bool, scale: float, shown: str = "") -> Measure:
    return Measure(Figure(key, unit, meaning, value, shown=shown), higher, True, scale)


def _whole(key: str, unit: str, meaning: str, value: Any, higher: bool, scale: float, shown: str = "") -> Measure:
    return Measure(Figure(key, unit, meaning, value, shown=shown), higher, False, scale)


_ALL: Final = (
    _part("tension_margin", "N", "Smallest distance of a tension from its line's limits, over the part, at rest.",
          _tension_margin, True, 10.0, "N"),
    _part("min_tension", "N", "Smallest tension, anywhere along a line.",
          lambda of: float(np.fmin.reduce(of.lines.lowest_tension, axis=None)), True, 10.0, "N"),
    _part("max_tension", "N", "Largest tension, anywhere along a line.", _largest("highest_tension"), False, 100.0,
          "N"),
    _part("expected_error", "m", "Error that 95 of 100 machines within the uncertainties stay below over the part, to "
          "first order.", _expected_error, False, 1e-3, "mm"),
    _part("lowest_frequency", "Hz", "Smallest natural frequency of the platform over the part.",
          lambda of: float(np.nanmin(modes(of.good).lowest)), True, 0.1),
    _part("clearance", "m", "Smallest distance of a line from another, the platform and the frame; not from the part.",
          _clearance, True, 0.01, "mm"),
    _part("max_torque", "N m", "Largest torque at a drum.", _largest("winch_torque"), False, 10.0),
    _part("cable_length", "m", "Cable that the lines need for the part: the largest length of each, summed up.",
          _cable_length, False, 1.0, "m"),
    _part("cost", "1", "Cost of the cable that the part needs, of the winches, and of the largest torque of each, by "
          "the prices given.", _cost, False, 1.0),
    _whole("volume", "m^3", "Volume of the workspace, by the nodes of a grid.", "combination.volume", True, 0.1),
    _whole("boundary_frequency", "Hz", "Smallest lowest frequency along the boundary of the workspace.",
           "combination.least", True, 0.1),
    _whole("exit_distance", "m", "Smallest distance of two exit points.", "combination.exit_distance", True, 0.01, "m"),
    _whole("frame_height", "m", "Height of the highest exit point above the frame's floor.",
           lambda of: max(line.exit_point[2] for line in of.robot.lines) - of.robot.scene.frame_min[2], False, 0.1,
           "m"),
)  # fmt: skip

MEASURES: Final = {each.key: each for each in _ALL}
"""Figures of candidates, by name."""


def measured(candidate: DesignCandidate, keys: Iterable[str]) -> dict[str, float]:
    """Return figures of a candidate design by name. Raises the errors of their analyses."""
    return {key: MEASURES[key].of(candidate) for key in keys}
