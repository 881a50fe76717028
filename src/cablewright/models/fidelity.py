"""The choice of physics, separate from the hardware."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from cablewright.foundation.errors import InputError, UnknownName


class CableLaw(StrEnum):
    """Model of the cables: straight and rigid, straight and elastic, or elastic with weight."""

    RIGID = "rigid"
    ELASTIC = "elastic"
    CATENARY = "catenary"


class SheaveLaw(StrEnum):
    """Model of the sheaves, from the simplest to the most detailed."""

    EYELET = "eyelet"
    SWIVEL = "swivel"
    UNIVERSAL_JOINT = "universal-joint"


@dataclass(frozen=True)
class Fidelity:
    """Cable law and sheave law. `sheave=None`: each sheave as it is built; another law simplifies it."""

    cable: CableLaw = CableLaw.CATENARY
    sheave: SheaveLaw | None = None

    @classmethod
    def of(cls, cable: str = "catenary", sheave: str | None = None) -> Fidelity:
        """Return the fidelity with the cable law and sheave law of these names.

        Raises `UnknownName` for any other name.
        """
        if cable not in list(CableLaw):
            raise UnknownName("cable law", cable, [law.value for law in CableLaw])
        if sheave is not None and sheave not in list(SheaveLaw):
            raise UnknownName("sheave law", sheave, [law.value for law in SheaveLaw])
        return cls(CableLaw(cable), None if sheave is None else SheaveLaw(sheave))

    def __str__(self) -> str:
        """The names of the laws: ``catenary`` with sheaves as built, ``elastic, eyelet``."""
        return ", ".join(law.value for law in (self.cable, self.sheave) if law is not None)

    def sheave_of(self, built: str, line: str) -> SheaveLaw:
        """Return the law of a *line* whose sheave is *built* so. Raises `InputError` for a law beyond the hardware.

        A pulley as built has the law `SWIVEL`: that of a sheave without a lever.
        """
        if built == "pulley":  # fixed in its plane: of the laws only the eyelet is simpler
            if self.sheave not in (None, SheaveLaw.EYELET):
                raise InputError(f"sheave = {self.sheave}: line {line!r} has a pulley, which does not turn")
            return self.sheave or SheaveLaw.SWIVEL
        hardware = SheaveLaw(built)
        if self.sheave is None:
            return hardware
        order = list(SheaveLaw)
        if order.index(self.sheave) > order.index(hardware):
            raise InputError(f"sheave = {self.sheave.value}: line {line!r} has only a sheave of kind {hardware.value}")
        return self.sheave
