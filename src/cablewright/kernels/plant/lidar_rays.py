"""A planar lidar that rotates while the platform moves: the range of each ray in a room."""

from math import cos, sin, sqrt

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.rotation import matrix

FAR = 1e300

# Columns of a wall: a vertical face from the floor to the ceiling.
WALL_X0, WALL_Y0, WALL_X1, WALL_Y1 = 0, 1, 2, 3  # m, world


@jit(allocates=True)
def turn_lidar(times, poses, begin, period, first_angle, step, mount, masks, walls, ceiling, grid, heights, ranges):
    """Write the *ranges* (m) of all rays of one turn; FAR where a ray hits nothing, NaN where the drum masks it.

    *times* (k,), s, and *poses* (k, 6), position and rotation vector in the world, are the drum's path, interpolated
    linearly. *mount* (3, 4): the lidar's axes as columns, then its position, in the drum's frame. *masks* (j, 2):
    first and last angle, rad, of each sector that the drum hides. *grid* (4,): x and y of the first node of the
    floor's *heights* (nx, ny), their spacing, and their maximum; with fewer than two by two nodes the floor is bare.
    """
    rotation, pose = np.eye(3), np.zeros(6)
    at = 0
    for k in range(ranges.shape[0]):
        angle, time = first_angle + k * step, begin + k * period
        if _masked(masks, angle):
            ranges[k] = np.nan
            continue
        while at < times.shape[0] - 2 and times[at + 1] < time:
            at += 1
        gap = times[at + 1] - times[at]
        share = min(max((time - times[at]) / gap, 0.0), 1.0) if gap > 0.0 else 1.0
        for j in range(6):
            pose[j] = poses[at, j] + share * (poses[at + 1, j] - poses[at, j])
        matrix(pose[3:], rotation)
        c, s = cos(angle), sin(angle)
        ranges[k] = _first_hit(pose, rotation, mount, c, s, walls, ceiling, grid, heights)


@jit
def _masked(masks, angle):
    """Whether an angle lies in a mask."""
    for j in range(masks.shape[0]):
        if masks[j, 0] <= angle <= masks[j, 1]:
            return True
    return False


@jit
def _first_hit(pose, rotation, mount, c, s, walls, ceiling, grid, heights):
    """Distance along the ray to the first wall, the ceiling, or the floor with its heights."""
    ox, oy, oz = pose[0], pose[1], pose[2]
    dx, dy, dz = 0.0, 0.0, 0.0
    for j in range(3):
        way = c * mount[j, 0] + s * mount[j, 1]
        ox += rotation[0, j] * mount[j, 3]
        oy += rotation[1, j] * mount[j, 3]
        oz += rotation[2, j] * mount[j, 3]
        dx += rotation[0, j] * way
        dy += rotation[1, j] * way
        dz += rotation[2, j] * way
    found = FAR
    for i in range(walls.shape[0]):
        found = min(found, ray_to_wall(ox, oy, dx, dy, walls[i]))
    if dz > 0.0:
        found = min(found, (ceiling - oz) / dz)
    elif dz < 0.0:
        found = min(found, ray_to_floor(ox, oy, oz, dx, dy, dz, min(found, 1e3), grid, heights))
    return found


@jit
def ray_to_wall(ox, oy, dx, dy, wall):
    """Distance along the ray from (ox, oy) in units of (dx, dy) to a wall, in plan view; FAR if it misses."""
    ex, ey = wall[WALL_X1] - wall[WALL_X0], wall[WALL_Y1] - wall[WALL_Y0]
    across = dx * ey - dy * ex
    if across == 0.0:
        return FAR
    ax, ay = wall[WALL_X0] - ox, wall[WALL_Y0] - oy
    distance = (ax * ey - ay * ex) / across
    along = (ax * dy - ay * dx) / across
    return distance if distance > 0.0 and 0.0 <= along <= 1.0 else FAR


@jit
def height_at(grid, heights, x, y):
    """Height (m) above the floor, bilinear between four nodes; 0 outside the grid."""
    nx, ny = heights.shape
    if nx < 2 or ny < 2:
        return 0.0
    u, v = (x - grid[0]) / grid[2], (y - grid[1]) / grid[2]
    if not (0.0 <= u <= nx - 1 and 0.0 <= v <= ny - 1):
        return 0.0
    i, j = min(int(u), nx - 2), min(int(v), ny - 2)
    u -= i
    v -= j
    low = heights[i, j] + u * (heights[i + 1, j] - heights[i, j])
    high = heights[i, j + 1] + u * (heights[i + 1, j + 1] - heights[i, j + 1])
    return low + v * (high - low)


@jit
def ray_to_floor(ox, oy, oz, dx, dy, dz, far, grid, heights):
    """Distance along a descending ray to the surface of *heights* or the bare floor; FAR if beyond *far*.

    Marches in steps of half the grid's spacing from the highest point on, then bisects the step that crosses.
    """
    floor_at = -oz / dz
    if heights.shape[0] < 2 or oz <= 0.0:
        return floor_at if 0.0 < floor_at <= far else FAR
    here = max(0.0, (grid[3] - oz) / dz)
    step = 0.5 * grid[2] / max(sqrt(dx * dx + dy * dy), 0.2)
    last = min(floor_at, far)
    before = here
    while here < last:
        here = min(here + step, last)
        if oz + here * dz <= height_at(grid, heights, ox + here * dx, oy + here * dy):
            for _ in range(30):
                middle = 0.5 * (before + here)
                if oz + middle * dz <= height_at(grid, heights, ox + middle * dx, oy + middle * dy):
                    here = middle
                else:
                    before = middle
            return here
        before = here
    return floor_at if floor_at <= far else FAR
