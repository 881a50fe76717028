"""Which winch turns the drum of which line: lines may share one, and a counterweight has none."""

from __future__ import annotations

from dataclasses import dataclass
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
        """Return those of *robot*."""
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
        """Which lines have a winch for themselves, (m,): the torque of its motor is theirs."""
        return np.array([host >= 0 and np.count_nonzero(self.host == host) == 1 for host in self.host])

    def of_lines(self, turned: ArrayLike) -> Array:
        """Return by how much each line's drum turns, (m,), paying out, as winches have *turned*, (w,)."""
        return np.asarray(self.sense * np.asarray(turned)[self.winch])
