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

# Columns of a ray with an echo: cosine of its angle from the drum's axis, downwards; unit vector, level, along the
# drum's axes; its point from B, and from the lidar, likewise, m; position of B, m, world; cosine and sine of the yaw;
# s over which the gyro is integrated since, without encoders since, and with them; square of the vector's z; rotation
# of each winch drum since, rad.
COSINE, RAY, POINT, BEAM, PLACE, HEADING, GYRO_TIME, COASTING_TIME, COUNTED_TIME = 0, 1, 4, 7, 10, 13, 15, 16, 17
Z_SQUARE, ROTATION = 18, 19

# Numbers of a lidar: its place, m, and the x and y axes of its plane, in the platform's frame.
AXIS_X, AXIS_Y, OF_LIDAR = 3, 6, 9

# Numbers of a wall: normal, direction along it, reference along it, m, and distance, m.
NORMAL, ALONG, REFERENCE, DISTANCE = 0, 2, 4, 5

# Rules of a wall: largest cosine of its rays, least height of its points in the floor's frame, m; distance, m, of its
# points from where it is expected, and from their median; least number of these.
FLAT, LOWEST, BAND, SCATTER, MIN_POINTS = 0, 1, 2, 3, 4
STEEP = 0.5  # sine of the angle between wall and ray, at least

MAX_RUN_GAP = 4  # rays between successive points of a run on the floor
MIN_RUN = 4  # points of such a run
MAX_RUN_SLOPE = 0.15  # powder lies at 0.4
MIN_LEVEL = 8  # points of a level
ITERATIONS = 3  # of its middle


@jit
def tilted(x, y, z, rx, ry):
    """Rotate a vector by a small rotation vector (rx, ry), rad, to second order."""
    ux, uy, uz = ry * z, -rx * z, rx * y - ry * x  # rotation vector x point
    return x + ux + 0.5 * ry * uz, y + uy - 0.5 * rx * uz, z + uz + 0.5 * (rx * uy - ry * ux)


@jit(allocates=True)
def within(ranges, first, step, lidar, tilts, cosine):
    """Return the points (k, 3), m from B, level, of rays within a *cosine* of the drum's axis, and the last one's tilt.

    *ranges* (n,), m, NaN: no echo; *first*, *step*, rad: angle of the first ray, and between rays; *lidar* (OF_LIDAR,);
    *tilts* (n, 2), rad.
    """
    n, count, last = ranges.shape[0], 0, 0
    points = np.empty((n, 3))
    for i in range(n):
        angle = first + step * i
        c, s = cos(angle), sin(angle)
        if not isfinite(ranges[i]) or not -(c * lidar[AXIS_X + 2] + s * lidar[AXIS_Y + 2]) >= cosine:
            continue
        x = lidar[0] + ranges[i] * (c * lidar[AXIS_X] + s * lidar[AXIS_Y])
        y = lidar[1] + ranges[i] * (c * lidar[AXIS_X + 1] + s * lidar[AXIS_Y + 1])
        z = lidar[2] + ranges[i] * (c * lidar[AXIS_X + 2] + s * lidar[AXIS_Y + 2])
        points[count, 0], points[count, 1], points[count, 2] = tilted(x, y, z, tilts[i, 0], tilts[i, 1])
        count, last = count + 1, i
    return points[:count], last


@jit(allocates=True)
def connected(points, heading, apart):
    """Return depth (j,) below B and coordinate (j,) along *heading* (2,), m, of points that a neighbour is near to.

    *points* (k, 3), m; *apart*, m: how much less or more deep a neighbour may be.
    """
    k, count = points.shape[0], 0
    depth, along = np.empty(k), np.empty(k)
    for i in range(k):
        before = i > 0 and abs(points[i, 2] - points[i - 1, 2]) <= apart
        if before or (i < k - 1 and abs(points[i + 1, 2] - points[i, 2]) <= apart):
            depth[count], along[count] = -points[i, 2], points[i, 0] * heading[0] + points[i, 1] * heading[1]
            count += 1
    return depth[:count], along[:count]


@jit
def line(x, y):
    """Slope, and value at x = 0, of the least-squares line; level where the points have one x."""
    n, mx, my, spread, turned = x.shape[0], 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        mx += x[i]
        my += y[i]
    mx /= n
    my /= n
    for i in range(n):
        spread += (x[i] - mx) * (x[i] - mx)
        turned += (x[i] - mx) * y[i]
    slope = turned / spread if spread > 1e-12 else 0.0
    return slope, my - slope * mx


@jit
def lowest_level(ordered, band, share, ceiling):
    """Return the mean of the lowest cluster of *ordered* values (k,) that begins below *ceiling*; NaN if there is none.

    A cluster: the values within *band* of its middle; at least 8, and at least *share* of the largest cluster's number.
    """
    k, starts, end, largest = ordered.shape[0], 0, 0, 0
    while starts < k and ordered[starts] < ceiling:
        while end < k and ordered[end] < ordered[starts] + band:
            end += 1
        largest = max(largest, end - starts)
        starts += 1
    if starts == 0:
        return nan
    least, begin, end = max(share * largest, float(min(MIN_LEVEL, largest))), 0, 0
    while begin < starts:
        while end < k and ordered[end] < ordered[begin] + band:
            end += 1
        if end - begin >= least:
            break
        begin += 1
    middle = ordered[begin] + 0.5 * band
    for _ in range(ITERATIONS):
        count, total = 0, 0.0
        for i in range(k):
            if abs(ordered[i] - middle) < band:
                count += 1
                total += ordered[i]
        if count == 0:
            break
        middle = total / count
    return middle


@jit(allocates=True)
def mark_floor(ordered, heights, along, band, share, ceiling, floor):
    """Mark the points of the *floor* (k,), by their *heights* (k,), m, also given *ordered*; see `floor_points`.

    They are within *band* (k,), m, of the `lowest_level`, and in runs whose slope *along* the scan (k,), m, is small.
    """
    k, count, mean = heights.shape[0], 0, 0.0
    near, x, y = np.empty(k, np.int64), np.empty(k), np.empty(k)
    for i in range(k):
        floor[i] = False
        mean += band[i] / k
    level = lowest_level(ordered, mean, share, ceiling)
    for i in range(k):
        if abs(heights[i] - level) < band[i]:
            near[count], x[count], y[count] = i, along[i], heights[i]
            count += 1
    begin = 0
    for end in range(1, count + 1):
        if end < count and near[end] - near[end - 1] <= MAX_RUN_GAP:
            continue
        if end - begin >= MIN_RUN and abs(line(x[begin:end], y[begin:end])[0]) < MAX_RUN_SLOPE:
            for j in range(begin, end):
                floor[near[j]] = True
        begin = end


@jit(allocates=True)
def rays(ranges, first, step, begin, period, lidar, attitudes, yaw, change, x, at, jacobian, imu_time, encoder_time):
    """Return the rays (k, ROTATION + m) of a scan that have an echo, by the estimate *x*; see COSINE.

    *ranges*, *first*, *step*, *lidar*: see `within`; *begin*, *period*, s: time of the first ray, and between rays.
    *attitudes* (n, 3), rad; *yaw*, rad, to be added. *change* (n, m + 4): rotation of the drums since each ray, rad,
    then motion, m, and time, s, without encoders. *at*: see `update`; *jacobian* (3, m): motion of B per length.
    *imu_time*, *encoder_time*, s: of the last readings.
    """
    n, m, count, vertical = ranges.shape[0], jacobian.shape[1], 0, at[VERTICAL]
    found = np.empty((n, ROTATION + m))
    turn_x, turn_y, turn_z = x[vertical + 3], x[vertical + 4], x[vertical + 5]
    for i in range(n):
        if not isfinite(ranges[i]) or not ranges[i] > 0.0:
            continue
        ray, angle, time = found[count], first + step * i, begin + period * i
        c, s, rx, ry = cos(angle), sin(angle), attitudes[i, 1], attitudes[i, 2]
        ax = c * lidar[AXIS_X] + s * lidar[AXIS_Y]
        ay = c * lidar[AXIS_X + 1] + s * lidar[AXIS_Y + 1]
        az = c * lidar[AXIS_X + 2] + s * lidar[AXIS_Y + 2]
        ux, uy, uz = tilted(ax, ay, az, rx, ry)
        ux, uy, uz = ux + turn_y * uz - turn_z * uy, uy + turn_z * ux - turn_x * uz, uz + turn_x * uy - turn_y * ux
        arm = tilted(lidar[0] + x[vertical], lidar[1] + x[vertical + 1], lidar[2] + x[vertical + 2], rx, ry)
        ray[COSINE], ray[RAY], ray[RAY + 1], ray[RAY + 2] = -az, ux, uy, uz
        for k in range(3):
            ray[BEAM + k] = ranges[i] * ray[RAY + k]
            moved = 0.0
            for j in range(m):
                moved += change[i, j] * x[at[RADII] + j] * jacobian[k, j]
            ray[PLACE + k] = x[at[POSITION] + k] - (moved + change[i, m + k])
        ray[POINT], ray[POINT + 1], ray[POINT + 2] = arm[0] + ray[BEAM], arm[1] + ray[BEAM + 1], arm[2] + ray[BEAM + 2]
        ray[HEADING], ray[HEADING + 1] = cos(yaw + attitudes[i, 0]), sin(yaw + attitudes[i, 0])
        ray[GYRO_TIME], ray[COASTING_TIME] = imu_time - time, change[i, m + 3]
        ray[COUNTED_TIME], ray[Z_SQUARE] = encoder_time - time - change[i, m + 3], uz * uz
        for j in range(m):
            ray[ROTATION + j] = change[i, j]
        count += 1
    return found[:count]


@jit
def _moved(x, at, velocity, estimate, axis):
    """By how much, m, updates and clock corrections have moved B since the *estimate* (3,) of a scan's rays."""
    return x[at[POSITION] + axis] - estimate[axis] - x[at[CLOCK]] * velocity[axis]


@jit
def locate(turn, x, at, velocity, estimate, floor, places, heights):
    """Write the positions *places* (k, 2), m, world, and *heights* (k,), m above the *floor*, of a scan's points.

    *turn*: of `rays`; *velocity* (3,), m/s of B; *estimate* (3,), m, of B, by which the rays were computed.
    """
    bias, by = x[at[GROUND] - 1], _moved(x, at, velocity, estimate, 2) - floor
    by_x, by_y = _moved(x, at, velocity, estimate, 0), _moved(x, at, velocity, estimate, 1)
    for i in range(turn.shape[0]):
        ray = turn[i]
        c, s = ray[HEADING], ray[HEADING + 1]
        places[i, 0] = ray[PLACE] + by_x + c * ray[POINT] - s * ray[POINT + 1]
        places[i, 1] = ray[PLACE + 1] + by_y + s * ray[POINT] + c * ray[POINT + 1]
        heights[i] = ray[PLACE + 2] + ray[POINT + 2] + by - bias * ray[RAY + 2]


@jit(allocates=True)
def ring(turn, heights, may_be, inner, outer, heading, scatter):
    """Return indices, *heights*, coordinates along *heading* (2,) and bands of height, (j,), of a ring's points.

    *turn*: of `rays`; *inner*, *outer*: cosines of the ring's angles from the drum's axis. The height of points that
    are not *may_be* (k,) floor is infinite. *scatter*, m: how far points of a level may be from it along a ray.
    """
    k, count = turn.shape[0], 0
    members, possible, along, band = np.empty(k, np.int64), np.empty(k), np.empty(k), np.empty(k)
    for i in range(k):
        if outer < turn[i, COSINE] <= inner:
            members[count], possible[count] = i, heights[i] if may_be[i] else np.inf
            along[count] = turn[i, POINT] * heading[0] + turn[i, POINT + 1] * heading[1]
            band[count] = scatter * turn[i, COSINE]
            count += 1
    return members[:count], possible[:count], along[:count], band[:count]


@jit
def average(turn, chosen, mean):
    """Write the *mean* (ROTATION + m,) of the *chosen* (k,) rays of a *turn*, see `rays`."""
    columns, count = mean.shape[0], 0
    mean[:] = 0.0
    for i in range(turn.shape[0]):
        if chosen[i]:
            count += 1
            for j in range(columns):
                mean[j] += turn[i, j]
    for j in range(columns):
        mean[j] /= count


@jit
def _add_motion(mean, x, at, jacobian, axis, share, H):
    """Add the derivatives of *share* times B's coordinate by an *axis*, at rays of a *mean*, to the row *H* (n,)."""
    H[at[POSITION] + axis] += share
    H[at[VELOCITY] + axis] -= share * mean[COASTING_TIME]
    for i in range(jacobian.shape[1]):
        H[at[RADII] + i] -= share * jacobian[axis, i] * x[at[RADII] + i] * mean[ROTATION + i]
        H[at[STRETCH] + i] -= share * jacobian[axis, i] * mean[COUNTED_TIME]


@jit
def _turning(a, b, x, y, z):
    """Derivatives of a point's coordinate along (a, b, 0) by a rotation about each axis."""
    return -b * z, a * z, b * x - a * y


@jit
def write_height(turn, chosen, x, at, jacobian, velocity, estimate, floor, mean, H):
    """Write the derivative *H* (n,) of the mean height of the *chosen* points, which is returned, m above the *floor*.

    In *mean*, that of their rays, see `average`. Other arguments: see `locate`; *jacobian* (3, m), see `rays`.
    """
    average(turn, chosen, mean)
    H[:] = 0.0
    _add_motion(mean, x, at, jacobian, 2, 1.0, H)
    H[at[ATTITUDE]], H[at[ATTITUDE] + 1] = mean[POINT + 1], -mean[POINT]
    for k in range(3):
        H[at[GYRO] + k] = mean[GYRO_TIME] * H[at[ATTITUDE] + k]
    H[at[GROUND] - 1] = -mean[RAY + 2]
    first = at[VERTICAL]
    H[first + 2], H[first + 3], H[first + 4] = 1.0, mean[BEAM + 1], -mean[BEAM]
    H[at[CLOCK]] = -velocity[2]
    place = mean[PLACE + 2] + _moved(x, at, velocity, estimate, 2)
    return place + mean[POINT + 2] - floor - x[at[GROUND] - 1] * mean[RAY + 2]


@jit(allocates=True)
def write_wall(turn, x, at, jacobian, velocity, estimate, wall, own, rules, mean, H):
    """Find the points of a *wall*, number *own*, and write the derivative *H* (n,) of their distance from it.

    Returns their number, 0 where it is less than the least, how far they are beyond the wall, m, and, in *mean*, that
    of their rays, see `average`. *turn*, *velocity*, *estimate*: see `locate`; numbers and rules: see NORMAL and FLAT.
    """
    k, bias, errors, count = turn.shape[0], x[at[GROUND] - 1], at[WALLS] + 2 * own, 0
    off, along, good, scratch = np.empty(k), np.empty(k), np.zeros(k, np.bool_), np.empty(k)
    by_x, by_y = _moved(x, at, velocity, estimate, 0), _moved(x, at, velocity, estimate, 1)
    nx, ny, tx, ty = wall[NORMAL], wall[NORMAL + 1], wall[ALONG], wall[ALONG + 1]
    for i in range(k):
        ray = turn[i]
        if not ray[COSINE] < rules[FLAT] or not ray[PLACE + 2] + ray[POINT + 2] > rules[LOWEST]:
            continue
        c, s = ray[HEADING], ray[HEADING + 1]
        ahead, left = nx * c + ny * s, ny * c - nx * s  # the normal along the drum's axes
        steep = ahead * ray[RAY] + left * ray[RAY + 1]
        if not steep > STEEP:
            continue
        there_x, there_y = ray[PLACE] + by_x, ray[PLACE + 1] + by_y
        sideways = (tx * c + ty * s) * ray[POINT] + (ty * c - tx * s) * ray[POINT + 1]
        along[i] = there_x * tx + there_y * ty + sideways - wall[REFERENCE]
        across = ahead * ray[POINT] + left * ray[POINT + 1]
        off[i] = there_x * nx + there_y * ny + across - wall[DISTANCE] - x[errors] + x[errors + 1] * along[i]
        off[i] -= bias * steep
        if abs(off[i]) < rules[BAND]:
            good[i] = True
            scratch[count] = off[i]
            count += 1
    if count < rules[MIN_POINTS]:
        return 0, nan
    middle, total, reached, ahead, left, steep = median(scratch[:count].copy(), count, scratch), 0.0, 0.0, 0.0, 0.0, 0.0
    count = 0
    for i in range(k):
        good[i] = good[i] and abs(off[i] - middle) < rules[SCATTER]
        if good[i]:
            c, s = turn[i, HEADING], turn[i, HEADING + 1]
            a, b = nx * c + ny * s, ny * c - nx * s
            count, total, reached, ahead, left = count + 1, total + off[i], reached + along[i], ahead + a, left + b
            steep += a * turn[i, RAY] + b * turn[i, RAY + 1]
    if count < rules[MIN_POINTS]:
        return 0, nan
    average(turn, good, mean)
    H[:] = 0.0
    _add_motion(mean, x, at, jacobian, 0, nx, H)
    _add_motion(mean, x, at, jacobian, 1, ny, H)
    a, b, first, mount = ahead / count, left / count, at[ATTITUDE], at[VERTICAL]
    H[first], H[first + 1], H[first + 2] = _turning(a, b, mean[POINT], mean[POINT + 1], mean[POINT + 2])
    for j in range(3):
        H[at[GYRO] + j] = mean[GYRO_TIME] * H[first + j]
    H[at[GROUND] - 1], H[mount], H[mount + 1] = -steep / count, a, b
    H[mount + 3], H[mount + 4], H[mount + 5] = _turning(a, b, mean[BEAM], mean[BEAM + 1], mean[BEAM + 2])
    H[errors], H[errors + 1] = -1.0, reached / count
    H[at[CLOCK]] = -(nx * velocity[0] + ny * velocity[1])
    return count, total / count
