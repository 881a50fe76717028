"""Oracle: the way of a cable over eyelets and grooved wheels that stand still, with 30 digits, all wheels together.

A stop is a point (3,), or a wheel (centre, axis, radius) round which the cable travels with a positive rotation. On a
wheel the cable is a circular arc, and where it comes or leaves it is square to the arm there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from mpmath import mp

DIGITS = 30
NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)

Wheel = tuple[np.ndarray, np.ndarray, float]
Stop = np.ndarray | Wheel


@dataclass(frozen=True)
class Way:
    """Length and mean height (m) of all, contacts by stop (come, leave), and the angle on each stop, rad."""

    length: float
    mean_height: float
    contacts: tuple[tuple[np.ndarray, np.ndarray], ...]
    angles: tuple[float, ...]

    @property
    def comes_from(self) -> np.ndarray:
        """Where the cable leaves the last stop but one."""
        return self.contacts[-2][1]


def way(stops: Sequence[Stop]) -> Way:
    """Return the way over the stops. The first one is a point; a wheel that is the last has no arc."""
    guesses = _guesses(stops)
    with mp.workdps(DIGITS):
        keys = [(i, leaves) for i, stop in enumerate(stops) if isinstance(stop, tuple) for leaves in (0, 1)]
        keys = [key for key in keys if key != (len(stops) - 1, 1)]

        def contacts(turns):
            found = [[_vector(stop), _vector(stop)] if not isinstance(stop, tuple) else [None, None] for stop in stops]
            for (i, leaves), turn in zip(keys, turns, strict=True):
                found[i][leaves] = _rim(stops[i], guesses[i][leaves], turn)
            return found

        def misses(*turns):
            at, out = contacts(turns), []
            for i, leaves in keys:
                one, two = (at[i][1], at[i + 1][0]) if leaves else (at[i - 1][1], at[i][0])
                arm = [p - c for p, c in zip(at[i][leaves], _vector(stops[i][0]), strict=True)]
                out.append(mp.fdot([b - a for a, b in zip(one, two, strict=True)], arm))
            return out

        turns = mp.findroot(misses, [mp.mpf(0)] * len(keys), tol=1e-40) if keys else []
        at = contacts(list(turns))
        at[-1][1] = at[-1][0]
    found = [tuple(np.array([float(x) for x in point]) for point in pair) for pair in at]
    return _measured(stops, found)


def _guesses(stops: Sequence[Stop]) -> list[tuple[np.ndarray, np.ndarray]]:
    """Arms where the cable would come and leave if all other wheels were points."""
    middles = [stop[0] if isinstance(stop, tuple) else stop for stop in stops]
    found = []
    for i, stop in enumerate(stops):
        ways = [middles[i] - middles[max(i - 1, 0)], middles[min(i + 1, len(stops) - 1)] - middles[i]]
        found.append(tuple(_arm(way, stop[1]) for way in ways) if isinstance(stop, tuple) else (stop, stop))
    return found


def _arm(way: np.ndarray, axis: np.ndarray) -> np.ndarray:
    arm = np.cross(way, axis)
    return arm / (np.linalg.norm(arm) or 1.0)


def _vector(point: np.ndarray) -> list:
    return [mp.mpf(float(x)) for x in point]


def _rim(wheel: Wheel, arm: np.ndarray, turn):
    centre, axis, radius = wheel
    e = _vector(arm)
    n = _vector(axis)
    size = mp.sqrt(mp.fdot(n, n))
    n = [x / size for x in n]
    e = [x - mp.fdot(e, n) * y for x, y in zip(e, n, strict=True)]
    size = mp.sqrt(mp.fdot(e, e))
    e = [x / size for x in e]
    f = [n[1] * e[2] - n[2] * e[1], n[2] * e[0] - n[0] * e[2], n[0] * e[1] - n[1] * e[0]]
    return [c + radius * (mp.cos(turn) * x + mp.sin(turn) * y) for c, x, y in zip(_vector(centre), e, f, strict=True)]


def _measured(stops: Sequence[Stop], contacts: list) -> Way:
    length, moment, angles = 0.0, 0.0, []
    for i, (stop, (come, leave)) in enumerate(zip(stops, contacts, strict=True)):
        if i:
            span = float(np.linalg.norm(come - contacts[i - 1][1]))
            length, moment = length + span, moment + 0.5 * span * (come[2] + contacts[i - 1][1][2])
        angle = 0.0
        if isinstance(stop, tuple) and i < len(stops) - 1:
            centre, axis, radius = stop
            axis, arm = axis / np.linalg.norm(axis), (come - centre) / radius
            ahead = np.cross(axis, arm)
            angle = float(np.arctan2((leave - centre) @ ahead, (leave - centre) @ arm) % (2 * np.pi))
            along = 0.5 * angle * (NODES + 1.0)
            heights = centre[2] + radius * (np.cos(along) * arm[2] + np.sin(along) * ahead[2])
            length, moment = length + radius * angle, moment + radius * 0.5 * angle * float(WEIGHTS @ heights)
        angles.append(angle)
    return Way(length, moment / length, tuple(contacts), tuple(angles))
