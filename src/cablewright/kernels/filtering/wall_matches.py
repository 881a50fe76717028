"""Lines of a lidar's turn as surveyed walls: the equation of each match, which line is which wall, and the updates.

Each is an equation rho(state) = 0 at the time when the beam passed the middle of the line, related to the current state
by the rotations that encoders and gyro measured since. So a scan that arrives late is used at its own time.
"""

from math import cos, inf, radians, sin, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.filtering.update import (
    ATTITUDE,
    CLOCK,
    GYRO,
    MOUNTS,
    POSITION,
    RADII,
    RANGES,
    STRETCH,
    VELOCITY,
    WALLS,
    size_of,
    update,
)
from cablewright.kernels.rotation import wrapped

# Numbers of a wall: azimuth of its normal, rad; normal; distance and reference, m.
AZIMUTH, NORMAL, DISTANCE, REFERENCE = 0, 1, 3, 4
# Noise, of `FilterSettings`: of walls (rad, m), of gyro, velocity and travel, of unmeasured rotation (rad/s, s).
WALL_ANGLE, WALL_OFFSET, GYRO_WALK, VELOCITY_WALK, TRAVEL, TURNING, SKEW = 0, 1, 2, 3, 4, 5, 6

NO_WALL, REJECTED = -1, -2  # of a line: none has about its direction; those that have are rejected by the gate
DIRECTION_SIGMAS, DIRECTION = 5.0, radians(3.0)  # by which a line's direction may differ from its wall's
LINE_LENGTH = 4.0  # m, typical, for the curvature of B's path
LEAST_TURNING = 0.2  # s of rotation that is not measured


class SweptLines(NamedTuple):
    """The k lines of a `LidarTurn`, and how B has moved since each, by the sensors that measured it. Times are in s."""

    lidar: int
    mount: NDArray[np.float64]  # (3,) m, of the lidar, along the drum's level axes
    angles: NDArray[np.float64]  # (k,) rad
    distances: NDArray[np.float64]  # (k,) m
    covariances: NDArray[np.float64]  # (k, 2, 2)
    bias_slopes: NDArray[np.float64]  # (k, 2)
    sweeps: NDArray[np.float64]  # (k, 6)
    changes: NDArray[np.float64]  # (k + 1, m + 4), `FilterState.change_since` the end, and since each line's middle
    yaw: float  # rad, at the end of the turn, less the state's
    end: float
    counted: float  # when encoders last counted
    turned: float  # to which the gyro is integrated
    coasting: bool
    unturned: bool  # whether rotation is not measured
    factor: float  # on the noise


@jit
def equation(x, at, jacobian, rates, walls, lines, noise, i, j, H, innovation, R):
    """Write the equation of line *i* as wall *j*: *H* (2, n), *innovation* (2,) of angle and distance, and *R* (2, 2).

    *x* (n,): state; *jacobian* (3, m): motion of B per length; *rates* (m,), rad/s of the winch drums; *walls* (w, 5);
    *lines*: `SweptLines`; *noise* (7,).
    """
    wall, m, (to_end, along, slope, aside, by_rate, off_by_rate) = walls[j], rates.shape[0], _columns(lines.sweeps[i])
    nx, ny = wall[NORMAL], wall[NORMAL + 1]
    off_wall, turned_wall = x[at[WALLS] + 2 * j], x[at[WALLS] + 2 * j + 1]
    mount, bias = at[MOUNTS] + 3 * lines.lidar, x[at[RANGES] + lines.lidar]
    ahead, left, height = lines.mount[0] + x[mount], lines.mount[1] + x[mount + 1], lines.mount[2]
    since, first, gyro = lines.changes[1 + i], at[ATTITUDE], at[GYRO]
    coasting_time, middle_time = since[m + 3], lines.end - to_end
    uncounted, unturned = lines.counted - middle_time - coasting_time, lines.turned - middle_time
    H[:, :] = 0.0
    by_clock = 0.0
    for k in range(m):
        across = nx * jacobian[0, k] + ny * jacobian[1, k]
        paid = across * x[at[RADII] + k]
        H[1, at[RADII] + k], H[1, at[STRETCH] + k] = -paid * since[k], -across * uncounted
        if not lines.coasting:
            H[0, at[RADII] + k] = slope * paid * rates[k]
            H[1, at[RADII] + k] += along * slope * paid * rates[k]
            by_clock -= paid * rates[k]
    yaw = x[at[ATTITUDE] + 2] + lines.yaw
    c, s = cos(yaw), sin(yaw)
    moved_x, moved_y, _ = _moved(x, at, jacobian, lines.changes[0])
    lidar_x = x[at[POSITION]] - moved_x + c * ahead - s * left
    lidar_y = x[at[POSITION] + 1] - moved_y + s * ahead + c * left
    from_reference = nx * lidar_y - ny * lidar_x - wall[REFERENCE]
    angle_slope, offset_slope = lines.bias_slopes[i, 0], lines.bias_slopes[i, 1]
    turn = wrapped(yaw + x[mount + 2] + lines.angles[i] - wall[AZIMUTH] - turned_wall) - angle_slope * bias
    off = nx * lidar_x + ny * lidar_y - wall[DISTANCE] - off_wall + turned_wall * from_reference
    off += lines.distances[i] - offset_slope * bias
    for k in range(2):
        n, v = wall[NORMAL + k], at[VELOCITY] + k
        H[1, at[POSITION] + k] = n
        H[1, v] = -coasting_time * n
        if lines.coasting:
            H[0, v] = slope * n
            H[1, v] += slope * along * n
            by_clock -= n * x[v]
    # Rotating a line about the middle of its points shifts its perpendicular distance.
    forward, beside = nx * c + ny * s, ny * c - nx * s  # the normal along the drum's axes
    H[0, first + 2] = 1.0
    H[1, first], H[1, first + 1], H[1, first + 2] = -beside * height, forward * height, beside * ahead - forward * left
    H[1, gyro], H[1, gyro + 1] = unturned * H[1, first], unturned * H[1, first + 1]
    late = lines.turned - lines.end
    H[0, gyro + 2] = late + by_rate
    H[1, gyro + 2] = along * H[0, gyro + 2] - (late * (along + aside) + off_by_rate)
    H[0, at[RANGES] + lines.lidar], H[1, at[RANGES] + lines.lidar] = -angle_slope, -offset_slope
    H[1, at[WALLS] + 2 * j] = H[0, at[WALLS] + 2 * j + 1] = -1.0
    H[1, at[WALLS] + 2 * j + 1] = from_reference
    H[1, mount], H[1, mount + 1], H[0, mount + 2] = forward, beside, 1.0
    H[1, at[CLOCK]] = by_clock
    innovation[0], innovation[1] = -turn, -(off + by_clock * x[at[CLOCK]])
    moved_x, moved_y, moved_z = _moved(x, at, jacobian, since)
    _spread(lines, noise, i, sqrt(moved_x**2 + moved_y**2 + moved_z**2), R)


@jit
def _columns(row):
    """Return the columns of a *row* (6,) of `LidarTurn.sweeps`."""
    return row[0], row[1], row[2], row[3], row[4], row[5]


@jit
def _moved(x, at, jacobian, change):
    """Return by how much, m, B moves by a *change* (m + 4,), see `FilterState.displacement`."""
    m = jacobian.shape[1]
    moved_x, moved_y, moved_z = change[m], change[m + 1], change[m + 2]
    for k in range(m):
        paid = change[k] * x[at[RADII] + k]
        moved_x += jacobian[0, k] * paid
        moved_y += jacobian[1, k] * paid
        moved_z += jacobian[2, k] * paid
    return moved_x, moved_y, moved_z


@jit
def _spread(lines, noise, i, far, R):
    """Write the noise *R* (2, 2) of the angle and the distance of line *i*, since whose middle B has moved *far*, m.

    Besides the line's own: of the wall, of linearising that motion, and of rotation and motion that are not measured.
    """
    to_end, along, slope, aside, _, _ = _columns(lines.sweeps[i])
    for a in range(2):
        for b in range(2):
            R[a, b] = lines.covariances[i, a, b]
    _lever(R, noise[WALL_ANGLE] ** 2, along)
    R[1, 1] += noise[WALL_OFFSET] ** 2 + (far * far / (2.0 * LINE_LENGTH)) ** 2 + noise[TRAVEL] ** 2 * far
    R[0, 0] += noise[GYRO_WALK] ** 2 * abs(lines.turned - (lines.end - to_end))
    dt = min(to_end, 1.0)
    if lines.coasting:
        _lever(R, noise[VELOCITY_WALK] ** 2 * dt * slope**2, along)
        R[1, 1] += noise[VELOCITY_WALK] ** 2 * dt**3
    if lines.unturned:
        _lever(R, (noise[TURNING] * max(dt, LEAST_TURNING)) ** 2, -aside)
        R[1, 1] += (noise[TURNING] * noise[SKEW]) ** 2
    for a in range(2):
        for b in range(2):
            R[a, b] *= lines.factor


@jit
def _lever(R, variance, arm):
    """Add to the noise *R* (2, 2) of angle and distance a rotation of that *variance*, rad^2, at an *arm*, m."""
    R[0, 0] += variance
    R[0, 1] += variance * arm
    R[1, 0] += variance * arm
    R[1, 1] += variance * arm * arm


@jit(allocates=True)
def use(x, P, at, jacobian, rates, walls, visible, lines, noise, gate, found, sizes, order):
    """Update the state *x* (n,) and its covariance *P* (n, n) by lines, the most certain match first.

    *visible* (w,): whether the lidar sees each wall; *gate*: largest normalised square of an innovation (NIS); the rest
    as in `equation`. Writes the wall of each line, *found* (k,), or NO_WALL or REJECTED; its NIS, *sizes* (k,); and the
    *order* (k,) of lines that were used, of which it returns the number.
    """
    count, n = lines.angles.shape[0], x.shape[0]
    H, innovation, R = np.empty((2, n)), np.empty(2), np.empty((2, 2))
    nis, claims = np.empty((count, walls.shape[0])), np.empty(walls.shape[0], np.int64)
    no_spread, nothing = np.zeros((0, 0)), np.zeros(0, np.bool_)
    found[:] = NO_WALL
    for used in range(count):
        yaw, claims[:] = x[at[ATTITUDE] + 2] + lines.yaw, 0
        reach = DIRECTION_SIGMAS * sqrt(P[at[ATTITUDE] + 2, at[ATTITUDE] + 2]) + DIRECTION
        for i in range(count):
            if found[i] >= 0:
                continue
            found[i] = NO_WALL
            for j in range(walls.shape[0]):
                nis[i, j] = inf
                if visible[j] and abs(wrapped(walls[j, AZIMUTH] - lines.angles[i] - yaw)) <= reach:
                    equation(x, at, jacobian, rates, walls, lines, noise, i, j, H, innovation, R)
                    nis[i, j], found[i] = size_of(P, H, innovation, R), REJECTED
                    claims[j] += nis[i, j] <= gate
        line, wall = _most_certain(found, nis, claims, gate)
        if line < 0:
            return used
        equation(x, at, jacobian, rates, walls, lines, noise, line, wall, H, innovation, R)
        order[used], found[line], sizes[line] = line, wall, nis[line, wall]
        update(x, P, at, H, innovation, R, no_spread, nothing)
    return count


@jit
def _most_certain(found, nis, claims, gate):
    """Return the line and the wall of the most certain match; (-1, -1) where no match passes the gate.

    The one whose wall the fewest lines may be, *claims* (w,); of these the one with the least NIS.
    """
    line, wall = -1, -1
    for i in range(nis.shape[0]):
        if found[i] >= 0:
            continue
        for j in range(nis.shape[1]):
            if not nis[i, j] <= gate:
                continue
            fewer = line < 0 or claims[j] < claims[wall]
            if fewer or (claims[j] == claims[wall] and nis[i, j] < nis[line, wall]):
                line, wall = i, j
    return line, wall
