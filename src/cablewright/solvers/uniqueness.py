"""Theorems on uniqueness: among which equilibria a given one is the only one, see `docs/theory/uniqueness.md`."""

from __future__ import annotations

import math

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.models.statics import Equilibrium
from cablewright.solvers.certify import is_only_one

EVERYWHERE = "all equilibria"
_SAFE = 1e-6  # relative: how far inside a condition has to hold, far above rounding and a certificate's bound


def unique_among(equilibrium: Equilibrium) -> str | None:
    """Return in words the equilibria of the same lengths of which this single one is the only one; None: not known.

    Theorem 1: lines through eyelets without a modelled dead span. Theorems 2 and 3: eyelets and swivels with the cable
    over a rigid arc, dead spans constant or straight below on the axis; then the equilibria whose dead spans are taut
    and whose lines leave their swivels outwards, as they do wherever the platform is farther than two radii,
    horizontally, from each swivel's axis. The equilibrium has to be one of them. The platform is a point.
    """
    if is_only_one(equilibrium):
        return EVERYWHERE
    lines = equilibrium.lines
    dead_length, dead_tension = _slackest_dead_spans(equilibrium)
    modulus = _modulus(equilibrium, dead_length)
    covered = (
        equilibrium.model.n == 3
        and lines.in_plane.all()
        and not (lines.mount.any() or lines.spring.any())
        and equilibrium.model.robot.platform.plane is None
        and not lines.has_lever.any()
        and np.all((lines.weight > 0.0) & (lines.free_compliance > 0.0) & (lines.arc_compliance == 0.0))
        and np.all((lines.radius == 0.0) | ((lines.side > 0.0) & (lines.lever == lines.radius) & (lines.spans == 1.0)))
        and np.all(~lines.has_dead_span | ((lines.winch_distance == 0.0) & (lines.winch_height < 0.0)))
        and np.all(modulus > _SAFE * lines.free_compliance * equilibrium.lengths)
    )
    if not covered or not _is_among(equilibrium, dead_length, dead_tension):
        return None
    return _words(equilibrium)


def _slackest_dead_spans(equilibrium: Equilibrium) -> tuple[Array, Array]:
    """Length l_0, m, and tension T_0, N, at which a dead span straight below is about to go slack.

    A dead span that is not modelled has its constant length, and 0 N. Theorem 2: T_0 = w l_0, and
    l_0 = 2 d / (1 + sqrt(1 + 2 c w d)); of a rigid dead span l_0 = d.
    """
    lines = equilibrium.lines
    depth = np.where(lines.has_dead_span, -lines.winch_height, 0.0)
    length = 2.0 * depth / (1.0 + np.sqrt(1.0 + 2.0 * lines.dead_compliance * lines.weight * np.maximum(depth, 0.0)))
    return np.where(lines.has_dead_span, length, lines.dead_length), lines.weight * length


def _modulus(equilibrium: Equilibrium, dead_length: Array) -> Array:
    """The modulus of strong monotonicity of each line, m/N: theorem 2, and Eqs. 6 and 8 for swivels."""
    lines = equilibrium.lines
    free = (equilibrium.lengths - dead_length) / lines.spans
    stretch = np.where(lines.has_dead_span, lines.dead_compliance * lines.weight * dead_length, 0.0)  # kappa
    skew = lines.free_compliance * lines.radius * np.where(stretch > 0.0, (1.0 + 0.5 * stretch) / (1.0 - stretch), 0.5)
    return np.where(stretch < 0.5, lines.free_compliance * (free - math.pi * lines.radius) - skew, -np.inf)


def _is_among(equilibrium: Equilibrium, dead_length: Array, dead_tension: Array) -> bool:
    """Whether this equilibrium surely is as `_words` say, and its lines leave their swivels on the theorem's branch.

    A dead span that hangs in a loop has more tension than T_0, too, but more cable than l_0.
    """
    lines, states = equilibrium.lines, equilibrium.line_states
    taut = (states.tension > (1.0 + _SAFE) * dead_tension) & (states.dead_length < (1.0 + _SAFE) * dead_length)
    away = equilibrium.platform_points - lines.exit_point
    beside = np.hypot(away[..., 0], away[..., 1]) > (1.0 + _SAFE) * 2.0 * lines.radius.max()
    outwards = np.abs(states.free_angle) < 0.5 * math.pi
    return bool(np.all(taut | ~lines.has_dead_span) and np.all((beside & outwards) | (lines.radius == 0.0)))


def _words(equilibrium: Equilibrium) -> str:
    lines, parts = equilibrium.lines, []
    if lines.has_dead_span.any():
        parts.append("whose dead spans are taut")
    if lines.radius.any():
        parts.append(f"whose platform is farther than {2.0 * lines.radius.max():g} m from the axis of each swivel")
    return f"{EVERYWHERE} {' and '.join(parts)}".strip()
