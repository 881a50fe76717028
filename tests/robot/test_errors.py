"""The exception family: one line, an exit code, the nearest valid names."""

import pytest

from cablewright.foundation.errors import (
    AnswerError,
    CablewrightError,
    EnvironmentFault,
    InputError,
    UnknownName,
    suggestion,
)


@pytest.mark.parametrize(("kind", "code"), [(AnswerError, 1), (InputError, 2), (UnknownName, 2), (EnvironmentFault, 3)])
def test_each_kind_has_its_exit_code(kind: type[CablewrightError], code: int) -> None:
    assert kind.exit_code == code
    assert issubclass(kind, CablewrightError)


def test_a_message_is_one_line() -> None:
    assert str(InputError("a file\n\twith a\r\nbroken name")) == "a file with a broken name"


def test_an_unknown_name_offers_the_nearest() -> None:
    error = UnknownName("robot", "paty2012", ["paty2021", "merlet2023"])
    assert str(error) == "unknown robot 'paty2012'; did you mean 'paty2021'?"
    assert error.valid == ("paty2021", "merlet2023")


def test_suggestion_lists_what_is_allowed_where_nothing_is_near() -> None:
    assert suggestion("zzz", ["b", "a"]) == "allowed: a, b"
    assert suggestion("zzz", [f"name{k:02}" for k in range(15)], limit=2) == "allowed: name00, name01 and 13 more"
    assert suggestion("zzz", []) == "there are none"
