"""The swing of a platform whose lines are paid out along a path: free vibrations between samples, one after another.

The lengths of a sample hold the platform at rest at the pose e. Between two samples e goes linearly in time, so the
platform's displacement p from e is a free vibration of its modes, which is known at all times; at a sample the velocity
of e jumps by v, and that of p by -v. Modes are those of the sample at the end of each stretch. What counts is the
displacement q of the platform from its target: p, and the error of e itself, the *offset* there.
"""

from math import cos, exp, hypot, pi, sin, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import copy
from cablewright.kernels.layout import OK, SINGULAR
from cablewright.kernels.motion.modal import follow_modes

POINTS = 20  # of a period at which a vibration is looked at: its peaks are found to 1.3 %
STEPS = 1024  # looked at in one stretch at most: later peaks are bounded by the sum of all amplitudes
CHECKED = 8  # steps after which it is seen whether what remains can still be a peak
MINOR = 0.01  # share of a quantity's amplitudes below which a mode is not looked at in steps of its own

# Rows of the state that is carried from sample to sample, (CARRIED, f).
PLACE, RATE, SPEED, OFFSET, KNOWN = 0, 1, 2, 3, 4  # p, its rate, the rate of e, the offset; whether the first are known
CARRIED = 5


class SwingWork(NamedTuple):
    """Working memory of `swing_rows`, for f degrees of freedom and o outputs: nozzle coordinates and tensions."""

    lower: NDArray[np.float64]  # (f, f)
    system: NDArray[np.float64]  # (f, f)
    vectors: NDArray[np.float64]  # (f, f)
    shapes: NDArray[np.float64]  # (f, f)
    values: NDArray[np.float64]  # (f,) (rad/s)^2
    rates: NDArray[np.float64]  # (f,) rad/s, undamped
    cosine: NDArray[np.float64]  # (f,) modal displacement
    sine: NDArray[np.float64]  # (f,) that a quarter of a period before, but for damping
    turns: NDArray[np.float64]  # (f, 2) what a step of time multiplies both by, as a complex number
    gains: NDArray[np.float64]  # (o, f) outputs per cosine
    waves: NDArray[np.float64]  # (o, f) and per sine
    sizes: NDArray[np.float64]  # (1 + m, f) output per amplitude of a mode: of the nozzle, and of each tension
    before: NDArray[np.float64]  # (o,) outputs of the offset where a stretch begins
    after: NDArray[np.float64]  # (o,) and where it ends


@jit(allocates=True)
def swing_rows(
    mass, stiffness, point, pull, heavy, moves, offsets, spent, dwell, fresh, ratio, carried, displacement, frequency,
    drop, rise, codes,
):  # fmt: skip
    """Follow the swing over b samples, and write its extremes up to each of them and in its dwell.

    *mass*, *stiffness* (b, f, f). *point* (b, 3, f): motion of the nozzle, *pull* and *heavy* (b, m, f): changes of
    tensions per displacement and per acceleration of the platform. *moves* (b, f): of the wanted pose since the sample
    before; *offsets* (b, f); *spent*, *dwell* (b,), s. *fresh* (b,): where it begins at rest. *ratio*: of damping,
    under 1. *carried* (CARRIED, f): the state, in and out. Written: *displacement* (b,), m, of the nozzle, *frequency*
    (b,), Hz, of the mode with most of it, *drop* and *rise* (b, m), N, of tensions, *codes* (b,).
    """
    f, m = mass.shape[1], pull.shape[1]
    work = _swing(f, m)
    for k in range(mass.shape[0]):
        codes[k], frequency[k] = OK, 0.0
        for i in range(m):
            drop[k, i] = rise[k, i] = 0.0
        if not (follow_modes(mass[k], stiffness[k], work.lower, work.system, work.vectors, work.shapes, work.values)
                and _is_stable(work)):  # fmt: skip
            codes[k], displacement[k], carried[KNOWN, 0] = SINGULAR, np.nan, 0.0
            continue
        _read(point[k], pull[k], heavy[k], ratio, work)
        _offset(point[k], pull[k], offsets[k], work.after)
        if fresh[k] or carried[KNOWN, 0] == 0.0:
            carried[:, :] = 0.0
            carried[KNOWN, 0] = 1.0
            copy(offsets[k], carried[OFFSET])
            displacement[k] = hypot(work.after[0], hypot(work.after[1], work.after[2]))
            continue
        displacement[k] = 0.0
        _offset(point[k], pull[k], carried[OFFSET], work.before)
        for i in range(f):
            step = moves[k, i] + offsets[k, i] - carried[OFFSET, i]
            carried[OFFSET, i] = offsets[k, i]
            if spent[k] > 0.0:
                carried[RATE, i] += carried[SPEED, i] - step / spent[k]
                carried[SPEED, i] = step / spent[k]
            else:
                carried[PLACE, i] -= step
        if spent[k] > 0.0:
            _vibrate(mass[k], spent[k], ratio, carried, displacement, frequency, drop, rise, k, work)
        if dwell[k] > 0.0:
            for i in range(f):
                carried[RATE, i] += carried[SPEED, i]
                carried[SPEED, i] = 0.0
            copy(work.after, work.before)
            _vibrate(mass[k], dwell[k], ratio, carried, displacement, frequency, drop, rise, k, work)


@jit(allocates=True)
def _swing(f, m):
    """Scratch; the vectors are those of no neighbour."""
    return SwingWork(
        np.zeros((f, f)),
        np.zeros((f, f)),
        np.eye(f),
        np.zeros((f, f)),
        np.zeros(f),
        np.zeros(f),
        np.zeros(f),
        np.zeros(f),
        np.zeros((f, 2)),
        np.zeros((3 + m, f)),
        np.zeros((3 + m, f)),
        np.zeros((1 + m, f)),
        np.zeros(3 + m),
        np.zeros(3 + m),
    )


@jit
def _is_stable(work):
    """Set the rates of the modes. False where the platform is unstable in one of them."""
    for c in range(work.values.shape[0]):
        if not work.values[c] > 0.0:
            return False
        work.rates[c] = sqrt(work.values[c])
    return True


@jit
def _read(point, pull, heavy, ratio, work):
    """Set the outputs per mode of a platform that moves by its shapes."""
    f, m = work.shapes.shape[0], pull.shape[0]
    for c in range(f):
        rate = work.rates[c]
        twice = 2.0 * ratio * rate
        square = 0.0
        for o in range(3 + m):
            gain = change = 0.0
            for i in range(f):
                if o < 3:
                    gain += point[o, i] * work.shapes[i, c]
                else:
                    gain += pull[o - 3, i] * work.shapes[i, c]
                    change += heavy[o - 3, i] * work.shapes[i, c]
            # acceleration: minus the square of the rate times the displacement, less damping times the velocity
            work.gains[o, c] = gain + change * (0.5 * twice * twice - rate * rate)
            work.waves[o, c] = change * twice * rate * sqrt(1.0 - ratio * ratio)
            if o < 3:
                square += gain * gain
            else:
                work.sizes[o - 2, c] = hypot(work.gains[o, c], work.waves[o, c])
        work.sizes[0, c] = sqrt(square)


@jit
def _offset(point, pull, offset, outputs):
    """Write the *outputs* (o,) of a platform displaced by *offset* (f,)."""
    for o in range(outputs.shape[0]):
        total = 0.0
        for i in range(offset.shape[0]):
            total += (point[o, i] if o < 3 else pull[o - 3, i]) * offset[i]
        outputs[o] = total


@jit
def _vibrate(mass, duration, ratio, carried, displacement, frequency, drop, rise, k, work):
    """Let the platform vibrate for *duration* (s), and enlarge the extremes of row *k* by those of this time."""
    _enter(mass, ratio, carried, work)
    f, m = work.rates.shape[0], drop.shape[1]
    step, count = _steps(duration, work)
    _turn(step, ratio, work)
    most, done = displacement[k] * displacement[k], 0
    first = _loudest(work)
    while True:
        share, square = min(done * step / duration, 1.0), 0.0
        for o in range(3 + m):
            value = work.before[o] + share * (work.after[o] - work.before[o])
            for c in range(f):
                value += work.gains[o, c] * work.cosine[c] + work.waves[o, c] * work.sine[c]
            if o < 3:
                square += value * value
            else:
                drop[k, o - 3], rise[k, o - 3] = min(drop[k, o - 3], value), max(rise[k, o - 3], value)
        if square > most:
            most, frequency[k] = square, work.rates[first] / (2.0 * pi)
        if done == count or (done % CHECKED == CHECKED - 1 and _is_over(most, drop[k], rise[k], work)):
            break
        _advance(work)
        done += 1
    left = duration - done * step
    if left > 1e-9 * duration:
        if done == count:
            most = _bound(most, drop[k], rise[k], work)
        _turn(left, ratio, work)
        _advance(work)
    displacement[k] = sqrt(most)
    _leave(ratio, carried, work)


@jit
def _enter(mass, ratio, carried, work):
    """Set the modal displacements from the platform's displacement and rate."""
    f = mass.shape[0]
    for c in range(f):
        place = rate = 0.0
        for i in range(f):
            for j in range(f):
                weight = work.shapes[i, c] * mass[i, j]
                place += weight * carried[PLACE, j]
                rate += weight * carried[RATE, j]
        work.cosine[c] = place
        work.sine[c] = -(rate + ratio * work.rates[c] * place) / (work.rates[c] * sqrt(1.0 - ratio * ratio))


@jit
def _leave(ratio, carried, work):
    """Set the platform's displacement and rate from the modal displacements."""
    f = work.rates.shape[0]
    carried[PLACE, :] = 0.0
    carried[RATE, :] = 0.0
    for c in range(f):
        x, y, rate = work.cosine[c], work.sine[c], work.rates[c]
        speed = -rate * (ratio * x + sqrt(1.0 - ratio * ratio) * y)
        for i in range(f):
            carried[PLACE, i] += work.shapes[i, c] * x
            carried[RATE, i] += work.shapes[i, c] * speed


@jit
def _turn(step, ratio, work):
    """Set what a *step* (s) multiplies the modal displacements by."""
    damped = sqrt(1.0 - ratio * ratio)
    for c in range(work.rates.shape[0]):
        size, angle = exp(-ratio * work.rates[c] * step), damped * work.rates[c] * step
        work.turns[c, 0], work.turns[c, 1] = size * cos(angle), size * sin(angle)


@jit
def _advance(work):
    """Let the modes vibrate for a step."""
    for c in range(work.rates.shape[0]):
        x, y = work.cosine[c], work.sine[c]
        work.cosine[c] = work.turns[c, 0] * x - work.turns[c, 1] * y
        work.sine[c] = work.turns[c, 1] * x + work.turns[c, 0] * y


@jit
def _steps(duration, work):
    """Return the step (s) and the number of steps by the fastest mode with more than a minor share of anything."""
    fastest = 0.0
    for o in range(work.sizes.shape[0]):
        total = 0.0
        for c in range(work.rates.shape[0]):
            total += work.sizes[o, c] * hypot(work.cosine[c], work.sine[c])
        for c in range(work.rates.shape[0]):
            if work.sizes[o, c] * hypot(work.cosine[c], work.sine[c]) > MINOR * total:
                fastest = max(fastest, work.rates[c])
    needed = duration * fastest * POINTS / (2.0 * pi)
    if needed <= STEPS:
        count = int(needed) + 1
        return duration / count, count
    return 2.0 * pi / (POINTS * fastest), STEPS


@jit
def _loudest(work):
    """The mode with the largest amplitude at the nozzle."""
    most, found = -1.0, 0
    for c in range(work.rates.shape[0]):
        size = work.sizes[0, c] * hypot(work.cosine[c], work.sine[c])
        if size > most:
            most, found = size, c
    return found


@jit
def _amplitude(o, work):
    """What all modes can still add to the nozzle (*o* = 0) or a tension, and the larger of both offsets."""
    total = 0.0
    for c in range(work.rates.shape[0]):
        total += work.sizes[o, c] * hypot(work.cosine[c], work.sine[c])
    if o == 0:
        begin = hypot(work.before[0], hypot(work.before[1], work.before[2]))
        return total + max(begin, hypot(work.after[0], hypot(work.after[1], work.after[2])))
    return total + max(abs(work.before[o + 2]), abs(work.after[o + 2]))


@jit
def _is_over(most, drop, rise, work):
    """Whether the remaining vibration cannot exceed the extremes found so far."""
    size = _amplitude(0, work)
    if size * size > most:
        return False
    for i in range(drop.shape[0]):
        if _amplitude(1 + i, work) > min(-drop[i], rise[i]):
            return False
    return True


@jit
def _bound(most, drop, rise, work):
    """Enlarge the extremes to the bound of the remaining vibration; return the square of the nozzle's."""
    for i in range(drop.shape[0]):
        size = _amplitude(1 + i, work)
        drop[i], rise[i] = min(drop[i], -size), max(rise[i], size)
    size = _amplitude(0, work)
    return max(most, size * size)
