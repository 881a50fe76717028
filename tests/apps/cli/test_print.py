"""`print`: a run folder with log, figures and report; reasons of rejection."""

from __future__ import annotations

import json
from importlib.metadata import version

import pytest

from cablewright.apps.report.document import script
from cablewright.foundation.errors import AnswerError
from cablewright.live.prints.plan import PrintOptions, twin_of
from cablewright.live.prints.run import run_print
from cablewright.machine.log.log import read_log
from cablewright.printing.job import load_job
from cablewright.robot import load
from print_logs import RING

pytestmark = pytest.mark.usefixtures("undrawn")

JOB = RING.format(radius=0.2)
KEYS = (
    "layers", "distance", "mean_speed", "speed_variance", "mean_path_error", "path_error_variance", "max_path_error",
    "estimated_max_path_error", "log", "report",
)  # fmt: skip
FAST = ("--plant", "quasi-static")


@pytest.fixture(scope="module")
def job(tmp_path_factory):
    file = tmp_path_factory.mktemp("job") / "ring.toml"
    file.write_text(JOB)
    return file


def test_a_print_leaves_log_figures_and_report(cli, job, tmp_path) -> None:
    out = tmp_path / "run"
    answer = cli("print", "merlet2023", job, *FAST, "--out", out, "--json")
    assert answer.code == 0
    values = answer.json
    assert all(values[key] is not None for key in KEYS)
    assert values["status"] == "finished"
    assert values["layers"] == 1
    assert values["distance"] == pytest.approx(1.2566, rel=5e-3)
    assert values["max_path_error"] < 0.0482  # the paper's
    with read_log(values["log"]) as log:
        assert len(list(log.entries())) == values["steps"]
    assert "://" not in (out / "report.html").read_text().replace(script(), "")  # three.js names specifications
    assert json.loads((out / "manifest.json").read_text())["cablewright"] == version("cablewright")
    assert json.loads((out / "metrics.json").read_text()) == values
    again = cli("print", "merlet2023", job, *FAST, "--out", out, "--json")
    assert again.code == 2
    assert "is not empty; --resume the run in it, or give another folder" in again.err
    resumed = cli("print", "merlet2023", job, *FAST, "--out", out, "--resume")
    assert resumed.code == 0
    assert "status                         finished\nlayers                         1\n" in resumed.out
    other = cli("print", "merlet2023", job, *FAST, "--seed", 5, "--out", out, "--resume")
    assert other.code == 2
    assert "another seed: 0, requested: 5" in other.err


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--layers", "0"), "layers = 0: must be 1 to 1"),
        (("--plant", "real"), "--plant"),
        (("--estimator", "magic"), "--estimator"),
        (("--control", "magic"), "--control"),
        (("--height", "sky"), "--height"),
        (("--period", "-1", *FAST), "period = -1"),
        (("--intrusions", "-2"), "intrusions = -2"),
        (("--machine", "nowhere.toml"), "nowhere.toml"),
        (("--resume",), "holds no print"),
        (("--severity", "harsh"), "--severity"),
        (("--log", "every=0"), "--log = 'every=0': expected every=N, with N from 1 to 10000 steps"),
        (("--log", "all"), "--log = 'all': expected every=N"),
    ],
)
def test_bad_options_are_one_line(cli, job, tmp_path, options, says) -> None:
    answer = cli("print", "merlet2023", job, "--out", tmp_path / "run", *options)
    assert answer.code == 2
    assert says in answer.err
    assert answer.err.count("\n") == 1
    assert answer.out == ""
    assert not (tmp_path / "run").exists()


@pytest.mark.slow  # in live/prints/test_finished_prints.py
def test_a_thinned_log_has_the_print_in_fewer_steps(cli, job, tmp_path) -> None:
    out, thin = tmp_path / "run", ("--log", "every=5")
    values = cli("print", "merlet2023", job, *FAST, *thin, "--out", out, "--json").json
    assert (values["status"], values["layers"]) == ("finished", 1)
    assert not any("logged" in note for note in values["notes"])  # a step that is left out on purpose is no gap
    with read_log(values["log"]) as log:
        times = [entry.frame.time for entry in log.entries()]
        assert log.head.every == 5
    assert len(times) == values["steps"] < 0.4 * times[-1]  # a step is a second
    other = cli("print", "merlet2023", job, *FAST, "--out", out, "--resume")
    assert (other.code, "log_every: 5, requested: 1" in other.err) == (2, True)


def test_bad_jobs_are_one_line(cli, tmp_path) -> None:
    for text, says in (
        (JOB.replace('"3 cm/s"', '"-3 cm/s"', 1), "motion.print_speed"),
        (JOB.replace("layers = 1", "layers = 0"), "helix.layers = 0"),
        (JOB.replace('name = "a ring"', 'name = "a ring"\nrobot = "jung2020"'), "robot = 'jung2020'"),
        (JOB.replace("[0.3, -0.5, 0.0]", "[2.4, -0.5, 0.0]"), "the path leaves the frame of 'merlet2023'"),
    ):
        file = tmp_path / "job.toml"
        file.write_text(text)
        answer = cli("print", "merlet2023", file, *FAST, "--out", tmp_path / "run")
        assert answer.code in (1, 2)
        assert says in answer.err
        assert answer.err.count("\n") == 1


def test_a_rejected_print_leaves_nothing_and_can_be_tried_again(cli, job, tmp_path, monkeypatch) -> None:
    def refuse(*_args, **_kwargs):
        raise AnswerError("the machine as built cannot hold the start")

    with monkeypatch.context() as patch:
        patch.setattr("cablewright.live.prints.run.SimulatedMachine", refuse)
        answer = cli("print", "merlet2023", job, *FAST, "--out", tmp_path / "run")
    assert (answer.code, answer.err.count("\n")) == (1, 1)
    assert not list(tmp_path.iterdir())
    far = tmp_path / "far.toml"
    far.write_text(JOB.replace("[0.3, -0.5, 0.0]", "[2.4, -0.5, 0.0]"))
    assert cli("print", "merlet2023", far, *FAST, "--out", tmp_path / "run").code == 1
    assert cli("print", "merlet2023", job, *FAST, "--out", tmp_path / "run").code == 0


def test_other_folders_are_left_alone(cli, job, tmp_path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    answer = cli("print", "merlet2023", job, *FAST, "--out", tmp_path)
    assert answer.code == 2
    assert [each.name for each in tmp_path.iterdir()] == ["mine.txt"]


@pytest.mark.slow  # other options are kept in the first test
def test_a_severity_is_kept_with_the_print_and_reported(cli, job, tmp_path) -> None:
    """Encoders alone show no effect of a severity except that of the drum; the print goes on as it began."""
    out, options = tmp_path / "run", (*FAST, "--estimator", "encoders", "--out", tmp_path / "run")
    answer = cli("print", "merlet2023", job, *options, "--severity", "rough", "--json")
    assert answer.json["severity"] == "rough"
    kept = json.loads((out / "manifest.json").read_text())["options"]
    assert kept["severity"] == "rough"
    assert kept["machine"]["simulation"]["tolerances"]["wall"] == 2e-3
    assert kept["machine"]["owner"]["room"]["deviation"] == 2e-3
    assert (
        "rough: walls, mounts, clocks, zeros, people, gaps of the link and what no model has"
        in (out / "report.html").read_text()
    )
    assert cli("print", "merlet2023", job, *options, "--severity", "rough", "--resume").code == answer.code
    other = cli("print", "merlet2023", job, *options, "--resume")
    assert other.code == 2
    assert "another severity: rough, requested: None" in other.err


def test_a_print_on_an_ideal_machine_says_so(cli, job, tmp_path) -> None:
    out = tmp_path / "run"
    answer = cli("print", "merlet2023", job, *FAST, "--estimator", "encoders", "--out", out)
    assert "severity                       ideal\n" in answer.out
    assert "as built                       walls, mounts and clocks are exactly as described\n" in answer.out
    assert "ideal: walls, mounts and clocks are exactly as described" in (out / "report.html").read_text()


def test_a_print_begun_from_python_goes_on_too(job, tmp_path) -> None:
    twin = twin_of(load("merlet2023"), load_job(job), None, PrintOptions(plant="quasi-static"))
    assert run_print(twin, tmp_path / "run", {}, {}).finished
    again = run_print(twin, tmp_path / "run", {}, {}, resume=True)
    assert again.finished
    assert again.steps == 0
