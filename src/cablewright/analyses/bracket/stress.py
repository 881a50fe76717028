"""Stress in the brackets of a robot at a pose: as built, on universal joints, and with the second rotation blocked.

Loads come from the statics, stresses from two meshes, one twice as fine as the other: their difference, which is what
Richardson's extrapolation of first order makes of it, is the estimate of the error. That is careful. What is judged,
and where, is told in `bracket_parts`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from cablewright.analyses.bracket.elasticity import von_mises
from cablewright.analyses.bracket.loads import UNIVERSAL_JOINT, Loads, facings, joints, loads_at
from cablewright.analyses.bracket.parts import BracketPart, base, cheek
from cablewright.arrays import Array
from cablewright.errors import InputError
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Model
from cablewright.results import Figure, Result
from cablewright.robot import Bracket, Robot
from cablewright.robot.bracket import Axle
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import linearise

PLATES = ("baseplate", "uprights", "lever")
"""What is judged by finite elements, in the order of the rows of peaks."""

TIMES = 2
"""How often the elements of the coarsest mesh are divided along each side, unless told."""

NO_MOMENT = 1e-6  # N m: less is rounding
_TIMES = (1, 2)  # 3 would take more than 10 GB


@dataclass(frozen=True)
class BracketMesh:
    """All parts of a bracket meshed alike: the base, and a cheek for each length of lever (m)."""

    bracket: Bracket
    times: int

    @property
    def base(self) -> BracketPart:
        """Baseplate, uprights and block."""
        return base(self.bracket, self.times)

    def cheek(self, lever: float) -> BracketPart:
        """A cheek of a lever."""
        return cheek(self.bracket, lever, self.times)

    def peaks(self, loads: Loads, near: Loads | None = None) -> Array:
        """(3, N, m) the largest linearised von Mises stress of each of `PLATES` at each pose and line, Pa.

        With *near*, only where it is largest for any of those loads: faster, and a lower bound.
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
    """The largest stress of one part: Pa, on the fine mesh and on the coarse; where, m, in the part's frame."""

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
    """One design at one pose: loads of all lines, stresses of the highest loaded one.

    `line`: its index. `sheave_motions` (m, 3): how far each line's sheave gives way, m, world, as far as the line feels
    it: with the universal joint the lever does not take part in turns that the joint leaves free.
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
        Figure("platform_motion", "m, rad", "Motion of the platform because the brackets give way, lengths held; null "
               "where cables are rigid.", detail=True),
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
        Figure("sheave_motions", "m", "Displacement of each line's sheave because its bracket gives way, world.",
               detail=True),
    )  # fmt: skip
    HEADLINES: ClassVar = ("line", "part", "max_von_mises", "safety")

    bracket: Bracket
    times: int
    loads: Loads
    plates: Array  # (3, m) Pa
    coarse: Array  # (3, m) Pa
    sheave_motions: Array

    @property
    def line_names(self) -> list[str]:
        """Names of the lines."""
        return [line.name for line in self.loads.held.model.robot.lines]

    @property
    def line_name(self) -> str:
        """Name of `line`."""
        return self.line_names[self.line]

    @property
    def own_pin_moment(self) -> float:
        """Moment about the pin of `line`, N m; rounding counts as 0."""
        moment = float(self.loads.pin_moment[0, self.line])
        return moment if abs(moment) > NO_MOMENT else 0.0

    @property
    def line(self) -> int:
        """The line whose bracket is stressed most."""
        return int(self.plates.max(axis=0).argmax())

    @cached_property
    def peaks(self) -> tuple[Peak, ...]:
        """Of the highest loaded line, by `PLATES`."""
        i, fine = self.line, BracketMesh(self.bracket, self.times)
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
        """The part that is stressed most."""
        return max(self.peaks, key=lambda peak: peak.stress)

    @property
    def max_von_mises(self) -> float:
        """The largest linearised von Mises stress of baseplate, uprights and lever, Pa."""
        return self.worst.stress

    @property
    def error_estimate(self) -> float:
        """Of the largest stress, relative: see `Peak`."""
        return self.worst.error

    @property
    def axle_stress(self) -> float:
        """The largest bending stress of the axle as a beam between the cheeks' middles, Pa."""
        force = float(np.linalg.norm(self.loads.sheave_force[0, self.line]))
        return force * _axle_stress(self.bracket)

    @property
    def safety(self) -> float:
        """The smallest ratio of a part's yield strength to its stress."""
        own, axle = self.bracket.material.yield_strength, self.bracket.axle.material.yield_strength
        return min(own / self.max_von_mises, axle / self.axle_stress)

    @property
    def on_base(self) -> Array:
        """(5,) the load of the highest loaded base, by `BASE_CASES`."""
        return np.asarray(self.loads.on_base()[0, self.line, :5])

    @property
    def on_cheek(self) -> Array:
        """(4,) the load of each cheek of the highest loaded line, by `LEVER_CASES`."""
        return np.asarray(self.loads.on_cheek()[0, self.line])

    @property
    def base_wrench(self) -> Array:
        """(6,) force and moment about the middle of the baseplate's back, bracket's frame, N and N m."""
        return np.asarray(self.loads.on_base(foot(self.bracket))[0, self.line])

    @cached_property
    def fields(self) -> tuple[tuple[BracketPart, Array, Array], ...]:
        """Base and cheek of the highest loaded line, each with displacements (N, 3), m, and stresses (6, P), Pa.

        Each in its part's frame, with the displacements of the part alone.
        """
        fine = BracketMesh(self.bracket, self.times)
        lever = joints(self.loads.held.model.robot)[self.line].lever
        found = []
        for part, load in ((fine.base, self.on_base), (fine.cheek(lever), self.on_cheek)):
            found.append((part, (part.moved @ load).reshape(-1, 3), part.stress @ load))
        return tuple(found)

    @property
    def raw_peak(self) -> float:
        """The largest von Mises stress at any node, singular edges and contacts too, Pa: it grows with the mesh."""
        return max(float(von_mises(stress).max()) for _, _, stress in self.fields)

    @property
    def max_displacement(self) -> float:
        """The largest displacement of any place of the base or the lever, m; the lever is carried along by the base."""
        (_, base_moved, _), (lever, own, _) = self.fields
        along = self._carried(lever.elastic.solid.places.T[: len(own)]) + own @ self.turn.T
        return float(max(np.linalg.norm(base_moved, axis=1).max(), np.linalg.norm(along, axis=1).max()))

    @property
    def level(self) -> Array:
        """(3, 3) from the world's axes to those of the highest loaded bracket."""
        facing = facings(self.loads.held.model.robot)[self.line]
        c, s = np.cos(facing), np.sin(facing)
        return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])

    @property
    def turn(self) -> Array:
        """(3, 3) from the lever's frame into the bracket's."""
        swing = self.loads.azimuth[0, self.line] - facings(self.loads.held.model.robot)[self.line]
        return _lever_frame(float(swing), float(self.loads.lever_angle[0, self.line]))

    def _carried(self, places: Array) -> Array:
        """How places (P, 3) of the rigid lever move with the base, bracket's frame."""
        moved = _head_motion(BracketMesh(self.bracket, self.times), self.on_base, self.turn, self.loads.design)
        return np.asarray(moved[:3] + np.cross(moved[3:], places @ self.turn.T))

    @property
    def energy_error(self) -> float:
        """Zienkiewicz and Zhu's relative error of the whole base in the energy norm, singular edges included."""
        part, load = BracketMesh(self.bracket, self.times).base, self.on_base[:, None]
        return float(part.elastic.energy_error(part.moved @ load, part.stress @ load)[0])

    @property
    def imbalance(self) -> float:
        """How far the bolts' reactions miss the loads of the base, relative to them: force, and moment per standoff."""
        part, load = BracketMesh(self.bracket, self.times).base, self.on_base[:, None]
        arm = np.repeat([1.0, self.bracket.standoff], 3)[:, None]
        applied = part.elastic.wrench(part.cases @ load)
        missed = applied + part.elastic.reactions(part.cases @ load, part.moved @ load)
        return float(np.abs(missed / arm).max() / np.abs(applied / arm).max())

    @property
    def nodes(self) -> int:
        """How many nodes the fine meshes of base and cheek have."""
        return sum(part.elastic.solid.basis.N for part, _, _ in self.fields)

    @cached_property
    def platform_motion(self) -> Array:
        """(n,) how far the platform moves because the brackets give way, lengths held, m and rad: to first order.

        NaN where the cables are rigid.
        """
        model = self.loads.held.model
        if model.fidelity.cable is CableLaw.RIGID:
            return np.full(model.n, np.nan)
        linear = linearise(self.loads.held[0])
        return np.asarray(np.einsum("nmi,mi->n", linear.per_exit_point, self.sheave_motions))


@dataclass(frozen=True, eq=False)
class Comparison:
    """Both designs at a pose, and what the elasticity of the cables alone does to the platform."""

    model: Model
    bracket: Bracket
    pose: Array
    retraction: float | None
    universal_joint: Design
    conventional: Design

    @property
    def designs(self) -> tuple[Design, Design]:
        """The universal joint's and the conventional one."""
        return self.universal_joint, self.conventional

    @property
    def ratio(self) -> float:
        """The conventional design's largest stress over the universal joint's."""
        return self.conventional.max_von_mises / self.universal_joint.max_von_mises

    @cached_property
    def cable_motion(self) -> Array:
        """(n,) how far the platform hangs from the pose when lengths were computed with rigid cables, m and rad.

        NaN where the cables are rigid, or gravity decides a part of the pose.
        """
        model, held = self.model, self.universal_joint.loads.held
        unknown = np.full(model.n, np.nan)
        if model.fidelity.cable is CableLaw.RIGID or model.m < model.n:
            return unknown
        rigid = Model(model.robot, Fidelity(CableLaw.RIGID), model.tension_limits)
        straight = solve_inverse(rigid, self.pose, retraction=self.retraction)
        if not straight.ok:
            return unknown
        hangs = solve_forward(held.model, straight.lengths, guess=self.pose, retraction=self.retraction)
        return np.asarray(hangs.pose - self.pose) if hangs.ok else unknown


def bracket_of(robot: Robot) -> Bracket:
    """The robot's own bracket. Raises `InputError` if it has none."""
    if robot.bracket is None:
        raise InputError(f"robot {robot.name!r} has no table [bracket]: give one, or a file of its own with --bracket")
    return robot.bracket


def bracket_at(
    model: Model, pose: ArrayLike, *, bracket: Bracket | None = None, times: int = TIMES,
    retraction: float | None = None,
) -> Comparison:  # fmt: skip
    """Stress in both designs of the highest loaded bracket at a *pose* (n,).

    *bracket* takes the place of the robot's own. *times*: how often elements are divided, 1 or 2; of 1 no error is
    told. Raises `AnswerError` for a pose that cannot be held, `InputError` where
    something is missing.
    """
    if times not in _TIMES:
        raise InputError(f"times = {times}: one of {', '.join(map(str, _TIMES))} is allowed")
    own = bracket_of(model.robot) if bracket is None else bracket
    both = loads_at(model, np.asarray(pose, dtype=np.float64)[None], retraction=retraction)
    for loads in both:
        loads.held[0].checked()
    fine = BracketMesh(own, times)
    jointed, blocked = (
        Design(own, times, loads, fine.peaks(loads)[:, 0], _coarser(fine, loads), _sheave_motions(fine, loads))
        for loads in both
    )
    return Comparison(model, own, np.asarray(jointed.loads.held.pose[0]), retraction, jointed, blocked)


def plate_peaks(bracket: Bracket, loads: Loads, times: int = TIMES, near: Loads | None = None) -> Array:
    """(3, N, m) the largest stress of each of `PLATES` at many poses, Pa; NaN where there is no load.

    With *near*, only the places where it is largest for any of those loads are looked at: a lower bound, and fast.
    """
    return BracketMesh(bracket, times).peaks(loads, near)


def foot(bracket: Bracket) -> tuple[float, float, float]:
    """The middle of the baseplate's back in the bracket's frame, m."""
    return (-bracket.standoff - bracket.baseplate.thickness, 0.0, bracket.rise)


def _coarser(mesh: BracketMesh, loads: Loads) -> Array:
    """(3, m) the stresses of the next coarser mesh, NaN where there is none."""
    if mesh.times == 1:
        return np.full((len(PLATES), loads.held.model.m), np.nan)
    return BracketMesh(mesh.bracket, mesh.times - 1).peaks(loads)[:, 0]


def _sheave_motions(mesh: BracketMesh, loads: Loads) -> Array:
    """(m, 3) see `Design.sheave_motions`."""
    robot = loads.held.model.robot
    faces, axle = facings(robot), _axle_compliance(mesh.bracket)
    bases, cheeks = loads.on_base()[0, :, :5], loads.on_cheek()[0]
    moved = np.empty((robot.m, 3))
    for i, joint in enumerate(joints(robot)):
        turn = _lever_frame(float(loads.azimuth[0, i] - faces[i]), float(loads.lever_angle[0, i]))
        head = _head_motion(mesh, bases[i], turn, loads.design)
        own = np.zeros(3)
        own[[0, 2]] = (mesh.cheek(joint.lever).compliance @ cheeks[i])[:2]
        own[[0, 2]] += axle * 2.0 * cheeks[i, :2]
        if loads.design == UNIVERSAL_JOINT:
            own[2] = 0.0  # a turn about the pin
        carried = head[:3] + np.cross(head[3:], turn @ np.array([joint.lever, 0.0, 0.0])) + turn @ own
        c, s = np.cos(faces[i]), np.sin(faces[i])
        moved[i] = c * carried[0] - s * carried[1], s * carried[0] + c * carried[1], carried[2]
    return moved


def _head_motion(mesh: BracketMesh, load: Array, turn: Array, design: str) -> Array:
    """(6,) motion of the joint and rotation of what it carries, bracket's frame, m and rad.

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


def _axle_stress(bracket: Bracket) -> float:
    """Bending stress per force on the sheave, Pa/N: a beam between the cheeks' middles, loaded evenly by the sheave."""
    span, width = bracket.lever.gap + bracket.lever.thickness, bracket.axle.sheave_width
    return (2.0 * span - width) / 8.0 * 32.0 / (np.pi * bracket.lever.axle**3)


def _axle_compliance(bracket: Bracket) -> float:
    """Deflection per force on the sheave in the sense of work, m/N: bending and shear of that beam."""
    span, width, axle = bracket.lever.gap + bracket.lever.thickness, bracket.axle.sheave_width, bracket.axle
    points, weights = np.polynomial.legendre.leggauss(4)  # exact for the square of a quadratic
    total = 0.0
    ends = (0.0, 0.5 * (span - width), 0.5 * span)
    for a, b in pairwise(ends):
        x = 0.5 * (a + b) + 0.5 * (b - a) * points
        inside = np.maximum(x - ends[1], 0.0)
        moment, shear = 0.5 * x - 0.5 * inside**2 / width, 0.5 - inside / width
        flexibility = moment**2 / _bending(bracket, axle) + shear**2 / _shearing(bracket, axle)
        total += (b - a) * float(weights @ flexibility)  # both halves of the span
    return total


def _bending(bracket: Bracket, axle: Axle) -> float:
    return axle.material.young_modulus * np.pi * bracket.lever.axle**4 / 64.0


def _shearing(bracket: Bracket, axle: Axle) -> float:
    """Timoshenko's for a round bar."""
    modulus = 0.5 * axle.material.young_modulus / (1.0 + axle.material.poisson_ratio)
    return 0.9 * modulus * 0.25 * np.pi * bracket.lever.axle**2
