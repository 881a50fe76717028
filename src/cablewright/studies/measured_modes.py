"""Modes identified in a recorded free swing, compared with the model's, and numbers that would explain differences."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize_scalar

from cablewright.analyses.modes import Modes, modes
from cablewright.analyses.swing_identification import PERIODS, IdentifiedModes, identify_swing
from cablewright.foundation.arrays import Array
from cablewright.foundation.choices import SwingSignal
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.foundation.results import Figure, Pictured
from cablewright.robot import Parameter, RigidPlatform, Robot, nominal, parameters_of, with_value
from cablewright.studies.swing_records import SwingRecord, read_swing

FARTHEST: Final = 0.15
"""Largest relative difference of a measured frequency from that of the model with which it is compared."""

_SURE: Final = 2e-3  # relative: the least sigma of a frequency in a fit, as swings of one amplitude and another differ
_OVERTONE: Final = 5e-3  # relative difference of a frequency from a sum of others, within which it may be that sum
_LEAST: Final = 0.05  # share that a number explains; below, it is left out
_FITS: Final = 15  # evaluations of the model for one number

MODES: Final = (
    Figure("frequency", "Hz", "Measured frequency.", digits=5),
    Figure("frequency_sigma", "Hz", "Its standard deviation.", name="sigma", digits=2),
    Figure("model_frequency", "Hz", "The model's; null where none is within 15 %.", name="model", digits=5),
    Figure("difference", "1", "Measured over the model's, less 1.", shown="%", digits=3),
    Figure("damping", "1", "Measured share of critical damping.", shown="%", digits=3),
    Figure("damping_sigma", "1", "Its standard deviation.", name="sigma of damping", shown="%", digits=2),
    Figure("share", "1", "Share of the record's energy; shares of modes close to each other overlap.", shown="%",
           digits=3),
    Figure("dominant", "", "Freedom with the largest share of the mode's kinetic energy in the model."),
    Figure("motion", "", "pendulum or stretch, of the model."),
)  # fmt: skip
EXPLANATIONS: Final = (
    Figure("number", "", "The one number that is changed."),
    Figure("value", "SI", "Its value in the robot file."),
    Figure("fitted", "SI", "Value with which the model's frequencies are nearest to the measured ones."),
    Figure("unit", "", "Unit of both."),
    Figure("explains", "1", "Share of the squared differences that this removes.", shown="%", digits=3),
    Figure("left", "1", "Root mean square of the relative differences that are left.", shown="%", digits=3),
)


@dataclass(frozen=True)
class OneNumberFit:
    """Effect of another value of one *number* on the differences of modes; fields as in `EXPLANATIONS`."""

    number: str
    value: float
    fitted: float
    unit: str
    explains: float
    left: float


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredModes(Pictured):
    """Modes of a swing compared with the model's.

    `matched` (k,): the model's mode of each measured one, -1 for none.
    """

    FIGURES: ClassVar = (
        Figure("robot", "", "Name of the robot.", "model.equilibrium.model.robot.name"),
        Figure("log", "", "The file.", "path"),
        Figure("signal", "", "Readings that were used.", "record.signal"),
        Figure("start", "s", "First time that was used.", "start", digits=5),
        Figure("duration", "s", "Duration of the used record."),
        Figure("rate", "Hz", "Samples a second."),
        Figure("pose", "m, rad", "Pose of the model.", "model.equilibrium.pose"),
        Figure("explained", "1", "Share of the record's energy that the measured modes explain together.",
               "swing.explained", digits=3, shown="%"),
        Figure("measured_damping", "1", "Mean share of critical damping, by energy.", digits=3, shown="%"),
        Figure("damping", "1", "Share of critical damping of the model.", "model.damping.ratio", "damping of the model",
               3, shown="%"),
        Figure("damping_assumed", "", "Whether the robot file gives no damping.", "model.damping.is_assumed",
               detail=True),
        Figure("model_frequencies", "Hz", "All frequencies of the model.", "model.frequencies", detail=True),
        Figure("modes", "", "Measured modes.", "rows", parts=MODES),
        Figure("explanations", "", "Fits of one number each, from 5 % explained on; several may fit.",
               parts=EXPLANATIONS, ranked=True),
        Figure("notes", "", "Missing results, and limits of the fits.", detail=True),
    )  # fmt: skip
    HEADLINES: ClassVar = ("robot", "log", "measured_damping")

    path: str
    record: SwingRecord
    swing: IdentifiedModes
    model: Modes
    matched: tuple[int, ...]
    explanations: tuple[OneNumberFit, ...]

    @property
    def start(self) -> float:
        """First time of the recorded swing, s."""
        return float(self.swing.times[0])

    @property
    def duration(self) -> float:
        """Duration of the recorded swing, s."""
        return float(self.swing.times[-1] - self.swing.times[0])

    @property
    def rate(self) -> float:
        """Samples of the record per second, Hz."""
        return (len(self.record.times) - 1) / float(self.record.times[-1] - self.record.times[0])

    @property
    def measured_damping(self) -> float:
        """Mean damping ratio of the modes, weighted by energy."""
        return float(np.average(self.swing.damping, weights=self.swing.shares))

    @property
    def rows(self) -> tuple[dict[str, Any], ...]:
        """The figures `MODES` of each measured mode."""
        swing, model = self.swing, self.model
        measured = zip(
            swing.frequencies, swing.frequency_sigmas, swing.damping, swing.damping_sigmas, swing.shares, strict=True
        )
        keys = ("frequency", "frequency_sigma", "damping", "damping_sigma", "share")
        return tuple(
            dict(zip(keys, map(float, values), strict=True))
            | (
                {}
                if k < 0
                else {
                    "model_frequency": float(model.frequencies[k]),
                    "difference": float(values[0] / model.frequencies[k] - 1.0),
                    "dominant": model.mostly[k],
                    "motion": model.motion[k],
                }
            )
            for k, values in zip(self.matched, measured, strict=True)
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on modes that were not found, possible overtones, and limits of the fits."""
        return (*self._not_found(), *self._overtones(), *self._of_fits())

    def _not_found(self) -> Iterator[str]:
        low, high = PERIODS / self.duration, 0.5 * self.rate
        for k, frequency in enumerate(self.model.frequencies):
            mode = f"mode {k + 1} of the model, {frequency:.3g} Hz, was not found"
            if k in self.matched:
                continue
            if frequency > high:
                yield f"{mode}: it is over half the sampling rate, {high:.3g} Hz"
            elif frequency < low:
                needed = f"at least {PERIODS / frequency:.3g} s are needed" if frequency > 0.0 else "it is unstable"
                yield f"{mode}: {self.duration:.3g} s hold fewer than {PERIODS:g} periods; {needed}"
            else:
                yield f"{mode}: the swing has little of it, or it is more than {100 * FARTHEST:g} % off"

    def _overtones(self) -> Iterator[str]:
        strong = self.swing.frequencies[np.argsort(-self.swing.shares)[:3]]
        for frequency, share in zip(self.swing.frequencies, self.swing.shares, strict=True):
            sums = [(a + b, a, b) for i, a in enumerate(strong) for b in strong[i:]]
            nearest, a, b = min(sums, key=lambda each: abs(each[0] - frequency))
            if abs(nearest / frequency - 1.0) < _OVERTONE and share < 0.1 * float(self.swing.shares.max()):
                of = f"twice {a:.4g} Hz" if a == b else f"the sum of {a:.4g} and {b:.4g} Hz"
                yield f"{frequency:.4g} Hz is {of}: it may be an overtone of a large swing and no mode"

    def _of_fits(self) -> Iterator[str]:
        count = sum(k >= 0 for k in self.matched)
        if count == 1:
            yield "one frequency was compared: any number that changes it explains it; measure more modes or poses"
        elif self.explanations and self._is_near():
            yield f"the measured frequencies agree with the model's within {100.0 * _SURE:g} % or twice their sigmas"
        elif self.explanations:
            yield f"each fit changes one number to {count} frequencies of one pose: it shows what fits, not the cause"

    def _is_near(self) -> bool:
        """Whether nothing needs an explanation."""
        pairs = [(i, k) for i, k in enumerate(self.matched) if k >= 0]
        measured, of = (np.array(each) for each in zip(*pairs, strict=True))
        off = abs(self.swing.frequencies[measured] - self.model.frequencies[of])
        allowed = np.maximum(2.0 * self.swing.frequency_sigmas[measured], _SURE * self.model.frequencies[of])
        return bool((off <= allowed).all())


def measured_modes(
    robot: Robot,
    path: str | Path,
    pose: ArrayLike | None = None,
    *,
    signal: SwingSignal | None = None,
    span: tuple[float, float] | None = None,
    **laws: Any,
) -> MeasuredModes:
    """Identify modes of a free swing in the log or CSV file at *path*, and compare them with those of *robot* there.

    *pose* (n,), m and rad, with NaN for what gravity decides; by default of a log the mean of its estimates. *signal*
    and *span* as `read_swing`; *laws* as `modes`. Raises `InputError` for a record without a swing or a pose,
    `AnswerError` where the robot does not balance at the pose.
    """
    record = read_swing(Path(path), robot.n, signal, span)
    at = record.pose if pose is None else pose
    if at is None:
        raise InputError(f"{path}: does not say where the platform was: give --at X,Y,Z[,RX,RY,RZ]")
    model = modes(robot, at, **laws)
    if not model.has_modes:
        raise AnswerError(f"the model has no modes there: {model.refusal}")
    highest = float(model.frequencies.max())
    try:
        swing = identify_swing(record.times, record.channels, highest)
    except InputError as fault:
        raise InputError(f"{path}: {fault}") from None
    matched = _matched(swing, model.frequencies)
    return MeasuredModes(
        str(path), record, swing, model, matched, _explanations(robot, at, laws, swing, model, matched)
    )


def _matched(swing: IdentifiedModes, model: Array) -> tuple[int, ...]:
    """Return for each measured mode, the strongest first, the nearest of the model's that is still free, or -1."""
    matched, free = [-1] * len(swing.frequencies), {k for k, each in enumerate(model) if each > 0.0}
    for i in np.argsort(-swing.shares):
        off = {k: abs(np.log(swing.frequencies[i] / model[k])) for k in free}
        if off and min(off.values()) < np.log1p(FARTHEST):
            matched[i] = min(off, key=lambda k: off[k])
            free.discard(matched[i])
    return tuple(matched)


@dataclass(frozen=True)
class _Number:
    """One number that may explain differences: its name, unit, value, range, and the robot with another value."""

    name: str
    unit: str
    value: float
    bounds: tuple[float, float]
    changed: Callable[[float], Robot]


def _explanations(
    robot: Robot, pose: ArrayLike, laws: dict[str, Any], swing: IdentifiedModes, model: Modes, matched: tuple[int, ...]
) -> tuple[OneNumberFit, ...]:
    """Return the fits of one number each, the best first."""
    pairs = [(i, k) for i, k in enumerate(matched) if k >= 0]
    if not pairs:
        return ()
    measured, of = (np.array(each) for each in zip(*pairs, strict=True))
    frequencies = swing.frequencies[measured]
    weights = 1.0 / np.maximum(swing.frequency_sigmas[measured] / frequencies, _SURE)

    def off(scale: float, changed: Robot) -> Array:
        found = model if changed is robot else modes(changed, pose, **laws)
        return np.asarray(np.log(frequencies / scale / np.maximum(found.frequencies[of], 1e-9)))

    def judged(number: str, unit: str, value: float, best: float, left: Array) -> OneNumberFit:
        before = float(((weights * off(1.0, robot)) ** 2).sum())
        share = 1.0 - float(((weights * left) ** 2).sum()) / max(before, 1e-300)
        return OneNumberFit(number, value, best, unit, share, float(np.sqrt((left**2).mean())))

    scale = float(np.exp(np.average(off(1.0, robot), weights=weights**2)))
    found = [judged("all frequencies by one factor", "1", 1.0, scale, off(scale, robot))]
    for each in _numbers(robot):

        def missed(value: float, each: _Number = each) -> float:
            left = off(1.0, each.changed(value))
            return float(((weights * left) ** 2).sum()) if np.isfinite(left).all() else 1e30

        best = float(minimize_scalar(missed, bounds=each.bounds, method="bounded", options={"maxiter": _FITS}).x)
        found.append(judged(each.name, each.unit, each.value, best, off(1.0, each.changed(best))))
    return tuple(sorted((each for each in found if each.explains >= _LEAST), key=lambda each: -each.explains))


def _numbers(robot: Robot) -> Iterator[_Number]:
    """Yield the numbers that change frequencies: payload, centre of mass, inertia, and stiffness of lines."""
    kinds = [parameters_of(robot, "mass"), parameters_of(robot, "modulus", shared=True)]
    kinds += [parameters_of(robot, "modulus")]
    platform = robot.platform
    if isinstance(platform, RigidPlatform):
        size = max(float(np.linalg.norm(line.platform_point)) for line in robot.lines)
        for axis in "xyz":
            (centre,) = parameters_of(robot, f"centre_of_mass.{axis}")
            yield _of_parameter(robot, centre, 0.3 * size)
        yield _Number("inertia", "1", 1.0, (0.4, 2.5), lambda factor: _with_inertia(robot, platform, factor))
    for each in kinds:
        for parameter in each:
            yield _of_parameter(robot, parameter, 0.0)


def _of_parameter(robot: Robot, parameter: Parameter, room: float) -> _Number:
    """Return a number of the registry, *room* to either side of its value, or from 0.4 to 2.5 times it."""
    value = nominal(robot, parameter)
    bounds = (value - room, value + room) if room else (0.4 * value, 2.5 * value)
    return _Number(parameter.label, parameter.unit, value, bounds, lambda other: with_value(robot, parameter, other))


def _with_inertia(robot: Robot, platform: RigidPlatform, factor: float) -> Robot:
    """Return the robot with *factor* times the inertia about the centre of mass of its *platform*."""
    assert platform.inertia is not None  # of which modes were computed
    kinds = {"inertia": platform.inertia, "inertia_products": platform.inertia_products}
    return robot.with_platform(**{key: tuple(factor * each for each in values) for key, values in kinds.items()})
