"""The report of `cablewright check`: whether this robot can print this job, and how well."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np

from cablewright.analyses.accuracy.expected_error import ExpectedError
from cablewright.apps import style
from cablewright.apps.dark_pictures import themed
from cablewright.apps.figures import summary
from cablewright.apps.pictures.line_tensions import MAX_LINES, limits, tensions
from cablewright.apps.pictures.motion_errors import motion
from cablewright.apps.pictures.path_errors import MAX_NAMES, error_by_height, plan, side_view
from cablewright.apps.quantities import count, quantity
from cablewright.apps.report.check_summary import Digest
from cablewright.apps.report.document import verdict, view, write_report
from cablewright.apps.report.page import Html, Themed, cards, element, notice, picture, section, table
from cablewright.apps.report.provenance import assumptions, inputs_table, list_of
from cablewright.apps.report.result import along_table, key_figures, part_table
from cablewright.apps.report.worst_limits import findings_table
from cablewright.apps.web.check_scene import check_scene
from cablewright.foundation.errors import Status
from cablewright.foundation.memory_mapped import let_go
from cablewright.printing.layers import LayerTable
from cablewright.robot.uncertainty import ASSUMED
from cablewright.studies.checks.result import Check

Pictures = dict[str, Themed]

_SETTINGS: Final = (
    "max_expected_error", "bead_width", "bead_height", "bead_by", "uncertainty", "damping", "layers_by", "material_by",
    "samples", "shaped_from", "corner_deviation", "acceleration", "ignored_words",
)  # fmt: skip


def write(check: Check, folder: Path, layers: LayerTable) -> Path:
    """Write ``report.html`` and its pictures into ``folder``, which exists, and return the path of the report.

    The page holds its pictures and asks nothing of any other place. The same check gives the same bytes. Raises
    `EnvironmentFault` where the folder cannot be written.
    """
    digest = Digest(check, layers)
    pictures = _pictures(digest)
    title = f"Check of {check.job.name} on {check.robot.name}"
    return write_report(folder, title, _body(digest, title, pictures), pictures)


def _pictures(digest: Digest) -> Pictures:
    """Draw all pictures there is something to draw for."""
    drawn, kinds = {}, (plan, side_view, tensions, error_by_height, limits, motion)
    with style.drawing():
        for name, draw in zip(("plan", "path-3d", "tensions", "error-height", "limits", "motion"), kinds, strict=True):
            figure = draw(digest)
            if figure is not None:
                drawn[name] = themed(figure)
            let_go(digest.check)
    return drawn


def _body(digest: Digest, title: str, pictures: Pictures) -> Iterator[Html]:
    """Yield the page from the verdict to where everything came from."""
    yield element("h1", title)
    word, kind = ("Can be printed", "yes") if digest.check.feasible else ("Cannot be printed", "no")
    yield verdict(word, digest.check.verdict, kind=kind)
    turns = () if digest.check.robot.n == 6 else ("max_turn_uncompensated",)
    notes = {"expected error": f"at most {quantity(digest.check.allowed_error, 'm')} is allowed"}
    results = summary(digest.check, "feasible", "verdict", "not_checked", *turns, *_SETTINGS)
    yield cards((*each, notes.get(each[0], "")) for each in results)
    yield from _notices(digest)
    if digest.check.robot.m >= digest.check.robot.freedoms:
        yield section("The robot along the path", view(check_scene(digest.check)))
    yield section("Not checked", list_of(list(digest.check.not_checked)))
    yield section("Worst place of every limit", findings_table(digest))
    if digest.check.expected is not None and digest.check.expected.causes:
        yield section("Expected error, and what makes it", *_expected(digest.check, digest.check.expected))
    yield section("The path, and its error without compensation", *_path(digest, pictures))
    yield section("Tension of each line", *_tensions(digest, pictures))
    if "motion" in pictures:
        yield section("Error by motion", *_motion(digest.check, pictures))
    yield section("Error against height", *_errors(digest, pictures))
    yield section("Winches and sheaves", *_winches(digest, pictures))
    present = [each.key for each in digest.check.figures if each.key in _SETTINGS]
    settings = table(["setting", "value"], (each[:2] for each in key_figures(digest.check, present)))
    yield section("Inputs", inputs_table(digest), settings)
    yield section("What is assumed", list_of(assumptions(digest.check.robot)))


def _notices(digest: Digest) -> Iterator[Html]:
    """Yield notices that a reader needs before using a figure or picture: guesses, and samples that are left out."""
    yield from map(notice, digest.check.notes)
    total = count(len(digest.check.samples))
    for code, times in digest.unsolved():
        yield notice(f"at {count(times)} of {total} samples: {Status.of(code).value}")
    lost = int(np.isnan(digest.check.error_uncompensated).sum())
    if lost:
        yield notice(
            f"at {count(lost)} of {total} samples it is not known where the platform hangs without compensation; "
            "pictures of the error leave them out"
        )


def _expected(check: Check, expected: ExpectedError) -> Iterator[Html]:
    """Yield what the expected error is, its causes, and the ranges that it comes from."""
    source = "assumed, nothing was measured" if check.uncertainty == ASSUMED else f"given: {check.uncertainty}"
    yield element(
        "p",
        f"95 of 100 machines whose numbers are uncertain as below ({source}) keep the nozzle within "
        f"{quantity(expected.value, 'm')} of the whole path that lays material. The numbers are drawn once for the "
        "job, and each machine is solved. The motion of the platform comes on top.",
    )
    yield part_table(check, "expected_error_by")
    yield table(("uncertain number", "min", "max", "unit"), _ranges(expected), numbers=(1, 2))


def _ranges(expected: ExpectedError) -> Iterator[tuple[str, ...]]:
    for each in expected.ranges:
        yield each.parameter.label, f"{each.low:.6g}", f"{each.high:.6g}", each.parameter.unit


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


def _tensions(digest: Digest, pictures: Pictures) -> Iterator[Html]:
    m = digest.check.robot.m
    each = "in each layer" if digest.by_layer else "in each part of the path"
    if "tensions" in pictures:
        yield picture(
            pictures["tensions"],
            "Tension of the lines over the time of the print, with their limits",
            f"Band: from the lowest to the highest tension {each}, anywhere along the line, with the motion of the "
            "platform. Line: the "
            f"median at the sheave, at rest. Dashed: the line's tension limits.{_some(m)}",
        )
    else:
        yield element("p", "Not known: no equilibrium was found.")
    yield along_table(digest.check, "line")


def _motion(check: Check, pictures: Pictures) -> Iterator[Html]:
    assert check.motion is not None
    frequency, place = check.motion.frequency, check.where(check.motion.sample)
    yield element(
        "p",
        f"Where material is laid the platform swings the nozzle at most {quantity(check.motion.largest, 'm')} from the "
        f"path, at {frequency:.3g} Hz {place}; along 95 % of the length at most {quantity(check.motion.usual, 'm')}. "
        f"Damping of every mode: {check.robot.damping} of the critical.",
    )
    yield picture(
        pictures["motion"],
        "Error of the nozzle by the motion of the platform over the time of the print, and its frequency",
        "Moves that lay material. Above: largest and median in each part of the print. Below: frequency of the mode "
        "with most of the error, the median of each part. Rings: the largest error.",
    )


def _errors(digest: Digest, pictures: Pictures) -> Iterator[Html]:
    if "error-height" not in pictures:
        yield element("p", f"Not drawn: {digest.nothing_drawn}.")
        return
    yield picture(
        pictures["error-height"],
        "Error against the height of the nozzle, without and with partial compensation, and expected with full",
        "Moves that lay material. Full line: the median at that height; dotted: the largest. With full "
        "compensation the model meets the path. The rest is due to uncertain numbers; the curve is "
        "its root mean square.",
    )


def _winches(digest: Digest, pictures: Pictures) -> Iterator[Html]:
    some = f" The {MAX_LINES} lines with tensions nearest to their limits." if digest.check.robot.m > MAX_LINES else ""
    if "limits" in pictures:
        yield picture(
            pictures["limits"],
            "Winch speed and torque, swing and lever angle that each line used and may use",
            f"Blue: what the job uses, orange where that is outside. Pale, up to the marks: what is allowed.{some}",
        )


def _some(m: int) -> str:
    """Say that a picture leaves lines out, where it does."""
    return f" Of {m} lines, the {MAX_LINES} with tensions nearest to their limits are drawn." if m > MAX_LINES else ""
