"""Position and yaw of the platform from planar lidars in a room with known walls (Merlet, Papegay 2023, III.A).

`step` takes one scan of one lidar: settings and state in, state and answer out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final, Literal

import numpy as np

from cablewright.estimation.lidar.constraints import (
    Candidate,
    Candidates,
    Constraint,
    contradicting_walls,
    find_candidates,
    find_constraints,
    score_candidates,
)
from cablewright.estimation.lidar.room import Laser, RoomMap
from cablewright.estimation.lidar.scan import LidarModel
from cablewright.estimation.lidar.wall_lines import LidarTurn, LineSearch
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError
from cablewright.models.rotation import wrap_angle, wrap_angles

WallStatus = Literal["ok", "ambiguous", "parallel", "no-wall"]

_MAX_SCORED: Final = 240  # points of a turn that score candidates: evenly chosen, they give the same shares as all
_LASER_GATE: Final = 3.0  # sigmas
_MIN_SIGMA: Final = 1e-6  # m, of values given as exact

SENTENCES: Final[dict[str, str]] = {
    "ok": "position and yaw are found",
    "ambiguous": "two positions explain the scan about equally well; a measured distance to a wall decides",
    "parallel": "all walls in sight bound the same direction: the position along them is not known",
    "no-wall": "no wall is in sight",
}


@dataclass(frozen=True)
class WallSettings:
    """Room, lidars, and how a pose is chosen.

    ``yaw_range``: rad, of the platform at the start. ``yaw_step``: rad, and ``max_displacement``: m, largest change of
    yaw and position since the last pose, which holds for ``max_misses`` turns without one. ``kept_turns``: how many of
    each lidar are used together. ``yaw_tolerance``: rad, difference of the yaws by two walls, besides noise. ``rank``:
    ``variance``, the paper's, or ``evidence``, the share of points that a candidate explains. ``near_distance``: m from
    a wall, of a point that it explains; ``recess``: m, depth of windows and doors. ``gate``: m from its wall, besides
    noise, of a line in the final fit. ``distinct_distance``: m, from which a second candidate is another place.
    ``ambiguity``: the pose is ambiguous if another pose explains this share of the lines of the first one: in a
    long room turned by half, both long walls and one end fit again. ``min_explained``: share that the first must
    explain.
    """

    room: RoomMap
    lidars: tuple[LidarModel, ...] = (LidarModel(),)
    search: LineSearch = field(default_factory=LineSearch)
    yaw_range: tuple[float, float] = (-math.pi / 4, math.pi / 4)
    yaw_step: float = math.radians(15.0)
    max_displacement: float = 0.5
    max_misses: int = 10
    kept_turns: int = 3
    yaw_tolerance: float = math.radians(1.0)
    rank: Literal["variance", "evidence"] = "evidence"
    near_distance: float = 0.02
    recess: float = 0.12
    gate: float = 0.015
    distinct_distance: float = 0.02
    ambiguity: float = 0.6
    min_explained: float = 0.25

    def __post_init__(self) -> None:
        if not 0 < self.yaw_range[1] - self.yaw_range[0] <= math.tau + 1e-9:
            low, high = (f"{end:g}" for end in self.yaw_range)
            raise InputError(f"yaw_range = ({low}, {high}): must be two rising angles in rad, at most one turn apart")
        if self.kept_turns < 1:
            raise InputError("at least one kept turn is expected")
        if self.lidars and not self.room.walls:
            raise InputError("room: 0 walls; lidars need at least 1")

    @cached_property
    def visible(self) -> Mask:
        """Mask (l, w) of the walls that each lidar can see."""
        names = [wall.name for wall in self.room.walls]
        seen = [names if each.visible_walls is None else each.visible_walls for each in self.lidars]
        return np.array([[name in visible for name in names] for visible in seen])


@dataclass(frozen=True)
class WallState:
    """State of the localisation between two calls of `step`."""

    turns: tuple[LidarTurn, ...] = ()  # in the platform's frame at the last one's end
    yaw: float | None = None  # rad, the last one
    position: tuple[float, float] | None = None  # m, likewise; both moved by other sensors since
    misses: int = 0  # turns since then


@dataclass(frozen=True, eq=False)
class WallPose:
    """Pose of the platform, fitted to all lines that agree with the first candidate."""

    status: WallStatus
    position: Array  # (2,) m; NaN where unknown
    yaw: float  # rad; NaN if no wall is in sight
    covariance: Array  # (3, 3) of x, y, yaw
    candidates: tuple[Candidate, ...]  # best first
    constraints: tuple[Constraint, ...]
    turns: tuple[LidarTurn, ...]
    used: tuple[int, ...]  # indices of constraints in the final fit
    bias: Array  # (l,) m, of each lidar's ranges, as far as opposite walls show it
    confidence: float  # share of points explained by the first candidate less that of any other place
    note: str  # one sentence


def start() -> WallState:
    """Return the localisation's state before the first scan."""
    return WallState()


def step(
    settings: WallSettings,
    state: WallState,
    turn: LidarTurn,
    lasers: Sequence[Laser] = (),
    moved: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> tuple[WallState, WallPose]:
    """Return state and pose after one turn of a lidar.

    ``lasers``: an operator's distances at this position, which decide between candidates. ``moved``: (dx, dy, dyaw) m
    and rad in the reference frame, motion since the last turn of any lidar by other sensors; older turns are shifted by
    it.

    Raises `InputError` for a lidar or wall that does not exist; never for the content of a scan.
    """
    if not 0 <= turn.lidar < len(settings.lidars):
        raise InputError(f"scan: lidar {turn.lidar}: must be from 0 to {len(settings.lidars) - 1}")
    known = all(math.isfinite(value) for value in moved)
    moved = moved if known else (0.0, 0.0, 0.0)
    turns = _with_newest(settings, _shifted(state, moved) if known else (), turn)
    room = settings.room
    yaws = settings.yaw_range
    if state.yaw is not None:
        centre = state.yaw + moved[2]
        yaws = centre - settings.yaw_step, centre + settings.yaw_step
    constraints = find_constraints(turns, settings.visible, room, yaws)
    found = find_candidates(constraints, room, settings.yaw_tolerance, settings.recess)
    found = score_candidates(
        found, _latest_points(turns, settings), room, lasers, settings.near_distance, settings.recess
    )
    expected = None if state.position is None or not known else np.add(state.position, moved[:2])
    found = _ranked(found, settings, expected)
    pose = _pose(settings, constraints, found, turns, expected)
    if pose.status != "ok" and (contradiction := contradicting_walls(constraints, room, settings.gate)):
        pose = replace(pose, note=f"{pose.note}; {contradiction}")
    return _next_state(settings, state, turns, pose, moved), pose


def _next_state(
    settings: WallSettings,
    state: WallState,
    turns: tuple[LidarTurn, ...],
    pose: WallPose,
    moved: tuple[float, float, float],
) -> WallState:
    """Return the state after *pose*: without one the last yaw and position move on, for `max_misses` turns."""
    if pose.status == "ok":
        return WallState(turns, wrap_angle(pose.yaw), (float(pose.position[0]), float(pose.position[1])))
    misses = state.misses + 1
    if misses > settings.max_misses:
        return WallState(turns, misses=misses)
    yaw = None if state.yaw is None else wrap_angle(state.yaw + moved[2])
    if pose.status == "parallel" and not math.isnan(pose.yaw):
        yaw = wrap_angle(pose.yaw)
    place = state.position
    position = None if place is None else (place[0] + moved[0], place[1] + moved[1])
    return WallState(turns, yaw, position, misses)


def _shifted(state: WallState, moved: tuple[float, float, float]) -> tuple[LidarTurn, ...]:
    """Transform older turns to the platform's present frame: walls move opposite to the platform."""
    if moved == (0.0, 0.0, 0.0):
        return state.turns
    if state.yaw is None:
        return ()  # the direction of the motion in the lidars' frame is not known
    yaw = state.yaw + moved[2]
    back = np.array([[math.cos(yaw), math.sin(yaw)], [-math.sin(yaw), math.cos(yaw)]]) @ np.array(moved[:2])
    c, s = math.cos(moved[2]), math.sin(moved[2])
    turn = np.array([[c, s], [-s, c]])

    def shifted(one: LidarTurn) -> LidarTurn:
        angles = one.angles - moved[2]
        across = [math.cos(angle) * back[0] + math.sin(angle) * back[1] for angle in angles.tolist()]
        return replace(
            one,
            mount=turn @ one.mount,  # moves with the lines: the lidar's mount at that time, but for the shift
            points=one.points @ turn.T - back,
            angles=angles,
            distances=one.distances - across,
            ends=one.ends @ turn.T - back,
        )

    return tuple(map(shifted, state.turns))


def _with_newest(settings: WallSettings, older: tuple[LidarTurn, ...], newest: LidarTurn) -> tuple[LidarTurn, ...]:
    """Return the last turns of each lidar, the newest last."""
    turns = (*older, newest)
    own = [i for i, turn in enumerate(turns) if turn.lidar == newest.lidar]
    dropped = set(own[: max(0, len(own) - settings.kept_turns)])
    return tuple(turn for i, turn in enumerate(turns) if i not in dropped)


def _latest_points(turns: Sequence[LidarTurn], settings: WallSettings) -> list[tuple[Array, Mask]]:
    """Return the points of each lidar's last turn, and which walls that lidar can see."""
    last = {turn.lidar: turn.points for turn in turns}
    return [(xy[:: 1 + len(xy) // _MAX_SCORED], settings.visible[i]) for i, xy in last.items()]


def _are_latest(turns: Sequence[LidarTurn]) -> Mask:
    """Return which of all lines are of their lidar's last turn."""
    last = {turn.lidar: i for i, turn in enumerate(turns)}
    return np.repeat([last[turn.lidar] == i for i, turn in enumerate(turns)], [len(turn) for turn in turns])


def _ranked(found: Candidates, settings: WallSettings, expected: Array | None) -> Candidates:
    """Sort by the misfit of the operator's distances, then the excess displacement, then `WallSettings.rank`."""
    misfit = np.maximum(0.0, found.laser_misfit - _LASER_GATE)
    rank = found.variance if settings.rank == "variance" else -found.explained
    return found.select(np.lexsort((rank, _excess_displacement(found, settings, expected), misfit)))


def _excess_displacement(found: Candidates, settings: WallSettings, expected: Array | None) -> Array:
    """Distance (k,), m, of candidates from the expected position beyond `max_displacement`."""
    if expected is None:
        return np.zeros(len(found.yaw))
    return np.asarray(np.maximum(0.0, np.hypot(*(found.position - expected).T) - settings.max_displacement))


def _pose(
    settings: WallSettings,
    constraints: Sequence[Constraint],
    found: Candidates,
    turns: Sequence[LidarTurn],
    expected: Array | None,
) -> WallPose:
    """Fit the pose from the first candidate, and judge its status."""
    biases, candidates = np.zeros(len(settings.lidars)), found.as_tuple()
    unknown = WallPose(
        "no-wall", np.full(2, math.nan), math.nan, np.full((3, 3), math.nan), candidates, tuple(constraints),
        tuple(turns), used=(), bias=biases, confidence=0.0, note="",
    )  # fmt: skip
    if not constraints:
        lines = sum(map(len, turns))
        why = f"{lines} straight lines, none at a yaw that is allowed" if lines else "no straight line long enough"
        return replace(unknown, note=f"{SENTENCES['no-wall']}: {why}")
    if not candidates:
        return _partial_pose(unknown)
    best, excess = candidates[0], _excess_displacement(found, settings, expected)
    x, covariance, bias, used = _fit(settings, constraints, turns, best)
    current = _are_latest(turns)[np.array([one.line for one in constraints])[found.constraints]].all(axis=1)
    rivals = found.explained[_plausible(found, excess) & _distinct(found, settings, current)].tolist()
    status: WallStatus = "ambiguous"
    if best.laser_misfit > _LASER_GATE:
        note = f"no position agrees with the laser's distances; the nearest is {best.laser_misfit:.1f} sigma off"
    elif best.explained < settings.min_explained:
        found_share, min_share = 100.0 * best.explained, 100.0 * settings.min_explained
        note = f"the best position explains {found_share:.0f} % of the points; {min_share:.0f} % are expected"
    elif excess[0]:
        far = excess[0] + settings.max_displacement
        note = f"the position jumps: the nearest that fits is {far:.2f} m from the expected one"
    else:
        status = "ambiguous" if max(rivals, default=-1.0) > settings.ambiguity * best.explained else "ok"
        note = SENTENCES[status]
    return replace(
        unknown, status=status, position=x[:2], yaw=float(x[2]), covariance=covariance, used=used, bias=bias,
        confidence=best.explained - max(rivals, default=0.0), note=note,
    )  # fmt: skip


def _plausible(found: Candidates, excess: Array) -> Mask:
    """Return which candidates fit the operator's distances and the expected position; all, if none does."""
    fits = found.laser_misfit <= _LASER_GATE
    fits |= not fits.any()
    near = fits & (excess == 0.0)
    return near if near.any() else fits


def _partial_pose(unknown: WallPose) -> WallPose:
    """Return the pose where walls bound one direction only, or no two agree: yaw at most."""
    best = min(unknown.constraints, key=lambda one: one.yaw_sigma)
    one_way = len({one.kind for one in unknown.constraints}) == 1
    covariance = unknown.covariance.copy()
    covariance[2, 2] = best.yaw_sigma**2
    note = (
        SENTENCES["parallel"] if one_way else "no two walls that cross agree in yaw, or they place the platform outside"
    )
    return replace(unknown, status="parallel", yaw=best.yaw if one_way else math.nan, covariance=covariance, note=note)


def _distinct(found: Candidates, settings: WallSettings, current: Mask) -> Mask:
    """Return which candidates are other positions or yaws than the first, by more than motion between turns explains.

    ``current``: (k,), which are of the lidars' last turns alone.
    """
    distance = np.where(current, settings.distinct_distance, settings.max_displacement)
    far = np.hypot(*(found.position - found.position[0]).T) > distance
    angle = np.where(current, 3.0 * settings.yaw_tolerance, settings.yaw_step)
    turned = np.abs(wrap_angles(found.yaw - found.yaw[0])) > angle
    return np.asarray(far | turned)


def _fit(
    settings: WallSettings, constraints: Sequence[Constraint], turns: Sequence[LidarTurn], best: Candidate
) -> tuple[Array, Array, Array, tuple[int, ...]]:
    """Fit x, y and yaw to all lines that agree with the candidate.

    Each lidar's bias and each wall's surveyed distance are fitted too, with their sigmas as priors. Returns x, y, yaw
    (3,), their covariance (3, 3), the biases (l,), m, and the indices of the constraints used.
    """
    room, lidars, k = settings.room, settings.lidars, np.arange(len(constraints))
    prior = np.concatenate([np.zeros(3), [one.bias_sigma for one in lidars], room.distance_sigmas])
    prior[3:] = np.maximum(prior[3:], _MIN_SIGMA) ** -2.0
    lines, walls = np.array([(one.line, one.wall) for one in constraints]).T
    spread = np.concatenate([turn.covariances for turn in turns])[lines]
    spread[:, 0, 0] += room.angle_sigmas[walls] ** 2
    weights = np.linalg.inv(spread)
    turn_gate = settings.yaw_tolerance + 3.0 * np.sqrt(spread[:, 0, 0])
    off_gate = settings.gate + 3.0 * np.sqrt(spread[:, 1, 1] + room.distance_sigmas[walls] ** 2)
    n, yaws = room.normals[walls], np.array([one.yaw for one in constraints])
    counts = [len(turn) for turn in turns]
    mounts = np.repeat([turn.mount for turn in turns], counts, axis=0)[lines]
    units = np.repeat([turn.lidar for turn in turns], counts)[lines]
    distances = np.concatenate([turn.distances for turn in turns])[lines] - room.distances[walls]
    # Residuals are (yaw, position along the normal); their derivatives but for the position's by yaw:
    J = np.zeros((len(k), 2, len(prior)))
    J[:, 0, 2], J[:, 1, :2] = 1.0, n
    J[k, :, 3 + units] = -np.concatenate([turn.bias_slopes for turn in turns])[lines]
    J[k, 1, 3 + len(lidars) + walls] = -1.0
    q = np.zeros(len(prior))
    q[:3] = *best.position, best.yaw
    used = np.empty(0, np.intp)
    for _ in range(2):
        c, s = math.cos(q[2]), math.sin(q[2])
        lever = mounts @ np.array([[c, s], [-s, c]])
        J[:, 1, 2] = n[:, 1] * lever[:, 0] - n[:, 0] * lever[:, 1]
        off = (n * (lever + q[:2])).sum(axis=1) + distances + J[:, 1, 3:] @ q[3:]
        turn = wrap_angles(q[2] - yaws) + J[:, 0, 3:] @ q[3:]
        if not len(used):  # what agrees with the candidate, and always its own two lines
            fits = (np.abs(turn) <= turn_gate) & (np.abs(off) <= off_gate)
            fits[list(best.constraints)] = True
            used = np.flatnonzero(fits)
        slopes = J[used]
        weighted = (weights[used] @ slopes).reshape(-1, len(prior))
        normal_matrix = np.diag(prior) + weighted.T @ slopes.reshape(-1, len(prior))
        q = q - np.linalg.solve(normal_matrix, np.stack([turn, off], axis=1)[used].ravel() @ weighted + prior * q)
    covariance = np.linalg.inv(normal_matrix)[:3, :3].astype(np.float64)
    return q[:3], covariance, q[3 : 3 + len(lidars)], tuple(used.tolist())
