"""Residuals of calibration measurements and their derivatives, for straight lines over sheaves."""

from math import atan2, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import along_columns
from cablewright.kernels.fitting.guided_path import GuidedPath, guided_path, place_guided
from cablewright.kernels.fitting.line_over_sheave import COLUMNS, MIN_DISTANCE, TILT_OFFSET, YAW_OFFSET
from cablewright.kernels.fitting.line_rows import (
    balance,
    between,
    encoder,
    put,
    reading_of_cell,
    swivel,
    tied,
    wound,
    wrapped,
)
from cablewright.kernels.fitting.sighting import BODY_COLUMNS, NUMBERS, edge, place_bodies
from cablewright.kernels.rotation import compose, cross, rotate
from cablewright.kernels.statics.platform import place_platform

# Kinds of rows, and the meaning of their `line`, `other` (indices of lines or axes) and `extra` (six numbers):
ENCODER = 0  # line
COORDINATE = 1  # other: the axis of the pose, 3 to 5 of a rotation, whose measured vector is extra[:3]
SWIVEL = 2  # line: angle of its free cable about the swivel's axis, rad, see `line_over_sheave.swivel_frame`
TILT = 3  # other: 0 about x, 1 about y, rad: of the platform against the plumb line
REACH = 4  # extra: a point of the world, a point of the platform: their distance, m
PLANE = 5  # extra: unit normal, a point of the platform: its distance along the normal from the origin, m
BALANCE = 6  # extra: directions of a force, 1 / N, and of a moment, 1 / N m: unbalanced part of measured tensions
BETWEEN = 7  # line, other: distance of two exit points, m; belongs to no pose
YAW = 10  # azimuth of the platform's x axis, rad
SIGHTING = 12  # line, other: indices of camera and tag among the bodies; extra: see `sighting.edge`; px
ALONG = 11  # other: 0 for the position, 3 for the rotation; extra: unit vector along which, the measured rotation
# Of lines that stretch and sag; the part that depends on their equilibrium is added elsewhere:
PAID_OUT = 8  # line
TENSION = 9  # line
TIED = 13  # line and, other, the one on whose drum it is; extra: 1 or -1, if both are paid out together or not;
# and 1 of lines that stretch and sag


class MeasurementRows(NamedTuple):
    """Measurements in the order of poses; those without a pose come last. N poses, R rows, k unknowns, m lines."""

    freedoms: int  # p: directions in which a pose is free, its n coordinates or, in a plane, fewer
    start: NDArray[np.int64]  # (N + 1,) first row of each pose, and the first one without a pose
    kind: NDArray[np.int64]  # (R,)
    line: NDArray[np.int64]  # (R,)
    other: NDArray[np.int64]  # (R,)
    extra: NDArray[np.float64]  # (R, 6)
    lines: NDArray[np.float64]  # (m, COLUMNS): known values
    target: NDArray[np.int64]  # (m, COLUMNS): index of the unknown, -1 where the value is known
    tensions: NDArray[np.float64]  # (N, m) N: readings of load cells
    load: NDArray[np.float64]  # (10,): force N and moment N m, world, at the platform's origin; weight N, its centre
    linear: NDArray[np.float64]  # (q, k): rows without a pose that are linear in the unknowns, weighted
    wanted: NDArray[np.float64]  # (q,): their expected values
    bodies: NDArray[np.float64]  # (b, BODY_COLUMNS): cameras and tags, see `sighting`
    body_target: NDArray[np.int64]  # (b, NUMBERS): index of the unknown, -1 where the value is known
    guided: NDArray[np.float64] | None  # (m, ..) packed rows of lines that `guided_path` draws, else 0; None: no line


class RowReading(NamedTuple):
    """Working memory of one measurement: its derivatives by the pose, and the nonzero ones by unknowns."""

    slope: NDArray[np.float64]  # (6,)
    gradient: NDArray[np.float64]  # (m * COLUMNS + 2 * NUMBERS,)
    unknown: NDArray[np.int64]  # (m * COLUMNS + 2 * NUMBERS,): the unknown of each; an unknown may occur twice
    rotation: NDArray[np.float64]  # (3, 3) of the pose
    lines: NDArray[np.float64]  # (m, COLUMNS): all values of the lines, unknowns included
    free: NDArray[np.float64]  # (12,): length, u (3,), per radius, free span, distance from the axis, its cosine and
    # sine, unit vector (3,) away from the axis
    turn: NDArray[np.float64]  # (3,)
    bodies: NDArray[np.float64]  # (b, BODY_COLUMNS): all values of the bodies, unknowns included
    by_body: NDArray[np.float64]  # (2, NUMBERS): derivatives by a camera and a tag
    spare: NDArray[np.float64]  # (2, 3, 3)
    path: GuidedPath


@jit(allocates=True)
def reading(rows):
    """Allocate a `RowReading` for *rows*."""
    return reading_of(rows.lines.shape[0], rows.bodies.shape[0])


@jit(allocates=True)
def reading_of(m, bodies):
    """Allocate a `RowReading` for *m* lines, and for as many cameras and tags as *bodies* says."""
    numbers = m * COLUMNS + 2 * NUMBERS
    return RowReading(
        np.zeros(6),
        np.zeros(numbers),
        np.zeros(numbers, np.int64),
        np.eye(3),
        np.zeros((m, COLUMNS)),
        np.zeros(12),
        np.zeros(3),
        np.zeros((bodies, BODY_COLUMNS)),
        np.zeros((2, NUMBERS)),
        np.zeros((2, 3, 3)),
        guided_path(m),
    )


@jit
def place_unknowns(rows, theta, work):
    """Write all values of the lines and the bodies to *work*, with the unknowns taken from *theta* (k,)."""
    for i in range(work.lines.shape[0]):
        for c in range(COLUMNS):
            at = rows.target[i, c]
            work.lines[i, c] = rows.lines[i, c] if at < 0 else theta[at]
    place_guided(rows.guided, work.lines, work.path)
    place_bodies(rows.bodies, rows.body_target, theta, work.bodies, work.spare[0], work.spare[1])


@jit
def read_row(rows, i, j, value, pose, work):
    """Return the residual of measurement *i* at pose *j*, and the number of its derivatives in *work*.

    The residual is NaN where it is not defined.
    """
    kind = rows.kind[i]
    work.slope[:] = 0.0
    if kind == ENCODER:
        return encoder(rows.guided, rows, rows.line[i], j, value, pose, work, 0, 1.0)
    if kind == COORDINATE:
        return _coordinate(rows.other[i], rows.extra[i], value, pose, work), 0
    if kind == ALONG:
        return _along(rows.other[i], rows.extra[i], value, pose, work), 0
    if kind == SWIVEL:
        return swivel(rows.guided, rows, rows.line[i], value, pose, work)
    if kind == TILT:
        return _tilt(rows, rows.other[i], value, work)
    if kind == YAW:
        return _yaw(rows, value, work)
    if kind in (REACH, PLANE):
        return _contact(kind, rows.extra[i], value, pose, work), 0
    if kind == BALANCE:
        return balance(rows.guided, rows, j, rows.extra[i], pose, work)
    if kind == PAID_OUT:
        return wound(rows, work, 0, rows.line[i], value, 1.0)  # the length itself is added elsewhere
    if kind == TENSION:
        return reading_of_cell(rows, rows.line[i], value, work)
    if kind == TIED:
        sense, stretches = rows.extra[i, 0], rows.extra[i, 1] > 0.0
        return tied(rows.guided, rows, rows.line[i], rows.other[i], sense, j, value, pose, work, stretches)
    if kind == SIGHTING:
        return _sighting(rows, rows.line[i], rows.other[i], rows.extra[i], value, pose, work)
    return between(rows, rows.line[i], rows.other[i], value, work)


@jit
def _coordinate(axis, extra, value, pose, work):
    work.slope[axis] = 1.0
    if axis < 3:
        return pose[axis] - value
    for k in range(3):  # the derivative is that for small angles: the measured rotation is near
        work.turn[k] = -extra[k]
    compose(pose[3], pose[4], pose[5], work.turn)
    return work.turn[axis - 3]


@jit
def _along(axis, extra, value, pose, work):
    turn = work.turn
    for k in range(3):
        work.slope[axis + k] = extra[k]
        turn[k] = pose[k] if axis < 3 else -extra[3 + k]
    if axis == 3:
        compose(pose[3], pose[4], pose[5], turn)
    return extra[0] * turn[0] + extra[1] * turn[1] + extra[2] * turn[2] - value


@jit
def _tilt(rows, about, value, work):
    """Tilt of the plumb line in the platform's frame, rad; d(R^T e_z) = -R^T (w x e_z) for a world rotation w."""
    turned, slope = work.rotation, work.slope
    up, sign = turned[2, 2], (1.0 if about == 0 else -1.0)
    axis = 1 - about
    lean = turned[2, axis]
    square = lean * lean + up * up
    for k in range(2):  # w x e_z is (w_y, -w_x, 0)
        row, turn = (1, 1.0) if k == 0 else (0, -1.0)
        change, rise = turn * turned[row, axis], turn * turned[row, 2]
        slope[3 + k] = sign * (change * up - lean * rise) / square
    offset = TILT_OFFSET + about
    return sign * atan2(lean, up) - value - work.lines[0, offset], put(rows, work, 0, 0, offset, -1.0)


@jit
def _yaw(rows, value, work):
    """Azimuth of the platform's x axis; d(R e_x) = w x (R e_x) for a world rotation w."""
    turned, slope = work.rotation, work.slope
    x, y, z = turned[0, 0], turned[1, 0], turned[2, 0]
    square = max(x * x + y * y, MIN_DISTANCE * MIN_DISTANCE)
    slope[3], slope[4], slope[5] = -x * z / square, -y * z / square, 1.0
    return wrapped(atan2(y, x) - value - work.lines[0, YAW_OFFSET]), put(rows, work, 0, 0, YAW_OFFSET, -1.0)


@jit
def _contact(kind, extra, value, pose, work):
    slope = work.slope
    arm, spot = work.turn, work.free
    arm[0], arm[1], arm[2] = rotate(work.rotation, extra[3], extra[4], extra[5])
    for a in range(3):
        spot[a] = pose[a] + arm[a]
    if kind == PLANE:
        for a in range(3):
            slope[a] = extra[a]
        size = spot[0] * extra[0] + spot[1] * extra[1] + spot[2] * extra[2]
    else:
        size = sqrt((spot[0] - extra[0]) ** 2 + (spot[1] - extra[1]) ** 2 + (spot[2] - extra[2]) ** 2)
        for a in range(3):
            slope[a] = (spot[a] - extra[a]) / max(size, MIN_DISTANCE)
    slope[3], slope[4], slope[5] = cross(arm[0], arm[1], arm[2], slope[0], slope[1], slope[2])
    return size - value


@jit
def _sighting(rows, camera, tag, extra, value, pose, work):
    seen, count = edge(work.bodies, camera, tag, extra, pose, work.rotation, work.slope, work.by_body), 0
    for which, body in enumerate((camera, tag)):
        for column in range(NUMBERS):
            at = rows.body_target[body, column]
            if at >= 0:
                work.gradient[count], work.unknown[count] = work.by_body[which, column], at
                count += 1
    return seen - value, count


@jit(allocates=True)
def derivatives(rows, free, theta, poses, values, weights, residuals, slopes, gradients):
    """Write weighted residuals (R,) and derivatives by pose (R, p) and unknowns (R, k) at *theta*, *poses* (N, n).

    *free* (n, p): an orthonormal basis of the directions in which poses are free.
    """
    work = reading(rows)
    place_unknowns(rows, theta, work)
    gradients[:, :] = 0.0
    slopes[:, :] = 0.0
    in_plane = rows.freedoms < free.shape[0]
    for j in range(poses.shape[0] + 1):
        alone = j == poses.shape[0]
        pose = poses[0 if alone else j]
        place_platform(pose, work.rotation)
        for i in range(rows.start[j], values.shape[0] if alone else rows.start[j + 1]):
            if weights[i] == 0.0:  # it does not count, even where it has no value
                residuals[i] = 0.0
                continue
            off, count = read_row(rows, i, j, values[i], pose, work)
            if in_plane:
                along_columns(free, work.slope, work.turn)
            residuals[i] = weights[i] * off
            for k in range(rows.freedoms):
                slopes[i, k] = weights[i] * work.slope[k]
            for k in range(count):
                gradients[i, work.unknown[k]] += weights[i] * work.gradient[k]
