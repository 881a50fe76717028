"""Statuses of solves, and the exceptions of cablewright: one line for people, an exit code for programs."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable
from enum import Enum
from numbers import Real
from typing import Any, ClassVar, Final, Self

MAX_MESSAGE: Final = 2000
"""Characters of the longest message."""


class Status(Enum):
    """The outcome of a solve, as a sentence. The order is that of the kernels' codes."""

    OK = "solved"
    NOT_CONVERGED = "the solver did not converge"
    SINGULAR = "the equations are singular here: the platform can move without any line resisting"
    NOT_FINITE = "a number is not finite"
    UNDER_EXIT = "the platform point is in an eyelet, or on the axis of a sheave: the line has no plane there"
    INSIDE_SHEAVE = "the platform point is inside a sheave"
    BAD_WRAP = "a line does not wrap its sheave: its angle of contact is negative or over a full turn"
    INFEASIBLE = "no tensions within the limits balance the load"
    OVERSTRETCHED = "a line is over its breaking load"
    LEVER_UNSTABLE = "a lever stands on its head: an equilibrium, but an unstable one"
    UNSTABLE = "the platform would leave this pose: an equilibrium, but an unstable one"
    JUMPED = "the equilibrium that was followed ends or jumps between these lengths and the last"
    FOLD = "the equilibrium that is followed is about to vanish: its stiffness is all but singular"
    UNCERTIFIED = "the equilibrium was found, but that it is the only one there could not be proved"
    OUT_OF_LIMITS = "the pose balances, but is outside the machine's limits"  # not a code of kernels

    @classmethod
    def of(cls, code: int) -> Self:
        """Return the status of a kernel's code."""
        return list(cls)[code]

    @property
    def word(self) -> str:
        """The status as commands print it: ``not-converged``."""
        return self.name.lower().replace("_", "-")


class CablewrightError(Exception):
    """Base of all exceptions of cablewright. The message is one line."""

    exit_code: ClassVar[int] = 1

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


def one_line(message: str) -> str:
    """Return a message as one line of at most `MAX_MESSAGE` characters, without control characters.

    Names and keys from strangers' files are in messages, and a terminal would obey control characters in them. A longer
    one loses its middle.
    """
    line = printable(" ".join(message.split()))
    return line if len(line) <= MAX_MESSAGE else f"{line[: MAX_MESSAGE // 2]} ... {line[10 - MAX_MESSAGE // 2 :]}"


def printable(text: str) -> str:
    """Return *text* with each character that no terminal shows, line ends too, as its escape."""
    if text.isprintable():
        return text
    return "".join(each if each.isprintable() else ascii(each)[1:-1] for each in text)


class AnswerError(CablewrightError):
    """The computation ran and its answer is no: infeasible, overstretched, not converged.

    `status`: that of the solve. ``known``: values that JSON has besides the reason.
    """

    def __init__(self, message: str, status: Status | None = None) -> None:
        self.status = status
        self.known: dict[str, object] = {}
        super().__init__(message)


class InputError(CablewrightError):
    """Error: invalid input, such as a file, a key, a value, an option."""

    exit_code: ClassVar[int] = 2


class EnvironmentFault(CablewrightError):
    """An error of the environment: a full disk, a folder that cannot be written."""

    exit_code: ClassVar[int] = 3


class UnknownName(InputError):
    """Error: a name outside a known set, ``UnknownName("robot", "paty", library_names())``."""

    def __init__(self, kind: str, name: str, valid: Iterable[str]) -> None:
        self.kind = kind
        self.name = name
        self.valid = tuple(valid)
        super().__init__(f"unknown {kind} {name!r}; {suggestion(name, self.valid)}")


def require_positive(**values: float) -> None:
    """Raise `InputError` unless all *values* are numbers, finite and more than 0."""
    for name, value in dict[str, Any](values).items():
        if not isinstance(value, Real):
            raise InputError(f"{name} = {value!r:.60}: a number in SI units is expected")
        if not 0.0 < float(value) < math.inf:
            raise InputError(f"{name} = {value:g}: must be a finite number over 0")


def suggestion(name: str, valid: Iterable[str], limit: int = 12) -> str:
    """Return a hint with the valid names nearest to ``name``, or the first ``limit`` where none is near."""
    names = sorted(valid)
    near = difflib.get_close_matches(name, names, n=3, cutoff=0.6)
    if near:
        return "did you mean " + " or ".join(repr(n) for n in near) + "?"
    if not names:
        return "there are none"
    more = f" and {len(names) - limit} more" if len(names) > limit else ""
    return "allowed: " + ", ".join(names[:limit]) + more
