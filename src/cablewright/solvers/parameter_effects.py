"""First-order motion of the platform and change of tensions per uncertain parameter, from the linearisation."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.kernels.layout import EXIT, LENGTH
from cablewright.kernels.statics.line.spatial_parameter_derivatives import mount_rows
from cablewright.kernels.statics.line.vertical_plane import AXIS_DISTANCE
from cablewright.models.packed_views import PlatformNumbers
from cablewright.models.parameters import OF_LINES, OF_PLATFORM, lines_of
from cablewright.models.rotation import matrices, rotations
from cablewright.models.statics import Equilibrium
from cablewright.models.stiffness import along_chords
from cablewright.robot.parameters import Parameter
from cablewright.robot.uncertainty import Range
from cablewright.solvers.linearise import Linearisation, TensionChanges, linearise, tension_changes


def response(equilibrium: Equilibrium, parameters: Sequence[Parameter], linear: Linearisation | None = None) -> Array:
    """Return the motion (N, n, k) of the platform per parameter at the N solved rows of a batch, with lengths held.

    Motions are m and rad (world frame) per the parameter's unit. *linear* is the linearisation, if known. Raises
    `AnswerError` where a row was not solved or is singular, `InputError` where cables are rigid.
    """
    linear = linearise(equilibrium) if linear is None else linear
    out = np.zeros((len(equilibrium.pose), equilibrium.model.n, len(parameters)))
    compliance = linear.per_wrench
    for k, parameter in enumerate(parameters):
        if parameter.kind in OF_PLATFORM:
            wrench = _wrench(equilibrium, OF_PLATFORM[parameter.kind])
            out[:, :, k] = np.einsum("nij,nj->ni", compliance, wrench)
            continue
        for i, column, per in _columns(equilibrium, parameter):
            out[:, :, k] += linear.motion[:, :, i, column] * per[:, None]
    return out


def range_response(equilibrium: Equilibrium, ranges: Sequence[Range], linear: Linearisation | None = None) -> Array:
    """Return the `response` to the parameters of *ranges*, with the cable that zeroing pays out of each line."""
    linear = linearise(equilibrium) if linear is None else linear
    out = response(equilibrium, [each.parameter for each in ranges], linear)
    return out + linear.motion[..., LENGTH] @ zeroing(ranges, equilibrium.model.m).T


def zeroing(ranges: Sequence[Range], m: int) -> Array:
    """Return how much more cable *m* lines pay out by zeroing at a pose, per unit of k parameters, (k, m), m."""
    return np.array([each.zeroing or (0.0,) * m for each in ranges]).reshape(-1, m)


def at_nozzle(equilibrium: Equilibrium, motion: Array) -> Array:
    """Return the motion (N, 3, k) of the nozzle, m, for a *motion* (N, n, k) of the platform."""
    if equilibrium.model.n == 3:
        return motion
    arm = equilibrium.nozzle - equilibrium.pose[:, :3]
    return motion[:, :3] + np.cross(motion[:, 3:], arm[:, :, None], axis=1)


def nozzle_response(equilibrium: Equilibrium, parameters: Sequence[Parameter]) -> Array:
    """Return the motion (N, 3, k) of the nozzle per parameter; see `response`."""
    return at_nozzle(equilibrium, response(equilibrium, parameters))


def departures(parameters: Sequence[Parameter], nominal: Array, values: Array) -> Array:
    """Return differences of *values* (..., k) from *nominal* ones (k,), in variables with nearly linear statics.

    This is the difference; for a modulus factor, which acts through the compliance, it is 1 - 1 / factor.
    """
    inverse = np.array([one.kind in OF_LINES and OF_LINES[one.kind].by_inverse for one in parameters])
    return np.where(inverse, 1.0 / nominal.clip(min=1e-300) - 1.0 / np.where(inverse, values, 1.0), values - nominal)


def tension_response(
    equilibrium: Equilibrium, parameters: Sequence[Parameter], motion: Array, changes: TensionChanges
) -> Array:
    """Return the change (N, m, k) of tensions at the sheaves, N, per parameter.

    *motion* (N, n, k) is the `response`, *changes* the `tension_changes` of the same equilibrium.
    """
    out = changes.following(motion)
    for k, parameter in enumerate(parameters):
        for i, column, per in _columns(equilibrium, parameter):
            out[:, i, k] += changes.own[:, i, column] * per
    return out


def range_tension_response(
    equilibrium: Equilibrium, ranges: Sequence[Range], motion: Array, changes: TensionChanges
) -> Array:
    """Return `tension_response` to the parameters of *ranges*, with the cable that zeroing pays out of each line."""
    out = tension_response(equilibrium, [each.parameter for each in ranges], motion, changes)
    return out + changes.own[..., LENGTH, None] * zeroing(ranges, equilibrium.model.m).T


def _columns(equilibrium: Equilibrium, parameter: Parameter) -> Iterator[tuple[int, int, Array]]:
    """Yield lines with the parameter, its columns in the linearisation, and the factor (N,) to each column's unit."""
    if parameter.kind == "exit_compliance":
        yield from _by_mounts(equilibrium, lines_of(equilibrium.model.robot, parameter))
    elif parameter.kind in OF_LINES:
        number, robot = OF_LINES[parameter.kind], equilibrium.model.robot
        for i in lines_of(robot, parameter):
            yield i, number.linear, number.per(robot.lines[i], equilibrium.lengths[:, i])


def mount_lengths(equilibrium: Equilibrium) -> Array:
    """Return the extra line length on a stiff mount at the same tension, per compliance, (N, m), m per m/N.

    At the N solved rows of a batch, platform held, of mounts that are equally compliant in all directions; to first
    order. Displacement of an exit point across its line is neglected: it rotates the force by displacement over span.
    Raises `AnswerError` where a row was not solved, `InputError` where cables are rigid.
    """
    changes, out = tension_changes(equilibrium), np.zeros_like(equilibrium.lengths)
    for i, column, per in _by_mounts(equilibrium, range(equilibrium.model.m)):
        out[:, i] += changes.own[:, i, column] * per
    return out / changes.per_length


def _by_mounts(equilibrium: Equilibrium, lines: Iterable[int]) -> Iterator[tuple[int, int, Array]]:
    """As `_columns`: an exit goes as the force on it, and its dead span, whose winch stays, covers as much less."""
    rows, m = len(equilibrium.pose), equilibrium.model.m
    forces, dead = np.zeros((rows, m, 3)), np.zeros((rows, m, 3))
    away = equilibrium.platform_points[..., :2] - equilibrium.lines.exit_point[..., :2]
    planes = away / np.maximum(np.linalg.norm(away, axis=-1, keepdims=True), AXIS_DISTANCE)
    mount_rows(equilibrium.packed.lines, equilibrium.states, planes, forces, dead)
    for i in lines:
        for axis in range(3):
            yield i, EXIT + axis, forces[:, i, axis]
        yield i, LENGTH, (forces[:, i] * dead[:, i]).sum(axis=1)


def _wrench(equilibrium: Equilibrium, column: int) -> Array:
    """Change (N, n) of the wrench on the platform per unit of its parameter in a *column* of `Packed.platform`."""
    n, rows, width = equilibrium.model.n, len(equilibrium.pose), equilibrium.packed.platform.shape[1]
    there, one = PlatformNumbers(equilibrium.packed.platform), PlatformNumbers(np.eye(width)[column])
    if one.wrench.any():
        return np.tile(one.wrench[:n], (rows, 1))
    if one.weight > 0.0:  # the mass: one more kilogram at the centre of mass
        pull, centre = np.array([equilibrium.model.robot.scene.gravity]), there.centre_of_mass
    else:  # the centre of mass: the weight is displaced
        pull, centre = there.weight, one.centre_of_mass[None]
    force = np.broadcast_to(np.array([0.0, 0.0, -1.0]) * pull[:, None], (rows, 3))
    arms = np.einsum("nij,nj->ni", matrices(rotations(equilibrium.pose)), np.broadcast_to(centre, (rows, 3)))
    return np.hstack([force * float(one.weight), along_chords(n, force, arms)[:, 3:]])
