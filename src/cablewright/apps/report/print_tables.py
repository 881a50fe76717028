"""Tables of a print's report."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from cablewright.apps.figures import NONE, Sheet, columns, pairs, table, text
from cablewright.apps.quantities import count, quantity
from cablewright.apps.report.page import Html, element
from cablewright.apps.report.provenance import program
from cablewright.apps.report.result import sheet_table
from cablewright.foundation.arrays import Array
from cablewright.foundation.results import Figure
from cablewright.live.prints.result import LineUse, PathFollowing, PrintRecord, StateUse
from cablewright.live.prints.structure import PrintedStructure

_MAX_FAULTS: Final = 40
_OF_THE_PAPER: Final = "merlet2023"
_PAPER: Final = {
    "mean_path_error": "-0.26 mm", "path_error_variance": "7.74 mm^2", "max_path_error": "48.2 mm",
    "mean_speed": "30.168 mm/s", "speed_variance": "2.667 mm^2/s^2",
}  # fmt: skip
_RECORD: Final = {"layers": "142 (or 146)", "travelled": "about 9 km", "duration": "126 h", "barrier_stops": "24"}
_OF_MACHINE: Final = ("print_speed", "yaw", "tilt", "temperature", "humidity")
_HEIGHT: Final = Figure("height", "m", "Largest height of a cross-section.", shown="cm")
_TAUT: Final = next(each for each in LineUse.FIGURES if each.key == "taut")


def following_table(found: PrintRecord) -> Html:
    """Return the table of error, height and speed: true, and by the estimates."""
    both = {name: of for name, of in (("true", found.true), ("estimated", found.estimated)) if of.error.count}
    if not both:
        return element("p", "Not known: no step in the log printed with a known position.")
    rows = pairs(PathFollowing.FIGURES, *both.values())
    return sheet_table(Sheet("", ("while printing", *both), rows, (False, *(True for _ in both))))


def paper_table(found: PrintRecord) -> Html | None:
    """Return the figures of Merlet and Papegay 2023 beside those of this print; None for another robot."""
    if found.head.robot.name != _OF_THE_PAPER:
        return None
    structure = found.structure
    rows: list[tuple[str, ...]] = [
        (each.label, _PAPER[each.key], text(each, each.of(found.true)), text(each, each.of(found.estimated)))
        for each in PathFollowing.FIGURES
        if each.key in _PAPER
    ]
    rows += [
        (each.label, _RECORD[each.key], text(each, each.of(found)), "") for each in found.figures if each.key in _RECORD
    ]
    if structure is not None:
        mass = next(each for each in structure.figures if each.key == "mass")
        rows.append(("powder", "2.56 t", text(mass, structure.mass), text(mass, structure.estimated_mass)))
        for cut, theirs in zip(structure.sections, ("9 cm", "18 cm"), strict=True):
            heights = (text(_HEIGHT, _top(values)) for values in (cut.true, cut.estimated))
            rows.append((f"height {cut.title}", theirs, *heights))
    taut = (text(_TAUT, [getattr(line, key) for line in found.lines]) for key in ("true_taut", "taut"))
    rows.append(("taut, by line", "75, 100, 52, 30 %", *taut))
    note = (
        "Theirs are of the whole exhibition and as their lidars saw it; the heights are of 1.7 t. They print the "
        "variances in cm, and without a unit. Their lines are numbered: the order is that of the robot file."
    )
    head = ("", "Merlet, Papegay 2023", "here, true", "here, estimated")
    made = sheet_table(Sheet("", head, rows, (False, True, True, True)))
    return element("div", made, element("p", note, class_="soft"))


def _top(values: Array) -> float:
    return float(values[np.isfinite(values)].max()) if np.isfinite(values).any() else math.nan


def states_table(found: PrintRecord) -> Html:
    """Return the table of the time in each state of a print, with reasons."""
    return sheet_table(table("", StateUse.FIGURES, found.state_uses()))


def structure_table(structure: PrintedStructure) -> Html:
    """Return the table of mass and height, and the difference between the scanned and the true structure."""
    rows = [row for row in pairs(PrintedStructure.FIGURES, structure) if row[1] != NONE]
    return sheet_table(Sheet("", ("what", "value"), rows, (False, True)))


def lines_table(found: PrintRecord) -> Html:
    """Return the table of load and motion of each line."""
    return sheet_table(table("", LineUse.FIGURES, found.lines))


def faults_table(found: PrintRecord) -> Html:
    """Return the table of faults of the estimation, and of notices of the machine."""
    if not found.faults and not found.notices:
        return element("p", "The estimation reported no faults, and the machine nothing else.")
    faults, notices = (next(each for each in found.figures if each.key == key) for key in ("faults", "notices"))
    reported = table("", faults.parts, list(found.faults.items())[:_MAX_FAULTS])
    noticed, steps = zip(*found.notices.most_common(_MAX_FAULTS), strict=True) if found.notices else ((), ())
    of_machine = columns("", [(Figure("notice", "", "Notice of the machine."), noticed), (notices, steps)])
    return element("div", *(sheet_table(each) for each in (reported, of_machine) if each.rows))


def inputs_table(found: PrintRecord, name: str) -> Html:
    """Return the table of a print's inputs: robot, machine, job, program."""
    head = found.head
    rows = [
        ("robot", head.robot.name),
        ("machine", f"{head.settings.name}, {head.origin}"),
        *([("as built", f"{head.severity}: {head.built}")] if head.severity else []),
        ("job", name),
        ("path", f"{quantity(found.track.length, 'm')} in {count(len(found.track.visits.begin))} visits of layers"),
        ("step", f"{quantity(head.period, 's')}, {count(found.steps)} steps"),
        *pairs((each for each in found.figures if each.key in _OF_MACHINE), found),
        ("program", program()),
    ]
    return sheet_table(Sheet("", ("what", "value"), rows, (False, False)))
