"""The report of `cablewright check`: can this robot print this job, and how well, for those who build and run it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from cablewright.analyses.accuracy.compensation import COMPENSATIONS
from cablewright.apps import style
from cablewright.apps.pictures.error import error_by_height
from cablewright.apps.pictures.lines import MAX_LINES, limits, tensions
from cablewright.apps.pictures.path import MAX_NAMES, plan, side_view
from cablewright.apps.quantities import count, duration, quantity
from cablewright.apps.report.digest import Digest, extreme, median
from cablewright.apps.report.findings import findings_table
from cablewright.apps.report.page import Html, cards, element, page, picture, section
from cablewright.apps.report.per_line import line_table, unknowns
from cablewright.apps.report.provenance import assumptions, inputs_table, list_of
from cablewright.apps.report.viewer import canvas, script
from cablewright.errors import Status
from cablewright.file_output import write_whole
from cablewright.printing.layers import LayerTable
from cablewright.studies.check import Check

Pictures = dict[str, bytes]


def write(check: Check, folder: Path, layers: LayerTable) -> Path:
    """Write ``report.html`` and its pictures into ``folder``, which exists, and return the path of the report.

    The page holds its pictures and asks nothing of any other place. The same check gives the same bytes. Raises
    `EnvironmentFault` where the folder cannot be written.
    """
    digest = Digest(check, layers)
    pictures = _pictures(digest)
    for name, png in pictures.items():
        write_whole(folder / f"{name}.png", png)
    title = f"Check of {check.job.name} on {check.robot.name}"
    report = folder / "report.html"
    write_whole(report, page(title, _body(digest, title, pictures), script()).encode("utf-8"))
    return report


def _pictures(digest: Digest) -> Pictures:
    """Draw all pictures there is something to draw for."""
    with style.drawing():
        drawn = {
            "plan": plan(digest),
            "path-3d": side_view(digest),
            "tensions": tensions(digest),
            "error-height": error_by_height(digest),
            "limits": limits(digest),
        }
        return {name: style.png(figure) for name, figure in drawn.items() if figure is not None}


def _body(digest: Digest, title: str, pictures: Pictures) -> Iterator[Html]:
    """Yield the page from the verdict to where everything came from."""
    yield element("h1", title)
    yield _verdict(digest.check)
    yield cards(_key_figures(digest))
    yield from _notices(digest)
    yield section("Worst place of every limit", findings_table(digest))
    yield section("The path, and how far off it is without compensation", *_path(digest, pictures))
    yield section("Tension of each line", *_tensions(digest, pictures))
    yield section("Error against height", *_errors(digest, pictures))
    yield section("Winches and sheaves", *_winches(digest, pictures))
    yield section("What went in", inputs_table(digest))
    yield section("What is assumed", list_of(assumptions(digest.check.robot)))


def _verdict(check: Check) -> Html:
    word = "Can be printed" if check.feasible else "Cannot be printed"
    kind = "yes" if check.feasible else "no"
    return element("div", element("strong", word), element("p", check.verdict), class_=f"verdict {kind}", role="status")


def _key_figures(digest: Digest) -> Iterator[tuple[str, str, str]]:
    """Yield what, how much and a note. Errors are those of the whole path, travel moves too."""
    check, lines = digest.check, digest.check.statics.lines

    def largest(error: np.ndarray) -> str:
        return quantity(extreme(error, highest=True), "m")

    middle = quantity(float(median(check.error_uncompensated)), "m")
    yield "layers", count(check.layer_count), ""
    yield "extruded length", quantity(check.samples.extruded_length, "m"), ""
    yield "duration", duration(check.law.duration), ""
    yield f"error {COMPENSATIONS['none'].words}", largest(check.error_uncompensated), f"largest; median {middle}"
    yield f"error {COMPENSATIONS['full'].words}", largest(check.error_compensated), "largest, of the model itself"
    yield f"error {COMPENSATIONS['elastic'].words}", largest(check.error_elastic_only), "largest"
    if check.robot.n == 6:
        yield "turn without compensation", quantity(extreme(check.turn_uncompensated, highest=True), "rad"), "largest"
    yield "lowest tension", quantity(extreme(lines.lowest_tension, highest=False), "N"), ""
    yield "highest tension", quantity(extreme(lines.highest_tension, highest=True), "N"), ""
    yield "highest winch speed", quantity(extreme(lines.winch_speed, highest=True), "m/s"), "of the cable"
    torque = extreme(lines.winch_torque, highest=True)
    note = "the robot file gives no drum radius" if np.isnan(torque) else "at the drum"
    yield "highest winch torque", quantity(torque, "N m"), note


def _notices(digest: Digest) -> Iterator[Html]:
    """Yield what a reader has to know before trusting a picture: samples that it leaves out."""
    total = count(len(digest.check.samples))
    for code, times in digest.unsolved():
        yield element("p", f"At {count(times)} of {total} samples: {Status.of(code).value}.", class_="notice")
    lost = int(np.isnan(digest.check.error_uncompensated).sum())
    if lost:
        told = f"At {count(lost)} of {total} samples nothing tells where the platform hangs without compensation"
        yield element("p", f"{told}; pictures of the error leave them out.", class_="notice")


def _path(digest: Digest, pictures: Pictures) -> Iterator[Html]:
    m = digest.check.robot.m
    yield picture(
        pictures["plan"],
        "The extruded path seen from above, within the frame, coloured by its error",
        "From above, moves that lay material. Grey: the frame; squares: where the lines leave their mountings. Where "
        "layers lie on each other, the largest error is drawn.",
    )
    some = f"{MAX_NAMES} of the {m}" if m > MAX_NAMES else "the"
    yield picture(
        pictures["path-3d"],
        "The extruded path seen from a corner, with the frame and the lines",
        f"The same from a corner, with {some} lines to the place of the largest error.",
    )
    yield canvas(digest)


def _tensions(digest: Digest, pictures: Pictures) -> Iterator[Html]:
    m = digest.check.robot.m
    each = "in each layer" if digest.by_layer else "in each part of the path"
    if "tensions" in pictures:
        yield picture(
            pictures["tensions"],
            "Tension of the lines over the time of the print, with their limits",
            f"Band: from the lowest to the highest tension {each}, anywhere along the line, compensated. Line: the "
            f"median at the sheave. Dashed: the line's tension limits.{_some(m)}",
        )
    else:
        yield element("p", "Not known: no equilibrium was found.")
    yield line_table(digest)


def _errors(digest: Digest, pictures: Pictures) -> Iterator[Html]:
    if "error-height" not in pictures:
        yield element("p", f"Not drawn: {digest.nothing_drawn}.")
        return
    yield picture(
        pictures["error-height"],
        "Error against the height of the nozzle, without, with partial and with full compensation",
        "Moves that lay material. Full line: the median at that height; dotted: the largest. What is left after full "
        "compensation is that of the model and its solver, not of a machine.",
    )


def _winches(digest: Digest, pictures: Pictures) -> Iterator[Html]:
    some = f" The {MAX_LINES} lines with tensions nearest to their limits." if digest.check.robot.m > MAX_LINES else ""
    if "limits" in pictures:
        yield picture(
            pictures["limits"],
            "Winch speed and torque, swing and lever angle that each line used and may use",
            f"Blue: what the job uses, orange where that is outside. Pale, up to the marks: what is allowed.{some}",
        )
    missing = unknowns(digest)
    if missing:
        yield list_of(missing)


def _some(m: int) -> str:
    """Say that a picture leaves lines out, where it does."""
    return f" Of {m} lines, the {MAX_LINES} with tensions nearest to their limits are drawn." if m > MAX_LINES else ""
