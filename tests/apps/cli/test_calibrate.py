"""`calibrate` and `simulate-calibration`: their JSON, what they write, and bad input in one line."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cablewright.apps.report.document import script
from cablewright.calibration.poses.simulation import aligned
from cablewright.robot import library_text, load

KEYS = {"status", "rms", "iterations", "unknowns", "rank", "gauge", "weakest", "sigma", "rejected", "robot"}
TRUE = np.array([line.exit_point for line in load("wang2021").lines])


@pytest.fixture(scope="module")
def data(cli, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("data") / "d.csv"
    made = cli("simulate-calibration", "wang2021", "--poses", "40", "--noise", "0.0001", "--seed", "1", "--out", file)
    assert made.code == 0
    return file


@pytest.fixture
def changed(data: Path, tmp_path: Path) -> Callable[..., Path]:
    """The data with each table of cells changed."""

    def write(change: Callable[[list[list[str]]], list[list[str]]]) -> Path:
        rows = [line.split(",") for line in data.read_text().splitlines() if not line.startswith("#")]
        file = tmp_path / "changed.csv"
        file.write_text("".join(",".join(row) + "\n" for row in change(rows)))
        return file

    return write


def test_json(cli, data: Path) -> None:
    found = cli("calibrate", "wang2021", data, "--json").json
    assert found.keys() >= KEYS
    assert found["status"] == "ok"
    assert (found["unknowns"], found["rank"]) == (136, 132)
    assert found["gauge"] == ["translation along x", "translation along y", "translation along z", "yaw"]
    assert 1e-5 < found["rms"] < 1e-4
    assert found["encoder_sigma"] == pytest.approx(1e-4, rel=0.5)
    assert found["rejected"] == []
    assert len(found["sigma"]) == 16
    assert all(value > 0.0 for value in found["sigma"].values())
    exits = np.array([line["exit_point"] for line in found["robot"]["lines"]])
    assert np.abs(exits - TRUE).max() < 0.05


def test_without_noise_it_is_exact_and_the_same_twice(cli, tmp_path: Path) -> None:
    file, truth = tmp_path / "d.csv", tmp_path / "true.json"
    made = ("simulate-calibration", "wang2021", "--poses", "20", "--noise", "0", "--seed", "4", "--out", file)
    assert cli(*made, "--truth", truth).code == 0
    first, again = cli("calibrate", "wang2021", file, "--json"), cli("calibrate", "wang2021", file, "--json")
    assert first.out == again.out
    found, known = first.json, json.loads(truth.read_text())
    assert found["rms"] < 1e-12
    exits = np.array([line["exit_point"] for line in found["robot"]["lines"]])
    places, poses = aligned(exits, TRUE, np.array(found["pose"]))
    assert np.abs(places - TRUE).max() < 1e-9
    assert np.abs(poses - known["poses"]).max() < 1e-9
    home = [found["values"][f"home length of {line.name}"] for line in load("wang2021").lines]
    assert home == pytest.approx(known["home_lengths"], abs=1e-9)


def test_the_robot_is_written_with_its_comments_and_a_report(cli, data: Path, tmp_path: Path) -> None:
    robot, out = tmp_path / "mine.toml", tmp_path / "new.toml"
    robot.write_text(library_text("wang2021"))
    found = cli("calibrate", robot, data, "--datum", "south-west,south-east.y", "--accept", "--out", out, "--json").json
    assert found["out"] == str(out)
    assert robot.read_text() == library_text("wang2021")
    written = load(out)
    assert written.lines[0].exit_point == load("wang2021").lines[0].exit_point
    assert written.lines[1].exit_point[1] == -1.75
    assert written.lines[2].exit_point != load("wang2021").lines[2].exit_point
    assert "# assumed, all exit points" in out.read_text()
    page = (tmp_path / "new.html").read_text()
    assert found["report"] == str(tmp_path / "new.html")
    assert page.count("<picture>") == 3
    assert "http" not in page.split("</head>")[1].replace(script(), "")


def test_text_for_people(cli, data: Path) -> None:
    printed = cli("calibrate", "wang2021", data)
    assert (printed.figure("unknowns"), printed.figure("determined by the data")) == ("136", "132")
    assert printed.figure("left open") == "translation along x, translation along y, translation along z, yaw"
    assert "three exit points surveyed" in printed.out


def test_each_reason_is_on_a_line_of_its_own(cli, data: Path, tmp_path: Path) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text('schema = 1\n[sigma]\nencoder = "0.02 mm"\n')
    asked = ("calibrate", "wang2021", data, "--plan", plan)
    reasons = cli(*asked, "--json").json["reasons"]
    lines = [line.strip() for line in cli(*asked).out.splitlines()]
    assert len(reasons) > 1
    assert lines[1].startswith("reasons ")
    assert lines[1].endswith(reasons[0])
    assert lines[2 : len(reasons) + 1] == reasons[1:]


def test_columns_in_mm_say_so(cli, data: Path, changed) -> None:
    def in_mm(rows: list[list[str]]) -> list[list[str]]:
        return [[f"{name} (mm)" for name in rows[0]], *([repr(1e3 * float(cell)) for cell in row] for row in rows[1:])]

    same, found = (cli("calibrate", "wang2021", file, "--json").json for file in (data, changed(in_mm)))
    assert found["rms"] == pytest.approx(same["rms"], rel=1e-6)


def test_guesses_are_not_needed(cli, data: Path, changed) -> None:
    same = cli("calibrate", "wang2021", data, "--json").json
    found = cli("calibrate", "wang2021", changed(lambda rows: [row[:4] for row in rows]), "--json").json
    assert found["rms"] == pytest.approx(same["rms"], rel=1e-6)


def test_gross_errors_are_left_out_and_named(cli, changed) -> None:
    def spoiled(rows: list[list[str]]) -> list[list[str]]:
        for at in (8, 22):
            rows[at][2] = repr(float(rows[at][2]) + 0.05)
        return rows

    answer = cli("calibrate", "wang2021", changed(spoiled), "--json")
    assert [(each["pose"], each["row"]) for each in answer.json["rejected"]] == [(8, 9), (22, 23)]
    assert answer.json["rms"] < 1e-4
    assert (answer.json["unknowns"], answer.json["rank"]) == (130, 126)
    assert "2 of 40 poses do not fit" in answer.err


def test_a_plan_beside_the_data_counts(cli, data: Path, tmp_path: Path) -> None:
    file = tmp_path / "d.csv"
    file.write_text(data.read_text())
    (tmp_path / "d.toml").write_text(
        'schema = 1\nlevel = "1 mrad"\n[sigma]\nencoder = "0.1 mm"\n'
        '[[distances]]\nbetween = ["south-west", "south-east"]\nvalue = "4.8826 m"\n'
    )
    plain, found = (cli("calibrate", "wang2021", each, "--json").json for each in (data, file))
    assert found["encoder_sigma"] == 1e-4
    assert max(found["sigma"].values()) < 0.5 * max(plain["sigma"].values())


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda rows: rows[:12], "11 poses; at least 12 are required"),
        (lambda rows: [rows[0], *[rows[5]] * 40], "line 3: repeats all measurements of line 2"),
        (lambda rows: [row[:2] + row[3:] for row in rows], "no column 'dl_3'"),
        (lambda rows: [rows[0], *([repr(1e3 * float(c)) for c in row] for row in rows[1:])], "are these mm?"),
        (lambda rows: [rows[0], *([repr(1e3 * float(row[0])), *row[1:]] for row in rows[1:])], "are units mixed?"),
        (lambda rows: [*rows[:5], ["nan"] * 7, *rows[6:]], "line 6: dl_1 = 'nan': must be a finite number"),
        (lambda rows: [*rows[:5], [""] * 7, *rows[6:]], "line 6: dl_1 = '': must be a finite number"),
        (lambda rows: [*rows[:5], rows[5][:6], *rows[6:]], "line 6: 6 cells; the header has 7"),
        (lambda rows: [[*rows[0][:3], "dl_5", *rows[0][4:]], *rows[1:]], "unknown column 'dl_5'; 'wang2021' has 4"),
        (lambda rows: [[*rows[0][:3], "dl_1", *rows[0][4:]], *rows[1:]], "more than one column 'dl_1'"),
        (lambda rows: [["dl_1 (inch)", *rows[0][1:]], *rows[1:]], "unknown unit 'inch'"),
        (lambda rows: [row[:6] for row in rows], "no column 'z'"),
        (lambda rows: rows[:1], "a header, but no poses"),
        (lambda rows: [], "empty"),
    ],
)
def test_bad_data_are_one_line_and_change_nothing(cli, changed, tmp_path: Path, change, told: str) -> None:
    robot = tmp_path / "mine.toml"
    robot.write_text(library_text("wang2021"))
    out = tmp_path / "new.toml"
    assert told in cli("calibrate", robot, changed(change), "--out", out).refusal
    assert robot.read_text() == library_text("wang2021")
    assert not out.exists()


@pytest.mark.parametrize(
    ("datum", "told"),
    [
        ("south-west,south-west.x", "held twice"),
        ("inner,south-west", "contradict each other"),
        ("nowhere", "unknown datum 'nowhere'"),
        ("south-west.q", "unknown datum"),
    ],
)
def test_a_bad_datum(cli, data: Path, datum: str, told: str) -> None:
    assert told in cli("calibrate", "wang2021", data, "--datum", datum).refusal


def test_a_datum_that_holds_every_unknown(cli, data: Path, tmp_path: Path) -> None:
    plan = tmp_path / "plan.toml"
    names = [line.name for line in load("wang2021").lines]
    plan.write_text(f'schema = 1\nunknowns = ["exit_point"]\ndatum = {json.dumps(names)}\n')
    refusal = cli("calibrate", "wang2021", data, "--plan", plan).refusal
    assert "datum: holds every unknown; nothing is left to calibrate" in refusal


def test_the_report_does_not_take_the_place_of_the_robot(cli, data: Path, tmp_path: Path) -> None:
    file = tmp_path / "mine.html"
    assert (
        "the report would have the same file name"
        in cli("calibrate", "wang2021", data, "--out", file, "--accept").refusal
    )
    assert not file.exists()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("schema = 1\nunknown = []\n", "unknown key"),
        ('schema = 1\nunknowns = ["exit"]\n', "unknown unknown 'exit'"),
        ('schema = 1\nunknowns = ["platform_point"]\n', "point platform"),
        ('schema = 1\n[sigma]\nencoder = "-1 mm"\n', "sigma.encoder"),
        ('schema = 1\ndatum = ["south-west"]\n', "give one of them"),
    ],
)
def test_a_bad_plan(cli, data: Path, tmp_path: Path, text: str, told: str) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text(text)
    assert told in cli("calibrate", "wang2021", data, "--plan", plan, "--datum", "south-east").refusal


@pytest.mark.slow  # as `test_a_bad_answer_is_never_written`
def test_what_cannot_be_calibrated_says_why_and_changes_nothing(cli, changed, tmp_path: Path) -> None:
    def shuffled(rows: list[list[str]]) -> list[list[str]]:
        return [rows[0], *([row[1], row[0], row[2], repr(-float(row[3])), *row[4:]] for row in rows[1:])]

    out = tmp_path / "new.toml"
    answer = cli("calibrate", "wang2021", changed(shuffled), "--out", out, "--json")
    assert answer.no.startswith("not calibrated: ")
    assert answer.json["status"] in ("not-converged", "inconsistent", "degenerate")
    assert answer.json["verdict"] == "bad"
    assert answer.json["out"] is None
    assert not out.exists()


@pytest.mark.usefixtures("undrawn_here")
def test_a_doubtful_answer_is_written_only_where_it_is_accepted(cli, data: Path, tmp_path: Path) -> None:
    out = tmp_path / "new.toml"
    answer = cli("calibrate", "wang2021", data, "--out", out, "--json")
    assert (answer.code, answer.json["status"], answer.json["verdict"], answer.json["out"]) == (
        1,
        "ok",
        "doubtful",
        None,
    )
    assert re.search(
        r"^exit point z of .* is known to .* mm \(one sigma\), where 2 mm is needed", answer.json["reasons"][0]
    )
    assert answer.no.startswith("doubtful: exit point z of ")
    assert not out.exists()
    accepted = cli("calibrate", "wang2021", data, "--out", out, "--accept", "--json")
    assert (accepted.code, accepted.json["verdict"], accepted.json["reasons"]) == (
        0,
        "doubtful",
        answer.json["reasons"],
    )
    assert load(out).lines[2].exit_point != load("wang2021").lines[2].exit_point
    assert 'class="verdict doubt"' in (tmp_path / "new.html").read_text()


@pytest.mark.usefixtures("undrawn_here")
def test_the_required_accuracy_decides(cli, data: Path, tmp_path: Path) -> None:
    out = tmp_path / "new.toml"
    answer = cli("calibrate", "wang2021", data, "--need", "50 mm", "--out", out, "--json")
    assert (answer.code, answer.json["verdict"], answer.json["reasons"]) == (0, "good", [])
    assert answer.json["exit_sigma"] < 0.05
    assert 'class="verdict yes"' in (tmp_path / "new.html").read_text()
    page = re.sub("<[^>]*>", "", (tmp_path / "new.html").read_text()).replace("\xa0", " ")
    assert "Exit points are known to 14.6 mm (one sigma) or better; lengths of 40 poses fit to 0.03 mm" in page
    assert "--need" in cli("calibrate", "wang2021", data, "--need", "much").refusal
    assert "--need" in cli("calibrate", "wang2021", data, "--need", "-1").refusal


def test_a_bad_answer_is_never_written(cli, changed, tmp_path: Path) -> None:
    def exchanged(rows: list[list[str]]) -> list[list[str]]:
        return [rows[0], *([row[1], row[0], *row[2:]] for row in rows[1:])]

    out = tmp_path / "new.toml"
    answer = cli("calibrate", "wang2021", changed(exchanged), "--out", out, "--accept", "--json")
    assert (answer.code, answer.json["verdict"], answer.json["out"]) == (1, "bad", None)
    assert answer.no.startswith("not calibrated: columns 1 and 2")
    assert not out.exists()


def test_all_rows_are_kept_where_that_is_asked(cli, changed) -> None:
    def spoiled(rows: list[list[str]]) -> list[list[str]]:
        rows[8][2] = repr(float(rows[8][2]) + 0.05)
        return rows

    file = changed(spoiled)
    (out,) = cli("calibrate", "wang2021", file, "--json").json["rejected"]
    assert (out["pose"], len(out["measured"]), len(out["expected"])) == (8, 4, 4)
    assert cli("calibrate", "wang2021", file, "--keep-all", "--json").json["rejected"] == []


@pytest.mark.parametrize(
    "options",
    [("--poses", "0"), ("--poses", "999999999"), ("--noise", "-1"), ("--noise", "nan"), ("--seed", "-1")],
)
def test_bad_simulations(cli, tmp_path: Path, options: tuple[str, str]) -> None:
    given = {"--poses": "20", "--noise": "0.0001", "--seed": "1", "--out": str(tmp_path / "d.csv")} | dict([options])
    assert cli("simulate-calibration", "wang2021", *(part for pair in given.items() for part in pair)).refusal


@pytest.mark.slow  # in calibration/test_elastic_lines.py; a robot is written above
@pytest.mark.usefixtures("undrawn_here")
def test_lines_that_sag(cli, tmp_path: Path) -> None:
    """The same contract as of rigid lines; the modulus is written, comments are kept, there is a report."""
    file, robot, out = tmp_path / "d.csv", tmp_path / "mine.toml", tmp_path / "new.toml"
    robot.write_text(library_text("paty2021").replace("102.2 GPa", "80 GPa"))
    made = ("--poses", "25", "--noise", "0", "--cable", "catenary", "--tension-noise", "0", "--seed", "3")
    truth = tmp_path / "t.json"
    assert cli("simulate-calibration", "paty2021", *made, "--guess", "0.02", "--out", file, "--truth", truth).code == 0
    plan = tmp_path / "plan.toml"
    plan.write_text('schema = 1\nunknowns = ["exit_point", "length_offset", "modulus"]\nshared = ["modulus"]\n')
    asked = (
        "calibrate",
        robot,
        file,
        "--cable",
        "catenary",
        "--plan",
        plan,
        "--rough",
        "0.02",
        "--out",
        out,
        "--accept",
    )
    found = cli(*asked, "--json").json
    assert found.keys() >= KEYS
    assert (found["status"], found["cable"]) == ("ok", "catenary")
    assert found["unknowns"] - found["rank"] == len(found["gauge"]) == 4
    assert found["rms"] < 1e-10
    home = [found["values"][f"home length of {line.name}"] for line in load("paty2021").lines]
    assert home == pytest.approx(json.loads(truth.read_text())["home_lengths"], abs=1e-8)
    assert load(out).lines[0].cable.young_modulus == pytest.approx(load("paty2021").lines[0].cable.young_modulus)
    assert "Lines stretch and sag" in (tmp_path / "new.html").read_text()
    assert "# " in out.read_text()


@pytest.mark.parametrize(
    ("robot", "made", "asked", "told"),
    [
        ("wang2021", (), ("--cable", "elastic"), "measure tensions (f_1 .., even roughly"),
        ("wang2021", ("--tension-noise", "1"), ("--cable", "rubber"), "is not one of"),
        (
            "wang2021",
            ("--tension-noise", "1"),
            ("--cable", "elastic", "--datum", "south-west,inner"),
            "contradict each",
        ),
        ("wang2021", ("--tension-noise", "1", "--poses", "2"), ("--cable", "elastic"), "at least 3 are required"),
    ],
)
def test_bad_data_of_lines_that_stretch(cli, tmp_path: Path, robot: str, made, asked, told: str) -> None:
    file, out = tmp_path / "d.csv", tmp_path / "new.toml"
    given = {"--poses": "20", "--noise": "0"} | dict(zip(made[::2], made[1::2], strict=True))
    made_up = (part for pair in given.items() for part in pair)
    assert cli("simulate-calibration", robot, *made_up, "--cable", "elastic", "--out", file).code == 0
    assert told in cli("calibrate", robot, file, *asked, "--out", out).refusal
    assert not out.exists()


def test_all_that_may_be_measured_is_made_and_read(cli, tmp_path: Path) -> None:
    file, noise = tmp_path / "d.csv", ("--tension-noise", "0.5", "--swivel-noise", "0.001", "--tilt-noise", "0.001")
    made = ("--poses", "12", "--noise", "0.0001", *noise, "--pose-noise", "0.001", "--cable", "catenary")
    assert cli("simulate-calibration", "jung2020", *made, "--out", file).code == 0
    file.with_suffix(".toml").write_text('schema = 1\n[sigma]\nencoder = "0.1 mm"\ntension = "0.5 N"\n')
    found = cli("calibrate", "jung2020", file, "--cable", "catenary", "--rough", "0.01", "--json").json
    assert (found["status"], found["gauge"], found["rejected"]) == ("ok", [], [])
    assert "no tilt" in cli("simulate-calibration", "wang2021", *made, "--out", file).refusal
    bad = ("--poses", "5", "--noise", "0", "--tension-noise", "nan", "--out", file)
    assert "tension noise = nan" in cli("simulate-calibration", "wang2021", *bad).refusal


def test_a_body_may_be_guessed_unrotated(cli, tmp_path: Path) -> None:
    file, cut = tmp_path / "d.csv", tmp_path / "cut.csv"
    cli(
        "simulate-calibration",
        "jung2020",
        "--poses",
        "30",
        "--noise",
        "0",
        "--seed",
        "2",
        "--guess",
        "0.02",
        "--out",
        file,
    )
    rows = [line.split(",") for line in file.read_text().splitlines() if not line.startswith("#")]
    cut.write_text("".join(",".join(row[:11]) + "\n" for row in rows))
    found = cli("calibrate", "jung2020", cut, "--rough", "0.05", "--json").json
    assert found["status"] == "ok"
    assert found["rms"] < 1e-10
    assert len(found["gauge"]) == 6


@pytest.mark.usefixtures("undrawn_here")
def test_what_was_calibrated_is_checked_and_compared(cli, data: Path, tmp_path: Path) -> None:
    lines = data.read_text().splitlines(keepends=True)
    early, late = tmp_path / "early.csv", tmp_path / "late.csv"
    early.write_text("".join(lines[:-8]))
    late.write_text("".join([*lines[:4], *lines[-8:]]))
    robot = tmp_path / "mine.toml"
    made = cli("calibrate", "wang2021", early, "--need", "0.1", "--out", robot, "--json")
    record = tmp_path / "mine.calibration.toml"
    assert (made.code, made.json["record"], record.exists()) == (0, str(record), True)
    assert "moved" not in made.json
    same = cli("calibrate", robot, late, "--check", "--json")
    assert (same.code, same.json["verdict"], same.json["changes"]) == (0, "unchanged", [])
    rows = [line.split(",") for line in late.read_text().splitlines() if not line.startswith("#")]
    for row in rows[1:]:
        row[2] = repr(float(row[2]) - 0.01)
    late.write_text("".join(",".join(row) + "\n" for row in rows))
    moved = cli("calibrate", robot, late, "--check", "--json")
    (change,) = moved.json["changes"]
    assert (moved.code, moved.json["verdict"], change["line"]) == (1, "moved", "north-east")
    assert change["amount"] == pytest.approx(0.01, abs=1e-3)
    assert "length of north-east by +" in moved.err
    again = cli("calibrate", robot, data, "--need", "0.1", "--json")
    assert (again.json["moved"], again.json["last"].endswith("early.csv")) == ([], True)
    elsewhere = cli("calibrate", "wang2021", late, "--check", "--last", record)
    assert (elsewhere.code, "give the file that this calibration wrote" in elsewhere.err) == (2, True)


def test_a_guide_needs_no_data_and_writes_the_next_poses(cli, data: Path, tmp_path: Path) -> None:
    file = tmp_path / "next.csv"
    told = cli(
        "calibrate", "wang2021", tmp_path / "none.csv", "--guide", "--rough", "0.05", "--next-out", file, "--json"
    )
    assert (told.code, told.json["advice"], told.json["poses"], told.json["sigma"]) == (0, "measure", 0, None)
    assert len(told.json["next"]) == 17
    assert file.read_text().splitlines()[1] == "dl_1,dl_2,dl_3,dl_4,x,y,z"
    later = cli("calibrate", "wang2021", data, "--guide", "--next", "2", "--json").json
    assert (later["poses"], len(later["next"]), len(later["exits"])) == (40, 2, 4)
    assert later["sigma_next"] <= later["sigma"]
    assert cli("calibrate", "wang2021", data, "--guide", "--need", "0.1", "--json").json["advice"] == "stop"


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        (("--check",), "no record of a calibration beside wang2021"),
        (("--check", "--guide"), "give one of them"),
        (("--guide", "--out", "x.toml"), "writes no robot"),
        (("--guide", "--next", "0"), "next = 0: must be from 1 to 50"),
        (("--check", "--last", "nowhere.toml"), "nowhere.toml: no such file"),
    ],
)
def test_what_check_and_guide_reject(cli, data: Path, asked: tuple[str, ...], told: str) -> None:
    found = cli("calibrate", "wang2021", data, *asked)
    assert (found.code, told in found.err) == (2, True), found.err


def test_effects_that_cross_validation_tests_are_shown(cli, data: Path) -> None:
    answer = cli("calibrate", "wang2021", data, "--models", "auto", "--accept")
    assert answer.code == 0
    assert "effects" in answer.out
    assert all(name in answer.out for name in ("stretch", "deflection", "held-out error without"))
    assert "effects" not in cli("calibrate", "wang2021", data, "--accept", "--json").json
    assert cli("calibrate", "wang2021", data, "--models", "all").code == 2
