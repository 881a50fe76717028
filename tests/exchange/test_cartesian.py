"""A job back to its owner's firmware: what the file keeps, and where the firmware's own arithmetic brings the nozzle.

Replicas of RepRapFirmware's and Klipper's laws are written here from their documentation, RepRapFirmware's in float32.
"""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

import cablewright as cw
from cablewright.apps.cli.main import run
from cablewright.exchange import rrf_spool
from cablewright.exchange.firmware import firmware, plain_gcode
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.machine.drums import drums_of
from cablewright.printing.job import Job, load_job
from cablewright.robot import Robot, load
from cablewright.robot.new_robot import Outline
from cablewright.studies.new_robot import new_robot
from exchange.test_hangprinter_config import Config, wound
from exchange.vase import vase

MICRO = 16


@pytest.fixture(scope="module")
def job(tmp_path_factory: pytest.TempPathFactory) -> Job:
    path = tmp_path_factory.mktemp("vase") / "vase.gcode"
    path.write_text(vase(4, 40))
    return load_job(path)


@pytest.fixture(scope="module", params=["hangprinter-v4", "over-middle"])
def built(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Robot:
    """The Hangprinter of the library, and what `new` makes with lines over the middle."""
    if request.param != "over-middle":
        return load(request.param)
    folder = tmp_path_factory.mktemp("starter") / "own"
    new_robot(Outline(name="own", layout="over-middle"), folder)
    return load(folder / "robot.toml")


@pytest.fixture(scope="module", params=[(3, 24), pytest.param((260, 280), marks=pytest.mark.slow)], ids=["few", "3-MB"])
def whole(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Job:
    """A vase of three layers, and one of 3 MB, as its slicer writes it."""
    path = tmp_path_factory.mktemp("whole") / "vase.gcode"
    path.write_text(vase(*request.param))
    return load_job(path)


def moves(text: str) -> np.ndarray:
    """Places (k, 3), mm, to which a file goes, from its G92 or its first place on."""
    at, found = {}, []
    for line in text.splitlines():
        words = dict(re.findall(r"([XYZ])(-?[0-9.]+)", line.partition(";")[0]))
        if words and line.startswith(("G0", "G1", "G92")):
            at |= words
            found.append([float(at[axis]) for axis in "XYZ"])
    return np.array(found)


def fed(text: str) -> float:
    """Filament, mm, of a file with M83."""
    return sum(float(each) for each in re.findall(r"(?m)^G[01] [^;\n]*E(-?[0-9.]+)", text))


@pytest.mark.parametrize("name", ["reprapfirmware", "klipper"])
def test_a_job_keeps_the_commands_of_its_file(name: str, job: Job) -> None:
    made = firmware(name, load("hangprinter-v4"), job)
    text = made.files["job.g" if name == "reprapfirmware" else "job.gcode"]
    assert job.gcode is not None
    source = job.gcode.read_text()
    for line in ("M140 S60", "M104 S210", "M190 S60", "M109 S210", "M106 S0", "M106 S255", "M107", "M104 S0",
                 "; thumbnail begin 16x16 24", "; iVBORw0KGgoAAAANSUhEUgAA", ";WIDTH:1.2"):  # fmt: skip
        assert re.search(rf"(?m)^{line}$", text), line
    assert [line for line in text.splitlines() if line.startswith((";LAYER", ";Z:"))] == [
        line for line in source.splitlines() if line.startswith((";LAYER", ";Z:"))
    ]
    assert fed(text) == pytest.approx(fed(source), abs=1e-4)
    assert text.count("G1 E-0.80000") == text.count("G1 E0.80000") == 4
    assert ("M486 S0" in text) is (name == "reprapfirmware")
    assert ("EXCLUDE_OBJECT_START NAME=vase" in text) is (name == "klipper")
    body = "\n".join(line for line in text.splitlines() if not line.startswith(";"))
    assert not re.search(r"M84|M81|M201|START_PRINT|G28", body)
    lost = " ".join(made.lost)
    assert "M84 (1): motors stay on" in lost
    assert "M81 (1): supply stays on" in lost
    assert "M201 (1): limits of the motion" in lost
    assert "START_PRINT (1)" in lost


def test_commands_stay_where_they_are(job: Job) -> None:
    text = firmware("reprapfirmware", load("hangprinter-v4"), job).files["job.g"]
    at = [text.index(each) for each in ("M109 S210", "M106 S0", "Z:0.60", "Z:1.20", "M106 S255", "Z:1.80", "M104 S0")]
    assert at == sorted(at)
    second = text.index(";Z:1.20")
    assert text.index("G1 E-0.80000", second) < text.index("G1 X", second)


def test_a_larger_part_is_reported_in_strand(tmp_path: Path) -> None:
    (tmp_path / "vase.gcode").write_text(vase(2, 12))
    (tmp_path / "job.toml").write_text('schema = 1\nname = "v"\ngcode = "vase.gcode"\nscale = 2.0\n')
    made = firmware("reprapfirmware", load("hangprinter-v4"), load_job(tmp_path / "job.toml"))
    assert "E is mm of strand that is laid" in " ".join(made.lost)
    assert "\nM82\nG92 E0\n" in made.files["job.g"]


@pytest.mark.parametrize("version", ["3.5", "3.7", "klipper"])
def test_line_lengths_in_the_firmware(version: str, built: Robot, whole: Job) -> None:
    """In float32 each line is as long as the straight distance to 0.1 mm, over the whole job."""
    if version == "klipper":
        made, _ = plain_gcode("klipper", built, whole)
        at, (anchors, turns) = moves(made.files["job.gcode"]), klipper_anchors(made.files["printer.cfg"])
        apart = np.linalg.norm(at[:, None] - anchors, axis=2)
        paid = np.round((apart - apart[0]) / turns * 200 * MICRO) / (200 * MICRO) * turns
        assert np.abs(paid - (apart - apart[0])).max() < 0.1
        return
    made = firmware("reprapfirmware", built, whole, version=version)
    config, at = Config(made.files["config.g"]), moves(made.files["job.g"])
    if version == "3.7":
        assert config.words["M666Q"] == [0.0]
        radii = np.array(config.words["M666R"], np.float32)
        steps = straight_steps(config, at, radii)
    else:
        steps = config.steps(at)
    assert np.isfinite(steps).all()
    turned = np.round(steps) / (200 * MICRO) * 2.0 * np.pi
    paid = turned * [1e3 * (line.winch.drum_radius or 0.0) for line in built.lines] / config.words["M666U"]
    distance = np.linalg.norm(at[:, None] - config.anchors, axis=2) - np.linalg.norm(config.anchors, axis=1)
    assert np.abs(paid - distance).max() < 0.1


def klipper_anchors(text: str) -> tuple[np.ndarray, np.ndarray]:
    """Anchors (m, 3), mm, and by how much a turn of each winch moves the nozzle along its line, mm."""
    sections = re.findall(r"anchor_x: (\S+)\nanchor_y: (\S+)\nanchor_z: (\S+)\nrotation_distance: (\S+)", text)
    numbers = np.array(sections, float)
    return numbers[:, :3], numbers[:, 3]


def straight_steps(config: Config, at: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """Places of motors where Q is 0, in 3.7: steps for mm at the origin, times the line's position, in float32."""
    f = np.float32
    anchors, u = config.anchors.astype(f), np.array(config.words["M666U"])
    d = np.sqrt(((at.astype(f)[:, None] - anchors) ** 2).sum(axis=-1, dtype=f))
    d0 = np.sqrt((anchors**2).sum(axis=-1, dtype=f))
    per_mm = ((u * 200 * MICRO / (2 * np.pi)).astype(f) / radii).astype(f)
    return np.asarray((d - d0) * per_mm, float)


@pytest.mark.parametrize(("dialect", "version"), [("rrf", "3.5"), ("rrf", "3.7"), ("klipper", None)])
def test_the_nozzle_is_on_the_path_by_the_firmware_alone(
    dialect: str, version: str | None, built: Robot, whole: Job
) -> None:
    """From the files: whole steps of the motors, the lengths that they pay out, and where those hold the nozzle."""
    robot = built
    made, found = plain_gcode(dialect, robot, whole, version=version)  # type: ignore[arg-type]
    text = made.files["job.g" if dialect == "rrf" else "job.gcode"]
    at = moves(text)
    if dialect == "rrf":
        config = Config(made.files["config.g"])
        radii = np.array(config.words["M666R"], np.float32)
        steps = config.steps(at) if config.words["M666Q"][0] else straight_steps(config, at, radii)
        turned = np.round(steps - steps[0]) / (200 * MICRO) * 2.0 * np.pi
        assert "M666 W" not in made.files["config.g"]
    else:
        anchors, turns = klipper_anchors(made.files["printer.cfg"])
        apart = np.linalg.norm(at[:, None] - anchors, axis=2) / turns
        turned = np.round((apart - apart[0]) * 200 * MICRO) / (200 * MICRO) * 2.0 * np.pi
    first = cw.inverse(robot, at[0] / 1e3, preferred=found.first, cable="catenary")
    radius = np.array([line.winch.drum_radius for line in robot.lines], float)
    wanted = firmware("reprapfirmware", robot, whole).path.samples.positions
    held = cw.forward(robot, first.lengths + radius * turned, guess=wanted)
    off = np.linalg.norm(held.pose - wanted, axis=1)
    assert len(at) == len(wanted)
    assert off.max() < 2e-4
    assert found.error < 2e-4
    limits = np.array([line.tension_limits for line in robot.lines])
    assert (held.tensions > limits[:, 0] - 0.5).all()
    assert (held.tensions < limits[:, 1] + 0.5).all()
    assert found.difference < 1e-2


@pytest.mark.parametrize("dialect", ["rrf", "klipper"])
def test_the_nozzle_is_on_the_path_over_most_of_the_reach(dialect: str, tmp_path: Path) -> None:
    """Within 0.2 mm from the bed to 0.4 m over it, 0.6 m wide, where X Y Z as they are would be twice that off."""
    text, s = "G21\nG90\nM83\n;LAYER:0\n", 300.0
    for z in (5.0, 200.0, 400.0):
        text += f"G0 X{-s} Y{-0.8 * s} Z{z} F6000\n"
        for x, y in ((s, -0.3 * s), (s, 0.8 * s), (-s, 0.8 * s), (-s, -0.3 * s)):
            text += f"G1 X{x} Y{y} E9 F3000\n"
    (tmp_path / "wide.gcode").write_text(text)
    made, found = plain_gcode(dialect, load("hangprinter-v4"), load_job(tmp_path / "wide.gcode"))  # type: ignore[arg-type]
    assert found.error < 2e-4
    assert found.without > 4e-4
    assert made.files


def test_a_body_keeps_its_lines(tmp_path: Path) -> None:
    """Of a body that does not rotate a line is as long as from a point to its exit point less its platform point."""
    robot = load("cogiro")
    (tmp_path / "s.gcode").write_text("G21\nG90\nM83\n;LAYER:0\nG0 X0 Y0 Z1500 F3000\nG1 X200 Y0 E9\nG1 X200 Y200 E9\n")
    lines = tuple(
        line.model_copy(update={"winch": line.winch.model_copy(update={"drum_radius": 0.1})}) for line in robot.lines
    )
    made, found = plain_gcode("klipper", robot.model_copy(update={"lines": lines}), load_job(tmp_path / "s.gcode"))
    assert found.error < 2e-4
    x = re.search(r"anchor_x: (\S+)", made.files["printer.cfg"])
    line = robot.lines[0]
    assert x is not None
    expected = 1e3 * (line.exit_point[0] - line.platform_point[0] + robot.platform.nozzle[0])
    assert float(x[1]) == pytest.approx(expected, abs=1e-9)


def test_tensions_beyond_their_limits_are_rejected(job: Job) -> None:
    robot = load("hangprinter-v4").limited((12.0, 18.5))
    with pytest.raises(AnswerError, match=r"computes give line .* tension_limits are 12 to 18.5 N: export klipper"):
        plain_gcode("rrf", robot, job)


def test_more_lines_than_anchors(job: Job) -> None:
    robot = load("hangprinter-v4")
    more = tuple(
        robot.lines[k % 4].model_copy(
            update={"name": f"L{k}", "exit_point": tuple(c + 0.05 * k for c in robot.lines[k % 4].exit_point)}
        )
        for k in range(9)
    )
    with pytest.raises(InputError, match="has 9 lines; the own kinematics of rrf has 3 to 8"):
        plain_gcode("rrf", robot.model_copy(update={"lines": more}), job)
    six = robot.model_copy(update={"lines": more[:6]})
    with pytest.raises(InputError, match=r"RepRapFirmware 3\.6 has up to 5 anchors: give --firmware-version 3\.7"):
        firmware("reprapfirmware", six, job, version="3.6")
    made = firmware("reprapfirmware", six, job)
    assert re.search(r"M669 A\S+ B\S+ C\S+ D\S+ I\S+ J\S+ P", made.files["config.g"])
    assert "RepRapFirmware 3.7; --firmware-version takes another" in made.assumed


def randomly_built(number: np.random.Generator) -> Robot:
    robot = load("hangprinter-v4")
    lines = []
    for line in robot.lines:
        away = np.array(line.exit_point) * number.uniform(0.3, 3.0) + number.normal(0.0, 0.1, 3)
        winch = line.winch.model_copy(update={"drum_radius": float(number.uniform(0.02, 0.2))})
        update = {"exit_point": tuple(map(float, away)), "winch": winch, "advantage": int(number.integers(1, 5))}
        lines.append(line.model_copy(update=update))
    built = robot.model_copy(update={"lines": tuple(lines)})
    growth = [None, 10.0 ** number.uniform(-6.0, 0.0)][int(number.integers(2))]
    return wound(built, growth)


def finite_of(robot: Robot, number: np.random.Generator) -> bool | None:
    """Whether the firmware's places of motors are finite for the written file; None without one."""
    at = number.uniform(-0.4, 0.4, (3, 3))
    drums = drums_of(robot)
    squares = [
        2e3 * drum.build_up * drum.radius**2 / line.cables for drum, line in zip(drums, robot.lines, strict=True)
    ]
    try:
        law = rrf_spool.spool_law(robot, drums, at, squares[0])
    except InputError:  # of a spool that is empty there, or a law with too large errors
        return None
    spans = np.array([line.advantage for line in robot.lines], float)
    anchors = 1e3 * np.array([line.exit_point for line in robot.lines])
    turned = rrf_spool.in_firmware(1e3 * at, anchors, np.array(law.radii), law.growth, spans, np.ones(4))
    return law.growth > 0.0 and bool(np.isfinite(turned).all())


@pytest.mark.parametrize("count", [60, pytest.param(10_000, marks=pytest.mark.slow)])
def test_no_robot_has_motors_without_a_place(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rrf_spool, "_POINTS", 24)
    monkeypatch.setattr(rrf_spool, "CANDIDATES", rrf_spool.CANDIDATES[::8])
    number = np.random.default_rng(67)
    found = [finite_of(randomly_built(number), number) for _ in range(count)]
    assert False not in found
    assert found.count(True) > 0.5 * count


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "vase.gcode").write_text(vase(2, 12))
    part, out = str(tmp_path / "vase.gcode"), str(tmp_path / "out")
    assert run(["export", "gcode", "hangprinter-v4", part, "--for", "rrf", "--out", out, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert 0.0 < answer["nozzle_error"] < 2e-4
    for words, why in (
        (["gcode"], "--for = None: must be rrf or klipper"),
        (["klipper", "--for", "rrf"], "--for = rrf: must be left out"),
        (["klipper", "--tolerance", "20 kg"], "--tolerance"),
        (["klipper", "--tolerance", "20"], "must be under 1 m; a number alone is in m"),
        (["reprapfirmware", "--gear", "20"], "teeth of motor and spool, each 1 to 10000, like 20:255"),
    ):
        command = ["export", words[0], "hangprinter-v4", part, "--out", str(tmp_path / "no"), *words[1:]]
        assert run(command) == 2
        assert why in capsys.readouterr().err
    command = ["export", "klipper", "hangprinter-v4", part, "--out", str(tmp_path / "k"), "--tolerance", "20 um"]
    assert run(command) == 0
    geared = ["export", "reprapfirmware", "hangprinter-v4", part, "--out", str(tmp_path / "g"), "--gear", "20:255"]
    assert run([*geared, "--full-steps", "25"]) == 0
    config = Config((tmp_path / "g" / "config.g").read_text())
    assert config.words["M666L"] == [20.0] * 4
    assert config.words["M666H"] == [255.0] * 4
    assert config.words["M666J"] == [25.0] * 4
    assert math.isfinite(answer["points"])
