"""`calibrate`, `simulate-calibration`: parameters of a robot from measurements at poses, and simulated data."""

from __future__ import annotations

import json
from dataclasses import replace
from datetime import UTC, datetime
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

import cablewright as cw
from cablewright.apps.cli.command import command, options
from cablewright.apps.cli.options import AsJson, CalibrationPlanFile, Limits, RobotName, Seed
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import check_suffix, quantity, tension_range
from cablewright.foundation.errors import InputError
from cablewright.foundation.file_output import write_whole
from cablewright.foundation.units import LENGTH
from cablewright.models.fidelity import CableLaw


@options("Check")
class CheckOptions:
    """Options of the check whether anything moved since a calibration."""

    check: Annotated[
        bool,
        typer.Option(
            "--check",
            help="Do not calibrate: test whether the machine has changed since the last calibration of ROBOT, and at "
            "which line.",
        ),
    ] = False
    last: Annotated[
        Path | None,
        typer.Option(
            "--last",
            metavar="FILE.toml",
            help="Record of the last calibration, with which --check compares; by default ROBOT.calibration.toml "
            "beside ROBOT.toml, which --out writes.",
        ),
    ] = None
    false_alarm: Annotated[
        float,
        typer.Option("--false-alarm", help="Probability that --check reports a change although nothing has changed."),
    ] = 0.01
    new_home: Annotated[
        bool,
        typer.Option(
            "--new-home",
            help="The lengths were zeroed again after the last calibration: --check does not test the home lengths.",
        ),
    ] = False


@options("Guide")
class GuideOptions:
    """Options of the guide to the next calibration poses."""

    guide: Annotated[
        bool,
        typer.Option(
            "--guide",
            help="Report the accuracy reached by the poses in DATA.csv (none if it is absent), "
            "the poses to measure next, and when to stop. Writes no robot.",
        ),
    ] = False
    count: Annotated[int, typer.Option("--next", help="Number of poses that --guide proposes to measure next.")] = 4
    limits: Limits = None
    next_out: Annotated[
        Path | None,
        typer.Option(
            "--next-out",
            metavar="FILE.csv",
            help="CSV file to write, with the poses to measure next and their encoder counts.",
        ),
    ] = None
    plot: Annotated[
        Path | None,
        typer.Option(
            "--plot",
            metavar="FILE",
            help="Picture of --guide to write, .png, .svg or .pdf: the room with the next poses and the camera.",
        ),
    ] = None

    def __post_init__(self) -> None:
        """Reject other kinds of files, and a picture of anything else. Raises `InputError`."""
        check_suffix(self.plot, "--plot", ".png", ".svg", ".pdf")
        if self.plot is not None and not self.guide:
            raise InputError("--plot: is the picture of --guide; a calibration has its pictures in --report")


@options("Pictures")
class PictureOptions:
    """Options of pictures of tags that a camera took at the poses."""

    pictures: Annotated[
        Path | None,
        typer.Option(
            "--pictures", metavar="FOLDER", help="Pictures of tags at the poses; names end with the pose: pose-07.jpg."
        ),
    ] = None
    camera: Annotated[
        Path | None,
        typer.Option("--camera", metavar="CAMERA.toml", help="The camera: what `camera` wrote, or a file of OpenCV."),
    ] = None
    tags: Annotated[
        Path | None, typer.Option("--tags", metavar="TAGS.toml", help="Layout of the tags, as for `tags`.")
    ] = None

    def taken_so_far(self, data: Path, machine: cw.Robot) -> tuple[Path | cw.Measured | None, cw.Sightings | None]:
        """Return the *data*, and the sightings, both as far as there are any yet. Raises `InputError`."""
        from cablewright.calibration.guidance.pictures_to_take import sightings_so_far

        if self.pictures is None or self.camera is None or self.tags is None:
            found = self.beside(data, machine)  # rejects some of the three without the others
            return found if data.exists() else None, None
        with progress() as show:
            return sightings_so_far(machine, data, self.pictures, self.tags, self.camera, show)

    def beside(self, data: Path, machine: cw.Robot) -> Path | cw.Measured:
        """Return the *data* with the sightings of tags in the pictures, if there are any.

        Raises `InputError` where one of the three options is missing.
        """
        from cablewright.calibration.measurements import read_measured

        given = {"--pictures": self.pictures, "--camera": self.camera, "--tags": self.tags}
        missing = [name for name, value in given.items() if value is None]
        if self.pictures is None or self.camera is None or self.tags is None:
            if len(missing) < len(given):
                raise InputError(f"{missing[0]}: is missing; pictures require --pictures, --camera and --tags")
            return data
        measured = read_measured(data, machine)
        with progress() as show:
            seen = cw.read_sightings(self.pictures, self.tags, self.camera, len(measured.counted), progress=show)
        return replace(measured, sightings=seen)


class Models(StrEnum):
    """Choice of the effects in the model: of the plan file (file), or also those that cross-validation finds (auto)."""

    FILE = "file"
    AUTO = "auto"


@options()
class FitOptions:
    """Options of `calibrate` on the data and the cable model."""

    data: Annotated[
        Path,
        typer.Argument(metavar="DATA.csv", help="CSV file with columns dl_1 .. dl_m: length changes since home, m."),
    ]
    datum: Annotated[
        str | None,
        typer.Option(
            "--datum",
            metavar="SPEC",
            help="Exit points or coordinates that keep their values in the robot file, to fix the frame, like "
            "south-west,south-east.y; `inner` (the default) keeps the mean position and rotation of all exit "
            "points.",
        ),
    ] = None
    plan: CalibrationPlanFile = None
    rough: Annotated[float, typer.Option("--rough", help="Largest error of the exit points in the robot file, m.")] = (
        0.5
    )
    cable: Annotated[
        CableLaw, typer.Option("--cable", help="Cable law; elastic and catenary need tensions or measured poses.")
    ] = CableLaw.RIGID
    models: Annotated[
        Models,
        typer.Option(
            "--models",
            help="Model to calibrate: that of the plan file (file), or that model with the effects that "
            "cross-validation finds (auto).",
        ),
    ] = Models.FILE
    keep_all: Annotated[
        bool, typer.Option("--keep-all", help="Use all rows of the data: do not search for gross errors.")
    ] = False
    need: Annotated[
        str,
        typer.Option("--need", metavar="L", help="Required standard deviation of exit points: m, or like '2 mm'."),
    ] = "2 mm"

    def planned(self) -> cw.CalibrationPlan:
        """Return the plan of --plan, or of the TOML file with the data's name; --datum replaces their datum."""
        from cablewright.calibration.plan import load_plan
        from cablewright.foundation.toml_input import read_table

        file, beside = self.plan, self.data.with_suffix(".toml")
        if file is None and beside != self.data and beside.is_file() and "lines" not in read_table(beside)[0]:
            file = beside  # not a robot's file of the same name
        plan = cw.CalibrationPlan() if file is None else load_plan(file)
        if self.datum is None:
            return plan
        parts = tuple(part.strip() for part in self.datum.split(","))
        if plan.datum and set(plan.datum) != set(parts):
            raise InputError(f"--datum = {self.datum!r}: {file} has datum = {list(plan.datum)}; give one of them")
        return plan.model_copy(update={"datum": parts})

    def needed(self) -> float:
        """The standard deviation of exit points that printing needs, m. Raises `InputError`."""
        return quantity(self.need, "--need", LENGTH)


@command(
    "calibrate wang2021 examples/calibration.csv --accept",
    "calibration.judgement.result:Calibration",
    "calibration.drift.drift:Drift",
    "calibration.guidance.guided_calibration:Guidance",
)
def calibrate_command(
    *,
    robot: RobotName,
    fit: FitOptions,
    accept: Annotated[
        bool, typer.Option("--accept", help="Accept a doubtful result: write the robot file and end with exit code 0.")
    ] = False,
    seen: PictureOptions,
    since: CheckOptions,
    guidance: GuideOptions,
    seed: Seed = 0,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE.toml", help="Robot file to write, with the calibrated values.")
    ] = None,
    report: Annotated[
        Path | None,
        typer.Option(
            "--report", metavar="FILE.html", help="HTML report to write; by default beside the file of --out."
        ),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Estimates exit points, home lengths and other unknowns with sigmas, and lists unobservable directions.

    The verdict is good, doubtful or bad. A doubtful one is a no (exit 1) without --accept; a bad one is always a no and
    writes no robot. --out also writes a record, FILE.calibration.toml, for later comparison (--check).
    """
    from cablewright.calibration.drift.record import record_of, record_path, record_text
    from cablewright.robot import file_text, update

    machine = cw.load(robot)
    if since.check and guidance.guide:
        raise InputError("--check and --guide: give one of them, not both")
    if since.check:
        last = _record(robot, since.last)
        if last is None:
            beside = f"there is no record of a calibration beside {robot}"
            raise InputError(f"--check: {beside}; name it with --last, or calibrate with --out")
        data = seen.beside(fit.data, machine)
        drift = cw.check_drift(machine, data, last, false_alarm=since.false_alarm, new_home=since.new_home)
        return answer(drift, as_json)
    if guidance.guide:
        if out is not None or report is not None:
            raise InputError("--guide: writes no robot and no report; leave --out and --report away")
        return _guide(machine, fit, seen, guidance, seed, as_json)
    page = report or (None if out is None else out.with_suffix(".html"))
    if out is not None and page is not None and page.resolve() == out.resolve():
        raise InputError(
            f"--out {out}: the report would have the same file name; give the name of a robot file, FILE.toml"
        )
    found = _compared(replace(_found(machine, fit, seen, seed), accepted=accept), _record(robot, since.last))
    out = out if found.ok else None
    page = report or (None if out is None else out.with_suffix(".html"))
    record = None if out is None else record_path(out)
    texts: dict[Path, str] = {}
    if page is not None:
        from cablewright.apps.report.calibration import calibration_page

        texts[page] = calibration_page(found, fit.data.name)
    if out is not None and record is not None:
        texts[out] = update(file_text(robot), found.robot)
        texts[record] = record_text(record_of(found, fit.data, datetime.now(UTC)))
    for file, text in texts.items():
        write_whole(file, text.encode())
    return answer(found, as_json, out=out, record=record, report=page)


def _found(machine: cw.Robot, fit: FitOptions, seen: PictureOptions, seed: int) -> cw.Calibration:
    """The calibration."""
    data = seen.beside(fit.data, machine)
    with progress() as show:
        return cw.calibrate(
            machine,
            data,
            fit.planned(),
            seed=seed,
            rough=fit.rough,
            cable=fit.cable,
            outliers=not fit.keep_all,
            need=fit.needed(),
            models=fit.models.value,
            progress=show,
        )


def _record(robot: str, last: Path | None) -> Path | None:
    """The record of the last calibration: that named, or else that beside the robot's file, if it is there."""
    from cablewright.calibration.drift.record import record_path

    beside = record_path(robot)
    # a robot of the library has no record
    return last or (beside if Path(robot).suffix == ".toml" and beside.is_file() else None)


def _compared(found: cw.Calibration, file: Path | None) -> cw.Calibration:
    """The same, compared with the last calibration, if there is a record of one."""
    from cablewright.calibration.drift.record import compared, load_record

    if file is None or found.verdict == "bad" or found.posterior.redundancy < 1:
        return found
    record = load_record(file)
    told = f"{record.date.isoformat(timespec='minutes')}, {record.data}"
    return replace(found, last=told, moved=compared(found, record))


def _guide(
    machine: cw.Robot, fit: FitOptions, seen: PictureOptions, given: GuideOptions, seed: int, as_json: bool
) -> int:
    """Which poses to measure next."""
    from cablewright.calibration.measurements import write_measured

    data, sightings = seen.taken_so_far(fit.data, machine)
    with progress() as show:
        found = cw.guide(
            machine,
            data,
            fit.planned(),
            count=given.count,
            need=fit.needed(),
            rough=fit.rough,
            tension_limits=tension_range(given.limits),
            sightings=sightings,
            seed=seed,
            progress=show,
        )
    if given.next_out is not None and found.next_poses:
        comments = (f"poses to measure next of {machine.name}; counts are as far as it is known",)
        write_whole(given.next_out, write_measured(found.to_measure, machine, comments).encode())
    if given.plot is not None:
        found.plot(given.plot)
    return answer(found, as_json, next_out=given.next_out if found.next_poses else None, plot=given.plot)


@options("Noise")
class NoiseOptions:
    """Standard deviations of the simulated measurements."""

    noise: Annotated[
        float,
        typer.Option("--noise", help="Standard deviation of the simulated encoder readings, as cable length in m."),
    ]
    guess: Annotated[
        float, typer.Option("--guess", help="Maximum error of the guessed positions x,y,z that the file contains, m.")
    ] = 0.05
    tension_noise: Annotated[
        float | None,
        typer.Option("--tension-noise", help="Also simulate measured tensions, with this standard deviation, N."),
    ] = None
    swivel_noise: Annotated[
        float | None,
        typer.Option(
            "--swivel-noise",
            help="Also simulate measured swivel angles of the sheaves, with this standard deviation, rad.",
        ),
    ] = None
    tilt_noise: Annotated[
        float | None,
        typer.Option(
            "--tilt-noise",
            help="Also simulate the measured tilt of a rigid platform, with this standard deviation, rad.",
        ),
    ] = None
    yaw_noise: Annotated[
        float | None,
        typer.Option(
            "--yaw-noise", help="Also simulate the measured yaw of a rigid platform, with this standard deviation, rad."
        ),
    ] = None
    frequency_noise: Annotated[
        float | None,
        typer.Option(
            "--frequency-noise",
            help="Also simulate the measured frequencies of the free cable spans, with this standard deviation, Hz.",
        ),
    ] = None
    pose_noise: Annotated[
        float | None,
        typer.Option(
            "--pose-noise",
            help="Simulate measured poses with this standard deviation, m and rad, instead of guessed positions.",
        ),
    ] = None


@command(
    "simulate-calibration wang2021 --poses 14 --noise 1e-4 --out runs/simulated.csv",
    "calibration.poses.simulation:SimulatedCalibration",
)
def simulate_calibration_command(
    *,
    robot: RobotName,
    poses: Annotated[int, typer.Option("--poses", help="Number of simulated poses; the first is the home pose.")],
    out: Annotated[
        Path, typer.Option("--out", metavar="FILE.csv", help="CSV file to write, with the simulated measurements.")
    ],
    seed: Seed = 0,
    cable: Annotated[
        CableLaw, typer.Option("--cable", help="Cable law of the lines that are simulated.")
    ] = CableLaw.RIGID,
    noises: NoiseOptions,
    truth: Annotated[
        Path | None,
        typer.Option("--truth", metavar="FILE.json", help="JSON file to write, with the true poses and home lengths."),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """ROBOT is the true robot. The first pose is home. Columns x,y,z of the file are start values, not data."""
    from cablewright.calibration.measurements import write_measured

    machine, given = cw.load(robot), noises
    sensors = cw.SensorNoise(
        given.tension_noise,
        given.swivel_noise,
        given.tilt_noise,
        given.pose_noise,
        given.yaw_noise,
        given.frequency_noise,
    )
    made = cw.simulate_calibration(
        machine, poses, given.noise, seed=seed, guess=given.guess, cable=cable, sensors=sensors
    )
    lines = "" if cable == "rigid" else f", {cable} lines"
    guesses = f"x,y,z are guesses within {given.guess:g} m of the poses, not data"
    comments = (
        f"simulated: {poses} poses of {machine.name}{lines}, encoder noise {given.noise:g} m",
        f"seed {seed}",
        guesses if given.pose_noise is None else "poses are measured",
        *(f"{what} noise {value:g}, SI" for what, value in vars(sensors).items() if value is not None),
    )
    write_whole(out, write_measured(made.measured, machine, comments).encode(), parents=True)
    if truth is not None:
        true = {"schema": 1, "poses": made.poses.tolist(), "home_lengths": made.home_lengths.tolist()}
        write_whole(truth, (json.dumps(true) + "\n").encode())
    return answer(made, as_json, out=out)
