"""The report of `cablewright calibrate`: estimated values, their uncertainty, undetermined combinations."""

from __future__ import annotations

from collections.abc import Iterator

from cablewright.apps import style
from cablewright.apps.dark_pictures import themed
from cablewright.apps.pictures.calibration import correlation_picture, exits_picture, residuals_picture
from cablewright.apps.quantities import count, quantity
from cablewright.apps.report.document import document, verdict, view
from cablewright.apps.report.page import Html, Themed, cards, element, notice, picture, section, table
from cablewright.apps.report.provenance import list_of, program
from cablewright.apps.report.result import along_table, key_figures, part_table
from cablewright.apps.web.robot_scene import robot_scene
from cablewright.apps.web.scene import SceneBody, SceneDescription
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.plan import Known

Pictures = dict[str, Themed]


def calibration_page(found: Calibration, data: str) -> str:
    """Return the page as HTML; *data* names the file of the measurements. The same calibration gives the same text."""
    title = f"Calibration of {found.problem.robot.name}"
    return document(title, _body(found, title, data, _pictures(found)))


def _scene(found: Calibration, title: str) -> SceneDescription:
    """The robot that was found, and the poses of the measurements."""
    places = found.poses[:, :3]
    return robot_scene(found.robot, title).with_bodies(
        SceneBody("poses that were measured", "--estimate", points=places)
    )


def _pictures(found: Calibration) -> Pictures:
    if found.status != "ok":
        return {}
    with style.drawing():
        drawn = {
            "residuals": residuals_picture(found),
            "exits": exits_picture(found),
            "correlation": correlation_picture(found),
        }
        return {name: themed(figure) for name, figure in drawn.items() if figure is not None}


def _body(found: Calibration, title: str, data: str, pictures: Pictures) -> Iterator[Html]:
    yield element("h1", title)
    yield _verdict(found)
    yield cards(_figures(found))
    yield from map(notice, found.notes)
    if found.status == "ok":
        yield section("What the data leave open", *_open(found))
        yield section("The robot, and where it was measured", view(_scene(found, title)))
        sigmas = [f"{words[0].upper()}{words[1:]}." for words in (found.three_sigmas, found.sigma_advice) if words]
        yield section("Values", along_table(found, "unknown"), list_of(sigmas))
        yield section("Residuals of the lengths", *_residuals(found, pictures))
        yield section("How well exit points are known", *_exits(pictures))
        yield section("What one more measurement would bring", *_suggestions(found))
    yield section("Inputs", _inputs(found, data))
    yield section("What is assumed", list_of(_assumed(found)))


def _verdict(found: Calibration) -> Html:
    word, kind = {
        "good": ("Calibrated", "yes"), "doubtful": ("Doubtful", "doubt"), "bad": ("Not calibrated", "no")
    }[found.verdict]  # fmt: skip
    told = [each[0].upper() + each[1:] + "." for each in found.reasons]
    if found.verdict == "good":
        fits = f"lengths of {count(found.problem.poses)} poses fit to {quantity(found.rms, 'm')}"
        known = found.exit_sigma
        exits = f"Exit points are known to {quantity(known, 'm')} (one sigma) or better; " if known is not None else ""
        told = [f"{exits}{fits if exits else fits.capitalize()} rms."]
    if found.verdict == "doubtful" and found.accepted:
        told.append("It was accepted as it is.")
    return verdict(word, *told, kind=kind)


def _figures(found: Calibration) -> Iterator[tuple[str, str, str]]:
    spoiled = len({each.pose for each in found.rejected})
    given = found.problem.plan.sigma.encoder is not None
    notes = {
        "poses": f"{count(spoiled)} with something left out" if spoiled else "all are used",
        "rms": "of the lengths that are used",
        "encoder_sigma": "given" if given else "estimated from the residuals",
        "unknowns": "poses included",
        "iterations": f"best of {found.fit.starts} starts",
    }
    yield from key_figures(found, ("poses", "rms", "encoder_sigma", "unknowns", "rank", "iterations"), notes)


def _open(found: Calibration) -> Iterator[Html]:
    if found.gauge:
        yield element("p", "The measurements do not determine these combinations; the datum fixes them:")
        yield list_of(list(found.gauge))
    else:
        yield element("p", "Nothing: the data determine all unknowns.")
    held = ", ".join(found.problem.plan.datum)
    if held and held != "inner":
        yield element("p", f"Datum: {held} as in the robot file.")
    else:
        yield element("p", "Datum: inner. Exit points, as a whole, keep the place and direction of the robot file.")
    yield element("p", "The least known of the determined combinations:")
    yield part_table(found, "weakest")


def _residuals(found: Calibration, pictures: Pictures) -> Iterator[Html]:
    yield picture(
        pictures["residuals"],
        "Residual of each line's length at each pose",
        "One mark for each length that is used. Each pose absorbs as many errors as it has degrees of freedom, so "
        "residuals are smaller than the encoders' sigma.",
    )
    if found.rejected:
        yield part_table(found, "rejected")


def _exits(pictures: Pictures) -> Iterator[Html]:
    if "exits" in pictures:
        yield picture(
            pictures["exits"],
            "Exit points from above and from the side with their sigma ellipses, enlarged",
            "In the frame of the datum. Ellipses hold 39 % of the probability of two coordinates.",
        )
    if "correlation" in pictures:
        yield picture(
            pictures["correlation"],
            "Matrix of the correlations of all unknowns",
            "Dark: one of the two is known only as well as the other. Columns are in the order of the rows.",
        )
    if not pictures.keys() & {"exits", "correlation"}:
        yield element("p", "No picture: nothing to draw.")


def _suggestions(found: Calibration) -> Iterator[Html]:
    if not found.suggestions:
        yield element("p", "No suggestion: the sigma of the encoders is not known.")
        return
    yield element("p", "Sigma of the exit points' coordinates, rms, in the frame of the inner datum.")
    yield part_table(found, "suggestions")


def _inputs(found: Calibration, data: str) -> Html:
    plan, robot = found.problem.plan, found.problem.robot
    rows = [
        ("robot", robot.name),
        ("measurements", data),
        ("unknowns", ", ".join(plan.unknowns)),
        ("shared by all lines", ", ".join(plan.shared)),
        ("groups of lines", "; ".join(f"{each.name}: {', '.join(each.lines)}" for each in plan.groups)),
        ("datum", ", ".join(plan.datum) or "inner"),
        ("priors", ", ".join(f"{each.name} ±{each.deviation:g}" for each in plan.priors)),
        ("known", ", ".join(f"{each.name} {_said(each)}" for each in plan.known)),
        ("program", program()),
    ]
    return table(("what", "value"), [row for row in rows if row[1]])


def _said(known: Known) -> str:
    """Return value and standard deviation of a number that counts as known, as far as the plan gives them."""
    value = "" if known.value is None else f"{known.value:g}"
    return value + ("" if known.deviation is None else f" ±{known.deviation:g}")


def _assumed(found: Calibration) -> list[str]:
    lines = {
        "rigid": "Lines are straight and do not stretch; sheaves swivel about a vertical axis without friction.",
        "elastic": "Lines are straight and stretch; sheaves are as in the robot file, without friction.",
        "catenary": "Lines stretch and sag; sheaves are as in the robot file, without friction.",
    }
    begin = "the winch exit, unstrained" if found.problem.elastic else "the exit point"
    return [
        lines[found.problem.cable],
        "Errors of each kind of sensor are independent and normal, with one sigma for all lines and poses.",
        "Sigma is of the first order: where a tilt is known to a few degrees only, its errors are not normal.",
        f"Lengths count from {begin}; home lengths are those where counts are zero, whichever pose that is.",
    ]
