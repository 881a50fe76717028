"""The physics one chooses: by a word, and never more than the hardware has."""

from __future__ import annotations

import pytest

from cablewright.foundation.errors import InputError, UnknownName
from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
from cablewright.models.statics import Model
from cablewright.robot import library_names, load

ORDER = list(SheaveLaw)


@pytest.mark.parametrize("cable", list(CableLaw))
@pytest.mark.parametrize("sheave", [None, *SheaveLaw])
def test_words_and_values_are_the_same(cable: CableLaw, sheave: SheaveLaw | None) -> None:
    words = Fidelity.of(cable.value, None if sheave is None else sheave.value)
    assert words == Fidelity(cable, sheave)
    assert hash(words) == hash(Fidelity(cable, sheave))
    assert isinstance(words.cable, CableLaw)


def test_without_words_it_is_all_physics() -> None:
    assert Fidelity.of() == Fidelity() == Fidelity(CableLaw.CATENARY, None)


@pytest.mark.parametrize("word", ["rope", "", "Catenary", "catenary "])
def test_another_word_is_rejected_with_those_there_are(word: str) -> None:
    with pytest.raises(UnknownName, match="unknown cable law"):
        Fidelity.of(word)
    with pytest.raises(UnknownName, match="unknown sheave law"):
        Fidelity.of("rigid", word)


@pytest.mark.parametrize(("wrong", "right"), [("catenry", "catenary"), ("elastc", "elastic")])
def test_a_near_word_is_suggested_as_one_would_type_it(wrong: str, right: str) -> None:
    with pytest.raises(UnknownName) as caught:
        Fidelity.of(wrong)
    assert str(caught.value) == f"unknown cable law '{wrong}'; did you mean '{right}'?"


@pytest.mark.parametrize("built", ORDER)
@pytest.mark.parametrize("wanted", ORDER)
def test_a_sheave_can_be_simplified_but_not_added_to(built: SheaveLaw, wanted: SheaveLaw) -> None:
    fidelity = Fidelity(sheave=wanted)
    if ORDER.index(wanted) <= ORDER.index(built):
        assert fidelity.sheave_of(built.value, "east") is wanted
    else:
        with pytest.raises(InputError, match=f"sheave = {wanted}: line 'east' has only a sheave of kind {built}"):
            fidelity.sheave_of(built.value, "east")


def test_as_built_is_as_built() -> None:
    assert [Fidelity().sheave_of(kind.value, "east") for kind in ORDER] == ORDER


@pytest.mark.parametrize("name", library_names())
def test_a_model_of_more_than_the_hardware_is_rejected_when_packed(name: str) -> None:
    robot = load(name)
    for sheave in ORDER:
        model = Model(robot, Fidelity(sheave=sheave))
        if ORDER.index(sheave) <= ORDER.index(SheaveLaw(robot.lines[0].sheave.kind)):
            assert model.packed.lines.shape[0] == robot.m
        else:
            with pytest.raises(InputError, match="has only a sheave of kind"):
                _ = model.packed
