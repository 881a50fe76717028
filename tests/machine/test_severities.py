"""Severities: `ideal` is the machine without them, and each sets the truth and the owner's settings."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from cablewright.foundation.choices import SeverityName
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.signals import Command
from cablewright.machine.files import load_machine, machine_text
from cablewright.machine.log.head import LogHead, read_head, written_head
from cablewright.machine.log.messages import encode
from cablewright.machine.sensors.tensions import TensionSensor
from cablewright.machine.settings import ClockSettings
from cablewright.machine.simulated.settings import load_twin
from cablewright.machine.simulated.severities import severity_of, with_severity
from cablewright.machine.simulated.severity_tables import OWN, PARTS, SEVERITIES
from cablewright.robot import load
from twins import SETTINGS, SIMULATION, TWIN, changed, machine

CELLS = TensionSensor(rate=100.0, deviation=1.0, bias=2.0, most=1000.0)
MEASURED = TWIN.with_owner(load_cells=CELLS)


def with_key(key: str, table: str = "simulation") -> str:
    text = machine_text("merlet2023")
    assert f"\n[{table}]" in text
    return text.replace(f"\n[{table}]", f"\n[{table}]\n{key}\n#", 1)


@pytest.mark.parametrize("plant", ["dynamic", "quasi-static"])
def test_ideal_is_the_machine_without_a_severity(plant: str) -> None:
    plain, ideal = machine(MEASURED, 3, plant), machine(with_severity(MEASURED, "ideal"), 3, plant)
    for _ in range(200):
        command = Command(plain.time, np.array([0.3, -0.3, 0.1, 0.0]) * math.cos(0.4 * plain.time), 1.0)
        frames = plain.step(command), ideal.step(command)
        told = [[encode(each, "abcd", 1024) for each in frame.readings] for frame in frames]
        assert told[0] == told[1]
        assert encode(plain.truth, "abcd", 1024) == encode(ideal.truth, "abcd", 1024)
    assert with_severity(TWIN, "ideal") == TWIN
    assert with_severity(with_severity(TWIN, "rough"), "ideal") == TWIN


@pytest.mark.parametrize(
    ("name", "numbers"),
    [
        ("typical", (1e-3, 0.1, 2e-3, 10e-6, 0.5, 0.05, 0.2, 0.005)),
        ("rough", (2e-3, 0.3, 10e-3, 50e-6, 1.5, 0.2, 2.0, 0.02)),
    ],
)
def test_a_severity_sets_the_truth_and_the_owner_s_settings(name: SeverityName, numbers: tuple[float, ...]) -> None:
    wall, turn, offset, drift, bias, people, gap, gain = numbers
    made = with_severity(MEASURED, name)
    law, owner = made.simulation, made.owner
    off = law.tolerances
    assert (off.wall, off.mount_place, off.clock_offset) == (wall, wall, offset)
    assert (off.clock_drift, off.tension_gain, off.mass) == (pytest.approx(drift), gain, 0.0)
    assert np.degrees([off.mount_turn, off.line_angle_bias]) == pytest.approx([turn, bias])
    assert (law.people.share, law.wifi.gap_every, law.wifi.gap_length) == (people, 60.0, gap)
    assert off.tension_drift > 0.0
    assert owner.room.deviation == wall
    assert {(lidar.place_deviation, lidar.turn_deviation) for lidar in owner.lidars.values()} == {
        (wall, off.mount_turn)
    }
    assert (owner.inertial.turn_deviation, owner.line_angles.bias) == (off.mount_turn, off.line_angle_bias)
    assert (owner.load_cells.gain_deviation, owner.motor_torques) == (gain, None)
    assert owner.clock == ClockSettings(offset=offset, drift=off.clock_drift, latency=SIMULATION.wifi.latency)
    assert (off.anchor, law.wifi.jitter, owner.room.walls) == (1e-3, SIMULATION.wifi.jitter, SETTINGS.room.walls)
    assert severity_of(law) == name == law.severity


def test_a_part_of_a_severity_is_that_part_alone() -> None:
    rough = with_severity(MEASURED, "rough")
    assert with_severity(MEASURED, "rough", PARTS) == rough
    assert with_severity(rough, "rough", ()).with_simulation(severity="ideal") == MEASURED
    keys = [key for part in PARTS.values() for key in part]
    assert sorted([*keys, "mass"]) == sorted(key for table in SEVERITIES["rough"].values() for key in table)
    walls = with_severity(MEASURED, "rough", ("walls",))
    assert (walls.simulation.tolerances.wall, walls.owner.room.deviation) == (2e-3, 2e-3)
    assert walls.with_owner(room=SETTINGS.room).owner == MEASURED.owner
    assert severity_of(walls.simulation) == OWN
    clock = with_severity(MEASURED, "rough", ("clock", "mounts")).owner
    assert (clock.clock, clock.lidars) == (rough.owner.clock, rough.owner.lidars)
    assert clock.room == SETTINGS.room
    with pytest.raises(UnknownName, match="walls"):
        with_severity(TWIN, "rough", ("wall",))


def test_in_a_file_a_severity_sets_the_truth_alone_and_explicit_keys_win(tmp_path: Path) -> None:
    (tmp_path / "rough.toml").write_text(with_key('severity = "rough"'))
    rough = load_twin(tmp_path / "rough.toml")
    assert rough.owner == SETTINGS == load_machine(tmp_path / "rough.toml")
    assert rough.simulation == with_severity(TWIN, "rough").simulation
    text = with_key('severity = "rough"').replace(
        "[simulation.tolerances]", '[simulation.tolerances]\nwall = "7 mm"\n#'
    )
    (tmp_path / "own.toml").write_text(text.replace("[simulation.wifi]", '[simulation.wifi]\ngap_length = "1 s"\n#'))
    own = load_twin(tmp_path / "own.toml").simulation
    assert (own.tolerances.wall, own.tolerances.mount_place) == (7e-3, 2e-3)
    assert (own.wifi.gap_length, own.wifi.gap_every, own.wifi.latency) == (1.0, 60.0, 5e-3)
    assert severity_of(own) == OWN


def test_other_numbers_have_no_name() -> None:
    assert severity_of(SIMULATION) == "ideal"
    assert severity_of(changed(tolerances={"mass": 0.01}).simulation) == OWN
    assert severity_of(changed(clock={"jumps": ((1.0, 1.0),)}).simulation) == OWN
    for name in SEVERITIES:
        assert severity_of(with_severity(TWIN, name).simulation) == name


def test_unknown_severities_are_rejected(tmp_path: Path) -> None:
    with pytest.raises(UnknownName, match="rough"):
        with_severity(TWIN, "ruogh")  # type: ignore[arg-type]
    for value in ('"ruogh"', "3", "[1]", "{}"):
        (tmp_path / "own.toml").write_text(with_key(f"severity = {value}"))
        with pytest.raises(InputError, match=r"own\.toml: simulation\.severity.*'ideal', 'typical' or 'rough'"):
            load_twin(tmp_path / "own.toml")


@pytest.mark.parametrize(
    ("table", "key", "says"),
    [
        ("simulation.tolerances", 'wall = "-1 mm"', r"tolerances\.wall = '-1 mm': must be at least 0"),
        ("simulation.tolerances", "mount_turn = 2.0", r"tolerances\.mount_turn = 2\.0: must be at most 0\.5"),
        ("simulation.tolerances", "clock_drift = 0.1", r"tolerances\.clock_drift = 0\.1: must be at most 0\.01"),
        ("simulation.wifi", "gap_every = 0.5", r"wifi\.gap_every = 0\.5: must be 0 \(no gaps\), or at least 1 s"),
    ],
)
def test_numbers_out_of_their_range_are_rejected(table: str, key: str, says: str, tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text(with_key(key, table))
    with pytest.raises(InputError, match=says):
        load_twin(tmp_path / "own.toml")


def test_jumps_come_in_their_order(tmp_path: Path) -> None:
    text = machine_text("merlet2023") + '\n[simulation.clock]\njumps = [["2 s", "1 s"], ["1 s", "-3 ms"]]\n'
    (tmp_path / "own.toml").write_text(text)
    with pytest.raises(InputError, match=r"simulation\.clock\.jumps.*in the order of their times"):
        load_twin(tmp_path / "own.toml")
    (tmp_path / "own.toml").write_text(text.replace('"2 s"', '"0 s"'))
    assert load_twin(tmp_path / "own.toml").simulation.clock.jumps == ((0.0, 1.0), (1.0, -3e-3))


def test_a_head_keeps_its_severity() -> None:
    made = with_severity(MEASURED, "rough")
    head = LogHead(load("merlet2023"), made.owner, 0.01, simulation=made.simulation, plant="dynamic", seed=1)
    again = read_head(written_head(head), "head")
    assert again == head
    texts = written_head(head)
    law = json.loads(texts["simulation"])
    law["tolerances"]["wall"] = 0.0  # explicit, so that it wins
    changed_head = read_head({**texts, "simulation": json.dumps(law)}, "head")
    assert changed_head.simulation is not None
    assert changed_head.simulation.tolerances.wall == 0.0
