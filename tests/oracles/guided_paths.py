"""Oracle: the taut path of one massless, frictionless cable over sheaves whose axes point anywhere, with 60 digits.

A line begins at an eyelet, on a sheave that swivels about any axis, or on a wheel that stands still in the world; it
ends at a point of the platform or on a sheave that swivels about an axis of the platform. The free span between is
straight, leaves each sheave along its tangent, and each swivel turns until its plane holds the span. A swivel finds
its place where the length is least: a sheave that faces away from the span is no solution. A wheel that stands still
has a groove: the cable stays on its circle, and the span may leave it askew (its projection on the wheel's plane is
tangent), so that the length is no minimum there.

Lengths are m, angles rad. Axes are unit vectors; what rounding left of their length is taken away here. The platform's
frame is at ``position`` and turned by ``rotation``, a matrix as nested sequences.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import mujoco
import numpy as np
from mpmath import mp, mpf
from scipy.optimize import root
from scipy.spatial.transform import Rotation

DIGITS = 60
LEFT_OVER = mpf(10) ** (8 - DIGITS)
"""The largest miss of the path's equations, relative to the distance of its ends."""

FEED = 1.0
"""How far before a swivel a tendon begins, over the distance of the line's ends."""

INERTIAL = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'

Real: TypeAlias = mpf | float
Triple: TypeAlias = Sequence[Real] | np.ndarray
Matrix: TypeAlias = Sequence[Triple] | np.ndarray
Vector = tuple[mpf, mpf, mpf]


@dataclass(frozen=True)
class Eyelet:
    """The cable begins at a point of the world."""

    point: Triple


@dataclass(frozen=True)
class Swivel:
    """A sheave that turns freely about ``axis``, which touches its rim in ``exit_point``.

    The cable comes along the axis: with ``side`` +1 (over) travelling towards +axis, with -1 (under) towards -axis.
    ``dead`` is the length of cable along the axis that counts before the exit point, m.
    """

    exit_point: Triple
    axis: Triple
    radius: Real
    side: int = 1
    dead: Real = 0.0


@dataclass(frozen=True)
class Pulley:
    """A grooved wheel about ``axis``, fixed in the world; ``winch_exit`` is in its plane.

    The cable runs straight to the wheel and then round it with a positive rotation about the axis.
    """

    centre: Triple
    axis: Triple
    radius: Real
    winch_exit: Triple


@dataclass(frozen=True)
class End:
    """The platform's end of a line, in its frame: a point, or with ``axis`` a sheave that turns about it.

    Read from its anchor the cable comes along the axis, travelling towards +axis, and meets the sheave in ``point``.
    With ``leaves`` it is a grooved wheel about the axis in ``point``: the cable runs round it with a positive rotation
    about the axis and off in that direction.
    """

    point: Triple
    axis: Triple | None = None
    radius: Real = 0.0
    leaves: Triple | None = None


Frame = Eyelet | Swivel | Pulley


@dataclass(frozen=True)
class TautPath:
    """Where a line runs. ``direction`` is the unit vector of the free span, from the frame to the platform.

    The span runs from ``leaves`` (D1) to ``arrives`` (D2 or B). Wraps are angles, arcs are lengths. ``unknowns`` are
    angles that find the same or a neighbouring path again: give them as ``guess``.
    """

    leaves: Vector
    arrives: Vector
    direction: Vector
    dead_length: mpf
    frame_wrap: mpf
    frame_arc: mpf
    free_length: mpf
    end_wrap: mpf
    end_arc: mpf
    unknowns: tuple[mpf, ...]

    @property
    def length(self) -> mpf:
        """The whole length from the winch, or its substitute, to the anchor, m."""
        with mp.workdps(DIGITS):
            return self.dead_length + self.frame_arc + self.free_length + self.end_arc


def taut_path(
    frame: Frame, end: End, position: Triple, rotation: Matrix, guess: Sequence[mpf] | None = None
) -> TautPath:
    """Return the path at a pose of the platform; wraps are in [0, 2 pi).

    Raises `ArithmeticError` where no swivel rests: a point inside a sheave, on a swivel's axis, or behind a sheave.
    """
    with mp.workdps(DIGITS):
        first, last = _start(frame), _finish(end, position, rotation)
        scale = _norm(_minus(last.foot, first.foot))
        unknowns = tuple(guess) if guess is not None else _by_turns(first, last)

        def misses(*at: mpf) -> list[mpf]:
            mine, other = at[: first.count], at[first.count :]
            pairs = first.misses(mine, last.contact(other)) + last.misses(other, first.contact(mine))
            return [value / scale for value in pairs]

        if unknowns:
            unknowns = _root(misses, unknowns)
        mine, other = unknowns[: first.count], unknowns[first.count :]
        leaves, arrives = first.contact(mine), last.contact(other)
        span = _minus(arrives, leaves)
        free = _norm(span)
        _check(first, last, mine, other)
        return TautPath(
            leaves=leaves,
            arrives=arrives,
            direction=_times(1 / free, span),
            dead_length=first.dead,
            frame_wrap=first.wrap(mine),
            frame_arc=first.radius * first.wrap(mine),
            free_length=free,
            end_wrap=last.wrap(other),
            end_arc=last.radius * last.wrap(other),
            unknowns=unknowns,
        )


def length_gradient(frame: Frame, end: End, position: Triple, rotation: Matrix) -> list[mpf]:
    """Return how the length grows with motions of the platform (6), by differences, right to 25 digits.

    Motions are of the platform's origin along the world's axes and about the world's axes through that origin.
    """
    with mp.workdps(DIGITS):
        step = mpf(10) ** -18
        length = _length_after(frame, end, position, rotation)
        return [(length([(i, step)]) - length([(i, -step)])) / (2 * step) for i in range(6)]


def length_hessian(
    frame: Frame, end: End, position: Triple, rotation: Matrix, one_by_one: bool = False
) -> list[list[mpf]]:
    """Return the second derivative (6, 6) of the length by motions of the platform, by differences, to 20 digits.

    Rotations of one motion are those of one rotation vector, so that the matrix is symmetric. With ``one_by_one``,
    row i and column j are a small motion j and then a small motion i about the world's axes: the derivative of
    `length_gradient`, not symmetric in its rotations.
    """
    with mp.workdps(DIGITS):
        step = mpf(10) ** -13
        length = _length_after(frame, end, position, rotation, one_by_one)
        here = 2 * length([])
        found = [[mpf(0)] * 6 for _ in range(6)]
        for i in range(6):
            found[i][i] = (length([(i, step)]) + length([(i, -step)]) - here) / step**2
            for j in range(6):
                if i == j:
                    continue
                if j < i and not (one_by_one and j > 2):
                    found[i][j] = found[j][i]
                    continue
                signs = [(x, y, x * y) for x in (1, -1) for y in (1, -1)]
                total = mp.fsum(sign * length([(j, y * step), (i, x * step)]) for x, y, sign in signs)
                found[i][j] = total / (4 * step**2)
        return found


class _Point:
    """An end of the span that is a point."""

    count = 0
    radius = mpf(0)

    def __init__(self, foot: Vector, dead: mpf) -> None:
        self.foot, self.dead = foot, dead

    def contact(self, at: Sequence[mpf]) -> Vector:
        return self.foot

    def wrap(self, at: Sequence[mpf]) -> mpf:
        return mpf(0)

    def guess(self, other: Vector) -> tuple[mpf, ...]:
        return ()

    def misses(self, at: Sequence[mpf], other: Vector) -> list[mpf]:
        return []

    def check(self, at: Sequence[mpf], other: Vector) -> None:
        """Nothing can be wrong."""


class _Turning:
    """A sheave that turns about ``inlet``, the direction in which the cable comes to its rim at ``foot``.

    Unknowns are the turn of its plane and the wrap. Read outwards, from the frame or from the platform.
    """

    count = 2

    def __init__(self, foot: Vector, inlet: Vector, radius: Real, dead: mpf) -> None:
        self.foot, self.inlet, self.radius, self.dead = foot, inlet, mpf(radius), dead
        self.x = _unit(_cross(inlet, min(((1, 0, 0), (0, 1, 0), (0, 0, 1)), key=lambda axis: abs(_dot(axis, inlet)))))
        self.y = _cross(inlet, self.x)

    def middle(self, at: Sequence[mpf]) -> Vector:
        """Return the unit vector from the foot to the sheave's centre."""
        return _plus(_times(mp.cos(at[0]), self.x), _times(mp.sin(at[0]), self.y))

    def outwards(self, at: Sequence[mpf]) -> Vector:
        """Return the unit vector from the centre to where the span leaves the rim."""
        return _plus(_times(-mp.cos(at[1]), self.middle(at)), _times(mp.sin(at[1]), self.inlet))

    def onwards(self, at: Sequence[mpf]) -> Vector:
        """Return the direction in which the cable runs there."""
        return _plus(_times(mp.sin(at[1]), self.middle(at)), _times(mp.cos(at[1]), self.inlet))

    def contact(self, at: Sequence[mpf]) -> Vector:
        return _plus(self.foot, _times(self.radius, _plus(self.middle(at), self.outwards(at))))

    def wrap(self, at: Sequence[mpf]) -> mpf:
        return at[1]

    def guess(self, other: Vector) -> tuple[mpf, mpf]:
        reach = _minus(other, self.foot)
        x, y, along = _dot(reach, self.x), _dot(reach, self.y), _dot(reach, self.inlet)
        aside = mp.hypot(x, y)
        if aside == 0:
            raise ArithmeticError("the span runs along the swivel's axis, which leaves its turn open")
        return mp.atan2(y, x), _tangent(self.radius - aside, along, self.radius)

    def normal(self, at: Sequence[mpf]) -> Vector:
        """Return the unit normal of the sheave's plane."""
        return _cross(self.inlet, self.middle(at))

    def misses(self, at: Sequence[mpf], other: Vector) -> list[mpf]:
        return [
            _dot(_minus(other, self.foot), self.normal(at)),
            _dot(_minus(other, self.contact(at)), self.outwards(at)),
        ]

    def offsets(self, at: Sequence[mpf], other: Vector) -> tuple[mpf, mpf]:
        """Return how far from the axis, towards the centre, the span leaves the rim and ends."""
        near, far = _minus(self.contact(at), self.foot), _minus(other, self.foot)
        return _dot(near, self.middle(at)), _dot(far, self.middle(at))

    def check(self, at: Sequence[mpf], other: Vector) -> None:
        if self.offsets(at, other)[1] <= 0:
            raise ArithmeticError("the sheave does not face the span")
        if abs(_dot(_unit(_minus(other, self.contact(at))), self.onwards(at)) - 1) > LEFT_OVER * 10**6:
            raise ArithmeticError("the span does not go on from the rim")


class _Standing:
    """A wheel whose plane stands still. The unknown is the wrap."""

    count = 1

    def __init__(self, wheel: Pulley) -> None:
        self.foot, axis, self.radius = _vector(wheel.centre), _unit(wheel.axis), mpf(wheel.radius)
        exit_ = _minus(_vector(wheel.winch_exit), self.foot)
        exit_ = _minus(exit_, _times(_dot(exit_, axis), axis))
        away = _norm(exit_)
        if away <= self.radius:
            raise ArithmeticError("the winch exit is inside the wheel")
        self.dead = mp.sqrt(away**2 - self.radius**2)
        lead = mp.acos(self.radius / away)  # from the winch exit, seen from the centre, on to where the cable meets it
        x = _times(1 / away, exit_)
        y = _cross(axis, x)
        self.x = _plus(_times(mp.cos(lead), x), _times(mp.sin(lead), y))
        self.y = _cross(axis, self.x)

    def outwards(self, at: Sequence[mpf]) -> Vector:
        return _plus(_times(mp.cos(at[0]), self.x), _times(mp.sin(at[0]), self.y))

    def onwards(self, at: Sequence[mpf]) -> Vector:
        return _plus(_times(-mp.sin(at[0]), self.x), _times(mp.cos(at[0]), self.y))

    def contact(self, at: Sequence[mpf]) -> Vector:
        return _plus(self.foot, _times(self.radius, self.outwards(at)))

    def wrap(self, at: Sequence[mpf]) -> mpf:
        return at[0]

    def guess(self, other: Vector) -> tuple[mpf]:
        reach = _minus(other, self.foot)
        return (_tangent(_dot(reach, self.x), _dot(reach, self.y), self.radius),)

    def misses(self, at: Sequence[mpf], other: Vector) -> list[mpf]:
        return [_dot(_minus(other, self.contact(at)), self.outwards(at))]

    def check(self, at: Sequence[mpf], other: Vector) -> None:
        if _dot(_minus(other, self.contact(at)), self.onwards(at)) <= 0:
            raise ArithmeticError("the span does not go on from the rim")


_Guide = _Point | _Turning | _Standing


def _start(frame: Frame) -> _Guide:
    if isinstance(frame, Eyelet):
        return _Point(_vector(frame.point), mpf(0))
    if isinstance(frame, Pulley):
        return _Standing(frame)
    inlet = _times(mpf(frame.side), _unit(frame.axis))
    return _Turning(_vector(frame.exit_point), inlet, frame.radius, mpf(frame.dead))


def _finish(end: End, position: Triple, rotation: Matrix) -> _Guide:
    foot = _plus(_vector(position), _turned(rotation, end.point))
    if end.axis is None:
        return _Point(foot, mpf(0))
    axis = _unit(_turned(rotation, end.axis))
    if end.leaves is None:
        return _Turning(foot, axis, end.radius, mpf(0))
    leaves, radius = _unit(_turned(rotation, end.leaves)), mpf(end.radius)
    anchor = _plus(foot, _times(radius, _plus(_cross(leaves, axis), leaves)))
    return _Standing(Pulley(foot, _times(-1, axis), radius, anchor))


def _by_turns(first: _Guide, last: _Guide) -> tuple[mpf, ...]:
    """Return unknowns found by turning one sheave to the other and back: this nears where both rest."""
    with mp.workdps(20):
        other: tuple[mpf, ...] = ()
        arrives, unknowns = last.foot, (mp.inf,)
        for _ in range(200):
            mine = first.guess(arrives)
            other = last.guess(first.contact(mine))
            arrives, before, unknowns = last.contact(other), unknowns, (*mine, *other)
            if len(before) == len(unknowns) and all(abs(a - b) < 1e-12 for a, b in zip(before, unknowns, strict=True)):
                break
        return unknowns


def _root(misses: Callable[..., list[mpf]], start: Sequence[mpf]) -> tuple[mpf, ...]:
    try:
        found = mp.findroot(misses, start, tol=LEFT_OVER, maxsteps=60)
    except ValueError as error:
        raise ArithmeticError("no path is found") from error
    return tuple(mp.matrix([found]) if isinstance(found, mpf) else found)


def _check(first: _Guide, last: _Guide, mine: Sequence[mpf], other: Sequence[mpf]) -> None:
    """Raise `ArithmeticError` where the path is a solution of its equations that no cable takes."""
    leaves, arrives = first.contact(mine), last.contact(other)
    first.check(mine, arrives)
    last.check(other, leaves)
    for wrap in (first.wrap(mine), last.wrap(other)):
        if not 0 <= wrap < 2 * mp.pi:
            raise ArithmeticError(f"a wrap of {float(wrap):g} rad")
    if isinstance(first, _Turning) and isinstance(last, _Turning):
        x1, far1 = first.offsets(mine, arrives)
        x2, far2 = last.offsets(other, leaves)
        across = _dot(first.normal(mine), last.normal(other))
        if far1 * far2 <= x1 * x2 * across**2:  # the length's second derivative by the two turns, times f^2 / (x1 x2)
            raise ArithmeticError("the two sheaves turn away from where they balance")


def _tangent(x: mpf, y: mpf, radius: mpf) -> mpf:
    """Return the angle in [0, 2 pi) at which a cable that runs round with that radius leaves towards (x, y)."""
    away = mp.hypot(x, y)
    if away <= radius:
        raise ArithmeticError("the span ends inside the sheave")
    return (mp.atan2(y, x) - mp.acos(radius / away)) % (2 * mp.pi)


def _length_after(
    frame: Frame, end: End, position: Triple, rotation: Matrix, one_by_one: bool = True
) -> Callable[[Sequence[tuple[int, mpf]]], mpf]:
    """Return the length as a function of small motions, each an axis from 0 to 5 and how far, one by one or
    together."""
    guess = taut_path(frame, end, position, rotation).unknowns
    matrix = [_vector(row) for row in rotation]

    def length(motions: Sequence[tuple[int, mpf]]) -> mpf:
        moved, turned = list(_vector(position)), matrix
        together = [mpf(0)] * 3
        for axis, amount in motions:
            if axis < 3:
                moved[axis] += amount
            elif one_by_one:
                turned = _product(_rotation([amount if i == axis - 3 else mpf(0) for i in range(3)]), turned)
            else:
                together[axis - 3] += amount
        return taut_path(frame, end, moved, _product(_rotation(together), turned), guess).length

    return length


def _rotation(vector: Triple) -> list[Vector]:
    """Return the matrix of a rotation vector."""
    angle = _norm(vector)
    sinc = mp.sin(angle) / angle if angle else mpf(1)
    versine = 2 * (mp.sin(angle / 2) / angle) ** 2 if angle else mpf(0.5)
    columns = []
    for unit in ((1, 0, 0), (0, 1, 0), (0, 0, 1)):
        once = _cross(vector, unit)
        columns.append(_plus(unit, _plus(_times(sinc, once), _times(versine, _cross(vector, once)))))
    return [(columns[0][i], columns[1][i], columns[2][i]) for i in range(3)]


def _product(left: Matrix, right: Matrix) -> list[Vector]:
    columns = [_turned(left, [row[i] for row in right]) for i in range(3)]
    return [(columns[0][i], columns[1][i], columns[2][i]) for i in range(3)]


def _turned(rotation: Matrix, vector: Triple) -> Vector:
    x, y, z = (_dot(_vector(row), _vector(vector)) for row in rotation)
    return x, y, z


def _vector(values: Triple) -> Vector:
    x, y, z = (mpf(value) for value in values)
    return x, y, z


def _dot(a: Triple, b: Triple) -> mpf:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Triple, b: Triple) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _plus(a: Triple, b: Triple) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _minus(a: Triple, b: Triple) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _times(factor: mpf, a: Triple) -> Vector:
    return factor * a[0], factor * a[1], factor * a[2]


def _norm(a: Triple) -> mpf:
    return mp.sqrt(_dot(a, a))


def _unit(a: Triple) -> Vector:
    a = _vector(a)
    return _times(1 / _norm(a), a)


@dataclass(frozen=True)
class MujocoPath:
    """The length of a line in MuJoCo, m, and its gradient (6) by motions of the platform as in `length_gradient`.

    ``left_over`` is the largest derivative of the length by free rotations: 0 where the sheaves rest.
    """

    length: float
    gradient: np.ndarray
    left_over: float


def mujoco_length(frame: Frame, end: End, position: Triple, rotation: Matrix) -> float:
    """Return the length of the line in MuJoCo, m: `mujoco_path` has the rest."""
    return mujoco_path(frame, end, position, rotation).length


def mujoco_path(frame: Frame, end: End, position: Triple, rotation: Matrix) -> MujocoPath:
    """Return the length of a tendon over cylinders on hinges, turned until none of them is turned by the tendon.

    A cylinder has no groove. Once the cable slips aside it may tip the cylinder over, so that this is a stationary
    point of the length and often no minimum; but there the cable runs where a groove would hold it. Where both ends
    have a sheave, the tendon runs through a ring between them that slides across the span. On a wheel that stands still
    the cable slides along the axis: the span must be in the wheel's plane, or else this raises `ValueError`.
    """
    A, B = _feet(frame, end, position, rotation)
    _refuse_askew(frame, end, rotation, B)
    size = float(np.linalg.norm(B - A))
    model = mujoco.MjModel.from_xml_string(_xml(frame, end, position, rotation))
    data = mujoco.MjData(model)
    data.qpos[:3] = position
    data.qpos[3:7] = np.roll(Rotation.from_matrix(np.array(rotation, float)).as_quat(), 1)
    small = 0.02 * np.where(model.jnt_type[1:] == mujoco.mjtJoint.mjJNT_SLIDE, size, 1.0)

    def look(turns: np.ndarray) -> tuple[float, np.ndarray]:
        data.qpos[7:] = turns * small
        mujoco.mj_forward(model, data)  # a spring of 1 N/m pulls with its length
        length = float(data.ten_length[0])
        return length, -data.qfrc_passive / length

    def slope(turns: np.ndarray) -> np.ndarray:
        return look(turns)[1][6:] * small / size

    at = root(slope, np.zeros(len(small)), tol=1e-15).x if len(small) else small
    length, gradient = look(at)
    _refuse_astray(model, data, size)
    length += float(frame.dead) if isinstance(frame, Swivel) else 0.0
    length -= FEED * (isinstance(frame, Swivel) + (end.axis is not None)) * size
    turned = np.array(rotation, float) @ gradient[3:6]
    return MujocoPath(length, np.concatenate([gradient[:3], turned]), float(np.abs(gradient[6:]).max(initial=0.0)))


def _feet(frame: Frame, end: End, position: Triple, rotation: Matrix) -> tuple[np.ndarray, np.ndarray]:
    """Return where the line begins (or its wheel's centre) and its point of the platform, world, m."""
    first = {Eyelet: "point", Swivel: "exit_point", Pulley: "centre"}[type(frame)]
    begin = np.array(getattr(frame, first), float)
    return begin, np.array(position, float) + np.array(rotation, float) @ np.array(end.point, float)


def _refuse_askew(frame: Frame, end: End, rotation: Matrix, point: np.ndarray) -> None:
    if not isinstance(frame, Pulley):
        return
    normal, reach = np.array(frame.axis, float), point - np.array(frame.centre, float)
    askew = abs(normal @ reach) > 1e-9 * np.linalg.norm(reach)
    if askew or (end.axis is not None and abs(normal @ np.array(rotation, float) @ np.array(end.axis, float)) > 1e-9):
        raise ValueError("on a wheel that stands still MuJoCo's cable runs in the wheel's plane alone")


def _refuse_astray(model: mujoco.MjModel, data: mujoco.MjData, size: float) -> None:
    """Raise `ArithmeticError` if the tendon has left a sheave, or slipped aside on one."""
    if data.ten_wrapnum[0] != model.nwrap + model.ngeom:
        raise ArithmeticError("MuJoCo's cable has left a sheave")
    names = [model.site(i).name for i in range(model.nsite)]
    for i in range(model.ngeom):
        other = "M" if "M" in names else {"WA": "B", "WB": "A"}[model.geom(i).name]
        axis = data.geom_xmat[i].reshape(3, 3)[:, 2]
        if abs(axis @ (data.site(other).xpos - data.geom_xpos[i])) > 1e-8 * size:
            raise ArithmeticError("MuJoCo's cable has slipped aside on a sheave")


def _xml(frame: Frame, end: End, position: Triple, rotation: Matrix) -> str:
    """Return the line in MuJoCo's format (MJCF), every hinge near where it will rest."""
    A, B = _feet(frame, end, position, rotation)
    feed = FEED * float(np.linalg.norm(B - A))
    turn = np.array(rotation, float)
    path, begins = ['<site site="A"/>'], f'<site name="A" pos="{_text(A)}"/>'
    if isinstance(frame, Swivel):
        inlet = frame.side * np.array(frame.axis, float)
        begins = _sheave("A", A, inlet, float(frame.radius), B - A, feed)
        path.append('<geom geom="WA" sidesite="SA"/>')
    elif isinstance(frame, Pulley):
        begins = _wheel(frame, B)
        path.append('<geom geom="WA" sidesite="SA"/>')
    ends = f'<site name="B" pos="{_text(end.point)}"/>'
    wound = end.axis is not None
    if end.axis is not None:
        point, inlet = np.array(end.point, float), np.array(end.axis, float)
        ends = _sheave("B", point, inlet, float(end.radius), turn.T @ (A - B), feed)
    if len(path) > 1 and wound:
        path.append('<site site="M"/>')
        begins += _ring(A, B)
    path += ['<geom geom="WB" sidesite="SB"/>'] * wound + ['<site site="B"/>']
    return f"""<mujoco>
  <compiler angle="radian"/>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="platform"><freejoint/>{INERTIAL}{ends}</body>
    {begins}
  </worldbody>
  <tendon><spatial stiffness="1" springlength="0">{"".join(path)}</spatial></tendon>
</mujoco>"""


def _sheave(name: str, foot: np.ndarray, inlet: np.ndarray, radius: float, towards: np.ndarray, feed: float) -> str:
    """Return a site from which the cable comes, and a sheave that turns about ``inlet``, its plane through a point."""
    middle = _one(towards - (towards @ inlet) * inlet)
    return f"""<site name="{name}" pos="{_text(foot - feed * inlet)}"/>
    <body pos="{_text(foot)}" xyaxes="{_text([*middle, *np.cross(inlet, middle)])}">
      <joint type="hinge" axis="0 0 1"/>{INERTIAL}<site name="S{name}" pos="{radius!r} 0 {2 * radius!r}"/>
      <geom name="W{name}" type="cylinder" pos="{radius!r} 0 0" zaxis="0 1 0" size="{radius!r} {radius!r}"/>
    </body>"""


def _wheel(wheel: Pulley, point: np.ndarray) -> str:
    """Return the winch exit and a wheel, the cable on the right of it between there and a point."""
    centre, exit_, axis = (np.array(each, float) for each in (wheel.centre, wheel.winch_exit, wheel.axis))
    right = np.cross(_one(centre - exit_) + _one(point - centre), axis)
    right = centre + 2 * float(wheel.radius) * _one(right)
    return f"""<site name="A" pos="{_text(exit_)}"/><site name="SA" pos="{_text(right)}"/>
    <geom name="WA" type="cylinder" pos="{_text(centre)}" zaxis="{_text(axis)}" size="{_text([wheel.radius] * 2)}"/>"""


def _ring(A: np.ndarray, B: np.ndarray) -> str:
    """Return a ring halfway between two points that slides across the line between them."""
    along = _one(B - A)
    one = _one(np.cross(along, np.eye(3)[np.abs(along).argmin()]))
    slides = "".join(f'<joint type="slide" axis="{_text(axis)}"/>' for axis in (one, np.cross(along, one)))
    return f'<body pos="{_text((A + B) / 2)}">{slides}{INERTIAL}<site name="M"/></body>'


def _text(vector: Triple) -> str:
    return " ".join(repr(float(value)) for value in vector)


def _one(vector: np.ndarray) -> np.ndarray:
    return np.asarray(vector / np.linalg.norm(vector))


@dataclass(frozen=True)
class Case:
    """A line and a pose of its platform."""

    frame: Frame
    end: End
    position: np.ndarray
    rotation: np.ndarray


def random_case(
    rng: np.random.Generator,
    frame_kind: Literal["eyelet", "swivel", "pulley"],
    end_kind: Literal["point", "swivel"],
    in_plane: bool = False,
) -> Case:
    """Return a line of 0.3 m to 60 m with sheaves of 1 % to 5 % of that, each with 15 to 160 degrees of cable on it.

    A fixed wheel's plane misses the platform point by up to 20 degrees, with ``in_plane`` by none.
    """
    size = 0.3 * 200 ** rng.random()
    A, span, rotation = (
        rng.uniform(-size, size, 3),
        _one(rng.standard_normal(3)),
        Rotation.from_quat(rng.standard_normal(4)).as_matrix(),
    )
    aside = _across(rng, span)  # in the fixed wheel's plane
    frame: Frame = Eyelet(tuple(A))
    if frame_kind == "swivel":
        side = int(rng.choice([-1, 1]))
        inlet = _turned_by(span, _across(rng, span), _wound(rng))
        dead = float(rng.choice([0.0, rng.uniform(0.1, 1.0) * size]))
        frame = Swivel(tuple(A), tuple(side * inlet), size * rng.uniform(0.01, 0.05), side, dead)
    elif frame_kind == "pulley":
        axis, radius = np.cross(span, aside), size * rng.uniform(0.01, 0.05)
        inlet = _turned_by(span, -aside, _wound(rng))
        exit_ = A + radius * np.cross(inlet, axis) - rng.uniform(0.2, 1.0) * size * inlet
        frame = Pulley(tuple(A), tuple(axis), radius, tuple(exit_))
        if not in_plane:
            span = _turned_by(span, axis, rng.uniform(-0.35, 0.35))
    arm = rng.uniform(-0.2, 0.2, 3) * size
    position = A + size * span - rotation @ arm
    end = End(tuple(arm))
    if end_kind == "swivel":
        out = _turned_by(-span, aside if in_plane else _across(rng, span), _wound(rng))
        end = End(tuple(arm), tuple(rotation.T @ out), size * rng.uniform(0.01, 0.05))
    return Case(frame, end, position, rotation)


def _across(rng: np.random.Generator, vector: np.ndarray) -> np.ndarray:
    """Return any unit vector normal to a unit vector."""
    return _one(np.cross(vector, rng.standard_normal(3)))


def _turned_by(vector: np.ndarray, towards: np.ndarray, angle: float) -> np.ndarray:
    """Return a unit vector turned by an angle towards another that is normal to it."""
    return np.asarray(np.cos(angle) * vector + np.sin(angle) * towards)


def _wound(rng: np.random.Generator) -> float:
    return float(np.radians(rng.uniform(15, 160)))
