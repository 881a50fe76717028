"""What `forward --certify` proves, and `--length-error`, the box that holds the pose; the reasons where nothing is."""

from __future__ import annotations

import re

import numpy as np
import pytest

from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.certify import certify
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.pose_hull import enclose_poses

CERTIFY = ("forward", "house-printer", "--lengths", "28,28,28,28", "--certify")
MIDDLE = {"wang2021": "0,0,0.5", "merlet2023": "0,0,1", "cogiro": "0,0,2"}
LENGTHS = [28.0, 28.0, 28.1, 28.0]
FORWARD = ("forward", "house-printer", "--lengths", ",".join(map(str, LENGTHS)))
KEYS = {"bound", "box", "levers", "unique", "unique_among", "reason"}


@pytest.mark.parametrize("sheave", [None, "eyelet", "swivel", "universal-joint"])
def test_it_prints_what_the_solver_proves(cli, sheave: str | None) -> None:
    answer = cli(*CERTIFY, *(() if sheave is None else ("--sheave", sheave)), "--json")
    told = [line for line in answer.err.splitlines() if not line.startswith("compiling kernels")]
    assert (answer.code, told) == (0, [])
    found = answer.json
    assert found["certified"] is True
    assert found["certificate"].keys() == KEYS
    model = Model(load("house-printer"), Fidelity.of("catenary", sheave))
    proof = certify(solve_forward(model, [28.0] * 4))
    assert found["certificate"]["bound"] == proof.bound.tolist()
    assert found["certificate"]["box"] == proof.box.tolist()
    assert max(found["certificate"]["bound"]) < 1e-9
    jointed = sheave in (None, "universal-joint")
    assert found["certificate"]["levers"] == ("stable" if jointed else None)
    assert found["certificate"]["unique"] == ("locally" if jointed else "conditionally")  # dead spans are modelled
    assert "exactly one equilibrium" in found["certificate"]["reason"]


def test_without_the_option_nothing_is_certified(cli) -> None:
    assert not {"certified", "certificate"} & cli(*CERTIFY[:-1], "--json").json.keys()


@pytest.mark.parametrize(
    ("name", "sheave", "unique"),
    [
        ("wang2021", "eyelet", "globally"),
        ("wang2021", None, "conditionally"),  # swivels
        ("merlet2023", "eyelet", "conditionally"),  # a dead span
        ("cogiro", "eyelet", "locally"),  # a body
    ],
)
def test_it_says_where_there_is_one_equilibrium_at_all(cli, name: str, sheave: str | None, unique: str) -> None:
    options = () if sheave is None else ("--sheave", sheave)
    held = cli("inverse", name, "--at", MIDDLE[name], *options, "--json").json
    lengths = ",".join(map(repr, held["lengths"]))
    answer = cli("forward", name, "--lengths", lengths, *options, "--certify", "--json")
    assert answer.code == 0, answer.err
    assert answer.json["certificate"]["unique"] == unique
    text = cli("forward", name, "--lengths", lengths, *options, "--certify")
    assert text.figure("unique") == unique


def test_a_cable_without_weight_is_not_proved_to_hang_in_one_place_only(cli) -> None:
    options = ("--sheave", "eyelet", "--cable", "elastic", "--json")
    held = cli("inverse", "wang2021", "--at", MIDDLE["wang2021"], *options).json
    lengths = ",".join(map(repr, held["lengths"]))
    found = cli("forward", "wang2021", "--lengths", lengths, *options, "--certify").json
    assert found["certificate"]["unique"] == "locally"


def test_people_get_the_certificate(cli) -> None:
    plain, answer = cli(*CERTIFY[:-1]), cli(*CERTIFY)
    assert (answer.code, answer.err) == (0, "")
    assert "certificate" not in plain.out
    assert (answer.figure("certified"), answer.figure("unique"), answer.figure("levers")) == (
        "yes",
        "locally",
        "stable",
    )
    assert re.fullmatch(r"\S+, \S+, \S+ m", answer.figure("bound"))


def test_a_body_has_a_bound_on_its_turn(cli) -> None:
    lengths = cli("inverse", "cogiro", "--at", MIDDLE["cogiro"], "--json").json["lengths"]
    answer = cli("forward", "cogiro", "--lengths", ",".join(map(repr, lengths)), "--certify")
    assert answer.code == 0
    assert (answer.figure("bound")[-3:], answer.figure("unique")) == ("rad", "locally")


@pytest.mark.parametrize("as_json", [True, False])
def test_what_is_not_certified_is_a_no_with_its_reason(cli, as_json: bool) -> None:
    slack = ("forward", "house-printer", "--lengths", "29,28,28,28", "--cable", "elastic")
    more = ["--json"] if as_json else []
    assert cli(*slack, *more).code == 0
    answer = cli(*slack, "--certify", *more)
    assert answer.no == "not certified: a massless line hangs slack and has no shape"
    if as_json:
        found = answer.json
        assert found["status"] == "ok"
        assert found["certified"] is False
        assert found["certificate"]["bound"] == [None] * 3
        assert found["certificate"]["unique"] is None
    else:
        assert answer.figure("certified") == "no"


def test_a_status_goes_before_the_certificate(cli) -> None:
    answer = cli("forward", "house-printer", "--lengths", "25,24,25,25", "--certify", "--json")
    assert "breaking load" in answer.no
    assert answer.json["status"] == "overstretched"
    assert answer.json["certified"] is True  # it balances, and that is proved


def test_where_there_is_no_answer_nothing_is_certified(cli) -> None:
    answer = cli("forward", "house-printer", "--lengths", "2,2,2,2", "--certify", "--json")
    assert answer.code == 1
    assert answer.json["certified"] is (answer.json["status"] == "overstretched")


def test_rigid_cables_are_rejected(cli) -> None:
    assert "do not determine tensions" in cli(*CERTIFY, "--cable", "rigid").refusal


@pytest.mark.slow
def test_it_prints_the_box_that_the_solver_proves(cli) -> None:
    answer = cli(*FORWARD, "--length-error", "1e-3", "--json")
    assert (answer.code, answer.err) == (0, "")
    box = answer.json["pose_box"]
    assert box.keys() == {"low", "high", "certified", "unique", "leaves", "reason"}
    found = solve_forward(Model(load("house-printer")), LENGTHS)
    proved = enclose_poses(found, 1e-3)
    assert box["certified"] is proved.complete is True
    assert (box["low"], box["high"]) == (proved.low.tolist(), proved.high.tolist())
    assert box["unique"] == "locally"
    assert box["leaves"] == proved.leaves > 0
    assert (np.array(box["low"]) < answer.json["pose"]).all()
    assert (np.array(box["high"]) > answer.json["pose"]).all()


def test_no_box_is_an_answer_too(cli) -> None:
    answer = cli(*FORWARD, "--length-error", "0.05", "--budget", "3", "--json")
    assert answer.code == 0
    box = answer.json["pose_box"]
    assert box["certified"] is False
    assert box["low"] == box["high"] == [None] * 3
    assert box["unique"] is None
    assert box["reason"].startswith("no box within the budget of 3 leaves")
    assert "no box within the budget" in cli(*FORWARD, "--length-error", "0.05", "--budget", "3").out


def test_people_get_ends_that_are_rounded_outward(cli) -> None:
    answer = cli(*FORWARD, "--length-error", "1e-3,1e-3,2e-3,1e-3")
    assert answer.code == 0
    low, high = answer.figure("low"), answer.figure("high")
    box = enclose_poses(solve_forward(Model(load("house-printer")), LENGTHS), [1e-3, 1e-3, 2e-3, 1e-3])
    least, most = (np.array(list(map(float, re.findall(r"-?\d+\.\d+", line)))) for line in (low, high))
    assert ((least <= box.low) & (box.low < least + 1.1e-6)).all()
    assert ((most >= box.high) & (box.high > most - 1.1e-6)).all()


def test_without_the_option_there_is_no_box(cli) -> None:
    assert "pose_box" not in cli(*FORWARD, "--json").json


@pytest.mark.parametrize(
    ("given", "says"),
    [
        (("0",), "over 0 is expected"),
        (("-1e-3",), "over 0 is expected"),
        (("30",), "as large as the length of line"),
        (("1e-3,1e-3",), "one number is expected, or 4"),
        (("wide",), "--length-error = 'wide'"),
        (("1e-3", "--budget", "0"), "budget = 0"),
    ],
)
def test_bad_errors_are_rejected_in_one_line(cli, given: tuple[str, ...], says: str) -> None:
    answer = cli(*FORWARD, "--length-error", *given)
    assert answer.code == 2
    assert answer.out == ""
    assert says in answer.err
    assert len(answer.err.splitlines()) == 1
