"""`accuracy`: errors of the nozzle at a pose, over a shape or along a job."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import cablewright as cw
from cablewright.apps.cli.command import command, options
from cablewright.apps.cli.options import AsJson, ExecutorOptions, Limits, Retraction, RobotOptions, Seed
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import numbers, pose_of, run_path, tension_range
from cablewright.foundation.choices import CompensationName, MethodName
from cablewright.foundation.errors import InputError

if TYPE_CHECKING:
    from cablewright.analyses.accuracy.spread import Method
    from cablewright.studies.accuracy import ManyOptions

SHAPES = ("at", "helix", "path", "plane", "workspace")
TAKEN_BY = {
    "half_width": ("plane",),
    "step": ("helix", "plane", "workspace"),
    "retraction": ("at", "helix", "plane", "workspace"),
}
"""Options that only some shapes take."""

_KERNELS = ("inverse", "linearise", "forward")

STEPS = 40
"""Steps along the longest side of the frame where none is given."""


@options("Places")
class PlaceOptions:
    """Options of the positions: a pose, a helix, a path, a plane or the workspace."""

    at: Annotated[
        str | None,
        typer.Option(
            "--at",
            metavar="X,Y,Z[,RX,RY,RZ]",
            help="Compute the accuracy at one pose: position, m, and rotation vector, rad. Write `free` for a "
            "coordinate that equilibrium determines.",
        ),
    ] = None
    helix: Annotated[
        str | None,
        typer.Option(
            "--helix",
            metavar="RADIUS,PITCH,Z0,Z1",
            help="Compute the accuracy at positions on a helix "
            "about the frame's vertical centre line; RADIUS, "
            "PITCH and heights in m.",
        ),
    ] = None
    path: Annotated[
        Path | None,
        typer.Option(
            "--path", metavar="JOB", help="Compute the accuracy along the path of a job (TOML or G-code file)."
        ),
    ] = None
    plane: Annotated[
        float | None,
        typer.Option(
            "--plane",
            metavar="Z",
            help="Compute the accuracy at positions in a horizontal square at height Z, m; --half-width sets its size.",
        ),
    ] = None
    half_width: Annotated[
        float | None,
        typer.Option(
            "--half-width",
            metavar="W",
            help="Half the side of the square of --plane, m; by default the square fits into the frame.",
        ),
    ] = None
    workspace: Annotated[
        bool, typer.Option("--workspace", help="Compute the accuracy at the nodes of a grid in the static workspace.")
    ] = False
    step: Annotated[
        float | None,
        typer.Option(
            "--step",
            metavar="S",
            help=f"Distance between neighbouring positions, m; by default 0.1 on a helix, else 1/{STEPS} of the "
            f"frame's longest side.",
        ),
    ] = None
    retraction: Retraction = None

    @property
    def shape(self) -> str:
        """Return the name of the requested shape of positions, like helix.

        Raises `InputError` unless exactly one is given.
        """
        given = [shape for shape in SHAPES if getattr(self, shape) is not None and getattr(self, shape) is not False]
        if len(given) != 1:
            names = " and ".join(f"--{shape}" for shape in given) or "none"
            raise InputError(f"expected one of --at, --helix, --path, --plane and --workspace; got {names}")
        for option, shapes in TAKEN_BY.items():
            if getattr(self, option) is not None and given[0] not in shapes:
                raise InputError(f"--{option.replace('_', '-')} does not go with --{given[0]}")
        return given[0]

    def of(self, machine: cw.Robot) -> cw.Places:
        """Return the positions of a helix, a plane or the workspace of a robot. Raises `InputError`."""
        from cablewright.live import position_sets

        if self.helix is not None:
            radius, pitch, low, high = numbers(self.helix, "--helix", 4) or []
            step = position_sets.HELIX_STEP if self.step is None else self.step
            return position_sets.Places.helix(machine, radius, pitch, low, high, step)
        ends = zip(machine.scene.frame_min, machine.scene.frame_max, strict=True)
        step = max(high - low for low, high in ends) / STEPS if self.step is None else self.step
        if self.workspace:
            return position_sets.Places.workspace(step)
        assert self.plane is not None
        return position_sets.Places.plane(machine, self.plane, self.half_width, step)


@options("Uncertain parameters")
class UncertaintyOptions:
    """Options of the uncertain parameters, and of the method for the spread."""

    modulus_range: Annotated[
        str | None,
        typer.Option(
            "--modulus-range",
            metavar="MIN,MAX",
            help="Vary only the Young's modulus of each cable, by a factor from MIN to MAX; by default 0.7,1.3.",
        ),
    ] = None
    uncertainty: Annotated[
        Path | None,
        typer.Option(
            "--uncertainty",
            metavar="TOML",
            help="TOML file of the uncertain parameters; by default the robot file's [uncertainty], and without that "
            "the moduli alone.",
        ),
    ] = None
    method: Annotated[
        MethodName,
        typer.Option(
            "--method", help="Method that computes the range of the nozzle error from the uncertain parameters."
        ),
    ] = "vertices"
    samples: Annotated[
        int | None,
        typer.Option("--samples", help="Number of random samples for --method monte-carlo; by default 100000."),
    ] = None
    seed: Seed = 0

    def ranges(self, machine: cw.Robot) -> tuple[cw.Range, ...]:
        """Return the uncertain parameters of a robot with their ranges. Raises `InputError`."""
        from cablewright.robot.uncertainty import load_uncertainty, modulus_ranges

        if self.uncertainty is not None:
            if self.modulus_range is not None:
                raise InputError("--modulus-range and --uncertainty: give one of them, not both")
            return load_uncertainty(self.uncertainty).of(machine, str(self.uncertainty))
        if self.modulus_range is None:
            return machine.ranges()
        low, high = numbers(self.modulus_range, "--modulus-range", 2) or []
        return modulus_ranges(machine, low, high)

    def spread_method(self) -> Method | str:
        """Method that computes the range of the nozzle error from the uncertain parameters. Raises `InputError`."""
        if self.method == "monte-carlo":
            return cw.MonteCarlo(100_000 if self.samples is None else self.samples, self.seed)
        if self.samples is not None:
            raise InputError("--samples is only for --method monte-carlo; leave it out")
        return self.method


@command(
    "accuracy house-printer --at 3,2,1", "studies.accuracy_at_pose:AccuracyAtPose", "studies.accuracy:AccuracyStudy"
)
def accuracy_command(
    *,
    robot: RobotOptions,
    places: PlaceOptions,
    uncertain: UncertaintyOptions,
    compensation: Annotated[
        CompensationName,
        typer.Option(
            "--compensation",
            help="Model from which the machine computes the commanded lengths: rigid cables (none), elastic cables, "
            "full model with eyelets, or full model.",
        ),
    ] = "none",
    home: Annotated[
        str | None,
        typer.Option(
            "--home",
            metavar="X,Y,Z[,RX,RY,RZ]",
            help="Pose, m and rad, at which the cable lengths were zeroed, so that the commanded lengths are exact "
            "there; by default they were zeroed nowhere.",
        ),
    ] = None,
    tension_limits: Limits = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            help="Run folder for the results; for several positions by default a folder in runs/, "
            "named for robot and shape.",
        ),
    ] = None,
    executor: ExecutorOptions,
    as_json: AsJson = False,
) -> int:
    """Prints the error of the commanded lengths, and the largest error for uncertain parameters.

    A shape writes a run folder with a report; one pose does so with --out. With --workers or --cluster, the same
    command resumes an interrupted run. The answer is no (exit 1) if the robot can hold none of the positions.
    """
    from cablewright.running import run_folders
    from cablewright.studies import accuracy

    machine = robot.loaded(places.retraction)
    is_pose = places.shape == "at"
    where: Any = pose_of(places.at, machine) if is_pose else places.path or places.of(machine)
    folder = out if is_pose else run_path(out, "accuracy", machine.name, places.shape)
    asked: ManyOptions = {
        "method": uncertain.spread_method(),
        "compensation": compensation,
        "tension_limits": tension_range(tension_limits),
        "home": numbers(home, "--home"),
        "seed": uncertain.seed,
    }
    ranges = uncertain.ranges(machine)
    with (
        nullcontext() if folder is None else run_folders.run_folder(folder) as part,
        _working(executor, None if is_pose else folder) as who,
    ):
        found = accuracy.accuracy(machine, where, ranges, **asked | who | {"room": part})
        if part is not None:
            options = {"compensation": compensation, "home": home, "tension_limits": tension_limits}
            options |= {"load": robot.load, "wrench": robot.wrench} | asdict(places) | asdict(uncertain)
            _write(found, part, robot.robot, options)
    if folder is not None:
        _beside(folder).unlink(missing_ok=True)  # of a run that was interrupted
    return answer(found, as_json, report=None if folder is None else folder / "report.html")


@contextmanager
def _working(executor: ExecutorOptions, folder: Path | None) -> Iterator[ManyOptions]:
    """Who computes, with its progress; *folder*: the run folder of a shape, None at a pose. Raises `InputError`."""
    if not executor.asked:
        with progress(*_KERNELS) as show:
            yield {"progress": show}
        return
    if folder is None:
        raise InputError(
            "--workers and --cluster: leave them out for a single pose (--at); they are for many positions"
        )
    kept = _beside(folder)
    with executor.working(kept, *_KERNELS) as (works, show):
        yield {"progress": show, "executor": works, "file": kept}


def _write(found: cw.AccuracyAtPose | cw.AccuracyStudy, part: Path, robot: str, options: dict[str, Any]) -> None:
    """Write manifest, tables and report into the run folder."""
    from cablewright.apps.report import accuracy as report
    from cablewright.running import run_folders
    from cablewright.studies.accuracy_tables import write_places

    inputs = {"robot": run_folders.robot_hash(robot)}
    if options["uncertainty"] is not None:
        inputs["uncertainty"] = run_folders.file_hash(options["uncertainty"])
    if options["path"] is not None:
        inputs |= run_folders.job_hashes(options["path"], cw.load_job(options["path"]))
    run_folders.write_manifest(part, "accuracy", inputs, options)
    if isinstance(found, cw.AccuracyAtPose):
        report.write_place(found, part, options)
    else:
        write_places(found, part)
        report.write(found, part, options)


def _beside(folder: Path) -> Path:
    """Where the results are while the run folder is not there yet."""
    return folder.with_name(f"{folder.name}.results.jsonl")
