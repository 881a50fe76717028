"""Exhaustive search for the equilibria of a point load: proof that the known ones are all in a box."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.progress import Progress, silent
from cablewright.kernels.certificates import exclusion
from cablewright.models.statics import Equilibrium, Model
from cablewright.solvers.certify import certify
from cablewright.solvers.equilibria import (
    FOUND,
    SAME_POSE,
    Equilibria,
    box_of,
    distinct,
    lever_patterns,
    slack_spans,
    solve_starts,
)
from cablewright.solvers.line_cover import OutOfTime, atlases, refuse_unfit
from cablewright.solvers.row_threads import run
from cablewright.solvers.uniqueness import EVERYWHERE

BLOCK, CHUNK = 512, 16  # boxes judged between two checks of the time limit, and by a thread at a time
MIN_SIZES = (0.02, 0.01, 0.005)
"""Side of a box, m, below which it stays undecided, by level; each next level has finer leaves and retries them."""
STARTS = 64  # boxes per level in which more equilibria are searched for
SHARES = 1000  # steps of the reported progress, shares of the volume
SAVE_EVERY = 5.0  # s between two saved states

REASONS = {
    exclusion.AXIS: "next to the vertical through an exit point",
    exclusion.SHAPES: "the shapes of a line could not be separated: it barely carries its dead span, or its lever "
    "turns over",
    exclusion.SOFT: "a line can become slack there, so two equilibria can be close together",
    exclusion.UNSEEN: "at most one equilibrium is there, and none was found",
}


@dataclass(frozen=True, eq=False)
class ExhaustiveSearch:
    """State of an exhaustive search, from which it can be resumed."""

    box: Array  # (6,) lowest and highest x, y, z of the searched region, m
    open: Array  # (N, 6) boxes to be judged
    undecided: Array  # (U, 6) boxes without a proof on this level
    reasons: NDArray[np.int64]  # (U,)
    poses: Array  # (K, 3) of the equilibria known when boxes were judged
    level: int
    judged: int

    @property
    def finished(self) -> bool:
        """Whether every box is judged, on the last level if some are undecided."""
        return len(self.open) == 0


def begin(model: Model, box: Array | None) -> ExhaustiveSearch:
    """Return the initial state of an exhaustive search in *box*, as for `equilibria`."""
    return _anew(np.stack(box_of(model, box), axis=1).ravel())


def _anew(box: Array) -> ExhaustiveSearch:
    return ExhaustiveSearch(box, box[None], np.empty((0, 6)), np.empty(0, dtype=np.int64), np.empty((0, 3)), 0, 0)


def exhaust(
    found: Equilibria,
    search: ExhaustiveSearch,
    *,
    time_limit: float = 600.0,
    save: Callable[[ExhaustiveSearch], None] | None = None,
    progress: Progress | None = None,
) -> tuple[Equilibria, ExhaustiveSearch]:
    """Continue *search* for equilibria other than *found* until it is finished or *time_limit*, s, is over.

    Each call computes the lines' shapes again, which are not in the state: one that ends before gets no further.
    *save* is called with the state every few seconds and at the end, also on an interrupt. Returns the equilibria,
    including those that the search found, and the state. Raises `InputError` for machines that are not covered.
    """
    model, lengths = found.solutions.model, found.solutions.lengths[0]
    refuse_unfit(model, lengths)
    if not time_limit > 0.0:
        raise InputError(f"time limit = {time_limit:g} s: must be over 0")
    save, progress = save or (lambda _search: None), progress or silent
    deadline, before = time.monotonic() + time_limit, search.judged
    solutions = _again(found.solutions, search.poses)
    if solutions is None:
        search, solutions, before = _anew(search.box), found.solutions, 0
    search = replace(search, poses=solutions.pose)
    while not search.finished:
        search = _level(solutions, search, deadline, save, progress)
        if not search.finished or not len(search.undecided) or search.level + 1 == len(MIN_SIZES):
            break
        more = _hunt(solutions, search.undecided)
        level, judged = search.level + 1, search.judged
        search = replace(_anew(search.box), open=search.undecided, poses=more.pose, level=level, judged=judged)
        solutions = more
    save(search)
    return _conclude(found, solutions, search, search.judged - before), search


def _level(
    solutions: Equilibrium,
    search: ExhaustiveSearch,
    deadline: float,
    save: Callable[[ExhaustiveSearch], None],
    progress: Progress,
) -> ExhaustiveSearch:
    """Judge the open boxes until none is left or the time is over; none where the lines take all of it."""
    certified = solutions[np.flatnonzero(certify(solutions).certified)]
    view = np.stack([search.open[:, ::2].min(axis=0), search.open[:, 1::2].max(axis=0)], axis=1).ravel()
    try:
        known = atlases(certified, solutions.lengths[0], search.box, view, search.level, deadline, progress)
    except OutOfTime:
        return search
    whole, saved = _volume(search.open), time.monotonic()
    try:
        while len(search.open):
            search = _judge(known, search)
            now = time.monotonic()
            progress("places", SHARES - int(np.ceil(SHARES * _volume(search.open) / whole)), SHARES)
            if now > deadline:
                break
            if now - saved > SAVE_EVERY:
                save(search)
                saved = now
    except KeyboardInterrupt:
        save(search)
        raise
    return search


def _judge(known: exclusion.Atlases, search: ExhaustiveSearch) -> ExhaustiveSearch:
    """Judge the last boxes of the list and halve those that stay open."""
    block, rest = search.open[-BLOCK:], search.open[:-BLOCK]
    codes, reasons = np.full(len(block), exclusion.OPEN), np.zeros(len(block), dtype=np.int64)
    run(exclusion.judge_rows, len(block), np.ascontiguousarray(block), known, codes, reasons, chunk=CHUNK)
    left, why = block[codes == exclusion.OPEN], reasons[codes == exclusion.OPEN]
    sides = left[:, 1::2] - left[:, ::2]
    small = sides.max(axis=1, initial=0.0) < MIN_SIZES[search.level]
    halves = _halves(left[~small], sides[~small])
    return replace(
        search,
        open=np.concatenate([rest, halves]),
        undecided=np.concatenate([search.undecided, left[small]]),
        reasons=np.concatenate([search.reasons, why[small]]),
        judged=search.judged + len(block),
    )


def _halves(boxes: Array, sides: Array) -> Array:
    """The halves of boxes, cut across their longest side."""
    axis, rows = sides.argmax(axis=1), np.arange(len(boxes))
    middle = 0.5 * (boxes[rows, 2 * axis] + boxes[rows, 2 * axis + 1])
    low, high = boxes.copy(), boxes.copy()
    low[rows, 2 * axis + 1] = middle
    high[rows, 2 * axis] = middle
    return np.concatenate([low, high])


def _volume(boxes: Array) -> float:
    return float(np.prod(boxes[:, 1::2] - boxes[:, ::2], axis=1).sum())


def _again(solutions: Equilibrium, poses: Array) -> Equilibrium | None:
    """The equilibria with those at *poses* of an earlier run; None if some are not found again."""
    if not len(poses):
        return solutions
    every = _hunt(solutions, np.repeat(poses, 2, axis=1), len(poses))
    apart = np.abs(every.pose[None] - poses[:, None]).max(axis=2).min(axis=1)
    return every if bool((apart < SAME_POSE).all()) else None


def _hunt(solutions: Equilibrium, boxes: Array, count: int = STARTS) -> Equilibrium:
    """The equilibria with new ones, last, found from the centres of some boxes with every pattern of levers."""
    model, lengths = solutions.model, solutions.lengths[0]
    chosen = boxes[np.linspace(0, len(boxes) - 1, min(len(boxes), count)).astype(np.int64)]
    middles = 0.5 * (chosen[:, ::2] + chosen[:, 1::2])
    patterns = lever_patterns(model, np.random.default_rng(0))
    rows = solve_starts(model, lengths, np.repeat(middles, len(patterns), axis=0), np.tile(patterns, (len(middles), 1)))
    every = rows[np.flatnonzero(np.isin(rows.code, FOUND))]
    return distinct(every, solutions)


def _conclude(found: Equilibria, solutions: Equilibrium, search: ExhaustiveSearch, judged: int) -> Equilibria:
    """The result of *search*, which replaces what is not proved in *found*; it *judged* so many boxes this time."""
    low, high = search.box[::2], search.box[1::2]
    inside = solutions[np.flatnonzero(((solutions.pose >= low) & (solutions.pose <= high)).all(axis=1))]
    certificates = certify(inside)
    clusters, reasons = _clusters(search)
    if not search.finished:
        early = "" if judged else " before the lines' shapes were known, so that it needs a longer time limit"
        why = f"the search was stopped{early}; {len(search.open)} boxes are not judged yet"
    elif len(clusters):
        why = f"the search could not decide {len(clusters)} small boxes"
    else:
        why = "the search excludes any other in the box whose dead spans are taut"
    proved = search.finished and not len(clusters) and bool(certificates.certified.all())
    return replace(
        found,
        solutions=inside,
        certificates=certificates,
        slack=slack_spans(inside),
        complete_for=_covered(inside.model) if proved and found.complete_for != EVERYWHERE else found.complete_for,
        why=why,
        undecided=clusters,
        undecided_why=tuple(_sentence(reason) for reason in reasons),
        finished=search.finished,
    )


def _covered(model: Model) -> str:
    """The equilibria among which a search leaves out none; see `docs/theory/exhaustive.md`."""
    if model.lines.has_dead_span.any():
        return f"{EVERYWHERE} with the platform in the box and without a loop in a dead span"
    return f"{EVERYWHERE} with the platform in the box"


def _sentence(reason: int) -> str:
    return "; ".join(text for bit, text in REASONS.items() if reason & bit)


def _clusters(search: ExhaustiveSearch) -> tuple[Array, list[int]]:
    """Undecided boxes, merged where they touch, and why they are undecided."""
    boxes, reasons, k = search.undecided.copy(), search.reasons.copy(), 0
    while k < len(boxes):
        own = boxes[k]
        touch = ((boxes[:, ::2] <= own[1::2] + 1e-9) & (boxes[:, 1::2] >= own[::2] - 1e-9)).all(axis=1)
        if touch.sum() == 1:  # itself
            k += 1
            continue
        own[::2], own[1::2] = boxes[touch, ::2].min(axis=0), boxes[touch, 1::2].max(axis=0)
        reasons[k] = np.bitwise_or.reduce(reasons[touch])
        touch[k] = False
        boxes, reasons, k = boxes[~touch], reasons[~touch], 0
    return boxes, [int(reason) for reason in reasons]
