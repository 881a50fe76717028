"""The data of the turnable view: the path in few pieces, packed small, beside frame and lines."""

from __future__ import annotations

import base64
import json
from typing import Any, Final

import numpy as np
from matplotlib.colors import to_hex
from numpy.typing import NDArray

from cablewright.apps import style
from cablewright.apps.pictures.path import error_scale
from cablewright.apps.quantities import quantity
from cablewright.apps.report.digest import Digest
from cablewright.apps.report.page import Html, bundled, element
from cablewright.apps.report.thinning import coarse_corners
from cablewright.arrays import Indices

_MAX_PIECES: Final = 18_000
_SPAN: Final = 10  # samples
_LEVELS: Final = 32
_PEN_UP: Final = 255
_STEPS: Final = 65_535  # of the grid that positions are rounded to, across the largest side


def canvas(digest: Digest) -> Html:
    """Return the view, its data and how it is used; nothing if nothing is extruded."""
    if len(digest.extruding) == 0:
        return Html("")
    data = json.dumps(_data(digest), separators=(",", ":"))
    for mark in "<>&":  # nothing in a name ends the element
        data = data.replace(mark, f"\\u{ord(mark):04x}")
    how = (
        "Click it, then drag to turn and roll the wheel to zoom, or use two fingers; or the arrow keys, + and \u2212, "
        "and 0 for the first view."
    )
    label = "The path in the frame, in three dimensions, coloured by the error without compensation"
    return element(
        "div",
        element("canvas", id="view", tabindex="0", role="img", aria_label=f"{label}. {how}"),
        element("p", f"The same, to turn. {how}", class_="soft"),
        Html(f'<script type="application/json" id="view-data">{data}</script>'),
        class_="interactive",
    )


def script() -> str:
    """Return the program that draws the view."""
    return bundled("viewer.js")


def _data(digest: Digest) -> dict[str, Any]:
    robot, samples = digest.check.robot, digest.check.samples
    scale = error_scale(digest)
    vertices, levels = _vertices(digest, scale.low, scale.high)
    points = samples.positions[vertices]
    origin = points.min(axis=0)
    step = max(float(np.ptp(points, axis=0).max()), 1e-9) / _STEPS
    grid = np.round((points - origin) / step).astype("<u2")
    ramp = style.error_colours()(np.linspace(0, 1, _LEVELS))
    worst = digest.worst
    return {
        "origin": [float(v) for v in origin],
        "step": step,
        "centre": [float(v) for v in (origin + points.max(axis=0)) / 2],
        "xyz": _packed(grid),
        "level": _packed(levels),
        "ramp": [to_hex(colour) for colour in ramp],
        "low": scale.low,
        "high": scale.high,
        "frame": [robot.scene.frame_min, robot.scene.frame_max],
        "lines": [
            {"name": line.name, "exit": line.exit_point, "end": None if worst is None else end}
            for line, end in zip(robot.lines, digest.line_ends.tolist(), strict=True)
        ],
        "worst": None if worst is None else [float(v) for v in samples.positions[worst]],
        "label": "" if worst is None else f"largest: {quantity(float(digest.check.error_uncompensated[worst]), 'm')}",
    }


def _vertices(digest: Digest, low: float, high: float) -> tuple[Indices, NDArray[np.uint8]]:
    """Return samples and the colour levels of the pieces that end there; a piece that does not go on lifts the pen."""
    pieces = coarse_corners(digest.check.samples, digest.extruding, _MAX_PIECES, _SPAN)
    lifted = np.append(True, pieces.begin[1:] != pieces.end[:-1])
    share = (digest.check.error_uncompensated[pieces.end] * 1e3 - low) / max(high - low, 1e-12)
    level = np.clip(share * _LEVELS, 0, _LEVELS - 1).astype(np.uint8)
    at = np.flatnonzero(lifted)
    return np.insert(pieces.end, at, pieces.begin[at]), np.insert(level, at, np.uint8(_PEN_UP))


def _packed(values: NDArray[Any]) -> str:
    return base64.b64encode(values.tobytes()).decode("ascii")
