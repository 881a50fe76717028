"""Stress in the brackets of a robot at a pose, for both designs: with the universal joint, and with levers held level.

Loads come from the statics, stresses from two meshes, one with half the element size of the other. The difference is
the error estimate, as in Richardson's extrapolation of first order, which is conservative. `parts` states where stress
is evaluated.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from cablewright.analyses.bracket.elasticity import von_mises
from cablewright.analyses.bracket.loads import UNIVERSAL_JOINT, Loads, facings, frames, joints, loads_at
from cablewright.analyses.bracket.parts import BracketPart, base, cheek
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.results import Figure, Result
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Model
from cablewright.robot import Bracket, Robot
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import linearise

PLATES = ("baseplate", "uprights", "lever")
"""The plates evaluated by finite elements, in the order of the rows of peaks."""

TIMES = 2  # default number of divisions of the coarsest elements along each side

NO_MOMENT = 1e-6  # N m: less is rounding
_TIMES = (1, 2)  # 3 would take more than 10 GB of memory


@dataclass(frozen=True)
class BracketMesh:
    """All parts of a bracket at one refinement: the base, and a cheek for each length of lever (m)."""

    bracket: Bracket
    times: int

    @property
    def base(self) -> BracketPart:
        """The parts that carry the sheave: baseplate, uprights and block."""
        return base(self.bracket, self.times)

    def cheek(self, lever: float) -> BracketPart:
        """Return a cheek of a lever of this length, m."""
        return cheek(self.bracket, lever, self.times)

    def peaks(self, loads: Loads, near: Loads | None = None) -> Array:
        """Return the largest linearised von Mises stress, Pa, of each of `PLATES` at each pose and line: (3, N, m).

        NaN where there is no load. With *near*, only the positions where stress is largest under any of those loads are
        evaluated: faster, and a lower bound.
        """
        found = np.full((len(PLATES), *loads.lever_angle.shape), np.nan)
        good, bases, cheeks = np.isfinite(loads.lever_angle), loads.on_base()[..., :5], loads.on_cheek()
        only = None if near is None else self.base.hot(near.on_base()[..., :5][np.isfinite(near.lever_angle)])
        found[:2, good] = self.base.peaks(bases[good], only)
        for i, joint in enumerate(joints(loads.held.model.robot)):
            own = self.cheek(joint.lever)
            if near is not None:
                only = own.hot(near.on_cheek()[np.isfinite(near.lever_angle[:, i]), i])
            found[2, good[:, i], i] = own.peaks(cheeks[good[:, i], i], only)[0]
        return found


@dataclass(frozen=True, repr=False)
class Peak(Result):
    """The largest stress of one part: Pa, on the fine mesh and on the coarse; its position, m, in the part's frame."""

    FIGURES: ClassVar = (
        Figure("max_von_mises", "Pa", "Largest linearised von Mises stress of the part.", "stress", shown="MPa"),
        Figure("error_estimate", "1", "Estimated relative error of the stress; null on the coarsest mesh.", "error",
               "error", 2, shown="%"),
        Figure("place", "m", "Place of the largest stress in the part's frame.", shown="m"),
    )  # fmt: skip
    HEADLINES: ClassVar = ("max_von_mises", "error_estimate")

    part: str
    stress: float
    coarse: float
    error: float  # relative, estimated; NaN where there is no coarser mesh
    place: tuple[float, float, float]


def _plate_figure(name: str) -> Figure:
    """The largest stress of one of `PLATES` as a figure of a design."""
    meaning = f"Largest linearised von Mises stress of the {name}."
    of_part = PLATES.index(name)
    return Figure(f"{name}_von_mises", "Pa", meaning, lambda of: of.peaks[of_part].stress, name, shown="MPa")


@dataclass(frozen=True, eq=False, repr=False)
class Design(Result):
    """One bracket design at one pose: loads of all lines, stresses of the highest loaded one.

    `sheave_motions` (m, 3): displacement of each line's sheave, m, world. With the universal joint the lever does not
    follow rotations that the joint leaves free.
    """

    FIGURES: ClassVar = (
        Figure("line", "", "Name of the line whose bracket is stressed most.", "line_name"),
        Figure("tension", "N", "Tension of that line at its sheave.", lambda of: of.loads.held.tensions[0, of.line],
               digits=5, shown="N"),
        Figure("lever_angle", "rad", "Angle of its lever above the horizontal.",
               lambda of: of.loads.lever_angle[0, of.line], digits=3),
        Figure("pin_moment", "N m", "Moment about the pin of its lever.", "own_pin_moment", "moment about the pin"),
        Figure("base_moment_norm", "N m", "Norm of base_moment.", lambda of: np.linalg.norm(of.base_wrench[3:]),
               "moment at the base"),
        Figure("part", "", "Part with the largest stress.", "worst.part", "most stressed part"),
        Figure("max_von_mises", "Pa", "Largest linearised von Mises stress of baseplate, uprights and lever.",
               shown="MPa"),
        Figure("error_estimate", "1", "Estimated relative error of that stress; null on the coarsest mesh.",
               name="error", digits=2, shown="%"),
        Figure("parts", "", "Largest stress of each part.",
               lambda of: {peak.part: peak for peak in of.peaks}, parts=Peak.FIGURES, detail=True),
        *map(_plate_figure, PLATES),
        Figure("axle_stress", "Pa", "Largest bending stress of the axle.", name="axle", shown="MPa"),
        Figure("safety", "1", "Smallest ratio of a part's yield strength to its stress.", digits=3),
        Figure("max_displacement", "m", "Largest displacement of base or lever.", shown="mm"),
        Figure("platform_motion", "m, rad", "Motion of the platform by the compliance of the brackets at constant "
        "lengths; null for rigid cables.", detail=True),
        Figure("platform_displacement", "m", "Norm of the translation in platform_motion; null where cables are rigid.",
               lambda of: np.linalg.norm(of.platform_motion[:3]), "platform moves by", shown="mm"),
        Figure("nodes", "1", "Number of nodes of the meshes of base and cheek."),
        Figure("raw_max_von_mises", "Pa", "Largest von Mises stress at any node, singular edges too: it grows as the "
               "mesh is refined.", "raw_peak", detail=True),
        Figure("energy_error", "1", "Relative error of the base in the energy norm (Zienkiewicz and Zhu).",
               detail=True),
        Figure("imbalance", "1", "Relative difference of the bolts' reactions from the loads of the base.",
               detail=True),
        Figure("lines", "", "Names of the lines, in the order of the arrays below.", "line_names", detail=True),
        Figure("line_max_von_mises", "Pa", "Largest stress in the bracket of each line.",
               lambda of: of.plates.max(axis=0), detail=True),
        Figure("tensions", "N", "Tension of each line at its sheave.", lambda of: of.loads.held.tensions[0],
               detail=True),
        Figure("lever_angles", "rad", "Angle of each lever above the horizontal.", lambda of: of.loads.lever_angle[0],
               detail=True),
        Figure("pin_moments", "N m", "Moment about the pin of each lever.", lambda of: of.loads.pin_moment[0],
               detail=True),
        Figure("spindle_moments", "N m", "Moment about the spindle of each lever.",
               lambda of: of.loads.spindle_moment[0], detail=True),
        Figure("base_force", "N", "Force on the base of that line's bracket, bracket's frame.",
               lambda of: of.base_wrench[:3], detail=True),
        Figure("base_moment", "N m", "Moment about the middle of the back of its baseplate, bracket's frame.",
               lambda of: of.base_wrench[3:], detail=True),
        Figure("sheave_motions", "m", "Displacement of each line's sheave by the compliance of its bracket, world.",
               detail=True),
    )  # fmt: skip
    HEADLINES: ClassVar = ("line", "part", "max_von_mises", "safety")

    mesh: BracketMesh
    loads: Loads
    plates: Array  # (3, m) Pa
    coarse: Array  # (3, m) Pa
    sheave_motions: Array

    @property
    def line_names(self) -> list[str]:
        """Names of the robot's lines."""
        return [line.name for line in self.loads.held.model.robot.lines]

    @property
    def line_name(self) -> str:
        """Name of the line whose bracket is computed."""
        return self.line_names[self.line]

    @property
    def own_pin_moment(self) -> float:
        """Moment about the pin of `line`, N m; rounding counts as 0."""
        moment = float(self.loads.pin_moment[0, self.line])
        return moment if abs(moment) > NO_MOMENT else 0.0

    @property
    def line(self) -> int:
        """Index of the line with the highest stress in its bracket."""
        return int(self.plates.max(axis=0).argmax())

    @cached_property
    def peaks(self) -> tuple[Peak, ...]:
        """The largest stresses of the highest loaded line's bracket, by `PLATES`."""
        i, fine = self.line, self.mesh
        lever = joints(self.loads.held.model.robot)[i].lever
        found = []
        for k, name in enumerate(PLATES):
            part = fine.cheek(lever) if name == "lever" else fine.base
            place = part.peak_place(0 if name == "lever" else k, self.on_cheek if name == "lever" else self.on_base)
            stress, coarse = float(self.plates[k, i]), float(self.coarse[k, i])
            error = abs(stress - coarse) / stress if stress > 0.0 else np.nan
            x, y, z = (float(each) for each in place)
            found.append(Peak(name, stress, coarse, error, (x, y, z)))
        return tuple(found)

    @property
    def worst(self) -> Peak:
        """The part of the bracket with the highest stress."""
        return max(self.peaks, key=lambda peak: peak.stress)

    @property
    def max_von_mises(self) -> float:
        """The largest linearised von Mises stress of baseplate, uprights and lever, Pa."""
        return self.worst.stress

    @property
    def error_estimate(self) -> float:
        """Relative error of the bracket's largest stress, see `Peak`."""
        return self.worst.error

    @property
    def axle_stress(self) -> float:
        """The largest bending stress of the axle, a beam between the middles of the cheeks, uniformly loaded, Pa."""
        lever, width = self.mesh.bracket.lever, self.mesh.bracket.axle.sheave_width
        force = float(np.linalg.norm(self.loads.sheave_force[0, self.line]))
        return force * (2.0 * (lever.gap + lever.thickness) - width) / 8.0 * 32.0 / (np.pi * lever.axle**3)

    @property
    def safety(self) -> float:
        """The smallest ratio of a part's yield strength to its stress."""
        own, axle = self.mesh.bracket.material.yield_strength, self.mesh.bracket.axle.material.yield_strength
        return min(own / self.max_von_mises, axle / self.axle_stress)

    @property
    def on_base(self) -> Array:
        """Loads (5,) on the highest loaded base, by `BASE_CASES`."""
        return np.asarray(self.loads.on_base()[0, self.line, :5])

    @property
    def on_cheek(self) -> Array:
        """Loads (4,) on each cheek of the highest loaded line, by `LEVER_CASES`."""
        return np.asarray(self.loads.on_cheek()[0, self.line])

    @property
    def base_wrench(self) -> Array:
        """(6,) force and moment about the middle of the baseplate's back, bracket's frame, N and N m."""
        return np.asarray(self.loads.on_base(foot(self.mesh.bracket))[0, self.line])

    @cached_property
    def fields(self) -> tuple[tuple[BracketPart, Array, Array], ...]:
        """Base and cheek of the highest loaded line, with displacements (N, 3), m, and stresses (6, P), Pa.

        Both in the part's own frame; displacements are those of the part alone.
        """
        lever = joints(self.loads.held.model.robot)[self.line].lever
        loaded = (self.mesh.base, self.on_base), (self.mesh.cheek(lever), self.on_cheek)
        return tuple((part, (part.moved @ load).reshape(-1, 3), part.stress @ load) for part, load in loaded)

    @property
    def raw_peak(self) -> float:
        """The largest von Mises stress at any node, singular edges included, Pa: it grows with refinement."""
        return max(float(von_mises(stress).max()) for _, _, stress in self.fields)

    @property
    def max_displacement(self) -> float:
        """The largest displacement of any point of the base or the lever, which moves with the base, m."""
        (_, base_moved, _), (lever, own, _) = self.fields
        along = self._carried(lever.elastic.solid.places.T[: len(own)]) + own @ self.turn.T
        return float(max(np.linalg.norm(base_moved, axis=1).max(), np.linalg.norm(along, axis=1).max()))

    @property
    def level(self) -> Array:
        """Rotation (3, 3) from the world's axes to those of the highest loaded bracket."""
        return np.asarray(frames(self.loads.held.model.robot)[self.line])

    @property
    def turn(self) -> Array:
        """Rotation (3, 3) from the lever's frame to the bracket's."""
        swing = self.loads.azimuth[0, self.line] - facings(self.loads.held.model.robot)[self.line]
        return _lever_frame(float(swing), float(self.loads.lever_angle[0, self.line]))

    def _carried(self, places: Array) -> Array:
        """Displacements (P, 3) of points of the rigid lever with the base, bracket's frame, m."""
        moved = _head_motion(self.mesh, self.on_base, self.turn, self.loads.design)
        return np.asarray(moved[:3] + np.cross(moved[3:], places @ self.turn.T))

    @property
    def energy_error(self) -> float:
        """Zienkiewicz and Zhu's relative error of the whole base in the energy norm, singular edges included."""
        part, load = self.mesh.base, self.on_base[:, None]
        return float(part.elastic.energy_error(part.moved @ load, part.stress @ load)[0])

    @property
    def imbalance(self) -> float:
        """Relative difference of the bolts' reactions and the loads on the base: force, and moment per standoff."""
        part, load = self.mesh.base, self.on_base[:, None]
        arm = np.repeat([1.0, self.mesh.bracket.standoff], 3)[:, None]
        applied = part.elastic.wrench(part.cases @ load)
        missed = applied + part.elastic.reactions(part.cases @ load, part.moved @ load)
        return float(np.abs(missed / arm).max() / np.abs(applied / arm).max())

    @property
    def nodes(self) -> int:
        """Number of nodes of the fine meshes of base and cheek."""
        return sum(part.elastic.solid.basis.N for part, _, _ in self.fields)

    @cached_property
    def platform_motion(self) -> Array:
        """(n,) displacement of the platform by the compliance of the brackets, lengths held, m and rad; first order.

        NaN where the cables are rigid.
        """
        model = self.loads.held.model
        if model.fidelity.cable is CableLaw.RIGID:
            return np.full(model.n, np.nan)
        linear = linearise(self.loads.held[0])
        return np.asarray(np.einsum("nmi,mi->n", linear.per_exit_point, self.sheave_motions))


@dataclass(frozen=True, eq=False)
class Comparison:
    """Both bracket designs at a pose, and the displacement of the platform by the elasticity of the cables alone."""

    model: Model
    bracket: Bracket
    pose: Array
    retraction: float | None
    universal_joint: Design
    conventional: Design

    @property
    def designs(self) -> tuple[Design, Design]:
        """The design with universal joints and the conventional one."""
        return self.universal_joint, self.conventional

    @property
    def ratio(self) -> float:
        """The conventional design's largest stress over the universal joint's."""
        return self.conventional.max_von_mises / self.universal_joint.max_von_mises

    @cached_property
    def cable_motion(self) -> Array:
        """(n,) displacement of the platform from the pose under lengths computed with rigid cables, m and rad.

        NaN where the cables are rigid, or gravity decides a part of the pose.
        """
        model, held = self.model, self.universal_joint.loads.held
        unknown = np.full(model.n, np.nan)
        if model.fidelity.cable is CableLaw.RIGID or model.winches < model.freedoms:
            return unknown
        rigid = Model(model.robot, Fidelity(CableLaw.RIGID), model.tension_limits)
        straight = solve_inverse(rigid, self.pose, retraction=self.retraction)
        if not straight.ok:
            return unknown
        hangs = solve_forward(held.model, straight.lengths, guess=self.pose, retraction=self.retraction)
        return np.asarray(hangs.pose - self.pose) if hangs.ok else unknown


def bracket_of(robot: Robot) -> Bracket:
    """Return the robot's own bracket. Raises `InputError` if it has none."""
    if robot.bracket is None:
        raise InputError(
            f"robot {robot.name!r} has no table [bracket]: add one to the robot file, or give a bracket "
            f"file with --bracket"
        )
    return robot.bracket


def bracket_at(
    model: Model, pose: ArrayLike, *, bracket: Bracket | None = None, times: int = TIMES,
    retraction: float | None = None,
) -> Comparison:  # fmt: skip
    """Compute the stress in the highest loaded bracket of both designs at a *pose* (n,), m and rad.

    *bracket* replaces the robot's own. *times*: divisions of the elements, 1 or 2; with 1 there is no error estimate.
    *retraction*: the platform's retraction length, m. Raises `AnswerError` for a pose that cannot be held, `InputError`
    for invalid arguments.
    """
    if times not in _TIMES:
        raise InputError(f"times = {times}: one of {', '.join(map(str, _TIMES))} is allowed")
    own = bracket_of(model.robot) if bracket is None else bracket
    both = loads_at(model, np.asarray(pose, dtype=np.float64)[None], retraction=retraction)
    for loads in both:
        loads.held[0].checked()
    fine = BracketMesh(own, times)
    jointed, blocked = (
        Design(fine, loads, fine.peaks(loads)[:, 0], _coarser(fine, loads), _sheave_motions(fine, loads))
        for loads in both
    )
    return Comparison(model, own, np.asarray(jointed.loads.held.pose[0]), retraction, jointed, blocked)


def foot(bracket: Bracket) -> tuple[float, float, float]:
    """Return the middle of the baseplate's back in the bracket's frame, m."""
    return (-bracket.standoff - bracket.baseplate.thickness, 0.0, bracket.rise)


def _coarser(mesh: BracketMesh, loads: Loads) -> Array:
    """(3, m) peaks of the next coarser mesh, Pa; NaN where there is none."""
    if mesh.times == 1:
        return np.full((len(PLATES), loads.held.model.m), np.nan)
    return BracketMesh(mesh.bracket, mesh.times - 1).peaks(loads)[:, 0]


def _sheave_motions(mesh: BracketMesh, loads: Loads) -> Array:
    """`Design.sheave_motions`."""
    robot = loads.held.model.robot
    faces, rotations, axle = facings(robot), frames(robot), _axle_compliance(mesh.bracket)
    bases, cheeks = loads.on_base()[0, :, :5], loads.on_cheek()[0]
    moved = np.empty((robot.m, 3))
    for i, joint in enumerate(joints(robot)):
        turn = _lever_frame(float(loads.azimuth[0, i] - faces[i]), float(loads.lever_angle[0, i]))
        head = _head_motion(mesh, bases[i], turn, loads.design)
        own = np.zeros(3)
        own[[0, 2]] = (mesh.cheek(joint.lever).compliance @ cheeks[i])[:2]
        own[[0, 2]] += axle * 2.0 * cheeks[i, :2]
        if loads.design == UNIVERSAL_JOINT:
            own[2] = 0.0  # a rotation about the pin
        carried = head[:3] + np.cross(head[3:], turn @ np.array([joint.lever, 0.0, 0.0])) + turn @ own
        moved[i] = carried @ rotations[i]
    return moved


def _head_motion(mesh: BracketMesh, load: Array, turn: Array, design: str) -> Array:
    """(6,) displacement of the joint and rotation of the part that it carries, bracket's frame, m and rad.

    The rotation about the vertical axis is free, and with the universal joint the one about the pin.
    """
    given = np.append(mesh.base.compliance @ load, 0.0)
    if design == UNIVERSAL_JOINT:
        pin = turn[:, 1]
        given[3:] -= pin * (pin @ given[3:])
    return given


def _lever_frame(swing: float, angle: float) -> Array:
    """(3, 3) columns: along the lever, along the pin, across both, in the bracket's frame."""
    c, s, cb, sb = np.cos(swing), np.sin(swing), np.cos(angle), np.sin(angle)
    return np.array([[c * cb, -s, -c * sb], [s * cb, c, -s * sb], [sb, 0.0, cb]])


def _axle_compliance(bracket: Bracket) -> float:
    """Deflection of the axle per force on the sheave, in the sense of work, m/N: bending and shear of a beam."""
    from skfem.models.elasticity import lame_parameters

    span, width, diameter = bracket.lever.gap + bracket.lever.thickness, bracket.axle.sheave_width, bracket.lever.axle
    _, shear_modulus = lame_parameters(bracket.axle.material.young_modulus, bracket.axle.material.poisson_ratio)
    bending = bracket.axle.material.young_modulus * np.pi * diameter**4 / 64.0
    shearing = 0.9 * shear_modulus * 0.25 * np.pi * diameter**2  # 0.9: Timoshenko's coefficient of a round bar
    points, weights = np.polynomial.legendre.leggauss(4)  # exact for the square of a quadratic
    total = 0.0
    ends = (0.0, 0.5 * (span - width), 0.5 * span)
    for a, b in pairwise(ends):
        x = 0.5 * (a + b) + 0.5 * (b - a) * points
        inside = np.maximum(x - ends[1], 0.0)
        moment, shear = 0.5 * x - 0.5 * inside**2 / width, 0.5 - inside / width
        flexibility = moment**2 / bending + shear**2 / shearing
        total += (b - a) * float(weights @ flexibility)  # both halves of the span
    return total
