"""Draw the pictures of ``docs/slack.md`` again: ``python tools/slack_pictures.py``."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from cablewright.apps import style
from cablewright.apps.pictures.slack import angle_over_excess, let_out_picture
from cablewright.models.statics import Model
from cablewright.robot import Eyelet, load
from cablewright.solvers.inverse import inverse
from cablewright.solvers.slack import angle_from_excess, let_out

IMAGES = Path(__file__).resolve().parent.parent / "docs" / "images"
LINE = "north-west"
SPAN, DISTANCE = 2.5, 0.2  # m: the cable and the sensor of Merlet's Fig. 8
SAID = (0.01, math.radians(12.45), "Merlet 2023, text")


def draw_let_out() -> bytes:
    """One line of four is let out and reeled in while the others keep their lengths."""
    robot = load("merlet2023")
    by = np.linspace(-0.02, 0.02, 401)
    found = let_out(Model(robot), inverse(robot, [0.0, -1.0, 1.0]).lengths, LINE, by)
    return style.png(let_out_picture(found, by, LINE))


def draw_angles() -> bytes:
    """A line of Merlet's Fig. 8 at some elevations: how far a sensor near the platform turns."""
    robot = load("merlet2023")
    line = robot.lines[0].model_copy(update={"sheave": Eyelet(), "winch_exit": None})
    model = Model(robot.model_copy(update={"lines": (line,)}))
    excess = np.append(0.0, np.geomspace(1e-5, 0.1, 200))
    angles = {}
    for elevation in (0, 45, 80):
        across, down = SPAN * math.cos(math.radians(elevation)), SPAN * math.sin(math.radians(elevation))
        x, y, z = line.exit_point
        found = angle_from_excess(model, [x + across, y, z - down], line.name, DISTANCE, excess)
        angles[f"line falls by {elevation}°"] = found + math.radians(elevation)
    return style.png(angle_over_excess(excess, angles, SAID))


def main() -> None:
    """Write the pictures."""
    with style.drawing():
        (IMAGES / "slack-let-out.png").write_bytes(draw_let_out())
        (IMAGES / "slack-angle.png").write_bytes(draw_angles())


if __name__ == "__main__":
    main()
