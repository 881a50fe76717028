"""Notices of a machine besides readings: conditions such as a slipping brake."""

from dataclasses import dataclass
from enum import StrEnum


class Condition(StrEnum):
    """Conditions that a machine reports with a step's readings."""

    STALLED = "a motor cannot pull its load"
    LIMITED = "the commanded speed of a winch exceeds that of its motor"
    DRUM_END = "a winch drum is empty or full"
    POWDER_OUT = "the valve is open but no powder is left"
    SILENT = "nothing came over the wireless link for longer than it should"
    NO_EQUILIBRIUM = "the plant found no equilibrium and stayed where it was"
    OFF_PLANE = "the platform is lifted off its plane, which only pushes"
    BRANCH_END = "the equilibrium of the plant ended, and the plant moved to another one nearby"
    UNCERTIFIED = "the equilibrium that the plant followed could not be certified"
    CLOCK_AHEAD = "the clock jumped ahead"
    CLOCK_BACK = "the clock jumped back; readings since then are skipped"
    OVERRUN = "a step came later than it was due"
    HUNG = "the control hung"
    DRIVE_FAULT = "a winch's drive reports a fault"
    BUS_SILENT = "a winch's drive does not answer"
    ESTOP = "the emergency-stop chain is open"
    BRAKE = "a brake is not as it was commanded"
    LOG_BEHIND = "the disk was slower than the log: steps before this one are left out of it"
    NOT_SAVED = "counts of the winches could not be saved: after a loss of power it is to be homed"


@dataclass(frozen=True)
class Notice:
    """A condition of the machine. ``subject``: name of the line or source that has it; empty: the whole machine."""

    condition: Condition
    subject: str = ""
