"""`show`: a 3-D view of a robot in a browser, alone or with a job, a run or a log."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

import typer

import cablewright as cw
from cablewright.apps.cli.command import command
from cablewright.apps.cli.options import AsJson, Pose, Retraction, RobotOptions
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import check_suffix, pose_of, run_path
from cablewright.foundation.errors import InputError
from cablewright.foundation.results import Figure, Result

if TYPE_CHECKING:
    from cablewright.apps.web.scene import SceneDescription
    from cablewright.foundation.progress import Progress


@command("show jung2020", "apps.cli.show:Shown")
def show_command(
    *,
    robot: RobotOptions,
    what: Annotated[
        Path | None,
        typer.Argument(
            metavar="[WHAT]", help="Job, run folder or log to show; without it, the page shows the robot alone."
        ),
    ] = None,
    at: Pose = None,
    retraction: Retraction = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE.html", help="HTML page to write; by default runs/show-ROBOT[-WHAT].html."),
    ] = None,
    png: Annotated[
        Path | None, typer.Option("--png", metavar="FILE.png", help="PNG picture to write in addition to the page.")
    ] = None,
    open_page: Annotated[bool, typer.Option("--open", help="Open the page in the browser.")] = False,
    as_json: AsJson = False,
) -> int:
    """Writes one self-contained HTML file. Without a job, the robot rests near the middle of its frame.

    WHAT is a job (TOML or G-code), the run folder of a check or a print, or a machine's log (MCAP). Lines have the
    shape of their statics. The page judges nothing; use `check` for that.
    """
    from cablewright.apps.report.show import show_page
    from cablewright.foundation.file_output import write_whole

    check_suffix(out, "--out", ".html")
    check_suffix(png, "--png", ".png")
    if what is not None and (at is not None or retraction is not None):
        raise InputError("--at and --retraction are for the robot alone: leave them out with a job, a run or a log")
    with progress() as report:
        machine = robot.loaded(retraction)
        scene = _robot_alone(machine, at) if what is None else _scene_of(machine, robot.robot, what, report)
    names = (scene.robot.name,) if what is None else (scene.robot.name, what.stem)
    page = run_path(out, "show", *names, suffix=".html")
    text = show_page(scene).encode("utf-8")
    if out is None:
        page.parent.mkdir(exist_ok=True)
    write_whole(page, text)
    if png is not None:
        from cablewright.apps.web.png import scene_png

        write_whole(png, scene_png(scene))
    if open_page:
        typer.launch(str(page))
    return answer(Shown(scene, len(text)), as_json, report=page, plot=png)


def _scene_of(robot: cw.Robot, name: str, what: Path, report: Progress) -> SceneDescription:
    """The scene of a job, a run or a log; *name*: what the command line calls the robot. Raises `InputError`."""
    if what.is_dir() and (what / "samples.parquet").is_file():
        from cablewright.apps.web.check_scene import check_folder_scene
        from cablewright.running.run_folders import read_manifest, robot_hash

        inputs = (read_manifest(what) or {}).get("inputs")
        if not isinstance(inputs, dict) or inputs.get("robot") != robot_hash(name):
            raise InputError(f"{what}: belongs to another robot than {name}, or to an earlier version of its file")
        return check_folder_scene(robot, what)
    if what.is_dir() or what.suffix == ".mcap":
        from cablewright.apps.web.log_scene import log_scene

        found = log_scene(what, report)
        if found.robot.name != robot.name:
            raise InputError(f"{what}: is of robot {found.robot.name!r}, not of {robot.name!r}")
        return found
    from cablewright.apps.web.check_scene import job_scene

    return job_scene(robot, cw.load_job(what), report)


def _robot_alone(robot: cw.Robot, at: str | None) -> SceneDescription:
    from cablewright.apps.web.robot_scene import one_state, robot_scene

    pose = pose_of(at, robot)
    if pose is None:
        return robot_scene(robot)
    found = cw.inverse(robot, pose)
    note = "at rest: an equilibrium" if found.ok else f"not in equilibrium: {found.sentence()}"
    return one_state(found, robot.name, note)


@dataclass(frozen=True, repr=False)
class Shown(Result):
    """Result of `show`: the contents of its page."""

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
