"""Results of the commands for drives."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Final

from cablewright.foundation.results import Figure, Result
from cablewright.foundation.signals import DriveState
from cablewright.machine.drives.identity import Identity

_IDENTITY: Final = (
    Figure("node", "1", "Number of the node."),
    Figure("line", "", "Line whose drive it is by the machine file; null: none."),
    Figure("name", "", "Name that the device reports (0x1008)."),
    Figure("profile", "1", "Its profile (0x1000); of drives it is 402."),
    Figure("serial", "1", "Its serial number (0x1018)."),
    Figure("rated_torque", "N m", "Rated torque of its motor (0x6076)."),
    Figure("twice", "", "Whether two devices answer at that number."),
)


@dataclass(frozen=True)
class Found:
    """A drive that answered the scan of the bus, and the line that the machine file assigns to it."""

    identity: Identity
    line: str | None

    def row(self) -> dict[str, object]:
        """Return the drive as a row of the table."""
        own = self.identity
        return {
            "node": own.node,
            "line": self.line,
            "name": own.name,
            "profile": own.profile,
            "serial": own.serial,
            "rated_torque": own.rated_torque,
            "twice": own.twice,
        }


@dataclass(frozen=True, eq=False, repr=False)
class BusScan(Result):
    """Result of a scan: devices that answer on a bus."""

    FIGURES: ClassVar = (
        Figure("machine", "", "Name of the machine."),
        Figure("missing", "", "Lines whose drive does not answer."),
        Figure("nodes", "", "Nodes that answer.", lambda of: [each.row() for each in of.found], parts=_IDENTITY),
    )

    machine: str
    found: tuple[Found, ...]
    missing: tuple[str, ...]

    @property
    def refusal(self) -> str:
        """Sentence on the missing drives; empty if there are none."""
        return f"no drive answers for {', '.join(self.missing)}" if self.missing else ""


@dataclass(frozen=True)
class Value:
    """One parameter (object) of one drive, with its present and its required value."""

    line: str
    object: str
    wanted: int
    value: int | None
    agrees: bool


@dataclass(frozen=True, eq=False, repr=False)
class DriveValues(Result):
    """Objects of all drives, with present and required values."""

    FIGURES: ClassVar = (
        Figure("machine", "", "Name of the machine."),
        Figure("different", "1", "Number of objects that are not as they should be; `enable` writes them."),
        Figure("values", "", "Objects of each drive.", parts=(
            Figure("line", "", "Name of the line."),
            Figure("object", "", "Index and name of the object."),
            Figure("value", "1", "Its value, in units of the drive; null: the drive has no such object."),
            Figure("wanted", "1", "Its value as it should be."),
            Figure("agrees", "", "Whether both are the same where it counts, or the drive may lack it."),
        )),
    )  # fmt: skip

    machine: str
    values: tuple[Value, ...]

    @property
    def different(self) -> int:
        """Number of objects whose value is not the required one."""
        return sum(not each.agrees for each in self.values)


@dataclass(frozen=True)
class DriveLine:
    """State of a drive at the end of a session."""

    line: str
    state: DriveState
    tension: float = math.nan
    fault: str = ""


@dataclass(frozen=True, eq=False, repr=False)
class DriveSession(Result):
    """Result of a session with drives, which has ended with brakes closed."""

    FIGURES: ClassVar = (
        Figure("machine", "", "Name of the machine."),
        Figure("action", "", "What was asked: write, enable, release, jog, tension or home."),
        Figure("status", "", "`done` or `refused`."),
        Figure("reason", "", "Why it was not done; empty where it was.", detail=True),
        Figure("position", "m", "Measured position of the platform; null without a measurement.",
               only=lambda of: of.position is not None),
        Figure("rotation", "rad", "Rotation vector of a rigid platform there.", only=lambda of: of.rotation is not None,
               shown="deg"),
        Figure("misfit", "m", "By how much the lengths do not fit together.", only=lambda of: of.position is not None),
        Figure("notes", "", "What else was found, and what no test could see.", detail=True),
        Figure("duration", "s", "Duration, by the machine's clock."),
        Figure("bus", "", "Cycles, frames sent and received, answers missed, frames malformed, errors, cycles over "
               "half a period late, share of the bus that is used.", detail=True),
        Figure("drives", "", "Drives as they were last under torque, or at the end.", parts=(
            Figure("line", "", "Name of the line."),
            Figure("state", "", "State of its drive."),
            Figure("tension", "N", "Tension by its torque."),
            Figure("fault", "", "Text of its fault; empty: none."),
        )),
    )  # fmt: skip
    HEADLINES: ClassVar = ("machine", "action", "status")

    machine: str
    action: str
    reason: str
    drives: tuple[DriveLine, ...]
    bus: dict[str, float | int]
    duration: float = 0.0
    position: tuple[float, float, float] | None = None
    rotation: tuple[float, ...] | None = None
    misfit: float = math.nan
    notes: tuple[str, ...] = ()

    @property
    def status(self) -> str:
        """Status of the action on the drives: ``done`` or ``refused``."""
        return "refused" if self.reason else "done"

    @property
    def refusal(self) -> str:
        """Reason why the action on the drives was not done."""
        return self.reason
