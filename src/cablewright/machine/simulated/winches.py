"""Simulated winches: motors, and drums with irregularly wound cable, as arrays for the kernels."""

from __future__ import annotations

from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.kernels.plant import winding
from cablewright.machine.coils import coils_of
from cablewright.machine.settings import WinchSettings
from cablewright.machine.simulated.as_built_parts import CROSSINGS, drawn
from cablewright.machine.simulated.settings import Winding
from cablewright.models.coil import turns_per_layer
from cablewright.models.winch_lines import WinchLines
from cablewright.robot import Line, Robot

_Number = TypeVar("_Number", np.float64, np.bool_)
_TRIES: Final = 12  # each reduces the error to the ratio of crossing and radius


class Winches:
    """All winches of a robot. `state` (m, ...) changes in place as kernels turn the drums.

    A row is a line's cable on its drum: see `WinchLines`. That of a line with a counterweight does not move.
    """

    SAVED = ("state", "start_angles")

    def __init__(self, robot: Robot, settings: WinchSettings, walk: Winding, lengths: Array, seed: int) -> None:
        """Wind the drums of *robot*, irregularly by *walk*, with *lengths* (m,), m, paid out.

        Raises `InputError` for a line without drum radius or cable diameter, or more cable out than a winch holds.
        """
        self.settings, self.lines = settings, WinchLines.of(robot)
        self.counts_per_turn = np.array([settings.ratio / winding.TURN, settings.counts])
        walks = {"radius_walk": walk.radius_walk, "sideways_walk": walk.sideways_walk, "memory": walk.walk_turns}
        self.coils = coils_of(robot, settings, seed, **walks)
        turns = min(len(coil.radii) for coil in self.coils if coil is not None)
        self.radii, self.wound, self.sideways = (
            np.array([np.zeros(turns) if coil is None else getattr(coil, column)[:turns] for coil in self.coils])
            for column in ("radii", "wound", "sideways")
        )
        self.motor = np.array([settings.max_speed, settings.lag, settings.max_torque])
        self.state = np.zeros((robot.m, winding.WINCH))
        self.state[:, winding.HELD] = settings.held
        self.state[:, winding.HOST], self.state[:, winding.SENSE] = self.lines.host, self.lines.sense
        for host in self.lines.hosts:
            self.state[host, winding.MATES] = np.count_nonzero(self.lines.host == host) - 1
        for own, line, coil in zip(self.state, robot.lines, self.coils, strict=True):
            own[winding.RATIO], own[winding.HEIGHT] = line.cables, _first_stretch(line)
            own[winding.MIDDLE] = line.winch.drum_radius or (0.0 if coil is None else coil.radii[0])
        self._cross(robot, walk, seed)
        self._pay_out(robot, lengths)
        self.start_angles = self.angles

    def _cross(self, robot: Robot, walk: Winding, seed: int) -> None:
        """Let upper layers cross the turns below them, each drum's at a place of its own by *seed*.

        They begin with the turn in which the cable climbs to the second layer.
        """
        span = walk.crossing_angle / winding.TURN
        places = (1.0 - span) * drawn(seed, CROSSINGS).uniform(0.0, 1.0, robot.m)
        for own, line, place in zip(self.state, robot.lines, places, strict=True):
            diameter = line.cable.diameter or 0.0
            own[winding.CROSSING] = walk.crossing * diameter
            own[winding.CROSSING_FROM] = turns_per_layer(self.settings.width, diameter) - 1
            own[winding.CROSSING_AT], own[winding.CROSSING_SPAN] = place, span

    def _pay_out(self, robot: Robot, lengths: Array) -> None:
        """Turn the drums until *lengths* are paid out; iterates, as detour and crossings depend on the drum's angle."""
        for i, (own, coil, line) in enumerate(zip(self.state, self.coils, robot.lines, strict=True)):
            if coil is None:
                continue
            out = float(lengths[i])
            for _ in range(_TRIES if own[winding.CROSSING] else 4):
                if not self.settings.held >= out:
                    raise InputError(
                        f"winch.held = {self.settings.held:g} m: must be at least {lengths[i]:g} m, the length that "
                        f"line {line.name!r} has paid out at the start; give the winch more cable"
                    )
                own[winding.ANGLE] = coil.angle(self.settings.held - out)
                out += float(lengths[i]) - self.lengths_out()[i]
        hosts = self.state[self.lines.host, winding.ANGLE]
        self.state[:, winding.ZERO] = self.state[:, winding.ANGLE] - self.lines.sense * hosts

    def lengths_out(self) -> Array:
        """Unstrained lengths (m,) from the nominal winch exit points to the platform, m."""
        rows = zip(self.state, self.radii, self.wound, self.sideways, strict=True)
        return np.array([winding.length_out(*row) for row in rows])

    def by_line(self, of_winches: NDArray[_Number]) -> NDArray[_Number]:
        """Convert numbers *of_winches* (w,) to (m,): each at the line that its winch is named for, else zeros."""
        if self.lines.plain:
            return of_winches
        found = np.zeros(len(self.state), dtype=of_winches.dtype)
        found[self.lines.hosts] = of_winches
        return found

    @property
    def angles(self) -> Array:
        """Wound angle of each line's drum, (m,) rad."""
        return np.array(self.state[:, winding.ANGLE])

    @property
    def leaving_radii(self) -> Array:
        """Radius at which each line leaves its drum, (m,) m; 0 without one."""
        found = np.empty(len(self.state))
        winding.leaving(self.state, self.radii, found)
        return found

    @property
    def counts(self) -> NDArray[np.int64]:
        """Counts (w,) of the motors' encoders since the start; paying out is positive."""
        found = np.empty(len(self.lines.hosts), np.int64)
        winding.count(self.state, self.lines.hosts, self.start_angles, self.counts_per_turn, found)
        return found

    def after_load(self) -> None:
        """Raise `InputError` for a loaded drum angle below 0 or above what the drum can hold."""
        last = winding.TURN * (self.radii.shape[1] - 1)
        if not ((self.angles >= 0.0) & (self.angles <= last)).all():
            raise InputError(f"snapshot: a winch drum is wound by less than 0 or more than {last:g} rad")

    @property
    def slipped(self) -> Array:
        """Angle (m,), rad, that drums have paid out against closed brakes; a view."""
        return self.state[:, winding.SLIPPED]

    def set_brakes(self, torques: Array, softness: Array) -> None:
        """Close brakes that hold *torques* (m,), N m, 0: open; *softness* (m,): see `Brakes.close`."""
        self.state[:, winding.BRAKE] = torques
        self.state[:, winding.SOFT] = softness
        self.state[torques == 0.0, winding.PULL : winding.SLIP_BEFORE + 1] = 0.0

    def set_unmodelled(self, ratio: Array, stretch: Array | float, lag: Array | float) -> None:
        """Set the ratio (m,) of drum pull to tension at the platform, *ratio*, and corrections of the length paid out.

        *stretch* (m,): m, of the cable before the sheave by that tension; *lag* (m,): rad, of drums behind motors.
        """
        self.state[:, winding.RATIO] = ratio
        self.state[:, winding.OFFSET] = stretch if not np.any(lag) else stretch - self.leaving_radii * lag


def _first_stretch(line: Line) -> float:
    """Length of the straight cable from the winch to its first fixed point, m; 0 if the winch is not described.

    Of a cable in one vertical plane its height, as its winch is below or above the sheave.
    """
    if line.winch_exit is None:
        return 0.0
    return abs(line.exit_point[2] - line.winch_exit[2]) if line.in_plane else line.dead_span().first.length
