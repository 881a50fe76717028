"""Lines of G-code that move a virtual X Y Z, mm, and the winches, degrees of their drums, together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from cablewright.exchange.motion_export.non_motion_gcode import Beside
from cablewright.foundation.errors import printable
from cablewright.robot import Robot
from cablewright.studies.checks.winch_angles import WinchPath


def extent_notes(path: WinchPath, letters: Sequence[str], robot: Robot, extruded: str, mark: str = "; ") -> str:
    """Return comments that describe the file: points, error, the line of each letter, and the meaning of E."""
    text = f"{mark}{len(path.samples)} points; lengths between them are good to {1e6 * path.error:.3g} um\n"
    text += f"{mark}X Y Z: the nozzle, mm; winches: degrees of the drum, positive pays out; {extruded}\n"
    for letter, line, length in zip(letters, robot.winch_lines, path.lengths[0], strict=True):
        text += f"{mark}{letter} is line {printable(line.name)}, {length:.6f} m long at the first point\n"
    return text


def motion_lines(
    path: WinchPath, letters: Sequence[str], besides: Beside, *, extruder: bool, mark: str = "; "
) -> Iterator[str]:
    """Yield the G-code lines that move to each point but the first, with the line number of the job's file.

    Between them are those that *besides* has of the file, each before the first point of a later line.
    """
    samples, angles = path.samples, np.degrees(path.turns)
    millimetres, laid, feeds = 1e3 * samples.positions, 1e3 * path.laid, besides.feeds
    layer, feed, pending = -1, 0.0, besides.lines()
    number, other = next(pending, (1 << 62, ""))
    for k in range(1, len(samples)):
        while number <= samples.line[k]:
            yield other
            feed = 0.0 if other.startswith("G1 E") else feed
            number, other = next(pending, (1 << 62, ""))
        if samples.layer[k] != layer:
            layer = int(samples.layer[k])
            if not besides.has_layers:
                yield f"{mark}LAYER:{layer}\n"
        x, y, z = millimetres[k]
        words = [f"X{x:.4f} Y{y:.4f} Z{z:.4f}"]
        words += [
            f"{letter}{angle:.6f}" for letter, angle in zip(letters, angles[k], strict=False)
        ]  # none of a job in X Y Z
        if extruder and feeds is not None:
            words += [f"E{feeds[k]:.5f}"] if feeds[k] else []
        elif extruder and samples.extruding[k]:
            words.append(f"E{laid[k]:.4f}")
        speed = 6e4 * float(samples.speed_limit[k])
        if speed != feed:
            words.append(f"F{speed:.3f}")
            feed = speed
        yield f"{'G1' if samples.extruding[k] else 'G0'} {' '.join(words)} {mark}line {samples.line[k]}\n"
        if samples.dwell[k] > 0.0:
            yield f"G4 P{1e3 * samples.dwell[k]:.0f}\n" if extruder else f"G4 P{samples.dwell[k]:.3f}\n"
    if number < 1 << 62:
        yield other
    yield from (other for _, other in pending)


def extruder_words(besides: Beside) -> tuple[str, str, str]:
    """Return the code for E, the word that sets it to zero, and the meaning of E in words."""
    if besides.feeds is not None:
        return "M83", "", "E: mm of filament, each line its own"
    return "M82", " E0", "E: mm of strand laid"
