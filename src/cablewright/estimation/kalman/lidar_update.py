"""Filter update by horizontal lidars: angle and distance of each scanned line to its wall, and the range biases."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from cablewright.estimation.kalman.settings import FilterSettings
from cablewright.estimation.kalman.state import CHI2, FilterState, judge, passes_gate, update_state
from cablewright.estimation.lidar import localisation
from cablewright.estimation.lidar.constraints import contradicting_walls, find_constraints
from cablewright.estimation.lidar.wall_lines import LidarTurn, scanned
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Scan
from cablewright.kernels.filtering.wall_matches import LINE_LENGTH, REJECTED, SweptLines, use

_SETTLING_TIME: Final = 4.0  # s from the start in which ...
_SETTLING_FACTOR: Final = 4.0  # ... the variance of a lidar's measurements is so many times as large
_WALL_TIMEOUT: Final = 3.5  # s without any wall of a kind
_REPORTED: Final = 3  # rejections in a row from which they are reported
_DOUBTFUL_WALL: Final = 4.0  # sigmas of its survey, of a wall's error that is reported
_DOUBTFUL_SURVEY: Final = 2.2  # mean square of all walls' errors over the stated variances, that is reported


def extract(settings: FilterSettings, state: FilterState, scan: Scan) -> None:
    """Find the straight lines in one scan of a horizontal lidar; `update`, in the next time step, uses them."""
    times, walls, lidar = scan.times, settings.machine.walls, settings.machine.lidars.index(scan.source)
    attitudes, motion = state.turns.attitudes.at(times), state.motion_since(times)
    moved = motion.displacement[-1] - motion.displacement  # (n, 3) m, world
    state.attitude.turn_yaw = float(attitudes[-1, 0])
    yaw = state.attitude.yaw - state.attitude.gyro_yaw + state.attitude.turn_yaw
    state.turns.extracted = scanned(scan, walls.lidars[lidar], lidar, walls.search, attitudes, moved[:, :2], yaw)


def update(settings: FilterSettings, state: FilterState) -> None:
    """Update the filter by the lines of the extracted scan, one after another; the most certain match comes first."""
    turn, state.turns.extracted = state.turns.extracted, None
    assert turn is not None
    if not len(turn):
        state.monitor.report(turn.source, "walls", "no wall is in sight: no straight line long enough")
        return
    own, (x, _, at), motion = settings.machine.walls, state.mean, state.motion
    found, sizes, order = np.empty(len(turn), np.int64), np.empty(len(turn)), np.empty(len(turn), np.int64)
    used = use(
        x, state.P, at, state.hung.jacobian, motion.drum_rates, own.room.numbers, own.visible[turn.lidar],
        swept(settings, state, turn), settings.on_walls, CHI2[2], found, sizes, order,
    )  # fmt: skip
    for line in order[:used].tolist():
        judge(state, turn.source, float(sizes[line]), 2)
        state.judged.last_wall_times[own.room.walls[found[line]].kind] = state.time
    lengths = turn.lengths
    _report(settings, state, turn, float(lengths[found >= 0].sum()), float(lengths[found == REJECTED].sum()))
    _report_walls(settings, state)


def swept(settings: FilterSettings, state: FilterState, turn: LidarTurn) -> SweptLines:
    """Return the lines of a *turn*, and how B has moved since, as the kernels `wall_matches` need them."""
    times, attitude, motion = np.append(turn.end, turn.end - turn.sweeps[:, 0]), state.attitude, state.motion
    return SweptLines(
        turn.lidar,
        np.append(turn.mount, settings.machine.walls.lidars[turn.lidar].mount[2]),
        turn.angles,
        turn.distances,
        turn.covariances,
        turn.bias_slopes,
        turn.sweeps,
        state.change_since(times),
        attitude.turn_yaw - attitude.gyro_yaw,
        turn.end,
        motion.last_encoder_time,
        attitude.last_imu_time,
        motion.coasting,
        state.has_long_steps or turn.begin < attitude.imu_gap_end,
        noise_factor(state),
    )


def _report_walls(settings: FilterSettings, state: FilterState) -> None:
    """Report walls that are elsewhere than their survey's standard deviation can explain, and widen the position's.

    A wall with a large error shows alone. Of all walls the mean square of their errors over the stated variances is 1
    where the survey is as good as stated: it is that of estimate and covariance together, one step of expectation and
    maximisation (Dempster, Laird, Rubin 1977). The position is known less well by its excess, as far as errors of walls
    make its covariance.
    """
    own, walls = state.layout.walls, settings.machine.walls.room.walls
    for j, wall in enumerate(walls):
        error = float(state.built.wall_errors[j, 0])
        wrong = abs(error) > _DOUBTFUL_WALL * wall.distance_sigma > 0.0
        sentence = f"wall {wall.name!r} is {1e3 * error:+.1f} mm from where it was surveyed"
        state.monitor.set("room", wall.name, sentence, active=wrong)
    stated, found = state.built.survey_variances[: 2 * len(walls)], state.P[own, own]
    if not len(walls) or not (stated > 0.0).all():
        return
    ratio = float(np.mean((state.mean.x[own] ** 2 + np.diag(found)) / stated))
    by_walls = state.P[state.layout.position, own]
    spread = by_walls @ np.linalg.solve(found, by_walls.T)
    state.judged.survey_doubt[:] = 0.5 * max(ratio - 1.0, 0.0) * (spread + spread.T)
    sentence = f"errors of walls are {math.sqrt(ratio):.2g} times as large as their survey states: survey them again"
    state.monitor.set("room", "survey", sentence, active=ratio > _DOUBTFUL_SURVEY)


def displacement_variance(settings: FilterSettings, far: float) -> float:
    """Return the variance, m^2, of a displacement of B by *far*, m, that is linearised."""
    return (far * far / (2.0 * LINE_LENGTH)) ** 2 + settings.travel_noise**2 * far


def _report(settings: FilterSettings, state: FilterState, turn: LidarTurn, used: float, rejected: float) -> None:
    """Report the faults of a turn. *used*, *rejected*: m, length of the lines that match a wall, and of the others."""
    monitor, source = state.monitor, turn.source
    if used:
        unseen = [kind for kind, last in state.judged.last_wall_times.items() if state.time - last > _WALL_TIMEOUT]
        if unseen:
            monitor.report(source, "walls", localisation.SENTENCES["parallel"])
        else:
            monitor.clear(source, "walls")
        state.judged.last_position_time = state.time
    elif not rejected:
        monitor.report(source, "walls", "no line in sight can be a wall at the estimated yaw")
    if rejected > used:
        state.judged.rejections[source] = state.judged.rejections.get(source, 0) + 1
        sentence, walls = "its walls contradict the estimated position: not used", settings.machine.walls
        yaws = state.attitude.yaw - walls.yaw_step, state.attitude.yaw + walls.yaw_step
        seen = find_constraints([turn], walls.visible, walls.room, yaws)
        why = contradicting_walls(seen, walls.room, walls.gate)
        monitor.report(source, "gate", f"{sentence}; {why}" if why else sentence)
    else:
        state.judged.rejections[source] = 0
        monitor.clear(source, "gate")


def noise_factor(state: FilterState) -> float:
    """Return the factor on a lidar's variance: larger while swing and rates, which distort a scan, settle."""
    return _SETTLING_FACTOR if state.time - state.motion.settling_start < _SETTLING_TIME else 1.0


def gated_update(
    state: FilterState, what: str, H: Array, innovation: Array, R: Array, fault: tuple[str, str], sentence: str
) -> bool:
    """Update by one measurement if it passes the gate, else count and report the rejection; return whether it did."""
    if not passes_gate(state.P, H, innovation, R)[0]:
        state.judged.rejections[what] = state.judged.rejections.get(what, 0) + 1
        if sentence and state.judged.rejections[what] >= _REPORTED:
            state.monitor.report(*fault, sentence)
        return False
    state.judged.rejections[what] = 0
    state.monitor.clear(*fault)
    update_state(state, fault[0], H, innovation, R)
    return True
