"""`print`: a job printed in closed loop on a simulated machine, in a run folder from which it can be resumed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import typer

from cablewright.apps.cli.options import (
    AsJson,
    Estimator,
    JobFile,
    LayerCount,
    MachineName,
    Period,
    Plant,
    RobotName,
    Seed,
    Severity,
)
from cablewright.apps.cli.output import answer, progress, tell
from cablewright.apps.cli.parsing import quantity
from cablewright.choices import HeightRule, LawName
from cablewright.errors import InputError


@dataclass(frozen=True, kw_only=True)
class PrintJobCommand:
    """A machine file that names drives moves a real machine, by orders that are typed: docs/drives.md.

    The run folder gets the log, the figures (metrics.json), a report and the structure as a mesh.

    A print that was interrupted resumes with --resume and the same options. The answer is no (exit 1) if the machine
    stops before the end of the job.
    """

    EXAMPLE: ClassVar = (
        "print merlet2023 examples/blind-machines.toml --layers 1 --plant quasi-static --out runs/example"
    )
    ANSWERS: ClassVar = (
        "studies.prints.print_job:PrintedJob",
        "studies.prints.result:StateUse",
        "studies.prints.print_job:LearntLine",
    )

    robot: RobotName
    job: JobFile
    machine: MachineName = None
    layers: LayerCount = None
    estimator: Estimator = None
    control: Annotated[
        LawName,
        typer.Option("--control", help="Control law: of Merlet and Papegay 2023, or by the machine's model."),
    ] = "model"
    height: Annotated[
        HeightRule | None,
        typer.Option(
            "--height",
            help="Height kept over the structure, or that of the job; by default structure if a lidar sees it.",
        ),
    ] = None
    plant: Plant = "dynamic"
    severity: Severity = None
    period: Period = 1.0
    seed: Seed = 0
    intrusions: Annotated[
        int, typer.Option("--intrusions", metavar="N", help="Number of simulated light-barrier interruptions.")
    ] = 0
    place_layers: Annotated[
        int,
        typer.Option(
            "--place-layers",
            metavar="N",
            help="Stop after each N layers and measure where the platform is, for encoders alone; by default never.",
        ),
    ] = 0
    place_sigma: Annotated[
        str, typer.Option("--place-sigma", metavar="D", help="Standard deviation of that in each coordinate.")
    ] = "1 mm"
    place_every: Annotated[
        str | None,
        typer.Option(
            "--place-every", metavar="T", help="Measure it where the path begins, and each T of time; by default never."
        ),
    ] = None
    place_stops: Annotated[
        int,
        typer.Option("--place-stops", metavar="S", help="Stop at S places each time, spread evenly along one layer."),
    ] = 1
    place_learn: Annotated[
        bool,
        typer.Option(
            "--place-learn", help="Learn from all places how far each line is off, and how much it creeps and gives."
        ),
    ] = False
    place_tensions: Annotated[
        bool, typer.Option("--place-tensions", help="Correct what a place leaves open of lengths by measured tensions.")
    ] = False
    real_time: Annotated[bool, typer.Option("--real-time", help="Wait in each step until its time has come.")] = False
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Run folder; by default runs/print-ROBOT-JOB.")
    ] = None
    resume: Annotated[bool, typer.Option("--resume", help="Resume the print in the run folder.")] = False
    restart: Annotated[
        bool, typer.Option("--restart", help="Print again from the beginning in the run folder of the same print.")
    ] = False
    as_json: AsJson = False

    def run(self) -> int:
        """Print, write the report, and show the figures."""
        from cablewright.apps.report import print as report
        from cablewright.printing.job import load_job
        from cablewright.robot import load
        from cablewright.studies.prints.plan import PrintOptions
        from cablewright.studies.prints.print_job import print_job
        from cablewright.studies.store import folder_name
        from cablewright.units import DURATION, LENGTH

        if self.resume and self.restart:
            raise InputError("print: --resume or --restart, not both")
        if self._is_real():
            return self._print_on_drives()
        name = load_job(self.job).name
        folder = self.out or Path("runs") / folder_name("print", load(self.robot).name, self.job.stem)
        options = PrintOptions(
            self.estimator, self.control, self.height, self.layers, self.plant, self.period, self.seed,
            self.intrusions, self.severity, place_layers=self.place_layers,
            place_sigma=quantity(self.place_sigma, "--place-sigma", LENGTH), place_tensions=self.place_tensions,
            place_every=0.0 if self.place_every is None else quantity(self.place_every, "--place-every", DURATION),
            place_stops=self.place_stops, place_learn=self.place_learn,
        )  # fmt: skip
        try:
            with progress() as show:
                found = print_job(
                    self.robot,
                    self.job,
                    folder,
                    machine=self.machine,
                    options=options,
                    resume=self.resume,
                    restart=self.restart,
                    real_time=self.real_time,
                    progress=show,
                )
                show("writing report", 0, 1)
                found = found.with_report(report.write(found.record, folder, name, found.step_times))
        except KeyboardInterrupt:
            tell(f"cablewright: interrupted; --out {folder} --resume with the same options resumes the print")
            raise
        return answer(found, self.as_json)

    def _is_real(self) -> bool:
        """Whether the machine file names real drives."""
        from cablewright.machine.files import load_machine

        return self.machine is not None and load_machine(self.machine).kind != "simulated"

    def _print_on_drives(self) -> int:
        """Print on the drives of the machine file, by orders that a person types."""
        from cablewright.apps.cli.drives.machine_file import load_real
        from cablewright.apps.cli.drives.orders import typed_orders
        from cablewright.apps.report import print as report
        from cablewright.printing.job import load_job
        from cablewright.robot import load
        from cablewright.studies.drives.printing import print_on_drives
        from cablewright.studies.store import folder_name, job_hashes, robot_hash

        assert self.machine is not None
        self._require_real()
        robot, job = load(self.robot), load_job(self.job)
        folder = self.out or Path("runs") / folder_name("print", robot.name, self.job.stem)
        inputs = {"robot": robot_hash(self.robot), **job_hashes(self.job, job)}
        with typed_orders() as operator:
            found = print_on_drives(
                robot,
                job,
                folder,
                load_real(self.machine, robot),
                Path(self.machine).with_suffix(""),
                operator,
                inputs=inputs,
                law=self.control,
                layers=self.layers,
                resume=self.resume,
                restart=self.restart,
                say=tell,
            )
        page = report.write(found.record, folder, job.name, found.step_times)
        return answer(found.with_report(page), self.as_json)

    def _require_real(self) -> None:
        """Refuse options of simulations. Raises `InputError`."""
        for option, given, usual in (
            ("--plant", self.plant, "dynamic"),
            ("--seed", self.seed, 0),
            ("--period", self.period, 1.0),
            ("--intrusions", self.intrusions, 0),
            ("--place-layers", self.place_layers, 0),
            ("--place-sigma", self.place_sigma, "1 mm"),
            ("--place-every", self.place_every, None),
            ("--place-stops", self.place_stops, 1),
            ("--place-learn", self.place_learn, False),
            ("--place-tensions", self.place_tensions, False),
            ("--real-time", self.real_time, False),
        ):
            if given != usual:
                raise InputError(f"{option}: is for simulated machines; {self.machine} names real drives")
        for option, value, only in (("--estimator", self.estimator, "encoders"), ("--height", self.height, "job")):
            if value not in (None, only):
                raise InputError(f"{option} = {value}: on real drives it is {only}")
