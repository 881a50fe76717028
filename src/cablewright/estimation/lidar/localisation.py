"""Position and yaw of the platform from planar lidars in a room with known walls (Merlet, Papegay 2023, III.A).

`step` takes one turn of one lidar: settings and state in, state and answer out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.errors import InputError
from cablewright.estimation.lidar.constraints import (
    Candidate,
    Candidates,
    Constraint,
    SeenLine,
    all_wrapped,
    candidates_of,
    constraints_of,
    judged,
    wrapped,
)
from cablewright.estimation.lidar.room import Laser, RoomMap
from cablewright.estimation.lidar.scan import LidarModel, level_mount, points_of
from cablewright.estimation.lidar.wall_lines import LineSearch, lines_of

__all__ = [
    "KeptTurn",
    "LidarTurn",
    "WallPose",
    "WallSettings",
    "WallState",
    "WallStatus",
    "look",
    "start",
    "steady_drift",
    "step",
]

Array = NDArray[np.float64]

WallStatus = Literal["ok", "ambiguous", "parallel", "no-wall"]

_MOST_JUDGED: Final = 240  # points of a turn that judge candidates: evenly chosen, these tell shares as well as all
_LASER_FITS: Final = 3.0  # sigmas
_LEAST_SIGMA: Final = 1e-6  # m: what is called exact

_SAID: Final[dict[str, str]] = {
    "ok": "position and yaw are found",
    "ambiguous": "two places explain the scan about as well; a distance measured to a wall would tell",
    "parallel": "all walls in sight bound the same direction: the place along them is not known",
    "no-wall": "no wall is in sight",
}


@dataclass(frozen=True)
class WallSettings:
    """What is known of room and lidars, and how scans are judged.

    ``yaw_range``: rad, of the platform at the start. ``yaw_step``: rad, and ``stray``: m, by how much yaw and place may
    differ from the last answer, which counts for ``patience`` turns without one. ``keep``: turns of each lidar that
    count. ``agree``: rad, by which the yaws of two walls may differ besides their noise. ``rank``: ``variance``, the
    paper's, or ``evidence``, the share of points that a place explains. ``near``: m, from a wall, of a point that it
    explains; ``recess``: m, how deep windows and doors may be behind it. ``gate``: m, by how much a line may be off its
    wall, besides its noise, to count in the final fit. ``distinct``: m, from which a second candidate is another place,
    and ``doubt``: what share of the points that the first explains it must explain for the first to be doubted: in a
    long room turned by half, both long walls and one end fit again. ``least``: the share that it must explain itself.
    """

    room: RoomMap
    lidars: tuple[LidarModel, ...] = (LidarModel(),)
    search: LineSearch = field(default_factory=LineSearch)
    yaw_range: tuple[float, float] = (-math.pi / 4, math.pi / 4)
    yaw_step: float = math.radians(15.0)
    stray: float = 0.5
    patience: int = 10
    keep: int = 3
    agree: float = math.radians(1.0)
    rank: Literal["variance", "evidence"] = "evidence"
    near: float = 0.02
    recess: float = 0.12
    gate: float = 0.015
    distinct: float = 0.02
    doubt: float = 0.6
    least: float = 0.25

    def __post_init__(self) -> None:
        if not 0 < self.yaw_range[1] - self.yaw_range[0] <= math.tau + 1e-9:
            low, high = (f"{end:g}" for end in self.yaw_range)
            raise InputError(f"yaw_range = ({low}, {high}): must rise by a turn at most, rad")
        if self.keep < 1 or not self.lidars:
            raise InputError("one lidar and one turn to keep at least are wanted")

    @cached_property
    def sees(self) -> NDArray[np.bool_]:
        """(l, w): which walls each lidar can see."""
        return np.array(
            [[one.sees is None or wall.name in one.sees for wall in self.room.walls] for one in self.lidars]
        )


class LidarTurn(NamedTuple):
    """One turn of one lidar.

    ``tilt``: rad, rotation vector (x, y) of the platform by which it leans, at the end or at each ray. ``drift``: where
    the platform was at each ray, as `points_of` takes it; `steady_drift` makes one. ``moved``: (dx, dy, dyaw) m and rad
    in the reference frame since the turn before, of whatever lidar, where something else knows it; older turns follow.
    """

    angles: ArrayLike  # (n,) rad, counter-clockwise
    ranges: ArrayLike  # (n,) m; 0 or not finite: no echo
    lidar: int = 0
    tilt: ArrayLike = (0.0, 0.0)  # (2,) or (n, 2)
    drift: ArrayLike | None = None  # (n, 3)
    moved: tuple[float, float, float] = (0.0, 0.0, 0.0)


def steady_drift(times: ArrayLike, velocity: tuple[float, float], yaw_rate: float, yaw: float) -> Array:
    """(n, 3) m and rad: where the platform was at each ray, if it moves steadily.

    ``times``: (n,) s, of the rays; the last one is the end. ``velocity``: m/s, reference frame; ``yaw``: rad, at the
    end.
    """
    before = np.asarray(times, dtype=np.float64)
    before = before - before[-1:]
    c, s = math.cos(yaw), math.sin(yaw)
    ahead, left = c * velocity[0] + s * velocity[1], c * velocity[1] - s * velocity[0]
    return np.outer(before, [ahead, left, yaw_rate])


class KeptTurn(NamedTuple):
    """What is kept of a turn, in the platform's present level frame."""

    lidar: int
    seen: tuple[SeenLine, ...]
    xy: Array  # (n, 2) m


@dataclass(frozen=True)
class WallState:
    """What `step` hands to the next."""

    turns: tuple[KeptTurn, ...] = ()
    yaw: float | None = None  # rad, the last that was found
    position: tuple[float, float] | None = None  # m, likewise; both as moved since
    misses: int = 0  # turns since then


@dataclass(frozen=True, eq=False)
class WallPose:
    """Where the platform is. ``position`` and ``yaw`` are fitted to all lines that fit the first candidate."""

    status: WallStatus
    position: Array  # (2,) m; NaN where it is not known
    yaw: float  # rad; NaN if no wall is in sight
    covariance: Array  # (3, 3) of x, y, yaw
    candidates: tuple[Candidate, ...]  # the best first
    constraints: tuple[Constraint, ...]
    seen: tuple[SeenLine, ...]
    used: tuple[int, ...]  # constraints in the final fit
    bias: Array  # (l,) m, of each lidar's ranges, as far as opposite walls tell
    confidence: float  # share of points that the first candidate explains more than any other place
    note: str  # what a person should know, one sentence


def start() -> WallState:
    """Return the state before the first scan."""
    return WallState()


def look(settings: WallSettings, scan: LidarTurn) -> KeptTurn:
    """Find the lines of a new turn and bring them into the platform's level frame: half of the work of `step`."""
    lidar = settings.lidars[scan.lidar]
    points = points_of(lidar, scan.angles, scan.ranges, scan.tilt, scan.drift)
    mount = level_mount(lidar, scan.tilt)
    lines = lines_of(points, lidar, settings.search)
    c, s = math.cos(lidar.yaw), math.sin(lidar.yaw)
    turn = np.array([[c, -s], [s, c]])
    seen = tuple(
        SeenLine(scan.lidar, mount, line._replace(angle=line.angle + lidar.yaw, ends=line.ends @ turn.T + mount))
        for line in lines
    )
    return KeptTurn(scan.lidar, seen, points.xy @ turn.T + mount)


def step(
    settings: WallSettings,
    state: WallState,
    scan: LidarTurn,
    lasers: Sequence[Laser] = (),
    looked: KeptTurn | None = None,
) -> tuple[WallState, WallPose]:
    """Take one turn of a lidar. ``lasers``: what an operator measured at this place; it picks among candidates.

    *looked*: what `look` found in the turn, where that was done before: who has no time for all may take two steps.

    Raises `InputError` for a lidar or wall that is not there, or arrays that do not fit; never for what a scan holds.
    """
    if not 0 <= scan.lidar < len(settings.lidars):
        raise InputError(f"scan: lidar {scan.lidar}; there are {len(settings.lidars)}, counted from 0")
    known = all(math.isfinite(value) for value in scan.moved)
    moved = scan.moved if known else (0.0, 0.0, 0.0)
    turns = _kept(settings, _shifted(state, moved) if known else (), look(settings, scan) if looked is None else looked)
    room, seen = settings.room, [one for turn in turns for one in turn.seen]
    yaws = settings.yaw_range
    if state.yaw is not None:
        centre = state.yaw + moved[2]
        yaws = centre - settings.yaw_step, centre + settings.yaw_step
    constraints = constraints_of(seen, settings.sees, room, yaws)
    found = candidates_of(constraints, room, settings.agree, settings.recess)
    found = judged(found, _newest(turns, settings), room, lasers, settings.near, settings.recess)
    expected = None if state.position is None or not known else np.add(state.position, moved[:2])
    found = _ranked(found, settings, expected)
    pose = _answer(settings, constraints, found, seen, _fresh(turns), expected)
    return _followed(settings, state, turns, pose, moved), pose


def _followed(
    settings: WallSettings,
    state: WallState,
    turns: tuple[KeptTurn, ...],
    pose: WallPose,
    moved: tuple[float, float, float],
) -> WallState:
    """Return the state after an answer: what is sure is kept, and after too long without it nothing is."""
    if pose.status == "ok":
        return WallState(turns, wrapped(pose.yaw), (float(pose.position[0]), float(pose.position[1])))
    misses = state.misses + 1
    if misses > settings.patience:
        return WallState(turns, misses=misses)
    yaw = None if state.yaw is None else wrapped(state.yaw + moved[2])
    if pose.status == "parallel" and not math.isnan(pose.yaw):
        yaw = wrapped(pose.yaw)
    place = state.position
    position = None if place is None else (place[0] + moved[0], place[1] + moved[1])
    return WallState(turns, yaw, position, misses)


def _shifted(state: WallState, moved: tuple[float, float, float]) -> tuple[KeptTurn, ...]:
    """Bring older turns to where the platform is now: what moved one way is seen to have moved the other."""
    if moved == (0.0, 0.0, 0.0):
        return state.turns
    if state.yaw is None:
        return ()  # which way it moved for the lidars is not known
    yaw = state.yaw + moved[2]
    back = np.array([[math.cos(yaw), math.sin(yaw)], [-math.sin(yaw), math.cos(yaw)]]) @ np.array(moved[:2])
    c, s = math.cos(moved[2]), math.sin(moved[2])
    turn = np.array([[c, s], [-s, c]])

    def shifted(one: SeenLine) -> SeenLine:
        angle = one.line.angle - moved[2]
        across = math.cos(angle) * back[0] + math.sin(angle) * back[1]
        mount = turn @ one.mount  # stays with the line: where the lidar was, but for the shift
        line = one.line._replace(
            angle=angle, distance=one.line.distance - float(across), ends=one.line.ends @ turn.T - back
        )
        return SeenLine(one.lidar, mount, line)

    return tuple(KeptTurn(t.lidar, tuple(shifted(one) for one in t.seen), t.xy @ turn.T - back) for t in state.turns)


def _kept(settings: WallSettings, older: tuple[KeptTurn, ...], newest: KeptTurn) -> tuple[KeptTurn, ...]:
    """Return the last turns of each lidar, the newest last."""
    turns = (*older, newest)
    own = [i for i, turn in enumerate(turns) if turn.lidar == newest.lidar]
    gone = set(own[: max(0, len(own) - settings.keep)])
    return tuple(turn for i, turn in enumerate(turns) if i not in gone)


def _newest(turns: Sequence[KeptTurn], settings: WallSettings) -> list[tuple[Array, NDArray[np.bool_]]]:
    """Return the points of each lidar's last turn, and which walls they may be on."""
    last = {turn.lidar: turn.xy for turn in turns}
    return [(xy[:: 1 + len(xy) // _MOST_JUDGED], settings.sees[i]) for i, xy in last.items()]


def _fresh(turns: Sequence[KeptTurn]) -> NDArray[np.bool_]:
    """Return which of all lines are of the last turn of their lidar."""
    last = {turn.lidar: i for i, turn in enumerate(turns)}
    return np.array([last[turn.lidar] == i for i, turn in enumerate(turns) for _ in turn.seen], np.bool_)


def _ranked(found: Candidates, settings: WallSettings, expected: Array | None) -> Candidates:
    """Put those that fit the operator's distances first, then those where the platform can be, then by the rank."""
    misfit = np.maximum(0.0, found.laser_misfit - _LASER_FITS)
    rank = found.variance if settings.rank == "variance" else -found.explained
    return found.chosen(np.lexsort((rank, _beyond(found, settings, expected), misfit)))


def _beyond(found: Candidates, settings: WallSettings, expected: Array | None) -> Array:
    """By how much candidates are farther from where the platform should be than allowed, (k,) m."""
    if expected is None:
        return np.zeros(len(found.yaw))
    return np.asarray(np.maximum(0.0, np.hypot(*(found.position - expected).T) - settings.stray))


def _answer(
    settings: WallSettings,
    constraints: Sequence[Constraint],
    found: Candidates,
    seen: Sequence[SeenLine],
    fresh: NDArray[np.bool_],
    expected: Array | None,
) -> WallPose:
    """Fit the first candidate, and say how sure it is."""
    biases, candidates = np.zeros(len(settings.lidars)), found.told()
    nothing = WallPose(
        "no-wall", np.full(2, math.nan), math.nan, np.full((3, 3), math.nan), candidates, tuple(constraints),
        tuple(seen), used=(), bias=biases, confidence=0.0, note="",
    )  # fmt: skip
    if not constraints:
        lines = f"{len(seen)} straight lines, none at a yaw that is allowed" if seen else "no straight line long enough"
        return replace(nothing, note=f"{_SAID['no-wall']}: {lines}")
    if not candidates:
        return _half(nothing)
    best, beyond = candidates[0], _beyond(found, settings, expected)
    x, covariance, bias, used = _fit(settings, constraints, seen, best)
    now = fresh[np.array([one.seen for one in constraints])[found.constraints]].all(axis=1)
    rivals = found.explained[_likely(found, beyond) & _apart(found, settings, now)].tolist()
    status: WallStatus = "ambiguous" if max(rivals, default=-1.0) > settings.doubt * best.explained else "ok"
    note = _SAID[status]
    if best.laser_misfit > _LASER_FITS:
        note = f"no place agrees with the laser's distances; the nearest is {best.laser_misfit:.1f} sigma off"
        status = "ambiguous"
    elif best.explained < settings.least:
        wanted = f"{100 * settings.least:.0f} % is wanted"
        note = f"the best place explains {100 * best.explained:.0f} % of the points, {wanted}"
        status = "ambiguous"
    elif beyond[0]:
        far = beyond[0] + settings.stray
        note = f"the place jumps: the nearest that fits is {far:.2f} m from where it should be"
        status = "ambiguous"
    return replace(
        nothing, status=status, position=x[:2], yaw=float(x[2]), covariance=covariance, used=used, bias=bias,
        confidence=best.explained - max(rivals, default=0.0), note=note,
    )  # fmt: skip


def _likely(found: Candidates, beyond: Array) -> NDArray[np.bool_]:
    """Say which candidates fit the operator's distances, and of these which are where the platform can be, if any."""
    fits = found.laser_misfit <= _LASER_FITS
    fits |= not fits.any()
    there = fits & (beyond == 0.0)
    return there if there.any() else fits


def _half(nothing: WallPose) -> WallPose:
    """Answer where walls bound one direction only, or no two agree."""
    best = min(nothing.constraints, key=lambda one: one.yaw_sigma)
    one_way = len({one.kind for one in nothing.constraints}) == 1
    covariance = nothing.covariance.copy()
    covariance[2, 2] = best.yaw_sigma**2
    note = _SAID["parallel"] if one_way else "no two walls that cross agree in yaw, or they put the platform outside"
    return replace(nothing, status="parallel", yaw=best.yaw if one_way else math.nan, covariance=covariance, note=note)


def _apart(found: Candidates, settings: WallSettings, new: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Say which candidates are other places or yaws than the first; those of older turns may be so far away by motion.

    ``new``: (k,), which are of new turns alone.
    """
    far = np.hypot(*(found.position - found.position[0]).T) > np.where(new, settings.distinct, settings.stray)
    turned = np.abs(all_wrapped(found.yaw - found.yaw[0])) > np.where(new, 3.0 * settings.agree, settings.yaw_step)
    return np.asarray(far | turned)


def _fit(
    settings: WallSettings, constraints: Sequence[Constraint], seen: Sequence[SeenLine], best: Candidate
) -> tuple[Array, Array, Array, tuple[int, ...]]:
    """Fit x, y and yaw to all lines that fit the candidate.

    Each lidar's bias and each wall's surveyed distance are unknown too, as far as their sigmas let them be. Returns
    x, y, yaw (3,), their covariance (3, 3), the biases (l,) m, and which constraints are used.
    """
    room, lidars, k = settings.room, settings.lidars, np.arange(len(constraints))
    prior = np.concatenate([np.zeros(3), [one.bias_sigma for one in lidars], room.distance_sigmas])
    prior[3:] = np.maximum(prior[3:], _LEAST_SIGMA) ** -2.0
    lines, walls = [seen[one.seen].line for one in constraints], np.array([one.wall for one in constraints])
    spread = np.array([line.covariance for line in lines])
    spread[:, 0, 0] += room.angle_sigmas[walls] ** 2
    weights = np.linalg.inv(spread)
    turn_gate = settings.agree + 3.0 * np.sqrt(spread[:, 0, 0])
    off_gate = settings.gate + 3.0 * np.sqrt(spread[:, 1, 1] + room.distance_sigmas[walls] ** 2)
    n, yaws = room.normals[walls], np.array([one.yaw for one in constraints])
    mounts = np.array([seen[one.seen].mount for one in constraints])
    distances = np.array([line.distance for line in lines]) - room.distances[walls]
    # Residuals are (yaw, place along the normal); their slopes but for the yaw's of the place:
    J = np.zeros((len(k), 2, len(prior)))
    J[:, 0, 2], J[:, 1, :2] = 1.0, n
    J[k, :, [3 + seen[one.seen].lidar for one in constraints]] = [-line.per_bias for line in lines]
    J[k, 1, 3 + len(lidars) + walls] = -1.0
    q = np.zeros(len(prior))
    q[:3] = *best.position, best.yaw
    used = np.empty(0, np.intp)
    for _ in range(2):
        c, s = math.cos(q[2]), math.sin(q[2])
        lever = mounts @ np.array([[c, s], [-s, c]])
        J[:, 1, 2] = n[:, 1] * lever[:, 0] - n[:, 0] * lever[:, 1]
        off = (n * (lever + q[:2])).sum(axis=1) + distances + J[:, 1, 3:] @ q[3:]
        turn = all_wrapped(q[2] - yaws) + J[:, 0, 3:] @ q[3:]
        if not len(used):  # what fits the candidate, and always its own two lines
            fits = (np.abs(turn) <= turn_gate) & (np.abs(off) <= off_gate)
            fits[list(best.constraints)] = True
            used = np.flatnonzero(fits)
        slopes = J[used]
        weighted = (weights[used] @ slopes).reshape(-1, len(prior))
        normal_matrix = np.diag(prior) + weighted.T @ slopes.reshape(-1, len(prior))
        q = q - np.linalg.solve(normal_matrix, np.stack([turn, off], axis=1)[used].ravel() @ weighted + prior * q)
    covariance = np.linalg.inv(normal_matrix)[:3, :3].astype(np.float64)
    return q[:3], covariance, q[3 : 3 + len(lidars)], tuple(used.tolist())
