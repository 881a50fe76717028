"""Machine files and commands for drives that are wrong: one line that names file, key and value, and the exit code."""

from __future__ import annotations

from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[3] / "examples" / "virtual-drives.toml"


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('kind = "canopen"', 'kind = "modbus"', "kind = 'modbus': must be 'simulated', 'canopen' or 'ethercat'"),
        ('kind = "canopen"', "", 'kind: must be "canopen" or "ethercat" where there is a table [drives]'),
        ('kind = "canopen"', 'kind = "ethercat"', "drives.interface = 'loopback': must be a network interface"),
        ('channel = "43113"', "", "drives.channel: must be a UDP port from 1024 to 65535"),
        ('line = "south-west"', 'line = "south"', "drives.valve.line = 'south': has no drive in drives.nodes"),
        ("closes_alone = true", "", "drives.valve.closes_alone: is missing"),
        ("closes_alone = true", 'closes_alone = "perhaps"', "drives.valve.closes_alone = 'perhaps'"),
        ("bit = 16", "bit = 32", "drives.valve.bit = 32"),
        ("id = 2,", "id = 1,", "two lines have the node 1; each needs a drive of its own"),
        ("id = 2,", "id = 127,", "127 is this computer's"),
        ("id = 2,", "id = 128,", "id = 128: must be"),
        ("direction = -1 }", "direction = 2 }", "direction = 2"),
        ("south-east = {", "south = {", "one node for each line of the robot is expected"),
        ('channel = "43113"', 'channel = "can0"', "must be a UDP port from 1024 to 65535"),
        ('channel = "43113"', 'channel = "a; reboot"', "drives.channel"),
        ("bitrate = 1000000", "bitrate = 250000", "of the bus; at most 70% is allowed"),
        ('rated_torque = "0.5 N m"', 'rated_torque = "1 kN m"', "check its unit"),
        ("[motor_torques]", "[load_cells]", "drives are enabled only with measured tensions"),
        ("[encoders]\nrate = 100.0", "", "no [encoders]"),
        (
            'tension = "30 N"',
            'tension = "30 kN"',
            "drives.tension = 30000 N: line south-west of merlet2023 may pull 2000 N",
        ),
        ('jog_tension = "500 N"', 'jog_tension = "5 kN"', "machine.toml: drives.jog_tension = 5000 N: line south-west"),
        (
            'heartbeat_timeout = "500 ms"',
            'heartbeat_timeout = "5 s"',
            "drives.heartbeat_timeout = 5 s: cable runs at up",
        ),
        (
            "deceleration = 1.0",
            "deceleration = 0.01",
            "drives.deceleration = 0.01 m/s^2: cable runs at up to 0.1825 m/s",
        ),
        ("deceleration = 1.0", "deceleration = 100.0", "drives.deceleration = 100"),
        (
            "[drives]\n",
            '[drives]\nacknowledged = "yes"\n',
            "acknowledged = 'yes': must be 'tested on virtual drives only'",
        ),
        ('robot = "merlet2023"', 'robot = "house-printer"', "robot = 'house-printer', but the robot is 'merlet2023'"),
    ],
)
def test_a_wrong_file_is_rejected_before_anything_is_sent(cli, old: str, new: str, says: str, tmp_path: Path) -> None:
    text = EXAMPLE.read_text("utf-8")
    assert old in text
    file = tmp_path / "machine.toml"
    file.write_text(text.replace(old, new, 1), encoding="utf-8")
    at = ("--place", "0,0,1", "--at", "0,0,1")
    answer = cli("drives", "home", "merlet2023", "--machine", str(file), "--try", *at)
    assert answer.code == 2, answer.err
    assert says in answer.err
    assert len(answer.err.strip().splitlines()) == 1


def test_a_bus_without_answers_is_an_environment_fault(cli, tmp_path: Path) -> None:
    file = tmp_path / "machine.toml"
    file.write_text(EXAMPLE.read_text("utf-8").replace('"43113"', '"43998"'), encoding="utf-8")
    answer = cli("drives", "scan", "merlet2023", "--machine", str(file))
    assert answer.code == 3
    assert "`cablewright drives --virtual FILE` starts virtual drives" in answer.err
    real = tmp_path / "real.toml"
    text = EXAMPLE.read_text("utf-8").replace('"loopback"', '"socketcan"').replace('"43113"', '"can7"')
    real.write_text(text, encoding="utf-8")
    answer = cli("drives", "scan", "merlet2023", "--machine", str(real))
    assert answer.code == 3
    assert "ip link set can7 up type can bitrate 1000000" in answer.err


@pytest.mark.parametrize("action", ["write", "enable", "release", "tension", "home"])
def test_a_real_bus_moves_nothing_without_acknowledgement(cli, action: str, tmp_path: Path) -> None:
    file = tmp_path / "machine.toml"
    text = EXAMPLE.read_text("utf-8").replace('"loopback"', '"socketcan"').replace('"43113"', '"can7"')
    file.write_text(text, encoding="utf-8")
    answer = cli("drives", action, "merlet2023", "--machine", str(file))
    assert answer.code == 2
    assert "drives.acknowledged: is missing: this version was tested on virtual drives only" in answer.err
    file.write_text(text.replace('# acknowledged = "tested', 'acknowledged = "tested'), encoding="utf-8")
    answer = cli("drives", action, "merlet2023", "--machine", str(file))
    assert answer.code == 3
    assert "ip link set can7 up" in answer.err


def test_a_place_in_millimetres_is_rejected(cli) -> None:
    answer = cli("drives", "home", "merlet2023", "--machine", str(EXAMPLE), "--try", "--place", "0,0,1000")
    assert answer.code == 2
    assert "place: z = 1000 m: is outside the frame of merlet2023, 0 to 4.03 m; places are in m" in answer.err


def test_a_simulated_machine_has_no_drives(cli) -> None:
    answer = cli("drives", "scan", "merlet2023", "--machine", "merlet2023")
    assert (answer.code, "has no real drives" in answer.err) == (2, True)
    answer = cli("drives", "scan", "merlet2023")
    assert (answer.code, "expected ACTION ROBOT --machine FILE" in answer.err) == (2, True)
    answer = cli("drives", "jog", "merlet2023", "--machine", str(EXAMPLE), "--try", "--velocity", "0,0,1")
    assert (answer.code, "runs until an operator ends it" in answer.err) == (2, True)


@pytest.mark.parametrize(
    ("option", "says"),
    [
        (("--plant", "quasi-static"), "--plant: is for simulated machines"),
        (("--seed", "3"), "--seed: is for simulated machines"),
        (("--recalibration", "file"), "--recalibration: is for simulated machines"),
        (("--accept-doubtful",), "--accept-doubtful: is for simulated machines"),
        (("--estimator", "filter"), "--estimator = filter: on real drives it is encoders"),
    ],
)
def test_options_of_simulations_are_rejected_on_drives(cli, option: tuple[str, ...], says: str) -> None:
    job = EXAMPLE.with_name("blind-machines.toml")
    answer = cli("print", "merlet2023", str(job), "--machine", str(EXAMPLE), *option)
    assert (answer.code, says in answer.err) == (2, True), answer.err


def test_a_job_with_stages_is_rejected_before_the_bus_is_opened(cli, tmp_path: Path) -> None:
    job = tmp_path / "tower.toml"
    text = EXAMPLE.with_name("blind-machines.toml").read_text("utf-8")
    job.write_text(f'{text}\n[[stages]]\nz = "0.1 m"\nraised = "0.5 m"\n', encoding="utf-8")
    answer = cli("print", "merlet2023", str(job), "--machine", str(EXAMPLE), "--out", str(tmp_path / "run"))
    assert (answer.code, answer.err.count("\n")) == (2, 1), answer.err
    assert f"{job}: stages: are printed on simulated machines" in answer.err
    assert "print each stage as a job of its own, with heights in place of stages" in answer.err
    assert not (tmp_path / "run").exists()


def test_all_actions_can_be_tried(cli) -> None:
    for action, more in (
        ("show", ()),
        ("write", ()),
        ("release", ()),
        ("enable", ("--seconds", "0.1")),
        ("tension", ()),
        ("home", ("--place", "0,0,1", "--at", "0,0,1")),
    ):
        answer = cli("drives", action, "merlet2023", "--machine", str(EXAMPLE), "--try", *more, "--json")
        assert answer.code == 0, (action, answer.err)
        assert answer.json.get("status", "done") == "done"


def test_ethercat_drives_cannot_be_tried_without_a_cable(cli, tmp_path: Path) -> None:
    text = EXAMPLE.read_text("utf-8").replace('"loopback"', '"cwnone"').replace('"canopen"', '"ethercat"')
    file = tmp_path / "machine.toml"
    file.write_text(text, encoding="utf-8")
    answer = cli("drives", "scan", "merlet2023", "--machine", str(file), "--try")
    assert (answer.code, "--try is for CAN; virtual EtherCAT drives need --virtual" in answer.err) == (2, True)
    answer = cli("drives", "home", "merlet2023", "--machine", str(file))
    assert (answer.code, "drives.acknowledged: is missing" in answer.err) == (2, True)
    answer = cli("drives", "scan", "merlet2023", "--machine", str(file))
    assert answer.code == 3
    assert "ip link set cwnone up" in answer.err or "pip install 'cablewright[ethercat]'" in answer.err
    file.write_text(text.replace("43113", "cwnone"), encoding="utf-8")
    answer = cli("drives", "--virtual", str(file), "--at", "0.7,-0.5,1")
    assert (answer.code, "drives.channel = 'cwnone': cannot be had for virtual drives" in answer.err) == (3, True)
