"""Lengths of a machine's lines by the counts of its winches, kept on disk, and valid once homing has accepted them."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Annotated, ClassVar, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, ValidationError

from cablewright.control.balance_check import CarriedWatch
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.foundation.file_output import write_whole
from cablewright.foundation.reading_times import ReadingTimes
from cablewright.foundation.saved_state import Saved
from cablewright.foundation.signals import Drives, DriveState, Encoders, Estimate, SensorFrame, Tensions, frozen
from cablewright.foundation.toml_input import read_bytes
from cablewright.live.body_estimator import BodyEstimator
from cablewright.live.estimators import DeadReckoning, homed, homed_settings
from cablewright.machine.settings import MachineSettings
from cablewright.machine.winch_counts import CountsFile, Remembering
from cablewright.models.rotation import rotations
from cablewright.robot import Robot
from cablewright.solvers.hanging_path import hung
from cablewright.solvers.inverse import solve_inverse

_MAX_FILE: Final = 1 << 20  # bytes

_Number = Annotated[float, Field(ge=-1e5, le=1e5, allow_inf_nan=False)]


class _File(CountsFile):
    """Content of the file: lengths at counts, and the position of the platform then."""

    lengths: tuple[_Number, ...]
    position: tuple[_Number, _Number, _Number]
    rotation: tuple[_Number, _Number, _Number] | None = None  # of a rigid platform


class LengthKeeper:
    """Lengths at the last homing, by encoder counts.

    They are valid in the epoch of those counts alone, see `Remembering`.
    """

    def __init__(self, path: Path, robot: Robot, settings: MachineSettings) -> None:
        """The file at *path*, which need not be there. Raises `InputError` for one that is damaged or of another."""
        self.path, self.robot = path, robot
        self.reckoning = homed_settings(robot, settings)
        self.tension_error = 0.1 if settings.drives is None else settings.drives.tension_error
        self.machine: Remembering | None = None  # whose counts these are
        self.found: DeadReckoning | BodyEstimator | None = None  # since homing has passed the lengths, in this session
        self.doubt = ""  # why they are not believed any more, until homing passes them again
        self.laid: Callable[[], float] = lambda: 0.0
        """Powder, kg, that has left the drum since it was filled: only a print knows it, by hand the drum is full."""
        self._saved = self._read()

    @property
    def pose(self) -> Array | None:
        """Pose of the platform at the last homing, (n,) m and rad; None: it was never homed."""
        return None if self._saved is None else np.array([*self._saved.position, *(self._saved.rotation or ())])

    def lengths(self, counts: NDArray[np.int64]) -> Array | None:
        """Return lengths (m,), m, at *counts* (w,); None if none are saved, or a drum cannot have turned that much."""
        if self._saved is None or self.machine is None or self._saved.epoch != self.machine.epoch or self.doubt:
            return None
        reckoning = self.reckoning
        turned = reckoning.winches.of_lines(counts - np.array(self._saved.counts)) / reckoning.counts_per_radian
        out = np.array(self._saved.lengths)
        try:
            begin = reckoning.drums.angles(out)
        except InputError:  # beyond the drum's turns
            return None
        paid = reckoning.drums.paid(begin, begin - turned)
        return None if paid is None else np.asarray(out + paid)

    def tensions(self, torques: Array, lengths: Array, expected: Array) -> Array:
        """Return tensions (m,), N, from *torques* (w,), N m, of the drums, with *lengths* (m,), m, paid out.

        *expected* (m,), N: see `WinchLines.tensions`.
        """
        reckoning, arms = self.reckoning, np.zeros(len(lengths))
        for i, (coil, out) in enumerate(zip(reckoning.coils, lengths.tolist(), strict=True)):
            if coil is not None:
                held = min(max(reckoning.total_length - out, 0.0), float(coil.wound[-1]))
                arms[i] = coil.radius(coil.angle(held)) * self.robot.lines[i].cables
        return reckoning.winches.tensions(torques, arms, expected)

    def accept(self, lengths: Array, counts: NDArray[np.int64], pose: Array) -> None:
        """Store lengths (m,), m, that homing has accepted at *counts*, with their *pose* (n,), on disk.

        Raises `AnswerError`.
        """
        self.found, self.doubt = homed(self.reckoning, lengths, counts, pose), ""
        lines = [line.name for line in self.robot.lines]
        assert self.machine is not None
        content = {"schema": 2, "robot": self.robot.name, "lines": lines, "epoch": self.machine.epoch}
        content["counts"] = counts.tolist()
        content |= {"lengths": lengths.tolist(), "position": pose[:3].tolist()}
        if turn := pose[3:].tolist():
            content["rotation"] = turn
        text = json.dumps(content)
        self._saved = _File.model_validate_json(text)
        write_whole(self.path, text.encode() + b"\n")

    def _read(self) -> _File | None:
        if not self.path.exists():
            return None
        try:
            found = _File.model_validate_json(read_bytes(self.path, _MAX_FILE, "saved lengths"))
        except ValidationError as error:
            first = error.errors(include_url=False, include_context=False)[0]
            where = ".".join(map(str, first["loc"])) or "the file"
            raise InputError(f"{self.path}: {where}: {first['msg']}; remove it and home the machine again") from None
        lines = tuple(line.name for line in self.robot.lines)
        counted = len(found.counts), len(found.lengths)
        if (found.robot, found.lines) != (self.robot.name, lines) or counted != (self.robot.winches, self.robot.m):
            raise InputError(f"{self.path}: holds lengths of {found.robot!r}, lines {', '.join(found.lines)}")
        turns = len(found.rotation or ())
        if 3 + turns != self.robot.n:
            what = "a rotation, which no point has" if turns else "no rotation, which a rigid platform has"
            raise InputError(f"{self.path}: rotation: holds {what}; remove the file and home the machine again")
        return found


class KeptEstimator:
    """The estimator of a real machine; positions are valid once it was homed.

    Nothing of it is saved with a print: it starts again by homing.
    """

    SAVED: ClassVar[Saved] = ()

    def __init__(self, keeper: LengthKeeper, guess: Array) -> None:
        """*guess* (n,), m and rad: the reported pose while it is unknown."""
        self._keeper, self._guess = keeper, guess
        self._carried = CarriedWatch(keeper.reckoning.model, keeper.tension_error)
        self._times = ReadingTimes()
        self._lengths: Array | None = None  # (m,) m, of the last estimate

    def step(self, frame: SensorFrame) -> Estimate:
        """Return the estimate after one frame; see `Estimator.step`."""
        found = self._keeper.found
        if found is not None:
            estimate = found.step(self._at_radii(frame))
            self._lengths = estimate.lengths
            if not self._doubts(frame, estimate):
                return estimate
        m = len(self._keeper.robot.lines)
        lengths = None
        for reading in frame.of(Encoders):
            counted = len(reading.counts) == self._keeper.robot.winches
            lengths = self._keeper.lengths(reading.counts) if counted else None
        unknown = frozen(np.full(m, np.nan))
        return Estimate(
            frame.time,
            frozen(self._guess[:3]),
            frozen(np.zeros(3)),
            frozen(rotations(self._guess)),
            unknown if lengths is None else frozen(lengths),
            unknown,
            np.zeros(m, dtype=bool),
            frozen([math.nan if coil is None else coil.radii[0] for coil in self._keeper.reckoning.coils]),
            valid=False,
        )

    def _at_radii(self, frame: SensorFrame) -> SensorFrame:
        """A frame with tensions at the radii at which cable leaves: drives show those at the smallest."""
        keeper, out = self._keeper, self._lengths
        if out is None or not frame.of(Tensions) or not np.isfinite(out).all():
            return frame
        unknown = np.full(len(out), np.nan)  # of lines on one drum
        readings = [
            replace(each, tensions=frozen(keeper.tensions(each.torques, out, unknown)))
            if isinstance(each, Tensions) and each.torques is not None
            else each
            for each in frame.readings
        ]
        return replace(frame, readings=tuple(readings))

    def _doubts(self, frame: SensorFrame, estimate: Estimate) -> bool:
        """Whether the lines do not carry the platform where it is reckoned to be: it is homed again then."""
        keeper = self._keeper
        pulls = [each for each in frame.of(Tensions) if self._times.is_new(each.source, each.time, frame.time)]
        if not all(state is DriveState.ENABLED for each in frame.of(Drives) for state in each.states):
            self._carried.forget()  # brakes carry it
        elif (
            pulls
            and self._carried.is_due(frame.time)
            and estimate.valid
            and pulls[-1].torques is not None
            and self.tensions is not None
        ):
            tensions = keeper.tensions(pulls[-1].torques, estimate.lengths, self.tensions)
            pose = np.concatenate([estimate.position, estimate.rotation])[: keeper.robot.n]
            keeper.doubt = self._carried.judge(pose, tensions, frame.time, keeper.laid())
            if keeper.doubt:
                keeper.found = None
                self._carried.forget()
        return bool(keeper.doubt)

    @property
    def tensions(self) -> Array | None:
        """Return the tensions at the sheaves (m,), N, at the estimated lengths; see `Estimator.tensions`."""
        found = self._keeper.found
        return None if found is None else found.tensions

    @property
    def measured(self) -> Array | None:
        """Return the tensions (m,), N, by the torques of the drives, smoothed; see `Measuring.measured`."""
        found = self._keeper.found
        return found.measured if isinstance(found, DeadReckoning) else None

    @property
    def danger(self) -> str:
        """Reason why the machine must stop, by the estimator of a rigid platform; empty: none."""
        found = self._keeper.found
        return "" if found is None else found.danger

    @property
    def searches(self) -> bool:
        """Return whether the estimator still searches for the cause of the danger."""
        found = self._keeper.found
        return found is not None and found.searches


def warm(keeper: LengthKeeper, pose: Array) -> None:
    """Compile or load the kernels of estimation and homing, before a machine waits for them. Raises `AnswerError`."""
    from cablewright.control.length_check import check_lengths
    from cablewright.solvers.continuation import Tracker

    reckoning = keeper.reckoning
    held = solve_inverse(reckoning.model, hung(reckoning.model, pose[None]))[0].checked()
    lengths, counts = held.lengths, np.zeros(keeper.robot.winches, dtype=np.int64)
    begun = homed(reckoning, lengths, counts, held.pose)
    for now in (0.01, 0.02, 0.2):  # the last one ends a measurement of a rigid platform
        readings = (Encoders(now, counts), Tensions("motor_torques", now, held.tensions))
        begun.step(SensorFrame(now, readings))
    check_lengths(reckoning.model, lengths, np.full(len(lengths), 100.0), held.pose)
    try:
        Tracker(reckoning.model, lengths, begin=held).step(lengths)
    except AnswerError:
        return  # reported on request
