"""Record of a calibration beside the robot's file: date, data, values and sigmas, to compare later measurements with.

A later calibration is compared with it: which exit points moved by more than both sigmas explain. Both are moved onto
one another by the best translation and yaw, which encoders do not determine.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Annotated, Final, Self

import numpy as np
import tomlkit
from pydantic import Field, Strict, model_validator

from cablewright.calibration.judgement.likely_changes import Evidence, Explanation, Suspect, beside
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.judgement.sigmas import kind_of
from cablewright.calibration.measurement_rows.measurement_kinds import ON_ONE_DRUM, SIGMA_OF
from cablewright.calibration.plan import SIGMAS, CalibrationPlan, Group, Known, Sigmas
from cablewright.calibration.poses.observability import azimuth_offsets, motions, open_freedoms
from cablewright.calibration.poses.problem import CalibrationProblem
from cablewright.calibration.sightings.sighted import SightedUnknown
from cablewright.calibration.unknowns import Unknown, is_in_file, unknowns_of
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.toml_input import load_model
from cablewright.foundation.validation import Description, FileDescription, refusal
from cablewright.models.fidelity import CableLaw
from cablewright.models.rotation import wrap_angles
from cablewright.robot import Robot
from cablewright.robot.parameters import nominal

_MAX_UNKNOWNS: Final = 500
_AGREES: Final = 1e-8  # m: numbers in a robot's file are rounded to a nanometre
_Number = Annotated[float, Strict(), Field(allow_inf_nan=False)]
LEVEL: Final = 0.01
"""The share of comparisons that say that something moved though nothing did."""

_SHIFTS: Final = ("translation", "yaw")  # beginnings of their names
_ROUNDING: Final = 1e-8  # m: of numbers in a robot's file


class KnownValue(Description):
    """Value and standard deviation, SI, of an unknown in a calibration record. No line: all lines share it."""

    name: str
    line: str | None = None
    value: _Number
    sigma: Annotated[_Number, Field(ge=0)]


class CalibrationRecord(FileDescription):
    """The file of a calibration for later drift checks: values, their covariance, and the data of the fit.

    ``sigma``: standard deviation of the sensors, from their residuals. ``redundancy``: the redundant numbers from which
    the encoders' sigma is estimated; absent where it was given. ``considered``: numbers that count as known, by their
    errors. ``on_drum``: factor by which residuals raised the sigma of lines on one drum. ``covariance``: the rows of
    the lower triangle of that of values and considered, SI.
    """

    robot: str
    date: datetime
    data: str
    sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
    verdict: str
    cable: CableLaw
    poses: Annotated[int, Strict(), Field(ge=1)]
    redundancy: Annotated[int, Strict(), Field(ge=1)] | None = None
    unknowns: Annotated[tuple[str, ...], Field(min_length=1, max_length=20)]
    shared: Annotated[tuple[str, ...], Field(max_length=20)] = ()
    groups: Annotated[tuple[Group, ...], Field(max_length=_MAX_UNKNOWNS)] = ()
    known: Annotated[tuple[Known, ...], Field(max_length=_MAX_UNKNOWNS)] = ()
    sigma: Sigmas
    on_drum: Annotated[float, Strict(), Field(ge=1.0, allow_inf_nan=False)] = 1.0
    values: Annotated[tuple[KnownValue, ...], Field(min_length=1, max_length=_MAX_UNKNOWNS)]
    considered: Annotated[tuple[KnownValue, ...], Field(max_length=_MAX_UNKNOWNS)] = ()
    covariance: Annotated[tuple[tuple[_Number, ...], ...], Field(max_length=2 * _MAX_UNKNOWNS)]

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        if self.sigma.encoder is None:
            raise refusal("sigma.encoder", "is missing")
        if [len(row) for row in self.covariance] != [at + 1 for at in range(len(self.values) + len(self.considered))]:
            raise refusal("covariance", "must be the lower triangle: a row for each of values and considered")
        values = np.linalg.eigvalsh(self.spread)
        if values[0] < -1e-6 * max(values[-1], 0.0):
            raise refusal("covariance", "is none: it has a negative variance")
        return self

    @property
    def spread(self) -> Array:
        """The covariance (k + q, k + q) of values and considered, SI."""
        found = np.zeros((len(self.covariance), len(self.covariance)))
        for at, row in enumerate(self.covariance):
            found[at, : at + 1] = found[: at + 1, at] = row
        return found

    @property
    def amounts(self) -> Array:
        """The values of the unknowns (k,), SI."""
        return np.array([each.value for each in self.values])

    @property
    def freedom(self) -> float:
        """Number of degrees of freedom from which the encoders' sigma was estimated; inf where it was given."""
        return math.inf if self.redundancy is None else float(self.redundancy)

    @property
    def plan(self) -> CalibrationPlan:
        """The plan of later measurements: the same unknowns, and the sigmas of the record."""
        named = {name: getattr(self, name) for name in ("unknowns", "shared", "groups", "known", "sigma")}
        return CalibrationPlan(**named)

    def unknowns_in(self, robot: Robot, where: str) -> tuple[Unknown, ...]:
        """Return the unknowns of *robot*. Raises `InputError` if it is not the robot whose calibration this is."""
        found = unknowns_of(robot, self.unknowns, self.shared, self.cable is not CableLaw.RIGID, self.plan.grouped)
        hung, known_of = {robot.lines[at].name for at in robot.hung}, {(each.name, each.line) for each in self.values}
        found = tuple(each for each in found if each.line not in hung or (each.kind, each.line) in known_of)
        own = self.values[: len(found)]  # those of camera and tags come last
        if [(each.kind, each.line) for each in found] != [(each.name, each.line) for each in own]:
            raise InputError(f"{where}: values are not those of {robot.name!r}, in its order of lines")
        for each, known in zip(found, own, strict=True):
            if is_in_file(robot, each) and each.name != "modulus":
                now = nominal(robot, each)
                if abs(now - known.value) > _AGREES * max(1.0, abs(known.value)):
                    raise InputError(
                        f"{where}: {each.label} is {known.value:.9g}, and {now:.9g} in the robot's file: give the file "
                        "that this calibration wrote"
                    )
        return found

    def weighed(self, problem: CalibrationProblem) -> CalibrationProblem:
        """Return the problem with the record's sigma of lines on one drum.

        Raises `InputError` for tensions that show an exit point of which the record knows nothing.
        """
        told = {(each.name, each.line) for each in (*self.values, *self.considered)}
        for each in problem.unknowns:
            if each.name in self.unknowns and (each.kind, each.line) not in told:
                raise InputError(
                    f"{problem.measured.origin}: the record knows nothing of line {each.line!r}, whose counterweight "
                    "tensions f_1 .. show: leave these columns out, or calibrate with tensions first"
                )
        weights = problem.weights.copy()
        problem.of_poses(weights)[:, kind_of(problem) == ON_ONE_DRUM] /= self.on_drum
        return replace(problem, weights=weights)


def record_of(found: Calibration, data: str | Path, date: datetime) -> CalibrationRecord:
    """Return the record of a calibration of the file *data*, made at *date*.

    Raises `InputError` for a calibration without sigmas.
    """
    if found.verdict == "bad" or not np.isfinite(found.covariance).all():
        raise InputError(
            f"{data}: a calibration without standard deviations gives no record for --check; measure more poses"
        )
    plan, factors = found.problem.plan, found.problem.factors
    sizes = {key: getattr(plan.sigma, key) * factors.get(kind, 1.0) for kind, key in SIGMA_OF.items()}
    sizes["encoder"] = found.encoder_sigma
    if found.problem.measured.frequencies is not None:  # they are tensions there
        sizes["frequency"] = plan.sigma.frequency * factors.get("tensions", 1.0)
    sigma = Sigmas(**{key: float(np.clip(size, *SIGMAS)) for key, size in sizes.items()})
    told = zip(found.unknowns, found.values.tolist(), found.sigma.tolist(), strict=True)
    return CalibrationRecord(
        robot=found.problem.robot.name,
        date=date,
        data=Path(data).name,
        sha256=hashlib.sha256(Path(data).read_bytes()).hexdigest(),
        verdict=found.verdict,
        cable=CableLaw(found.problem.cable),
        poses=found.problem.poses,
        redundancy=max(found.posterior.redundancy, 1) if plan.sigma.encoder is None else None,
        unknowns=plan.unknowns,
        shared=plan.shared,
        groups=plan.groups,
        known=plan.known,
        sigma=sigma,
        on_drum=factors.get(ON_ONE_DRUM, 1.0),
        values=tuple(KnownValue(name=one.kind, line=one.line, value=value, sigma=s) for one, value, s in told),
        considered=tuple(
            KnownValue(name=each.name, line=each.line, value=each.value, sigma=each.sigma)
            for each in found.doubt.considered
        ),
        covariance=tuple(tuple(row[: at + 1]) for at, row in enumerate(found.joint_covariance.tolist())),
    )


def record_text(record: CalibrationRecord) -> str:
    """Return the text of the TOML file of a calibration record."""
    table = record.model_dump(mode="json", by_alias=True, exclude_none=True)
    table["date"] = record.date
    return tomlkit.dumps(table)


def record_path(robot: str | Path) -> Path:
    """Return the path of the record of a robot's file: ``mine.calibration.toml`` for ``mine.toml``."""
    return Path(robot).with_suffix(".calibration.toml")


def load_record(path: str | Path) -> CalibrationRecord:
    """Read a calibration record from its TOML file.

    Raises `InputError`, one line naming file, key, value and the allowed range.
    """
    return load_model(CalibrationRecord, path)


def compared(found: Calibration, last: CalibrationRecord, level: float = LEVEL) -> Explanation:
    """Return the changes of the unknowns from the *last* calibration to a new one.

    Raises `InputError` where they have no unknown in common.
    """
    before = {(each.name, each.line): at for at, each in enumerate(last.values)}
    both = [
        (at, before[each.kind, each.line])
        for at, each in enumerate(found.unknowns)
        if each.name not in ("length_offset", "modulus")
        and not isinstance(each, SightedUnknown)
        and (each.kind, each.line) in before
    ]
    if not both:
        raise InputError("the last calibration has no unknown in common with this one")
    new, old = (np.array(side) for side in zip(*both, strict=True))
    named = motions(found.alone)
    open_ones = set(open_freedoms(found.alone))
    free = [motion[new] for name, motion in named.items() if name.startswith(_SHIFTS) or name in open_ones]
    kept = beside(np.array(free).reshape(len(free), len(new)).T)
    change = found.values[new] - last.amounts[old]
    around = azimuth_offsets([found.unknowns[at] for at in new]) > 0.0
    change[around] = wrap_angles(change[around])  # the same zero a turn away
    spread = found.covariance[np.ix_(new, new)] + last.spread[np.ix_(old, old)]
    size = np.eye(kept.shape[1]) * _ROUNDING**2
    freedom = min(float(max(found.posterior.redundancy, 1)), last.freedom)
    suspects = list(_suspects(found, new, kept))
    return Evidence(kept.T @ change, kept.T @ spread @ kept + size, suspects, freedom).explained(level)


def _suspects(found: Calibration, which: Array, kept: Array) -> Iterator[Suspect]:
    """Yield what may have changed: each exit point, and each other unknown."""
    unknowns = [found.unknowns[at] for at in which.tolist()]
    points = [(each.name, each.line) for each in unknowns if each.axis is not None]
    for name, line in dict.fromkeys(points):
        own = [at for at, each in enumerate(unknowns) if (each.name, each.line) == (name, line)]
        yield Suspect(name.replace("_", " "), line, kept[own].T, len(set(points)))
    alone = [at for at, each in enumerate(unknowns) if each.axis is None]
    for at in alone:
        yield Suspect(unknowns[at].name.replace("_", " "), unknowns[at].line, kept[[at]].T, len(alone))
