"""Arguments, options and groups of options that several commands share."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import cablewright as cw
from cablewright.apps.cli.command import options
from cablewright.apps.cli.output import progress, tell
from cablewright.apps.cli.parsing import check_suffix, numbers, rotations, tension_range
from cablewright.foundation.choices import (
    CountName,
    CriterionName,
    EstimatorName,
    PlantName,
    PointName,
    SeverityName,
    TensionChoice,
)
from cablewright.foundation.errors import InputError
from cablewright.foundation.progress import Progress
from cablewright.models.fidelity import CableLaw, SheaveLaw

if TYPE_CHECKING:
    from cablewright.foundation.results import Pictured
    from cablewright.running.executors.executor import Executor

RobotName = Annotated[
    str,
    typer.Argument(metavar="ROBOT", help="A robot's TOML file, or a name that `cablewright robots` lists."),
]
JobFile = Annotated[Path, typer.Argument(metavar="JOB", help="A job's TOML file, or a G-code file.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object in SI units instead of text.")]
Plot = Annotated[
    Path | None,
    typer.Option(
        "--plot",
        metavar="FILE",
        help="Picture of the result to write, .png, .svg or .pdf; its numbers are written to FILE.csv.",
    ),
]
PlotWidth = Annotated[
    str | None,
    typer.Option(
        "--plot-width",
        metavar="W",
        help="Width of the picture: one-column or two-column of a paper, or a length like 120 mm.",
    ),
]
PlotStyle = Annotated[
    Path | None,
    typer.Option("--plot-style", metavar="FILE.mplstyle", help="Style sheet of matplotlib for the picture."),
]
BeadSize = Annotated[
    str | None,
    typer.Option(
        "--bead",
        metavar="WIDTH,HEIGHT",
        help="Width and height of all strands, like 1.2mm,0.6mm; by default those of the job file, or of the G-code.",
    ),
]
Seed = Annotated[int, typer.Option("--seed", help="Seed of all random numbers; the same seed gives the same result.")]
MachineName = Annotated[
    str | None,
    typer.Option(
        "--machine",
        metavar="NAME",
        help="A machine's TOML file, or a name that `cablewright machines` lists; by default the robot's name.",
    ),
]
Estimator = Annotated[
    EstimatorName | None,
    typer.Option(
        "--estimator",
        help="Estimator of the platform's position: that of Merlet and Papegay 2023 (paper), a Kalman filter of all "
        "sensors (filter), or encoders alone; by default the filter, if the machine has its sensors.",
    ),
]
LayerCount = Annotated[
    int | None, typer.Option("--layers", metavar="N", help="Print only the first N layers; by default all.")
]
Period = Annotated[float, typer.Option("--period", metavar="T", help="Time step of the quasi-static plant, s.")]
Plant = Annotated[
    PlantName,
    typer.Option(
        "--plant",
        help="Simulate the platform with inertia in steps of 10 ms (dynamic), or as a sequence "
        "of equilibria (quasi-static).",
    ),
]
Severity = Annotated[
    SeverityName | None,
    typer.Option(
        "--severity",
        help="How much the simulated machine deviates from its description in walls, mounts, clocks, sensors, "
        "people, link gaps, creep, friction, compliance and wind; by default as in the machine file.",
    ),
]
Pose = Annotated[
    str | None,
    typer.Option(
        "--at",
        metavar="X,Y,Z[,RX,RY,RZ]",
        help="Pose of the platform: position, m, and rotation vector, rad. Write `free` for a coordinate that "
        "equilibrium determines.",
    ),
]
Lengths = Annotated[
    str, typer.Option("--lengths", metavar="L1,..,Lm", help="Unstrained length of each line, m, separated by commas.")
]
LengthsOrLog = Annotated[
    str,
    typer.Option(
        "--lengths",
        metavar="L1,..,Lm",
        help="Unstrained length of each line, m, or a CSV file with one row of lengths for each pose.",
    ),
]
Clearance = Annotated[
    float,
    typer.Option(
        "--clearance",
        metavar="D",
        help="Minimum allowed distance of a line from obstacles, m; 0 reports contact alone.",
    ),
]
Limits = Annotated[
    str | None,
    typer.Option(
        "--tension-limits",
        metavar="MIN,MAX",
        help="Smallest and largest allowed tension of every line, N; by default those of the robot file.",
    ),
]
Box = Annotated[
    str | None,
    typer.Option("--box", metavar="X0,X1,Y0,Y1,Z0,Z1", help="Box in which to search, m; by default the robot's frame."),
]
CalibrationPlanFile = Annotated[
    Path | None,
    typer.Option(
        "--plan",
        metavar="PLAN.toml",
        help="Plan file (TOML) that names the unknowns, the standard deviations and the datum; by default the TOML "
        "file beside the data.",
    ),
]
Retraction = Annotated[
    float | None, typer.Option("--retraction", metavar="L", help="Length to which the end-effector is retracted, m.")
]
SheaveChoice = Annotated[
    SheaveLaw | None,
    typer.Option(
        "--sheave", help="Sheave law: how the model describes the sheaves; by default as the robot file does."
    ),
]
Geometric = Annotated[
    bool,
    typer.Option(
        "--geometric/--no-geometric", help="Include the geometric stiffness (from tension) in the frequencies."
    ),
]
Tensions = Annotated[
    TensionChoice | None,
    typer.Option(
        "--tensions",
        help="How tensions are chosen along the boundary: those of least norm (least), or those nearest to the "
        "middle of the limits (middle); by default middle for the closed forms, else least.",
    ),
]


@options("Robot and load")
class RobotOptions:
    """Options of the robot and the external wrench on its platform."""

    robot: RobotName
    lines: Annotated[
        str | None,
        typer.Option("--lines", metavar="NAME,..", help="Names of the lines that hold the platform; by default all."),
    ] = None
    load: Annotated[
        str | None,
        typer.Option(
            "--load",
            metavar="NAME",
            help="Name of the load in the robot file that the platform carries; by default the platform's own values.",
        ),
    ] = None
    wrench: Annotated[
        str | None,
        typer.Option(
            "--wrench",
            metavar="FX,FY,FZ[,MX,MY,MZ]",
            help="External force on the platform, N, and moment about its origin, N m, in the world's axes.",
        ),
    ] = None

    def loaded(self, retraction: float | None = None) -> cw.Robot:
        """Return the robot under its load and wrench, retracted to a length (m) where one is given.

        Raises `InputError`.
        """
        robot = cw.load(self.robot)
        if self.lines is not None:
            robot = robot.with_lines([name.strip() for name in self.lines.split(",")])
        if self.load is not None:
            robot = robot.under_load(self.load)
        if retraction is not None:
            robot = robot.retracted(retraction)
        values = numbers(self.wrench, "--wrench")
        if values is None:
            return robot
        if len(values) not in (3, 6):
            raise InputError(f"--wrench = {self.wrench!r}: expected 3 numbers, N, or 6, N and N m")
        x, y, z, *moment = values
        a, b, c = moment or (0.0, 0.0, 0.0)
        return robot.under_wrench((x, y, z), (a, b, c))


@options("Model of the lines")
class LawOptions:
    """Options of the physics of the lines: cable law and sheave law."""

    cable: Annotated[
        CableLaw | None,
        typer.Option(
            "--cable", help="Cable law: how the model describes sag and stretch of the cables; by default catenary."
        ),
    ] = None
    sheave: SheaveChoice = None
    tension_limits: Limits = None

    def laws(self) -> dict[str, Any]:
        """Return keyword arguments on the model for functions of `cablewright`."""
        return {"cable": self.cable, "sheave": self.sheave, "tension_limits": tension_range(self.tension_limits)}


@options("Workspace")
class RegionOptions(LawOptions):
    """Options of the workspace criterion, and of the region to search."""

    criterion: Annotated[
        CriterionName | None,
        typer.Option(
            "--criterion",
            help="Criterion by which a pose belongs to the workspace; by default exact. Only "
            "static includes the sag of the cables.",
        ),
    ] = None
    box: Box = None
    point: Annotated[
        PointName | None,
        typer.Option("--point", help="Point of the platform that the position refers to; by default the nozzle."),
    ] = None
    cable: Annotated[
        CableLaw | None,
        typer.Option(
            "--cable",
            help="Cable law: how the model describes sag and stretch of the cables; by default "
            "catenary for the criterion static, else rigid.",
        ),
    ] = None

    @property
    def criterion_name(self) -> str:
        """Return the name of the criterion of the workspace."""
        return self.criterion or "exact"

    def places(self) -> dict[str, Any]:
        """Return keyword arguments on the region for functions of `cablewright`."""
        return {"box": numbers(self.box, "--box"), "point": self.point or "nozzle"}

    def as_arguments(self) -> dict[str, Any]:
        """Return keyword arguments for functions of `cablewright`, without the criterion."""
        return self.laws() | self.places()


@options("Workspace")
class OrientedRegionOptions(RegionOptions):
    """Options of the region, for any orientation and retraction."""

    orientations: Annotated[
        str | None,
        typer.Option(
            "--orientations",
            metavar="RX,RY,RZ;...",
            help="Rotation vectors, rad: the criterion must hold for each; by default no rotation.",
        ),
    ] = None
    retraction: Retraction = None
    retraction_law: Annotated[
        str | None,
        typer.Option(
            "--retraction-law",
            metavar="C,D[,MIN,MAX]",
            help="Retraction length C z + D at height z, m, clamped to MIN and MAX, m.",
        ),
    ] = None

    def places(self) -> dict[str, Any]:
        """Return keyword arguments on the region and its orientations for functions of `cablewright`."""
        more = {"orientations": rotations(self.orientations), "retraction": self.retraction_at_heights()}
        return super().places() | more

    def retraction_at_heights(self) -> float | cw.RetractionLaw | None:
        """Return the retraction length, m, or its law by height. Raises `InputError`."""
        values = numbers(self.retraction_law, "--retraction-law")
        if values is None:
            return self.retraction
        if self.retraction is not None:
            raise InputError("--retraction and --retraction-law: give one of them, not both")
        if len(values) not in (2, 4):
            raise InputError(
                f"--retraction-law = {self.retraction_law!r}: expected C,D of the length C z + D in m, or C,D,MIN,MAX"
            )
        slope, intercept, *clamps = values
        low, high = clamps or (None, None)
        return cw.RetractionLaw(slope, intercept, low, high, self.point or "nozzle")


@options("Volume")
class CountOptions:
    """Options of a workspace volume's computation."""

    count: Annotated[
        CountName,
        typer.Option(
            "--count", help="Compute the volume with an estimated error (volume), or count the nodes of a grid (nodes)."
        ),
    ] = "volume"
    grid: Annotated[
        int | None,
        typer.Option(
            "--grid", metavar="N", help="Number of grid nodes along each side of the search box; by default 41."
        ),
    ] = None
    tolerance: Annotated[
        float | None,
        typer.Option(
            "--tolerance",
            metavar="T",
            help="Error of the volume, as a fraction of the volume, at which the refinement stops; by default 0.002.",
        ),
    ] = None
    seed: Seed = 0


@options("Output")
class OutputOptions:
    """Options of printed and written output."""

    plot: Plot = None
    plot_width: PlotWidth = None
    plot_style: PlotStyle = None
    report: Annotated[
        Path | None,
        typer.Option(
            "--report", metavar="FILE.html", help="HTML page to write, with the results, tables and a picture."
        ),
    ] = None
    as_json: AsJson = False

    def __post_init__(self) -> None:
        """Reject other kinds of files, before any work. Raises `InputError`."""
        check_suffix(self.plot, "--plot", ".png", ".svg", ".pdf")
        if self.plot is None and (self.plot_width is not None or self.plot_style is not None):
            raise InputError("--plot-width and --plot-style: give --plot FILE too, the picture that they are for")
        check_suffix(self.report, "--report", ".html")

    def write(self, found: Pictured, title: str, *, when: bool = True) -> dict[str, Path | None]:
        """Write the requested picture and page; return their files by kind.

        *title* of the page; *when*: whether there is something to draw.
        """
        drawn = self.plot if when else None
        if drawn is not None:
            found.plot(drawn, width=self.plot_width, style=self.plot_style)
        if self.report is not None:
            from cablewright.apps.report.result import result_page
            from cablewright.foundation.file_output import write_whole

            write_whole(self.report, result_page(found, title, drawn=when).encode("utf-8"))
        return {"plot": drawn} | ({} if self.report is None else {"report": self.report})


@options("Who computes")
class ExecutorOptions:
    """Options of the processes or computers that share the computation."""

    workers: Annotated[
        int | None,
        typer.Option(
            "--workers",
            metavar="N",
            help="Number of worker processes on this computer, with one thread "
            "each; by default this process does all the work.",
        ),
    ] = None
    cluster: Annotated[
        str | None,
        typer.Option(
            "--cluster",
            metavar="ADDRESS",
            help="Address of a dask scheduler, like tcp://HOST:8786, whose workers do the work; or `local` for "
            "processes of this computer.",
        ),
    ] = None

    @property
    def asked(self) -> bool:
        """Whether the computation is to be shared with other processes or computers."""
        return self.workers is not None or self.cluster is not None

    @contextmanager
    def working(self, kept: Path, *kernels: str) -> Iterator[tuple[Executor, Progress]]:
        """Context with the executor and its progress. An interruption reports that *kept* has the results so far.

        Raises `InputError`, `EnvironmentFault`.
        """
        from cablewright.running.executors.choice import chosen

        try:
            with chosen(self.workers, self.cluster) as executor, progress(*kernels) as show:
                yield executor, show
        except KeyboardInterrupt:
            tell(f"{kept} has the finished results; the same command resumes from there")
            raise
