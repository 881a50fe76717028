"""`show`: a robot to look at in a browser, alone or with a job, a run or a log."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

import typer

from cablewright.apps.cli.options import AsJson, Pose, Retraction, RobotOptions
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import check_suffix, pose_of
from cablewright.errors import InputError
from cablewright.results import Figure, Result

if TYPE_CHECKING:
    from cablewright.apps.web.scene import SceneDescription
    from cablewright.progress import Progress


@dataclass(frozen=True, kw_only=True)
class ShowCommand:
    """Writes one HTML file that needs no other. Without a job, the robot is at rest near the middle of its frame.

    WHAT is a job (TOML or G-code), the run folder of a check or a print, or a machine's log (MCAP). Lines hang as the
    statics of the robot file have them; nothing is judged, `check` does that.
    """

    EXAMPLE: ClassVar = "show jung2020"
    ANSWERS: ClassVar = ("apps.cli.show:Shown",)

    robot: RobotOptions
    what: Annotated[
        Path | None, typer.Argument(metavar="[WHAT]", help="Job, run folder or log; without it, the robot alone.")
    ] = None
    at: Pose = None
    retraction: Retraction = None
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE.html", help="Page; by default runs/show-ROBOT[-WHAT].html.")
    ] = None
    png: Annotated[Path | None, typer.Option("--png", metavar="FILE.png", help="Write a picture as well.")] = None
    open_page: Annotated[bool, typer.Option("--open", help="Open the page in the browser.")] = False
    as_json: AsJson = False

    def __post_init__(self) -> None:
        """Refuse other kinds of files before any work. Raises `InputError`."""
        check_suffix(self.out, "--out", ".html")
        check_suffix(self.png, "--png", ".png")
        if self.what is not None and (self.at is not None or self.retraction is not None):
            raise InputError("--at and --retraction are for the robot alone: leave them out with a job, a run or a log")

    def run(self) -> int:
        """Draw, write and print."""
        from cablewright.apps.report.show import show_page
        from cablewright.file_output import write_whole
        from cablewright.studies.store import folder_name

        with progress() as report:
            scene = self.scene(report)
        names = (scene.robot.name,) if self.what is None else (scene.robot.name, self.what.stem)
        page = self.out or Path("runs") / f"{folder_name('show', *names)}.html"
        text = show_page(scene).encode("utf-8")
        if self.out is None:
            page.parent.mkdir(exist_ok=True)
        write_whole(page, text)
        if self.png is not None:
            from cablewright.apps.web.png import scene_png

            write_whole(self.png, scene_png(scene))
        if self.open_page:
            typer.launch(str(page))
        return answer(Shown(scene, len(text)), self.as_json, report=page, plot=self.png)

    def scene(self, report: Progress) -> SceneDescription:
        """What is to be drawn. Raises `InputError`."""
        robot = self.robot.loaded(self.retraction)
        if self.what is None:
            return self._robot_alone()
        if self.what.is_dir() and (self.what / "samples.parquet").is_file():
            from cablewright.apps.web.check_scene import check_folder_scene
            from cablewright.studies.store import read_manifest, robot_hash

            inputs = (read_manifest(self.what) or {}).get("inputs")
            if not isinstance(inputs, dict) or inputs.get("robot") != robot_hash(self.robot.robot):
                raise InputError(f"{self.what}: is of another robot than {self.robot.robot}, or its file has changed")
            return check_folder_scene(robot, self.what)
        if self.what.is_dir() or self.what.suffix == ".mcap":
            from cablewright.apps.web.log_scene import log_scene

            found = log_scene(self.what, report)
            if found.robot.name != robot.name:
                raise InputError(f"{self.what}: is of robot {found.robot.name!r}, not of {robot.name!r}")
            return found
        from cablewright.apps.web.check_scene import job_scene
        from cablewright.printing.job import load_job

        return job_scene(robot, load_job(self.what), report)

    def _robot_alone(self) -> SceneDescription:
        from cablewright.apps.web.robot_scene import one_state, robot_scene
        from cablewright.solvers.inverse import inverse

        robot = self.robot.loaded(self.retraction)
        pose = pose_of(self.at, robot)
        if pose is None:
            return robot_scene(robot)
        found = inverse(robot, pose)
        note = "at rest: an equilibrium" if found.ok else f"not in equilibrium: {found.sentence()}"
        return one_state(found, robot.name, note)


@dataclass(frozen=True, repr=False)
class Shown(Result):
    """What a page shows."""

    FIGURES: ClassVar = (
        Figure("robot", "", "Name of the robot.", "scene.robot.name"),
        Figure("title", "", "Title of the page.", "scene.title"),
        Figure("states", "1", "Number of states of the robot that the page has.", lambda of: len(of.scene.states)),
        Figure("points", "1", "Number of points of the path; null without one.",
               lambda of: None if of.scene.path is None else len(of.scene.path.positions), "points of the path"),
        Figure("size", "1", "Size of the page, bytes.", "size", "bytes"),
        Figure("note", "", "What has to be known of the states.", lambda of: " ".join(of.scene.notes), detail=True),
    )  # fmt: skip

    scene: SceneDescription
    size: int
