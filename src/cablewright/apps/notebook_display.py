"""Display of values in notebooks: tables of a result, and a robot in 3-D."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Final

from cablewright.apps.figures import sheets, summary
from cablewright.apps.report.page import Html, element, join, table
from cablewright.apps.report.result import sheet_table
from cablewright.foundation.data_frames import columns_of
from cablewright.foundation.errors import InputError
from cablewright.foundation.file_output import write_whole
from cablewright.foundation.results import Pictured, Result
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot

if TYPE_CHECKING:
    from cablewright.apps.web.scene import SceneDescription

_MOST_ROWS: Final = 12  # of a batch that a notebook shows


def result_html(found: Result) -> str:
    """Return the figures of a result as tables, or of a batch its first rows."""
    parts = [element("strong", type(found).__name__)]
    if getattr(found, "single", True) is False:
        columns = columns_of(found)
        count = max(map(len, columns.values()), default=0)
        rows = [[_number(values[k]) for values in columns.values()] for k in range(min(count, _MOST_ROWS))]
        parts += [table(tuple(columns), rows, numbers=range(len(columns)))]
        parts += [element("p", f"{count} rows, of which {len(rows)} are shown")] if count > len(rows) else []
        return join(parts)
    parts.append(table(("figure", "value"), [(label, _lines(value)) for label, value in summary(found)]))
    for sheet in sheets(found):
        parts += [element("em", sheet.title)] if sheet.title else []
        parts.append(sheet_table(sheet))
    return join(parts)


def _number(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _lines(value: str) -> Html:
    return join(value.split("\n"), "<br>")


@dataclass(frozen=True, eq=False, repr=False)
class View:
    """A robot in 3-D: in a notebook a frame, elsewhere a self-contained page."""

    scene: SceneDescription
    height: int  # pixels of the frame

    def page(self) -> str:
        """Return the page of the view as HTML. It makes no request; the same scene gives the same text."""
        from cablewright.apps.report.show import show_page

        return show_page(self.scene)

    def save(self, file: str | Path) -> None:
        """Write the page of the view.

        Raises `InputError` for an ending other than .html, `EnvironmentFault` for a failed write.
        """
        if Path(file).suffix.lower() != ".html":
            raise InputError(f"view = {str(file)!r}: expected a name that ends in .html")
        write_whole(Path(file), self.page().encode("utf-8"))

    def _repr_html_(self) -> str:
        look = f"width: 100%; height: {self.height}px; border: 0"
        return f'<iframe srcdoc="{escape(self.page())}" style="{look}" title="{escape(self.scene.title)}"></iframe>'

    def __repr__(self) -> str:
        """Name and number of states in one line."""
        return f"View({self.scene.title!r}, states={len(self.scene.states)})"


def view(what: Robot | Model | Result, *, height: int = 640) -> View:
    """Return a view to turn of a robot at rest, of a solved pose, or of a result that has a robot.

    *height*: pixels of its frame in a notebook. `View.save` writes it as a page of its own. Raises `InputError` for a
    batch, and for a result without a robot.

    Examples
    --------
    >>> import cablewright as cw
    >>> cw.view(cw.inverse(cw.load("merlet2023"), [0.0, 0.0, 1.0]))
    View('merlet2023', states=1)
    """
    from cablewright.apps.web.robot_scene import one_state, robot_scene, scene_of

    if not 100 <= height <= 4000:
        raise InputError(f"height = {height}: must be from 100 to 4000 pixels")
    if isinstance(what, Equilibrium):
        if not what.single:
            raise InputError("view: a batch has no view; take one of its rows")
        note = "at rest: an equilibrium" if what.ok else f"not in equilibrium: {what.sentence()}"
        return View(one_state(what, what.model.robot.name, note), height)
    if isinstance(what, Robot | Model):
        return View(robot_scene(what), height)
    scene = scene_of(what, type(what).__name__) if isinstance(what, Pictured) else None
    if scene is None:
        raise InputError(f"view: {type(what).__name__} has no robot to show")
    return View(scene, height)
