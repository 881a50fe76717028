"""Oracle: how far the claimed state of one line is from the equations of its statics, with 50 digits.

All is in the line's vertical plane: origin in the exit point A, x horizontally towards the platform point B, z up.
Directions are angles from x towards z, in rad. Lengths are m and unstrained, forces N.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from mpmath import mp, mpf

from cablewright.robot import Eyelet, Line, UniversalJoint
from oracles.irvine import DIGITS, Pair, Real, span

Model = Literal["rigid", "elastic", "catenary"]


@dataclass(frozen=True)
class LineState:
    """What is claimed of a line.

    ``tension`` (N) is the one on both sides of the sheave. ``phi`` is the direction in which the free span leaves the
    sheave, ``psi`` the direction from the sheave into the dead span, ``beta`` the lever's. An eyelet's dead span has a
    vertical plane of its own, with x towards the winch exit. Without a winch exit the cable comes vertically, from
    below if it wraps over and from above if under, and ``psi`` and ``dead_length`` are not looked at; nor is ``beta``
    where there is no lever.
    """

    tension: Real
    phi: Real
    free_length: Real
    psi: Real = 0.0
    dead_length: Real = 0.0
    beta: Real = 0.0


@dataclass(frozen=True)
class LineCheck:
    """By how much a claimed state misses: ends of the spans (m), moment over tension and lever, length (m).

    ``dead_end`` is empty where no dead span is modelled, ``moment`` where there is no lever. ``force`` (3) is what the
    line pulls the platform point with, N, world; ``wound`` the angle on the sheave, rad.
    """

    free_end: Pair
    dead_end: tuple[mpf, ...]
    moment: tuple[mpf, ...]
    length: mpf
    force: tuple[mpf, mpf, mpf]
    wound: mpf

    @property
    def vector(self) -> list[mpf]:
        """All that should be zero."""
        return [*self.free_end, *self.dead_end, *self.moment, self.length]

    @property
    def geometry(self) -> mpf:
        """The largest miss that is a length, m."""
        return max(abs(value) for value in (*self.free_end, *self.dead_end, self.length))


def check(
    line: Line,
    gravity: Real,
    platform_point: Sequence[Real],
    length: Real,
    state: LineState,
    model: Model = "catenary",
) -> LineCheck:
    """Return how far ``state`` is from the statics of a line of that unstrained length, m.

    ``platform_point``: (3,) m, world. ``elastic`` leaves out the cable's weight, ``rigid`` its stretch too.
    """
    with mp.workdps(DIGITS):
        T, phi, beta = mpf(state.tension), mpf(state.phi), mpf(state.beta)
        w = mpf(line.cable.linear_density) * mpf(gravity) if model == "catenary" else mpf(0)
        EA = stiffness(line) if model != "rigid" else mp.inf
        radius, side = _rim(line)
        psi = mpf(state.psi) if line.winch_exit is not None else -side * mp.pi / 2
        centre = _centre(line, beta)

        B, towards = _in_plane(line, platform_point)
        given = _given(line, T, phi, psi) if model != "rigid" else (mpf(0), mpf(0))
        leaves = (
            centre[0] - side * radius * mp.sin(phi) + given[0],
            centre[1] + side * radius * mp.cos(phi) + given[1],
        )
        H, V0 = T * mp.cos(phi), T * mp.sin(phi)
        free = span(H, V0, state.free_length, w, EA)
        free_end = (leaves[0] + free[0] - B[0], leaves[1] + free[1] - B[1])

        if line.winch_exit is None:
            dead_end, dead_length = (), mpf(line.dead_length)
        else:
            C = _winch_exit(line, line.winch_exit, towards)
            enters = (centre[0] + side * radius * mp.sin(psi), centre[1] - side * radius * mp.cos(psi) + given[1])
            dead_length = mpf(state.dead_length)
            dead = span(T * mp.cos(psi), T * mp.sin(psi), dead_length, w, EA if line.dead_elastic else mp.inf)
            dead_end = (enters[0] + dead[0] - C[0], enters[1] + dead[1] - C[1])

        wound = side * (psi - phi) + mp.pi
        arc = radius * wound / (1 + T / EA) if line.arc_elastic else radius * wound
        miss = mpf(state.free_length) + dead_length + arc - mpf(length)
        if line.spring is not None and model != "rigid":
            miss -= T * line.cables / mpf(line.spring)
        along = (-H * towards[0], -H * towards[1], -(V0 + w * mpf(state.free_length)))
        return LineCheck(free_end, dead_end, _moment(line, T, phi, psi, beta), miss, along, wound)


def stiffness(line: Line) -> mpf:
    """Return the cable's EA, N."""
    cable = line.cable
    return mpf(cable.axial_stiffness) if cable.axial_stiffness else mpf(cable.young_modulus) * mpf(cable.section)


def _rim(line: Line) -> tuple[mpf, int]:
    """Return the sheave's radius, and +1 for a cable over it, -1 for one under it."""
    if isinstance(line.sheave, Eyelet):
        return mpf(0), 1
    return mpf(line.sheave.radius), 1 if line.sheave.wrap == "over" else -1


def _centre(line: Line, beta: mpf) -> Pair:
    if isinstance(line.sheave, UniversalJoint):
        return mpf(line.sheave.lever) * mp.cos(beta), mpf(line.sheave.lever) * mp.sin(beta)
    return (mpf(0), mpf(0)) if isinstance(line.sheave, Eyelet) else (mpf(line.sheave.radius), mpf(0))


def _in_plane(line: Line, platform_point: Sequence[Real]) -> tuple[Pair, Pair]:
    """Return B in the plane, and the plane's horizontal unit vector."""
    x, y, z = (mpf(b) - mpf(a) for a, b in zip(line.exit_point, platform_point, strict=True))
    reach = mp.hypot(x, y)
    if reach == 0:
        raise ValueError(f"line {line.name!r} has no plane: its platform point is straight below its exit point")
    return (reach, z), (x / reach, y / reach)


def _given(line: Line, T: mpf, phi: mpf, psi: mpf) -> Pair:
    """Return by how much the mount of the exit point gives, m: under both spans in height, sideways under the free one.

    The winch of a modelled dead span stands on its own; any other is on the mount.
    """
    if line.exit_compliance is None:
        return mpf(0), mpf(0)
    assert isinstance(line.exit_compliance, float)
    soft, dead = mpf(line.exit_compliance) * line.cables, mpf(0) if line.winch_exit is None else mp.sin(psi)
    return soft * T * mp.cos(phi), soft * T * (mp.sin(phi) + dead)


def _winch_exit(line: Line, winch_exit: Sequence[Real], towards: Pair) -> Pair:
    """Return C in the plane of the dead span: the line's, or for an eyelet the one that C itself makes."""
    x, y, z = (mpf(c) - mpf(a) for a, c in zip(line.exit_point, winch_exit, strict=True))
    return (mp.hypot(x, y) if isinstance(line.sheave, Eyelet) else x * towards[0] + y * towards[1]), z


def _moment(line: Line, T: mpf, phi: mpf, psi: mpf, beta: mpf) -> tuple[mpf, ...]:
    """Return the moment about the joint, lifting the lever, over tension and lever.

    Both tensions are T, at opposite equal arms, so that together they act in the sheave's centre.
    """
    if not isinstance(line.sheave, UniversalJoint):
        return ()
    lever, weight, arm = (mpf(v) for v in (line.sheave.lever, line.sheave.lever_weight, line.sheave.lever_mass_centre))
    pull = (T * (mp.cos(phi) + mp.cos(psi)), T * (mp.sin(phi) + mp.sin(psi)))
    moment = lever * (mp.cos(beta) * pull[1] - mp.sin(beta) * pull[0]) - arm * mp.cos(beta) * weight
    return (moment / (T * lever),)
