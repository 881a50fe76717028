"""The stress of a bracket: base and lever of both designs, coloured by von Mises stress, seen from outside."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]

from cablewright.analyses.bracket.elasticity import von_mises
from cablewright.analyses.bracket.stress import Design
from cablewright.apps import style
from cablewright.apps.space_axes import add_lines, space
from cablewright.arrays import Array
from cablewright.studies.bracket import BracketStress

_MILLI: Final = 1e3
_AROUND: Final = 72  # pieces of the sheave's outline
_ARROW: Final = 0.06  # m: the larger pull's length
_FROM: Final = (24.0, 32.0)  # degrees: elevation and azimuth of the eye


def bracket_picture(stress: BracketStress) -> Figure:
    """Draw both designs in one scale of colours. Call within `style.drawing`."""
    found = stress.designs
    drawn = style.figure(10.6, 6.0)
    grid = drawn.add_gridspec(1, 2)
    designs = ((found.universal_joint, "universal joint"), (found.conventional, "second rotation blocked"))
    largest = max(design.max_von_mises for design, _ in designs) / 1e6
    colours = ScalarMappable(Normalize(0.0, largest), style.stress_colours())
    shown = [_design(drawn, grid[0, k], design, name, colours) for k, (design, name) in enumerate(designs)]
    bar = drawn.colorbar(colours, ax=shown, extend="max", shrink=0.8, aspect=30, pad=0.02)
    bar.set_label("von Mises stress in MPa; more only at sharp edges and contacts")
    bar.outline.set_visible(False)
    robot = found.model.robot
    line = robot.lines[found.universal_joint.line].name
    place = ", ".join(f"{x:g}" for x in found.pose[:3])
    title = f"{style.label(robot.name)}, line {style.label(line)}, platform at ({place}) m"
    drawn.suptitle(title.replace("-", "\N{MINUS SIGN}") if "-" not in robot.name + line else title, x=0.01, ha="left")
    return drawn


def _design(drawn: Figure, where: SubplotSpec, design: Design, name: str, colours: ScalarMappable) -> Any:
    """Draw one design; return its axes."""
    faces, values = _faces(design)
    outline = _sheave(design)
    ends = np.concatenate([faces.reshape(-1, 3), outline.reshape(-1, 3)])
    axes, _ = space(drawn, where, _MILLI * ends.min(axis=0), _MILLI * ends.max(axis=0), "mm")
    axes.view_init(elev=_FROM[0], azim=_FROM[1])
    painted = Poly3DCollection(
        _MILLI * faces, facecolors=colours.to_rgba(values / 1e6), linewidths=0.1, zsort="average"
    )
    painted.set_edgecolor(colours.to_rgba(values / 1e6))
    axes.add_collection3d(painted, autolim=False)
    add_lines(axes, _MILLI * outline, 4, 1.1, style.GREY)
    for start, pull in _pulls(design):
        axes.quiver(
            *(_MILLI * start), *(_MILLI * pull), color=style.ORANGE, linewidth=1.6, arrow_length_ratio=0.2, zorder=6
        )
    worst = design.worst
    axes.set_title(f"{name}: {worst.stress / 1e6:.0f} MPa in the {worst.part}, safety {design.safety:.2f}")
    return axes


def _faces(design: Design) -> tuple[Array, Array]:
    """Outer faces (F, 4, 3) of base and both cheeks, m, bracket's frame, and the stress (F,) of each, Pa."""
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
    """The corners of flat faces (F, 4, 3) in an order around each."""
    away = faces - faces.mean(axis=1, keepdims=True)
    normal = np.cross(away[:, 0], away[:, 1] + 1e-3 * away[:, 2])
    first = away[:, 0] / np.linalg.norm(away[:, 0], axis=1, keepdims=True)
    second = np.cross(normal / np.linalg.norm(normal, axis=1, keepdims=True), first)
    angle = np.arctan2((away * second[:, None]).sum(axis=2), (away * first[:, None]).sum(axis=2))
    return np.asarray(np.take_along_axis(faces, np.argsort(angle, axis=1)[..., None], axis=1))


def _sheave(design: Design) -> Array:
    """Pieces (P, 2, 3) of the sheave's two rims, m, bracket's frame."""
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
    """Where both spans touch the sheave and how they pull, as arrows, m, bracket's frame."""
    loads, i = design.loads, design.line
    largest = float(np.linalg.norm(loads.free[0, i]))
    level = design.level
    found = []
    for touch, pull in ((loads.leaving, loads.free), (loads.entering, loads.dead)):
        found.append((level @ (touch - loads.joint)[0, i], _ARROW / largest * level @ pull[0, i]))
    return found
