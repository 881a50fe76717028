"""One scan of a planar lidar: its points made level, clusters of them, straight lines through these, and their times.

The rules of `cut` and `draw` are explained in `Clustering` and `LineSearch` of cablewright.estimation.
"""

from math import atan2, ceil, copysign, cos, hypot, inf, isfinite, pi, sin, sqrt, tan

from cablewright.kernels import jit
from cablewright.kernels.rotation import wrapped

TURN = 2.0 * pi

# Rules of `cut`.
SIGMA, GRAZING, SKIP, REACH, ALIGNMENT, MIN_SIZE = 0, 1, 2, 3, 4, 5
# Rules of `draw`.
NOISE, BEARING_NOISE, BEYOND, MERGE, OUTLIER, MIN_POINTS, MIN_LENGTH = 0, 1, 2, 3, 4, 5, 6
# Columns of a cluster: its mean, and the vector from there to its end, m; sums of xx, xy, yy about the mean, m^2.
MEAN, END, SCATTER, SUMS = 0, 2, 4, 7
# Columns of a line: its unit vector; its offset across that; coordinates of its mean (negated) and ends along it, m.
ALONG, OFFSET, LEVER, LOW, HIGH = 0, 2, 3, 4, 5
# Number of its points, sum of their weights (1/m^2), their weighted scatter along it, ratio of residuals to noise, sum
# of squared residuals (m^2); weighted sums of the rays' steepness, and of steepness times coordinate along the line.
COUNT, TOTAL, LARGER, SCALE, SQUARES, STEEP, TURNED, COLUMNS = 6, 7, 8, 9, 10, 11, 12, 13

# Rows of the scratch of `draw` for points near a line: point, unit vector of its ray, range, weight.
X, Y, U, V, FAR, WEIGHT = 0, 1, 2, 3, 4, 5

CLEAR_OF_NOISE = 5.0  # sigmas: distance of two points from which the length between them is measured
ROUNDS = 3  # of merging clusters, and of a line's fit
MIN_STEEPNESS = 0.3  # sine of the angle between ray and line: noise is not reduced further below it
SHARES = 9  # rays over which a line's points are taken to be evenly spread


@jit
def choose(angles, ranges, tilts, drift, limits, masks, chosen, bearing):
    """Write which rays are valid, *chosen* (n,), and their *bearing* (n,), rad, from 0 to a turn; return their number.

    *angles*, *ranges* (n,), rad and m; *tilts* (n, 2) or (1, 2), rad, and *drift* (n, 3) or (0, 3): as in `levelled`;
    *limits* (2,), m, of a valid range; *masks* (k, 2), rad: bearings that are left out, from and to.
    """
    count = 0
    for i in range(angles.shape[0]):
        tilt = tilts[min(i, tilts.shape[0] - 1)]
        good = isfinite(angles[i]) and limits[0] <= ranges[i] <= limits[1] and isfinite(tilt[0]) and isfinite(tilt[1])
        if drift.shape[0] > 0:
            good = good and isfinite(drift[i, 0]) and isfinite(drift[i, 1]) and isfinite(drift[i, 2])
        for k in range(masks.shape[0]):
            good = good and (angles[i] - masks[k, 0]) % TURN > (masks[k, 1] - masks[k, 0]) % TURN
        if good:
            chosen[count], bearing[count] = i, angles[i] % TURN
            count += 1
    return count


@jit
def level(bearing, chosen, ranges, tilts, drift, mount, centre, xy, ray, far, step):
    """Write the points *xy* (k, 2), m, *ray* (k, 2), *far* (k,), m, and *step* (k,), rad, of `Points`.

    *bearing*, *chosen* (k,): of `choose`, by rising bearing; *mount* (4,): yaw of the lidar, rad, and its place on the
    platform, m; *centre* (2,): that place seen from above at the end of the turn, m.
    """
    count, widest, first, moves = bearing.shape[0], 0.0, 0, drift.shape[0] > 0
    for i in range(count):
        gap = (bearing[i + 1] if i + 1 < count else bearing[0] + TURN) - bearing[i]
        if gap > widest:
            widest, first = gap, i + 1
    for i in range(tilts.shape[0]):
        moves = moves or tilts[i, 0] != 0.0 or tilts[i, 1] != 0.0
    c, s = cos(mount[0]), sin(mount[0])
    for i in range(count):
        own = (first + i) % count
        k, step[i] = chosen[own], (bearing[own + 1] if own + 1 < count else bearing[0] + TURN) - bearing[own]
        u, v, distance = cos(bearing[own]), sin(bearing[own]), ranges[k]
        x, y = distance * u, distance * v
        if moves:
            tilt = tilts[min(k, tilts.shape[0] - 1)]
            x, y = tilted(c * x - s * y + mount[1], s * x + c * y + mount[2], mount[3], tilt[0], tilt[1])
            if drift.shape[0] > 0:
                c_, s_ = cos(drift[k, 2]), sin(drift[k, 2])
                x, y = c_ * x - s_ * y + drift[k, 0], s_ * x + c_ * y + drift[k, 1]
            x, y = x - centre[0], y - centre[1]
            x, y = c * x + s * y, c * y - s * x
            distance = hypot(x, y)
            u, v = x / max(distance, 1e-12), y / max(distance, 1e-12)
        xy[i, 0], xy[i, 1], ray[i, 0], ray[i, 1], far[i] = x, y, u, v, distance


@jit
def tilted(x, y, z, along, across):
    """Return x and y of the point (x, y, z), m, after a horizontal rotation vector, rad, by Rodrigues' formula."""
    angle = hypot(along, across)
    ax, ay = along / max(angle, 1e-300), across / max(angle, 1e-300)
    c, s = cos(angle), sin(angle)
    dot = (1.0 - c) * (ax * x + ay * y)
    return c * x + s * (ay * z) + dot * ax, c * y - s * (ax * z) + dot * ay


@jit
def sweep(angles, distances, ends, mount, scan, sweeps):
    """Write the *sweeps* (k, 6) of `LidarTurn` for lines, with *angles*, *distances* (k,) and *ends* (k, 2, 2).

    *mount* (3,): place of the lidar, m, and its yaw, rad; *scan* (3,): angle of the last ray and between rays, rad, and
    the time between rays, s. A line's points are taken to be evenly spread in bearing.
    """
    end, sense = scan[0] + mount[2], copysign(1.0, scan[1])
    slowness = scan[2] * (1.0 / abs(scan[1]) if scan[1] != 0.0 else 1.0 / TURN)  # s/rad
    for k in range(angles.shape[0]):
        angle = angles[k]
        first = atan2(ends[k, 0, 1] - mount[1], ends[k, 0, 0] - mount[0])
        span = wrapped(atan2(ends[k, 1, 1] - mount[1], ends[k, 1, 0] - mount[0]) - first)
        aside = cos(angle) * mount[1] - sin(angle) * mount[0]
        middle, before, turned = 0.0, 0.0, 0.0  # means; the platform turns about its point
        square, slope, by_rate = 0.0, 0.0, 0.0
        for i in range(SHARES):
            along, turn = _passed(first + span * (i + 0.5) / SHARES, angle, distances[k], end, sense)
            middle += along / SHARES
            before += slowness * turn / SHARES
            turned += slowness * turn * (along + aside) / SHARES
        for i in range(SHARES):
            along, turn = _passed(first + span * (i + 0.5) / SHARES, angle, distances[k], end, sense)
            square += (along - middle) ** 2
            slope += (along - middle) * slowness * turn
            by_rate += (along - middle) * slowness * turn * (along + aside)
        square = max(square, 1e-9)
        sweeps[k, 0], sweeps[k, 1], sweeps[k, 2], sweeps[k, 3] = before, middle, slope / square, aside
        sweeps[k, 4], sweeps[k, 5] = by_rate / square, turned


@jit
def _passed(bearing, angle, distance, end, sense):
    """Return where a ray meets a line, m along it, and its angle, rad, before the *end*."""
    return distance * tan(bearing - angle), (end - bearing) * sense % TURN


@jit
def cut(xy, distance, step, rules, work, marks, members, first, size, sums):
    """Divide the points *xy* (n, 2), m, of a lidar scan, in order of angle, into clusters; return their number.

    *distance* (n,), m, and *step* (n,), rad to the next point, as in `Points`. Points of cluster i are
    ``members[first[i]:first[i] + size[i]]``; *sums* (n // 2, SUMS). Scratch: *work* (4, n), *marks* (2, n).
    """
    n, count = xy.shape[0], 0
    if n < max(rules[MIN_SIZE], 2.0):
        return 0
    way, x, y, far = work[0], work[1], work[2], work[3]
    near, aligned = marks[0], marks[1]
    usual = median(step, n, way)
    for i in range(n):
        if not 0 < i < n - 1 or not _is_stray(xy, distance, step, i, usual, rules):
            members[count], x[count], y[count], far[count] = i, xy[i, 0], xy[i, 1], distance[i]
            count += 1
    if count < rules[MIN_SIZE]:
        return 0
    bearing, at = 0.0, 0
    for i in range(count - 1):
        before = bearing
        while at < members[i + 1]:
            bearing += step[at]
            at += 1
        apart = hypot(x[i + 1] - x[i], y[i + 1] - y[i])
        near[i] = _near(apart, far[i], far[i + 1], bearing - before, usual, rules)
    near[count - 1] = False
    few = CLEAR_OF_NOISE * rules[SIGMA] / max(usual * median(far, count, way), 1e-9)
    _measure(x, y, count, max(ceil(min(few, float(count))), 1), way)
    _align(x, y, count, way, near, rules, aligned)
    k, begin = 0, 0
    for i in range(count):
        if near[i] and aligned[i] and aligned[i + 1]:
            continue
        if i > begin and i - begin + 1 >= rules[MIN_SIZE]:
            first[k], size[k] = begin, i - begin + 1
            _sum(x, y, begin, i + 1, sums[k])
            k += 1
        begin = i + 1
    return k


@jit
def median(values, n, scratch):
    """Return the median of values[:n], n > 0, by Hoare's selection; *scratch* (n,) is overwritten."""
    for i in range(n):
        scratch[i] = values[i]
    middle, low, high = n // 2, 0, n - 1
    while low < high:
        pivot, i, j = scratch[middle], low, high
        while i <= j:
            while scratch[i] < pivot:
                i += 1
            while scratch[j] > pivot:
                j -= 1
            if i <= j:
                scratch[i], scratch[j] = scratch[j], scratch[i]
                i += 1
                j -= 1
        if j < middle:
            low = i
        if i > middle:
            high = j
    if n % 2 == 1:
        return scratch[middle]
    below = scratch[0]
    for i in range(1, middle):
        if scratch[i] > below:
            below = scratch[i]
    return 0.5 * (below + scratch[middle])


@jit
def _reached(apart, one, other, turn, rules):
    """Whether two points *apart* (m) can be on one wall at the smallest grazing angle, by the law of sines.

    *one* and *other*: their ranges, m; *turn*: the angle between their rays, rad.
    """
    turned = min(turn, 0.5 * rules[GRAZING])
    return apart <= min(one, other) * sin(turned) / sin(rules[GRAZING] - turned) + 6.0 * rules[SIGMA]


@jit
def _near(apart, one, other, turn, usual, rules):
    """Whether two points can be successive ones on a wall.

    Half a degree more than the *usual* angle, rad, is allowed, since rays of several turns are not evenly spaced.
    """
    return turn <= (rules[SKIP] + 1.0) * usual + 0.01 and _reached(apart, one, other, turn, rules)


@jit
def _is_stray(xy, distance, step, i, usual, rules):
    """Whether point i is far from both neighbours while these are near each other."""
    x0, y0, x1, y1, x2, y2 = xy[i - 1, 0], xy[i - 1, 1], xy[i, 0], xy[i, 1], xy[i + 1, 0], xy[i + 1, 1]
    before, own, after = distance[i - 1], distance[i], distance[i + 1]
    if _near(hypot(x2 - x1, y2 - y1), own, after, step[i], usual, rules):
        return False
    if _near(hypot(x1 - x0, y1 - y0), before, own, step[i - 1], usual, rules):
        return False
    return _reached(hypot(x2 - x0, y2 - y0), before, after, step[i] + step[i - 1], rules)


@jit
def _measure(x, y, count, few, way):
    """Write the length *way* (m) along the points, measured between every *few*-th of them because of noise."""
    way[0] = 0.0
    at = 0
    while at < count - 1:
        node = min(at + few, count - 1)
        here = way[at]
        there = here + hypot(x[node] - x[at], y[node] - y[at])
        slope = (there - here) / (node - at)
        for j in range(at + 1, node):
            way[j] = slope * (j - at) + here
        way[node] = there
        at = node


@jit
def _align(x, y, count, way, near, rules, aligned):
    """Mark the points that lie on the line of two others, REACH before and REACH after them along the points."""
    tolerance = 3.0 * sqrt(1.5) * rules[SIGMA] + rules[ALIGNMENT]
    begin, end, back, ahead = 0, -1, 0, 0
    for i in range(count):
        if i > end:  # begin the next run of points near each other
            begin = end = i
            while near[end]:
                end += 1
        while back < i and way[back + 1] <= way[i] - rules[REACH]:
            back += 1
        while ahead < count and way[ahead] < way[i] + rules[REACH]:
            ahead += 1
        before, after = max(back, begin), min(ahead, end)
        aligned[i] = True
        if before < i < after:
            fx, fy = x[before], y[before]
            cx, cy = x[after] - fx, y[after] - fy
            beside = abs(cx * (y[i] - fy) - cy * (x[i] - fx))
            aligned[i] = beside <= tolerance * max(hypot(cx, cy), 1e-12)


@jit
def _sum(x, y, begin, end, row):
    """Write mean, end and scatter of a cluster's points; the end is that of evenly spread points."""
    mx, my, xx, xy, yy = 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(begin, end):
        mx += x[j]
        my += y[j]
    mx /= end - begin
    my /= end - begin
    for j in range(begin, end):
        dx, dy = x[j] - mx, y[j] - my
        xx += dx * dx
        xy += dx * dy
        yy += dy * dy
    angle, larger = axis(xx, xy, yy)
    half = sqrt(3.0 * larger / (end - begin))
    row[MEAN], row[MEAN + 1], row[END], row[END + 1] = mx, my, half * cos(angle), half * sin(angle)
    row[SCATTER], row[SCATTER + 1], row[SCATTER + 2] = xx, xy, yy


@jit
def axis(xx, xy, yy):
    """Fit a line by total least squares: angle of the major axis, rad, and scatter along it, m^2.

    The sums are about the mean of the points.
    """
    return 0.5 * atan2(2.0 * xy, xx - yy), 0.5 * (xx + yy + hypot(xx - yy, 2.0 * xy))


@jit
def draw(xy, ray, distance, members, first, size, sums, rules, work, marks, found):
    """Fit straight lines through the k clusters of `cut` and the points near them; return the number of lines.

    Clusters on the line of the largest one are merged with it first. *ray* (n, 2): unit vectors to the points. *found*:
    (max lines, COLUMNS). Scratch: *work* (6, n), *marks* (2, n).
    """
    k, lines = size.shape[0], 0
    free, group = marks[0], marks[1]
    free[:k] = 1
    for _ in range(found.shape[0]):
        seed = -1
        for c in range(k):
            if free[c] and (seed < 0 or size[c] > size[seed]):
                seed = c
        if seed < 0:
            break
        total, mx, my, angle = _gather(seed, size, sums, rules[MERGE], free, group)
        ax, ay = cos(angle), sin(angle)
        low, high = inf, -inf
        for c in range(k):
            if group[c]:
                free[c] = 0
                for j in range(first[c], first[c] + size[c]):
                    i = members[j]
                    place = ax * xy[i, 0] + ay * xy[i, 1]
                    low, high = min(low, place), max(high, place)
        if total < rules[MIN_POINTS] // 2 or high - low < 0.5 * rules[MIN_LENGTH]:
            continue
        low, high = low - rules[BEYOND], high + rules[BEYOND]
        near = 0
        for i in range(xy.shape[0]):
            x, y = xy[i, 0], xy[i, 1]
            if low <= ax * x + ay * y <= high:
                work[X, near], work[Y, near], work[U, near], work[V, near] = x, y, ray[i, 0], ray[i, 1]
                work[FAR, near] = distance[i]
                near += 1
        lines += _fit(work, near, mx, my, ax, ay, rules, found[lines])
    return lines


@jit
def _gather(seed, size, sums, merge, free, group):
    """Mark the free clusters whose ends are within *merge* (m) of their common line, starting with *seed*.

    Returns number, mean (m) and angle (rad) of their points.
    """
    k = size.shape[0]
    group[:k] = 0
    group[seed] = 1
    for _ in range(ROUNDS):
        _, mx, my, angle = _pool(size, sums, group)
        nx, ny = -sin(angle), cos(angle)
        changed = False
        for c in range(k):
            off = abs((sums[c, MEAN] - mx) * nx + (sums[c, MEAN + 1] - my) * ny)
            off += abs(sums[c, END] * nx + sums[c, END + 1] * ny)  # of the farther end
            joined = 1 if c == seed or (free[c] and off <= merge) else 0
            if joined != group[c]:
                group[c] = joined
                changed = True
        if not changed:
            break
    return _pool(size, sums, group)


@jit
def _pool(size, sums, group):
    """Number, mean (m) and angle (rad) of the points of the marked clusters."""
    total, mx, my, xx, xy, yy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for c in range(size.shape[0]):
        if group[c]:
            total += size[c]
            mx += size[c] * sums[c, MEAN]
            my += size[c] * sums[c, MEAN + 1]
    mx /= total
    my /= total
    for c in range(size.shape[0]):
        if group[c]:
            dx, dy = sums[c, MEAN] - mx, sums[c, MEAN + 1] - my
            xx += sums[c, SCATTER] + size[c] * dx * dx
            xy += sums[c, SCATTER + 1] + size[c] * dx * dy
            yy += sums[c, SCATTER + 2] + size[c] * dy * dy
    return total, mx, my, axis(xx, xy, yy)[0]


@jit
def _fit(work, n, mx, my, ax, ay, rules, row):
    """Fit a line to n points in *work* and write it to *row*; False if it is too short or has too few points.

    Weighted total least squares from the line through (mx, my) along (ax, ay): the noise of a range counts by the sine
    of the angle between its ray and the line.
    """
    x, y, u, v, far, weight = work[X], work[Y], work[U], work[V], work[FAR], work[WEIGHT]
    offset, count, total, larger = ax * my - ay * mx, 0, 0.0, 0.0
    limit, scale = max(rules[MERGE], rules[OUTLIER] * rules[NOISE]), inf  # the initial line is rough
    for _ in range(ROUNDS):
        count, total, mx, my = 0, 0.0, 0.0, 0.0
        for j in range(n):
            steep = max(abs(ax * v[j] - ay * u[j]), MIN_STEEPNESS) * rules[NOISE]
            across = far[j] * rules[BEARING_NOISE] * (ax * u[j] + ay * v[j])
            variance = steep * steep + across * across
            weight[j] = 0.0
            if abs(ax * y[j] - ay * x[j] - offset) <= min(rules[OUTLIER] * scale * sqrt(variance), limit):
                count += 1
                weight[j] = 1.0 / variance
                total += weight[j]
                mx += weight[j] * x[j]
                my += weight[j] * y[j]
        if count < rules[MIN_POINTS]:
            return False
        mx /= total
        my /= total
        xx, xy, yy = 0.0, 0.0, 0.0
        for j in range(n):
            dx, dy = x[j] - mx, y[j] - my
            xx += weight[j] * dx * dx
            xy += weight[j] * dx * dy
            yy += weight[j] * dy * dy
        angle, larger = axis(xx, xy, yy)
        side = 1.0 if cos(angle) * ax + sin(angle) * ay >= 0.0 else -1.0
        ax, ay = side * cos(angle), side * sin(angle)
        offset = ax * my - ay * mx
        squares = 0.0
        for j in range(n):
            off = ax * y[j] - ay * x[j] - offset
            squares += weight[j] * off * off
        scale = max(1.0, sqrt(squares / max(count - 2, 1)))
    low, high, squares, steep, turned = inf, -inf, 0.0, 0.0, 0.0
    lever = -(ax * mx + ay * my)  # derivative of the offset by the angle, since the line passes through the mean
    for j in range(n):
        if weight[j] > 0.0:
            place = ax * x[j] + ay * y[j]
            low, high = min(low, place), max(high, place)
            off = ax * y[j] - ay * x[j] - offset
            squares += off * off
            # a range bias moves each point across the line by its ray's steepness, which varies along the line
            moved = weight[j] * (ax * v[j] - ay * u[j])
            steep += moved
            turned += moved * (place + lever)
    if high - low < rules[MIN_LENGTH]:
        return False
    row[ALONG], row[ALONG + 1], row[OFFSET], row[LEVER], row[LOW], row[HIGH] = ax, ay, offset, lever, low, high
    row[COUNT], row[TOTAL], row[LARGER], row[SCALE], row[SQUARES] = count, total, larger, scale, squares
    row[STEEP], row[TURNED] = steep, turned
    return True
