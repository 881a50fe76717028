"""`accuracy`: how far off the robot prints, at a place or over a shape."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cablewright.apps.cli.accuracy_text import print_place, print_study, warn
from cablewright.apps.cli.options import AsJson, Limits, LoadName, Retracted, RobotName, Wrench, described
from cablewright.apps.cli.output import limits, numbers, print_json, progress
from cablewright.errors import AnswerError, InputError, UnknownName

if TYPE_CHECKING:
    from cablewright.analyses.accuracy.spread import Method
    from cablewright.progress import Progress
    from cablewright.robot import Robot
    from cablewright.robot.uncertainty import Range
    from cablewright.studies.accuracy import Study
    from cablewright.studies.accuracy_at_pose import AccuracyAtPose

__all__ = ["accuracy"]

SHAPES = ("at", "helix", "path", "plane", "workspace")
TAKEN_BY = {
    "half_width": ("plane",),
    "step": ("helix", "plane", "workspace"),
    "retraction": ("at", "helix", "plane", "workspace"),
}
"""Options that only some shapes take."""

STEPS = 40
"""Steps along the longest side of the frame where none is given."""


def accuracy(
    robot: RobotName,
    at: Annotated[str | None, typer.Option("--at", metavar="X,Y,Z[,RX,RY,RZ]", help="One pose, m and rad.")] = None,
    helix: Annotated[
        str | None,
        typer.Option("--helix", metavar="RADIUS,PITCH,Z0,Z1", help="Along a helix in the frame's middle, m."),
    ] = None,
    path: Annotated[Path | None, typer.Option("--path", metavar="JOB", help="Along a job's path.")] = None,
    plane: Annotated[
        float | None, typer.Option("--plane", metavar="Z", help="Over a horizontal square at this height, m.")
    ] = None,
    half_width: Annotated[
        float | None, typer.Option("--half-width", metavar="W", help="From the middle to the sides of the plane, m.")
    ] = None,
    workspace: Annotated[bool, typer.Option("--workspace", help="Over all that the robot can reach.")] = False,
    step: Annotated[float | None, typer.Option("--step", metavar="S", help="Distance between places, m.")] = None,
    modulus_range: Annotated[
        str | None,
        typer.Option("--modulus-range", metavar="LOW,HIGH", help="Factors between which moduli lie; 0.7,1.3."),
    ] = None,
    uncertainty: Annotated[
        Path | None, typer.Option("--uncertainty", metavar="TOML", help="What is uncertain, and how much.")
    ] = None,
    method: Annotated[str, typer.Option("--method", help="vertices, first-order or monte-carlo.")] = "vertices",
    samples: Annotated[int | None, typer.Option("--samples", help="Samples of monte-carlo; 100000.")] = None,
    seed: Annotated[int, typer.Option("--seed", help="Seed of what is random.")] = 0,
    compensation: Annotated[
        str, typer.Option("--compensation", help="Lengths from: none (rigid cables), elastic, eyelets or full.")
    ] = "none",
    home: Annotated[
        str | None, typer.Option("--home", metavar="X,Y,Z[,RX,RY,RZ]", help="Where the lengths were zeroed.")
    ] = None,
    tension_limits: Limits = None,
    retraction: Retracted = None,
    load: LoadName = None,
    wrench: Wrench = None,
    out: Annotated[Path | None, typer.Option("--out", help="Run folder; of a shape runs/accuracy-ROBOT-SHAPE.")] = None,
    as_json: AsJson = False,
) -> int:
    """How far off the robot prints: the error without compensation, and what uncertain numbers leave of it."""
    given = {name: value for name, value in locals().items() if name not in ("robot", "out", "as_json")}
    machine = described(robot, load, wrench)
    if retraction is not None:
        machine = machine.retracted(retraction)
    asked = _Asked(robot, machine, given, out, as_json)
    try:
        return asked.at_place() if asked.shape == "at" else asked.over_shape()
    except AnswerError as reason:
        if as_json:
            print_json({"status": "refused", "reason": str(reason)})
        raise


@dataclass(frozen=True)
class _Asked:
    """What the command line asks for. Options by name, as given."""

    name: str
    robot: Robot
    given: Mapping[str, Any]
    out: Path | None
    as_json: bool

    @property
    def shape(self) -> str:
        """Which of the shapes is asked for. Raises `InputError` unless it is one, with the options it takes."""
        asked = [shape for shape in SHAPES if self.given[shape] is not None and self.given[shape] is not False]
        if len(asked) != 1:
            told = " and ".join(f"--{shape}" for shape in asked) or "none"
            raise InputError(f"one of --at, --helix, --path, --plane and --workspace is wanted; got {told}")
        for option, shapes in TAKEN_BY.items():
            if self.given[option] is not None and asked[0] not in shapes:
                raise InputError(f"--{option.replace('_', '-')} does not go with --{asked[0]}")
        return asked[0]

    def ranges(self) -> tuple[Range, ...]:
        """What is uncertain. Raises `InputError`."""
        from cablewright.robot.uncertainty import load_uncertainty, of_moduli

        factors, file = self.given["modulus_range"], self.given["uncertainty"]
        if file is not None:
            if factors is not None:
                raise InputError("--modulus-range and --uncertainty: give one of them")
            return load_uncertainty(file).of(self.robot, str(file))
        values = numbers(factors, "--modulus-range") or [0.7, 1.3]
        if len(values) != 2:
            raise InputError(f"--modulus-range = {factors!r}: two factors are wanted, lowest,highest")
        return of_moduli(self.robot, *values)

    def method(self) -> Method:
        """How the spread is found. Raises `UnknownName`."""
        from cablewright.analyses.accuracy.spread import FirstOrder, MonteCarlo, Vertices

        name, samples = self.given["method"], self.given["samples"]
        if name == "monte-carlo":
            return MonteCarlo(100_000 if samples is None else samples, self.given["seed"])
        if samples is not None:
            raise InputError("--samples goes with --method monte-carlo")
        methods: dict[str, Method] = {"vertices": Vertices(), "first-order": FirstOrder()}
        if name not in methods:
            raise UnknownName("method", name, (*methods, "monte-carlo"))
        return methods[name]

    def options(self) -> dict[str, Any]:
        """What `accuracy`, `accuracy_over` and `accuracy_at` take alike."""
        return {
            "ranges": self.ranges(),
            "method": self.method(),
            "compensation": self.given["compensation"],
            "tension_limits": limits(self.given["tension_limits"]),
            "home": numbers(self.given["home"], "--home"),
        }

    def at_place(self) -> int:
        """One pose; a run folder only where --out asks for it."""
        from cablewright.studies.accuracy_at_pose import accuracy_at

        pose = numbers(self.given["at"], "--at", free=True) or []
        with self._folder(self.out) as part, progress() as show:
            found = accuracy_at(self.robot, pose, seed=self.given["seed"], progress=show, **self.options())
            if part is not None:
                self._write_inputs(part)
                _write_place(found, part, self.given)
        report = None if self.out is None else str(self.out / "report.html")
        if self.as_json:
            print_json(found.summary() | {"report": report})
        else:
            print_place(found, report)
        warn(found.accuracy)
        return 0

    def over_shape(self) -> int:
        """A helix, a path, a plane or the workspace, with a run folder."""
        from cablewright.studies import store

        folder = self.out or Path("runs") / store.folder_name("accuracy", self.robot.name, self.shape)
        with self._folder(folder) as part, progress() as show:
            assert part is not None
            found = self._studied(show)
            self._write_inputs(part)
            _write_study(found, part, self.given)
        report = str(folder / "report.html")
        if self.as_json:
            print_json({"status": "ok"} | found.summary() | {"report": report})
        else:
            print_study(found, report)
        warn(found.accuracy)
        return 0

    def _studied(self, show: Progress) -> Study:
        from cablewright.printing.job import load_job
        from cablewright.studies import accuracy as studies

        given, options = self.given, self.options() | {"progress": show}
        if self.shape == "path":
            return studies.accuracy_over_job(self.robot, load_job(given["path"]), **options)
        if self.shape == "workspace":
            return studies.accuracy_over_workspace(self.robot, self._step(), **options)
        if self.shape == "plane":
            places = studies.on_plane(self.robot, given["plane"], given["half_width"], self._step())
        else:
            places = studies.along_helix(
                self.robot, *self._helix(), given["step"] if given["step"] is not None else studies.HELIX_STEP
            )
        return studies.accuracy_over(self.robot, places, **options)

    def _helix(self) -> tuple[float, float, float, float]:
        values = numbers(self.given["helix"], "--helix") or []
        if len(values) != 4:
            raise InputError(f"--helix = {self.given['helix']!r}: four numbers are wanted, RADIUS,PITCH,Z0,Z1 in m")
        return values[0], values[1], values[2], values[3]

    def _step(self) -> float:
        """The step asked for, or one that goes along the frame's longest side in `STEPS`."""
        if self.given["step"] is not None:
            return float(self.given["step"])
        scene = self.robot.scene
        return max(high - low for low, high in zip(scene.frame_min, scene.frame_max, strict=True)) / STEPS

    @contextmanager
    def _folder(self, folder: Path | None) -> Iterator[Path | None]:
        """The run folder, refused before the work where it cannot be had; None where none is asked for."""
        from cablewright.studies import store

        if folder is None:
            yield None
            return
        with store.run_folder(folder) as part:
            yield part

    def _write_inputs(self, part: Path) -> None:
        """Write the manifest."""
        from cablewright.printing.job import load_job
        from cablewright.studies import store

        given, inputs = self.given, {"robot": store.robot_hash(self.name)}
        if given["uncertainty"] is not None:
            inputs["uncertainty"] = store.file_hash(given["uncertainty"])
        if given["path"] is not None:
            inputs |= store.job_hashes(given["path"], load_job(given["path"]))
        store.write_manifest(part, "accuracy", inputs, self.given)


def _write_place(found: AccuracyAtPose, folder: Path, given: Mapping[str, Any]) -> None:
    from cablewright.apps.report import accuracy as report

    report.write_place(found.accuracy, found.region, found.summary(), folder, given)


def _write_study(found: Study, folder: Path, given: Mapping[str, Any]) -> None:
    from cablewright.apps.report import accuracy as report
    from cablewright.studies import store

    store.write_places(found, folder)
    report.write(found, folder, given)
