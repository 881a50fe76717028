"""The page of `cablewright show`: a robot in 3-D, alone or with a job, a run or a log."""

from __future__ import annotations

from collections.abc import Iterator

from cablewright.apps.quantities import quantity
from cablewright.apps.report.document import document, view
from cablewright.apps.report.page import Html, element, section, table
from cablewright.apps.report.provenance import list_of, robot_rows
from cablewright.apps.web.scene import SceneDescription
from cablewright.robot import Robot


def show_page(scene: SceneDescription) -> str:
    """Return the page as HTML. It makes no request; the same scene gives the same text."""
    return document(scene.title, _body(scene))


def _body(scene: SceneDescription) -> Iterator[Html]:
    yield element("h1", scene.title)
    yield view(scene)
    yield section("Lines", _lines(scene.robot))
    yield section("The robot", table(("what", "value"), [row for row in robot_rows(scene.robot) if row[1]]))
    yield section("What is drawn", list_of(_drawn(scene)))


def _lines(robot: Robot) -> Html:
    head = ("line", "exit point", "platform point", "sheave", "tension limits", "breaking load")
    rows = [
        (
            line.name,
            _point(line.exit_point),
            _point(line.platform_point),
            line.sheave.kind
            if line.sheave.kind == "eyelet"
            else f"{line.sheave.kind}, {quantity(line.sheave.radius, 'm')}",
            f"{quantity(line.tension_limits[0], 'N')} to {quantity(line.tension_limits[1], 'N')}",
            quantity(line.cable.breaking_load, "N"),
        )
        for line in robot.lines
    ]
    return table(head, rows)


def _drawn(scene: SceneDescription) -> list[str]:
    robot, told = scene.robot, []
    if robot.platform.drawing and scene.drum is None:
        told.append(robot.platform.drawing)
    told.append("Free spans are catenaries of the line states; what lies between a winch and its sheave is straight.")
    if any(line.sheave.kind != "eyelet" for line in robot.lines):
        told.append("Sheaves have their radius and are turned as their line takes them; their width is not known.")
    return told


def _point(point: tuple[float, float, float]) -> str:
    return f"({', '.join(f'{value:.3f}' for value in point)}) m".replace("-", "\N{MINUS SIGN}")
