"""A complete configuration of LinuxCNC, and a job in its simulated motion where it is installed."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from pathlib import Path
from tempfile import gettempdir

import numpy as np
import pytest

import cablewright as cw
from cablewright.exchange.firmware import firmware
from cablewright.printing.job import load_job
from cablewright.robot import load
from exchange.vase import vase

DRIVER = """#!/usr/bin/python3
import json, sys, time, linuxcnc
c, s = linuxcnc.command(), linuxcnc.stat()
c.state(linuxcnc.STATE_ESTOP_RESET); c.wait_complete()
c.state(linuxcnc.STATE_ON); c.wait_complete()
c.mode(linuxcnc.MODE_MANUAL); c.wait_complete(); c.teleop_enable(0); c.wait_complete()
c.home(-1)
end = time.time() + 20
while time.time() < end:
    s.poll()
    if all(s.homed[: s.joints]): break
    time.sleep(0.05)
found = {"homed": list(s.homed[: s.joints]), "at": list(s.joint_actual_position[: s.joints])}
c.teleop_enable(1); c.wait_complete()
c.mode(linuxcnc.MODE_AUTO); c.wait_complete(); c.program_open("job.ngc"); c.auto(linuxcnc.AUTO_RUN, 0)
rows, idle, end = [], 0, time.time() + 120
while time.time() < end and idle < 100:
    s.poll()
    rows.append([s.current_vel, *s.joint_actual_position[: s.joints]])
    idle = idle + 1 if s.interp_state == linuxcnc.INTERP_IDLE and len(rows) > 200 else 0
    time.sleep(0.004)
errors, e = [], linuxcnc.error_channel()
while True:
    got = e.poll()
    if not got: break
    errors.append(got[1])
json.dump(found | {"rows": rows, "errors": errors, "line": s.motion_line}, open("found.json", "w"))
"""


def test_the_configuration_is_complete(tmp_path: Path) -> None:
    """Every joint is homed where it stands, its limits hold the job, and every file that is named is there."""
    (tmp_path / "vase.gcode").write_text(vase(2, 24))
    made = firmware("linuxcnc", load("hangprinter-v4"), load_job(tmp_path / "vase.gcode"), complete=True)
    ini = made.files["machine.ini"]
    sections = re.findall(r"(?m)^\[(\w+)\]", ini)
    needed = ["EMC", "DISPLAY", "TASK", "RS274NGC", "EMCMOT", "EMCIO", "HAL", "KINS", "TRAJ"]
    assert sections[: len(needed)] == needed
    assert len(sections) == len(set(sections))
    for key in ("PARAMETER_FILE", "TOOL_TABLE", "HALFILE"):
        named = re.search(rf"(?m)^{key} = (\S+)$", ini)
        assert named is not None
        assert named[1] in made.files
    joints = re.findall(r"\[JOINT_(\d)\]\n(.*?)(?=\n\n|\Z)", ini, re.DOTALL)
    assert len(joints) == 7
    start = [*(1e3 * made.path.samples.positions[0]), 0.0, 0.0, 0.0, 0.0]
    for k, body in joints:
        values = dict(re.findall(r"(\w+) = (\S+)", body))
        assert float(values["HOME"]) == float(values["HOME_OFFSET"]) == pytest.approx(start[int(k)], abs=1e-4)
        assert values["HOME_SEARCH_VEL"] == values["HOME_LATCH_VEL"] == "0"
        assert float(values["MIN_LIMIT"]) < float(values["HOME"]) < float(values["MAX_LIMIT"])
        assert f"joint.{k}.motor-pos-cmd => joint.{k}.motor-pos-fb" in made.files["machine.hal"]
    plain = firmware("linuxcnc", load("hangprinter-v4"), load_job(tmp_path / "vase.gcode"))
    assert set(plain.files) == {"machine.ini", "job.ngc"}


@pytest.mark.skipif(shutil.which("linuxcnc") is None, reason="needs LinuxCNC (Debian: linuxcnc-uspace)")
def test_a_job_runs_in_its_simulated_motion(tmp_path: Path) -> None:
    """Joints are homed, winches are within a microstep of the model all along, and the nozzle does not stop."""
    robot = load("hangprinter-v4")
    (tmp_path / "part.gcode").write_text(
        "G21\nG90\nM83\n;LAYER:0\nG0 X-60 Y0 Z5 F3000\nG1 X60 Y0 E5 F1800\nG1 X60 Y60 E5\nG1 X-60 Y60 E5\n"
    )
    made = firmware("linuxcnc", robot, load_job(tmp_path / "part.gcode"), complete=True)
    for name, text in made.files.items():
        (tmp_path / name).write_text(text.replace("DISPLAY = axis", f"DISPLAY = {tmp_path / 'driver.py'}"))
    (tmp_path / "driver.py").write_text(DRIVER)
    (tmp_path / "driver.py").chmod(0o755)
    surroundings = os.environ | {"HOME": str(tmp_path), "RTAPI_FIFO_PATH": f"{gettempdir()}/rtapi_{os.getpid()}"}
    if os.geteuid() == 0:  # which LinuxCNC does not run as
        surroundings |= {"RTAPI_UID": "65534"}
    done = subprocess.run(
        ["linuxcnc", str(tmp_path / "machine.ini")], cwd=tmp_path, env=surroundings, timeout=240, check=False,
        capture_output=True, text=True,
    )  # fmt: skip
    assert (tmp_path / "found.json").is_file(), done.stdout[-2000:] + done.stderr[-2000:]
    found = json.loads((tmp_path / "found.json").read_text())
    assert found["errors"] == []
    assert all(found["homed"])
    rows = np.array(found["rows"])
    places, turned = rows[:, 1:4] / 1e3, np.radians(rows[:, 4:])
    assert np.linalg.norm(places[-1] - made.path.samples.positions[-1]) < 1e-4
    radius = np.array([line.winch.drum_radius for line in robot.lines], float)
    first = cw.inverse(robot, made.path.samples.positions[0]).lengths
    off = (cw.inverse(robot, places).lengths - first) / radius - turned
    assert np.abs(off).max() < 2.0 * np.pi / (200 * 16)
    laying = places[:, 2] > 4.999e-3
    middle = laying & (np.abs(places[:, 0]) < 0.05)
    assert rows[middle, 0].min() > 0.5 * rows[middle, 0].max()
