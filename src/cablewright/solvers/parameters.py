"""First order: how platform and tensions change with each uncertain number of a robot, from the one linearisation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import layout
from cablewright.kernels.statics import linearise as linearise_kernel
from cablewright.models.parameters import lines_of
from cablewright.models.rotation import matrices
from cablewright.models.statics import Equilibrium
from cablewright.robot.parameters import AXES, Parameter
from cablewright.solvers.linearise import Linearisation, TensionChanges, linearise

__all__ = ["at_nozzle", "departures", "nozzle_response", "response", "tension_response"]

Array = NDArray[np.float64]


def response(equilibrium: Equilibrium, parameters: Sequence[Parameter], linear: Linearisation | None = None) -> Array:
    """Motion (N, n, k) of the platform per each parameter at the N solved rows of a batch, with commands held.

    Motions are m and rad per the parameter's unit; a rotation is in space. *linear* is its linearisation, where there
    is one. Raises `AnswerError` where a row was not solved or is singular, `InputError` where cables are rigid.
    """
    linear = linear or linearise(equilibrium)
    out = np.zeros((len(equilibrium.pose), equilibrium.model.n, len(parameters)))
    compliance = linear.per_wrench
    for k, parameter in enumerate(parameters):
        wrench = _wrench(equilibrium, parameter)
        if wrench is not None:
            out[:, :, k] = np.einsum("nij,nj->ni", compliance, wrench)
            continue
        for i in lines_of(equilibrium.model.robot, parameter):
            column, times = _column(equilibrium, parameter, i)
            out[:, :, k] += linear.motion[:, :, i, column] * times[:, None]
    return out


def at_nozzle(equilibrium: Equilibrium, motion: Array) -> Array:
    """Motion (N, 3, k) of the nozzle, m, with a *motion* (N, n, k) of the platform."""
    if equilibrium.model.n == 3:
        return motion
    arm = equilibrium.nozzle - equilibrium.pose[:, :3]
    return motion[:, :3] + np.cross(motion[:, 3:], arm[:, :, None], axis=1)


def nozzle_response(equilibrium: Equilibrium, parameters: Sequence[Parameter]) -> Array:
    """As `response`, the motion (N, 3, k) of the nozzle."""
    return at_nozzle(equilibrium, response(equilibrium, parameters))


def departures(parameters: Sequence[Parameter], nominal: Array, values: Array) -> Array:
    """How far *values* (..., k) are from the *nominal* ones (k,), in what `response` is per and statics nearly linear.

    That is their difference; for a modulus, whose compliance is what stretches, 1 - 1 / factor.
    """
    modulus = np.array([parameter.kind == "modulus" for parameter in parameters])
    return np.where(modulus, 1.0 / nominal.clip(min=1e-300) - 1.0 / np.where(modulus, values, 1.0), values - nominal)


def tension_response(
    equilibrium: Equilibrium, parameters: Sequence[Parameter], motion: Array, changes: TensionChanges
) -> Array:
    """Change (N, m, k) of tensions at the sheaves, N, per each parameter.

    *motion* (N, n, k) is the `response`, *changes* the `tension_changes` of the same equilibrium.
    """
    out = changes.following(motion)
    for k, parameter in enumerate(parameters):
        if _wrench(equilibrium, parameter) is None:
            for i in lines_of(equilibrium.model.robot, parameter):
                column, times = _column(equilibrium, parameter, i)
                out[:, i, k] += changes.own[:, i, column] * times
    return out


def _column(equilibrium: Equilibrium, parameter: Parameter, i: int) -> tuple[int, Array]:
    """Which parameter of the linearisation a number of line *i* is, and how many of its units one is, (N,) or (1,)."""
    kind, axis = parameter.kind.partition(".")[::2]
    lengths, cable, one = equilibrium.lengths[:, i], equilibrium.model.robot.lines[i].cable, np.ones(1)
    if kind == "modulus":
        return linearise_kernel.MODULUS, one
    if kind == "exit_point":
        return linearise_kernel.EXIT + AXES.index(axis), one
    if kind == "platform_point":
        return linearise_kernel.POINT + AXES.index(axis), one
    if kind == "sheave_radius":
        return linearise_kernel.SHEAVE, one
    if kind == "linear_density":
        return linearise_kernel.WEIGHT_FACTOR, one / cable.linear_density if cable.linear_density else 0.0 * one
    if kind == "length_offset":
        return linearise_kernel.LENGTH, one
    if kind == "length_scale":
        return linearise_kernel.LENGTH, lengths
    assert kind == "temperature"
    assert cable.thermal_expansion is not None
    return linearise_kernel.LENGTH, lengths * cable.thermal_expansion


def _wrench(equilibrium: Equilibrium, parameter: Parameter) -> Array | None:
    """Change (N, n) of the wrench on the platform per a number of the platform; None for numbers of lines."""
    kind, axis = parameter.kind.partition(".")[::2]
    n, rows = equilibrium.model.n, len(equilibrium.pose)
    wrench = np.zeros((rows, 6))
    if kind in ("force", "moment"):
        wrench[:, AXES.index(axis) + (3 if kind == "moment" else 0)] = 1.0
        return wrench[:, :n]
    if kind not in ("mass", "centre_of_mass"):
        return None
    if kind == "mass":
        wrench[:, 2] = -equilibrium.model.robot.scene.gravity
    if n == 6:
        platform = np.broadcast_to(equilibrium.packed.platform, (rows, layout.PLATFORM))
        turned = matrices(equilibrium.pose[:, 3:])
        if kind == "mass":
            centre = np.einsum("nij,nj->ni", turned, platform[:, layout.MASS_X : layout.MASS_Z + 1])
            wrench[:, 3:] = np.cross(centre, wrench[:, :3])
        else:
            weight = platform[:, layout.PLATFORM_WEIGHT, None] * np.array([0.0, 0.0, -1.0])
            wrench[:, 3:] = np.cross(turned[:, :, AXES.index(axis)], weight)
    return wrench[:, :n]
