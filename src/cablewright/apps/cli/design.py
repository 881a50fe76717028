"""`design`: search for values of design variables with which a robot serves its part best."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import cablewright as cw
from cablewright.apps.cli.command import command, options
from cablewright.apps.cli.options import AsJson, ExecutorOptions, RobotName, Seed
from cablewright.apps.cli.output import answer, tell
from cablewright.apps.cli.parsing import named_number, run_path
from cablewright.foundation.choices import CriterionName, InertiaName, OptimiserName
from cablewright.foundation.errors import InputError

RESULTS = "results.jsonl"


@options("Search")
class SearchOptions:
    """Options of the design search."""

    method: Annotated[
        OptimiserName | None,
        typer.Option(
            "--method",
            help="Optimiser: differential evolution (de) or CMA-ES for one objective, NSGA-II for several; by "
            "default de for one objective, nsga2 for several.",
        ),
    ] = None
    evaluations: Annotated[
        int, typer.Option("--evaluations", metavar="N", help="Total number of candidate designs to evaluate.")
    ] = 400
    population: Annotated[
        int | None,
        typer.Option(
            "--population",
            metavar="N",
            help="Number of candidate designs in each generation; by default 6 for each variable.",
        ),
    ] = None
    seed: Seed = 0
    criterion: Annotated[
        CriterionName,
        typer.Option(
            "--criterion", help="Criterion by which a position belongs to the workspace, for objectives like volume."
        ),
    ] = "exact"
    inertia: Annotated[
        InertiaName,
        typer.Option(
            "--inertia",
            help="Inertia of the platform for the objective boundary_frequency: the robot "
            "file's (given), or that of a box about its points.",
        ),
    ] = "given"
    grid: Annotated[
        int,
        typer.Option(
            "--grid",
            metavar="N",
            help="Number of grid nodes along each side of the search box, for objectives of the workspace.",
        ),
    ] = 9

    def workspace(self) -> cw.TradeSettings:
        """Return the settings with which workspaces are computed. Raises `InputError`."""
        return cw.TradeSettings(
            criterion=self.criterion, count="nodes", grid=self.grid, boundary_grid=self.grid, inertia=self.inertia
        )


@options()
class GoalOptions:
    """Options of design variables, objectives and constraints."""

    vary: Annotated[
        list[str],
        typer.Option(
            "--vary",
            metavar="NAME=LOW:HIGH",
            help="A design variable and its bounds in SI units; repeat the option for more. Names as in `trade`: "
            "exits-x, exit_point.z, "
            "exit_point.x@LINE, width-x, sheave_radius, tension-min, .., and NAME+NAME.",
        ),
    ]
    objective: Annotated[
        list[str],
        typer.Option(
            "--objective",
            metavar="FIGURE",
            help="Quantity to optimise; repeat the option for a Pareto front. tension_margin, expected_error, "
            "lowest_frequency, "
            "clearance, max_torque, cable_length, cost, volume, boundary_frequency, ..",
        ),
    ]
    constraint: Annotated[
        list[str] | None,
        typer.Option(
            "--constraint",
            metavar="FIGURE>=VALUE",
            help="Constraint on one of the quantities of "
            "--objective, in SI units, with >= or <=; repeat "
            "the option for more.",
        ),
    ] = None
    price: Annotated[
        list[str] | None,
        typer.Option(
            "--price",
            metavar="NAME=VALUE",
            help="Price for the objective cost, in any one currency: of a metre of cable, of a winch, or of a newton "
            "metre of a winch's torque; repeat the option for each.",
        ),
    ] = None
    symmetry: Annotated[
        str | None,
        typer.Option(
            "--symmetry",
            metavar="x|y|x,y",
            help="Mirror planes through the frame's middle; a variable of one line then also changes its mirror "
            "images.",
        ),
    ] = None

    @property
    def mirrors(self) -> tuple[str, ...]:
        """The planes about which the design is to be symmetric."""
        return () if self.symmetry is None else tuple(each.strip() for each in self.symmetry.split(","))

    def prices(self) -> dict[str, float] | None:
        """The prices by name; None without one. Raises `InputError`."""
        expected = "expected NAME=VALUE, a name and a number"
        return dict(named_number(text, f"--price = {text!r}: {expected}") for text in self.price or ()) or None


@command(
    "design house-printer examples/helix.toml --vary exit_point.z=8:15 --objective expected_error "
    "--evaluations 20 --population 10 --out runs/design",
    "studies.design.result:Designed",
)
def design_command(
    *,
    robot: RobotName,
    job: Annotated[
        Path | None,
        typer.Argument(
            metavar="[JOB]", help="A job's TOML file, or a G-code file; objectives of the workspace need none."
        ),
    ] = None,
    goal: GoalOptions,
    search: SearchOptions,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", metavar="DIR", help="Folder for the state and result of the search; by default in runs/."
        ),
    ] = None,
    executor: ExecutorOptions,
    as_json: AsJson = False,
) -> int:
    """Evaluates candidates at a few positions that represent the whole part, within the limits of the hardware.

    The folder --out gets robot.toml (the best or most balanced candidate), up to two others, a report, and all results.
    The same command resumes an interrupted search. Run `check` on the result. The answer is no (exit 1) if no candidate
    meets all constraints.
    """
    described = cw.load(robot)
    folder = run_path(out, "design", described.name, *(() if job is None else (job.stem,)))
    _require_own(folder)
    with executor.working(folder) as (works, show):
        found = cw.design(
            described,
            job,
            goal.vary,
            goal.objective,
            goal.constraint or (),
            symmetry=goal.mirrors,
            method=search.method,
            evaluations=search.evaluations,
            population=search.population,
            workspace=search.workspace(),
            prices=goal.prices(),
            seed=search.seed,
            file=folder / RESULTS,
            executor=works,
            progress=show,
        )
    return answer(found, as_json, **_written(found, folder, robot, job))


def _written(found: cw.Designed, folder: Path, robot: str, job: Path | None) -> dict[str, object]:
    """Write the robots and the report; return their files."""
    from cablewright.apps.report.result import result_page
    from cablewright.foundation.file_output import write_whole
    from cablewright.robot import library_text
    from cablewright.robot.write_back import update

    page = result_page(found, f"Design of {found.what.robot.name}", drawn=bool(found.holding))
    write_whole(folder / "report.html", page.encode("utf-8"))
    text = library_text(robot) if robot in cw.library_names() else Path(robot).read_text("utf-8")
    files = ["robot.toml", *(f"candidate-{k}.toml" for k in range(2, len(found.chosen) + 1))]
    files = files[: len(found.chosen)]
    for name, each in zip(files, found.chosen, strict=True):
        write_whole(folder / name, update(text, found.robot_of(each)).encode("utf-8"))
    if files:
        on = "" if job is None else f" {job}"
        tell(f"note: judged at {len(found.what.places)} places; cablewright check {folder / 'robot.toml'}{on}")
    return {"robots": [str(folder / name) for name in files], "report": folder / "report.html"}


def _require_own(folder: Path) -> None:
    """Raise `InputError` if the folder holds anything but an earlier search."""
    if folder.exists() and not (folder.is_dir() and ((folder / RESULTS).exists() or not any(folder.iterdir()))):
        raise InputError(f"--out = {folder}: exists already and holds no search; choose another folder")
