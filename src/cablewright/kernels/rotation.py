"""Rotations as rotation vectors, rad. Increments are about world axes: R becomes exp(d) R."""

from math import atan2, cos, hypot, pi, sin, sqrt

import numpy as np

from cablewright.kernels import jit


@jit
def matrix(vector, out):
    """Write the (3, 3) matrix of rotation *vector* (3,) to *out* (Rodrigues)."""
    x, y, z = vector[0], vector[1], vector[2]
    angle = sqrt(x * x + y * y + z * z)
    if angle > 1e-4:
        a = sin(angle) / angle
        b = (1.0 - cos(angle)) / (angle * angle)
    else:
        a = 1.0 - angle * angle / 6.0
        b = 0.5 - angle * angle / 24.0
    _write(x, y, z, a, b, out)


@jit
def _write(x, y, z, a, b, out):
    """Identity plus a [v]x plus b [v]x [v]x."""
    out[0, 0] = 1.0 - b * (y * y + z * z)
    out[1, 1] = 1.0 - b * (x * x + z * z)
    out[2, 2] = 1.0 - b * (x * x + y * y)
    out[0, 1] = b * x * y - a * z
    out[1, 0] = b * x * y + a * z
    out[0, 2] = b * x * z + a * y
    out[2, 0] = b * x * z - a * y
    out[1, 2] = b * y * z - a * x
    out[2, 1] = b * y * z + a * x


@jit
def rotate(rotation, x, y, z):
    """Return the vector (x, y, z) multiplied by the (3, 3) matrix *rotation*."""
    return (
        rotation[0, 0] * x + rotation[0, 1] * y + rotation[0, 2] * z,
        rotation[1, 0] * x + rotation[1, 1] * y + rotation[1, 2] * z,
        rotation[2, 0] * x + rotation[2, 1] * y + rotation[2, 2] * z,
    )


@jit
def rotate_back(rotation, x, y, z):
    """The vector (x, y, z) multiplied by the transpose of the (3, 3) matrix *rotation*."""
    return (
        rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0] * z,
        rotation[0, 1] * x + rotation[1, 1] * y + rotation[2, 1] * z,
        rotation[0, 2] * x + rotation[1, 2] * y + rotation[2, 2] * z,
    )


@jit
def cross(ax, ay, az, bx, by, bz):
    """The vector product a x b."""
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@jit
def left_jacobian(vector, out):
    """Write to *out* the (3, 3) left Jacobian: from changes of rotation *vector* (3,) to increments in world axes."""
    x, y, z = vector[0], vector[1], vector[2]
    angle = sqrt(x * x + y * y + z * z)
    if angle > 1e-3:
        a = (1.0 - cos(angle)) / (angle * angle)
        b = (angle - sin(angle)) / (angle * angle * angle)
    else:
        a = 0.5 - angle * angle / 24.0
        b = 1.0 / 6.0 - angle * angle / 120.0
    _write(x, y, z, a, b, out)


@jit
def compose(x, y, z, vector):
    """Compose rotation *vector* (3,) in place with the world increment (x, y, z): exp(increment) exp(vector)."""
    aw, ax, ay, az = _quaternion(x, y, z)
    bw, bx, by, bz = _quaternion(vector[0], vector[1], vector[2])
    w = aw * bw - ax * bx - ay * by - az * bz
    x = aw * bx + ax * bw + ay * bz - az * by
    y = aw * by - ax * bz + ay * bw + az * bx
    z = aw * bz + ax * by - ay * bx + az * bw
    size = sqrt(x * x + y * y + z * z)
    if w < 0.0:
        w, x, y, z = -w, -x, -y, -z
    factor = 2.0 * atan2(size, w) / size if size > 1e-9 else 2.0
    vector[0], vector[1], vector[2] = factor * x, factor * y, factor * z


@jit
def _quaternion(x, y, z):
    angle = sqrt(x * x + y * y + z * z)
    factor = sin(0.5 * angle) / angle if angle > 1e-8 else 0.5 - angle * angle / 48.0
    return cos(0.5 * angle), factor * x, factor * y, factor * z


@jit
def yawed(yaw, x, y):
    """Return the rotation vector of a tilt by (x, y), rad, followed by a rotation by *yaw*, rad, by quaternions."""
    tilt = hypot(x, y)
    c, d = cos(0.5 * tilt), (0.5 if tilt < 1e-9 else sin(0.5 * tilt) / tilt)
    a, b = cos(0.5 * yaw), sin(0.5 * yaw)
    w, i, j, k = a * c, d * (a * x - b * y), d * (a * y + b * x), b * c
    if w < 0.0:
        w, i, j, k = -w, -i, -j, -k
    size = sqrt(i * i + j * j + k * k)
    scale = 2.0 if size < 1e-12 else 2.0 * atan2(size, w) / size
    return scale * i, scale * j, scale * k


@jit
def wrapped(angle):
    """Return an *angle*, rad, within half a turn of 0."""
    return angle - 2.0 * pi * np.rint(angle / (2.0 * pi))
