from __future__ import annotations

import pytest

from cablewright.foundation.signals import Encoders, Inertial, Scan
from cablewright.machine.log.log import read_log

SHORT = ["--loop", "28", "--duration", "4", "--plant", "quasi-static"]


def test_a_log_is_written_and_summed_up(cli, tmp_path) -> None:
    out, plot = tmp_path / "run.mcap", tmp_path / "run.png"
    answer = cli("simulate", "merlet2023", *SHORT, "--seed", 3, "--out", out, "--plot", plot, "--json")
    assert answer.code == 0
    values = answer.json
    assert values["steps"] == 20
    assert values["duration"] == pytest.approx(4.0)
    assert (values["out"], values["plot"]) == (str(out), str(plot))
    assert plot.read_bytes().startswith(b"\x89PNG")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run.mcap", "run.png", "run.png.csv"]
    with read_log(out) as log:
        entries = list(log.entries())
        assert log.head.seed == 3
        assert log.head.robot.name == "merlet2023"
    assert len(entries) == 20
    assert sum(len(entry.frame.readings) for entry in entries) == sum(values["readings"].values())


def test_a_severity_is_reported_and_kept_in_the_log(cli, tmp_path) -> None:
    out = tmp_path / "run.mcap"
    options = [*SHORT, "--seed", 3, "--severity", "typical", "--fault", "north,0,100"]
    answer = cli("simulate", "merlet2023", *options, "--out", out, "--json")
    assert answer.json["severity"] == "typical"
    assert answer.json["built"].endswith("by the severity typical")
    with read_log(out) as log:
        assert (log.head.severity, log.head.settings.room.deviation) == ("typical", 1e-3)
        frames = [entry.frame for entry in log.entries()]
        stamps = [each.time - frame.time for frame in frames for each in frame.of(Inertial)]
        assert len({round(each, 4) for each in stamps}) == 1  # a clock with an offset that hardly drifts
        assert 1e-6 < abs(stamps[0]) < 0.01
        assert {each.time - frame.time for frame in frames for each in frame.of(Encoders)} == {0.0}  # on a wire
    assert cli("simulate", "merlet2023", *SHORT, "--json").json["severity"] == "ideal"


def test_the_same_seed_writes_the_same_bytes(cli, tmp_path) -> None:
    for name in ("a", "b"):
        assert cli("simulate", "merlet2023", *SHORT, "--out", tmp_path / f"{name}.mcap").code == 0
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()


def test_it_holds_with_the_dynamic_plant_for_people(cli) -> None:
    answer = cli("simulate", "merlet2023", "--hold", "0,0,1.2", "--duration", "2", "--valve", "0")
    assert answer.code == 0
    shown = dict(line.split("  ", 1) for line in answer.out.splitlines() if "  " in line)
    shown = {key: value.strip() for key, value in shown.items()}
    assert (shown["duration"], shown["plant"], shown["seed"]) == ("2.000 s", "dynamic", "0")
    assert shown["powder left"] == "20.00 kg"
    assert float(shown["real time ratio"]) > 0.0


def test_faults_are_planned_on_the_command_line(cli, tmp_path) -> None:
    out = tmp_path / "a.mcap"
    faults = ["--fault", "north,0,100", "--fault", "line_angles:south-east,0.1,1,stuck", "--wifi-gap", "2,3"]
    answer = cli(
        "simulate", "merlet2023", "--hold", "0,0,1.2", "--duration", "5", "--plant", "quasi-static", *faults,
        "--out", out, "--json",
    )  # fmt: skip
    assert "north" not in answer.json["readings"]
    assert answer.json["readings"]["south"] > 2
    assert answer.json["notices"] == {"wifi: nothing came over the wireless link for longer than it should": 3}
    with read_log(out) as log:
        assert log.head.simulation.faults[1].line == "south-east"
        assert log.head.simulation.wifi.gaps == ((2.0, 3.0),)
        assert {reading.source for entry in log.entries() for reading in entry.frame.of(Scan)} == {"south", "vertical"}


def test_a_machine_file_of_ones_own_is_taken(cli, tmp_path) -> None:
    text = cli("machines", "merlet2023").out
    (tmp_path / "own.toml").write_text(text.replace('powder = "20 kg"', 'powder = "5 kg"'))
    answer = cli("simulate", "merlet2023", "--machine", tmp_path / "own.toml", *SHORT, "--valve", "0", "--json")
    assert answer.json["powder"] == 5.0
    names = ["cogiro", "house-printer", "ipanema", "jung2020", "merlet2023"]
    assert cli("machines").out == f"machines  {', '.join(names)}\n"
    assert cli("machines", "--json").json["machines"] == names
    assert cli("machines", "merlet2023", "--json").json["file"] == text


def test_a_robot_has_a_machine_of_its_own(cli) -> None:
    told = cli("simulate", "house-printer", "--hold", "0,0,1", "--duration", "0.5", "--json").json
    assert told["machine"] == "house-printer"
    assert set(told["readings"]) == {"Barrier", "Encoders"}


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "expected either --loop or --hold"),
        (["--loop", "28", "--hold", "0,0,1"], "expected either --loop or --hold"),
        (["--hold", "0,0,1"], "--hold needs --duration"),
        (["--hold", "0,0", "--duration", "1"], "--hold = 0,0: expected X,Y,Z, m"),
        (["--hold", "0,nan,1", "--duration", "1"], "3 finite numbers"),
        (["--loop", "1e6"], "loop = 1e+06 m: must be more than 0 and less than 10000 m"),
        ([*SHORT, "--plant", "static"], "--plant"),
        ([*SHORT, "--seed", "-1"], "seed = -1"),
        ([*SHORT, "--speed", "0"], "speed = 0"),
        ([*SHORT, "--valve", "2"], "valve = 2"),
        ([*SHORT, "--duration", "-1"], "duration = -1"),
        ([*SHORT, "--duration", "nan"], "duration = nan"),
        ([*SHORT, "--out", "log.bag"], "a name that ends in .mcap"),
        ([*SHORT, "--plot", "a.jpg"], "a name that ends in .png"),
        ([*SHORT, "--fault", "north"], "SOURCE,FROM,TO[,KIND[,SIZE]]"),
        ([*SHORT, "--fault", "nort,1,2"], "source = 'nort'"),
        ([*SHORT, "--fault", "north,2,1"], "must be after begin"),
        ([*SHORT, "--fault", "line_angles:top,1,2"], "unknown line 'top'"),
        ([*SHORT, "--fault", "north:south-east,1,2"], "is for line_angles"),
        ([*SHORT, "--fault", "north,1,2,loud"], "kind = 'loud'"),
        ([*SHORT, "--wifi-gap", "2,1"], "must each rise"),
        ([*SHORT, "--wifi-gap", "2"], "expected 2 finite numbers"),
        ([*SHORT, "--machine", "merlet"], "no machine 'merlet'"),
    ],
)
def test_bad_input_is_rejected(cli, arguments: list[str], says: str) -> None:
    assert says in cli("simulate", "merlet2023", *arguments).refusal


def test_a_bad_machine_file_is_rejected(cli, tmp_path) -> None:
    text = cli("machines", "merlet2023").out
    for old, new, says in (
        ('powder = "20 kg"', 'powder = "60 kg"', "must be at most capacity, 50 kg"),
        ("rate = 10.0 ", "rate = 30.0 ", "distance.rate = 30 Hz"),
        ('substep = "2 ms"', 'substep = "3 ms"', "simulation.substep = 0.003 s"),
        ("loss = 1e-3", "loss = 2.0", "simulation.wifi.loss = 2.0"),
        ("axes = [[0, 0, -1], [1, 0, 0]]", "axes = [[0, 0, -1], [1, 0, 1]]", "two unit vectors at right angles"),
        ("to = [-2.5, 5.0]", "to = [-2.5, -5.0]", "must differ from from"),
        ("schema = 1", "schema = 2", "schema = 2"),
        (
            'radius = "0.18 m"',
            'radius = "1e-300 m"',
            "drum.radius = '1e-300 m': must be at least 1e-06",
        ),
        ('width = "75 mm"', 'width = "1e30 mm"', "winch.width = '1e30 mm': must be at most 100000"),
        ('lag = "20 ms"', 'lag = "1e300 s"', "winch.lag"),
        ("[simulation.wifi]", "[simulation.wify]", "simulation.wify: unknown key; did you mean 'wifi'"),
    ):
        (tmp_path / "own.toml").write_text(text.replace(old, new, 1))
        assert old in text
        refusal = cli(
            "simulate", "merlet2023", *SHORT, "--plant", "dynamic", "--machine", tmp_path / "own.toml"
        ).refusal
        assert says in refusal


def test_what_cannot_be_simulated_is_said(cli, tmp_path) -> None:
    assert "no winch.drum_radius" in cli("simulate", "wang2021", "--hold", "1,0,1", "--duration", "1").refusal
    assert "a line would have to push" in cli("simulate", "merlet2023", "--hold", "0,0,9", "--duration", "1").no
    nowhere = cli("simulate", "merlet2023", *SHORT, "--out", tmp_path / "no" / "a.mcap")
    assert nowhere.code == 3
