"""One period of a simulated machine: winches, retraction, body, cable vibration, and readings of the lines' sensors."""

from math import atan2, cos, exp, nan, pi, sin, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit
from cablewright.kernels.layout import FREE, NOT_CONVERGED, OK, TAU, WEIGHT
from cablewright.kernels.plant.counterweights import hang, rise
from cablewright.kernels.plant.dynamics import PLACE, RATE, TURN, VELOCITY, YAW_REST, midpoint_step
from cablewright.kernels.plant.retracting_platform import LENGTH, pull_along, set_part, set_points, turn_drive
from cablewright.kernels.plant.winding import STRAIN, count, radius_at, turn_winches
from cablewright.kernels.rotation import cross, matrix, rotate
from cablewright.kernels.statics.line.interface import draw_line, guess_line
from cablewright.kernels.statics.line.solved_line import heading_of_line
from cablewright.kernels.statics.line.upright import is_slack, start_force
from cablewright.kernels.statics.line.vertical_plane import place
from cablewright.kernels.statics.platform import load_scale, place_platform, pose_of

# Columns of a line's readings: tension at the sheave, N; tangent's angle, true and by an accelerometer, rad; length of
# the straight line, m; direction of the free span in plan view, rad.
TENSION, TANGENT, SHOWN, TAUT, HEADING = 0, 1, 2, 3, 4
SHOWS = 5

# What `observe` writes of each line, all lines one after another, after the motion of drum or body: length, tension,
# excess, radius at the drum, angle by the accelerometer, direction of the swivel, tension at the winch.
LINES, OF_EACH = 12, 7
LENGTHS, PULLS, EXCESS, RADII, ANGLES, SWIVELS, WINCH_PULLS = 0, 1, 2, 3, 4, 5, 6

# Entries of the vibration parameters: damping ratio; amplitude in steady state at mid-span, m; gravity, m/s^2.
DAMPING, AMPLITUDE, GRAVITY = 0, 1, 2

PUSHED = 2.0 / pi  # share of its end's acceleration that excites a line's first mode


class Drive(NamedTuple):
    """State and parameters of the drive that retracts a platform; its *beam* is empty without one."""

    beam: NDArray[np.float64]  # (BEAM,) or (0,)
    moved: NDArray[np.float64]  # (m,): 1 of lines whose platform points move
    fixed: NDArray[np.float64]  # (m, 3): platform points at a length of 0, m
    speed: NDArray[np.float64]  # (1,): commanded, m/s
    flags: NDArray[np.int64]  # (1,): see `retracting_platform.turn_drive`


@jit
def advance(
    packed,
    body,
    winches,
    motor,
    radii,
    wound,
    sideways,
    speeds,
    drive,
    vibration,
    noise,
    dt,
    motion,
    lengths,
    states,
    vibrations,
    acceleration,
    tensions,
    flags,
    work,
    swing,
    after,
):
    """Advance the simulated machine by len(*noise*) steps of *dt* (s).

    Arguments from *motion* on are updated in place. *speeds* (m,): commanded speeds of the winch drums, rad/s. *drive*:
    that of the retraction. *vibration* (3,): parameters of the lines' first mode; *noise* (k, m): standard normal
    numbers that excite it; *vibrations* (m, 2): its displacement (m) and speed at mid-span. *acceleration* (6,): of the
    body's origin and of its rotation in the last step, m/s^2 and rad/s^2. For other arguments see
    `winding.turn_winches`. Returns a code; during a failed step the body stands still.
    """
    code = OK
    for k in range(noise.shape[0]):
        turn_winches(winches, motor, radii, wound, sideways, speeds, tensions, dt, after, flags)
        if drive.beam.shape[0] > 0:
            _retract(packed, body, drive, dt, states, work)
        hang(swing.weights, packed.lines, states, dt, lengths, after)
        for j in range(3):
            acceleration[j] = -motion[VELOCITY + j]
            acceleration[3 + j] = -motion[RATE + j]
        done = midpoint_step(packed, body, motion, lengths, after, dt, states, work, swing)
        if done != OK:
            done = retry(packed, body, motion, lengths, after, dt, states, work, swing)
        if done != OK:
            code = done
            for j in range(3):
                motion[VELOCITY + j] = motion[RATE + j] = 0.0
        for j in range(3):
            acceleration[j] = (acceleration[j] + motion[VELOCITY + j]) / dt
            acceleration[3 + j] = (acceleration[3 + j] + motion[RATE + j]) / dt
        carry_ends(motion, acceleration, work.arms, swing.ends)
        for i in range(lengths.shape[0]):
            lengths[i] = after[i]
            tensions[i] = exp(states[i, TAU])
            if not is_slack(packed.lines[i], states[i]):
                end, shape = swing.ends[i], vibrations[i]
                heading = heading_of_line(packed.lines[i], states[i], work.planes[i], packed.general)
                vibrate(packed.lines[i], states[i], heading, end, noise[k, i], vibration, dt, shape)
        rise(swing.weights, packed.lines, states, dt, lengths, done == OK)
    if drive.beam.shape[0] > 0:
        set_points(packed.lines, drive.beam, drive.moved, drive.fixed, drive.beam[LENGTH])
    return code


@jit
def _retract(packed, body, drive, dt, states, work):
    """Move the retraction for *dt* (s), and the platform points to where they are half of it before its end."""
    before = drive.beam[LENGTH]
    pull = pull_along(packed, body, drive.beam, drive.moved, states, work.planes, work.rotation)
    acceleration = turn_drive(drive.beam, drive.speed[0], pull, dt, drive.flags)
    set_part(body, drive.beam, acceleration)
    set_points(packed.lines, drive.beam, drive.moved, drive.fixed, 0.5 * (before + drive.beam[LENGTH]))


@jit
def carry_ends(motion, acceleration, arms, ends):
    """Write the acceleration (m, 3), m/s^2, of each platform point of a moving body.

    Its arm (m, 3), m, is in world axes, from the body's origin.
    """
    wx, wy, wz = motion[RATE], motion[RATE + 1], motion[RATE + 2]
    ex, ey, ez = acceleration[3], acceleration[4], acceleration[5]
    square = wx * wx + wy * wy + wz * wz
    for i in range(arms.shape[0]):
        rx, ry, rz = arms[i, 0], arms[i, 1], arms[i, 2]
        dot = wx * rx + wy * ry + wz * rz
        ends[i, 0] = acceleration[0] + (ey * rz - ez * ry + wx * dot - rx * square)
        ends[i, 1] = acceleration[1] + (ez * rx - ex * rz + wy * dot - ry * square)
        ends[i, 2] = acceleration[2] + (ex * ry - ey * rx + wz * dot - rz * square)


@jit
def retry(packed, body, motion, before, after, dt, states, work, swing):
    """Repeat a failed dynamic step from newly guessed line states."""
    share = load_scale(packed) / packed.lines.shape[0]
    pose_of(motion[PLACE : PLACE + 3], motion[TURN : TURN + 3], swing.place)
    place_platform(swing.place, work.rotation)
    for i in range(packed.lines.shape[0]):
        if is_slack(packed.lines[i], states[i]):
            continue
        place(packed.lines, i, swing.place, work.rotation, work.arms[i], work.planes[i])
        row, y, length = packed.lines[i], states[i], 0.5 * (before[i] + after[i])
        if not guess_line(row, y, swing.place, i, length, share, work, work.spatial):
            return NOT_CONVERGED
    return midpoint_step(packed, body, motion, before, after, dt, states, work, swing)


@jit
def vibrate(row, y, heading, acceleration, noise, vibration, dt, shape):
    """Advance the first transverse vibration mode of a cable in its plane, along *heading*, by *dt* (s).

    *shape* (2,) is its displacement and speed. The mode is that of a taut string, excited by its moving end and by
    *noise*; exact for constant excitation. *acceleration* (3,): that of the platform point, m/s^2.
    """
    if row[WEIGHT] == 0.0:
        return
    h, v = start_force(y)
    end = v + row[WEIGHT] * y[FREE]
    tension = sqrt(h * h + end * end)
    normal = _normal(h, end, tension, heading, acceleration)
    ratio = vibration[DAMPING]
    pulse = pi / y[FREE] * sqrt(tension * vibration[GRAVITY] / row[WEIGHT])
    force = -PUSHED * normal + vibration[AMPLITUDE] * noise * sqrt(4.0 * ratio * pulse * pulse * pulse / dt)
    still = force / (pulse * pulse)
    damped = pulse * sqrt(1.0 - ratio * ratio)
    keep, c, s = exp(-ratio * pulse * dt), cos(damped * dt), sin(damped * dt)
    away, moving = shape[0] - still, shape[1]
    shape[0] = still + keep * (away * c + (moving + ratio * pulse * away) / damped * s)
    shape[1] = keep * (moving * c - (pulse * pulse * away + ratio * pulse * moving) / damped * s)


@jit
def _normal(h, end, tension, heading, acceleration):
    """Acceleration of the platform point across the line, in its plane, m/s^2."""
    along = heading[0] * acceleration[0] + heading[1] * acceleration[1]
    return (h * acceleration[2] - end * along) / tension


@jit
def show_lines(packed, states, pose, work, ends, vibrations, vibration, sensors_at, scratch, shown):
    """Write the simulated readings of each line's sensors to *shown* (m, SHOWS).

    Accelerometers are *sensors_at* (m,), m before the platform. *pose* (n,): at which the lines are placed in *work*.
    *ends* (m, 3): acceleration of each platform point, m/s^2.
    """
    for i in range(packed.lines.shape[0]):
        row, y, acceleration, sensor_at = packed.lines[i], states[i], ends[i], sensors_at[i]
        heading = heading_of_line(row, y, work.planes[i], packed.general)
        h, v = start_force(y)
        here = v + row[WEIGHT] * (y[FREE] - sensor_at)
        shown[i, TENSION] = exp(y[TAU])
        shown[i, TANGENT] = tangent = atan2(here, h)
        shown[i, SHOWN] = tangent
        shown[i, HEADING] = atan2(heading[1], heading[0])
        shown[i, TAUT] = draw_line(row, scratch, pose, i, 1.0, work, work.spatial)
        if row[WEIGHT] == 0.0:
            continue
        end = v + row[WEIGHT] * y[FREE]
        tension = sqrt(h * h + end * end)
        wave = pi / y[FREE]
        pulse = wave * sqrt(tension * vibration[GRAVITY] / row[WEIGHT])
        swung = -(pulse * pulse * vibrations[i, 0] + 2.0 * vibration[DAMPING] * pulse * vibrations[i, 1])
        share = 1.0 - sensor_at / y[FREE]
        normal = share * _normal(h, end, tension, heading, acceleration) + swung * sin(wave * sensor_at)
        along = heading[0] * acceleration[0] + heading[1] * acceleration[1]
        tangential = share * (h * along + end * acceleration[2]) / tension
        tilted = tangent - vibrations[i, 0] * wave * cos(wave * sensor_at)
        gravity = vibration[GRAVITY]
        shown[i, SHOWN] = atan2(gravity * sin(tilted) + tangential, gravity * cos(tilted) + normal)


@jit
def observe(
    packed, states, pose, work, ends, vibrations, vibration, sensors_at, scratch, shown,
    motion, lengths, winches, radii, ratio, upright, hosts, begin, counts_per_turn, told, rotation, counts,
):  # fmt: skip
    """Write what sensors measure: each line's readings, as `show_lines`, and the numbers *told* (12 + 7 m,).

    These are *motion* (12,); and of each line its length, m, tension, N, excess, m, the radius at which it leaves its
    drum, m, the angle that its accelerometer shows, rad, the direction of its swivel, rad, NaN unless *upright* (m,),
    and the tension at its winch, N, by the *ratio* (m,). Writes also the *rotation* (3, 3) of the drum or body, and the
    encoders' *counts* (w,), see `winding.count`.
    """
    show_lines(packed, states, pose, work, ends, vibrations, vibration, sensors_at, scratch, shown)
    m = lengths.shape[0]
    for k in range(LINES):
        told[k] = motion[k]
    for i in range(m):
        told[LINES + i], told[LINES + m + i] = lengths[i], shown[i, TENSION]
        told[LINES + 2 * m + i] = lengths[i] - shown[i, TAUT]
        told[LINES + 3 * m + i] = radius_at(winches[i], radii[i])
        told[LINES + 4 * m + i] = shown[i, SHOWN]
        told[LINES + 5 * m + i] = shown[i, HEADING] if upright[i] else nan
        told[LINES + 6 * m + i] = shown[i, TENSION] * ratio[i]
    matrix(motion[TURN : TURN + 3], rotation)
    count(winches, hosts, begin, counts_per_turn, counts)


@jit
def drift(motion, last, twist, moved, normal, yaw, body, strains, winches, nozzle, rotation):
    """Set the *strains* (m,) of cables on their winches, and change the yaw at which the twist of a drum's lines rests.

    *twist* (2,): deviation, rad, and length, m, of its random walk; empty: of another platform, or in a plane.
    *moved*: m, since it was at *last* (3,), m, which becomes where it is; *normal*: a standard normal number; *yaw*,
    rad: of the drum against what its lines carry. Writes the *rotation* (3, 3). Returns where in plan view the *nozzle*
    (3,), m, of the body is, and the yaw without that of the drum.
    """
    rest = 0.0
    for i in range(strains.shape[0]):
        winches[i, STRAIN] = strains[i]
    matrix(motion[TURN : TURN + 3], rotation)
    x, y, _ = rotate(rotation, nozzle[0], nozzle[1], nozzle[2])
    if twist.shape[0] > 0:
        keep = exp(-moved / twist[1])
        push = twist[0] * sqrt(1.0 - keep * keep)
        rest = keep * (body[YAW_REST] - yaw) + push * normal
        body[YAW_REST] = rest + yaw
        for k in range(3):
            last[k] = motion[PLACE + k]
    return motion[PLACE] + x, motion[PLACE + 1] + y, rest


@jit(allocates=True)
def feel(rotation, place, acceleration, rate, gravity, axes, measured):
    """Add the reading of an ideal accelerometer and gyro at *place* (3,), m, on a moving body to *measured* (6,).

    They are the specific force, m/s^2, and the turn rate, rad/s. *rotation* (3, 3), *acceleration* (6,), m/s^2 and
    rad/s^2, and *rate* (3,), rad/s, world: of the body. *axes* (3, 3): of the unit, in the body's frame.
    """
    force = np.empty(3)
    x, y, z = rotate(rotation, place[0], place[1], place[2])
    ax, ay, az = cross(acceleration[3], acceleration[4], acceleration[5], x, y, z)
    x, y, z = cross(rate[0], rate[1], rate[2], x, y, z)
    x, y, z = cross(rate[0], rate[1], rate[2], x, y, z)
    force[0], force[1], force[2] = acceleration[0] + ax + x, acceleration[1] + ay + y, acceleration[2] + az + z
    force[2] += gravity
    for j in range(3):
        for k in range(3):
            along = 0.0
            for i in range(3):
                along += rotation[k, i] * axes[i, j]
            measured[j] += force[k] * along
            measured[3 + j] += rate[k] * along
