"""A made-up check: the path of a job, errors, tensions and winches of a plausible size."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np

from cablewright.analyses.accuracy.expected_error import ErrorCause, ExpectedError
from cablewright.analyses.feasibility import Finding, LineQuantities
from cablewright.models.statics import Model
from cablewright.printing.job import load_job
from cablewright.printing.layers import LayerTable, layer_table
from cablewright.printing.path import Samples
from cablewright.printing.timing import TimeLaw
from cablewright.robot import Robot, load, loads
from cablewright.robot.uncertainty import ASSUMED, assumed_uncertainty
from cablewright.solvers.swing_free_motion import JobMotion
from cablewright.studies.checks.path_statics import PathStatics
from cablewright.studies.checks.result import Check
from cablewright.studies.checks.sample_errors import SampleErrors

GRAVITY = 9.81

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"

SPIRE = """\
G21
G90
M83
G1 F1200
;LAYER:0 Z:100
G1 Z100
G1 X-500 Y-500
G1 X500 Y-500 E10
G1 X500 Y500 E10
G1 X-500 Y500 E10
G1 X-500 Y-500 E10
;LAYER:1 Z:200
G1 Z200
G1 X400 Y-500 E10
G1 X400 Y400 E10
;LAYER:2 Z:300
G1 Z300
G1 X-400 Y400 E10
"""


def ring_robot(m: int, *, known_winch: bool = False, kind: str = "eyelet", name: str = "ring") -> Robot:
    """m lines from a circle of exit points, under the ceiling of a cube of 10 m."""
    lines = "".join(
        f'[[lines]]\nname = "line {i}"\n'
        f"exit_point = [{5 * math.cos(2 * math.pi * i / m)}, {5 * math.sin(2 * math.pi * i / m)}, 10.0]\n"
        for i in range(m)
    )
    winch = "[winch]\ndrum_radius = 0.1\nmax_speed = 1.0\nmax_torque = 600.0\n" if known_winch else ""
    sheave = '[sheave]\nkind = "swivel"\nradius = 0.05\n' if kind == "swivel" else '[sheave]\nkind = "eyelet"\n'
    return loads(
        f'schema = 1\nname = "{name}"\n[scene]\nframe_min = [-5, -5, 0]\nframe_max = [5, 5, 10]\n'
        '[platform]\nkind = "point"\nmass = 100.0\n'
        "[cable]\naxial_stiffness = 1e6\nlinear_density = 0.03\nbreaking_load = 10000.0\n"
        f"{sheave}{winch}[line]\ntension_limits = [20.0, 5000.0]\n{lines}",
        "ring",
    )


def small_job(folder: Path, text: str = SPIRE, name: str = "spire.gcode"):
    """A job of a few moves."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return load_job(path)


def house_check(robot: Robot | None = None) -> tuple[Check, LayerTable]:
    """The example house on the house printer."""
    return make_check(robot or load("house-printer"), load_job(EXAMPLES / "house.toml"))


def make_check(robot: Robot, job, *, feasible: bool = True) -> tuple[Check, LayerTable]:
    """Plausible numbers for `job` on `robot`; an infeasible one has too low tensions at one end."""
    samples = job.samples(job.toolpath())
    law = job.time_law(samples)
    statics = _statics(robot, samples.positions, law, feasible=feasible)
    check = Check(
        robot=robot,
        job=job,
        samples=samples,
        law=law,
        shaping=_unshaped(samples, law),
        poses=samples.positions,
        retraction=None,
        statics=statics,
        errors=SampleErrors.of(robot, samples, samples.positions, statics),
        findings=tuple(_findings(robot, samples, statics.tensions)),
        toolpath=dataclasses.replace(job.toolpath(), unknown={"M104": 1}),
        travels=(),
        fastest=None,
        slower=(),
        expected=_expected(robot, samples),
        beads=job.beads(job.toolpath()),
        uncertainty=ASSUMED,
        distances=None,
        not_checked=("wind", "interference of lines: switched off"),
        step=0.05,
        chosen=Model(robot),
        verdict="Every sample is within all limits." if feasible else "A line hangs loose in layer 2.",
    )
    return check, layer_table(samples, law)


def _statics(robot: Robot, positions: np.ndarray, law: TimeLaw, *, feasible: bool) -> PathStatics:
    """Plausible statics at `positions`."""
    k, m = len(positions), robot.m
    exits = np.array([line.exit_point for line in robot.lines])
    span = np.linalg.norm(positions[:, None] - exits, axis=2)  # (k, m)
    drop = np.maximum(exits[:, 2] - positions[:, 2:3], 0.3)
    share = np.exp(-span / 8)
    share /= share.sum(axis=1, keepdims=True)
    tensions = robot.platform.mass * GRAVITY * share * span / drop
    if not feasible:
        tensions[:, 0] -= 0.5 * tensions[:, 0].max() * (positions[:, 0] - positions[:, 0].min())
    horizontal = np.linalg.norm(positions[:, :2], axis=1)
    sag = 0.02 + 0.002 * horizontal**2 + 0.001 * positions[:, 2]
    down = np.array([0.0, 0.0, -1.0])
    wobble = np.sin(np.arange(k))[:, None] * 1e-9
    swing = np.arctan2(positions[:, 1:2] - exits[:, 1], positions[:, 0:1] - exits[:, 0])
    swing = np.angle(np.exp(1j * (swing - np.arctan2(-exits[:, 1], -exits[:, 0]))))
    winch = robot.lines[0].winch
    rate = np.gradient(span, axis=0) / np.maximum(np.gradient(law.time), 1e-6)[:, None] if k > 1 else 0 * span
    unknown = np.full((k, m), np.nan)
    return PathStatics(
        codes=np.zeros(k, dtype=np.int64) if feasible else np.where(tensions[:, 0] <= np.median(tensions[:, 0]), 7, 0),
        violations=np.zeros(k),
        tensions=tensions,
        displacement=np.full(k, 2e-3),
        frequency=np.full(k, 1.8),
        plane_force=np.full(k, np.nan),
        lines=LineQuantities(
            lowest_tension=tensions - 4.0,
            highest_tension=tensions + 0.5,
            cable_length=span + 1e-3,
            swing=swing if getattr(robot.lines[0].sheave, "swing", None) else unknown,
            lever=-np.arctan2(drop, span) if getattr(robot.lines[0].sheave, "lever_range", None) else unknown,
            winch_speed=np.clip(np.abs(rate), 0.0, 0.5),
            winch_torque=tensions * winch.drum_radius if winch.drum_radius else unknown,
            sheave_clearance=unknown,
        ),
        rigid_lengths=span,
        lengths=span + 1e-3,
        commanded=span + 1e-3,
        uncompensated=positions + sag[:, None] * down,
        elastic_only=positions + 0.0003 * (1 + positions[:, 2:3] / 3) * down,
        compensated=positions + wobble * down,
    )


def _unshaped(samples: Samples, law: TimeLaw) -> JobMotion:
    """A motion that is not shaped."""
    layers = layer_table(samples, law)
    return JobMotion(samples, law, samples, law.duration, None, np.nan, 'motion.shaping = "none"', layers)


def arrays_of(check: Check) -> dict[str, np.ndarray]:
    """All that the statics of a check say, by name."""
    own = dict(vars(check.statics))
    return own | vars(own.pop("lines"))


def changed(check: Check, arrays: dict[str, np.ndarray], **fields) -> Check:
    """The check with other *arrays* of its statics, and other *fields*."""
    ours = {name: values for name, values in arrays.items() if hasattr(check.statics, name)}
    lines = dataclasses.replace(
        check.statics.lines, **{name: values for name, values in arrays.items() if name not in ours}
    )
    statics = dataclasses.replace(check.statics, lines=lines, **ours)
    samples, poses = fields.get("samples", check.samples), fields.get("poses", check.poses)
    errors = SampleErrors.of(check.robot, samples, poses, statics)
    return dataclasses.replace(check, statics=statics, errors=errors, **fields)


def first_sample(check: Check, layers: LayerTable) -> tuple[Check, LayerTable]:
    """The same check of nothing but the start of the path."""
    kind = type(check.samples)
    samples = kind(**{field.name: getattr(check.samples, field.name)[:1] for field in dataclasses.fields(kind)})
    law = TimeLaw(np.zeros(1), np.zeros(1), 0.0)
    arrays = {name: values[:1] for name, values in arrays_of(check).items()}
    findings = tuple(dataclasses.replace(finding, sample=0) for finding in check.findings)
    poses = check.poses[:1]
    cut = changed(check, arrays, samples=samples, law=law, findings=findings, poses=poses)
    return cut, layer_table(samples, law)


def _expected(robot: Robot, samples) -> ExpectedError:
    """An expected error that grows with the height."""
    rms = 4e-3 + 1e-4 * samples.positions[:, 2]
    tensions = np.array([line.tension_limits for line in robot.lines])
    causes = (ErrorCause("exit_point", 0.9, 2e-3), ErrorCause("modulus", 0.1, 6e-3))
    return ExpectedError(7e-3, int(rms.argmax()), rms, causes, assumed_uncertainty(robot).of(robot), 0.01, 0, tensions)


def _findings(robot: Robot, samples, tensions):
    """As `analyses.feasibility.judge` gives them: one for each limit, of its worst line."""
    low, high = robot.lines[0].tension_limits
    for name, values, margins, bounds in (
        ("lowest tension", tensions - 4.0, tensions - 4.0 - low, (low, np.inf)),
        ("highest tension", tensions, high - tensions, (-np.inf, high)),
    ):
        at, line = np.unravel_index(np.argmin(margins), margins.shape)
        count = int((margins < 0).any(axis=1).sum())
        yield Finding(
            name, "N", float(margins[at, line]), float(values[at, line]), bounds, robot.lines[line].name, int(at), count
        )
    middle = len(samples) // 2
    yield Finding("winch speed", "m/s", 0.54, 0.46, (-np.inf, 1.0), robot.lines[0].name, middle, 0)
    yield Finding("swing", "rad", 0.31, 0.47, (-0.785, 0.785), robot.lines[-1].name, middle, 0)
    yield Finding("frame, z", "m", 0.0, 0.0, (0.0, 15.0), None, 0, 0)
