"""Q and R of a Hangprinter's configuration, by a reader and a law written from the firmware's documentation.

Each drum of RepRapFirmware's Hangprinter turns by k0 (sqrt(R^2 + l k2) - R) steps, in float32, where l is the change of
its anchor's distance since the origin, k2 = -U O Q and k0 = 2 U J micro H / (2 pi L) / k2.
"""

from __future__ import annotations

import math
import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from cablewright.exchange.firmware import Firmware, firmware
from cablewright.exchange.rrf_config import rrf_config
from cablewright.foundation.errors import InputError
from cablewright.machine.drums import drums_of
from cablewright.printing.job import load_job
from cablewright.robot import Robot, load

MICRO = 16
SQUARE = """G21
G90
M83
M104 S210
;LAYER:0
G0 X-{s} Y-{s} Z20 F3000
G1 X{s} Y-{s} E5 F1800
G1 X{s} Y{s} E5
M106 S255
G1 X-{s} Y{s} E5
G1 X-{s} Y-{s} E5
"""


class Config:
    """The words of M669 and M666 of a file, as lists of numbers."""

    def __init__(self, text: str) -> None:
        self.words: dict[str, list[float]] = {}
        for code, rest in re.findall(r"(?m)^(M669|M666) ([^;\n]*)", text):
            for letter, values in re.findall(r"([A-Z])([-0-9.:]+)", rest):
                self.words[code + letter] = [float(each) for each in values.split(":")]
        self.anchors = np.array([self.words[f"M669{letter}"] for letter in "ABCD"])

    def steps(self, points: np.ndarray, single: type = np.float32) -> np.ndarray:
        """Places of the motors (k, 4), steps, before they are rounded to whole ones; *points* (k, 3), mm."""
        f = single
        u, o, teeth_l, teeth_h, full, r = (np.array(self.words["M666" + letter]) for letter in "UOLHJR")
        per_radian = (u * full * MICRO * teeth_h / (2 * np.pi * teeth_l)).astype(f)
        k2 = -(u * o).astype(f) * f(self.words["M666Q"][0])
        k0 = (2.0 * per_radian.astype(float) / k2).astype(f)
        a, at = self.anchors.astype(f), points.astype(f)
        d = np.sqrt(((at[:, None] - a) ** 2)[..., ::-1].cumsum(axis=-1, dtype=f)[..., -1])
        d0 = np.sqrt((a**2)[..., ::-1].cumsum(axis=-1, dtype=f)[..., -1])
        r = r.astype(f)
        return (k0 * (np.sqrt(r * r + (d - d0) * k2) - r)).astype(float)


def exported(tmp_path: Path, robot: Robot, size: int = 100) -> Firmware:
    (tmp_path / "square.gcode").write_text(SQUARE.format(s=size))
    return firmware("reprapfirmware", robot, load_job(tmp_path / "square.gcode"))


def wound(robot: Robot, growth: float | None) -> Robot:
    """Spools whose square of the radius grows by *growth*, mm, per mm of cable; R where the nozzle is at the origin."""
    lines = []
    for line in robot.lines:
        r = line.winch.drum_radius
        assert r is not None
        at = line.advantage * math.dist(line.exit_point, line.platform_point)
        given = {} if growth is None else {"build_up": 0.5e-3 * growth / r**2, "drum_length": at}
        lines.append(line.model_copy(update={"winch": line.winch.model_copy(update=given)}))
    return robot.model_copy(update={"lines": tuple(lines)})


def off(made: Firmware, robot: Robot, growth: float | None) -> float:
    """Largest distance (mm) of the nozzle from the job's path, by the turns that the firmware commands."""
    config = Config(made.files["config.g"])
    ends = 1e3 * made.path.samples.positions
    points = np.concatenate([np.linspace(a, b, 7) for a, b in pairwise(ends)])
    away = points[:, None] - config.anchors
    d = np.linalg.norm(away, axis=2)
    turned = config.steps(points) / (200 * MICRO) * 2 * np.pi  # without a gear
    r = np.array([1e3 * line.winch.drum_radius for line in robot.lines])
    u = np.array([line.advantage for line in robot.lines])
    g = growth or 0.0
    paid = r * turned - 0.25 * g * turned**2  # of cable: the integral of the radius over the angle
    wrong = paid / u - (d - np.linalg.norm(config.anchors, axis=1))
    steps = np.einsum("kji,ki->kj", np.linalg.pinv(away / d[..., None]), wrong)
    return float(np.linalg.norm(steps, axis=1).max())


def told(made: Firmware) -> float:
    return float(re.search(r"the nozzle is up to ([0-9.e-]+) mm off", " ".join(made.lost))[1])


@pytest.mark.parametrize("growth", [None, 1e-4, 0.007, 0.05])
def test_the_nozzle_is_where_the_firmware_puts_it(growth: float | None, tmp_path: Path) -> None:
    robot = wound(load("hangprinter-v4"), growth)
    made = exported(tmp_path, robot)
    config = Config(made.files["config.g"])
    assert config.words["M666Q"][0] > 0.0
    assert np.isfinite(config.steps(np.array([[100.0, 100.0, 20.0]]))).all()
    found = off(made, robot, growth)
    assert found <= 0.2
    assert found == pytest.approx(told(made), rel=0.25, abs=2e-3)


def test_no_other_build_up_is_much_better(tmp_path: Path) -> None:
    """Total error of curvature and rounding, for each Q with radii by least squares."""
    robot = load("hangprinter-v4")
    made = exported(tmp_path, robot)
    text, best = made.files["config.g"], np.inf
    config = Config(text)
    r = np.array([1e3 * line.winch.drum_radius for line in robot.lines])
    for q in map(float, np.geomspace(1e-4, 0.3, 36)):
        trial = Config(text)
        trial.words["M666Q"] = [q]
        radii = r.copy()
        points = 1e3 * made.path.samples.positions
        moved = np.linalg.norm(points[:, None] - config.anchors, axis=2) - np.linalg.norm(config.anchors, axis=1)
        for i in range(4):  # secant of the slope: mean of the turns is right
            for _ in range(6):
                share = np.sqrt(radii[i] ** 2 - 2 * q * moved[:, i])
                bent = 4 * moved[:, i] / (share + radii[i])
                radii[i] *= (bent @ moved[:, i]) / (2 * moved[:, i] / r[i] @ moved[:, i])
        trial.words["M666R"] = list(radii)
        files = dict(made.files)
        lines = re.sub(r"(?m)^M666 Q.*$", f"M666 Q{q!r} R{':'.join(map(repr, map(float, radii)))}", text)
        files["config.g"] = lines
        best = min(best, off(Firmware(files, (), (), made.path), robot, None))
    assert off(made, robot, None) <= 1.15 * best


def test_own_build_up_is_kept_where_it_is_as_good(tmp_path: Path) -> None:
    robot = wound(load("hangprinter-v4"), 0.05)
    config = Config(exported(tmp_path, robot).files["config.g"])
    assert config.words["M666Q"] == [0.05]
    assert config.words["M666R"] == pytest.approx([1e3 * line.winch.drum_radius for line in robot.lines], rel=1e-14)


def test_a_job_too_large_is_rejected(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nozzle is 0\.2.* mm off .*, over 0\.2 mm: give build_up .*export klipper"):
        exported(tmp_path, load("hangprinter-v4"), 360)


def test_numbers_have_no_exponents(tmp_path: Path) -> None:
    """E is a letter of its own in G-code."""
    robot = load("hangprinter-v4")
    x, y, _ = robot.lines[0].exit_point
    first = robot.lines[0].model_copy(update={"tension_limits": (1e-7, 3e3), "exit_point": (x, y, 0.12 + 1e-9)})
    platform = robot.platform.model_copy(update={"mass": 1e-5})
    robot = robot.model_copy(update={"lines": (first, *robot.lines[1:]), "platform": platform})
    drums = drums_of(robot)
    text = rrf_config(robot, drums, None, 200, np.array([(0.1, 0.0, 0.1), (0.0, 0.1, 0.2)])).text
    config = Config(text)
    assert not re.search(r"(?m)^M6.*[0-9]e", text)
    assert config.words["M666I"][0] == 2e-7
    assert config.anchors[0, 2] == pytest.approx(1e-6, abs=1e-9)
    assert config.words["M666W"] == [1e-5]


def test_commands_besides_motion_are_listed(tmp_path: Path) -> None:
    made = exported(tmp_path, load("hangprinter-v4"))
    lost = " ".join(made.lost)
    assert "M104" not in lost  # it is in the file
    assert "shaping" in lost
    for text in made.files.values():
        assert all(f"; lost: {each}\n" in text for each in made.lost)
        assert all(f"; assumed: {each}\n" in text for each in made.assumed)


def test_the_cable_before_the_exit_point_is_a_guy_wire(tmp_path: Path) -> None:
    """M666 Y: length that stretches and does not move; where it is not given the firmware takes its own."""
    robot = load("hangprinter-v4")
    assert Config(exported(tmp_path, robot).files["config.g"]).words["M666Y"] == [0.0] * 4
    lines = tuple(line.model_copy(update={"dead_length": 0.25}) for line in robot.lines)
    config = Config(exported(tmp_path, robot.model_copy(update={"lines": lines})).files["config.g"])
    assert config.words["M666Y"] == [250.0] * 4
