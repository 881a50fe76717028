"""Covers of the lines' shapes by small boxes (leaves) for given lengths, as the exhaustive search needs them."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.foundation.progress import Progress, silent
from cablewright.kernels.certificates.exclusion import Atlases
from cablewright.kernels.certificates.line_cover import FULL, atlas_work, cover
from cablewright.kernels.statics.line import line_cell
from cablewright.models.packed_views import LineNumbers, PlatformNumbers
from cablewright.models.statics import Equilibrium, Model
from cablewright.models.support_table import Capability, require

ROOM = 1 << 16  # initial capacity, leaves of a line; doubled as needed
MAX_ROOM = 1 << 21
GRAINS = ((0.025, 0.012, 0.025, 0.006), (0.025, 0.025, 0.02, 0.012), (0.1, 0.25, 0.02, 0.012))
"""Largest and smallest leaf by zone of tension: enough to just carry the dead span, up to three times that, above.

In rad and log tension, the two largest sizes first.
"""
FINER = 0.5  # ratio of the sizes between levels, except in the last zone
MIN_SHARE = 0.05  # of its weight: lowest tension, at its sheave, that is covered for a line without dead span
STRIPS = 16  # parts of a cover between two looks at the clock
BARE = 0.999  # of the stretched dead span's weight: lower bound of the tension at the sheave


class OutOfTime(Exception):
    """Error: the covers were not ready in time."""


def refuse_unfit(model: Model, lengths: Array) -> None:
    """Raise `InputError` for a machine or lengths that the exhaustive search does not support."""
    require(model, Capability.EXHAUSTIVE)
    if model.massless:
        raise InputError("exhaustive: cables without weight have no shape where they are slack; use catenary")
    for line, own, length in zip(model.robot.lines, map(LineNumbers, model.packed.lines), lengths, strict=True):
        steep = own.winch_height < 0.0 and -own.winch_height >= abs(own.winch_distance)
        if own.has_dead_span:
            if not steep:
                raise InputError(f"exhaustive: line {line.name}: its dead span has to go down at 45 degrees or more")
            if not -own.winch_height > own.lever + own.radius:
                raise InputError(f"exhaustive: line {line.name}: its winch exit has to be lower than its lever reaches")
        if not own.free_compliance > 0.0:
            raise InputError(f"exhaustive: line {line.name}: its cable has to stretch")
        if not length - _max_dead(own) > 0.0:
            raise InputError(f"exhaustive: line {line.name}: {length:g} m is too short to leave its sheave in any pose")


def atlases(
    found: Equilibrium,
    lengths: Array,
    box: Array,
    view: Array,
    level: int,
    deadline: float = np.inf,
    progress: Progress = silent,
) -> Atlases:
    """Return covers of all shapes of the lines at *lengths* (m,), m, with the certified equilibria *found* (K,).

    *box* (6,): lowest and highest x, y, z of the searched region, m; *view* (6,): of the part that is still open, which
    is resolved more finely. *level*: 0, 1, ... with ever smaller leaves. *deadline*: time on the clock `time.monotonic`
    at which the search stops, s. Raises `AnswerError` where they take too much memory, `OutOfTime` where they are not
    ready at the deadline.
    """
    packed = found.model.packed
    exits = found.model.lines.exit_point - found.model.lines.platform_point
    done: list[tuple[Array, Array]] = []
    ended = threading.Event()

    def go_on() -> None:
        if ended.is_set() or time.monotonic() > deadline:
            raise OutOfTime

    def one(i: int) -> tuple[Array, Array]:
        return _leaves(packed.lines[i], float(lengths[i]), _seen(box, exits[i]), _seen(view, exits[i]), level, go_on)

    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        try:
            for part in pool.map(one, range(len(lengths))):
                done.append(part)
                progress("shapes of the lines", len(done), len(lengths))
        finally:
            ended.set()  # an interruption does not wait for the lines that are under way
    leaves = np.concatenate([part[0] for part in done])
    offsets = np.array([0, *np.cumsum([len(part[0]) for part in done])])
    free = np.stack([_free_by_label(part[0]) for part in done])
    labels, known = known_of(found)
    platform = PlatformNumbers(packed.platform)
    load = platform.wrench[:3] - [0.0, 0.0, platform.weight]
    weights = found.model.lines.weight.copy()
    return Atlases(exits, weights, load, leaves, offsets, free, np.stack([part[1] for part in done]), labels, known)


def known_of(found: Equilibrium) -> tuple[NDArray[np.int64], Array]:
    """Return labels (K, m) and numbers (K, m, 4), see `Atlases`, of the equilibria with taut dead spans."""
    lines, states = found.model.lines, found.line_states
    t, phi, psi, beta = states.tension, states.free_angle, states.dead_angle, states.lever_angle
    h, v = t * np.cos(phi), t * np.sin(phi)
    pull = lines.lever_moment / (np.where(lines.has_lever, lines.lever, 1.0) * t)
    stands = lines.has_lever & (pull * np.sin(beta) - np.cos(phi - beta) - np.cos(psi - beta) > 0.0)
    rises = lines.has_dead_span & (t * np.sin(psi) + lines.weight * states.dead_length > -1e-6 * t)
    usual = ~rises.any(axis=1) & (np.abs(phi) < np.pi).all(axis=1)
    away = found.pose[:, None, :3] - (lines.exit_point - lines.platform_point)
    end = v + lines.weight * states.free_length
    known = np.stack([h, end, away[..., 0], away[..., 1]], axis=-1)
    return stands[usual].astype(np.int64), np.ascontiguousarray(known[usual])


def _seen(box: Array, exit_point: Array) -> Array:
    """Min and max horizontal distance, and min and max height, of a box from an exit point, m."""
    low, high = box[::2] - exit_point, box[1::2] - exit_point
    near = np.maximum(np.maximum(low, -high), 0.0)
    far = np.maximum(np.abs(low), np.abs(high))
    more = 1e-6
    return np.array([np.hypot(near[0], near[1]) - more, np.hypot(far[0], far[1]) + more, low[2] - more, high[2] + more])


def _max_dead(own: LineNumbers) -> float:
    """Upper bound of the length of a taut dead span and its contact, m."""
    if not own.has_dead_span:
        return float(own.dead_length + 2.0 * np.pi * own.radius)
    spans = abs(own.winch_distance) + abs(own.winch_height) + 2.0 * (own.lever + own.radius)
    return float(spans + 2.0 * np.pi * own.radius)


def _tensions(own: LineNumbers, length: float, far: float) -> Array:
    """Ends of the zones of tension at the sheave, N; the last exceeds any tension within *far* (m) of the exit."""
    weight, compliance = own.weight, own.free_compliance
    free = length - _max_dead(own)
    min_tension = MIN_SHARE * weight * length
    around = own.lever + own.radius
    zones = [min_tension, 60.0 * min_tension]
    if own.has_dead_span:
        depth = -own.winch_height
        full = 1.04 * weight * (depth + own.lever)
        stretched = 1.0 + own.dead_compliance * weight * depth
        zones = [BARE * weight * (depth - around) / stretched, full, 3.0 * full]
    max_tension = max(2.0 * zones[-1], 10.0 * weight * length)
    # a span advances at least this far along its initial direction: its weight never reverses it
    while (compliance * max_tension * free + free) * (max_tension - weight * free) / (
        max_tension + weight * free
    ) < far + around:
        max_tension *= 1.05
    return np.array([*zones, max_tension])


def _leaves(
    row: Array, length: float, seen: Array, view: Array, level: int, go_on: Callable[[], None]
) -> tuple[Array, Array]:
    """Leaves of one line, and the range of tensions (2,) that they cover, N; *go_on* raises where it is to end."""
    row = np.ascontiguousarray(row)
    own = LineNumbers(row)
    zones = _tensions(own, length, float(np.hypot(seen[1], np.abs(seen[2:]).max())))
    psi, beta = (np.pi if own.unknowns > count else 0.0 for count in (4.0, 5.0))
    dead = _max_dead(own) if own.has_dead_span else 0.0
    first = np.array([0.0, dead, -psi, psi, -beta, beta])
    cells = _cells(zones, 2.0 * np.pi if own.radius > 0.0 else np.pi, level)
    work, room = atlas_work(), ROOM
    while room <= MAX_ROOM:
        leaves, count = np.empty((room, line_cell.LEAF)), 0
        for cell, grain in cells:
            go_on()
            count = cover(row, length, cell, first, grain, view, leaves, count, work)
            if count == FULL:
                break
        else:
            kept = leaves[:count]
            if not own.has_dead_span:
                kept = np.concatenate([kept, _nearly_loose(own, length, zones[0])])
            return kept.copy(), np.array([zones[0], zones[-1]])
        room *= 2
    raise AnswerError(
        f"exhaustive: the search divides a line of {length:g} m into more than {MAX_ROOM} parts, the maximum; try a "
        "smaller box"
    )


def _cells(zones: Array, widest: float, level: int) -> list[tuple[Array, Array]]:
    """Ranges of angle and log tension that together are all, and the sizes of their leaves; for each see `cover`."""
    grains = GRAINS if len(zones) == 4 else GRAINS[1:]
    strips = list(pairwise(np.linspace(-widest, widest, STRIPS + 1)))
    cells = []
    for zone, (tensions, grain) in enumerate(zip(pairwise(np.log(zones)), grains, strict=True)):
        finer = FINER**level if zone < len(grains) - 1 else 1.0
        sizes = np.array([finer * size for size in grain] + list(grain[:2]))
        cells += [(np.array([*strip, *tensions]), sizes) for strip in strips]
    return cells


def _nearly_loose(own: LineNumbers, length: float, min_tension: float) -> Array:
    """One leaf that contains all shapes with less tension at the sheave than *min_tension*, N."""
    leaf = np.full((1, line_cell.LEAF), np.nan)
    weight, compliance = own.weight, own.free_compliance
    reach = 1.001 * (length + own.radius) * (1.0 + compliance * (min_tension + weight * length))
    below = 1.001 * (min_tension / weight * (1.0 + compliance * min_tension) + own.radius)
    spans = {
        line_cell.CELL_PHI: (-np.pi, np.pi),
        line_cell.CELL_TAU: (-700.0, np.log(min_tension)),
        line_cell.X: (-reach, reach),
        line_cell.Z: (-below, reach),
        line_cell.REACH: (0.0, reach),
        line_cell.CENTRE: (0.0, reach),
        line_cell.BEND: (-1.0, 1.0),
        line_cell.H: (-min_tension, min_tension),
        line_cell.V: (-min_tension, min_tension),
        line_cell.FREE_SPAN: (0.0, length),
        line_cell.BY_PHI: (-np.inf, np.inf),
        line_cell.BY_TAU: (-np.inf, np.inf),
    }
    for column, ends in spans.items():
        leaf[0, column : column + 2] = ends
    leaf[0, line_cell.LABEL], leaf[0, line_cell.GOOD] = line_cell.UNCLEAR, 0.0
    return leaf


def _free_by_label(leaves: Array) -> Array:
    """Min and max free length where the line has a positive stiffness, by label, (2, 2)."""
    ends = np.zeros((2, 2))
    for label in (line_cell.HANGING, line_cell.STANDING):
        own = leaves[(leaves[:, line_cell.LABEL] == label) & (leaves[:, line_cell.GOOD] == 1.0)]
        if len(own):
            ends[label] = own[:, line_cell.FREE_SPAN].min(), own[:, line_cell.FREE_SPAN + 1].max()
    return ends
