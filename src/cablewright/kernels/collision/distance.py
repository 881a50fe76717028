"""Distances of a segment from a segment, a box, a flat convex polygon and a flat disc, exact to rounding.

Segment i of a polyline (k, 3) is from its point i to its point i + 1; its length may be zero. Lengths are in m.
"""

from math import sqrt

from cablewright.kernels import jit

CUTS = 16  # more than the six faces of a box can require
HALVINGS = 52  # of a segment, to the rounding of a fraction of it
PARALLEL = 1e-12  # squared sine of two directions under which rounding dominates their common normal


@jit
def vector(a, i, b, j):
    """Return the vector from point *i* of *a* to point *j* of *b*."""
    return b[j, 0] - a[i, 0], b[j, 1] - a[i, 1], b[j, 2] - a[i, 2]


@jit
def segment_segment(a, i, b, j):
    """Squared distance of segment *i* of *a* from segment *j* of *b*, and the fractions at which it is reached.

    The lines' nearest points follow from cross products. Where they are outside the segments, or the lines are nearly
    parallel, each end is compared with the other segment (the distance is then exact to 1e-8 of the lengths).
    """
    px, py, pz = a[i, 0], a[i, 1], a[i, 2]
    ux, uy, uz = vector(a, i, a, i + 1)
    qx, qy, qz = b[j, 0], b[j, 1], b[j, 2]
    vx, vy, vz = vector(b, j, b, j + 1)
    rx, ry, rz = vector(a, i, b, j)
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    square = nx * nx + ny * ny + nz * nz
    best, s, t = 1e300, 0.0, 0.0
    if square > 0.0:
        s = (nx * (ry * vz - rz * vy) + ny * (rz * vx - rx * vz) + nz * (rx * vy - ry * vx)) / square
        t = (nx * (ry * uz - rz * uy) + ny * (rz * ux - rx * uz) + nz * (rx * uy - ry * ux)) / square
        if 0.0 <= s <= 1.0 and 0.0 <= t <= 1.0:
            dx, dy, dz = rx + t * vx - s * ux, ry + t * vy - s * uy, rz + t * vz - s * uz
            best = dx * dx + dy * dy + dz * dz
            if square > PARALLEL * (ux * ux + uy * uy + uz * uz) * (vx * vx + vy * vy + vz * vz):
                return best, s, t
    other, at = point_segment(px, py, pz, qx, qy, qz, vx, vy, vz)
    if other < best:
        best, s, t = other, 0.0, at
    other, at = point_segment(px + ux, py + uy, pz + uz, qx, qy, qz, vx, vy, vz)
    if other < best:
        best, s, t = other, 1.0, at
    other, at = point_segment(qx, qy, qz, px, py, pz, ux, uy, uz)
    if other < best:
        best, s, t = other, at, 0.0
    other, at = point_segment(qx + vx, qy + vy, qz + vz, px, py, pz, ux, uy, uz)
    if other < best:
        best, s, t = other, at, 1.0
    return best, s, t


@jit
def point_segment(x, y, z, qx, qy, qz, vx, vy, vz):
    """Return the squared distance of a point from the segment from q to q + v, and the fraction where it is reached."""
    rx, ry, rz = x - qx, y - qy, z - qz
    square = vx * vx + vy * vy + vz * vz
    t = 0.0
    if square > 0.0:
        t = min(max((rx * vx + ry * vy + rz * vz) / square, 0.0), 1.0)
    dx, dy, dz = rx - t * vx, ry - t * vy, rz - t * vz
    return dx * dx + dy * dy + dz * dz, t


@jit
def segment_box(px, py, pz, ux, uy, uz, hx, hy, hz):
    """Squared distance of the segment from p to p + u from a box of half sides h about zero, and the fraction.

    It is convex along the segment, and its slope is linear between the planes of the faces: the bracket of the slope's
    zero is narrowed to two of those.
    """
    low, high = 0.0, 1.0
    first = _slope(px, py, pz, ux, uy, uz, hx, hy, hz, 0.0)
    if first >= 0.0:
        return _outside(px, py, pz, hx, hy, hz), 0.0
    last = _slope(px, py, pz, ux, uy, uz, hx, hy, hz, 1.0)
    if last <= 0.0:
        return _outside(px + ux, py + uy, pz + uz, hx, hy, hz), 1.0
    for p, u, h in ((px, ux, hx), (py, uy, hy), (pz, uz, hz)):
        if u == 0.0:
            continue
        for face in (-h, h):
            s = (face - p) / u
            if low < s < high:
                slope = _slope(px, py, pz, ux, uy, uz, hx, hy, hz, s)
                if slope < 0.0:
                    low, first = s, slope
                else:
                    high, last = s, slope
    s = low + (high - low) * (-first / (last - first))
    return _outside(px + s * ux, py + s * uy, pz + s * uz, hx, hy, hz), s


@jit
def _beyond(x, h):
    """Signed distance of x from the interval -h to h."""
    return x - h if x > h else (x + h if x < -h else 0.0)


@jit
def _outside(x, y, z, hx, hy, hz):
    x, y, z = _beyond(x, hx), _beyond(y, hy), _beyond(z, hz)
    return x * x + y * y + z * z


@jit
def _slope(px, py, pz, ux, uy, uz, hx, hy, hz, s):
    """Half the slope of the squared distance."""
    return ux * _beyond(px + s * ux, hx) + uy * _beyond(py + s * uy, hy) + uz * _beyond(pz + s * uz, hz)


@jit
def depth_in_box(px, py, pz, ux, uy, uz, hx, hy, hz, s):
    """Largest depth (negative) of the segment from p to p + u in the box, and its fraction; *s* is a fraction inside.

    Minus the distance of a point from the nearest face is, along the segment, the largest of six linear functions. Two
    of them are intersected until the intersection lies on the largest.
    """
    low, high = 0.0, 1.0
    at_low, fall = _face(px, py, pz, ux, uy, uz, hx, hy, hz, low, -1.0)
    if fall >= 0.0:
        return at_low, low
    at_high, rise = _face(px, py, pz, ux, uy, uz, hx, hy, hz, high, 1.0)
    if rise <= 0.0:
        return at_high, high
    for _ in range(CUTS):
        cut = low + (at_high - rise * (high - low) - at_low) / (fall - rise)
        if not low < cut < high:
            break
        value, slope = _face(px, py, pz, ux, uy, uz, hx, hy, hz, cut, 0.0)
        s = cut
        if value <= at_low + fall * (cut - low) + 1e-15 * (hx + hy + hz) or slope == 0.0:
            break
        if slope < 0.0:
            low, at_low, fall = cut, value, slope
        else:
            high, at_high, rise = cut, value, slope
    value, _ = _face(px, py, pz, ux, uy, uz, hx, hy, hz, s, 0.0)
    return value, s


@jit
def _face(px, py, pz, ux, uy, uz, hx, hy, hz, s, side):
    """The largest of the six functions and its slope; of equal ones, that with the slope farthest towards *side*."""
    value, slope = -1e300, 0.0
    for p, u, h in ((px, ux, hx), (py, uy, hy), (pz, uz, hz)):
        for sign in (-1.0, 1.0):
            here = sign * (p + s * u) - h
            if here > value or (here == value and (sign * u - slope) * side > 0.0):
                value, slope = here, sign * u
    return value, slope


@jit
def clipped(row, ceiling, polygon):
    """Cut a triangle, nine numbers of *row*, at height *ceiling*, m, and write the part below to *polygon* (5, 3).

    Written are the corners in order, then the first again. Returns the number of corners: 0, 3 or 4.
    """
    count = 0
    for k in range(3):
        j = 3 * k
        i = 3 * ((k + 1) % 3)
        z, after = row[j + 2], row[i + 2]
        if z <= ceiling:
            polygon[count, 0], polygon[count, 1], polygon[count, 2] = row[j], row[j + 1], z
            count += 1
        if (z <= ceiling) != (after <= ceiling):
            t = (ceiling - z) / (after - z)
            polygon[count, 0] = row[j] + t * (row[i] - row[j])
            polygon[count, 1] = row[j + 1] + t * (row[i + 1] - row[j + 1])
            polygon[count, 2] = ceiling
            count += 1
    for k in range(3):
        polygon[count, k] = polygon[0, k]
    return count


@jit
def segment_polygon(a, i, polygon, count):
    """Squared distance of segment *i* of *a* from a flat convex polygon of *count* corners, and the fraction.

    Zero where the segment passes through it. *polygon* (count + 1, 3) ends with its first corner; if its area is zero
    only its edges count.
    """
    best, at = 1e300, 0.0
    for k in range(count):
        square, s, _ = segment_segment(a, i, polygon, k)
        if square < best:
            best, at = square, s
    nx, ny, nz = _normal(polygon, count)
    square = nx * nx + ny * ny + nz * nz
    if not square > 0.0:
        return best, at
    first = _height(a, i, polygon, nx, ny, nz)
    last = _height(a, i + 1, polygon, nx, ny, nz)
    if first * last <= 0.0 and first != last:
        s = first / (first - last)
        x = a[i, 0] + s * (a[i + 1, 0] - a[i, 0])
        y = a[i, 1] + s * (a[i + 1, 1] - a[i, 1])
        z = a[i, 2] + s * (a[i + 1, 2] - a[i, 2])
        if _over(x, y, z, polygon, count, nx, ny, nz):
            return 0.0, s
    for end in range(2):
        height = last if end else first
        here = height * height / square
        j = i + end
        if here < best and _over(a[j, 0], a[j, 1], a[j, 2], polygon, count, nx, ny, nz):
            best, at = here, float(end)
    return best, at


@jit
def _normal(polygon, count):
    """Normal vector of the polygon, as long as twice its area."""
    nx = ny = nz = 0.0
    for k in range(1, count - 1):
        ux, uy, uz = vector(polygon, 0, polygon, k)
        vx, vy, vz = vector(polygon, 0, polygon, k + 1)
        nx += uy * vz - uz * vy
        ny += uz * vx - ux * vz
        nz += ux * vy - uy * vx
    return nx, ny, nz


@jit
def _height(a, j, polygon, nx, ny, nz):
    x, y, z = vector(polygon, 0, a, j)
    return x * nx + y * ny + z * nz


@jit
def _over(x, y, z, polygon, count, nx, ny, nz):
    """Whether the point's projection onto the polygon's plane is inside all edges."""
    for k in range(count):
        ex, ey, ez = vector(polygon, k, polygon, k + 1)
        rx, ry, rz = x - polygon[k, 0], y - polygon[k, 1], z - polygon[k, 2]
        side = (ey * rz - ez * ry) * nx + (ez * rx - ex * rz) * ny + (ex * ry - ey * rx) * nz
        if side < 0.0:
            return False
    return True


@jit
def segment_disc(a, i, disc):
    """Squared distance of segment *i* of *a* from a flat disc, and the fraction; zero where the segment crosses it.

    *disc* (7,): its centre, m, the unit vector across it, and its radius, m. The squared distance is convex along the
    segment, and the zero of its slope is found by bisection.
    """
    px, py, pz = a[i, 0] - disc[0], a[i, 1] - disc[1], a[i, 2] - disc[2]
    ux, uy, uz = vector(a, i, a, i + 1)
    low, high = 0.0, 1.0
    if _disc_slope(px, py, pz, ux, uy, uz, disc) >= 0.0:
        high = low
    elif _disc_slope(px + ux, py + uy, pz + uz, ux, uy, uz, disc) <= 0.0:
        low = high
    for _ in range(HALVINGS):
        s = 0.5 * (low + high)
        if not low < s < high:
            break
        if _disc_slope(px + s * ux, py + s * uy, pz + s * uz, ux, uy, uz, disc) < 0.0:
            low = s
        else:
            high = s
    s = 0.5 * (low + high)
    height, x, y, z, beyond = _above_disc(px + s * ux, py + s * uy, pz + s * uz, disc)
    return height * height + (x * x + y * y + z * z) * beyond * beyond, s


@jit
def _disc_slope(x, y, z, ux, uy, uz, disc):
    """Half the slope of the squared distance at a point, from the disc's centre, along a segment."""
    height, x, y, z, beyond = _above_disc(x, y, z, disc)
    rise = ux * disc[3] + uy * disc[4] + uz * disc[5]
    return height * rise + beyond * (x * ux + y * uy + z * uz)


@jit
def _above_disc(x, y, z, disc):
    """Height of a point above the disc, its vector (3) from the axis, and which share of that is beyond the rim."""
    height = x * disc[3] + y * disc[4] + z * disc[5]
    x, y, z = x - height * disc[3], y - height * disc[4], z - height * disc[5]
    away = sqrt(x * x + y * y + z * z)
    return height, x, y, z, 1.0 - disc[6] / away if away > disc[6] else 0.0
