"""The stress of a bracket: base and lever of both designs, coloured by von Mises stress, seen from outside."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec

from cablewright.analyses.bracket.elasticity import von_mises
from cablewright.analyses.bracket.stress import Design
from cablewright.apps import style
from cablewright.apps.space_axes import add_faces, add_lines, bounds, space
from cablewright.foundation.arrays import Array
from cablewright.studies.bracket import BracketStress

_MILLI: Final = 1e3
_AROUND: Final = 72  # pieces of the sheave's outline
_ARROW: Final = 0.06  # m: the larger pull's length
_FROM: Final = (24.0, 32.0)  # degrees: elevation and azimuth of the eye


def bracket_picture(stress: BracketStress) -> Figure:
    """Draw the stress of both bracket designs in one colour scale."""
    found = stress.designs
    drawn, places = style.grid(10.6, 6.0, (1, 2), (0, 0), (0, 1))
    designs = ((found.universal_joint, "universal joint"), (found.conventional, "second rotation blocked"))
    largest = max(design.max_von_mises for design, _ in designs) / 1e6
    colours = ScalarMappable(Normalize(0.0, largest), style.stress_colours())
    shown = [_design(drawn, at, design, name, colours) for at, (design, name) in zip(places, designs, strict=True)]
    text = "von Mises stress in MPa; more only at sharp edges and contacts"
    style.colour_bar(drawn, shown, colours, text, extend="max", shrink=0.8)
    robot = found.model.robot
    line = robot.lines[found.universal_joint.line].name
    place = style.minus(", ".join(f"{x:g}" for x in found.pose[:3]))
    style.headline(drawn, f"{style.label(robot.name)}, line {style.label(line)}, platform at ({place}) m")
    return drawn


def _design(drawn: Figure, where: SubplotSpec, design: Design, name: str, colours: ScalarMappable) -> Any:
    """Draw one design; return its axes."""
    faces, values = _faces(design)
    outline = _sheave(design)
    low, high = bounds(faces.reshape(-1, 3), outline.reshape(-1, 3))
    axes, _ = space(drawn, where, _MILLI * low, _MILLI * high, "mm")
    axes.view_init(elev=_FROM[0], azim=_FROM[1])
    add_faces(axes, _MILLI * faces, colours.to_rgba(values / 1e6), zorder=1, width=0.1)
    add_lines(axes, _MILLI * outline, 4, 1.1, style.GREY)
    arrow = {"color": style.ORANGE, "linewidth": 1.6, "arrow_length_ratio": 0.2, "zorder": 6}
    for start, pull in _pulls(design):
        axes.quiver(*(_MILLI * start), *(_MILLI * pull), **arrow)
    worst = design.worst
    axes.set_title(f"{name}: {worst.stress / 1e6:.0f} MPa in the {worst.part}, safety {design.safety:.2f}")
    return axes


def _faces(design: Design) -> tuple[Array, Array]:
    """Return outer faces (F, 4, 3) of base and both cheeks, m, bracket's frame, and the stress (F,) of each, Pa."""
    bracket = design.mesh.bracket
    aside = 0.5 * (bracket.lever.gap + bracket.lever.thickness)
    corners, values = [], []
    for part, _, stress in design.fields:
        mesh = part.elastic.solid.mesh
        outer = np.asarray(mesh.facets)[:, mesh.boundary_facets()]
        at, level = part.elastic.solid.places.T, von_mises(stress)
        around = _around(at[outer.T])
        own = level[outer].mean(axis=0)
        for side in (-1.0, 1.0) if part.name == "lever" else (0.0,):
            turn = design.turn if part.name == "lever" else np.eye(3)
            corners.append((around + np.array([0.0, side * aside, 0.0])) @ turn.T)
            values.append(own)
    return np.concatenate(corners), np.concatenate(values)


def _around(faces: Array) -> Array:
    """Return the corners of flat faces (F, 4, 3) in an order around each."""
    away = faces - faces.mean(axis=1, keepdims=True)
    normal = np.cross(away[:, 0], away[:, 1] + 1e-3 * away[:, 2])
    first = away[:, 0] / np.linalg.norm(away[:, 0], axis=1, keepdims=True)
    second = np.cross(normal / np.linalg.norm(normal, axis=1, keepdims=True), first)
    angle = np.arctan2((away * second[:, None]).sum(axis=2), (away * first[:, None]).sum(axis=2))
    return np.asarray(np.take_along_axis(faces, np.argsort(angle, axis=1)[..., None], axis=1))


def _sheave(design: Design) -> Array:
    """Return pieces (P, 2, 3) of the sheave's two rims, m, bracket's frame."""
    robot = design.loads.held.model.robot
    sheave: Any = robot.lines[design.line].sheave
    angle = np.linspace(0.0, 2.0 * np.pi, _AROUND + 1)
    half = 0.5 * design.mesh.bracket.axle.sheave_width
    rims = []
    for side in (-half, half):
        x, z = sheave.lever + sheave.radius * np.cos(angle), sheave.radius * np.sin(angle)
        rim = np.stack([x, np.full_like(x, side), z], axis=1) @ design.turn.T
        rims.append(np.stack([rim[:-1], rim[1:]], axis=1))
    return np.concatenate(rims)


def _pulls(design: Design) -> list[tuple[Array, Array]]:
    """Return where both spans touch the sheave and how they pull, as arrows, m, bracket's frame."""
    loads, i = design.loads, design.line
    scale = _ARROW / float(np.linalg.norm(loads.free[0, i]))
    spans = ((loads.leaving, loads.free), (loads.entering, loads.dead))
    return [(design.level @ (at - loads.joint)[0, i], scale * design.level @ pull[0, i]) for at, pull in spans]
