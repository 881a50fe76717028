"""Settings of the estimator of a rigid platform: its model, its sensors, and their standard deviations."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from cablewright.estimation.body.creep import LOOP
from cablewright.estimation.body.updates.update import Update
from cablewright.estimation.clock_offset import ClockLeadSettings
from cablewright.foundation.errors import InputError, require_positive
from cablewright.models.coil import Coil, LineCoils
from cablewright.models.statics import Model
from cablewright.models.support_table import Capability, require
from cablewright.models.winch_lines import WinchLines


@dataclass(frozen=True)
class Deviations:
    """Standard deviations of the real machine from its description.

    ``home_length``: m, of each line's length where the machine was homed. ``drum_radius``: share of each drum's.
    ``exit_point``: m, of each coordinate. ``mass``: share of the platform's; ``centre``: m, of each coordinate of its
    centre of mass. ``uneven``: m, of a length for irregular winding of the cable on its drum, which changes over
    ``uneven_length``, m, of cable. ``model``: N, of a tension that a perfect description would predict, for effects
    that no model has. ``creep``: strain of each cable after an hour under the mean tension at home, besides the
    described creep; None: see `creep_of`. ``hysteresis``: strain between the ways up and down of a large cycle of
    loads; None: see `loop`. ``exit_compliance``: m/N, compliance of the mount of each exit point besides the described
    one; None: see `prior`. ``friction``: share of a tension by which a cell shows less while cable is paid out over its
    sheave, and more while it is wound.
    """

    home_length: float = 2e-3
    drum_radius: float = 3e-3
    exit_point: float = 1e-3
    mass: float = 5e-3
    centre: float = 2e-3
    uneven: float = 2e-4
    uneven_length: float = 2.0
    model: float = 0.5
    creep: float | None = None
    hysteresis: float | None = None
    friction: float = 0.01
    exit_compliance: float | None = None

    def __post_init__(self) -> None:
        """Raise `InputError` for numbers that are not positive and finite."""
        require_positive(**{name: value for name, value in vars(self).items() if value is not None})

    @property
    def loop(self) -> float:
        """Strain by hysteresis: as stated, else the assumed one, that of the severity `typical`."""
        return LOOP if self.hysteresis is None else self.hysteresis


@dataclass(frozen=True, eq=False)
class BodySettings:
    """Settings of the body filter: the machine as its files describe it.

    ``counts_per_radian``: encoder counts for a radian of a winch drum. ``coils``: each line's cable on its winch drum,
    wound regularly; None: the line has no winch. ``total_length``: length of a winch's cable, wound and paid out, m.
    ``max_drum_speed``: highest speed of a winch drum, rad/s. ``sensors``: data of the sensors that are used besides
    encoders, in the order of `UPDATES`. ``beam_deviation``: standard deviation of a reading of the length of a platform
    that retracts, m.
    ``interval``: duration of the readings that make one measurement, s. ``smoothing_time``: time over which the
    velocity is smoothed, s. ``slack_threshold``: excess of length from which a line counts as slack, m. ``clock``:
    settings of the clock on the platform, which stamps messages over the wireless link; None: the machine's clock does.
    ``cells``: source of tensions that are read but correct nothing, where the pose is by encoders alone; None: no
    tensions are read.
    """

    model: Model
    counts_per_radian: float
    coils: tuple[Coil | None, ...]
    total_length: float
    max_drum_speed: float
    deviations: Deviations = field(default_factory=Deviations)
    sensors: tuple[Update, ...] = ()
    beam_deviation: float = 0.0
    timeouts: dict[str, float] = field(default_factory=lambda: {"encoders": 0.5})
    interval: float = 0.1
    smoothing_time: float = 0.2
    slack_threshold: float = 2.5e-3
    clock: ClockLeadSettings | None = None
    cells: str | None = None

    def __post_init__(self) -> None:
        """Reject point platforms, and another number of coils than lines."""
        if self.model.n != 6 or len(self.coils) != self.model.m:
            raise InputError(f"robot {self.model.robot.name!r}: a rigid platform and a coil for each line are expected")
        require(self.model, Capability.ESTIMATION)
        require_positive(interval=self.interval, smoothing_time=self.smoothing_time, max_drum_speed=self.max_drum_speed)

    @cached_property
    def drums(self) -> LineCoils:
        """The coils of the lines' cables on their winch drums."""
        return LineCoils(self.coils, self.total_length)

    @cached_property
    def winches(self) -> WinchLines:
        """The winches, whose encoders are read."""
        return WinchLines.of(self.model.robot)
