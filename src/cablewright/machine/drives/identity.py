"""Identity of a drive, from its identity object: vendor, product, serial number."""

from __future__ import annotations

from typing import Final, NamedTuple

from cablewright.foundation.errors import InputError
from cablewright.machine.drives import objects as o
from cablewright.machine.drives.object_transfers import Transfer, Transfers
from cablewright.machine.drives.objects import Mode, supports

_RATED: Final = 0.01  # share by which a motor's rated torque may be off the file's
_ASKED: Final = (
    o.DEVICE_TYPE, o.VENDOR, o.PRODUCT, o.REVISION, o.SERIAL, o.SUPPORTED_MODES, o.RATED_TORQUE, o.DEVICE_NAME
)  # fmt: skip


class Identity(NamedTuple):
    """Identity of the device at a node; None: not reported."""

    node: int
    profile: int
    vendor: int | None
    product: int | None
    revision: int | None
    serial: int | None
    modes: int | None
    rated_torque: float | None  # N m
    name: str
    twice: bool  # two drives answer

    def require(self, line: str, rated_torque: float) -> None:
        """Raise `InputError` for a drive that is not one for a winch, or of another motor."""
        who = f"drives.nodes.{line}.id = {self.node}"
        if self.twice:
            raise InputError(f"{who}: two drives have this number; give each its own")
        if self.profile != o.PROFILE:
            raise InputError(f"{who}: has the profile {self.profile}, not {o.PROFILE} of drives")
        for mode in Mode:
            if self.modes is None or not supports(self.modes, mode):
                raise InputError(f"{who}: the drive has no cyclic synchronous {mode.name.lower()} (0x6502)")
        found = self.rated_torque
        if found is None or abs(found - rated_torque) > _RATED * rated_torque:
            tells = "none" if found is None else f"{found:g} N m"
            why = f"but the drive of line {line} reports {tells} (0x6076): check motor, file and unit"
            raise InputError(f"drives.rated_torque = {rated_torque:g} N m: {why}")


class Asked:
    """A drive whose identity was requested."""

    def __init__(self, transfers: Transfers) -> None:
        """Ask by *transfers*, which are not carried out yet."""
        self._found = {each: transfers.add(Transfer(each)) for each in _ASKED}

    def identity(self, node: int, *, twice: bool = False) -> Identity | None:
        """Return the identity reported by the drive at *node*, or None. *twice*: whether two devices have answered."""
        profile, rated = self._number(o.DEVICE_TYPE), self._number(o.RATED_TORQUE)
        if profile is None:
            return None
        return Identity(
            node,
            profile & 0xFFFF,
            self._number(o.VENDOR),
            self._number(o.PRODUCT),
            self._number(o.REVISION),
            self._number(o.SERIAL),
            self._number(o.SUPPORTED_MODES),
            None if rated is None else 1e-3 * rated,
            self._found[o.DEVICE_NAME].text,
            twice,
        )

    def _number(self, kind: o.Object) -> int | None:
        return None if self._found[kind].failure else self._found[kind].result
