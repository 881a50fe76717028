"""Draw the pictures of ``docs/index.md``, ``conventions.md`` and ``show.md``: ``python tools/docs_pictures.py``."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.axes import Axes

import cablewright as cw
from cablewright.apps import style
from cablewright.apps.pictures.path_errors import side_view
from cablewright.apps.report.check_summary import Digest
from cablewright.apps.web.png import scene_png
from cablewright.apps.web.robot_scene import robot_scene
from cablewright.printing.layers import layer_table
from cablewright.robot import library_names

ROOT = Path(__file__).resolve().parent.parent
IMAGES = ROOT / "docs" / "images"
HOUSE = ROOT / "examples" / "house.toml"
STEP: Final = 0.2  # m: four times as coarse as the job of the page, so that it takes seconds

EDGE: Final = 4.0  # m: the frame of the sketch
SHEAVE: Final = 0.24  # m: drawn larger than any sheave
WINCH: Final = 0.35  # m: height of the winch exit points
PLATFORM: Final = np.array([1.9, 1.7, 1.75])  # m: origin of the platform
HALF: Final = np.array([0.45, 0.45, 0.2])  # m: half its size
NOZZLE: Final = np.array([0.0, 0.0, -0.55])  # m, platform frame
UP: Final = np.array([0.0, 0.0, 1.0])
LABELLED: Final = 0  # the line whose parts are named


def draw_check(file: Path = HOUSE, step: float = STEP) -> bytes:
    """The path of a job's report, that of the quick start, coloured by its error; *step*, m, between samples."""
    job = cw.load_job(file)
    coarse = job.model_copy(update={"sampling": job.sampling.model_copy(update={"step": step})})
    found = cw.check(cw.load("house-printer"), coarse, skip=("interference", "expected-error"))
    return style.png(side_view(Digest(found, layer_table(found.samples, found.law))))


def seen(point: np.ndarray) -> np.ndarray:
    """Project points (.., 3) onto the sheet: x to the right, z up, y into the sheet."""
    return np.stack([point[..., 0] + 0.5 * point[..., 1], point[..., 2] + 0.32 * point[..., 1]], axis=-1)


def spot(point: np.ndarray, across: float = 0.0, up: float = 0.0) -> tuple[float, float]:
    """The place on the sheet of one point (3,), moved."""
    x, z = seen(point).tolist()
    return x + across, z + up


def draw_frame() -> bytes:
    """The frame of a robot with its axes, and the names of the points and spans of one line."""
    drawn = style.figure(7.2, 5.2)
    axes = drawn.add_subplot(aspect="equal")
    axes.set_axis_off()
    _box(axes, np.zeros(3), np.full(3, EDGE), style.GREY, 0.8)
    _box(axes, PLATFORM - HALF, PLATFORM + HALF, style.INK, 1.4)
    corners = ((0.0, 0.0), (EDGE, 0.0), (EDGE, EDGE), (0.0, EDGE))
    for index, (x, y) in enumerate(corners):
        _line(axes, x, y, index)
    _axes_of(axes, np.array([0.5 * EDGE, 0.5 * EDGE, 0.0]), 0.8, style.GREEN)
    _axes_of(axes, PLATFORM, 0.62, style.BLUE)
    tip = seen(PLATFORM + NOZZLE)
    axes.plot(*zip(seen(PLATFORM - HALF[2] * UP), tip, strict=True), color=style.INK, linewidth=3.0)
    axes.plot(*tip, marker="v", color=style.RED, markersize=7, zorder=5)
    for text, point, place in (
        ("nozzle", PLATFORM + NOZZLE, (-0.6, -0.25)),
        ("world frame: origin on the floor,\nz up, gravity along -z", np.array([2.0, 2.0, 0.0]), (1.0, -0.62)),
        ("platform frame:\nits origin is the pose", PLATFORM, (2.15, 0.25)),
    ):
        _note(axes, text, point, place)
    axes.set(xlim=(-1.5, 6.2), ylim=(-0.15, 5.4))
    return style.png(drawn)


def _line(axes: Axes, x: float, y: float, index: int) -> None:
    """Draw a line from its winch over its sheave to the platform; name the parts of one."""
    winch, exit_point = np.array([x, y, WINCH]), np.array([x, y, EDGE - SHEAVE])
    end = PLATFORM + HALF * [-1 if x == 0 else 1, -1 if y == 0 else 1, 1]
    inwards = (end - exit_point) * [1.0, 1.0, 0.0]
    inwards /= np.linalg.norm(inwards)
    centre = exit_point + SHEAVE * inwards
    straight = (end - centre) @ inwards, end[2] - centre[2]  # in the plane of the line
    leaves = np.arctan2(straight[1], straight[0]) + np.arccos(SHEAVE / np.hypot(*straight))
    top = centre + SHEAVE * (np.cos(leaves) * inwards + np.sin(leaves) * UP)
    turn = np.linspace(0.0, 2.0 * np.pi, 90)[:, None]
    rim = seen(centre + SHEAVE * (np.cos(turn) * inwards + np.sin(turn) * UP))
    axes.fill(*rim.T, facecolor="#e8edf2", edgecolor=style.INK, linewidth=1.2, zorder=3)
    for start, stop in ((winch, exit_point), (top, end)):
        axes.plot(*zip(seen(start), seen(stop), strict=True), color=style.RED, linewidth=1.6, zorder=4)
    arc = np.linspace(leaves, np.pi, 40)[:, None]
    bow = seen(centre + SHEAVE * (np.cos(arc) * inwards + np.sin(arc) * UP))
    axes.plot(*bow.T, color=style.RED, linewidth=1.6, zorder=4)
    for point, marker in ((winch, "s"), (exit_point, "o"), (end, "o")):
        axes.plot(*seen(point), marker=marker, color=style.INK, markersize=5, zorder=5)
    if index == LABELLED:
        _note(axes, "winch exit  C", winch, (-0.9, 0.1))
        _note(axes, "dead span", 0.5 * (winch + exit_point), (-0.9, 0.1))
        _note(axes, "exit point  A", exit_point, (-0.9, 0.1))
        _note(axes, "sheave", centre + SHEAVE * UP, (-0.6, 0.6))
        _note(axes, "free span", 0.55 * top + 0.45 * end, (0.4, 0.7))
        _note(axes, "platform point  B", end, (-1.15, -0.75))


def _box(axes: Axes, low: np.ndarray, high: np.ndarray, colour: str, width: float) -> None:
    """Draw the twelve edges of a box."""
    for axis in range(3):
        for corner in np.ndindex(2, 2):
            start = np.insert(np.array(corner), axis, 0)
            stop = np.insert(np.array(corner), axis, 1)
            ends = [seen(np.where(each, high, low)) for each in (start, stop)]
            axes.plot(*zip(*ends, strict=True), color=colour, linewidth=width, zorder=2)


def _axes_of(axes: Axes, origin: np.ndarray, size: float, colour: str) -> None:
    """Draw the three axes of a frame as arrows."""
    for axis, letter in enumerate("xyz"):
        stop = origin + size * np.eye(3)[axis]
        arrow = {"arrowstyle": "-|>", "color": colour, "linewidth": 1.6}
        axes.annotate("", spot(stop), spot(origin), arrowprops=arrow, zorder=6)
        axes.text(*spot(stop, 0.06, 0.04), letter, color=colour, fontsize=10, zorder=6)


def _note(axes: Axes, text: str, point: np.ndarray, offset: tuple[float, float]) -> None:
    """Name a point, from a place off it."""
    arrow = {"arrowstyle": "-", "color": style.GREY, "linewidth": 0.8, "shrinkB": 3.0}
    place = spot(point, *offset)
    axes.annotate(text, spot(point), place, arrowprops=arrow, fontsize=9.5, ha="center", va="center", zorder=7)


def draw_robot(name: str) -> bytes:
    """A robot of the library at rest, as ``cablewright show NAME --png`` draws it."""
    return scene_png(robot_scene(cw.load(name)))


def main() -> None:
    """Write all pictures."""
    for name in library_names():
        (IMAGES / f"robot-{name}.png").write_bytes(draw_robot(name))
    with style.drawing():
        (IMAGES / "check-path.png").write_bytes(draw_check())
        (IMAGES / "frame.png").write_bytes(draw_frame())


if __name__ == "__main__":
    main()
