"""Atlases of a machine's lines: all shapes that they can have with given lengths, as `exhaustive` needs them."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cablewright.errors import AnswerError, InputError
from cablewright.kernels import layout
from cablewright.kernels.certificates import line_cell
from cablewright.kernels.certificates.exclusion import Atlases
from cablewright.kernels.certificates.line_cover import FULL, atlas_work, cover
from cablewright.models.statics import Equilibrium, Model
from cablewright.progress import Progress

__all__ = ["atlases", "known_of", "refuse_unfit"]

Array = NDArray[np.float64]

ROOM = 1 << 16  # leaves of a line, doubled as often as it takes
MOST_ROOM = 1 << 21
GRAINS = ((0.025, 0.012, 0.025, 0.006), (0.025, 0.025, 0.02, 0.012), (0.1, 0.25, 0.02, 0.012))
"""Widest and least leaf, by zone: near the tension that only just carries the dead span, up to three times it, above.

In rad and log tension, widest before least."""
FINER = 0.5  # from level to level, of the first two
LEAST_SHARE = 0.05  # of its own weight: under this tension at its sheave a line without dead span is not looked into
BARE = 0.999  # of the dead span's weight as it is stretched: no tension at the sheave is less


def refuse_unfit(model: Model, lengths: Array) -> None:
    """Raise `InputError` for a machine or lengths that atlases do not cover."""
    if model.n != 3:
        raise InputError("exhaustive: only for a point load; a body's equilibria are found by many starts alone")
    for line, row, length in zip(model.robot.lines, model.packed.lines, lengths, strict=True):
        modelled = row[layout.UNKNOWNS] > 3.0
        steep = row[layout.WINCH_Z] < 0.0 and -row[layout.WINCH_Z] >= abs(row[layout.WINCH_X])
        if modelled and not steep:
            raise InputError(f"exhaustive: line {line.name}: its dead span has to go down at 45 degrees or more")
        if modelled and not -row[layout.WINCH_Z] > row[layout.LEVER] + row[layout.RADIUS]:
            raise InputError(f"exhaustive: line {line.name}: its winch exit has to be lower than its lever reaches")
        if not row[layout.FREE_COMPLIANCE] > 0.0:
            raise InputError(f"exhaustive: line {line.name}: its cable has to stretch")
        if not length - _most_dead(row) > 0.0:
            raise InputError(f"exhaustive: line {line.name}: {length:g} m is too short to leave its sheave in any pose")


def atlases(
    found: Equilibrium,
    lengths: Array,
    box: Array,
    view: Array,
    level: int,
    progress: Progress | None = None,
) -> Atlases:
    """Atlases of the lines of *found*, (K,) equilibria of *lengths* (m,), which are known for certain.

    *box* (6,): x, y, z of the places asked about, low and high, m; *view* (6,): of those still open, which are resolved
    finer. *level*: 0, 1, ... ever finer. Raises `AnswerError` where they take too much memory.
    """
    packed = found.model.packed
    exits = packed.lines[:, :3] - packed.lines[:, 3:6]
    done: list[tuple[Array, Array]] = []

    def one(i: int) -> tuple[Array, Array]:
        return _leaves(packed.lines[i], float(lengths[i]), _seen(box, exits[i]), _seen(view, exits[i]), level)

    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        for part in pool.map(one, range(len(lengths))):
            done.append(part)
            if progress:
                progress("shapes of the lines", len(done), len(lengths))
    leaves = np.concatenate([part[0] for part in done])
    offsets = np.array([0, *np.cumsum([len(part[0]) for part in done])])
    free = np.stack([_free_by_label(part[0]) for part in done])
    labels, known = known_of(found)
    platform = packed.platform
    load = platform[layout.WRENCH : layout.WRENCH + 3] - [0.0, 0.0, platform[layout.PLATFORM_WEIGHT]]
    weights = packed.lines[:, layout.WEIGHT].copy()
    return Atlases(exits, weights, load, leaves, offsets, free, np.stack([part[1] for part in done]), labels, known)


def known_of(found: Equilibrium) -> tuple[NDArray[np.int64], Array]:
    """Labels (K, m) and numbers (K, m, 4) of equilibria whose dead spans hang taut; see `Atlases`."""
    rows, states = found.model.packed.lines, found.states
    t, phi, psi, beta = (
        np.exp(states[..., layout.TAU]),
        states[..., layout.PHI],
        states[..., layout.PSI],
        states[..., layout.BETA],
    )
    h, v = t * np.cos(phi), t * np.sin(phi)
    has_lever, has_dead = rows[:, layout.UNKNOWNS] == 6.0, rows[:, layout.UNKNOWNS] > 3.0
    pull = rows[:, layout.LEVER_MOMENT] / (np.where(has_lever, rows[:, layout.LEVER], 1.0) * t)
    stands = has_lever & (pull * np.sin(beta) - np.cos(phi - beta) - np.cos(psi - beta) > 0.0)
    rises = has_dead & (t * np.sin(psi) + rows[:, layout.WEIGHT] * states[..., layout.DEAD] > -1e-6 * t)
    usual = ~rises.any(axis=1) & (np.abs(phi) < np.pi).all(axis=1)
    away = found.pose[:, None, :3] - (rows[:, :3] - rows[:, 3:6])
    end = v + rows[:, layout.WEIGHT] * states[..., layout.FREE]
    known = np.stack([h, end, away[..., 0], away[..., 1]], axis=-1)
    return stands[usual].astype(np.int64), np.ascontiguousarray(known[usual])


def _seen(box: Array, exit_point: Array) -> Array:
    """Least and largest horizontal distance and height of a box from an exit point, m."""
    low, high = box[::2] - exit_point, box[1::2] - exit_point
    near = np.maximum(np.maximum(low, -high), 0.0)
    far = np.maximum(np.abs(low), np.abs(high))
    more = 1e-6
    return np.array([np.hypot(near[0], near[1]) - more, np.hypot(far[0], far[1]) + more, low[2] - more, high[2] + more])


def _most_dead(row: Array) -> float:
    """More than any taut dead span and the contact take of a line's length: a span that only goes down and one way."""
    if row[layout.UNKNOWNS] == 3.0:
        return float(row[layout.DEAD_LENGTH] + 2.0 * np.pi * row[layout.RADIUS])
    spans = abs(row[layout.WINCH_X]) + abs(row[layout.WINCH_Z]) + 2.0 * (row[layout.LEVER] + row[layout.RADIUS])
    return float(spans + 2.0 * np.pi * row[layout.RADIUS])


def _tensions(row: Array, length: float, far: float) -> Array:
    """Ends of the zones of tension at the sheave, N: the last is more than any within *far* (m) of the exit point."""
    weight, compliance = row[layout.WEIGHT], row[layout.FREE_COMPLIANCE]
    free = length - _most_dead(row)
    least = LEAST_SHARE * weight * length
    around = row[layout.LEVER] + row[layout.RADIUS]
    zones = [least, 60.0 * least]
    if row[layout.UNKNOWNS] > 3.0:
        depth = -row[layout.WINCH_Z]
        full = 1.04 * weight * (depth + row[layout.LEVER])
        stretched = 1.0 + row[layout.DEAD_COMPLIANCE] * weight * depth
        zones = [BARE * weight * (depth - around) / stretched, full, 3.0 * full]
    most = max(2.0 * zones[-1], 10.0 * weight * length)
    # a span goes at least so far along its own start: its weight never turns it back
    while (compliance * most * free + free) * (most - weight * free) / (most + weight * free) < far + around:
        most *= 1.05
    return np.array([*zones, most])


def _leaves(row: Array, length: float, seen: Array, view: Array, level: int) -> tuple[Array, Array]:
    """Leaves of one line, and the tensions that they cover."""
    row = np.ascontiguousarray(row)
    zones = _tensions(row, length, float(np.hypot(seen[1], np.abs(seen[2:]).max())))
    grains = GRAINS if len(zones) == 4 else GRAINS[1:]
    widest = (2.0 if row[layout.RADIUS] > 0.0 else 1.0) * np.pi
    psi, beta = (np.pi if row[layout.UNKNOWNS] > count else 0.0 for count in (4.0, 5.0))
    dead = _most_dead(row) if row[layout.UNKNOWNS] > 3.0 else 0.0
    first = np.array([0.0, dead, -psi, psi, -beta, beta])
    work, room = atlas_work(), ROOM
    while room <= MOST_ROOM:
        leaves, count = np.empty((room, line_cell.LEAF)), 0
        for zone, ((low, high), grain) in enumerate(zip(pairwise(zones), grains, strict=True)):
            finer = FINER**level if zone < len(grains) - 1 else 1.0
            limits = np.array([finer * size for size in grain] + list(grain[:2]))
            cell = np.array([-widest, widest, np.log(low), np.log(high)])
            count = cover(row, length, cell, first, limits, view, leaves, count, work)
            if count == FULL:
                break
        else:
            kept = leaves[:count]
            if row[layout.UNKNOWNS] == 3.0:
                kept = np.concatenate([kept, _nearly_loose(row, length, zones[0])])
            return kept.copy(), np.array([zones[0], zones[-1]])
        room *= 2
    raise AnswerError(f"exhaustive: a line of {length:g} m takes more than {MOST_ROOM} leaves; a smaller box may do")


def _nearly_loose(row: Array, length: float, least: float) -> Array:
    """What a line can do with less tension at its sheave than is looked into: hang beside or above it, anyhow."""
    own = np.full((1, line_cell.LEAF), np.nan)
    weight, compliance = row[layout.WEIGHT], row[layout.FREE_COMPLIANCE]
    reach = 1.001 * (length + row[layout.RADIUS]) * (1.0 + compliance * (least + weight * length))
    below = 1.001 * (least / weight * (1.0 + compliance * least) + row[layout.RADIUS])
    spans = {
        line_cell.CELL_PHI: (-np.pi, np.pi),
        line_cell.CELL_TAU: (-700.0, np.log(least)),
        line_cell.X: (-reach, reach),
    }
    spans |= {
        line_cell.Z: (-below, reach),
        line_cell.REACH: (0.0, reach),
        line_cell.CENTRE: (0.0, reach),
        line_cell.BEND: (-1.0, 1.0),
    }
    spans |= {line_cell.H: (-least, least), line_cell.V: (-least, least), line_cell.FREE_SPAN: (0.0, length)}
    spans |= {line_cell.BY_PHI: (-np.inf, np.inf), line_cell.BY_TAU: (-np.inf, np.inf)}
    for column, ends in spans.items():
        own[0, column : column + 2] = ends
    own[0, line_cell.LABEL], own[0, line_cell.GOOD] = line_cell.UNCLEAR, 0.0
    return own


def _free_by_label(leaves: Array) -> Array:
    """Least and largest free length where the line only stiffens, by label, (2, 2)."""
    ends = np.zeros((2, 2))
    for label in (line_cell.HANGING, line_cell.STANDING):
        own = leaves[(leaves[:, line_cell.LABEL] == label) & (leaves[:, line_cell.GOOD] == 1.0)]
        if len(own):
            ends[label] = own[:, line_cell.FREE_SPAN].min(), own[:, line_cell.FREE_SPAN + 1].max()
    return ends
