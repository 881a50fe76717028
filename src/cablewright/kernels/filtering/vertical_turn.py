"""Rays of one scan of a vertical lidar: their points, the floor among them, and measurements of floor and walls.

The rules are explained in cablewright.estimation: `height`, `kalman.vertical_scan` and `kalman.vertical_update`.
"""

from math import cos, isfinite, nan, sin

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.filtering.update import (
    ATTITUDE,
    CLOCK,
    GROUND,
    GYRO,
    POSITION,
    RADII,
    STRETCH,
    VELOCITY,
    VERTICAL,
    WALLS,
)
from cablewright.kernels.fitting.scan_lines import median

# Columns of a ray with an echo: cosine of its angle from the drum's axis, downwards; its unit vector, world; its point,
# m from B, and m from the lidar, level, along the drum's axes; its point by the estimate, m, world; cosine and sine of
# the yaw; s over which the gyro is integrated since, s since without encoders, and with them; square of the vector's z;
# rotation of each winch drum since, rad.
COSINE, RAY, POINT, BEAM, THERE, HEADING, GYRO_TIME, COASTING_TIME, COUNTED_TIME = 0, 1, 4, 7, 10, 13, 15, 16, 17
Z_SQUARE, ROTATION = 18, 19

# Numbers of a lidar (9,): its place, m, and the x and y axes of its plane, in the platform's frame.
AXIS_X, AXIS_Y = 3, 6

# Numbers of a wall: normal, direction along it, reference along it, m, and distance, m.
NORMAL, ALONG, REFERENCE, DISTANCE = 0, 2, 4, 5

# Rules of a wall: largest cosine of its rays; least z of its points, m, world; distance of its points from where it is
# expected, and from their median, m; least number of them.
FLAT, LOWEST, BAND, SCATTER, MIN_POINTS = 0, 1, 2, 3, 4
STEEP = 0.5  # sine of the angle between wall and ray, at least

MAX_RUN_GAP = 4  # rays between successive points of a run on the floor
MIN_RUN = 4  # points of such a run
MAX_RUN_SLOPE = 0.15  # powder lies at 0.4
MIN_LEVEL = 8  # points of a level
ITERATIONS = 3  # of its middle


@jit
def tilted(x, y, z, rx, ry):
    """Return (x, y, z) after a rotation by the small vector (rx, ry, 0), rad, to second order."""
    ux, uy, uz = ry * z, -rx * z, rx * y - ry * x  # rotation vector x point
    return x + ux + 0.5 * ry * uz, y + uy - 0.5 * rx * uz, z + uz + 0.5 * (rx * uy - ry * ux)


@jit
def _cross(ax, ay, az, bx, by, bz):
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@jit
def _direction(lidar, angle):
    """Unit vector of a ray, in the platform's frame."""
    x, y, c, s = lidar[AXIS_X:AXIS_Y], lidar[AXIS_Y:], cos(angle), sin(angle)
    return c * x[0] + s * y[0], c * x[1] + s * y[1], c * x[2] + s * y[2]


@jit(allocates=True)
def within(ranges, first, step, lidar, tilts, cosine):
    """Return the points (k, 3), m from B, level, of rays within a *cosine* of the drum's axis, and the last's index.

    *ranges* (n,), m, NaN: no echo; *first*, *step*, rad: angle of the first ray, and between rays; *lidar* (9,), see
    AXIS_X; *tilts* (n, 2), rad.
    """
    n, count, last = ranges.shape[0], 0, 0
    points = np.empty((n, 3))
    for i in range(n):
        x, y, z = _direction(lidar, first + step * i)
        if isfinite(ranges[i]) and -z >= cosine:
            x, y, z = lidar[0] + ranges[i] * x, lidar[1] + ranges[i] * y, lidar[2] + ranges[i] * z
            points[count, 0], points[count, 1], points[count, 2] = tilted(x, y, z, tilts[i, 0], tilts[i, 1])
            count, last = count + 1, i
    return points[:count], last


@jit(allocates=True)
def line(x, y):
    """Slope, and value at x = 0, of the least-squares line; level where the points have one x."""
    away = x - x.mean()
    spread = (away * away).sum()
    slope = (away * y).sum() / spread if spread > 1e-12 else 0.0
    return slope, y.mean() - slope * x.mean()


@jit(allocates=True)
def lowest_level(ordered, band, share, ceiling):
    """Return the mean of the lowest cluster of *ordered* values (k,) that begins below *ceiling*; NaN if there is none.

    A cluster: the values within *band* of its middle; at least 8, and at least *share* of the largest cluster's number.
    """
    sizes, begin, end, largest = np.zeros(ordered.shape[0], np.int64), 0, 0, 0
    for i in range(ordered.shape[0]):
        while end < ordered.shape[0] and ordered[end] < ordered[i] + band:
            end += 1
        sizes[i] = end - i if ordered[i] < ceiling else 0
        largest = max(largest, sizes[i])
    if largest == 0:
        return nan
    while sizes[begin] < max(share * largest, min(MIN_LEVEL, largest)):
        begin += 1
    middle = ordered[begin] + 0.5 * band
    for _ in range(ITERATIONS):
        near = ordered[np.abs(ordered - middle) < band]
        if near.size:
            middle = near.mean()
    return middle


@jit(allocates=True)
def mark_floor(ordered, heights, along, band, share, ceiling, floor):
    """Mark the points of the *floor* (k,), k > 0, by their *heights* (k,), m, also given *ordered*; see `floor_points`.

    They are within *band* (k,), m, of the `lowest_level`, and in runs whose slope *along* the scan (k,), m, is small.
    """
    level, begin = lowest_level(ordered, band.mean(), share, ceiling), 0
    near = np.flatnonzero(np.abs(heights - level) < band)
    for end in range(1, near.size + 1):
        if end < near.size and near[end] - near[end - 1] <= MAX_RUN_GAP:
            continue
        run, begin = near[begin:end], end
        if run.size >= MIN_RUN and abs(line(along[run], heights[run])[0]) < MAX_RUN_SLOPE:
            floor[run] = True


@jit(allocates=True)
def rays(
    ranges, first, step, begin, period, lidar, attitudes, yaw, rotation, coasting_time, displacement, x, at, imu_time,
    encoder_time,
):  # fmt: skip
    """Return the rays (k, ROTATION + m) of a scan that have an echo, by the estimate *x*; see COSINE.

    *ranges*, *first*, *step*, *lidar*: see `within`; *begin*, *period*, s: time of the first ray, and between rays.
    *attitudes* (n, 3), rad; *yaw*, rad, to be added; *rotation* (n, m), *coasting_time* (n,), *displacement* (n, 3):
    see `MotionSince`. *at*: see `update`; *imu_time*, *encoder_time*, s: of the last readings.
    """
    n, count, (place, mount) = ranges.shape[0], 0, (at[POSITION], at[VERTICAL])
    found = np.empty((n, ROTATION + rotation.shape[1]))
    for i in range(n):
        if not isfinite(ranges[i]) or not ranges[i] > 0.0:
            continue
        ray, time, (rx, ry) = found[count], begin + period * i, (attitudes[i, 1], attitudes[i, 2])
        c, s, (ax, ay, az) = cos(yaw + attitudes[i, 0]), sin(yaw + attitudes[i, 0]), _direction(lidar, first + step * i)
        ux, uy, uz = tilted(ax, ay, az, rx, ry)
        by_mount = _cross(x[mount + 3], x[mount + 4], x[mount + 5], ux, uy, uz)
        ux, uy, uz = ux + by_mount[0], uy + by_mount[1], uz + by_mount[2]
        arm = tilted(lidar[0] + x[mount], lidar[1] + x[mount + 1], lidar[2] + x[mount + 2], rx, ry)
        beam = ranges[i] * ux, ranges[i] * uy, ranges[i] * uz
        for k in range(3):
            ray[BEAM + k], ray[POINT + k] = beam[k], arm[k] + beam[k]
            ray[THERE + k] = x[place + k] - displacement[i, k]
        ray[RAY], ray[RAY + 1], ray[RAY + 2], ray[COSINE] = c * ux - s * uy, s * ux + c * uy, uz, -az
        ray[THERE] += c * ray[POINT] - s * ray[POINT + 1]
        ray[THERE + 1] += s * ray[POINT] + c * ray[POINT + 1]
        ray[THERE + 2] += ray[POINT + 2]
        ray[HEADING], ray[HEADING + 1], ray[GYRO_TIME], ray[COASTING_TIME] = c, s, imu_time - time, coasting_time[i]
        ray[COUNTED_TIME], ray[Z_SQUARE] = encoder_time - time - coasting_time[i], uz * uz
        for j in range(rotation.shape[1]):
            ray[ROTATION + j] = rotation[i, j]
        count += 1
    return found[:count]


@jit
def _moved(x, at, velocity, estimate):
    """Return by how much, m, B is from the *estimate* (3,) of a scan's rays, by later updates of it and the clock."""
    place, late = x[at[POSITION] :], x[at[CLOCK]]
    return (
        place[0] - estimate[0] - late * velocity[0],
        place[1] - estimate[1] - late * velocity[1],
        place[2] - estimate[2] - late * velocity[2],
    )


@jit
def locate(turn, x, at, velocity, estimate, floor, places, heights):
    """Write the positions *places* (k, 2), m, world, and *heights* (k,), m above the *floor*, of a scan's points.

    *turn*: of `rays`; *velocity* (3,), m/s of B; *estimate* (3,), m, of B, by which the rays were computed.
    """
    move = _moved(x, at, velocity, estimate)
    for i in range(turn.shape[0]):
        places[i, 0], places[i, 1] = turn[i, THERE] + move[0], turn[i, THERE + 1] + move[1]
        heights[i] = turn[i, THERE + 2] + move[2] - floor - x[at[GROUND] - 1] * turn[i, RAY + 2]


@jit
def _average(turn, chosen, mean):
    """Write the *mean* (ROTATION + m,) of the *chosen* (k,) rays of a *turn*, of which there is one at least."""
    mean[:] = 0.0
    for i in range(turn.shape[0]):
        if chosen[i]:
            mean += turn[i]
    mean /= chosen.sum()


@jit
def _write(mean, n, x, at, jacobian, velocity, H):
    """Write the derivative *H* of a coordinate along *n* (3), world, of points by the *mean* of their rays."""
    c, s, radii, stretch = mean[HEADING], mean[HEADING + 1], at[RADII], at[STRETCH]
    own = n[0] * c + n[1] * s, n[1] * c - n[0] * s, n[2]  # along the drum's axes
    by_attitude = _cross(mean[POINT], mean[POINT + 1], mean[POINT + 2], *own)
    by_mount = _cross(mean[BEAM], mean[BEAM + 1], mean[BEAM + 2], *own)
    H[:] = 0.0
    for k in range(3):
        H[at[POSITION] + k], H[at[VELOCITY] + k] = n[k], -n[k] * mean[COASTING_TIME]
        H[at[ATTITUDE] + k], H[at[GYRO] + k] = by_attitude[k], mean[GYRO_TIME] * by_attitude[k]
        H[at[VERTICAL] + k], H[at[VERTICAL] + 3 + k] = own[k], by_mount[k]
        H[at[GROUND] - 1] -= n[k] * mean[RAY + k]
        H[at[CLOCK]] -= n[k] * velocity[k]
        for i in range(jacobian.shape[1]):
            H[radii + i] -= n[k] * jacobian[k, i] * x[radii + i] * mean[ROTATION + i]
            H[stretch + i] -= n[k] * jacobian[k, i] * mean[COUNTED_TIME]


@jit
def write_height(turn, chosen, x, at, jacobian, velocity, estimate, floor, mean, H):
    """Write the derivative *H* (n,) of the mean height of the *chosen* (k,) points, which is returned, m over *floor*.

    In *mean* (ROTATION + m,), that of their rays. *jacobian* (3, m): motion of B per length; the others: see `locate`.
    """
    _average(turn, chosen, mean)
    _write(mean, (0.0, 0.0, 1.0), x, at, jacobian, velocity, H)
    return mean[THERE + 2] + _moved(x, at, velocity, estimate)[2] - floor - x[at[GROUND] - 1] * mean[RAY + 2]


@jit
def _beyond(ray, move, x, at, wall, errors):
    """How far, m, a ray's point is beyond a wall and along it, and the sine of the angle between ray and wall."""
    nx, ny, there_x, there_y = wall[NORMAL], wall[NORMAL + 1], ray[THERE] + move[0], ray[THERE + 1] + move[1]
    steep, along = (
        nx * ray[RAY] + ny * ray[RAY + 1],
        wall[ALONG] * there_x + wall[ALONG + 1] * there_y - wall[REFERENCE],
    )
    beyond = nx * there_x + ny * there_y - wall[DISTANCE] - x[errors] + x[errors + 1] * along
    return beyond - x[at[GROUND] - 1] * steep, along, steep


@jit(allocates=True)
def write_wall(turn, x, at, jacobian, velocity, estimate, wall, own, rules, mean, H):
    """Find the points of a *wall*, number *own*, and write the derivative *H* (n,) of their mean distance beyond it.

    Returns their number, 0 where it is less than the least, and that distance, m. Numbers and rules of a wall: see
    NORMAL and FLAT; the others: see `write_height`.
    """
    k, errors, move = turn.shape[0], at[WALLS] + 2 * own, _moved(x, at, velocity, estimate)
    off, good = np.empty(k), np.empty(k, np.bool_)
    for i in range(k):
        off[i], _, steep = _beyond(turn[i], move, x, at, wall, errors)
        seen = turn[i, COSINE] < rules[FLAT] and turn[i, THERE + 2] > rules[LOWEST] and steep > STEEP
        good[i] = seen and abs(off[i]) < rules[BAND]
    count = good.sum()
    if count >= rules[MIN_POINTS]:
        good &= np.abs(off - median(off[good], count, np.empty(count))) < rules[SCATTER]
        count = good.sum()
    if count < rules[MIN_POINTS]:
        return 0, nan
    _average(turn, good, mean)
    _write(mean, (wall[NORMAL], wall[NORMAL + 1], 0.0), x, at, jacobian, velocity, H)
    beyond, H[errors + 1], _ = _beyond(mean, move, x, at, wall, errors)
    H[errors] = -1.0
    return count, beyond
