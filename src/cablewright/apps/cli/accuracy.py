"""`accuracy`: how far off the robot prints, at a place or over a shape."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cablewright.apps.cli.accuracy_text import print_place, print_study, warn
from cablewright.apps.cli.options import AsJson, Limits, LoadName, Retracted, RobotName, Wrench, command, described
from cablewright.apps.cli.output import limits, numbers, print_json, progress
from cablewright.errors import AnswerError, InputError

if TYPE_CHECKING:
    from cablewright.analyses.accuracy.nozzle_error import AccuracyOptions
    from cablewright.analyses.accuracy.spread import Method
    from cablewright.progress import Progress
    from cablewright.robot import Robot
    from cablewright.robot.uncertainty import Range
    from cablewright.studies.accuracy import AccuracyStudy
    from cablewright.studies.places import Places

SHAPES = ("at", "helix", "path", "plane", "workspace")
TAKEN_BY = {
    "half_width": ("plane",),
    "step": ("helix", "plane", "workspace"),
    "retraction": ("at", "helix", "plane", "workspace"),
}
"""Options that only some shapes take."""

STEPS = 40
"""Steps along the longest side of the frame where none is given."""


@dataclass(frozen=True)
class _Accuracy:
    """How far off the robot prints: the error without compensation, and what uncertain numbers leave of it."""

    robot: RobotName
    at: Annotated[str | None, typer.Option("--at", metavar="X,Y,Z[,RX,RY,RZ]", help="One pose, m and rad.")] = None
    helix: Annotated[
        str | None,
        typer.Option("--helix", metavar="RADIUS,PITCH,Z0,Z1", help="Along a helix in the frame's middle, m."),
    ] = None
    path: Annotated[Path | None, typer.Option("--path", metavar="JOB", help="Along a job's path.")] = None
    plane: Annotated[
        float | None, typer.Option("--plane", metavar="Z", help="Over a horizontal square at this height, m.")
    ] = None
    half_width: Annotated[
        float | None, typer.Option("--half-width", metavar="W", help="From the middle to the sides of the plane, m.")
    ] = None
    workspace: Annotated[bool, typer.Option("--workspace", help="Over all that the robot can reach.")] = False
    step: Annotated[float | None, typer.Option("--step", metavar="S", help="Distance between places, m.")] = None
    modulus_range: Annotated[
        str | None,
        typer.Option("--modulus-range", metavar="LOW,HIGH", help="Factors between which moduli lie; 0.7,1.3."),
    ] = None
    uncertainty: Annotated[
        Path | None, typer.Option("--uncertainty", metavar="TOML", help="What is uncertain, and how much.")
    ] = None
    method: Annotated[str, typer.Option("--method", help="vertices, first-order or monte-carlo.")] = "vertices"
    samples: Annotated[int | None, typer.Option("--samples", help="Samples of monte-carlo; 100000.")] = None
    seed: Annotated[int, typer.Option("--seed", help="Seed of what is random.")] = 0
    compensation: Annotated[
        str, typer.Option("--compensation", help="Lengths from: none (rigid cables), elastic, eyelets or full.")
    ] = "none"
    home: Annotated[
        str | None, typer.Option("--home", metavar="X,Y,Z[,RX,RY,RZ]", help="Where the lengths were zeroed.")
    ] = None
    tension_limits: Limits = None
    retraction: Retracted = None
    load: LoadName = None
    wrench: Wrench = None
    out: Annotated[Path | None, typer.Option("--out", help="Run folder; of a shape runs/accuracy-ROBOT-SHAPE.")] = None
    as_json: AsJson = False

    def run(self) -> int:
        """Answer at one place or over a shape."""
        try:
            return self.at_place() if self.shape == "at" else self.over_shape()
        except AnswerError as reason:
            if self.as_json:
                print_json({"status": "refused", "reason": str(reason)})
            raise

    @property
    def options(self) -> dict[str, Any]:
        """What was asked of the robot, by name, as a manifest and a report tell it."""
        return {key: value for key, value in asdict(self).items() if key not in ("robot", "out", "as_json")}

    @cached_property
    def machine(self) -> Robot:
        """The robot asked for, as loaded and retracted."""
        machine = described(self.robot, self.load, self.wrench)
        return machine if self.retraction is None else machine.retracted(self.retraction)

    @cached_property
    def shape(self) -> str:
        """Which of the shapes is asked for. Raises `InputError` unless it is one, with the options it takes."""
        asked = [shape for shape in SHAPES if getattr(self, shape) is not None and getattr(self, shape) is not False]
        if len(asked) != 1:
            told = " and ".join(f"--{shape}" for shape in asked) or "none"
            raise InputError(f"one of --at, --helix, --path, --plane and --workspace is wanted; got {told}")
        for option, shapes in TAKEN_BY.items():
            if getattr(self, option) is not None and asked[0] not in shapes:
                raise InputError(f"--{option.replace('_', '-')} does not go with --{asked[0]}")
        return asked[0]

    def ranges(self) -> tuple[Range, ...]:
        """What is uncertain. Raises `InputError`."""
        from cablewright.robot.uncertainty import load_uncertainty, modulus_ranges

        if self.uncertainty is not None:
            if self.modulus_range is not None:
                raise InputError("--modulus-range and --uncertainty: give one of them")
            return load_uncertainty(self.uncertainty).of(self.machine, str(self.uncertainty))
        values = numbers(self.modulus_range, "--modulus-range") or [0.7, 1.3]
        if len(values) != 2:
            raise InputError(f"--modulus-range = {self.modulus_range!r}: two factors are wanted, lowest,highest")
        return modulus_ranges(self.machine, *values)

    def spread_method(self) -> Method | str:
        """How the spread is found."""
        from cablewright.analyses.accuracy.spread import MonteCarlo

        if self.method == "monte-carlo":
            return MonteCarlo(100_000 if self.samples is None else self.samples, self.seed)
        if self.samples is not None:
            raise InputError("--samples goes with --method monte-carlo")
        return self.method

    def question(self, show: Any) -> AccuracyOptions:
        """What is asked alike at one pose and over a shape."""
        return {
            "method": self.spread_method(),
            "compensation": self.compensation,
            "tension_limits": limits(self.tension_limits),
            "home": numbers(self.home, "--home"),
            "seed": self.seed,
            "progress": show,
        }

    def at_place(self) -> int:
        """One pose; a run folder only where --out asks for it."""
        from cablewright.apps.report.accuracy import write_place
        from cablewright.studies import store
        from cablewright.studies.accuracy import accuracy as find

        pose = numbers(self.at, "--at", free=True) or []
        with nullcontext() if self.out is None else store.run_folder(self.out) as part, progress() as show:
            found = find(self.machine, pose, self.ranges(), **self.question(show))
            if part is not None:
                self._write_inputs(part)
                write_place(found.accuracy, found.region, found.to_dict(), part, self.options)
        report = None if self.out is None else str(self.out / "report.html")
        if self.as_json:
            print_json(found.to_dict() | {"report": report})
        else:
            print_place(found, report)
        warn(found.accuracy)
        return 0

    def over_shape(self) -> int:
        """A helix, a path, a plane or the workspace, with a run folder."""
        from cablewright.apps.report.accuracy import write
        from cablewright.studies import store

        folder = self.out or Path("runs") / store.folder_name("accuracy", self.machine.name, self.shape)
        with store.run_folder(folder) as part, progress() as show:
            found = self._studied(show)
            self._write_inputs(part)
            store.write_places(found, part)
            write(found, part, self.options)
        report = str(folder / "report.html")
        if self.as_json:
            print_json(found.to_dict() | {"report": report})
        else:
            print_study(found, report)
        warn(found.accuracy)
        return 0

    def _studied(self, show: Progress) -> AccuracyStudy:
        from cablewright.studies.accuracy import accuracy as find

        return find(self.machine, self.path or self._places(), self.ranges(), **self.question(show))

    def _places(self) -> Places:
        from cablewright.studies.places import HELIX_STEP, Places

        if self.workspace:
            return Places.workspace(self._step())
        if self.plane is not None:
            return Places.plane(self.machine, self.plane, self.half_width, self._step())
        return Places.helix(self.machine, *self._helix(), HELIX_STEP if self.step is None else self.step)

    def _helix(self) -> tuple[float, float, float, float]:
        values = numbers(self.helix, "--helix") or []
        if len(values) != 4:
            raise InputError(f"--helix = {self.helix!r}: four numbers are wanted, RADIUS,PITCH,Z0,Z1 in m")
        return values[0], values[1], values[2], values[3]

    def _step(self) -> float:
        """The step asked for, or one that goes along the frame's longest side in `STEPS`."""
        if self.step is not None:
            return self.step
        scene = self.machine.scene
        return max(high - low for low, high in zip(scene.frame_min, scene.frame_max, strict=True)) / STEPS

    def _write_inputs(self, part: Path) -> None:
        """Write the manifest."""
        from cablewright.printing.job import load_job
        from cablewright.studies import store

        inputs = {"robot": store.robot_hash(self.robot)}
        if self.uncertainty is not None:
            inputs["uncertainty"] = store.file_hash(self.uncertainty)
        if self.path is not None:
            inputs |= store.job_hashes(self.path, load_job(self.path))
        store.write_manifest(part, "accuracy", inputs, self.options)


accuracy = command(_Accuracy)
