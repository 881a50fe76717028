"""The physics one chooses to use, apart from the hardware that there is."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from cablewright.errors import InputError, UnknownName


class CableLaw(StrEnum):
    """How a cable behaves: straight and stiff, straight and elastic, or elastic with weight."""

    RIGID = "rigid"
    ELASTIC = "elastic"
    CATENARY = "catenary"


class SheaveLaw(StrEnum):
    """How a line leaves its mounting, from the plainest model to the fullest."""

    EYELET = "eyelet"
    SWIVEL = "swivel"
    UNIVERSAL_JOINT = "universal-joint"


@dataclass(frozen=True)
class Fidelity:
    """Cable law and sheave law. `sheave=None` takes each sheave as it is built; another value simplifies it."""

    cable: CableLaw = CableLaw.CATENARY
    sheave: SheaveLaw | None = None

    @classmethod
    def of(cls, cable: str = "catenary", sheave: str | None = None) -> Fidelity:
        """From the words of the command line. Raises `UnknownName` for another word."""
        if cable not in list(CableLaw):
            raise UnknownName("cable law", cable, [law.value for law in CableLaw])
        if sheave is not None and sheave not in list(SheaveLaw):
            raise UnknownName("sheave law", sheave, [law.value for law in SheaveLaw])
        return cls(CableLaw(cable), None if sheave is None else SheaveLaw(sheave))

    def __str__(self) -> str:
        """Its words: ``catenary`` with sheaves as built, ``elastic, eyelet``."""
        return ", ".join(law.value for law in (self.cable, self.sheave) if law is not None)

    def sheave_of(self, built: str, line: str) -> SheaveLaw:
        """The law for a sheave *built* as named. A model can simplify hardware, it cannot add to it."""
        hardware = SheaveLaw(built)
        if self.sheave is None:
            return hardware
        order = list(SheaveLaw)
        if order.index(self.sheave) > order.index(hardware):
            raise InputError(f"sheave = {self.sheave.value}: line {line!r} has only a sheave of kind {hardware.value}")
        return self.sheave
