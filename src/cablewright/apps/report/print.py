"""The report of `cablewright print`: the printed part, its errors, and their meaning for the machine."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np

from cablewright.apps import style
from cablewright.apps.dark_pictures import themed
from cablewright.apps.figures import NONE
from cablewright.apps.pictures.print import (
    drum_picture,
    errors_picture,
    path_picture,
    speed_picture,
    states_picture,
    steps_picture,
)
from cablewright.apps.pictures.print_lines import angles_picture, coiling_picture, ringing_picture, tensions_picture
from cablewright.apps.pictures.print_structure import cuts_picture, maps_picture
from cablewright.apps.quantities import count, duration, quantity
from cablewright.apps.report.document import verdict, view, write_report
from cablewright.apps.report.page import Html, Themed, cards, element, notice, picture, section
from cablewright.apps.report.print_tables import (
    faults_table,
    following_table,
    inputs_table,
    lines_table,
    paper_table,
    states_table,
    structure_table,
)
from cablewright.apps.report.provenance import list_of
from cablewright.apps.report.result import key_figures
from cablewright.apps.web.print_scene import print_scene, structure_mesh
from cablewright.foundation.arrays import Array
from cablewright.foundation.file_output import write_whole
from cablewright.live.prints.result import PrintRecord
from cablewright.machine.sensors.line_angles import LINE_ANGLES

Pictures = dict[str, Themed]

_CARDS: Final = (
    "layers", "distance", "duration", "mean_path_error", "max_path_error", "max_height_error", "max_error_in_space",
    "estimated_max_path_error", "mean_speed", "barrier_stops", "refills",
)  # fmt: skip

_OF_BODY: Final = ("position_rms", "position_max", "orientation_max", "min_tension_margin")


def write(found: PrintRecord, folder: Path, name: str, step_times: Array | None = None) -> Path:
    """Write ``report.html``, its pictures and the structure's meshes into *folder*, which exists; return the report.

    *name*: name of the job. *step_times*: durations (k,) of the steps of control, s. The page holds its pictures and
    needs no other file. Raises `EnvironmentFault` where the folder cannot be written.
    """
    pictures = _pictures(found, step_times)
    if found.structure is not None and found.structure.best is not None:
        mesh = structure_mesh(found.structure.best, found)
        write_whole(folder / "structure.stl", mesh.stl())
        write_whole(folder / "structure.glb", mesh.glb())
    title = f"Print of {name} on {found.head.robot.name}"
    return write_report(folder, title, _body(found, title, name, pictures), pictures)


def _pictures(found: PrintRecord, step_times: Array | None) -> Pictures:
    """Draw all pictures there is something to draw for."""
    with style.drawing():
        drawn = {
            "path": path_picture(found),
            "errors": errors_picture(found),
            "speed": speed_picture(found),
            "drum": drum_picture(found),
            "angles": angles_picture(found),
            "tensions": tensions_picture(found),
            "coiling": coiling_picture(found),
            "ringing": ringing_picture(found),
            "structure": maps_picture(found),
            "cuts": cuts_picture(found),
            "states": states_picture(found),
            "steps": None if step_times is None or not len(step_times) else steps_picture(step_times),
        }
        return {name: themed(figure) for name, figure in drawn.items() if figure is not None}


def _body(found: PrintRecord, title: str, name: str, pictures: Pictures) -> Iterator[Html]:
    yield element("h1", title)
    yield _verdict(found)
    yield cards(_cards(found))
    yield from map(notice, found.notes)
    scene = print_scene(found, title)
    if scene is not None:
        yield section("The machine along the path", view(scene))
    yield section("Path errors", following_table(found), *_shown(pictures, "path", "errors"))
    paper = paper_table(found)
    if paper is not None:
        yield section("Beside the paper", paper)
    yield section("Speed", *_shown(pictures, "speed"))
    yield section("States", states_table(found), *_shown(pictures, "states", "steps"))
    if found.structure is not None:
        yield section("The structure", structure_table(found.structure), *_shown(pictures, "structure", "cuts"))
    yield section(f"Yaw and tilt of the {found.head.settings.carrier.WORD}", *_shown(pictures, "drum"))
    yield section("Lines: load and slack", lines_table(found), *_shown(pictures, "angles", "tensions"))
    yield section("Lines: wear", *_wear(found, pictures))
    yield section("Faults and notices", faults_table(found))
    yield section("Inputs", inputs_table(found, name))
    yield section("Definitions", list_of(_definitions(found)))


def _verdict(found: PrintRecord) -> Html:
    total = len(np.unique(found.track.visits.number[found.track.visits.number > 0]))
    whole = found.layers >= total
    layers = f"all {count(total)} layers" if whole else f"{count(found.layers)} of {count(total)} layers"
    best = found.best
    if best.error.count:
        whose = "" if found.has_truth else " by the estimation"
        beside, height, space = (quantity(each.size, "m") for each in (best.error, best.height, best.space))
        rms = quantity(math.hypot(best.space.mean, best.space.deviation), "m")
        sentence = (
            f"{layers[0].upper()}{layers[1:]} in {duration(found.duration)}: the largest distance from the path was "
            f"{space}, rms {rms}; at most {beside} beside it, and {height} above or below{whose}."
        )
    else:
        sentence = f"{layers}; the position of the platform is not known."
    word, kind = ("Printed", "yes") if whole else ("Not finished", "no")
    return verdict(word, sentence, kind=kind)


def _cards(found: PrintRecord) -> list[tuple[str, str, str]]:
    """Labels and values of the main figures: true ones where they are known."""
    without_truth = () if found.has_truth else ("estimated_mean_path_error", "estimated_mean_speed")
    of_body = _OF_BODY if found.head.robot.n == 6 else ()
    made = list(key_figures(found, (*_CARDS, *of_body, *without_truth)))
    if found.structure is not None:
        made += key_figures(found.structure, ("mass", "max_height"))
    return [each for each in made if each[1] != NONE]


def _shown(pictures: Pictures, *names: str) -> Iterator[Html]:
    drawn = [name for name in names if name in pictures]
    for name in drawn:
        yield picture(pictures[name], *_CAPTIONS[name])
    if not drawn:
        yield element("p", "Not drawn: the log does not have the data.")


def _wear(found: PrintRecord, pictures: Pictures) -> Iterator[Html]:
    if "coiling" in pictures:
        yield picture(pictures["coiling"], *_CAPTIONS["coiling"])
    if "ringing" in pictures:
        yield picture(pictures["ringing"], *_CAPTIONS["ringing"])
    else:
        rate = found.head.settings.sensor(LINE_ANGLES)
        why = (
            "the machine has no sensors on its lines"
            if rate is None
            else "no window of 20 s had a peak that stands out"
        )
        yield element("p", f"No frequency of a line is known: {why}, or the readings are too few for it.")


_CAPTIONS = {
    "path": (
        "The path from above, coloured by how far beside it the platform was",
        "Where layers lie on each other, the largest error is drawn. Two steps in a thousand are beyond the scale.",
    ),
    "errors": (
        "Error beside the path along some layers, and mean, sigma and extremes of each",
        "Seen from above, positive left of the path, while printing.",
    ),
    "speed": (
        "Histogram of the speed along the path, and the speed over time",
        "Dashed: the job's print speed; corners, and a G-code's own feeds, are slower.",
    ),
    "states": ("States over time, and distance along the path", "Very short states are drawn longer than they were."),
    "steps": (
        "Histogram of how long the steps of control took",
        "Estimation, control, supervision and log of one step; the simulated machine does not count.",
    ),
    "structure": (
        "Height maps from above: true, rebuilt from scans, and their difference",
        "Rebuilt from vertical scans of the last two layers, one each 2 s. White: not seen.",
    ),
    "cuts": (
        "Heights across the path at two places",
        "Left: where no other pass of the layer is near. Right: where the structure is highest.",
    ),
    "drum": ("Yaw and tilt of the drum over time", "As Figs. 5 and 6 of Merlet and Papegay 2023."),
    "angles": (
        "Measured angle and that of a taut line: of the line that is taut most of the time, and of the one least",
        "As Fig. 7 of Merlet and Papegay 2023, of the last whole layer: a line is slack where the two part.",
    ),
    "tensions": (
        "Tension of each line in the last whole layer",
        "Estimated: the tensions of three lines that hold the drum while no other line is taut.",
    ),
    "coiling": (
        "Radius at which cable leaves each winch drum against the length paid out",
        "As Fig. 9 of Merlet and Papegay 2023. Dashed: a drum that is wound evenly.",
    ),
    "ringing": (
        "First frequency of each line over time and its ratio to a string's against the temperature",
        "By the accelerometers on taut lines, in windows of 20 s in which a peak stands out.",
    ),
}


def _definitions(found: PrintRecord) -> list[str]:
    made = [
        "Path errors are distances beside the path, seen from above; left of the path is positive.",
        "Only steps that printed count.",
        "Means and variances are of every step; pictures are of at most 20 000 steps, evenly chosen.",
        "A line is slack where its excess over the taut length is over 2.5 mm.",
        "A coil is irregular by the standard deviation of its radius from an even coil, less a straight line.",
    ]
    if found.has_truth:
        made.insert(1, "True is what the simulated machine did; estimated is what its controller had from its sensors.")
    return made
