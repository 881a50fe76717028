"""Calibration of lines that stretch and sag, from measured poses: Young's modulus beside the geometry.

What the platform does is the equilibrium for the lengths paid out, so at each pose the true lengths take the place of
the pose as its own unknowns. All derivatives are those of the one linearisation of an equilibrium.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.calibration.observability import Direction, Information, information_of, open_freedoms, weakest
from cablewright.calibration.plan import Plan
from cablewright.calibration.problem import ENCODER_SIGMA, Derivatives, Measured
from cablewright.calibration.unknowns import Unknown, unknowns_of, with_values
from cablewright.errors import InputError
from cablewright.models.fidelity import Fidelity
from cablewright.models.parameters import varied
from cablewright.models.rotation import turn_between
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot, nominal
from cablewright.solvers.forward import solve_again, solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import linearise
from cablewright.solvers.parameters import response

__all__ = ["ElasticCalibration", "calibrate_elastic"]

Array = NDArray[np.float64]

_MOST_STEPS: Final = 60
_STEP: Final = 1e-10  # m, and parts of the modulus: shorter steps end a fit
_MOST_DAMPING: Final = 1e8
_STRAIGHT: Final = 1e-5


@dataclass(frozen=True, eq=False)
class ElasticCalibration:
    """What was found. `status` is "ok", or `reason` says what went wrong. Sigma counts datum-free, inner constraint."""

    status: str
    reason: str
    old: Robot
    unknowns: tuple[Unknown, ...]
    values: Array  # (k,)
    lengths: Array  # (N, m) m: what was paid out, unstrained, from winch exit to platform
    equilibrium: Equilibrium
    alone: Information
    rms: float  # m, of the poses' positions
    iterations: int

    @property
    def sigma(self) -> Array:
        """Standard deviations of the unknowns (k,)."""
        return np.asarray(np.sqrt(np.diag(self.alone.covariance)))

    @property
    def weakest(self) -> tuple[Direction, ...]:
        """The least known combinations that are not open."""
        return weakest(self.alone)

    @cached_property
    def robot(self) -> Robot:
        """The calibrated robot; the old one unless `status` is "ok"."""
        return with_values(self.old, self.unknowns, self.values) if self.status == "ok" else self.old

    @property
    def gauge(self) -> tuple[str, ...]:
        """The freedoms that the data leave open, in words."""
        return open_freedoms(self.alone)


def calibrate_elastic(
    robot: Robot, measured: Measured, plan: Plan | None = None, cable: str = "catenary"
) -> ElasticCalibration:
    """Calibrate a robot with *cable* law "elastic" or "catenary" from encoders and measured poses.

    Without measured poses nothing would be left over: lengths say where the platform is, and there is no second voice.
    Raises `InputError` for data that cannot be used, `AnswerError` where the file's robot does not hang near a pose.
    """
    plan = plan or Plan()
    search = _Search(robot, measured, plan, cable)
    return search.run()


class _Search:
    """Levenberg-Marquardt over unknowns and the lengths paid out at each pose."""

    def __init__(self, robot: Robot, measured: Measured, plan: Plan, cable: str) -> None:
        if measured.guess is None or measured.pose_sigma is None:
            raise InputError(f"{measured.origin}: {cable} lines need measured poses: columns x.. with sigma_x..")
        for given, what in ((measured.tensions, "f_1"), (measured.swivel, "swivel_1"), (measured.tilt, "tilt_x")):
            if given is not None:
                raise InputError(f"{measured.origin}: column {what}: {cable} lines take encoders and poses alone")
        for key in ("datum", "level", "priors", "distances", "points", "planes", "ranges"):
            if getattr(plan, key):
                raise InputError(f"{key}: goes with rigid lines alone; {cable} ones take encoders and poses")
        self.robot, self.measured = robot, measured
        self.wanted, self.pose_sigma = measured.guess, measured.pose_sigma
        self.sigma = plan.sigma.encoder or ENCODER_SIGMA
        self.model = Model(robot, Fidelity.of(cable))
        self.model.refuse_rigid()
        self.unknowns = unknowns_of(robot, plan.unknowns, plan.shared, elastic=True)
        count, (m, n) = len(measured.counted), (robot.m, robot.n)
        if count * n < len(self.unknowns):
            needed = -(-len(self.unknowns) // n)
            raise InputError(f"{measured.origin}: {count} poses; at least {needed} are needed for {len(self.unknowns)}")
        self.hardware = [at for at, each in enumerate(self.unknowns) if each.parameter is not None]
        self.parameters = [each.parameter for each in self.unknowns if each.parameter is not None]
        self.names = [line.name for line in robot.lines]
        self.shape = count, m, n

    def run(self) -> ElasticCalibration:
        """Steps until they are small, or none is downhill."""
        theta, lengths, held = self._start()
        rows = self._rows(theta, lengths, held)
        cost, damping, steps = self._cost(rows), 1e-3, 0
        for _ in range(_MOST_STEPS):
            change, own = _step(rows, damping)
            moved, paid = theta + change, lengths + own
            then = self._at(moved, paid, held)
            trial = None if then is None else self._rows(moved, paid, then)
            if trial is not None and self._cost(trial) <= cost:
                assert then is not None
                theta, lengths, held, rows, cost = moved, paid, then, trial, self._cost(trial)
                damping, steps = max(0.1 * damping, 1e-12), steps + 1
                if max(np.abs(change).max(), np.abs(own).max()) < _STEP:
                    return self._told("ok", "", theta, lengths, held, rows, steps)
            elif max(np.abs(change).max(), np.abs(own).max()) < _STEP:
                return self._told("ok", "", theta, lengths, held, rows, steps)
            else:
                damping *= 10.0
            if damping > _MOST_DAMPING:
                break
        return self._told("not-converged", "no step leads on", theta, lengths, held, rows, steps)

    def _start(self) -> tuple[Array, Array, Equilibrium]:
        """The file's numbers, with home lengths that suit the measured poses at the least tensions."""
        theta = np.zeros(len(self.unknowns))
        for at, each in enumerate(self.unknowns):
            theta[at] = nominal(self.robot, each.parameter) if each.parameter is not None else each.nominal or 0.0
        taken = solve_inverse(self.model, self.wanted).checked().lengths
        offsets = np.median(taken - self.measured.counted, axis=0)
        for at, each in enumerate(self.unknowns):
            if each.name == "length_offset":
                theta[at] = offsets[self.names.index(each.line or "")]
        lengths = self._out(theta) if "length_offset" in {each.name for each in self.unknowns} else taken
        return theta, lengths, solve_forward(self.model, lengths, guess=self.wanted).checked()

    def _of_lines(self, theta: Array, name: str, otherwise: float) -> Array:
        """The values (m,) of an unknown of the winches."""
        found = np.full(len(self.names), otherwise)
        for each, value in zip(self.unknowns, theta, strict=True):
            if each.name == name:
                found[[each.line in (None, line) for line in self.names]] = value
        return found

    def _out(self, theta: Array) -> Array:
        """Lengths (N, m) that the encoders' counts stand for, m."""
        offset, scale, build_up = self._winches(theta)
        return np.asarray(offset + scale * self._unscaled(build_up))

    def _winches(self, theta: Array) -> tuple[Array, Array, Array]:
        scale = self._of_lines(theta, "length_scale", 1.0) * self._of_lines(theta, "drum_radius", 1.0)
        return self._of_lines(theta, "length_offset", 0.0), scale, self._of_lines(theta, "build_up", 0.0)

    def _unscaled(self, build_up: Array) -> Array:
        counted, x = self.measured.counted, self.measured.counted * build_up
        series = counted * (1.0 - 0.5 * x + x * x / 6.0)
        exact = -np.expm1(-x) / np.where(build_up == 0.0, 1.0, build_up)
        return np.where(np.abs(x) < _STRAIGHT, series, exact)

    def _by_winch(self, theta: Array) -> Array:
        """Derivatives (N, m, k) of the lengths that counts stand for."""
        count, m, _ = self.shape
        _, scale, build_up = self._winches(theta)
        one, counted = self._unscaled(build_up), self.measured.counted
        x = counted * build_up
        turning = np.where(build_up == 0.0, 1.0, build_up)
        exact = (counted * np.exp(-x) - one) / turning
        per_build_up = scale * np.where(np.abs(x) < _STRAIGHT, -counted * counted * (0.5 - x / 3.0), exact)
        per = {"length_offset": np.ones_like(one), "length_scale": one, "drum_radius": one, "build_up": per_build_up}
        found = np.zeros((count, m, len(self.unknowns)))
        for k, each in enumerate(self.unknowns):
            if each.name in per:
                lines = [each.line in (None, line) for line in self.names]
                found[:, lines, k] = per[each.name][:, lines]
        return found

    def _at(self, theta: Array, lengths: Array, near: Equilibrium) -> Equilibrium | None:
        """The equilibria with these numbers, from those near; None where there are none, or no such robot."""
        values = theta[self.hardware]
        positive = [each.kind in ("modulus", "sheave_radius") for each in self.parameters]
        if not (lengths > 0.0).all() or not (values[positive] > 0.0).all():
            return None
        packed, paid = varied(
            self.robot, self.model.rows(), self.parameters, np.tile(values, (len(lengths), 1)), lengths
        )
        found = solve_again(near, packed, paid, 1)
        return found if found.ok.all() else None

    def _rows(self, theta: Array, lengths: Array, held: Equilibrium) -> Derivatives:
        """Weighted residuals of encoders and poses, by the lengths of each pose and by the unknowns."""
        count, m, n = self.shape
        off = held.pose - self.wanted
        if n == 6:
            off[:, 3:] = turn_between(self.wanted[:, 3:], held.pose[:, 3:])
        residual = np.concatenate([(lengths - self._out(theta)) / self.sigma, off / self.pose_sigma], axis=1)
        by_length = np.zeros((count, m + n, m))
        by_length[:, :m] = np.eye(m) / self.sigma
        by_length[:, m:] = linearise(held).per_length / self.pose_sigma[..., None]
        by_unknown = np.zeros((count, m + n, len(self.unknowns)))
        by_unknown[:, :m] = -self._by_winch(theta) / self.sigma
        motion = response(held, self.parameters)
        modulus = [each.kind == "modulus" for each in self.parameters]
        motion /= np.where(modulus, theta[self.hardware], 1.0)
        by_unknown[:, m:, self.hardware] = motion / self.pose_sigma[..., None]
        return Derivatives(residual, by_length, by_unknown, np.zeros(0), np.zeros((0, len(self.unknowns))))

    def _cost(self, rows: Derivatives) -> float:
        return float(np.sum(rows.residual**2))

    def _told(
        self, status: str, reason: str, theta: Array, lengths: Array, held: Equilibrium, rows: Derivatives, steps: int
    ) -> ElasticCalibration:
        exits = np.array([line.exit_point for line in self.robot.lines])
        for each, value in zip(self.unknowns, theta, strict=True):
            if each.name == "exit_point" and each.axis is not None:
                exits[self.names.index(each.line or ""), each.axis] = value
        found = information_of(rows, self.robot, self.unknowns, exits, np.ones(rows.residual.shape, dtype=bool))
        rms = float(np.sqrt(np.mean((held.pose[:, :3] - self.wanted[:, :3]) ** 2)))
        sizes = np.array([each.size for each in self.unknowns])
        return ElasticCalibration(
            status, reason, self.robot, self.unknowns, theta * sizes, lengths, held, found, rms, steps
        )


def _step(rows: Derivatives, damping: float) -> tuple[Array, Array]:
    """The damped step of unknowns (k,) and of the lengths (N, m) of each pose, which a Schur complement eliminates."""
    H, G, r = rows.by_pose, rows.by_unknown, rows.residual
    V = np.einsum("nea,neb->nab", H, H)
    W = np.einsum("nea,nek->nak", H, G)
    h = -np.einsum("nea,ne->na", H, r)
    U, g = np.einsum("nek,nel->kl", G, G), -np.einsum("nek,ne->k", G, r)
    m = V.shape[1]
    V[:, range(m), range(m)] *= 1.0 + damping
    inner = np.linalg.solve(V, np.concatenate([W, h[..., None]], axis=2))
    reduced = U + np.diag(damping * np.diag(U) + 1e-12) - np.einsum("nak,nal->kl", W, inner[..., :-1])
    change = np.linalg.lstsq(reduced, g - np.einsum("nak,na->k", W, inner[..., -1]), rcond=1e-15)[0]
    return np.asarray(change), np.asarray(inner[..., -1] - inner[..., :-1] @ change)
