"""Which winch turns the drum of which line: lines may share one, and a counterweight has none."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from cablewright.foundation.arrays import Array, Indices, Mask
from cablewright.robot import Robot


@dataclass(frozen=True, eq=False)
class WinchLines:
    """The w winches of a robot with m lines.

    ``hosts``: (w,) the line that each winch is named for. ``host``: (m,) that of each line, -1 with a counterweight;
    ``winch``: (m,) its place among ``hosts``. ``sense``: (m,) 1: paid out as its host is, -1: wound up then, 0: no
    winch.
    """

    hosts: Indices
    host: Indices
    winch: Indices
    sense: Array

    @classmethod
    def of(cls, robot: Robot) -> Self:
        """Return the assignment of lines to winches of *robot*."""
        hosts, index = list(robot.hosts), {line.name: i for i, line in enumerate(robot.lines)}
        host, sense = np.arange(robot.m), np.ones(robot.m)
        for i, line in enumerate(robot.lines):
            if line.shared_winch is not None:
                host[i], sense[i] = index[line.shared_winch.line], line.shared_winch.sense
        host[list(robot.hung)], sense[list(robot.hung)] = -1, 0.0
        return cls(np.array(hosts), host, np.array([hosts.index(i) if i >= 0 else -1 for i in host.tolist()]), sense)

    @property
    def plain(self) -> bool:
        """Whether each line has a winch of its own."""
        return len(self.hosts) == len(self.host)

    @property
    def alone(self) -> Mask:
        """Mask (m,) of lines with a winch of their own: the torque of its motor is theirs."""
        return np.array([host >= 0 and np.count_nonzero(self.host == host) == 1 for host in self.host])

    @property
    def shared(self) -> Indices:
        """Indices (d,) of the winches with several lines, whose torque is that of all these lines together."""
        return np.flatnonzero(~self.alone[self.hosts])

    @cached_property
    def senses(self) -> Array:
        """Return how each drum winds each line, (w, m): 1, -1 (opposite), or 0 for lines that are not on it."""
        found = np.zeros((len(self.hosts), len(self.host)))
        wound = np.flatnonzero(self.winch >= 0)
        found[self.winch[wound], wound] = self.sense[wound]
        return found

    @cached_property
    def opposed(self) -> Mask:
        """Mask (w,) of drums whose lines are wound in opposite directions, so that their pulls oppose each other."""
        return np.asarray((self.senses == -1.0).any(axis=1))

    def torques(self, tensions: Array, arms: Array) -> Array:
        """Return the torque (..., w), N m, of the cables on each drum; positive pays out.

        *tensions* (..., m), N, of one cable of each line; *arms* (..., m), m: its radius, once for each cable. NaN of a
        line is one of its own drum alone.
        """
        return np.asarray(np.where(self.senses, (tensions * arms)[..., None, :] * self.senses, 0.0).sum(axis=-1))

    def tensions(self, torques: Array, arms: Array, expected: Array) -> Array:
        """Return the tensions (m,), N, nearest to those *expected* (m,), N, with the *torques* (w,), N m.

        That of a line alone on its drum follows from the torque; *arms* (m,) as in `torques`. A counterweight keeps
        what is expected of it. NaN of a line on a drum with another whose tension is expected to be NaN.
        """
        if self.plain:
            return np.asarray(torques / arms)
        per_tension, known = np.where(self.sense, self.sense * arms, 0.0), np.where(self.alone, 0.0, expected)
        missed = (torques - self.torques(known, arms)) / (self.senses**2 @ per_tension**2)
        return np.asarray(known + np.where(self.sense, per_tension * missed[self.winch], 0.0))

    def of_lines(self, turned: ArrayLike) -> Array:
        """Return by how much each line's drum turns, (m,), paying out, when the winches have *turned*, (w,)."""
        return np.asarray(self.sense * np.asarray(turned)[self.winch])
