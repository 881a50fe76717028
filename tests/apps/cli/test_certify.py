"""`forward --certify`: what is proved, and the reason where nothing is."""

from __future__ import annotations

import pytest

from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.certify import certify
from cablewright.solvers.forward import solve_forward

CERTIFY = ("forward", "house-printer", "--lengths", "28,28,28,28", "--certify")
MIDDLE = {"wang2021": "0,0,0.5", "merlet2023": "0,0,1", "cogiro": "0,0,2"}
KEYS = {"bound", "box", "levers", "unique", "reason"}


@pytest.mark.parametrize("sheave", [None, "eyelet", "swivel", "universal-joint"])
def test_it_prints_what_the_solver_proves(cli, sheave: str | None) -> None:
    answer = cli(*CERTIFY, *(() if sheave is None else ("--sheave", sheave)), "--json")
    assert (answer.code, answer.err) == (0, "")
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
    assert found["certificate"]["unique"] == "locally"  # dead spans are modelled
    assert "exactly one equilibrium" in found["certificate"]["reason"]


def test_without_the_option_nothing_is_certified(cli) -> None:
    assert not {"certified", "certificate"} & cli(*CERTIFY[:-1], "--json").json.keys()


@pytest.mark.parametrize(
    ("name", "sheave", "unique"),
    [
        ("wang2021", "eyelet", "globally"),
        ("wang2021", None, "locally"),  # swivels
        ("merlet2023", "eyelet", "locally"),  # a dead span
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
    assert ("the only one there is" in text.out) == (unique == "globally")


def test_a_cable_without_weight_is_not_proved_to_hang_in_one_place_only(cli) -> None:
    options = ("--sheave", "eyelet", "--cable", "elastic", "--json")
    held = cli("inverse", "wang2021", "--at", MIDDLE["wang2021"], *options).json
    lengths = ",".join(map(repr, held["lengths"]))
    found = cli("forward", "wang2021", "--lengths", lengths, *options, "--certify").json
    assert found["certificate"]["unique"] == "locally"


def test_people_get_one_line(cli) -> None:
    plain, answer = cli(*CERTIFY[:-1]), cli(*CERTIFY)
    assert (answer.code, answer.err) == (0, "")
    more = [line for line in answer.out.splitlines() if line not in plain.out.splitlines()]
    assert len(more) == 1
    assert more[0].startswith("certified: an equilibrium within ")
    assert more[0].endswith(" m, the only one near; levers stable")


def test_a_body_has_a_bound_on_its_turn(cli) -> None:
    lengths = cli("inverse", "cogiro", "--at", MIDDLE["cogiro"], "--json").json["lengths"]
    answer = cli("forward", "cogiro", "--lengths", ",".join(map(repr, lengths)), "--certify")
    assert answer.code == 0
    assert " rad, the only one near" in answer.out


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
        assert "not certified: a massless line" in answer.out


def test_a_status_goes_before_the_certificate(cli) -> None:
    answer = cli("forward", "house-printer", "--lengths", "25,24,25,25", "--certify", "--json")
    assert "breaking load" in answer.no
    assert answer.json["status"] == "overstretched"
    assert answer.json["certified"] is True  # it balances, and that is proved


def test_where_there_is_no_answer_nothing_is_certified(cli) -> None:
    answer = cli("forward", "house-printer", "--lengths", "2,2,2,2", "--certify", "--json")
    assert answer.code == 1
    assert answer.json["certified"] is (answer.json["status"] == "overstretched")


def test_rigid_cables_are_refused(cli) -> None:
    assert "leave tensions undecided" in cli(*CERTIFY, "--cable", "rigid").refusal
