"""`inverse` and `forward`: the contract's JSON, and a no with its reason and numbers."""

from __future__ import annotations

import math

import pytest

from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse

LENGTHS = "28,28,28,28"
INVERSE_KEYS = {"schema", "status", "pose", "lengths", "tensions", "residual"}
FORWARD_KEYS = {"schema", "status", "pose", "tensions", "residual"}


@pytest.mark.parametrize("cable", ["rigid", "elastic", "catenary"])
@pytest.mark.parametrize("sheave", [None, "eyelet", "swivel", "universal-joint"])
def test_inverse_prints_what_the_solver_finds(cli, cable: str, sheave: str | None) -> None:
    options = () if sheave is None else ("--sheave", sheave)
    answer = cli("inverse", "house-printer", "--at", "1,2,1.5", "--cable", cable, *options, "--json")
    assert (answer.code, answer.err) == (0, "")
    found = answer.json
    assert found.keys() >= INVERSE_KEYS
    assert found["status"] == "ok"
    assert found["pose"] == [1.0, 2.0, 1.5]
    assert (found["cable"], found["sheave"]) == (cable, sheave)
    solved = solve_inverse(Model(load("house-printer"), Fidelity.of(cable, sheave)), [1, 2, 1.5])
    assert found["lengths"] == solved.lengths.tolist()
    assert found["tensions"] == solved.tensions.tolist()
    assert 0.0 <= found["residual"] < 1e-9


@pytest.mark.parametrize("cable", ["elastic", "catenary"])
def test_forward_prints_what_the_solver_finds(cli, cable: str) -> None:
    answer = cli("forward", "house-printer", "--lengths", LENGTHS, "--cable", cable, "--json")
    assert (answer.code, answer.err) == (0, "")
    found = answer.json
    assert found.keys() >= FORWARD_KEYS
    assert found["status"] == "ok"
    solved = solve_forward(Model(load("house-printer"), Fidelity.of(cable)), [28.0] * 4)
    assert found["pose"] == solved.pose.tolist()
    assert len(found["pose"]) == 3
    assert found["tensions"] == solved.tensions.tolist()


def test_forward_undoes_inverse(cli) -> None:
    held = cli("inverse", "house-printer", "--at", "1,2,1.5", "--json").json
    lengths = ",".join(repr(length) for length in held["lengths"])
    for guess in ((), ("--guess", "1.1,1.9,1.4")):
        back = cli("forward", "house-printer", "--lengths", lengths, *guess, "--json").json
        assert back["pose"] == pytest.approx(held["pose"], abs=1e-9)
        assert back["tensions"] == pytest.approx(held["tensions"], rel=1e-9)


def test_modulus_factors_move_the_platform_and_leave_nothing_unsolved(cli) -> None:
    plain = cli("forward", "house-printer", "--lengths", LENGTHS, "--json").json
    ones = cli("forward", "house-printer", "--lengths", LENGTHS, "--modulus-factors", "1,1,1,1", "--json").json
    softer = cli("forward", "house-printer", "--lengths", LENGTHS, "--modulus-factors", ".5,.5,.5,.5", "--json").json
    assert ones["pose"] == plain["pose"]
    assert softer["pose"][2] < plain["pose"][2] - 1e-4
    assert softer["residual"] < 1e-9


def test_people_get_a_table(cli) -> None:
    answer = cli("inverse", "house-printer", "--at", "1,2,1.5")
    assert (answer.code, answer.err) == (0, "")
    assert (answer.figure("status"), answer.figure("robot")) == ("ok", "house-printer")
    assert answer.rows[-5] == ["line", "length, m", "tension, N", "at platform, N", "at winch, N"]
    assert [row[0] for row in answer.rows[-4:]] == ["south-west", "south-east", "north-east", "north-west"]
    assert answer.rows[-4][1] == "33.482453"


@pytest.mark.parametrize("as_json", [True, False])
def test_overstretched_names_the_line_and_by_how_much(cli, as_json: bool) -> None:
    answer = cli("forward", "house-printer", "--lengths", "25,24,25,25", *(["--json"] if as_json else []))
    line, tension, over, breaking = (
        answer.no.removeprefix("a line is over its breaking load: line ")
        .replace(" N over its", ",")
        .replace(" at ", ",")
        .replace(" N", "")
        .split(",")
    )
    assert line in {"south-west", "south-east", "north-east", "north-west"}
    assert float(breaking) == 10290
    assert float(tension) - float(breaking) == pytest.approx(float(over), rel=1e-3)
    if as_json:
        found = answer.json
        assert found["status"] == "overstretched"
        names = [each.name for each in load("house-printer").lines]
        assert max(found["tensions"]) == found["tensions"][names.index(line)] == pytest.approx(float(tension), rel=1e-5)
    else:
        assert answer.figure("status") == "overstretched"


@pytest.mark.parametrize(
    ("at", "status", "says"),
    [
        ("0,0,14.9", "infeasible", "above its maximum, 5150 N"),
        ("0,0,20", "infeasible", "a line would have to push"),  # above the frame: lines cannot push down
        ("9,0,1", "infeasible", "a line would have to push"),  # outside the lines
        ("7.4,7.4,14.95", "inside-sheave", "inside a sheave"),
        ("7.5,7.5,1", "infeasible", "a line would have to push"),  # on the vertical axis of a sheave: the limit
        ("0,0,-1", "out-of-limits", "frame, z -1 m; 0 to 15 m is allowed"),
    ],
)
def test_a_pose_that_cannot_be_held(cli, at: str, status: str, says: str) -> None:
    answer = cli("inverse", "house-printer", f"--at={at}", "--json")
    assert says in answer.no
    assert answer.json["status"] == status
    assert answer.json.keys() >= INVERSE_KEYS
    text = cli("inverse", "house-printer", f"--at={at}")
    assert text.no == answer.no
    assert text.figure("status") == status


@pytest.mark.parametrize("at", ["0,0,14.9", "7.45,0,1"])
def test_an_infeasible_pose_is_reported_with_the_numbers_it_prints(cli, at: str) -> None:
    """The line, the excess and the tensions printed belong together."""
    answer = cli("inverse", "house-printer", "--at", at, "--json")
    said, found = answer.no.split(": at best line ")[1], answer.json
    name, excess = said.split(" is ")[0], float(said.split(" is ")[1].split(" N")[0])
    i = [line.name for line in load("house-printer").lines].index(name)
    ends = [found[key][i] for key in ("tensions", "platform_tensions", "winch_tensions")]
    under, over = 20 - min(ends), max(ends) - 5150
    assert (under if "below" in said else over) == pytest.approx(excess, rel=0.01, abs=0.1)
    assert found["margin"] == pytest.approx(-excess, rel=0.01, abs=0.1)


def test_tension_limits_decide(cli) -> None:
    at = ("inverse", "house-printer", "--at", "0,0,1", "--json", "--tension-limits")
    assert cli(*at, "100,2000").code == 0
    assert "384.2 N below its minimum, 1000 N" in cli(*at, "1000,2000").no
    assert "above its maximum, 600 N" in cli(*at, "20,600").no


def test_numbers_that_are_not_finite_are_null(cli) -> None:
    answer = cli("inverse", "house-printer", "--at", "0,0,1e29", "--json")
    assert answer.code == 1
    assert answer.json["residual"] is None


@pytest.mark.parametrize("length", [40, 100, 200])
def test_long_lines_hang_below_the_floor(cli, length: int) -> None:
    found = cli("forward", "house-printer", "--lengths", ",".join([str(length)] * 4), "--json").json
    assert found["pose"][:2] == pytest.approx([0, 0], abs=1e-9)
    assert -length < found["pose"][2] < -length + 35
    assert sum(found["platform_tensions"]) >= 200 * 9.81
    assert all(math.isfinite(x) for x in found["tensions"])
