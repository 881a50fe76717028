"""Lines that share winch drums, as a table for the kernels, and the errors of lengths that do not fit."""

from __future__ import annotations

from itertools import chain, permutations

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array
from cablewright.kernels.shared_winches.quadratic_program import LINE, OFFSET, OTHER, SENSE, SHARES
from cablewright.robot import Robot


def shares(robot: Robot) -> Array:
    """Return the (s, 4) table of the lines on the drums of others: see `kernels.shared_winches.quadratic_program`."""
    names = [line.name for line in robot.lines]
    table = np.zeros((len(robot.sharing), SHARES))
    for row, line in zip(table, robot.sharing, strict=True):
        assert line.shared_winch is not None  # by the definition of `sharing`
        row[LINE], row[OTHER] = names.index(line.name), names.index(line.shared_winch.line)
        row[SENSE], row[OFFSET] = line.shared_winch.sense, line.shared_winch.offset
    return table


def drums(robot: Robot) -> tuple[NDArray[np.int64], Array, Array]:
    """Return hosts (m,), senses (m,) and offsets (m,), m, of all lines: L = offset + sense * L[host].

    The host is the line whose length determines that of a line on the same drum; other lines are their own hosts.
    """
    hosts, senses, offsets = np.arange(robot.m), np.ones(robot.m), np.zeros(robot.m)
    for row in shares(robot):
        line = int(row[LINE])
        hosts[line], senses[line], offsets[line] = int(row[OTHER]), row[SENSE], row[OFFSET]
    return hosts, senses, offsets


def missed_lengths(robot: Robot, lengths: Array) -> Array:
    """Return by how much *lengths* (..., m) are too short for the drums that they share (..., s), m."""
    table = shares(robot)
    own, other = table[:, LINE].astype(int), table[:, OTHER].astype(int)
    return np.asarray(table[:, OFFSET] + table[:, SENSE] * lengths[..., other] - lengths[..., own])


def drum_mates(robot: Robot) -> list[tuple[int, int, float]]:
    """Return pairs of lines on one drum, each in both orders, and 1 or -1: whether they wind along each other."""
    drums: dict[str, list[tuple[int, float]]] = {}
    for index, line in enumerate(robot.lines):
        shared = line.shared_winch
        host, sense = (line.name, 1.0) if shared is None else (shared.line, shared.sense)
        drums.setdefault(host, []).append((index, sense))
    pairs = chain.from_iterable(permutations(members, 2) for members in drums.values())
    return [(i, j, own * other) for (i, own), (j, other) in pairs]
